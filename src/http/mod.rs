//! The HTTP skin: routes, extractors, problems. No arithmetic, no SQL.

mod access;
mod admission;
mod audit;
mod body;
mod calibrations;
pub mod caller;
mod conditional;
pub mod connections;
mod current_machine;
mod edge;
mod extract;
mod guard;
mod held_keys;
mod idempotency;
mod jobs;
mod keys;
mod kinematics;
mod machines;
mod negotiate;
pub mod observation;
mod openapi;
mod paging;
pub mod problem;
mod programs;
mod range;
mod rates;
mod refusals;
mod router;
mod service;
mod servo;
mod state;
mod wear;

pub use openapi::{document, operations};
pub use router::router;
pub use state::AppState;
