//! Written text before it is read back.

use std::collections::VecDeque;

use crate::process::text::Passage;

/// Text of the output, and its intended meaning.
#[derive(Debug)]
pub(in crate::process) struct Outgoing<E> {
    pub(in crate::process) text: Vec<u8>,
    /// The intended motions, in order.
    pub(in crate::process) expected: VecDeque<E>,
    /// The copied parts of it.
    pub(in crate::process) copied: Vec<Copied>,
}

/// Blocks that were copied into the output.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct Copied {
    /// Their passage, as its index in its stretch.
    pub(in crate::process) passage: usize,
    /// The first block, and the block after the last.
    pub(in crate::process) blocks: [usize; 2],
    /// Their start in the written text.
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

    /// Copies blocks of a passage. The passage comes with its index in its stretch.
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
