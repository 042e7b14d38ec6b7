//! Cycles that state all parameters of one hole, as the motions that they are: to the clearance above the surface,
//! down, and up to the end. `CYCLE81(…)` runs at once, `MCALL CYCLE81(…)` at the end of every motion, and `CYCL DEF 200`
//! where it is called.
//!
//! Chip breaking and pecking are one stroke, as for the cycles of ISO programs. Dwells are no motions.

use super::block_words::AXES;
use super::cycle::{HoleCycle, HoleLevels, HoleStroke};
use super::execute::Action;
use super::interpreter::Interpreter;
use super::modal::{ModalFeed, ToolLength};
use super::tilted_plane::place_in;
use super::travel::VECTORS;
use super::{Feed, FeedMode, Motion, MotionKind, Unfollowable};
use crate::program::{Address, Block, Code, Keyword};

/// The words of the parameters.
const HOLE_WORDS: u32 = Address::P.bit()
    | Address::Q.bit()
    | Address::K.bit()
    | Address::R.bit()
    | Address::I.bit()
    | Address::J.bit()
    | Address::H.bit()
    | Address::S.bit()
    | Address::L.bit();
/// Words beside them on which no place depends.
const BESIDE: u32 = Address::N.bit() | Address::F.bit();
/// Levels this close are one \[mm\]: programs in inches have at most five decimals.
const SAME_LEVEL_MM: f64 = 1e-6;
const LINEAR: u32 = Address::X.bit() | Address::Y.bit() | Address::Z.bit();

impl Interpreter {
    /// The hole that the words of the block state, [`HoleCycle::OTHER`] if it is not followed.
    pub(super) fn stated_hole(&self) -> HoleCycle {
        self.hole_of_words().unwrap_or(HoleCycle::OTHER)
    }

    fn hole_of_words(&self) -> Option<HoleCycle> {
        let words = &self.block;
        let rules = self.rules.holes?;
        let mm_per_unit = self.modal.mm_per_unit?;
        let stated = words.present & HOLE_WORDS;
        let is_known = words.g_codes().contains(&Code::Keyword(Keyword::Hole))
            && (words.unknown | words.absolute | words.incremental) & stated == 0;
        if !is_known || !self.options.as_it_runs {
            return None;
        }
        let number = |address: Address| words.value(address);
        let length = |address: Address| number(address).map(|value| value * mm_per_unit);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small whole number")]
        let stroke = (rules.stroke)(number(Address::P)? as u32);
        let surface_mm = length(Address::Q)?;
        let clearance_mm = length(Address::K).unwrap_or(0.0);
        let below_mm = length(Address::J);
        let (depth_mm, end_mm) = match rules.levels {
            HoleLevels::Planes => {
                let end_mm = length(Address::R)?;
                (depth_of(surface_mm, end_mm, length(Address::I), below_mm)?, end_mm)
            }
            HoleLevels::Clearances => {
                let second_mm = length(Address::R).filter(|second_mm| *second_mm >= 0.0)?;
                number(Address::K)?;
                (surface_mm + below_mm?, surface_mm + clearance_mm.max(second_mm))
            }
        };
        let plane_mm = surface_mm + clearance_mm;
        let lowest_end_mm = match stroke {
            HoleStroke::Bore | HoleStroke::Ream | HoleStroke::Tap => plane_mm,
            HoleStroke::Drill | HoleStroke::Other => surface_mm,
        };
        let is_sound = clearance_mm >= 0.0
            && depth_mm < surface_mm - SAME_LEVEL_MM
            && end_mm >= lowest_end_mm - SAME_LEVEL_MM;
        if !is_sound {
            return None;
        }
        let axis = match number(Address::H) {
            None => None,
            Some(plane) => [(1.0, 2), (2.0, 1), (3.0, 0)]
                .into_iter()
                .find_map(|(named, axis)| ((plane - named).abs() <= 0.0).then_some(Some(axis)))?,
        };
        let feeds = self.feeds_of_words(rules.levels, stroke)?;
        Some(HoleCycle { stroke, plane_mm, depth_mm, end_mm, feeds, mm_per_unit, axis })
    }

    /// The feeds of a cycle down and up; `None` if they are missing. A feed up of 0 is the feed down where clearances
    /// state the hole.
    #[expect(
        clippy::option_option,
        reason = "a cycle without feeds of its own, and a cycle without its feeds"
    )]
    fn feeds_of_words(&self, levels: HoleLevels, stroke: HoleStroke) -> Option<Option<[(f64, u8); 2]>> {
        let feed = |address: Address| {
            self.block.value(address).map(|value| (value, self.block.decimals[address.index()]))
        };
        let has_own = match (levels, stroke) {
            (_, HoleStroke::Ream) => true,
            (_, HoleStroke::Tap) => self.block.has(Address::S),
            (HoleLevels::Clearances, stroke) => stroke == HoleStroke::Drill,
            (HoleLevels::Planes, _) => false,
        };
        if !has_own {
            return Some(None);
        }
        let down = feed(Address::S).filter(|(value, _)| *value > 0.0)?;
        let up = match stroke {
            HoleStroke::Ream => feed(Address::L)?,
            HoleStroke::Tap => feed(Address::L).unwrap_or(down),
            _ => down,
        };
        let is_same = up.0.abs() <= 0.0 && levels == HoleLevels::Clearances;
        let up = if is_same { down } else { up };
        (up.0 > 0.0).then_some(Some([down, up]))
    }

    /// `CYCL DEF 200`: the cycle waits for its call.
    pub(super) fn define_hole(&mut self) -> Action {
        self.modal.hole = Some(self.stated_hole());
        Action::Consume
    }

    /// `CYCLE81(…)`: the cycle runs here.
    pub(super) fn run_hole(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) {
        self.set_feed();
        let hole = self.stated_hole();
        let is_alone = self.block.present & !(HOLE_WORDS | BESIDE) == 0 && reason.is_none();
        if is_alone && self.make_hole(index, block, hole, motions) {
            return;
        }
        self.position.forget_axes();
        self.opaque(index, block, Unfollowable::CannedCycle, motions);
        self.forget_named(self.block.present);
    }

    /// `MCALL CYCLE81(…)`: the cycle runs at the end of every motion from here on.
    pub(super) fn begin_modal_hole(&mut self) -> Action {
        self.set_feed();
        let is_alone = self.block.present & (AXES | VECTORS) == 0;
        let is_followed = self.options.as_it_runs && is_alone;
        self.modal.macro_call = Some(true);
        self.modal.hole_at_motions = self.options.as_it_runs;
        self.modal.hole = is_followed.then(|| self.stated_hole());
        if !is_followed {
            self.position.forget_axes();
        }
        if is_alone { Action::Consume } else { Action::Odd(Unfollowable::ConflictingCodes) }
    }

    /// `MCALL` alone. After a cycle of one hole the position is known.
    pub(super) fn end_modal_call(&mut self) {
        self.modal.macro_call = Some(false);
        if std::mem::take(&mut self.modal.hole_at_motions) {
            self.modal.hole = None;
        } else {
            self.position.forget_all();
        }
    }

    /// A block while a cycle runs at the end of every motion. Only of a block with X, Y or Z it is certain that the
    /// cycle runs after it.
    #[cold]
    pub(super) fn move_to_hole(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) {
        let runs = self.modal.macro_call == Some(true);
        if runs {
            self.modal.macro_call = Some(false);
            self.find_obstacle();
        }
        let before = motions.len();
        self.move_by_words(index, block, reason, motions);
        let made = motions.get(before..).unwrap_or_default();
        if !runs && !made.is_empty() {
            // It may have run.
            self.position.forget_linear();
        }
        if runs && !made.is_empty() {
            let is_followed = made.iter().all(|motion| motion.unfollowable.is_none());
            let hole = self.modal.hole.unwrap_or(HoleCycle::OTHER);
            let names_place = self.block.present & LINEAR != 0;
            if !(is_followed && names_place && self.make_hole(index, block, hole, motions)) {
                self.opaque(index, block, Unfollowable::CannedCycle, motions);
                self.position.forget_linear();
            }
        }
        if runs {
            self.modal.macro_call = Some(true);
            self.find_obstacle();
        }
    }

    /// The action of a block at whose end a cycle runs. If the cycle is followed, the block moves as it says.
    pub(super) fn action_at_call(&mut self, action: Option<Action>) -> Option<Action> {
        let may_move = matches!(action, None | Some(Action::Consume));
        let is_defined = self.options.as_it_runs && self.modal.hole.is_some() && !self.modal.hole_at_motions;
        self.this_block.makes_hole = may_move && is_defined;
        if self.this_block.makes_hole || !may_move {
            action
        } else {
            Some(Action::Odd(Unfollowable::CannedCycle))
        }
    }

    /// The end of a block: the defined cycle makes its hole, if the block calls it. After a block that moves in another
    /// way while a cycle runs at every motion, the place is not known.
    pub(super) fn end_with_hole(
        &mut self,
        index: usize,
        block: &Block,
        action: Option<Action>,
        before: usize,
        motions: &mut Vec<Motion>,
    ) {
        let made = motions.get(before..).unwrap_or_default();
        if self.this_block.makes_hole {
            let is_followed = made.iter().all(|motion| motion.unfollowable.is_none());
            let hole = self.modal.hole.unwrap_or(HoleCycle::OTHER);
            if is_followed && self.make_hole(index, block, hole, motions) {
                self.this_block.runs_cycle = false;
            } else {
                self.opaque(index, block, Unfollowable::CannedCycle, motions);
            }
        } else if self.modal.hole_at_motions && action.is_some() && !made.is_empty() {
            self.position.forget_linear();
        }
    }

    /// Makes the hole at the present place. Returns false, and changes nothing, if it is not followed.
    fn make_hole(&mut self, index: usize, block: &Block, hole: HoleCycle, motions: &mut Vec<Motion>) -> bool {
        let HoleCycle { stroke, plane_mm, depth_mm, end_mm, feeds, .. } = hole;
        let axis = self.modal.plane.filter(|plane| hole.axis.is_none_or(|axis| axis == *plane));
        let (Some(axis), Some(place_mm)) = (axis.map(usize::from), self.position.linear_mm()) else {
            return false;
        };
        let is_above = place_mm.get(axis).is_some_and(|at_mm| *at_mm >= plane_mm - SAME_LEVEL_MM);
        if stroke == HoleStroke::Other || !is_above || !self.may_make(hole) {
            return false;
        }
        let at = |level_mm: f64| {
            let mut there_mm = place_mm;
            if let Some(level) = there_mm.get_mut(axis) {
                *level = level_mm;
            }
            there_mm
        };
        let up = if stroke == HoleStroke::Drill {
            (MotionKind::Rapid, end_mm, 1)
        } else {
            (MotionKind::Linear, plane_mm, 1)
        };
        let course = [
            (MotionKind::Rapid, plane_mm, 0),
            (MotionKind::Linear, depth_mm, 0),
            up,
            (MotionKind::Rapid, end_mm, 1),
        ];
        for (kind, level_mm, which) in course {
            let to_mm = at(level_mm);
            if self.position.linear_mm() == Some(to_mm) {
                continue;
            }
            let mut motion = self.motion_shell(index, block, kind);
            let counts = stroke != HoleStroke::Tap || self.modal.feed_mode() == Some(FeedMode::PerMinute);
            match feeds.filter(|_| counts && kind == MotionKind::Linear) {
                Some(own) => motion.feed = self.feed_as_written(own[which], hole.mm_per_unit),
                None if stroke == HoleStroke::Tap => motion.feed = motion.feed.unknown(),
                None => {}
            }
            let start = self.position.axis_words();
            motion.start = start;
            self.stand_at(to_mm);
            motion.end = self.position.axis_words();
            motion.linear_end_mm = Some(to_mm);
            if let Some(frame) = self.plane_in_force() {
                place_in(frame, &mut motion);
            } else if self.modal.turn.is_some() {
                self.turn_ends(&mut motion, start);
            }
            self.note_offset(&mut motion);
            motions.push(motion);
        }
        let has_own = feeds.is_some() || stroke == HoleStroke::Tap;
        if has_own && !self.rules.holes.is_some_and(|rules| rules.keeps_feed) {
            self.modal.feed = ModalFeed::Unknown;
        }
        true
    }

    /// Whether the state of the control leaves no doubt about the motions of a hole.
    fn may_make(&self, hole: HoleCycle) -> bool {
        let modal = &self.modal;
        let is_turned = modal.turn.is_some() && modal.obstacle_beside_turn().is_none();
        let is_clear = self.obstacle().is_none() || self.plane_in_force().is_some() || is_turned;
        let [.., first, second] = self.position.axes;
        let is_along_axis = match modal.tool_length {
            Some(ToolLength::Plain) => true,
            Some(ToolLength::Tcp) => {
                self.rules.holes.is_some_and(|rules| rules.under_tcp) && first.and(second).is_some()
            }
            _ => false,
        };
        let counts = match modal.feed_mode() {
            Some(FeedMode::PerMinute) => true,
            Some(FeedMode::PerRevolution) => hole.feeds.is_none() || hole.stroke == HoleStroke::Tap,
            Some(FeedMode::InverseTime) | None => false,
        };
        is_clear
            && counts
            && is_along_axis
            && modal.compensation == Some(false)
            && modal.mm_per_unit == Some(hole.mm_per_unit)
            && !self.corner_open
    }

    fn feed_as_written(&self, (raw, decimals): (f64, u8), mm_per_unit: f64) -> Feed {
        Feed {
            mode: self.modal.feed_mode(),
            value: Some(raw * mm_per_unit),
            raw,
            decimals,
            paths: self.rules.feed.paths,
            word_in_block: true,
        }
    }
}

/// The depth of a hole as a coordinate \[mm\], from its coordinate and from its distance below the surface. If both are
/// stated they have to agree. Controls take a distance of 0 as not stated, and none if the retract plane is the surface.
fn depth_of(surface_mm: f64, end_mm: f64, at_mm: Option<f64>, below_mm: Option<f64>) -> Option<f64> {
    let below_mm = below_mm.filter(|below_mm| below_mm.abs() > 0.0);
    match (at_mm, below_mm) {
        (at_mm, None) => at_mm,
        (at_mm, Some(below_mm)) => {
            let depth_mm = surface_mm - below_mm;
            let other_mm = at_mm.filter(|at_mm| at_mm.abs() > 0.0).unwrap_or(depth_mm);
            let is_certain =
                end_mm > surface_mm + SAME_LEVEL_MM && (other_mm - depth_mm).abs() <= SAME_LEVEL_MM;
            is_certain.then_some(depth_mm)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_depth_is_a_coordinate_or_a_distance_and_both_have_to_agree() {
        let rows = [
            (Some(-5.0), None, Some(-5.0)),
            (Some(-5.0), Some(0.0), Some(-5.0)),
            (Some(0.0), Some(7.0), Some(-5.0)),
            (None, Some(7.0), Some(-5.0)),
            (Some(-5.0), Some(7.0), Some(-5.0)),
            (Some(-5.0), Some(8.0), None),
            (None, None, None),
            (None, Some(0.0), None),
        ];
        for (at_mm, below_mm, expected) in rows {
            assert_eq!(depth_of(2.0, 10.0, at_mm, below_mm), expected, "{at_mm:?} {below_mm:?}");
        }
        assert_eq!(depth_of(2.0, 2.0, None, Some(7.0)), None, "the retract plane is the surface");
        assert_eq!(depth_of(2.0, 2.0, Some(-5.0), None), Some(-5.0));
    }
}
