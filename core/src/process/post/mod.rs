//! Posting turns cutter location data into an ISO program for one machine, by inverse kinematics.

mod approach;
mod arc;
mod parameters;
mod points;
mod read_back;
mod report;
mod run;
mod statement;
mod tool;
mod write;

pub use parameters::{PostForm, PostParameters};
pub use report::PostReport;
pub use run::post;
