//! A twisted blade with rounded edges.

use super::blade_profile::{BladeProfile, quarter};
use super::fault::SizeCheck;
use super::{ParametricSurface, SurfaceDerivatives, SurfaceFault, SurfaceQuantity};
use crate::geometry::{Vec3, trig};

/// The sizes of a [`Blade`]. The default is a small turbine blade: 40 mm by 60 mm, 3.8 mm thick, edges of 0.65 mm
/// and 0.35 mm, 40° of camber, 25° of twist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeSizes {
    /// Length of the camber line between the centres of both edges \[mm\].
    pub camber_length_mm: f64,
    /// Turn of the camber line, an arc, from the leading to the trailing edge \[rad\].
    pub camber_rad: f64,
    /// Largest thickness \[mm\].
    pub thickness_mm: f64,
    /// Radius of the leading edge \[mm\].
    pub leading_radius_mm: f64,
    /// Radius of the trailing edge \[mm\].
    pub trailing_radius_mm: f64,
    /// Height along the span \[mm\].
    pub span_mm: f64,
    /// Turn of the profile at the tip against that at the root \[rad\].
    pub twist_rad: f64,
}

impl Default for BladeSizes {
    fn default() -> Self {
        Self {
            camber_length_mm: 40.0,
            camber_rad: 40.0_f64.to_radians(),
            thickness_mm: 3.8,
            leading_radius_mm: 0.65,
            trailing_radius_mm: 0.35,
            span_mm: 60.0,
            twist_rad: 25.0_f64.to_radians(),
        }
    }
}

/// A blade on the root plane along +Z: one closed profile, turned evenly over the span about the middle of its
/// camber line.
///
/// u runs once around the profile in [0, 1], counter-clockwise as seen from +Z: the convex side on the camber
/// line's left, the leading edge, the other side, the trailing edge. v is the height over the root \[mm\]. The
/// profile is the envelope of circles along the camber line, closed by circles at the edges. Its normals are
/// continuous all around. Its curvature is continuous except at the four points where the edges begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blade {
    root_mm: Vec3,
    sizes: BladeSizes,
    profile: BladeProfile,
}

/// Largest growth of half the thickness along the camber line for a valid profile: 45° of wedge on each side.
const MAX_SLOPE: f64 = 0.7;
const MAX_ANGLE_RAD: f64 = std::f64::consts::FRAC_PI_2;

impl Blade {
    /// A blade on the root plane through `root_mm`, the middle of its camber line.
    ///
    /// # Errors
    /// Lengths not in [0.001, 10 000] mm, camber or twist beyond ±90°, an edge thicker than the blade, a profile
    /// steeper than 0.7, a camber line that folds the concave side. All faults are reported together, as far as they
    /// can be found.
    pub fn new(root_mm: Vec3, sizes: BladeSizes) -> Result<Self, Vec<SurfaceFault>> {
        let mut check = SizeCheck::default();
        check.place(root_mm);
        check.length(SurfaceQuantity::CamberLength, sizes.camber_length_mm);
        check.length(SurfaceQuantity::Thickness, sizes.thickness_mm);
        check.length(SurfaceQuantity::LeadingRadius, sizes.leading_radius_mm);
        check.length(SurfaceQuantity::TrailingRadius, sizes.trailing_radius_mm);
        check.length(SurfaceQuantity::Span, sizes.span_mm);
        check.angle(SurfaceQuantity::CamberAngle, sizes.camber_rad, [-MAX_ANGLE_RAD, MAX_ANGLE_RAD]);
        check.angle(SurfaceQuantity::Twist, sizes.twist_rad, [-MAX_ANGLE_RAD, MAX_ANGLE_RAD]);
        let half_mm = 0.5 * sizes.thickness_mm;
        let edges_mm = [sizes.leading_radius_mm, sizes.trailing_radius_mm];
        for (quantity, radius_mm) in
            [SurfaceQuantity::LeadingRadius, SurfaceQuantity::TrailingRadius].into_iter().zip(edges_mm)
        {
            if radius_mm > half_mm {
                check.push(SurfaceFault::EdgeTooThick { quantity, radius_mm, max_mm: half_mm });
            }
        }
        let profile = BladeProfile::new(sizes.camber_length_mm, sizes.camber_rad, half_mm, edges_mm);
        if check.is_clean() {
            let slope = profile.steepest();
            if slope > MAX_SLOPE {
                check.push(SurfaceFault::TooSteep { slope, max_slope: MAX_SLOPE });
            }
            // The distance over the hollow side is at least √(1 − ρ′²) − ρ κ.
            let camber_radius_mm = sizes.camber_length_mm / sizes.camber_rad.abs();
            let min_mm = half_mm / (1.0 - slope * slope).max(0.0).sqrt();
            if slope <= MAX_SLOPE && camber_radius_mm <= min_mm {
                check.push(SurfaceFault::CamberTooTight { camber_radius_mm, min_mm });
            }
        }
        check.finish(Self { root_mm, sizes, profile })
    }

    /// The sizes.
    #[must_use]
    pub fn sizes(&self) -> &BladeSizes {
        &self.sizes
    }
}

impl ParametricSurface for Blade {
    fn domain(&self) -> [[f64; 2]; 2] {
        [[0.0, 1.0], [0.0, self.sizes.span_mm]]
    }

    fn derivatives(&self, [u, v]: [f64; 2]) -> SurfaceDerivatives {
        let profile = self.profile.at(u);
        let rate = self.sizes.twist_rad / self.sizes.span_mm;
        let (sin, cos) = trig::sin_cos(rate * v);
        let turned = |p: Vec3| Vec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z);
        let (point, by_u) = (turned(profile.point_mm), turned(profile.by_u));
        SurfaceDerivatives {
            point_mm: self.root_mm + point + Vec3::new(0.0, 0.0, v),
            by_u,
            by_v: quarter(point) * rate + Vec3::z(),
            by_uu: turned(profile.by_uu),
            by_uv: quarter(by_u) * rate,
            by_vv: point * (-rate * rate),
        }
    }
}

#[cfg(test)]
mod tests;
