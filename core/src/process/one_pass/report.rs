//! The report of a program compensated in one pass.

use super::changes::ChangeTotals;
use super::error_budget::ErrorBudget;
use crate::motion::Interpolation;
use crate::process::contact_path::CcReport;
use crate::process::fault::Warning;
use crate::process::move_ends::WearReport;
use crate::process::singular::SingularityReport;
use crate::process::text::ProgramReading;
use crate::program::{Dialect, Steps};
use crate::units::{Angle, Length};

/// The effect of computing the program anew for the calibrated machine.
#[derive(Debug, Clone, PartialEq)]
pub struct LocationErrorReport {
    /// Whether the machine has any error. Without errors nothing moves.
    pub has_errors: bool,
    /// Motions whose ends were posted again.
    pub motions_posted: u64,
    /// Motions whose rotary words changed.
    pub motions_turned: u64,
    /// Largest distance between a tip on the machine with its errors and the same tip on the nominal machine.
    pub max_tip: Length,
    /// Its line of the upload.
    pub max_tip_line: Option<u64>,
    /// Largest angle between the two tool axes.
    pub max_axis: Angle,
    /// Its line of the upload.
    pub max_axis_line: Option<u64>,
    /// Largest change of a rotary word. Near the pole it is far larger than the errors themselves.
    pub max_turn: Angle,
    /// Its line of the upload.
    pub max_turn_line: Option<u64>,
    /// Largest angle between the written tool axis and the upload's: from rounding, and from the pole.
    pub max_axis_left: Angle,
    /// Its line of the upload.
    pub max_axis_left_line: Option<u64>,
    /// Motions that end inside the pole cone, where the axis next to the workpiece keeps its correction.
    pub held_at_pole: u64,
}

/// The result of a compensation in one pass. All lines are lines of the upload.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// Interpolation mode: TCP if the program switches it on or the parameter asks for it.
    pub interpolation: Interpolation,
    /// The steps that changed something.
    pub steps: Steps,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written.
    pub blocks_out: u64,
    /// Report on singular regions, if they were searched.
    pub singularity: Option<SingularityReport>,
    /// Report of the step that moves ends for location errors, if asked for.
    pub location_errors: Option<LocationErrorReport>,
    /// Report of the step for the worn cutter, if asked for. Its words are those before the `cc` step.
    pub wear: Option<WearReport>,
    /// Report of the step for the cutter-contact path, if asked for.
    pub cc: Option<CcReport>,
    /// What the steps did to the blocks.
    pub changes: ChangeTotals,
    /// The errors before and after.
    pub budget: ErrorBudget,
    /// Warnings of the steps that move ends. The `cc` report has its own.
    pub warnings: Vec<Warning>,
}
