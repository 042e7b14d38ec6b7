//! A sweep of gains and feeds, as a family of curves and as a map.

use super::axis::{Axis, plain, range, range_from_zero};
use super::chart::{Chart, Sample, TALL, WIDTH, colour_bar};
use super::svg::{Anchor, BLACK, Dot, INKS, Lettering, PAPER, Shade, Stroke, width_of};

/// The content of the figures.
#[derive(Debug, Clone, Copy)]
pub struct SweepFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Name of each row.
    pub gains: &'a [String],
    /// Unit of the feeds.
    pub feed_unit: &'a str,
    /// Feed of each column \[in that unit\].
    pub feeds: &'a [f64],
    /// Largest contour error \[µm\], row by row; `None` without a result.
    pub max_abs_um: &'a [Vec<Option<f64>>],
}

/// A colour ramp from low to high, even in lightness (after Viridis): large errors are dark, also in print.
const RAMP: [[f64; 3]; 5] =
    [[253.0, 231.0, 37.0], [94.0, 201.0, 98.0], [33.0, 145.0, 140.0], [59.0, 82.0, 139.0], [68.0, 1.0, 84.0]];
const NOTHING: Shade = Shade([150, 150, 150]);

fn cells<'a>(figure: &SweepFigure<'a>) -> impl Iterator<Item = f64> + use<'a> {
    figure.max_abs_um.iter().flatten().flatten().copied().filter(|value| value.is_finite())
}

/// Draws the largest contour error over the feed, one curve for each row. If there are more rows than colours, it
/// draws as many rows as there are colours, evenly chosen, with the first and the last. Same numbers, same bytes.
#[must_use]
pub fn sweep_curves(figure: &SweepFigure<'_>) -> String {
    let rows = figure.max_abs_um.len();
    let drawn = rows.min(INKS.len());
    let title = if drawn < rows {
        format!("{} ({drawn} of {rows} gains drawn)", figure.title)
    } else {
        figure.title.to_owned()
    };
    let x = Axis::linear(range(figure.feeds.iter().copied()), format!("feed [{}]", figure.feed_unit));
    let y = Axis::linear(range_from_zero(cells(figure)), "largest contour error [µm]");
    let mut chart = Chart::new(&title);
    let panel = chart.panel(TALL, x, y);
    for index in 0..drawn {
        let row = if drawn > 1 { index * (rows - 1) / (drawn - 1) } else { 0 };
        let Some(cells) = figure.max_abs_um.get(row) else { continue };
        let stroke = Stroke::of_curve(index);
        // A missing cell interrupts the curve.
        let mut points: Vec<(f64, f64)> =
            figure.feeds.iter().zip(cells).map(|(feed, cell)| (*feed, cell.unwrap_or(f64::NAN))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.line(&panel, points.iter().copied(), stroke);
        chart.dots(&panel, points, 3.5, Dot::Disk(stroke.ink));
        let label = figure.gains.get(row).map_or("", String::as_str);
        chart.explain(Sample::Dotted(stroke, Dot::Disk(stroke.ink)), label);
    }
    chart
        .finish(&format!("Largest contour error over the feed, one curve for each gain. {}", best_of(figure)))
}

/// The least error and where it is, in words.
fn best_of(figure: &SweepFigure<'_>) -> String {
    best(figure).map_or_else(String::new, |(least_um, row, column)| {
        let gain = figure.gains.get(row).map_or("", String::as_str);
        let feed = figure.feeds.get(column).copied().unwrap_or(0.0);
        format!("Least: {} µm with {gain} at {} {}.", plain(least_um), plain(feed), figure.feed_unit)
    })
}

/// The least error with its row and column, the first of equal ones.
fn best(figure: &SweepFigure<'_>) -> Option<(f64, usize, usize)> {
    let rows = figure.max_abs_um.iter().enumerate();
    rows.flat_map(|(row, cells)| cells.iter().enumerate().map(move |(column, cell)| (*cell, row, column)))
        .filter_map(|(cell, row, column)| Some((cell.filter(|value| value.is_finite())?, row, column)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Space for the colour scale.
const SCALE: f64 = 130.0;
/// A cell needs this much space for its number.
const NUMBER_PX: (f64, f64) = (6.0, 16.0);

/// Draws the grid as coloured cells with their numbers and a colour scale, and frames the cell with the least error.
/// Cells without a result are grey. Same numbers, same bytes.
#[must_use]
pub fn sweep_map(figure: &SweepFigure<'_>) -> String {
    let (rows, columns) = (figure.max_abs_um.len().max(1), figure.feeds.len().max(1));
    let most = cells(figure).fold(0.0, f64::max);
    let names = |values: &[f64]| values.iter().map(|value| plain(*value)).collect::<Vec<_>>();
    let mut chart = Chart::new(figure.title);
    let widest = figure.gains.iter().map(|gain| width_of(gain, 13.0)).fold(44.0, f64::max);
    let left = 54.0 + widest.min(0.3 * WIDTH);
    let top = chart.take(TALL + 64.0) + 10.0;
    let place = [left, top, WIDTH - left - SCALE, TALL];
    let x = Axis::named(names(figure.feeds), format!("feed [{}]", figure.feed_unit));
    let panel = chart.panel_in(place, x, Axis::named(figure.gains.to_vec(), "gains"));
    let (width, height) = (place[2] / columns as f64, place[3] / rows as f64);
    let shade = |value: f64| Shade::between(&RAMP, if most > 0.0 { value / most } else { 0.0 });
    let corner = |row: usize, column: usize| {
        (left + column as f64 * width, top + place[3] - (row + 1) as f64 * height)
    };
    for (row, cells) in figure.max_abs_um.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            let (x, y) = corner(row, column);
            let value = cell.filter(|value| value.is_finite());
            let shade = value.map_or(NOTHING, shade);
            chart.drawing.boxes(&[[x, y, width, height]], &shade);
            let text = value.map_or_else(|| "–".to_owned(), plain);
            if width_of(&text, 12.0) + NUMBER_PX.0 <= width && height >= NUMBER_PX.1 {
                let lettering = Lettering::new(12.0, shade.ink(), Anchor::Middle);
                chart.drawing.text((x + 0.5 * width, y + 0.5 * height + 4.0), &text, lettering);
            }
        }
    }
    if let Some((least_um, row, column)) = best(figure) {
        let (x, y) = corner(row, column);
        let ends = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)];
        // White beside black is seen on every colour.
        chart.drawing.line(&ends, Stroke::new(PAPER, 5.0));
        chart.drawing.line(&ends, Stroke::new(BLACK, 2.5));
        chart.explain(Sample::Line(Stroke::new(BLACK, 2.5)), format!("least error: {} µm", plain(least_um)));
    }
    if figure.max_abs_um.iter().flatten().any(Option::is_none) {
        chart.explain(Sample::Note, "grey, –: no result");
    }
    chart.explain(Sample::Note, "numbers: largest contour error [µm]");
    let top_um = if most > 0.0 { most } else { 1.0 };
    let marks = Axis::linear(0.0..top_um, "").marks(6.0);
    let marks: Vec<_> = marks.into_iter().map(|(value, text)| (value / top_um, text)).collect();
    let bar = [WIDTH - SCALE + 34.0, top, 20.0, TALL];
    colour_bar(&mut chart, bar, |share| Shade::between(&RAMP, share), &marks);
    chart.drawing.text((bar[0], top - 8.0), "µm", Lettering::new(13.0, BLACK, Anchor::Start));
    drop(panel);
    chart.finish(&format!("Largest contour error for each gain and feed. {}", best_of(figure)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures() -> (Vec<String>, Vec<f64>, Vec<Vec<Option<f64>>>) {
        let gains: Vec<String> = (0..9_u32).map(|k| format!("C × {}", 0.6 + 0.1 * f64::from(k))).collect();
        let feeds: Vec<f64> = (1..=8_u32).map(|k| 300.0 * f64::from(k)).collect();
        let cells = (0..9_u32)
            .map(|row| {
                let mismatch = f64::from(row.abs_diff(4)) * 0.1;
                let cell =
                    |feed: &f64| (row != 8 || *feed < 1500.0).then_some(feed * (mismatch + 0.01) * 0.1);
                feeds.iter().map(cell).collect()
            })
            .collect();
        (gains, feeds, cells)
    }

    #[test]
    fn both_figures_name_units_gains_and_feeds() {
        let (gains, feeds, cells) = figures();
        let figure = SweepFigure {
            title: "XC circle",
            feed_unit: "mm/min",
            gains: &gains,
            feeds: &feeds,
            max_abs_um: &cells,
        };
        let curves = sweep_curves(&figure);
        for part in ["feed [mm/min]", "[µm]", "C × 0.6", "6 of 9 gains drawn"] {
            assert!(curves.contains(part), "{part}");
        }
        let map = sweep_map(&figure);
        // 300 · 0.01 · 0.1 at the matched gain.
        for part in ["feed [mm/min]", "largest contour error [µm]", "0.3 µm", "C × 1"] {
            assert!(map.contains(part), "{part}");
        }
        assert_eq!(map, sweep_map(&figure));
        assert_eq!(curves, sweep_curves(&figure));
    }

    #[test]
    fn empty_single_and_faulty_grids_are_drawn() {
        let one = vec!["as set".to_owned()];
        for (gains, feeds, cells) in [
            (vec![], vec![], vec![]),
            (one.clone(), vec![900.0], vec![vec![Some(3.0)]]),
            (one.clone(), vec![900.0], vec![vec![None]]),
            (one, vec![900.0, 1800.0], vec![vec![Some(f64::NAN), Some(0.0)]]),
        ] {
            let figure = SweepFigure {
                title: "",
                feed_unit: "mm/min",
                gains: &gains,
                feeds: &feeds,
                max_abs_um: &cells,
            };
            for svg in [sweep_curves(&figure), sweep_map(&figure)] {
                assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
            }
        }
    }
}
