//! A requested job: it is read before its program, and becomes work after the program has arrived.

use serde::de::IgnoredAny;

use crate::jobs::work::{ByOperation, by_operation};
use crate::jobs::{JobFault, MachineUsed, Means, ProgramParameters, ProgramWork, Sizes};
use crate::program::Steps;
use crate::wire::{Fault, FaultList, JobOperation, JobRequest, Unreadable, read_json};

/// A requested job; every part of it could be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobOrder {
    /// The machine.
    pub machine_id: String,
    /// The operation.
    pub operation: JobOperation,
    /// The client's own id.
    pub external_id: Option<String>,
    /// Address of the webhook about its end.
    pub callback_url: Option<String>,
    /// Whether the operation uses the part's surface.
    pub looks_at_part: bool,
    /// Whether the program may come with files that it calls.
    pub calls_files: bool,
    /// The steps that must not be applied twice.
    pub steps: Steps,
    /// The cutter whose wear entries are used, if the wear comes from entries.
    pub cutter_id: Option<String>,
    /// The whole order with defaults filled in; equal orders have equal text.
    pub canonical: String,
    text: Vec<u8>,
}

impl JobOrder {
    /// Reads an order.
    ///
    /// # Errors
    /// It cannot be read, or a member outside its parameters is wrong.
    pub fn read(text: &[u8]) -> Result<Self, JobFault> {
        // The operation determines the type of its parameters.
        let head = read_json::<JobRequest<IgnoredAny>>(text)?;
        let mut faults = FaultList::default();
        head.check(&mut faults);
        faults.into_result().map_err(JobFault::Parameters)?;
        let Read { looks_at_part, calls_files, steps, cutter_id, canonical } =
            by_operation(head.operation, Whole(text))?;
        Ok(Self {
            machine_id: head.machine_id,
            operation: head.operation,
            external_id: head.external_id,
            callback_url: head.callback_url,
            looks_at_part,
            calls_files,
            steps,
            cutter_id,
            canonical,
            text: text.to_owned(),
        })
    }

    /// The work of the order.
    ///
    /// # Errors
    /// Parameters that do not fit, by their pointers into the order, or work that would cost too much.
    pub fn work(&self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<ProgramWork, JobFault> {
        let made = by_operation(self.operation, Work { text: &self.text, on, sizes, means });
        made.map_err(|fault| match fault {
            JobFault::Parameters(faults) => JobFault::Parameters(faults.into_iter().map(within).collect()),
            other => other,
        })
    }
}

fn within(fault: Fault) -> Fault {
    Fault { pointer: format!("/parameters{}", fault.pointer), ..fault }
}

struct Whole<'a>(&'a [u8]);

/// The properties of an order after its parameters were read.
struct Read {
    looks_at_part: bool,
    calls_files: bool,
    steps: Steps,
    cutter_id: Option<String>,
    canonical: String,
}

impl ByOperation for Whole<'_> {
    type Output = Result<Read, JobFault>;

    fn with<P: ProgramParameters>(self) -> Self::Output {
        let request: JobRequest<P> = read_json(self.0)?;
        let parameters = &request.parameters;
        Ok(Read {
            looks_at_part: P::LOOKS_AT_PART,
            calls_files: P::CALLS_FILES,
            steps: parameters.steps(),
            cutter_id: parameters.cutter_id().map(str::to_owned),
            canonical: serde_json::to_string(&request)?,
        })
    }
}

struct Work<'a> {
    text: &'a [u8],
    on: MachineUsed,
    sizes: Sizes,
    means: &'a Means,
}

impl ByOperation for Work<'_> {
    type Output = Result<ProgramWork, JobFault>;

    fn with<P: ProgramParameters>(self) -> Self::Output {
        let request: Result<JobRequest<P>, Unreadable> = read_json(self.text);
        ProgramWork::new(request?.parameters, self.on, self.sizes, self.means)
    }
}
