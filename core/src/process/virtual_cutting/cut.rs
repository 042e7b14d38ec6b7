//! The course of one motion, and the number of straight pieces into which it is divided.

use super::parameters::VerificationParameters;
use crate::contact::{CutterBody, Station};
use crate::geometry::Vec3;
use crate::kinematics::{Kinematics, ToolPose};
use crate::machine::Machine;
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind};
use crate::process::arc_path::{ArcModes, ArcPath};
use crate::process::fault::LeftOutReason;
use crate::program::Batch;

/// A motion whose every pose is known.
#[derive(Debug, Clone, Copy)]
pub(super) struct CutPath {
    shape: Shape,
    mode: Interpolation,
    pub(super) kind: MotionKind,
    pub(super) line: u64,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
    /// All five words linear.
    Straight([AxisWords; 2]),
    Arc(ArcPath),
}

/// Pieces longer than this, in cutter radii, are divided: short pieces are excluded faster.
const MAX_LENGTH_IN_RADII: f64 = 0.5;
/// Most pieces into which a motion is divided for its length alone.
const MAX_PIECES_BY_LENGTH: f64 = 4096.0;
/// Most stretching of the linear axes by squareness errors, each within 0.05 rad.
const STRETCH: f64 = 1.2;

impl CutPath {
    /// The course of a motion; `None` if it has no length.
    ///
    /// # Errors
    /// Why the course is not known.
    pub(super) fn of(
        parameters: &VerificationParameters,
        modes: ArcModes,
        batch: &Batch,
        motion: &Motion,
    ) -> Result<Option<Self>, LeftOutReason> {
        if let Some(reason) = motion.unfollowable {
            return Err(LeftOutReason::NotFollowed(reason));
        }
        if motion.offset_changed {
            return Err(LeftOutReason::WorkOffsetChanged);
        }
        let (Some(start), Some(end)) = (motion.start, motion.end) else {
            return Err(LeftOutReason::PositionUnknown);
        };
        let shape = match motion.kind {
            MotionKind::Arc => {
                let arc = ArcPath::of(modes, batch, motion, [start, end]);
                Shape::Arc(arc.map_err(LeftOutReason::UnknownArc)?)
            }
            _ if start == end => return Ok(None),
            _ => Shape::Straight([start, end]),
        };
        let mode = motion.mode(parameters.program.interpolation);
        Ok(Some(Self { shape, mode, kind: motion.kind, line: motion.line }))
    }

    /// Whether a rotary axis is off zero under machine interpolation. The tool's position in W then depends on the
    /// set-up.
    pub(super) fn hangs_on_set_up(&self) -> bool {
        let is_off = |words: AxisWords| words.rotary_deg.iter().any(|word| word.abs() > 0.0);
        self.mode == Interpolation::Machine && [0.0, 1.0].into_iter().any(|u| is_off(self.words_at(u)))
    }

    /// The tool's pose at the fraction `u`.
    pub(super) fn pose_at(&self, machine: &Machine, kinematics: &Kinematics, u: f64) -> ToolPose {
        Station::new(machine, kinematics, self.mode, self.words_at(u)).pose
    }

    fn words_at(&self, u: f64) -> AxisWords {
        match &self.shape {
            Shape::Arc(arc) => arc.words_at(u),
            Shape::Straight([from, to]) => {
                let lerp = |a: f64, b: f64| if u >= 1.0 { b } else { a + (b - a) * u };
                AxisWords {
                    linear_mm: std::array::from_fn(|k| lerp(from.linear_mm[k], to.linear_mm[k])),
                    rotary_deg: std::array::from_fn(|k| lerp(from.rotary_deg[k], to.rotary_deg[k])),
                }
            }
        }
    }

    /// Number of equal pieces of the motion. A piece is taken as straight in the frame of the tool, and is nowhere
    /// farther than `resolution_mm` from the true motion.
    ///
    /// In that frame a point at the distance ρ from the tip has the second derivative `|y″| ≤ ρΩ² + 2Ω|w′| + |w″|`
    /// by u. Ω is the sum of both rotary axes' turns, and w the tip in W. N chords leave `|y″|/(8N²)`. ρ belongs to
    /// the cutter's farthest point.
    pub(super) fn pieces(
        &self,
        machine: &Machine,
        kinematics: &Kinematics,
        body: &CutterBody,
        resolution_mm: f64,
    ) -> u64 {
        let reach_mm = body.cutting_length_mm() + body.radius_mm();
        let (path_mm, bend_mm) = match &self.shape {
            Shape::Arc(arc) => {
                let [path_mm, bend_mm] = arc.derivative_bounds_mm();
                (STRETCH * path_mm, STRETCH * bend_mm)
            }
            Shape::Straight(ends) => {
                let turns =
                    [0, 1].map(|k| (ends[1].rotary_deg[k] - ends[0].rotary_deg[k]).abs().to_radians());
                let tips = [0.0, 1.0].map(|u| self.pose_at(machine, kinematics, u).tip_mm);
                let tip_bend_mm = match self.mode {
                    Interpolation::Tcp => 0.0,
                    Interpolation::Machine => {
                        let linear = [0, 1].map(|k| Vec3::from(ends[k].linear_mm));
                        kinematics.tip_curvature_bound_mm(linear, tips, turns)
                    }
                };
                let turn = turns[0] + turns[1];
                // the tip's speed differs from its mean by no more than half its change
                let path_mm = (tips[1] - tips[0]).norm() + 0.5 * tip_bend_mm;
                (path_mm, reach_mm * turn * turn + 2.0 * turn * path_mm + tip_bend_mm)
            }
        };
        let by_bend = (bend_mm / (8.0 * resolution_mm)).sqrt();
        let by_length = (path_mm / (MAX_LENGTH_IN_RADII * body.radius_mm())).min(MAX_PIECES_BY_LENGTH);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at least 1, and saturates"
        )]
        let pieces = by_bend.max(by_length).ceil().max(1.0) as u64;
        pieces
    }
}
