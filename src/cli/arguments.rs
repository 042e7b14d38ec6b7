//! What can be typed.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use super::{KeysCommand, StartFault, health, keys, serve};
use crate::config::{Flags, Settings};

/// One HTTP service for five-axis machine tools.
#[derive(Debug, Parser)]
#[command(name = "trunnion", version, about)]
pub struct Cli {
    /// What to do; without it, serve
    #[command(subcommand)]
    pub command: Option<Command>,
    /// TOML file with settings, named as the long flags with underscores
    #[arg(long, env = "TRUNNION_CONFIG", global = true)]
    pub config: Option<PathBuf>,
    /// Every setting.
    #[command(flatten)]
    pub flags: Flags,
}

/// The commands.
#[derive(Debug, Clone, PartialEq, Eq, Subcommand)]
pub enum Command {
    /// Run the service until it is told to stop
    Serve,
    /// Ask the service at the listen address whether it is ready; for containers
    Healthcheck,
    /// Make, list and revoke API keys, also while the service runs
    #[command(subcommand)]
    Keys(KeysCommand),
}

/// Does what the command line says, to its end.
///
/// # Errors
/// Settings that cannot be used, or a service that could not start.
pub fn run(cli: &Cli) -> Result<(), StartFault> {
    let settings = Settings::load(&cli.flags, cli.config.as_ref())?;
    match &cli.command {
        None | Some(Command::Serve) => serve::until_stopped(settings),
        Some(Command::Healthcheck) => health::check(&settings),
        Some(Command::Keys(command)) => keys::run(&settings, command),
    }
}
