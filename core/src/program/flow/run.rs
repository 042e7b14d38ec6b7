//! Runs a program: one run of blocks after the other, until a statement changes the course.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU16;

use super::files::{Files, SubprogramFile};
use super::places::{Turn, Turns};
use crate::program::course::{
    Comparison, EndInCall, Piece, PlaceName, Search, Statement, Step, Structure, When,
};
use crate::program::{Batch, Block, BlockKind, Constants, DiagnosticCode, Dialect, Excerpt};

/// The most blocks and statements that a program runs. A control has no such bound, but a program that reaches this one
/// is most likely one that never ends.
const MAX_STEPS: u64 = 250_000;
/// Bytes of an expression that count as one more statement.
const STEP_BYTES: u64 = 32;

/// Numbers that differ by less than this share may compare either way in the arithmetic of another control.
const ON_EDGE: f64 = 1e-9;

/// How two numbers compare; `None` if the result depends on the last digits.
fn order(left: f64, right: f64) -> Option<Ordering> {
    let order = left.partial_cmp(&right)?;
    let is_certain = order.is_eq() || (left - right).abs() > ON_EDGE * left.abs().max(right.abs()).max(1.0);
    is_certain.then_some(order)
}

/// What a called text does not share with its caller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Own {
    Nothing,
    /// Its parameters.
    Parameters,
    /// The variables of its file.
    Variables,
}

/// What calls the present text.
#[derive(Debug)]
pub(super) struct Caller {
    /// The block after the call.
    pub(super) back: usize,
    /// The block at which the called text begins.
    pub(super) begin: usize,
    /// The file of the caller, and the line of the call in it.
    pub(super) file: usize,
    pub(super) line: u64,
    /// How often it still runs after this time.
    pub(super) again: u32,
    /// What it does not share with its caller.
    pub(super) own: Own,
    /// The repetitions of the caller that are under way.
    pub(super) repetitions: BTreeMap<usize, u64>,
}

/// The effect of a statement.
pub(super) enum Course {
    /// The next block to run.
    GoOn(usize),
    /// The statement is an ordinary block.
    Show,
    /// The statement ends the run.
    Refuse,
    /// It ends the run with this fact.
    Fail(DiagnosticCode),
}

/// A program that is run block by block. Conditions are computed from the values that the text fixes.
#[derive(Debug)]
pub struct ProgramRun {
    pub(super) batches: Vec<Batch>,
    /// The index of the first block of every batch.
    first_blocks: Vec<usize>,
    pub(super) files: Files,
    /// The name of the main program's head.
    main_head: Option<PlaceName>,
    /// The file of the next block.
    pub(super) file: usize,
    pub(super) turns: Turns,
    pub(super) constants: Constants,
    /// The next block.
    pub(super) at: usize,
    pub(super) callers: Vec<Caller>,
    /// How often repetitions still have to run, by the index of their turn.
    pub(super) repetitions: BTreeMap<usize, u64>,
    /// The files that were called so far.
    pub(super) called: BTreeSet<usize>,
    steps: u64,
    pub(super) has_ended: bool,
}

impl ProgramRun {
    /// The run of the program in these batches, from the block that begins at this byte of the upload on. Before it,
    /// the program has run in the order of its text. It calls these files.
    #[must_use]
    pub fn new(mut batches: Vec<Batch>, from: u64, subprograms: Vec<SubprogramFile>) -> Self {
        let main_blocks = batches.iter().map(|batch| batch.blocks().len()).sum();
        let files = Files::new(main_blocks, &subprograms);
        batches.extend(subprograms.into_iter().flat_map(|file| file.batches));
        let mut first_blocks = Vec::with_capacity(batches.len());
        let mut blocks = 0;
        for batch in &batches {
            first_blocks.push(blocks);
            blocks += batch.blocks().len();
        }
        let dialect = batches.first().map_or(Dialect::Iso, Batch::dialect);
        let turns = Turns::of(&batches, &files.starts());
        let in_main = (0..).map_while(|index| turns.get(index)).take_while(|turn| turn.block < main_blocks);
        let mut heads = in_main.filter(|turn| turn.statement.step == Step::Head);
        let main_head = heads.find_map(|turn| turn.statement.name.clone());
        let mut run = Self {
            batches,
            first_blocks,
            files,
            main_head,
            file: 0,
            turns,
            constants: Constants::new(dialect),
            at: 0,
            callers: Vec::new(),
            repetitions: BTreeMap::new(),
            called: BTreeSet::new(),
            steps: 0,
            has_ended: false,
        };
        run.pass_to(from);
        run
    }

    /// How many of the files beside the main program no call has reached so far.
    #[must_use]
    pub fn files_never_called(&self) -> usize {
        (1..self.files.count()).filter(|file| !self.called.contains(file)).count()
    }

    /// Evaluates the blocks of the main program before this byte.
    fn pass_to(&mut self, from: u64) {
        let mut passed = Batch::new();
        let end = self.files.blocks(0).end;
        let of_main = self.batches.iter().zip(&self.first_blocks).filter(|(_, first)| **first < end);
        for (batch, first) in of_main {
            let before = |block: &Block| batch.offset() + u64::from(block.start) < from;
            let count = batch.blocks().partition_point(before);
            batch.copy_blocks(0, count, &mut passed);
            self.constants.evaluate(&mut passed);
            self.at = first + count;
            if count < batch.blocks().len() {
                break;
            }
        }
    }

    /// Fills `batch` with the next blocks that run; false if there are none.
    pub fn next_batch(&mut self, batch: &mut Batch) -> bool {
        while !self.has_ended {
            let end = self.files.body(self.file).end;
            let turn = self.turns.first_at(self.at);
            let stop = self.turns.get(turn).map_or(end, |turn| turn.block.min(end));
            if self.at >= end && self.file == 0 {
                break;
            }
            if stop > self.at {
                self.run_blocks(stop, batch);
                return true;
            }
            self.steps += 1;
            let course = if self.steps > MAX_STEPS {
                self.step_back_into_the_text();
                Course::Fail(DiagnosticCode::RunsTooLong { text: self.excerpt(), max: MAX_STEPS })
            } else if self.at >= end {
                self.end_of_file()
            } else {
                self.obey(turn)
            };
            match course {
                Course::GoOn(next) => self.at = next,
                Course::Show => {
                    self.copy(self.at + 1, batch);
                    self.constants.evaluate(batch);
                    batch.is_evaluated = true;
                    self.at += 1;
                    return true;
                }
                Course::Refuse => return self.end_with(BlockKind::Flow, None, batch),
                Course::Fail(code) => return self.end_with(BlockKind::Malformed, Some(code), batch),
            }
        }
        false
    }

    /// Runs ordinary blocks up to `stop`, as far as one batch goes.
    fn run_blocks(&mut self, stop: usize, batch: &mut Batch) {
        let from = self.at;
        self.at = self.copy(stop, batch);
        self.constants.evaluate(batch);
        batch.is_evaluated = true;
        self.steps += (self.at - from) as u64;
    }

    /// Copies the blocks from the present one to `stop`, as far as one batch goes. Returns where they end.
    pub(super) fn copy(&self, stop: usize, batch: &mut Batch) -> usize {
        let Some((source, first)) = self.batch_of(self.at) else { return stop };
        let last = stop.min(first + source.blocks().len());
        source.copy_blocks(self.at - first, last - first, batch);
        if let Some(file) = u16::try_from(self.file).ok().and_then(NonZeroU16::new) {
            let calls = self.callers.iter().rev();
            let from_main = calls.clone().find(|caller| caller.file == 0).or(calls.clone().next_back());
            let line = from_main.map_or(0, |caller| caller.line);
            batch.call_from(line, file, self.files.file_name(self.file));
        }
        last
    }

    /// The batch of a block, and the index of its first block.
    fn batch_of(&self, block: usize) -> Option<(&Batch, usize)> {
        let index = self.first_blocks.partition_point(|first| *first <= block).checked_sub(1)?;
        self.batches.get(index).zip(self.first_blocks.get(index).copied())
    }

    /// The line of the present block in its file.
    pub(super) fn line(&self) -> u64 {
        let Some((batch, first)) = self.batch_of(self.at) else { return 0 };
        batch.blocks().get(self.at - first).map_or(0, |block| block.line)
    }

    /// The text of the present block.
    fn text(&self) -> &[u8] {
        let Some((batch, first)) = self.batch_of(self.at) else { return &[] };
        batch.blocks().get(self.at - first).map_or(&[], |block| batch.block_text(block))
    }

    pub(super) fn excerpt(&self) -> Excerpt {
        Excerpt::new(self.text().trim_ascii())
    }

    /// The value of a piece of the present block. A long expression counts as several statements.
    pub(super) fn value(&mut self, piece: Piece) -> Option<f64> {
        let text = piece.of(self.text()).trim_ascii().to_vec();
        self.steps += text.len() as u64 / STEP_BYTES;
        self.constants.value(&text)
    }

    fn holds(&mut self, piece: Option<Piece>) -> Option<bool> {
        self.value(piece?).map(|value| value != 0.0)
    }

    /// What the statement at the present block does.
    fn obey(&mut self, index: usize) -> Course {
        let Some(Turn { statement, partner, .. }) = self.turns.get(index) else { return Course::Refuse };
        let (Statement { name, step, .. }, partner) = (statement.clone(), *partner);
        let next = Course::GoOn(self.at + 1);
        let opens = matches!(step, Step::Open(..) | Step::Count { .. } | Step::Else(_));
        if opens && partner.is_none() {
            // The structure never ends.
            return Course::Refuse;
        }
        match step {
            Step::End(end) if self.file > 0 => match end {
                EndInCall::EndsAll => Course::Show,
                EndInCall::Returns => self.return_from_call(true),
                EndInCall::NotFollowed => Course::Refuse,
            },
            Step::Head if self.file > 0 => match name {
                Some(name) if self.main_head.as_ref() != Some(&name) => Course::Refuse,
                _ => next,
            },
            Step::NotInCall if self.file > 0 => Course::Refuse,
            Step::NotInSub if self.callers.iter().any(|caller| caller.own == Own::Parameters) => {
                Course::Refuse
            }
            Step::Plain | Step::End(_) | Step::Entry | Step::Head | Step::NotInCall | Step::NotInSub => {
                Course::Show
            }
            Step::NotFollowed => Course::Refuse,
            Step::Open(Structure::Sub, _) | Step::Else(_) => self.after(self.turns.end_of(index)),
            Step::Open(Structure::While, piece) if partner.is_some_and(|partner| partner < index) => {
                // The end of `DO`.
                self.either(piece, |run| run.after(partner), |_| next)
            }
            Step::Open(Structure::If, piece) => self.either(piece, |_| next, |run| run.branch(partner)),
            Step::Open(Structure::While, piece) => {
                self.either(piece, |_| next, |run| run.after(run.turns.end_of(index)))
            }
            Step::Open(Structure::Repeat, piece) => match piece.and_then(|piece| self.value(piece)) {
                Some(times) if times >= 1.0 => {
                    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
                    self.repetitions.insert(index, times as u64);
                    next
                }
                Some(_) => self.after(self.turns.end_of(index)),
                None => Course::Refuse,
            },
            Step::Label
            | Step::Open(Structure::Do | Structure::Until | Structure::Loop | Structure::For, _) => next,
            Step::Count { variable, first, last } => self.begin_count(index, [variable, first, last]),
            Step::Close(_, piece) => self.close(partner, piece),
            Step::Break => self.after(partner.and_then(|open| self.turns.end_of(open))),
            Step::Continue => self.go_to_condition(partner),
            Step::Return => self.return_from_call(true),
            Step::ReturnIfCalled => self.return_from_call(false),
            Step::CallOwn(arguments) => self.call_own(name.as_ref(), &arguments),
            Step::Call(callee, times) => self.call(name.as_ref(), callee, times),
            Step::GoBack(times) => self.go_back(index, name.as_ref(), times),
            Step::Jump { search, when, may_lack } => {
                let Some(holds) = self.is_time(&when) else { return Course::Refuse };
                if !holds {
                    return next;
                }
                match name.and_then(|name| self.turns.find(&name, search, self.at)) {
                    Some(block) => Course::GoOn(block),
                    None if may_lack => next,
                    None => Course::Refuse,
                }
            }
            Step::Select { value, places } => self.select(value, &places),
        }
    }

    /// Goes on after the statement of this index.
    fn after(&self, index: Option<usize>) -> Course {
        match index.and_then(|index| self.turns.get(index)) {
            Some(turn) => Course::GoOn(turn.block + 1),
            None => Course::Refuse,
        }
    }

    fn either(
        &mut self,
        condition: Option<Piece>,
        holds: impl FnOnce(&mut Self) -> Course,
        fails: impl FnOnce(&mut Self) -> Course,
    ) -> Course {
        match self.holds(condition) {
            Some(true) => holds(self),
            Some(false) => fails(self),
            None => Course::Refuse,
        }
    }

    /// The next branch of an IF whose condition did not hold.
    fn branch(&mut self, mut partner: Option<usize>) -> Course {
        while let Some(turn) = partner.and_then(|index| self.turns.get(index)) {
            let block = turn.block;
            self.steps += 1;
            match turn.statement.step {
                Step::Else(Some(piece)) => {
                    let after = turn.partner;
                    // Its text is that of its own block.
                    self.at = block;
                    match self.holds(Some(piece)) {
                        Some(true) => return Course::GoOn(block + 1),
                        Some(false) => partner = after,
                        None => return Course::Refuse,
                    }
                }
                _ => return Course::GoOn(block + 1),
            }
        }
        Course::Refuse
    }

    /// The end of a structure.
    fn close(&mut self, partner: Option<usize>, condition: Option<Piece>) -> Course {
        let next = Course::GoOn(self.at + 1);
        let Some((open, turn)) = partner.and_then(|open| Some((open, self.turns.get(open)?))) else {
            return Course::Refuse;
        };
        let (block, step) = (turn.block, turn.statement.step.clone());
        match step {
            Step::Open(Structure::If, _) => next,
            Step::Open(Structure::Sub, _) => self.return_from_call(true),
            Step::Open(Structure::While, _) => Course::GoOn(block),
            Step::Open(Structure::Loop, _) => Course::GoOn(block + 1),
            Step::Open(Structure::Until, _) => self.either(condition, |_| next, |_| Course::GoOn(block + 1)),
            Step::Open(Structure::Repeat, _) => {
                let left = self.repetitions.get(&open).copied().unwrap_or(0).saturating_sub(1);
                self.repetitions.insert(open, left);
                if left > 0 { Course::GoOn(block + 1) } else { next }
            }
            Step::Count { variable, last, .. } => {
                let end = self.at;
                self.at = block;
                let name = variable.of(self.text()).to_vec();
                if !self.constants.count(&name, &name, b"+1") {
                    return Course::Refuse;
                }
                match self.count_goes_on(variable, last) {
                    Some(true) => Course::GoOn(block + 1),
                    Some(false) => Course::GoOn(end + 1),
                    None => Course::Refuse,
                }
            }
            _ => Course::Refuse,
        }
    }

    fn begin_count(&mut self, index: usize, [variable, first, last]: [Piece; 3]) -> Course {
        let end = self.turns.end_of(index);
        let (name, from) = (variable.of(self.text()).to_vec(), first.of(self.text()).trim_ascii().to_vec());
        if !self.constants.count(&name, &from, b"") {
            return Course::Refuse;
        }
        match self.count_goes_on(variable, last) {
            Some(true) if end.is_some() => Course::GoOn(self.at + 1),
            Some(false) => self.after(end),
            _ => Course::Refuse,
        }
    }

    fn count_goes_on(&mut self, variable: Piece, last: Piece) -> Option<bool> {
        order(self.value(variable)?, self.value(last)?).map(Ordering::is_le)
    }

    /// Goes to where a loop decides whether it runs again.
    fn go_to_condition(&self, open: Option<usize>) -> Course {
        let Some((open, turn)) = open.and_then(|open| Some((open, self.turns.get(open)?))) else {
            return Course::Refuse;
        };
        match turn.statement.step {
            Step::Open(Structure::While, _) => Course::GoOn(turn.block),
            _ => match self.turns.end_of(open).and_then(|end| self.turns.get(end)) {
                Some(end) => Course::GoOn(end.block),
                None => Course::Refuse,
            },
        }
    }

    fn is_time(&mut self, when: &When) -> Option<bool> {
        match when {
            When::Always => Some(true),
            When::Holds(piece) => self.holds(Some(*piece)),
            When::Compares(left, comparison, right) => {
                let order = order(self.value(*left)?, self.value(*right)?)?;
                Some(match comparison {
                    Comparison::Equal => order.is_eq(),
                    Comparison::Unequal => order.is_ne(),
                    Comparison::Greater => order.is_gt(),
                    Comparison::Less => order.is_lt(),
                })
            }
        }
    }

    fn select(&mut self, value: Piece, places: &[(Option<Piece>, Search, PlaceName)]) -> Course {
        let Some(value) = self.value(value) else { return Course::Refuse };
        for (constant, search, name) in places {
            let fits = match constant {
                Some(constant) => match self.value(*constant).and_then(|constant| order(constant, value)) {
                    Some(order) => order.is_eq(),
                    None => return Course::Refuse,
                },
                None => true,
            };
            if fits {
                let found = self.turns.find(name, *search, self.at);
                return found.map_or(Course::Refuse, Course::GoOn);
            }
        }
        Course::GoOn(self.at + 1)
    }

    /// `CALL LBL 5 REP 2`: the text from the label to here runs twice more.
    fn go_back(&mut self, index: usize, name: Option<&PlaceName>, times: u32) -> Course {
        let here = self.files.blocks(self.file);
        let place = name.and_then(|name| self.turns.place(name, &here)).filter(|place| *place < self.at);
        let Some(place) = place else { return Course::Refuse };
        let left = self.repetitions.get(&index).copied().unwrap_or(u64::from(times));
        if left == 0 {
            self.repetitions.remove(&index);
            return Course::GoOn(self.at + 1);
        }
        self.repetitions.insert(index, left - 1);
        Course::GoOn(place + 1)
    }
}
