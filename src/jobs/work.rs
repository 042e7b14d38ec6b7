//! The one interface between callers and the work on a program: an operation with its parameters goes in; work comes
//! out that can run in the pool, in a queue or on the command line.

use std::fmt;
use std::io;
use std::sync::Arc;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::part_surface::facets_of;
use super::refusals::of_parameter;
use super::workplace::{Finished, Workplace};
use super::{Compensator, CompensatorFault, Cost, InputFile, JobFault, ToolShelf};
use crate::kinematics::{BareKinematics, Kinematics, Setup};
use crate::machine::{Machine, Side};
use crate::process::{ProgramReading, ProgramSetup, SurveyExtent};
use crate::program::Steps;
use crate::store::Draft;
use crate::wire::{
    CcParameters, CompensationParameters, Drives, Fault, FaultList, JobOperation, MachineProfile,
    MachineStatements, PostingParameters, Provenance, ResolvedInputs, ResolvedWear, ServoProgramParameters,
    Statements, VerificationParameters, WearParameters, read_json, two_statements,
};

/// The machine that a program is for.
#[derive(Debug, Clone)]
pub struct MachineUsed {
    /// Its id.
    pub machine_id: String,
    /// Its revision.
    pub revision: i64,
    /// The machine at this revision.
    pub machine: Machine,
    /// Its drives, if the profile has any.
    pub drives: Option<Drives>,
    /// The statements of the profile about programs.
    pub statements: Arc<MachineStatements>,
    /// Its tools at the time when the work is accepted.
    pub shelf: ToolShelf,
    /// The machine without a set-up, with its errors and without.
    bare: [BareKinematics; 2],
}

impl MachineUsed {
    /// The machine at this revision, with these tools.
    ///
    /// # Errors
    /// Every fault of the profile, with its pointer.
    pub fn new(
        machine_id: String,
        revision: i64,
        profile: MachineProfile,
        shelf: ToolShelf,
    ) -> Result<Self, Vec<Fault>> {
        let drives = profile.drives.clone();
        let statements = Arc::new(MachineStatements::of(&profile));
        let (_, machine) = profile.into_machine()?;
        let bare = [true, false].map(|apply_errors| BareKinematics::new(&machine, apply_errors));
        Ok(Self { machine_id, revision, machine, drives, statements, shelf, bare })
    }

    /// The set-up of a program on this machine, with these statements of the request.
    pub(super) fn program(
        &self,
        statements: &Statements<'_>,
        apply_errors: bool,
    ) -> Result<ProgramSetup, Vec<Fault>> {
        let mut faults = FaultList::default();
        let program = statements.to_core(
            &self.machine,
            &self.statements,
            self.shelf.table(),
            apply_errors,
            &mut faults,
        );
        faults.into_result().map(|()| program)
    }

    /// The resolved inputs of a program that was read in this way.
    ///
    /// # Errors
    /// The request states an offset of the program twice with different values.
    pub(super) fn resolved(
        &self,
        statements: &Statements<'_>,
        reading: &ProgramReading,
    ) -> Result<ResolvedInputs, CompensatorFault> {
        if let Some(fault) = two_statements(statements, reading) {
            return Err(CompensatorFault::Refused(Box::new(of_parameter(fault))));
        }
        let table = |place| self.shelf.place(place);
        let resolved = ResolvedInputs::of(statements, &self.statements, &table, reading);
        let cuts = |wear: &&ResolvedWear| resolved.has_tool(&wear.tool_id);
        let wear = self.shelf.wear().iter().filter(cuts).cloned().collect();
        Ok(ResolvedInputs { wear, ..resolved })
    }

    /// Whether a rotary axis turns the tool.
    pub(super) fn has_head_axis(&self) -> bool {
        self.machine.rotary_axes().iter().any(|axis| axis.side == Side::Head)
    }

    /// The machine with this set-up.
    pub(super) fn kinematics(&self, setup: &Setup) -> Kinematics {
        let [calibrated, nominal] = &self.bare;
        let bare = if setup.apply_errors { calibrated } else { nominal };
        bare.set_up(setup.work_offset_mm, setup.tool_length_mm)
    }

    /// The provenance of a program made from another one.
    pub(super) fn provenance(&self, program: &InputFile, output: &Draft) -> Provenance {
        Provenance {
            machine_revision: self.revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            input_sha256: program.sha256.clone(),
            output_sha256: output.sha256(),
            steps: None,
        }
    }
}

/// The sizes of the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// Length of the program \[bytes\].
    pub program_length: u64,
    /// Largest number of facets of the part's surface, if one came with the program.
    pub surface_facets: Option<u64>,
}

impl Sizes {
    /// The sizes of uploaded files.
    ///
    /// # Errors
    /// The beginning of the surface cannot be read.
    pub fn of(program: &InputFile, surface: Option<&InputFile>) -> io::Result<Self> {
        let surface_facets = surface.map(facets_of).transpose()?;
        Ok(Self { program_length: program.length, surface_facets })
    }

    /// The sizes of the files of a request.
    ///
    /// # Errors
    /// As for [`Self::of`].
    pub fn of_drafts(program: &Draft, surface: Option<&Draft>) -> io::Result<Self> {
        Self::of(&InputFile::of(program)?, surface.map(InputFile::of).transpose()?.as_ref())
    }

    /// Whether the part's surface came with the program.
    #[must_use]
    pub const fn has_part(&self) -> bool {
        self.surface_facets.is_some()
    }

    /// The cost of reading the part, and of finding a contact on it for every block of the program.
    pub(super) fn cost_of_part(&self) -> Cost {
        self.surface_facets.map_or(Cost::NOTHING, |facets| Cost::of_part(facets, self.program_length))
    }
}

/// The means of the work, the same for every program.
#[derive(Debug, Clone)]
pub struct Means {
    /// The compensator of the CC path.
    pub compensator: Arc<dyn Compensator>,
    /// The largest allowed cost of a computation \[s of one core\].
    pub max_cost_s: f64,
}

/// Parameters of an operation on a program.
pub trait ProgramParameters: Serialize + DeserializeOwned + Send + 'static {
    /// The operation.
    const OPERATION: JobOperation;
    /// Whether it uses the part's surface, if one comes with the program.
    const LOOKS_AT_PART: bool;
    /// Whether the program may come with files that it calls.
    const CALLS_FILES: bool = true;

    /// The requested steps that must not be applied twice: a program that is a stored output of one of them is
    /// refused.
    fn steps(&self) -> Steps {
        Steps::NONE
    }

    /// The cutter whose wear entries are used, if the wear comes from entries.
    fn cutter_id(&self) -> Option<&str> {
        None
    }

    /// Memory of the work in addition to that of every computation, if a parameter determines it \[bytes\].
    fn working_bytes(&self) -> u64 {
        0
    }

    /// The work with its estimated cost; nothing is read yet.
    ///
    /// # Errors
    /// Every wrong parameter, with its pointer.
    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>>;
}

/// A generic action on the parameters of an operation whose name is known only at run time.
pub trait ByOperation {
    /// The result of the action.
    type Output;

    /// Does the action with these parameters.
    fn with<P: ProgramParameters>(self) -> Self::Output;
}

/// Does an action with the parameters of an operation. Every operation on programs is listed here.
pub fn by_operation<D: ByOperation>(operation: JobOperation, what: D) -> D::Output {
    match operation {
        JobOperation::CcCompensation => what.with::<CcParameters>(),
        JobOperation::WearCompensation => what.with::<WearParameters>(),
        JobOperation::Compensation => what.with::<CompensationParameters>(),
        JobOperation::Verification => what.with::<VerificationParameters>(),
        JobOperation::ServoSimulation => what.with::<ServoProgramParameters>(),
        JobOperation::Posting => what.with::<PostingParameters>(),
    }
}

type Run = Box<dyn FnMut(Workplace<'_>) -> Result<Finished, JobFault> + Send>;

/// Work with checked parameters.
pub struct Prepared {
    cost: Cost,
    steps_in_turn: u32,
    run: Run,
}

impl fmt::Debug for Prepared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Prepared").field("cost", &self.cost).finish_non_exhaustive()
    }
}

impl Prepared {
    pub(super) fn new(
        cost: Cost,
        run: impl FnMut(Workplace<'_>) -> Result<Finished, JobFault> + Send + 'static,
    ) -> Self {
        Self { cost, steps_in_turn: 0, run: Box::new(run) }
    }

    /// The same, for work in which this number of steps take the program one after the other and write it.
    pub(super) fn with_steps_in_turn(self, steps_in_turn: u32) -> Self {
        Self { steps_in_turn, ..self }
    }
}

/// Work that may be done: its parameters are valid, and its cost is within the limit.
#[derive(Debug)]
pub struct ProgramWork {
    /// The operation.
    pub operation: JobOperation,
    /// The parameters, with defaults filled in.
    pub parameters: serde_json::Value,
    /// The machine's tools at its acceptance.
    pub shelf: ToolShelf,
    prepared: Prepared,
}

impl ProgramWork {
    /// The work with these parameters.
    ///
    /// # Errors
    /// Wrong parameters, or work that would cost too much.
    pub fn new<P: ProgramParameters>(
        parameters: P,
        on: MachineUsed,
        sizes: Sizes,
        means: &Means,
    ) -> Result<Self, JobFault> {
        let kept = serde_json::to_value(&parameters)?;
        let shelf = on.shelf.clone();
        let prepared = parameters.prepare(on, sizes, means).map_err(JobFault::Parameters)?;
        prepared.cost.within(means.max_cost_s)?;
        Ok(Self { operation: P::OPERATION, parameters: kept, shelf, prepared })
    }

    /// The work of an operation given by name, with its parameters as JSON text.
    ///
    /// # Errors
    /// Parameters that cannot be read or are wrong, or work that would cost too much.
    pub fn read(
        operation: JobOperation,
        parameters: &[u8],
        on: MachineUsed,
        sizes: Sizes,
        means: &Means,
    ) -> Result<Self, JobFault> {
        struct Read<'a>(&'a [u8], MachineUsed, Sizes, &'a Means);
        impl ByOperation for Read<'_> {
            type Output = Result<ProgramWork, JobFault>;
            fn with<P: ProgramParameters>(self) -> Self::Output {
                let Self(parameters, on, sizes, means) = self;
                ProgramWork::new(read_json::<P>(parameters)?, on, sizes, means)
            }
        }
        by_operation(operation, Read(parameters, on, sizes, means))
    }

    /// How many steps take the program in turn; 0 for work that only reads it.
    pub(super) fn steps_in_turn(&self) -> u32 {
        self.prepared.steps_in_turn
    }

    /// Does the work, to its end or until its place stops it.
    ///
    /// # Errors
    /// The reason why there is no result.
    pub fn run(self, place: Workplace<'_>) -> Result<Finished, JobFault> {
        let Prepared { mut run, steps_in_turn, .. } = self.prepared;
        let extent = if steps_in_turn > 0 { SurveyExtent::Head } else { SurveyExtent::Whole };
        let finished = match run(Workplace { survey: extent, ..place }) {
            // The files of this attempt are already removed.
            Err(JobFault::Compensator(CompensatorFault::HeadMisled)) => {
                run(Workplace { survey: SurveyExtent::Whole, ..place })
            }
            other => other,
        }?;
        Ok(Finished { steps: finished.steps.map(|steps| steps.and(place.program.steps_done)), ..finished })
    }
}
