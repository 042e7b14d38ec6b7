//! Content negotiation: the Accept header with its q-values (RFC 9110 §12.5.1).

use http::HeaderMap;
use http::header::ACCEPT;

use super::problem::{Problem, ProblemType};

/// The best of `offers` (media types, our preferred one first) for the client.
///
/// # Errors
/// No offer fits.
pub(super) fn choose<'a>(headers: &HeaderMap, offers: &[&'a str]) -> Result<&'a str, Problem> {
    let Some(first) = offers.first() else {
        return Err(Problem::new(ProblemType::NotAcceptable, "this resource has no representation"));
    };
    if !headers.contains_key(ACCEPT) {
        return Ok(first);
    }
    let ranges: Vec<Range> = headers
        .get_all(ACCEPT)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','))
        .filter_map(Range::parse)
        .collect();
    let mut best: Option<(&str, u16)> = None;
    for offer in offers {
        let quality = quality(&ranges, offer);
        if quality > best.map_or(0, |(_, quality)| quality) {
            best = Some((offer, quality));
        }
    }
    best.map(|(offer, _)| offer).ok_or_else(|| {
        Problem::new(
            ProblemType::NotAcceptable,
            format!("no representation fits the Accept header; accept one of {}", offers.join(", ")),
        )
    })
}

struct Range {
    kind: String,
    subtype: String,
    /// Quality in thousandths.
    quality: u16,
}

impl Range {
    fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split(';');
        let (kind, subtype) = parts.next()?.trim().split_once('/')?;
        let mut quality = 1000;
        for parameter in parts {
            let (name, value) = parameter.split_once('=').unwrap_or((parameter, ""));
            if name.trim().eq_ignore_ascii_case("q") {
                let value: f64 = value.trim().parse().ok().filter(|q| (0.0..=1.0).contains(q))?;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "between 0 and 1000"
                )]
                {
                    quality = (value * 1000.0).round() as u16;
                }
            }
        }
        Some(Self { kind: kind.to_ascii_lowercase(), subtype: subtype.to_ascii_lowercase(), quality })
    }

    /// How closely the range names the offer; `None` when it does not fit.
    fn closeness(&self, kind: &str, subtype: &str) -> Option<u8> {
        match (self.kind == kind, self.subtype == subtype) {
            (true, true) => Some(2),
            (true, false) if self.subtype == "*" => Some(1),
            _ if self.kind == "*" && self.subtype == "*" => Some(0),
            _ => None,
        }
    }
}

/// The quality of an offer: that of the range that names it most closely.
fn quality(ranges: &[Range], offer: &str) -> u16 {
    let (kind, subtype) = offer.split_once('/').unwrap_or((offer, ""));
    ranges
        .iter()
        .filter_map(|range| Some((range.closeness(kind, subtype)?, range.quality)))
        .max()
        .map_or(0, |(_, quality)| quality)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFFERS: [&str; 3] = ["text/plain", "application/json", "image/svg+xml"];

    fn chosen(accept: &str) -> Option<&'static str> {
        let mut headers = HeaderMap::new();
        headers.insert(ACCEPT, accept.parse().unwrap());
        choose(&headers, &OFFERS).ok()
    }

    #[test]
    fn the_best_liked_representation_is_chosen() {
        assert_eq!(choose(&HeaderMap::new(), &OFFERS).ok(), Some("text/plain"));
        assert_eq!(chosen("*/*"), Some("text/plain"));
        assert_eq!(chosen("application/json"), Some("application/json"));
        assert_eq!(chosen("image/*;q=0.5, application/json;q=0.4"), Some("image/svg+xml"));
        assert_eq!(chosen("*/*;q=0.1, application/json"), Some("application/json"));
        assert_eq!(chosen("*/*, text/plain;q=0"), Some("application/json"));
        assert_eq!(chosen("Image/SVG+XML"), Some("image/svg+xml"));
    }

    #[test]
    fn nothing_fitting_is_refused() {
        for accept in ["text/html", "application/json;q=0", "nonsense", "text/plain;q=2"] {
            assert_eq!(chosen(accept), None, "{accept}");
        }
    }
}
