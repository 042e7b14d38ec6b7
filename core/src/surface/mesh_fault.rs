//! Why a file gives no mesh.

use std::fmt;

use thiserror::Error;

use crate::geometry::Vec3;

/// Most facets of a mesh, 2²⁴ − 1.
pub const MAX_FACETS: u32 = (1 << 24) - 1;

/// Why a file is no STL file, or not a whole one.
#[derive(Debug, Error)]
pub enum StlFault {
    /// The bytes could not be had.
    #[error("reading failed: {0}")]
    Read(#[source] std::io::Error),
    /// Neither a binary header nor a text that begins with `solid`.
    #[error("the file is neither a binary STL file nor a text that begins with solid")]
    NotStl,
    /// Shorter than a binary header.
    #[error("the file ends after {bytes} bytes, within the 84 bytes of its header")]
    TruncatedHeader {
        /// Its bytes.
        bytes: usize,
    },
    /// Fewer facets than the header says.
    #[error("the header states {stated} facets, the file ends after {facets}")]
    Truncated {
        /// Facets stated.
        stated: u32,
        /// Whole facets there.
        facets: u32,
    },
    /// More bytes than the header says.
    #[error("the header states {stated} facets, but the file goes on behind them")]
    TrailingBytes {
        /// Facets stated.
        stated: u32,
    },
    /// The text ends within a solid.
    #[error("the text ends in line {line}, before its endsolid")]
    TruncatedText {
        /// The last line.
        line: u64,
    },
    /// Not the word that has to stand here.
    #[error("line {line}: expected {expected}")]
    Syntax {
        /// The line.
        line: u64,
        /// What should stand there.
        expected: &'static str,
    },
    /// More facets than a mesh may have.
    #[error("{facets} facets are too many: at most {max}")]
    TooManyFacets {
        /// Facets stated, or read so far.
        facets: u64,
        /// Most accepted.
        max: u64,
    },
}

/// Why a file gives no mesh.
#[derive(Debug, Error)]
pub enum MeshFault {
    /// No whole STL file.
    #[error(transparent)]
    Stl(#[from] StlFault),
    /// A number that cannot be.
    #[error(
        "facet {facet}{}: coordinate {value_mm:e} mm is not between -{max_mm} mm and {max_mm} mm",
        in_line(*line)
    )]
    Coordinate {
        /// Which facet, the first is 1.
        facet: u64,
        /// Its line, in a text.
        line: Option<u64>,
        /// The coordinate \[mm\].
        value_mm: f64,
        /// The largest accepted \[mm\].
        max_mm: f64,
    },
    /// Nothing is left.
    #[error("there is no facet that has an area; {degenerate} have none")]
    NoFacets {
        /// Facets without an area.
        degenerate: u64,
    },
    /// Neighbouring facets that disagree about which side is out.
    #[error(
        "{edges} edges join facets of contrary sense, the first from ({:.3}, {:.3}, {:.3}) to ({:.3}, {:.3}, {:.3}) mm",
        from_mm.x, from_mm.y, from_mm.z, to_mm.x, to_mm.y, to_mm.z
    )]
    ContraryEdges {
        /// How many edges.
        edges: u64,
        /// The first one's ends \[mm\].
        from_mm: Vec3,
        /// … to here \[mm\].
        to_mm: Vec3,
    },
    /// A closed surface whose facets all face inward.
    #[error("the surface is closed and faces inward: it encloses {volume_mm3} mm³")]
    InsideOut {
        /// The volume, negative \[mm³\].
        volume_mm3: f64,
    },
    /// A parameter out of range.
    #[error("{parameter} of {value_mm:e} mm is not between {min_mm:e} mm and {max_mm:e} mm")]
    Parameter {
        /// Which one.
        parameter: MeshParameter,
        /// Its value \[mm\].
        value_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// Nobody waits for it any more.
    #[error("cancelled")]
    Cancelled,
}

fn in_line(line: Option<u64>) -> String {
    line.map_or_else(String::new, |line| format!(", which ends in line {line}"))
}

/// A parameter of the reading of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshParameter {
    /// Millimetres in a unit of the file.
    Unit,
    /// How far facets may be from the surface they stand for.
    ChordalTolerance,
}

impl fmt::Display for MeshParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unit => "a unit of the file",
            Self::ChordalTolerance => "a chordal tolerance",
        })
    }
}
