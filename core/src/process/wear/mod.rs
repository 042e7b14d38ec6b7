//! A whole program for a worn cutter: every block's end is moved so that the contact stays, written, read back.
//! Blocks are never divided. Tool axis and rotary words never change, but where the program is posted anew for the machine
//! as it is: then every end keeps its tool pose in W, and rotary words change with the rest.

mod assumption;
mod contact;
mod course;
mod feed;
mod move_program;
mod parameters;
mod points;
mod posting;
mod report;
mod run;
mod verify;
mod worn_tool;
mod written;

pub use assumption::Assumption;
pub(super) use move_program::{Moved, move_program};
pub use move_program::{compensate_wear, compensate_wear_side_by_side};
pub(super) use parameters::Moves;
pub use parameters::{LengthInControl, Milling, WearParameters, WornCutter};
pub use report::{CurvatureAcross, WearReport};
