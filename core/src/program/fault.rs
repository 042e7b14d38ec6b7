//! Why reading or writing stops.

use thiserror::Error;

use super::{Address, Excerpt, ForeignDialect};

/// Why a text cannot be read as a program at all.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ReadFault {
    /// A line longer than any control takes.
    #[error("line {line} is longer than {max_bytes} bytes; divide the line")]
    LineTooLong {
        /// 1-based line.
        line: u64,
        /// Longest accepted, line ending included.
        max_bytes: usize,
    },
    /// A dialect that the service recognises but does not read.
    #[error(
        "line {line}: the program is written for {dialect}, a dialect that is not supported; post it as ISO G-code, or for Sinumerik 840D, Heidenhain conversational or Okuma OSP"
    )]
    UnsupportedDialect {
        /// 1-based line that shows the dialect.
        line: u64,
        /// The dialect.
        dialect: ForeignDialect,
    },
    /// A CSV column with an unknown name.
    #[error(
        "line {line}, column {column}: `{name}` is not a column of a program; rename or remove the column"
    )]
    UnknownColumn {
        /// 1-based line of the header.
        line: u64,
        /// 1-based column of the table.
        column: u32,
        /// Name of the column.
        name: Excerpt,
    },
    /// The header has a CSV column twice.
    #[error("line {line}, column {column}: the header has column {address} twice; remove one of them")]
    RepeatedColumn {
        /// 1-based line of the header.
        line: u64,
        /// 1-based column of the table.
        column: u32,
        /// Address of the column.
        address: Address,
    },
    /// A required CSV column is missing.
    #[error("line {line}: the header has no column {address}; add this column")]
    MissingColumn {
        /// 1-based line of the header.
        line: u64,
        /// The missing address.
        address: Address,
    },
    /// The header does not have exactly two rotary columns.
    #[error(
        "line {line}: a five-axis program has two of the columns A, B and C, but this header has {count}"
    )]
    RotaryColumns {
        /// 1-based line of the header.
        line: u64,
        /// The number of columns A B C in the header.
        count: usize,
    },
    /// The header has both contact points and contact normals.
    #[error(
        "line {line}: the header has both contact points (U V W) and contact normals (nx ny nz); keep only one of the two"
    )]
    TwoContacts {
        /// 1-based line of the header.
        line: u64,
    },
    /// A CSV program without a header row.
    #[error("line {line}: the header row is missing; begin the CSV program with a row that names X, Y and Z")]
    NoHeader {
        /// 1-based line where the header row should be.
        line: u64,
    },
}

impl ReadFault {
    /// 1-based line of the upload.
    #[must_use]
    pub fn line(&self) -> u64 {
        match *self {
            Self::LineTooLong { line, .. }
            | Self::UnsupportedDialect { line, .. }
            | Self::UnknownColumn { line, .. }
            | Self::RepeatedColumn { line, .. }
            | Self::MissingColumn { line, .. }
            | Self::RotaryColumns { line, .. }
            | Self::TwoContacts { line }
            | Self::NoHeader { line } => line,
        }
    }
}

/// Why a block cannot be written. In this case the writer has appended nothing.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum WriteFault {
    /// The value is not finite, or it is larger than a reader would accept.
    #[error("{address} {value} cannot be written; the limit is ±{max_abs:e}")]
    NotPrintable {
        /// Address of the word.
        address: Address,
        /// Value of the word.
        value: f64,
        /// The largest magnitude that is written.
        max_abs: f64,
    },
    /// The batch has no such block.
    #[error("the batch has {blocks} blocks, but no block with index {index}")]
    NoBlock {
        /// The index asked for.
        index: usize,
        /// Number of blocks.
        blocks: usize,
    },
    /// A table has only motions, so no row can hold only a feed.
    #[error("a row of a table cannot hold only a feed")]
    NoFeedRow,
    /// The CSV program has no column for the word, or the dialect has no such word.
    #[error("the program has no column or word {address}")]
    NoColumn {
        /// Address of the word.
        address: Address,
    },
}
