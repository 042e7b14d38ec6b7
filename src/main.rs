//! The `trunnion` binary: reads its settings, starts the service, drains it. Everything else is in the library.

#![forbid(unsafe_code)]

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use rustix::fs::Mode;
use trunnion::cli::{Cli, Command};

#[global_allocator]
static MEMORY: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    let cli = Cli::parse();
    // What the service and its commands write is its user's alone; a program that is written for somebody has the rights of any new file.
    if !matches!(cli.command, Some(Command::Compensate(_))) {
        rustix::process::umask(Mode::RWXG | Mode::RWXO);
    }
    match trunnion::cli::run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _nobody_reads = writeln!(std::io::stderr(), "trunnion: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
