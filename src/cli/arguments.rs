//! The arguments of the command line.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use super::{
    CompensateArguments, ConfigCommand, KeysCommand, StartFault, WebhooksCommand, backup, compensate, doctor,
    health, keys, migrate, serve, settings, webhooks,
};
use crate::config::{Flags, Settings};
use crate::store::{AuditHead, Depth};

/// One HTTP service for five-axis machine tools.
#[derive(Debug, Parser)]
#[command(name = "trunnion", version, about)]
pub struct Cli {
    /// Command to run; without it, serve
    #[command(subcommand)]
    pub command: Option<Command>,
    /// TOML file with settings; their names are those of the long flags, with underscores
    #[arg(long, env = "TRUNNION_CONFIG", global = true)]
    pub config: Option<PathBuf>,
    /// Every setting.
    #[command(flatten)]
    pub flags: Flags,
}

/// The commands.
#[derive(Debug, Clone, PartialEq, Eq, Subcommand)]
pub enum Command {
    /// Run the service until it receives SIGTERM or SIGINT
    Serve,
    /// Ask the service at the listen address whether it is ready; for containers
    Healthcheck,
    /// Create, list and revoke API keys; works while the service runs
    #[command(subcommand)]
    Keys(KeysCommand),
    /// Show or rotate the secret that signs webhooks; works while the service runs
    #[command(subcommand)]
    Webhooks(WebhooksCommand),
    /// Update the database to the newest schema, without serving
    Migrate,
    /// Copy the data directory (database, files, manifest); works while the service runs
    Backup {
        /// Directory of the backup; it must not exist
        target: PathBuf,
    },
    /// Restore a backup into the data directory, which must be empty or missing
    Restore {
        /// Directory of the backup
        backup: PathBuf,
    },
    /// Check settings, data directory, database and files, and report faults
    Doctor {
        /// Do not read all files
        #[arg(long, conflicts_with_all = ["deep", "audit_head"])]
        quick: bool,
        /// Read every row too: digests, schema, audit log, keys
        #[arg(long)]
        deep: bool,
        /// A head of the audit log that was recorded elsewhere, to compare with; implies --deep
        #[arg(long, value_name = "SEQ:DIGEST")]
        audit_head: Option<AuditHead>,
    },
    /// Show the settings
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Print the description of the interface
    Openapi,
    /// Run an operation on one program, without a service and without a database
    Compensate(CompensateArguments),
}

/// Runs the command to its end.
///
/// # Errors
/// Unusable settings, or a service that could not start.
pub fn run(cli: &Cli) -> Result<(), StartFault> {
    let settings = Settings::load(&cli.flags, cli.config.as_ref())?;
    match &cli.command {
        None | Some(Command::Serve) => serve::until_stopped(settings, cli.config.as_deref()),
        Some(Command::Healthcheck) => health::check(&settings),
        Some(Command::Keys(command)) => keys::run(&settings, command),
        Some(Command::Webhooks(command)) => webhooks::run(&settings, *command),
        Some(Command::Migrate) => Ok(migrate::run(&settings)?),
        Some(Command::Backup { target }) => Ok(backup::back_up(&settings, target)?),
        Some(Command::Restore { backup }) => Ok(backup::restore(&settings, backup)?),
        Some(Command::Doctor { quick, deep, audit_head }) => {
            let depth = Depth { files: !quick, rows: *deep, known_head: audit_head.clone() };
            Ok(doctor::run(&settings, cli.config.as_deref(), &depth)?)
        }
        Some(Command::Config(ConfigCommand::Show)) => Ok(settings::show(&cli.flags, cli.config.as_ref())?),
        Some(Command::Openapi) => Ok(settings::describe_interface()?),
        Some(Command::Compensate(arguments)) => Ok(compensate::run(&settings, arguments)?),
    }
}
