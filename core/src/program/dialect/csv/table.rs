//! The rows of a table.

use crate::program::dialect::LineRead;
use crate::program::dialect::line::Source;
use crate::program::dialect::plain::{PlainLine, Shows};
use crate::program::line::{is_blank, line_end, next_line};
use crate::program::number::{MAX_MAGNITUDE, read_unsigned};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Excerpt, ReadFault,
    Word, WordForm,
};

/// Names of columns, in lower case.
const NAMES: [(&[u8], Address); 13] = [
    (b"x", Address::X),
    (b"y", Address::Y),
    (b"z", Address::Z),
    (b"a", Address::A),
    (b"b", Address::B),
    (b"c", Address::C),
    (b"f", Address::F),
    (b"u", Address::U),
    (b"v", Address::V),
    (b"w", Address::W),
    (b"nx", Address::NX),
    (b"ny", Address::NY),
    (b"nz", Address::NZ),
];

fn address(name: &[u8]) -> Option<Address> {
    let name = name.trim_ascii();
    NAMES.iter().find(|(known, _)| name.eq_ignore_ascii_case(known)).map(|(_, address)| *address)
}

/// The separator that a header row uses.
fn separator(header: &[u8]) -> u8 {
    [b';', b'\t'].into_iter().find(|byte| header.contains(byte)).unwrap_or(b',')
}

fn without_mark(line: &[u8]) -> &[u8] {
    line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line)
}

/// Whether a line is a header row with columns X, Y and Z.
pub(in crate::program) fn is_header(line: &[u8]) -> bool {
    let line = without_mark(line);
    let separator = separator(line);
    let has = |wanted| line.split(|&byte| byte == separator).any(|name| address(name) == Some(wanted));
    has(Address::X) && has(Address::Y) && has(Address::Z)
}

/// The columns and the separator of a header row on this line.
pub(in crate::program) fn read_header(header: &[u8], line: u64) -> Result<(Vec<Address>, u8), ReadFault> {
    let header = without_mark(header);
    let separator = separator(header);
    if !is_header(header) && !header.contains(&separator) {
        return Err(ReadFault::NoHeader { line });
    }
    let mut columns = Vec::new();
    for (name, column) in header.split(|&byte| byte == separator).zip(1..) {
        let Some(address) = address(name) else {
            return Err(ReadFault::UnknownColumn { line, column, name: Excerpt::new(name.trim_ascii()) });
        };
        if columns.contains(&address) {
            return Err(ReadFault::RepeatedColumn { line, column, address });
        }
        columns.push(address);
    }
    let has = |address| columns.contains(&address);
    if let Some(&address) = [Address::X, Address::Y, Address::Z].iter().find(|&&address| !has(address)) {
        return Err(ReadFault::MissingColumn { line, address });
    }
    let count = [Address::A, Address::B, Address::C].into_iter().filter(|&address| has(address)).count();
    if count != 2 {
        return Err(ReadFault::RotaryColumns { line, count });
    }
    let points = [Address::U, Address::V, Address::W];
    let normals = [Address::NX, Address::NY, Address::NZ];
    if points.iter().any(|&address| has(address)) && normals.iter().any(|&address| has(address)) {
        return Err(ReadFault::TwoContacts { line });
    }
    for group in [points, normals] {
        if group.iter().any(|&address| has(address))
            && let Some(&address) = group.iter().find(|&&address| !has(address))
        {
            return Err(ReadFault::MissingColumn { line, address });
        }
    }
    Ok((columns, separator))
}

/// Reads one row. An empty cell is not a word: the value before stays.
pub(in crate::program) fn read_row(source: Source<'_>, batch: &mut Batch) -> LineRead {
    match read_plain_row(source, batch) {
        Some(next) => LineRead::one(next),
        None => read_any_row(source, batch),
    }
}

/// Reads a row of plain numbers, one in each column. For any other row it returns `None` and leaves nothing in the
/// batch.
fn read_plain_row(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let separator = batch.separator;
    let columns = std::mem::take(&mut batch.columns);
    let mut row = PlainLine::begin(source, batch);
    let is_plain = plain_cells(&mut row, &columns, separator).is_some();
    let read = row.end(is_plain, Shows::Points);
    batch.columns = columns;
    read
}

#[expect(clippy::inline_always, reason = "the row stays in registers")]
#[inline(always)]
fn plain_cells(row: &mut PlainLine<'_>, columns: &[Address], separator: u8) -> Option<()> {
    let (last, others) = columns.split_last()?;
    for column in others {
        row.word(*column, 0)?;
        if row.byte()? != separator {
            return None;
        }
        row.at += 1;
    }
    row.word(*last, 0)?;
    matches!(row.byte(), Some(b'\n' | b'\r')).then_some(())
}

fn read_any_row(source: Source<'_>, batch: &mut Batch) -> LineRead {
    let Source { text, start, shift, line: number, .. } = source;
    let body_end = line_end(text, start);
    let end = next_line(text, body_end);
    let first_word = batch.words.len();
    let body = text.get(start..body_end).unwrap_or_default();
    let kind = if is_blank(body) {
        BlockKind::Blank
    } else {
        match read_cells(body, start.wrapping_add(shift), batch) {
            Ok(()) => BlockKind::Words,
            Err((code, from, to)) => {
                batch.words.truncate(first_word);
                let offset = batch.offset + start.wrapping_add(shift) as u64;
                batch.faults.push(Diagnostic {
                    code,
                    line: number,
                    called: None,
                    column: u32::try_from(from + 1).unwrap_or(u32::MAX),
                    span: ByteSpan { start: offset + from as u64, end: offset + to as u64 },
                });
                BlockKind::Malformed
            }
        }
    };
    let at = |position: usize| position.wrapping_add(shift);
    #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
    batch.blocks.push(Block {
        line: number,
        start: at(start) as u32,
        body_end: at(body_end) as u32,
        end: at(end) as u32,
        words_start: first_word as u32,
        words_end: batch.words.len() as u32,
        kind,
        flags: BlockFlags::default(),
    });
    LineRead::one(end)
}

/// The words of a row that starts at `base` of the batch's text, or the fault between two of its bytes.
fn read_cells(body: &[u8], base: usize, batch: &mut Batch) -> Result<(), (DiagnosticCode, usize, usize)> {
    let mut from = 0;
    let mut index = 0;
    loop {
        let rest = body.get(from..).unwrap_or_default();
        let to = from + memchr::memchr(batch.separator, rest).unwrap_or(rest.len());
        let Some(&address) = batch.columns.get(index) else {
            return Err((cell_count(body, batch), from, body.len()));
        };
        let cell = body.get(from..to).unwrap_or_default();
        let blanks = cell.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let written = cell.trim_ascii();
        if !written.is_empty() {
            let start = from + blanks;
            let end = start + written.len();
            let Some((value, decimals, has_point)) = cell_number(written) else {
                let code = DiagnosticCode::CellNumber { column: address, text: Excerpt::new(written) };
                return Err((code, start, end));
            };
            if value.abs() > MAX_MAGNITUDE {
                let value = value.clamp(f64::MIN, f64::MAX);
                return Err((
                    DiagnosticCode::TooLarge { address, value, max_abs: MAX_MAGNITUDE },
                    start,
                    end,
                ));
            }
            batch.habits.points |= has_point;
            #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
            batch.words.push(Word {
                value,
                start: (base + start) as u32,
                end: (base + end) as u32,
                address,
                lead: 0,
                decimals,
                form: WordForm::Number,
                has_point,
            });
        }
        index += 1;
        if to >= body.len() {
            break;
        }
        from = to + 1;
    }
    if index == batch.columns.len() { Ok(()) } else { Err((cell_count(body, batch), 0, body.len())) }
}

fn cell_count(body: &[u8], batch: &Batch) -> DiagnosticCode {
    let cells = memchr::memchr_iter(batch.separator, body).count() + 1;
    DiagnosticCode::CellCount {
        cells: u32::try_from(cells).unwrap_or(u32::MAX),
        columns: u32::try_from(batch.columns.len()).unwrap_or(u32::MAX),
    }
}

/// A whole cell as value, decimals and whether it has a point. An exponent counts as the decimals that are needed to
/// write the value without it.
fn cell_number(text: &[u8]) -> Option<(f64, u8, bool)> {
    let (negative, digits) = match text.split_first()? {
        (b'-', rest) => (true, rest),
        (b'+', rest) => (false, rest),
        _ => (false, text),
    };
    let number = read_unsigned(digits, 0)?;
    let mut value = number.value;
    let mut decimals = number.decimals;
    if number.end < digits.len() {
        let exponent = match digits.get(number.end..)?.split_first()? {
            (b'e' | b'E', rest) => std::str::from_utf8(rest).ok()?.parse::<i32>().ok()?,
            _ => return None,
        };
        value = std::str::from_utf8(digits).ok()?.parse().ok()?;
        decimals = u8::try_from((i64::from(decimals) - i64::from(exponent)).clamp(0, 15)).unwrap_or(15);
    }
    Some((if negative { 0.0 - value } else { value }, decimals, number.has_point))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::dialect::plain::tests::compare;

    #[test]
    fn plain_lines_are_read_as_in_the_general_way() {
        let plain = ["1.5,-2.25,3", "-0,+.5,1234.5678"];
        let pieces = ",|,|,|, |;|x|e5|E-2";
        compare(&plain, pieces, read_plain_row, |source, batch| Some(read_any_row(source, batch)));
    }
}
