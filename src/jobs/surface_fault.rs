//! Why the surface of a part is not worked with.

use thiserror::Error;

use crate::surface::{MeshFault, StlFault};

/// Why an uploaded surface is not used.
#[derive(Debug, Error)]
pub enum PartSurfaceFault {
    /// It needs more memory than surfaces may have.
    #[error(
        "a surface of {facets} facets needs an estimated {estimated_bytes} bytes of memory, but the limit is {limit_bytes}; upload fewer facets, or raise max_surface_memory_bytes"
    )]
    TooLarge {
        /// Number of facets that the file states, or has room for.
        facets: u64,
        /// Memory for reading them.
        estimated_bytes: u64,
        /// What there is.
        limit_bytes: u64,
    },
    /// Other surfaces leave too little memory at present.
    #[error(
        "other surfaces in use leave less than the {estimated_bytes} bytes of memory that this surface needs; retry later"
    )]
    NoRoom {
        /// Memory for reading it.
        estimated_bytes: u64,
    },
    /// It is no surface.
    #[error(transparent)]
    Mesh(MeshFault),
}

impl PartSurfaceFault {
    /// Whether the only fault is its size.
    #[must_use]
    pub fn is_too_large(&self) -> bool {
        matches!(self, Self::TooLarge { .. } | Self::Mesh(MeshFault::Stl(StlFault::TooManyFacets { .. })))
    }
}
