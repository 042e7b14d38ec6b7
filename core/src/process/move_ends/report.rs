//! The report that goes with a program for a worn cutter.

use super::assumption::Assumption;
use crate::motion::Interpolation;
use crate::process::fault::Warning;
use crate::process::pipeline::{DeviationSummary, Series};
use crate::process::set_up::ContactSource;
use crate::process::text::ProgramReading;
use crate::program::{Dialect, Steps};
use crate::units::{Angle, Length};

/// The tightest curvature of the part across the feed, over the contacts of a program.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurvatureAcross {
    /// Least radius where the part is convex, with its line. `None` if the part is never convex.
    pub convex: Option<(Length, u64)>,
    /// Least radius where the part is concave, with its line.
    pub concave: Option<(Length, u64)>,
}

/// A smaller curvature counts as flat, because single-precision normals show no more \[1/mm\].
const FLAT_PER_MM: f64 = 1e-5;

impl CurvatureAcross {
    /// Records the curvature at the end of a line's motion, positive where the part is convex.
    pub(super) fn note(&mut self, curvature_per_mm: f64, line: u64) {
        if curvature_per_mm.is_nan() || curvature_per_mm.abs() < FLAT_PER_MM {
            return;
        }
        let radius = Length::from_mm(1.0 / curvature_per_mm.abs());
        let least = if curvature_per_mm > 0.0 { &mut self.convex } else { &mut self.concave };
        if least.is_none_or(|(known, _)| radius < known) {
            *least = Some((radius, line));
        }
    }
}

/// The report of a wear compensation.
#[derive(Debug, Clone, PartialEq)]
pub struct WearReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// The interpolation mode: TCP if the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Where contacts came from.
    pub contact: ContactSource,
    /// The steps that changed something.
    pub steps: Steps,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written. The only inserted blocks are those with F alone before calls.
    pub blocks_out: u64,
    /// Blocks whose bytes changed.
    pub blocks_changed: u64,
    /// Motions at whose end a contact is stated or found on the part. It is kept.
    pub contacts_kept: u64,
    /// Motions at whose end a contact is assumed from the feed. It is kept if the assumption is right.
    pub contacts_assumed: u64,
    /// How much of the program could be compensated by assumed contacts. `None` if none are assumed.
    pub assumption: Option<Assumption>,
    /// The remaining deviation at assumed contacts, if the assumptions are right.
    pub after_if_assumed: Option<DeviationSummary>,
    /// Motions whose end is at another place in the written program.
    pub motions_shifted: u64,
    /// Blocks whose F was lowered so that they do not run faster than the source's.
    pub feeds_lowered: u64,
    /// Blocks that changed only because the source's F word was restored after such blocks.
    pub feeds_restored: u64,
    /// Largest shift of a tip.
    pub max_shift: Length,
    /// The line of the largest shift.
    pub max_shift_line: Option<u64>,
    /// Least and largest angle between normal and tool axis. `None` without a contact.
    pub contact_angles: Option<[Angle; 2]>,
    /// How tightly the part is curved across the feed at the contacts of straight motions. `None` without a surface.
    pub curvature: Option<CurvatureAcross>,
    /// Offset along the normal that the worn cutter leaves with the original program.
    pub before: DeviationSummary,
    /// Distance of the worn cutter's contact from the nominal one's, from the written text. An assumed contact proves
    /// nothing, so the deviation before counts there.
    pub after: DeviationSummary,
    /// Σ chords between the kept contacts \[mm\].
    pub cc_path_length_mm: f64,
    /// Both deviations along the path.
    pub series: Series,
    /// Warnings for the caller.
    pub warnings: Vec<Warning>,
}
