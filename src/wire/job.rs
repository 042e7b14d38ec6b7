//! A job as clients see it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{CallbackUrl, Fault, FaultList};

/// What a job computes.
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
    /// Compensation in one pass.
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

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for its turn.
    Queued,
    /// Is being computed.
    Running,
    /// Done; program and report are there.
    Succeeded,
    /// Refused; the problem says why.
    Failed,
    /// Cancelled by the client.
    Cancelled,
}

impl JobState {
    /// Whether it never changes again.
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

/// A job: what was asked, of which machine, of which bytes, and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = Job)]
pub struct JobDocument {
    /// `UUIDv7`.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// The machine.
    #[schema(example = "example-ac-table")]
    pub machine_id: String,
    /// Revision of the machine it was computed on.
    pub machine_revision: i64,
    /// What was computed.
    pub operation: JobOperation,
    /// With which parameters, defaults filled in.
    #[schema(value_type = Object)]
    pub parameters: serde_json::Value,
    /// Where it stands.
    pub state: JobState,
    /// Done share, 0 to 1.
    #[schema(minimum = 0.0, maximum = 1.0)]
    pub progress: f64,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// SHA-256 of the part's surface, where one was uploaded.
    pub surface_sha256: Option<String>,
    /// SHA-256 of the resulting program, or of a verification's table of residuals.
    pub output_sha256: Option<String>,
    /// SHA-256 of the table of changes, where the operation makes one.
    pub changes_sha256: Option<String>,
    /// The client's own id.
    pub external_id: Option<String>,
    /// Who is told of its end.
    #[schema(example = "https://mes.example.com/trunnion")]
    pub callback_url: Option<String>,
    /// Computations begun; an orderly stop of the service takes back the one under way.
    pub attempts: i64,
    /// Why it failed: a problem document.
    #[schema(value_type = Option<Object>)]
    pub problem: Option<serde_json::Value>,
    /// Version of the service.
    pub software_version: String,
    /// When it was asked for.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub created_at: String,
    /// When its computation began.
    pub started_at: Option<String>,
    /// When it ended.
    pub finished_at: Option<String>,
}

/// A job as it is asked for; `P` are the parameters of its operation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobRequest<P> {
    /// The machine; its current revision is used.
    pub machine_id: String,
    /// What is to be computed.
    pub operation: JobOperation,
    /// The same as of the operation's own endpoint.
    pub parameters: P,
    /// The client's own id, 1 to 200 characters.
    #[serde(default)]
    pub external_id: Option<String>,
    /// Who is told of the job's end, an `http` or `https` address.
    #[serde(default)]
    pub callback_url: Option<String>,
}

/// Longest id of the client's own \[characters\].
const MAX_EXTERNAL_ID: usize = 200;

impl<P> JobRequest<P> {
    /// Finds what is wrong outside the parameters.
    pub fn check(&self, faults: &mut FaultList) {
        if let Some(id) = &self.external_id
            && (!(1..=MAX_EXTERNAL_ID).contains(&id.chars().count()) || id.chars().any(char::is_control))
        {
            let detail =
                format!("not a text of 1 to {MAX_EXTERNAL_ID} characters without control characters");
            faults.push(|| Fault::new("/external_id", detail));
        }
        if let Some(Err(fault)) = self.callback_url.as_deref().map(str::parse::<CallbackUrl>) {
            faults.push(|| Fault::new("/callback_url", fault.to_string()));
        }
    }
}
