//! The core of Trunnion: a pure, synchronous, unit-safe model of a five-axis machine tool and of the programs it runs.
//!
//! No HTTP, no SQL, no clock, no files, no threads of its own: the crate has no dependency that could bring them,
//! and `tests/architecture/` checks it. Modules are in reading order; `docs/architecture.md` is the map.

#![forbid(unsafe_code)]

pub mod units;

mod listed;

pub mod geometry;

pub mod machine;

pub mod kinematics;

pub mod program;

pub mod surface;

pub mod motion;

pub mod contact;

pub mod side_by_side;

pub mod wear;

pub mod servo;

pub mod calibration;

pub mod process;

pub mod plot;
