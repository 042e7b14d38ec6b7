//! The place and the form of a stamp in a program.

use super::Stamp;
use crate::program::dialect::StampAfter;
use crate::program::{Address, Batch, BlockKind, Dialect, ReadLimits, Reader};

/// A stamp in its place in a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StampPlace {
    /// The number of the program's bytes before it.
    pub offset: usize,
    /// Its whole line. If the program's first line has no end yet, a line end and the line.
    pub line: Vec<u8>,
}

/// The part of a program that is examined \[bytes\]. It contains the head and shows the style.
const HEAD_BYTES: usize = 64 * 1024;

/// The place of the stamp in a program of this dialect, and its line in the program's own comment form: after `%` and
/// the O line of an ISO program, after `%_N_` and `;$PATH` of an 840D program, after `BEGIN PGM`, after `PARTNO`.
/// `None` for a table, which has no comments, and if the head of the text cannot be read.
///
/// `head` is the beginning of the program: 64 KiB of it, or all of it.
#[must_use]
pub fn place_stamp(head: &[u8], dialect: Dialect, stamp: &Stamp) -> Option<StampPlace> {
    let head = head.get(..HEAD_BYTES).unwrap_or(head);
    let blocks = read(head, dialect)?;
    let form = dialect.rules().stamp?;
    let offset = match form.after {
        StampAfter::TapeMarkAndName => after_mark_and_name(head, &blocks),
        StampAfter::LinesThatBeginWith(marks) => {
            after_lines(head, |line| marks.iter().any(|mark| starts(line, mark)))
        }
        StampAfter::LineWith(text) => after_line_with(head, text),
    };
    let [before, after] = if form.or_semicolons && semicolons_alone(head) { SEMICOLON } else { form.comment };
    let end = line_end_of(head);
    let mut line = Vec::new();
    if offset > 0 && !matches!(head.get(offset - 1), Some(b'\n' | b'\r')) && offset != MARK_BYTES.len() {
        line.extend_from_slice(end);
    }
    line.extend_from_slice(format!("{before}{stamp}{after}").as_bytes());
    line.extend_from_slice(end);
    let place = StampPlace { offset, line };
    is_sound(head, dialect, &place, &blocks).then_some(place)
}

/// A comment to the end of its line.
const SEMICOLON: [&str; 2] = ["; ", ""];

/// A byte order mark.
const MARK_BYTES: &[u8] = b"\xef\xbb\xbf";

/// A line of the head: its end, its kind, and whether it names the program.
#[derive(Debug, Clone, Copy, PartialEq)]
struct HeadLine {
    end: usize,
    kind: BlockKind,
    names_program: bool,
    words: usize,
}

/// The whole lines of the head.
fn read(head: &[u8], dialect: Dialect) -> Option<Vec<HeadLine>> {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    reader.feed(head);
    reader.finish();
    let mut batch = Batch::new();
    let mut lines = Vec::new();
    while reader.next_batch(&mut batch).ok()? {
        let offset = usize::try_from(batch.offset()).ok()?;
        lines.extend(batch.blocks().iter().map(|block| HeadLine {
            end: offset + block.end as usize,
            kind: block.kind,
            names_program: batch.words(block).first().is_some_and(|word| word.address == Address::O),
            words: batch.words(block).len(),
        }));
    }
    Some(lines)
}

/// After the banner, `%` and the O line, if the program has them.
fn after_mark_and_name(head: &[u8], lines: &[HeadLine]) -> usize {
    let start = if head.starts_with(MARK_BYTES) { MARK_BYTES.len() } else { 0 };
    let mut offset = start;
    let mut has_mark = false;
    for line in lines {
        match line.kind {
            BlockKind::Banner => offset = line.end,
            BlockKind::Percent if !has_mark => (offset, has_mark) = (line.end, true),
            _ if line.names_program => return line.end,
            // Comments and empty lines may come before the O line. Without an O line they belong to the text after
            // them.
            BlockKind::Blank | BlockKind::Comment => {}
            _ => break,
        }
    }
    offset
}

/// After the first lines that are all of this kind. Empty lines between them are ignored.
fn after_lines(head: &[u8], is_head: impl Fn(&[u8]) -> bool) -> usize {
    let mut offset = if head.starts_with(MARK_BYTES) { MARK_BYTES.len() } else { 0 };
    let mut at = offset;
    while let Some((line, end)) = next_line(head, at) {
        if is_head(line.trim_ascii()) {
            offset = end;
        } else if !line.trim_ascii().is_empty() {
            break;
        }
        at = end;
    }
    offset
}

/// After the first line with this text; at the start if no line has it.
fn after_line_with(head: &[u8], text: &[u8]) -> usize {
    let start = if head.starts_with(MARK_BYTES) { MARK_BYTES.len() } else { 0 };
    let mut at = start;
    while let Some((line, end)) = next_line(head, at) {
        let upper = line.to_ascii_uppercase();
        if memchr::memmem::find(&upper, text).is_some() {
            return end;
        }
        at = end;
    }
    start
}

fn starts(line: &[u8], mark: &[u8]) -> bool {
    line.get(..mark.len()).is_some_and(|start| start.eq_ignore_ascii_case(mark))
}

/// The line that starts here, without its end, and the start of the next line.
fn next_line(head: &[u8], at: usize) -> Option<(&[u8], usize)> {
    let rest = head.get(at..).filter(|rest| !rest.is_empty())?;
    let length = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
    let ending = match rest.get(length..) {
        Some([b'\r', b'\n', ..]) => 2,
        Some([_, ..]) => 1,
        _ => 0,
    };
    Some((&rest[..length], at + length + ending))
}

/// The ending of the first line; LF if the line has no ending.
fn line_end_of(head: &[u8]) -> &'static [u8] {
    match memchr::memchr2(b'\n', b'\r', head).map(|at| head.get(at..at + 2)) {
        Some(Some(b"\r\n")) => b"\r\n",
        Some(Some([b'\r', _])) => b"\r",
        _ => b"\n",
    }
}

/// Whether an ISO program has comments that begin with a semicolon, and none that begin with a parenthesis.
fn semicolons_alone(head: &[u8]) -> bool {
    memchr::memchr(b';', head).is_some() && memchr::memchr(b'(', head).is_none()
}

/// Whether the stamp reads as one comment, and every line of the head reads as before.
fn is_sound(head: &[u8], dialect: Dialect, place: &StampPlace, before: &[HeadLine]) -> bool {
    let (above, below) = head.split_at(place.offset.min(head.len()));
    let stamped = [above, &place.line, below].concat();
    let Some(mut after) = read(&stamped, dialect) else { return false };
    let stamp_end = place.offset + place.line.len();
    let Some(at) = after.iter().position(|line| line.end == stamp_end) else { return false };
    let is_comment =
        after.get(at).is_some_and(|line| matches!(line.kind, BlockKind::Comment | BlockKind::Blank));
    after.remove(at);
    let is_same = |(line, before): (&HeadLine, &HeadLine)| {
        (line.kind, line.names_program, line.words) == (before.kind, before.names_program, before.words)
    };
    is_comment && after.len() == before.len() && after.iter().zip(before).all(is_same)
}

#[cfg(test)]
mod tests {
    use super::super::{StepName, Steps};
    use super::*;

    fn stamp() -> Stamp {
        Stamp {
            version: "0.2.0".to_owned(),
            operation: "cc-compensation".to_owned(),
            steps: Steps::of(&[StepName::Cc]),
            machine: "dmu-80".to_owned(),
            revision: 3,
            tool: None,
            source: "0a1b2c3d4e5f6789".to_owned(),
            parameters: "9f8e7d6c5b4a3928".to_owned(),
        }
    }

    #[test]
    fn a_stamp_stands_after_the_head_in_the_form_of_the_programs_own_comments() {
        let cases = [
            (Dialect::Iso, "%\nO1001(PART)\nG0 X1\n", "%\nO1001(PART)\n(STAMP)\nG0 X1\n"),
            (Dialect::Iso, "%\r\nG0 X1\r\n", "%\r\n(STAMP)\r\nG0 X1\r\n"),
            (Dialect::Iso, "G0 X1\nM30\n", "(STAMP)\nG0 X1\nM30\n"),
            (Dialect::Iso, "(HEAD)\nG0 X1\n", "(STAMP)\n(HEAD)\nG0 X1\n"),
            (Dialect::Iso, "; head\nG0 X1 ; a\n", "; STAMP\n; head\nG0 X1 ; a\n"),
            (Dialect::Iso, "%\n\n(a)\nO7\nG0 X1\n%\n", "%\n\n(a)\nO7\n(STAMP)\nG0 X1\n%\n"),
            (
                Dialect::Iso,
                "====\nlisting of today\n%\nG0 X1\n",
                "====\nlisting of today\n%\n(STAMP)\nG0 X1\n",
            ),
            (Dialect::Iso, "\u{feff}G0 X1\n", "\u{feff}(STAMP)\nG0 X1\n"),
            (Dialect::Iso, "%", "%\n(STAMP)\n"),
            (
                Dialect::Siemens,
                "%_N_A_MPF\n;$PATH=/_N_MPF_DIR\nN10 G0 X1\n",
                "%_N_A_MPF\n;$PATH=/_N_MPF_DIR\n; STAMP\nN10 G0 X1\n",
            ),
            (Dialect::Siemens, "G0 X=1\n", "; STAMP\nG0 X=1\n"),
            (Dialect::Heidenhain, "0 BEGIN PGM A MM\n1 L X+1\n", "0 BEGIN PGM A MM\n; STAMP\n1 L X+1\n"),
            (Dialect::Apt, "PARTNO/ A\nGOTO/1,2,3\n", "PARTNO/ A\n$$ STAMP\nGOTO/1,2,3\n"),
            (Dialect::Apt, "GOTO/1,2,3\n", "$$ STAMP\nGOTO/1,2,3\n"),
        ];
        for (dialect, source, expected) in cases {
            let StampPlace { offset, line } =
                place_stamp(source.as_bytes(), dialect, &stamp()).expect(source);
            let stamped = [&source.as_bytes()[..offset], &line, &source.as_bytes()[offset..]].concat();
            let stamped = String::from_utf8(stamped).unwrap();
            assert_eq!(stamped, expected.replace("STAMP", &stamp().to_string()), "{source}");
        }
        assert_eq!(place_stamp(b"X,Y,Z,A,C\n1,2,3,4,5\n", Dialect::Csv, &stamp()), None);
    }

    #[test]
    fn a_stamp_is_placed_however_long_the_program_is() {
        for blocks in 190..=205 {
            for (dialect, head) in [(Dialect::Okuma, "$A.MIN%\nO1\n"), (Dialect::Iso, "= LISTING =\nO1\n")] {
                let source = format!("{head}{}M2\n%\n", "G1 X1.\n".repeat(blocks));
                let place = place_stamp(source.as_bytes(), dialect, &stamp());
                assert_eq!(place.map(|place| place.offset), Some(head.len()), "{dialect:?}, {blocks} blocks");
            }
        }
    }
}
