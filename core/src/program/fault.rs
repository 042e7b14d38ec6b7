//! Why reading or writing stops.

use thiserror::Error;

use super::{Address, Excerpt, ForeignDialect};

/// Why a text cannot be read as a program at all.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ReadFault {
    /// A line longer than any control takes.
    #[error("line {line} is longer than {max_bytes} bytes")]
    LineTooLong {
        /// 1-based line.
        line: u64,
        /// Longest accepted, line ending included.
        max_bytes: usize,
    },
    /// A dialect that is recognised and not read.
    #[error(
        "line {line}: the program is written for {dialect}, a dialect that is not supported; post it as ISO G-code, for Sinumerik 840D or as Heidenhain conversational"
    )]
    UnsupportedDialect {
        /// 1-based line that shows the dialect.
        line: u64,
        /// Which it is.
        dialect: ForeignDialect,
    },
    /// A CSV column of unknown name.
    #[error("line {line}, column {column}: `{name}` is not a column of a program")]
    UnknownColumn {
        /// 1-based line of the header.
        line: u64,
        /// 1-based column of the table.
        column: u32,
        /// Its name.
        name: Excerpt,
    },
    /// A CSV column that stands twice.
    #[error("line {line}, column {column}: {address} stands twice in the header")]
    RepeatedColumn {
        /// 1-based line of the header.
        line: u64,
        /// 1-based column of the table.
        column: u32,
        /// Its address.
        address: Address,
    },
    /// A CSV column that has to be there.
    #[error("line {line}: the header has no column {address}")]
    MissingColumn {
        /// 1-based line of the header.
        line: u64,
        /// The address missing.
        address: Address,
    },
    /// Not two rotary columns.
    #[error("line {line}: a five-axis program has two of the columns A B C, this header has {count}")]
    RotaryColumns {
        /// 1-based line of the header.
        line: u64,
        /// How many of A B C there are.
        count: usize,
    },
    /// Contact points and contact normals at once.
    #[error("line {line}: the header has both contact points (U V W) and contact normals (nx ny nz)")]
    TwoContacts {
        /// 1-based line of the header.
        line: u64,
    },
    /// A CSV program without a header row.
    #[error("line {line}: a CSV program starts with a header row that names X, Y and Z")]
    NoHeader {
        /// 1-based line where it should be.
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

/// Why a block cannot be written. Nothing has been appended then.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum WriteFault {
    /// Not finite, or larger than a reader would take.
    #[error("{address} {value} cannot be written; the limit is ±{max_abs:e}")]
    NotPrintable {
        /// Of the word.
        address: Address,
        /// Its value.
        value: f64,
        /// Largest magnitude written.
        max_abs: f64,
    },
    /// No such block in the batch.
    #[error("the batch has {blocks} blocks, none of index {index}")]
    NoBlock {
        /// Index asked for.
        index: usize,
        /// Number of blocks.
        blocks: usize,
    },
    /// A table has motions only: no row can hold a feed alone.
    #[error("a row of a table cannot hold a feed alone")]
    NoFeedRow,
    /// A CSV program has no column for the word, or the dialect no such word.
    #[error("the program has no column or word {address}")]
    NoColumn {
        /// Of the word.
        address: Address,
    },
}
