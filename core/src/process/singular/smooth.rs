//! Finds rotary words with less travel. At each point, the tolerance of the tool axis gives a room to the axis next
//! to the workpiece. This axis follows the taut string through the rooms. The other axis follows as closely as it
//! can. The tip or the contact stays.

use super::figures::time_s;
use super::pending::Pending;
use super::planner::{Planner, SmoothedMotion};
use super::report::LeftReason;
use super::taut_string::taut_string;
use super::words::{Pen, Wanted};
use crate::contact::{Effort, rotary_rad};
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::TurningRoom;
use crate::motion::{ContactWords, Interpolation};
use crate::process::pipeline::in_units;

/// The new largest speed may be at most this share of the old one. If not, the words are left unchanged.
const WORTH: f64 = 0.9;
/// A motion that takes less time than this has no speed \[s\].
const INSTANT_S: f64 = 1e-9;
/// Error of arithmetic in an angle \[rad\].
const ARITHMETIC_RAD: f64 = 1e-12;

/// The words of u and v at each point of a region \[deg\], and the times of the points: in seconds, or in motions if
/// a feed gives no time.
struct Way {
    words_deg: Vec<[f64; 2]>,
    clock: Vec<f64>,
}

impl Way {
    /// The largest speed of an axis, in degrees per unit of the clock.
    fn fastest(&self) -> f64 {
        let steps = self.words_deg.windows(2).zip(self.clock.windows(2));
        steps
            .map(|(words, at)| {
                let step = |k: usize| (words[1][k] - words[0][k]).abs();
                step(0).max(step(1)) / (at[1] - at[0])
            })
            .fold(0.0, f64::max)
    }
}

impl Planner<'_> {
    /// New ends for the motions of a region. `None` for motions that keep their words.
    ///
    /// # Errors
    /// The reason why the region is left unchanged. It is meaningless if the effort has ended.
    pub(super) fn smooth(
        &self,
        region: &[Pending],
        effort: &mut Effort<'_>,
    ) -> Result<Vec<Option<SmoothedMotion>>, LeftReason> {
        if region.len() < 2 {
            return Err(LeftReason::NothingToGain);
        }
        if region.iter().any(|pending| pending.motion.tool_axis.is_some()) {
            return Err(LeftReason::ToolVectors);
        }
        let states_point = |pending: &Pending| matches!(pending.motion.contact, ContactWords::Point(_));
        if region.iter().any(states_point) && !region.iter().all(states_point) {
            return Err(LeftReason::MixedContacts);
        }
        let source = self.source_way(region);
        let way = self.taut_way(region, &source)?;
        if way.fastest() > WORTH * source.fastest() {
            return Err(LeftReason::NothingToGain);
        }
        self.written(region, &way, effort)
    }

    fn source_way(&self, region: &[Pending]) -> Way {
        let [u, v] = self.cutting.kinematics.workpiece_to_tool();
        let words = |deg: [f64; 2]| [deg[u], deg[v]];
        let first = region.iter().take(1).map(|pending| words(pending.ends[0].words.rotary_deg));
        let words_deg = first.chain(region.iter().map(|pending| words(pending.ends[1].words.rotary_deg)));
        let times: Option<Vec<f64>> = region
            .iter()
            .map(|pending| {
                let block = self.cutting.block(pending.mode, pending.ends, [None, None]);
                time_s(&block, &pending.motion).filter(|time_s| *time_s > INSTANT_S)
            })
            .collect();
        // If a time is not known, every block counts the same.
        let times = times.unwrap_or_else(|| vec![1.0; region.len()]);
        let mut clock = vec![0.0];
        let mut now = 0.0;
        for time in times {
            now += time;
            clock.push(now);
        }
        Way { words_deg: words_deg.collect(), clock }
    }

    /// The path with the slowest axis next to the workpiece. The ends of the region stay.
    fn taut_way(&self, region: &[Pending], source: &Way) -> Result<Way, LeftReason> {
        let kinematics = &self.cutting.kinematics;
        let [u, _] = kinematics.workpiece_to_tool();
        let travel = self.cutting.machine.rotary_axes()[u].travel_deg;
        let last = region.len();
        let mut rooms = Vec::with_capacity(last + 1);
        for (index, words) in source.words_deg.iter().enumerate() {
            let Some(pending) = (index > 0 && index < last).then(|| region.get(index - 1)).flatten() else {
                rooms.push([words[0]; 2]);
                continue;
            };
            let tolerance_rad = self.room_rad(pending)?;
            let station = &pending.ends[1];
            let angles = rotary_rad(self.cutting.machine, station.words.rotary_deg);
            let branch = kinematics.branch(angles);
            let room = kinematics
                .turning_room(station.pose.axis, branch, words[0], tolerance_rad)
                .unwrap_or_else(|| TurningRoom::only(words[0]));
            let [mut low, mut high] = room.range_deg;
            if let Some(travel) = travel {
                (low, high) = (low.max(travel.min), high.min(travel.max));
            }
            rooms.push([low.min(words[0]), high.max(words[0])]);
        }
        let first_words = taut_string(&source.clock, &rooms);
        let words_deg = first_words
            .into_iter()
            .enumerate()
            .map(|(index, first_deg)| {
                let [_, second_deg] = source.words_deg[index];
                let Some(pending) = (index > 0 && index < last).then(|| region.get(index - 1)).flatten()
                else {
                    return [first_deg, second_deg];
                };
                let axis = pending.ends[1].pose.axis;
                [first_deg, kinematics.best_second_deg(axis, first_deg, second_deg)]
            })
            .collect();
        Ok(Way { words_deg, clock: source.clock.clone() })
    }

    /// The part of the tool-axis tolerance that remains after the rotary words are rounded \[rad\].
    pub(super) fn room_rad(&self, pending: &Pending) -> Result<f64, LeftReason> {
        let [_, decimals] = self.decimals(&pending.motion);
        let half_rad = (0.5 * 0.1_f64.powi(i32::from(decimals))).to_radians();
        let tolerance_rad = self.singularity.axis_tolerance.rad();
        // Half a unit of one rotary word turns the tool by no more than `half_rad`.
        let room_rad = tolerance_rad - 2.0 * half_rad - ARITHMETIC_RAD;
        if room_rad < 0.5 * tolerance_rad {
            return Err(LeftReason::DecimalsTooCoarse);
        }
        Ok(room_rad)
    }

    /// The words of all points as they are written, rotary words first.
    fn written(
        &self,
        region: &[Pending],
        way: &Way,
        effort: &mut Effort<'_>,
    ) -> Result<Vec<Option<SmoothedMotion>>, LeftReason> {
        let kinematics = &self.cutting.kinematics;
        let [u, v] = kinematics.workpiece_to_tool();
        let Some(first) = region.first() else { return Ok(Vec::new()) };
        let mut pen = Pen::at_start(self.cutting.machine, first);
        let mut from = first.ends[0].words;
        let mut found = Vec::with_capacity(region.len());
        for (index, pending) in region.iter().enumerate() {
            effort.pass(1);
            if effort.is_over() {
                return Err(LeftReason::NothingToGain);
            }
            let is_last = index + 1 == region.len();
            let unit = pending.motion.mm_per_unit;
            let [linear, rotary] = self.decimals(&pending.motion);
            let near = |decimals| if is_last { Wanted::Exact(decimals) } else { Wanted::Near(decimals) };
            let source = &pending.ends[1];
            let mut words = Vec::new();
            let mut rotary_deg = source.words.rotary_deg;
            if !is_last && let Some(wanted) = way.words_deg.get(index + 1) {
                (rotary_deg[u], rotary_deg[v]) = (wanted[0], wanted[1]);
            }
            for (k, word_deg) in rotary_deg.into_iter().enumerate() {
                pen.move_to(pending, 3 + k, word_deg, near(rotary), &mut words);
            }
            let angles = rotary_rad(self.cutting.machine, pen.words(unit).rotary_deg);
            let axis = kinematics.axis(angles);
            if !is_last && angle_between(axis, source.pose.axis) > self.singularity.axis_tolerance.rad() {
                return Err(LeftReason::DecimalsTooCoarse);
            }
            let touch = self.cutting.touch(source, pending.mode, pending.motion.contact, effort);
            let tip_mm = self.cutting.kept_tip_mm(&source.pose, touch.as_ref(), axis);
            let mut target = *source;
            if !is_last {
                target.words.linear_mm = match pending.mode {
                    Interpolation::Tcp => tip_mm.into(),
                    Interpolation::Machine => kinematics.linear_mm(tip_mm, angles).into(),
                };
            }
            let target = in_units(&target.words, unit);
            for (k, target) in target.into_iter().enumerate().take(3) {
                pen.move_to(pending, k, target, near(linear), &mut words);
            }
            let contact = self.contact_words(pending, &mut pen, angles, is_last, &mut words);
            let end = pen.words(unit);
            if self.is_outside(pending.mode, &end) {
                return Err(LeftReason::OutOfTravel);
            }
            let is_same = words.is_empty() && from == pending.ends[0].words;
            let moved = if is_same {
                None
            } else {
                let ends = [from, end];
                let feed = self.feed(pending, ends)?;
                let half_mm = 0.5 * 0.1_f64.powi(i32::from(linear)) * unit;
                Some(SmoothedMotion { pending: pending.clone(), ends, contact, words, feed, touch, half_mm })
            };
            found.push(moved);
            from = if is_same { source.words } else { end };
        }
        Ok(found)
    }

    /// U V W of the same contact. In machine interpolation they depend on the rotary words.
    fn contact_words(
        &self,
        pending: &Pending,
        pen: &mut Pen,
        angles: [f64; 2],
        is_last: bool,
        words: &mut Vec<crate::program::NewWord>,
    ) -> ContactWords {
        let ContactWords::Point(source_mm) = pending.motion.contact else { return pending.motion.contact };
        let decimals = pending.motion.decimals.contact.max(self.decimals(&pending.motion)[0]);
        if is_last || pending.mode == Interpolation::Tcp {
            return pen.point_to(pending, source_mm, Wanted::Exact(decimals), words);
        }
        let point_mm: Vec3 = self.cutting.point_mm(source_mm, &pending.ends[1], pending.mode);
        let target_mm = self.cutting.kinematics.linear_mm(point_mm, angles).into();
        pen.point_to(pending, target_mm, Wanted::Near(decimals), words)
    }
}
