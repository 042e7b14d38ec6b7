//! A whole program through the drives of its machine: the effect of servo lag on the part.

mod run;
mod sampler;

pub use run::{ProgramSimulation, SimulationParameters, simulate};

pub(in crate::process) use run::{LeftOuts, simulate_lines};
