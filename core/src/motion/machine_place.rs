//! Motions in machine coordinates and to reference positions, on a machine whose owner states where these are.
//!
//! A control that reads G53 or SUPA moves its axes to the stated places, whatever the work offset is. The words of the
//! program at such a place follow from the stated zero of the machine, the work offset and the length of the tool in
//! the spindle. Only operations that read a program as it runs do this.

use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::meaning::MFunction;
use super::modal::{ACROSS_G17, MotionMode, ToolLength};
use super::{AxisWords, Interpolation, Motion, MotionKind, ToolKey, Unfollowable};
use crate::geometry::{PlaneFrame, Turn};
use crate::program::{Address, Block, Code, Keyword};

/// Z, along the tool with every axis at zero.
const Z: usize = 2;
/// Words that a block in machine coordinates may have besides its codes.
const WORDS: u32 = AXES
    | Address::F.bit()
    | Address::S.bit()
    | Address::N.bit()
    | Address::T.bit()
    | Address::D.bit()
    | Address::H.bit();
const LINEAR: u32 = Address::X.bit() | Address::Y.bit() | Address::Z.bit();
/// G28, and G30 with the number of the position in P.
const FIRST_REFERENCE: Code = Code::G(280);
const NUMBERED_REFERENCE: Code = Code::G(300);

/// Where an axis of the program ends.
#[derive(Debug, Clone, Copy)]
enum AxisEnd {
    /// Where it is.
    Stays,
    /// At this word \[mm, deg\].
    At(f64),
    /// At a word that depends on a length that is not known.
    Unknown,
}

impl Interpreter {
    /// The block after G53, SUPA or M91. Returns false, and changes nothing, if the motion is not followed.
    pub(super) fn move_in_machine(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) -> bool {
        let kind = match self.modal.motion {
            Some(MotionMode::Rapid) => MotionKind::Rapid,
            Some(MotionMode::Linear) => MotionKind::Linear,
            _ => return false,
        };
        let words = &self.block;
        let present = words.present;
        let turns = present & (AXES & !LINEAR) != 0;
        let is_certain = self.this_block.from_machine_zero
            && !self.this_block.from_other_zero
            && !self.changes_tool()
            && !(turns && (self.modal.shortest_path || self.modal.rotary_feed_in_mm))
            && reason.is_none()
            && present & AXES != 0
            && present & !WORDS == 0
            && present & self.axes.foreign().bit() == 0
            && (words.unknown | words.incremental) & present == 0
            && words.comma == 0
            && self.modal.incremental == Some(false);
        let Some(scale) = self.modal.mm_per_unit.filter(|_| is_certain) else { return false };
        let mut targets = [None; 5];
        for (slot, address) in self.axes.all().into_iter().enumerate() {
            targets[slot] = words.value(address).map(|value| if slot < 3 { value * scale } else { value });
        }
        let Some(ends) = self.words_in_machine(targets, self.counts_length()) else { return false };
        for (slot, address) in self.axes.all().into_iter().enumerate() {
            if targets[slot].is_some() {
                self.position.decimals[slot] = self.block.decimals[address.index()];
            }
        }
        let mut motion = self.motion_shell(index, block, kind);
        self.stand_in_machine(ends, &mut motion);
        motions.push(motion);
        true
    }

    /// The way of the named axes to the reference position of G28 or G30, after the point of their words. Returns
    /// false, and changes nothing, if it is not followed.
    pub(super) fn move_to_reference(
        &mut self,
        index: usize,
        block: &Block,
        motions: &mut Vec<Motion>,
    ) -> bool {
        let Some(mut targets) = self.reference_in_machine() else { return false };
        let all_go = self.all_go_home();
        for (target, address) in targets.iter_mut().zip(self.axes.all()) {
            let is_named = all_go || self.block.has(address);
            if is_named && target.is_none() {
                return false;
            }
            *target = target.filter(|_| is_named);
        }
        let Some(mut ends) = self.words_in_machine(targets, Some(false)) else { return false };
        if self.changes_tool() {
            // The change moves axes too, before this motion or after it.
            ends[..3].fill(AxisEnd::Unknown);
        }
        let mut motion = self.motion_shell(index, block, MotionKind::Rapid);
        self.stand_in_machine(ends, &mut motion);
        motions.push(motion);
        true
    }

    /// After G28 or G30 whose way is not certain: if the reference position is stated, the named axes are there
    /// anyway.
    pub(super) fn arrive_at_reference(&mut self, reason: Option<Unfollowable>) {
        let is_certain = self.rules.reference_passes_point
            && reason.is_none()
            && !self.changes_tool()
            && self.block.present & self.axes.foreign().bit() == 0
            && self.block.comma == 0;
        let Some(targets) = self.reference_in_machine().filter(|_| is_certain) else { return };
        let mut named = targets;
        for (target, address) in named.iter_mut().zip(self.axes.all()) {
            *target = target.filter(|_| self.block.has(address));
        }
        let Some(ends) = self.words_in_machine(named, Some(false)) else { return };
        for (axis, end) in self.position.axes.iter_mut().zip(ends) {
            if let AxisEnd::At(word) = end {
                *axis = Some(word);
            }
        }
    }

    /// `M140 MB MAX`: back along the tool to the end of the travel, on a machine whose tool is always along Z. In a plane
    /// and under tool-centre-point control the words of that place are not known. Returns false, and changes nothing, if
    /// the motion is not followed.
    pub(super) fn retract_to_limit(
        &mut self,
        index: usize,
        block: &Block,
        motions: &mut Vec<Motion>,
    ) -> bool {
        let has = |keyword| self.block.g_codes().contains(&Code::Keyword(keyword));
        let is_rapid = has(Keyword::RetractToLimit);
        let is_certain = (is_rapid || has(Keyword::RetractToLimitAtFeed))
            && self.options.as_it_runs
            && !self.axes.has_head_axis()
            && self.block.present & AXES == 0
            && self.modal.compensation == Some(false)
            && !self.changes_tool()
            && !self.modal.is_lost;
        let limit_mm = self.machine_coordinates.as_ref().and_then(|stated| stated.retract_z_mm);
        let Some(limit_mm) = limit_mm.filter(|_| is_certain) else { return false };
        let targets = [None, None, Some(limit_mm), None, None];
        let ends = self.words_in_machine(targets, Some(false)).unwrap_or([
            AxisEnd::Unknown,
            AxisEnd::Unknown,
            AxisEnd::Unknown,
            AxisEnd::Stays,
            AxisEnd::Stays,
        ]);
        let kind = if is_rapid { MotionKind::Rapid } else { MotionKind::Linear };
        let mut motion = self.motion_shell(index, block, kind);
        // F holds for this motion alone.
        motion.feed = motion.feed.unknown();
        self.stand_in_machine(ends, &mut motion);
        motions.push(motion);
        true
    }

    /// Whether G28 or G30 without words of axes sends all axes to the reference position directly.
    pub(super) fn all_go_home(&self) -> bool {
        self.is_rs274 && self.block.present & !Address::N.bit() == 0
    }

    /// G28.1 stores the place of the axes.
    pub(super) fn store_reference(&mut self) {
        let is_certain = self.options.as_it_runs
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.options.interpolation != Some(Interpolation::Tcp)
            && self.block.present & !Address::N.bit() == 0;
        let place = || {
            let zero_mm = self.machine_coordinates.as_ref()?.zero_mm;
            let (origin_mm, length_mm) = (self.origin_mm()?, self.length_mm()?);
            let [Some(x), Some(y), Some(z), Some(first), Some(second)] = self.position.axes else {
                return None;
            };
            let [x, y, z] = self.modal.turn.map_or([x, y, z], |turn| turn.of([x, y, z]));
            let tip_mm = [x, y, z + length_mm];
            let [x, y, z] = std::array::from_fn(|k| tip_mm[k] + origin_mm[k] - zero_mm[k]);
            Some([x, y, z, first, second])
        };
        self.zeros.home = Some(place().filter(|_| is_certain));
    }

    /// The reference position that the block names, in machine coordinates.
    fn reference_in_machine(&self) -> Option<[Option<f64>; 5]> {
        let references = &self.machine_coordinates.as_ref()?.references;
        let stored = self.zeros.home.filter(|_| self.block.g_codes().contains(&FIRST_REFERENCE));
        if let Some(home) = stored {
            return Some(home?.map(Some));
        }
        let codes = self.block.g_codes();
        let number = match (codes.contains(&FIRST_REFERENCE), codes.contains(&NUMBERED_REFERENCE)) {
            (true, false) => 1,
            (false, true) if self.block.has(Address::P) => {
                self.number_of(Address::P).filter(|number| *number >= 2)?
            }
            (false, true) => 2,
            _ => return None,
        };
        references.get(usize::from(number) - 1).copied()
    }

    /// Whether Z in machine coordinates places the tip. `None` if this is not known.
    fn counts_length(&self) -> Option<bool> {
        if self.rules.has_no_length(&self.modal) {
            return Some(false);
        }
        let counts = self.machine_coordinates.as_ref()?.length_counts?;
        (!counts || self.rules.has_stated_length(&self.modal)).then_some(counts)
    }

    /// Whether words Z of the program place the gauge point, not the tip: no length is in force, but one was before, on
    /// a machine whose owner states where the gauge point stands. A program without lengths runs in a work offset of
    /// its tool's tip.
    #[inline]
    pub(super) fn places_gauge_point(&self) -> bool {
        self.machine_coordinates.is_some()
            && self.options.as_it_runs
            && self.modal.had_length
            && self.rules.has_no_length(&self.modal)
    }

    /// Whether words Z may place the gauge point of a tool of some length, because the program has written the height
    /// of its zero. Where the tip is in W is not known then.
    #[inline]
    pub(super) fn may_place_gauge_point(&self) -> bool {
        self.zeros.has_height && !self.modal.length_on && self.length_mm() != Some(0.0)
    }

    /// The ends of the axes at these machine coordinates. `None` if the state of the control leaves open where they go.
    fn words_in_machine(
        &self,
        targets: [Option<f64>; 5],
        counts_length: Option<bool>,
    ) -> Option<[AxisEnd; 5]> {
        let zero_mm = self.machine_coordinates.as_ref()?.zero_mm;
        // A zero turned about Z leaves Z as it is.
        let turn = self.modal.turn.filter(|_| self.has_own_zeros());
        let obstacle = if turn.is_some() { self.modal.obstacle_beside_turn() } else { self.obstacle() };
        let is_clear = self.options.as_it_runs
            && obstacle.is_none()
            && self.options.interpolation != Some(Interpolation::Tcp)
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.modal.compensation == Some(false)
            && self.modal.turn.is_some() == turn.is_some();
        let origin_mm = self.origin_mm().filter(|_| is_clear)?;
        let mut ends = targets.map(|target| target.map_or(AxisEnd::Stays, AxisEnd::At));
        for slot in 0..3 {
            if let Some(target_mm) = targets[slot] {
                ends[slot] = AxisEnd::At(target_mm + zero_mm[slot] - origin_mm[slot]);
            }
        }
        if let Some(turn) = turn.filter(|_| targets[..2].iter().any(Option::is_some)) {
            let [x, y] = self.turned_words(turn, [ends[0], ends[1]]);
            (ends[0], ends[1]) = (x, y);
        }
        if let AxisEnd::At(word_mm) = ends[Z] {
            ends[Z] = match counts_length {
                Some(false) => {
                    self.length_mm().map_or(AxisEnd::Unknown, |length_mm| AxisEnd::At(word_mm - length_mm))
                }
                // The length acts along Z in G17 alone.
                Some(true) if self.modal.plane == Some(ACROSS_G17) => AxisEnd::At(word_mm),
                Some(true) | None => return None,
            };
        }
        Some(ends)
    }

    /// The ends of X and Y in a zero that is turned about Z, from those along axes that are not turned. Where one axis
    /// moves, both words change.
    fn turned_words(&self, turn: Turn, ends: [AxisEnd; 2]) -> [AxisEnd; 2] {
        let [x, y, ..] = self.position.axes;
        let standing = x.zip(y).map(|(x, y)| turn.of([x, y, 0.0]));
        let end = |k: usize| match ends[k] {
            AxisEnd::At(at_mm) => Some(at_mm),
            AxisEnd::Stays => standing.map(|at_mm| at_mm[k]),
            AxisEnd::Unknown => None,
        };
        let words = end(0).zip(end(1)).map(|(x, y)| turn.back([x, y, 0.0]));
        words.map_or([AxisEnd::Unknown; 2], |[x, y, _]| [AxisEnd::At(x), AxisEnd::At(y)])
    }

    /// After a motion of axes to places of the machine that is not followed: the words of those axes are not known.
    /// If words are not positions of single axes, none of X Y Z is.
    pub(super) fn forget_moved(&mut self, named: u32) {
        self.forget_named(named);
        let is_of_axes = self.obstacle().is_none()
            && self.options.interpolation != Some(Interpolation::Tcp)
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.modal.turn.is_none();
        if named & AXES != 0 && !is_of_axes {
            self.position.forget_linear();
        }
    }

    /// Zero of the program's words, in M \[mm\]; `None` if it is not stated.
    fn origin_mm(&self) -> Option<[f64; 3]> {
        let offset = self.modal.work_offset.filter(|_| self.modal.shifts == 0)?;
        let offset_mm = self.options.work_offsets.of(offset, self.is_only_offset(offset))?;
        let program_mm = self.modal.program_offset_mm?;
        let [Some(x), Some(y), Some(z)] = self.modal.datum_mm else { return None };
        Some(std::array::from_fn(|slot| offset_mm[slot] + program_mm[slot] + [x, y, z][slot]))
    }

    /// Whether a tool is changed in the block: before its motion or after it.
    fn changes_tool(&self) -> bool {
        self.block.has_m(self.rules, MFunction::ToolChange)
    }

    /// The length of the tool in the spindle \[mm\]. It is not known if the program changes it or puts the length of
    /// another tool in force.
    fn length_mm(&self) -> Option<f64> {
        let tool = self.modal.spindle.tool();
        let is_own = match (self.modal.length_number, tool.key()) {
            (Some(number), Some(ToolKey::Number(own))) => {
                number.abs() <= 0.0 || (number - f64::from(own)).abs() <= 0.0
            }
            _ => true,
        };
        self.options.tool_lengths.of(tool).filter(|_| is_own && !self.modal.writes_lengths)
    }

    /// Puts the axes at these words, and ends the motion there.
    fn stand_in_machine(&mut self, ends: [AxisEnd; 5], motion: &mut Motion) {
        motion.start = self.position.axis_words();
        for (axis, end) in self.position.axes.iter_mut().zip(ends) {
            *axis = match end {
                AxisEnd::Stays => *axis,
                AxisEnd::At(word) => Some(word),
                AxisEnd::Unknown => None,
            };
        }
        if ends[3..].iter().any(|end| !matches!(end, AxisEnd::Stays)) {
            self.position.forget_tool_axis();
        }
        motion.end = self.position.axis_words();
        motion.linear_end_mm = self.position.linear_mm();
        if let Some(turn) = self.modal.turn {
            let turned = |words: AxisWords| AxisWords { linear_mm: turn.of(words.linear_mm), ..words };
            (motion.start, motion.end) = (motion.start.map(turned), motion.end.map(turned));
            motion.linear_end_mm = motion.linear_end_mm.map(|at_mm| turn.of(at_mm));
            motion.frame = Some(PlaneFrame::new([0.0; 3], turn));
        }
        motion.in_machine = true;
    }
}
