//! A whole program through the drives of its machine: the effect of servo lag on the part.

mod parameters;
mod run;
mod sampler;

pub use parameters::SimulationParameters;
pub use run::{ProgramSimulation, simulate};

pub(in crate::process) use run::simulate_lines;
