//! What the codes of a block do.

use super::codes::{Code, MCode, code_of, meaning};
use super::interpreter::{AXES, Interpreter, at_bytes, bit};
use super::modal::{ModalFeed, MotionMode, ToolLength, Transformation};
use super::travel::CONTACT;
use super::{ContactWords, FeedMode, FeedRules, Motion, MotionKind, Unfollowable};
use crate::program::{
    Address, Batch, Block, BlockFlags, DiagnosticCode, Diagnostics, Dialect, Excerpt, Word, WordForm,
};

/// What a block does with its axis words besides moving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Action {
    /// Axis words are no motion.
    Consume,
    /// They set an offset.
    Shift,
    /// G28, G30.
    Reference,
    /// Moves that are not written.
    Elsewhere,
    Call,
    Unknown,
    /// Axis words belong to a programmable frame.
    Frame,
    /// A spline, thread or the like in this block only.
    Odd(Unfollowable),
}

/// G43.1, G50 and G50.1: axis words beside them may be offsets or axes, and no motion.
const NAMES_AXES: [u32; 3] = [431, 500, 501];
/// G69: likewise, unless the block says how it moves.
const END_OF_ROTATION: u32 = 690;
/// G15, which on some controls selects a work coordinate system by its H.
const POLAR_END: u32 = 150;
/// The same as a work offset: `G15 H2`.
const OFFSET_BY_H: u16 = 150;
/// G50.1 and G51.1.
const MIRRORS: [u32; 2] = [501, 511];
/// G107: on with an axis, whatever the value beside its letter; off without.
const CYLINDER_OF_AN_AXIS: u32 = 1070;
/// G07: on with an axis at 0, which does not move then, and off with the axis at 1.
const HYPOTHETICAL_AXIS: u32 = 70;
/// Words that cycles have and a change of units does not.
const CYCLE_WORDS: u32 =
    bit(Address::P) | bit(Address::Q) | bit(Address::I) | bit(Address::J) | bit(Address::K) | bit(Address::L);
/// G43.1: on some controls the length along the tool, whichever way it points; on others along Z.
const LENGTH_ALONG_THE_TOOL: u32 = 431;
/// G43.4, G43.5, G49: the codes of the tool length group that say what is interpolated.
const SETTLING: [u32; 5] = [434, 2340, 435, 490, 491];

impl Interpreter {
    /// A block with codes other than G0 and G1, or otherwise not plain.
    pub(super) fn execute(
        &mut self,
        batch: &Batch,
        index: usize,
        block: &Block,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
    ) {
        if block.flags.has(BlockFlags::ASSIGNS_SYSTEM) {
            self.shift_offsets();
        }
        if self.block.has(Address::O) && self.is_under_way() {
            self.forget_all();
        }
        let mut reason = self.block_reason(batch, block, diagnostics);
        let before = self.modal;
        let (mut action, mut one_shot) = self.apply_g_codes(&mut reason);
        self.settle_conflicts(batch, block, &before, &mut reason, diagnostics);
        let (ends, called) = self.apply_m_codes();
        let ends = ends || self.this_block.ends;
        one_shot |= self.this_block.machine_coordinates;
        if self.this_block.runs_cycle {
            action = action.or(Some(Action::Odd(Unfollowable::CannedCycle)));
        } else if self.this_block.moves_elsewhere {
            action = action.or(Some(Action::Elsewhere));
        }
        if self.sections.is_called_text {
            reason = reason.or(Some(Unfollowable::CalledText));
        }
        if self.block.odd_code {
            action = Some(Action::Unknown);
        } else if called {
            action = Some(Action::Call);
        }
        self.obstacle = self.modal.obstacle();
        if self.this_block.flow
            || (self.block.has_m(self.dialect, MCode::Return) && self.block.has(Address::P))
        {
            let text = Excerpt::new(batch.block_text(block).trim_ascii());
            let code = DiagnosticCode::ControlFlow { text };
            diagnostics.push(at_bytes(batch, block, block.start, block.body_end, code));
        }
        let before = motions.len();
        self.act(batch, index, block, action, one_shot, reason, motions, diagnostics);
        if let Some(section) = self.this_block.section {
            self.apply_section(section);
        }
        if self.block.has_m(self.dialect, MCode::Return) {
            self.go_back(index, block, before, motions);
        }
        self.finish_block();
        if ends {
            self.end(block.line);
        }
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one block, used here only")]
    fn act(
        &mut self,
        batch: &Batch,
        index: usize,
        block: &Block,
        action: Option<Action>,
        one_shot: bool,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
    ) {
        let axis_words = self.block.present & AXES;
        match action {
            None if one_shot => {
                self.set_feed();
                if axis_words != 0 {
                    let reason = Some(Unfollowable::MachineCoordinates);
                    self.move_axes(index, block, reason, motions);
                }
                self.forget_named(self.block.present);
            }
            None => self.move_axes(index, block, reason, motions),
            // F of a dwell may be a time.
            Some(Action::Consume)
                if self.block.has(Address::F) && FeedRules::of(self.dialect).dwell_may_set_feed =>
            {
                self.modal.feed = ModalFeed::Unknown;
            }
            Some(Action::Consume | Action::Frame) => {}
            Some(Action::Shift) => {
                self.set_feed();
                // G92 E0 zeroes the extruder, G92 S limits the spindle; G92 alone zeroes all.
                let is_of_axes =
                    axis_words != 0 || !(self.block.has(Address::E) || self.block.has(Address::S));
                if is_of_axes && !self.ends_no_shift() {
                    self.shift_offsets();
                }
                if self.block.has(Address::E) {
                    self.position.extruder = self.block.value(Address::E);
                }
            }
            Some(Action::Reference) => {
                self.set_feed();
                self.opaque(index, block, Unfollowable::Reference, motions);
                // U V W name the linear axes incrementally on some controls.
                let incremental = bit(Address::U) | bit(Address::V) | bit(Address::W);
                if axis_words == 0 || self.block.present & incremental != 0 {
                    self.position.forget_axes();
                } else {
                    self.forget_named(axis_words);
                }
            }
            Some(Action::Elsewhere) => {
                self.set_feed();
                // G53.1, G53.3 and G53.6 turn the tool onto the tilted plane.
                let tilted = self.obstacle == Some(Unfollowable::TiltedPlane);
                let reason = if tilted { Unfollowable::TiltedPlane } else { Unfollowable::Reference };
                self.opaque(index, block, reason, motions);
                self.position.forget_axes();
            }
            Some(Action::Odd(reason)) => {
                self.set_feed();
                self.opaque(index, block, reason, motions);
                self.forget_named(self.block.present);
            }
            Some(Action::Call) => {
                let text = Excerpt::new(batch.block_text(block).trim_ascii());
                let code = DiagnosticCode::Call { text };
                diagnostics.push(at_bytes(batch, block, block.start, block.body_end, code));
                self.opaque(index, block, Unfollowable::Call, motions);
                self.forget_all();
            }
            Some(Action::Unknown) => {
                let odd = batch.words(block).iter().find(|word| is_unknown(self.dialect, word));
                let (start, end) = odd.map_or((block.start, block.body_end), |word| (word.start, word.end));
                let text =
                    odd.map_or_else(|| batch.block_text(block).trim_ascii(), |word| batch.word_text(word));
                let code = DiagnosticCode::UnknownCode { text: Excerpt::new(text) };
                diagnostics.push(at_bytes(batch, block, start, end, code));
                // It may have been the motion that RAPID or CIRCLE was for.
                self.modal.next_motion = None;
                self.opaque(index, block, Unfollowable::UnknownCode, motions);
                self.forget_all();
            }
        }
    }

    /// M99: what follows is somewhere else. Its block is one opaque motion, whatever else it does.
    fn go_back(&mut self, index: usize, block: &Block, before: usize, motions: &mut Vec<Motion>) {
        if motions.len() == before {
            self.opaque(index, block, Unfollowable::Return, motions);
        }
        for motion in motions.iter_mut().skip(before) {
            motion.kind = MotionKind::Opaque;
            (motion.start, motion.end, motion.contact) = (None, None, ContactWords::None);
            motion.unfollowable.get_or_insert(Unfollowable::Return);
        }
    }

    /// What the way the block is written forbids.
    fn block_reason(
        &mut self,
        batch: &Batch,
        block: &Block,
        diagnostics: &mut Diagnostics,
    ) -> Option<Unfollowable> {
        let mut reason = None;
        let words = batch.words(block);
        if block.flags.has(BlockFlags::COMMA) {
            reason = Some(Unfollowable::Corner);
        }
        if block.flags.has(BlockFlags::REPEATED) {
            // G, M and N may stand several times, and `,R` is no second R.
            let mut seen = 0;
            let repeatable = bit(Address::G) | bit(Address::M) | bit(Address::N);
            for word in words.iter().filter(|word| word.form != WordForm::Comma) {
                let address = word.address;
                let is_repeated = seen & bit(address) & !repeatable != 0;
                seen |= bit(address);
                if !is_repeated {
                    continue;
                }
                let code = DiagnosticCode::RepeatedAddress { address };
                diagnostics.push(at_bytes(batch, block, word.start, word.end, code));
                reason = Some(Unfollowable::RepeatedAddress { address });
                // Which of the two holds, nobody can tell.
                self.block.unknown |= bit(address);
            }
        }
        if block.flags.has(BlockFlags::DELETE) {
            reason = Some(Unfollowable::BlockDelete);
        }
        reason
    }

    /// Sets the modes; gives what else is to be done, and whether G53 stands in the block.
    #[expect(clippy::too_many_lines, reason = "one arm for every kind of code")]
    fn apply_g_codes(&mut self, reason: &mut Option<Unfollowable>) -> (Option<Action>, bool) {
        let mut action = None;
        let mut machine_coordinates = false;
        let mut motion_codes = 0;
        let mut ends_cycle = false;
        let axis_words = self.block.present & AXES;
        let also = |action: &mut Option<Action>, new: Action| {
            // Two codes that want the axis words: what moves unseen wins.
            let wins = !matches!(action, Some(Action::Call | Action::Unknown | Action::Elsewhere));
            if action.is_some() && *action != Some(new) && axis_words != 0 {
                *action = Some(Action::Odd(Unfollowable::ConflictingCodes));
            } else if wins {
                *action = Some(new);
            }
        };
        for index in 0..self.block.g_count {
            let code = self.code(index);
            match code {
                Code::Motion(mode) => {
                    motion_codes += u32::from(motion_codes == 0 || self.modal.motion != Some(mode));
                    self.modal.motion = Some(mode);
                }
                Code::MotionWithAxes(MotionMode::Spline) if axis_words != 0 => {
                    self.modal.motion = Some(MotionMode::Spline);
                }
                Code::MotionWithAxes(_) if axis_words != 0 => {
                    also(&mut action, Action::Odd(Unfollowable::SpecialMotion));
                }
                Code::EndCycle => ends_cycle = true,
                Code::Transform(_, false) | Code::ToolLength(_)
                    if axis_words != 0 && self.may_name_axes(self.block.g_codes[index]) =>
                {
                    // The words name axes, or are offsets; on some controls the block moves all the same.
                    self.set_mode(code, index);
                    also(&mut action, Action::Odd(Unfollowable::ConflictingCodes));
                }
                Code::Transform(Transformation::Cylinder, _)
                    if self.block.g_codes[index] == CYLINDER_OF_AN_AXIS =>
                {
                    self.transform(Transformation::Cylinder, axis_words != 0);
                    also(&mut action, Action::Consume);
                }
                Code::Transform(Transformation::Cylinder, _)
                    if self.block.g_codes[index] == HYPOTHETICAL_AXIS && axis_words != 0 =>
                {
                    self.transform(Transformation::Cylinder, !self.is_hypothetical_end());
                    also(&mut action, Action::Consume);
                }
                Code::Plane(_)
                | Code::Incremental(_)
                | Code::Units(_)
                | Code::Feed(_)
                | Code::Compensation(_)
                | Code::ToolLength(_)
                | Code::WorkOffset
                | Code::Transform(..)
                | Code::ToolOffset
                | Code::RoundsCorners(_)
                | Code::VectorsInMachine(_)
                | Code::ExactStop(_)
                | Code::ExactStopHere => self.set_mode(code, index),
                Code::NoMotion => also(&mut action, Action::Consume),
                Code::WriteOffsets => {
                    self.write_offsets();
                    also(&mut action, Action::Consume);
                }
                Code::Shift => also(&mut action, Action::Shift),
                Code::OtherShift => {
                    if !self.ends_no_shift() {
                        self.shift_offsets();
                    }
                    also(&mut action, Action::Consume);
                }
                Code::MachineCoordinates => machine_coordinates = true,
                Code::Reference => also(&mut action, Action::Reference),
                Code::Elsewhere => also(&mut action, Action::Elsewhere),
                Code::Call => also(&mut action, Action::Call),
                Code::ModalCall => {
                    self.modal.macro_call = Some(true);
                    also(&mut action, Action::Call);
                }
                Code::EndModalCall => {
                    self.modal.macro_call = Some(false);
                    self.position.forget_all();
                }
                Code::Statement(statement) => {
                    if let Some(new) = self.apply_statement(statement, reason) {
                        also(&mut action, new);
                    }
                }
                Code::ProgramFrame(frame, added) => {
                    self.program_frame(frame, added);
                    also(&mut action, Action::Frame);
                }
                Code::ModalCycle
                | Code::Cycle
                | Code::Swivel(_)
                | Code::Probing
                | Code::PolarEnd
                | Code::OrientationWord
                | Code::OtherAxis => {
                    if let Some(new) = self.leave(code) {
                        also(&mut action, new);
                    }
                }
                Code::BlockWord => also(&mut action, Action::Odd(Unfollowable::ControlWord)),
                Code::ForeignWord => *reason = Some(Unfollowable::ControlWord),
                Code::Harmless | Code::MotionWithAxes(_) => {}
                Code::Unknown => also(&mut action, Action::Unknown),
            }
        }
        if ends_cycle && motion_codes == 0 && self.modal.motion == Some(MotionMode::Cycle) {
            self.modal.motion = None;
        }
        if motion_codes > 1 {
            *reason = Some(Unfollowable::ConflictingCodes);
            self.modal.motion = None;
        }
        // A dwell and a motion: whose the axis words are depends on the control.
        if action == Some(Action::Consume) && motion_codes > 0 && axis_words != 0 {
            action = Some(Action::Odd(Unfollowable::ConflictingCodes));
        }
        // Unknown codes and calls are never hidden by a conflict.
        if (0..self.block.g_count).any(|index| self.code(index) == Code::Unknown) {
            action = Some(Action::Unknown);
        }
        (action, machine_coordinates)
    }

    /// Whether axis words beside this code may be something else than a motion.
    fn may_name_axes(&self, code: u32) -> bool {
        NAMES_AXES.contains(&code) || (code == END_OF_ROTATION && !self.says_how_to_move())
    }

    /// G0 to G3.
    fn says_how_to_move(&self) -> bool {
        self.block.g_codes().iter().any(|code| matches!(code, 0 | 10 | 20 | 30))
    }

    /// Sets the mode that the code of this index names.
    fn set_mode(&mut self, code: Code, index: usize) {
        match code {
            Code::Plane(plane) => self.modal.plane = Some(plane),
            Code::Incremental(incremental) => self.modal.incremental = Some(incremental),
            Code::Units(mm_per_unit) => self.set_unit(mm_per_unit),
            Code::Feed(mode) => {
                if self.modal.feed_mode != Some(mode) {
                    self.modal.void_feed();
                }
                self.modal.feed_mode = Some(mode);
            }
            Code::Compensation(on) => self.modal.compensation = Some(on),
            // TRAORI again, or TRAFOOF again: nothing new.
            Code::ToolLength(length) if self.dialect == Dialect::Siemens => self.switch_tip(length),
            Code::ToolLength(_)
                if self.block.g_codes[index] == LENGTH_ALONG_THE_TOOL
                    && self.has_head_axis
                    && !self.options.interpolation_stated =>
            {
                self.modal.tool_length = None;
                self.position.forget_linear();
            }
            Code::ToolLength(length) => {
                if self.modal.tool_length == Some(ToolLength::Vector) && length != ToolLength::Vector {
                    self.position.tool_axis = [None; 3];
                }
                if self.modal.tool_length == Some(length) {
                    // Another length perhaps, unless nothing but the mode is repeated; H has been looked at.
                    self.position.axes[2] = None;
                } else {
                    self.position.forget_linear();
                }
                self.modal.tool_length = Some(length);
                let settles = SETTLING.contains(&self.block.g_codes[index]);
                self.modal.kinematics_switched &= !settles;
            }
            Code::WorkOffset => self.change_work_offset(self.block.g_codes[index]),
            Code::Transform(Transformation::PolarWords, false)
                if self.block.g_codes[index] == POLAR_END && self.block.has(Address::H) =>
            {
                self.transform(Transformation::PolarWords, false);
                self.set_work_offset(self.numbered(OFFSET_BY_H, Address::H));
            }
            Code::Transform(Transformation::Mirror, on) if MIRRORS.contains(&self.block.g_codes[index]) => {
                self.mirror(on);
            }
            Code::Transform(Transformation::Cylinder, on) => {
                // G7.1 is ended by the axis at zero.
                self.transform(Transformation::Cylinder, on && !self.is_cylinder_end());
            }
            Code::Transform(which, on) => self.transform(which, on),
            Code::ToolOffset => {
                self.position.forget_linear();
                self.modal.edge = None;
            }
            Code::RoundsCorners(on) => self.modal.rounds_corners = on,
            Code::VectorsInMachine(on) => self.modal.vectors_in_machine = on,
            Code::ExactStop(on) => self.modal.exact_stop = on,
            Code::ExactStopHere => self.this_block.exact_stop = true,
            _ => {}
        }
    }

    /// Words whose motion is left alone; gives what else is to be done.
    fn leave(&mut self, code: Code) -> Option<Action> {
        match code {
            Code::ModalCycle => {
                self.modal.macro_call = Some(true);
                self.position.forget_axes();
            }
            Code::Cycle => {
                self.position.forget_axes();
                return Some(Action::Odd(Unfollowable::CannedCycle));
            }
            Code::Swivel(on) => {
                self.transform(Transformation::Swivel, on);
                if on {
                    self.position.forget_axes();
                    return Some(Action::Odd(Unfollowable::Transformation));
                }
            }
            Code::Probing => {
                self.position.forget_axes();
                return Some(Action::Odd(Unfollowable::Probing));
            }
            Code::PolarEnd => {
                self.position.forget_linear();
                return Some(Action::Odd(Unfollowable::ControlWord));
            }
            Code::OrientationWord => {
                self.position.forget_rotary();
                return Some(Action::Odd(Unfollowable::ControlWord));
            }
            Code::OtherAxis => {
                self.position.forget_axes();
                return Some(Action::Odd(Unfollowable::ControlWord));
            }
            _ => {}
        }
        None
    }

    /// The meaning of a G code in this block. In ISO programs, where no G0 to G3 says how the block moves, G70 and G71 are cycles
    /// beside words of cycles: of turning (P Q) or of holes in a circle (I J K L); G11 and G62 beside axis words are frames.
    pub(super) fn code(&self, index: usize) -> Code {
        let tenths = self.block.g_codes().get(index).copied().unwrap_or_default();
        let is_other = self.dialect == Dialect::Iso
            && match tenths {
                700 | 710 => self.block.present & CYCLE_WORDS != 0 && !self.says_how_to_move(),
                110 | 620 => self.block.present & AXES != 0 && !self.says_how_to_move(),
                _ => false,
            };
        if is_other { Code::Unknown } else { meaning(self.dialect, tenths) }
    }

    /// A motion that may do anything with these axes.
    pub(super) fn opaque(
        &mut self,
        index: usize,
        block: &Block,
        reason: Unfollowable,
        motions: &mut Vec<Motion>,
    ) {
        let mut motion = self.motion_shell(index, block, MotionKind::Opaque);
        motion.start = self.position.axis_words();
        motion.unfollowable = Some(reason);
        if matches!(reason, Unfollowable::Call | Unfollowable::UnknownCode) {
            // F may be an argument: what is called may run at the feed that stands. A block's time ends with it.
            motion.feed.word_in_block = false;
            if motion.feed.mode == Some(FeedMode::InverseTime) {
                (motion.feed.value, motion.feed.raw, motion.feed.decimals) = (None, 0.0, 0);
            }
        }
        motions.push(motion);
    }

    /// The axes named in the block are not known any more.
    pub(super) fn forget_named(&mut self, named: u32) {
        let [first, second] = self.rotary_addresses;
        for (slot, address) in [Address::X, Address::Y, Address::Z, first, second].into_iter().enumerate() {
            if named & bit(address) != 0 {
                self.position.axes[slot] = None;
            }
        }
        if named & (bit(first) | bit(second)) != 0 {
            self.position.tool_axis = [None; 3];
        }
        if named & bit(self.foreign_address) != 0 {
            self.position.foreign_deg = None;
        }
        for (slot, address) in CONTACT.into_iter().enumerate() {
            if named & bit(address) != 0 {
                self.position.contact_mm[slot] = None;
            }
        }
    }
}

fn is_unknown(dialect: Dialect, word: &Word) -> bool {
    match word.address {
        Address::G => code_of(word).is_none_or(|code| meaning(dialect, code) == Code::Unknown),
        Address::M => word.code_tenths().is_none(),
        _ => false,
    }
}
