//! Deviation of the cutter contact along its path, before and after compensation.

use plotters::prelude::*;

use super::PlotFault;
use super::style::{MUTED, Mark, SIZE, corner_opposite, frame, legend, mark_worst, mesh, plain, swatch};

/// One point of the curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviationPoint {
    /// Contact path length \[mm\].
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
}

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

/// Ratio of the largest drawn to the smallest non-zero deviation above which the axis is logarithmic.
const LOG_ABOVE: f64 = 50.0;
/// The logarithmic axis starts at this share of the tolerance.
const LOG_FLOOR: f64 = 1e-3;

/// Replaces the tolerance in the scale of a figure without one \[µm\].
const NO_TOLERANCE_UM: f64 = 1.0;

const BEFORE: RGBColor = RGBColor(196, 84, 26);
const AFTER: RGBColor = RGBColor(21, 101, 142);

/// Draws both curves over the contact path and the tolerance as a dashed line. Marks the worst block before
/// compensation with its line number. The deviation axis is logarithmic if the largest value is more than 50
/// times the tolerance. Same points, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn deviation_along_path(figure: &DeviationFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &DeviationFigure<'_>, svg: &mut String) -> Option<()> {
    let points = figure.points;
    let path_end = points.last().map_or(1.0, |point| point.path_mm).max(1e-3);
    let scale_um = figure.tolerance_um.unwrap_or(NO_TOLERANCE_UM);
    let largest = points.iter().flat_map(|point| [point.before_um, point.after_um]).fold(scale_um, f64::max);
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, figure.title);
    if largest > LOG_ABOVE * scale_um {
        let floor = LOG_FLOOR * scale_um;
        let chart = builder.build_cartesian_2d(0.0..path_end, (floor..largest * 2.0).log_scale()).ok()?;
        curves(chart, figure, path_end, floor)?;
    } else {
        let chart = builder.build_cartesian_2d(0.0..path_end, 0.0..largest * 1.3).ok()?;
        curves(chart, figure, path_end, 0.0)?;
    }
    root.present().ok()
}

fn curves<'a, Y>(
    mut chart: ChartContext<'a, SVGBackend<'a>, Cartesian2d<plotters::coord::types::RangedCoordf64, Y>>,
    figure: &DeviationFigure<'_>,
    path_end: f64,
    floor: f64,
) -> Option<()>
where
    Y: Ranged<ValueType = f64> + plotters::coord::ranged1d::ValueFormatter<f64>,
{
    mesh(&mut chart, "cutter-contact path [mm]", figure.quantity)?;
    let curve = |value: fn(&DeviationPoint) -> f64| {
        figure.points.iter().map(move |point| (point.path_mm, value(point).max(floor)))
    };
    chart
        .draw_series(LineSeries::new(curve(|point| point.before_um), BEFORE.stroke_width(1)))
        .ok()?
        .label("before")
        .legend(swatch(BEFORE.stroke_width(3)));
    chart
        .draw_series(LineSeries::new(curve(|point| point.after_um), AFTER.stroke_width(1)))
        .ok()?
        .label("after")
        .legend(swatch(AFTER.stroke_width(3)));
    if let Some(level) = figure.tolerance_um {
        let ends = [(0.0, level), (path_end, level)];
        chart
            .draw_series(DashedLineSeries::new(ends, 8, 5, MUTED.stroke_width(2)))
            .ok()?
            .label(format!("tolerance {} µm", plain(level)))
            .legend(swatch(MUTED.stroke_width(2)));
    }
    let worst = figure.points.iter().max_by(|a, b| a.before_um.total_cmp(&b.before_um));
    if let Some(worst) = worst {
        let label = format!("line {}: {} µm", worst.line, plain(worst.before_um));
        let top = (worst.path_mm, worst.before_um.max(floor));
        let mark = Mark { dot: BEFORE, text: BEFORE, is_left: worst.path_mm > 0.75 * path_end };
        mark_worst(&mut chart, top, label, mark)?;
    }
    // The legend stays out of the worst block's half.
    let right = worst.is_some_and(|worst| worst.path_mm > 0.5 * path_end);
    legend(&mut chart, corner_opposite(right), 0.85)
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
        };
        let svg = deviation_along_path(&figure).expect("a figure");
        let worst = points.iter().max_by(|a, b| a.before_um.total_cmp(&b.before_um)).expect("points");
        for part in
            ["path [mm]", "[µm]", "tolerance 10 µm", "before", "after", &format!("line {}:", worst.line)]
        {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, deviation_along_path(&figure).expect("a figure"));
    }

    #[test]
    fn empty_and_enormous_figures_are_drawn() {
        for points in [Vec::new(), wave(1e6), wave(0.0)] {
            let figure = DeviationFigure {
                title: "",
                points: &points,
                tolerance_um: Some(10.0),
                quantity: "deviation [µm]",
            };
            assert!(deviation_along_path(&figure).expect("a figure").ends_with("</svg>\n"));
        }
    }
}
