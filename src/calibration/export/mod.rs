//! Calibrated axes as text for a control, from sources that anyone can read.
//!
//! [`neutral`]: ISO 230-7 symbols, cascaded values and lines, complete and at full precision. Read back, the text gives
//! the axes it was made from (`tests/oracles/control_export.rs`).

mod absolute;
mod neutral;
mod text;

pub use absolute::{AbsoluteError, absolute_errors};
pub use neutral::neutral;
