//! APT rows: a feed is a separate statement before the point.

use super::point::POINT;
use crate::program::batch::FeedStatement;
use crate::program::writer::{Style, line_ending, print_number};
use crate::program::{Address, Batch, Block, Keyword, NewWord, WordForm};

/// The number of values in a row that needs these addresses: three, six or nine.
fn row_length(needs: impl Fn(Address) -> bool) -> usize {
    POINT.iter().rposition(|address| needs(*address)).map_or(3, |last| (last / 3 + 1) * 3)
}

/// The point again with other values, after a feed statement if the words have a feed.
pub(super) fn print_point(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    dropped: &[Address],
    _: bool,
    out: &mut Vec<u8>,
) {
    print_feed(batch, block, new, out);
    let words = batch.words(block);
    if new.iter().all(|word| word.address == Address::F) && dropped.is_empty() {
        out.extend_from_slice(body(batch, block));
        return;
    }
    let source = |address: Address| words.iter().find(|word| word.address == address);
    let has_value = |address: Address| new.iter().any(|word| word.address == address);
    let keeps = |address: Address| source(address).is_some() && !dropped.contains(&address);
    let is_row = words.iter().any(|word| word.keyword() == Some(Keyword::Goto))
        && words.iter().all(|word| word.form != WordForm::Incremental);
    let length = row_length(|address| has_value(address) || keeps(address));
    let own = POINT.iter().filter(|address| source(**address).is_some()).count();
    if !is_row || length != own {
        print_row(batch, block, new, dropped, out);
        return;
    }
    let mut copied = block.start;
    for word in words {
        if let Some(new) = new.iter().find(|new| new.address == word.address) {
            out.extend_from_slice(text(batch, copied, word.start));
            print_number(batch, word, new, out);
            copied = word.end;
        }
    }
    out.extend_from_slice(text(batch, copied, block.body_end));
}

/// A new point in the style of an old one, after a feed statement if the words have a feed. Values without a new word
/// are taken from the old point.
pub(super) fn insert_point(
    batch: &Batch,
    source: &Block,
    new: &[NewWord],
    dropped: &[Address],
    _: bool,
    out: &mut Vec<u8>,
) {
    print_feed(batch, source, new, out);
    if new.iter().all(|word| word.address == Address::F) {
        // The caller prints the line ending.
        let ending = line_ending(batch, source).len();
        out.truncate(out.len().saturating_sub(ending));
        return;
    }
    print_row(batch, source, new, dropped, out);
}

fn print_row(batch: &Batch, source: &Block, new: &[NewWord], dropped: &[Address], out: &mut Vec<u8>) {
    let words = batch.words(source);
    let style = Style::new(batch, source);
    let is_value = |address: Address| POINT.contains(&address);
    let mut own = words.iter().filter(|word| is_value(word.address));
    let (first, second) = (own.next(), own.next());
    let last = words.iter().rev().find(|word| is_value(word.address));
    let between = match (first, second) {
        (Some(first), Some(second)) => text(batch, first.end, second.start),
        _ => b",",
    };
    let between = if between.iter().all(|byte| matches!(byte, b',' | b' ' | b'\t')) { between } else { b"," };
    let head = first.map_or(&b""[..], |first| text(batch, source.start, first.start));
    let is_goto = head.trim_ascii_start().get(..4).is_some_and(|word| word.eq_ignore_ascii_case(b"GOTO"));
    if is_goto && !head.contains(&b'$') {
        out.extend_from_slice(head);
    } else {
        let indent = head.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
        out.extend_from_slice(head.get(..indent).unwrap_or_default());
        out.extend_from_slice(b"GOTO/");
    }
    let find = |address: Address| new.iter().find(|word| word.address == address);
    let old = |address: Address| words.iter().find(|word| word.address == address);
    let length = row_length(|address| {
        find(address).is_some() || (old(address).is_some() && !dropped.contains(&address))
    });
    for (index, address) in POINT.into_iter().take(length).enumerate() {
        if index > 0 {
            out.extend_from_slice(between);
        }
        match (find(address), old(address)) {
            (Some(new), Some(word)) => print_number(batch, word, new, out),
            (Some(new), None) => style.print_usual(new, out),
            (None, Some(word)) => out.extend_from_slice(batch.word_text(word)),
            (None, None) => out.push(b'0'),
        }
    }
    // Blanks and commas after the last value, as the program has them.
    let tail = last.map_or(&b""[..], |last| text(batch, last.end, source.body_end));
    if tail.iter().all(|byte| matches!(byte, b',' | b' ' | b'\t')) {
        out.extend_from_slice(tail);
    }
}

/// `FEDRAT/…` on a separate line.
fn print_feed(batch: &Batch, block: &Block, new: &[NewWord], out: &mut Vec<u8>) {
    let Some(feed) = new.iter().find(|word| word.address == Address::F) else { return };
    let statement = statement_before(batch, block);
    let indent = body(batch, block);
    let blanks = indent.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    out.extend_from_slice(indent.get(..blanks).unwrap_or_default());
    out.extend_from_slice(b"FEDRAT/");
    let blank: &[u8] = if statement.blank { b" " } else { b"" };
    let unit: &[u8] = match statement.unit {
        Some(Keyword::MmPerMinute) => b"MMPM",
        Some(Keyword::InchPerMinute) => b"IPM",
        Some(Keyword::UnitPerMinute) => b"PERMIN",
        Some(Keyword::MmPerRevolution) => b"MMPR",
        Some(Keyword::InchPerRevolution) => b"IPR",
        Some(Keyword::UnitPerRevolution) => b"PERREV",
        _ => b"",
    };
    let style = Style::new(batch, block);
    out.extend_from_slice(blank);
    if statement.unit_first && !unit.is_empty() {
        out.extend_from_slice(unit);
        out.push(b',');
        style.print_usual(feed, out);
    } else {
        style.print_usual(feed, out);
        if !unit.is_empty() {
            out.push(b',');
            out.extend_from_slice(blank);
            out.extend_from_slice(unit);
        }
    }
    out.extend_from_slice(line_ending(batch, block));
}

/// The style of the last feed before this block.
fn statement_before(batch: &Batch, block: &Block) -> FeedStatement {
    let mut before = batch.blocks.iter().rev().skip_while(|other| other.start > block.start);
    before.find_map(|other| FeedStatement::of(batch, other)).unwrap_or(batch.habits.feed_before)
}

fn body<'a>(batch: &'a Batch, block: &Block) -> &'a [u8] {
    text(batch, block.start, block.body_end)
}

fn text(batch: &Batch, from: u32, to: u32) -> &[u8] {
    batch.text.get(from as usize..to as usize).unwrap_or_default()
}
