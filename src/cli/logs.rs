//! Structured logs on standard error.

use std::io::{IsTerminal, Stderr, stderr};

use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt;
use tracing_subscriber::prelude::*;

use super::log_fields::PlainFields;
use super::log_lines::{LogLines, WrittenAtEnd};
use super::log_text::{LineTime, TextLines};
use crate::config::{LogFormat, Settings};

/// Sets the process's log writer; the log is complete when the returned value is dropped. A second call changes
/// nothing, so tests may start several services. The directives were checked with the settings; an unreadable one
/// counts as `info`.
///
/// # Errors
/// The thread that writes cannot be started.
pub(super) fn open(settings: &Settings) -> std::io::Result<WrittenAtEnd<Stderr>> {
    let filter = settings.log.parse().unwrap_or_else(|_| Targets::new().with_default(LevelFilter::INFO));
    let registry = tracing_subscriber::registry();
    let log = LogLines::new(stderr())?;
    let lines = fmt::layer().with_ansi(stderr().is_terminal()).with_writer(log.clone());
    let opened = match settings.log_format {
        LogFormat::Text => {
            let lines = lines.fmt_fields(PlainFields).event_format(TextLines::new(LineTime));
            registry.with(filter).with(lines).try_init()
        }
        LogFormat::Json => registry.with(filter).with(lines.with_timer(LineTime).json()).try_init(),
    };
    match (opened.is_ok(), settings.log_format) {
        (true, LogFormat::Text) => log.written_before_panics(),
        (true, LogFormat::Json) => panics_as_lines(),
        (false, _) => {}
    }
    Ok(log.written_at_end())
}

/// Reports a panic as a line of the log, in place of the text of the standard library.
fn panics_as_lines() {
    std::panic::set_hook(Box::new(|panic| {
        let (place, text) = (panic.location().map(ToString::to_string), panic.payload_as_str());
        // An error is written at once, with all lines before it.
        tracing::error!(place, text, "a thread panicked");
    }));
}
