//! What was made of a program: its unit, the work offsets and the tools it uses, with the lines where.

use crate::motion::{Motion, WorkOffset};
use crate::units::LengthUnit;

/// How a program was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProgramReading {
    /// The unit it counts in; `None` where it has no length.
    pub unit: Option<LengthUnit>,
    /// Whether the text itself says so.
    pub unit_is_stated: bool,
    /// The work offsets under which it moves, in the order in which they come.
    pub work_offsets: Vec<OffsetUse>,
}

/// The motions under one work offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffsetUse {
    /// The offset; `None` for all motions whose offset is not known, or is shifted in a way that is not known.
    pub offset: Option<WorkOffset>,
    /// It is the offset of the program's first point, or the one in force before the program names any.
    pub is_only: bool,
    /// Its motions are left alone, because nobody states where it is.
    pub is_left_alone: bool,
    /// First and last line of the upload with such a motion.
    pub lines: [u64; 2],
    /// How many there are.
    pub motions: u64,
}

/// Most work offsets that are told apart; the motions of further ones are counted with the last.
const MAX_OFFSETS: usize = 1000;

impl ProgramReading {
    /// Takes motions, in their order.
    pub(super) fn see(&mut self, motions: &[Motion]) {
        let mut last = None;
        for motion in motions {
            let offset =
                if motion.offset_changed && motion.is_only_offset { None } else { motion.work_offset };
            let key = (offset, motion.offset_changed);
            let known = match last {
                Some((known, index)) if known == key => Some(index),
                _ => self.work_offsets.iter().position(|used| (used.offset, used.is_left_alone) == key),
            };
            let index = known.unwrap_or_else(|| self.add(motion, offset));
            if let Some(used) = self.work_offsets.get_mut(index) {
                used.lines[1] = motion.line;
                used.motions += 1;
            }
            last = Some((key, index));
        }
    }

    fn add(&mut self, motion: &Motion, offset: Option<WorkOffset>) -> usize {
        if self.work_offsets.len() < MAX_OFFSETS {
            self.work_offsets.push(OffsetUse {
                offset,
                is_only: motion.is_only_offset,
                is_left_alone: motion.offset_changed,
                lines: [motion.line; 2],
                motions: 0,
            });
        }
        self.work_offsets.len() - 1
    }
}
