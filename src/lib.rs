//! Trunnion: a pure, synchronous, unit-safe model of a five-axis machine tool, with a thin HTTP skin on one side
//! and a thin `SQLite` skin on the other.
//!
//! Modules in reading order. `docs/architecture.md` is the map; `tests/architecture.rs` holds its arrows.

pub mod units;

pub mod geometry;

pub mod machine;

pub mod kinematics;

pub mod program;

pub mod surface;

pub mod motion;

pub mod contact;

pub mod wear;

pub mod servo;

pub mod calibration;

pub mod process;

pub mod plot;

pub mod wire;

pub mod config;

pub mod store;

pub mod jobs;

pub mod http;

pub mod cli;
