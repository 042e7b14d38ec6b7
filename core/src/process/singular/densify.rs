//! Divides a motion into equal parts. The contact keeps to its line, the tool axis stays near the great circle, and
//! no rotary axis turns far in one part.
//!
//! The tolerance around the great circle gives the axis next to the workpiece a room at every node. For a given
//! number of parts, the taut string through the rooms has the smallest largest step. The nodes use half of the
//! tolerance. The other half is for the path between them.

use super::figures::{axis_deviation, great_circle, rotary_steps_deg};
use super::pending::Pending;
use super::planner::{DensifiedMotion, Planner};
use super::report::LeftReason;
use super::taut_string::taut_string;
use crate::contact::{
    CutterContact, Effort, Node, Resolution, SourceBlock, Station, prove, rotary_rad, sample_until_sure,
    segments,
};
use crate::geometry::GreatCircle;
use crate::kinematics::{Branch, TurningRoom};
use crate::motion::{AxisWords, ContactWords, FeedMode, Interpolation};
use crate::process::divided::{Checked, Division, resolution, unfit_feed};
use crate::process::pipeline::FeedInTime;
use crate::process::set_up::ContactSource;

/// Largest number of parts of one block.
pub(super) const MAX_PARTS: u32 = 2048;
/// The nodes' share of the tool-axis tolerance.
const NODES_SHARE: f64 = 0.5;
/// Plans leave this share of the contact's tolerance free, for deviations that sampling misses.
const RESERVE: f64 = 2e-4;
/// Rounded words may exceed the largest step by this \[deg\].
const STEP_SLACK_DEG: f64 = 1e-9;

/// A motion that is to be divided.
struct Task<'a, 'b> {
    planner: &'b Planner<'a>,
    pending: &'b Pending,
    block: &'b SourceBlock<'a>,
    arc: GreatCircle,
    resolution: Resolution,
    /// The tool-axis tolerance of the nodes \[rad\].
    room_rad: f64,
}

impl<'a> Planner<'a> {
    /// The parts of a motion. `None` if it is left unchanged because it keeps every limit.
    ///
    /// # Errors
    /// The reason why it is not divided although it should be.
    pub(super) fn densify(
        &self,
        pending: &Pending,
        effort: &mut Effort<'_>,
    ) -> Result<Option<DensifiedMotion<'a>>, LeftReason> {
        let block = self.block(pending, effort);
        let limits = self.limits();
        let (arc, whole) = (great_circle(&block), block.whole());
        let axis = axis_deviation(&block, &whole, &arc, limits.axis_tolerance_rad);
        let before = sample_until_sure(&block, &whole, limits.tolerance_mm);
        effort.spend(axis.evaluations + before.evaluations);
        let step_deg = rotary_steps_deg(&whole).into_iter().fold(0.0, f64::max);
        let times = [
            (axis.sampled_rad / limits.axis_tolerance_rad).sqrt(),
            (before.max_mm / limits.tolerance_mm).sqrt(),
            step_deg / self.singularity.max_step.deg(),
        ];
        let needed = times.into_iter().fold(0.0, f64::max);
        if needed <= 1.0 {
            return Ok(None);
        }
        let motion = &pending.motion;
        if motion.tool_axis.is_some() {
            return Err(LeftReason::ToolVectors);
        }
        if motion.feed.mode == Some(FeedMode::InverseTime) && motion.feed.value.is_none() {
            return Err(LeftReason::NoInverseTime);
        }
        if motion.extra.is_some_and(|extra| extra.start.is_none()) {
            return Err(LeftReason::ExtruderUnknown);
        }
        let start_contact = match pending.standing {
            ContactWords::None => None,
            ContactWords::Point(words) | ContactWords::Normal(words) => Some(words),
        };
        let contact_from_words = self.cutting.contact == ContactSource::Program;
        // The parts are not judged again by their contacts, because regions are judged by their words alone.
        let contacts = [CutterContact::Tip; 2];
        let checked = Checked { block, before, contact_from_words, start_contact, contacts, pass_feed: None };
        let [linear, rotary] = self.decimals(motion);
        let resolution = resolution(&checked, motion, linear, rotary);
        let room_rad = self.room_rad(pending)?.min(NODES_SHARE * limits.axis_tolerance_rad);
        let task = Task { planner: self, pending, block: &checked.block, arc, resolution, room_rad };
        let nodes = task.fewest(needed, effort)?;
        let carries_feed = motion.feed.value.is_some() && self.survey.has_feed_column;
        if carries_feed {
            match unfit_feed(&checked, motion, &nodes, self.cutting.parameters.max_feed) {
                None | Some(FeedInTime::Fits(_)) => {}
                Some(FeedInTime::TooLow(_)) => return Err(LeftReason::FeedTooSmall),
                Some(FeedInTime::TooHigh(_)) => return Err(LeftReason::FeedTooHigh),
            }
        }
        let division = Division { nodes, resolution, carries_feed };
        Ok(Some(DensifiedMotion { source: *motion, checked, division }))
    }
}

impl Task<'_, '_> {
    /// The fewest equal parts that keep every limit: the number is doubled until they do, then found by halving the
    /// interval.
    fn fewest(&self, needed: f64, effort: &mut Effort<'_>) -> Result<Vec<Node>, LeftReason> {
        if needed > f64::from(MAX_PARTS) {
            return Err(LeftReason::TooManyParts);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 1 ..= MAX_PARTS")]
        let mut holding = (needed.ceil() as u32).max(2);
        let mut failed = 1;
        let mut best = loop {
            match self.divided(holding, effort) {
                Ok(nodes) => break nodes,
                Err(reason) if holding >= MAX_PARTS => return Err(reason),
                Err(LeftReason::OutOfTravel) => return Err(LeftReason::OutOfTravel),
                Err(_) => {
                    failed = holding;
                    holding = (holding * 2).min(MAX_PARTS);
                }
            }
        };
        while failed > 1 && holding - failed > 1 + failed / 32 {
            let middle = failed + (holding - failed) / 2;
            match self.divided(middle, effort) {
                Ok(nodes) => (holding, best) = (middle, nodes),
                Err(_) => failed = middle,
            }
        }
        Ok(best)
    }

    /// The nodes of a division into this number of parts, if it keeps every limit.
    fn divided(&self, parts: u32, effort: &mut Effort<'_>) -> Result<Vec<Node>, LeftReason> {
        if effort.is_over() {
            return Err(LeftReason::TooManyParts);
        }
        let way = self.rotary_way(parts)?;
        let nodes = self.nodes(parts, &way);
        let planner = self.planner;
        let limits = planner.limits();
        let max_step_deg = planner.singularity.max_step.deg() + STEP_SLACK_DEG;
        let mut reason = None;
        for segment in segments(self.block, &nodes) {
            if rotary_steps_deg(&segment).into_iter().any(|step| step > max_step_deg) {
                return Err(LeftReason::TooManyParts);
            }
        }
        for segment in segments(self.block, &nodes) {
            if planner.is_outside(self.pending.mode, &segment.ends[1].words) {
                return Err(LeftReason::OutOfTravel);
            }
            let found = axis_deviation(self.block, &segment, &self.arc, limits.axis_tolerance_rad);
            effort.spend(found.evaluations);
            if found.sampled_rad + found.open_rad > limits.axis_tolerance_rad {
                reason = Some(LeftReason::TooManyParts);
                break;
            }
        }
        let within_mm = limits.tolerance_mm * (1.0 - RESERVE);
        if reason.is_none() && prove(self.block, &nodes, within_mm, effort).is_err() {
            reason = Some(LeftReason::DecimalsTooCoarse);
        }
        reason.map_or(Ok(nodes), Err)
    }

    /// Words of u and v \[deg\] at the nodes from 0 to `parts`.
    fn rotary_way(&self, parts: u32) -> Result<Vec<[f64; 2]>, LeftReason> {
        let kinematics = &self.planner.cutting.kinematics;
        let [u, v] = kinematics.workpiece_to_tool();
        let travel = self.planner.cutting.machine.rotary_axes()[u].travel_deg;
        let ends = self.block.ends.map(|end| [end.words.rotary_deg[u], end.words.rotary_deg[v]]);
        let rooms = self.rooms(parts, ends.map(|words| words[0])).ok_or(LeftReason::OutOfReach)?;
        let at: Vec<f64> = (0..=parts).map(f64::from).collect();
        let mut ranges: Vec<[f64; 2]> = rooms.iter().map(|room| room.range_deg).collect();
        if let Some(travel) = travel {
            let inner = parts as usize;
            for range in ranges.iter_mut().take(inner).skip(1) {
                *range = [range[0].max(travel.min), range[1].min(travel.max)];
                if range[0] > range[1] {
                    return Err(LeftReason::OutOfTravel);
                }
            }
        }
        let mut second_deg = ends[0][1];
        let way = taut_string(&at, &ranges).into_iter().enumerate().map(|(index, first_deg)| {
            second_deg = match index {
                0 => ends[0][1],
                _ if index == parts as usize => ends[1][1],
                _ => {
                    let axis = self.arc.at(at[index] / f64::from(parts));
                    kinematics.best_second_deg(axis, first_deg, second_deg)
                }
            };
            [first_deg, second_deg]
        });
        Ok(way.collect())
    }

    /// The rooms of u at the nodes. They are found node by node, from both ends towards the node nearest to the
    /// singularity. Each room continues the turn of the room before. At the nearest node the solutions meet, and
    /// whole turns too if u is free.
    fn rooms(&self, parts: u32, ends_deg: [f64; 2]) -> Option<Vec<TurningRoom>> {
        let kinematics = &self.planner.cutting.kinematics;
        let machine = self.planner.cutting.machine;
        let axes: Vec<_> = (0..=parts).map(|k| self.arc.at(f64::from(k) / f64::from(parts))).collect();
        let nearness =
            |index: usize| kinematics.singularity_at(kinematics.polar_angle_rad(axes[index])).angle_rad;
        let last = parts as usize;
        let middle = (1..last).min_by(|a, b| nearness(*a).total_cmp(&nearness(*b))).unwrap_or(1);
        let branches = self.branches(machine, [nearness(0), nearness(last)]);
        let mut rooms = vec![TurningRoom::only(ends_deg[0]); last + 1];
        rooms[last] = TurningRoom::only(ends_deg[1]);
        let mut near_deg = ends_deg[0];
        for index in 1..middle {
            rooms[index] = kinematics.turning_room(axes[index], branches[0], near_deg, self.room_rad)?;
            near_deg = follow(&rooms[index], near_deg);
        }
        near_deg = ends_deg[1];
        for index in (middle..last).rev() {
            rooms[index] = kinematics.turning_room(axes[index], branches[1], near_deg, self.room_rad)?;
            near_deg = follow(&rooms[index], near_deg);
        }
        Some(rooms)
    }

    /// The branches at both ends. An end in the singularity itself takes the other end's branch.
    fn branches(&self, machine: &crate::machine::Machine, nearness_rad: [f64; 2]) -> [Branch; 2] {
        let kinematics = &self.planner.cutting.kinematics;
        let branch = |k: usize| kinematics.branch(rotary_rad(machine, self.block.ends[k].words.rotary_deg));
        let [start, end] = [branch(0), branch(1)];
        match nearness_rad.map(|angle| angle <= self.room_rad) {
            [true, false] => [end, end],
            [false, true] => [start, start],
            _ => [start, end],
        }
    }

    /// The nodes with rounded words: the rotary words first, then X Y Z for the rounded rotary words.
    fn nodes(&self, parts: u32, way: &[[f64; 2]]) -> Vec<Node> {
        let kinematics = &self.planner.cutting.kinematics;
        let [u, v] = kinematics.workpiece_to_tool();
        let last = parts as usize;
        let mut nodes = Vec::with_capacity(last);
        for (index, words) in way.iter().enumerate().skip(1) {
            #[expect(clippy::cast_precision_loss, reason = "at most MAX_PARTS")]
            let fraction = index as f64 / f64::from(parts);
            if index == last {
                let station = self.block.ends[1];
                nodes.push(Node {
                    fraction,
                    station,
                    contact_mm: self.block.line.at_mm(1.0),
                    written_axis: None,
                });
                break;
            }
            let mut rotary_deg = [0.0; 2];
            (rotary_deg[u], rotary_deg[v]) = (words[0], words[1]);
            let (rotary_deg, written_axis) = self.resolution.turned(self.block, rotary_deg);
            let angles = rotary_rad(self.planner.cutting.machine, rotary_deg);
            let axis = kinematics.axis(angles);
            let offset_mm = self.block.carry.at(&self.block.tool, fraction, axis).offset_mm;
            let contact_mm = self.block.line.at_mm(fraction);
            let tip_mm = contact_mm - offset_mm;
            let exact = match self.pending.mode {
                Interpolation::Machine => kinematics.linear_mm(tip_mm, angles),
                Interpolation::Tcp => tip_mm,
            };
            let linear_mm = self.resolution.linear_mm(exact.into());
            let words = AxisWords { linear_mm, rotary_deg };
            let station: Station = self.planner.station(self.pending.mode, words);
            nodes.push(Node { fraction, station, contact_mm, written_axis });
        }
        nodes
    }
}

/// The middle of a room, which determines the turn of the next room. A free room determines nothing.
fn follow(room: &TurningRoom, near_deg: f64) -> f64 {
    if room.is_free() { near_deg } else { 0.5 * (room.range_deg[0] + room.range_deg[1]) }
}
