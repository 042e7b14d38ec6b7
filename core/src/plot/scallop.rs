//! Scallop height over the step-over or over the tool radius (P3 Fig. 4).

use plotters::prelude::*;

use super::PlotFault;
use super::style::{GRID, MUTED, SIZE, colour, plain, range};

/// One curve with its marked points.
#[derive(Debug, Clone, PartialEq)]
pub struct ScallopCurve {
    /// Name of the curve: the values that are constant along it.
    pub label: String,
    /// Position \[mm\] and height \[µm\], in order.
    pub line: Vec<(f64, f64)>,
    /// Marked points: position \[mm\] and height \[µm\].
    pub dots: Vec<(f64, f64)>,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct ScallopFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Quantity along the x axis, with its unit.
    pub place: &'a str,
    /// The curves.
    pub curves: &'a [ScallopCurve],
    /// Allowed height \[µm\], drawn as a dashed line.
    pub allowed_um: Option<f64>,
}

/// Draws the curves, their points, and the allowed height. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn scallop_heights(figure: &ScallopFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &ScallopFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let points = || {
        let all = figure.curves.iter().flat_map(|curve| curve.line.iter().chain(&curve.dots));
        all.copied().filter(|(place, height)| place.is_finite() && height.is_finite())
    };
    let most = points().map(|(_, height)| height).fold(0.0, f64::max);
    // An allowed height far above the curves would make them look flat.
    let allowed = figure.allowed_um.filter(|allowed| allowed.is_finite() && *allowed <= 3.0 * most);
    let places = range(points().map(|(place, _)| place));
    let heights = range(points().map(|(_, height)| height).chain(allowed));
    let mut chart = ChartBuilder::on(&root)
        .caption(figure.title, ("sans-serif", 18))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(84)
        .build_cartesian_2d(places.clone(), heights)
        .ok()?;
    chart
        .configure_mesh()
        .x_desc(figure.place)
        .y_desc("scallop height [µm]")
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .light_line_style(WHITE.mix(0.0))
        .bold_line_style(GRID)
        .x_label_formatter(&|value| plain(*value))
        .y_label_formatter(&|value| plain(*value))
        .draw()
        .ok()?;
    for (index, curve) in figure.curves.iter().enumerate() {
        let finite = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect()
        };
        chart
            .draw_series(LineSeries::new(finite(&curve.line), colour(index).stroke_width(2)))
            .ok()?
            .label(&curve.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], colour(index).stroke_width(3)));
        let dots = finite(&curve.dots).into_iter().map(|at| Circle::new(at, 4, colour(index).filled()));
        chart.draw_series(dots).ok()?;
    }
    if let Some(allowed) = allowed {
        let ends = [(places.start, allowed), (places.end, allowed)];
        chart
            .draw_series(DashedLineSeries::new(ends, 8, 5, MUTED.stroke_width(2)))
            .ok()?
            .label(format!("allowed {} µm", plain(allowed)))
            .legend(|(x, y)| PathElement::new([(x, y), (x + 22, y)], MUTED.stroke_width(2)));
    }
    // Heights rise to the right over a step-over, and fall over a radius. The legend stays out of their way.
    let rises = figure.curves.first().is_none_or(|curve| {
        curve.line.first().zip(curve.line.last()).is_none_or(|(first, last)| first.1 <= last.1)
    });
    let corner = if rises { SeriesLabelPosition::UpperLeft } else { SeriesLabelPosition::UpperRight };
    chart
        .configure_series_labels()
        .position(corner)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font(("sans-serif", 14))
        .draw()
        .ok()?;
    drop(chart);
    root.present().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(scale: f64) -> ScallopCurve {
        let line: Vec<(f64, f64)> =
            (0..50_u32).map(|k| (f64::from(k) * 0.01, scale * f64::from(k).powi(2))).collect();
        ScallopCurve { label: "tool radius 5 mm".to_owned(), dots: vec![line[30]], line }
    }

    #[test]
    fn the_figure_names_units_curves_and_what_is_allowed() {
        let curves = [curve(0.01), curve(0.02)];
        let figure = ScallopFigure {
            title: "convex surface",
            place: "step-over [mm]",
            curves: &curves,
            allowed_um: Some(20.0),
        };
        let svg = scallop_heights(&figure).expect("a figure");
        for part in ["step-over [mm]", "height [µm]", "tool radius 5 mm", "allowed 20 µm", "<circle"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, scallop_heights(&figure).expect("a figure"));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        for curves in [vec![], vec![curve(0.0)], vec![curve(f64::NAN)], vec![curve(1e200)]] {
            let figure =
                ScallopFigure { title: "", place: "", curves: &curves, allowed_um: Some(f64::INFINITY) };
            let svg = scallop_heights(&figure).expect("a figure");
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
