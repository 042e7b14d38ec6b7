//! Runs an operation on one program without a service and without a database: the same work, from file to
//! file.

use std::fs::{self, File, Permissions};
use std::io::{self, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;

use clap::Args;
use tempfile::NamedTempFile;

use super::CommandFault;
use super::fault::is_over_its_limit;
use super::migrate::block_on;
use super::settings::say;
use crate::config::Settings;
use crate::jobs::{
    CompensatorFault, Compute, Cost, CutterContactCompensator, Finished, InputFile, JobFault, MachineUsed,
    Means, ProgramWork, Sizes, Spool, ToolShelf, Workplace,
};
use crate::shares::Share;
use crate::store::{Blobs, Draft};
use crate::wire::{JobOperation, MachineProfile, ProgramUnit, read_json};

/// The operation and the program.
#[derive(Debug, Clone, PartialEq, Eq, Args)]
pub struct CompensateArguments {
    /// The program; `-` reads standard input
    input: PathBuf,
    /// File for the result, written completely or not at all; without it only the report is made
    output: Option<PathBuf>,
    /// The machine's profile, as JSON
    #[arg(long)]
    machine: PathBuf,
    /// Operation: cc-compensation, wear-compensation, compensation, posting, verification, servo-simulation
    #[arg(long, default_value = "compensation", value_parser = operation)]
    operation: JobOperation,
    /// Parameters of the operation: JSON, or a file with JSON
    #[arg(long, default_value = "{}")]
    parameters: String,
    /// Unit of the lengths in a program that states none: mm or inch
    #[arg(long, value_parser = unit)]
    unit: Option<ProgramUnit>,
    /// The part's surface as STL
    #[arg(long)]
    surface: Option<PathBuf>,
    /// File for the report instead of standard output
    #[arg(long)]
    report: Option<PathBuf>,
    /// File for the table of changes of a compensation in one pass
    #[arg(long)]
    changes: Option<PathBuf>,
}

fn operation(word: &str) -> Result<JobOperation, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(word.to_owned()))
}

fn unit(word: &str) -> Result<ProgramUnit, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(word.to_owned()))
}

/// The parameters with the unit of the flag. A text that is not a JSON object is left for the operation to
/// refuse.
fn with_unit(parameters: Vec<u8>, unit: Option<ProgramUnit>) -> Result<Vec<u8>, CommandFault> {
    let Some(unit) = unit else { return Ok(parameters) };
    let read = serde_json::from_slice::<serde_json::Map<String, serde_json::Value>>(&parameters);
    let (Ok(members), Some(open)) = (read, memchr::memchr(b'{', &parameters)) else { return Ok(parameters) };
    let typed = serde_json::json!(unit);
    match members.get("unit") {
        Some(stated) if *stated != typed => {
            Err(CommandFault::TwoUnits { typed: typed.to_string(), stated: stated.to_string() })
        }
        Some(_) => Ok(parameters),
        None => {
            // The rest of the text stays as it is, so that its faults are reported.
            let comma = if members.is_empty() { "" } else { "," };
            let member = format!("\"unit\":{typed}{comma}");
            let (head, rest) = parameters.split_at(open + 1);
            Ok([head, member.as_bytes(), rest].concat())
        }
    }
}

fn at(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> CommandFault {
    let path = path.to_owned();
    move |source| CommandFault::File { doing, path, source }
}

/// Does the work and writes the results.
pub(super) fn run(settings: &Settings, arguments: &CompensateArguments) -> Result<(), CommandFault> {
    let operation = arguments.operation;
    let nothing = |what| Err(CommandFault::NothingToWrite { operation: operation.as_str(), what });
    if operation == JobOperation::ServoSimulation && arguments.output.is_some() {
        return nothing("program");
    }
    if operation != JobOperation::Compensation && arguments.changes.is_some() {
        return nothing("table of changes");
    }
    let parameters = Parameters::of(&arguments.parameters);
    check_places(arguments, parameters)?;
    let on = machine(&arguments.machine, settings.max_json_bytes)?;
    let parameters = with_unit(parameters.read(settings.max_parameters_bytes)?, arguments.unit)?;
    let working = tempfile::Builder::new().prefix("trunnion-").tempdir().map_err(CommandFault::Process)?;
    let blobs = Blobs::open(working.path())?;
    let program = taken(&blobs, &arguments.input, "max_body_bytes", settings.max_body_bytes)?;
    let surface = arguments.surface.as_ref();
    let limit = settings.max_surface_bytes;
    let surface = surface.map(|path| taken(&blobs, path, "max_surface_bytes", limit)).transpose()?;
    let means = Means {
        compensator: Arc::new(CutterContactCompensator { budget: Cost::budget_within(settings.max_cost_s) }),
        max_cost_s: settings.max_cost_s,
    };
    let finished = block_on(async {
        let opened = || Ok((InputFile::of(&program)?, surface.as_ref().map(InputFile::of).transpose()?));
        let (program, surface) = opened().map_err(at("reading", &arguments.input))?;
        let sizes = Sizes::of(&program, surface.as_ref()).map_err(at("reading", &arguments.input))?;
        let work =
            ProgramWork::read(operation, &parameters, on, sizes, &means).map_err(CommandFault::Work)?;
        let compute = Compute::new(settings.computations(), 0, Share(1.0), settings.max_surface_memory_bytes)
            .costing_at_most(settings.max_cost_s);
        let memory = sizes.surface_facets.map(|facets| compute.surface_memory(facets)).transpose();
        let memory = memory.map_err(|fault| CommandFault::Work(fault.into()))?;
        let spool = Spool::new(blobs.clone(), u64::MAX).with_results_within(settings.max_result_bytes);
        let worked = compute.run_in_parts(move |threads, stop| {
            let _memory = memory;
            let surface = surface.as_ref();
            work.run(Workplace::new(&program, surface, &spool, threads, stop))
        });
        tokio::select! {
            worked = worked => match worked {
                Ok(Ok(finished)) => Ok(finished),
                Ok(Err(JobFault::Compensator(CompensatorFault::Cancelled))) => Err(CommandFault::Stopped),
                Ok(Err(fault)) => Err(CommandFault::Work(fault)),
                Err(fault) => Err(CommandFault::Work(fault.into())),
            },
            _told = tokio::signal::ctrl_c() => Err(CommandFault::Stopped),
        }
    })?;
    thread::scope(|scope| {
        // The copies of the inputs may be as long as the result, and are removed while that goes to the disk. Without
        // a second thread they are removed before.
        let _removal = thread::Builder::new().spawn_scoped(scope, move || drop((program, surface)));
        write_results(arguments, finished)
    })
}

/// Writes the results to their places.
fn write_results(arguments: &CompensateArguments, finished: Finished) -> Result<(), CommandFault> {
    let Finished { report, output, changes, .. } = finished;
    if arguments.report.is_none() {
        // If the report cannot be written, no program is written either.
        say(&report)?;
    }
    for (made, path) in [(output, &arguments.output), (changes, &arguments.changes)] {
        if let (Some(made), Some(path)) = (made, path) {
            write_whole(path, |file| moved_or_copied(made.path(), file))?;
        }
    }
    arguments
        .report
        .as_ref()
        .map_or(Ok(()), |path| write_whole(path, |file| file.write_all(report.as_bytes())))
}

/// Parameters as they are given.
#[derive(Debug, Clone, Copy)]
enum Parameters<'a> {
    Inline(&'a str),
    File(&'a Path),
}

impl<'a> Parameters<'a> {
    fn of(typed: &'a str) -> Self {
        let text = typed.trim_start();
        if text.starts_with('{') { Self::Inline(text) } else { Self::File(Path::new(typed)) }
    }

    fn read(self, limit_bytes: u64) -> Result<Vec<u8>, CommandFault> {
        let setting = "max_parameters_bytes";
        match self {
            Self::Inline(text) if text.len() as u64 > limit_bytes => {
                Err(CommandFault::TooLarge { path: PathBuf::from("--parameters"), limit_bytes, setting })
            }
            Self::Inline(text) => Ok(text.as_bytes().to_vec()),
            Self::File(path) => read_within(path, setting, limit_bytes),
        }
    }
}

/// A whole file, up to the limit of a setting; an endless file, such as a device, is not read further.
fn read_within(path: &Path, setting: &'static str, limit_bytes: u64) -> Result<Vec<u8>, CommandFault> {
    let mut text = Vec::new();
    let file = File::open(path).map_err(at("opening", path))?;
    file.take(limit_bytes.saturating_add(1)).read_to_end(&mut text).map_err(at("reading", path))?;
    if text.len() as u64 > limit_bytes {
        return Err(CommandFault::TooLarge { path: path.to_owned(), limit_bytes, setting });
    }
    Ok(text)
}

/// Checks the places of the results before any work: each must have its own place, in an existing folder, and
/// must not replace a special file or an input. Only the program itself may be replaced by its result.
fn check_places(arguments: &CompensateArguments, parameters: Parameters<'_>) -> Result<(), CommandFault> {
    let CompensateArguments { input, output, machine, surface, report, changes, .. } = arguments;
    let whole = |path: &Path| path.canonicalize().ok();
    // A missing file cannot be overwritten; reading it reports the fault.
    let mut read: Vec<PathBuf> = whole(machine).into_iter().collect();
    read.extend(surface.as_deref().and_then(whole));
    if let Parameters::File(path) = parameters {
        read.extend(whole(path));
    }
    let program = if input == Path::new("-") { None } else { whole(input) };
    let mut taken = Vec::new();
    for (path, is_program) in [(output, true), (report, false), (changes, false)] {
        let Some(path) = path else { continue };
        let folder = folder_of(path);
        let folder = folder.canonicalize().map_err(at("looking for", folder))?;
        let Some(name) = path.file_name() else { return Err(CommandFault::NoPlainFile(path.to_owned())) };
        let place = folder.join(name);
        match fs::symlink_metadata(&place) {
            Ok(found) if !found.is_file() => return Err(CommandFault::NoPlainFile(path.to_owned())),
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

fn machine(path: &Path, limit_bytes: u64) -> Result<MachineUsed, CommandFault> {
    let text = read_within(path, "max_json_bytes", limit_bytes)?;
    let (text, machine_id, revision) = profile_alone(text);
    let profile: MachineProfile = read_json(&text).map_err(CommandFault::UnreadableMachine)?;
    let machine_id = machine_id.unwrap_or_else(|| profile.name.clone());
    MachineUsed::new(machine_id, revision, profile, ToolShelf::default()).map_err(CommandFault::Machine)
}

/// A profile in the form in which it is sent to a service, with the id and revision if it was read from one;
/// else the revision is 0.
fn profile_alone(text: Vec<u8>) -> (Vec<u8>, Option<String>, i64) {
    let Ok(serde_json::Value::Object(mut members)) = serde_json::from_slice(&text) else {
        return (text, None, 0);
    };
    let Some(machine_id) = members.remove("machine_id") else { return (text, None, 0) };
    let machine_id = machine_id.as_str().map(str::to_owned);
    members.remove("created_at");
    let revision = members.remove("revision").and_then(|revision| revision.as_i64());
    let text = serde_json::Value::Object(members).to_string().into_bytes();
    (text, machine_id, revision.unwrap_or_default())
}

/// A file copied to a place where nobody changes it during the work, up to the limit of a setting.
fn taken(blobs: &Blobs, path: &Path, setting: &'static str, limit_bytes: u64) -> Result<Draft, CommandFault> {
    let draft = blobs.draft()?.within(limit_bytes);
    let copied = if path == Path::new("-") {
        draft.with_all_of(&mut io::stdin().lock())
    } else {
        let mut file = File::open(path).map_err(at("opening", path))?;
        draft.with_all_of(&mut file)
    };
    copied.map_err(|fault| match fault {
        fault if is_over_its_limit(&fault) => {
            CommandFault::TooLarge { path: path.to_owned(), limit_bytes, setting }
        }
        fault => at("reading", path)(fault),
    })
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

/// Writes a file completely or not at all: first to a temporary file beside it, then to its name.
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
    file.as_file().sync_all().map_err(at("synchronising", path))?;
    file.persist(path).map_err(|fault| at("writing", path)(fault.error))?;
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(at("synchronising", folder))
}
