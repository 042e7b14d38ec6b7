//! The part's surface from an uploaded file.

use std::io::{self, Read};
use std::ops::ControlFlow;
use std::sync::Arc;

use super::{CompensatorFault, InputFile, JobFault, PartSurfaceFault};
use crate::contact::PartSurface;
use crate::process::ProgramSource;
use crate::surface::{Mesh, MeshFault, MeshSettings, STL_HEADER_BYTES, stl_facets_at_most};
use crate::wire::SurfaceReading;

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
) -> Result<Option<PartSurface>, JobFault> {
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
) -> Result<Mesh, JobFault> {
    let open = || Ok((surface.open()?, facets_of(surface)?));
    let (file, max_facets) = open().map_err(CompensatorFault::Io)?;
    let settings = MeshSettings { max_facets, ..*settings };
    Mesh::read_stl(file, &settings, stop).map_err(|fault| match fault {
        MeshFault::Cancelled => CompensatorFault::Cancelled.into(),
        fault => PartSurfaceFault::Mesh(fault).into(),
    })
}
