//! Following error of the axes over time (P2 Fig. 6, 8).

use super::axis::{Axis, plain, range};
use super::chart::{Chart, HALF, Sample, TALL};
use super::svg::{MUTED, Stroke};

/// The following error of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowingErrorCurve<'a> {
    /// Axis letter.
    pub axis: char,
    /// Errors of linear axes are in µm on the left scale, those of rotary axes in µrad on the right.
    pub is_linear: bool,
    /// Errors \[µm or µrad\], one for each time.
    pub errors: &'a [f64],
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct FollowingErrorFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Times \[s\].
    pub time_s: &'a [f64],
    /// One for each axis.
    pub curves: &'a [FollowingErrorCurve<'a>],
    /// Start of the judged part \[s\].
    pub judged_from_s: f64,
}

const START: Stroke = Stroke::new(MUTED, 1.2).dashed("6 4");

/// Draws the curves, those of linear axes above those of rotary axes, and a line at the start of the judged part. Same
/// numbers, same bytes.
#[must_use]
pub fn following_error_over_time(figure: &FollowingErrorFigure<'_>) -> String {
    let end_s = figure.time_s.last().copied().unwrap_or(1.0).max(1e-6);
    let of = |linear: bool| {
        let curves = figure.curves.iter().enumerate();
        curves.filter(move |(_, curve)| curve.is_linear == linear)
    };
    let kinds: Vec<bool> = [true, false].into_iter().filter(|linear| of(*linear).next().is_some()).collect();
    let height = if kinds.len() > 1 { HALF } else { TALL };
    let mut chart = Chart::new(figure.title);
    let mut largest = Vec::new();
    for (place, linear) in kinds.iter().copied().enumerate() {
        let (kind, unit) = if linear { ("linear", "µm") } else { ("rotary", "µrad") };
        let errors = of(linear).flat_map(|(_, curve)| curve.errors.iter().copied());
        let time = if place + 1 == kinds.len() { "time [s]" } else { "" };
        let y = Axis::linear(range(errors), format!("{kind} axes [{unit}]"));
        let panel = chart.panel(height, Axis::linear(0.0..end_s, time), y);
        if figure.judged_from_s > 0.0 {
            chart.upright(&panel, figure.judged_from_s, START);
        }
        for (index, curve) in of(linear) {
            let stroke = Stroke::of_curve(index);
            chart.line(&panel, figure.time_s.iter().copied().zip(curve.errors.iter().copied()), stroke);
            chart.explain(Sample::Line(stroke), format!("{} [{unit}]", curve.axis));
            let most = curve
                .errors
                .iter()
                .filter(|error| error.is_finite())
                .fold(0.0, |most: f64, error| most.max(error.abs()));
            largest.push(format!("{} {} {unit}", curve.axis, plain(most)));
        }
    }
    if kinds.is_empty() {
        chart.panel(TALL, Axis::linear(0.0..end_s, "time [s]"), Axis::linear(-1.0..1.0, ""));
    }
    if figure.judged_from_s > 0.0 {
        chart.explain(Sample::Line(START), format!("judged from {} s", plain(figure.judged_from_s)));
    }
    chart.finish(&format!("Following error of each axis over time. Largest: {}.", largest.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_names_axes_units_and_the_judged_part() {
        let time_s: Vec<f64> = (0..200_u32).map(|k| f64::from(k) * 0.01).collect();
        let x: Vec<f64> = time_s.iter().map(|t| 800.0 * t.sin()).collect();
        let c: Vec<f64> = time_s.iter().map(|t| -40.0 * t).collect();
        let curves = [
            FollowingErrorCurve { axis: 'X', is_linear: true, errors: &x },
            FollowingErrorCurve { axis: 'C', is_linear: false, errors: &c },
        ];
        let figure =
            FollowingErrorFigure { title: "circle", time_s: &time_s, curves: &curves, judged_from_s: 1.0 };
        let svg = following_error_over_time(&figure);
        for part in ["time [s]", "[µm]", "[µrad]", "X [µm]", "C [µrad]", "judged from 1 s"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, following_error_over_time(&figure));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        let odd = [f64::NAN, 1e300, 0.0];
        let curves = [FollowingErrorCurve { axis: 'A', is_linear: false, errors: &odd }];
        for (time_s, curves) in [(&[][..], &[][..]), (&[0.0, 1.0, 2.0][..], &curves[..])] {
            let figure = FollowingErrorFigure { title: "", time_s, curves, judged_from_s: 0.0 };
            let svg = following_error_over_time(&figure);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
