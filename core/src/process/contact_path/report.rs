//! The report of a compensated program.

use crate::motion::Interpolation;
use crate::process::fault::Warning;
use crate::process::pipeline::{DeviationSummary, Series};
use crate::process::set_up::ContactSource;
use crate::process::text::ProgramReading;
use crate::program::{Dialect, Steps};

/// Everything a compensation has to show for itself.
#[derive(Debug, Clone, PartialEq)]
pub struct CcReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// Who interpolates: with TCP where the program switches it on or the parameter says so. Motions before the switch
    /// are judged as machine motions all the same.
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
    /// Those of them that stay as they are, because their parts would run too fast.
    pub motions_left_over: u64,
    /// Blocks that only got their F word back after divided blocks.
    pub feeds_restored: u64,
    /// Deviation of the upload.
    pub before: DeviationSummary,
    /// Deviation of what was written, from its own text.
    pub after: DeviationSummary,
    /// Σ chords of the checked motions \[mm\].
    pub cc_path_length_mm: f64,
    /// Deviation along the path.
    pub series: Series,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}
