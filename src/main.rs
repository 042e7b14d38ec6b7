//! The `trunnion` binary: reads its settings, starts the service, drains it. Everything else is in the library.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use rustix::fs::Mode;
use trunnion::cli::{Cli, Command};

/// Blocks of memory from this length on come directly from the system, and return to it when they are freed
/// \[bytes\].
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const GIVEN_BACK_FROM_BYTES: libc::c_int = 1 << 20;

/// Sets this length in the C library's allocator. Otherwise the allocator raises it up to 32 MiB as blocks
/// are freed, and keeps shorter blocks: a process whose requests held at most 336 MiB used 582 MiB.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[expect(unsafe_code, reason = "no crate wraps this call")]
fn give_memory_back() {
    // SAFETY: it sets a number of the allocator, and there is no other thread yet.
    let _set = unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, GIVEN_BACK_FROM_BYTES) };
}

/// Other allocators give memory back by themselves.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn give_memory_back() {}

fn main() -> ExitCode {
    give_memory_back();
    let cli = Cli::parse();
    // Only the service's user can read what it and its commands write; a program that is written for a user
    // gets the permissions of an ordinary new file.
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
