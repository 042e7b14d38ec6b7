//! A program read piece by piece: from text to blocks and motions.

use crate::contact::TipLook;
use crate::kinematics::ToolPose;
use crate::process::set_up::Stop;
use std::collections::VecDeque;
use std::io::Read;
use std::ops::ControlFlow;
use std::sync::Arc;

use super::course::run_from;
use super::line_map::LineCursor;
use super::radius_path::RadiusPath;
use super::reading::ProgramReading;
use super::source::{CHUNK_BYTES, ProgramSource, read_some};
use super::survey::Survey;
use super::surveyor::Surveyor;
use crate::machine::Machine;
use crate::motion::{Interpreter, InterpreterOptions, Motion, StatedCutter, ToolName};
use crate::process::fault::{Fault, WarningKind, Warnings};
use crate::process::set_up::{ProgramSetup, ToolVectors, Tooling};
use crate::program::{Batch, Diagnostics, Dialect, ProgramRun, ReadLimits, Reader, Severity};

/// The tool in W at the end of a motion and half way along it, by interpolation mode. Both are next to each other
/// in memory, because they are used one after the other. The poses of a motion without known ends are not used.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct MotionPoses {
    pub(in crate::process) end: ToolPose,
    pub(in crate::process) middle: ToolPose,
}

/// A batch of blocks with the motions they make.
#[derive(Debug, Default)]
pub(in crate::process) struct Passage {
    pub(in crate::process) batch: Batch,
    pub(in crate::process) motions: Vec<Motion>,
    /// One for each motion, after they are [prepared](crate::process::contact_path::Preparation).
    pub(in crate::process) poses: Vec<MotionPoses>,
    /// One for each motion, after they are prepared, if every contact is the tip. Otherwise empty.
    pub(in crate::process) looks: Vec<TipLook>,
    /// Positions of X Y Z \[mm\] and of the rotary axes \[deg\] after each motion, as far as known. Filled only if
    /// [asked for](Passages::keeping_positions).
    pub(in crate::process) positions: Vec<[Option<f64>; 5]>,
}

impl Passage {
    /// The text of a motion's block; empty if the block was in an earlier passage.
    pub(in crate::process) fn block_text(&self, motion: &Motion) -> &[u8] {
        let block = self.batch.blocks().get(motion.block as usize);
        block.filter(|block| block.line == motion.line).map_or(&[], |block| self.batch.block_text(block))
    }
}

/// Consecutive passages that are worked on together.
#[derive(Debug, Default)]
pub(in crate::process) struct Stretch {
    pub(in crate::process) passages: Vec<Passage>,
    /// The first motion after it.
    following: Option<Motion>,
}

impl Stretch {
    /// Gives the motions with tool vectors their words, if the passages [left that](Passages::leaving_vectors).
    pub(in crate::process) fn resolve(&mut self, vectors: &mut ToolVectors) {
        for passage in &mut self.passages {
            vectors.resolve(&mut passage.motions);
        }
        if let Some(following) = &mut self.following {
            vectors.resolve_ahead(following);
        }
    }

    /// A motion by its place.
    pub(in crate::process) fn motion(&self, passage: usize, motion: usize) -> Option<&Motion> {
        self.passages.get(passage)?.motions.get(motion)
    }

    /// The first motion after the passage of this index.
    pub(in crate::process) fn following(&self, index: usize) -> Option<&Motion> {
        let later = self.passages.get(index + 1..).unwrap_or_default();
        later.iter().find_map(|passage| passage.motions.first()).or(self.following.as_ref())
    }
}

/// Passages in a stretch. They are some milliseconds of work, so that handing over costs little. They are few
/// enough that their motions stay in the cache between the workers.
const STRETCH_PASSAGES: usize = 4;
/// Most batches without a motion that are read ahead to find the next motion.
const MAX_LOOKAHEAD: usize = 64;

/// Reads a source into passages, with one motion of look-ahead for rules that need a neighbour.
pub(in crate::process) struct Passages<'a> {
    source: &'a dyn ProgramSource,
    /// The blocks in the order in which they run, from the first one on that changes the course.
    run: Option<ProgramRun>,
    input: Box<dyn Read + Send + 'a>,
    chunk: Vec<u8>,
    ended: bool,
    reader: Reader,
    interpreter: Interpreter,
    /// `None` if motions with vectors get their words elsewhere.
    vectors: Option<ToolVectors>,
    keeps_positions: bool,
    /// The course changes in a way that is not followed, because the texts are too long.
    is_too_long: bool,
    /// The path of the tool under radius compensation, if the program is followed as it runs.
    radius: Option<RadiusPath>,
    /// Surveys the text while it is read, if it was not surveyed before.
    surveyor: Option<Surveyor>,
    ahead: VecDeque<Passage>,
    /// Finished passages, whose memory is used again.
    spare: Vec<Passage>,
    pub(in crate::process) diagnostics: Diagnostics,
    pub(in crate::process) blocks: u64,
    pub(in crate::process) motions: u64,
    reading: ProgramReading,
    /// Which tool cuts in which section.
    tooling: Arc<Tooling>,
    /// From the lines read to those of the upload, if the text read was written from it.
    lines: Vec<LineCursor<'a>>,
    /// The same from the first line on, for messages after all is read.
    first_lines: Vec<LineCursor<'a>>,
}

impl<'a> Passages<'a> {
    pub(in crate::process) fn open(
        source: &'a dyn ProgramSource,
        machine: &Machine,
        program: &ProgramSetup,
    ) -> Result<Self, Fault> {
        Ok(Self {
            source,
            run: None,
            input: source.open()?,
            chunk: vec![0; CHUNK_BYTES],
            ended: false,
            reader: Reader::new(program.dialect, ReadLimits::default()),
            interpreter: Interpreter::new(machine, program.options()),
            vectors: Some(ToolVectors::new(machine, program)),
            keeps_positions: false,
            is_too_long: false,
            radius: None,
            surveyor: None,
            ahead: VecDeque::new(),
            spare: Vec::new(),
            diagnostics: Diagnostics::new(),
            blocks: 0,
            motions: 0,
            reading: ProgramReading::default(),
            tooling: program.tools.tooling(),
            lines: Vec::new(),
            first_lines: Vec::new(),
        })
    }

    /// Follows the program as it runs: loops, jumps and calls are followed. Only for readers that write nothing.
    pub(in crate::process) fn following_its_run(mut self, machine: &Machine, program: &ProgramSetup) -> Self {
        let options = InterpreterOptions { as_it_runs: true, ..program.options() };
        self.interpreter = Interpreter::new(machine, options);
        self.radius = Some(RadiusPath::new());
        self
    }

    /// Gives motions the lines to which these cursors lead, one after the other.
    pub(in crate::process) fn with_lines(mut self, lines: Vec<LineCursor<'a>>) -> Self {
        self.first_lines.clone_from(&lines);
        self.lines = lines;
        self
    }

    /// Leaves tool vectors unresolved. Stretches are [resolved](Stretch::resolve) in order later.
    pub(in crate::process) fn leaving_vectors(mut self) -> Self {
        self.vectors = None;
        self
    }

    /// Makes the text be surveyed while it is read.
    pub(in crate::process) fn surveying(mut self, machine: &Machine) -> Self {
        self.surveyor = Some(Surveyor::new(machine));
        self
    }

    /// The survey of the text, after its end; `None` if it was not [asked for](Self::surveying).
    pub(in crate::process) fn survey(&mut self) -> Option<Survey> {
        self.surveyor.take().map(Surveyor::finish)
    }

    /// Makes passages give the axis positions after each motion, even if not all are known.
    pub(in crate::process) fn keeping_positions(mut self) -> Self {
        self.keeps_positions = true;
        self
    }

    pub(in crate::process) fn dialect(&self) -> Dialect {
        self.reader.dialect().unwrap_or(Dialect::Iso)
    }

    /// Cursors from the lines read to those of the upload, one after the other, from the first line on.
    pub(in crate::process) fn to_upload(&self) -> Vec<LineCursor<'a>> {
        self.first_lines.clone()
    }

    /// The next passage, and the first motion after it.
    pub(in crate::process) fn next(&mut self) -> Result<Option<(Passage, Option<Motion>)>, Fault> {
        let Some(passage) =
            self.ahead.pop_front().map_or_else(|| self.read(), |passage| Ok(Some(passage)))?
        else {
            return Ok(None);
        };
        while self.ahead.iter().all(|later| later.motions.is_empty()) && self.ahead.len() < MAX_LOOKAHEAD {
            match self.read()? {
                Some(later) => self.ahead.push_back(later),
                None => break,
            }
        }
        let following = self.ahead.iter().find_map(|later| later.motions.first().copied());
        Ok(Some((passage, following)))
    }

    /// Fills a stretch with the next passages. It stays empty at the end of the program.
    pub(in crate::process) fn fill(&mut self, stretch: &mut Stretch, stop: &Stop<'_>) -> Result<(), Fault> {
        self.spare.append(&mut stretch.passages);
        while stretch.passages.len() < STRETCH_PASSAGES {
            if stop().is_break() {
                return Err(Fault::Cancelled);
            }
            let Some((passage, following)) = self.next()? else { break };
            stretch.passages.push(passage);
            stretch.following = following;
        }
        Ok(())
    }

    /// Hands every passage to `work`, with the first motion after it and the dialect, until the program is refused.
    /// A refused program is still read to its end, so that every fault is listed.
    pub(in crate::process) fn work(
        &mut self,
        stop: &dyn Fn() -> ControlFlow<()>,
        mut work: impl FnMut(&Passage, Option<&Motion>, Dialect) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        while let Some((passage, following)) = self.next()? {
            if stop().is_break() {
                return Err(Fault::Cancelled);
            }
            if !self.is_refused() {
                work(&passage, following.as_ref(), self.dialect())?;
            }
            self.recycle(passage);
        }
        self.refusals()
    }

    fn read(&mut self) -> Result<Option<Passage>, Fault> {
        let mut passage = self.spare.pop().unwrap_or_default();
        passage.motions.clear();
        passage.poses.clear();
        passage.looks.clear();
        if !self.next_blocks(&mut passage.batch)? {
            return Ok(self.last_motions(passage));
        }
        if let Some(surveyor) = &mut self.surveyor {
            surveyor.see(&passage.batch);
        }
        self.interpret(&mut passage, None);
        if let Some(block) = self.interpreter.stopped_at() {
            self.change_course(&mut passage, block)?;
        }
        if let Some(vectors) = &mut self.vectors {
            vectors.resolve(&mut passage.motions);
        }
        for cursor in &mut self.lines {
            for motion in &mut passage.motions {
                motion.line = cursor.source_line(motion.line);
            }
        }
        if let Some(radius) = self.radius.as_mut().filter(|_| self.interpreter.has_compensated_radius()) {
            let Passage { batch, motions, positions, .. } = &mut passage;
            radius.follow(batch, motions, positions);
        }
        self.blocks += passage.batch.blocks().iter().filter(|block| block.counts()).count() as u64;
        self.motions += passage.motions.len() as u64;
        self.reading.see(&passage.motions);
        Ok(Some(passage))
    }

    /// The motions that were held back until the end of the program, if there are any.
    fn last_motions(&mut self, mut passage: Passage) -> Option<Passage> {
        let radius = self.radius.as_mut().filter(|radius| radius.holds_back())?;
        passage.batch = Batch::new();
        radius.finish(&mut passage.motions, &mut passage.positions);
        self.motions += passage.motions.len() as u64;
        self.reading.see(&passage.motions);
        Some(passage)
    }

    /// The blocks that come next; false at the end.
    fn next_blocks(&mut self, batch: &mut Batch) -> Result<bool, Fault> {
        if let Some(run) = &mut self.run {
            return Ok(!self.interpreter.has_ended() && run.next_batch(batch));
        }
        while !self.reader.next_batch(batch)? {
            if self.ended {
                return Ok(false);
            }
            let count = read_some(&mut *self.input, &mut self.chunk)?;
            let text = &self.chunk[..count];
            if let Some(surveyor) = &mut self.surveyor {
                surveyor.see_text(text);
            }
            if count == 0 {
                self.ended = true;
                self.reader.finish();
            } else {
                self.reader.feed(text);
            }
        }
        Ok(true)
    }

    /// Makes the motions of a passage, or those from a block on.
    fn interpret(&mut self, passage: &mut Passage, from: Option<usize>) {
        let Passage { batch, motions, positions, .. } = passage;
        let diagnostics = &mut self.diagnostics;
        if from.is_none() {
            positions.clear();
        }
        let interpreter = &mut self.interpreter;
        let keeps_positions = self.keeps_positions;
        let see = |motions: &[Motion], at| {
            if keeps_positions {
                positions.resize(motions.len(), at);
            }
        };
        match from {
            Some(from) => interpreter.interpret_rest(from, batch, motions, diagnostics, see),
            None if keeps_positions => interpreter.interpret_each(batch, motions, diagnostics, see),
            None => interpreter.interpret(batch, motions, diagnostics),
        }
    }

    /// The program does not go on in the order of its text at this block.
    fn change_course(&mut self, passage: &mut Passage, block: usize) -> Result<(), Fault> {
        let batch = &passage.batch;
        let start = batch.blocks().get(block).map_or(0, |block| u64::from(block.start));
        self.run = run_from(self.source, batch.dialect(), batch.offset() + start)?;
        self.interpreter.run_on();
        if self.run.is_some() {
            passage.batch.end_before(block);
        } else {
            self.is_too_long = true;
            self.interpret(passage, Some(block));
        }
        Ok(())
    }

    /// How the program was read so far.
    pub(in crate::process) fn reading(&self) -> ProgramReading {
        let (unit, unit_is_stated) = (self.interpreter.unit(), self.interpreter.states_unit());
        let reading = self.reading.clone().with_tools(&self.tooling, self.interpreter.tool_names());
        ProgramReading { unit, unit_is_stated, ..reading }
    }

    /// The names by which tools were called so far, and the cutters that `CUTTER/` states.
    pub(in crate::process) fn tools_told(&self) -> (Vec<ToolName>, Vec<StatedCutter>) {
        (self.interpreter.tool_names().to_vec(), self.interpreter.stated_cutters().to_vec())
    }

    /// Gives back a finished stretch.
    pub(in crate::process) fn recycle_all(&mut self, stretch: &mut Stretch) {
        self.spare.append(&mut stretch.passages);
    }

    /// Gives back a finished passage.
    pub(in crate::process) fn recycle(&mut self, passage: Passage) {
        self.spare.push(passage);
    }

    /// Adds the warnings about the text as a whole.
    pub(in crate::process) fn warn(&self, warnings: &mut Warnings) {
        let to_upload = |cursors: &mut [LineCursor<'a>], line: u64| {
            cursors.iter_mut().fold(line, |line, cursor| cursor.source_line(line))
        };
        let mut cursors = self.first_lines.clone();
        let mut before = 0;
        for diagnostic in self.diagnostics.kept() {
            if diagnostic.severity() == Severity::Warning {
                if diagnostic.line < before {
                    cursors.clone_from(&self.first_lines);
                }
                before = diagnostic.line;
                let line = to_upload(&mut cursors, diagnostic.line);
                warnings.add(WarningKind::EffectUnknown, Some(line));
            }
        }
        let (after_end, end) = self.behind_the_end();
        if after_end > 0 {
            warnings.add(WarningKind::TextAfterEnd, end).count = after_end;
        }
        if let Some(line) = self.interpreter.unit_disagrees_at() {
            let mut cursors = self.first_lines.clone();
            warnings.add(WarningKind::UnitDisagrees, Some(to_upload(&mut cursors, line)));
        }
        if self.tooling.leaves_stated {
            warnings.add(WarningKind::StatedToolUnused, None);
        }
        if let Some((count, line)) = self.tooling.differing {
            let mut cursors = self.first_lines.clone();
            warnings.add(WarningKind::CutterDiffers, Some(to_upload(&mut cursors, line))).count = count;
        }
        let idle_files = self.files_never_called();
        if idle_files > 0 {
            warnings.add(WarningKind::FileNotCalled, None).count = idle_files;
        }
        let without_point = self.interpreter.words_without_point();
        if without_point > 0 {
            warnings.add(WarningKind::WordsWithoutPoint, None).count = without_point;
        }
    }

    /// How many files beside the main program no call has reached, if the program was followed as it runs.
    pub(in crate::process) fn files_never_called(&self) -> u64 {
        let count = match &self.run {
            Some(run) => run.files_never_called(),
            None if self.radius.is_some() && !self.is_too_long => {
                let mut sent = 0;
                while matches!(self.source.open_subprogram(sent), Ok(Some(_))) {
                    sent += 1;
                }
                sent
            }
            None => 0,
        };
        count as u64
    }

    /// Number of blocks after the program's end, and the line of the end in the upload.
    pub(in crate::process) fn behind_the_end(&self) -> (u64, Option<u64>) {
        let mut cursors = self.first_lines.clone();
        let end = self
            .interpreter
            .end_line()
            .map(|line| cursors.iter_mut().fold(line, |line, cursor| cursor.source_line(line)));
        (self.interpreter.blocks_after_end(), end)
    }

    /// Whether something was found that refuses the program as a whole.
    pub(in crate::process) fn is_refused(&self) -> bool {
        self.diagnostics.count(Severity::Refusal) > 0
    }

    /// The program's refusals, if any, as a fault.
    pub(in crate::process) fn refusals(&mut self) -> Result<(), Fault> {
        if self.is_refused() {
            return Err(Fault::Program(Box::new(std::mem::take(&mut self.diagnostics))));
        }
        Ok(())
    }
}
