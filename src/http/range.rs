//! Partial downloads (RFC 9110 §14): one range of bytes, if the content has not changed.

use std::ops::Range;

use axum::response::{IntoResponse, Response};
use http::header::{ACCEPT_RANGES, CONTENT_LENGTH, CONTENT_RANGE, IF_RANGE, RANGE};
use http::{HeaderMap, HeaderValue, StatusCode};

use super::problem::{Problem, ProblemType};

/// The requested part of the content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Asked {
    /// All of it.
    Whole,
    /// These bytes.
    Part(Range<u64>),
    /// Bytes beyond the end.
    Outside,
}

/// The requested part of a content with this length and tag. Several ranges, another unit or an unreadable header ask
/// for the whole content.
pub(super) fn asked(headers: &HeaderMap, length: u64, tag: &str) -> Asked {
    let mut given = headers.get_all(RANGE).iter();
    let (Some(range), None) = (given.next(), given.next()) else { return Asked::Whole };
    // A foreign tag, a weak tag or a date: the client has the beginning of another content.
    if let Some(condition) = headers.get(IF_RANGE)
        && condition.as_bytes() != format!("\"{tag}\"").as_bytes()
    {
        return Asked::Whole;
    }
    range.to_str().ok().and_then(|text| one_range(text, length)).unwrap_or(Asked::Whole)
}

fn one_range(text: &str, length: u64) -> Option<Asked> {
    let (unit, range) = text.trim().split_once('=')?;
    let (first, last) = range.trim().split_once('-')?;
    if !unit.trim().eq_ignore_ascii_case("bytes") {
        return None;
    }
    // A position with more digits than a number can hold is beyond every end.
    let number = |digits: &str| {
        let sound = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        sound.then(|| digits.parse::<u64>().unwrap_or(u64::MAX))
    };
    let part = match (first.trim(), last.trim()) {
        ("", last) => length.saturating_sub(number(last)?)..length,
        (first, "") => number(first)?..length,
        (first, last) => {
            let (first, last) = (number(first)?, number(last)?);
            if last < first {
                return None;
            }
            first..last.saturating_add(1).min(length)
        }
    };
    Some(if part.is_empty() { Asked::Outside } else { Asked::Part(part) })
}

/// Adds to a response which part of the content it is; its body is that part.
pub(super) fn dressed(asked: &Asked, length: u64, mut response: Response) -> Response {
    let headers = response.headers_mut();
    headers.insert(ACCEPT_RANGES, HeaderValue::from_static("bytes"));
    let sent = match asked {
        Asked::Whole => length,
        Asked::Part(part) => {
            let range = format!("bytes {}-{}/{length}", part.start, part.end - 1);
            if let Ok(range) = HeaderValue::try_from(range) {
                headers.insert(CONTENT_RANGE, range);
            }
            part.end - part.start
        }
        Asked::Outside => return outside(length),
    };
    headers.insert(CONTENT_LENGTH, HeaderValue::from(sent));
    if matches!(asked, Asked::Part(_)) {
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
    }
    response
}

fn outside(length: u64) -> Response {
    let detail = format!("the content has only {length} bytes");
    let mut response = Problem::new(ProblemType::RangeNotSatisfiable, detail).into_response();
    if let Ok(range) = HeaderValue::try_from(format!("bytes */{length}")) {
        response.headers_mut().insert(CONTENT_RANGE, range);
    }
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(range: &str, condition: Option<&str>) -> Asked {
        let mut headers = HeaderMap::new();
        headers.insert(RANGE, range.parse().unwrap());
        if let Some(condition) = condition {
            headers.insert(IF_RANGE, condition.parse().unwrap());
        }
        asked(&headers, 100, "tag")
    }

    #[test]
    fn one_range_of_bytes_is_a_part() {
        for (range, part) in [
            ("bytes=0-0", 0..1),
            ("bytes=0-99", 0..100),
            ("bytes=10-", 10..100),
            ("bytes=-10", 90..100),
            ("bytes=-1000", 0..100),
            ("Bytes = 20 - 29", 20..30),
            ("bytes=99-99999999999999999999999999", 99..100),
        ] {
            assert_eq!(of(range, None), Asked::Part(part), "{range}");
        }
        assert_eq!(of("bytes=5-", Some("\"tag\"")), Asked::Part(5..100));
    }

    #[test]
    fn what_is_not_there_cannot_be_sent() {
        for range in ["bytes=100-", "bytes=100-200", "bytes=-0", "bytes=99999999999999999999999-"] {
            assert_eq!(of(range, None), Asked::Outside, "{range}");
        }
    }

    #[test]
    fn everything_else_is_the_whole() {
        for range in [
            "bytes=0-1,3-4",
            "lines=0-1",
            "bytes",
            "bytes=",
            "bytes=-",
            "bytes=5-4",
            "bytes=a-b",
            "bytes=+1-2",
        ] {
            assert_eq!(of(range, None), Asked::Whole, "{range}");
        }
        for condition in ["\"other\"", "W/\"tag\"", "Sat, 21 Nov 2026 18:00:00 GMT"] {
            assert_eq!(of("bytes=5-", Some(condition)), Asked::Whole, "{condition}");
        }
        assert_eq!(asked(&HeaderMap::new(), 100, "tag"), Asked::Whole);
    }
}
