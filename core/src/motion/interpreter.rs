//! From blocks to motions: the course of a block. What its codes do is in `execute`.

use super::dialect::{MotionRules, ToolWords};
use super::meaning::MFunction;
use super::modal::{Modal, MotionMode, ToolLength};
use super::position::Position;
use super::sections::Sections;
use super::statements::ThisBlock;
use super::unit::UnitFrom;
use super::{Decimals, Motion, StatedCutter, ToolName, Unfollowable, WorkOffset, WorkOffsets};
use crate::machine::{Machine, Side};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Code, Constants, Diagnostic, DiagnosticCode,
    Diagnostics, Dialect, Excerpt, Keyword, Word, WordForm,
};
use crate::units::LengthUnit;
use std::sync::Arc;

/// How a program is to be taken where the text alone does not say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InterpreterOptions {
    /// Feed in G94 before the first F word [mm/min]; motions take it rounded to few decimals of the program's unit.
    /// Where F is given but its number is not known, or does not hold any more, it is not used.
    pub feed_mm_per_min: Option<f64>,
    /// Whether the caller says what the control interpolates: motions behind M428 to M430 can be followed then.
    pub interpolation_stated: bool,
    /// The unit of a program that does not state one; tables count in millimetres all the same.
    pub unit: Option<LengthUnit>,
    /// Where the axes stand before the first block, as words in the first work offset: X Y Z \[mm\], the rotaries in the
    /// profile's order \[deg\].
    pub start: [Option<f64>; 5],
    /// Where the work offsets are.
    pub work_offsets: Arc<WorkOffsets>,
}

impl InterpreterOptions {
    /// A program that counts in millimetres unless it says otherwise; nothing else is stated.
    #[must_use]
    pub fn in_mm() -> Self {
        Self { unit: Some(LengthUnit::Millimetre), ..Self::default() }
    }
}

/// A control that reads a program batch after batch, in the program's order.
///
/// It starts in G90 G94 G17 G40 G49, with the unit, the work offset and the positions that the caller states. A call (M98, G65, an O word's `call`) leaves
/// every modal group unknown until a word sets it again, and every position until an absolute word does.
#[derive(Debug, Clone)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about the course of the program")]
pub struct Interpreter {
    pub(super) options: InterpreterOptions,
    pub(super) modal: Modal,
    pub(super) position: Position,
    pub(super) program_decimals: Decimals,
    /// Why no motion can be followed in the present modal state.
    pub(super) obstacle: Option<Unfollowable>,
    /// By address: the axis it moves: 0–2 X Y Z, 3–4 the machine's rotaries.
    pub(super) rotary_addresses: [Address; 2],
    pub(super) foreign_address: Address,
    /// A rotary axis carries the tool.
    pub(super) has_head_axis: bool,
    /// The work offset of the first complete point.
    pub(super) only_offset: Option<WorkOffset>,
    /// Who says in which unit the program counts.
    pub(super) unit_from: UnitFrom,
    /// The unit that held last, also after a call that may have changed it.
    pub(super) last_mm_per_unit: Option<f64>,
    /// Line of the block at hand.
    pub(super) line: u64,
    /// First line where the text states another unit than the caller.
    pub(super) unit_disagrees_at: Option<u64>,
    /// The motion before asked for a corner to the present one.
    pub(super) corner_open: bool,
    /// The block before made a motion that axis words alone would make again: see `repetition`.
    pub(super) repeats: bool,
    /// And it stated the tool axis as a vector.
    pub(super) states_vector: bool,
    has_blocks: bool,
    has_motions: bool,
    ended: bool,
    /// Line of the block that ended the program.
    end_line: Option<u64>,
    blocks_after_end: u64,
    /// Axis words without a decimal point that are not zero, and whether there is one with a point.
    words_without_point: u64,
    has_points: bool,
    /// Of the program's dialect, once its first batch is there, and what its parameters stand at.
    pub(super) rules: &'static MotionRules,
    constants: Option<Constants>,
    pub(super) block: BlockWords,
    pub(super) this_block: ThisBlock,
    pub(super) sections: Sections,
    /// Names by which tools were called, and what a cutter location program says of them.
    pub(super) tool_names: Vec<ToolName>,
    pub(super) stated_cutters: Vec<StatedCutter>,
    /// It runs along to see what a section sets, whatever was before: see `sections`.
    pub(super) is_stranger: bool,
}

/// The words of the block at hand, by address.
#[derive(Debug, Clone)]
pub(super) struct BlockWords {
    pub(super) values: [f64; 32],
    pub(super) decimals: [u8; 32],
    /// Addresses in the block, bit by index; those of `,R` and its kin apart.
    pub(super) present: u32,
    /// Of these, the ones whose value is not a plain number.
    pub(super) unknown: u32,
    pub(super) comma: u32,
    /// Of those present, the ones that say themselves what they count from.
    pub(super) absolute: u32,
    pub(super) incremental: u32,
    /// Of those present, the ones written with a decimal point.
    points: u32,
    /// Of those present, the ones that are not plain numbers.
    pub(super) odd: u32,
    /// G codes and statement words, and M codes.
    pub(super) g_codes: [Code; 16],
    pub(super) g_count: usize,
    pub(super) m_codes: [Code; 16],
    pub(super) m_count: usize,
    /// A G or M word without a plain code, or too many of them.
    pub(super) odd_code: bool,
}

impl BlockWords {
    const EMPTY: Self = Self {
        values: [0.0; 32],
        decimals: [0; 32],
        present: 0,
        unknown: 0,
        comma: 0,
        absolute: 0,
        incremental: 0,
        points: 0,
        odd: 0,
        g_codes: [Code::G(0); 16],
        g_count: 0,
        m_codes: [Code::M(0); 16],
        m_count: 0,
        odd_code: false,
    };

    #[inline]
    fn gather(&mut self, words: &[Word]) {
        (self.g_count, self.m_count, self.odd_code) = (0, 0, false);
        // Sums of bits stay in registers.
        let (mut present, mut unknown, mut comma, mut points) = (0, 0, 0, 0);
        let (mut absolute, mut incremental, mut odd) = (0, 0, 0);
        for word in words {
            let index = word.address.index() & 31;
            match word.address {
                Address::G => Self::add_code(word, &mut self.g_codes, &mut self.g_count, &mut self.odd_code),
                Address::M => Self::add_code(word, &mut self.m_codes, &mut self.m_count, &mut self.odd_code),
                _ if word.form == WordForm::Comma => comma |= 1 << index,
                _ => {
                    let bit = 1 << index;
                    present |= bit;
                    self.values[index] = word.value;
                    self.decimals[index] = word.decimals;
                    points |= u32::from(word.has_point) << index;
                    if word.form != WordForm::Number {
                        odd |= bit;
                        unknown |= u32::from(!word.is_known()) << index;
                        absolute |= u32::from(word.form == WordForm::Absolute) << index;
                        incremental |= u32::from(word.form == WordForm::Incremental) << index;
                    }
                }
            }
        }
        (self.present, self.unknown, self.comma, self.points) = (present, unknown, comma, points);
        (self.absolute, self.incremental, self.odd) = (absolute, incremental, odd);
    }

    #[inline]
    fn add_code(word: &Word, codes: &mut [Code; 16], count: &mut usize, odd: &mut bool) {
        match (word.code(), codes.get_mut(*count)) {
            (Some(code), Some(slot)) => {
                *slot = code;
                *count += 1;
            }
            _ => *odd = true,
        }
    }

    #[inline]
    pub(super) fn has(&self, address: Address) -> bool {
        self.present & (1 << address.index()) != 0
    }

    /// The value of a word, if it stands in the block with a plain number.
    #[inline]
    pub(super) fn value(&self, address: Address) -> Option<f64> {
        let bit = 1 << address.index();
        (self.present & bit != 0 && self.unknown & bit == 0).then(|| self.values[address.index()])
    }

    pub(super) fn g_codes(&self) -> &[Code] {
        self.g_codes.get(..self.g_count).unwrap_or_default()
    }

    /// Whether an M code of this meaning stands in the block.
    pub(super) fn has_m(&self, rules: &MotionRules, wanted: MFunction) -> bool {
        let codes = self.m_codes.get(..self.m_count).unwrap_or_default();
        codes.iter().any(|&code| rules.m_function(code) == wanted)
    }

    /// What a word counts from: G91's place or zero; `None` where the modal sense is not known.
    #[inline]
    pub(super) fn is_incremental(&self, address: Address, modal: Option<bool>) -> Option<bool> {
        let bit = bit(address);
        if self.incremental & bit != 0 {
            Some(true)
        } else if self.absolute & bit != 0 {
            Some(false)
        } else {
            modal
        }
    }

    /// The statement word of a block that has no other, and no M codes.
    #[inline]
    pub(super) fn only_statement(&self) -> Option<Keyword> {
        if self.m_count > 0 || self.g_count != 1 || self.odd_code {
            return None;
        }
        self.g_codes.first().and_then(|code| code.keyword())
    }

    /// G0 and G1 only, no M codes: nothing but motion can come of it.
    #[inline]
    fn is_simple(&self) -> bool {
        self.m_count == 0
            && self.g_count <= 1
            && !self.odd_code
            && self.g_codes().iter().all(|code| matches!(code, Code::G(0 | 10)))
    }
}

/// G4.
pub(super) const DWELL: Code = Code::G(40);
/// Bits of X Y Z A B C.
pub(super) const AXES: u32 =
    bit(Address::X) | bit(Address::Y) | bit(Address::Z) | bit(Address::A) | bit(Address::B) | bit(Address::C);

pub(super) const fn bit(address: Address) -> u32 {
    1 << address.index()
}

impl Interpreter {
    /// A control of this machine in its starting state.
    #[must_use]
    pub fn new(machine: &Machine, options: InterpreterOptions) -> Self {
        let letters = [Address::A, Address::B, Address::C];
        let rotary_addresses = machine.rotary_axes().each_ref().map(|axis| letters[axis.letter as usize]);
        let foreign_address =
            letters.into_iter().find(|letter| !rotary_addresses.contains(letter)).unwrap_or(Address::C);
        Self {
            options,
            modal: Modal::START,
            position: Position::UNKNOWN,
            program_decimals: Decimals::default(),
            obstacle: None,
            rotary_addresses,
            foreign_address,
            has_head_axis: machine.rotary_axes().iter().any(|axis| axis.side == Side::Head),
            only_offset: None,
            unit_from: UnitFrom::Nobody,
            last_mm_per_unit: None,
            line: 0,
            unit_disagrees_at: None,
            corner_open: false,
            repeats: false,
            states_vector: false,
            has_blocks: false,
            has_motions: false,
            ended: false,
            end_line: None,
            blocks_after_end: 0,
            words_without_point: 0,
            has_points: false,
            rules: MotionRules::of(Dialect::Iso),
            constants: None,
            block: BlockWords::EMPTY,
            this_block: ThisBlock::default(),
            sections: Sections::default(),
            tool_names: Vec::new(),
            stated_cutters: Vec::new(),
            is_stranger: false,
        }
    }

    /// Appends the motions of the batch and what there is to say about it. A diagnostic of severity `Refusal` means
    /// that the program as a whole cannot be followed: its effect could reach any later block.
    ///
    /// Expressions of the batch whose value is fixed by the program so far become numbers in it.
    pub fn interpret(&mut self, batch: &mut Batch, motions: &mut Vec<Motion>, diagnostics: &mut Diagnostics) {
        self.interpret_each(batch, motions, diagnostics, |_, _| {});
    }

    /// [`Self::interpret`]; after every block `see` gets all motions so far, and where X Y Z \[mm\] and the machine's rotary axes
    /// \[deg\] are then, as far as that is known.
    pub fn interpret_each(
        &mut self,
        batch: &mut Batch,
        motions: &mut Vec<Motion>,
        diagnostics: &mut Diagnostics,
        mut see: impl FnMut(&[Motion], [Option<f64>; 5]),
    ) {
        if self.constants.is_none() {
            self.rules = MotionRules::of(batch.dialect());
            self.begin_dialect();
        }
        self.constants.get_or_insert_with(|| Constants::new(batch.dialect())).evaluate(batch);
        for index in 0..batch.blocks().len() {
            let Some(block) = batch.blocks().get(index).copied() else { break };
            if self.rules.takes_ijk_as_vector && !self.ended && self.takes_vector(batch.words(&block)) {
                batch.name_tool_axis(&block);
            }
            let (batch, block) = (&*batch, &block);
            if self.ended {
                let ends_again =
                    || batch.words(block).iter().any(|word| word.keyword() == Some(Keyword::EndPgm));
                let is_text = block.counts() && block.kind != BlockKind::Percent && !ends_again();
                self.blocks_after_end += u64::from(is_text);
                continue;
            }
            self.run_along(batch, index, block);
            self.interpret_block(batch, index, block, motions, diagnostics);
            see(motions, self.position.axes);
        }
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
            // The first one opens the tape, another one closes it.
            BlockKind::Percent if self.has_blocks => self.end(block.line),
            BlockKind::Percent
            | BlockKind::Blank
            | BlockKind::Comment
            | BlockKind::Banner
            | BlockKind::Header => {}
            BlockKind::Assignment => self.assign(block),
            BlockKind::Call => {
                self.has_blocks = true;
                let text = excerpt(batch, block);
                diagnostics.push(at_block(batch, block, DiagnosticCode::Call { text }));
                self.block.gather(&[]);
                self.opaque(index, block, Unfollowable::Call, motions);
                self.forget_all();
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
                let fault = batch.faults().iter().find(|fault| fault.line == block.line);
                diagnostics.extend(fault.copied());
            }
        }
    }

    /// A control in the same state that runs along to see what a section sets.
    pub(super) fn stranger(&mut self) -> Self {
        let sections = std::mem::take(&mut self.sections);
        let constants = self.constants.take();
        let stranger = Self { is_stranger: true, ..self.clone() };
        (self.sections, self.constants) = (sections, constants);
        stranger
    }

    /// Whether the program has ended (M2, M30, M99, closing `%`): what follows is text.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    /// 1-based line of the block that ended the program, if it has ended.
    #[must_use]
    pub fn end_line(&self) -> Option<u64> {
        self.end_line
    }

    /// How many blocks stand behind the end of the program so far, tape marks and comments apart: they are neither
    /// checked nor followed.
    #[must_use]
    pub fn blocks_after_end(&self) -> u64 {
        self.blocks_after_end
    }

    /// How many words X Y Z A B C so far have a whole number other than 0 and no decimal point, in an ISO program
    /// that writes others with one; 0 where none has a point. Controls that count in least increments read `X10` as
    /// 0.010 mm. Times of a dwell are not counted.
    #[must_use]
    pub fn words_without_point(&self) -> u64 {
        if self.has_points { self.words_without_point } else { 0 }
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
            // Parameters may stand at something else where the section is called.
            for word in words.iter().filter(|word| word.form == WordForm::Evaluated) {
                self.block.unknown |= bit(word.address);
            }
        }
        self.begin_block();
        self.line = block.line;
        if self.unit_from == UnitFrom::Nobody {
            self.ask_for_unit(batch, block, diagnostics);
        }
        let motions_before = motions.len();
        self.has_blocks |= !words.is_empty();
        if self.rules.counts_points {
            self.count_points();
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
            block.flags.is_plain() && self.block.present & (bit(Address::T) | bit(Address::D)) == 0;
        if is_plain && self.block.is_simple() && !self.block.has(Address::O) {
            if let Some(&code) = self.block.g_codes().last() {
                self.set_straight(code);
            }
            self.move_plainly(index, block, motions);
        } else if is_plain && self.is_plain_statement() {
            self.move_plainly(index, block, motions);
        } else if block.flags.has(BlockFlags::DELETE) {
            // The operator decides: only what comes out the same both ways is known behind it.
            let skipped = (self.modal, self.position, self.ended, self.end_line);
            self.see_tools(batch, block);
            self.execute(batch, index, block, motions, diagnostics);
            self.modal = self.modal.common(&skipped.0);
            self.position = self.position.common(&skipped.1);
            (self.ended, self.end_line) = (skipped.2, skipped.3);
            self.obstacle = self.modal.obstacle();
            self.repeats = false;
        } else {
            self.see_tools(batch, block);
            self.execute(batch, index, block, motions, diagnostics);
            self.repeats = false;
        }
        if self.rules.is_of_points && motions.len() > motions_before {
            self.note_shape();
        }
        self.has_motions |= !motions.is_empty();
        if self.rules.has_sections {
            self.sections.count(motions.get(motions_before..).unwrap_or_default());
        }
    }

    #[inline]
    fn set_straight(&mut self, code: Code) {
        self.modal.motion = Some(if code == Code::G(0) { MotionMode::Rapid } else { MotionMode::Linear });
    }

    #[inline]
    fn count_points(&mut self) {
        let axes = self.block.present & AXES & !self.block.unknown;
        let mut without = axes & !self.block.points;
        if axes == 0 || self.block.g_codes().contains(&DWELL) {
            return;
        }
        self.has_points |= without != axes;
        while without != 0 {
            let index = without.trailing_zeros() as usize & 31;
            without &= without - 1;
            self.words_without_point += u64::from(self.block.values[index] != 0.0);
        }
    }

    /// Marks the end of the program.
    pub(super) fn end(&mut self, line: u64) {
        self.ended = true;
        self.end_line = Some(line);
    }

    /// Whether an O number now starts another program.
    pub(super) fn is_under_way(&self) -> bool {
        self.has_motions
    }

    /// Whether the program has moved so far.
    pub(super) fn has_motions(&self) -> bool {
        self.has_motions
    }

    fn assign(&mut self, block: &Block) {
        self.has_blocks = true;
        if block.flags.has(BlockFlags::ASSIGNS_SYSTEM) {
            self.shift_offsets();
        }
    }

    /// A work offset moves: no position is known in the new coordinates.
    pub(super) fn shift_offsets(&mut self) {
        self.modal.shifts = self.modal.shifts.saturating_add(1);
        self.position.forget_axes();
    }

    /// Behind a call.
    pub(super) fn forget_all(&mut self) {
        if self.rules.call_keeps_modes {
            self.modal.forget_conversational();
        } else {
            self.modal.forget();
        }
        if self.rules.is_of_points {
            self.modal.tool_length = Some(ToolLength::Vector);
        }
        self.position.forget_all();
        self.obstacle = self.modal.obstacle();
    }
}

pub(super) fn excerpt(batch: &Batch, block: &Block) -> Excerpt {
    Excerpt::new(batch.block_text(block).trim_ascii())
}

/// A diagnostic of a whole block, from its first byte that is no blank.
pub(super) fn at_block(batch: &Batch, block: &Block, code: DiagnosticCode) -> Diagnostic {
    let text = batch.block_text(block);
    let blanks = text.iter().take_while(|byte| byte.is_ascii_whitespace()).count().min(text.len());
    at_bytes(batch, block, block.start + u32::try_from(blanks).unwrap_or(0), block.body_end, code)
}

/// A diagnostic of some bytes of the batch's text.
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
        column: start.saturating_sub(block.start) + 1,
        span: ByteSpan {
            start: batch.offset() + u64::from(start),
            end: batch.offset() + u64::from(end.max(start)),
        },
    }
}
