//! Contour error along a run, over time. The worst point is marked with its time and line.

use super::axis::{Axis, plain, range_from_zero};
use super::chart::{Chart, HALF, Panel, Sample, TALL, envelope};
use super::svg::{INKS, Ink, MUTED, Stroke};

/// One point of the curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContourPoint {
    /// Time from the start \[s\].
    pub time_s: f64,
    /// Line of the program; 0 for a path without a program.
    pub line: u64,
    /// Contour error \[µm\].
    pub contour_um: f64,
    /// Angle between the tool axes \[µrad\].
    pub axis_urad: Option<f64>,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct ContourFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// The run.
    pub points: &'a [ContourPoint],
    /// Start of the judged part \[s\].
    pub judged_from_s: f64,
}

/// Number of columns of an envelope: steps that an eye can follow.
const COLUMNS: usize = 220;
const START: Stroke = Stroke::new(MUTED, 1.2).dashed("6 4");

/// Draws the contour error of the tip, and that of the tool axis below it, and marks the worst judged point. A long run
/// is drawn as its envelope. Same numbers, same bytes.
#[must_use]
pub fn contour_error_along(figure: &ContourFigure<'_>) -> String {
    let points: Vec<ContourPoint> =
        figure.points.iter().copied().filter(|point| point.contour_um.is_finite()).collect();
    let tip: Vec<(f64, f64)> = points.iter().map(|point| (point.time_s, point.contour_um)).collect();
    let axis: Vec<(f64, f64)> =
        points.iter().filter_map(|point| Some((point.time_s, point.axis_urad?))).collect();
    let has_axis = axis.iter().any(|(_, axis_urad)| *axis_urad > 0.0);
    let end_s = points.last().map_or(1.0, |point| point.time_s).max(1e-6);
    let mut chart = Chart::new(figure.title);
    let tip_axis = Axis::linear(
        range_from_zero(tip.iter().map(|(_, error)| *error)),
        if has_axis { "tool tip [µm]" } else { "contour error of the tool tip [µm]" },
    );
    let (height, time) = if has_axis { (HALF, "") } else { (TALL, TIME) };
    let panel = chart.panel(height, Axis::linear(0.0..end_s, time), tip_axis);
    course(&mut chart, &panel, &tip, INKS[0], "contour error of the tool tip");
    if has_axis {
        let range = range_from_zero(axis.iter().map(|(_, error)| *error));
        let below =
            chart.panel(HALF, Axis::linear(0.0..end_s, TIME), Axis::linear(range, "tool axis [µrad]"));
        course(&mut chart, &below, &axis, INKS[2], "error of the tool axis");
        judged(&mut chart, &below, figure.judged_from_s);
    }
    judged(&mut chart, &panel, figure.judged_from_s);
    if figure.judged_from_s > 0.0 {
        chart.explain(Sample::Line(START), format!("judged from {} s", plain(figure.judged_from_s)));
    }
    let from_judged = points.iter().filter(|point| point.time_s >= figure.judged_from_s);
    let worst = from_judged.max_by(|a, b| a.contour_um.abs().total_cmp(&b.contour_um.abs()));
    let mut description = "Contour error of the tool tip over time.".to_owned();
    if let Some(worst) = worst {
        let at_line = if worst.line > 0 { format!("line {}, ", worst.line) } else { String::new() };
        let label = format!("{at_line}{} s: {} µm", plain(worst.time_s), plain(worst.contour_um));
        chart.mark(&panel, (worst.time_s, worst.contour_um), &label);
        description = format!("{description} Largest: {label}.");
    }
    chart.finish(&description)
}

const TIME: &str = "time [s]";

/// Draws an error over time, and explains it. A long run is drawn as its envelope: the points of a run are the largest
/// of their neighbours, so errors without a sign have an upper edge only.
fn course(chart: &mut Chart, panel: &Panel, points: &[(f64, f64)], ink: Ink, name: &str) {
    let stroke = Stroke::new(ink, 1.4);
    let Some(columns) = envelope(points, COLUMNS) else {
        chart.line(panel, points.iter().copied(), stroke);
        return chart.explain(Sample::Line(stroke), name);
    };
    let has_sign = points.iter().any(|(_, error)| *error < 0.0);
    let floor = |least: f64| if has_sign { least } else { 0.0 };
    chart.band(panel, columns.iter().map(|(x, least, most)| (*x, floor(*least), *most)), ink, 0.25);
    chart.line(panel, columns.iter().map(|(x, _, most)| (*x, *most)), stroke);
    let kind = if has_sign {
        chart.line(panel, columns.iter().map(|(x, least, _)| (*x, *least)), stroke);
        "least and largest"
    } else {
        "largest"
    };
    chart.explain(Sample::Line(stroke), format!("{name}: {kind} in each 1/{COLUMNS} of the time"));
}

/// A line at the start of the judged part.
fn judged(chart: &mut Chart, panel: &Panel, from_s: f64) {
    if from_s > 0.0 {
        chart.upright(panel, from_s, START);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figure_marks_the_worst_line_and_names_its_units() {
        let points: Vec<ContourPoint> = (0..300_u32)
            .map(|k| ContourPoint {
                time_s: f64::from(k) * 0.01,
                line: u64::from(k) + 5,
                contour_um: 30.0 * (f64::from(k) * 0.02).sin(),
                axis_urad: Some(f64::from(k)),
            })
            .collect();
        let figure = ContourFigure { title: "blade.nc", points: &points, judged_from_s: 0.0 };
        let svg = contour_error_along(&figure);
        let worst =
            points.iter().max_by(|a, b| a.contour_um.abs().total_cmp(&b.contour_um.abs())).expect("points");
        for part in ["time [s]", "[µm]", "[µrad]", &format!("line {}, ", worst.line), ": −30 µm"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, contour_error_along(&figure));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        let point = |contour_um| ContourPoint { time_s: 1.0, line: 0, contour_um, axis_urad: None };
        for points in [vec![], vec![point(f64::NAN)], vec![point(0.0)], vec![point(1e200), point(-1e200)]] {
            let figure = ContourFigure { title: "", points: &points, judged_from_s: 0.0 };
            let svg = contour_error_along(&figure);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
