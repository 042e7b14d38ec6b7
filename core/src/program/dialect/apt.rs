//! APT cutter location text (CLDATA): a major word, `/`, minor words and numbers between commas; `$` at the end of a
//! line runs on, `$$` begins a comment.
//!
//! A `GOTO/` has three values (tip), six (tip and tool axis) or nine (tip, tool axis, contact normal out of the part
//! toward the tool). Words of post-processors that are not known are left alone: they do not move the points.

use super::LineRead;
use super::scan::{Number, Scan, Spelling, extent, fingerprint, number};
use crate::program::line::{is_blank, line_end, next_line};
use crate::program::{Address, Batch, BlockFlags, BlockKind, DiagnosticCode, Keyword, WordForm};

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
/// How far the length of a contact normal may be off 1: six decimals of a rounded vector, or single precision.
const NORMAL_LENGTH: f64 = 0.01;
/// Statements whose rest is text of the post's, dollars included.
const TEXT: [&[u8]; 9] = [
    b"PPRINT",
    b"PARTNO",
    b"INSERT",
    b"REMARK",
    b"PPFUN",
    b"DISPLY",
    b"OPFEATSTART",
    b"OPFEATEND",
    b"TITLES",
];
/// Statements that move the points behind them, or count them otherwise.
const TRANSFORMATIONS: [&[u8]; 12] = [
    b"TRACUT", b"ROTATE", b"TRANS", b"COPY", b"MIRROR", b"INDEX", b"MODE", b"ORIGIN", b"MATRIX", b"SCALE",
    b"ZOFF", b"REFSYS",
];
/// Motions along surfaces that the processor has not worked out.
const SURFACE_MOTIONS: [&[u8]; 8] =
    [b"GO", b"GOFWD", b"GOLFT", b"GORGT", b"GOBACK", b"GOUP", b"GODOWN", b"ARC"];
/// What calls or repeats other statements.
const CALLS: [&[u8]; 4] = [b"CALL", b"CALSUB", b"CALLSUB", b"SUBPRG"];
const FLOW: [&[u8]; 7] = [b"JUMPTO", b"IF", b"DO", b"LOOPST", b"LOOPND", b"MACRO", b"TERMAC"];

/// Reads the statement that starts at `start` of `text` and adds it to the batch; `None` where lines that belong to
/// it are not there yet (`last`: there are no more). `shift` (wrapping) takes positions in `text` to positions in
/// the batch's text.
pub(in crate::program) fn read_line(
    text: &[u8],
    start: usize,
    shift: usize,
    line: u64,
    last: bool,
    batch: &mut Batch,
) -> Option<LineRead> {
    let whole = extent(text, start, last, |line, _| Some(runs_on(line)))?;
    let matrix = matrix_end(text, start, last)?;
    let mut scan = Scan::new(text, start, whole, shift, line, batch);
    if line == 1 && text.get(start..).unwrap_or_default().starts_with(b"\xef\xbb\xbf") {
        scan.at += 3;
    }
    skip_blanks(&mut scan);
    let from = scan.at;
    let kind = if matrix > start {
        let rows = text.get(start..matrix).unwrap_or_default();
        scan.flags.set(BlockFlags::COMMENT);
        apart(&mut scan, Keyword::CoordinateSystem, start, rows)
    } else if is_blank(scan.slice(from, whole.body_end)) {
        scan.skip_all();
        BlockKind::Blank
    } else if scan.slice(from, from + 2) == b"$$" {
        scan.flags.set(BlockFlags::COMMENT);
        BlockKind::Comment
    } else if scan.byte(from) == b'%' {
        BlockKind::Percent
    } else {
        statement(&mut scan)
    };
    Some(scan.close(kind))
}

/// Whether the line ends in a single `$`; text statements end with their line.
fn runs_on(line: &[u8]) -> bool {
    let body = without_comment(line).trim_ascii();
    body.ends_with(b"$") && !TEXT.iter().any(|word| starts(body, word))
}

/// The line up to `$$`.
fn without_comment(line: &[u8]) -> &[u8] {
    // Most lines have no dollar: looking for two costs more.
    let Some(first) = memchr::memchr(b'$', line) else { return line };
    let rest = line.get(first..).unwrap_or_default();
    let comment = rest.windows(2).position(|pair| pair == b"$$");
    comment.map_or(line, |at| line.get(..first + at).unwrap_or_default())
}

fn starts(text: &[u8], word: &[u8]) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// Blanks, and the `$` and line ending between the lines of a statement.
fn skip_blanks(scan: &mut Scan<'_>) {
    while scan.at < scan.extent.body_end && matches!(scan.byte(scan.at), b' ' | b'\t' | b'$' | b'\r' | b'\n')
    {
        if scan.slice(scan.at, scan.at + 2) == b"$$" {
            scan.flags.set(BlockFlags::COMMENT);
            scan.at = line_end(scan.text, scan.at).min(scan.extent.body_end);
            continue;
        }
        scan.at += 1;
    }
}

/// One past the word at `from`.
fn word_end(scan: &Scan<'_>, from: usize) -> usize {
    let mut end = from;
    while scan.byte(end).is_ascii_alphanumeric() || matches!(scan.byte(end), b'_' | b'-' | b'.' | b'+') {
        end += 1;
    }
    end
}

fn is_one_of(word: &[u8], words: &[&[u8]]) -> bool {
    words.iter().any(|known| word.eq_ignore_ascii_case(known))
}

fn statement(scan: &mut Scan<'_>) -> BlockKind {
    let start = scan.at;
    let end = word_end(scan, start);
    let major = scan.slice(start, end);
    scan.at = end;
    if major.is_empty() {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    }
    if major.eq_ignore_ascii_case(b"GOTO") {
        return point(scan, Keyword::Goto, start);
    }
    if major.eq_ignore_ascii_case(b"INSERT") {
        let harmless = is_harmless_code(scan.slice(end, scan.extent.body_end));
        return said(scan, if harmless { Keyword::PostWord } else { Keyword::UnknownStatement }, start);
    }
    if is_one_of(major, &TEXT) {
        return said(scan, Keyword::PostWord, start);
    }
    if is_one_of(major, &TRANSFORMATIONS) {
        return said(scan, Keyword::PointsMoved, start);
    }
    if is_one_of(major, &CALLS) {
        return BlockKind::Call;
    }
    if is_one_of(major, &FLOW) {
        return BlockKind::Flow;
    }
    // `TLON,GOFWD/…`, `TLLFT,GORGT/…`: motions along surfaces.
    if is_one_of(major, &SURFACE_MOTIONS) || names_surface_motion(scan, end) {
        return said(scan, Keyword::SurfaceMotion, start);
    }
    let word = Upper::of(major);
    match word.as_bytes() {
        b"RAPID" => said(scan, Keyword::Rapid, start),
        b"FEDRAT" => feed(scan, start),
        b"FROM" => point(scan, Keyword::From, start),
        b"GODLTA" => delta(scan, start),
        b"GOHOME" => said(scan, Keyword::GoHome, start),
        b"CIRCLE" => said(scan, Keyword::Circle, start),
        b"CYCLE" => {
            let off = has_minor(scan, end, b"OFF");
            said(scan, if off { Keyword::CycleOff } else { Keyword::CycleOn }, start)
        }
        b"CUTCOM" => {
            let off = has_minor(scan, end, b"OFF");
            said(scan, if off { Keyword::R0 } else { Keyword::RadiusCompensation }, start)
        }
        b"MULTAX" => {
            let off = has_minor(scan, end, b"OFF");
            said(scan, if off { Keyword::MultaxOff } else { Keyword::MultaxOn }, start)
        }
        b"TLAXIS" => tool_axis(scan, start),
        b"UNITS" | b"UNIT" => units(scan, start),
        // Along the tool, to a plane that other statements set; what the operator may skip up to OPSKIP/OFF.
        b"RETRCT" | b"OPSKIP" => said(scan, Keyword::SurfaceMotion, start),
        b"PREFUN" => {
            let codes = || minors(scan, end).filter(|word| word.first().is_some_and(u8::is_ascii_digit));
            let harmless = codes().next().is_some() && codes().all(is_harmless_number);
            said(scan, if harmless { Keyword::PostWord } else { Keyword::UnknownStatement }, start)
        }
        b"CSYS" | b"MSYS" => told_apart(scan, Keyword::CoordinateSystem, start),
        b"CUTTER" => told_apart(scan, Keyword::Cutter, start),
        b"TRNTYP" => {
            let moves = |word: &[u8]| {
                number(word, 0, Spelling::Exponent).is_some_and(|number| number.value.abs() > 0.0)
            };
            let plain = has_minor(scan, end, b"WORLD") && !minors(scan, end).any(moves);
            said(scan, if plain { Keyword::PostWord } else { Keyword::PointsMoved }, start)
        }
        b"ROTABL" | b"ROTHED" => rotation(scan, start),
        b"LOADTL" | b"LOAD" | b"TOOLNO" | b"TURRET" | b"UNLOAD" => tool(scan, start),
        b"END" | b"FINI" => said(scan, Keyword::EndPgm, start),
        _ => said(scan, Keyword::PostWord, start),
    }
}

/// G codes that move nothing and leave units, offsets and the sense of words and feeds as cutter location data has them.
const HARMLESS_CODES: [f64; 9] = [4.0, 9.0, 17.0, 40.0, 61.0, 64.0, 80.0, 90.0, 94.0];

/// Whether the number of a G code is that of a harmless one.
fn is_harmless_number(text: &[u8]) -> bool {
    let code = number(text, 0, Spelling::Exponent).map(|number| number.value);
    code.is_some_and(|code| HARMLESS_CODES.iter().any(|known| (code - known).abs() < 1e-9))
}

/// Whether the text is words for people, as `Stock Size X95. Y150. Z120.`: two of letters alone, which no block of a program
/// for a control has beside axis words.
fn is_prose(text: &[u8]) -> bool {
    let words = text.split(|byte| !byte.is_ascii_alphanumeric());
    words.filter(|word| word.len() > 1 && word.iter().all(u8::is_ascii_alphabetic)).nth(1).is_some()
}

/// Whether code that goes into the posted program as it stands moves no axis and calls nothing. Comments between round
/// brackets do not count; they end at the first `)`, where some controls end them: what stands behind it may run.
fn is_harmless_code(text: &[u8]) -> bool {
    if is_prose(text) {
        return true;
    }
    let mut in_comment = false;
    for (at, byte) in text.iter().enumerate() {
        match byte {
            b'(' => in_comment = true,
            b')' => in_comment = false,
            _ => {}
        }
        let before = at.checked_sub(1).and_then(|before| text.get(before));
        if in_comment || before.is_some_and(u8::is_ascii_alphabetic) {
            continue;
        }
        let value = text.get(at + 1..).unwrap_or_default().trim_ascii_start();
        let has_value = value.first().is_some_and(|byte| {
            byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.' | b'#' | b'=' | b'[')
        });
        let moves = match byte.to_ascii_uppercase() {
            _ if !has_value => false,
            b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C' | b'U' | b'V' | b'W' => true,
            b'G' => !is_harmless_number(value),
            b'M' => number(value, 0, Spelling::Exponent)
                .is_none_or(|number| [96.0, 97.0, 98.0, 99.0, 198.0].contains(&number.value)),
            _ => false,
        };
        if moves {
            return false;
        }
    }
    true
}

/// A word in upper case, cut to what the statements known have.
struct Upper {
    bytes: [u8; 8],
    length: usize,
}

impl Upper {
    fn of(word: &[u8]) -> Self {
        let mut upper = Self { bytes: [0; 8], length: 0 };
        if word.len() <= upper.bytes.len() {
            for (slot, byte) in upper.bytes.iter_mut().zip(word) {
                *slot = byte.to_ascii_uppercase();
            }
            upper.length = word.len();
        }
        upper
    }

    fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

fn said(scan: &mut Scan<'_>, keyword: Keyword, start: usize) -> BlockKind {
    let end = scan.extent.body_end;
    scan.keyword(keyword, start, end);
    scan.skip_all();
    BlockKind::Words
}

/// The rest of the statement up to a comment.
fn rest<'a>(scan: &Scan<'a>, from: usize) -> &'a [u8] {
    without_comment(scan.slice(from, scan.extent.body_end))
}

fn minors<'a>(scan: &Scan<'a>, from: usize) -> impl Iterator<Item = &'a [u8]> + use<'a> {
    rest(scan, from)
        .split(|byte| matches!(byte, b',' | b'/' | b' ' | b'\t' | b'$' | b'\r' | b'\n'))
        .filter(|word| !word.is_empty())
}

fn has_minor(scan: &Scan<'_>, from: usize, wanted: &[u8]) -> bool {
    minors(scan, from).any(|word| word.eq_ignore_ascii_case(wanted))
}

/// `TLON,GOFWD/`: a surface motion named before the slash.
fn names_surface_motion(scan: &Scan<'_>, from: usize) -> bool {
    let rest = rest(scan, from);
    let head = rest.get(..memchr::memchr(b'/', rest).unwrap_or(rest.len())).unwrap_or_default();
    head.split(|byte| matches!(byte, b',' | b' ' | b'\t')).any(|word| is_one_of(word, &SURFACE_MOTIONS))
}

/// Goes behind the slash of the statement; false where there is none.
fn slash(scan: &mut Scan<'_>) -> bool {
    skip_blanks(scan);
    let found = scan.byte(scan.at) == b'/';
    scan.at += usize::from(found);
    found
}

/// The numbers between commas from the present position on, each with its start. Gives up at anything else.
fn numbers(scan: &mut Scan<'_>) -> Option<([(usize, Number); 9], usize)> {
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
fn point(scan: &mut Scan<'_>, keyword: Keyword, start: usize) -> BlockKind {
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
    scan: &mut Scan<'_>,
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

/// `GODLTA/dx,dy,dz`; along the tool axis with one value.
fn delta(scan: &mut Scan<'_>, start: usize) -> BlockKind {
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
fn tool_axis(scan: &mut Scan<'_>, start: usize) -> BlockKind {
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
fn feed(scan: &mut Scan<'_>, start: usize) -> BlockKind {
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
                // A feed for something else behind it.
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
        let keyword = match Upper::of(scan.slice(from, end)).as_bytes() {
            b"MMPM" => Keyword::MmPerMinute,
            b"IPM" => Keyword::InchPerMinute,
            b"PERMIN" | b"UPM" => Keyword::UnitPerMinute,
            b"MMPR" => Keyword::MmPerRevolution,
            b"IPR" => Keyword::InchPerRevolution,
            b"PERREV" | b"UPR" => Keyword::UnitPerRevolution,
            _ => Keyword::FeedElsewhere,
        };
        scan.keyword(keyword, from, end);
        scan.at = end;
    }
    if !has_number {
        scan.keyword(Keyword::FeedElsewhere, head, head);
    }
    BlockKind::Words
}

/// `UNITS/MM`, `UNITS/INCHES`
fn units(scan: &mut Scan<'_>, start: usize) -> BlockKind {
    let unit = minors(scan, scan.at).next().unwrap_or_default();
    let keyword = if unit.eq_ignore_ascii_case(b"MM") || starts(unit, b"MILLI") {
        Keyword::BeginMm
    } else if starts(unit, b"INCH") || unit.eq_ignore_ascii_case(b"IN") {
        Keyword::BeginInch
    } else {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    };
    said(scan, keyword, start)
}

/// `LOADTL/5`, `LOAD/TOOL,5`: the tool's number as a T word.
fn tool(scan: &mut Scan<'_>, start: usize) -> BlockKind {
    let (head, end) = (scan.at, scan.extent.body_end);
    scan.keyword(Keyword::ToolCall, start, end);
    let body = scan.text.get(..end).unwrap_or_default();
    let is_open = |byte: u8| matches!(byte, b',' | b'/' | b' ' | b'\t');
    let mut starts =
        (head..end).filter(|at| scan.byte(*at).is_ascii_digit() && is_open(scan.byte(at.saturating_sub(1))));
    if let Some(from) = starts.next()
        && let Some(number) = number(body, from, Spelling::Exponent)
    {
        scan.number_word(Address::T, WordForm::Number, from, 0, number);
    }
    scan.skip_all();
    BlockKind::Words
}

/// A statement that is told apart from others of its kind by its P word: equal texts have equal ones.
fn told_apart(scan: &mut Scan<'_>, keyword: Keyword, start: usize) -> BlockKind {
    let text = rest(scan, scan.at);
    apart(scan, keyword, start, text)
}

/// The same for a text that stands elsewhere. Blanks do not count.
fn apart(scan: &mut Scan<'_>, keyword: Keyword, start: usize, text: &[u8]) -> BlockKind {
    let value = fingerprint(text.iter().copied().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'$'));
    let end = scan.extent.body_end;
    scan.keyword(keyword, start, end);
    scan.number_word(Address::P, WordForm::Number, end, 0, Number::standing_for(value, end));
    scan.skip_all();
    BlockKind::Words
}

/// Rows of the matrix that some systems state the machining axes with, in comments: `$$ 1.0 0.0 0.0 25.0`.
const MATRIX_ROWS: usize = 3;

/// One past the matrix in comments that starts at `start`, `start` itself where there is none; `None` where that is not to
/// be seen yet.
fn matrix_end(text: &[u8], start: usize, last: bool) -> Option<usize> {
    let mut at = start;
    for _ in 0..MATRIX_ROWS {
        let end = line_end(text, at);
        if end >= text.len() && !last {
            return None;
        }
        if !is_matrix_row(text.get(at..end).unwrap_or_default()) {
            return Some(start);
        }
        at = next_line(text, end);
    }
    Some(at)
}

/// A comment of four numbers and nothing else.
fn is_matrix_row(line: &[u8]) -> bool {
    let Some(rest) = line.trim_ascii_start().strip_prefix(b"$$") else { return false };
    let mut items = rest.split(u8::is_ascii_whitespace).filter(|item| !item.is_empty());
    let is_number =
        |item: &[u8]| number(item, 0, Spelling::Exponent).is_some_and(|number| number.end == item.len());
    (0..4).all(|_| items.next().is_some_and(is_number)) && items.next().is_none()
}

/// `ROTABL/ 1.570796,AAXIS,TABLE,CCLW`: by nothing it is harmless, otherwise the points behind it are turned.
fn rotation(scan: &mut Scan<'_>, start: usize) -> BlockKind {
    let turns = minors(scan, scan.at).any(|word| {
        number(word, 0, Spelling::Exponent).is_none_or(|number| number.value.abs() > 0.0)
            && word.first().is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.'))
    });
    said(scan, if turns { Keyword::PointsMoved } else { Keyword::PostWord }, start)
}
