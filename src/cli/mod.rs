//! The command line.

mod arguments;
mod backup;
mod compensate;
mod doctor;
mod fault;
mod health;
mod logs;
mod migrate;
mod serve;
mod settings;

pub use arguments::{Cli, Command, run};
pub use compensate::CompensateArguments;
pub use fault::CommandFault;
pub use serve::{Running, StartFault, start};
pub use settings::ConfigCommand;
