//! Completion scripts for shells, and manual pages: made from the same description as the flags themselves.

use std::io;
use std::path::Path;

use clap_complete::Shell;

use super::command_line::shown;
use super::settings::put;
use super::{CommandFault, command};

const NAME: &str = "trunnion";

/// Prints the script that completes the commands and flags in this shell.
pub(super) fn complete(shell: Shell) -> Result<(), CommandFault> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut shown(), NAME, &mut script);
    print(&script)
}

/// Prints the manual page, or writes the pages of all commands into a directory.
pub(super) fn manual(directory: Option<&Path>) -> Result<(), CommandFault> {
    let Some(directory) = directory else {
        let mut page = Vec::new();
        clap_mangen::Man::new(command()).render(&mut page).map_err(CommandFault::Print)?;
        return print(&page);
    };
    let unusable = |doing| {
        let path = directory.to_owned();
        move |source: io::Error| CommandFault::File { doing, path, source }
    };
    std::fs::create_dir_all(directory).map_err(unusable("making"))?;
    clap_mangen::generate_to(command(), directory).map_err(unusable("writing into"))
}

fn print(text: &[u8]) -> Result<(), CommandFault> {
    let text = std::str::from_utf8(text).map_err(io::Error::other);
    text.and_then(put).map_err(CommandFault::Print)
}
