//! Writes a whole program for a worn cutter, for location errors, or for both. Every block's end is moved so that the
//! contact stays, and the result is read back. Blocks are never divided. Tool axis and rotary words never change,
//! unless the program is computed anew for the machine as it is. Then every end keeps its tool pose in W, and rotary
//! words change with the rest.

mod assumption;
mod check;
mod contact;
mod end_contact;
mod feed;
mod moved;
mod moves;
mod parameters;
mod pilot;
mod points;
mod recalibration;
mod report;
mod step;
mod work;
mod worn_tool;
mod written;

pub use assumption::Assumption;
pub use parameters::{LengthInControl, Milling, WearParameters, WornCutter};
pub use report::{CurvatureAcross, WearReport};
pub use step::{compensate_wear, compensate_wear_side_by_side};

pub(in crate::process) use moved::Moved;
pub(in crate::process) use moves::Moves;
pub(in crate::process) use step::MoveStep;
