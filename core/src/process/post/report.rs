//! What is reported of a posting.

use crate::process::text::ProgramReading;
use crate::units::Angle;

/// The result of a posting.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PostReport {
    /// How the data were read.
    pub reading: ProgramReading,
    /// Blocks of the source.
    pub blocks_in: u64,
    /// Blocks of the posted program.
    pub blocks_out: u64,
    /// Points of the posted program.
    pub points: u64,
    /// Arcs that became lines.
    pub arcs: u64,
    /// Statements for the post-processor that became comments.
    pub notes: u64,
    /// Statements for the post-processor that became words: M0 M1, G4, S M3 M4 M5, M7 M8 M9.
    pub words: u64,
    /// Comments that the machine should have acted on.
    pub not_done: u64,
    /// Line of the first of them.
    pub first_not_done_line: Option<u64>,
    /// Blocks after the end of the source, which are not posted.
    pub blocks_after_end: u64,
    /// Line of the end, if there is one.
    pub end_line: Option<u64>,
    /// Statements `CUTCOM/` that switch radius compensation on and are left out, because the points are those of the
    /// cutter's centre.
    pub cutcoms: u64,
    /// Line of the first of them.
    pub first_cutcom_line: Option<u64>,
    /// Tool changes directly after a cut.
    pub changes_after_cut: u64,
    /// Line of the first of them.
    pub first_change_after_cut_line: Option<u64>,
    /// Line of the last point, if the program ends after a cut.
    pub cut_at_end_line: Option<u64>,
    /// Tool changes of the posted program.
    pub tool_changes: u64,
    /// Number of windows of points. The path in each was chosen with knowledge of the next points only.
    pub windows: u64,
    /// H of the last G43.4 or G43, if the program has it.
    pub length_number: Option<u32>,
    /// The number is not stated, and the data name no tool by number.
    pub length_number_is_assumed: bool,
    /// The program switches no length on, for at least one tool.
    pub length_is_left_out: bool,
    /// Points at which a rotary axis turns by more than the threshold.
    pub rewinds: u64,
    /// Line of the first rewind.
    pub first_rewind_line: Option<u64>,
    /// Line of the first rewind at feed: the table turns back while the cutter is in the part.
    pub cutting_rewind_line: Option<u64>,
    /// Points inside the pole cone, at which the rotary axis next to the workpiece was held.
    pub pole_holds: u64,
    /// Largest distance between a tip read back and the source's tip \[mm\].
    pub largest_tip_error_mm: f64,
    /// Largest angle between a tool axis read back and the source's.
    pub largest_axis_error: Angle,
    /// Largest angle between the tool axis and the great circle half way between two points.
    pub largest_axis_swing: Angle,
    /// Line of that motion.
    pub axis_swing_line: Option<u64>,
    /// Largest distance of the tip from the straight line half way between two points \[mm\]. In machine
    /// coordinates only: under tool-centre-point control the control keeps the tip straight.
    pub largest_tip_swing_mm: f64,
    /// Line of that motion.
    pub tip_swing_line: Option<u64>,
}
