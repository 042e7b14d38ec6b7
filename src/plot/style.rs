//! What the figures have in common.

use plotters::prelude::*;

/// Width and height of a figure.
pub(super) const SIZE: (u32, u32) = (1000, 520);
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);
pub(super) const MUTED: RGBColor = RGBColor(90, 90, 90);
/// Told apart by every kind of eye (Okabe and Ito), the lightest left out.
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(120, 94, 20),
];

/// The colour of the curve of this index.
pub(super) fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// A number with the digits a reader needs and no exponent.
pub(super) fn plain(value: f64) -> String {
    let digits = match value.abs() {
        size if size == 0.0 || size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        size if size >= 0.1 => 3,
        _ => 4,
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// 1, 2 or 5 times a power of ten, the largest that is not above `value`.
pub(super) fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let mut decade = 1.0;
    while decade > value {
        decade /= 10.0;
    }
    while decade * 10.0 <= value {
        decade *= 10.0;
    }
    [5.0, 2.0, 1.0].into_iter().map(|step| step * decade).find(|step| *step <= value).unwrap_or(decade)
}

/// Smallest and largest of the finite values, widened by a twentieth so that no curve lies on the frame; ±1 where
/// there is nothing to see.
pub(super) fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|value| value.is_finite()) {
        least = least.min(value);
        most = most.max(value);
    }
    if least > most {
        return -1.0..1.0;
    }
    let margin = 0.05 * (most - least);
    let margin = if margin > 0.0 { margin } else { 0.5 * most.abs().max(1e-6) };
    least - margin..most + margin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_marks_are_round() {
        for (value, expected) in [(37.0, 20.0), (5.0, 5.0), (0.0199, 0.01), (999.0, 500.0), (0.0, 1.0)] {
            assert!((round_down(value) - expected).abs() < 1e-12 * expected, "{value}");
        }
        assert!((round_down(f64::NAN) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_range_is_never_empty() {
        for values in [vec![], vec![3.0], vec![0.0, 0.0], vec![f64::NAN], vec![-2.0, 5.0]] {
            let range = range(values.into_iter());
            assert!(range.start < range.end, "{range:?}");
        }
    }
}
