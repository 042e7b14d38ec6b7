//! Scallop height over the step-over or over the tool radius (P3 Fig. 4).

use super::axis::{Axis, plain, range_from_zero, span};
use super::chart::{Chart, Sample, TALL};
use super::svg::{BLACK, Dot, Stroke};

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

const ALLOWED: Stroke = Stroke::new(BLACK, 1.4).dashed("9 5");

/// Draws the curves, their points, and the allowed height. Same numbers, same bytes.
#[must_use]
pub fn scallop_heights(figure: &ScallopFigure<'_>) -> String {
    let points = || {
        let all = figure.curves.iter().flat_map(|curve| curve.line.iter().chain(&curve.dots));
        all.copied().filter(|(place, height)| place.is_finite() && height.is_finite())
    };
    let most = points().map(|(_, height)| height).fold(0.0, f64::max);
    // An allowed height far above the curves would make them look flat.
    let allowed = figure.allowed_um.filter(|allowed| allowed.is_finite() && *allowed <= 3.0 * most);
    let places = span(points().map(|(place, _)| place));
    let heights = range_from_zero(points().map(|(_, height)| height).chain(allowed));
    let mut chart = Chart::new(figure.title);
    let panel =
        chart.panel(TALL, Axis::linear(places, figure.place), Axis::linear(heights, "scallop height [µm]"));
    if let Some(allowed) = allowed {
        chart.level(&panel, allowed, ALLOWED);
    }
    for (index, curve) in figure.curves.iter().enumerate() {
        let stroke = Stroke::of_curve(index);
        chart.line(&panel, curve.line.iter().copied(), stroke);
        chart.dots(&panel, curve.dots.iter().copied(), 4.0, Dot::Disk(stroke.ink));
        chart.explain(Sample::Dotted(stroke, Dot::Disk(stroke.ink)), curve.label.as_str());
    }
    if let Some(allowed) = allowed {
        chart.explain(Sample::Line(ALLOWED), format!("allowed {} µm", plain(allowed)));
    }
    let allowed = allowed.map_or_else(String::new, |allowed| format!(", {} µm allowed", plain(allowed)));
    chart.finish(&format!("Scallop height over the {}: up to {} µm{allowed}.", figure.place, plain(most)))
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
        let svg = scallop_heights(&figure);
        for part in ["step-over [mm]", "height [µm]", "tool radius 5 mm", "allowed 20 µm", "<circle"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, scallop_heights(&figure));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        for curves in [vec![], vec![curve(0.0)], vec![curve(f64::NAN)], vec![curve(1e200)]] {
            let figure =
                ScallopFigure { title: "", place: "", curves: &curves, allowed_um: Some(f64::INFINITY) };
            let svg = scallop_heights(&figure);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
