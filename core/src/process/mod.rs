//! Joins program, contact and machine. Steps read a whole program, write a whole program and report on it; the other
//! rooms answer one question about a program.

mod arc_path;
mod contact_path;
mod divided;
mod fault;
mod interpret;
mod move_ends;
mod one_pass;
mod pipeline;
mod post;
mod set_up;
mod simulate;
mod singular;
mod text;
mod virtual_cutting;
mod written_out;

pub use arc_path::UnknownArc;
pub use contact_path::{CcParameters, CcReport, OutputForm, compensate, compensate_side_by_side};
pub use fault::{
    CutterDifference, EnteredWear, Fault, LeftOut, LeftOutReason, LineFault, LineFaultKind, LineFaults,
    NotPosted, ToolUnknown, UnfitWear, UnknownAxes, Unstated, VerificationFault, VerificationQuantity,
    Warning, WarningKind,
};
pub use interpret::{
    Interpretation, Interpreted, InterpretedArc, InterpretedKind, InterpretedMotion, interpret_program,
};
pub use move_ends::{
    Assumption, CurvatureAcross, LengthInControl, Milling, WearParameters, WearReport, WornCutter,
    compensate_wear, compensate_wear_side_by_side,
};
pub use one_pass::{
    BlockBudget, BudgetLine, CcStep, ChangePoint, ChangeSeries, ChangeSink, ChangeTotals,
    CompensationParameters, CompensationReport, ErrorBudget, LocationErrorReport, NotModelled,
    NotModelledKind, ServoStep, WearStep, compensate_program, treat_and_compensate,
};
pub use pipeline::{
    Bucket, Buckets, DeviationSummary, ErrorShares, MotionChange, MotionError, Series, SeriesPoint,
};
pub use post::{PostForm, PostParameters, PostReport, post};
pub use set_up::{
    Budget, ContactSource, ListedTool, ProgramSetup, StartPosition, Stop, SurveyExtent, ToolTable, Tools,
};
pub use simulate::{ProgramSimulation, SimulationParameters, simulate};
pub use singular::{
    LeftReason, RegionFigures, RegionTreatment, RegionsLeft, SingularRegion, SingularityAction,
    SingularityParameters, SingularityReport, treat_singular_regions,
};
pub use text::{
    MemoryStepStore, OffsetUse, OpenSubprogram, Place, ProgramReading, ProgramSource, StepStore, ToolUse,
};
pub use virtual_cutting::{
    Convergence, Effort, Extreme, Histogram, MotionCounts, ResidualSummary, Verification,
    VerificationParameters, verify_part,
};
pub use written_out::{WrittenOut, write_out};
