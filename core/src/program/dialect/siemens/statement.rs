//! The parts of Sinumerik programs that are not letters with numbers: names, assignments, calls, values of every form.

use super::constants::{MAX_DEPTH, Mistake, NoNames, Number, Walk, operand_name_end, with_exponent};
use super::cycle;
use super::line::{fail_exponent, fail_value, has_equals, has_exponent, push_keyword};
use super::names::{self, Name};
use crate::program::dialect::line::Line;
use crate::program::number::{MAX_MAGNITUDE, read_unsigned};
use crate::program::{Address, BlockFlags, BlockKind, DiagnosticCode, Keyword, Word, WordForm};

/// The number of decimals that is assumed for a value that is not written as a decimal.
const COMPUTED_DECIMALS: u8 = 4;
/// From this number on, the digits of `CYCLE832` switch transformations.
const FIRST_TRANSFORMATION_DIGIT: f64 = 1000.0;

/// Text at `start` that is not a letter with a number: a name, or a letter with `=` or `[`.
pub(super) fn named(line: &mut Line<'_>, start: usize) {
    let end = operand_name_end(line.text, start);
    let Some(text) = line.text.get(start..end).filter(|text| !text.is_empty()) else {
        return line.fail_unexpected(start);
    };
    match *text {
        [b'$', ..] => system_assignment(line, start, end),
        [letter] if letter.is_ascii_alphabetic() => lone_letter(line, start, letter),
        [_] => line.fail_unexpected(start),
        _ if line.byte(end) == b':' && line.has_only_number() => line.at = end + 1,
        _ => match names::name(text) {
            Some(name) => known(line, start, end, name),
            None => own(line, start, end),
        },
    }
}

/// A name of the control's language.
fn known(line: &mut Line<'_>, start: usize, end: usize, name: Name) {
    match name {
        Name::Flow => line.settle(BlockKind::Flow),
        Name::Call => line.settle(BlockKind::Call),
        Name::Heading => line.settle(BlockKind::Assignment),
        Name::Declaration => {
            line.flags.set(BlockFlags::ASSIGNS);
            let line_end = line.end();
            push_keyword(line, Keyword::Declaration, start, line_end);
            line.settle(BlockKind::Assignment);
        }
        Name::Return => {
            // The same as the M code M17.
            let Some(tail) = skip_tail(line, start, end) else { return };
            push(line, Address::M, WordForm::Number, start, tail.end, 0, 17.0);
        }
        Name::ModalCall => modal_call(line, start, end),
        Name::Nothing => {
            if let Some(tail) = skip_tail(line, start, end) {
                line.at = tail.end;
            }
        }
        Name::Word(Keyword::Turns) if has_equals(line, end) => {
            push_keyword(line, Keyword::Turns, start, end);
            value_word(line, Address::P, end, end);
        }
        Name::Word(keyword) => {
            let Some(tail) = skip_tail(line, start, end) else { return };
            let keyword = match keyword {
                // The second transformation, a basic orientation or offsets of the rotary axes: another
                // transformation.
                Keyword::Traori if !tail.is_first_transformation() => Keyword::OtherTraori,
                Keyword::CornerRounding if tail.value == Some(0.0) => Keyword::CornerRoundingOff,
                other => other,
            };
            push_keyword(line, keyword, start, tail.end);
        }
        Name::Value(address) if has_equals(line, end) => value_word(line, address, start, end),
        Name::Corner(address) if has_equals(line, end) => {
            let Some(tail) = skip_tail(line, start, end) else { return };
            let value = tail.value.unwrap_or_default();
            if value.abs() > MAX_MAGNITUDE {
                return line.fail_too_large(lettered(address, Address::R), value, line.at, tail.end);
            }
            push(line, address, WordForm::Comma, start, tail.end, 0, value);
        }
        Name::Value(_) | Name::Corner(_) => line.fail_unexpected(start),
    }
}

/// A name of the program or of the machine's builder: a variable that is assigned, a cycle, a call.
fn own(line: &mut Line<'_>, start: usize, end: usize) {
    let text = line.text.get(start..end).unwrap_or_default();
    let cycle = text.get(..5).filter(|head| head.eq_ignore_ascii_case(b"CYCLE")).and_then(|_| text.get(5..));
    let number: Option<u32> = cycle.and_then(|digits| std::str::from_utf8(digits).ok()?.parse().ok());
    if let Some(number) = number {
        return numbered_cycle(line, start, end, number);
    }
    let next = line.blanks_end(end);
    if line.byte(next) == b'[' || has_equals(line, end) {
        assignment(line, start, end, Keyword::Named);
    } else {
        line.settle(BlockKind::Call);
    }
}

fn numbered_cycle(line: &mut Line<'_>, start: usize, end: usize, number: u32) {
    let Some(tail) = skip_tail(line, start, end) else { return };
    let keyword = match number {
        800 if tail.arguments == 0 => Keyword::SwivelOff,
        800 => Keyword::Swivel,
        // Tolerances and dynamics. With more than three digits it may switch transformations.
        832 if tail.second.is_none_or(|digits| digits < FIRST_TRANSFORMATION_DIGIT) => {
            line.at = tail.end;
            return;
        }
        832 => Keyword::UnknownStatement,
        _ if names::is_standard_cycle(number) => {
            if cycle::hole(line, Keyword::Cycle, start, end, number, false) {
                line.at = tail.end;
                return;
            }
            Keyword::Cycle
        }
        _ => return line.settle(BlockKind::Call),
    };
    push_keyword(line, keyword, start, tail.end);
}

fn modal_call(line: &mut Line<'_>, start: usize, end: usize) {
    let callee = line.blanks_end(end);
    if matches!(line.byte(callee), b';' | b'\n' | b'\r') {
        line.at = callee;
        return push_keyword(line, Keyword::ModalCallEnd, start, end);
    }
    let callee_end = operand_name_end(line.text, callee);
    let name = line.text.get(callee..callee_end).unwrap_or_default();
    let number: Option<u32> = name
        .get(..5)
        .filter(|head| head.eq_ignore_ascii_case(b"CYCLE"))
        .and_then(|_| std::str::from_utf8(name.get(5..)?).ok()?.parse().ok());
    let is_standard =
        number.is_some_and(names::is_standard_cycle) || names::name(name) == Some(Name::Word(Keyword::Cycle));
    // What stands behind the arguments is not read, so its effect is unknown.
    let is_alone = walk_tail(line.text, callee_end)
        .is_ok_and(|tail| matches!(line.byte(line.blanks_end(tail.end)), b';' | b'\n' | b'\r'));
    let is_standard = is_standard && is_alone;
    let is_hole = number
        .filter(|_| is_standard)
        .is_some_and(|number| cycle::hole(line, Keyword::ModalCycle, start, callee_end, number, true));
    if is_hole {
        return line.skip_all();
    }
    let keyword = if is_standard { Keyword::ModalCycle } else { Keyword::ModalCall };
    let line_end = line.end();
    push_keyword(line, keyword, start, line_end);
}

/// The text after a name: the number of arguments, the first two if they are numbers, and a value after `=`.
struct Tail {
    end: usize,
    arguments: usize,
    first: Option<f64>,
    second: Option<f64>,
    value: Option<f64>,
}

impl Tail {
    /// Whether these are the arguments of the first transformation as it is configured: no argument, or 1.
    fn is_first_transformation(&self) -> bool {
        match self.arguments {
            0 => true,
            1 => self.first.is_some_and(|number| (number - 1.0).abs() <= 0.0),
            _ => false,
        }
    }
}

/// Moves over subscripts, arguments and `=` with a value. `None`: they cannot be read, and the line has failed.
fn skip_tail(line: &mut Line<'_>, start: usize, end: usize) -> Option<Tail> {
    let result = walk_tail(line.text, end);
    result.map_err(|mistake| give_up(line, start, mistake)).ok()
}

fn walk_tail(text: &[u8], end: usize) -> Result<Tail, Mistake> {
    let mut names = NoNames;
    let mut walk = Walk::new(text, end, &mut names);
    let mut tail = Tail { end, arguments: 0, first: None, second: None, value: None };
    if walk.is_next(b'[') {
        walk.list(b']')?;
        tail.end = walk.at;
    }
    if walk.is_next(b'(') {
        let arguments = walk.list(b')')?;
        tail.end = walk.at;
        tail.arguments = arguments.count;
        let value = |index: usize| arguments.values().get(index).copied().flatten().map(|read| read.value);
        (tail.first, tail.second) = (value(0), value(1));
    }
    walk.at = tail.end;
    if walk.take_equals() {
        tail.value = walk.value()?.map(|number| number.value);
        tail.end = walk.at;
    }
    Ok(tail)
}

fn give_up(line: &mut Line<'_>, start: usize, mistake: Mistake) {
    match mistake {
        Mistake::NoOperand(_) => fail_value(line, start, false),
        Mistake::Unclosed(at) => fail_value(line, at.max(start), true),
        Mistake::TooDeep(_) => {
            line.fail_with(|text| DiagnosticCode::TooDeep { text, max: u32::from(MAX_DEPTH) }, start);
        }
        Mistake::Exponent(at) => fail_exponent(line, at),
    }
}

/// `NAME=…`, `NAME[2,1]=…`: the word is the whole assignment.
fn assignment(line: &mut Line<'_>, start: usize, name_end: usize, keyword: Keyword) {
    let Some(tail) = skip_tail(line, start, name_end) else { return };
    let text = line.text.get(name_end..tail.end).unwrap_or_default();
    if !text.contains(&b'=') || tail.arguments > 0 {
        return line.fail_unexpected(start);
    }
    line.flags.set(BlockFlags::ASSIGNS);
    push_keyword(line, keyword, start, tail.end);
}

/// `$P_UIFR[1]=…`: offsets, frames, tools and machine data may change. Inputs, timers and markers have no effect.
fn system_assignment(line: &mut Line<'_>, start: usize, end: usize) {
    let name = line.text.get(start..end).unwrap_or_default();
    let bare = name.get(name.iter().take_while(|byte| **byte == b'$').count()..).unwrap_or_default();
    if bare.is_empty() {
        return line.fail_unexpected(start);
    }
    if matches!(bare.first(), Some(b'R' | b'r')) {
        return assignment(line, start, end, Keyword::Assigned);
    }
    let is_harmless = [&b"A_"[..], b"AC_", b"AN_"].iter().any(|mark| starts_with_ignoring_case(bare, mark));
    let Some(tail) = skip_tail(line, start, end) else { return };
    if !line.text.get(end..tail.end).unwrap_or_default().contains(&b'=') {
        return line.fail_unexpected(start);
    }
    line.flags.set(BlockFlags::ASSIGNS);
    if !is_harmless {
        line.flags.set(BlockFlags::ASSIGNS_SYSTEM);
    }
    line.at = tail.end;
}

fn starts_with_ignoring_case(text: &[u8], mark: &[u8]) -> bool {
    text.get(..mark.len()).is_some_and(|head| head.eq_ignore_ascii_case(mark))
}

/// One letter with `=` or `[` after it, or without anything that it could have.
fn lone_letter(line: &mut Line<'_>, start: usize, letter: u8) {
    let end = start + 1;
    let is_indexed = line.byte(line.blanks_end(end)) == b'[';
    let letter = letter.to_ascii_uppercase();
    match letter {
        b'R' if is_indexed => assignment(line, start, end, Keyword::Assigned),
        // A code by its number in a group. The text does not state which code this is.
        b'G' if is_indexed => {
            let Some(tail) = skip_tail(line, start, end) else { return };
            push(line, Address::G, WordForm::Expression, start, tail.end, 1, 0.0);
        }
        b'M' | b'H' | b'S' | b'F' if is_indexed => {
            if let Some(tail) = skip_tail(line, start, end) {
                line.at = tail.end;
            }
        }
        b'A'..=b'C' | b'E' | b'U'..=b'Z' if is_indexed => machine_axis(line, start, end),
        b'L' | b'N' | b'R' => fail_value(line, start, false),
        _ if has_equals(line, end) => value_word(line, Address::of_letter(letter), start, end),
        _ => fail_value(line, start, false),
    }
}

fn machine_axis(line: &mut Line<'_>, start: usize, end: usize) {
    let Some(tail) = skip_tail(line, start, end) else { return };
    push_keyword(line, Keyword::MachineAxis, start, tail.end);
}

/// A letter with a number and unusual text after it, or a letter that has a meaning of its own.
pub(super) fn odd_number(line: &mut Line<'_>, start: usize, at: usize, end: usize, negative: bool) {
    let letter = line.byte(start).to_ascii_uppercase();
    if letter == b'L' {
        return line.settle(BlockKind::Call);
    }
    if let Some(exponent_end) = has_exponent(line.text, end) {
        return number_with_exponent(line, start, at, end, exponent_end, negative);
    }
    if !has_equals(line, end) || at != start + 1 {
        // `X10E5` is two words.
        if matches!(line.byte(end), b'E' | b'e') && letter != b'R' {
            return plain(line, start, at, end, negative);
        }
        return line.fail_unexpected(start);
    }
    let digits = line.text.get(at..end).unwrap_or_default();
    if !digits.iter().all(u8::is_ascii_digit) {
        return line.fail_unexpected(start);
    }
    match (letter, digits) {
        (b'R', _) => assignment(line, start, end, Keyword::Assigned),
        (b'A', b"3") => value_word(line, Address::TI, start, end),
        (b'B', b"3") => value_word(line, Address::TJ, start, end),
        (b'C', b"3") => value_word(line, Address::TK, start, end),
        (b'A'..=b'C', [b'2' | b'4'..=b'8']) => {
            let Some(tail) = skip_tail(line, start, end) else { return };
            push_keyword(line, Keyword::OrientationWord, start, tail.end);
        }
        (b'M', b"0") => value_word(line, Address::M, start, end),
        (b'T', _) => value_word(line, Address::T, start, end),
        // A word of another spindle, or the intermediate point of a circle, which has no meaning elsewhere.
        (b'M' | b'H' | b'S', _) | (b'I'..=b'K', b"1") => {
            if let Some(tail) = skip_tail(line, start, end) {
                line.at = tail.end;
            }
        }
        (b'A'..=b'C' | b'E' | b'O' | b'Q' | b'U'..=b'Z', _) => machine_axis(line, start, end),
        _ => line.fail_unexpected(start),
    }
}

/// A letter with a plain number after all.
fn plain(line: &mut Line<'_>, start: usize, at: usize, end: usize, negative: bool) {
    let Some(number) = read_unsigned(line.text, at) else { return fail_value(line, start, false) };
    let letter = line.byte(start);
    let value = if negative { 0.0 - number.value } else { number.value };
    if number.value > MAX_MAGNITUDE {
        return line.fail_too_large(Address::of_letter(letter), value, line.at, end);
    }
    line.note_number(number.has_point, number.has_whole);
    let word = Word {
        value,
        start: line.in_batch(start),
        end: line.in_batch(end),
        address: Address::of_letter(letter),
        lead: 1,
        decimals: number.decimals,
        form: WordForm::Number,
        has_point: number.has_point,
    };
    line.at = end;
    line.push(word);
}

fn number_with_exponent(
    line: &mut Line<'_>,
    start: usize,
    at: usize,
    mantissa_end: usize,
    end: usize,
    negative: bool,
) {
    let letter = line.byte(start);
    let magnitude = with_exponent(line.text, at, mantissa_end, end);
    let value = if negative { 0.0 - magnitude } else { magnitude };
    if magnitude > MAX_MAGNITUDE {
        return line.fail_too_large(Address::of_letter(letter), value, line.at, end);
    }
    push(line, Address::of_letter(letter), WordForm::Evaluated, start, end, 1, value);
}

/// `X=10.5`, `X=R1+2`, `X=IC(5)`: `name_end` is one past the letters.
fn value_word(line: &mut Line<'_>, address: Address, start: usize, name_end: usize) {
    let equals = line.blanks_end(name_end);
    let value_at = line.blanks_end(equals + 1);
    match read_value(line.text, value_at) {
        Err(mistake) => give_up(line, start, mistake),
        Ok(read) => {
            if address == Address::T && is_text(line.text.get(value_at..read.end).unwrap_or_default()) {
                return push(line, address, WordForm::Name, start, read.end, value_at - start, 0.0);
            }
            let Some(value) = read.value.map(|number| number.value) else {
                return push(line, address, WordForm::Expression, start, read.end, equals + 1 - start, 0.0);
            };
            if value.abs() > MAX_MAGNITUDE {
                return line.fail_too_large(lettered(address, Address::A), value, line.at, read.end);
            }
            if let Some(written) = read.written {
                line.note_number(written.has_point, written.has_whole);
                let word = Word {
                    value,
                    start: line.in_batch(start),
                    end: line.in_batch(read.end),
                    address,
                    lead: lead(equals + 1 - start),
                    decimals: written.decimals,
                    form: read.form,
                    has_point: written.has_point,
                };
                line.at = read.end;
                return line.push(word);
            }
            let form = if read.form == WordForm::Number { WordForm::Evaluated } else { read.form };
            push(line, address, form, start, read.end, equals + 1 - start, value);
        }
    }
}

/// Whether a value is only a text: `"BALL_10"`.
fn is_text(value: &[u8]) -> bool {
    matches!(value.trim_ascii_end(), [b'"', text @ .., b'"'] if !text.contains(&b'"'))
}

/// A value as written.
struct ReadValue {
    value: Option<Number>,
    /// `Number`, `Absolute` or `Incremental`.
    form: WordForm,
    /// The number, if the value is only a number.
    written: Option<crate::program::number::Unsigned>,
    end: usize,
}

fn read_value(text: &[u8], at: usize) -> Result<ReadValue, Mistake> {
    let mut names = NoNames;
    let wrapper = wrapper(text, at);
    let inner = wrapper.map_or(at, |(_, inner)| inner);
    let mut walk = Walk::new(text, inner, &mut names);
    let value = walk.expression()?;
    let mut end = walk.at;
    let written = written_number(text, inner).filter(|number| number.end == end);
    let form = match wrapper {
        None => WordForm::Number,
        Some((form, _)) => {
            if !walk.take(b')') {
                return Err(Mistake::Unclosed(at));
            }
            end = walk.at;
            form
        }
    };
    Ok(ReadValue { value, form, written, end })
}

/// `AC(`, `IC(` and `QU(` (for output without waiting): the form that they give the value, and where the value begins.
fn wrapper(text: &[u8], at: usize) -> Option<(WordForm, usize)> {
    let end = operand_name_end(text, at);
    let name = text.get(at..end)?;
    let form = if name.eq_ignore_ascii_case(b"IC") {
        WordForm::Incremental
    } else if name.eq_ignore_ascii_case(b"AC") {
        WordForm::Absolute
    } else if name.eq_ignore_ascii_case(b"QU") {
        WordForm::Number
    } else {
        return None;
    };
    let blanks = text.get(end..)?.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    (text.get(end + blanks) == Some(&b'(')).then_some((form, end + blanks + 1))
}

/// The plain number at a byte, with its sign separate.
fn written_number(text: &[u8], at: usize) -> Option<crate::program::number::Unsigned> {
    let blanks = |from: usize| {
        from + text.get(from..).unwrap_or_default().iter().take_while(|b| matches!(b, b' ' | b'\t')).count()
    };
    let mut from = blanks(at);
    if matches!(text.get(from), Some(b'+' | b'-')) {
        from = blanks(from + 1);
    }
    read_unsigned(text, from)
}

fn lead(bytes: usize) -> u8 {
    u8::try_from(bytes).unwrap_or(u8::MAX)
}

/// Adds a word whose value is not a plain number.
fn push(
    line: &mut Line<'_>,
    address: Address,
    form: WordForm,
    start: usize,
    end: usize,
    lead_bytes: usize,
    value: f64,
) {
    let word = Word {
        value,
        start: line.in_batch(start),
        end: line.in_batch(end),
        address,
        lead: lead(lead_bytes),
        decimals: if matches!(form, WordForm::Expression | WordForm::Comma | WordForm::Name) {
            0
        } else {
            COMPUTED_DECIMALS
        },
        form,
        has_point: !matches!(form, WordForm::Expression | WordForm::Name),
    };
    line.at = end;
    line.push(word);
}

/// The address; in a message, another address if it is not a letter.
fn lettered(address: Address, instead: Address) -> Address {
    if address.letter().is_some() { address } else { instead }
}
