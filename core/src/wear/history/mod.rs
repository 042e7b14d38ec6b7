//! The prediction from measured wear: the course of one edge's readings, its possible continuations, and the life
//! of a cutter.

mod ahead;
mod course;
mod filter;
mod life;
mod normal;
mod reading;

pub use ahead::{STAGE_RATES, STAGES_PER_SPAN, STANDSTILL_OF_AGE, STANDSTILLS, WearAhead, wear_ahead};
pub use course::{CourseBasis, WearCourse, WearRate};
pub use life::{CutterLife, LifeEnds, LifeKind, cutter_life};
pub use reading::{CourseFault, LEAST_PLACES, WearReading};
