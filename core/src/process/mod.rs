//! The places where program, contact and machine are joined: a whole program in, a whole program out, with a report.

mod arc_path;
mod compensate;
mod compensation;
mod contact_finder;
mod dialect_fit;
mod fault;
mod feed_at_risk;
mod glance;
mod interpretation;
mod inventory;
mod judge;
mod numbering;
mod parameters;
mod pipeline;
mod plain_lines;
mod plan;
mod post;
mod prepare;
mod program_setup;
mod read_back;
mod reading;
mod report;
mod sampler;
mod series;
mod set_ups;
mod simulate;
mod singularity;
mod stream;
mod survey;
mod tool_vectors;
mod tools;
mod unknown_axes;
mod untouched;
mod verification;
mod verify;
mod warnings;
mod wear;

pub use arc_path::UnknownArc;
pub use compensate::{compensate, compensate_side_by_side};
pub use compensation::{
    BlockBudget, BlockChange, BlockError, BudgetLine, CcStep, ChangePoint, ChangeSeries, ChangeSink,
    ChangeTotals, CompensationParameters, CompensationReport, ErrorBudget, ErrorShares, LocationErrorReport,
    MemorySpool, NotModelled, NotModelledKind, Place, ServoStep, Spool, WearStep, compensate_program,
};
pub use fault::{Fault, LineFault, LineFaultKind, LineFaults, Unstated};
pub use interpretation::{
    Interpretation, Interpreted, InterpretedArc, InterpretedKind, InterpretedMotion, interpret_program,
};
pub use parameters::{Budget, CcParameters, ContactSource, OutputForm};
pub use post::{NotPosted, PostForm, PostParameters, PostReport, post};
pub use program_setup::{ProgramSetup, StartPosition};
pub use reading::{OffsetUse, ProgramReading, ToolUse};
pub use report::{CcReport, DeviationSummary, Warning, WarningKind};
pub use series::{Series, SeriesPoint};
pub use simulate::{LeftOut, LeftOutReason, ProgramSimulation, SimulationParameters, simulate};
pub use singularity::{
    LeftReason, RegionFigures, RegionTreatment, RegionsLeft, SingularRegion, SingularityAction,
    SingularityParameters, SingularityReport, treat_and_compensate, treat_singular_regions,
};
pub use stream::{ProgramSource, Stop};
pub use tools::{CutterDifference, EnteredWear, ListedTool, ToolTable, ToolUnknown, Tools, UnfitWear};
pub use unknown_axes::UnknownAxes;
pub use verification::{
    Convergence, Effort, Extreme, Histogram, MotionCounts, ResidualSummary, Verification, VerificationFault,
    VerificationParameters, VerificationQuantity, verify_part,
};
pub use wear::{
    Assumption, CurvatureAcross, LengthInControl, Milling, WearParameters, WearReport, WornCutter,
    compensate_wear, compensate_wear_side_by_side,
};
