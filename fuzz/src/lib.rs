//! What has to hold of the core for every input.

pub use trunnion_core::program;

pub mod checks;
