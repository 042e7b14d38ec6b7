//! Fields of log lines as text: the same bytes as the library writes, without its styles. A terminal shows styles; a
//! file has none, but the library sets two empty ones for each field, which takes half of the time of a line.

use std::cell::RefCell;
use std::error::Error;
use std::fmt::{self, Debug, Write};

use tracing::field::{Field, Visit};
use tracing_subscriber::field::{RecordFields, VisitOutput};
use tracing_subscriber::fmt::FormatFields;
use tracing_subscriber::fmt::format::{DefaultFields, DefaultVisitor, Writer};

thread_local! {
    /// The fields are put together here. The text of a span begins empty, and would grow with each of its fields.
    static TEXT: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Writes fields as text.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlainFields;

impl<'w> FormatFields<'w> for PlainFields {
    fn format_fields<R: RecordFields>(&self, mut writer: Writer<'w>, fields: R) -> fmt::Result {
        if writer.has_ansi_escapes() {
            return DefaultFields::new().format_fields(writer, fields);
        }
        // A field that writes a line of the log while it is printed would find the text in use.
        let mut text = TEXT.take();
        text.clear();
        let mut plain = Plain { text: &mut text, is_first: true, written: Ok(()) };
        fields.record(&mut plain);
        let written = plain.written.and_then(|()| writer.write_str(&text));
        TEXT.set(text);
        written
    }
}

struct Plain<'t> {
    text: &'t mut String,
    is_first: bool,
    written: fmt::Result,
}

impl Plain<'_> {
    /// Whether a field is only its name and its value.
    fn is_plain(field: &Field) -> bool {
        let name = field.name();
        name != "message" && !name.starts_with("r#") && !name.starts_with("log.")
    }

    /// Writes a plain field.
    fn write(&mut self, field: &Field, value: impl FnOnce(&mut String) -> fmt::Result) {
        if self.written.is_ok() {
            if !self.is_first {
                self.text.push(' ');
            }
            self.is_first = false;
            self.text.push_str(field.name());
            self.text.push('=');
            self.written = value(self.text);
        }
    }

    /// Leaves a field to the library.
    fn leave(&mut self, record: impl FnOnce(&mut DefaultVisitor<'_>)) {
        if self.written.is_ok() {
            let mut library = DefaultVisitor::new(Writer::new(self.text), self.is_first);
            record(&mut library);
            self.written = library.finish();
            self.is_first = false;
        }
    }
}

/// Whether a byte is a printable character of ASCII.
fn is_printable(byte: u8) -> bool {
    matches!(byte, b' '..=b'~')
}

impl Visit for Plain<'_> {
    fn record_str(&mut self, field: &Field, value: &str) {
        if !Self::is_plain(field) {
            return self.leave(|library| library.record_str(field, value));
        }
        let needs_no_escape = |byte| is_printable(byte) && byte != b'"' && byte != b'\\';
        self.write(field, |text| {
            // A fold does not stop early, so several bytes are checked at once.
            if !value.bytes().fold(true, |all, byte| all & needs_no_escape(byte)) {
                return write!(text, "{value:?}");
            }
            text.push('"');
            text.push_str(value);
            text.push('"');
            Ok(())
        });
    }

    fn record_f64(&mut self, field: &Field, value: f64) {
        /// In this range, JSON and `Debug` print a number alike.
        const SAME_IN_JSON: std::ops::Range<f64> = 1e-4..1e15;
        if !Self::is_plain(field) || !SAME_IN_JSON.contains(&value) {
            return self.record_debug(field, &value);
        }
        self.write(field, |text| {
            text.push_str(zmij::Buffer::new().format_finite(value));
            Ok(())
        });
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        if !Self::is_plain(field) {
            return self.record_debug(field, &value);
        }
        self.write(field, |text| {
            text.push_str(itoa::Buffer::new().format(value));
            Ok(())
        });
    }

    fn record_error(&mut self, field: &Field, value: &(dyn Error + 'static)) {
        self.leave(|library| library.record_error(field, value));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if Self::is_plain(field) {
            return self.write(field, |text| write!(text, "{value:?}"));
        }
        let (begin, is_first) = (self.text.len(), self.is_first);
        if field.name() == "message" && self.written.is_ok() {
            // Most messages need no escape, and are written directly.
            self.written = write!(self.text, "{}{value:?}", if is_first { "" } else { " " });
            self.is_first = false;
            if self.written.is_ok() && self.text.bytes().skip(begin).all(is_printable) {
                return;
            }
            self.text.truncate(begin);
            (self.written, self.is_first) = (Ok(()), is_first);
        }
        self.leave(|library| library.record_debug(field, value));
    }
}

#[cfg(test)]
mod tests {
    use std::io;
    use std::sync::{Arc, Mutex, PoisonError};

    use tracing_subscriber::fmt::time::FormatTime;
    use tracing_subscriber::prelude::*;
    use tracing_subscriber::{Layer, Registry, fmt};

    use super::super::log_text::TextLines;
    use super::*;

    /// What was written.
    #[derive(Clone, Default)]
    struct Paper(Arc<Mutex<Vec<u8>>>);

    impl io::Write for Paper {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// The lines of some events and spans, without their times.
    fn lines(layer: impl FnOnce(Paper) -> Box<dyn Layer<Registry> + Send + Sync>) -> String {
        let paper = Paper::default();
        let layer = layer(paper.clone());
        tracing::subscriber::with_default(tracing_subscriber::registry().with(layer), || {
            let nothing: Option<&str> = None;
            let span = tracing::error_span!(
                "request",
                id = "a b",
                nothing,
                trace_id = format_args!("{:04x}", 7),
                late = tracing::field::Empty
            );
            let fault = io::Error::other(io::Error::other("deep\u{1b}[31m"));
            span.in_scope(|| {
                tracing::info!(status = 200_u16, elapsed_ms = 0.25, good = true, "answered");
                span.record("late", "x\"y\\z");
                tracing::info!(
                    a = 1e-4,
                    b = 9.9e-5,
                    c = 0.1 + 0.2,
                    d = 123_456.0,
                    e = 1e14 / 3.0,
                    f = 1e15,
                    "ms"
                );
                tracing::info!(
                    g = 0.0,
                    h = -0.5,
                    i = f64::NAN,
                    j = 1e16,
                    k = 5e-324,
                    l = u64::MAX,
                    "it's \"so\" \\"
                );
                tracing::warn!(error = &fault as &dyn Error, path = %"/ü", "a \u{1b}[0m {}", 5);
                tracing::error!(r#type = "t", empty = "", count = -3, list = ?[1, 2]);
                tracing::trace_span!("within").in_scope(|| tracing::debug!(target: "other", "deep"));
            });
            tracing::trace!("outside");
        });
        let text = paper.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        String::from_utf8(text).unwrap()
    }

    /// The same time for all lines.
    #[derive(Clone)]
    struct Then;

    impl FormatTime for Then {
        fn format_time(&self, writer: &mut Writer<'_>) -> std::fmt::Result {
            writer.write_str("then")
        }
    }

    #[test]
    fn lines_have_the_bytes_of_the_library() {
        for ansi in [false, true] {
            let written = |paper: Paper| {
                fmt::layer().with_timer(Then).with_ansi(ansi).with_writer(move || paper.clone())
            };
            let theirs = lines(|paper| written(paper).boxed());
            assert_eq!(theirs.lines().count(), 7, "{theirs}");
            assert_eq!(lines(|paper| written(paper).fmt_fields(PlainFields).boxed()), theirs);
            let ours =
                |paper| written(paper).fmt_fields(PlainFields).event_format(TextLines::new(Then)).boxed();
            assert_eq!(lines(ours), theirs);
        }
    }
}
