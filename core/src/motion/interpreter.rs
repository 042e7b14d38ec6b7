//! From blocks to motions: how a block is interpreted. The effect of its codes is in `execute`.

use super::block_words::BlockWords;
use super::course::Course;
use super::dialect::{MotionRules, ToolWords};
use super::machine_axes::MachineAxes;
use super::modal::{Modal, MotionMode, ToolLength};
use super::point_arc::PointArc;
use super::position::Position;
use super::sections::Sections;
use super::spindle::ToolsNamed;
use super::start_modes::StartModes;
use super::statements::ThisBlock;
use super::unit::ProgramUnit;
use super::written_zeros::WrittenZeros;
use super::{
    Decimals, Interpolation, Motion, RadiusOffsets, ToolLengths, Unfollowable, WorkOffset, WorkOffsets,
};
use crate::kinematics::PlaneAxes;
use crate::machine::{Machine, MachineCoordinates};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Code, Constants, Diagnostic, DiagnosticCode,
    Diagnostics, Dialect, Excerpt, Keyword, PlaceInFile, WordForm,
};
use crate::units::LengthUnit;
use std::sync::Arc;

/// How to interpret a program where its text alone is not enough.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InterpreterOptions {
    /// Feed in G94 before the first F word [mm/min]. Motions take it rounded to few decimals of the program's unit. It
    /// is not used if an F is given whose number is not known or no longer holds.
    pub feed_mm_per_min: Option<f64>,
    /// What the control interpolates, if the caller states it. Motions after M428 to M430 can be followed then.
    pub interpolation: Option<Interpolation>,
    /// The unit of a program that does not state one. Tables always count in millimetres.
    pub unit: Option<LengthUnit>,
    /// The modes before the first block, in dialects whose motions are modal.
    pub start_modes: StartModes,
    /// The axis positions before the first block, as words in the first work offset: X Y Z \[mm\], then the rotary
    /// axes in the profile's order \[deg\].
    pub start: [Option<f64>; 5],
    /// The positions of the work offsets.
    pub work_offsets: Arc<WorkOffsets>,
    /// The lengths of the tools.
    pub tool_lengths: Arc<ToolLengths>,
    /// The radii in the registers of the control.
    pub radius_offsets: Arc<RadiusOffsets>,
    /// The points of cutter location data under `CUTCOM/` are places of the cutter's centre: the control need not
    /// compensate for its radius.
    pub cutcom_at_centre: bool,
    /// The program is followed as it runs: the interpreter stops at a loop, a jump or a call, and
    /// [`Interpreter::stopped_at`] says where. Without this, the text is followed in its own order.
    pub as_it_runs: bool,
}

impl InterpreterOptions {
    /// A program that counts in millimetres unless it states another unit. Nothing else is stated.
    #[must_use]
    pub fn in_mm() -> Self {
        Self { unit: Some(LengthUnit::Millimetre), ..Self::default() }
    }
}

/// A control that reads a program batch after batch, in the program's order.
///
/// It starts in G90 G94 G17 G40 G49. The caller states other modes, the unit, the work offset and the positions. After a
/// call (M98, G65, an O word's `call`) every modal group is unknown until a word sets it again. Every position is
/// unknown until an absolute word states it.
#[derive(Debug, Clone)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about the course of the program")]
pub struct Interpreter {
    pub(super) options: InterpreterOptions,
    pub(super) modal: Modal,
    pub(super) position: Position,
    /// The circle of the next point of a cutter location program, or the one on which the tool is.
    pub(super) point_arc: PointArc,
    pub(super) program_decimals: Decimals,
    /// Why no motion can be followed in the present modal state.
    obstacle: Option<Unfollowable>,
    /// The letters of the machine's axes.
    pub(super) axes: MachineAxes,
    /// How the control turns the rotary axes to a tilted plane; `None` if the profile does not say so.
    pub(super) planes: Option<Arc<PlaneAxes>>,
    /// Where the control's machine coordinates count from; `None` if the profile does not say so.
    pub(super) machine_coordinates: Option<Arc<MachineCoordinates>>,
    /// The control is known to run programs as RS274/NGC does, if the program is of a dialect of such controls.
    pub(super) is_rs274: bool,
    /// The zeros that the program has written.
    pub(super) zeros: WrittenZeros,
    /// The work offset of the first complete point.
    pub(super) only_offset: Option<WorkOffset>,
    /// The unit in which the program counts, and its source.
    pub(super) program_unit: ProgramUnit,
    /// Line of the present block.
    pub(super) line: u64,
    /// Where the present block is, if it is in a file that the program calls.
    pub(super) called: Option<PlaceInFile>,
    /// The motion before asked for a corner to the present one.
    pub(super) corner_open: bool,
    /// The block before made a motion that axis words alone would repeat: see `repetition`.
    pub(super) repeats: bool,
    /// The block before stated the tool axis as a vector.
    pub(super) states_vector: bool,
    /// The course of the program so far.
    course: Course,
    /// The rules of the program's dialect, known after the first batch, and the present values of its parameters.
    pub(super) rules: &'static MotionRules,
    constants: Option<Constants>,
    pub(super) block: BlockWords,
    pub(super) this_block: ThisBlock,
    pub(super) sections: Sections,
    /// The tools that the program names.
    pub(super) tools: ToolsNamed,
    /// This control runs along to find what a section sets in every case: see `sections`.
    pub(super) is_stranger: bool,
    /// It stops at the next block that changes the course of the program.
    pub(super) stops_at_flow: bool,
    /// The block of the batch at which it stopped.
    stopped_at: Option<usize>,
    /// One after the last block of the batch to be interpreted.
    batch_end: usize,
    /// Strokes of canned cycles that were made in addition to one for each block.
    pub(super) further_strokes: u32,
}

impl Interpreter {
    /// A control of this machine in its starting state.
    #[must_use]
    pub fn new(machine: &Machine, options: InterpreterOptions) -> Self {
        Self {
            stops_at_flow: options.as_it_runs,
            stopped_at: None,
            batch_end: 0,
            options,
            modal: Modal::START,
            position: Position::UNKNOWN,
            point_arc: PointArc::None,
            program_decimals: Decimals::default(),
            obstacle: None,
            axes: MachineAxes::of(machine),
            planes: PlaneAxes::of(machine).map(Arc::new),
            machine_coordinates: machine.machine_coordinates().cloned().map(Arc::new),
            is_rs274: machine.has_rs274_control(),
            zeros: WrittenZeros::default(),
            only_offset: None,
            program_unit: ProgramUnit::default(),
            line: 0,
            called: None,
            corner_open: false,
            repeats: false,
            states_vector: false,
            course: Course::default(),
            rules: MotionRules::of(Dialect::Iso),
            constants: None,
            block: BlockWords::EMPTY,
            this_block: ThisBlock::default(),
            sections: Sections::default(),
            tools: ToolsNamed::default(),
            is_stranger: false,
            further_strokes: 0,
        }
    }

    /// Appends the motions of the batch and its diagnostics. A diagnostic of severity `Refusal` means that the program
    /// as a whole cannot be followed, because the effect could reach any later block.
    ///
    /// An expression in the batch becomes a number there if the program so far fixes its value.
    pub fn interpret(&mut self, batch: &mut Batch, motions: &mut Vec<Motion>, diagnostics: &mut Diagnostics) {
        self.interpret_each(batch, motions, diagnostics, |_, _| {});
    }

    /// [`Self::interpret`]. After every block, `see` gets all motions so far. It also gets the positions of X Y Z
    /// \[mm\] and of the machine's rotary axes \[deg\], as far as they are known.
    pub fn interpret_each(
        &mut self,
        batch: &mut Batch,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
        mut see: impl FnMut(&[Motion], [Option<f64>; 5]),
    ) {
        if self.constants.is_none() {
            self.rules = MotionRules::of(batch.dialect());
            self.stops_at_flow &= batch.dialect().rules().follows_flow();
            self.begin_dialect();
        }
        self.constants.get_or_insert_with(|| Constants::new(batch.dialect())).evaluate(batch);
        self.interpret_blocks(0, batch, motions, diagnostics, &mut see);
    }

    /// The block of the last batch at which the interpreter stopped, because the block changes the course of the
    /// program. This block and the ones after it are not interpreted.
    #[must_use]
    pub fn stopped_at(&self) -> Option<usize> {
        self.stopped_at
    }

    /// From here on the batches come in the order in which the program runs, so that nothing stops the interpreter any
    /// more.
    pub fn run_on(&mut self) {
        (self.stops_at_flow, self.stopped_at) = (false, None);
    }

    /// [`Self::interpret_each`] for the rest of the batch in which the interpreter stopped, after [`Self::run_on`].
    pub fn interpret_rest(
        &mut self,
        first: usize,
        batch: &mut Batch,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
        mut see: impl FnMut(&[Motion], [Option<f64>; 5]),
    ) {
        self.interpret_blocks(first, batch, motions, diagnostics, &mut see);
    }

    /// The blocks from `first` on of a batch whose expressions have their values.
    fn interpret_blocks(
        &mut self,
        first: usize,
        batch: &mut Batch,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
        see: &mut impl FnMut(&[Motion], [Option<f64>; 5]),
    ) {
        self.batch_end = batch.blocks().len();
        let mut index = first;
        while index < self.batch_end {
            let Some(block) = batch.blocks().get(index).copied() else { break };
            if self.rules.takes_ijk_as_vector
                && !self.course.has_ended()
                && self.takes_vector(batch.words(&block))
            {
                batch.name_tool_axis(&block);
            }
            let (batch, block, at) = (&*batch, &block, index);
            index += 1;
            self.called = batch.place_in_file(at);
            if self.course.has_ended() {
                let ends_again =
                    || batch.words(block).iter().any(|word| word.keyword() == Some(Keyword::EndPgm));
                let is_text = block.counts() && block.kind != BlockKind::Percent && !ends_again();
                self.course.pass_behind_end(is_text);
                continue;
            }
            self.run_along(batch, at, block);
            self.interpret_block(batch, at, block, motions, diagnostics);
            see(motions, self.position.axes);
        }
    }

    /// Stops at this block, if it may.
    pub(super) fn stops(&mut self, index: usize) -> bool {
        if self.stops_at_flow {
            self.stopped_at = Some(index);
            self.batch_end = 0;
        }
        self.stops_at_flow
    }

    /// One block of a program that has not ended.
    pub(super) fn interpret_block(
        &mut self,
        batch: &Batch,
        index: usize,
        block: &Block,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
    ) {
        let says_nothing = matches!(block.kind, BlockKind::Blank | BlockKind::Comment);
        self.repeats &= says_nothing || block.kind == BlockKind::Words;
        match block.kind {
            BlockKind::Words => self.interpret_words(batch, index, block, motions, diagnostics),
            // The first `%` opens the tape, and another one closes it.
            BlockKind::Percent if self.course.has_blocks() => self.end(block.line),
            BlockKind::Percent
            | BlockKind::Blank
            | BlockKind::Comment
            | BlockKind::Banner
            | BlockKind::Header => {}
            BlockKind::Assignment => self.assign(block),
            BlockKind::Call | BlockKind::Flow if self.stops(index) => {}
            BlockKind::Call => {
                self.course.note_block();
                let text = excerpt(batch, block);
                diagnostics.push(at_block(batch, block, DiagnosticCode::Call { text }));
                self.block.gather(&[]);
                self.opaque(index, block, Unfollowable::Call, motions);
                self.lose_state();
            }
            BlockKind::Flow => {
                let text = excerpt(batch, block);
                diagnostics.push(at_block(batch, block, DiagnosticCode::ControlFlow { text }));
            }
            BlockKind::Template => {
                let text = excerpt(batch, block);
                diagnostics.push(at_block(batch, block, DiagnosticCode::TemplateText { text }));
            }
            BlockKind::Malformed => {
                // In a called file, all blocks have the line of the call.
                let place = (block.line, batch.called_line(block));
                let fault = batch.faults().iter().find(|fault| (fault.line, fault.called) == place);
                diagnostics.extend(fault.copied());
            }
        }
    }

    /// A control in the same state that runs along to find what a section sets.
    pub(super) fn stranger(&mut self) -> Self {
        let sections = std::mem::take(&mut self.sections);
        let constants = self.constants.take();
        let stranger = Self { is_stranger: true, ..self.clone() };
        (self.sections, self.constants) = (sections, constants);
        stranger
    }

    fn interpret_words(
        &mut self,
        batch: &Batch,
        index: usize,
        block: &Block,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
    ) {
        let words = batch.words(block);
        self.block.gather(words);
        if self.is_stranger && block.flags.has(BlockFlags::EXPRESSION) {
            // Parameters may have other values where the section is called.
            for word in words.iter().filter(|word| word.form == WordForm::Evaluated) {
                self.block.unknown |= word.address.bit();
            }
        }
        self.begin_block();
        self.line = block.line;
        if self.program_unit.is_unknown() {
            self.ask_for_unit(batch, block, diagnostics);
        }
        let motions_before = motions.len();
        if !words.is_empty() {
            self.course.note_block();
        }
        if self.rules.counts_points {
            self.course.count_points(&self.block);
        }
        let may_be_skipped = block.flags.has(BlockFlags::DELETE);
        match self.rules.tool_words {
            ToolWords::LengthByH => self.take_length_word(may_be_skipped),
            ToolWords::EdgeByTAndD => self.take_tool_words(may_be_skipped),
            ToolWords::None => {}
        }
        if self.rules.has_parallel_axes && self.lone_letter().is_some() {
            self.position.forget_linear();
        }
        let is_plain =
            block.flags.is_plain() && self.block.present & (Address::T.bit() | Address::D.bit()) == 0;
        if is_plain && self.block.is_simple() && !self.block.has(Address::O) {
            if let Some(&code) = self.block.g_codes().last() {
                self.set_straight(code);
            }
            self.move_plainly(index, block, motions);
        } else if is_plain && self.is_plain_statement() {
            self.move_plainly(index, block, motions);
        } else if block.flags.has(BlockFlags::DELETE) {
            // The operator decides. After the block only the results that are the same both ways are known.
            let skipped = (self.modal, self.position, self.course.end_line());
            let zeros = self.zeros.clone();
            self.see_tools(batch, block);
            self.execute(batch, index, block, motions, diagnostics);
            let writes_zeros = self.zeros != zeros;
            self.modal = self.modal.common(&skipped.0);
            self.position = self.position.common(&skipped.1);
            self.course.end_at(skipped.2);
            if writes_zeros {
                self.lose_zeros();
            }
            self.find_obstacle();
            self.repeats = false;
        } else {
            self.see_tools(batch, block);
            self.execute(batch, index, block, motions, diagnostics);
            self.repeats = false;
        }
        if self.rules.is_of_points && motions.len() > motions_before {
            self.note_shape();
        }
        if !motions.is_empty() {
            self.course.note_motion();
        }
        if self.rules.has_sections {
            self.sections.count(motions.get(motions_before..).unwrap_or_default());
        }
    }

    #[inline]
    fn set_straight(&mut self, code: Code) {
        self.modal.motion = Some(if code == Code::G(0) { MotionMode::Rapid } else { MotionMode::Linear });
    }

    /// Marks the end of the program.
    pub(super) fn end(&mut self, line: u64) {
        self.course.end_at(Some(line));
    }

    /// Whether the program has moved so far.
    pub(super) fn has_motions(&self) -> bool {
        self.course.has_motions()
    }

    /// Why no motion can be followed in the present modal state.
    #[inline]
    pub(super) fn obstacle(&self) -> Option<Unfollowable> {
        self.obstacle
    }

    /// Looks for the obstacle after a mode has changed.
    pub(super) fn find_obstacle(&mut self) {
        self.obstacle = self.modal.obstacle();
    }

    pub(super) fn course(&self) -> &Course {
        &self.course
    }

    fn assign(&mut self, block: &Block) {
        self.course.note_block();
        if block.flags.has(BlockFlags::ASSIGNS_SYSTEM) {
            self.assign_system();
        }
        if block.flags.has(BlockFlags::SETS_CYCLE) {
            self.modal.hole = None;
        }
    }

    /// A work offset moves, so no position is known in the new coordinates.
    pub(super) fn shift_offsets(&mut self) {
        self.drop_zeros();
        self.modal.shifts = self.modal.shifts.saturating_add(1);
        self.position.forget_axes();
    }

    /// Forgets everything that a call may change.
    pub(super) fn forget_all(&mut self) {
        self.lose_zeros();
        if self.rules.call_keeps_modes {
            self.modal.forget_conversational();
        } else {
            self.modal.forget();
        }
        if self.rules.is_of_points {
            self.modal.tool_length = Some(ToolLength::Vector);
        }
        self.position.forget_all();
        self.find_obstacle();
    }
}

pub(super) fn excerpt(batch: &Batch, block: &Block) -> Excerpt {
    Excerpt::new(batch.block_text(block).trim_ascii())
}

/// A diagnostic of a whole block, from its first byte that is not blank.
pub(super) fn at_block(batch: &Batch, block: &Block, code: DiagnosticCode) -> Diagnostic {
    let text = batch.block_text(block);
    let blanks = text.iter().take_while(|byte| byte.is_ascii_whitespace()).count().min(text.len());
    at_bytes(batch, block, block.start + u32::try_from(blanks).unwrap_or(0), block.body_end, code)
}

/// A diagnostic of certain bytes of the batch's text.
pub(super) fn at_bytes(
    batch: &Batch,
    block: &Block,
    start: u32,
    end: u32,
    code: DiagnosticCode,
) -> Diagnostic {
    Diagnostic {
        code,
        line: block.line,
        called: batch.called_line(block),
        column: start.saturating_sub(block.start) + 1,
        span: ByteSpan {
            start: batch.offset() + u64::from(start),
            end: batch.offset() + u64::from(end.max(start)),
        },
    }
}
