//! The only way of a program through a writing step: read in stretches, worked on, written, read back, handed over.

mod chain;
mod deviation;
mod drive;
mod emit;
mod feed_at_risk;
mod feed_in_time;
mod kept_motion;
mod motion_change;
mod outgoing;
mod read_back;
pub(in crate::process) mod record;
mod resources;
mod rewriter;
mod series;
mod surveyed;

pub use deviation::DeviationSummary;
pub use motion_change::{ErrorShares, MotionChange, MotionError};
pub use series::{Bucket, Buckets, Series, SeriesPoint};

pub(in crate::process) use chain::{Step, StepDone, reported, run_chain, to_upload};
pub(in crate::process) use deviation::DeviationTotals;
pub(in crate::process) use drive::{Hands, Look, Note, Prepare, StepCheck, StepRun, StepWork, Upstream};
pub(in crate::process) use emit::{Emitter, SAME_WORD, differs, exact_decimals, form, in_units};
pub(in crate::process) use feed_in_time::{
    FEED_TIMES, FeedInTime, MIN_FEED, TIME_ROUNDING, feed_in_time, rounded_feed,
};
pub(in crate::process) use kept_motion::{
    ARITHMETIC_MM, KeptMotion, LINEAR_ROUNDING, SAME_READ_BACK, same_words,
};
pub(in crate::process) use outgoing::{Copied, Outgoing};
pub(in crate::process) use read_back::{BeforeAfter, Expected, MachineWord, ReadBack, failed};
pub(in crate::process) use resources::Resources;
pub(in crate::process) use rewriter::{Placed, Rewriter};
pub(in crate::process) use surveyed::{Asked, Surveyed};
