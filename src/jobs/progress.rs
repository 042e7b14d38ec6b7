//! How far work on a program has come, by the bytes that were read of the program.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{InputFile, ProgramWork};

/// Progress of a program that was read to its end but whose result is not complete yet.
const ALMOST_DONE: f64 = 0.99;

/// The progress of one computation.
#[derive(Debug, Clone)]
pub struct Progress {
    /// Bytes read so far.
    read: Arc<AtomicU64>,
    /// Bytes to read.
    all: f64,
}

impl Progress {
    /// The progress of this work on this program. Its steps take the program one after the other, and each reads it
    /// once. With more readings the progress waits at the end.
    #[must_use]
    pub fn of(program: &InputFile, work: &ProgramWork) -> Self {
        let all = program.length as f64 * f64::from(work.steps_in_turn().max(1));
        Self { read: program.counted(), all }
    }

    /// The part of the work that is done, between 0 and 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        (self.read.load(Ordering::Relaxed) as f64 / self.all.max(1.0)).min(ALMOST_DONE)
    }
}
