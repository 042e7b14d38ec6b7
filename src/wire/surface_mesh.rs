//! The properties of an uploaded surface file.

use serde::{Deserialize, Serialize};

use super::{Contact, Fault, FaultList, Fixed};
use crate::contact::PartSurface;
use crate::description::ToSchema;
use crate::surface::{MeshReport, MeshSettings};
use crate::units::Length;

/// How an uploaded surface is read, and the distance within which a cutter touches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceReading {
    /// Millimetres in one unit of the file.
    pub unit_mm: Option<f64>,
    /// Largest distance of the facets from the smooth surface.
    pub chordal_tolerance_um: Option<f64>,
    /// Largest gap at which a cutter touches.
    pub contact_gap_um: Option<f64>,
}

impl SurfaceReading {
    const GAP_RANGE_UM: [f64; 2] = [1e-3, 1e4];

    /// Checks the values; `is_uploaded` says whether a surface came with the program.
    pub fn check(&self, is_uploaded: bool, faults: &mut FaultList) {
        let tolerances_um =
            MeshSettings::TOLERANCES_MM.map(|tolerance_mm| Length::from_mm(tolerance_mm).um());
        for (name, value, [min, max]) in [
            ("surface_unit_mm", self.unit_mm, MeshSettings::UNITS_MM),
            ("chordal_tolerance_um", self.chordal_tolerance_um, tolerances_um),
            ("contact_gap_um", self.contact_gap_um, Self::GAP_RANGE_UM),
        ] {
            let Some(value) = value else { continue };
            faults.check_range(|| format!("/{name}"), value, min, max);
            if !is_uploaded {
                let detail = "has an effect only with a surface in the form field surface; remove it or upload the surface";
                faults.push(|| Fault::new(format!("/{name}"), detail));
            }
        }
    }

    /// Checks the values if the surface is to say where the cutter touches.
    pub fn check_with_contact(&self, contact: Contact, is_uploaded: bool, faults: &mut FaultList) {
        self.check(is_uploaded, faults);
        let detail = match contact {
            Contact::Surface if !is_uploaded => Some("missing: a surface in the form field surface, which /v1/job-batches does not have"),
            Contact::Surface | Contact::Auto => None,
            _ => {
                is_uploaded.then_some("a surface came with the program, but this contact does not use it; remove it or set contact to surface")
            }
        };
        if let Some(detail) = detail {
            faults.push(|| Fault::new("/contact", detail));
        }
    }

    /// How the file is read.
    #[must_use]
    pub fn settings(&self) -> MeshSettings {
        let usual = MeshSettings::default();
        MeshSettings {
            mm_per_unit: self.unit_mm.unwrap_or(usual.mm_per_unit),
            chordal_tolerance_mm: self
                .chordal_tolerance_um
                .map_or(usual.chordal_tolerance_mm, |tolerance_um| Length::from_um(tolerance_um).mm()),
            ..usual
        }
    }

    /// Largest gap at which a cutter touches.
    #[must_use]
    pub fn contact_gap(&self) -> Length {
        self.contact_gap_um.map_or(PartSurface::DEFAULT_CONTACT_GAP, Length::from_um)
    }
}

/// The properties of an uploaded surface file.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceMesh)]
pub struct SurfaceMeshDoc {
    /// Number of facets in the file.
    pub facets: u64,
    /// Number of facets with an area.
    pub triangles: u64,
    /// Number of different corners.
    pub vertices: u64,
    /// Facets that were dropped because they are too thin to have a normal.
    pub degenerate_facets: u64,
    /// Facets whose stated normal contradicts their winding; the winding is used.
    pub contradicting_normals: u64,
    /// Edges of only one facet: the rim of an open surface, or a gap.
    pub open_edges: u64,
    /// Edges of more than two facets.
    pub non_manifold_edges: u64,
    /// Edges across which the surface is not smooth within the chordal tolerance.
    pub sharp_edges: u64,
    /// Enclosed volume; null for an open surface.
    pub volume_mm3: Option<f64>,
    /// Smallest coordinates.
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

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::surface::{Mesh, MeshFault};

    fn reading(unit_mm: f64, chordal_tolerance_um: f64, contact_gap_um: f64) -> SurfaceReading {
        SurfaceReading {
            unit_mm: Some(unit_mm),
            chordal_tolerance_um: Some(chordal_tolerance_um),
            contact_gap_um: Some(contact_gap_um),
        }
    }

    fn faults(reading: SurfaceReading) -> usize {
        let mut faults = FaultList::default();
        reading.check(true, &mut faults);
        faults.into_result().map_or_else(|faults| faults.len(), |()| 0)
    }

    #[test]
    fn what_the_wire_accepts_the_core_accepts() {
        for reading in [reading(1e-6, 0.001, 0.001), reading(1e6, 1e4, 1e4)] {
            assert_eq!(faults(reading), 0);
            let stop = || ControlFlow::Continue(());
            let fault = Mesh::read_stl(&b"solid x\nendsolid"[..], &reading.settings(), &stop).unwrap_err();
            assert!(matches!(fault, MeshFault::NoFacets { .. }), "{fault}");
        }
        assert_eq!(faults(reading(0.99e-6, 0.99e-3, 0.0)), 3);
        assert_eq!(faults(reading(1.01e6, 1.01e4, 1.01e4)), 3);
    }
}
