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
    /// Least radius where the part is convex, with its line; none where it never is.
    pub convex: Option<(Length, u64)>,
    /// Least radius where it is concave.
    pub concave: Option<(Length, u64)>,
}

/// Radii beyond this are flat: single-precision normals tell no more \[1/mm\].
const FLAT_PER_MM: f64 = 1e-5;

impl CurvatureAcross {
    /// Takes in the curvature at the end of a line's motion, positive where the part is convex.
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

/// Everything a wear compensation has to show for itself.
#[derive(Debug, Clone, PartialEq)]
pub struct WearReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// Interpolation mode: TCP if the program switches it on or the parameter asks for it.
    pub interpolation: Interpolation,
    /// Where contacts came from.
    pub contact: ContactSource,
    /// The steps that changed something.
    pub steps: Steps,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written: more only by blocks with F alone before calls.
    pub blocks_out: u64,
    /// Blocks whose bytes changed.
    pub blocks_changed: u64,
    /// Motions at whose end a contact is stated or found on the part, and kept.
    pub contacts_kept: u64,
    /// Motions at whose end a contact is assumed from the feed, and kept if it is the right one.
    pub contacts_assumed: u64,
    /// How much of the program could be compensated by assumed contacts; `None` where none are assumed.
    pub assumption: Option<Assumption>,
    /// What is left at assumed contacts if they are the right ones.
    pub after_if_assumed: Option<DeviationSummary>,
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
    /// How tightly the part is curved across the feed at the contacts of straight motions; none without a surface.
    pub curvature: Option<CurvatureAcross>,
    /// Offset that the worn cutter leaves along the normal with the program as it was.
    pub before: DeviationSummary,
    /// Distance of the worn cutter's contact from the nominal one's, from the written text. Where a contact is assumed nothing is
    /// proven, and what was there before counts.
    pub after: DeviationSummary,
    /// Σ chords between the contacts kept \[mm\].
    pub cc_path_length_mm: f64,
    /// Both along the path.
    pub series: Series,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}
