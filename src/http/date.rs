//! The header `Date` of every answer. The HTTP library treats a clock before 1970 as impossible and ends the
//! connection. Here such an answer has no `Date` (RFC 9110 §6.6.1: a server without a clock sends none).

use std::cell::RefCell;

use axum::response::Response;
use http::HeaderValue;
use http::header::DATE;
use jiff::Timestamp;
use jiff::fmt::rfc2822::DateTimePrinter;

use crate::jobs::system_time;

thread_local! {
    /// The last header, with its second since 1970.
    static MADE: RefCell<(i64, Option<HeaderValue>)> = const { RefCell::new((i64::MIN, None)) };
}

/// The answer with the current time.
pub(super) fn dated(mut response: Response) -> Response {
    if let Some(date) = header(system_time()) {
        response.headers_mut().insert(DATE, date);
    }
    response
}

/// The header for this time; `None` before 1970.
fn header(now: Timestamp) -> Option<HeaderValue> {
    let second = now.as_second();
    MADE.with_borrow_mut(|made| {
        if made.0 != second {
            *made = (second, if second < 0 { None } else { printed(now) });
        }
        made.1.clone()
    })
}

fn printed(now: Timestamp) -> Option<HeaderValue> {
    let text = DateTimePrinter::new().timestamp_to_rfc9110_string(&now).ok()?;
    HeaderValue::try_from(text).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_is_told_as_http_has_it_and_none_before_1970() {
        let told = |text: &str| header(text.parse().expect("a time"));
        assert_eq!(told("1994-11-06T08:49:37.9Z").expect("a date"), "Sun, 06 Nov 1994 08:49:37 GMT");
        assert_eq!(told("1970-01-01T00:00:00Z").expect("a date"), "Thu, 01 Jan 1970 00:00:00 GMT");
        assert_eq!(told("1969-12-31T23:59:58Z"), None);
        assert_eq!(told("1994-11-06T08:49:38Z").expect("a date"), "Sun, 06 Nov 1994 08:49:38 GMT");
    }
}
