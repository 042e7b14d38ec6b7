//! Distance from the tool to the commanded path.

use crate::geometry::{Vec3, angle_between};
use crate::kinematics::ToolPose;

/// Contour error at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContourError {
    /// Distance of the tool tip from the commanded path \[mm\]. With a plane it is measured in that plane, and
    /// positive to the right of travel as seen from its normal.
    pub tip_mm: f64,
    /// Angle between the tool axis and the commanded one at the foot \[rad\].
    pub axis_rad: f64,
}

/// Follows the foot of the actual tool on the commanded path.
///
/// The path is the polyline of the commanded samples. The foot is searched from slightly before the previous foot
/// to the present command: a nearest point of the whole path could be on the neighbouring pass. Only if the tool
/// leads the command, as feed-forward can make it, the search continues beyond the command as long as the distance
/// decreases.
#[derive(Debug, Clone)]
pub struct FootTracker {
    /// Commanded poses that are still needed.
    path: Vec<Sample>,
    /// Index of the first of them in the run.
    base: usize,
    /// Index in the run of the segment of the previous foot.
    foot: usize,
    plane_normal: Option<Vec3>,
    /// First sample at the present position of the command.
    arrived: usize,
    /// First sample to which the search may go back.
    window: usize,
    /// How far behind the command the foot is searched \[segments on which the command moved\].
    longest_lag: usize,
    /// Whether a foot has been farther behind than the search.
    is_lost: bool,
}

/// Tip, and tool axis times [`AXIS_WEIGHT_MM`].
#[derive(Debug, Clone, Copy)]
struct Sample {
    tip_mm: Vec3,
    axis: Vec3,
    /// Length of the path up to here, as the search counts it.
    arc: f64,
    /// Number of samples up to here at which the command moved.
    moves: usize,
}

/// The length in millimetres of tip that a radian of tool axis counts as in the search for the foot. It is so small
/// that it does not move the foot of a moving tip, yet it finds the foot if the tip rests and only the axis turns.
const AXIS_WEIGHT_MM: f64 = 1e-3;
/// How far before the previous foot the search begins \[segments\].
const BACK: usize = 4;
/// Rounding of the length of a path of a kilometre.
const ARC_ROUNDING_MM: f64 = 1e-8;
/// How far beyond the command a leading tool is followed \[segments\].
pub const LOOK_AHEAD: usize = 64;

/// Initial position of a tool, before any command.
const NOWHERE: Sample =
    Sample { tip_mm: Vec3::new(0.0, 0.0, 0.0), axis: Vec3::new(0.0, 0.0, 1.0), arc: 0.0, moves: 0 };

impl Sample {
    fn separation(&self, other: &Self) -> f64 {
        let tip = (self.tip_mm - other.tip_mm).norm_squared();
        let axis = (self.axis - other.axis).norm_squared();
        (tip + AXIS_WEIGHT_MM * AXIS_WEIGHT_MM * axis).sqrt()
    }
}

/// A point of a segment: its position on the segment, and its distance.
#[derive(Debug, Clone, Copy)]
struct Foot {
    segment: usize,
    fraction: f64,
    separation: f64,
}

impl FootTracker {
    /// A tracker for a path that is still to come. `plane_normal` gives the error a sign. The tool is searched at
    /// most `longest_lag` samples with motion behind the command.
    #[must_use]
    pub fn new(plane_normal: Option<Vec3>, longest_lag: usize) -> Self {
        Self {
            path: Vec::new(),
            base: 0,
            foot: 0,
            arrived: 0,
            window: 0,
            plane_normal,
            longest_lag,
            is_lost: false,
        }
    }

    /// Whether the tool has ever been farther behind its command than the search. Its errors are then wrong.
    #[must_use]
    pub const fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Takes the next commanded pose.
    pub fn command(&mut self, pose: &ToolPose) {
        let mut sample = Sample { tip_mm: pose.tip_mm, axis: pose.axis, arc: 0.0, moves: 0 };
        if let Some(last) = self.path.last() {
            sample.arc = last.arc + last.separation(&sample);
            sample.moves = last.moves + usize::from(sample.arc > last.arc);
        }
        self.path.push(sample);
    }

    /// The contour error of `actual` while the command is at sample `now` of the run. Samples up to
    /// `now + LOOK_AHEAD` must have been commanded, as far as the run has them.
    pub fn judge(&mut self, actual: &ToolPose, now: usize) -> ContourError {
        let actual = Sample { tip_mm: actual.tip_mm, axis: actual.axis, arc: 0.0, moves: 0 };
        let Sample { arc, moves, .. } = *self.at(now);
        let oldest = moves.saturating_sub(self.longest_lag);
        self.is_lost |= self.at(self.foot).moves < oldest;
        self.window = self.first_after(self.window, |sample| sample.moves < oldest);
        // If the command has been at rest since then, only one position has to be searched.
        self.arrived = self.first_after(self.arrived, |sample| sample.arc < arc);
        let first = self.foot.min(self.arrived).saturating_sub(BACK).max(self.window);
        let mut best = self.foot_on(first.min(now), &actual);
        let mut segment = first;
        while segment < self.arrived.min(now) {
            let foot = self.foot_on(segment, &actual);
            // Of equal feet the later one is taken: where nothing moves, the foot keeps up with the command.
            if foot.separation <= best.separation {
                best = foot;
            }
            // The path cannot come nearer by more than its own length.
            let reach = self.at(segment + 1).arc + foot.separation - best.separation - ARC_ROUNDING_MM;
            segment = self.first_beyond(reach, segment + 1, now);
        }
        if best.segment + 1 >= self.arrived && best.fraction >= 1.0 && self.arrived < now {
            best = self.foot_on(now - 1, &actual);
        }
        let is_at_the_command = best.segment + 1 >= now && best.fraction >= 1.0;
        if is_at_the_command || now == self.base {
            for segment in now..now + LOOK_AHEAD {
                let foot = self.foot_on(segment, &actual);
                if foot.separation > best.separation {
                    break;
                }
                best = foot;
            }
        }
        self.foot = best.segment;
        self.error_at(&best, &actual)
    }

    /// The first segment from `from` on, before `now`, whose end is farther than this length of path.
    fn first_beyond(&self, arc: f64, from: usize, now: usize) -> usize {
        let ends = |segment: usize| (segment + 1).saturating_sub(self.base).min(self.path.len());
        let within = self.path.get(ends(from)..ends(now)).unwrap_or_default();
        // Mostly it is the next one.
        if within.first().is_some_and(|end| end.arc >= arc) {
            return from;
        }
        from + within.partition_point(|end| end.arc < arc)
    }

    /// The index in the run of the first sample that is not `before`, if all samples `before` come first. It is
    /// searched from `near` on: it moves by a sample or so with each of the command.
    fn first_after(&self, near: usize, before: impl Fn(&Sample) -> bool) -> usize {
        let mut index = near.saturating_sub(self.base).min(self.path.len());
        while index > 0 && !before(&self.path[index - 1]) {
            index -= 1;
        }
        while index < self.path.len() && before(&self.path[index]) {
            index += 1;
        }
        self.base + index
    }

    /// Removes the samples that no later search needs.
    pub fn trim(&mut self) {
        let keep_from = self.foot.min(self.arrived).saturating_sub(BACK).max(self.base);
        let count = (keep_from - self.base).min(self.path.len());
        self.path.drain(..count);
        self.base += count;
    }

    /// The nearest point of a segment; beyond the end of the path its last point.
    fn foot_on(&self, segment: usize, actual: &Sample) -> Foot {
        let (from, to) = (self.at(segment), self.at(segment + 1));
        let weight = AXIS_WEIGHT_MM * AXIS_WEIGHT_MM;
        let (tip, axis) = (to.tip_mm - from.tip_mm, to.axis - from.axis);
        let length2 = tip.norm_squared() + weight * axis.norm_squared();
        let along = (actual.tip_mm - from.tip_mm).dot(&tip) + weight * (actual.axis - from.axis).dot(&axis);
        let fraction = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 1.0 };
        let at = Sample {
            tip_mm: from.tip_mm + tip * fraction,
            axis: from.axis + axis * fraction,
            arc: 0.0,
            moves: 0,
        };
        Foot { segment, fraction, separation: actual.separation(&at) }
    }

    /// A sample of the run. Beyond the known samples, the nearest known one.
    fn at(&self, index: usize) -> &Sample {
        let last = self.path.len().saturating_sub(1);
        self.path.get(index.saturating_sub(self.base).min(last)).unwrap_or(&NOWHERE)
    }

    fn error_at(&self, foot: &Foot, actual: &Sample) -> ContourError {
        let (from, to) = (self.at(foot.segment), self.at(foot.segment + 1));
        let travel = to.tip_mm - from.tip_mm;
        let away = actual.tip_mm - (from.tip_mm + travel * foot.fraction);
        let axis_rad = angle_between(actual.axis, from.axis + (to.axis - from.axis) * foot.fraction);
        let tip_mm = match self.plane_normal {
            None => away.norm(),
            Some(normal) => {
                let in_plane = away - normal * normal.dot(&away);
                let right = travel.cross(&normal);
                in_plane.norm().copysign(in_plane.dot(&right))
            }
        };
        ContourError { tip_mm, axis_rad }
    }
}
