//! A saddle: convex in one direction, concave in the other.

use super::fault::SizeCheck;
use super::{ParametricSurface, SurfaceDerivatives, SurfaceFault, SurfaceQuantity};
use crate::geometry::Vec3;

/// The hyperbolic paraboloid `z = −x²/(2a) + y²/(2b)` about its centre, facing +Z: at the centre convex along X with
/// radius a, concave along Y with radius b. u and v are X and Y from the centre \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_field_names, reason = "every field is a length")]
pub struct Saddle {
    centre_mm: Vec3,
    convex_radius_mm: f64,
    concave_radius_mm: f64,
    half_mm: [f64; 2],
}

impl Saddle {
    /// A saddle of `length_mm` along X (convex, radius `convex_radius_mm` at the centre) by `width_mm` along Y
    /// (concave, radius `concave_radius_mm`).
    ///
    /// # Errors
    /// Every size that is not in [0.001, 10 000] mm, a position farther than 100 m.
    pub fn new(
        centre_mm: Vec3,
        convex_radius_mm: f64,
        concave_radius_mm: f64,
        length_mm: f64,
        width_mm: f64,
    ) -> Result<Self, Vec<SurfaceFault>> {
        let mut check = SizeCheck::default();
        check.place(centre_mm);
        check.length(SurfaceQuantity::ConvexRadius, convex_radius_mm);
        check.length(SurfaceQuantity::ConcaveRadius, concave_radius_mm);
        check.length(SurfaceQuantity::Length, length_mm);
        check.length(SurfaceQuantity::Width, width_mm);
        let half_mm = [0.5 * length_mm, 0.5 * width_mm];
        check.finish(Self { centre_mm, convex_radius_mm, concave_radius_mm, half_mm })
    }
}

impl ParametricSurface for Saddle {
    fn domain(&self) -> [[f64; 2]; 2] {
        self.half_mm.map(|half| [-half, half])
    }

    fn derivatives(&self, [u, v]: [f64; 2]) -> SurfaceDerivatives {
        let (a, b) = (self.convex_radius_mm, self.concave_radius_mm);
        SurfaceDerivatives {
            point_mm: self.centre_mm + Vec3::new(u, v, 0.5 * (v * v / b - u * u / a)),
            by_u: Vec3::new(1.0, 0.0, -u / a),
            by_v: Vec3::new(0.0, 1.0, v / b),
            by_uu: Vec3::new(0.0, 0.0, -1.0 / a),
            by_uv: Vec3::zeros(),
            by_vv: Vec3::new(0.0, 0.0, 1.0 / b),
        }
    }
}
