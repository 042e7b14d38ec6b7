//! Contour error along a run, over time. The worst point is marked with its time and line.

use plotters::prelude::*;

use super::PlotFault;
use super::style::{
    MUTED, Mark, SIZE, colour, corner_opposite, frame, legend, mark_worst, mesh, plain, range, right_axis,
    swatch,
};

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

/// Draws the contour error of the tip on the left scale and that of the tool axis on the right, and marks the worst
/// judged point. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn contour_error_along(figure: &ContourFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &ContourFigure<'_>, svg: &mut String) -> Option<()> {
    let points: Vec<ContourPoint> =
        figure.points.iter().copied().filter(|point| point.contour_um.is_finite()).collect();
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let axis_urad = || points.iter().filter_map(|point| Some((point.time_s, point.axis_urad?)));
    let has_axis = axis_urad().any(|(_, axis_urad)| axis_urad > 0.0);
    let end_s = points.last().map_or(1.0, |point| point.time_s).max(1e-6);
    let left = range(points.iter().map(|point| point.contour_um).chain([0.0]));
    let right = range(axis_urad().map(|(_, axis_urad)| axis_urad).chain([0.0]));
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, figure.title);
    let mut chart = builder
        .right_y_label_area_size(if has_axis { 74 } else { 16 })
        .build_cartesian_2d(0.0..end_s, left.start..left.end + 0.1 * (left.end - left.start))
        .ok()?
        .set_secondary_coord(0.0..end_s, right);
    mesh(&mut chart, "time [s]", "contour error of the tip [µm]")?;
    if has_axis {
        right_axis(&mut chart, "error of the tool axis [µrad]", 14)?;
        chart
            .draw_secondary_series(LineSeries::new(axis_urad(), colour(2).mix(0.7).stroke_width(1)))
            .ok()?
            .label("tool axis [µrad]")
            .legend(swatch(colour(2).stroke_width(3)));
    }
    let tip = points.iter().map(|point| (point.time_s, point.contour_um));
    chart
        .draw_series(LineSeries::new(tip, colour(0).stroke_width(1)))
        .ok()?
        .label("tool tip [µm]")
        .legend(swatch(colour(0).stroke_width(3)));
    let judged = points.iter().filter(|point| point.time_s >= figure.judged_from_s);
    let worst = judged.max_by(|a, b| a.contour_um.abs().total_cmp(&b.contour_um.abs()));
    if let Some(worst) = worst {
        let place = if worst.line > 0 {
            format!("line {}", worst.line)
        } else {
            format!("{} s", plain(worst.time_s))
        };
        let label = format!("{place}: {} µm", plain(worst.contour_um));
        let mark = Mark { dot: colour(1), text: MUTED, is_left: worst.time_s > 0.7 * end_s };
        mark_worst(&mut chart, (worst.time_s, worst.contour_um), label, mark)?;
    }
    let right = worst.is_some_and(|worst| worst.time_s > 0.5 * end_s);
    legend(&mut chart, corner_opposite(right), 0.85)?;
    drop(chart);
    root.present().ok()
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
        let svg = contour_error_along(&figure).expect("a figure");
        let worst =
            points.iter().max_by(|a, b| a.contour_um.abs().total_cmp(&b.contour_um.abs())).expect("points");
        for part in ["time [s]", "[µm]", "[µrad]", &format!("line {}: -30", worst.line)] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, contour_error_along(&figure).expect("a figure"));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        let point = |contour_um| ContourPoint { time_s: 1.0, line: 0, contour_um, axis_urad: None };
        for points in [vec![], vec![point(f64::NAN)], vec![point(0.0)], vec![point(1e200), point(-1e200)]] {
            let figure = ContourFigure { title: "", points: &points, judged_from_s: 0.0 };
            let svg = contour_error_along(&figure).expect("a figure");
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
