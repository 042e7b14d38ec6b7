//! Runs an operation on one program without a service and without a database: the same work, from file to
//! file.

mod machine;
mod parameters;
mod progress;
mod results;
mod summary;

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use clap::builder::PossibleValuesParser;
use clap::{ArgGroup, Args};

use self::machine::{machine, preset_names};
use self::parameters::{Parameters, with_flags};
use self::progress::Bar;
use self::results::{check_places, write_results};
use super::CommandFault;
use super::fault::is_over_its_limit;
use super::migrate::block_on;
use crate::config::Settings;
use crate::jobs::{
    CompensatorFault, Compute, Cost, CutterContactCompensator, InputFile, JobFault, Means, ProgramWork,
    Progress, SentFile, Sizes, Spool, Workplace, joined,
};
use crate::shares::Share;
use crate::store::{Blobs, Draft};
use crate::wire::{JobOperation, ProgramUnit};

/// The name that stands for standard input, or for standard output.
const STANDARD_STREAM: &str = "-";

/// The operation and the program.
#[derive(Debug, Clone, PartialEq, Args)]
#[command(group(ArgGroup::new("on").required(true).args(["machine", "preset"])))]
pub struct CompensateArguments {
    /// The program; `-` reads standard input
    input: PathBuf,
    /// File for the result, written completely or not at all; without it only the report is made
    output: Option<PathBuf>,
    /// The machine's profile, as JSON
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// A common layout of a machine, in place of a profile
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(preset_names()))]
    preset: Option<String>,
    /// Operation: cc-compensation, wear-compensation, compensation, posting, verification, servo-simulation
    #[arg(long, default_value = "compensation", value_parser = operation)]
    operation: JobOperation,
    /// Parameters of the operation: JSON, or a file with JSON; without it a compensation has the step cc
    #[arg(long, value_name = "JSON")]
    parameters: Option<String>,
    /// Unit of the lengths in a program that states none: mm or inch
    #[arg(long, value_parser = unit)]
    unit: Option<ProgramUnit>,
    /// Origin of the program's coordinates in those of the machine (mm)
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    work_offset_mm: Option<Offset>,
    /// Radius of the cutter (mm)
    #[arg(long, value_name = "MM", value_parser = finite, allow_negative_numbers = true)]
    tool_radius_mm: Option<f64>,
    /// Largest allowed distance of the contact path from its line (µm); the default is 10
    #[arg(long, value_name = "UM", value_parser = finite, allow_negative_numbers = true)]
    tolerance_um: Option<f64>,
    /// Also compensate the location errors in the machine's profile
    #[arg(long)]
    location_errors: bool,
    /// The part's surface as STL
    #[arg(long, value_name = "FILE")]
    surface: Option<PathBuf>,
    /// A file that the program calls, by its name; several may be given
    #[arg(long, value_name = "FILE")]
    subprogram: Vec<PathBuf>,
    /// Write loops and calls out before the program is compensated
    #[arg(long)]
    flatten: bool,
    /// File for the report as JSON; `-` writes it to standard output
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// File for the table of changes of a compensation in one pass
    #[arg(long, value_name = "FILE")]
    changes: Option<PathBuf>,
}

/// Three coordinates [mm].
#[derive(Debug, Clone, Copy, PartialEq)]
struct Offset([f64; 3]);

impl FromStr for Offset {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text.split(',').map(finite).collect::<Result<_, _>>()?;
        let given = numbers.len();
        let three = <[f64; 3]>::try_from(numbers);
        three.map(Self).map_err(|_others| format!("{given} numbers, but X,Y,Z are three, such as 12,-7,35"))
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("{text:?} is not a number"))
}

fn operation(word: &str) -> Result<JobOperation, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(word.to_owned()))
}

fn unit(word: &str) -> Result<ProgramUnit, serde_json::Error> {
    serde_json::from_value(serde_json::Value::String(word.to_owned()))
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
    let began = Instant::now();
    let parameters = Parameters::of(arguments.parameters.as_deref().unwrap_or("{}"));
    check_places(arguments, parameters)?;
    let on = machine(arguments, settings.max_json_bytes)?;
    let parameters = with_flags(parameters.read(settings.max_parameters_bytes)?, arguments)?;
    let working = tempfile::Builder::new().prefix("trunnion-").tempdir().map_err(CommandFault::Process)?;
    let blobs = Blobs::open(working.path())?;
    let program = taken(&blobs, &arguments.input, "max_body_bytes", settings.max_body_bytes)?;
    let program = with_files(program, &blobs, arguments, settings.max_body_bytes)?;
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
        let _bar = Bar::of(Progress::of(&program, &work));
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
        write_results(arguments, finished, began)
    })
}

/// The program with the files that it calls.
fn with_files(
    program: Draft,
    blobs: &Blobs,
    arguments: &CompensateArguments,
    limit_bytes: u64,
) -> Result<Draft, CommandFault> {
    if arguments.subprogram.is_empty() {
        return Ok(program);
    }
    if arguments.operation == JobOperation::Posting {
        let operation = arguments.operation.as_str();
        return Err(CommandFault::NoSuchMember { flag: "--subprogram", operation });
    }
    let sent = |path: &Path, draft: &Draft| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        SentFile::of(name.unwrap_or_default(), draft).map_err(at("reading", path))
    };
    let main = sent(&arguments.input, &program)?;
    let files = arguments.subprogram.iter().map(|path| {
        let draft = taken(blobs, path, "max_body_bytes", limit_bytes)?;
        sent(path, &draft)
    });
    let files = files.collect::<Result<_, _>>()?;
    joined(&Spool::new(blobs.clone(), u64::MAX), main, files, false).map_err(CommandFault::Files)
}

/// A file copied to a place where nobody changes it during the work, up to the limit of a setting.
fn taken(blobs: &Blobs, path: &Path, setting: &'static str, limit_bytes: u64) -> Result<Draft, CommandFault> {
    let draft = blobs.draft()?.within(limit_bytes);
    let copied = if path == Path::new(STANDARD_STREAM) {
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
