//! The arguments of the command line.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Parser, Subcommand};
use clap_complete::Shell;

use super::refusal::warn;
use super::{
    CompensateArguments, ConfigCommand, KeysCommand, StartFault, WebhooksCommand, backup, compensate, demo,
    doctor, health, keys, manual, migrate, serve, settings, webhooks,
};
use crate::config::{DatabaseAddress, Flags, Settings, unknown_variables};
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
#[derive(Debug, Clone, PartialEq, Subcommand)]
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
    /// Update the database to the newest schema, without serving; or move it to a server
    Migrate {
        /// Move the data directory to this empty database on a server of PostgreSQL; with --files postgres its files too
        #[arg(long, value_name = "ADDRESS")]
        to: Option<DatabaseAddress>,
    },
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
    /// Load example programs, a calibration history and a wear history into an empty data directory
    Demo,
    /// Print a script that completes commands and flags in a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    Man {
        /// Directory for the pages of all commands, instead of one page on standard output
        #[arg(long, value_name = "DIRECTORY")]
        all_into: Option<PathBuf>,
    },
}

/// Runs the command to its end.
///
/// # Errors
/// Unusable settings, or a service that could not start.
pub fn run(cli: &Cli) -> Result<(), StartFault> {
    let told = || unknown_variables(variables());
    let loaded = || Settings::load(&cli.flags, cli.config.as_ref());
    let settings = || {
        told()?.iter().for_each(|warning| warn(warning));
        loaded()
    };
    match cli.command.as_ref().unwrap_or(&Command::Serve) {
        Command::Serve => {
            let warnings = told()?;
            serve::until_stopped(loaded()?, cli.config.as_deref(), &warnings)
        }
        // A container asks every few seconds: a warning each time would hide the answer.
        Command::Healthcheck => {
            told()?;
            health::check(&loaded()?)
        }
        Command::Keys(command) => keys::run(&settings()?, command),
        Command::Webhooks(command) => webhooks::run(&settings()?, *command),
        Command::Migrate { to: None } => Ok(migrate::run(&settings()?)?),
        Command::Migrate { to: Some(address) } => {
            told()?.iter().for_each(|warning| warn(warning));
            let flags = Flags { database: Some(Some(address.clone())), ..cli.flags.clone() };
            Ok(migrate::to_server(&Settings::load(&flags, cli.config.as_ref())?, address)?)
        }
        Command::Backup { target } => Ok(backup::back_up(&settings()?, target)?),
        Command::Restore { backup } => Ok(backup::restore(&settings()?, backup)?),
        Command::Doctor { quick, deep, audit_head } => {
            let depth = Depth { files: !quick, rows: *deep, known_head: audit_head.clone() };
            Ok(doctor::run(&settings()?, cli.config.as_deref(), &depth)?)
        }
        Command::Config(ConfigCommand::Show) => {
            settings()?;
            Ok(settings::show(&cli.flags, cli.config.as_ref())?)
        }
        Command::Compensate(arguments) => Ok(compensate::run(&settings()?, arguments)?),
        Command::Demo => demo::run(settings()?),
        // These need no settings: a packager has none.
        Command::Openapi => Ok(settings::describe_interface()?),
        Command::Completions { shell } => Ok(manual::complete(*shell)?),
        Command::Man { all_into } => Ok(manual::manual(all_into.as_deref())?),
    }
}

/// The environment, as far as it is text.
fn variables() -> impl Iterator<Item = (String, String)> {
    let text = |(name, value): (OsString, OsString)| {
        Some((name.into_string().ok()?, value.to_string_lossy().into_owned()))
    };
    std::env::vars_os().filter_map(text)
}
