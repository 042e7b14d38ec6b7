//! How a run that is refused ends: with a block, at which its message stands.

use super::ProgramRun;
use crate::program::{Batch, BlockKind, ByteSpan, Diagnostic, DiagnosticCode};

impl ProgramRun {
    /// From the end of a called file to its last block, or to the call if the file has none. A message needs a block.
    pub(super) fn step_back_into_the_text(&mut self) {
        let body = self.files.body(self.file);
        if self.at < body.end {
            return;
        }
        if !body.is_empty() {
            self.at = body.end - 1;
        } else if let Some(caller) = self.callers.pop() {
            self.file = caller.file;
            self.at = caller.back.saturating_sub(1).max(self.files.blocks(caller.file).start);
        }
    }

    /// Ends the run with the present block as one of this kind.
    pub(super) fn end_with(
        &mut self,
        kind: BlockKind,
        code: Option<DiagnosticCode>,
        batch: &mut Batch,
    ) -> bool {
        self.copy(self.at + 1, batch);
        if batch.blocks.is_empty() {
            // A run that is refused must never look like one that is over.
            self.callers.clear();
            self.file = 0;
            self.at = self.files.blocks(0).end.saturating_sub(1);
            self.copy(self.at + 1, batch);
        }
        batch.is_evaluated = true;
        let called = batch.blocks().first().and_then(|block| batch.called_line(block));
        if let Some(block) = batch.blocks.first_mut() {
            block.kind = kind;
            block.words_end = block.words_start;
            let start = batch.offset + u64::from(block.start);
            let end = batch.offset + u64::from(block.body_end);
            batch.faults.clear();
            batch.faults.extend(code.map(|code| Diagnostic {
                code,
                line: block.line,
                called,
                column: 1,
                span: ByteSpan { start, end },
            }));
        }
        self.has_ended = true;
        true
    }
}
