//! The files of the results: their places are checked before any work, and each is written whole or not at all.

use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use tempfile::NamedTempFile;

use super::parameters::Parameters;
use super::{CompensateArguments, STANDARD_STREAM, at, summary};
use crate::cli::CommandFault;
use crate::cli::settings::say;
use crate::jobs::Finished;

/// Writes the results to their places, and says in three lines what they are.
pub(super) fn write_results(
    arguments: &CompensateArguments,
    finished: Finished,
    began: Instant,
) -> Result<(), CommandFault> {
    let Finished { report, output, changes, .. } = finished;
    let to_standard_output = arguments.report.as_deref() == Some(Path::new(STANDARD_STREAM));
    if to_standard_output {
        // If the report cannot be written, no program is written either.
        say(&report)?;
    }
    for (made, path) in [(output, &arguments.output), (changes, &arguments.changes)] {
        if let (Some(made), Some(path)) = (made, path) {
            write_whole(path, |file| moved_or_copied(made.path(), file))?;
        }
    }
    if let Some(path) = arguments.report.as_ref().filter(|_| !to_standard_output) {
        write_whole(path, |file| file.write_all(report.as_bytes()))?;
    }
    let lines = summary::lines(arguments, &report, began.elapsed())?;
    if to_standard_output {
        let _nobody_reads = writeln!(io::stderr(), "{lines}");
        return Ok(());
    }
    // If there is a file, it is the result, whether anybody reads the lines or not.
    let is_all = arguments.output.is_none() && arguments.report.is_none();
    say(&lines).or_else(|fault| if is_all { Err(fault) } else { Ok(()) })
}

/// Checks the places of the results before any work: each must have its own place, in an existing folder, and
/// must not replace a special file or an input. Only the program itself may be replaced by its result.
pub(super) fn check_places(
    arguments: &CompensateArguments,
    parameters: Parameters<'_>,
) -> Result<(), CommandFault> {
    let CompensateArguments { input, output, machine, surface, report, changes, .. } = arguments;
    let whole = |path: &Path| path.canonicalize().ok();
    // A missing file cannot be overwritten; reading it reports the fault.
    let mut read: Vec<PathBuf> = machine.as_deref().and_then(whole).into_iter().collect();
    read.extend(surface.as_deref().and_then(whole));
    if let Parameters::File(path) = parameters {
        read.extend(whole(path));
    }
    let program = if input == Path::new(STANDARD_STREAM) { None } else { whole(input) };
    let mut taken = Vec::new();
    let report = report.as_ref().filter(|path| path.as_path() != Path::new(STANDARD_STREAM));
    for (path, is_program) in [(output.as_ref(), true), (report, false), (changes.as_ref(), false)] {
        let Some(path) = path else { continue };
        let folder = folder_of(path);
        let folder = folder.canonicalize().map_err(at("looking for", folder))?;
        let Some(name) = path.file_name() else { return Err(CommandFault::NoPlainFile(path.to_owned())) };
        let place = folder.join(name);
        match fs::symlink_metadata(&place) {
            Ok(found) if !found.is_file() => return Err(CommandFault::NoPlainFile(path.to_owned())),
            Ok(found) if found.permissions().readonly() => {
                return Err(CommandFault::WriteProtected(path.to_owned()));
            }
            _ => {}
        }
        if taken.contains(&place) {
            return Err(CommandFault::SamePlace(path.to_owned()));
        }
        if read.contains(&place) || (!is_program && program.as_ref() == Some(&place)) {
            return Err(CommandFault::OwnInput(path.to_owned()));
        }
        taken.push(place);
    }
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Moves the result to the new file. If the file systems differ, copies it.
fn moved_or_copied(result: &Path, file: &mut NamedTempFile) -> io::Result<()> {
    let permissions = file.as_file().metadata()?.permissions();
    let moved = fs::set_permissions(result, permissions).and_then(|()| fs::rename(result, file.path()));
    if moved.is_ok() {
        *file.as_file_mut() = File::open(file.path())?;
        return Ok(());
    }
    io::copy(&mut File::open(result)?, file.as_file_mut()).map(drop)
}

/// Writes a file completely or not at all: first to a temporary file beside it, then to its name. A file that is
/// replaced hands on its permissions.
fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut NamedTempFile) -> io::Result<()>,
) -> Result<(), CommandFault> {
    let folder = folder_of(path);
    // The permissions of an ordinary new file, not those of a temporary file.
    let mut file = tempfile::Builder::new()
        .prefix(".trunnion-")
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder)
        .map_err(at("making a file beside", path))?;
    write(&mut file).map_err(at("writing", path))?;
    if let Ok(replaced) = fs::metadata(path) {
        file.as_file().set_permissions(replaced.permissions()).map_err(at("writing", path))?;
    }
    file.as_file().sync_all().map_err(at("synchronising", path))?;
    file.persist(path).map_err(|fault| at("writing", path)(fault.error))?;
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(at("synchronising", folder))
}
