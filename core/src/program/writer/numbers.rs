//! Blocks of which only numbers change. Nearly every block that is printed again is such a block: each new word
//! replaces one of its words, in the order of the block, and the number is short.
//!
//! The general way in `body` looks for places of new words and for words to leave out, which takes longer than the
//! numbers. Here the digits of all numbers are computed before the first one is written: one number takes long, but a
//! processor computes several at the same time if nothing else is between them. The price is a second way to print
//! a block. The tests compare the two.

use super::NewWord;
use super::style::plain_look;
use crate::program::short_decimal::{Row, ShortDecimal};
use crate::program::{Address, Batch, Block, Word};

/// The most words that change.
const MOST_WORDS: usize = 8;

/// A number, and the bytes of the batch's text before it.
#[derive(Clone, Copy)]
struct Numbered {
    from: u32,
    to: u32,
    number: ShortDecimal,
}

impl Numbered {
    const NOTHING: Self = Self { from: 0, to: 0, number: ShortDecimal::NOTHING };
}

/// Finds the new words in the style of the block's words. `start` gives the place where the text before a word starts, by the
/// word before and the word itself. `None` if more than short numbers of the block change.
#[expect(clippy::inline_always, reason = "its two callers differ in `start`")]
#[inline(always)]
fn numbered(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    all: &mut [Numbered; MOST_WORDS],
    mut start: impl FnMut(Option<&Word>, &Word) -> Option<u32>,
) -> Option<()> {
    if new.len() > MOST_WORDS || !block.flags.is_plain() {
        return None;
    }
    let words = batch.words(block);
    let mut next = 0_usize;
    for (one, new) in all.iter_mut().zip(new) {
        let mut before = next.checked_sub(1).and_then(|index| words.get(index));
        let word = loop {
            let word = words.get(next)?;
            next += 1;
            if word.address == new.address {
                break word;
            }
            before = Some(word);
        };
        // Other addresses may be in a block twice.
        if !(word.address.is_coordinate() || word.address == Address::F) {
            return None;
        }
        let number = ShortDecimal::of(new.value, new.decimals, plain_look(batch, word)?)?;
        *one = Numbered { from: start(before, word)?, to: word.start + u32::from(word.lead), number };
    }
    Some(())
}

/// Appends the block up to its line ending, with the new words in place of its own. Appends nothing, and gives false,
/// if more than short numbers of the block change.
pub(super) fn print_numbers(batch: &Batch, block: &Block, new: &[NewWord], out: &mut Vec<u8>) -> bool {
    let mut copied = block.start;
    let mut all = [Numbered::NOTHING; MOST_WORDS];
    let start = |_: Option<&Word>, word: &Word| Some(std::mem::replace(&mut copied, word.end));
    if numbered(batch, block, new, &mut all, start).is_none() {
        return false;
    }
    let mut row = Row::new(out);
    for one in all.iter().take(new.len()) {
        row.push_piece(&batch.text, one.from as usize, one.to as usize);
        row.push_short(one.number);
    }
    row.push_piece(&batch.text, copied as usize, block.body_end as usize);
    row.flush();
    true
}

/// Whether only the letter of a word, and `=` if the dialect has it, is before its number.
fn is_after_letter(batch: &Batch, word: &Word) -> bool {
    let text = batch.text.get(word.start as usize..word.start as usize + usize::from(word.lead));
    let Some([letter, mark @ ..]) = text else { return false };
    let is_mark = |byte: &u8| matches!(byte, b' ' | b'\t' | b'=');
    word.address.letter() == Some(letter.to_ascii_uppercase())
        && (mark.is_empty() || (batch.dialect.rules().writing.has_equals && mark.iter().all(is_mark)))
}

/// Appends the new words in the style of the block's words of the same letters. Appends nothing, and gives false, if
/// the block does not have these letters in this order with only blanks before them.
pub(super) fn print_inserted_numbers(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    out: &mut Vec<u8>,
) -> bool {
    let mut all = [Numbered::NOTHING; MOST_WORDS];
    let mut is_first = true;
    let start = |before: Option<&Word>, word: &Word| {
        if !is_after_letter(batch, word) {
            return None;
        }
        if std::mem::take(&mut is_first) {
            return Some(word.start);
        }
        let gap = batch.text.get(before?.end as usize..word.start as usize)?;
        gap.iter().all(|byte| matches!(byte, b' ' | b'\t')).then_some(before?.end)
    };
    if numbered(batch, block, new, &mut all, start).is_none() {
        return false;
    }
    let mut row = Row::new(out);
    for one in all.iter().take(new.len()) {
        row.push_piece(&batch.text, one.from as usize, one.to as usize);
        row.push_short(one.number);
    }
    row.flush();
    true
}

#[cfg(test)]
mod tests {
    use super::super::body::{insert_any, print_any};
    use super::*;
    use crate::program::{Dialect, ReadLimits, Reader};

    const PROGRAMS: [(Dialect, &str); 4] = [
        (
            Dialect::Iso,
            "N10 G1 X1. Y-.5 z+3.25(note) F100\nX  12.5 Y   7.25\nX1 X2 ,R3 A5\nX[1+2] Y3\nG4 P2 (X1)\nX1Y2Z3",
        ),
        (Dialect::Siemens, "N1 G1 X=1.5 Y = 2 Z-3 ; X1\nX=AC(5) Y=IC(1) C=-.5\nA3=0.5 B3=0 C3=0.5 X1"),
        (
            Dialect::Heidenhain,
            "1 L X+1,5 Y-2 Z+3 R0 FMAX\n2 L X+1.5 IY-2 A+3 F100 M3\n3 LN X+1 NX+0 NY+0 NZ+1",
        ),
        (Dialect::Okuma, "G15 H1\nG1 X1. Y2.5 Z-3 F100 M8\nX5 Y7"),
    ];

    fn new_words(bits: u32) -> Vec<NewWord> {
        let addresses = [
            Address::X,
            Address::Y,
            Address::Z,
            Address::A,
            Address::C,
            Address::F,
            Address::TI,
            Address::NX,
        ];
        let chosen = addresses.into_iter().enumerate().filter(|(index, _)| bits >> index & 1 > 0);
        chosen
            .map(|(index, address)| NewWord {
                address,
                value: [0.5, -12.25, 0.0][index % 3] * f64::from(bits),
                decimals: 3,
            })
            .collect()
    }

    /// Prints every choice of words in two ways, where the first way applies.
    fn compare(
        quickly: impl Fn(&Batch, &Block, &[NewWord], &mut Vec<u8>) -> bool,
        generally: impl Fn(&Batch, &Block, &[NewWord], &mut Vec<u8>),
    ) {
        let mut compared = 0;
        for (dialect, text) in PROGRAMS {
            let mut reader = Reader::new(Some(dialect), ReadLimits::default());
            reader.feed(text.as_bytes());
            reader.finish();
            let mut batch = Batch::new();
            assert!(reader.next_batch(&mut batch).unwrap());
            for block in batch.blocks() {
                for bits in 0..512 {
                    let mut new = new_words(bits / 2);
                    if bits % 2 > 0 {
                        new.reverse();
                    }
                    let (mut text, mut other) = (b"; ".to_vec(), b"; ".to_vec());
                    if quickly(&batch, block, &new, &mut text) {
                        generally(&batch, block, &new, &mut other);
                        compared += 1;
                    }
                    assert_eq!(String::from_utf8_lossy(&text), String::from_utf8_lossy(&other), "{new:?}");
                }
            }
        }
        assert!(compared > 50, "{compared} blocks");
    }

    #[test]
    fn changed_numbers_are_printed_as_in_the_general_way() {
        compare(print_numbers, |batch, block, new, out| print_any(batch, block, new, &[], false, out));
    }

    #[test]
    fn inserted_numbers_are_printed_as_in_the_general_way() {
        compare(
            |batch, block, new, out| {
                // Conversational blocks are made by another function.
                batch.dialect != Dialect::Heidenhain && print_inserted_numbers(batch, block, new, out)
            },
            |batch, block, new, out| insert_any(batch, block, new, false, out),
        );
    }
}
