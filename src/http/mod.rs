//! The HTTP skin: routes, extractors, problems. No arithmetic, no SQL.

mod body;
mod calibrations;
mod conditional;
pub mod connections;
mod current_machine;
mod edge;
mod extract;
mod idempotency;
mod jobs;
mod kinematics;
mod machines;
mod negotiate;
mod openapi;
mod paging;
pub mod problem;
mod programs;
mod range;
mod refusals;
mod router;
mod service;
mod servo;
mod state;
mod wear;

pub use openapi::{document, operations};
pub use router::router;
pub use state::AppState;
