//! The course of Sinumerik programs: structures, jumps to labels and block numbers, CASE.

use super::constants::operand_name_end;
use crate::program::course::{Piece, PlaceName, Search, Statement, Step, Structure, When, block_number};
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind};

/// What a block does to the course of its program.
pub(super) fn read(batch: &Batch, block: &Block) -> Statement {
    let text = batch.text().get(block.start as usize..block.body_end as usize).unwrap_or_default();
    let (label, from) = label(text);
    let end = body_end(text, from);
    let statement = match block.kind {
        BlockKind::Flow => of_text(text, from, end).unwrap_or(Statement::NOT_FOLLOWED),
        BlockKind::Words => {
            let ends = batch
                .words(block)
                .iter()
                .any(|word| word.address == Address::M && matches!(word.code_tenths(), Some(20 | 170 | 300)));
            Statement::of(if ends { Step::End } else { Step::Plain })
        }
        _ => Statement::PLAIN,
    };
    let is_plain = matches!(statement.step, Step::Plain | Step::End);
    let is_skippable = block.flags.has(BlockFlags::DELETE) && !is_plain;
    let statement = if is_skippable { Statement::NOT_FOLLOWED } else { statement };
    Statement { place: label, ..statement }
}

/// The label of a statement, and where its text begins after the block number and the label.
fn label(text: &[u8]) -> (Option<PlaceName>, usize) {
    let mut at = blanks_end(text, 0);
    if matches!(text.get(at), Some(b'N' | b'n' | b':')) {
        let digits = text.get(at + 1..).unwrap_or_default().iter().take_while(|byte| byte.is_ascii_digit());
        let count = digits.count();
        if count > 0 {
            at = blanks_end(text, at + 1 + count);
        }
    }
    let end = operand_name_end(text, at);
    let is_label = end > at + 1 && text.get(end) == Some(&b':');
    match text.get(at..end).filter(|_| is_label) {
        Some(name) => (Some(upper(name)), blanks_end(text, end + 1)),
        None => (None, at),
    }
}

fn upper(name: &[u8]) -> PlaceName {
    name.to_ascii_uppercase().into()
}

fn blanks_end(text: &[u8], mut at: usize) -> usize {
    while matches!(text.get(at), Some(b' ' | b'\t')) {
        at += 1;
    }
    at
}

/// Where the statement ends before its comment.
fn body_end(text: &[u8], from: usize) -> usize {
    let mut quoted = false;
    let comment = text.iter().enumerate().skip(from).find(|(_, byte)| {
        quoted ^= **byte == b'"';
        **byte == b';' && !quoted
    });
    let mut end = comment.map_or(text.len(), |(at, _)| at);
    while end > from && matches!(text.get(end - 1), Some(b' ' | b'\t' | b'\r')) {
        end -= 1;
    }
    end
}

fn of_text(text: &[u8], from: usize, end: usize) -> Option<Statement> {
    let text = text.get(..end)?;
    let word_end = operand_name_end(text, from);
    let word = text.get(from..word_end)?.to_ascii_uppercase();
    let rest = Piece { start: blanks_end(text, word_end), end };
    let is_alone = rest.start >= end;
    let alone = |step: Step| is_alone.then(|| Statement::of(step));
    let with = |step: fn(Option<Piece>) -> Step| (!is_alone).then(|| Statement::of(step(Some(rest))));
    match word.as_slice() {
        b"IF" => match find_word(text, rest.start, b"GOTO") {
            Some(at) => {
                let condition = Piece { start: rest.start, end: at };
                jump(text, at, When::Holds(condition))
            }
            None => with(|piece| Step::Open(Structure::If, piece)),
        },
        b"ELSE" => alone(Step::Else(None)),
        b"ENDIF" => alone(Step::Close(Some(Structure::If), None)),
        b"WHILE" => with(|piece| Step::Open(Structure::While, piece)),
        b"ENDWHILE" => alone(Step::Close(Some(Structure::While), None)),
        b"LOOP" => alone(Step::Open(Structure::Loop, None)),
        b"ENDLOOP" => alone(Step::Close(Some(Structure::Loop), None)),
        b"REPEAT" => alone(Step::Open(Structure::Until, None)),
        b"UNTIL" => with(|piece| Step::Close(Some(Structure::Until), piece)),
        b"FOR" => count(text, rest),
        b"ENDFOR" => alone(Step::Close(Some(Structure::For), None)),
        b"GOTO" | b"GOTOB" | b"GOTOF" | b"GOTOC" => jump(text, from, When::Always),
        b"CASE" => select(text, rest),
        _ => None,
    }
}

/// Where a name that begins with these letters is, outside brackets and quotation marks.
fn find_word(text: &[u8], from: usize, word: &[u8]) -> Option<usize> {
    let (mut depth, mut quoted) = (0_i32, false);
    let mut at = from;
    while let Some(&byte) = text.get(at) {
        match byte {
            b'"' => quoted = !quoted,
            b'(' | b'[' if !quoted => depth += 1,
            b')' | b']' if !quoted => depth -= 1,
            byte if !quoted && (byte.is_ascii_alphabetic() || byte == b'_') => {
                let end = operand_name_end(text, at).max(at + 1);
                let begins =
                    text.get(at..at + word.len()).is_some_and(|name| name.eq_ignore_ascii_case(word));
                if begins && depth == 0 {
                    return Some(at);
                }
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    None
}

/// `FOR COUNTER=0 TO 7`
fn count(text: &[u8], rest: Piece) -> Option<Statement> {
    let name_end = operand_name_end(text, rest.start);
    let equals = blanks_end(text, name_end);
    if name_end == rest.start || text.get(equals) != Some(&b'=') {
        return None;
    }
    let to = find_word(text, equals + 1, b"TO").filter(|to| operand_name_end(text, *to) == to + 2)?;
    let variable = Piece { start: rest.start, end: name_end };
    let first = Piece { start: equals + 1, end: to };
    let last = Piece { start: to + 2, end: rest.end };
    Some(Statement::of(Step::Count { variable, first, last }))
}

/// The search of a jump and its target, with where the target ends.
fn target(text: &[u8], from: usize) -> Option<(Search, bool, PlaceName, usize)> {
    let word_end = operand_name_end(text, from);
    let (search, may_lack) = match text.get(from..word_end)?.to_ascii_uppercase().as_slice() {
        b"GOTO" => (Search::Around, false),
        b"GOTOC" => (Search::Around, true),
        b"GOTOF" => (Search::Forward, false),
        b"GOTOB" => (Search::Backward, false),
        _ => return None,
    };
    let start = blanks_end(text, word_end);
    let digits_end = |at: usize| {
        at + text.get(at..).unwrap_or_default().iter().take_while(|byte| byte.is_ascii_digit()).count()
    };
    let name_end = operand_name_end(text, start).max(digits_end(start));
    let name = text.get(start..name_end).filter(|name| !name.is_empty())?;
    let number = match name {
        [b'N' | b'n', digits @ ..] if !digits.is_empty() => digits,
        other => other,
    };
    let is_number = number.iter().all(u8::is_ascii_digit);
    let place = if is_number {
        block_number(std::str::from_utf8(number).ok()?.parse::<u32>().ok()?.into())
    } else {
        upper(name)
    };
    Some((search, may_lack, place, name_end))
}

fn jump(text: &[u8], from: usize, when: When) -> Option<Statement> {
    let (search, may_lack, name, end) = target(text, from)?;
    let is_done = blanks_end(text, end) >= text.len();
    is_done.then(|| Statement::named(name, Step::Jump { search, when, may_lack }))
}

/// `CASE(expression) OF 7 GOTOF SEVEN 9 GOTOF NINE DEFAULT GOTOF OTHER`
fn select(text: &[u8], rest: Piece) -> Option<Statement> {
    let of = find_word(text, rest.start, b"OF").filter(|of| operand_name_end(text, *of) == of + 2)?;
    let value = Piece { start: rest.start, end: of };
    let mut places = Vec::new();
    let mut at = blanks_end(text, of + 2);
    while at < text.len() {
        let go = find_word(text, at, b"GOTO")?;
        let default = find_word(text, at, b"DEFAULT").filter(|default| *default < go);
        let constant = if default.is_some() { None } else { Some(Piece { start: at, end: go }) };
        let (search, may_lack, place, end) = target(text, go)?;
        if may_lack {
            return None;
        }
        places.push((constant, search, place));
        at = blanks_end(text, end);
    }
    Some(Statement::of(Step::Select { value, places }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(text: &str) -> Option<Step> {
        let (_, from) = label(text.as_bytes());
        of_text(text.as_bytes(), from, body_end(text.as_bytes(), from)).map(|statement| statement.step)
    }

    #[test]
    fn structures_and_jumps_are_read_and_others_are_not_followed() {
        assert_eq!(label(b"N40 REPEAT_HERE: X=R1").0.as_deref(), Some(&b"REPEAT_HERE"[..]));
        assert_eq!(step("N5 ENDIF ; note"), Some(Step::Close(Some(Structure::If), None)));
        assert!(matches!(step("IF (a <= b)"), Some(Step::Open(Structure::If, Some(_)))));
        assert!(matches!(step("N1 IF R4>0 GOTOB LA1"), Some(Step::Jump { search: Search::Backward, .. })));
        assert!(matches!(step("FOR i=0 TO n"), Some(Step::Count { .. })));
        assert!(matches!(step("GOTOC NOWHERE"), Some(Step::Jump { may_lack: true, .. })));
        let Some(Step::Select { places, .. }) = step("CASE(4+3) OF 7 GOTOF SEVEN DEFAULT GOTOF OTHER") else {
            panic!("a CASE");
        };
        assert_eq!(places.len(), 2);
        for text in ["REPEAT LA1 P=3", "GOTO \"LA\"<<R1", "FOR i=0", "ELSE X5", "WHILE", "CASE(1)", "GOTOS"] {
            assert_eq!(step(text), None, "{text}");
        }
    }
}
