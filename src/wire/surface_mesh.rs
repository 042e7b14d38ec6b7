//! What was found in the file of an uploaded surface.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Fixed;
use crate::surface::MeshReport;

/// What was found in the file of an uploaded surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceMesh)]
pub struct SurfaceMeshDoc {
    /// Facets of the file.
    pub facets: u64,
    /// Facets with an area.
    pub triangles: u64,
    /// Different corners.
    pub vertices: u64,
    /// Facets dropped because they are too thin to have a normal.
    pub degenerate_facets: u64,
    /// Facets whose stated normal points against their winding; the winding counts.
    pub contradicting_normals: u64,
    /// Edges of one facet only: the rim of an open surface, or a gap.
    pub open_edges: u64,
    /// Edges of more than two facets.
    pub non_manifold_edges: u64,
    /// Edges across which the surface is not smooth within the chordal tolerance.
    pub sharp_edges: u64,
    /// Volume enclosed; null of an open surface.
    pub volume_mm3: Option<f64>,
    /// Least coordinates.
    pub least_mm: Fixed<3>,
    /// Largest coordinates.
    pub largest_mm: Fixed<3>,
}

impl From<&MeshReport> for SurfaceMeshDoc {
    fn from(core: &MeshReport) -> Self {
        Self {
            facets: core.facets,
            triangles: core.triangles,
            vertices: core.vertices,
            degenerate_facets: core.degenerate_facets,
            contradicting_normals: core.contradicting_normals,
            open_edges: core.open_edges,
            non_manifold_edges: core.non_manifold_edges,
            sharp_edges: core.sharp_edges,
            volume_mm3: core.volume_mm3,
            least_mm: Fixed(core.least_mm.into()),
            largest_mm: Fixed(core.largest_mm.into()),
        }
    }
}
