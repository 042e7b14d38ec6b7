//! A job as it is asked for: read before its program, made into work once the program is there.

use serde::de::IgnoredAny;

use crate::jobs::work::{ByOperation, by_operation};
use crate::jobs::{JobFault, MachineUsed, Means, ProgramParameters, ProgramWork, Sizes};
use crate::program::Steps;
use crate::wire::{Fault, FaultList, JobOperation, JobRequest, Unreadable, read_json};

/// A job as it is asked for, readable in every part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobOrder {
    /// The machine.
    pub machine_id: String,
    /// What is to be computed.
    pub operation: JobOperation,
    /// The client's own id.
    pub external_id: Option<String>,
    /// Who is told of the end.
    pub callback_url: Option<String>,
    /// Whether the operation looks at the part's surface.
    pub looks_at_part: bool,
    /// The steps that must not be done twice.
    pub steps: Steps,
    /// The cutter whose wear entries count, where its wear is theirs.
    pub cutter_id: Option<String>,
    /// The whole order with its defaults filled in, the same for orders that say the same.
    pub canonical: String,
    text: Vec<u8>,
}

impl JobOrder {
    /// Reads an order.
    ///
    /// # Errors
    /// It cannot be read, or something outside its parameters does not fit.
    pub fn read(text: &[u8]) -> Result<Self, JobFault> {
        // The operation says what its parameters are.
        let head = read_json::<JobRequest<IgnoredAny>>(text)?;
        let mut faults = FaultList::default();
        head.check(&mut faults);
        faults.into_result().map_err(JobFault::Parameters)?;
        let Read { looks_at_part, steps, cutter_id, canonical } = by_operation(head.operation, Whole(text))?;
        Ok(Self {
            machine_id: head.machine_id,
            operation: head.operation,
            external_id: head.external_id,
            callback_url: head.callback_url,
            looks_at_part,
            steps,
            cutter_id,
            canonical,
            text: text.to_owned(),
        })
    }

    /// The work it asks for.
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

/// What is known of an order once its parameters are read.
struct Read {
    looks_at_part: bool,
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
