//! Deviation of the cutter contact along its path, or the errors along a program, before and after compensation.

use super::axis::{Axis, plain};
use super::chart::{Chart, Panel, Sample, TALL, envelope};
use super::svg::{BLACK, INKS, Stroke};

/// One point of the curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviationPoint {
    /// Contact path length \[mm\], or the line of the program.
    pub path_mm: f64,
    /// Line of the upload.
    pub line: u64,
    /// Deviation before \[µm\].
    pub before_um: f64,
    /// Deviation after \[µm\].
    pub after_um: f64,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct DeviationFigure<'a> {
    /// Program and machine, one line.
    pub title: &'a str,
    /// The curves.
    pub points: &'a [DeviationPoint],
    /// The tolerance \[µm\], if there is one.
    pub tolerance_um: Option<f64>,
    /// Name and unit of the deviation: the text of its axis.
    pub quantity: &'a str,
    /// Name of the x axis: the path or the line of the program.
    pub place: &'a str,
}

/// The x axis of a figure over the contact path.
pub const ALONG_CONTACT_PATH: &str = "cutter-contact path [mm]";

impl DeviationPoint {
    /// The points of a series that is stored by columns.
    #[must_use]
    pub fn zipped(path_mm: &[f64], line: &[u64], before_um: &[f64], after_um: &[f64]) -> Vec<Self> {
        path_mm
            .iter()
            .zip(line)
            .zip(before_um.iter().zip(after_um))
            .map(|((path_mm, line), (before_um, after_um))| Self {
                path_mm: *path_mm,
                line: *line,
                before_um: *before_um,
                after_um: *after_um,
            })
            .collect()
    }
}

/// Ratio of the largest drawn deviation to the tolerance above which the axis is logarithmic.
const LOG_ABOVE: f64 = 50.0;
/// The logarithmic axis starts at this share of the tolerance.
const LOG_FLOOR: f64 = 1e-2;

const BEFORE: Stroke = Stroke::new(INKS[1], 1.4).dashed("5 2");
const AFTER: Stroke = Stroke::new(INKS[0], 1.4);
const TOLERANCE: Stroke = Stroke::new(BLACK, 1.4).dashed("9 5");

/// Draws both curves and the tolerance. Marks the worst block before compensation with its line number. The deviation
/// axis is logarithmic if the largest value is more than 50 times the tolerance. Of a long series, it draws the largest
/// value of each column. Same points, same bytes.
#[must_use]
pub fn deviation_along_path(figure: &DeviationFigure<'_>) -> String {
    let points = figure.points;
    let start = points.first().map_or(0.0, |point| point.path_mm);
    let end = points.last().map_or(1.0, |point| point.path_mm).max(start + 1e-3);
    let tolerance_um = figure.tolerance_um.filter(|tolerance| tolerance.is_finite() && *tolerance > 0.0);
    let finite = |value: &f64| value.is_finite();
    let values = || points.iter().flat_map(|point| [point.before_um, point.after_um]).filter(finite);
    let largest = values().fold(tolerance_um.unwrap_or(1e-3), f64::max);
    // A path starts at 0; lines start where the program does.
    let x = Axis::linear(start.min(if start < 0.1 * end { 0.0 } else { start })..end, figure.place);
    let y = match tolerance_um {
        Some(tolerance) if largest > LOG_ABOVE * tolerance => {
            Axis::logarithmic(LOG_FLOOR * tolerance..largest * 3.0, figure.quantity)
        }
        _ => Axis::linear(0.0..largest * 1.14, figure.quantity),
    };
    let mut chart = Chart::new(figure.title);
    let panel = chart.panel(TALL, x, y);
    curve(&mut chart, &panel, points, |point| point.before_um, BEFORE);
    curve(&mut chart, &panel, points, |point| point.after_um, AFTER);
    chart.explain(Sample::Line(BEFORE), "before");
    chart.explain(Sample::Line(AFTER), "after");
    if let Some(level) = tolerance_um {
        chart.level(&panel, level, TOLERANCE);
        chart.explain(Sample::Line(TOLERANCE), format!("tolerance {} µm", plain(level)));
    }
    let worst = points
        .iter()
        .filter(|point| point.before_um.is_finite())
        .max_by(|a, b| a.before_um.total_cmp(&b.before_um));
    let mut description = format!("{}, before and after.", figure.quantity);
    if let Some(worst) = worst {
        let label = format!("line {}: {} µm before", worst.line, plain(worst.before_um));
        chart.mark(&panel, (worst.path_mm, worst.before_um), &label);
        let after = points.iter().map(|point| point.after_um).filter(finite).fold(0.0, f64::max);
        description = format!("{description} Largest: {label}, {} µm after.", plain(after));
    }
    chart.finish(&description)
}

/// One curve, with a light area below it.
fn curve(
    chart: &mut Chart,
    panel: &Panel,
    points: &[DeviationPoint],
    value: fn(&DeviationPoint) -> f64,
    stroke: Stroke,
) {
    let all: Vec<(f64, f64)> = points.iter().map(|point| (point.path_mm, value(point))).collect();
    let drawn = match envelope(&all, Chart::columns(panel)) {
        Some(columns) => columns.into_iter().map(|(x, _, most)| (x, most)).collect(),
        None => all,
    };
    chart.band(panel, drawn.iter().map(|(x, y)| (*x, f64::MIN, *y)), stroke.ink, 0.12);
    chart.line(panel, drawn, stroke);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(scale: f64) -> Vec<DeviationPoint> {
        (0..500_u32)
            .map(|k| {
                let phase = f64::from(k) / 30.0;
                DeviationPoint {
                    path_mm: f64::from(k) * 0.7,
                    line: u64::from(k) + 12,
                    before_um: scale * phase.sin().abs() * (1.0 + f64::from(k) / 400.0),
                    after_um: 9.5 * phase.cos().abs(),
                }
            })
            .collect()
    }

    #[test]
    fn the_figure_names_units_tolerance_and_the_worst_line() {
        let points = wave(40.0);
        let figure = DeviationFigure {
            title: "flank.nc on example-ac-table",
            points: &points,
            tolerance_um: Some(10.0),
            quantity: "deviation [µm]",
            place: ALONG_CONTACT_PATH,
        };
        let svg = deviation_along_path(&figure);
        let worst = points.iter().max_by(|a, b| a.before_um.total_cmp(&b.before_um)).expect("points");
        for part in
            ["path [mm]", "[µm]", "tolerance 10 µm", "before", "after", &format!("line {}:", worst.line)]
        {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, deviation_along_path(&figure));
    }

    #[test]
    fn empty_and_enormous_figures_are_drawn() {
        for points in [Vec::new(), wave(1e6), wave(0.0)] {
            let figure = DeviationFigure {
                title: "",
                points: &points,
                tolerance_um: Some(10.0),
                quantity: "deviation [µm]",
                place: ALONG_CONTACT_PATH,
            };
            assert!(deviation_along_path(&figure).ends_with("</svg>\n"));
        }
    }
}
