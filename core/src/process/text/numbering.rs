//! Numbers for inserted blocks, between those of their neighbours, if there is room.

use crate::program::{Address, Batch, Block, Word, WordForm};

/// Block numbers are whole and below this.
const MAX_NUMBER: f64 = 1e9;

/// How a program numbers its blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::process) struct Numbering {
    last: Option<u64>,
    /// Every number is greater than all numbers before it. A number between two neighbours is then unused.
    increases: bool,
    /// Smallest step from one number to the next.
    least_step: u64,
}

impl Default for Numbering {
    fn default() -> Self {
        Self { last: None, increases: true, least_step: u64::MAX }
    }
}

impl Numbering {
    /// Whether blocks get the same numbers with both.
    pub(in crate::process) fn holds_for(&self, whole: &Self) -> bool {
        let facts = |of: &Self| (of.last.is_some(), of.increases, of.least_step);
        facts(self) == facts(whole)
    }

    /// Looks at the next block's words.
    pub(in crate::process) fn see(&mut self, words: &[Word]) {
        for word in words.iter().filter(|word| word.address == Address::N) {
            let Some(number) = whole(word) else {
                self.increases = false;
                continue;
            };
            self.see_number(number);
        }
    }

    /// Looks at the next block's number.
    pub(in crate::process) fn see_number(&mut self, number: u64) {
        if let Some(last) = self.last {
            self.increases &= number > last;
            self.least_step = self.least_step.min(number.saturating_sub(last));
        }
        self.last = Some(number);
    }

    /// The first of `count` numbers, one apart, for blocks after the block of index `block`. `None` if that block
    /// has no number, or if there is no room before the next one. After the last block of a batch, the room is the
    /// program's smallest step.
    pub(in crate::process) fn behind(&self, batch: &Batch, block: usize, count: u64) -> Option<u64> {
        if !self.increases || self.last.is_none() || count == 0 {
            return None;
        }
        let number =
            |block: &Block| batch.words(block).iter().find(|word| word.address == Address::N).and_then(whole);
        let own = number(batch.blocks().get(block)?)?;
        let next = batch.blocks().iter().skip(block + 1).find_map(number);
        let room = next.map_or(self.least_step, |next| next.saturating_sub(own));
        let last = own.checked_add(count)?;
        let same_length = last.ilog10() == own.max(1).ilog10() || next.is_some();
        (count < room && same_length).then_some(own + 1)
    }
}

fn whole(word: &Word) -> Option<u64> {
    let plain = word.form == WordForm::Number && !word.has_point && (0.0..MAX_NUMBER).contains(&word.value);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole and in range")]
    plain.then_some(word.value as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Dialect, ReadLimits, Reader};

    fn numbers(text: &str, block: usize, count: u64) -> Option<u64> {
        let mut reader = Reader::new(Some(Dialect::Iso), ReadLimits::default());
        let mut batch = Batch::new();
        reader.feed(text.as_bytes());
        reader.finish();
        assert!(reader.next_batch(&mut batch).unwrap());
        let mut numbering = Numbering::default();
        batch.blocks().iter().for_each(|block| numbering.see(batch.words(block)));
        numbering.behind(&batch, block, count)
    }

    #[test]
    fn new_numbers_lie_between_those_of_the_neighbours() {
        let text = "N10 X1\nN20 X2\n(note)\nN25 X3\nX4\nN35 X5\n";
        assert_eq!(numbers(text, 0, 9), Some(11));
        assert_eq!(numbers(text, 0, 10), None);
        assert_eq!(numbers(text, 1, 4), Some(21));
        assert_eq!(numbers(text, 1, 5), None);
        assert_eq!(numbers(text, 4, 1), None, "a block without a number");
        // The number after the last one of the batch may be the smallest step away.
        assert_eq!(numbers(text, 5, 4), Some(36));
        assert_eq!(numbers(text, 5, 5), None);
    }

    #[test]
    fn where_a_number_could_be_another_ones_there_is_none() {
        assert_eq!(numbers("N10 X1\nN20 X2\nN15 X3\n", 0, 1), None);
        assert_eq!(numbers("N10 X1\nN20 X2\nN20 X3\n", 0, 1), None);
        assert_eq!(numbers("N10.5 X1\nN20 X2\n", 0, 1), None);
        assert_eq!(numbers("N1 X1\nN2 X2\n", 0, 1), None);
        // One digit more than the control may accept.
        assert_eq!(numbers("N9989 X1\nN9999 X2\n", 1, 2), None);
    }
}
