//! What a command says on standard error if it does not do its work. A service whose log is JSON says it as JSON too,
//! so that its first line already has the form of the others.

use std::ffi::OsString;
use std::fmt::Display;
use std::io::Write;

use serde_json::{Value, json};

use super::{Cli, Command, StartFault, command};
use crate::config::{LogFormat, Settings};
use crate::jobs::system_time;

/// Exit status for arguments that cannot be used.
const WRONG_ARGUMENTS: u8 = 2;

/// A warning of a command.
pub(super) fn warn(text: &str) {
    say(format_args!("trunnion: warning: {text}"));
}

/// Says why a command failed.
pub fn tell(cli: &Cli, fault: &StartFault) {
    let serves = matches!(cli.command, None | Some(Command::Serve));
    // If the settings themselves are at fault, the flag and the variable are all that is known.
    let settings = Settings::load(&cli.flags, cli.config.as_ref());
    let form = settings.map_or(cli.flags.log_format, |settings| Some(settings.log_format));
    if serves && form == Some(LogFormat::Json) {
        say(not_started(fault));
    } else {
        say(format_args!("trunnion: {fault}"));
    }
}

/// Says what is wrong with the arguments, or prints the help that they ask for; returns the exit status.
#[must_use]
pub fn tell_of_arguments(fault: &clap::Error) -> u8 {
    if !fault.use_stderr() {
        let _nobody_reads = fault.print();
        return 0;
    }
    if serves_with_json_log() {
        let text = fault.render().to_string();
        say(not_started(&text.trim_start_matches("error: ").lines().next().unwrap_or_default()));
    } else {
        let _nobody_reads = fault.print();
    }
    WRONG_ARGUMENTS
}

/// Whether the arguments and the environment, although they cannot be read as a whole, ask for a service with a log
/// of JSON.
fn serves_with_json_log() -> bool {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let whole = command();
    let mut others = whole.get_subcommands().map(clap::Command::get_name).filter(|name| *name != "serve");
    if others.any(|name| arguments.iter().any(|word| word == name)) {
        return false;
    }
    let is_typed =
        |pair: &[OsString]| matches!(pair, [flag, form] if flag == "--log-format" && form == "json");
    arguments.windows(2).any(is_typed)
        || arguments.iter().any(|word| word == "--log-format=json")
        || std::env::var_os("TRUNNION_LOG_FORMAT").is_some_and(|form| form == "json")
}

/// A line as the log has them.
pub(super) fn json_line(level: &str, fields: &Value) -> String {
    let timestamp = format!("{:.6}", system_time());
    json!({ "timestamp": timestamp, "level": level, "fields": fields, "target": "trunnion" }).to_string()
}

/// The line of a service that does not start.
fn not_started(fault: &dyn Display) -> String {
    json_line("ERROR", &json!({ "message": "the service cannot start", "error": fault.to_string() }))
}

fn say(line: impl Display) {
    let _nobody_reads = writeln!(std::io::stderr(), "{line}");
}
