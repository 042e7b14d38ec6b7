//! The command line.

mod arguments;
mod health;
mod keys;
mod logs;
#[cfg(feature = "otlp")]
mod otlp;
mod serve;
mod tls;

pub use arguments::{Cli, Command, run};
pub use keys::{KeysCommand, KeysFault};
pub use serve::{Guarding, Running, StartFault, start};
pub use tls::TlsFault;
