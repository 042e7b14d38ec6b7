//! Observation of requests: a span and a log line for each, its trace, counts and times.

mod export;
mod metrics_text;
mod operations;
mod subject;
mod traceparent;

pub use export::{Exporter, FinishedSpan};
pub(super) use metrics_text::{Calibrations, Readings, metrics_text};
pub(super) use operations::{Operations, Series};
pub(super) use subject::Subject;
pub(super) use traceparent::TRACE_ID;
pub use traceparent::Trace;
