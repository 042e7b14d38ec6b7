//! A whole program for a worn cutter: every block's end is moved so that the contact stays, written, read back.
//! Blocks are never divided; tool axis and rotary words never change.

mod contact;
mod course;
mod feed;
mod parameters;
mod points;
mod report;
mod run;
mod verify;
mod written;

pub use parameters::{LengthInControl, Milling, WearParameters, WornCutter};
pub use report::{CurvatureAcross, WearReport};
pub use run::compensate_wear;
