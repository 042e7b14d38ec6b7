//! Parameters and report of the compensation of the CC path.

use serde::{Deserialize, Serialize};

use super::statements::program_parameters;
use super::{
    Contact, DeviationSeries, DeviationSummary, Dialect, Fault, FaultList, Interpolation, Provenance,
    ResolvedInputs, SingularRegions, SingularityAction, SingularityFindings, StampForm, SurfaceReading,
    Warning,
};
use crate::description::ToSchema;
use crate::machine::{Tool, ToolFault};
use crate::process;
use crate::units::Length;

/// How a deviating block is corrected.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Back onto the line, at the same share of it: no deviation is left, and the contact keeps its speed.
    #[default]
    Even,
    /// Back onto the line by the shortest way: no deviation is left, but the speed of the contact varies
    /// strongly.
    Foot,
    /// As first published: the tip moves away from its own foot on the line. A deviation is left; use it only
    /// for comparison.
    Seed,
}

/// Which blocks the answer has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Output {
    /// As few as the tolerance allows.
    #[default]
    Minimal,
    /// One block at every interpolation period of a block over tolerance; needs a feed.
    Interpolated,
}

program_parameters! {
/// Parameters of the compensation of the CC path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CcParameters {
    /// Cutter radius R. If it is absent, the machine's tool table gives it. Only `contact=tip` needs no
    /// radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 5.0)]
    pub tool_radius_mm: Option<f64>,
    /// Corner radius r. If it is absent, it equals the cutter radius (a ball-end cutter).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<f64>,
    /// Largest allowed distance of the CC path from its line.
    #[serde(default = "CcParameters::default_tolerance_um")]
    #[schema(default = 10.0)]
    pub tolerance_um: f64,
    /// Where the cutter contact comes from.
    #[serde(default)]
    pub contact: Contact,
    /// Millimetres in one unit of the uploaded surface: 25.4 for inches; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// Largest distance of the uploaded facets from the smooth surface that they represent; default 10.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// The cutter touches the uploaded surface if it is at most this far above or inside the facets; default
    /// 100.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_gap_um: Option<f64>,
    /// If the feed direction turns by more than this angle, a new pass begins for an assumed contact
    /// (`feed-plane`).
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
    /// How a deviating block is corrected.
    #[serde(default)]
    pub correction: Correction,
    /// Which blocks the answer has.
    #[serde(default)]
    pub output: Output,
    /// Largest F that the service writes; a block whose parts need a larger F stays as it is. If it is
    /// absent, the machine's `max_feed_mm_per_min` is used; without that, ten times the programmed feed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 12_000.0)]
    pub max_feed_mm_per_min: Option<f64>,
    /// Whether a changed program gets a comment that says so.
    #[serde(default)]
    #[schema(default = "comment")]
    pub stamp: StampForm,
    /// Apply the steps `cc` and `singularity` again to a program that already has their stamp, or is an earlier
    /// answer of theirs. A program that was smoothed before is not smoothed again. Steps that move ends are never
    /// repeated.
    #[serde(default)]
    #[schema(default = false)]
    pub allow_repeated: bool,
    /// Write the loops and calls of the program out, and compensate the result: one program without loops and
    /// calls. Without it, motions after a call are left unchanged, and a program with loops is refused.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(default = false)]
    pub flatten: bool,
    /// Treatment of singular regions, before all other steps.
    #[serde(default)]
    pub singularity: SingularityAction,
    /// How singular regions are found and treated; as query parameters one for each, such as
    /// `singular_regions.axis_tolerance_deg`.
    #[serde(default)]
    pub singular_regions: SingularRegions,
}
}

impl Default for CcParameters {
    fn default() -> Self {
        Self {
            tool_radius_mm: None,
            corner_radius_mm: None,
            tolerance_um: Self::default_tolerance_um(),
            contact: Contact::default(),
            surface_unit_mm: None,
            chordal_tolerance_um: None,
            contact_gap_um: None,
            pass_break_deg: Self::default_pass_break_deg(),
            correction: Correction::default(),
            output: Output::default(),
            max_feed_mm_per_min: None,
            stamp: StampForm::default(),
            allow_repeated: false,
            flatten: false,
            singularity: SingularityAction::default(),
            singular_regions: SingularRegions::default(),
            interpolation: None,
            unit: None,
            work_offset_mm: None,
            work_offsets_mm: None,
            radius_offsets_mm: None,
            tool_length_mm: None,
            tool_number: None,
            start: None,
            feed_mm_per_min: None,
            dialect: Dialect::default(),
        }
    }
}

impl CcParameters {
    /// Tolerance if none is stated (µm).
    #[must_use]
    pub const fn default_tolerance_um() -> f64 {
        10.0
    }

    /// Angle that separates two passes if none is stated (deg).
    #[must_use]
    pub const fn default_pass_break_deg() -> f64 {
        process::ContactSource::PASS_BREAK_DEG
    }

    /// Smallest and largest angle that may separate two passes (deg).
    pub const PASS_BREAK_RANGE_DEG: [f64; 2] = [0.1, 180.0];
    /// Smallest and largest tolerance (µm).
    pub const TOLERANCE_RANGE_UM: [f64; 2] = [0.01, 10_000.0];
    /// Largest feed that is accepted [mm/min].
    pub const MAX_FEED_MM_PER_MIN: f64 = 1e6;
    /// Largest offset or tool length that is accepted (mm).
    pub const MAX_OFFSET_MM: f64 = 1e5;

    /// How an uploaded surface is read.
    #[must_use]
    pub fn surface_reading(&self) -> SurfaceReading {
        SurfaceReading {
            unit_mm: self.surface_unit_mm,
            chordal_tolerance_um: self.chordal_tolerance_um,
            contact_gap_um: self.contact_gap_um,
        }
    }

    /// The tool, if the parameters state one. `has_part` says whether the surface of the part came with the
    /// program. Whether a tool is needed depends on the machine's tool table and on the program.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn check(&self, has_part: bool) -> Result<Option<Tool>, Vec<Fault>> {
        let mut faults = FaultList::default();
        self.surface_reading().check_with_contact(self.contact, has_part, &mut faults);
        let [min, max] = Self::TOLERANCE_RANGE_UM;
        faults.check_range(|| "/tolerance_um".to_owned(), self.tolerance_um, min, max);
        check_pass_break("", self.pass_break_deg, &mut faults);
        check_max_feed(self.max_feed_mm_per_min, &mut faults);
        self.statements().check(&mut faults);
        self.singular_regions.check(&mut faults);
        let tool = self.tool(&mut faults);
        faults.into_result().map(|()| tool)
    }

    fn tool(&self, faults: &mut FaultList) -> Option<Tool> {
        let Some(radius_mm) = self.tool_radius_mm else {
            if self.corner_radius_mm.is_some() {
                let detail = "missing: a corner radius needs the tool radius too";
                faults.push(|| Fault::new("/tool_radius_mm", detail));
            }
            return None;
        };
        let corner_mm = self.corner_radius_mm.unwrap_or(radius_mm);
        match Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)) {
            Ok(tool) => Some(tool),
            Err(fault) => {
                let pointer = match fault {
                    ToolFault::Radius { .. } => "/tool_radius_mm",
                    ToolFault::CornerRadius { .. } => "/corner_radius_mm",
                };
                faults.push(|| Fault::new(pointer, fault.to_string()));
                None
            }
        }
    }
}

/// Reports an angle between passes that is out of range.
pub(super) fn check_pass_break(pointer: &str, pass_break_deg: f64, faults: &mut FaultList) {
    let [min, max] = CcParameters::PASS_BREAK_RANGE_DEG;
    faults.check_range(|| format!("{pointer}/pass_break_deg"), pass_break_deg, min, max);
}

/// Reports a feed limit that is out of range.
pub(super) fn check_max_feed(max_feed_mm_per_min: Option<f64>, faults: &mut FaultList) {
    if let Some(feed) = max_feed_mm_per_min {
        let max = CcParameters::MAX_FEED_MM_PER_MIN;
        faults.check_range(|| "/max_feed_mm_per_min".to_owned(), feed, 1e-6, max);
    }
}

/// What the compensation found and did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CcFindings {
    /// Dialect in which the text was read.
    pub dialect: Dialect,
    /// Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Source of the cutter contact.
    pub contact: Contact,
    /// Number of blocks in the upload.
    pub blocks_in: u64,
    /// Number of blocks in the answer.
    pub blocks_out: u64,
    /// Number of inserted blocks.
    pub blocks_inserted: u64,
    /// Number of blocks that only got the source's F word back, after divided blocks.
    #[serde(default)]
    pub feeds_restored: u64,
    /// Number of motions whose deviation was computed.
    pub motions_checked: u64,
    /// Number of checked motions that exceeded the tolerance.
    pub motions_over_tolerance: u64,
    /// Number of motions over the tolerance that were not divided; a warning gives the reason.
    #[serde(default)]
    pub motions_left_over: u64,
    /// Deviation of the upload.
    pub before: DeviationSummary,
    /// Deviation of the answer, computed from its own text.
    pub after: DeviationSummary,
    /// Sum of the chords of the checked motions.
    pub cc_path_length_mm: f64,
    /// Singular regions; null if it was not possible to look for them.
    #[serde(default)]
    pub singularity: Option<SingularityFindings>,
    /// Deviation along the path.
    pub series: DeviationSeries,
    /// Warnings to the caller.
    pub warnings: Vec<Warning>,
}

/// The report of a compensation of the CC path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CcReport {
    /// The data that the result was computed from.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Inputs that were resolved beside the parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Results.
    #[serde(flatten)]
    pub findings: CcFindings,
}
