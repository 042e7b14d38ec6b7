//! The parts of ISO programs that are not plain words: expressions, parameters, O words, macro statements.

use crate::program::dialect::line::Line;
use crate::program::number::read_unsigned;
use crate::program::{Address, BlockFlags, BlockKind, MAX_MAGNITUDE, WordForm};

/// Statements of O words that change the flow.
const FLOW_WORDS: [&[u8]; 14] = [
    b"SUB",
    b"ENDSUB",
    b"RETURN",
    b"DO",
    b"WHILE",
    b"ENDWHILE",
    b"IF",
    b"ELSEIF",
    b"ELSE",
    b"ENDIF",
    b"REPEAT",
    b"ENDREPEAT",
    b"BREAK",
    b"CONTINUE",
];
/// Macro statements that change the flow. If a number follows the name, the list has the name without the number.
const MACRO_FLOW: [&[u8]; 8] = [b"IF", b"WHILE", b"GOTO", b"DO", b"END", b"ELSE", b"ENDIF", b"ENDW"];
/// Macro statements that only write to outside devices.
const MACRO_OUTPUT: [&[u8]; 5] = [b"DPRNT", b"BPRNT", b"POPEN", b"PCLOS", b"SETVN"];
/// Operators made of letters.
const OPERATORS: [&[u8]; 10] = [b"MOD", b"AND", b"OR", b"XOR", b"EQ", b"NE", b"GT", b"GE", b"LT", b"LE"];
/// Parameters from here on belong to the control. Of these, 3000–3999 are alarms, clocks and messages.
const FIRST_SYSTEM_PARAMETER: f64 = 1000.0;
const HARMLESS_PARAMETERS: std::ops::Range<f64> = 3000.0..4000.0;

/// A letter at the present position without a plain number after it.
pub(super) fn odd_word(line: &mut Line<'_>, letter: u8) {
    let start = line.at;
    let run_end = line.letters_end(start);
    let run = &line.text[start..run_end];
    if run.len() > 1 {
        if is_one_of(run, &MACRO_FLOW) {
            return flow(line, run_end);
        }
        let kind = if is_one_of(run, &MACRO_OUTPUT) {
            Some(BlockKind::Assignment)
        } else if run.eq_ignore_ascii_case(b"CALL") {
            Some(BlockKind::Call)
        } else {
            None
        };
        if let Some(kind) = kind.filter(|_| line.is_untouched() || has_only_number(line)) {
            line.kind = Some(kind);
            line.skip_all();
            return;
        }
    }
    match skip_value(line, start + 1) {
        Some(end) => {
            line.odd_word(Address::of_letter(letter), WordForm::Expression, start, end, 0.0);
        }
        None if matches!(line.byte(line.blanks_end(start + 1)), b'[' | b'#') => {
            line.fail_unclosed(start);
        }
        None => line.fail_number(start),
    }
}

/// A byte that begins neither a plain word nor a comment.
pub(super) fn special(line: &mut Line<'_>, byte: u8) {
    match byte {
        b'#' => assignment(line),
        b'o' | b'O' | b':' => o_word(line),
        b'<' if line.is_untouched() => named_program(line, line.at),
        b',' => comma_word(line),
        b'{' => {
            line.kind = Some(BlockKind::Template);
            line.skip_all();
        }
        _ => line.fail_unexpected(line.at),
    }
}

/// `IF`, `WHILE`, `GOTO`, …; `IF […] THEN #… = …` only assigns.
fn flow(line: &mut Line<'_>, run_end: usize) {
    let end = line.end();
    if line.text[line.at..run_end].eq_ignore_ascii_case(b"IF")
        && let Some(condition_end) = skip_value(line, run_end)
    {
        let then = line.blanks_end(condition_end);
        let then_end = line.letters_end(then);
        let parameter = line.blanks_end(then_end);
        if line.text[then..then_end].eq_ignore_ascii_case(b"THEN") && line.byte(parameter) == b'#' {
            line.at = parameter;
            return assignment(line);
        }
    }
    line.kind = Some(BlockKind::Flow);
    line.at = end;
}

/// `#501 = 1`, `#<name> = [#1 + 2]`, several on a line.
fn assignment(line: &mut Line<'_>) {
    let start = line.at;
    let Some(name_end) = skip_parameter(line, start) else { return line.fail_unclosed(start) };
    let equals = line.blanks_end(name_end);
    if line.byte(equals) != b'=' {
        return line.fail_unexpected(start);
    }
    let Some(mut end) = skip_value(line, equals + 1) else { return line.fail_number(equals) };
    loop {
        let operator = line.blanks_end(end);
        let word_end = line.letters_end(operator);
        let operand = if matches!(line.byte(operator), b'+' | b'-' | b'*' | b'/') {
            // RS274 has ** for powers.
            operator + 1 + usize::from(line.byte(operator) == b'*' && line.byte(operator + 1) == b'*')
        } else if is_one_of(&line.text[operator.min(word_end)..word_end], &OPERATORS) {
            word_end
        } else {
            break;
        };
        let Some(next) = skip_value(line, operand) else { return line.fail_unexpected(operator) };
        end = next;
    }
    line.flags.set(BlockFlags::ASSIGNS);
    if is_system_parameter(line, start, name_end) {
        line.flags.set(BlockFlags::ASSIGNS_SYSTEM);
    }
    line.at = end;
}

/// Whether the parameter that these bytes name may be a parameter of the control.
fn is_system_parameter(line: &Line<'_>, start: usize, end: usize) -> bool {
    match line.byte(start + 1) {
        // #<name> and #<_name> are the program's own.
        b'<' => false,
        b'0'..=b'9' => read_unsigned(&line.text[..end], start + 1).is_none_or(|number| {
            number.value >= FIRST_SYSTEM_PARAMETER && !HARMLESS_PARAMETERS.contains(&number.value)
        }),
        _ => true,
    }
}

/// `O1001`, `:0097`, `o<name> call […]`, `o100 while […]`; `OPROG1`, `O<PROG1>` at the head of a program.
fn o_word(line: &mut Line<'_>) {
    let start = line.at;
    let name = line.blanks_end(start + 1);
    let (mut number, mut is_name) = (None, false);
    let name_end = match line.byte(name) {
        b'<' => {
            is_name = true;
            find_on_line(line, name, b'>').map(|at| at + 1)
        }
        b'#' | b'[' => skip_value(line, name),
        byte if byte.is_ascii_alphabetic() || byte == b'_' => {
            is_name = line.byte(start) != b':';
            Some(plain_name_end(line, name)).filter(|_| is_name)
        }
        _ => {
            number = read_unsigned(line.text, name);
            number.map(|number| number.end)
        }
    };
    let Some(name_end) = name_end else { return line.fail_number(start) };
    let keyword = line.blanks_end(name_end);
    let keyword_end = line.letters_end(keyword);
    let statement = &line.text[keyword..keyword_end];
    let kind = if statement.eq_ignore_ascii_case(b"CALL") {
        BlockKind::Call
    } else if is_one_of(statement, &FLOW_WORDS) {
        BlockKind::Flow
    } else if let Some(number) = number.filter(|number| number.value <= MAX_MAGNITUDE) {
        return line.odd_word(Address::O, WordForm::Number, start, name_end, number.value);
    } else if is_name && line.opens() && !names_flow(line, start, name, name_end) {
        let lead = name - start;
        return line.name(Address::O, start, lead, name_end);
    } else {
        return line.fail_unexpected(start);
    };
    line.kind = Some(kind);
    line.skip_all();
}

/// `<NAME>` alone: the name of a program, as after an O word.
fn named_program(line: &mut Line<'_>, start: usize) {
    match find_on_line(line, start, b'>') {
        Some(end) => line.name(Address::O, start, 0, end + 1),
        None => line.fail_unclosed(start),
    }
}

/// One after a name that begins with a letter.
fn plain_name_end(line: &Line<'_>, mut at: usize) -> usize {
    while line.byte(at).is_ascii_alphanumeric() || matches!(line.byte(at), b'_' | b'-' | b'.') {
        at += 1;
    }
    at
}

/// `O SUB` with a blank: flow of RS274 without its number. `OSUB` is a name.
fn names_flow(line: &Line<'_>, start: usize, name: usize, name_end: usize) -> bool {
    let text = line.text.get(name..name_end).unwrap_or_default();
    name > start + 1 && (is_one_of(text, &FLOW_WORDS) || text.eq_ignore_ascii_case(b"CALL"))
}

/// `,R2` and similar words.
fn comma_word(line: &mut Line<'_>) {
    let start = line.at;
    let letter = line.blanks_end(start + 1);
    let Some(address) = Address::from_letter(line.byte(letter)) else {
        return line.fail_unexpected(start);
    };
    let mut at = line.blanks_end(letter + 1);
    let negative = line.byte(at) == b'-';
    if negative || line.byte(at) == b'+' {
        at = line.blanks_end(at + 1);
    }
    match read_unsigned(line.text, at) {
        Some(number) if number.value <= MAX_MAGNITUDE => {
            let value = if negative { 0.0 - number.value } else { number.value };
            line.odd_word(address, WordForm::Comma, start, number.end, value);
        }
        _ => match skip_value(line, letter + 1) {
            Some(end) => line.odd_word(address, WordForm::Comma, start, end, 0.0),
            None => line.fail_number(start),
        },
    }
}

/// Whether the line has only its block number so far.
fn has_only_number(line: &Line<'_>) -> bool {
    let text = line.text[line.start..line.at].trim_ascii();
    matches!(text.first(), Some(b'N' | b'n' | b'/'))
}

fn is_one_of(text: &[u8], words: &[&[u8]]) -> bool {
    words.iter().any(|word| text.eq_ignore_ascii_case(word))
}

fn find_on_line(line: &Line<'_>, from: usize, byte: u8) -> Option<usize> {
    let rest = line.text.get(from..)?;
    let at = memchr::memchr3(byte, b'\n', b'\r', rest)?;
    (rest.get(at) == Some(&byte)).then_some(from + at)
}

/// One after a value: signs, then a number, `[…]`, a parameter, or a function with its argument (ATAN with two). A
/// number has at most one sign: `X--5` is a typing error.
fn skip_value(line: &Line<'_>, from: usize) -> Option<usize> {
    let mut at = line.blanks_end(from);
    let mut signs = 0_usize;
    while matches!(line.byte(at), b'+' | b'-') {
        at = line.blanks_end(at + 1);
        signs += 1;
    }
    match line.byte(at) {
        b'[' => skip_brackets(line, at),
        b'#' => skip_parameter(line, at),
        byte if byte.is_ascii_alphabetic() => {
            let bracket = line.blanks_end(line.letters_end(at));
            if line.letters_end(at) - at < 2 || line.byte(bracket) != b'[' {
                return None;
            }
            let end = skip_brackets(line, bracket)?;
            let second = if line.byte(end) == b'/' { end + 1 } else { return Some(end) };
            if line.byte(second) == b'[' { skip_brackets(line, second) } else { Some(end) }
        }
        _ if signs > 1 => None,
        _ => read_unsigned(line.text, at).map(|number| number.end),
    }
}

/// One after the bracket that closes the one at `at`.
fn skip_brackets(line: &Line<'_>, at: usize) -> Option<usize> {
    let mut depth = 0_u32;
    let mut from = at;
    loop {
        match line.byte(from) {
            b'[' => depth += 1,
            b']' => depth -= 1,
            b'\n' | b'\r' => return None,
            _ => {}
        }
        from += 1;
        if depth == 0 {
            return Some(from);
        }
    }
}

/// One after a parameter: `#12`, `##3`, `#<name>`, `#[…]`, `#_NAME[…]`, `#ABS[…]`.
fn skip_parameter(line: &Line<'_>, at: usize) -> Option<usize> {
    let mut at = at;
    while line.byte(at) == b'#' {
        at = line.blanks_end(at + 1);
    }
    match line.byte(at) {
        b'<' => find_on_line(line, at, b'>').map(|end| end + 1),
        b'[' => skip_brackets(line, at),
        b'_' => {
            let mut end = at;
            while matches!(line.byte(end), b'_' | b'0'..=b'9') || line.byte(end).is_ascii_alphabetic() {
                end += 1;
            }
            if line.byte(end) == b'[' { skip_brackets(line, end) } else { Some(end) }
        }
        // RS274: `#atan[1]/[1]` is #45.
        byte if byte.is_ascii_alphabetic() => skip_value(line, at),
        _ => read_unsigned(line.text, at).map(|number| number.end),
    }
}
