//! A patch of a cylinder, as a ridge or as a trough.

use super::fault::SizeCheck;
use super::{Bulge, ParametricSurface, SurfaceDerivatives, SurfaceFault, SurfaceQuantity};
use crate::geometry::{Vec3, trig};

/// A patch of a cylinder along Y that faces +Z: convex about its top line, concave about its bottom line.
///
/// u is the angle from that line \[rad\], v is Y from the centre \[mm\]:
/// `p = c + (R sin u, v, k R cos u)`, k = +1 convex, −1 concave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    centre_mm: Vec3,
    radius_mm: f64,
    half_angle_rad: f64,
    half_length_mm: f64,
    bulge: Bulge,
}

impl Cylinder {
    /// A patch ±`half_angle_rad` about the top (or bottom) line, `length_mm` long along Y about `centre_mm`.
    ///
    /// # Errors
    /// A radius or length not in [0.001, 10 000] mm, a half angle not in [0.001, π], a position farther than 100 m.
    /// All faults are reported.
    pub fn new(
        centre_mm: Vec3,
        radius_mm: f64,
        half_angle_rad: f64,
        length_mm: f64,
        bulge: Bulge,
    ) -> Result<Self, Vec<SurfaceFault>> {
        let mut check = SizeCheck::default();
        check.place(centre_mm);
        check.length(SurfaceQuantity::Radius, radius_mm);
        check.length(SurfaceQuantity::Length, length_mm);
        check.angle(SurfaceQuantity::HalfAngle, half_angle_rad, [1e-3, std::f64::consts::PI]);
        check.finish(Self { centre_mm, radius_mm, half_angle_rad, half_length_mm: 0.5 * length_mm, bulge })
    }
}

impl ParametricSurface for Cylinder {
    fn domain(&self) -> [[f64; 2]; 2] {
        let (angle, length) = (self.half_angle_rad, self.half_length_mm);
        [[-angle, angle], [-length, length]]
    }

    fn derivatives(&self, [u, v]: [f64; 2]) -> SurfaceDerivatives {
        let (r, k) = (self.radius_mm, self.bulge.sign());
        let (sin, cos) = trig::sin_cos(u);
        SurfaceDerivatives {
            point_mm: self.centre_mm + Vec3::new(r * sin, v, k * r * cos),
            by_u: Vec3::new(cos, 0.0, -k * sin) * r,
            by_v: Vec3::y(),
            by_uu: Vec3::new(-sin, 0.0, -k * cos) * r,
            by_uv: Vec3::zeros(),
            by_vv: Vec3::zeros(),
        }
    }
}
