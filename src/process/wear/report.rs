//! The report that goes with a program for a worn cutter.

use super::super::{ContactSource, DeviationSummary, Series, Warning};
use crate::motion::Interpolation;
use crate::program::Dialect;
use crate::units::{Angle, Length};

/// Everything a wear compensation has to show for itself.
#[derive(Debug, Clone, PartialEq)]
pub struct WearReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// Who interpolates: with TCP where the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Where contacts came from.
    pub contact: ContactSource,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written: more only by blocks with F alone before calls.
    pub blocks_out: u64,
    /// Blocks whose bytes changed.
    pub blocks_changed: u64,
    /// Motions at whose end a contact was found, and kept.
    pub contacts_kept: u64,
    /// Motions whose end stands elsewhere in the written program.
    pub motions_shifted: u64,
    /// Blocks whose F was lowered so that they do not run faster than the source's.
    pub feeds_lowered: u64,
    /// Blocks that only got the source's F word back behind such ones.
    pub feeds_restored: u64,
    /// Largest shift of a tip.
    pub max_shift: Length,
    /// Where.
    pub max_shift_line: Option<u64>,
    /// Least and largest angle between normal and tool axis; none without a contact.
    pub contact_angles: Option<[Angle; 2]>,
    /// Offset that the worn cutter leaves along the normal with the program as it was.
    pub before: DeviationSummary,
    /// Distance of the worn cutter's contact from the nominal one's, from the written text.
    pub after: DeviationSummary,
    /// Σ chords between the contacts kept \[mm\].
    pub cc_path_length_mm: f64,
    /// Both along the path.
    pub series: Series,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}
