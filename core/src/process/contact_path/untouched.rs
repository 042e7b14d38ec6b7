//! Compares copied blocks byte for byte where that proves as much as reading them would.
//!
//! A motion that repeats the motion before ([`Motion::repeats`]) depends only on that motion and on its own text.
//! Suppose that the first motion of a run of copied blocks was read from the output and equals the source's to the
//! bit. Suppose also that all later blocks of the run repeat it, and that their bytes in the output equal the
//! source's. Then reading them would give the source's motions, by induction from one block to the next.
//!
//! In some dialects a statement may continue over lines or depend on the statement after it. There the last statement
//! of the run is both compared and read, because it shows where the statement before it ends and what it is.
//! Everything else is read.

use super::check::{ExpectedMotion, Judged, PathCheck, SourceMotion};
use crate::motion::Motion;
use crate::process::fault::{Fault, go_on};
use crate::process::pipeline::{Copied, KeptMotion, Outgoing, failed};
use crate::process::text::{Passage, Stretch};
use crate::program::Block;

/// Shorter runs are read, because that costs less than finding their ends.
const LEAST_RUN: usize = 4;

impl<'a> PathCheck<'a> {
    /// Checks this text of the output, which was written from this stretch.
    pub(in crate::process) fn look_at(
        &mut self,
        written: &mut Outgoing<ExpectedMotion<'a>>,
        stretch: &Stretch,
    ) -> Result<(), Fault> {
        let Outgoing { text, expected, copied } = written;
        self.read_back.expect_all(expected);
        let mut fed = 0;
        for copied in copied.iter() {
            let Some(passage) = stretch.passages.get(copied.passage) else { continue };
            fed = self.copied(text, fed, copied, passage, stretch)?;
        }
        self.read_back.feed(text.get(fed..).unwrap_or_default());
        self.read(stretch)?;
        self.milestones.reach(self.read_back.blocks_read(), self.found.after.max_mm());
        // The stretch is dropped before the rest of its text is read.
        for expected in self.read_back.awaited_mut() {
            if let ExpectedMotion::Same { motion, .. } = expected
                && let SourceMotion::At { passage, motion: index, .. } = *motion
                && let Some(source) = stretch.motion(passage, index)
            {
                *motion = SourceMotion::Kept(Box::new(KeptMotion::of(source)));
            }
        }
        Ok(())
    }

    /// Checks copied blocks in a text that is read up to `fed`. Returns the place up to which it is read afterwards.
    fn copied(
        &mut self,
        text: &[u8],
        mut fed: usize,
        copied: &Copied,
        passage: &Passage,
        stretch: &Stretch,
    ) -> Result<usize, Fault> {
        let (blocks, [from, to]) = (passage.batch.blocks(), copied.blocks);
        let Some(start) = blocks.get(from).map(|block| block.start as usize) else { return Ok(fed) };
        // The place where a block ends in the written text.
        let end_of = |block: usize| {
            blocks
                .get(block)
                .map_or(text.len(), |block| copied.at + (block.end as usize).saturating_sub(start))
        };
        let mut first = passage.motions.partition_point(|motion| (motion.block as usize) < from);
        loop {
            let before = passage.motions.get(first).filter(|motion| (motion.block as usize) < to);
            let Some(before) = before else { return Ok(fed) };
            let run = run_behind(&passage.motions, first, to);
            // If a statement depends on what follows, the last one of a run settles the one before it, and is read.
            let passed = run - usize::from(self.read_back.looks_ahead && run > 0);
            let last = passage.motions.get(first + run).filter(|_| run >= LEAST_RUN);
            let (Some(last), Some(last_passed)) = (last, passage.motions.get(first + passed)) else {
                first += run + 1;
                continue;
            };
            let (read_to, run_to) = (end_of(before.block as usize), end_of(last.block as usize));
            let feed_to = if self.read_back.looks_ahead { run_to } else { read_to };
            self.read_back.feed(text.get(fed..feed_to).unwrap_or_default());
            self.read_back.hold(feed_to - read_to);
            fed = feed_to;
            self.read(stretch)?;
            let run_blocks =
                blocks.get(before.block as usize + 1..=last_passed.block as usize).unwrap_or_default();
            let here = text.get(read_to..run_to);
            let there = passage.batch.blocks_text(before.block as usize + 1, last.block as usize + 1);
            if self.exact == Some((copied.passage, first))
                && self.read_back.can_pass_over()
                && here == Some(there)
            {
                let motions = passage.motions.get(first + 1..=first + passed).unwrap_or_default();
                self.pass_over(motions, before.block)?;
                let lines = lines_of(blocks, before.block as usize + 1, last_passed.block as usize + 1);
                self.read_back.pass_over(&passage.batch, run_blocks, lines, motions);
                if !self.read_back.looks_ahead {
                    fed = run_to;
                }
            }
            self.read_back.hold(0);
            first += run + 1;
        }
    }

    /// Takes over the findings of motions that need not be read. They come after the block of this index.
    fn pass_over(&mut self, motions: &[Motion], block_before: u32) -> Result<(), Fault> {
        let blocks_before = self.read_back.blocks_before();
        for motion in motions {
            self.effort.pass(1);
            go_on(&self.effort)?;
            let Some(ExpectedMotion::Same { motion: source, checked }) = self.read_back.take_expected()
            else {
                return Err(failed(motion.line, "there is a motion too many"));
            };
            if source.line() != motion.line {
                return Err(failed(motion.line, "a motion is missing"));
            }
            let blocks = blocks_before + u64::from(motion.block.saturating_sub(block_before));
            self.milestones.reach(blocks, self.found.after.max_mm());
            if let Some((path_mm, found)) = &checked {
                self.found.record(motion.line, *path_mm, found, found);
            }
            let deviation_mm = checked.map_or(0.0, |(_, found)| found.max_mm);
            self.judged.push(Judged::undivided(motion.line, motion.kind, deviation_mm));
        }
        Ok(())
    }
}

/// The number of lines of the blocks from one index up to, but not including, another. If the second index is past
/// the end of the batch, every block is one line.
fn lines_of(blocks: &[Block], from: usize, to: usize) -> u64 {
    match (blocks.get(from), blocks.get(to)) {
        (Some(first), Some(behind)) => behind.line - first.line,
        _ => (to - from) as u64,
    }
}

/// Counts the motions after this one that repeat it, in blocks before the block of index `end`. Their contacts are of
/// the same kind, and either all or none of them state a feed. All end at known words, because the motion after an
/// unknown end depends on earlier ones.
fn run_behind(motions: &[Motion], first: usize, end: usize) -> usize {
    let Some(before) = motions.get(first) else { return 0 };
    let has_feed = before.feed.word_in_block;
    let repeats = |motion: &&Motion| {
        motion.repeats
            && motion.end.is_some()
            && (motion.block as usize) < end
            && motion.feed.word_in_block == has_feed
            && std::mem::discriminant(&motion.contact) == std::mem::discriminant(&before.contact)
    };
    motions.iter().skip(first + 1).take_while(repeats).count()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::ops::ControlFlow;

    use super::super::parameters::CcParameters;
    use super::*;
    use crate::contact::Effort;
    use crate::kinematics::Setup;
    use crate::machine::{Machine, Preset, Tool};
    use crate::process::pipeline::StepCheck;
    use crate::process::set_up::ProgramSetup;
    use crate::process::text::Passages;
    use crate::program::Dialect;
    use crate::units::Length;

    fn tables() -> Machine {
        Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
    }

    fn in_mm(dialect: Dialect) -> ProgramSetup {
        ProgramSetup { dialect: Some(dialect), ..ProgramSetup::in_mm(&Setup::default()) }
    }

    /// Runs of lines that repeat, and lines that end such a run, in several dialects. Each comes with a text that
    /// every motion line contains.
    fn programs() -> [(Dialect, &'static str, String); 3] {
        [
            (Dialect::Iso, "X", program()),
            (Dialect::Heidenhain, "L X", conversational()),
            (Dialect::Apt, "GOTO/", cutter_locations()),
        ]
    }

    /// Statements that continue on the next line, comments, feeds, codes, and corners that the next statement cuts.
    fn conversational() -> String {
        let mut text = "0 BEGIN PGM P MM\n1 L X+0 Y+0 Z+0 A+0 C+0 R0 F500\n".to_owned();
        for line in 0..700 {
            let at = 0.25 * f64::from(line);
            match line % 97 {
                40 => text.push_str("; a note\n\n"),
                45..=50 => writeln!(text, "L X{at:+.3} ~\n  Y-{at:.2} ; note").unwrap(),
                60 => writeln!(text, "L X{at:+.3} FMAX M8").unwrap(),
                70 => writeln!(text, "L X{at:+.3} F{:.0}", 100.0 + at).unwrap(),
                75 => writeln!(text, "L X{at:+.3}\n; a note\n\nRND R1").unwrap(),
                80 => text.push_str("L IX+0.25\nL IX+0.25\n"),
                85..=88 => writeln!(text, "L\tX{at:+.3} c{at:+.1} ").unwrap(),
                _ => writeln!(text, "{} L X{at:+.3} Y-{at:.2} Z+2 A{:+.3} C{at:+.1}", line + 2, 0.5 * at)
                    .unwrap(),
            }
        }
        text.push_str("900 END PGM P MM\n");
        text
    }

    /// The same with points and vectors, which turn little from one to the next.
    fn cutter_locations() -> String {
        let mut text =
            "PARTNO/P\nUNITS/MM\nMULTAX/ON\nFEDRAT/500.,MMPM\nGOTO/0.,0.,0.,0.1,0.5,0.8\n".to_owned();
        for line in 0..700 {
            let at = 0.25 * f64::from(line);
            let (i, j) = (0.3 + 0.001 * at, 0.5 - 0.001 * at);
            match line % 97 {
                40 => text.push_str("$$ a note\n\n"),
                45..=50 => writeln!(text, "GOTO/{at:.3},1.,2.,$\n  {i:.4},{j:.4},0.8 $$ note").unwrap(),
                60 => writeln!(text, "RAPID\nGOTO/{at:.3},1.,5.,{i:.4},{j:.4},0.8").unwrap(),
                70 => writeln!(text, "FEDRAT/{:.0}.,MMPM", 100.0 + at).unwrap(),
                80 => text.push_str("GODLTA/0.25,0.,0.\n"),
                85..=88 => writeln!(text, "goto/\t{at:.3} , 1.,2.,{i:.4},{j:.4},0.8").unwrap(),
                90..=95 => writeln!(text, "GOTO/{at:.3},-1.25,2.5").unwrap(),
                _ => writeln!(text, "GOTO/{at:.3},-1.25,2.5,{i:.4},{j:.4},0.8").unwrap(),
            }
        }
        text.push_str("FINI\n");
        text
    }

    /// Runs of lines that repeat, and lines that end a run: feeds, codes, comments, contacts, incremental words.
    fn program() -> String {
        let mut text = "%\nG21 G90 G94\nG1 F500 X0. Y0. Z0. A0. C0.\n".to_owned();
        for line in 0..700 {
            let at = 0.25 * f64::from(line);
            match line % 97 {
                40 => text.push_str("(a note)\n\n"),
                60 => writeln!(text, "G0 X{at:.3} Z5.").unwrap(),
                61 => text.push_str("G1 Z0.5\nM8\n"),
                70 => writeln!(text, "X{at:.3} F{:.1}", 100.0 + at).unwrap(),
                80 => text.push_str("G91 X0.25\nX0.25\nG90\n"),
                85 => writeln!(text, "X{at:.3} U1. V2. W3.").unwrap(),
                86..=90 => writeln!(text, "X{at:.3} U{at:.3}").unwrap(),
                _ => writeln!(text, "N{} X{at:.3} Y-{at:.2} A{:.3} C{at:.1}", line + 1, 0.5 * at).unwrap(),
            }
        }
        text.push_str("M30\n%\n");
        text
    }

    /// Reads back a copy of `source` that `change` has altered, as if every block had been left unchanged.
    fn read_back(dialect: Dialect, source: &str, change: impl Fn(&mut Vec<u8>)) -> Result<(), Fault> {
        let machine = tables();
        let program = in_mm(dialect);
        let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).unwrap();
        let parameters = CcParameters::new(tool, program.clone());
        let source = source.as_bytes().to_vec();
        let mut passages = Passages::open(&source, &machine, &program)?;
        let mut stretch = Stretch::default();
        passages.fill(&mut stretch, &|| ControlFlow::Continue(()))?;
        let (mut written, mut inventory) = (Outgoing::default(), crate::process::text::Inventory::default());
        for (index, passage) in stretch.passages.iter().enumerate() {
            inventory.see(&passage.batch);
            written.copy((index, passage), 0, passage.batch.blocks().len());
            written.expected.extend(passage.motions.iter().zip(0..).map(|(motion, place)| {
                ExpectedMotion::Same {
                    motion: SourceMotion::At { passage: index, motion: place, line: motion.line },
                    checked: None,
                }
            }));
        }
        assert!(written.text == source, "the whole program");
        change(&mut written.text);
        let mut verifier = PathCheck::new(&machine, &parameters, dialect, Effort::default());
        verifier.look_at(&mut written, &stretch)?;
        verifier.finish(&inventory)
    }

    #[test]
    fn what_left_as_it_came_is_found_to_be_so() {
        for (dialect, _, source) in programs() {
            let found = read_back(dialect, &source, |_| ()).map_err(|fault| fault.to_string());
            assert_eq!(found, Ok(()), "{dialect}");
        }
    }

    #[test]
    fn no_changed_digit_goes_by() {
        for (dialect, _, source) in programs() {
            let digits =
                source.bytes().enumerate().filter(|(_, byte)| byte.is_ascii_digit()).map(|(at, _)| at);
            let behind_head = digits.filter(|at| (15..source.len() - 16).contains(at));
            for at in behind_head.step_by(61) {
                let change =
                    |text: &mut Vec<u8>| text[at] = if text[at] == b'9' { b'8' } else { text[at] + 1 };
                let changed = read_back(dialect, &source, change);
                assert!(changed.is_err(), "byte {at}: {:?}", source.get(at.saturating_sub(20)..at + 5));
            }
        }
    }

    #[test]
    fn no_line_is_lost_doubled_or_moved() {
        for (dialect, motion, source) in programs() {
            let ends: Vec<usize> = memchr::memchr_iter(b'\n', source.as_bytes()).map(|at| at + 1).collect();
            for line in (5..ends.len() - 4).step_by(23) {
                let (from, to, behind) = (ends[line - 1], ends[line], ends[line + 1]);
                let own = &source.as_bytes()[from..to];
                if !source[from..to].contains(motion) || !source[to..behind].contains(motion) {
                    continue;
                }
                let without = |text: &mut Vec<u8>| drop(text.drain(from..to));
                let twice = |text: &mut Vec<u8>| drop(text.splice(from..from, own.iter().copied()));
                let moved = |text: &mut Vec<u8>| text[from..behind].rotate_left(to - from);
                assert!(read_back(dialect, &source, without).is_err(), "{dialect}: line {line} lost");
                assert!(read_back(dialect, &source, twice).is_err(), "{dialect}: line {line} twice");
                assert!(read_back(dialect, &source, moved).is_err(), "{dialect}: line {line} moved");
            }
        }
    }

    /// A statement after a copied one that cuts its corner changes its meaning. So does a sign that the statement
    /// continues.
    #[test]
    fn no_statement_that_changes_the_one_before_goes_by() {
        let (dialect, _, source) = &programs()[1];
        let lines: Vec<usize> = memchr::memmem::find_iter(source.as_bytes(), b" L X").collect();
        for at in lines.into_iter().skip(8).step_by(37) {
            let from = memchr::memrchr(b'\n', &source.as_bytes()[..at]).unwrap() + 1;
            let insert = |text: &mut Vec<u8>, new: &[u8]| drop(text.splice(from..from, new.iter().copied()));
            for new in [&b"RND R0.5\n"[..], b"CHF 1\n", b"  X+1\n"] {
                assert!(read_back(*dialect, source, |text| insert(text, new)).is_err(), "byte {from}");
            }
            assert!(read_back(*dialect, source, |text| text[from - 1] = b'~').is_err(), "byte {from}");
        }
    }

    #[test]
    fn runs_end_where_more_than_places_change() {
        let machine = tables();
        let source =
            b"G90 G1 F100\nX0 Y0 Z0 A0 C0\nX1\nX2\n\nX3\nX4 F90\nX5\nG1 X6\nM8\nX7\nX8\nX#1\nX9\n".to_vec();
        let mut passages = Passages::open(&source, &machine, &in_mm(Dialect::Iso)).unwrap();
        let mut stretch = Stretch::default();
        passages.fill(&mut stretch, &|| ControlFlow::Continue(())).unwrap();
        let motions = &stretch.passages[0].motions;
        let repeats: Vec<bool> = motions.iter().map(|motion| motion.repeats).collect();
        // The first point has no motion before it. After M8 and after an unknown number, no motion repeats the one
        // before.
        let expected = [false, false, true, true, true, true, true, false, true, false, false];
        assert_eq!(repeats, expected);
        let runs = [(1, 2), (4, 0), (5, 1), (7, 1)];
        for (first, run) in runs {
            assert_eq!(run_behind(motions, first, usize::MAX), run, "after {first}");
        }
    }
}
