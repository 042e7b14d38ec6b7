//! The report that goes with a program compensated in one pass.

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

/// What posting anew for the calibrated machine did.
#[derive(Debug, Clone, PartialEq)]
pub struct LocationErrorReport {
    /// Whether the machine has any error: without one nothing is moved.
    pub has_errors: bool,
    /// Motions whose end was posted anew.
    pub motions_posted: u64,
    /// Those whose rotary words changed.
    pub motions_turned: u64,
    /// Largest distance of a tip on the machine as it is from where the nominal machine would have it.
    pub max_tip: Length,
    /// Its line of the upload.
    pub max_tip_line: Option<u64>,
    /// Largest angle between the tool axes of the two.
    pub max_axis: Angle,
    /// Its line of the upload.
    pub max_axis_line: Option<u64>,
    /// Largest change of a rotary word; near the pole it is far larger than the errors themselves.
    pub max_turn: Angle,
    /// Its line of the upload.
    pub max_turn_line: Option<u64>,
    /// Largest angle between the written tool axis and that of the upload: rounding, and what the pole leaves.
    pub max_axis_left: Angle,
    /// Its line of the upload.
    pub max_axis_left_line: Option<u64>,
    /// Motions that end inside the pole cone, where the axis next to the workpiece keeps its correction.
    pub held_at_pole: u64,
}

/// Everything a compensation in one pass has to show for itself. All lines are lines of the upload.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// Who interpolates: with TCP where the program switches it on or the parameter says so.
    pub interpolation: Interpolation,
    /// The steps that changed something.
    pub steps: Steps,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written.
    pub blocks_out: u64,
    /// Of singular regions, where they were looked for.
    pub singularity: Option<SingularityReport>,
    /// Of the step that moves ends for location errors, where asked for.
    pub location_errors: Option<LocationErrorReport>,
    /// Of the step for the worn cutter, where asked for; its words are those of the program before the `cc` step.
    pub wear: Option<WearReport>,
    /// Of the step for the cutter-contact path, where asked for.
    pub cc: Option<CcReport>,
    /// What the steps did to the blocks.
    pub changes: ChangeTotals,
    /// What is wrong before and after.
    pub budget: ErrorBudget,
    /// What the caller should know of the steps that move ends; the `cc` report has its own.
    pub warnings: Vec<Warning>,
}
