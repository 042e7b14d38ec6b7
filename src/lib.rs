//! Trunnion: a pure, synchronous, unit-safe model of a five-axis machine tool, with a thin HTTP skin on one side
//! and a thin `SQLite` skin on the other.
//!
//! Modules in reading order. `docs/architecture.md` is the map; `tests/architecture.rs` holds its arrows.

pub mod contact;
pub mod geometry;
pub mod kinematics;
pub mod machine;
pub mod motion;
pub mod plot;
pub mod process;
pub mod program;
pub mod units;
