//! The command line.

mod arguments;
mod backup;
mod beside;
mod compensate;
mod doctor;
mod fault;
mod health;
mod keys;
mod log_fields;
mod log_lines;
mod logs;
mod migrate;
#[cfg(feature = "otlp")]
mod otlp;
mod rights;
mod serve;
mod settings;
mod tls;
mod webhooks;

pub use arguments::{Cli, Command, run};
pub use compensate::CompensateArguments;
pub use fault::CommandFault;
pub use keys::{KeysCommand, KeysFault};
pub use serve::{Guarding, Running, StartFault, start};
pub use settings::ConfigCommand;
pub use tls::TlsFault;
pub use webhooks::{WebhooksCommand, WebhooksFault};
