//! Straight pieces of motion, and batches of them.

use super::boxes::AxisBox;
use super::section::{Run, Section};
use crate::contact::CutterBody;
use crate::geometry::{Mat3, Vec3, across};
use crate::kinematics::ToolPose;

/// A piece of motion between two poses, taken as straight in the frame of the tool.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sweep {
    tips_mm: [Vec3; 2],
    /// From W into the frame of the tool, which follows the axis but does not turn about it.
    to_tool: [Mat3; 2],
    /// The corner's centre on the axis, half way \[mm\].
    middle_mm: Vec3,
    /// The axis half way; its length is 1 except for the turn.
    axis: Vec3,
    /// Largest distance of any point of the cutter from its position half way \[mm\].
    half_travel_mm: f64,
    /// Chord of the turn of the axis.
    turn: f64,
    pub(super) line: u64,
    pub(super) by_rapid: bool,
}

impl Sweep {
    fn new(body: &CutterBody, poses: [&ToolPose; 2], line: u64, by_rapid: bool) -> Self {
        let [from, to] = poses;
        let tips_mm = [from.tip_mm, to.tip_mm];
        let start = frame(from.axis);
        let to_tool =
            if from.axis == to.axis { [start; 2] } else { [start, carried(&start, from.axis, to.axis)] };
        let axis = (from.axis + to.axis) * 0.5;
        let turn = (to.axis - from.axis).norm();
        let reach_mm = body.cutting_length_mm() + body.radius_mm();
        Self {
            tips_mm,
            to_tool,
            middle_mm: (from.tip_mm + to.tip_mm) * 0.5 + axis * body.corner_radius_mm(),
            axis,
            half_travel_mm: (0.5 + turn) * (to.tip_mm - from.tip_mm).norm() + turn * reach_mm,
            turn,
            line,
            by_rapid,
        }
    }

    /// A point fixed in W, in the tool's frame at both ends.
    #[inline]
    fn seen_mm(&self, point_mm: Vec3) -> [Vec3; 2] {
        // Written out, because a closure for both is not always inlined.
        let [first, second] = &self.to_tool;
        [first * (point_mm - self.tips_mm[0]), second * (point_mm - self.tips_mm[1])]
    }

    /// The needle of a sample, in the tool's frame at both ends.
    #[inline]
    pub(super) fn section(&self, point_mm: Vec3, normal: Vec3) -> Section {
        let first = self.to_tool[0] * normal;
        let along = [first, if self.is_parallel() { first } else { self.to_tool[1] * normal }];
        Section { at_mm: self.seen_mm(point_mm), along }
    }

    #[inline]
    fn is_parallel(&self) -> bool {
        self.to_tool[0] == self.to_tool[1]
    }

    /// A lower bound of the distance between a point and the cutter along the piece \[mm\]; `None` if the distance
    /// is certainly more than `enough_mm`.
    #[inline]
    pub(super) fn nearness_mm(&self, body: &CutterBody, point_mm: Vec3, enough_mm: f64) -> Option<f64> {
        // The cutter is within R of its axis between the corner's centre and its top.
        let from_centre = point_mm - self.middle_mm;
        let length_mm = body.cutting_length_mm() - body.corner_radius_mm();
        let along = from_centre.dot(&self.axis).clamp(0.0, length_mm);
        let reach_mm = body.radius_mm() + self.half_travel_mm + enough_mm * (1.0 + self.turn);
        if (from_centre - self.axis * along).norm_squared() > reach_mm * reach_mm {
            return None;
        }
        let bound_mm = Run::new(self.seen_mm(point_mm)).lower_bound_mm(body, enough_mm);
        (bound_mm < enough_mm).then_some(bound_mm)
    }
}

/// Rows: two unit vectors across the axis, and the axis.
fn frame(axis: Vec3) -> Mat3 {
    let least = if axis.x.abs() < 0.6 { Vec3::x() } else { Vec3::y() };
    let x = across(least, axis).normalize();
    rows(x, axis.cross(&x), axis)
}

/// The frame after the shortest turn from one axis to another.
fn carried(start: &Mat3, from: Vec3, to: Vec3) -> Mat3 {
    let both = from + to;
    // Opposite axes have no shortest turn, but no piece turns that far.
    let scale = 1.0 / (1.0 + from.dot(&to)).max(1e-9);
    let [x, y] = [0, 1].map(|k| {
        let old: Vec3 = start.row(k).transpose();
        old - both * (old.dot(&to) * scale)
    });
    rows(x, y, to)
}

fn rows(x: Vec3, y: Vec3, z: Vec3) -> Mat3 {
    Mat3::from_columns(&[x, y, z]).transpose()
}

/// The box around the cutter at a pose.
fn box_of(body: &CutterBody, pose: &ToolPose) -> AxisBox {
    // Extent of a disc of radius 1 across the axis, along x, y and z.
    let reach = pose.axis.map(|part| (1.0 - part * part).max(0.0).sqrt());
    let (corner_mm, core_mm, radius_mm) = (body.corner_radius_mm(), body.core_radius_mm(), body.radius_mm());
    let corner = pose.tip_mm + pose.axis * corner_mm;
    let top = pose.tip_mm + pose.axis * body.cutting_length_mm();
    let bottom = (reach * core_mm).add_scalar(corner_mm);
    let flank = reach * radius_mm;
    let mut found = AxisBox { low_mm: corner - bottom, high_mm: corner + bottom };
    for centre in [corner, top] {
        found.join(&AxisBox { low_mm: centre - flank, high_mm: centre + flank });
    }
    found
}

/// Pieces in one group: consecutive ones, which are mostly close together.
const GROUP: usize = 16;

/// A batch of pieces in the order of the program, with boxes around them and around groups of them.
#[derive(Debug, Clone, Default)]
pub struct SweepBatch {
    pub(super) sweeps: Vec<Sweep>,
    pub(super) boxes: Vec<AxisBox>,
    groups: Vec<AxisBox>,
}

impl SweepBatch {
    /// Number of pieces worth cutting with together.
    pub const FULL: usize = 16_384;

    /// An empty batch.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a piece of motion between two poses. `slack_mm` is the largest distance, for the cutter's farthest
    /// point, between the true motion and the motion that is straight in the frame of the tool.
    pub fn push(
        &mut self,
        body: &CutterBody,
        poses: [&ToolPose; 2],
        slack_mm: f64,
        line: u64,
        by_rapid: bool,
    ) {
        let mut around = box_of(body, poses[0]);
        around.join(&box_of(body, poses[1]));
        // A turning axis bulges out between the ends, by less than the slack.
        let slack = Vec3::repeat(4.0 * slack_mm);
        let around = AxisBox { low_mm: around.low_mm - slack, high_mm: around.high_mm + slack };
        if self.sweeps.len().is_multiple_of(GROUP) {
            self.groups.push(AxisBox::NOTHING);
        }
        if let Some(group) = self.groups.last_mut() {
            group.join(&around);
        }
        self.sweeps.push(Sweep::new(body, poses, line, by_rapid));
        self.boxes.push(around);
    }

    /// Number of pieces.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sweeps.len()
    }

    /// Whether it has no pieces.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sweeps.is_empty()
    }

    /// Removes all pieces.
    pub fn clear(&mut self) {
        self.sweeps.clear();
        self.boxes.clear();
        self.groups.clear();
    }

    /// The groups that meet a box, and the number of boxes compared.
    pub(super) fn groups_at(&self, around: &AxisBox, found: &mut Vec<usize>) -> u64 {
        found.clear();
        found.extend((0..self.groups.len()).filter(|&index| self.groups[index].meets(around)));
        self.groups.len() as u64
    }

    /// Number of boxes that [`Self::pieces_at`] compares.
    pub(super) fn boxes_looked_at(&self, groups: &[usize], around: &AxisBox) -> u64 {
        let met = groups.iter().filter(|&&group| self.groups[group].meets(around)).count();
        (groups.len() + met * GROUP) as u64
    }

    /// The pieces of some groups that meet a box.
    pub(super) fn pieces_at<'a>(
        &'a self,
        groups: &'a [usize],
        around: &'a AxisBox,
    ) -> impl Iterator<Item = usize> + 'a {
        groups
            .iter()
            .filter(move |&&group| self.groups[group].meets(around))
            .flat_map(|&group| group * GROUP..((group + 1) * GROUP).min(self.boxes.len()))
            .filter(move |&index| self.boxes[index].meets(around))
    }
}
