//! The effect of a worn or reground cutter on the part, and its compensation: scallop height between passes, the
//! shift of the tip that keeps the contact, and the remaining error.

mod advice;
mod cutter_wear;
mod effective_radius;
mod end_milling;
mod history;
mod pass;
mod plausible;
mod scallop;
mod scallop_fault;
mod side_milling;
mod stated_contact;
mod surface;
mod tip_shift;
mod virtual_cutting;
mod wear_table;

pub use advice::{Advice, Outlook, WearAdvice, WearQuestion, advise};
pub use cutter_wear::CutterWear;
pub use effective_radius::{LEAD_RANGE_DEG, LeadFault, cutter_radius, effective_radius};
pub use end_milling::{end_milling_shift, uncompensated_excess_mm};
pub use history::{
    CourseBasis, CourseFault, CutterLife, LEAST_PLACES, LifeEnds, LifeKind, STAGE_RATES, STAGES_PER_SPAN,
    STANDSTILL_OF_AGE, STANDSTILLS, WearAhead, WearCourse, WearRate, WearReading, cutter_life, wear_ahead,
};
pub use pass::{CutterPass, PassFault};
pub use plausible::{FALL_OF_WEAR, FALL_UM, MOST_WEAR_OF_RADIUS, has_fallen, most_wear};
pub use scallop::{largest_stepover, scallop_height, smallest_tool_radius};
pub use scallop_fault::{ScallopFault, ScallopQuantity};
pub use side_milling::side_milling_shift;
pub use stated_contact::{StatedShift, StatedSide, end_milling_shift_at, side_milling_shift_at, stated_side};
pub use surface::Surface;
pub use tip_shift::{FlatContact, ShiftFault, TipShift};
pub use virtual_cutting::{CutCounts, CutLeave, NeedleBed, Residual, SweepBatch};
pub use wear_table::{WearTable, WearTableFault};
