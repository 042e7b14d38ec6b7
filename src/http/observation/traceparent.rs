//! The trace that a request belongs to (W3C Trace Context): the `traceparent` of the request, the `traceresponse` of
//! the answer.

use std::fmt;

use http::{HeaderMap, HeaderName};
use uuid::Uuid;
use uuid::fmt::Simple;

/// Header of a request.
const TRACEPARENT: HeaderName = HeaderName::from_static("traceparent");

/// Bytes of a `traceparent` of the first version.
const LENGTH: usize = 55;
/// Where the id of the trace is in it.
pub(in crate::http) const TRACE_ID: std::ops::Range<usize> = 3..35;

/// The position of a request in a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trace {
    /// Id of the trace, not zero.
    pub trace_id: u128,
    /// Span of the caller, if the request names one.
    pub parent_id: Option<u64>,
    /// Our span in the trace, not zero.
    pub span_id: u64,
    /// Whether the caller records the trace; our traces are recorded.
    pub sampled: bool,
}

impl Trace {
    /// The trace that the headers name, or a new one. A `traceparent` that has another form, or that occurs twice, is
    /// ignored. `fresh` gives the new ids: its lower half is random enough for a span, the whole for a trace.
    #[must_use]
    pub fn of(headers: &HeaderMap, fresh: Uuid) -> Self {
        let (trace_id, span_id) = (fresh.as_u128(), fresh.as_u64_pair().1);
        let mut given = headers.get_all(TRACEPARENT).iter();
        match (given.next().and_then(|value| parsed(value.as_bytes())), given.next()) {
            (Some((trace_id, parent_id, sampled)), None) => {
                Self { trace_id, parent_id: Some(parent_id), span_id, sampled }
            }
            _ => Self { trace_id, parent_id: None, span_id, sampled: true },
        }
    }

    /// The same text as `Display`. Every answer has it. The library of ids prints its digits, because that is fast.
    pub(in crate::http) fn text(&self) -> [u8; LENGTH] {
        const SPAN_ID: std::ops::Range<usize> = 36..52;
        let mut text = *b"00-00000000000000000000000000000000-0000000000000000-00";
        let mut digits = [0; Simple::LENGTH];
        for (place, value) in [(TRACE_ID, self.trace_id), (SPAN_ID, u128::from(self.span_id) << 64)] {
            let digits = Uuid::from_u128(value).as_simple().encode_lower(&mut digits).as_bytes();
            if let (Some(part), Some(digits)) = (text.get_mut(place.clone()), digits.get(..place.len())) {
                part.copy_from_slice(digits);
            }
        }
        if let Some(flag) = text.last_mut() {
            *flag = b'0' + u8::from(self.sampled);
        }
        text
    }
}

/// The form of `traceparent` and `traceresponse`, with our span.
impl fmt::Display for Trace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&String::from_utf8_lossy(&self.text()))
    }
}

/// Trace, span and sampled flag. Later versions may have more text after the flags.
fn parsed(value: &[u8]) -> Option<(u128, u64, bool)> {
    let dash = |at: usize| value.get(at) == Some(&b'-');
    let whole =
        value.len() == LENGTH || (value.len() > LENGTH && dash(LENGTH) && value.get(..2) != Some(b"00"));
    if !whole || !dash(2) || !dash(35) || !dash(52) {
        return None;
    }
    let version = hex(value.get(..2)?)?;
    let trace_id = hex(value.get(3..35)?)?;
    let parent_id = u64::try_from(hex(value.get(36..52)?)?).ok()?;
    let flags = hex(value.get(53..55)?)?;
    (version != 0xff && trace_id != 0 && parent_id != 0).then_some((trace_id, parent_id, flags & 1 == 1))
}

/// Accepts only lower-case digits.
fn hex(digits: &[u8]) -> Option<u128> {
    digits.iter().try_fold(0, |sum, digit| {
        let value = match digit {
            b'0'..=b'9' => digit - b'0',
            b'a'..=b'f' => digit - b'a' + 10,
            _ => return None,
        };
        Some(sum << 4 | u128::from(value))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRESH: Uuid = Uuid::from_u128(0x0199_0000_0000_7000_8000_0000_0000_00ff);

    fn trace(values: &[&str]) -> Trace {
        let mut headers = HeaderMap::new();
        for value in values {
            headers.append(TRACEPARENT, value.parse().unwrap());
        }
        Trace::of(&headers, FRESH)
    }

    #[test]
    fn a_trace_goes_on_under_a_span_of_ours() {
        let text = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
        let found = trace(&[text]);
        assert_eq!(found.trace_id, 0x4bf9_2f35_77b3_4da6_a3ce_929d_0e0e_4736);
        assert_eq!(found.parent_id, Some(0x00f0_67aa_0ba9_02b7));
        assert!(found.sampled);
        assert_eq!(found.to_string(), "00-4bf92f3577b34da6a3ce929d0e0e4736-80000000000000ff-01");
        let unsampled = trace(&["00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-00"]);
        assert!(unsampled.to_string().ends_with("-00"));
        // A later version may have more text.
        let later = trace(&["cc-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-03-what-comes"]);
        assert_eq!(later.trace_id, found.trace_id);
        assert!(later.sampled);
    }

    #[test]
    fn what_is_not_of_the_form_begins_a_trace() {
        let sound = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
        for bad in [
            "",
            "00",
            "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",
            "00-00000000000000000000000000000000-00f067aa0ba902b7-01",
            "00-4bf92f3577b34da6a3ce929d0e0e4736-0000000000000000-01",
            "ff-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
            "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-more",
            "cc-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01.more",
            "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0",
            "00-4bf92f3577b34da6a3ce929d0e0e473-600f067aa0ba902b7-01",
            "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0g",
            "00_4bf92f3577b34da6a3ce929d0e0e4736_00f067aa0ba902b7_01",
        ] {
            let found = trace(&[bad]);
            assert_eq!((found.trace_id, found.parent_id), (FRESH.as_u128(), None), "{bad}");
        }
        assert_eq!(trace(&[sound, sound]).parent_id, None);
        assert_eq!(trace(&[]).parent_id, None);
    }
}
