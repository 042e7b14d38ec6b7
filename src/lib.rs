//! Trunnion: a pure, synchronous, unit-safe model of a five-axis machine tool, with a thin HTTP skin on one side
//! and a thin `SQLite` skin on the other.
//!
//! The model is a crate of its own, `trunnion_core`; its modules are re-exported here beside the skins'
//! modules.
//! Modules in reading order. `docs/architecture.md` is the map; `tests/architecture/` holds its arrows.

#![forbid(unsafe_code)]

pub use trunnion_core::{
    calibration, contact, geometry, kinematics, machine, motion, plot, process, program, servo, side_by_side,
    surface, units, wear,
};

mod description;

pub mod wire;

pub mod config;

pub mod meter;

pub mod shares;

pub mod store;

pub mod jobs;

pub mod http;

pub mod cli;
