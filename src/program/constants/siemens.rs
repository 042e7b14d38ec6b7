//! R parameters and variables of the Sinumerik.

use crate::program::Batch;

/// What the program has assigned so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Variables {}

impl Variables {
    #[expect(clippy::unused_self, clippy::needless_pass_by_ref_mut, reason = "nothing is evaluated yet")]
    pub(super) fn evaluate(&mut self, _batch: &mut Batch) {}
}
