//! Turns one line of an OSP program into words. Plain lines are read as those of ISO programs.

use super::detect::is_program_file;
use crate::program::comment::comment_end;
use crate::program::dialect::line::{Extent, Line, REPEATABLE, Source};
use crate::program::dialect::{LineRead, iso};
use crate::program::number::{MAX_MAGNITUDE, follows_number, read_unsigned};
use crate::program::{Address, Batch, BlockFlags, BlockKind, DiagnosticCode};

/// Statements that call a program once. `MODIN` calls a program after every motion up to `MODOUT`.
const CALLS: [&[u8]; 1] = [b"CALL"];
/// Statements that change the flow, or that act at the motions after them.
const FLOW: [&[u8]; 7] = [b"IF", b"GOTO", b"RTS", b"MODIN", b"MODOUT", b"RTMCR", b"RTMDI"];

/// Reads a line and adds it to the batch.
pub(super) fn read_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    match iso::read_plain_line(source, batch) {
        Some(next) => LineRead::one(next),
        None => read_any_line(source, batch),
    }
}

/// The same for every line.
fn read_any_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    let text = source.text;
    let mut line = Line::new(source, Extent::ONE_LINE, REPEATABLE, batch);
    while let Some(&byte) = text.get(line.at) {
        match byte {
            b'\n' | b'\r' => break,
            b' ' | b'\t' | 0x7f => line.at += 1,
            b'(' => comment(&mut line),
            b'%' if line.is_untouched() => tape_mark(&mut line),
            b'$' if line.is_untouched() => dollar(&mut line),
            b'/' if line.has_only_number() => skip_mark(&mut line),
            0xef if line.is_at_byte_order_mark() => line.at += 3,
            letter if letter.is_ascii_alphabetic() => word(&mut line, letter),
            byte if byte < b' ' => line.at += 1,
            _ => not_read(&mut line),
        }
    }
    let kind = kind_of(&line);
    line.close(kind)
}

/// `$PART.MIN%`: the name of the file, before the program or between two programs. Any other `$` continues the block
/// before it.
fn dollar(line: &mut Line<'_>) {
    let rest = line.text.get(line.at..).unwrap_or_default();
    let end = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    if is_program_file(rest.get(..end).unwrap_or_default().trim_ascii_end()) {
        return tape_mark(line);
    }
    line.fail_with(|text| DiagnosticCode::LineContinues { text }, line.at);
}

fn tape_mark(line: &mut Line<'_>) {
    line.kind = Some(BlockKind::Percent);
    line.skip_all();
}

/// `/`, `/1`
fn skip_mark(line: &mut Line<'_>) {
    line.flags.set(BlockFlags::DELETE);
    line.at += 1;
    if matches!(line.byte(line.at), b'1'..=b'9') && !line.byte(line.at + 1).is_ascii_digit() {
        line.at += 1;
    }
}

fn comment(line: &mut Line<'_>) {
    match comment_end(line.text, line.at) {
        Ok(end) => {
            line.flags.set(BlockFlags::COMMENT);
            line.at = end;
        }
        Err(_) => line.fail_with(|text| DiagnosticCode::NestedComment { text }, line.at),
    }
}

/// A letter with a number, or a name.
fn word(line: &mut Line<'_>, letter: u8) {
    let start = line.at;
    let address = Address::of_letter(letter);
    let sign = line.blanks_end(start + 1);
    let is_negative = line.byte(sign) == b'-';
    let is_signed = is_negative || line.byte(sign) == b'+';
    let at = if is_signed { line.blanks_end(sign + 1) } else { sign };
    if address == Address::E && follows_number(line.text, line.start, start) {
        return iso::fail_exponent(line);
    }
    match read_unsigned(line.text, at) {
        Some(number) if is_followed_by_more(line, number.end) => not_read(line),
        Some(number) if number.value <= MAX_MAGNITUDE => {
            line.unsigned_word(address, start, 1, is_negative, &number);
        }
        Some(number) => {
            let value = if is_negative { -number.value } else { number.value };
            line.fail_too_large(address, value, start, number.end);
        }
        None => named(line, address),
    }
}

/// Whether the text read up to a byte is the beginning of something else: `VC1=5`, `X1*2`, `LA1[2]`.
fn is_followed_by_more(line: &Line<'_>, at: usize) -> bool {
    matches!(line.byte(line.blanks_end(at)), b'=' | b'[' | b'*' | b'+' | b'-')
}

/// Letters that are not a word of a block: the name of a program or a block, a call, the flow, or a statement.
fn named(line: &mut Line<'_>, address: Address) {
    let start = line.at;
    let end = name_end(line, start);
    let is_alone = !is_followed_by_more(line, end);
    let letters = line.slice(start, line.letters_end(start));
    let is = |words: &[&[u8]]| words.iter().any(|word| letters.eq_ignore_ascii_case(word));
    if line.opens() && is(&CALLS) {
        return line.settle(BlockKind::Call);
    }
    if is(&FLOW) {
        return line.settle(BlockKind::Flow);
    }
    let is_name = end > start + 1 && is_alone && !is_function(letters);
    match address {
        // `OPART`; `NLAP1 G0 X5`: another part of the program can call a block by its name.
        Address::O if is_name && line.opens() => line.name(Address::O, start, 1, end),
        Address::N if is_name && line.is_untouched() && end - start <= LONGEST_BLOCK_NAME => {
            line.name(Address::N, start, 1, end);
        }
        _ => not_read(line),
    }
}

/// N and at most four letters or digits. In a longer one, words follow the name without a blank: `NLAPG91`.
const LONGEST_BLOCK_NAME: usize = 5;
/// Statements that begin like a name.
const NO_NAMES: [&[u8]; 4] = [b"NOEX", b"NCYL", b"NMSG", b"OMIT"];

/// Whether these letters are a statement, although they begin like a name.
fn is_function(letters: &[u8]) -> bool {
    NO_NAMES.iter().any(|name| letters.eq_ignore_ascii_case(name))
}

/// One after the letters and digits that start at a byte.
fn name_end(line: &Line<'_>, mut at: usize) -> usize {
    while line.byte(at).is_ascii_alphanumeric() {
        at += 1;
    }
    at
}

/// Fails the line, because variables and functions are not read.
#[cold]
fn not_read(line: &mut Line<'_>) {
    line.fail_with(|text| DiagnosticCode::StatementNotRead { text }, line.at);
}

/// The kind of a line that does not state its kind.
fn kind_of(line: &Line<'_>) -> BlockKind {
    if line.words().is_empty() && !line.flags.has(BlockFlags::DELETE) {
        if line.flags.has(BlockFlags::COMMENT) { BlockKind::Comment } else { BlockKind::Blank }
    } else {
        BlockKind::Words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Dialect, ReadLimits, Reader, WordForm};

    fn read(text: &str) -> Batch {
        let mut reader = Reader::new(Some(Dialect::Okuma), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let mut batch = Batch::new();
        assert!(reader.next_batch(&mut batch).unwrap(), "{text}");
        batch
    }

    fn kinds(text: &str) -> Vec<BlockKind> {
        read(text).blocks().iter().map(|block| block.kind).collect()
    }

    #[test]
    fn plain_lines_are_read_as_in_the_general_way() {
        let plain = ["N10 G1 X1.5 Y-2.25", "X1Y2Z12345678.5"];
        let pieces = "N10 |G1|G15H1|X|Y|z|A|E|VC1=5|M8 |(note)|;|=|$|/|%";
        let general = |source: Source<'_>, batch: &mut Batch| Some(read_any_line(source, batch));
        crate::program::dialect::plain::tests::compare(&plain, pieces, iso::read_plain_line, general);
    }

    #[test]
    fn names_of_files_programs_and_blocks_are_read() {
        use BlockKind::{Blank, Comment, Percent, Words};
        let text = "$PART.MIN%\nOPART (A)\nNLAP1 G0 X5 Y-.5\n/2 M1\n(N)\n\nO0001\n%\n";
        assert_eq!(kinds(text), [Percent, Words, Words, Words, Comment, Blank, Words, Percent]);
        let batch = read(text);
        let names: Vec<_> = batch.blocks().iter().flat_map(|block| batch.words(block)).collect();
        assert_eq!(batch.name(names[0]), Some(&b"PART"[..]));
        assert_eq!(batch.name(names[1]), Some(&b"LAP1"[..]));
        assert!(batch.faults().is_empty(), "{:?}", batch.faults());
    }

    #[test]
    fn calls_and_the_flow_are_told_and_variables_are_refused_with_their_text() {
        use BlockKind::{Call, Flow, Malformed};
        assert_eq!(kinds("CALL O1000\nN5 CALL OO88 XX=0 BB=1\n"), [Call; 2]);
        assert_eq!(kinds("IF[VC1 GT 5] N10\nGOTO NLAP\nRTS\nMODIN O5 X=1\nMODOUT\n"), [Flow; 5]);
        for line in [
            "VC1=5",
            "X=VC1",
            "G1 X=VC1+2",
            "NOEX VC1=1",
            "X5*2",
            "DRAW",
            "SB=1000",
            "G1 X[5]",
            "X#1",
            "; note",
            "NCYL X5. Y6.",
            "OMIT R2",
            // Words that follow a name without a blank.
            "NLAPG91",
            "NL1X200",
            "NSTRTG140",
        ] {
            let batch = read(&format!("{line}\n"));
            assert_eq!(batch.blocks()[0].kind, Malformed, "{line}");
            let code = batch.faults()[0].code;
            assert!(matches!(code, DiagnosticCode::StatementNotRead { .. }), "{line}: {code:?}");
            assert_eq!(batch.faults().len(), 1, "{line}");
        }
        let batch = read("G1 X5\n$ Y40.\n");
        assert_eq!(batch.blocks()[1].kind, Malformed);
        assert!(matches!(batch.faults()[0].code, DiagnosticCode::LineContinues { .. }));
        for line in ["X6.12E-17\n", "G1 X1e400\n"] {
            let code = read(line).faults()[0].code;
            assert!(matches!(code, DiagnosticCode::Exponent { .. }), "{line}: {code:?}");
        }
        // A word stays a word, whatever is refused after it.
        assert_eq!(read("G1 X5 Y=VC1\n").faults()[0].column, 7);
        assert!(
            read("G56 Z4.3307 H01\n")
                .words(&read("G56 Z4.3307 H01\n").blocks()[0])
                .iter()
                .all(|word| word.form == WordForm::Number)
        );
    }
}
