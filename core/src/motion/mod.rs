//! The meaning of a program on one machine: motions with start, end, feed and source line, under the modal state of a
//! control. Every value of that state may be unknown.
//!
//! A program starts in G90 G94 G17. Its unit, its work offsets and its axis positions are known if the text or the
//! caller states them. A motion that cannot be followed is reported and left unchanged. Nothing is guessed.

mod block_words;
mod compensation;
mod conflicts;
#[cfg(test)]
#[path = "words/tests.rs"]
mod contact_word_tests;
#[cfg(test)]
#[expect(clippy::float_cmp, clippy::items_after_statements, reason = "values as the text has them, exact")]
#[path = "conversational/tests.rs"]
mod conversational_tests;
mod course;
mod cycle;
mod dialect;
mod drilling;
mod execute;
mod feed;
mod feed_rules;
#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as the text has them, exact")]
#[path = "feed/tests.rs"]
mod feed_tests;
mod feed_words;
mod g_codes;
mod hole_cycle;
mod interpreter;
mod m_codes;
mod machine_axes;
mod machine_place;
mod meaning;
mod modal;
mod motion_shell;
mod motions;
mod offsets;
#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as the text has them, exact")]
#[path = "offsets/tests.rs"]
mod offsets_tests;
mod plane;
mod point_arc;
mod point_cycle;
mod position;
mod radius;
mod radius_offsets;
mod reference;
mod repetition;
mod sections;
mod sinumerik;
mod spindle;
mod start_modes;
mod statements;
#[cfg(test)]
#[expect(clippy::float_cmp, clippy::items_after_statements, reason = "values as the text has them, exact")]
#[path = "states/tests.rs"]
mod states_tests;
#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values as the text has them, exact")]
mod tests;
mod tilted_plane;
mod tool_axis;
mod tool_length;
mod tool_lengths;
mod travel;
mod unfollowable;
mod unit;
mod words;
mod work_offset;
mod written_zeros;
mod zeros;

pub use feed::{Feed, FeedMode};
pub use feed_rules::{FeedForm, FeedPath, FeedPaths, FeedRules};
pub use interpreter::{Interpreter, InterpreterOptions};
pub use machine_axes::rotary_addresses;
pub use meaning::BlockMotion;
pub use motions::{ArcCourse, Interpolation, Motion, MotionKind, RadiusCompensation};
pub use point_arc::{ROUNDED_ENDS, last_decimal_mm, off_circle_mm};
pub use radius::RadiusRule;
pub use radius_offsets::{RadiusOffsets, RadiusRegister};
pub(crate) use spindle::Spindle;
pub use spindle::{CalledTool, StatedCutter, ToolKey, ToolName};
pub use start_modes::{StartCodesFault, StartModes};
pub use tool_lengths::ToolLengths;
pub use unfollowable::{ModalGroup, Unfollowable};
pub use words::{AxisWords, ContactWords, Decimals, Extra};
pub use work_offset::{OffsetCode, WorkOffset, WorkOffsets};
