//! All exact sets of joints for a tool pose.

use super::pointing::{Pointed, Pointing, principal_deg};
use super::{InverseError, Joints, Kinematics, ToolPose};
use crate::geometry::{Vec3, trig};
use crate::machine::{Motion, Travel};

/// A computed word that lies outside a travel by no more is at its end \[deg or mm\]: the rounding of double
/// precision, well below the decimals of a program ([`Travel::WORD_SLACK`]).
pub const COMPUTED_WORD_SLACK: f64 = 1e-9;
/// A direction beyond the reach limit by no more than this counts as on it \[rad\].
pub const REACH_SLACK_RAD: f64 = 1e-9;
/// Closer than this to a reach limit or to the pole \[rad\] the two solutions are one: the axis moves by no more
/// than this.
const MERGE_RAD: f64 = 1e-13;
/// Largest coordinate of a pose accepted \[mm\].
pub const MAX_COORDINATE_MM: f64 = 1e6;

/// One of the two solutions of the direction: the sign of B in `v-angle = b0 ± B` (§1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// B is positive, or zero where both solutions are one.
    Plus,
    /// B is negative.
    Minus,
}

impl Branch {
    pub(super) const BOTH: [Self; 2] = [Self::Plus, Self::Minus];
}

/// One exact solution within travel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The solution of the direction.
    pub branch: Branch,
    /// Whole turns of the NC words beyond (−180, 180], in the profile's order.
    pub turns: [i32; 2],
    /// Axis positions.
    pub joints: Joints,
    /// |t·(u × v′)|: 0 at the pole and at the reach limit, 1 at its best.
    pub conditioning: f64,
    /// Angle between the tool axis and the pose's \[rad\]: 0, except for a pose beyond the reach limit by no more
    /// than 1e-9 rad or the tilt of the location errors.
    pub axis_residual_rad: f64,
}

/// The directions of one pose, examined one by one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solution {
    /// NC words of u, v \[deg\] for each branch.
    pub(super) words_deg: [[f64; 2]; 2],
    /// 1 where both branches meet.
    pub(super) branches: usize,
    pub(super) conditioning: f64,
    /// The axis is along ±u: the u-word is free.
    pub(super) at_pole: bool,
    /// min(φ, π − φ) \[rad\].
    pub(super) polar_distance_rad: f64,
    pub(super) axis_residual_rad: f64,
}

impl Kinematics {
    /// All exact candidates of a pose: both branches and every whole turn inside the travels (an unlimited axis
    /// has one, with its word in (−180, 180]), with X Y Z within travel. At the pole the word of the axis next to
    /// the workpiece is free. It becomes `free_word_deg`, moved into its travel. `index` names the pose in errors.
    ///
    /// The number of candidates is at most [`Kinematics::max_candidates`].
    ///
    /// # Errors
    /// No direction, direction out of reach, or every solution out of travel.
    pub fn candidates(
        &self,
        index: usize,
        pose: &ToolPose,
        free_word_deg: f64,
    ) -> Result<Vec<Candidate>, InverseError> {
        let mut solution = self.solution(index, pose)?;
        if solution.at_pole {
            let travel = self.travel_deg[0];
            let word = travel.map_or(free_word_deg, |t| free_word_deg.clamp(t.min, t.max));
            solution.words_deg[0][0] = word;
        }
        let mut found = Vec::new();
        let mut nearest_miss: Option<(f64, InverseError)> = None;
        let mut miss = |excess: f64, rank: f64, error: InverseError| {
            if nearest_miss.is_none_or(|(least, _)| rank + excess < least) {
                nearest_miss = Some((rank + excess, error));
            }
        };
        for branch in 0..solution.branches {
            let words = solution.words_deg[branch];
            let principal = words.map(principal_deg);
            let ranges: [_; 2] = std::array::from_fn(|k| turn_range(principal[k], self.travel_deg[k]));
            for k in 0..2 {
                if let (true, Some(travel)) = (ranges[k].is_empty(), self.travel_deg[k]) {
                    let (commanded, excess) = least_excess(principal[k], travel);
                    let axis = Motion::Rotary(self.profile_index[k]);
                    let (min, max) = (travel.min, travel.max);
                    miss(
                        excess,
                        ROTARY_RANK,
                        InverseError::OutOfTravel { pose: index, axis, commanded, min, max },
                    );
                }
            }
            for turn_u in ranges[0].clone() {
                for turn_v in ranges[1].clone() {
                    let turned =
                        [principal[0] + 360.0 * f64::from(turn_u), principal[1] + 360.0 * f64::from(turn_v)];
                    let joints = self.joints_at(pose.tip_mm, turned);
                    if let Some((excess, error)) = self.linear_miss(index, joints.linear_mm) {
                        miss(excess, 0.0, error);
                        continue;
                    }
                    let mut turns = [0; 2];
                    turns[self.profile_index[0]] = turn_u;
                    turns[self.profile_index[1]] = turn_v;
                    found.push(Candidate {
                        branch: Branch::BOTH[branch],
                        turns,
                        joints,
                        conditioning: solution.conditioning,
                        axis_residual_rad: solution.axis_residual_rad,
                    });
                }
            }
        }
        match nearest_miss {
            Some((_, error)) if found.is_empty() => Err(error),
            _ => Ok(found),
        }
    }

    /// The largest number of candidates of a pose, for estimates of size before the work starts.
    #[must_use]
    pub fn max_candidates(&self) -> usize {
        self.travel_deg.iter().fold(2, |count, travel| {
            let turns = travel.map_or(1.0, |t| ((t.max - t.min) / 360.0).floor() + 1.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 2001 turns")]
            let turns = turns as usize;
            count * turns
        })
    }

    /// The tilt that the location errors give u and v \[rad\]: the angles between nominal and calibrated direction
    /// of both axes, summed. 0 if errors are ignored.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        self.tilt_rad
    }

    /// The directions of one pose, with reach, pole and merging examined.
    pub(super) fn solution(&self, index: usize, pose: &ToolPose) -> Result<Solution, InverseError> {
        let Some(axis) = usable_axis(pose) else { return Err(InverseError::NoDirection { pose: index }) };
        let t: [f64; 3] = axis.into();
        let pointed = self.pointing.solve(t);
        let Reach { tilt_rad, nearest, farthest, beyond_rad, far } = reach(&self.pointing, &pointed);
        let polar_distance_rad = tilt_rad.min(std::f64::consts::PI - tilt_rad);
        let at_pole = polar_distance_rad <= MERGE_RAD;
        if beyond_rad > REACH_SLACK_RAD.max(self.tilt_rad) {
            let [tilt_deg, min_deg, max_deg] = [tilt_rad, nearest, farthest].map(f64::to_degrees);
            return Err(InverseError::OutOfReach { pose: index, tilt_deg, min_deg, max_deg });
        }
        let one = beyond_rad >= -MERGE_RAD;
        Ok(Solution {
            words_deg: if one { [self.pointing.solve_at_limit(t, far); 2] } else { pointed.words_deg },
            branches: if one { 1 } else { 2 },
            conditioning: if one { 0.0 } else { pointed.conditioning },
            at_pole,
            polar_distance_rad,
            axis_residual_rad: if beyond_rad > MERGE_RAD { beyond_rad } else { 0.0 },
        })
    }

    /// Joints for the NC words of u, v \[deg\]. The tip is exact for these words.
    pub(super) fn joints_at(&self, tip_mm: Vec3, words_deg: [f64; 2]) -> Joints {
        let mut rotary_rad = [0.0; 2];
        for k in 0..2 {
            rotary_rad[self.profile_index[k]] = self.sense[k] * words_deg[k].to_radians();
        }
        Joints { linear_mm: self.linear_mm(tip_mm, rotary_rad), rotary_rad }
    }

    /// Whether an axis among X Y Z has a travel.
    pub(super) fn is_linear_limited(&self) -> bool {
        self.linear_travel_mm.iter().any(Option::is_some)
    }

    /// Whether [`Kinematics::linear_miss`] finds none.
    #[inline]
    pub(super) fn is_linear_within(&self, linear_mm: [f64; 3]) -> bool {
        let [x, y, z] = &self.linear_travel_mm;
        [x, y, z]
            .into_iter()
            .zip(linear_mm)
            .all(|(travel, commanded)| travel.is_none_or(|travel| !is_beyond(travel, commanded)))
    }

    /// The linear axis with the largest excess over its travel, if any, with the excess \[mm\].
    pub(super) fn linear_miss(&self, index: usize, linear_mm: Vec3) -> Option<(f64, InverseError)> {
        let mut worst: Option<(f64, InverseError)> = None;
        for (k, travel) in self.linear_travel_mm.iter().enumerate() {
            let Some(Travel { min, max }) = *travel else { continue };
            let commanded = linear_mm[k];
            let excess = (min - commanded).max(commanded - max);
            if excess > COMPUTED_WORD_SLACK && worst.is_none_or(|(most, _)| excess > most) {
                let axis = Motion::Linear(k);
                worst = Some((excess, InverseError::OutOfTravel { pose: index, axis, commanded, min, max }));
            }
        }
        worst
    }
}

/// Whether a word of X, Y or Z is beyond its travel.
#[inline]
fn is_beyond(Travel { min, max }: Travel, commanded: f64) -> bool {
    (min - commanded).max(commanded - max) > COMPUTED_WORD_SLACK
}

/// An excess of a rotary axis is reported only if no branch reaches the check of the linear axes.
pub(super) const ROTARY_RANK: f64 = 1e9;

/// The pose's axis, normalised; `None` for a zero vector, or for numbers that are not finite or too large.
pub(super) fn usable_axis(pose: &ToolPose) -> Option<Vec3> {
    let tip_ok = pose.tip_mm.iter().all(|c| (-MAX_COORDINATE_MM..=MAX_COORDINATE_MM).contains(c));
    let square = pose.axis.x * pose.axis.x + pose.axis.y * pose.axis.y + pose.axis.z * pose.axis.z;
    (tip_ok && AXIS_SQUARE_RANGE.contains(&square)).then(|| pose.axis * (1.0 / square.sqrt()))
}

/// Squares of lengths of tool axes that can be normalised without loss.
pub(super) const AXIS_SQUARE_RANGE: std::ops::RangeInclusive<f64> = 1e-200..=1e200;

struct Reach {
    tilt_rad: f64,
    nearest: f64,
    farthest: f64,
    /// Angle of the direction beyond reach; negative inside.
    beyond_rad: f64,
    /// Whether the farther limit is the closer one.
    far: bool,
}

fn reach(pointing: &Pointing, pointed: &Pointed) -> Reach {
    let [sin2, cos2] = pointed.half_tilt;
    let tilt_rad = 2.0 * trig::atan2(sin2.sqrt(), cos2.sqrt());
    let (sigma, tau) = (pointing.sigma_rad, pointing.tau_rad);
    let nearest = (sigma - tau).abs();
    let farthest = (sigma + tau).min(std::f64::consts::TAU - (sigma + tau));
    let (below, above) = (nearest - tilt_rad, tilt_rad - farthest);
    Reach { tilt_rad, nearest, farthest, beyond_rad: below.max(above), far: above > below }
}

/// The whole turns k for which `word + 360·k` is within travel; only 0 on an unlimited axis.
pub(super) fn turn_range(word_deg: f64, travel: Option<Travel>) -> std::ops::Range<i32> {
    let Some(Travel { min, max }) = travel else { return 0..1 };
    let first = ((min - COMPUTED_WORD_SLACK - word_deg) / 360.0).ceil();
    let last = ((max + COMPUTED_WORD_SLACK - word_deg) / 360.0).floor();
    #[expect(clippy::cast_possible_truncation, reason = "travel ends are within a thousand turns")]
    let range = first as i32..(last as i32) + 1;
    range
}

/// The turned word with the smallest excess over the travel, and that excess \[deg\].
pub(super) fn least_excess(word_deg: f64, travel: Travel) -> (f64, f64) {
    let turns = ((0.5 * (travel.min + travel.max) - word_deg) / 360.0).round();
    let word = word_deg + 360.0 * turns;
    (word, (travel.min - word).max(word - travel.max))
}
