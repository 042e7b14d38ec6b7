//! The pass through the blocks: words get values, and assignments take effect after the words.

use super::expression::{Expression, MAX_DEPTH, Mistake, Value, Wrong};
use super::{Parameters, Target};
use crate::program::comment::comment_end;
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Excerpt,
    MAX_MAGNITUDE, Word, WordForm,
};

/// The number of decimals that a computed value is assumed to have.
const EVALUATED_DECIMALS: u8 = 4;
/// Codes that call a program, in tenths. The first three give the program its own parameters, and the last two of them
/// do so at every motion; the others use the caller's parameters.
const OWN_CALLS: [u32; 3] = [650, 660, 661];
const MODAL_CALLS: [u32; 2] = [660, 661];
const END_MODAL_CALL: u32 = 670;
const SHARED_CALLS: [u32; 4] = [960, 970, 980, 1980];
/// G codes of three digits that are not macros of the machine's builder, in tenths.
const PLAIN_CODES: [u32; 12] = [1030, 1070, 1071, 1120, 1121, 1130, 1131, 1500, 1530, 1540, 1870, 2340];
const FIRST_MACRO_CODE: u32 = 1000;
/// Alarms, clocks and messages.
const HARMLESS_PARAMETERS: std::ops::Range<f64> = 3000.0..4000.0;

/// An assignment that has been read and not yet been carried out.
struct Pending {
    target: Target,
    value: Value,
    /// `None`: depends on an unknown value.
    applies: Option<bool>,
}

impl Pending {
    /// Whether the assignment may set a parameter of the control, except alarms and messages, so that offsets may
    /// change.
    fn may_be_system(&self) -> bool {
        let is_own = match self.target {
            Target::Numbered(_) | Target::Named(_) => true,
            Target::Beyond(number) => HARMLESS_PARAMETERS.contains(&number),
            Target::System | Target::Unseen => false,
        };
        !is_own && self.applies != Some(false)
    }
}

impl Parameters {
    /// Goes through the blocks of a batch, which must be the program's next one.
    pub(in crate::program) fn evaluate(&mut self, batch: &mut Batch) {
        for index in 0..batch.blocks.len() {
            let Some(block) = batch.blocks.get(index) else { return };
            let says_nothing = block.kind == BlockKind::Words && block.flags.is_plain();
            if says_nothing && !self.modal_call && self.is_empty() {
                continue;
            }
            let block = *block;
            if let Err(fault) = self.evaluate_block(batch, index, &block) {
                refuse(batch, index, fault);
            }
        }
    }

    /// The value of an operand that is the whole text but for comments; `None` if it is not known.
    pub(in crate::program) fn value_of_text(&mut self, text: &[u8]) -> Option<f64> {
        let mut expression = Expression::new(text, 0, self, false);
        let value = expression.operand().ok()?;
        let (mut at, is_rs274) = (expression.at, expression.is_rs274);
        while let Some(&byte) = text.get(at) {
            match byte {
                b' ' | b'\t' => at += 1,
                b'(' => at = comment_end(text, at).ok()?,
                b';' => break,
                _ => return None,
            }
        }
        self.is_rs274 |= is_rs274;
        value
    }

    fn evaluate_block(&mut self, batch: &mut Batch, index: usize, block: &Block) -> Result<(), Diagnostic> {
        match block.kind {
            BlockKind::Words | BlockKind::Assignment => {}
            BlockKind::Call => {
                let text = batch.block_text(block).trim_ascii_start();
                if text.first().is_some_and(|byte| byte.eq_ignore_ascii_case(&b'o')) {
                    self.is_rs274 = true;
                    self.forget_global(true);
                } else {
                    self.forget_all();
                }
                return Ok(());
            }
            BlockKind::Flow => {
                self.forget_all();
                return Ok(());
            }
            _ => return Ok(()),
        }
        let assignments = if block.flags.has(BlockFlags::ASSIGNS) {
            self.read_assignments(batch, block)?
        } else {
            Vec::new()
        };
        if block.flags.has(BlockFlags::EXPRESSION) {
            self.evaluate_words(batch, block)?;
        }
        // The whole block is read before anything in it is set.
        if block.flags.has(BlockFlags::ASSIGNS_SYSTEM) && !assignments.iter().any(Pending::may_be_system) {
            clear_system(batch, index);
        }
        for Pending { target, value, applies } in assignments {
            self.set(target, value, applies);
        }
        if !self.is_empty() || self.modal_call {
            self.follow_calls(batch.words(block));
        }
        Ok(())
    }

    /// Gives values to words that have expressions.
    fn evaluate_words(&mut self, batch: &mut Batch, block: &Block) -> Result<(), Diagnostic> {
        let line_end = block.body_end as usize;
        let mut is_rs274 = self.is_rs274;
        let range = block.words_start as usize..block.words_end as usize;
        for index in range {
            let Some(word) = batch.words.get(index).copied() else { break };
            if word.form != WordForm::Expression {
                continue;
            }
            let text = batch.text.get(..line_end).unwrap_or_default();
            let start = (word.start + u32::from(word.lead)) as usize;
            let mut expression = Expression::new(text, start, self, true);
            let value = expression.operand().map_err(|wrong| diagnostic(batch, block, wrong))?;
            is_rs274 |= expression.is_rs274;
            let whole = expression.at == word.end as usize;
            let Some(value) = value.filter(|_| whole) else { continue };
            if value.abs() > MAX_MAGNITUDE {
                let (address, max_abs) = (word.address, MAX_MAGNITUDE);
                let code = DiagnosticCode::TooLarge { address, value, max_abs };
                return Err(at_bytes(batch, block, word.start as usize, word.end as usize, code));
            }
            if let Some(word) = batch.words.get_mut(index) {
                // −0 never gets in.
                word.value = value + 0.0;
                word.form = WordForm::Evaluated;
                word.decimals = EVALUATED_DECIMALS;
                word.has_point = true;
            }
        }
        self.is_rs274 = is_rs274;
        Ok(())
    }

    /// The assignments of a block, read with the parameters as they are before it.
    fn read_assignments(&mut self, batch: &Batch, block: &Block) -> Result<Vec<Pending>, Diagnostic> {
        let text = batch.text.get(..block.body_end as usize).unwrap_or_default();
        let mut words = batch.words(block).iter();
        let mut next = words.next();
        let mut pending = Vec::new();
        let always = (!block.flags.has(BlockFlags::DELETE)).then_some(true);
        let mut applies = always;
        let mut expression = Expression::new(text, block.start as usize, self, false);
        while let Some(&byte) = text.get(expression.at) {
            if let Some(word) = next.filter(|word| word.start as usize <= expression.at) {
                expression.at = expression.at.max(word.end as usize);
                next = words.next();
                continue;
            }
            match byte {
                b';' => break,
                b'(' => {
                    // The reader has already refused the line if this is not certain.
                    expression.at = comment_end(text, expression.at).unwrap_or(text.len());
                }
                b'#' => {
                    let read = read_one(&mut expression).map_err(|wrong| diagnostic(batch, block, wrong))?;
                    pending.push(Pending { target: read.0, value: read.1, applies });
                    applies = always;
                }
                byte if byte.is_ascii_alphabetic() => {
                    // IF […] THEN: only this assignment depends on the condition.
                    let name_end = letters_end(text, expression.at);
                    let name = text.get(expression.at..name_end).unwrap_or_default();
                    let is_if = name.eq_ignore_ascii_case(b"IF");
                    expression.at = name_end;
                    if is_if {
                        let condition =
                            expression.operand().map_err(|wrong| diagnostic(batch, block, wrong))?;
                        let holds = condition.map(|condition| condition != 0.0);
                        applies = if holds == Some(false) { holds } else { holds.and(always) };
                    }
                }
                _ => expression.at += 1,
            }
        }
        let is_rs274 = expression.is_rs274;
        self.is_rs274 = is_rs274;
        Ok(pending)
    }

    /// Forgets what a call of this block may change.
    fn follow_calls(&mut self, words: &[Word]) {
        let mut moves = false;
        for word in words {
            let code = word.code_tenths();
            match word.address {
                Address::M if code.is_some_and(|code| SHARED_CALLS.contains(&code)) => self.forget_all(),
                Address::G => {
                    let Some(code) = code else {
                        if word.form != WordForm::Keyword {
                            self.forget_all();
                        }
                        continue;
                    };
                    if code == END_MODAL_CALL {
                        self.modal_call = false;
                    }
                    self.modal_call |= MODAL_CALLS.contains(&code);
                    let is_macro = code >= FIRST_MACRO_CODE && !PLAIN_CODES.contains(&code);
                    if OWN_CALLS.contains(&code) || is_macro {
                        self.forget_global(false);
                    }
                }
                address => moves |= address.is_coordinate(),
            }
        }
        if moves && self.modal_call {
            self.forget_global(false);
        }
    }
}

/// `#… = …`, from its `#` on.
fn read_one(expression: &mut Expression<'_>) -> Result<(Target, Value), Wrong> {
    expression.at += 1;
    let target = expression.target()?;
    expression.skip_blanks();
    if expression.byte() == b'=' {
        expression.at += 1;
    }
    Ok((target, expression.chain()?))
}

fn letters_end(text: &[u8], mut at: usize) -> usize {
    while text.get(at).is_some_and(u8::is_ascii_alphabetic) {
        at += 1;
    }
    at
}

fn diagnostic(batch: &Batch, block: &Block, wrong: Wrong) -> Diagnostic {
    let text = Excerpt::new(batch.text.get(wrong.start..block.body_end as usize).unwrap_or_default());
    let code = match wrong.mistake {
        Mistake::Unexpected => DiagnosticCode::UnexpectedText { text },
        Mistake::Unclosed => DiagnosticCode::Unclosed { text },
        Mistake::Undefined => DiagnosticCode::Undefined { text },
        Mistake::NoFunction => DiagnosticCode::UnknownFunction { text },
        Mistake::TooDeep => DiagnosticCode::TooDeep { text, max: MAX_DEPTH },
    };
    at_bytes(batch, block, wrong.start, wrong.end, code)
}

fn at_bytes(batch: &Batch, block: &Block, start: usize, end: usize, code: DiagnosticCode) -> Diagnostic {
    Diagnostic {
        code,
        line: block.line,
        called: batch.called_line(block),
        column: u32::try_from(start - block.start as usize + 1).unwrap_or(u32::MAX),
        span: ByteSpan { start: batch.offset + start as u64, end: batch.offset + end as u64 },
    }
}

/// The block sets no parameter of the control after all.
fn clear_system(batch: &mut Batch, index: usize) {
    if let Some(block) = batch.blocks.get_mut(index) {
        block.flags.clear(BlockFlags::ASSIGNS_SYSTEM);
    }
}

/// The block cannot be read after all. Its words are removed and the reason is kept.
fn refuse(batch: &mut Batch, index: usize, fault: Diagnostic) {
    if let Some(block) = batch.blocks.get_mut(index) {
        block.kind = BlockKind::Malformed;
        block.words_end = block.words_start;
    }
    let line = |fault: &Diagnostic| (fault.line, fault.called.map(|called| called.line));
    let place = batch.faults.partition_point(|other| line(other) <= line(&fault));
    batch.faults.insert(place, fault);
}
