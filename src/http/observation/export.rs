//! Where the spans of requests go besides the log.

use std::fmt;
use std::time::Duration;

use http::StatusCode;

use super::Trace;

/// A request that has been answered, as a span of its trace.
#[derive(Debug, Clone, Copy)]
pub struct FinishedSpan<'a> {
    /// Where it stands in its trace.
    pub trace: Trace,
    /// Id of the operation.
    pub operation: &'a str,
    /// Method of the request.
    pub method: &'static str,
    /// Pattern of the path, where it met one.
    pub route: Option<&'a str>,
    /// How it was answered; none where the client left before.
    pub status: Option<StatusCode>,
    /// From the header of the request to the header of the answer.
    pub elapsed: Duration,
    /// When the answer began.
    pub ended_at: jiff::Timestamp,
    /// Id of the request.
    pub request_id: &'a str,
    /// The machine that its path names.
    pub machine_id: Option<&'a str>,
    /// The job that it is about or has made.
    pub job_id: Option<&'a str>,
}

/// Takes spans and gives them on; it neither waits nor keeps more than a bounded number.
pub trait Exporter: Send + Sync + fmt::Debug {
    /// A span has ended just now.
    fn export(&self, span: &FinishedSpan<'_>);

    /// Gives on what is left, for a moment at most. It may block.
    fn close(&self);
}
