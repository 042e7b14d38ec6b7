//! Calls of subprograms and files, and the ways back.

use super::run::{Caller, Course, Own, ProgramRun};
use crate::program::course::{Callee, Piece, PlaceName};
use crate::program::{Batch, DiagnosticCode, Dialect};

/// The most calls inside each other. Controls allow between 4 and 16.
const MAX_CALLS: usize = 32;

impl ProgramRun {
    /// A call of an O word. A subprogram that is in no file is called as an ordinary block.
    pub(super) fn call_own(&mut self, name: Option<&PlaceName>, arguments: &[Piece]) -> Course {
        let Some(name) = name else { return Course::Show };
        let within =
            |file: usize| self.turns.subprogram(name, &self.files.blocks(file)).map(|turn| (file, turn));
        let found = within(self.file).or_else(|| within(self.files.named(name)?)).or_else(|| within(0));
        let Some((file, begin)) = found else { return Course::Show };
        let Some(begin) = self.turns.get(begin).filter(|turn| turn.partner.is_some()) else {
            return Course::Refuse;
        };
        let begin = begin.block + 1;
        let values: Vec<_> = arguments.iter().map(|piece| self.value(*piece)).collect();
        let course = self.enter(begin, file, 1, Own::Parameters);
        if matches!(course, Course::GoOn(_)) {
            self.constants.enter(&values);
        }
        course
    }

    /// A call of a program, a file or a label.
    pub(super) fn call(&mut self, name: Option<&PlaceName>, callee: Callee, times: u32) -> Course {
        let Some(name) = name else { return Course::Show };
        if callee != Callee::File
            && let Some(place) = self.turns.place(name, &self.files.blocks(self.file))
        {
            return self.enter(place + 1, self.file, times, Own::Nothing);
        }
        if callee == Callee::Place {
            return Course::Show;
        }
        let Some(file) = self.files.named(name) else { return Course::Show };
        // A file may have several programs.
        let place = self.turns.place(name, &self.files.body(file)).filter(|_| callee == Callee::Program);
        if place.is_none()
            && callee == Callee::Program
            && self.files.name(file).is_some_and(|own| own != name)
        {
            // The control would know the file by the number in its text.
            return Course::Show;
        }
        let begin = place.map_or(self.files.body(file).start, |place| place + 1);
        let course = self.enter(begin, file, times, Own::Variables);
        if matches!(course, Course::GoOn(_)) {
            self.constants.enter_file();
        }
        course
    }

    fn enter(&mut self, begin: usize, file: usize, times: u32, own: Own) -> Course {
        if self.callers.len() >= MAX_CALLS {
            return Course::Fail(DiagnosticCode::CallsTooDeep { text: self.excerpt(), max: MAX_CALLS });
        }
        let repetitions = std::mem::take(&mut self.repetitions);
        let (again, back) = (times.saturating_sub(1), self.at + 1);
        let line = self.line();
        self.callers.push(Caller { back, begin, file: self.file, line, again, own, repetitions });
        self.file = file;
        self.called.insert(file);
        Course::GoOn(begin)
    }

    /// A called file has no more blocks.
    pub(super) fn end_of_file(&mut self) -> Course {
        let dialect = self.batches.first().map_or(Dialect::Iso, Batch::dialect);
        if dialect.rules().file_end_returns {
            return self.return_from_call(true);
        }
        self.step_back_into_the_text();
        Course::Fail(DiagnosticCode::NoReturn { text: self.excerpt() })
    }

    /// The end of a called text. `shows`: without a call, the statement is an ordinary block.
    pub(super) fn return_from_call(&mut self, shows: bool) -> Course {
        match self.callers.last_mut() {
            Some(caller) if caller.again > 0 => {
                caller.again -= 1;
                self.repetitions.clear();
                let begin = caller.begin;
                if caller.own == Own::Variables {
                    self.constants.leave_file();
                    self.constants.enter_file();
                }
                return Course::GoOn(begin);
            }
            Some(_) => {}
            None if shows => return Course::Show,
            None => return Course::GoOn(self.at + 1),
        }
        let Some(caller) = self.callers.pop() else { return Course::Refuse };
        match caller.own {
            Own::Nothing => {}
            Own::Parameters => self.constants.leave(),
            Own::Variables => self.constants.leave_file(),
        }
        self.file = caller.file;
        self.repetitions = caller.repetitions;
        Course::GoOn(caller.back)
    }
}
