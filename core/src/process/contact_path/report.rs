//! The report of a compensated program.

use crate::motion::Interpolation;
use crate::process::fault::Warning;
use crate::process::pipeline::{DeviationSummary, Series};
use crate::process::set_up::ContactSource;
use crate::process::text::ProgramReading;
use crate::program::{Dialect, Steps};

/// The report of a compensation.
#[derive(Debug, Clone, PartialEq)]
pub struct CcReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// The interpolation mode: TCP if the program switches it on or the parameter says so. Motions before the switch
    /// are still judged as machine motions.
    pub interpolation: Interpolation,
    /// Where contacts came from.
    pub contact: ContactSource,
    /// The steps that changed something.
    pub steps: Steps,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written.
    pub blocks_out: u64,
    /// Motions checked.
    pub motions_checked: u64,
    /// Motions over tolerance before.
    pub motions_over_tolerance: u64,
    /// Motions over tolerance that are left unchanged, because their parts would run too fast.
    pub motions_left_over: u64,
    /// Blocks that changed only because their F word was restored after divided blocks.
    pub feeds_restored: u64,
    /// Deviation of the upload.
    pub before: DeviationSummary,
    /// Deviation of the written program, measured from its own text.
    pub after: DeviationSummary,
    /// Σ chords of the checked motions \[mm\].
    pub cc_path_length_mm: f64,
    /// Deviation along the path.
    pub series: Series,
    /// Warnings for the caller.
    pub warnings: Vec<Warning>,
}
