//! Following error of the axes over time (P2 Fig. 6, 8).

use plotters::prelude::*;

use super::PlotFault;
use super::style::{MUTED, SIZE, colour, frame, legend, mesh, plain, range, right_axis, swatch};

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

/// Draws the curves, with linear axes on the left scale and rotary axes on the right, and a line at the start of
/// the judged part. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn following_error_over_time(figure: &FollowingErrorFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &FollowingErrorFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let errors = |linear: bool| {
        let curves = figure.curves.iter().filter(move |curve| curve.is_linear == linear);
        curves.flat_map(|curve| curve.errors.iter().copied())
    };
    let end_s = figure.time_s.last().copied().unwrap_or(1.0).max(1e-6);
    let (left, right) = (range(errors(true)), range(errors(false)));
    let has_rotary = figure.curves.iter().any(|curve| !curve.is_linear);
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, figure.title);
    let mut chart = builder
        .right_y_label_area_size(if has_rotary { 74 } else { 16 })
        .build_cartesian_2d(0.0..end_s, left.clone())
        .ok()?
        .set_secondary_coord(0.0..end_s, right);
    mesh(&mut chart, "time [s]", "following error of linear axes [µm]")?;
    if has_rotary {
        right_axis(&mut chart, "following error of rotary axes [µrad]", 14)?;
    }
    if figure.judged_from_s > 0.0 {
        let at = [(figure.judged_from_s, left.start), (figure.judged_from_s, left.end)];
        chart
            .draw_series(DashedLineSeries::new(at, 6, 4, MUTED.stroke_width(1)))
            .ok()?
            .label(format!("judged from {} s", plain(figure.judged_from_s)))
            .legend(swatch(MUTED.stroke_width(1)));
    }
    for (index, curve) in figure.curves.iter().enumerate() {
        let points = figure.time_s.iter().copied().zip(curve.errors.iter().copied());
        let line =
            LineSeries::new(points.filter(|(_, error)| error.is_finite()), colour(index).stroke_width(1));
        let unit = if curve.is_linear { "µm" } else { "µrad" };
        let label = format!("{} [{unit}]", curve.axis);
        let drawn = if curve.is_linear {
            chart.draw_series(line).ok()?
        } else {
            chart.draw_secondary_series(line).ok()?
        };
        drawn.label(label).legend(swatch(colour(index).stroke_width(3)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperLeft, 0.85)?;
    drop(chart);
    root.present().ok()
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
        let svg = following_error_over_time(&figure).expect("a figure");
        for part in ["time [s]", "[µm]", "[µrad]", "X [µm]", "C [µrad]", "judged from 1 s"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, following_error_over_time(&figure).expect("a figure"));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        let odd = [f64::NAN, 1e300, 0.0];
        let curves = [FollowingErrorCurve { axis: 'A', is_linear: false, errors: &odd }];
        for (time_s, curves) in [(&[][..], &[][..]), (&[0.0, 1.0, 2.0][..], &curves[..])] {
            let figure = FollowingErrorFigure { title: "", time_s, curves, judged_from_s: 0.0 };
            let svg = following_error_over_time(&figure).expect("a figure");
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
