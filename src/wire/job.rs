//! A job as clients see it.

use serde::{Deserialize, Serialize};

use super::{CallbackUrl, Fault, FaultList};
use crate::description::ToSchema;

/// The computation of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JobOperation {
    /// Compensation of the CC path.
    CcCompensation,
    /// Simulation of the servo drives along a program.
    ServoSimulation,
    /// Compensation of a program for a worn cutter.
    WearCompensation,
    /// Virtual cutting of the part's surface.
    Verification,
    /// Compensation with several steps in one pass.
    Compensation,
    /// Posting of cutter location data to the machine.
    Posting,
}

impl JobOperation {
    /// The word on the wire.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::CcCompensation => "cc-compensation",
            Self::ServoSimulation => "servo-simulation",
            Self::WearCompensation => "wear-compensation",
            Self::Verification => "verification",
            Self::Compensation => "compensation",
            Self::Posting => "posting",
        }
    }
}

/// State of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// The job waits for its turn.
    Queued,
    /// The job is being computed.
    Running,
    /// The job is done; program and report are ready.
    Succeeded,
    /// The job failed; `problem` gives the reason.
    Failed,
    /// The client cancelled the job.
    Cancelled,
}

impl JobState {
    /// Every final state.
    pub const ENDS: [Self; 3] = [Self::Succeeded, Self::Failed, Self::Cancelled];

    /// Whether this state is final.
    #[must_use]
    pub const fn is_final(self) -> bool {
        matches!(self, Self::Succeeded | Self::Failed | Self::Cancelled)
    }

    /// The word on the wire.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Running => "running",
            Self::Succeeded => "succeeded",
            Self::Failed => "failed",
            Self::Cancelled => "cancelled",
        }
    }
}

/// A job: the operation, the machine, the uploaded bytes and the result.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = Job)]
pub struct JobDocument {
    /// `UUIDv7`.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// The machine.
    #[schema(example = "example-ac-table")]
    pub machine_id: String,
    /// Revision of the machine that was used.
    pub machine_revision: i64,
    /// The operation that was computed.
    pub operation: JobOperation,
    /// Parameters of the operation, with defaults filled in.
    #[schema(value_type = Object)]
    pub parameters: serde_json::Value,
    /// State of the job.
    pub state: JobState,
    /// Completed share, 0 to 1.
    #[schema(minimum = 0.0, maximum = 1.0)]
    pub progress: f64,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// SHA-256 of the part's surface, if one was uploaded.
    pub surface_sha256: Option<String>,
    /// SHA-256 of the resulting program, or of the table of residuals of a verification.
    pub output_sha256: Option<String>,
    /// SHA-256 of the table of changes, if the operation makes one.
    pub changes_sha256: Option<String>,
    /// The client's own id.
    pub external_id: Option<String>,
    /// Address that gets a webhook when the job ends.
    #[schema(example = "https://mes.example.com/trunnion")]
    pub callback_url: Option<String>,
    /// Number of computations that were started; an orderly stop of the service does not count.
    pub attempts: i64,
    /// A problem document with the reason why the job failed.
    #[schema(value_type = Option<Object>)]
    pub problem: Option<serde_json::Value>,
    /// Version of the service.
    pub software_version: String,
    /// Time at which the job was accepted.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub created_at: String,
    /// Time at which the computation started.
    pub started_at: Option<String>,
    /// Time at which the job ended.
    pub finished_at: Option<String>,
}

/// A job of an archive.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct BatchedJob {
    /// Path of the program in the archive.
    #[schema(example = "op20/blade.nc")]
    pub path: String,
    /// Its job.
    pub job: JobDocument,
}

/// The jobs of an archive.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct JobBatch {
    /// A job for each program, in the order of the archive. A request that is repeated with its key gets those that
    /// are still stored.
    pub items: Vec<BatchedJob>,
    /// Files of the archive that are not programs: hidden files, and those below `__MACOSX`.
    #[schema(example = json!([]))]
    pub left_out: Vec<String>,
}

/// Request for a job; `P` is the type of the operation's parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobRequest<P> {
    /// Id of the machine; its current revision is used.
    pub machine_id: String,
    /// The operation to compute.
    pub operation: JobOperation,
    /// Parameters, the same as at the operation's own endpoint.
    pub parameters: P,
    /// The client's own id, 1 to 200 characters.
    #[serde(default)]
    pub external_id: Option<String>,
    /// Address that gets a webhook when the job ends; an `http` or `https` address.
    #[serde(default)]
    pub callback_url: Option<String>,
}

/// Longest client id of a job \[characters\].
const MAX_EXTERNAL_ID: usize = 200;

impl<P> JobRequest<P> {
    /// Reports the faults outside the parameters.
    pub fn check(&self, faults: &mut FaultList) {
        if let Some(id) = &self.external_id
            && (!(1..=MAX_EXTERNAL_ID).contains(&id.chars().count()) || id.chars().any(char::is_control))
        {
            let detail =
                format!("external_id must have 1 to {MAX_EXTERNAL_ID} characters and no control characters");
            faults.push(|| Fault::new("/external_id", detail));
        }
        if let Some(Err(fault)) = self.callback_url.as_deref().map(str::parse::<CallbackUrl>) {
            faults.push(|| Fault::new("/callback_url", fault.to_string()));
        }
    }
}
