//! From blocks to motions.

use super::Motion;
use crate::machine::Machine;
use crate::program::{Batch, Diagnostics};

/// How a program is to be taken where the text alone does not say.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InterpreterOptions {
    /// Feed before the first F word [mm/min].
    pub feed_mm_per_min: Option<f64>,
}

/// A control that reads batch after batch.
#[derive(Debug, Clone)]
pub struct Interpreter {
    _options: InterpreterOptions,
}

impl Interpreter {
    /// A control in its starting state.
    #[must_use]
    pub fn new(_machine: &Machine, options: InterpreterOptions) -> Self {
        Self { _options: options }
    }

    /// Appends the motions of the batch, and what there is to say about it; the first severity-`Refusal` diagnostic
    /// means that the program has to be refused as a whole.
    pub fn interpret(&mut self, _batch: &Batch, _motions: &mut Vec<Motion>, _diagnostics: &mut Diagnostics) {}

    /// Whether the program has ended (M2, M30, closing `%`): what follows is text.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        false
    }
}
