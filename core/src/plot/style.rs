//! Common parts of the figures.

use plotters::chart::DualCoordChartContext;
use plotters::coord::CoordTranslate;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width and height of a figure.
pub(super) const SIZE: (u32, u32) = (1000, 520);
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);
pub(super) const MUTED: RGBColor = RGBColor(90, 90, 90);
/// Colours that can be distinguished with any colour vision (Okabe and Ito), without the lightest.
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(120, 94, 20),
];

/// The colour of the curve of this index.
pub(super) fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// Title, margins, and space for the names of the axes.
pub(super) fn frame<DB: DrawingBackend>(builder: &mut ChartBuilder<'_, '_, DB>, title: &str) {
    builder.caption(title, ("sans-serif", 18)).margin(16).x_label_area_size(48).y_label_area_size(74);
}

/// Grid and numbers, and the names of the axes.
pub(super) fn mesh<DB, X, Y>(
    chart: &mut ChartContext<'_, DB, Cartesian2d<X, Y>>,
    x_name: &str,
    y_name: &str,
) -> Option<()>
where
    DB: DrawingBackend,
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .x_desc(x_name)
        .y_desc(y_name)
        .label_style(("sans-serif", 14))
        .axis_desc_style(("sans-serif", 15))
        .light_line_style(WHITE.mix(0.0))
        .bold_line_style(GRID)
        .x_label_formatter(&|value| plain(*value))
        .y_label_formatter(&|value| plain(*value))
        .draw()
        .ok()
}

/// The scale on the right, with its numbers in this letter size.
pub(super) fn right_axis<DB, CT, X, Y>(
    chart: &mut DualCoordChartContext<'_, DB, CT, Cartesian2d<X, Y>>,
    name: &str,
    size: u32,
) -> Option<()>
where
    DB: DrawingBackend,
    CT: CoordTranslate,
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_secondary_axes()
        .y_desc(name)
        .label_style(("sans-serif", size))
        .axis_desc_style(("sans-serif", size + 1))
        .y_label_formatter(&|value: &f64| plain(*value))
        .draw()
        .ok()
}

/// The sample beside a curve's name in the legend.
pub(super) fn swatch(style: impl Into<ShapeStyle>) -> impl Fn((i32, i32)) -> PathElement<(i32, i32)> {
    let style = style.into();
    move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style)
}

/// The names of the curves. The background shows through by 1 − `cover`.
pub(super) fn legend<'a, DB, CT>(
    chart: &mut ChartContext<'a, DB, CT>,
    position: SeriesLabelPosition,
    cover: f64,
) -> Option<()>
where
    DB: DrawingBackend + 'a,
    CT: CoordTranslate,
{
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE.mix(cover))
        .border_style(GRID)
        .label_font(("sans-serif", 14))
        .draw()
        .ok()
}

/// The upper corner outside the half of the figure with a mark.
pub(super) const fn corner_opposite(is_right: bool) -> SeriesLabelPosition {
    if is_right { SeriesLabelPosition::UpperLeft } else { SeriesLabelPosition::UpperRight }
}

/// The style of the mark on the worst point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark {
    /// Colour of the dot.
    pub(super) dot: RGBColor,
    /// Colour of its label.
    pub(super) text: RGBColor,
    /// Whether the label is left of the dot: near the right edge it would leave the figure.
    pub(super) is_left: bool,
}

/// Marks the worst point with a dot and a label above it.
pub(super) fn mark_worst<DB, X, Y>(
    chart: &mut ChartContext<'_, DB, Cartesian2d<X, Y>>,
    at: (f64, f64),
    label: String,
    mark: Mark,
) -> Option<()>
where
    DB: DrawingBackend,
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let (anchor, shift) = if mark.is_left { (HPos::Right, -8) } else { (HPos::Left, 8) };
    let style = ("sans-serif", 14).into_font().color(&mark.text).pos(Pos::new(anchor, VPos::Bottom));
    chart
        .draw_series(std::iter::once(
            EmptyElement::at(at)
                + Circle::new((0, 0), 4, mark.dot.filled())
                + Text::new(label, (shift, -4), style),
        ))
        .ok()?;
    Some(())
}

/// A number with the digits that a reader needs, without an exponent.
pub(super) fn plain(value: f64) -> String {
    let digits = match value.abs() {
        size if size == 0.0 || size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        size if size >= 0.1 => 3,
        _ => 4,
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// 1, 2 or 5 times a power of ten, the largest that is not above `value`.
pub(super) fn round_down(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let mut decade = 1.0;
    while decade > value {
        decade /= 10.0;
    }
    while decade * 10.0 <= value {
        decade *= 10.0;
    }
    [5.0, 2.0, 1.0].into_iter().map(|step| step * decade).find(|step| *step <= value).unwrap_or(decade)
}

/// Smallest and largest of the finite values, widened by a twentieth so that no curve touches the frame. ±1 if
/// there is no value.
pub(super) fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|value| value.is_finite()) {
        least = least.min(value);
        most = most.max(value);
    }
    if least > most {
        return -1.0..1.0;
    }
    let margin = 0.05 * (most - least);
    let margin = if margin > 0.0 { margin } else { 0.5 * most.abs().max(1e-6) };
    least - margin..most + margin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_marks_are_round() {
        for (value, expected) in [(37.0, 20.0), (5.0, 5.0), (0.0199, 0.01), (999.0, 500.0), (0.0, 1.0)] {
            assert!((round_down(value) - expected).abs() < 1e-12 * expected, "{value}");
        }
        assert!((round_down(f64::NAN) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_range_is_never_empty() {
        for values in [vec![], vec![3.0], vec![0.0, 0.0], vec![f64::NAN], vec![-2.0, 5.0]] {
            let range = range(values.into_iter());
            assert!(range.start < range.end, "{range:?}");
        }
    }
}
