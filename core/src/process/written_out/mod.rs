//! Loops and calls of a program written out: one text whose blocks run one after the other.

mod check;
mod write;

pub use write::{WrittenOut, write_out};
