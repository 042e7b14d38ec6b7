//! Why a file does not give a mesh.

use std::fmt;

use thiserror::Error;

use crate::geometry::Vec3;

/// Most facets of a mesh, 2²⁴ − 1.
pub const MAX_FACETS: u32 = (1 << 24) - 1;

/// Why a file is not an STL file, or is not complete.
#[derive(Debug, Error)]
pub enum StlFault {
    /// The bytes cannot be read.
    #[error("the file cannot be read: {0}")]
    Read(#[source] std::io::Error),
    /// Neither a binary header nor a text that begins with `solid`.
    #[error("the file is neither a binary STL file nor a text that begins with solid; save the part as STL")]
    NotStl,
    /// Shorter than a binary header.
    #[error(
        "the file ends after {bytes} bytes, before the end of its 84-byte header; send the complete file"
    )]
    TruncatedHeader {
        /// Length of the file.
        bytes: usize,
    },
    /// Fewer facets than the header states.
    #[error("the header states {stated} facets, but the file ends after {facets}; send the complete file")]
    Truncated {
        /// Facets stated.
        stated: u32,
        /// Complete facets in the file.
        facets: u32,
    },
    /// More bytes than the header states.
    #[error(
        "the header states {stated} facets, but the file continues after them; save the part as STL again"
    )]
    TrailingBytes {
        /// Facets stated.
        stated: u32,
    },
    /// The text ends within a solid.
    #[error("the text ends in line {line}, before its endsolid; send the complete file")]
    TruncatedText {
        /// The last line.
        line: u64,
    },
    /// Another word than the one expected here.
    #[error("line {line}: expected {expected}")]
    Syntax {
        /// The line.
        line: u64,
        /// The expected word.
        expected: &'static str,
    },
    /// More facets than a mesh can have.
    #[error("{facets} facets are too many; the limit is {max}. Save the part with a coarser tolerance")]
    TooManyFacets {
        /// Facets stated, or read so far.
        facets: u64,
        /// Largest number accepted.
        max: u64,
    },
}

/// Why a file does not give a mesh.
#[derive(Debug, Error)]
pub enum MeshFault {
    /// Not a complete STL file.
    #[error(transparent)]
    Stl(#[from] StlFault),
    /// A coordinate that is not plausible.
    #[error(
        "facet {facet}{}: coordinate {value_mm:e} mm is not between -{max_mm} mm and {max_mm} mm",
        in_line(*line)
    )]
    Coordinate {
        /// The facet; the first is 1.
        facet: u64,
        /// Its line, in a text.
        line: Option<u64>,
        /// The coordinate \[mm\].
        value_mm: f64,
        /// The largest accepted \[mm\].
        max_mm: f64,
    },
    /// No facet is left.
    #[error("no facet has an area; {degenerate} facets are degenerate; save the part again")]
    NoFacets {
        /// Facets without an area.
        degenerate: u64,
    },
    /// Neighbouring facets disagree about the outside.
    #[error(
        "{edges} edges join facets of opposite orientation, the first from ({:.3}, {:.3}, {:.3}) to ({:.3}, {:.3}, {:.3}) mm; repair the orientation of the facets in the CAD system",
        from_mm.x, from_mm.y, from_mm.z, to_mm.x, to_mm.y, to_mm.z
    )]
    ContraryEdges {
        /// Number of edges.
        edges: u64,
        /// Start of the first edge \[mm\].
        from_mm: Vec3,
        /// Its end \[mm\].
        to_mm: Vec3,
    },
    /// A closed surface whose facets all face inward.
    #[error("the surface is closed and faces inward: it encloses {volume_mm3} mm³. Reverse the facets")]
    InsideOut {
        /// The volume, negative \[mm³\].
        volume_mm3: f64,
    },
    /// A parameter out of range.
    #[error("{parameter} of {value_mm:e} mm is not between {min_mm:e} mm and {max_mm:e} mm")]
    Parameter {
        /// The parameter.
        parameter: MeshParameter,
        /// Its value \[mm\].
        value_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// The caller no longer waits.
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
    /// Largest distance between the facets and the true surface.
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
