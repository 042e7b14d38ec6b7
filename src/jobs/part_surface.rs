//! The part's surface from an uploaded file, within the memory that surfaces may take.

use std::io::{self, Read};
use std::ops::ControlFlow;
use std::sync::Arc;

use thiserror::Error;

use super::{CompensatorFault, InputFile};
use crate::contact::PartSurface;
use crate::process::ProgramSource;
use crate::surface::{Mesh, MeshFault, MeshSettings, STL_HEADER_BYTES, StlFault, stl_facets_at_most};
use crate::wire::SurfaceReading;

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
        /// The limit.
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
    /// The file is not a surface.
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

/// Largest number of facets in a file, from its first bytes and its length; exact for a binary file. Further facets
/// of a text file are not read.
pub(super) fn facets_of(surface: &InputFile) -> io::Result<u64> {
    let mut start = Vec::new();
    surface.open()?.take(STL_HEADER_BYTES as u64).read_to_end(&mut start)?;
    Ok(stl_facets_at_most(&start, surface.length))
}

/// The part with the uploaded surface, if one was uploaded.
pub(super) fn part_surface(
    surface: Option<&InputFile>,
    reading: &SurfaceReading,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Option<PartSurface>, super::JobFault> {
    let read = |surface| {
        let mesh = Arc::new(read_part(surface, &reading.settings(), stop)?);
        Ok(PartSurface { mesh, contact_gap: reading.contact_gap() })
    };
    surface.map(read).transpose()
}

/// The mesh of an uploaded surface.
pub(super) fn read_part(
    surface: &InputFile,
    settings: &MeshSettings,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Mesh, super::JobFault> {
    let open = || Ok((surface.open()?, facets_of(surface)?));
    let (file, max_facets) = open().map_err(CompensatorFault::Io)?;
    let settings = MeshSettings { max_facets, ..*settings };
    Mesh::read_stl(file, &settings, stop).map_err(|fault| match fault {
        MeshFault::Cancelled => CompensatorFault::Cancelled.into(),
        fault => PartSurfaceFault::Mesh(fault).into(),
    })
}
