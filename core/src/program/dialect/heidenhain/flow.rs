//! The course of conversational programs: labels, their calls and repetitions, jumps by FN 9 to FN 12.

use crate::program::course::{
    Callee, Comparison, EndInCall, Piece, PlaceName, Search, Statement, Step, When, called_name,
};
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, Keyword, Word, WordForm};

/// The most repetitions of a section.
const MAX_TIMES: u32 = 65_534;

/// What a block does to the course of its program.
pub(super) fn read(batch: &Batch, block: &Block) -> Statement {
    let text = batch.text().get(block.start as usize..block.body_end as usize).unwrap_or_default();
    let statement = match block.kind {
        BlockKind::Words => of_words(batch, block, text),
        BlockKind::Flow => of_function(text).unwrap_or(Statement::NOT_FOLLOWED),
        BlockKind::Call => called_program(text).map_or(Statement::PLAIN, |name| {
            Statement::named(called_name(name), Step::Call(Callee::File, 1))
        }),
        _ => Statement::PLAIN,
    };
    let is_plain = matches!(statement.step, Step::Plain | Step::End(_) | Step::Head);
    if block.flags.has(BlockFlags::DELETE) && !is_plain { Statement::NOT_FOLLOWED } else { statement }
}

fn of_words(batch: &Batch, block: &Block, text: &[u8]) -> Statement {
    let words = batch.words(block);
    if words.iter().any(|word| word.address == Address::M && matches!(word.code_tenths(), Some(20 | 300))) {
        // A called program must not have it.
        return Statement::of(Step::End(EndInCall::NotFollowed));
    }
    let Some(keyword) = words.iter().find_map(Word::keyword) else { return Statement::PLAIN };
    let place = || {
        let mut names = words.iter().filter(|word| word.address == Address::P);
        names.next().filter(|word| word.form == WordForm::Number).map(|word| label(word.value))
    };
    match (keyword, place()) {
        (Keyword::EndPgm, _) => Statement::of(Step::End(EndInCall::Returns)),
        // A program counts in the unit of its own head.
        (Keyword::BeginMm, _) => Statement::named(PlaceName::from(*b"MM"), Step::Head),
        (Keyword::BeginInch, _) => Statement::named(PlaceName::from(*b"INCH"), Step::Head),
        (Keyword::Label, Some(name)) => Statement::at(name, Step::Label),
        (Keyword::LabelEnd, _) => Statement::of(Step::ReturnIfCalled),
        (Keyword::CallLabel, Some(name)) => Statement::named(name, Step::Call(Callee::Place, 1)),
        (Keyword::RepeatLabel, Some(name)) => match repetitions(text) {
            Some(times) => Statement::named(name, Step::GoBack(times)),
            None => Statement::NOT_FOLLOWED,
        },
        (Keyword::Label | Keyword::CallLabel | Keyword::RepeatLabel, None) => Statement::NOT_FOLLOWED,
        _ => Statement::PLAIN,
    }
}

fn label(number: f64) -> PlaceName {
    format!("LBL{number}").into_bytes().into()
}

/// `… REP 5`, `… REP 5/5`
fn repetitions(text: &[u8]) -> Option<u32> {
    let at = memchr::memmem::find(text, b"REP")? + 3;
    let rest = text.get(at..)?.trim_ascii();
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let times: u32 = std::str::from_utf8(rest.get(..digits)?).ok()?.parse().ok()?;
    let behind = rest.get(digits..)?.trim_ascii_start();
    let is_plain = matches!(behind.first(), None | Some(b';'));
    (is_plain && times <= MAX_TIMES).then_some(times)
}

/// `CALL PGM TNC:\\PARTS\\POCKET.H`: the name as it is written.
fn called_program(text: &[u8]) -> Option<&[u8]> {
    let end = memchr::memchr(b';', text).unwrap_or(text.len());
    let words = words_of(text.get(..end)?, 0);
    let of = |word: &Piece| word.of(text);
    let call = words.iter().position(|word| of(word).eq_ignore_ascii_case(b"CALL"))?;
    let is_first = words.iter().take(call).all(|word| of(word).iter().all(u8::is_ascii_digit));
    let [program, name] = words.get(call + 1..)? else { return None };
    let name = of(name);
    let name = name.strip_prefix(b"\"").and_then(|name| name.strip_suffix(b"\"")).unwrap_or(name);
    (is_first && call <= 1 && of(program).eq_ignore_ascii_case(b"PGM")).then_some(name)
}

/// `FN 9: IF +Q1 EQU +Q2 GOTO LBL 3`
fn of_function(text: &[u8]) -> Option<Statement> {
    let end = memchr::memchr(b';', text).unwrap_or(text.len());
    let text = text.get(..end)?;
    let colon = memchr::memchr(b':', text)?;
    let words = words_of(text, colon + 1);
    let spelled = |word: &Piece| word.of(text).to_ascii_uppercase();
    let [condition, left, comparison, right, go, place, name] = words.as_slice() else { return None };
    let shape = [condition, go, place].map(spelled);
    if shape[0] != b"IF" || shape[1] != b"GOTO" || shape[2] != b"LBL" {
        return None;
    }
    let comparison = match spelled(comparison).as_slice() {
        b"EQU" => Comparison::Equal,
        b"NE" => Comparison::Unequal,
        b"GT" => Comparison::Greater,
        b"LT" => Comparison::Less,
        _ => return None,
    };
    let number: u32 = std::str::from_utf8(name.of(text)).ok()?.parse().ok()?;
    let when = When::Compares(*left, comparison, *right);
    let step = Step::Jump { search: Search::Around, when, may_lack: false };
    Some(Statement::named(label(number.into()), step))
}

/// The words between blanks.
fn words_of(text: &[u8], from: usize) -> Vec<Piece> {
    let mut words = Vec::new();
    let mut at = from;
    while at < text.len() {
        let is_blank = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\r');
        let start = at + text.get(at..).unwrap_or_default().iter().take_while(|byte| is_blank(byte)).count();
        let end =
            start + text.get(start..).unwrap_or_default().iter().take_while(|byte| !is_blank(byte)).count();
        if end > start {
            words.push(Piece { start, end });
        }
        at = end.max(start).max(at + 1);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_read_and_others_are_not_followed() {
        let statement = of_function(b"12 FN 9: IF +Q1 EQU +Q2 GOTO LBL 3 ; note").unwrap();
        assert_eq!(statement.name.as_deref(), Some(&b"LBL3"[..]));
        assert!(matches!(statement.step, Step::Jump { when: When::Compares(..), .. }));
        for text in ["FN 9: IF Q1 IS UNDEFINED GOTO LBL 3", "FN 9: IF +Q1 EQU +Q2 GOTO LBL \"A\"", "FN 9"] {
            assert_eq!(of_function(text.as_bytes()), None, "{text}");
        }
        assert_eq!(called_program(b"7 CALL PGM TNC:\\A\\B.H ; note"), Some(&b"TNC:\\A\\B.H"[..]));
        assert_eq!(called_program(b"CALL PGM \"B\""), Some(&b"B"[..]));
        for text in ["CALL SELECTED PGM", "CALL PGM", "L X5 CALL PGM B", "CALL PGM A B"] {
            assert_eq!(called_program(text.as_bytes()), None, "{text}");
        }
        assert_eq!(repetitions(b"CALL LBL 5 REP 2/2"), None);
        assert_eq!(repetitions(b"CALL LBL 5 REP 2"), Some(2));
    }
}
