//! What a program means on one machine: motions with start, end, feed and source line, under the modal state of a
//! control whose every value may be unknown.
//!
//! A program starts in G90 G21 G94 G17 with no position known. What cannot be followed is said to be so and left
//! alone; nothing is guessed.

mod codes;
#[cfg(test)]
#[expect(
    clippy::float_cmp,
    clippy::items_after_statements,
    reason = "values as they stand in the text, exact"
)]
#[path = "conversational/tests.rs"]
mod conversational_tests;
mod execute;
mod feed;
mod feed_rules;
mod interpreter;
mod modal;
mod motions;
mod offsets;
mod position;
mod sections;
mod sinumerik;
mod statements;
#[cfg(test)]
#[expect(
    clippy::float_cmp,
    clippy::items_after_statements,
    reason = "values as they stand in the text, exact"
)]
#[path = "states/tests.rs"]
mod states_tests;
#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as they stand in the text, exact")]
mod tests;
mod tool_axis;
mod tool_length;
mod travel;
mod unfollowable;
mod words;

pub use feed::{Feed, FeedMode};
pub use feed_rules::{FeedForm, FeedPath, FeedPaths, FeedRules};
pub use interpreter::{Interpreter, InterpreterOptions};
pub use motions::{ArcCourse, Interpolation, Motion, MotionKind};
pub use unfollowable::{ModalGroup, Unfollowable};
pub use words::{AxisWords, ContactWords, Decimals, Extra};
