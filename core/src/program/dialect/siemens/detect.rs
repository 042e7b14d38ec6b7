//! The marks of a Sinumerik program.

use crate::program::dialect::detect::starts;

/// Words that open a Sinumerik statement and no ISO block.
const STATEMENTS: [&[u8]; 31] = [
    b"RET",
    b"REPEAT",
    b"REPEATB",
    b"UNTIL",
    b"ENDFOR",
    b"ENDWHILE",
    b"ENDLOOP",
    b"TRAORI",
    b"TRAFOOF",
    b"SUPA",
    b"MCALL",
    b"DEF",
    b"PROC",
    b"CYCLE",
    b"WORKPIECE",
    b"GOTOF",
    b"GOTOB",
    b"EXTERN",
    b"ATRANS",
    b"AROT",
    b"TRANS",
    b"STOPRE",
    b"ORIWKS",
    b"ORIMKS",
    b"ORIAXES",
    b"ORIVECT",
    b"FFWON",
    b"COMPCAD",
    b"COMPON",
    b"SOFT",
    b"BRISK",
];

/// Whether a line, without blanks at its ends, belongs to a Sinumerik program and to no other dialect.
pub(super) fn is_shown_by(line: &[u8]) -> bool {
    if starts(line, b"%_N_") || starts(line, b";$PATH=") {
        return true;
    }
    let statement = match line.split_first() {
        Some((b'N' | b'n', rest)) => {
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            rest.get(digits..).unwrap_or_default().trim_ascii_start()
        }
        _ => line,
    };
    starts(statement, b"MSG(\"")
        || starts(statement, b"T=\"")
        || assigns_a_name(statement)
        || STATEMENTS.iter().any(|word| {
            starts(statement, word)
                && statement
                    .get(word.len())
                    .is_none_or(|byte| matches!(byte, b' ' | b'\t' | b'(' | b'8' | b';'))
        })
}

/// `_X_HOME=-365.`, `_LIST[2]=1`: a name that begins with an underscore. No other dialect has such a name without
/// brackets.
fn assigns_a_name(statement: &[u8]) -> bool {
    let Some(rest) = statement.strip_prefix(b"_") else { return false };
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
    let next = rest.get(length..).unwrap_or_default().trim_ascii_start();
    length > 0 && matches!(next, [b'=' | b'[', ..])
}

/// Addresses that have `=` after them only in Sinumerik programs.
const ASSIGNED: [&[u8]; 18] = [
    b"X", b"Y", b"Z", b"A", b"B", b"C", b"I", b"J", b"K", b"F", b"A3", b"B3", b"C3", b"CR", b"AR", b"AP",
    b"RP", b"TURN",
];

/// Whether an axis word, a feed, a radius or an R parameter has `=` after it: `X=IC(5)`, `CR=12.5`, `R1=2`.
pub(in crate::program::dialect) fn assigns_a_word(statement: &[u8]) -> bool {
    let statement = statement.trim_ascii_start();
    let end = statement.iter().position(|byte| b"([{;\"#".contains(byte)).unwrap_or(statement.len());
    let statement = statement.get(..end).unwrap_or_default();
    memchr::memchr_iter(b'=', statement).any(|equals| {
        let before = statement.get(..equals).unwrap_or_default().trim_ascii_end();
        let length =
            before.iter().rev().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
        let name = before.get(before.len() - length..).unwrap_or_default();
        let is_parameter = matches!(name, [b'R' | b'r', digits @ ..] if !digits.is_empty()
            && digits.iter().all(u8::is_ascii_digit));
        is_parameter || ASSIGNED.iter().any(|known| name.eq_ignore_ascii_case(known))
    })
}
