//! The one form in which problems are sent (RFC 9457). Faults of every layer below become problems only here.

use axum::response::{IntoResponse, Response};
use http::header::{CONTENT_TYPE, RETRY_AFTER};
use http::{HeaderValue, StatusCode};
use serde::Serialize;

pub use super::problem_type::ProblemType;
use crate::description::ToSchema;
use crate::jobs::memory::MemoryFault;
use crate::jobs::{
    CompensatorFault, ComputeFault, JobFault, KinematicsFault, PartSurfaceFault, RefusalClass,
    ServoWorkFault, SpoolFault, TooCostly, WearFault,
};
use crate::servo::ServoFault;
use crate::shares::{NoShare, Quota};
use crate::store::{BlobFault, DamagedFile, StorageFault, StoreError};
use crate::wire::{Fault, FaultList, QueryFault, RowFault, Unreadable};

/// Media type of a problem document.
pub const PROBLEM_JSON: &str = "application/problem+json";

/// A problem document (RFC 9457).
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Problem)]
pub struct ProblemDocument {
    /// Stable reference of the kind of problem; it resolves to a page that explains it.
    #[serde(rename = "type")]
    #[schema(example = "/problems/invalid-request")]
    kind: String,
    /// The kind of problem in a sentence.
    #[schema(example = "A field or parameter is wrong")]
    title: &'static str,
    /// The HTTP status.
    #[schema(example = 422)]
    status: u16,
    /// Details of this occurrence.
    detail: String,
    /// Every bad value.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    errors: Vec<Fault>,
    /// Line of the upload, 1-based.
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u64>,
    /// Text of that line.
    #[serde(skip_serializing_if = "Option::is_none")]
    block: Option<String>,
    /// Index of the pose, 0-based.
    #[serde(skip_serializing_if = "Option::is_none")]
    pose: Option<usize>,
}

/// A problem on its way to the client.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem(Box<Members>);

#[derive(Debug, Clone, PartialEq)]
struct Members {
    kind: ProblemType,
    detail: String,
    errors: Vec<Fault>,
    line: Option<u64>,
    block: Option<String>,
    pose: Option<usize>,
}

impl Problem {
    /// A problem of this kind with its details.
    pub fn new(kind: ProblemType, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        Self(Box::new(Members { kind, detail, errors: Vec::new(), line: None, block: None, pose: None }))
    }

    /// A problem with the bad values of a request.
    #[must_use]
    pub fn invalid(kind: ProblemType, errors: Vec<Fault>) -> Self {
        let detail = match errors.as_slice() {
            [] => kind.title().to_owned(),
            [only] => format!("{}: {}", only.pointer, only.detail),
            many if many.len() >= FaultList::KEPT => format!("at least {} values are wrong", many.len()),
            many => format!("{} values are wrong", many.len()),
        };
        let mut problem = Self::new(kind, detail);
        problem.0.errors = errors;
        problem
    }

    /// The same problem, for this pose.
    #[must_use]
    pub fn at_pose(mut self, pose: usize) -> Self {
        self.0.pose = Some(pose);
        self
    }

    /// The same problem, about this one of several files. A problem of the request's parameters is about all of them.
    #[must_use]
    pub fn about(mut self, path: &str) -> Self {
        if self.0.errors.is_empty() {
            self.0.detail = format!("{path}: {}", self.0.detail);
        }
        self
    }

    /// There is no machine with this id.
    #[must_use]
    pub fn machine_not_found(machine_id: &str) -> Self {
        Self::new(ProblemType::MachineNotFound, format!("there is no machine {machine_id:?}"))
    }

    /// The machine has no run with this id.
    #[must_use]
    pub fn calibration_not_found(machine_id: &str, id: &str) -> Self {
        let detail = format!("machine {machine_id:?} has no calibration {id:?}");
        Self::new(ProblemType::CalibrationNotFound, detail)
    }

    /// The machine's table has no tool with this id.
    #[must_use]
    pub fn tool_not_found(machine_id: &str, tool_id: &str) -> Self {
        let detail = format!("the table of machine {machine_id:?} has no tool {tool_id:?}");
        Self::new(ProblemType::ToolNotFound, detail)
    }

    /// The tool has no wear entry with this id.
    #[must_use]
    pub fn wear_entry_not_found(tool_id: &str, id: &str) -> Self {
        let detail = format!("tool {tool_id:?} has no wear entry {id:?}");
        Self::new(ProblemType::WearEntryNotFound, detail)
    }

    /// There is no job with this id.
    #[must_use]
    pub fn job_not_found(id: &str) -> Self {
        Self::new(ProblemType::JobNotFound, format!("there is no job {id:?}"))
    }

    /// A fault of the service: it is logged here, and its cause is never sent.
    pub fn internal(cause: &dyn std::fmt::Display) -> Self {
        tracing::error!(error = %cause, "internal fault");
        Self::new(
            ProblemType::Internal,
            "the service has a fault; find its cause in the log under the request id",
        )
    }

    /// Nothing can be stored at present: the cause is logged here, and only its kind is sent.
    pub(super) fn storage(fault: StorageFault, cause: &dyn std::fmt::Display) -> Self {
        tracing::error!(error = %cause, "{fault}");
        Self::new(ProblemType::StorageUnavailable, fault.to_string())
    }

    /// The kind of the problem.
    #[must_use]
    pub fn kind(&self) -> ProblemType {
        self.0.kind
    }

    /// The document of the problem.
    #[must_use]
    pub fn into_document(self) -> ProblemDocument {
        let Members { kind, detail, errors, line, block, pose } = *self.0;
        ProblemDocument {
            kind: format!("/problems/{}", kind.code()),
            title: kind.title(),
            status: kind.status().as_u16(),
            detail,
            errors,
            line,
            block,
            pose,
        }
    }

    /// The problem document of a failed job, as it is stored with the job.
    #[must_use]
    pub fn of_job(fault: JobFault) -> serde_json::Value {
        // Strings and whole numbers can always be printed.
        serde_json::to_value(Self::from(fault).into_document()).unwrap_or_default()
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let kind = self.kind();
        let document = self.into_document();
        // Strings and whole numbers can always be printed.
        let body = serde_json::to_vec(&document).unwrap_or_default();
        let mut response = (kind.status(), body).into_response();
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(PROBLEM_JSON));
        // The request's log line names it.
        response.extensions_mut().insert(kind);
        if kind.status() == StatusCode::SERVICE_UNAVAILABLE || kind == ProblemType::Quota {
            response.headers_mut().insert(RETRY_AFTER, HeaderValue::from_static("2"));
        }
        response
    }
}

impl From<Unreadable> for Problem {
    fn from(fault: Unreadable) -> Self {
        match fault {
            Unreadable::Syntax { .. } => Self::new(ProblemType::UnreadableJson, fault.to_string()),
            Unreadable::Document(fault) => Self::invalid(ProblemType::InvalidRequest, vec![fault]),
        }
    }
}

impl From<QueryFault> for Problem {
    fn from(fault: QueryFault) -> Self {
        match fault {
            QueryFault::Encoding => Self::new(ProblemType::MalformedRequest, fault.to_string()),
            QueryFault::Parameter(fault) => Self::invalid(ProblemType::InvalidRequest, vec![fault]),
        }
    }
}

impl From<RowFault> for Problem {
    fn from(RowFault { line, faults, too_many }: RowFault) -> Self {
        let kind = if too_many { ProblemType::TooCostly } else { ProblemType::InvalidRequest };
        let mut problem = Self::invalid(kind, faults);
        problem.0.line = Some(line);
        problem
    }
}

impl From<StoreError> for Problem {
    fn from(fault: StoreError) -> Self {
        match fault {
            StoreError::Storage { fault, ref source } => Self::storage(fault, source),
            StoreError::Objects { .. } => Self::storage(StorageFault::NoBucket, &fault),
            StoreError::Busy(ref source) => {
                tracing::error!(error = %source, "the database is busy");
                Self::new(ProblemType::StorageUnavailable, fault.to_string())
            }
            StoreError::Damaged(damaged) => damaged.into(),
            StoreError::Nul => Self::new(ProblemType::InvalidRequest, fault.to_string()),
            other => Self::internal(&other),
        }
    }
}

impl From<DamagedFile> for Problem {
    fn from(fault: DamagedFile) -> Self {
        Self::new(ProblemType::StoredFileDamaged, fault.to_string())
    }
}

impl From<BlobFault> for Problem {
    fn from(fault: BlobFault) -> Self {
        let fault = match fault {
            BlobFault::Damaged(damaged) => return damaged.into(),
            BlobFault::Rows(fault) => return fault.into(),
            other => other,
        };
        match fault.storage() {
            Some(storage) => Self::storage(storage, &fault),
            None => Self::internal(&fault),
        }
    }
}

impl From<std::io::Error> for Problem {
    fn from(fault: std::io::Error) -> Self {
        if let Some(share) = fault.get_ref().and_then(|cause| cause.downcast_ref::<NoShare>()) {
            return (*share).into();
        }
        if let Some(storage) = StorageFault::of(&fault) {
            return Self::storage(storage, &fault);
        }
        // This name is only for a limit that a setting gives; a limit of the disk is a fault of the service.
        if fault.kind() == std::io::ErrorKind::FileTooLarge && fault.raw_os_error().is_none() {
            return Self::new(ProblemType::ResultTooLarge, fault.to_string());
        }
        Self::internal(&fault)
    }
}

impl From<NoShare> for Problem {
    fn from(fault: NoShare) -> Self {
        let kind = match fault {
            NoShare::OverShare { .. } => ProblemType::Quota,
            NoShare::Full { quota: Quota::QueuedJobs, .. } => ProblemType::QueueFull,
            NoShare::Full { quota: Quota::SpoolBytes, .. } => ProblemType::StorageUnavailable,
            NoShare::Full { .. } => ProblemType::Busy,
        };
        Self::new(kind, fault.to_string())
    }
}

impl From<SpoolFault> for Problem {
    fn from(fault: SpoolFault) -> Self {
        match fault {
            SpoolFault::TooLarge { .. } => Self::new(ProblemType::BodyTooLarge, fault.to_string()),
            SpoolFault::NoShare(fault) => fault.into(),
            SpoolFault::File(fault) => fault.into(),
            SpoolFault::Write(fault) => fault.into(),
        }
    }
}

impl From<ComputeFault> for Problem {
    fn from(fault: ComputeFault) -> Self {
        match fault {
            ComputeFault::Busy => Self::new(ProblemType::Busy, fault.to_string()),
            ComputeFault::Memory(fault) => fault.into(),
            ComputeFault::NoShare(fault) => fault.into(),
            ComputeFault::Panicked => Self::internal(&fault),
            ComputeFault::TooCostly { .. } => Self::new(ProblemType::TooCostly, fault.to_string()),
        }
    }
}

impl From<MemoryFault> for Problem {
    fn from(fault: MemoryFault) -> Self {
        let kind = match fault {
            MemoryFault::Never { .. } => ProblemType::BodyTooLarge,
            MemoryFault::Now { .. } => ProblemType::MemoryBudget,
        };
        Self::new(kind, fault.to_string())
    }
}

impl From<TooCostly> for Problem {
    fn from(fault: TooCostly) -> Self {
        Self::new(ProblemType::TooCostly, fault.to_string())
    }
}

impl From<KinematicsFault> for Problem {
    fn from(fault: KinematicsFault) -> Self {
        match fault {
            KinematicsFault::Values(faults) => Self::invalid(ProblemType::InvalidRequest, faults),
            KinematicsFault::TooMany { .. } => Self::new(ProblemType::TooCostly, fault.to_string()),
            KinematicsFault::TooCostly(fault) => fault.into(),
            KinematicsFault::Unreachable { pose, detail } => {
                Self::new(ProblemType::UnreachablePose, detail).at_pose(pose)
            }
            KinematicsFault::Cancelled => Self::new(ProblemType::TimedOut, fault.to_string()),
        }
    }
}

impl From<WearFault> for Problem {
    fn from(fault: WearFault) -> Self {
        match fault {
            WearFault::Values(faults) => Self::invalid(ProblemType::InvalidRequest, faults),
            WearFault::TooMany { .. } => Self::new(ProblemType::TooCostly, fault.to_string()),
            WearFault::TooCostly(fault) => fault.into(),
            WearFault::Cancelled => Self::new(ProblemType::TimedOut, fault.to_string()),
        }
    }
}

impl From<ServoWorkFault> for Problem {
    fn from(fault: ServoWorkFault) -> Self {
        match fault {
            ServoWorkFault::Servo(fault) => fault.into(),
            ServoWorkFault::TooCostly(fault) => fault.into(),
            ServoWorkFault::Compute(fault) => fault.into(),
        }
    }
}

impl From<ServoFault> for Problem {
    fn from(fault: ServoFault) -> Self {
        let at =
            |kind, pointer: String, detail: String| Self::invalid(kind, vec![Fault::new(pointer, detail)]);
        let detail = fault.to_string();
        match fault {
            ServoFault::NoDrive { axis } => {
                at(ProblemType::InvalidRequest, format!("/drives/{axis}"), detail)
            }
            ServoFault::Unstable { axis, fault } => {
                let poles: Vec<String> =
                    fault.poles_per_s.iter().map(|pole| format!("{:.9} {:+.9}i", pole.re, pole.im)).collect();
                let detail = format!("poles [1/s]: {}", poles.join(", "));
                at(ProblemType::UnstableLoop, format!("/drives/{axis}"), detail)
            }
            ServoFault::TooStiff { .. }
            | ServoFault::TooFewSamples { .. }
            | ServoFault::TooFarBehind { .. } => {
                at(ProblemType::InvalidRequest, "/sample_period_s".to_owned(), detail)
            }
            ServoFault::ThroughRotaryCenter { .. } => {
                at(ProblemType::InvalidRequest, "/path/center_x_mm".to_owned(), detail)
            }
            ServoFault::NoGainWithinMargins { .. } => {
                at(ProblemType::InvalidRequest, "/least_gain_margin".to_owned(), detail)
            }
            ServoFault::NoLength => at(ProblemType::InvalidRequest, "/path".to_owned(), detail),
            ServoFault::TooManySamples { .. } => Self::new(ProblemType::TooCostly, detail),
            ServoFault::Unreachable { .. } | ServoFault::OutOfTravel { .. } | ServoFault::Jump { .. } => {
                Self::new(ProblemType::UnreachablePose, detail)
            }
            ServoFault::Stopped => Self::new(ProblemType::TimedOut, detail),
        }
    }
}

impl From<JobFault> for Problem {
    fn from(fault: JobFault) -> Self {
        match fault {
            JobFault::Unreadable(fault) => fault.into(),
            JobFault::Parameters(faults) => Self::invalid(ProblemType::InvalidRequest, faults),
            JobFault::TooCostly(fault) => fault.into(),
            JobFault::Compute(fault) => fault.into(),
            JobFault::Compensator(fault) => fault.into(),
            JobFault::Servo(fault) => fault.into(),
            JobFault::Blob(fault) => fault.into(),
            JobFault::PartSurface(fault) => {
                let detail = fault.to_string();
                if matches!(fault, PartSurfaceFault::NoRoom { .. }) {
                    return Self::new(ProblemType::Busy, detail);
                }
                if fault.is_too_large() {
                    return Self::new(ProblemType::BodyTooLarge, detail);
                }
                Self::invalid(ProblemType::InvalidRequest, vec![Fault::new("/surface", detail)])
            }
            JobFault::Store(fault) => fault.into(),
            JobFault::NoShare(fault) => fault.into(),
            JobFault::QueueFull { .. } => Self::new(ProblemType::QueueFull, fault.to_string()),
            JobFault::ProcessDied => Self::new(ProblemType::ProcessDied, fault.to_string()),
            JobFault::MachineLost => Self::internal(&fault),
            JobFault::KeyReused => Self::new(ProblemType::KeyReused, fault.to_string()),
            JobFault::Report(fault) => Self::internal(&fault),
        }
    }
}

impl From<CompensatorFault> for Problem {
    fn from(fault: CompensatorFault) -> Self {
        let refusal = match fault {
            CompensatorFault::Refused(refusal) => *refusal,
            CompensatorFault::Cancelled => return Self::new(ProblemType::TimedOut, fault.to_string()),
            CompensatorFault::Io(fault) => return fault.into(),
            CompensatorFault::VerificationFailed { .. } | CompensatorFault::HeadMisled => {
                return Self::internal(&fault);
            }
        };
        let kind = match refusal.class {
            RefusalClass::Program => ProblemType::ProgramFault,
            RefusalClass::ToleranceOutOfReach => ProblemType::ToleranceOutOfReach,
            RefusalClass::OutOfTravel => ProblemType::OutOfTravel,
            RefusalClass::Parameter => ProblemType::InvalidRequest,
            RefusalClass::TooCostly => ProblemType::TooCostly,
            RefusalClass::UnitUnknown => ProblemType::UnitUnknown,
            RefusalClass::AlreadyCompensated => ProblemType::AlreadyCompensated,
        };
        let mut problem = Self::new(kind, refusal.detail);
        problem.0.errors = refusal.errors;
        problem.0.line = refusal.line;
        problem.0.block = refusal.block;
        problem
    }
}
