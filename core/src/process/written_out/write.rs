//! Writes the blocks of a program in the order in which they run.

use std::io::{self, Write};

use super::check::check;
use crate::machine::Machine;
use crate::motion::{Motion, Unfollowable};
use crate::process::fault::Fault;
use crate::process::set_up::{ProgramSetup, Stop};
use crate::process::text::{Passages, ProgramSource};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Diagnostics, Dialect,
    Excerpt, Keyword, OwnNames, Word, WordForm, WritingOut, print_decimal,
};

/// Decimals of a value that was computed. A millionth of a millimetre or of a degree is finer than any control counts.
const DECIMALS: u8 = 6;
/// Decimals of a length or an angle that are left out if they are zero.
const SPARE_DECIMALS: usize = 2;

/// A program that was written out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrittenOut {
    /// The dialect in which it was read and written.
    pub dialect: Dialect,
    /// Assignments of parameters and variables that are left out: their values are in the words.
    pub assignments: u64,
    /// The line of the first of them in the program.
    pub first_assignment: Option<u64>,
    /// Files beside the main program that no call reaches.
    pub files_never_called: u64,
}

/// Writes the loops and calls of a program out: `out` gets one text whose blocks run one after the other. Up to the
/// first loop or call the text stays as it is, byte for byte. After it, words have numbers in the place of expressions,
/// and assignments are left out. `None` if the program has no loop and no call: nothing was written then.
///
/// `read` gives the text that was written. It is read back, and its motions are compared with those of the program.
///
/// # Errors
/// The program cannot be read or followed. A call is not followed, because its file is missing. A value that the
/// program uses or writes is not fixed by its text. The text cannot be written.
pub fn write_out<W: Write, S: ProgramSource>(
    machine: &Machine,
    program: &ProgramSetup,
    source: &dyn ProgramSource,
    out: W,
    read: impl FnOnce(W) -> io::Result<S>,
    stop: &Stop<'_>,
) -> Result<Option<(WrittenOut, S)>, Fault> {
    let mut passages = Passages::open(source, machine, program)?.following_its_run(machine, program);
    let mut writer = Writer {
        out,
        dialect: Dialect::Iso,
        own: OwnNames::default(),
        tail: Tail::default(),
        refusals: Diagnostics::new(),
        done: WrittenOut {
            dialect: Dialect::Iso,
            assignments: 0,
            first_assignment: None,
            files_never_called: 0,
        },
        has_cycle: false,
    };
    let mut runs = false;
    while let Some((passage, _)) = passages.next()? {
        if stop().is_break() {
            return Err(Fault::Cancelled);
        }
        runs = runs || passage.batch.is_of_run();
        writer.dialect = passages.dialect();
        writer.batch(&passage.batch, &passage.motions)?;
        passages.recycle(passage);
    }
    let Writer { mut out, dialect, tail, refusals, done, .. } = writer;
    let done = WrittenOut { dialect, files_never_called: passages.files_never_called(), ..done };
    // After a call without its file, nothing decides a later loop. So this comes first.
    if refusals.refusals().next().is_some() {
        return Err(Fault::Program(Box::new(refusals)));
    }
    passages.refusals()?;
    if !runs {
        return Ok(None);
    }
    out.write_all(&tail.missing())?;
    let written = read(out)?;
    check(machine, &ProgramSetup { dialect: Some(dialect), ..program.clone() }, source, &written, stop)?;
    Ok(Some((done, written)))
}

/// The reasons why a block cannot be written out, each with its cure.
mod reasons {
    pub(super) const CALL: &str = "this call is not followed: its file is missing, two files fit it, its number or its count is larger than is followed, or the files are longer than 4 MiB together; send its file, or send the program without flatten";
    pub(super) const VALUE: &str =
        "it uses a value that the text does not fix; write a number, or send the program without flatten";
    pub(super) const SYSTEM: &str =
        "it changes offsets or other values of the control; send the program without flatten";
    pub(super) const CYCLE: &str =
        "it sets a parameter in a program with cycles, which may use it; send the program without flatten";
    pub(super) const MIXED: &str =
        "it assigns a value and moves in one block; write the assignment into a block of its own";
}

/// Whether a word is the whole assignment of a variable.
fn is_assignment(word: &Word) -> bool {
    matches!(word.keyword(), Some(Keyword::Assigned | Keyword::Declaration))
}

struct Writer<W> {
    out: W,
    dialect: Dialect,
    own: OwnNames,
    tail: Tail,
    refusals: Diagnostics,
    done: WrittenOut,
    /// The program defines a cycle that uses parameters of the program.
    has_cycle: bool,
}

impl<W: Write> Writer<W> {
    fn rules(&self) -> &'static WritingOut {
        &self.dialect.rules().writing_out
    }

    fn batch(&mut self, batch: &Batch, motions: &[Motion]) -> Result<(), Fault> {
        let mut motions = motions.iter().peekable();
        for (index, block) in batch.blocks().iter().enumerate() {
            let mut calls = false;
            while let Some(motion) = motions.next_if(|motion| motion.block as usize <= index) {
                calls |= matches!(
                    motion.unfollowable,
                    Some(Unfollowable::Call | Unfollowable::ModalCall | Unfollowable::Return)
                );
            }
            let is_heidenhain = self.dialect == Dialect::Heidenhain;
            self.has_cycle |=
                is_heidenhain && memchr::memmem::find(batch.block_text(block), b"CYCL").is_some();
            if !batch.is_of_run() {
                self.note_variables(batch, block);
                if calls {
                    self.refuse(batch, block, reasons::CALL);
                }
                self.write(batch, block, batch.block_text(block))?;
                continue;
            }
            match self.written(batch, block, calls) {
                Ok(Some(text)) => self.write(batch, block, &text)?,
                Ok(None) => {}
                Err(reason) => self.refuse(batch, block, reason),
            }
        }
        Ok(())
    }

    /// The text of a block of the run; `None` if it is left out.
    fn written(
        &mut self,
        batch: &Batch,
        block: &Block,
        calls: bool,
    ) -> Result<Option<Vec<u8>>, &'static str> {
        let text = batch.block_text(block);
        let assigns = block.flags.has(BlockFlags::ASSIGNS);
        if calls || matches!(block.kind, BlockKind::Call | BlockKind::Flow) {
            return Err(reasons::CALL);
        }
        if block.flags.has(BlockFlags::ASSIGNS_SYSTEM) {
            return Err(reasons::SYSTEM);
        }
        let words = batch.words(block);
        let only_assigns = words.iter().all(|word| word.address == Address::N || is_assignment(word));
        if assigns && (block.kind == BlockKind::Assignment || (!words.is_empty() && only_assigns)) {
            self.note_variables(batch, block);
            self.leave_out(block, text)?;
            return Ok(None);
        }
        if !matches!(block.kind, BlockKind::Words | BlockKind::Assignment) {
            return Ok(Some(text.to_vec()));
        }
        if assigns && self.rules().cycle.is_some() {
            // The parameters of a cycle.
            let values = text.split(|byte| *byte == b'=').skip(1);
            let is_fixed = values.into_iter().all(|value| !(self.rules().names_value)(value, &self.own));
            return if is_fixed { Ok(Some(text.to_vec())) } else { Err(reasons::VALUE) };
        }
        if assigns && !words.iter().any(is_assignment) {
            return Err(reasons::MIXED);
        }
        if assigns {
            self.note_variables(batch, block);
            for word in words.iter().filter(|word| is_assignment(word)) {
                self.leave_out(block, batch.word_text(word))?;
            }
        }
        if words.iter().any(|word| word.form == WordForm::Expression) {
            return Err(reasons::VALUE);
        }
        let text = self.with_numbers(batch, block, words);
        if (self.rules().names_value)(&text, &self.own) {
            return Err(reasons::VALUE);
        }
        Ok(Some(text))
    }

    /// Notes the variables that a block declares or sets.
    fn note_variables(&mut self, batch: &Batch, block: &Block) {
        for word in batch.words(block).iter().filter(|word| is_assignment(word)) {
            self.own.note(batch.word_text(word));
        }
    }

    /// Leaves an assignment out, if nothing else uses what it sets.
    fn leave_out(&mut self, block: &Block, text: &[u8]) -> Result<(), &'static str> {
        if !(self.rules().is_own)(text, &self.own) {
            return Err(reasons::SYSTEM);
        }
        if self.has_cycle {
            return Err(reasons::CYCLE);
        }
        self.done.assignments += 1;
        self.done.first_assignment.get_or_insert(block.line);
        Ok(())
    }

    /// The block with numbers in the place of expressions, and without assignments.
    fn with_numbers(&self, batch: &Batch, block: &Block, words: &[Word]) -> Vec<u8> {
        let mut text = Vec::new();
        let mut at = block.start as usize;
        let whole = batch.text();
        let copy = |text: &mut Vec<u8>, from: usize, to: usize| {
            text.extend_from_slice(whole.get(from..to).unwrap_or_default());
        };
        for word in words {
            if is_assignment(word) {
                copy(&mut text, at, word.start as usize);
                at = word.end as usize;
                continue;
            }
            let start = word.start as usize + usize::from(word.lead);
            let end = word.end as usize;
            let value = whole.get(start..end).unwrap_or_default();
            let is_value =
                matches!(word.form, WordForm::Evaluated | WordForm::Absolute | WordForm::Incremental);
            let is_number = value.iter().all(|byte| !byte.is_ascii_alphabetic() && !b"#[(".contains(byte));
            if !is_value || is_number {
                continue;
            }
            // `AC(…)` and `IC(…)` keep their names.
            let wraps = word.form != WordForm::Evaluated && value.contains(&b'(');
            let open = memchr::memchr(b'(', value).filter(|_| wraps).map_or(start, |open| start + open + 1);
            copy(&mut text, at, open);
            text.extend(self.number(word));
            if wraps {
                text.push(b')');
            }
            at = end;
        }
        copy(&mut text, at, block.end as usize);
        text
    }

    /// The value of a word as its dialect writes numbers.
    fn number(&self, word: &Word) -> Vec<u8> {
        let is_place = matches!(
            word.address,
            Address::X
                | Address::Y
                | Address::Z
                | Address::A
                | Address::B
                | Address::C
                | Address::U
                | Address::V
                | Address::W
        );
        let is_length = is_place
            || matches!(word.address, Address::I | Address::J | Address::K | Address::R | Address::Q);
        let mut number = Vec::new();
        print_decimal(word.value, DECIMALS, &mut number);
        // Compensated words have the decimals of the program, and lengths keep enough of them. Without a point some
        // controls read a length in least increments.
        let zeros = number.iter().rev().take_while(|byte| **byte == b'0').count();
        number.truncate(number.len() - zeros.min(if is_length { SPARE_DECIMALS } else { DECIMALS.into() }));
        let keeps_point = self.rules().feed_keeps_point && matches!(word.address, Address::F | Address::E);
        if number.last() == Some(&b'.') && !keeps_point {
            number.pop();
        }
        if self.rules().places_have_signs && is_place && number.first() != Some(&b'-') {
            number.insert(0, b'+');
        }
        number
    }

    fn write(&mut self, batch: &Batch, block: &Block, text: &[u8]) -> Result<(), Fault> {
        self.tail.see(batch, block);
        self.out.write_all(text)?;
        if !text.ends_with(b"\n") && !text.ends_with(b"\r") {
            self.out.write_all(self.tail.line_ending())?;
        }
        Ok(())
    }

    fn refuse(&mut self, batch: &Batch, block: &Block, reason: &'static str) {
        let text = Excerpt::new(batch.block_text(block).trim_ascii());
        let offset = batch.offset();
        self.refusals.push(Diagnostic {
            code: DiagnosticCode::NotWrittenOut { text, reason },
            line: block.line,
            called: batch.called_line(block),
            column: 1,
            span: ByteSpan {
                start: offset + u64::from(block.start),
                end: offset + u64::from(block.body_end),
            },
        });
    }
}

/// What the end of the text still needs: the run ends at M30, and lines for the control may come after it.
#[derive(Debug, Default)]
struct Tail {
    tape_marks: u32,
    /// `END PGM` with the name of the program, until it is written.
    end: Option<Vec<u8>>,
    has_cr: bool,
}

impl Tail {
    fn see(&mut self, batch: &Batch, block: &Block) {
        let text = batch.block_text(block);
        self.has_cr |= text.ends_with(b"\r\n");
        self.tape_marks += u32::from(block.kind == BlockKind::Percent && text.trim_ascii() == b"%");
        for word in batch.words(block) {
            match word.keyword() {
                Some(Keyword::BeginMm | Keyword::BeginInch) if self.end.is_none() => {
                    let upper = text.to_ascii_uppercase();
                    let named = memchr::memmem::find(&upper, b"PGM").and_then(|at| text.get(at..));
                    let named = named.unwrap_or_default();
                    let named = named.get(..memchr::memchr(b';', named).unwrap_or(named.len()));
                    let named = named.unwrap_or_default().trim_ascii();
                    self.end = Some([b"END ", named].concat());
                }
                Some(Keyword::EndPgm) => self.end = Some(Vec::new()),
                _ => {}
            }
        }
    }

    fn line_ending(&self) -> &'static [u8] {
        if self.has_cr { b"\r\n" } else { b"\n" }
    }

    /// The lines that are still missing.
    fn missing(&self) -> Vec<u8> {
        let end = self.end.as_deref().filter(|end| !end.is_empty());
        let mark = (self.tape_marks == 1).then_some(&b"%"[..]);
        end.into_iter().chain(mark).flat_map(|line| [line, self.line_ending()].concat()).collect()
    }
}
