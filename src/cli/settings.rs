//! Prints the settings with their origins, and the description of the interface.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Subcommand;
use serde_json::Value;

use super::CommandFault;
use crate::config::{Flags, Origin, Settings};

/// Commands about the settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Subcommand)]
pub enum ConfigCommand {
    /// Show every setting in the form of a settings file, with its origin
    Show,
}

/// Parts of names whose values are never printed.
const SECRET: [&str; 3] = ["secret", "password", "token"];

/// Prints every setting as a line of a settings file.
pub(super) fn show(flags: &Flags, file: Option<&PathBuf>) -> Result<(), CommandFault> {
    let typed: Vec<String> = std::env::args().collect();
    for (name, value, origin) in Settings::with_origins(flags, file)? {
        let secret = SECRET.iter().any(|part| name.contains(part));
        let value = match &value {
            Value::Null => None,
            _ if secret => Some("\"(hidden)\"".to_owned()),
            value => Some(value.to_string()),
        };
        let line = value.map_or_else(|| format!("# {name} is not set"), |value| format!("{name} = {value}"));
        say(&format!("{line:<48} # {}", told(name, &origin, &typed)))?;
    }
    Ok(())
}

fn told(name: &str, origin: &Origin, typed: &[String]) -> String {
    match origin {
        Origin::Default => "default".to_owned(),
        Origin::File { path } => path.display().to_string(),
        Origin::FlagOrEnvironment { variable } => {
            let flag = format!("--{}", name.replace('_', "-"));
            let is_typed = typed.iter().any(|word| *word == flag || word.starts_with(&format!("{flag}=")));
            if is_typed { flag } else { format!("environment {variable}") }
        }
    }
}

/// Prints the description of the interface.
pub(super) fn describe_interface() -> Result<(), CommandFault> {
    put(&crate::http::description_text().map_err(CommandFault::Print)?).map_err(CommandFault::Print)
}

/// A line on standard output.
pub(super) fn say(line: &str) -> Result<(), CommandFault> {
    put(&format!("{line}\n")).map_err(CommandFault::Print)
}

/// Writes text to standard output and flushes it.
pub(super) fn put(text: &str) -> io::Result<()> {
    let mut output = io::stdout().lock();
    output.write_all(text.as_bytes()).and_then(|()| output.flush())
}
