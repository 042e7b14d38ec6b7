//! Blocks of which only numbers change. Nearly every block that is printed again is such a block: each new word
//! replaces one of its words, in the order of the block, and the number is short.
//!
//! The general way in `body` looks for places of new words and for words to leave out, which takes longer than the
//! numbers. Here the words of the block are gone through once, and everything is written into one row of fixed length.
//! The price is a second way to print a block. The tests compare the two.

use super::NewWord;
use super::style::PlainLooks;
use crate::program::short_decimal::{Row, ShortDecimal, append_row};
use crate::program::{Address, Batch, Block, Word};

/// Finds the new words among the block's words and appends them. Each has its letter as written, after the text before
/// it. `start` gives the place where this text starts, by the word before and the word itself. `None` if more than
/// short numbers of the block change.
#[expect(clippy::inline_always, reason = "its two callers differ in `start`")]
#[inline(always)]
fn push_numbers(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    row: &mut Row<'_>,
    mut start: impl FnMut(Option<&Word>, &Word) -> Option<u32>,
) -> Option<()> {
    let looks = PlainLooks::of(batch)?;
    let mut words = batch.words(block).iter();
    let mut before = None;
    for new in new {
        let word = loop {
            let word = words.next()?;
            if word.address == new.address {
                break word;
            }
            before = Some(word);
        };
        // Other addresses may be in a block twice.
        if !(word.address.is_coordinate() || word.address == Address::F) {
            return None;
        }
        let number = ShortDecimal::of(new.value, new.decimals, looks.of_word(word)?)?;
        let (from, to) = (start(before, word)?, word.start + u32::from(word.lead));
        row.push_word(&batch.text, from as usize, to as usize, number)?;
        before = Some(word);
    }
    Some(())
}

/// Appends the block up to its line ending, with the new words in place of its own. Appends nothing, and gives false,
/// if more than short numbers of the block change.
pub(super) fn print_numbers(batch: &Batch, block: &Block, new: &[NewWord], out: &mut Vec<u8>) -> bool {
    block.flags.is_plain()
        && append_row(out, |row| {
            let mut copied = block.start;
            let start = |_: Option<&Word>, word: &Word| Some(std::mem::replace(&mut copied, word.end));
            push_numbers(batch, block, new, row, start)?;
            row.push_piece(&batch.text, copied as usize, block.body_end as usize)
        })
}

/// Whether only the letter of a word, and `=` if the dialect has it, is before its number.
fn is_after_letter(batch: &Batch, word: &Word) -> bool {
    let start = word.start as usize;
    if word.lead == 1 {
        let letter = batch.text.get(start).copied().and_then(Address::from_letter);
        return letter == Some(word.address);
    }
    let Some([letter, mark @ ..]) = batch.text.get(start..start + usize::from(word.lead)) else {
        return false;
    };
    let is_mark = |byte: &u8| matches!(byte, b' ' | b'\t' | b'=');
    Address::from_letter(*letter) == Some(word.address)
        && batch.dialect.rules().writing.has_equals
        && mark.iter().all(is_mark)
}

/// Appends the new words in the style of the block's words of the same letters. Appends nothing, and gives false, if
/// the block does not have these letters in this order with only blanks before them.
pub(super) fn print_inserted_numbers(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    out: &mut Vec<u8>,
) -> bool {
    let mut is_first = true;
    let start = |before: Option<&Word>, word: &Word| {
        if !is_after_letter(batch, word) {
            return None;
        }
        if std::mem::take(&mut is_first) {
            return Some(word.start);
        }
        let gap = batch.text.get(before?.end as usize..word.start as usize)?;
        let is_blank = gap == b" " || gap.iter().all(|byte| matches!(byte, b' ' | b'\t'));
        is_blank.then_some(before?.end)
    };
    block.flags.is_plain() && append_row(out, |row| push_numbers(batch, block, new, row, start))
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
