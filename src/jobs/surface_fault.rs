//! Why the surface of a part is not worked with.

use thiserror::Error;

use crate::surface::{MeshFault, StlFault};

/// Why an uploaded surface is not worked with.
#[derive(Debug, Error)]
pub enum PartSurfaceFault {
    /// It would take more memory than surfaces may.
    #[error(
        "a surface of {facets} facets takes an estimated {estimated_bytes} bytes of memory, at most {limit_bytes} are allowed"
    )]
    TooLarge {
        /// Facets it states, or has room for.
        facets: u64,
        /// What reading them takes.
        estimated_bytes: u64,
        /// What there is.
        limit_bytes: u64,
    },
    /// Other surfaces leave too little memory at the moment.
    #[error(
        "the surfaces that are being worked on leave less than the {estimated_bytes} bytes of memory that this one takes"
    )]
    NoRoom {
        /// What reading it takes.
        estimated_bytes: u64,
    },
    /// It is no surface.
    #[error(transparent)]
    Mesh(MeshFault),
}

impl PartSurfaceFault {
    /// Whether it is only too large.
    #[must_use]
    pub fn is_too_large(&self) -> bool {
        matches!(self, Self::TooLarge { .. } | Self::Mesh(MeshFault::Stl(StlFault::TooManyFacets { .. })))
    }
}
