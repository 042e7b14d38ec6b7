//! The command line.

mod arguments;
mod health;
mod logs;
mod serve;

pub use arguments::{Cli, Command, run};
pub use serve::{Running, StartFault, start};
