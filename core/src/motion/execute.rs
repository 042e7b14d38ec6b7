//! The effect of a block's codes.

use super::block_words::AXES;
use super::interpreter::{Interpreter, at_bytes};
use super::meaning::{MFunction, Meaning, Statement};
use super::modal::ModalFeed;
use super::travel::CONTACT;
use super::{ContactWords, FeedMode, Motion, MotionKind, Unfollowable};
use crate::program::{
    Address, Batch, Block, BlockFlags, Code, DiagnosticCode, Diagnostics, Excerpt, Word, WordForm,
};

/// The action of a block on its axis words, besides moving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Action {
    /// The axis words are not a motion.
    Consume,
    /// The axis words set an offset.
    Shift,
    /// G28, G30.
    Reference,
    /// Motions that are not written.
    Elsewhere,
    /// G53.1: the rotary axes turn to the tilted plane.
    ToPlane,
    Call,
    Unknown,
    /// The axis words belong to a programmable frame.
    Frame,
    /// A cycle makes a hole here.
    Hole,
    /// A spline, a thread or a similar motion, in this block only.
    Odd(Unfollowable),
}

impl Interpreter {
    /// A block with codes other than G0 and G1, or a block that is not plain for another reason.
    pub(super) fn execute(
        &mut self,
        batch: &Batch,
        index: usize,
        block: &Block,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
    ) {
        if self.stops_at_flow && self.changes_course() && self.stops(index) {
            return;
        }
        if block.flags.has(BlockFlags::ASSIGNS_SYSTEM) {
            self.assign_system();
        }
        if self.block.has(Address::O) && self.has_motions() {
            self.forget_all();
        }
        let mut reason = self.block_reason(batch, block, diagnostics);
        let before = self.modal;
        let [.., first, second] = self.position.axes;
        let (mut action, mut one_shot) = self.apply_g_codes(&mut reason);
        self.settle_conflicts(batch, block, &before, &mut reason, diagnostics);
        let plane = self.stated_plane(batch, block, &before);
        if plane.is_some() && action.is_none() {
            action = Some(Action::Consume);
        }
        let (ends, called) = self.apply_m_codes();
        let ends = ends || self.this_block.ends;
        if self.this_block.machine_coordinates {
            one_shot = Some(Unfollowable::MachineCoordinates);
        }
        if self.this_block.runs_cycle && self.this_block.moves_elsewhere {
            // The cycle would begin where the other motion ends.
            reason = reason.or(Some(Unfollowable::CannedCycle));
            action = action.or(Some(Action::Elsewhere));
        } else if self.this_block.runs_cycle {
            action = self.action_at_call(action);
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
        self.note_radius_change();
        self.find_obstacle();
        if self.this_block.flow
            || (self.block.has_m(self.rules, MFunction::Return) && self.block.has(Address::P))
        {
            let text = Excerpt::new(batch.block_text(block).trim_ascii());
            let code = DiagnosticCode::ControlFlow { text };
            diagnostics.push(at_bytes(batch, block, block.start, block.body_end, code));
        }
        let before = motions.len();
        self.act(batch, index, block, action, one_shot, reason, motions, diagnostics);
        self.end_with_hole(index, block, action, before, motions);
        if let Some(plane) = plane {
            self.enter_plane(&plane, [first, second]);
            self.note_turn(reason, motions.get_mut(before..).unwrap_or_default());
        }
        if let Some(section) = self.this_block.section {
            self.apply_section(section);
        }
        if self.block.has_m(self.rules, MFunction::Return) {
            self.go_back(index, block, before, motions);
        }
        self.finish_block();
        if ends {
            self.end(block.line);
        }
    }

    /// Whether the block calls text by an M code, or calls a label.
    fn changes_course(&self) -> bool {
        let calls = |code: &Code| {
            matches!(
                self.rules.meaning(*code),
                Meaning::Statement(Statement::CallLabel | Statement::RepeatLabel)
            )
        };
        self.block.has_m(self.rules, MFunction::Call) || self.block.g_codes().iter().any(calls)
    }

    #[expect(clippy::too_many_arguments, reason = "the state of one block, used here only")]
    fn act(
        &mut self,
        batch: &Batch,
        index: usize,
        block: &Block,
        action: Option<Action>,
        one_shot: Option<Unfollowable>,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
    ) {
        let axis_words = self.block.present & AXES;
        match action {
            None if one_shot.is_some() => {
                self.set_feed();
                if self.move_in_machine(index, block, reason, motions) {
                    return;
                }
                if axis_words != 0 {
                    self.move_axes(index, block, one_shot, motions);
                }
                self.forget_moved(self.block.present);
            }
            None => self.move_axes(index, block, reason, motions),
            // F of a dwell may be a time.
            Some(Action::Consume) if self.block.has(Address::F) && self.rules.feed.dwell_may_set_feed => {
                self.modal.feed = ModalFeed::Unknown;
            }
            Some(Action::Consume | Action::Frame) => {}
            Some(Action::Hole) => self.run_hole(index, block, reason.or(one_shot), motions),
            Some(Action::Shift) => {
                self.set_feed();
                // G92 E0 zeroes the extruder, and G92 S limits the spindle. G92 alone zeroes all axes.
                let is_of_axes =
                    axis_words != 0 || !(self.block.has(Address::E) || self.block.has(Address::S));
                if is_of_axes && !self.write_shift() && !self.ends_no_shift() {
                    self.shift_offsets();
                }
                if self.block.has(Address::E) {
                    self.position.extruder = self.block.value(Address::E);
                }
            }
            Some(Action::Reference) => {
                self.set_feed();
                let reason = reason.or(one_shot);
                let goes_directly = self.all_go_home() && reason.is_none();
                let is_certain = goes_directly || self.pass_point(index, block, reason, motions);
                if is_certain && self.move_to_reference(index, block, motions) {
                    return;
                }
                self.opaque(index, block, Unfollowable::Reference, motions);
                // On some controls U V W name the linear axes incrementally.
                let incremental = Address::U.bit() | Address::V.bit() | Address::W.bit();
                if axis_words == 0 || self.block.present & incremental != 0 {
                    self.position.forget_axes();
                } else {
                    self.forget_moved(axis_words);
                    self.arrive_at_reference(reason);
                }
            }
            Some(Action::Elsewhere) => {
                self.set_feed();
                if reason.is_none() && self.retract_to_limit(index, block, motions) {
                    return;
                }
                // G53.1, G53.3 and G53.6 turn the tool onto the tilted plane.
                let tilted = self.obstacle() == Some(Unfollowable::TiltedPlane) && !self.stands_on_plane();
                let reason = if tilted { Unfollowable::TiltedPlane } else { Unfollowable::Reference };
                self.opaque(index, block, reason, motions);
                self.position.forget_axes();
            }
            Some(Action::ToPlane) => {
                self.set_feed();
                let tilted = self.obstacle().filter(|_| self.modal.is_tilted());
                self.opaque(index, block, tilted.unwrap_or(Unfollowable::Reference), motions);
                if self.turn_to_plane() {
                    let last = motions.len().saturating_sub(1);
                    self.note_turn(reason, motions.get_mut(last..).unwrap_or_default());
                } else {
                    self.position.forget_axes();
                }
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
                self.lose_state();
            }
            Some(Action::Unknown) => {
                let odd = batch.words(block).iter().find(|word| self.is_unknown(word));
                let (start, end) = odd.map_or((block.start, block.body_end), |word| (word.start, word.end));
                let text =
                    odd.map_or_else(|| batch.block_text(block).trim_ascii(), |word| batch.word_text(word));
                let code = DiagnosticCode::UnknownCode { text: Excerpt::new(text) };
                diagnostics.push(at_bytes(batch, block, start, end, code));
                // It may have been the motion to which RAPID or CIRCLE applies.
                self.modal.next_motion = None;
                self.opaque(index, block, Unfollowable::UnknownCode, motions);
                self.lose_state();
            }
        }
    }

    /// After a call, or a code that is not known.
    pub(super) fn lose_state(&mut self) {
        self.modal.is_lost |= self.rules.unknown_is_final;
        self.forget_all();
    }

    /// M99: the program continues somewhere else. The block is one opaque motion, whatever else it does.
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

    /// The reason against following the block that lies in how it is written.
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
            // G, M and N may occur several times, and `,R` is not a second R.
            let mut seen = 0;
            let repeatable = Address::G.bit() | Address::M.bit() | Address::N.bit();
            for word in words.iter().filter(|word| word.form != WordForm::Comma) {
                let address = word.address;
                let is_repeated = seen & address.bit() & !repeatable != 0;
                seen |= address.bit();
                if !is_repeated {
                    continue;
                }
                let code = DiagnosticCode::RepeatedAddress { address };
                diagnostics.push(at_bytes(batch, block, word.start, word.end, code));
                reason = Some(Unfollowable::RepeatedAddress { address });
                // It is not known which of the two holds.
                self.block.unknown |= address.bit();
            }
        }
        if block.flags.has(BlockFlags::DELETE) {
            reason = Some(Unfollowable::BlockDelete);
        }
        reason
    }

    /// A motion that may move these axes in any way.
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
            // F may be an argument of the call, and the called text may run at the active feed. The time of a block
            // ends with the block.
            motion.feed.word_in_block = false;
            if motion.feed.mode == Some(FeedMode::InverseTime) {
                (motion.feed.value, motion.feed.raw, motion.feed.decimals) = (None, 0.0, 0);
            }
        }
        motions.push(motion);
    }

    /// The axes named in the block are no longer known.
    pub(super) fn forget_named(&mut self, named: u32) {
        for (slot, address) in self.axes.all().into_iter().enumerate() {
            if named & address.bit() != 0 {
                self.position.axes[slot] = None;
            }
        }
        let [first, second] = self.axes.rotary();
        if named & (first.bit() | second.bit()) != 0 {
            self.position.forget_tool_axis();
        }
        if named & self.axes.foreign().bit() != 0 {
            self.position.foreign_deg = None;
        }
        for (slot, address) in CONTACT.into_iter().enumerate() {
            if named & address.bit() != 0 {
                self.position.contact_mm[slot] = None;
            }
        }
    }

    fn is_unknown(&self, word: &Word) -> bool {
        match word.address {
            Address::G => word.code().is_none_or(|code| self.rules.meaning(code) == Meaning::Unknown),
            Address::M => word.code().is_none(),
            _ => false,
        }
    }
}
