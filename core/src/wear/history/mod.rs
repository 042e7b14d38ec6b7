//! What measured wear says of the parts that are left: the course of one edge's readings, and the life of a cutter.

mod course;
mod filter;
mod life;
mod reading;
mod student;

pub use course::{WearCourse, WearRate};
pub use life::{CutterLife, LifeKind, cutter_life};
pub use reading::{CourseFault, LEAST_PLACES, WearReading};
