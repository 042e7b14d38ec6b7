//! Parameters and report of the compensation of the CC path.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::statements::program_parameters;
use super::{Fault, FaultList, ResolvedInputs, StampForm, SurfaceReading};
use super::{SingularRegions, SingularityAction, SingularityFindings};
use crate::machine::{Tool, ToolFault};
use crate::units::Length;
use crate::{motion, process, program};

/// Where the cutter contact comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Contact {
    /// The first available of program, normals and surface, else the tip.
    #[default]
    Auto,
    /// U V W words of the program.
    Program,
    /// Contact normals nx ny nz.
    Normals,
    /// A surface.
    Surface,
    /// Assumed from the feed, where rotary axes turn.
    FeedPlane,
    /// The tool tip itself.
    Tip,
}

/// What the control interpolates linearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The axis words.
    Machine,
    /// The tool tip in the workpiece, with tool centre point control on.
    Tcp,
}

impl Interpolation {
    /// In the core's terms.
    #[must_use]
    pub const fn to_core(self) -> motion::Interpolation {
        match self {
            Self::Machine => motion::Interpolation::Machine,
            Self::Tcp => motion::Interpolation::Tcp,
        }
    }
}

/// How a deviating block is corrected.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Back onto the line, at the same share of it: no residual, and the contact keeps its speed.
    #[default]
    Even,
    /// Back onto the line by the shortest way: no residual, but the contact's speed runs wild.
    Foot,
    /// As first published: the tip moves away from its own foot on the line. Leaves a residual; for comparison.
    Seed,
}

/// Which blocks the answer has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Output {
    /// As few as the tolerance allows.
    #[default]
    Minimal,
    /// One at every interpolation period of a block over tolerance; needs a feed.
    Interpolated,
}

/// The form of the program text.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dialect {
    /// Found from the text.
    #[default]
    Auto,
    /// ISO G-code.
    Iso,
    /// Siemens.
    Siemens,
    /// Heidenhain.
    Heidenhain,
    /// APT CL data.
    Apt,
    /// Columns separated by commas.
    Csv,
    /// Okuma OSP for machining centres.
    Okuma,
}

impl From<motion::Interpolation> for Interpolation {
    fn from(core: motion::Interpolation) -> Self {
        match core {
            motion::Interpolation::Machine => Self::Machine,
            motion::Interpolation::Tcp => Self::Tcp,
        }
    }
}

impl From<program::Dialect> for Dialect {
    fn from(core: program::Dialect) -> Self {
        match core {
            program::Dialect::Iso => Self::Iso,
            program::Dialect::Siemens => Self::Siemens,
            program::Dialect::Heidenhain => Self::Heidenhain,
            program::Dialect::Apt => Self::Apt,
            program::Dialect::Csv => Self::Csv,
            program::Dialect::Okuma => Self::Okuma,
        }
    }
}

impl Dialect {
    /// In the core's terms; none is found from the text.
    #[must_use]
    pub fn to_core(self) -> Option<program::Dialect> {
        match self {
            Self::Auto => None,
            Self::Iso => Some(program::Dialect::Iso),
            Self::Siemens => Some(program::Dialect::Siemens),
            Self::Heidenhain => Some(program::Dialect::Heidenhain),
            Self::Apt => Some(program::Dialect::Apt),
            Self::Csv => Some(program::Dialect::Csv),
            Self::Okuma => Some(program::Dialect::Okuma),
        }
    }
}

program_parameters! {
/// What the compensation of the CC path needs to know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CcParameters {
    /// Cutter radius R; that of the machine's tool table when absent. Only `contact=tip` can do without either.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 5.0)]
    pub tool_radius_mm: Option<f64>,
    /// Corner radius r; as the cutter radius (a ball) when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<f64>,
    /// Largest distance of the CC path from its line.
    #[serde(default = "CcParameters::default_tolerance_um")]
    #[schema(default = 10.0)]
    pub tolerance_um: f64,
    /// Where the cutter contact comes from.
    #[serde(default)]
    pub contact: Contact,
    /// Millimetres of one unit of the uploaded surface: 25.4 for inches; 1 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_unit_mm: Option<f64>,
    /// How far facets of the uploaded surface may stand off the smooth one that they stand for; 10 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chordal_tolerance_um: Option<f64>,
    /// A cutter touches the uploaded surface where it is no farther above or inside its facets; 100 unless said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_gap_um: Option<f64>,
    /// Where the feed turns by more than this, an assumed contact (`feed-plane`) belongs to another pass.
    #[serde(default = "CcParameters::default_pass_break_deg")]
    #[schema(default = 15.0)]
    pub pass_break_deg: f64,
    /// How a deviating block is corrected.
    #[serde(default)]
    pub correction: Correction,
    /// Which blocks the answer has.
    #[serde(default)]
    pub output: Output,
    /// The fastest F that is written: a block whose parts would need more stays as it is. The machine's `max_feed_mm_per_min`
    /// when absent, and where that is not stated ten times the programmed feed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 12_000.0)]
    pub max_feed_mm_per_min: Option<f64>,
    /// Whether a program that leaves changed says so in a comment.
    #[serde(default)]
    #[schema(default = "comment")]
    pub stamp: StampForm,
    /// Do the steps `cc` and `singularity` again to a program that bears their stamp. Steps that move ends are never repeated.
    #[serde(default)]
    #[schema(default = false)]
    pub allow_repeated: bool,
    /// What is done about singular regions, before everything else.
    #[serde(default)]
    pub singularity: SingularityAction,
    /// How they are found and treated, one parameter for each: `singular_regions.axis_tolerance_deg`.
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
            singularity: SingularityAction::default(),
            singular_regions: SingularRegions::default(),
            interpolation: None,
            unit: None,
            work_offset_mm: None,
            work_offsets_mm: None,
            tool_length_mm: None,
            tool_number: None,
            start: None,
            feed_mm_per_min: None,
            dialect: Dialect::default(),
        }
    }
}

impl CcParameters {
    /// The tolerance where none is stated (µm).
    #[must_use]
    pub const fn default_tolerance_um() -> f64 {
        10.0
    }

    /// The angle by which passes are told apart where none is stated (deg).
    #[must_use]
    pub const fn default_pass_break_deg() -> f64 {
        process::CcParameters::PASS_BREAK_DEG
    }

    /// Smallest and largest angle by which passes are told apart (deg).
    pub const PASS_BREAK_RANGE_DEG: [f64; 2] = [0.1, 180.0];
    /// Smallest and largest tolerance (µm).
    pub const TOLERANCE_RANGE_UM: [f64; 2] = [0.01, 10_000.0];
    /// Largest feed taken for real [mm/min].
    pub const MAX_FEED_MM_PER_MIN: f64 = 1e6;
    /// Largest offset or tool length taken for real (mm).
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

    /// The tool, if one is stated; `has_part` says whether the part's surface came with the program. Whether it has to be shows
    /// with the machine's tool table and the program.
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
                let detail = "missing: a corner radius needs the radius that it belongs to";
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

/// Collects a bad angle by which passes are told apart.
pub(super) fn check_pass_break(pointer: &str, pass_break_deg: f64, faults: &mut FaultList) {
    let [min, max] = CcParameters::PASS_BREAK_RANGE_DEG;
    faults.check_range(|| format!("{pointer}/pass_break_deg"), pass_break_deg, min, max);
}

/// Collects a bad limit of written feeds.
pub(super) fn check_max_feed(max_feed_mm_per_min: Option<f64>, faults: &mut FaultList) {
    if let Some(feed) = max_feed_mm_per_min {
        let max = CcParameters::MAX_FEED_MM_PER_MIN;
        faults.check_range(|| "/max_feed_mm_per_min".to_owned(), feed, 1e-6, max);
    }
}

/// Deviation of the CC path over all checked motions.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DeviationSummary {
    /// Largest distance from the line.
    pub max_um: f64,
    /// Root of the mean square along the path.
    pub rms_um: f64,
    /// Largest distance on the side of too much material.
    pub max_excess_um: f64,
    /// Largest distance on the side of too little material.
    pub max_gouge_um: f64,
    /// Line of the upload with the largest distance; null where nothing was checked.
    pub worst_line: Option<u64>,
}

/// Deviation along the path, down-sampled; all of one length.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DeviationSeries {
    /// Path length up to the sample.
    pub path_mm: Vec<f64>,
    /// Line of the upload.
    pub line: Vec<u64>,
    /// Distance before.
    pub before_um: Vec<f64>,
    /// Distance after, from the text that was written.
    pub after_um: Vec<f64>,
}

/// Something the caller should know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Warning {
    /// A stable word for the kind of warning.
    #[schema(example = "contact_off_tool")]
    pub kind: String,
    /// What it means.
    pub detail: String,
    /// How many motions or points it stands for.
    pub count: u64,
    /// First line of the upload it stands for, 1-based.
    pub line: Option<u64>,
    /// Line with the largest distance, where a distance belongs to the warning.
    pub worst_line: Option<u64>,
    /// Largest distance, where one belongs to the warning.
    pub max_distance_um: Option<f64>,
    /// Shortest time, where one belongs to the warning.
    #[serde(default)]
    pub min_time_ms: Option<f64>,
}

impl Warning {
    /// One of the program as a whole.
    #[must_use]
    pub fn plain(kind: &str, detail: &str) -> Self {
        Self {
            kind: kind.to_owned(),
            detail: detail.to_owned(),
            count: 1,
            line: None,
            worst_line: None,
            max_distance_um: None,
            min_time_ms: None,
        }
    }
}

impl From<&process::Warning> for Warning {
    fn from(core: &process::Warning) -> Self {
        let text = core.kind.text();
        Self {
            kind: core.kind.name().to_owned(),
            detail: core.reason.map_or_else(|| text.to_owned(), |reason| format!("{text}: {reason}")),
            count: core.count,
            line: core.line,
            worst_line: core.worst_line,
            max_distance_um: core.max_distance_mm.map(|distance_mm| Length::from_mm(distance_mm).um()),
            min_time_ms: core.min_time_s.map(|time_s| time_s * MS_PER_S),
        }
    }
}

/// Milliseconds in a second.
const MS_PER_S: f64 = 1000.0;

/// What a result was computed from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Provenance {
    /// Revision of the machine it was computed on.
    pub machine_revision: i64,
    /// Version of the service.
    pub software_version: String,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// SHA-256 of the answer.
    pub output_sha256: String,
    /// The steps that changed the program; null where an older version did not say so.
    #[serde(default)]
    #[schema(example = json!(["cc"]))]
    pub steps: Option<Vec<StepName>>,
}

/// A step of a compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StepName {
    /// Ends of motions were moved for a worn cutter.
    Wear,
    /// They were moved for the machine as it is.
    LocationErrors,
    /// The cutter-contact path between the ends was corrected.
    Cc,
    /// Singular regions were treated.
    Singularity,
}

impl StepName {
    /// The names of steps.
    #[must_use]
    pub fn all_of(steps: program::Steps) -> Vec<Self> {
        steps.iter().map(Self::of).collect()
    }

    const fn of(step: program::Step) -> Self {
        match step {
            program::Step::Wear => Self::Wear,
            program::Step::LocationErrors => Self::LocationErrors,
            program::Step::Cc => Self::Cc,
            program::Step::Singularity => Self::Singularity,
        }
    }
}

/// What the compensation found and did.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CcFindings {
    /// Form the text was read in.
    pub dialect: Dialect,
    /// What the control was taken to interpolate: `tcp` where the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Where the cutter contact came from.
    pub contact: Contact,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks of the answer.
    pub blocks_out: u64,
    /// Blocks that are new.
    pub blocks_inserted: u64,
    /// Blocks that only got the source's F word back, behind divided ones.
    #[serde(default)]
    pub feeds_restored: u64,
    /// Motions whose deviation was found.
    pub motions_checked: u64,
    /// Those of them that exceeded the tolerance.
    pub motions_over_tolerance: u64,
    /// Those that still do: a warning says why.
    #[serde(default)]
    pub motions_left_over: u64,
    /// The upload's deviation.
    pub before: DeviationSummary,
    /// The answer's deviation, from its own text.
    pub after: DeviationSummary,
    /// Chords of the checked motions, summed.
    pub cc_path_length_mm: f64,
    /// Singular regions; null where they could not be looked for.
    #[serde(default)]
    pub singularity: Option<SingularityFindings>,
    /// Deviation along the path.
    pub series: DeviationSeries,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
}

/// The report of a compensation of the CC path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CcReport {
    /// What it was computed from.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// What it rests on beside its parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// What was found and done.
    #[serde(flatten)]
    pub findings: CcFindings,
}
