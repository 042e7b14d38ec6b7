//! The one seam between who asks for work on a program and the work: an operation with its parameters in, work out that
//! can be done in the pool, in a queue or on the command line.

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
use crate::process::{ProgramReading, ProgramSetup};
use crate::program::Steps;
use crate::store::Draft;
use crate::wire::{
    CcParameters, CompensationParameters, Drives, Fault, FaultList, JobOperation, MachineProfile,
    MachineStatements, PostingParameters, Provenance, ResolvedInputs, ServoProgramParameters, Statements,
    VerificationParameters, WearParameters, read_json, two_statements,
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
    /// Its drives, where the profile has any.
    pub drives: Option<Drives>,
    /// What the profile states of programs.
    pub statements: Arc<MachineStatements>,
    /// Its tools as they are when the work is accepted.
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

    /// How a program runs on it of which a request states this.
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

    /// What a result rests on, of a program that was read in this way.
    ///
    /// # Errors
    /// The request states an offset of the program twice, and not alike.
    pub(super) fn resolved(
        &self,
        statements: &Statements<'_>,
        reading: &ProgramReading,
    ) -> Result<ResolvedInputs, CompensatorFault> {
        if let Some(fault) = two_statements(statements, reading) {
            return Err(CompensatorFault::Refused(Box::new(of_parameter(fault))));
        }
        let table = |place| self.shelf.place(place);
        Ok(ResolvedInputs {
            wear: self.shelf.wear().to_vec(),
            ..ResolvedInputs::of(statements, &self.statements, &table, reading)
        })
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

    /// What a program made of another one was computed from.
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

/// How much there is to work on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sizes {
    /// Length of the program \[bytes\].
    pub program_length: u64,
    /// Facets of the part's surface at most, where one came with the program.
    pub surface_facets: Option<u64>,
}

impl Sizes {
    /// Of the files that came in.
    ///
    /// # Errors
    /// The beginning of the surface cannot be read.
    pub fn of(program: &InputFile, surface: Option<&InputFile>) -> io::Result<Self> {
        let surface_facets = surface.map(facets_of).transpose()?;
        Ok(Self { program_length: program.length, surface_facets })
    }

    /// Of the files that a request brought.
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

    /// What reading the part costs, and finding a contact on it for every block of the program.
    pub(super) fn cost_of_part(&self) -> Cost {
        self.surface_facets.map_or(Cost::NOTHING, |facets| Cost::of_part(facets, self.program_length))
    }
}

/// What work is done with, the same for every program.
#[derive(Debug, Clone)]
pub struct Means {
    /// What the CC path is compensated by.
    pub compensator: Arc<dyn Compensator>,
    /// The dearest computation allowed \[s of one core\].
    pub max_cost_s: f64,
}

/// Parameters of an operation on a program.
pub trait ProgramParameters: Serialize + DeserializeOwned + Send + 'static {
    /// The operation.
    const OPERATION: JobOperation;
    /// Whether it looks at the part's surface, where one comes with the program.
    const LOOKS_AT_PART: bool;

    /// The steps that are asked for and that must not be done twice: to a program that is a stored output of one of them it is
    /// refused.
    fn steps(&self) -> Steps {
        Steps::NONE
    }

    /// The cutter whose wear entries count, where its wear is theirs.
    fn cutter_id(&self) -> Option<&str> {
        None
    }

    /// What the work takes besides what every computation does, where a parameter decides it \[bytes\].
    fn working_bytes(&self) -> u64 {
        0
    }

    /// The work, its cost estimated; nothing is read yet.
    ///
    /// # Errors
    /// Every parameter that does not fit, with its pointer.
    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>>;
}

/// Something that is done with the parameters of an operation whose name is known only at run time.
pub trait ByOperation {
    /// What comes of it.
    type Output;

    /// Does it with these parameters.
    fn with<P: ProgramParameters>(self) -> Self::Output;
}

/// Does something with the parameters of an operation. Every operation on programs stands here.
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

type Run = Box<dyn FnOnce(Workplace<'_>) -> Result<Finished, JobFault> + Send>;

/// Work whose parameters fit.
pub struct Prepared {
    cost: Cost,
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
        run: impl FnOnce(Workplace<'_>) -> Result<Finished, JobFault> + Send + 'static,
    ) -> Self {
        Self { cost, run: Box::new(run) }
    }
}

/// Work that may be done: its parameters fit, and it costs no more than it may.
#[derive(Debug)]
pub struct ProgramWork {
    /// What is done.
    pub operation: JobOperation,
    /// With which parameters, defaults filled in.
    pub parameters: serde_json::Value,
    /// The machine's tools that it was accepted with.
    pub shelf: ToolShelf,
    prepared: Prepared,
}

impl ProgramWork {
    /// The work that these parameters ask for.
    ///
    /// # Errors
    /// Parameters that do not fit, or work that would cost too much.
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

    /// The same for an operation by its name, its parameters as JSON text.
    ///
    /// # Errors
    /// Parameters that cannot be read or do not fit, or work that would cost too much.
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

    /// Does it, to its end or until its place says stop.
    ///
    /// # Errors
    /// Why nothing came of it.
    pub fn run(self, place: Workplace<'_>) -> Result<Finished, JobFault> {
        (self.prepared.run)(place)
    }
}
