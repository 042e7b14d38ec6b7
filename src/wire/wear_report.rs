//! The report of the compensation of a program for a worn cutter.

use serde::{Deserialize, Serialize};

use super::{
    Contact, DeviationSeries, DeviationSummary, Dialect, Fixed, Interpolation, Provenance, ResolvedInputs,
    Warning, WearAdviceAnswer,
};
use crate::description::ToSchema;
use crate::process::{self, CurvatureAcross};
use crate::units::Length;

/// The tightest curvature of the part across the feed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = CurvatureAcrossFeed)]
pub struct CurvatureDoc {
    /// Smallest radius where the part is convex; null if it is nowhere convex.
    pub convex_radius_mm: Option<f64>,
    /// Line of the upload whose motion ends there.
    pub convex_line: Option<u64>,
    /// Smallest radius where the part is concave; null if it is nowhere concave.
    pub concave_radius_mm: Option<f64>,
    /// Line of the upload whose motion ends there.
    pub concave_line: Option<u64>,
}

impl From<&CurvatureAcross> for CurvatureDoc {
    fn from(core: &CurvatureAcross) -> Self {
        let radius_mm = |found: Option<(Length, u64)>| found.map(|(radius, _)| radius.mm());
        Self {
            convex_radius_mm: radius_mm(core.convex),
            convex_line: core.convex.map(|(_, line)| line),
            concave_radius_mm: radius_mm(core.concave),
            concave_line: core.concave.map(|(_, line)| line),
        }
    }
}

/// How much of a program an assumed contact covers: the motions at feed, and their length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = AssumedContacts)]
pub struct AssumptionDoc {
    /// Straight motions at feed.
    pub cuts: u64,
    /// Motions at whose end a contact is assumed; only there can the cutter's residual be compensated.
    pub compensated: u64,
    /// Motions whose feed direction does not determine the contact: the tool plunges, or moves across its
    /// axis, as along a wall or on a floor.
    pub open: u64,
    /// Motions next to whose end no rotary axis turns; nothing is assumed there.
    pub not_turning: u64,
    /// Path length of the tip in all of these cuts.
    pub path_mm: f64,
    /// Path length of the tip in the compensated cuts.
    pub compensated_path_mm: f64,
}

impl From<&process::Assumption> for AssumptionDoc {
    fn from(core: &process::Assumption) -> Self {
        let process::Assumption { cuts, compensated, open, not_turning, path, path_compensated } = *core;
        Self {
            cuts,
            compensated,
            open,
            not_turning,
            path_mm: path.mm(),
            compensated_path_mm: path_compensated.mm(),
        }
    }
}

/// Results of the compensation for a worn cutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WearFindings {
    /// Dialect of the program text.
    pub dialect: Dialect,
    /// Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Where the cutter contact comes from.
    pub contact: Contact,
    /// Number of blocks in the upload.
    pub blocks_in: u64,
    /// Number of blocks in the answer; there are more only because of blocks with F alone before calls.
    pub blocks_out: u64,
    /// Number of blocks whose bytes changed.
    pub blocks_changed: u64,
    /// Number of motions at whose end a contact was found and kept.
    pub contacts_kept: u64,
    /// Number of motions at whose end a contact was assumed from the feed and kept.
    #[serde(default)]
    pub contacts_assumed: u64,
    /// For an assumed contact: how much of the program it covers. Null for a stated contact.
    #[serde(default)]
    pub assumption: Option<AssumptionDoc>,
    /// Number of motions that end at another point in the answer.
    pub motions_shifted: u64,
    /// Number of blocks whose F was lowered, so that no block runs faster than in the source.
    pub feeds_lowered: u64,
    /// Number of blocks that only got the source's F word back, after such blocks.
    pub feeds_restored: u64,
    /// Largest shift of a tip.
    pub max_shift_um: f64,
    /// Line of the upload with this shift; null if nothing moved.
    pub max_shift_line: Option<u64>,
    /// Smallest and largest angle between surface normal and tool axis; null without a contact.
    pub contact_angle_deg: Option<Fixed<2>>,
    /// Tightest curvature of the uploaded surface across the feed at the contacts; null without a surface.
    pub curvature: Option<CurvatureDoc>,
    /// Residual of the worn cutter along the normal with the unchanged program, without scallops.
    pub before: DeviationSummary,
    /// Distance between the contacts of the worn and the nominal cutter, computed from the written text.
    /// Values that depend on an assumed contact are as in `before`.
    pub after: DeviationSummary,
    /// For an assumed contact: the values of `after` if the assumption is right.
    #[serde(default)]
    pub after_if_assumed: Option<DeviationSummary>,
    /// Sum of the chords between contacts.
    pub cc_path_length_mm: f64,
    /// Both deviations along the path.
    pub series: DeviationSeries,
    /// Advice about the scallops for the contacts of this program; null if it was not requested.
    pub advice: Option<WearAdviceAnswer>,
    /// Warnings to the caller.
    pub warnings: Vec<Warning>,
}

impl WearFindings {
    /// Number of checked motions: those whose contact was found, or those moved by the length alone if these
    /// are more.
    #[must_use]
    pub const fn motions_checked(&self) -> u64 {
        let contacts = self.contacts_kept + self.contacts_assumed;
        if contacts > self.motions_shifted { contacts } else { self.motions_shifted }
    }
}

/// The report of a compensation for a worn cutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WearReport {
    /// The data that the result was computed from.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Inputs that were resolved beside the parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Results.
    #[serde(flatten)]
    pub findings: WearFindings,
}
