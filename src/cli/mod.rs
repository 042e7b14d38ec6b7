//! The command line.

mod arguments;
mod health;
mod logs;
#[cfg(feature = "otlp")]
mod otlp;
mod serve;

pub use arguments::{Cli, Command, run};
pub use serve::{Running, StartFault, start};
