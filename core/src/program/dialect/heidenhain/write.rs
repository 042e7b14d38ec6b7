//! New Heidenhain blocks: `L` and the words. Also the position of new words in an old block.

use super::RULES;
use crate::program::writer::{Style, acts_at_end};
use crate::program::{Address, Batch, Block, Keyword, NewWord, Word};

/// The word after which a feed goes. Coordinates, the sense of an arc and radius compensation come before the feed.
pub(super) fn feed_anchor(words: &[Word]) -> Option<usize> {
    words.iter().rposition(|word| {
        word.address.is_coordinate()
            || word
                .keyword()
                .is_some_and(|keyword| !matches!(keyword, Keyword::Fmax | Keyword::FeedElsewhere))
    })
}

/// The name of a vector's word.
fn name(address: Address) -> Option<&'static [u8]> {
    RULES.writing.names.iter().find(|(named, _)| *named == address).map(|(_, name)| *name)
}

/// A new block: a number if one is given, `L` (or `LN`), these words, and if wanted the source's codes that act at its
/// end.
pub(super) fn insert_block(
    batch: &Batch,
    source: &Block,
    new: &[NewWord],
    _: &[Address],
    with_end_codes: bool,
    out: &mut Vec<u8>,
) {
    let style = Style::new(batch, source);
    let text = batch.text.get(source.start as usize..source.body_end as usize).unwrap_or_default();
    let blanks = |text: &[u8]| text.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    let indent = blanks(text);
    out.extend_from_slice(text.get(..indent).unwrap_or_default());
    let behind = text.get(indent..).unwrap_or_default();
    let digits = behind.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let behind = behind.get(digits..).unwrap_or_default();
    let gap = blanks(behind);
    if let Some(number) = new.iter().find(|word| word.address == Address::N) {
        style.print_block_number(number, out);
        out.extend_from_slice(behind.get(..gap).unwrap_or_default());
    }
    let has_vector = new.iter().any(|word| name(word.address).is_some());
    let lower = behind.get(gap).is_some_and(u8::is_ascii_lowercase);
    out.extend_from_slice(match (has_vector, lower) {
        (false, false) => b"L",
        (false, true) => b"l",
        (true, false) => b"LN",
        (true, true) => b"ln",
    });
    let after_name = out.len();
    for word in new.iter().filter(|word| word.address != Address::N) {
        match (name(word.address), word.address.letter()) {
            (Some(name), _) => style.print_named(word, name, out),
            (None, Some(letter)) => style.print_named(word, &[letter], out),
            (None, None) => {}
        }
    }
    if with_end_codes {
        for word in batch.words(source).iter().filter(|word| acts_at_end(batch, word)) {
            style.print_same(word, false, out);
        }
    }
    // The reader would take `LX+1` as the name of another statement.
    if out.get(after_name).is_some_and(u8::is_ascii_alphabetic) {
        out.insert(after_name, b' ');
    }
}
