//! The one way of a program through a step that writes: read in stretches, worked on, written, read back, handed over.

mod drive;
mod emit;
mod line_map;
mod outgoing;
mod rewriter;

pub(super) use drive::{Check, Course, Hands, Look, Note, Prepare, Step, Upstream};
pub(super) use emit::{exact_decimals, in_units, letter, node_contact, rounded_feed};
pub(super) use line_map::{LineCursor, LineMap};
pub(super) use outgoing::{Copied, Outgoing};
pub(super) use rewriter::{Placed, Rewriter};
