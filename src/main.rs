//! The `trunnion` binary: reads its settings, starts the service, drains it. Everything else is in the library.

#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use trunnion::cli::Cli;

fn main() -> ExitCode {
    match trunnion::cli::run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _nobody_reads = writeln!(std::io::stderr(), "trunnion: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
