//! Fields of log lines as text: the same bytes as the library writes, without its styles. A terminal shows styles; a
//! file has none, but the library sets two empty ones for each field, which takes half of the time of a line.

use std::error::Error;
use std::fmt::{self, Debug};

use tracing::field::{Field, Visit};
use tracing_subscriber::field::{RecordFields, VisitOutput};
use tracing_subscriber::fmt::FormatFields;
use tracing_subscriber::fmt::format::{DefaultVisitor, Writer};

/// Writes fields as text.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlainFields;

impl<'w> FormatFields<'w> for PlainFields {
    fn format_fields<R: RecordFields>(&self, writer: Writer<'w>, fields: R) -> fmt::Result {
        let mut plain = Plain { writer, is_first: true, written: Ok(()) };
        fields.record(&mut plain);
        plain.written
    }
}

struct Plain<'w> {
    writer: Writer<'w>,
    is_first: bool,
    written: fmt::Result,
}

impl Plain<'_> {
    /// Whether a field is only its name and its value.
    fn is_plain(&self, field: &Field) -> bool {
        let name = field.name();
        !self.writer.has_ansi_escapes()
            && name != "message"
            && !name.starts_with("r#")
            && !name.starts_with("log.")
    }

    /// Writes a plain field.
    fn write(&mut self, field: &Field, value: impl FnOnce(&mut Writer<'_>) -> fmt::Result) {
        if self.written.is_ok() {
            let separator = if self.is_first { "" } else { " " };
            self.is_first = false;
            let writer = &mut self.writer;
            self.written = writer
                .write_str(separator)
                .and_then(|()| writer.write_str(field.name()))
                .and_then(|()| writer.write_str("="))
                .and_then(|()| value(writer));
        }
    }

    /// Leaves a field to the library.
    fn leave(&mut self, record: impl FnOnce(&mut DefaultVisitor<'_>)) {
        if self.written.is_ok() {
            let mut library = DefaultVisitor::new(self.writer.by_ref(), self.is_first);
            record(&mut library);
            self.written = library.finish();
            self.is_first = false;
        }
    }
}

impl Visit for Plain<'_> {
    fn record_str(&mut self, field: &Field, value: &str) {
        if !self.is_plain(field) {
            return self.leave(|library| library.record_str(field, value));
        }
        let as_it_is = |byte: u8| matches!(byte, b' '..=b'~') && byte != b'"' && byte != b'\\';
        self.write(field, |writer| {
            if !value.bytes().all(as_it_is) {
                return write!(writer, "{value:?}");
            }
            writer.write_str("\"")?;
            writer.write_str(value)?;
            writer.write_str("\"")
        });
    }

    fn record_error(&mut self, field: &Field, value: &(dyn Error + 'static)) {
        self.leave(|library| library.record_error(field, value));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if self.is_plain(field) {
            self.write(field, |writer| write!(writer, "{value:?}"));
        } else {
            self.leave(|library| library.record_debug(field, value));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{self, Write};
    use std::sync::{Arc, Mutex, PoisonError};

    use tracing_subscriber::fmt;
    use tracing_subscriber::fmt::format::DefaultFields;
    use tracing_subscriber::prelude::*;

    use super::*;

    /// What was written.
    #[derive(Clone, Default)]
    struct Paper(Arc<Mutex<Vec<u8>>>);

    impl Write for Paper {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// The lines of some events and spans, without their times.
    fn lines<F>(fields: F, ansi: bool) -> String
    where
        F: for<'w> FormatFields<'w> + Send + Sync + 'static,
    {
        let paper = Paper::default();
        let writer = paper.clone();
        let layer = fmt::layer()
            .without_time()
            .with_ansi(ansi)
            .with_writer(move || writer.clone())
            .fmt_fields(fields);
        tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
            let nothing: Option<&str> = None;
            let span = tracing::error_span!(
                "request",
                id = "a b",
                nothing,
                trace_id = format_args!("{:04x}", 7),
                late = tracing::field::Empty
            );
            let fault = std::io::Error::other(std::io::Error::other("deep\u{1b}[31m"));
            span.in_scope(|| {
                tracing::info!(status = 200_u16, elapsed_ms = 0.25, good = true, "answered");
                span.record("late", "x\"y\\z");
                tracing::warn!(error = &fault as &dyn Error, path = %"/ü", "a \u{1b}[0m {}", 5);
                tracing::error!(r#type = "t", empty = "", count = -3, list = ?[1, 2]);
            });
        });
        let text = paper.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn lines_have_the_bytes_of_the_library() {
        for ansi in [false, true] {
            let plain = lines(PlainFields, ansi);
            assert_eq!(plain, lines(DefaultFields::new(), ansi));
            assert_eq!(plain.lines().count(), 3, "{plain}");
        }
    }
}
