//! The solid of a cutter, as the signed distance from it.

use thiserror::Error;

use crate::geometry::Vec3;
use crate::kinematics::ToolPose;
use crate::machine::Tool;
use crate::units::Length;

/// The solid of a cutter (R, r): flat end of radius R − r, round corner r, cylindrical flank R up to the cutting
/// length ℓ above the tip, closed there by a flat top. Parts above it (shank, holder) do not belong to it.
///
/// It is convex. Its signed distance (negative inside) is therefore a convex function of the point, and never
/// changes by more than the point moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterBody {
    tool: Tool,
    // the numbers of the tool that the innermost loop of virtual cutting needs
    radius_mm: f64,
    corner_mm: f64,
    core_mm: f64,
    length_mm: f64,
}

/// Why a cutter has no valid body.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum CutterBodyFault {
    /// The flank does not reach above the corner, or its length is not plausible.
    #[error(
        "cutting length {cutting_length_mm:e} mm is not between the corner radius {corner_radius_mm} mm and {max_mm} mm"
    )]
    CuttingLength {
        /// The length asked for \[mm\].
        cutting_length_mm: f64,
        /// Corner radius r \[mm\].
        corner_radius_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
}

/// Signed distance and its derivatives in the half plane through the tool axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProfileDistance {
    /// Signed distance, negative inside \[mm\].
    pub(crate) distance_mm: f64,
    /// Derivative by the distance from the axis.
    pub(crate) radial: f64,
    /// Derivative by the height above the tip.
    pub(crate) axial: f64,
}

impl CutterBody {
    /// The largest cutting length accepted \[mm\].
    pub const MAX_CUTTING_LENGTH_MM: f64 = 4000.0;
    /// Default cutting length, in cutter radii.
    pub const DEFAULT_LENGTH_IN_RADII: f64 = 4.0;

    /// The body of `tool` with a flank up to `cutting_length` above the tip.
    ///
    /// # Errors
    /// A length not in (r, 4000] mm, or not positive.
    pub fn new(tool: &Tool, cutting_length: Length) -> Result<Self, CutterBodyFault> {
        let (length_mm, corner_mm) = (cutting_length.mm(), tool.corner_radius().mm());
        // NaN is in no range.
        if !(length_mm > corner_mm && length_mm > 0.0 && length_mm <= Self::MAX_CUTTING_LENGTH_MM) {
            return Err(CutterBodyFault::CuttingLength {
                cutting_length_mm: length_mm,
                corner_radius_mm: corner_mm,
                max_mm: Self::MAX_CUTTING_LENGTH_MM,
            });
        }
        Ok(Self::of_length(tool, length_mm))
    }

    /// The body of `tool` with the default flank of four radii.
    #[must_use]
    pub fn with_default_length(tool: &Tool) -> Self {
        Self::of_length(tool, Self::DEFAULT_LENGTH_IN_RADII * tool.radius().mm())
    }

    fn of_length(tool: &Tool, length_mm: f64) -> Self {
        Self {
            tool: *tool,
            radius_mm: tool.radius().mm(),
            corner_mm: tool.corner_radius().mm(),
            core_mm: tool.core_radius().mm(),
            length_mm,
        }
    }

    /// The cutter of this body.
    #[must_use]
    pub fn tool(&self) -> &Tool {
        &self.tool
    }

    /// Cutter radius R \[mm\].
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Corner radius r \[mm\].
    #[must_use]
    pub fn corner_radius_mm(&self) -> f64 {
        self.corner_mm
    }

    /// R − r \[mm\].
    #[must_use]
    pub fn core_radius_mm(&self) -> f64 {
        self.core_mm
    }

    /// Height of the body above the tip \[mm\].
    #[must_use]
    pub fn cutting_length_mm(&self) -> f64 {
        self.length_mm
    }

    /// Signed distance \[mm\] of `point_mm` in W from the body at `pose`: positive outside, negative inside.
    #[must_use]
    pub fn distance_mm(&self, pose: &ToolPose, point_mm: Vec3) -> f64 {
        let (_, radial_mm, axial_mm) = place(pose, point_mm);
        self.profile(radial_mm, axial_mm).distance_mm
    }

    /// Signed distance \[mm\] and its gradient, a unit vector in W away from the body. On the axis and on edges,
    /// which have many gradients, one of them.
    #[must_use]
    pub fn distance_and_gradient(&self, pose: &ToolPose, point_mm: Vec3) -> (f64, Vec3) {
        let (across, radial_mm, axial_mm) = place(pose, point_mm);
        let profile = self.profile(radial_mm, axial_mm);
        let outward = across.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(|| any_across(pose.axis));
        (profile.distance_mm, outward * profile.radial + pose.axis * profile.axial)
    }

    /// Signed distance at `radial_mm` ≥ 0 from the axis and `axial_mm` above the tip.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a few operations in the innermost loop of virtual cutting")]
    pub(crate) fn profile(&self, radial_mm: f64, axial_mm: f64) -> ProfileDistance {
        let top = axial_mm - self.length_mm;
        let outside_core = radial_mm - self.core_mm;
        let below_centre = axial_mm - self.corner_mm;
        if outside_core > 0.0 && below_centre < 0.0 {
            let from_centre = (outside_core * outside_core + below_centre * below_centre).sqrt();
            let distance_mm = from_centre - self.corner_mm;
            if top > distance_mm {
                return ProfileDistance { distance_mm: top, radial: 0.0, axial: 1.0 };
            }
            let scale = 1.0 / from_centre;
            return ProfileDistance {
                distance_mm,
                radial: outside_core * scale,
                axial: below_centre * scale,
            };
        }
        let side = radial_mm - self.radius_mm;
        if side > 0.0 && top > 0.0 {
            let distance_mm = (side * side + top * top).sqrt();
            return ProfileDistance { distance_mm, radial: side / distance_mm, axial: top / distance_mm };
        }
        let end = -axial_mm;
        if side >= end && side >= top {
            ProfileDistance { distance_mm: side, radial: 1.0, axial: 0.0 }
        } else if end >= top {
            ProfileDistance { distance_mm: end, radial: 0.0, axial: -1.0 }
        } else {
            ProfileDistance { distance_mm: top, radial: 0.0, axial: 1.0 }
        }
    }
}

/// The part of `point − tip` across the axis, its length, and the part along the axis.
fn place(pose: &ToolPose, point_mm: Vec3) -> (Vec3, f64, f64) {
    let from_tip = point_mm - pose.tip_mm;
    let axial_mm = from_tip.dot(&pose.axis);
    let across = from_tip - pose.axis * axial_mm;
    (across, across.norm(), axial_mm)
}

/// A unit vector across `axis`, always the same one for the same axis.
fn any_across(axis: Vec3) -> Vec3 {
    let least = if axis.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    (least - axis * least.dot(&axis)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of a few operations on lengths of ten to twenty millimetres \[mm\].
    const ROUNDING_MM: f64 = 1e-13;

    fn body(radius_mm: f64, corner_mm: f64, length_mm: f64) -> CutterBody {
        let tool = Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)).unwrap();
        CutterBody::new(&tool, Length::from_mm(length_mm)).unwrap()
    }

    fn upright() -> ToolPose {
        ToolPose { tip_mm: Vec3::new(1.0, 2.0, 3.0), axis: Vec3::z() }
    }

    #[track_caller]
    fn assert_distance(body: &CutterBody, from_tip: [f64; 3], expected_mm: f64) {
        let distance_mm = body.distance_mm(&upright(), upright().tip_mm + Vec3::from(from_tip));
        assert!((distance_mm - expected_mm).abs() < ROUNDING_MM, "{from_tip:?}: {distance_mm} {expected_mm}");
    }

    #[test]
    fn a_ball_is_a_sphere_below_its_centre_and_a_cylinder_above() {
        let ball = body(5.0, 5.0, 20.0);
        assert_distance(&ball, [0.0, 0.0, -1.0], 1.0);
        assert_distance(&ball, [0.0, 0.0, 1.0], -1.0);
        assert_distance(&ball, [6.0, 0.0, -3.0], 5.0);
        assert_distance(&ball, [0.0, 7.0, 12.0], 2.0);
        assert_distance(&ball, [3.0, 0.0, 1.0], 0.0);
        assert_distance(&ball, [0.0, 0.0, 19.0], -1.0);
        assert_distance(&ball, [8.0, 0.0, 24.0], 5.0);
        assert_distance(&ball, [0.0, 0.0, 22.0], 2.0);
    }

    #[test]
    fn bull_nose_and_flat_have_a_flat_end() {
        let bull = body(5.0, 1.0, 20.0);
        assert_distance(&bull, [2.0, 0.0, -0.5], 0.5);
        assert_distance(&bull, [2.0, 0.0, 0.25], -0.25);
        assert_distance(&bull, [7.0, 0.0, -3.0], 4.0);
        assert_distance(&bull, [0.0, 5.5, 1.0], 0.5);
        let flat = body(5.0, 0.0, 20.0);
        assert_distance(&flat, [8.0, 0.0, -4.0], 5.0);
        assert_distance(&flat, [4.5, 0.0, 2.0], -0.5);
        assert_distance(&flat, [4.5, 0.0, -2.0], 2.0);
    }

    #[test]
    fn distance_is_convex_keeps_its_slope_and_its_gradient_is_its_derivative() {
        /// Central difference over this step \[mm\].
        const STEP_MM: f64 = 1e-6;
        /// The error of the central difference. Points on both sides of a fold are left out.
        const DERIVATIVE: f64 = 1e-5;
        let pose = ToolPose { tip_mm: Vec3::new(0.3, -0.2, 0.1), axis: Vec3::new(0.36, -0.48, 0.8) };
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut smooth = 0;
        for body in [body(5.0, 5.0, 12.0), body(5.0, 1.5, 7.0), body(5.0, 0.0, 7.0), body(5.0, 5.0, 5.1)] {
            for _ in 0..5000 {
                let mut point = || Vec3::from_fn(|_, _| 30.0 * random() - 15.0);
                let (p, q) = (point(), point());
                let ((d, gradient), other) =
                    (body.distance_and_gradient(&pose, p), body.distance_mm(&pose, q));
                let middle = body.distance_mm(&pose, (p + q) * 0.5);
                assert!((d - other).abs() <= (p - q).norm() + ROUNDING_MM);
                assert!(2.0 * middle <= d + other + ROUNDING_MM, "{p} {q}");
                // a convex function lies above every tangent
                assert!(other >= d + gradient.dot(&(q - p)) - ROUNDING_MM, "{p} {q}");
                assert!((gradient.norm() - 1.0).abs() < ROUNDING_MM);
                let measured = Vec3::from_fn(|k, _| {
                    let step = Vec3::ith(k, STEP_MM);
                    (body.distance_mm(&pose, p + step) - body.distance_mm(&pose, p - step)) / (2.0 * STEP_MM)
                });
                smooth += usize::from((measured - gradient).norm() < DERIVATIVE);
            }
        }
        assert!(smooth > 19_900, "{smooth}");
    }

    #[test]
    fn a_flank_must_reach_above_the_corner() {
        let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).unwrap();
        for length_mm in [5.0, 0.0, -1.0, f64::NAN, f64::INFINITY, 4001.0] {
            assert!(CutterBody::new(&tool, Length::from_mm(length_mm)).is_err(), "{length_mm}");
        }
    }
}
