//! Posting of cutter location data to a machine: parameters and report.

use serde::{Deserialize, Serialize};

use super::{
    Dialect, Fault, FaultList, Fixed, Interpolation, LocationErrors, ProgramUnit, Provenance, ResolvedInputs,
    RotaryWords, Statements, Warning,
};
use crate::description::ToSchema;
use crate::machine::Machine;
use crate::process::{PostForm, PostParameters, PostReport, ProgramSetup};
use crate::program;
use crate::units::Length;

/// Most digits after the decimal point.
const MAX_DECIMALS: u8 = 6;
/// Tolerances of arcs that are accepted (µm).
const ARC_TOLERANCE_RANGE_UM: [f64; 2] = [0.1, 1000.0];

/// How tools change in the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ToolChange {
    /// `T5 M6` and a new approach at each `LOADTL/`. The machine retracts by itself.
    M6,
}

/// The points under `CUTCOM/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CutcomPoints {
    /// Places of the cutter's centre.
    Centre,
}

/// Parameters of a posting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PostingParameters {
    /// Meaning of X Y Z in the program: tool tips under G43.4 with the tip's feed (`tcp`), or axis positions
    /// with inverse-time feed (`machine`).
    #[schema(default = "tcp")]
    pub interpolation: Interpolation,
    /// Unit of the lengths if the data state none. If it is absent, the machine's `program_unit` is used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<ProgramUnit>,
    /// Origin of the workpiece in machine coordinates at zero pose. Zero is a valid answer; the member is
    /// needed if words depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = json!([0.0, 0.0, 0.0]))]
    pub work_offset_mm: Option<Fixed<3>>,
    /// Length of the tool; it matters only for head axes. Zero is a valid answer. If it is absent, the
    /// machine's tool table is used.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub tool_length_mm: Option<f64>,
    /// Number of the tool. If it is absent, it is the tool that the data load.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = 12)]
    pub tool_number: Option<u32>,
    /// Whether measured errors of the machine are applied.
    pub location_errors: LocationErrors,
    /// Rotary words before the first point, one query parameter for each: `start.A`, `start.C`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<RotaryWords>,
    /// H of G43.4 (`machine`: of G43, only with this or `tool_change`). If absent, the length register or the
    /// number of the tool, else 1 with a warning.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 9999, example = 12)]
    pub length_offset_number: Option<u32>,
    /// How tools change. If it is absent, the program has one tool and no change.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_change: Option<ToolChange>,
    /// What the points under `CUTCOM/` are. If it is absent, they are refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cutcom: Option<CutcomPoints>,
    /// Digits after the decimal point of X Y Z.
    #[schema(default = 4, minimum = 1, maximum = 6)]
    pub linear_decimals: u8,
    /// Digits after the decimal point of the rotary words.
    #[schema(default = 4, minimum = 1, maximum = 6)]
    pub rotary_decimals: u8,
    /// Largest distance between an arc and the lines that replace it.
    #[schema(default = 5.0)]
    pub arc_tolerance_um: f64,
    /// Dialect of the upload: cutter location data, so `auto` or `apt`.
    pub dialect: Dialect,
}

impl Default for PostingParameters {
    fn default() -> Self {
        let core = PostParameters::new(ProgramSetup::default());
        Self {
            interpolation: Interpolation::Tcp,
            unit: None,
            work_offset_mm: None,
            tool_length_mm: None,
            tool_number: None,
            location_errors: LocationErrors::default(),
            start: None,
            length_offset_number: core.length_number,
            tool_change: None,
            cutcom: None,
            linear_decimals: core.linear_decimals,
            rotary_decimals: core.rotary_decimals,
            arc_tolerance_um: core.arc_tolerance.um(),
            dialect: Dialect::default(),
        }
    }
}

impl PostingParameters {
    /// What the request states about the data.
    #[must_use]
    pub fn statements(&self) -> Statements<'_> {
        Statements {
            interpolation: None,
            unit: self.unit,
            work_offset_mm: self.work_offset_mm,
            work_offsets_mm: None,
            radius_offsets_mm: None,
            tool_length_mm: self.tool_length_mm,
            tool_number: self.tool_number,
            start: None,
            feed_mm_per_min: None,
            dialect: self.dialect,
        }
    }

    /// The parameters in the core's terms, without the set-up of the program.
    ///
    /// # Errors
    /// Every bad value, with its pointer.
    pub fn to_core(&self, machine: &Machine) -> Result<PostParameters, Vec<Fault>> {
        let mut faults = FaultList::default();
        for (name, decimals) in
            [("linear_decimals", self.linear_decimals), ("rotary_decimals", self.rotary_decimals)]
        {
            faults.check_range(|| format!("/{name}"), f64::from(decimals), 1.0, f64::from(MAX_DECIMALS));
        }
        let [min, max] = ARC_TOLERANCE_RANGE_UM;
        faults.check_range(|| "/arc_tolerance_um".to_owned(), self.arc_tolerance_um, min, max);
        if let Some(number) = self.length_offset_number {
            let at = || "/length_offset_number".to_owned();
            let numbers = PostParameters::LENGTH_NUMBERS;
            faults.check_range(at, f64::from(number), f64::from(*numbers.start()), f64::from(*numbers.end()));
        }
        if self.tool_length_mm.is_some_and(|length_mm| length_mm < 0.0) {
            faults.push(|| {
                Fault::new(
                    "/tool_length_mm",
                    "a tool length is not negative; give the distance from gauge point to tip",
                )
            });
        }
        if !matches!(self.dialect, Dialect::Auto | Dialect::Apt) {
            faults
                .push(|| Fault::new("/dialect", "only cutter location data can be posted; use auto or apt"));
        }
        self.statements().check(&mut faults);
        let start_words_deg = self.start.map(|start| start.in_profile_order(machine, "/start", &mut faults));
        for (axis, word) in machine.rotary_axes().iter().zip(start_words_deg.into_iter().flatten()) {
            if let Some(travel) = axis.travel_deg {
                let at = || format!("/start/{}", axis.letter.as_char());
                faults.check_range(at, word, travel.min, travel.max);
            }
        }
        faults.into_result()?;
        Ok(PostParameters {
            form: match self.interpolation {
                Interpolation::Tcp => PostForm::Tcp,
                Interpolation::Machine => PostForm::Machine,
            },
            length_number: self.length_offset_number,
            changes_tools: self.tool_change.is_some(),
            start_words_deg,
            linear_decimals: self.linear_decimals,
            rotary_decimals: self.rotary_decimals,
            arc_tolerance: Length::from_um(self.arc_tolerance_um),
            ..PostParameters::new(ProgramSetup::default())
        })
    }

    /// The set-up of the program, with what the request states of its points.
    #[must_use]
    pub fn with_points(&self, program: ProgramSetup) -> ProgramSetup {
        ProgramSetup { cutcom_at_centre: self.cutcom.is_some(), ..program }
    }
}

/// The written program, read back as a control reads it and put through the forward kinematics: largest
/// distances from the points of the source.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostingReadBack {
    /// Distance of a tool tip.
    pub max_tip_um: f64,
    /// Angle of a tool axis.
    pub max_axis_urad: f64,
}

/// Deviations between two points, which posting cannot correct: the largest values half way between them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostingBetweenPoints {
    /// Angle of the tool axis from the great circle.
    pub max_axis_urad: f64,
    /// Line of the upload with this angle.
    pub max_axis_line: Option<u64>,
    /// Distance of the tip from the straight line; 0 with `tcp`, because the control keeps the tip on it.
    pub max_tip_um: f64,
    /// Line of the upload with this distance.
    pub max_tip_line: Option<u64>,
}

/// Result of posting cutter location data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostingFindings {
    /// Dialect in which the upload was read.
    pub dialect: Dialect,
    /// Dialect of the program.
    pub output_dialect: Dialect,
    /// Meaning of X Y Z in the program.
    pub interpolation: Interpolation,
    /// Digits after the decimal point of X Y Z.
    pub linear_decimals: u8,
    /// Digits after the decimal point of the rotary words.
    pub rotary_decimals: u8,
    /// Number of blocks in the upload.
    pub blocks_in: u64,
    /// Number of blocks in the program.
    pub blocks_out: u64,
    /// Number of points in the program.
    pub points: u64,
    /// Number of arcs that became lines.
    pub arcs: u64,
    /// Post-processor statements that became comments in the program.
    pub comments: u64,
    /// Post-processor statements that became words of the program: stops, dwells, spindle, coolant.
    pub post_words: u64,
    /// Stretches of points over which the rotary solutions were chosen; each choice looks at least 1024
    /// points ahead.
    pub windows: u64,
    /// Points at which a rotary axis turns by more than 120°.
    pub rewinds: u64,
    /// Points inside the cone around the pole, where the rotary axis next to the workpiece was held.
    pub pole_holds: u64,
    /// Result of reading the program back.
    pub read_back: PostingReadBack,
    /// Deviations between the points.
    pub between_points: PostingBetweenPoints,
    /// Warnings to the caller.
    pub warnings: Vec<Warning>,
}

impl PostingFindings {
    /// The findings of a report of the core.
    #[must_use]
    pub fn of(parameters: &PostingParameters, core: &PostReport) -> Self {
        Self {
            dialect: program::Dialect::Apt.into(),
            output_dialect: program::Dialect::Iso.into(),
            interpolation: parameters.interpolation,
            linear_decimals: parameters.linear_decimals,
            rotary_decimals: parameters.rotary_decimals,
            blocks_in: core.blocks_in,
            blocks_out: core.blocks_out,
            points: core.points,
            arcs: core.arcs,
            comments: core.notes,
            post_words: core.words,
            windows: core.windows,
            rewinds: core.rewinds,
            pole_holds: core.pole_holds,
            read_back: PostingReadBack {
                max_tip_um: Length::from_mm(core.largest_tip_error_mm).um(),
                max_axis_urad: core.largest_axis_error.urad(),
            },
            between_points: PostingBetweenPoints {
                max_axis_urad: core.largest_axis_swing.urad(),
                max_axis_line: core.axis_swing_line,
                max_tip_um: Length::from_mm(core.largest_tip_swing_mm).um(),
                max_tip_line: core.tip_swing_line,
            },
            warnings: warnings(core, parameters.rotary_decimals),
        }
    }
}

fn warnings(core: &PostReport, rotary_decimals: u8) -> Vec<Warning> {
    // A program with an upright tool is held at the pole all the time, and has no error from it.
    let missed = core.largest_axis_error.deg() > 10_f64.powi(-i32::from(rotary_decimals));
    let comments = if core.tool_changes > 0 {
        "post-processor statements became comments"
    } else {
        "post-processor statements became comments; add tool changes yourself before and after the program"
    };
    [
        ("post_words_as_comments", comments, core.notes, None),
        (
            "post_words_not_done",
            "a statement that asks the machine for an action became a comment, because its form is not understood",
            core.not_done,
            core.first_not_done_line,
        ),
        (
            "cutcom_left_out",
            "CUTCOM statements became comments: the program follows the points as the path of the cutter's centre, and the control does not compensate for a radius",
            core.cutcoms,
            core.first_cutcom_line,
        ),
        (
            "length_offset_assumed",
            "G43.4 has H1, because the number of the tool length is not stated: give length_offset_number or tool_number",
            u64::from(core.length_number_is_assumed),
            None,
        ),
        (
            "length_left_out",
            "no G43 in the program: give length_offset_number, or switch the length on before",
            u64::from(core.length_is_left_out),
            None,
        ),
        (
            "tool_change_after_cut",
            "the tool changes after a cut: end each tool's data with a retract",
            core.changes_after_cut,
            core.first_change_after_cut_line,
        ),
        (
            "end_after_cut",
            "the program ends after a cut: end the data with a retract",
            u64::from(core.cut_at_end_line.is_some()),
            core.cut_at_end_line,
        ),
        (
            "text_after_end",
            "blocks after the program's end are not posted",
            core.blocks_after_end,
            core.end_line,
        ),
        (
            "rewind",
            "a rotary axis turns by more than 120° on the way to a point",
            core.rewinds,
            core.first_rewind_line,
        ),
        (
            "pole_hold",
            "inside the cone around the pole the rotary axis next to the workpiece is held, and the tool axis misses its direction",
            if missed { core.pole_holds } else { 0 },
            None,
        ),
    ]
    .into_iter()
    .filter(|(_, _, count, _)| *count > 0)
    .map(|(kind, detail, count, line)| Warning {
        kind: kind.to_owned(),
        detail: detail.to_owned(),
        count,
        line,
        worst_line: None,
        max_distance_um: None,
        min_time_ms: None,
    })
    .collect()
}

/// The report of a posting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PostingReport {
    /// The data that the result was computed from.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Inputs that were resolved beside the parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Results.
    #[serde(flatten)]
    pub findings: PostingFindings,
}
