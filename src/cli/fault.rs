//! Why a command failed.

use std::fmt::Write;
use std::path::PathBuf;

use thiserror::Error;

use super::DemoFault;
use crate::config::ConfigFault;
use crate::jobs::{CompensatorFault, ComputeFault, JobFault, ProgramFilesFault};
#[cfg(feature = "scale-out")]
use crate::store::MoveFault;
use crate::store::{BackupFault, BlobFault, LockFault, StoreError};
use crate::wire::{Fault, Unreadable};

/// Why a command failed.
#[derive(Debug, Error)]
pub enum CommandFault {
    /// The settings cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigFault),
    /// There is no backup, or nothing was restored.
    #[error(transparent)]
    Backup(#[from] BackupFault),
    /// The database cannot be used.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// The data directory was not moved to a server.
    #[cfg(feature = "scale-out")]
    #[error(transparent)]
    Move(#[from] MoveFault),
    /// The command is for a database that is a file.
    #[error(
        "trunnion {command} is for a database file and copied nothing; with database set, use {instead} (docs/scale-out.md)"
    )]
    OfTheServer {
        /// The command.
        command: &'static str,
        /// What to use.
        instead: &'static str,
    },
    /// A service has the data directory.
    #[error(transparent)]
    Lock(#[from] LockFault),
    /// The data directory has faults.
    #[error("{faults} of the checks failed; fix the faults listed above")]
    Unsound {
        /// How many checks failed.
        faults: usize,
    },
    /// A file cannot be read or written.
    #[error("while {doing} {}: {source}", path.display())]
    File {
        /// The action that failed.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// The working files cannot be used.
    #[error("the working files cannot be used: {0}")]
    Blobs(#[from] BlobFault),
    /// The files do not make one program.
    #[error(transparent)]
    Files(ProgramFilesFault),
    /// The machine's file is not a profile.
    #[error("the machine's profile is refused: {0}")]
    UnreadableMachine(Unreadable),
    /// The profile does not describe a five-axis machine.
    #[error("the machine's profile is refused:{}", listed(.0))]
    Machine(Vec<Fault>),
    /// A flag and the parameters state different values.
    #[error("{flag} is {typed}, but the parameters state the {name} {stated}: give only one of them")]
    TwoValues {
        /// The flag.
        flag: &'static str,
        /// The member of the parameters.
        name: &'static str,
        /// The value of the flag.
        typed: String,
        /// The value of the parameters.
        stated: String,
    },
    /// The operation has no member for the value of a flag.
    #[error("{flag} is no parameter of {operation}: leave it out, or state the value with --parameters")]
    NoSuchMember {
        /// The flag.
        flag: &'static str,
        /// The operation.
        operation: &'static str,
    },
    /// No preset has the name.
    #[error("there is no preset {given:?}; the presets are {known}")]
    NoPreset {
        /// The given name.
        given: String,
        /// Every name.
        known: String,
    },
    /// The operation makes no such result.
    #[error("{operation} makes no {what}: leave its file out")]
    NothingToWrite {
        /// The operation.
        operation: &'static str,
        /// The result that was to be written.
        what: &'static str,
    },
    /// The existing file is not a regular file: a device, a link or a folder is not replaced.
    #[error("{} is not a regular file and is not replaced; name another file", .0.display())]
    NoPlainFile(PathBuf),
    /// The existing file is write-protected.
    #[error("{} is write-protected and is not replaced; name another file, or allow writing to it", .0.display())]
    WriteProtected(PathBuf),
    /// Two results have the same place.
    #[error("{} is named for two results; give each its own file", .0.display())]
    SamePlace(PathBuf),
    /// A result would replace one of its inputs.
    #[error("{} is an input of this command and is not replaced; name another file", .0.display())]
    OwnInput(PathBuf),
    /// The example was not loaded.
    #[error(transparent)]
    Demo(DemoFault),
    /// The work has no result.
    #[error("{}", told(.0))]
    Work(JobFault),
    /// The command was stopped.
    #[error("stopped; nothing was written")]
    Stopped,
    /// A file exceeds its limit.
    #[error("{} is larger than the limit of {limit_bytes} bytes ({setting})", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its limit.
        limit_bytes: u64,
        /// The setting of the limit.
        setting: &'static str,
    },
    /// The output could not be printed.
    #[error("standard output cannot be written: {0}")]
    Print(std::io::Error),
    /// The process could not be set up.
    #[error("the process could not be set up: {0}")]
    Process(std::io::Error),
}

impl CommandFault {
    /// Exit status of the process: 1 if the command checked and refuses, 2 if it could not do its work.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Unsound { .. } | Self::UnreadableMachine(_) | Self::Machine(_) | Self::TooLarge { .. } => 1,
            Self::Work(fault) if is_refusal(fault) => 1,
            _ => 2,
        }
    }
}

/// Whether the program or its parameters are at fault.
fn is_refusal(fault: &JobFault) -> bool {
    match fault {
        JobFault::Unreadable(_)
        | JobFault::Parameters(_)
        | JobFault::TooCostly(_)
        | JobFault::Compute(ComputeFault::TooCostly { .. })
        | JobFault::Servo(_)
        | JobFault::PartSurface(_)
        | JobFault::Compensator(CompensatorFault::Refused(_)) => true,
        JobFault::Compensator(CompensatorFault::Io(fault)) => is_over_its_limit(fault),
        JobFault::Compensator(
            CompensatorFault::Cancelled
            | CompensatorFault::VerificationFailed { .. }
            | CompensatorFault::HeadMisled,
        )
        | JobFault::Compute(
            ComputeFault::Busy | ComputeFault::Memory(_) | ComputeFault::NoShare(_) | ComputeFault::Panicked,
        )
        | JobFault::NoShare(_)
        | JobFault::Blob(_)
        | JobFault::Store(_)
        | JobFault::KeyReused
        | JobFault::QueueFull { .. }
        | JobFault::MachineLost
        | JobFault::ProcessDied
        | JobFault::Report(_) => false,
    }
}

/// Whether a file has reached the limit of a setting; the disk's own limit has an error number.
pub(super) fn is_over_its_limit(fault: &std::io::Error) -> bool {
    fault.kind() == std::io::ErrorKind::FileTooLarge && fault.raw_os_error().is_none()
}

/// The fault with every location that it names, one on each line.
fn told(fault: &JobFault) -> String {
    match fault {
        JobFault::Parameters(faults) => format!("the parameters are refused:{}", listed(faults)),
        JobFault::Compensator(CompensatorFault::Refused(refusal)) => {
            let mut text = refusal.detail.clone();
            if let Some(line) = refusal.line {
                let block = refusal.block.as_deref().map_or_else(String::new, |block| format!(": {block}"));
                let _always = write!(text, "\n  first at line {line}{block}");
            }
            match refusal.errors.as_slice() {
                [only] if only.detail == refusal.detail => text,
                errors => text + &listed(errors),
            }
        }
        other => other.to_string(),
    }
}

fn listed(faults: &[Fault]) -> String {
    faults.iter().fold(String::new(), |text, fault| format!("{text}\n  {}: {}", fault.pointer, fault.detail))
}
