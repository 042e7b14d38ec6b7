//! The report of a compensation in one pass, and the table of its changes.

use std::io::Write;

use serde::{Deserialize, Serialize};

use super::{
    CcFindings, Dialect, Interpolation, Provenance, ResolvedInputs, SingularityFindings, Warning,
    WearFindings,
};
use crate::description::ToSchema;
use crate::motion::MotionKind;
use crate::process;
use crate::units::{Angle, Length};

fn um(mm: f64) -> f64 {
    Length::from_mm(mm).um()
}

fn urad(rad: f64) -> f64 {
    Angle::from_rad(rad).urad()
}

/// Result of posting the program again for the calibrated machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LocationErrorFindings {
    /// Whether the machine has any location error or squareness error; without one, nothing is moved.
    pub machine_has_errors: bool,
    /// Motions whose end was computed again.
    pub motions_posted: u64,
    /// Posted motions whose rotary words changed.
    pub motions_turned: u64,
    /// Largest distance between the tool tip on the calibrated machine and on the nominal machine.
    pub max_tip_um: f64,
    /// Line of the upload with this distance.
    pub max_tip_line: Option<u64>,
    /// Largest angle between the tool axes on the two machines.
    pub max_axis_urad: f64,
    /// Line of the upload with this angle.
    pub max_axis_line: Option<u64>,
    /// Largest change of a rotary word; near the pole it is far larger than the errors themselves.
    pub max_turn_deg: f64,
    /// Line of the upload with this change.
    pub max_turn_line: Option<u64>,
    /// Largest angle that remains between the written tool axis and the upload's: from rounding, and near the
    /// pole.
    pub max_axis_left_urad: f64,
    /// Line of the upload with this angle.
    pub max_axis_left_line: Option<u64>,
    /// Motions that end inside the cone around the pole, where the axis next to the workpiece keeps its
    /// correction.
    pub held_at_pole: u64,
}

impl From<&process::LocationErrorReport> for LocationErrorFindings {
    fn from(core: &process::LocationErrorReport) -> Self {
        Self {
            machine_has_errors: core.has_errors,
            motions_posted: core.motions_posted,
            motions_turned: core.motions_turned,
            max_tip_um: core.max_tip.um(),
            max_tip_line: core.max_tip_line,
            max_axis_urad: core.max_axis.urad(),
            max_axis_line: core.max_axis_line,
            max_turn_deg: core.max_turn.deg(),
            max_turn_line: core.max_turn_line,
            max_axis_left_urad: core.max_axis_left.urad(),
            max_axis_left_line: core.max_axis_left_line,
            held_at_pole: core.held_at_pole,
        }
    }
}

/// Changes that each step made to one motion of the upload.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MotionChange)]
pub struct BlockChangeDoc {
    /// Line of the upload.
    pub line: u64,
    /// Distance by which the end of the motion was moved for the location errors.
    pub location_errors_um: f64,
    /// Angle by which the tool axis at the end was turned for the location errors.
    pub tool_axis_urad: f64,
    /// Distance by which the end was moved for the worn cutter.
    pub wear_um: f64,
    /// Largest correction between the ends of the motion.
    pub cc_um: f64,
    /// Number of blocks that the motion became.
    pub blocks_out: u32,
}

impl From<&process::MotionChange> for BlockChangeDoc {
    fn from(core: &process::MotionChange) -> Self {
        Self {
            line: core.line,
            location_errors_um: um(core.location_errors_mm),
            tool_axis_urad: urad(core.axis_rad),
            wear_um: um(core.wear_mm),
            cc_um: um(core.cc_mm),
            blocks_out: core.blocks_out,
        }
    }
}

/// Changes along the program, down-sampled. Each point holds the largest values of the motions that it
/// represents. All arrays have the same length.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ChangeSeries)]
pub struct ChangeSeriesDoc {
    /// Line of the upload with the largest sum.
    pub line: Vec<u64>,
    /// Largest move for location errors.
    pub location_errors_um: Vec<f64>,
    /// Largest move for the worn cutter.
    pub wear_um: Vec<f64>,
    /// Largest correction between the ends of a motion.
    pub cc_um: Vec<f64>,
    /// Largest sum of one motion's errors as programmed.
    pub error_before_um: Vec<f64>,
    /// Largest sum of one motion's errors as written.
    pub error_after_um: Vec<f64>,
}

/// Changes that the steps made to the blocks. The job's table of changes has every motion.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Changes)]
pub struct ChangesDoc {
    /// SHA-256 of the table of changes.
    pub changes_sha256: String,
    /// Number of motions that any step changed.
    pub motions_changed: u64,
    /// Motions with the largest sum of changes, largest first.
    pub worst: Vec<BlockChangeDoc>,
    /// All changes, down-sampled.
    pub series: ChangeSeriesDoc,
}

impl ChangesDoc {
    /// The core's totals, with the digest of the table.
    #[must_use]
    pub fn of(changes_sha256: String, core: &process::ChangeTotals) -> Self {
        let points = core.series.points();
        Self {
            changes_sha256,
            motions_changed: core.motions_changed,
            worst: core.worst.iter().map(Into::into).collect(),
            series: ChangeSeriesDoc {
                line: points.iter().map(|point| point.line).collect(),
                location_errors_um: points.iter().map(|point| um(point.location_errors_mm)).collect(),
                wear_um: points.iter().map(|point| um(point.wear_mm)).collect(),
                cc_um: points.iter().map(|point| um(point.cc_mm)).collect(),
                error_before_um: points.iter().map(|point| um(point.error_before_mm)).collect(),
                error_after_um: points.iter().map(|point| um(point.error_after_mm)).collect(),
            },
        }
    }
}

/// One source of error over the whole program: its largest value as programmed and as written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = BudgetLine)]
pub struct BudgetLineDoc {
    /// Largest value as programmed.
    pub before_um: f64,
    /// Line of the upload with this value.
    pub before_line: Option<u64>,
    /// Largest value as written.
    pub after_um: f64,
    /// Line of the upload with this value.
    pub after_line: Option<u64>,
}

impl From<&process::BudgetLine> for BudgetLineDoc {
    fn from(core: &process::BudgetLine) -> Self {
        Self {
            before_um: um(core.before_mm),
            before_line: core.before_line,
            after_um: um(core.after_mm),
            after_line: core.after_line,
        }
    }
}

/// Errors of one motion, by source.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = MotionError)]
pub struct BlockErrorDoc {
    /// Largest deviation of the contact from its line between the ends.
    pub interpolation_um: f64,
    /// Distance at the end between the contact and its place on the nominal machine.
    pub location_errors_um: f64,
    /// Distance between the contact of the worn cutter and that of the nominal cutter.
    pub wear_um: f64,
    /// Error from the decimals of the written words.
    pub rounding_um: f64,
    /// Largest distance of the tip from its path, caused by the drives.
    pub servo_um: f64,
    /// Sum of all errors, as if all pointed in the same direction.
    pub sum_um: f64,
    /// Angle between the tool axis and the intended one.
    pub tool_axis_urad: f64,
}

impl BlockErrorDoc {
    fn of(shares: &process::ErrorShares, axis_rad: f64) -> Self {
        Self {
            interpolation_um: um(shares.interpolation_mm),
            location_errors_um: um(shares.location_errors_mm),
            wear_um: um(shares.wear_mm),
            rounding_um: um(shares.rounding_mm),
            servo_um: um(shares.servo_mm),
            sum_um: um(shares.sum_mm()),
            tool_axis_urad: urad(axis_rad),
        }
    }
}

/// One of the worst blocks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = BlockBudget)]
pub struct BlockBudgetDoc {
    /// Line of the upload.
    pub line: u64,
    /// Errors as programmed.
    pub before: BlockErrorDoc,
    /// Errors as written.
    pub after: BlockErrorDoc,
}

impl From<&process::BlockBudget> for BlockBudgetDoc {
    fn from(core: &process::BlockBudget) -> Self {
        let error = &core.error;
        Self {
            line: core.line,
            before: BlockErrorDoc::of(&error.before, error.axis_before_rad),
            after: BlockErrorDoc::of(&error.after, error.axis_after_rad),
        }
    }
}

/// An effect that the budget does not contain.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = NotModelled)]
pub struct NotModelledDoc {
    /// A stable word for the effect.
    #[schema(example = "thermal")]
    pub kind: String,
    /// The effect in words.
    pub detail: String,
    /// Number of motions, if the effect belongs to some motions.
    pub count: Option<u64>,
    /// First line of the upload, if the effect belongs to some motions.
    pub line: Option<u64>,
}

impl From<&process::NotModelled> for NotModelledDoc {
    fn from(core: &process::NotModelled) -> Self {
        Self {
            kind: core.kind.name().to_owned(),
            detail: core.kind.text().to_owned(),
            count: core.count,
            line: core.first_line,
        }
    }
}

/// Contribution of each source to the error, as programmed and as written.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ErrorBudget)]
pub struct ErrorBudgetDoc {
    /// Error of the contact between the ends of blocks.
    pub interpolation: BudgetLineDoc,
    /// Error from location errors at the ends of blocks.
    pub location_errors: BudgetLineDoc,
    /// Error from the worn cutter at the ends of blocks.
    pub wear: BudgetLineDoc,
    /// Error from the decimals of the written words.
    pub rounding: BudgetLineDoc,
    /// Error from the drives, on the written program.
    pub servo: BudgetLineDoc,
    /// The largest sum of one block.
    pub sum: BudgetLineDoc,
    /// Largest angle between the tool axis and the intended one, as programmed.
    pub tool_axis_before_urad: f64,
    /// Largest angle between the tool axis and the intended one, as written.
    pub tool_axis_after_urad: f64,
    /// Blocks with the largest sum as written, largest first.
    pub worst: Vec<BlockBudgetDoc>,
    /// Effects that the budget does not contain.
    pub not_modelled: Vec<NotModelledDoc>,
}

impl From<&process::ErrorBudget> for ErrorBudgetDoc {
    fn from(core: &process::ErrorBudget) -> Self {
        Self {
            interpolation: (&core.interpolation).into(),
            location_errors: (&core.location_errors).into(),
            wear: (&core.wear).into(),
            rounding: (&core.rounding).into(),
            servo: (&core.servo).into(),
            sum: (&core.sum).into(),
            tool_axis_before_urad: urad(core.axis_before_rad),
            tool_axis_after_urad: urad(core.axis_after_rad),
            worst: core.worst.iter().map(Into::into).collect(),
            not_modelled: core.not_modelled.iter().map(Into::into).collect(),
        }
    }
}

/// Results of a compensation in one pass. All lines are lines of the upload.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CompensationFindings {
    /// Dialect of the program text.
    pub dialect: Dialect,
    /// Interpolation that was assumed: `tcp` if the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// Number of blocks in the upload.
    pub blocks_in: u64,
    /// Number of blocks in the answer.
    pub blocks_out: u64,
    /// Number of inserted blocks.
    pub blocks_inserted: u64,
    /// Singular regions; null if it was not possible to look for them.
    pub singularity: Option<SingularityFindings>,
    /// Result of the step for location errors; null if it was not requested.
    pub location_errors: Option<LocationErrorFindings>,
    /// Result of the step for the worn cutter; null if it was not requested.
    pub wear: Option<WearFindings>,
    /// Result of the step for the cutter-contact path; null if it was not requested.
    pub cc: Option<CcFindings>,
    /// Changes that the steps made to the blocks.
    pub changes: ChangesDoc,
    /// Contribution of each source to the error.
    pub error_budget: ErrorBudgetDoc,
    /// Warnings of the steps that move ends; the step `cc` has its own warnings.
    pub warnings: Vec<Warning>,
}

/// The report of a compensation in one pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CompensationReport {
    /// The data that the result was computed from.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Inputs that were resolved beside the parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Results.
    #[serde(flatten)]
    pub findings: CompensationFindings,
}

/// One row of the table of changes: a motion that any step changed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChangeRow {
    /// Line of the upload.
    pub line: u64,
    /// `rapid`, `linear`, `arc`, or `opaque` for a motion that the service does not follow.
    pub kind: &'static str,
    /// Distance by which the end of the motion was moved for the location errors.
    pub location_errors_um: f64,
    /// Angle by which the tool axis at the end was turned for the location errors.
    pub tool_axis_urad: f64,
    /// Distance by which the end was moved for the worn cutter.
    pub wear_um: f64,
    /// Largest correction between the ends of the motion.
    pub cc_um: f64,
    /// Number of blocks that the motion became.
    pub blocks_out: u32,
    /// Sum of the motion's errors as programmed.
    pub error_before_um: f64,
    /// Sum of the motion's errors as written.
    pub error_after_um: f64,
}

impl From<&process::MotionChange> for ChangeRow {
    fn from(core: &process::MotionChange) -> Self {
        Self {
            line: core.line,
            kind: match core.kind {
                MotionKind::Rapid => "rapid",
                MotionKind::Linear => "linear",
                MotionKind::Arc => "arc",
                MotionKind::Opaque => "opaque",
            },
            location_errors_um: um(core.location_errors_mm),
            tool_axis_urad: urad(core.axis_rad),
            wear_um: um(core.wear_mm),
            cc_um: um(core.cc_mm),
            blocks_out: core.blocks_out,
            error_before_um: um(core.error.before.sum_mm()),
            error_after_um: um(core.error.after.sum_mm()),
        }
    }
}

/// Writes the table of changes row by row; a table without rows has a header too.
pub struct ChangeTable<W: Write>(csv::Writer<W>);

impl<W: Write> ChangeTable<W> {
    const COLUMNS: [&'static str; 9] = [
        "line",
        "kind",
        "location_errors_um",
        "tool_axis_urad",
        "wear_um",
        "cc_um",
        "blocks_out",
        "error_before_um",
        "error_after_um",
    ];

    /// A table with its header.
    ///
    /// # Errors
    /// The header cannot be written to the output.
    pub fn new(output: W) -> Result<Self, csv::Error> {
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(output);
        writer.write_record(Self::COLUMNS)?;
        Ok(Self(writer))
    }

    /// The output with all rows.
    ///
    /// # Errors
    /// The rows cannot be written to the output.
    pub fn into_inner(self) -> std::io::Result<W> {
        self.0
            .into_inner()
            .map_err(|fault| std::io::Error::new(fault.error().kind(), fault.error().to_string()))
    }
}

impl<W: Write> process::ChangeSink for ChangeTable<W> {
    fn changed(&mut self, change: &process::MotionChange) -> std::io::Result<()> {
        self.0.serialize(ChangeRow::from(change)).map_err(super::fault_of_table)
    }
}
