//! The public catalogue of problems.

use http::StatusCode;

macro_rules! catalogue {
    ($($variant:ident = $status:ident, $code:literal, $title:literal, $doc:literal;)+) => {
        /// Every kind of problem that this service answers with.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum ProblemType {
            $(#[doc = $title] $variant,)+
        }

        impl ProblemType {
            /// The whole catalogue.
            pub const ALL: &'static [Self] = &[$(Self::$variant,)+];

            /// Status, last part of the type's reference, title, and advice to the caller.
            #[must_use]
            pub const fn entry(self) -> (StatusCode, &'static str, &'static str, &'static str) {
                match self {
                    $(Self::$variant => (StatusCode::$status, $code, $title, $doc),)+
                }
            }
        }
    };
}

catalogue! {
    MalformedRequest = BAD_REQUEST, "malformed-request", "The request is malformed",
        "A header, the query or the body's framing cannot be read: a bad entity tag, a query that is not percent-encoded UTF-8, a body that ends early or does not decompress. Correct the request; the service will always refuse the same bytes.";
    UnreadableJson = BAD_REQUEST, "unreadable-json", "The body is not JSON",
        "The text is not JSON; the detail says where the fault is. NaN and Infinity are not JSON.";
    Unauthenticated = UNAUTHORIZED, "unauthenticated", "A valid API key is needed",
        "Send Authorization: Bearer with a key of this service. The detail says whether the key was missing, unknown, revoked or expired.";
    ScopeMissing = FORBIDDEN, "scope-missing", "The API key does not allow this",
        "The detail names the scope that the operation needs. Ask for a key that has it.";
    ForeignPage = FORBIDDEN, "foreign-page", "The request comes from a page of another site",
        "A service without API keys trusts the programs on its own computer, but a browser there may show a page of another site. Use an IP address or localhost, or create a key.";
    MachineNotAllowed = FORBIDDEN, "machine-not-allowed", "The API key is for other machines",
        "The key is limited to a list of machines, and this machine is not in it. Use another key.";
    NotFound = NOT_FOUND, "not-found", "There is nothing at this address",
        "No operation has this path. The page /docs lists all operations.";
    MachineNotFound = NOT_FOUND, "machine-not-found", "There is no such machine",
        "No machine has this id, or it was deleted. GET /v1/machines lists them.";
    RevisionNotFound = NOT_FOUND, "revision-not-found", "There is no such revision",
        "The machine or the tool never had this revision. GET /v1/machines/{machine_id}/revisions lists them; those of a tool are listed under the tool's own address.";
    ToolNotFound = NOT_FOUND, "tool-not-found", "There is no such tool in the machine's table",
        "The machine's table has no tool with this id, or it was deleted. GET /v1/machines/{machine_id}/tools lists them. Wear entries need no tool in the table.";
    CalibrationNotFound = NOT_FOUND, "calibration-not-found", "There is no such calibration run",
        "The machine has no run with this id. GET /v1/machines/{machine_id}/calibrations lists them.";
    WearEntryNotFound = NOT_FOUND, "wear-entry-not-found", "There is no such wear entry",
        "The tool has no entry with this id. GET /v1/machines/{machine_id}/tools/{tool_id}/wear-entries lists them.";
    JobNotFound = NOT_FOUND, "job-not-found", "There is no such job",
        "No job has this id. GET /v1/jobs lists them.";
    KeyNotFound = NOT_FOUND, "key-not-found", "There is no such API key",
        "No key has this id. GET /v1/keys lists them.";
    ResultNotFound = NOT_FOUND, "result-not-found", "The job has no such result",
        "The job's operation makes no program, table or residuals of this kind. Its report is at /v1/jobs/{id}/report.";
    JobNotSucceeded = CONFLICT, "job-not-succeeded", "The job has no result",
        "The job is waiting or running, or it failed or was cancelled: the detail says which. GET /v1/jobs/{id} gives its state and, if it failed, the reason.";
    JobEnded = CONFLICT, "job-ended", "The job has ended",
        "A job that has succeeded or failed can no longer be cancelled. Its result stays.";
    NothingToDeliver = CONFLICT, "nothing-to-deliver", "There is nothing to deliver",
        "The job was posted without callback_url, or it has not ended yet: the detail says which.";
    MethodNotAllowed = METHOD_NOT_ALLOWED, "method-not-allowed", "The resource does not have this method",
        "The Allow header names the methods it has.";
    NotAcceptable = NOT_ACCEPTABLE, "not-acceptable", "No representation fits the Accept header",
        "The detail names the available media types.";
    RequestTimeout = REQUEST_TIMEOUT, "request-timeout", "The body stopped arriving",
        "No byte of the body arrived for too long. Send it again.";
    KeyReused = CONFLICT, "idempotency-key-reused", "The idempotency key was used for another request",
        "The Idempotency-Key was first used with another body, query or path. Use a new key for a new request.";
    ConfirmationNeeded = CONFLICT, "confirmation-needed", "The change is large or uncertain, and not confirmed",
        "Applying the run would change a location error by more than 0.2 mm or 1000 µrad, or the run does not determine all errors. Each entry of errors names one such change or error. Check them; if you want to apply them, send {\"confirm\": true}.";
    AxesChanged = CONFLICT, "axes-changed", "The run measured other axes",
        "Since the run, the machine's nominal rotary axes have changed, or the location error of an axis that carries the measured axis. The errors of the run are no longer valid. Measure again, or restore the axes that were measured in the profile.";
    ToolNameTaken = CONFLICT, "tool-name-taken", "Another tool of the machine has this number or this name",
        "A program's call must mean exactly one tool. So two tools of a machine cannot have the same number or the same name; upper and lower case count as the same. Each entry of errors names the other tool. Change one of the two, or delete the other tool.";
    ToolTableFull = CONFLICT, "tool-table-full", "The machine has the largest allowed number of tools",
        "The detail gives the limit (max_tools_per_machine). Delete tools that are no longer used, or raise the limit.";
    AlreadyCompensated = CONFLICT, "already-compensated", "The step was done to this program before",
        "The program has the stamp of a requested step, or it equals an earlier output of such a step: the detail names the step. Wear or location errors compensated twice would move every end twice. Send the program as it was before the step; allow_repeated lets the steps cc and singularity run again.";
    AlreadyWithdrawn = CONFLICT, "already-withdrawn", "The entry was withdrawn for another reason",
        "The detail says when and why. A withdrawn entry stays as it is; post the right numbers as a new entry.";
    PreconditionFailed = PRECONDITION_FAILED, "precondition-failed", "The resource is not in the expected state",
        "If-Match names a revision that is not the current one, or If-None-Match: * was sent but the machine or tool exists. Read it again, then decide again.";
    PreconditionRequired = PRECONDITION_REQUIRED, "precondition-required", "If-Match is needed",
        "To replace or delete a machine or a tool, send the If-Match header with the ETag of the revision that you read.";
    BodyTooLarge = PAYLOAD_TOO_LARGE, "body-too-large", "The body is too large",
        "The detail names the limit. It counts bytes after decompression. A body that unpacks to far more bytes than a program normally does is refused too: send it without compression, or in parts.";
    UrlTooLong = URI_TOO_LONG, "url-too-long", "The address is too long",
        "Path and query together are longer than the limit that the detail names. Send long parameters in the body, as the form field parameters.";
    HeaderTooLarge = REQUEST_HEADER_FIELDS_TOO_LARGE, "header-too-large", "The header is too large",
        "All header fields together are longer than the limit that the detail names.";
    TooManyRequests = TOO_MANY_REQUESTS, "too-many-requests", "Too many requests from one caller",
        "The caller, identified by its key or without a key by its address, sends more requests than the service is set to answer. Retry after the time that Retry-After names.";
    Quota = TOO_MANY_REQUESTS, "quota", "The caller holds its full share",
        "One caller, identified by its key or without a key by its address, may hold only a part of what the others leave (max_share_per_caller), so that all callers find room. The detail names the shared resource, how much of it the caller holds, how much it may hold now, and how to make room. Nothing was stored. Retry after the time that Retry-After names.";
    UnsupportedMediaType = UNSUPPORTED_MEDIA_TYPE, "unsupported-media-type", "The body's media type or coding does not fit",
        "The detail names the media types that the operation accepts. Content codings are gzip and zstd.";
    RangeNotSatisfiable = RANGE_NOT_SATISFIABLE, "range-not-satisfiable", "The range is beyond the end",
        "The Range header asks for bytes that the resource does not have. Content-Range names its length.";
    InvalidRequest = UNPROCESSABLE_ENTITY, "invalid-request", "A field or parameter is wrong",
        "A value is unknown, missing, of the wrong type or out of its range. Each entry of errors gives its location as a JSON pointer; the dotted name of a query parameter is written as a pointer too.";
    InvalidMachine = UNPROCESSABLE_ENTITY, "invalid-machine", "The profile does not describe a five-axis machine",
        "Each entry of errors names a fault of the profile by JSON pointer.";
    UnreachablePose = UNPROCESSABLE_ENTITY, "unreachable-pose", "A pose cannot be reached",
        "The member pose is the index of the first such pose, from 0: the rotary axes cannot tilt the tool in this direction, or every solution is outside the travel.";
    ProgramFault = UNPROCESSABLE_ENTITY, "program-fault", "The program cannot be followed",
        "The members line and block name the first faulty line of the upload. errors lists the faults, at most 100. Nothing was stored.";
    UnitUnknown = UNPROCESSABLE_ENTITY, "unit-unknown", "The unit of the program is not known",
        "The program states neither millimetres nor inches before its first length; the member line names the block. Give unit as mm or inch, write it into the program (G20 G21, G70 G71, BEGIN PGM … MM, UNITS/), or state program_unit in the machine's profile.";
    OutOfTravel = UNPROCESSABLE_ENTITY, "out-of-travel", "The program leaves the machine's travel",
        "The members line and block name the first such line of the upload. Nothing was stored.";
    ToleranceOutOfReach = UNPROCESSABLE_ENTITY, "tolerance-out-of-reach", "The program's decimals cannot keep the tolerance",
        "Words keep the decimals of the source block; the detail gives the tolerance that they can keep. Request that tolerance, or post the program with more decimals.";
    UnstableLoop = UNPROCESSABLE_ENTITY, "unstable-loop", "A servo loop is unstable",
        "A closed loop has a pole that does not decay, so it cannot be simulated. Each entry of errors names an axis and its poles. Lower the position gain or the velocity gain.";
    ControlDoesNotFit = UNPROCESSABLE_ENTITY, "control-does-not-fit", "The control cannot represent these axes",
        "The control's published kinematics cannot represent this machine's axes. Each entry of errors gives a reason. The neutral format iso230 works for every machine.";
    TooCostly = UNPROCESSABLE_ENTITY, "too-costly", "The computation would cost too much",
        "The service estimates the work before it starts and counts it while it runs. The detail gives the number, the limit and how to reduce it. Split the request, or raise max_cost_s.";
    ResultTooLarge = UNPROCESSABLE_ENTITY, "result-too-large", "The result would be too large",
        "The result of the request is longer than the limit that the detail names. Nothing was stored. Split the request, or raise the limit.";
    Internal = INTERNAL_SERVER_ERROR, "internal", "The service has a fault",
        "This is a defect of the service, not of the request. Find its log lines with the X-Request-Id header.";
    StoredFileDamaged = INTERNAL_SERVER_ERROR, "stored-file-damaged", "Stored data is damaged",
        "A program, a surface, a table or a report does not match its SHA-256, or is missing. The service neither sends it nor computes with it. The detail gives the expected digest, and the length and digest that were found. Restore it from a backup, and run trunnion doctor, which lists all damaged data. You can also post a program again: the same bytes replace the damaged ones.";
    ProcessDied = INTERNAL_SERVER_ERROR, "process-died", "The process ended while it computed the job",
        "The process ended unexpectedly three times while it computed this job beside other work, then five times while it computed this job alone. The job is not tried again. Its program is kept; report the defect with it.";
    QueueFull = SERVICE_UNAVAILABLE, "queue-full", "The queue is full",
        "The jobs of the request would exceed the largest allowed number of waiting jobs (max_queued_jobs). Retry after the time that Retry-After names; use the same Idempotency-Key, so that the job is created only once.";
    Busy = SERVICE_UNAVAILABLE, "busy", "All computation places are busy",
        "All places of the computation pool are taken. Retry after the time that Retry-After names.";
    MemoryBudget = SERVICE_UNAVAILABLE, "memory-budget", "There is no memory for the request now",
        "All requests share a memory budget (max_memory_bytes), and one caller gets a part of it. The detail says what the request needs, what the caller's other requests hold and what is free. Retry after the time that Retry-After names, ask for less at once, or send fewer requests side by side.";
    TimedOut = SERVICE_UNAVAILABLE, "timed-out", "The request took too long",
        "The computation was stopped and nothing was stored. Retry later, or split the request.";
    StorageUnavailable = SERVICE_UNAVAILABLE, "storage-unavailable", "Nothing can be stored now",
        "The disk is full, read-only or failing, or the database does not answer: the detail says which. Nothing was stored. Retry after the time that Retry-After names.";
    ShuttingDown = SERVICE_UNAVAILABLE, "shutting-down", "The service is stopping",
        "The service is stopping and takes no new requests. Retry after the time that Retry-After names.";
}

impl ProblemType {
    /// HTTP status.
    #[must_use]
    pub const fn status(self) -> StatusCode {
        self.entry().0
    }
    /// Last part of the type's reference.
    #[must_use]
    pub const fn code(self) -> &'static str {
        self.entry().1
    }
    /// Short sentence that never changes.
    #[must_use]
    pub const fn title(self) -> &'static str {
        self.entry().2
    }
    /// What the problem means, and what the caller should do next.
    #[must_use]
    pub const fn doc(self) -> &'static str {
        self.entry().3
    }
    /// The type with this code.
    #[must_use]
    pub fn from_code(code: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.code() == code)
    }
    /// The problem for a bare status.
    pub(super) fn of_status(status: StatusCode) -> Self {
        match status {
            StatusCode::UNAUTHORIZED => Self::Unauthenticated,
            StatusCode::FORBIDDEN => Self::ScopeMissing,
            StatusCode::NOT_FOUND => Self::NotFound,
            StatusCode::METHOD_NOT_ALLOWED => Self::MethodNotAllowed,
            StatusCode::REQUEST_TIMEOUT => Self::RequestTimeout,
            StatusCode::PAYLOAD_TOO_LARGE => Self::BodyTooLarge,
            StatusCode::URI_TOO_LONG => Self::UrlTooLong,
            StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE => Self::HeaderTooLarge,
            StatusCode::TOO_MANY_REQUESTS => Self::TooManyRequests,
            StatusCode::UNSUPPORTED_MEDIA_TYPE => Self::UnsupportedMediaType,
            StatusCode::SERVICE_UNAVAILABLE => Self::Busy,
            other if other.is_client_error() => Self::MalformedRequest,
            _ => Self::Internal,
        }
    }
}
