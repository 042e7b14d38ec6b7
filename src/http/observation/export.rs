//! The export of request spans, in addition to the log.

use std::fmt;
use std::time::Duration;

use http::StatusCode;

use super::Trace;

/// A request that has been answered, as a span of its trace.
#[derive(Debug, Clone, Copy)]
pub struct FinishedSpan<'a> {
    /// Its position in the trace.
    pub trace: Trace,
    /// Id of the operation.
    pub operation: &'a str,
    /// HTTP method of the request.
    pub method: &'static str,
    /// Pattern of the path, if one matched.
    pub route: Option<&'a str>,
    /// Status of the answer; `None` if the client left before.
    pub status: Option<StatusCode>,
    /// Time from the header of the request to the header of the answer.
    pub elapsed: Duration,
    /// Time at which the answer began.
    pub ended_at: jiff::Timestamp,
    /// Id of the request.
    pub request_id: &'a str,
    /// The machine that its path names.
    pub machine_id: Option<&'a str>,
    /// The job that the request concerns or has created.
    pub job_id: Option<&'a str>,
}

/// Takes spans and passes them on. It neither waits nor keeps more than a limited number.
pub trait Exporter: Send + Sync + fmt::Debug {
    /// A span has just ended.
    fn export(&self, span: &FinishedSpan<'_>);

    /// Passes on the remaining spans, for a short time at most. It may block.
    fn close(&self);
}
