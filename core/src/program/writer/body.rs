//! Blocks of word dialects: a block printed again with other values, and new blocks in its style.

use super::numbers::{print_inserted_numbers, print_numbers};
use super::style::{Style, print_number};
use super::{NewWord, acts_at_end, written_letter};
use crate::program::{Address, Batch, Block, Word, WordForm};

/// The name of a word with more than one letter, up to its value.
fn name(batch: &Batch, address: Address) -> Option<&'static [u8]> {
    let names = batch.dialect.rules().writing.names;
    names.iter().find(|(named, _)| *named == address).map(|(_, name)| *name)
}

/// A word that the block does not have.
fn print_new(batch: &Batch, style: &Style<'_>, word: &NewWord, first: bool, out: &mut Vec<u8>) {
    match name(batch, word.address) {
        Some(name) => style.print_named(word, name, out),
        None => style.print_word(word, written_letter(word.address).unwrap_or_default(), first, out),
    }
}

/// An expression stays if its value is this close to the wanted value \[program units\].
const SAME_VALUE: f64 = 1e-9;

/// Whether the word as written already has the wanted value. An expression is then not replaced by its value.
fn keeps(word: &Word, new: &NewWord) -> bool {
    word.form == WordForm::Evaluated && (word.value - new.value).abs() <= SAME_VALUE
}

/// Bytes of an incremental word before its letter. The new word counts in the modal sense.
fn prefix(batch: &Batch, word: &Word) -> u32 {
    let starts_with_i = batch.word_text(word).first().is_some_and(|byte| byte.eq_ignore_ascii_case(&b'I'));
    u32::from(word.form == WordForm::Incremental && starts_with_i && word.address != Address::I)
}

/// A new block with only these words and, if wanted, the source's codes that act at its end.
pub(super) fn insert_block(
    batch: &Batch,
    source: &Block,
    words: &[NewWord],
    _: &[Address],
    with_end_codes: bool,
    out: &mut Vec<u8>,
) {
    let text = batch.text.get(source.start as usize..source.body_end as usize).unwrap_or_default();
    let indent = text.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    out.extend_from_slice(text.get(..indent).unwrap_or_default());
    let has_end_codes = with_end_codes && batch.words(source).iter().any(|word| acts_at_end(batch, word));
    if has_end_codes || !print_inserted_numbers(batch, source, words, out) {
        insert_any(batch, source, words, has_end_codes, out);
    }
}

/// The same for every block, without the blanks at its start.
pub(super) fn insert_any(
    batch: &Batch,
    source: &Block,
    words: &[NewWord],
    with_end_codes: bool,
    out: &mut Vec<u8>,
) {
    let style = Style::new(batch, source);
    let mut first = true;
    for word in words {
        if word.address == Address::N {
            style.print_block_number(word, out);
            first = false;
        } else if name(batch, word.address).is_some() || written_letter(word.address).is_some() {
            print_new(batch, &style, word, first, out);
            first = false;
        }
    }
    if with_end_codes {
        for word in batch.words(source).iter().filter(|word| acts_at_end(batch, word)) {
            style.print_same(word, first, out);
            first = false;
        }
    }
}

/// The block up to its line ending.
pub(super) fn print_body(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    dropped: &[Address],
    without_end_codes: bool,
    out: &mut Vec<u8>,
) {
    let is_done = dropped.is_empty() && !without_end_codes && print_numbers(batch, block, new, out);
    if !is_done {
        print_any(batch, block, new, dropped, without_end_codes, out);
    }
}

/// The same for every block.
pub(super) fn print_any(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    dropped: &[Address],
    without_end_codes: bool,
    out: &mut Vec<u8>,
) {
    let style = Style::new(batch, block);
    let words = batch.words(block);
    let text = |from: u32, to: u32| batch.text.get(from as usize..to as usize).unwrap_or_default();
    let replaces =
        |word: &Word| new.iter().find(|new| new.address == word.address && word.form != WordForm::Comma);
    // The place of words that the block does not have: after the last coordinate, or otherwise after the last of N and
    // G.
    let anchor =
        words.iter().rposition(|word| word.address.is_coordinate() && word.form != WordForm::Comma).or_else(
            || words.iter().rposition(|word| matches!(word.address, Address::N | Address::G | Address::O)),
        );
    let feed_anchor =
        batch.dialect.rules().writing.feed_anchor.map_or(anchor, |feed_anchor| feed_anchor(words));
    let has = |address| words.iter().any(|word| word.address == address && word.form != WordForm::Comma);
    let missing = || new.iter().filter(|new| !has(new.address));
    let mut copied = block.start;
    if anchor.is_none() && feed_anchor.is_none() && missing().next().is_some() {
        let first = words.first().map_or(block.start, |word| word.start);
        out.extend_from_slice(text(copied, first));
        copied = first;
        let mut at_start = true;
        for word in missing() {
            print_new(batch, &style, word, at_start, out);
            at_start = false;
        }
        if copied < block.body_end {
            out.push(b' ');
        }
    }
    let is_dropped = |word: &Word| {
        dropped.contains(&word.address) && word.form != WordForm::Comma && replaces(word).is_none()
    };
    for (index, word) in words.iter().enumerate() {
        if is_dropped(word) || (without_end_codes && acts_at_end(batch, word)) {
            let before = text(copied, word.start);
            if index == 0 && before.trim_ascii().is_empty() {
                // The next word takes its place.
                out.extend_from_slice(before);
                let behind = text(word.end, block.body_end);
                let blanks = behind.len() - behind.trim_ascii_start().len();
                copied = word.end + u32::try_from(blanks).unwrap_or(0);
            } else {
                out.extend_from_slice(before.trim_ascii_end());
                copied = word.end;
            }
        } else if let Some(new) = replaces(word).filter(|new| !keeps(word, new)) {
            // The letter stays as written.
            out.extend_from_slice(text(copied, word.start));
            out.extend_from_slice(text(word.start + prefix(batch, word), word.start + u32::from(word.lead)));
            print_number(batch, word, new, out);
            copied = word.end;
        }
        for (place, is_feed) in [(anchor, false), (feed_anchor, true)] {
            if place != Some(index) {
                continue;
            }
            // A word that was left out at the start has removed the blanks after it as well.
            out.extend_from_slice(text(copied, word.end));
            copied = copied.max(word.end);
            for word in missing().filter(|word| (word.address == Address::F) == is_feed) {
                print_new(batch, &style, word, false, out);
            }
        }
    }
    out.extend_from_slice(text(copied, block.body_end));
}
