//! Plain lines: names, plain numbers and blanks, as nearly all lines of a program are.
//!
//! Each dialect reads such lines in one pass over their bytes. The pass ends at the first byte that it does not expect.
//! Then nothing of the line is left in the batch, and the dialect's general way reads the line. The price is a second
//! way to read a line. The tests compare the two.

use super::line::{MAX_WORDS, REPEATABLE, Source};
use crate::program::line::next_line;
use crate::program::number::{MAX_MAGNITUDE, read_long_signed, read_short_signed};
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, Keyword, Word, WordForm};

/// The habits of a program that the numbers of a dialect's lines show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shows {
    Points,
    PointsAndZeros,
    PointsZerosAndSigns,
}

/// A plain line on its way into a batch. A line that is begun is ended, whether it was plain or not.
pub(super) struct PlainLine<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    pub(super) start: usize,
    shift: usize,
    number: u64,
    batch: &'a mut Batch,
    first_word: usize,
    /// Addresses seen so far, and those seen twice.
    seen: u32,
    repeated: u32,
    flags: BlockFlags,
    drops_zero: bool,
    points: bool,
    plus_signs: bool,
}

impl<'a> PlainLine<'a> {
    #[inline]
    pub(super) fn begin(source: Source<'a>, batch: &'a mut Batch) -> Self {
        let Source { text, start, shift, line: number, .. } = source;
        Self {
            text,
            at: start,
            start,
            shift,
            number,
            first_word: batch.words.len(),
            batch,
            seen: 0,
            repeated: 0,
            flags: BlockFlags::default(),
            drops_zero: false,
            points: false,
            plus_signs: false,
        }
    }

    /// The byte at the present position; `None` at the end of the text.
    #[inline]
    pub(super) fn byte(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// Whether a number has a point so far.
    #[inline]
    pub(super) fn has_point(&self) -> bool {
        self.points
    }

    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        while matches!(self.byte(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    #[inline]
    fn in_batch(&self, at: usize) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
        let position = at.wrapping_add(self.shift) as u32;
        position
    }

    /// Adds the word that starts `lead` bytes before the present position, where its number is. Moves to the byte
    /// after the number.
    #[expect(clippy::inline_always, reason = "the innermost loop of every reader")]
    #[inline(always)]
    pub(super) fn word(&mut self, address: Address, lead: u8) -> Option<()> {
        let (read, sign) = match read_short_signed(self.text, self.at) {
            Some(read) => read,
            None => read_long_signed(self.text, self.at).filter(|(read, _)| read.value <= MAX_MAGNITUDE)?,
        };
        let bit = address.bit();
        self.repeated |= self.seen & bit;
        self.seen |= bit;
        self.drops_zero |= !read.has_whole;
        self.points |= read.has_point;
        self.plus_signs |= sign == b'+';
        let word = Word {
            // 0 − 0 is +0, so a negative zero never gets in.
            value: if sign == b'-' { 0.0 - read.value } else { read.value },
            start: self.in_batch(self.at - usize::from(lead)),
            end: self.in_batch(read.end),
            address,
            lead,
            decimals: read.decimals,
            form: WordForm::Number,
            has_point: read.has_point,
        };
        self.batch.words.push(word);
        self.at = read.end;
        Some(())
    }

    /// Moves to the byte after a comment. `None` if the comment directly follows a word with this address, because it
    /// may then be the word's argument.
    #[inline]
    pub(super) fn skip_comment(&mut self, end: usize, may_take_it: Address) -> Option<()> {
        let start = self.in_batch(self.at);
        if self.batch.words.last().is_some_and(|word| word.address == may_take_it && word.end == start) {
            return None;
        }
        self.flags.set(BlockFlags::COMMENT);
        self.at = end;
        Some(())
    }

    /// Adds a statement word that ends at the present position and has this number of bytes.
    #[inline]
    pub(super) fn keyword(&mut self, keyword: Keyword, length: usize) {
        let (start, end) = (self.in_batch(self.at - length), self.in_batch(self.at));
        self.batch.words.push(Word::of_keyword(keyword, start, end));
    }

    /// Ends the line, and gives the start of the next one. If the line `is_plain`, its ending is at the present
    /// position. Otherwise nothing of it stays.
    ///
    /// The result fits into registers. A longer one would make each line wait for the line before.
    #[inline]
    pub(super) fn end(self, is_plain: bool, shows: Shows) -> Option<usize> {
        let words = self.batch.words.len();
        if !is_plain || words - self.first_word > MAX_WORDS {
            self.batch.words.truncate(self.first_word);
            return None;
        }
        let habits = &mut self.batch.habits;
        habits.points |= self.points;
        habits.drops_zero |= self.drops_zero && shows != Shows::Points;
        habits.plus_signs |= self.plus_signs && shows == Shows::PointsZerosAndSigns;
        let next = next_line(self.text, self.at);
        let mut flags = self.flags;
        if self.repeated & !REPEATABLE != 0 {
            flags.set(BlockFlags::REPEATED);
        }
        #[expect(clippy::cast_possible_truncation, reason = "fewer words than bytes")]
        let (words_start, words_end) = (self.first_word as u32, words as u32);
        let block = Block {
            line: self.number,
            start: self.in_batch(self.start),
            body_end: self.in_batch(self.at),
            end: self.in_batch(next),
            words_start,
            words_end,
            kind: BlockKind::Words,
            flags,
        };
        self.batch.blocks.push(block);
        Some(next)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::{Config, TestRunner};

    use super::super::LineRead;
    use super::*;

    const NUMBERS: &str = "1|-1.5|+.5|-0.0|0.|12345678|1234567.|1234.5678|0.1234567|0.12345678|0.123456789|\
        123.12345678901234|-1234567.12345678|12345678.5|0.00000000000000000000001|99999999999|1,5|--1|. |-|9|2.25";
    const ENDINGS: [&str; 3] = ["\n", "\r\n", "\r"];
    /// Lines after it: on some of them the meaning of a line depends.
    const NEXT: [&str; 5] =
        ["L X+1\n", "RND R1\n", "13 L X+1.5 Y-2.5 Z+3.5\n", "\n", "X1. Y2. Z3. A4. C5. X1. Y2.\n"];

    /// Lines of these pieces and numbers: many are plain, and some of the others are nearly plain.
    fn line(pieces: &'static str) -> impl Strategy<Value = String> {
        let piece = prop::sample::select(pieces.split('|').collect::<Vec<_>>());
        let number = prop::sample::select(NUMBERS.split('|').collect::<Vec<_>>());
        let blank = prop::sample::select(vec!["", "", " ", "  ", "\t"]);
        prop::collection::vec((piece, number, blank, 0..5_u8), 0..9).prop_map(|words| {
            let word = |(piece, number, blank, kind): (&str, &str, &str, u8)| match kind {
                0 => format!("{piece}{blank}"),
                1 => format!("{number}{blank}"),
                _ => format!("{piece}{number}{blank}"),
            };
            words.into_iter().map(word).collect()
        })
    }

    /// Compares the two ways to read a line: these plain lines, and lines of these pieces.
    pub(in crate::program::dialect) fn compare(
        plain_lines: &[&str],
        pieces: &'static str,
        plain: fn(Source<'_>, &mut Batch) -> Option<usize>,
        general: fn(Source<'_>, &mut Batch) -> Option<LineRead>,
    ) {
        let read_both_ways = |text: &str, line: u64| {
            let source = Source { text: text.as_bytes(), start: 0, shift: 5, line, is_last: false };
            let columns = vec![Address::X, Address::Y, Address::Z];
            let (mut batch, mut other) =
                (Batch { columns: columns.clone(), ..Batch::new() }, Batch { columns, ..Batch::new() });
            let Some(next) = plain(source, &mut batch) else {
                assert_eq!(batch, other, "nothing is left of {text:?}");
                return false;
            };
            assert_eq!(Some(LineRead::one(next)), general(source, &mut other), "{text:?}");
            assert_eq!(batch, other, "{text:?}");
            true
        };
        for line in plain_lines {
            assert!(read_both_ways(&format!("{line}\n13 L X+1.5 Y-2.5 Z+3.5\n"), 7), "{line}");
        }
        let ending = prop::sample::select(ENDINGS.to_vec());
        let next = prop::sample::select(NEXT.to_vec());
        let mut runner = TestRunner::new(Config::with_cases(4000));
        let lines = (line(pieces), ending, next, 1..3_u64);
        let result = runner.run(&lines, |(line, ending, next, number)| {
            read_both_ways(&format!("{line}{ending}{next}"), number);
            Ok(())
        });
        assert_eq!(result, Ok(()));
    }
}
