//! A flat rectangle.

use super::fault::SizeCheck;
use super::{ParametricSurface, SurfaceDerivatives, SurfaceFault, SurfaceQuantity};
use crate::geometry::Vec3;

/// A rectangle about its centre, along X and Y of W, with the normal +Z. u and v are X and Y from the centre
/// \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    centre_mm: Vec3,
    half_mm: [f64; 2],
}

impl Plane {
    /// A rectangle of `length_mm` along X by `width_mm` along Y.
    ///
    /// # Errors
    /// Every size that is not in [0.001, 10 000] mm, a position farther than 100 m.
    pub fn new(centre_mm: Vec3, length_mm: f64, width_mm: f64) -> Result<Self, Vec<SurfaceFault>> {
        let mut check = SizeCheck::default();
        check.place(centre_mm);
        check.length(SurfaceQuantity::Length, length_mm);
        check.length(SurfaceQuantity::Width, width_mm);
        check.finish(Self { centre_mm, half_mm: [0.5 * length_mm, 0.5 * width_mm] })
    }
}

impl ParametricSurface for Plane {
    fn domain(&self) -> [[f64; 2]; 2] {
        self.half_mm.map(|half| [-half, half])
    }

    fn derivatives(&self, [u, v]: [f64; 2]) -> SurfaceDerivatives {
        SurfaceDerivatives {
            point_mm: self.centre_mm + Vec3::new(u, v, 0.0),
            by_u: Vec3::x(),
            by_v: Vec3::y(),
            by_uu: Vec3::zeros(),
            by_uv: Vec3::zeros(),
            by_vv: Vec3::zeros(),
        }
    }
}
