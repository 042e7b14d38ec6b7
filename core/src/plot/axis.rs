//! The axes of a figure: the place of a value, round marks, and numbers as text.

use std::ops::Range;

use super::svg::whole;

/// An axis from one end to the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) name: String,
    ends: Range<f64>,
    scale: Scale,
}

#[derive(Debug, Clone, PartialEq)]
enum Scale {
    Linear,
    Logarithmic,
    /// Days since 1970-01-01, UTC.
    Dates,
    /// Names at 0, 1, 2 …
    Named(Vec<String>),
}

impl Axis {
    pub(super) fn linear(ends: Range<f64>, name: impl Into<String>) -> Self {
        Self { name: name.into(), ends, scale: Scale::Linear }
    }

    /// Both ends are above zero.
    pub(super) fn logarithmic(ends: Range<f64>, name: impl Into<String>) -> Self {
        Self { name: name.into(), ends, scale: Scale::Logarithmic }
    }

    /// Days since 1970-01-01, UTC.
    pub(super) fn dates(ends: Range<f64>, name: impl Into<String>) -> Self {
        Self { name: name.into(), ends, scale: Scale::Dates }
    }

    /// Names at 0, 1, 2 …, each in the middle of its part of the axis.
    pub(super) fn named(names: Vec<String>, name: impl Into<String>) -> Self {
        let end = names.len().max(1) as f64 - 0.5;
        Self { name: name.into(), ends: -0.5..end, scale: Scale::Named(names) }
    }

    pub(super) const fn start(&self) -> f64 {
        self.ends.start
    }

    pub(super) const fn end(&self) -> f64 {
        self.ends.end
    }

    /// Whether lines of the grid belong to the marks.
    pub(super) const fn has_grid(&self) -> bool {
        !matches!(self.scale, Scale::Named(_))
    }

    /// The place of a value: 0 at the start, 1 at the end; values outside are at the nearer end.
    pub(super) fn share(&self, value: f64) -> f64 {
        let Range { start, end } = self.ends;
        let share = if self.scale == Scale::Logarithmic {
            (value / start).max(f64::MIN_POSITIVE).ln() / (end / start).ln()
        } else {
            // Halves: the difference of two enormous numbers is finite.
            (0.5 * value - 0.5 * start) / (0.5 * end - 0.5 * start)
        };
        share.clamp(0.0, 1.0)
    }

    /// Round values with their texts, at most about `count`.
    pub(super) fn marks(&self, count: f64) -> Vec<(f64, String)> {
        let Range { start, end } = self.ends;
        match &self.scale {
            Scale::Linear => {
                let step = round_up((end - start) / count);
                let (marks, largest) = (multiples(&self.ends, step), start.abs().max(end.abs()));
                marks.into_iter().map(|value| (value, on_scale(value, step, largest))).collect()
            }
            Scale::Logarithmic => {
                let mut decade = decade_of(start);
                let mut marks = Vec::new();
                let factors: &[f64] = if end / start > 1e3 { &[1.0] } else { &[1.0, 2.0, 5.0] };
                while decade <= end {
                    marks.extend(factors.iter().map(|factor| factor * decade));
                    decade *= 10.0;
                }
                let every = (marks.len() as f64 / (2.0 * count)).ceil().max(1.0);
                let inside = marks.into_iter().filter(|value| (start..=end).contains(value));
                inside.step_by(whole(every)).map(|value| (value, plain(value))).collect()
            }
            Scale::Dates => date_marks(&self.ends, count),
            Scale::Named(names) => {
                let every = whole((names.len() as f64 / (2.5 * count)).ceil()).max(1);
                let named = names.iter().enumerate().step_by(every);
                named.map(|(place, name)| (place as f64, name.clone())).collect()
            }
        }
    }
}

/// The multiples of `step` within the range; few, because the step is a share of the range.
fn multiples(range: &Range<f64>, step: f64) -> Vec<f64> {
    let first = (range.start / step).ceil();
    let all = (0..MOST_MARKS).map(|k| (first + f64::from(k)) * step);
    // A mark at an end may be off by its rounding.
    all.take_while(|value| *value <= range.end + 1e-9 * step).map(|value| value + 0.0).collect()
}

/// No axis has as many.
const MOST_MARKS: u32 = 100;

/// A number with three significant digits, without zeros at its end. A whole number keeps all of its digits up to a
/// million.
#[must_use]
pub fn plain(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return scientific(value);
    }
    let digits = match size {
        size if size == 0.0 || size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        size if size >= 0.1 => 3,
        size if size >= 0.01 => 4,
        size if size >= 0.001 => 5,
        _ => 6,
    };
    let text = format!("{value:.digits$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text.as_str() };
    with_minus(text)
}

/// `1.5·10⁹`
fn scientific(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.2e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    let raised = exponent.chars().map(|letter| match letter {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => digit.to_digit(10).and_then(|digit| char::from_u32(0x2070 + digit)).unwrap_or(digit),
    });
    format!("{}·10{}", with_minus(digits), raised.collect::<String>())
}

/// The number with the sign that is as wide as a plus.
fn with_minus(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().any(|digit| digit.is_ascii_digit() && digit != '0') => {
            format!("−{digits}")
        }
        Some(digits) => digits.to_owned(),
        None => text.to_owned(),
    }
}

/// A mark of an axis: all marks of an axis have the decimals of their step.
fn on_scale(value: f64, step: f64, largest: f64) -> String {
    if !(1e-3..1e6).contains(&largest) {
        return if value == 0.0 { "0".to_owned() } else { scientific(value) };
    }
    let mut decimals = 0_usize;
    let mut unit = 1.0;
    while unit > step * (1.0 + 1e-9) && decimals < 9 {
        unit /= 10.0;
        decimals += 1;
    }
    with_minus(&format!("{value:.decimals$}"))
}

/// The power of ten that is not above `value`.
fn decade_of(value: f64) -> f64 {
    let mut decade = 1.0;
    while decade > value {
        decade /= 10.0;
    }
    while decade * 10.0 <= value {
        decade *= 10.0;
    }
    decade
}

/// 1, 2 or 5 times a power of ten, the largest that is not above `value`.
pub(super) fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let decade = decade_of(value);
    [5.0, 2.0, 1.0].into_iter().map(|step| step * decade).find(|step| *step <= value).unwrap_or(decade)
}

/// 1, 2 or 5 times a power of ten, the smallest that is not below `value`.
pub(super) fn round_up(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let decade = decade_of(value);
    let steps = [1.0, 2.0, 5.0].map(|step| step * decade);
    steps.into_iter().find(|step| *step >= value * (1.0 - 1e-9)).unwrap_or(10.0 * decade)
}

/// Smallest and largest of the finite values. ±1 if there is no value, and never empty.
pub(super) fn span(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|value| value.is_finite()) {
        least = least.min(value);
        most = most.max(value);
    }
    if least > most {
        return -1.0..1.0;
    }
    if least < most {
        return least..most;
    }
    let margin = 0.5 * most.abs().max(1e-6);
    least - margin..most + margin
}

/// The span, widened so that no curve touches the frame and a text has space beside its ends.
pub(super) fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let Range { start, end } = span(values);
    let margin = MARGIN * (end - start);
    if margin.is_finite() { start - margin..end + margin } else { start..end }
}

/// The same, from zero if no value is below it.
pub(super) fn range_from_zero(values: impl Iterator<Item = f64>) -> Range<f64> {
    let Range { start, end } = span(values.chain([0.0]));
    let widened = range([start, end].into_iter());
    if start < 0.0 || end <= start { widened } else { 0.0..widened.end }
}

/// Space above and below the values of a panel, as a share of their range.
const MARGIN: f64 = 0.1;

const HOURS_PER_DAY: f64 = 24.0;

/// Dates at round distances, as ISO 8601 writes them: years, months, days, or days with hours.
fn date_marks(ends: &Range<f64>, count: f64) -> Vec<(f64, String)> {
    let days = (ends.end - ends.start) / count;
    if days < 0.5 {
        let hours = [1.0, 2.0, 3.0, 6.0, 12.0];
        let step = hours.into_iter().find(|step| *step >= days * HOURS_PER_DAY).unwrap_or(12.0);
        let marks = multiples(ends, step / HOURS_PER_DAY);
        return marks
            .into_iter()
            .map(|day| {
                let hour = ((day - day.floor()) * HOURS_PER_DAY).round();
                let (_, month, date) = civil(day.floor());
                (day, format!("{month:02}-{date:02} {hour:02}:00"))
            })
            .collect();
    }
    if days <= 14.0 {
        let step = [1.0, 2.0, 7.0, 14.0].into_iter().find(|step| *step >= days).unwrap_or(14.0);
        // Weeks begin on Monday: the first of this era was 1970-01-05.
        let monday = if step < 7.0 { 0.0 } else { 4.0 };
        let marks = multiples(&(ends.start - monday..ends.end - monday), step);
        return marks
            .into_iter()
            .map(|day| day + monday)
            .map(|day| {
                let (year, month, date) = civil(day);
                (day, format!("{year}-{month:02}-{date:02}"))
            })
            .collect();
    }
    let months = days / 30.44;
    let steps = [1, 2, 3, 6, 12, 24, 60, 120, 240, 600, 1200];
    let step = steps.into_iter().find(|step| f64::from(*step) >= months).unwrap_or(12_000);
    let (year, ..) = civil(ends.start.floor());
    let first = year - year.rem_euclid((i64::from(step) / 12).max(1));
    (0..12_000 / i64::from(step))
        .map(|k| {
            let month = k * i64::from(step);
            (first + month / 12, month % 12 + 1)
        })
        .map(|(year, month)| (day_of(year, month), year, month))
        .take_while(|(day, ..)| *day <= ends.end)
        .filter(|(day, ..)| *day >= ends.start)
        .map(|(day, year, month)| {
            (day, if step >= 12 { year.to_string() } else { format!("{year}-{month:02}") })
        })
        .collect()
}

/// Year, month and day of a number of days since 1970-01-01, in the calendar of ISO 8601.
pub(super) fn civil(days: f64) -> (i64, i64, i64) {
    // Years that begin in March, so that the leap day is the last (H. Hinnant, "chrono-compatible low-level date
    // algorithms").
    #[expect(clippy::cast_possible_truncation, reason = "saturating")]
    let day = (days.clamp(-1e8, 1e8) as i64) + 719_468;
    let (era, of_era) = (day.div_euclid(146_097), day.rem_euclid(146_097));
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let from_march = (5 * of_year + 2) / 153;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    (year, month, of_year - (153 * from_march + 2) / 5 + 1)
}

/// Days from 1970-01-01 to the first day of a month.
fn day_of(year: i64, month: i64) -> f64 {
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let from_march = if month > 2 { month - 3 } else { month + 9 };
    let of_year = (153 * from_march + 2) / 5;
    (era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (value, expected) in [(37.0, 20.0), (5.0, 5.0), (0.0199, 0.01), (999.0, 500.0), (0.0, 1.0)] {
            assert!((round_down(value) - expected).abs() < 1e-12 * expected, "{value}");
        }
        for (value, expected) in [(37.0, 50.0), (5.0, 5.0), (0.0199, 0.02), (999.0, 1000.0), (2.1, 5.0)] {
            assert!((round_up(value) - expected).abs() < 1e-9 * expected, "{value}: {}", round_up(value));
        }
        assert!((round_down(f64::NAN) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_range_is_never_empty() {
        for values in [vec![], vec![3.0], vec![0.0, 0.0], vec![f64::NAN], vec![-2.0, 5.0]] {
            for range in [
                span(values.iter().copied()),
                range(values.iter().copied()),
                range_from_zero(values.iter().copied()),
            ] {
                assert!(range.start < range.end, "{range:?}");
            }
        }
    }

    #[test]
    fn numbers_have_three_significant_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1604.74, "1605"),
            (22.06, "22.1"),
            (5.499, "5.5"),
            (0.012_345, "0.0123"),
            (-3.0, "−3"),
            (1.5e9, "1.5·10⁹"),
            (-2.34e-7, "−2.34·10⁻⁷"),
        ] {
            assert_eq!(plain(value), text);
        }
    }

    #[test]
    fn marks_of_an_axis_have_the_same_decimals() {
        let texts = |axis: &Axis| axis.marks(6.0).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts(&Axis::linear(-0.55..0.5, "")), ["−0.4", "−0.2", "0.0", "0.2", "0.4"]);
        assert_eq!(texts(&Axis::linear(999.0..1004.0, "")).first().map(String::as_str), Some("999"));
        assert_eq!(texts(&Axis::logarithmic(0.1..2000.0, "")), ["0.1", "1", "10", "100", "1000"]);
        for ends in [-1e300..1e300, 0.0..1e-12, 5.0..5.0 + 1e-13] {
            assert!(texts(&Axis::linear(ends, "")).len() <= MOST_MARKS as usize);
        }
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (days, date) in [
            (0.0, (1970, 1, 1)),
            (59.0, (1970, 3, 1)),
            (11_016.0, (2000, 2, 29)),
            (20_161.0, (2025, 3, 14)),
            (-1.0, (1969, 12, 31)),
        ] {
            assert_eq!(civil(days), date);
            let (year, month, day) = date;
            assert!((day_of(year, month) + day as f64 - 1.0 - days).abs() < 0.5, "{date:?}");
        }
    }

    #[test]
    fn marks_of_dates_are_round_at_every_length() {
        let texts = |length: f64| {
            let axis = Axis::dates(20_161.3..20_161.3 + length, "");
            axis.marks(6.0).into_iter().map(|(_, text)| text).collect::<Vec<_>>()
        };
        assert_eq!(texts(1.0)[0], "03-14 08:00".replace("08", "12"));
        assert_eq!(texts(5.0)[..2], ["2025-03-15", "2025-03-16"]);
        assert_eq!(texts(300.0)[..2], ["2025-05", "2025-07"]);
        assert_eq!(texts(4000.0)[..2], ["2026", "2028"]);
        for length in [1e-6, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6] {
            assert!(texts(length).len() <= 14, "{length}: {:?}", texts(length));
        }
    }
}
