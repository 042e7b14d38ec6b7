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
/// The edge of an envelope is the largest value of this many columns on each side.
const NEAR: usize = 3;
const START: Stroke = Stroke::new(MUTED, 1.2).dashed("6 4");

/// Draws the contour error of the tip, and that of the tool axis below it, and marks the worst judged point. A run along
/// a program is drawn with its envelope. Same numbers, same bytes.
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
    let of_program = points.iter().any(|point| point.line > 0);
    course(&mut chart, &panel, &tip, (INKS[0], "contour error of the tool tip"), of_program);
    if has_axis {
        let range = range_from_zero(axis.iter().map(|(_, error)| *error));
        let below =
            chart.panel(HALF, Axis::linear(0.0..end_s, TIME), Axis::linear(range, "tool axis [µrad]"));
        course(&mut chart, &below, &axis, (INKS[2], "error of the tool axis"), of_program);
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

/// Draws an error over time, and explains it. Along a program it is drawn with its envelope: an error rises and falls
/// in every block, and a line alone would be a comb. The points of a run are the largest of their neighbours, so an
/// error without a sign has an upper edge only.
fn course(
    chart: &mut Chart,
    panel: &Panel,
    points: &[(f64, f64)],
    (ink, name): (Ink, &str),
    of_program: bool,
) {
    let stroke = Stroke::new(ink, 1.8);
    let Some(columns) = envelope(points, COLUMNS).filter(|_| of_program) else {
        chart.line(panel, points.iter().copied(), stroke);
        return chart.explain(Sample::Line(stroke), name);
    };
    let has_sign = points.iter().any(|(_, error)| *error < 0.0);
    let floor = |least: f64| if has_sign { least } else { 0.0 };
    chart.band(panel, columns.iter().map(|(x, least, most)| (*x, floor(*least), *most)), ink, 0.3);
    chart.explain(Sample::Area(ink, 0.3), name);
    let near = |place: usize| {
        let ends = place.saturating_sub(NEAR)..(place + NEAR + 1).min(columns.len());
        columns.get(ends).unwrap_or_default().iter()
    };
    let edge = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        columns.iter().enumerate().map(|(place, (x, ..))| (*x, of(place))).collect()
    };
    chart.line(panel, edge(&|place| near(place).map(|(.., most)| *most).fold(f64::MIN, f64::max)), stroke);
    if has_sign {
        let lower = edge(&|place| near(place).map(|(_, least, _)| *least).fold(f64::MAX, f64::min));
        chart.line(panel, lower, stroke);
    }
    chart.explain(Sample::Line(stroke), "its envelope: the largest nearby");
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
