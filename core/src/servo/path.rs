//! Commanded paths in the workpiece.

use crate::geometry::{GreatCircle, Vec3, trig};
use crate::kinematics::ToolPose;

use super::{AxisLetter, PathExtent, Run};

/// A circle made by two axes only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Circle {
    /// X and C make a circle about `(center_x, 0)` on the table C (P2 eq. (4)–(8)): `X = √(x² + y²)`,
    /// `C = atan2(y, x)`.
    XC {
        /// r \[mm\].
        radius_mm: f64,
        /// x0 \[mm\].
        center_x_mm: f64,
    },
    /// Two linear axes make a circle about the origin, from the first towards the second.
    Linear {
        /// First and second axis.
        axes: [AxisLetter; 2],
        /// r \[mm\].
        radius_mm: f64,
    },
}

impl Circle {
    /// r \[mm\].
    #[must_use]
    pub const fn radius_mm(&self) -> f64 {
        match self {
            Self::XC { radius_mm, .. } | Self::Linear { radius_mm, .. } => *radius_mm,
        }
    }

    /// The two axes.
    #[must_use]
    pub const fn axes(&self) -> [AxisLetter; 2] {
        match self {
            Self::XC { .. } => [AxisLetter::X, AxisLetter::C],
            Self::Linear { axes, .. } => *axes,
        }
    }
}

/// A path of the tool in the workpiece, through the kinematics of a machine.
#[derive(Debug, Clone, PartialEq)]
pub enum ToolPath {
    /// The bottom edge of a cone frustum, flank-milled: the tip on a circle, the tool axis along the generatrix
    /// (in the manner of ISO 10791-7).
    ConeFrustum {
        /// Centre of the bottom circle in W \[mm\].
        center_mm: Vec3,
        /// Its radius \[mm\].
        radius_mm: f64,
        /// Half the apex angle: between generatrix and cone axis \[rad\].
        half_apex_rad: f64,
        /// Tilt of the cone axis from Z, about the Y of W \[rad\].
        tilt_rad: f64,
    },
    /// The tip rests on the workpiece while the rotary axes turn from one angle to another and back (in the manner
    /// of ISO 10791-6).
    TipHold {
        /// The tip in W \[mm\].
        tip_mm: Vec3,
        /// Kinematic angles at both ends, in the profile's order \[rad\].
        rotary_rad: [[f64; 2]; 2],
    },
    /// Straight lines of the tip; the tool axis turns along great circles.
    Polyline {
        /// Its corners.
        poses: Vec<ToolPose>,
    },
}

/// A point along a path, in one of two forms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Waypoint {
    /// The tool in W; the joints follow from it.
    Pose(ToolPose),
    /// The joints' angles \[rad\], the tip in W \[mm\]; X Y Z follow from them.
    Held {
        /// Tip.
        tip_mm: Vec3,
        /// Kinematic angles in the profile's order \[rad\].
        rotary_rad: [f64; 2],
    },
}

/// A tip that moves by less than this is at rest \[mm\].
const RESTING_MM: f64 = 1e-9;

impl ToolPath {
    /// Whether it ends at its start, so that it can be run in laps.
    #[must_use]
    pub const fn is_closed(&self) -> bool {
        !matches!(self, Self::Polyline { .. })
    }

    /// The extent of a run along it.
    #[must_use]
    pub fn extent(&self, run: &Run) -> PathExtent {
        let stretches = self.stretches();
        let (count, lap) = (stretches.len(), stretches.iter().sum::<f64>());
        let laps = if self.is_closed() { run.laps.max(1) as usize } else { 1 };
        let stops_in_a_lap = if run.profile.is_some() {
            (0..count).filter(|k| self.has_corner_after(*k, run.stop_at_corners_above_rad)).count()
        } else {
            0
        };
        let stops = stops_in_a_lap.saturating_mul(laps);
        PathExtent { length: lap * laps as f64, lap: self.is_closed().then_some(lap), stops }
    }

    /// Lengths of its stretches as the feed counts them: mm of the tip, or degrees if only the axes turn.
    #[must_use]
    pub fn stretches(&self) -> Vec<f64> {
        match self {
            Self::ConeFrustum { radius_mm, .. } => vec![std::f64::consts::TAU * radius_mm],
            Self::TipHold { rotary_rad: [from, to], .. } => {
                let turn = (to[0] - from[0]).hypot(to[1] - from[1]).to_degrees();
                vec![turn, turn]
            }
            Self::Polyline { poses } => poses
                .windows(2)
                .map(|pair| {
                    let length_mm = (pair[1].tip_mm - pair[0].tip_mm).norm();
                    if length_mm > RESTING_MM {
                        return length_mm;
                    }
                    crate::geometry::angle_between(pair[0].axis, pair[1].axis).to_degrees()
                })
                .collect(),
        }
    }

    /// The tool at the fraction `u` in [0, 1] of a stretch.
    #[must_use]
    pub fn at(&self, stretch: usize, u: f64) -> Waypoint {
        match self {
            Self::ConeFrustum { center_mm, radius_mm, half_apex_rad, tilt_rad } => {
                let (sin_phi, cos_phi) = trig::sin_cos(std::f64::consts::TAU * u);
                let (sin_half, cos_half) = trig::sin_cos(*half_apex_rad);
                let (sin_tilt, cos_tilt) = trig::sin_cos(*tilt_rad);
                let tilted = |v: Vec3| {
                    Vec3::new(cos_tilt * v.x + sin_tilt * v.z, v.y, cos_tilt * v.z - sin_tilt * v.x)
                };
                let rim = Vec3::new(radius_mm * cos_phi, radius_mm * sin_phi, 0.0);
                let axis = Vec3::new(-sin_half * cos_phi, -sin_half * sin_phi, cos_half);
                Waypoint::Pose(ToolPose { tip_mm: center_mm + tilted(rim), axis: tilted(axis) })
            }
            Self::TipHold { tip_mm, rotary_rad: [from, to] } => {
                let u = if stretch == 0 { u } else { 1.0 - u };
                let rotary_rad = std::array::from_fn(|k| from[k] + (to[k] - from[k]) * u);
                Waypoint::Held { tip_mm: *tip_mm, rotary_rad }
            }
            Self::Polyline { poses } => {
                let last = poses.len().saturating_sub(1);
                let nowhere = ToolPose { tip_mm: Vec3::zeros(), axis: Vec3::z() };
                let pose = |index: usize| poses.get(index.min(last)).copied().unwrap_or(nowhere);
                let (from, to) = (pose(stretch), pose(stretch + 1));
                let turn = GreatCircle::between(from.axis, to.axis, Vec3::x());
                let tip_mm = from.tip_mm + (to.tip_mm - from.tip_mm) * u;
                Waypoint::Pose(ToolPose { tip_mm, axis: turn.at(u) })
            }
        }
    }

    /// Whether the tip changes its direction by more than `angle_rad` after this stretch, or comes to rest there.
    #[must_use]
    pub fn has_corner_after(&self, stretch: usize, angle_rad: f64) -> bool {
        match self {
            Self::ConeFrustum { .. } => false,
            Self::TipHold { .. } => true,
            Self::Polyline { poses } => {
                let Some([a, b, c]) =
                    poses.get(stretch..stretch + 3).and_then(|three| three.first_chunk::<3>())
                else {
                    return false;
                };
                let (before, after) = (b.tip_mm - a.tip_mm, c.tip_mm - b.tip_mm);
                before.norm() <= RESTING_MM
                    || after.norm() <= RESTING_MM
                    || crate::geometry::angle_between(before, after) > angle_rad
            }
        }
    }
}
