//! Statements with numbers: points, tool axes, feeds.

use super::line::{Upper, said, skip_blanks, word_end};
use crate::program::dialect::line::{Line, Source};
use crate::program::dialect::number::{Number, Spelling, number};
use crate::program::dialect::plain::{PlainLine, Shows};
use crate::program::{Address, Batch, BlockKind, DiagnosticCode, Keyword, WordForm};

/// The values of a `GOTO/` in their order.
pub(in crate::program) const POINT: [Address; 9] = [
    Address::X,
    Address::Y,
    Address::Z,
    Address::TI,
    Address::TJ,
    Address::TK,
    Address::NX,
    Address::NY,
    Address::NZ,
];

/// The largest difference between the length of a contact normal and 1: six decimals of a rounded vector, or single
/// precision.
const NORMAL_LENGTH: f64 = 0.01;

/// The head of a plain point.
const HEAD: &[u8; 5] = b"GOTO/";

/// Reads a line `GOTO/x,y,z[,i,j,k]` of plain numbers. For any other line it returns `None` and leaves nothing in the
/// batch.
pub(super) fn read_plain_point(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let mut line = PlainLine::begin(source, batch);
    let is_plain = plain_numbers(&mut line).is_some();
    line.end(is_plain, Shows::PointsZerosAndSigns)
}

#[expect(clippy::inline_always, reason = "the line stays in registers")]
#[inline(always)]
fn plain_numbers(line: &mut PlainLine<'_>) -> Option<()> {
    if !line.text.get(line.at..)?.first_chunk::<5>()?.eq_ignore_ascii_case(HEAD) {
        return None;
    }
    line.at += HEAD.len();
    line.keyword(Keyword::Goto, HEAD.len());
    for (index, address) in POINT.into_iter().enumerate().take(6) {
        line.skip_blanks();
        line.word(address, 0)?;
        match line.byte()? {
            b'\n' | b'\r' if index % 3 == 2 => return Some(()),
            b',' => line.at += 1,
            _ => return None,
        }
    }
    None
}

/// Moves to the byte after the slash of the statement; false if there is no slash.
fn slash(scan: &mut Line<'_>) -> bool {
    skip_blanks(scan);
    let found = scan.byte(scan.at) == b'/';
    scan.at += usize::from(found);
    found
}

/// The numbers between commas from the present position on, each with its start. Fails at anything else.
fn numbers(scan: &mut Line<'_>) -> Option<([(usize, Number); 9], usize)> {
    let mut list = [(0, Number::standing_for(0.0, 0)); 9];
    let mut count = 0;
    let body = scan.text.get(..scan.extent.body_end).unwrap_or_default();
    loop {
        skip_blanks(scan);
        let start = scan.at;
        if start >= scan.extent.body_end {
            break;
        }
        let (Some(read), Some(slot)) = (number(body, start, Spelling::Exponent), list.get_mut(count)) else {
            scan.fail_number(start);
            return None;
        };
        *slot = (start, read);
        count += 1;
        scan.at = read.end;
        skip_blanks(scan);
        match scan.byte(scan.at) {
            b',' => scan.at += 1,
            _ if scan.at >= scan.extent.body_end => break,
            _ => {
                scan.fail_unexpected(scan.at);
                return None;
            }
        }
    }
    Some((list, count))
}

/// `GOTO/x,y,z[,i,j,k[,nx,ny,nz]]`, `FROM/…`
pub(super) fn point(scan: &mut Line<'_>, keyword: Keyword, start: usize) -> BlockKind {
    if !slash(scan) {
        scan.fail_number(start);
        return BlockKind::Malformed;
    }
    let head = scan.at;
    let Some((list, count)) = numbers(scan) else { return BlockKind::Malformed };
    if !matches!(count, 3 | 6 | 9) {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    }
    scan.keyword(keyword, start, head);
    let mut values = list.iter().map(|(_, number)| number.value).skip(6);
    if count == 9
        && let (Some(x), Some(y), Some(z)) = (values.next(), values.next(), values.next())
    {
        let length = (x * x + y * y + z * z).sqrt();
        if (length - 1.0).abs() > NORMAL_LENGTH {
            let (from, to) = (list[6].0, list[8].1.end);
            scan.fail(DiagnosticCode::NotADirection { length }, from, to);
            return BlockKind::Malformed;
        }
    }
    words(scan, &list, count, &POINT, WordForm::Number);
    BlockKind::Words
}

/// Adds the first numbers of a list as words of these addresses.
fn words(
    scan: &mut Line<'_>,
    list: &[(usize, Number); 9],
    count: usize,
    addresses: &[Address],
    form: WordForm,
) {
    for ((start, number), address) in list.iter().take(count).zip(addresses) {
        scan.number_word(*address, form, *start, 0, *number);
    }
    scan.skip_all();
}

/// `GODLTA/dx,dy,dz`; with one value, along the tool axis.
pub(super) fn delta(scan: &mut Line<'_>, start: usize) -> BlockKind {
    if !slash(scan) {
        scan.fail_number(start);
        return BlockKind::Malformed;
    }
    let head = scan.at;
    let Some((list, count)) = numbers(scan) else { return BlockKind::Malformed };
    if count != 3 {
        return said(scan, Keyword::SurfaceMotion, start);
    }
    scan.keyword(Keyword::Goto, start, head);
    words(scan, &list, 3, &POINT, WordForm::Incremental);
    BlockKind::Words
}

/// `TLAXIS/i,j,k`
pub(super) fn tool_axis(scan: &mut Line<'_>, start: usize) -> BlockKind {
    if !slash(scan) {
        return said(scan, Keyword::PointsMoved, start);
    }
    let head = scan.at;
    let Some((list, count)) = numbers(scan) else { return BlockKind::Malformed };
    if count != 3 {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    }
    scan.keyword(Keyword::ToolAxis, start, head);
    words(scan, &list, 3, &[Address::TI, Address::TJ, Address::TK], WordForm::Number);
    BlockKind::Words
}

/// `FEDRAT/100.,MMPM`, `FEDRAT/ MMPM,171.09`, `FEDRAT/0.2,IPR`
pub(super) fn feed(scan: &mut Line<'_>, start: usize) -> BlockKind {
    slash(scan);
    let head = scan.at;
    scan.keyword(Keyword::Fedrat, start, head);
    let body = scan.text.get(..scan.extent.body_end).unwrap_or_default();
    let mut has_number = false;
    while scan.at < scan.extent.body_end {
        skip_blanks(scan);
        let from = scan.at;
        if from >= scan.extent.body_end {
            break;
        }
        if scan.byte(from) == b',' {
            scan.at += 1;
            continue;
        }
        if let Some(number) = number(body, from, Spelling::Exponent) {
            if has_number {
                // After the number, a feed for something else.
                scan.keyword(Keyword::FeedElsewhere, from, number.end);
                scan.at = number.end;
                continue;
            }
            has_number = true;
            scan.number_word(Address::F, WordForm::Number, from, 0, number);
            continue;
        }
        let end = word_end(scan, from);
        if end == from {
            scan.fail_unexpected(from);
            return BlockKind::Malformed;
        }
        let unit = feed_unit(scan.slice(from, end));
        scan.keyword(unit.unwrap_or(Keyword::FeedElsewhere), from, end);
        scan.at = end;
    }
    if !has_number {
        scan.keyword(Keyword::FeedElsewhere, head, head);
    }
    BlockKind::Words
}

/// The unit of a feed by its word.
pub(super) fn feed_unit(word: &[u8]) -> Option<Keyword> {
    match Upper::of(word).as_bytes() {
        b"MMPM" => Some(Keyword::MmPerMinute),
        b"IPM" => Some(Keyword::InchPerMinute),
        b"PERMIN" | b"UPM" => Some(Keyword::UnitPerMinute),
        b"MMPR" => Some(Keyword::MmPerRevolution),
        b"IPR" => Some(Keyword::InchPerRevolution),
        b"PERREV" | b"UPR" => Some(Keyword::UnitPerRevolution),
        _ => None,
    }
}
