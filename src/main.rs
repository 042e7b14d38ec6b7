//! The `trunnion` binary: reads its settings, starts the service, drains it. Everything else is in the library.

use std::process::ExitCode;

use rustix::fs::Mode;
use trunnion::cli::Command;

/// Tells the C library's allocator to give freed memory back to the system. By itself it keeps much of it.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[expect(unsafe_code, reason = "no crate wraps these two calls")]
mod allocator {
    use std::time::Duration;

    /// Blocks of memory from this length on come directly from the system, and return to it when they are freed
    /// \[bytes\].
    const GIVEN_BACK_FROM_BYTES: libc::c_int = 1 << 20;
    /// Time between two looks at the memory of the process.
    const EVERY: Duration = Duration::from_secs(10);
    /// Time until the service has started. Memory that only the start needed is then given back.
    const AFTER_START: Duration = Duration::from_secs(1);
    /// Below this memory of the process, shorter blocks are not given back: an idle service has a quarter of it
    /// \[bytes\].
    const KEPT_BELOW_BYTES: u64 = 128 << 20;

    /// Sets that length. Otherwise the allocator raises it up to 32 MiB as blocks are freed, and keeps shorter
    /// blocks: a process whose requests held at most 336 MiB used 582 MiB.
    pub(super) fn give_back_long_blocks() {
        // SAFETY: it sets a number of the allocator, and there is no other thread yet.
        let _set = unsafe { libc::mallopt(libc::M_MMAP_THRESHOLD, GIVEN_BACK_FROM_BYTES) };
    }

    /// Gives back what many short blocks leave: after a thousand connections at once, a process with 33 MiB at the
    /// start kept 292 MiB.
    pub(super) fn give_back_short_blocks() {
        let run = || {
            std::thread::sleep(AFTER_START);
            // SAFETY: it may be called from any thread, at any time.
            let _whether_any = unsafe { libc::malloc_trim(0) };
            loop {
                std::thread::sleep(EVERY);
                if trunnion::meter::resident_bytes().is_none_or(|bytes| bytes >= KEPT_BELOW_BYTES) {
                    // SAFETY: it may be called from any thread, at any time.
                    let _whether_any = unsafe { libc::malloc_trim(0) };
                }
            }
        };
        // Without this thread the service only keeps more memory.
        let _thread = std::thread::Builder::new().name("give-back".to_owned()).spawn(run);
    }
}

/// Other allocators give memory back by themselves.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod allocator {
    pub(super) fn give_back_long_blocks() {}
    pub(super) fn give_back_short_blocks() {}
}

fn main() -> ExitCode {
    allocator::give_back_long_blocks();
    let cli = match trunnion::cli::parsed() {
        Ok(cli) => cli,
        Err(fault) => return ExitCode::from(trunnion::cli::tell_of_arguments(&fault)),
    };
    if matches!(cli.command, None | Some(Command::Serve)) {
        allocator::give_back_short_blocks();
    }
    // Only the service's user can read what it and its commands write; a program that is written for a user
    // gets the permissions of an ordinary new file, and so do manual pages.
    if !matches!(cli.command, Some(Command::Compensate(_) | Command::Man { .. })) {
        rustix::process::umask(Mode::RWXG | Mode::RWXO);
    }
    match trunnion::cli::run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            trunnion::cli::tell(&cli, &error);
            ExitCode::from(error.exit_code())
        }
    }
}
