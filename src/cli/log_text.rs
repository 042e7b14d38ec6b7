//! Lines of the log as text: the same bytes as the library writes to a file. The library prints each part of a line
//! between two styles, which are empty in a file, and computes the date for every line. That takes most of the time of
//! a line. A terminal shows styles, and gets the library's lines.

use std::cell::RefCell;
use std::fmt::{self, Write};

use jiff::Timestamp;
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::fmt::format::{Format, FormatEvent, FormatFields, Full, Writer};
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};
use tracing_subscriber::fmt::{FmtContext, FormattedFields};
use tracing_subscriber::registry::{LookupSpan, SpanRef};

use crate::jobs::system_time;

/// The target of records that a library made for another kind of log. Their own target is one of their fields.
const FROM_ANOTHER_LOG: &str = "log";

thread_local! {
    /// A second since 1970, and its text.
    static SECOND: RefCell<(i64, String)> = const { RefCell::new((i64::MIN, String::new())) };
}

/// Prints the time of a line. The text of a second is made once.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineTime;

impl FormatTime for LineTime {
    fn format_time(&self, writer: &mut Writer<'_>) -> fmt::Result {
        let now = system_time();
        if now < Timestamp::UNIX_EPOCH { SystemTime.format_time(writer) } else { print(now, writer) }
    }
}

/// Prints a time from 1970 on, with six decimals.
fn print(time: Timestamp, writer: &mut impl Write) -> fmt::Result {
    let (second, mut rest_us) = (time.as_second(), time.subsec_nanosecond().unsigned_abs() / 1000);
    let mut decimals = *b".000000Z";
    for digit in decimals.iter_mut().skip(1).take(6).rev() {
        *digit = b'0' + (rest_us % 10) as u8;
        rest_us /= 10;
    }
    SECOND.with_borrow_mut(|made| {
        if made.0 != second {
            made.1.clear();
            write!(made.1, "{}", Timestamp::from_second(second).unwrap_or_default())?;
            // the letter of the zone
            made.1.pop();
            made.0 = second;
        }
        writer.write_str(&made.1)?;
        writer.write_str(std::str::from_utf8(&decimals).unwrap_or_default())
    })
}

/// Prints lines: without styles itself, with styles by the library.
#[derive(Debug)]
pub(super) struct TextLines<T> {
    library: Format<Full, T>,
    time: T,
}

impl<T: Clone> TextLines<T> {
    /// Lines that begin with this time.
    pub(super) fn new(time: T) -> Self {
        Self { library: Format::default().with_timer(time.clone()), time }
    }
}

impl<S, F, T> FormatEvent<S, F> for TextLines<T>
where
    S: Subscriber + for<'l> LookupSpan<'l>,
    F: for<'w> FormatFields<'w> + 'static,
    T: FormatTime,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, F>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let about = event.metadata();
        if writer.has_ansi_escapes() || about.target() == FROM_ANOTHER_LOG {
            return self.library.format_event(context, writer, event);
        }
        if self.time.format_time(&mut writer).is_err() {
            writer.write_str("<unknown time>")?;
        }
        writer.write_str(match *about.level() {
            Level::ERROR => " ERROR ",
            Level::WARN => "  WARN ",
            Level::INFO => "  INFO ",
            Level::DEBUG => " DEBUG ",
            Level::TRACE => " TRACE ",
        })?;
        if let Some(span) = context.event_scope().and_then(|mut spans| spans.next()) {
            print_spans::<S, F>(&span, &mut writer)?;
            writer.write_str(" ")?;
        }
        writer.write_str(about.target())?;
        writer.write_str(": ")?;
        context.format_fields(writer.by_ref(), event)?;
        writer.write_str("\n")
    }
}

/// Prints a span with its fields, after the spans around it.
fn print_spans<S, F>(span: &SpanRef<'_, S>, writer: &mut Writer<'_>) -> fmt::Result
where
    S: for<'l> LookupSpan<'l>,
    F: 'static,
{
    if let Some(around) = span.parent() {
        print_spans::<S, F>(&around, writer)?;
    }
    writer.write_str(span.name())?;
    if let Some(fields) = span.extensions().get::<FormattedFields<F>>()
        && !fields.is_empty()
    {
        writer.write_str("{")?;
        writer.write_str(fields)?;
        writer.write_str("}")?;
    }
    writer.write_str(":")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_six_decimals_and_the_shape_of_the_library() {
        let printed = |time: &str| {
            let mut text = String::new();
            print(time.parse().expect("a time"), &mut text).expect("text");
            text
        };
        for time in [
            "1970-01-01T00:00:00.000000Z",
            "2026-11-27T00:42:37.935315Z",
            "2026-11-27T00:42:37.000009Z",
            "2000-02-29T23:59:59.999999Z",
            "2026-11-27T00:42:37.100000Z",
        ] {
            assert_eq!(printed(time), time);
        }
        assert_eq!(printed("2026-11-27T00:42:37.9353159Z"), "2026-11-27T00:42:37.935315Z");
        // The library prints now; both texts are of one shape, and their order is that of the clock.
        let (mut ours, mut theirs, mut later) = (String::new(), String::new(), String::new());
        LineTime.format_time(&mut Writer::new(&mut ours)).expect("text");
        SystemTime.format_time(&mut Writer::new(&mut theirs)).expect("text");
        LineTime.format_time(&mut Writer::new(&mut later)).expect("text");
        assert_eq!(ours.len(), theirs.len(), "{ours} {theirs}");
        assert!(ours <= theirs && theirs <= later, "{ours} {theirs} {later}");
    }
}
