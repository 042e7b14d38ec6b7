//! The course of a program so far: whether it has begun, has moved and has ended, and which kinds of numbers it has.

use super::block_words::{AXES, BlockWords, DWELL};
use super::interpreter::Interpreter;

/// The course of a program so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Course {
    has_blocks: bool,
    has_motions: bool,
    /// Line of the block that ended the program.
    end_line: Option<u64>,
    blocks_after_end: u64,
    /// Axis words without a decimal point that are not zero, and whether a word with a point was seen.
    words_without_point: u64,
    has_points: bool,
}

impl Course {
    /// A block with words was seen.
    pub(super) fn note_block(&mut self) {
        self.has_blocks = true;
    }

    pub(super) fn has_blocks(&self) -> bool {
        self.has_blocks
    }

    pub(super) fn note_motion(&mut self) {
        self.has_motions = true;
    }

    pub(super) fn has_motions(&self) -> bool {
        self.has_motions
    }

    /// The program ends at this line; `None` if it has not ended so far.
    pub(super) fn end_at(&mut self, line: Option<u64>) {
        self.end_line = line;
    }

    pub(super) fn end_line(&self) -> Option<u64> {
        self.end_line
    }

    pub(super) fn has_ended(&self) -> bool {
        self.end_line.is_some()
    }

    /// Counts a line after the end if it is a block.
    pub(super) fn pass_behind_end(&mut self, is_block: bool) {
        self.blocks_after_end += u64::from(is_block);
    }

    /// Counts the axis words of a block that is not a dwell.
    #[inline]
    pub(super) fn count_points(&mut self, block: &BlockWords) {
        let axes = block.present & AXES & !block.unknown;
        let mut without = axes & !block.points;
        if axes == 0 || block.g_codes().contains(&DWELL) {
            return;
        }
        self.has_points |= without != axes;
        while without != 0 {
            let index = without.trailing_zeros() as usize & 31;
            without &= without - 1;
            self.words_without_point += u64::from(block.values[index] != 0.0);
        }
    }
}

impl Interpreter {
    /// Whether the program has ended (M2, M30, M99, closing `%`). The lines after the end are only text.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.course().has_ended()
    }

    /// 1-based line of the block that ended the program, if it has ended.
    #[must_use]
    pub fn end_line(&self) -> Option<u64> {
        self.course().end_line
    }

    /// The number of blocks after the end of the program so far, without tape marks and comments. These blocks are
    /// neither checked nor followed.
    #[must_use]
    pub fn blocks_after_end(&self) -> u64 {
        self.course().blocks_after_end
    }

    /// The number of words X Y Z A B C so far that have a whole number other than 0 and no decimal point. They
    /// count only in ISO and OSP programs that write other words with a point; otherwise the number is 0. Controls that
    /// count in least increments read `X10` as 0.010 mm. Times of a dwell are not counted.
    #[must_use]
    pub fn words_without_point(&self) -> u64 {
        let course = self.course();
        if course.has_points { course.words_without_point } else { 0 }
    }
}
