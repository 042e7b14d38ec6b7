//! Drilling cycles of cutter location data, as the motions that they are: across to the point's axis, down to the height
//! above the point, down at feed, and back up along the tool axis.
//!
//! A point is the mouth of a hole. The tool axis points out of it.

use super::cycle::PointCycle;
use super::interpreter::Interpreter;
use super::modal::ToolLength;
use super::travel::{CONTACTS, VECTORS};
use super::{Feed, Motion, MotionKind, Unfollowable};
use crate::geometry::Vec3;
use crate::program::{Address, Block, Code, Keyword};

/// Places this close are one \[mm\].
const SAME_PLACE_MM: f64 = 1e-6;
/// Tool axes this close are one \[length of the difference\].
const SAME_AXIS: f64 = 1e-6;
const PLACE: u32 = Address::X.bit() | Address::Y.bit() | Address::Z.bit();

impl Interpreter {
    /// `CYCLE/…`, or its end.
    pub(super) fn begin_point_cycle(&mut self, on: bool) {
        self.modal.in_cycle = on;
        self.modal.point_cycle = if on { self.stated_point_cycle() } else { None };
    }

    /// The cycle that the words of the block state, if its distances make sense.
    fn stated_point_cycle(&self) -> Option<PointCycle> {
        let mm_per_unit = self.modal.mm_per_unit?;
        let word = |address: Address| self.block.value(address);
        let length = |address: Address| word(address).map(|value| value * mm_per_unit);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small whole number")]
        let unit = Keyword::of_number(word(Address::H)? as u16)?;
        self.rules.feed.mode(Code::Keyword(unit))?;
        let pecks_mm = length(Address::P).map(|first| [first, length(Address::K).unwrap_or(first)]);
        let cycle = PointCycle {
            plane_mm: length(Address::R)?,
            // Some systems state the depth as a coordinate along the axis, below zero.
            depth_mm: length(Address::D)?.abs(),
            retract_mm: length(Address::Q)?,
            pecks_mm,
            feed: word(Address::S)?,
            feed_decimals: self.block.decimals[Address::S.index()],
            feed_unit: unit,
        };
        let is_sound = cycle.plane_mm >= 0.0
            && cycle.depth_mm > 0.0
            && cycle.retract_mm >= cycle.plane_mm
            && cycle.feed > 0.0
            && cycle.pecks_mm.is_none_or(|pecks| pecks.iter().all(|peck| *peck > SAME_PLACE_MM));
        is_sound.then_some(cycle)
    }

    /// Follows the cycle at the point of a block. Returns false, and changes nothing, if it is not followed.
    pub(super) fn follow_point_cycle(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) -> bool {
        let words = &self.block;
        let Some(cycle) = self.modal.point_cycle.filter(|_| self.options.as_it_runs) else { return false };
        let Some(bottoms_mm) = cycle.bottoms_mm() else { return false };
        let further = u32::try_from(bottoms_mm.len()).unwrap_or(u32::MAX) - 1;
        let is_certain = reason.is_none()
            && matches!(self.obstacle(), None | Some(Unfollowable::ToolVector))
            && self.modal.tool_length == Some(ToolLength::Vector)
            && words.present & PLACE == PLACE
            && words.present & !(PLACE | VECTORS) == 0
            && words.present & CONTACTS == 0
            && (words.unknown | words.incremental) & words.present == 0
            && self.may_repeat(further);
        let before = self.position;
        let (Some(from_mm), Some(from_axis)) = (before.linear_mm(), before.tool_axis()) else { return false };
        if !is_certain {
            return false;
        }
        self.take_axis_words();
        let course = self.course_of(cycle, &bottoms_mm, from_mm.into(), from_axis.into());
        let (Some(course), Some(axis)) = (course, self.position.tool_axis()) else {
            self.position = before;
            return false;
        };
        self.further_strokes += further;
        let feed = self.feed_of(cycle);
        let mut at = (from_mm, from_axis);
        for (kind, to) in course {
            let to_mm: [f64; 3] = to.into();
            if (to - Vec3::from(at.0)).norm() <= SAME_PLACE_MM {
                continue;
            }
            let mut motion = self.motion_shell(index, block, kind);
            if kind == MotionKind::Linear {
                motion.feed = feed;
            }
            motion.vector_start = Some(at);
            motion.linear_end_mm = Some(to_mm);
            motion.tool_axis = Some(axis);
            motion.unfollowable = Some(Unfollowable::ToolVector);
            self.note_offset(&mut motion);
            motions.push(motion);
            at = (to_mm, axis);
        }
        for (slot, to_mm) in self.position.axes.iter_mut().zip(at.0) {
            *slot = Some(to_mm);
        }
        true
    }

    /// The motions of the cycle at the point where the words of the block stand; `None` if the tool axis turns on the
    /// way or the tool comes from below the height at which the feed begins.
    fn course_of(
        &self,
        cycle: PointCycle,
        bottoms_mm: &[f64],
        from_mm: Vec3,
        from_axis: Vec3,
    ) -> Option<Vec<(MotionKind, Vec3)>> {
        let mouth_mm = Vec3::from(self.position.linear_mm()?);
        let axis = Vec3::from(self.position.tool_axis()?).try_normalize(f64::EPSILON)?;
        let was = from_axis.try_normalize(f64::EPSILON)?;
        let above_mm = (from_mm - mouth_mm).dot(&axis);
        if (axis - was).norm() > SAME_AXIS || above_mm < cycle.plane_mm - SAME_PLACE_MM {
            return None;
        }
        let at = |height_mm: f64| mouth_mm + axis * height_mm;
        let plane_mm = at(cycle.plane_mm);
        let mut course = vec![(MotionKind::Rapid, at(above_mm)), (MotionKind::Rapid, plane_mm)];
        for bottom_mm in bottoms_mm {
            course.push((MotionKind::Linear, at(-bottom_mm)));
            course.push((MotionKind::Rapid, plane_mm));
        }
        // The last way up goes to the height of retraction at once.
        course.pop();
        course.push((MotionKind::Rapid, at(cycle.retract_mm)));
        Some(course)
    }

    fn feed_of(&self, cycle: PointCycle) -> Feed {
        let mm_per_unit = self.modal.mm_per_unit.unwrap_or(1.0);
        let (mode, own_mm) = self.rules.feed.mode(Code::Keyword(cycle.feed_unit)).unzip();
        let value = cycle.feed * own_mm.flatten().unwrap_or(mm_per_unit);
        Feed {
            mode,
            value: mode.map(|_| value),
            raw: value / mm_per_unit,
            decimals: cycle.feed_decimals,
            paths: self.rules.feed.paths,
            word_in_block: true,
        }
    }
}
