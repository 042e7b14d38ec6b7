//! The course of Sinumerik programs: structures, jumps to labels and block numbers, CASE.

use super::constants::operand_name_end;
use super::names;
use crate::program::course::{
    Callee, EndInCall, Piece, PlaceName, Search, Statement, Step, Structure, When, block_number, called_name,
};
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, Word};

/// The most times that a call runs a subprogram.
const MAX_TIMES: u32 = 9999;

/// What a block does to the course of its program.
pub(super) fn read(batch: &Batch, block: &Block) -> Statement {
    let text = batch.text().get(block.start as usize..block.body_end as usize).unwrap_or_default();
    let (label, from) = label(text);
    let end = body_end(text, from);
    let statement = match block.kind {
        BlockKind::Flow => of_text(text, from, end).unwrap_or(Statement::NOT_FOLLOWED),
        BlockKind::Call => call(text, from, end).unwrap_or(Statement::PLAIN),
        BlockKind::Assignment => head(text, from, end).unwrap_or(Statement::PLAIN),
        BlockKind::Words => of_words(batch.words(block)),
        _ => Statement::PLAIN,
    };
    let is_plain = matches!(statement.step, Step::Plain | Step::End(_) | Step::Head | Step::NotInCall);
    let is_skippable = block.flags.has(BlockFlags::DELETE) && !is_plain;
    let statement = if is_skippable { Statement::NOT_FOLLOWED } else { statement };
    Statement { place: label, ..statement }
}

/// The end of a program. In a called file it returns if the block has nothing else.
fn of_words(words: &[Word]) -> Statement {
    let ends = |word: &Word| word.address == Address::M && matches!(word.code_tenths(), Some(20 | 170 | 300));
    if !words.iter().any(ends) {
        return Statement::PLAIN;
    }
    let is_alone = words.iter().all(|word| word.address == Address::N || ends(word));
    Statement::of(Step::End(if is_alone { EndInCall::Returns } else { EndInCall::NotFollowed }))
}

/// `PROC NAME`. A subprogram with parameters, and one that gives the modes of its caller back, is not followed.
fn head(text: &[u8], from: usize, end: usize) -> Option<Statement> {
    let text = text.get(..end)?;
    let word_end = operand_name_end(text, from);
    if !text.get(from..word_end)?.eq_ignore_ascii_case(b"PROC") {
        return None;
    }
    let name = blanks_end(text, word_end);
    let mut at = blanks_end(text, operand_name_end(text, name));
    while at < end {
        let next = operand_name_end(text, at);
        let says_nothing = [&b"DISPLOF"[..], b"DISPLON", b"SBLOF", b"SBLON", b"ACTBLOCNO"];
        let word = text.get(at..next).unwrap_or_default();
        if !says_nothing.iter().any(|known| word.eq_ignore_ascii_case(known)) {
            return Some(Statement::of(Step::NotInCall));
        }
        at = blanks_end(text, next);
    }
    Some(Statement::of(Step::Head))
}

/// `L100`, `L100 P3`, `POCKET`, `POCKET P2`, `CALL "POCKET"`, `EXTCALL "POCKET.SPF"`. A call with parameters is not
/// followed.
fn call(text: &[u8], from: usize, end: usize) -> Option<Statement> {
    let text = text.get(..end)?;
    let word_end = operand_name_end(text, from);
    let word = text.get(from..word_end)?;
    let mut at = blanks_end(text, word_end);
    let by_text = word.eq_ignore_ascii_case(b"CALL") || word.eq_ignore_ascii_case(b"EXTCALL");
    let name = if by_text {
        let has_brackets = text.get(at) == Some(&b'(');
        at = if has_brackets { blanks_end(text, at + 1) } else { at };
        let rest = text.get(at..)?.strip_prefix(b"\"")?;
        let length = memchr::memchr(b'"', rest)?;
        at = blanks_end(text, at + length + 2);
        if has_brackets {
            at = (text.get(at) == Some(&b')')).then(|| blanks_end(text, at + 1))?;
        }
        rest.get(..length)?
    } else if word.len() > 1 && names::name(word).is_none() {
        word
    } else {
        return None;
    };
    let mut times = 1;
    if matches!(text.get(at), Some(b'P' | b'p')) {
        at = blanks_end(text, at + 1);
        let digits = text.get(at..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
        times = std::str::from_utf8(text.get(at..at + digits)?).ok()?.parse().ok()?;
        at = blanks_end(text, at + digits);
    }
    let is_done = at >= text.len() && (1..=MAX_TIMES).contains(&times);
    is_done.then(|| Statement::named(bare(&called_name(name)), Step::Call(Callee::File, times)))
}

/// The name of a program without the marks of the control's own folders: `_N_POCKET_SPF` is POCKET.SPF.
fn bare(name: &PlaceName) -> PlaceName {
    let Some(marked) = name.strip_prefix(b"_N_") else { return name.clone() };
    match marked.len().checked_sub(4).map(|at| marked.split_at(at)) {
        Some((stem, b"_SPF")) => [stem, b".SPF"].concat().into(),
        Some((stem, b"_MPF")) => [stem, b".MPF"].concat().into(),
        _ => marked.into(),
    }
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
        let called = |text: &str| {
            let Statement { name, step, .. } = call(text.as_bytes(), 0, text.len())?;
            let Step::Call(Callee::File, times) = step else { return None };
            Some((String::from_utf8_lossy(&name?).into_owned(), times))
        };
        for (text, name, times) in [
            ("L54", "L54", 1),
            ("l54 p3", "L54", 3),
            ("Pocket", "POCKET", 1),
            ("CALL \"POCKET\"", "POCKET", 1),
            ("EXTCALL(\"/_N_WKS_DIR/_N_A_WPD/_N_POCKET_SPF\")", "POCKET.SPF", 1),
            ("EXTCALL \"POCKET.SPF\"", "POCKET.SPF", 1),
        ] {
            assert_eq!(called(text), Some((name.to_owned(), times)), "{text}");
        }
        for text in ["POCKET(1,2)", "CALL NAME", "PCALL \"A\"", "L54 P0", "L54 X5", "CALL \"A\" B"] {
            assert_eq!(called(text), None, "{text}");
        }
        let of_head = |text: &str| head(text.as_bytes(), 0, text.len()).map(|statement| statement.step);
        assert_eq!(of_head("PROC POCKET DISPLOF"), Some(Step::Head));
        assert_eq!(of_head("PROC POCKET(REAL X)"), Some(Step::NotInCall));
        assert_eq!(of_head("PROC POCKET SAVE"), Some(Step::NotInCall));
        assert_eq!(of_head("DEF REAL X"), None);
        for text in ["REPEAT LA1 P=3", "GOTO \"LA\"<<R1", "FOR i=0", "ELSE X5", "WHILE", "CASE(1)", "GOTOS"] {
            assert_eq!(step(text), None, "{text}");
        }
    }
}
