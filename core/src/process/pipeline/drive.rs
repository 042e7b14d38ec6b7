//! The driver. These pieces of work run side by side if threads are free: one stretch of the program is worked on and
//! written, the next one is prepared, the one after that is read, the text written before is read back, and the text
//! read back before that is handed over. The result does not depend on which thread does which work.

use std::io::Write;

use super::outgoing::Outgoing;
use super::read_back::{Expected, ReadBack};
use super::rewriter::Rewriter;
use super::surveyed::Surveyed;
use crate::machine::Machine;
use crate::process::fault::{Fault, Warnings};
use crate::process::set_up::{ProgramSetup, Stop};
use crate::process::text::{Inventory, LineCursor, Passages, ProgramSource, Stretch};
use crate::program::Dialect;
use crate::side_by_side::SideBySide;

/// A program, and its line maps back to the upload from which it was written.
pub(in crate::process) struct Upstream<'a> {
    pub(in crate::process) source: &'a dyn ProgramSource,
    /// Cursors from its lines to those of the upload, one after the other.
    pub(in crate::process) lines: Vec<LineCursor<'a>>,
}

impl<'a> Upstream<'a> {
    /// The upload itself.
    pub(in crate::process) fn upload(source: &'a dyn ProgramSource) -> Self {
        Self { source, lines: Vec::new() }
    }
}

/// A step that writes: its work on the motions of a program.
pub(in crate::process) trait StepWork: Send {
    /// What the next motion of the written program must be.
    type Expected: Expected + Send;
    /// The check that reads the written program back.
    type Checker: StepCheck<Expected = Self::Expected>;

    /// Works on a stretch. Returns true at its end, and false if enough is written to be handed over.
    fn write(&mut self, stretch: &Stretch, out: &mut Outgoing<Self::Expected>) -> Result<bool, Fault>;
    /// Writes the text held back until the program's end.
    fn end(&mut self, _out: &mut Outgoing<Self::Expected>) -> Result<(), Fault> {
        Ok(())
    }
    /// Receives the findings of the read-back and the inventory read so far. It is called between two rounds, so
    /// that the result does not depend on timing. Refuses to continue if the cost exceeds its limit.
    fn hear(&mut self, check: &Self::Checker, read: &Inventory) -> Result<(), Fault>;
    /// Whether the program has a fault that refuses it. It is then read to its end without writing, so that every
    /// fault is listed.
    fn has_faults(&self) -> bool;
    /// Refuses a program that was read to its end, if its lines have faults or if the step could follow nothing.
    ///
    /// # Errors
    /// The reason.
    fn refuse(&mut self, surveyed: &Surveyed<'_>, passages: &Passages<'_>) -> Result<(), Fault>;
    /// The warnings of the step, for those about the text as a whole.
    fn warnings(&mut self) -> &mut Warnings;
    /// The writer of the step.
    fn rewriter(&self) -> &Rewriter;
}

/// Reads the written program back.
pub(in crate::process) trait StepCheck: Send {
    /// What the next motion must be.
    type Expected: Expected;
    /// The result for one motion.
    type Outcome;

    /// The reader of the written text.
    fn read_back(&mut self) -> &mut ReadBack<Self::Expected>;
    /// Compares every motion that has arrived with what it must be. `of` is the stretch from which the text was
    /// written. Copied motions refer to it.
    fn compare(&mut self, of: &Stretch) -> Result<(), Fault>;
    /// Reads this text, which was written from this stretch.
    fn take(&mut self, written: &mut Outgoing<Self::Expected>, of: &Stretch) -> Result<(), Fault> {
        self.read_back().expect_all(&mut written.expected);
        self.read_back().feed(&written.text);
        self.compare(of)
    }
    /// Called at the end of the output. Every expected motion must have been read, and nothing of the source may be
    /// lost or doubled.
    fn finish(&mut self, source: &Inventory) -> Result<(), Fault> {
        self.read_back().end();
        self.compare(&Stretch::default())?;
        self.read_back().is_whole(source)
    }
    /// The results of the motions read back. The caller takes them away.
    fn outcomes(&mut self) -> &mut Vec<Self::Outcome>;
}

/// Prepares stretches in program order, before they are worked on.
pub(in crate::process) trait Prepare: Send {
    /// Prepares the next stretch.
    fn prepare(&mut self, stretch: &mut Stretch);
    /// Whether it gives tool vectors their words. Otherwise they get them while the program is read.
    fn resolves_vectors(&self) -> bool {
        false
    }
    /// The inventory of everything prepared.
    fn inventory(&self) -> &Inventory;
}

/// Counts, and leaves stretches unchanged.
impl Prepare for Inventory {
    fn prepare(&mut self, stretch: &mut Stretch) {
        stretch.passages.iter().for_each(|passage| self.see(&passage.batch));
    }

    fn inventory(&self) -> &Inventory {
        self
    }
}

/// Looks at a program while a step works on it, and changes nothing.
pub(in crate::process) trait Look: Send {
    /// Begins a program.
    ///
    /// # Errors
    /// The program cannot be read, or the caller no longer waits.
    fn begin(&mut self, surveyed: &Surveyed<'_>, dialect: Dialect) -> Result<(), Fault>;
    /// Looks at the next prepared stretch.
    fn look(&mut self, stretch: &Stretch);
    /// Called at the end of the program that `passages` read.
    ///
    /// # Errors
    /// The caller no longer waits.
    fn finish(&mut self, passages: &Passages<'_>) -> Result<(), Fault>;
}

/// Receives the result of each motion, in program order.
pub(in crate::process) type Note<'n, B> = &'n mut dyn FnMut(&B) -> Result<(), Fault>;

/// The workers of a step.
pub(in crate::process) struct Hands<'h, 'l, S: StepWork> {
    pub(in crate::process) prepare: &'h mut dyn Prepare,
    pub(in crate::process) work: &'h mut S,
    pub(in crate::process) check: &'h mut S::Checker,
    pub(in crate::process) look: Option<&'h mut (dyn Look + 'l)>,
}

/// The progress of a program through a step.
pub(in crate::process) struct StepRun<'a> {
    pub(in crate::process) passages: Passages<'a>,
    /// The finished stretch, whose text has still to be read back.
    worked_off: Stretch,
    present: Stretch,
    next: Stretch,
    coming: Stretch,
    stop: &'a Stop<'a>,
}

impl<'a> StepRun<'a> {
    /// Begins to read a surveyed program that `prepare` will prepare.
    pub(in crate::process) fn begin(
        Upstream { source, lines }: Upstream<'a>,
        surveyed: &Surveyed<'_>,
        machine: &Machine,
        program: &ProgramSetup,
        prepare: &dyn Prepare,
        stop: &'a Stop<'a>,
    ) -> Result<Self, Fault> {
        let mut passages = Passages::open(source, machine, program)?.with_lines(lines);
        if !surveyed.is_whole {
            passages = passages.surveying(machine);
        }
        if prepare.resolves_vectors() {
            passages = passages.leaving_vectors();
        }
        let (mut present, mut next) = (Stretch::default(), Stretch::default());
        let mut fill = |stretch: &mut Stretch| {
            passages.fill(stretch, stop).map_err(|fault| surveyed.before_the_end(fault))
        };
        fill(&mut present)?;
        fill(&mut next)?;
        let (worked_off, coming) = Default::default();
        Ok(Self { passages, worked_off, present, next, coming, stop })
    }

    /// The dialect of the text read.
    pub(in crate::process) fn dialect(&self) -> Dialect {
        self.passages.dialect()
    }

    /// Takes the program through a step. At its end, everything written was read back, and the text is complete.
    ///
    /// # Errors
    /// Why the program is refused; `output` then holds text that must not be run.
    pub(in crate::process) fn run<S: StepWork>(
        &mut self,
        mut hands: Hands<'_, '_, S>,
        surveyed: &Surveyed<'_>,
        output: &mut (dyn Write + Send),
        note: Note<'_, <S::Checker as StepCheck>::Outcome>,
        parts: &dyn SideBySide,
    ) -> Result<(), Fault> {
        if let Some(look) = &mut hands.look {
            look.begin(surveyed, self.dialect())?;
        }
        self.go_through(&mut hands, output, note, parts).map_err(|fault| surveyed.before_the_end(fault))?;
        surveyed.confirm(self.passages.survey())?;
        self.passages.refusals()?;
        if self.passages.motions == 0 {
            return Err(Fault::NoMotion);
        }
        hands.work.refuse(surveyed, &self.passages)?;
        hands.finish(&self.passages, output, note)?;
        self.passages.warn(hands.work.warnings());
        Ok(())
    }

    /// Works on all stretches. The text written last still has to be [finished](Hands::finish).
    fn go_through<S: StepWork>(
        &mut self,
        hands: &mut Hands<'_, '_, S>,
        output: &mut (dyn Write + Send),
        note: Note<'_, <S::Checker as StepCheck>::Outcome>,
        parts: &dyn SideBySide,
    ) -> Result<(), Fault> {
        let Self { passages, worked_off, present, next, coming, stop } = self;
        let Hands { prepare, work, check, look } = hands;
        prepare.prepare(present);
        let (mut is_of_present, mut is_next_prepared, mut has_ended) = (false, false, false);
        let (mut writing, mut written) = (Outgoing::default(), Outgoing::default());
        // Text that was read back, and is handed over beside the work of the next round.
        let mut checked_text = Vec::new();
        while !present.passages.is_empty() || !has_ended || !written.text.is_empty() {
            if stop().is_break() {
                return Err(Fault::Cancelled);
            }
            let is_refused = passages.is_refused();
            if present.passages.is_empty() && !has_ended {
                has_ended = true;
                if !is_refused {
                    work.end(&mut writing)?;
                }
            }
            let written_of = if is_of_present { &*present } else { &*worked_off };
            let (mut worked, mut checked, mut filled, mut handed_over) = (Ok(true), Ok(()), Ok(()), Ok(()));
            // The longest part first: a worker that finishes takes the next part.
            parts.run(vec![
                Box::new(|| {
                    if coming.passages.is_empty() {
                        filled = passages.fill(coming, stop);
                    }
                }),
                Box::new(|| {
                    if !is_refused && !present.passages.is_empty() {
                        worked = work.write(present, &mut writing);
                    }
                }),
                Box::new(|| {
                    if !is_refused && !is_next_prepared {
                        prepare.prepare(next);
                    }
                }),
                Box::new(|| checked = check.take(&mut written, written_of)),
                Box::new(|| handed_over = output.write_all(&checked_text)),
                Box::new(|| {
                    if !is_refused
                        && !is_of_present
                        && let Some(look) = look
                    {
                        look.look(present);
                    }
                }),
            ]);
            checked?;
            handed_over?;
            checked_text.clear();
            std::mem::swap(&mut checked_text, &mut written.text);
            check.outcomes().drain(..).try_for_each(|outcome| note(&outcome))?;
            let is_worked_off = worked?;
            filled?;
            if !is_refused {
                work.hear(check, prepare.inventory())?;
            }
            written.clear();
            if is_refused || work.has_faults() {
                writing.clear();
            }
            std::mem::swap(&mut writing, &mut written);
            is_of_present = true;
            is_next_prepared = true;
            if is_refused || is_worked_off {
                passages.recycle_all(worked_off);
                *worked_off = std::mem::replace(present, std::mem::replace(next, std::mem::take(coming)));
                is_of_present = false;
                is_next_prepared = false;
            }
        }
        Ok(output.write_all(&checked_text)?)
    }
}

impl<S: StepWork> Hands<'_, '_, S> {
    /// Finishes a program without faults: everything must have been read back.
    fn finish(
        &mut self,
        passages: &Passages<'_>,
        output: &mut (dyn Write + Send),
        note: Note<'_, <S::Checker as StepCheck>::Outcome>,
    ) -> Result<(), Fault> {
        let Self { prepare, work, check, look } = self;
        check.finish(&work.rewriter().inventory(prepare.inventory()))?;
        check.outcomes().drain(..).try_for_each(|outcome| note(&outcome))?;
        output.flush()?;
        look.as_mut().map_or(Ok(()), |look| look.finish(passages))
    }
}
