//! Text on its way out.

use std::collections::VecDeque;

use crate::process::text::Passage;

/// Text of the output, and what it has to mean.
#[derive(Debug)]
pub(in crate::process) struct Outgoing<E> {
    pub(in crate::process) text: Vec<u8>,
    /// What its motions have to be, in their order.
    pub(in crate::process) expected: VecDeque<E>,
    /// What of it was copied.
    pub(in crate::process) copied: Vec<Copied>,
}

/// Blocks that were copied into the output.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct Copied {
    /// Their passage, by its place in its stretch.
    pub(in crate::process) passage: usize,
    /// The first block, and the one behind the last.
    pub(in crate::process) blocks: [usize; 2],
    /// Where they start in the text that was written.
    pub(in crate::process) at: usize,
}

impl<E> Default for Outgoing<E> {
    fn default() -> Self {
        Self { text: Vec::new(), expected: VecDeque::new(), copied: Vec::new() }
    }
}

impl<E> Outgoing<E> {
    pub(in crate::process) fn clear(&mut self) {
        self.text.clear();
        self.expected.clear();
        self.copied.clear();
    }

    /// Copies blocks of a passage, given with its place in its stretch.
    pub(in crate::process) fn copy(
        &mut self,
        (index, passage): (usize, &Passage),
        first: usize,
        last: usize,
    ) {
        if first < last {
            self.copied.push(Copied { passage: index, blocks: [first, last], at: self.text.len() });
            self.text.extend_from_slice(passage.batch.blocks_text(first, last));
        }
    }
}
