//! A patch of a sphere, as a dome or as a bowl.

use super::fault::SizeCheck;
use super::{Bulge, ParametricSurface, SurfaceDerivatives, SurfaceFault, SurfaceQuantity};
use crate::geometry::{Vec3, trig};

/// A patch of a sphere that faces +Z: convex about its top, concave about its bottom, ±`half_angle` along X and Y.
///
/// u is the longitude about the diameter along Y, v the latitude toward +Y \[rad\]; both are 0 in the middle:
/// `p = c + R (sin u cos v, sin v, k cos u cos v)`, k = +1 convex, −1 concave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    centre_mm: Vec3,
    radius_mm: f64,
    half_angle_rad: f64,
    bulge: Bulge,
}

impl Sphere {
    /// Largest half angle \[rad\] (85°): the poles are excluded.
    pub const MAX_HALF_ANGLE_RAD: f64 = 85.0 * std::f64::consts::PI / 180.0;

    /// A patch of the sphere of `radius_mm` about `centre_mm`.
    ///
    /// # Errors
    /// A radius not in [0.001, 10 000] mm, a half angle not in [0.001, 85°], a position farther than 100 m. All
    /// faults are reported.
    pub fn new(
        centre_mm: Vec3,
        radius_mm: f64,
        half_angle_rad: f64,
        bulge: Bulge,
    ) -> Result<Self, Vec<SurfaceFault>> {
        let mut check = SizeCheck::default();
        check.place(centre_mm);
        check.length(SurfaceQuantity::Radius, radius_mm);
        check.angle(SurfaceQuantity::HalfAngle, half_angle_rad, [1e-3, Self::MAX_HALF_ANGLE_RAD]);
        check.finish(Self { centre_mm, radius_mm, half_angle_rad, bulge })
    }

    /// The centre \[mm\].
    #[must_use]
    pub fn centre_mm(&self) -> Vec3 {
        self.centre_mm
    }

    /// The radius \[mm\].
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// The side on which the part lies.
    #[must_use]
    pub fn bulge(&self) -> Bulge {
        self.bulge
    }
}

impl ParametricSurface for Sphere {
    fn domain(&self) -> [[f64; 2]; 2] {
        [[-self.half_angle_rad, self.half_angle_rad]; 2]
    }

    fn derivatives(&self, [u, v]: [f64; 2]) -> SurfaceDerivatives {
        let (r, k) = (self.radius_mm, self.bulge.sign());
        let ((su, cu), (sv, cv)) = (trig::sin_cos(u), trig::sin_cos(v));
        SurfaceDerivatives {
            point_mm: self.centre_mm + Vec3::new(su * cv, sv, k * cu * cv) * r,
            by_u: Vec3::new(cu * cv, 0.0, -k * su * cv) * r,
            by_v: Vec3::new(-su * sv, cv, -k * cu * sv) * r,
            by_uu: Vec3::new(-su * cv, 0.0, -k * cu * cv) * r,
            by_uv: Vec3::new(-cu * sv, 0.0, k * su * sv) * r,
            by_vv: Vec3::new(-su * cv, -sv, -k * cu * cv) * r,
        }
    }
}
