//! A location error over the runs, with uncertainty bars.

use plotters::prelude::*;

use super::PlotFault;
use super::style::{MUTED, SIZE, colour, frame, legend, mesh, range, swatch};

/// One run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrendMark {
    /// Days since the first run.
    pub days: f64,
    /// The value of the error.
    pub value: f64,
    /// Its standard uncertainty, if there is one.
    pub standard_uncertainty: Option<f64>,
    /// Whether the run determines it.
    pub identifiable: bool,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct TrendFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Name of the x axis, with the day of the first run.
    pub time_name: &'a str,
    /// Name and unit of the error.
    pub error_name: &'a str,
    /// The runs, oldest first.
    pub runs: &'a [TrendMark],
}

/// Bars reach two standard uncertainties in each direction: about 95 %.
const COVERAGE: f64 = 2.0;

/// Draws each run as a dot with its bar of two standard uncertainties, and joins the dots. Runs that do not
/// determine the error are hollow. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn calibration_trend(figure: &TrendFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &TrendFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let half = |run: &TrendMark| COVERAGE * run.standard_uncertainty.unwrap_or(0.0);
    let ends = figure.runs.iter().flat_map(|run| [run.value - half(run), run.value + half(run)]);
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, figure.title);
    let days = range(figure.runs.iter().map(|run| run.days));
    let mut chart = builder.build_cartesian_2d(days, range(ends)).ok()?;
    mesh(&mut chart, figure.time_name, figure.error_name)?;
    let line = figure.runs.iter().map(|run| (run.days, run.value));
    chart.draw_series(LineSeries::new(line, MUTED.stroke_width(1))).ok()?;
    let bars = figure.runs.iter().filter(|run| run.standard_uncertainty.is_some()).map(|run| {
        let ends = [(run.days, run.value - half(run)), (run.days, run.value + half(run))];
        PathElement::new(ends, colour(0).stroke_width(2))
    });
    chart
        .draw_series(bars)
        .ok()?
        .label("plus and minus two standard uncertainties")
        .legend(swatch(colour(0).stroke_width(2)));
    let dots = figure.runs.iter().map(|run| {
        let style = if run.identifiable { colour(0).filled() } else { colour(1).stroke_width(2) };
        Circle::new((run.days, run.value), 4, style)
    });
    chart.draw_series(dots).ok()?;
    if figure.runs.iter().any(|run| !run.identifiable) {
        chart
            .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())
            .ok()?
            .label("hollow: includes errors that the run could not separate from it")
            .legend(swatch(colour(1).stroke_width(2)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperLeft, 0.85)?;
    drop(chart);
    root.present().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_with_and_without_uncertainty_are_drawn_and_none_at_all_too() {
        let run = |days, value, standard_uncertainty, identifiable| TrendMark {
            days,
            value,
            standard_uncertainty,
            identifiable,
        };
        let runs = [run(0.0, 10.0, Some(0.5), true), run(30.0, 14.0, None, false)];
        let figure = |runs: &[TrendMark]| {
            calibration_trend(&TrendFigure { title: "A e_y", time_name: "days", error_name: "µm", runs })
                .expect("a figure")
        };
        let svg = figure(&runs);
        assert!(svg.contains("two standard uncertainties") && svg.contains("hollow"));
        assert_eq!(svg.matches("<circle").count(), 2);
        assert!(figure(&[]).ends_with("</svg>\n"));
        assert!(!figure(&[run(f64::NAN, f64::NAN, None, true)]).contains("NaN"));
    }
}
