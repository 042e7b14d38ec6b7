//! The command line.

mod arguments;
mod backup;
mod beside;
mod command_line;
mod compensate;
mod demo;
mod doctor;
mod fault;
mod health;
mod keys;
mod log_fields;
mod log_lines;
mod log_text;
mod logs;
mod manual;
mod migrate;
#[cfg(feature = "otlp")]
mod otlp;
mod refusal;
mod rights;
mod serve;
mod settings;
mod tls;
mod webhooks;

pub use arguments::{Cli, Command, run};
pub use command_line::{command, parsed};
pub use compensate::CompensateArguments;
pub use demo::DemoFault;
pub use fault::CommandFault;
pub use keys::{KeysCommand, KeysFault};
pub use refusal::{tell, tell_of_arguments};
pub use serve::{Guarding, Running, StartFault, start};
pub use settings::ConfigCommand;
pub use tls::TlsFault;
pub use webhooks::{WebhooksCommand, WebhooksFault};
