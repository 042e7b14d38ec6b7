//! A sweep of gains and feeds, as a family of curves and as a map.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PlotFault;
use super::style::{COLOURS, SIZE, colour, frame, legend, mesh, plain, range, right_axis, swatch};

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

/// Ends and middle of a colour ramp from low to high, even in lightness (after Viridis).
const RAMP: [[f64; 3]; 5] =
    [[253.0, 231.0, 37.0], [94.0, 201.0, 98.0], [33.0, 145.0, 140.0], [59.0, 82.0, 139.0], [68.0, 1.0, 84.0]];
const NOTHING: RGBColor = RGBColor(235, 235, 235);
/// Steps of the colour bar.
const BAR_STEPS: u32 = 64;

fn ramp(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 4")]
    let below = (place as usize).min(RAMP.len() - 2);
    let between = place - below as f64;
    let channel = |k: usize| {
        let value = RAMP[below][k] + (RAMP[below + 1][k] - RAMP[below][k]) * between;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 255")]
        let value = value.round() as u8;
        value
    };
    RGBColor(channel(0), channel(1), channel(2))
}

fn cells<'a>(figure: &SweepFigure<'a>) -> impl Iterator<Item = f64> + use<'a> {
    figure.max_abs_um.iter().flatten().flatten().copied().filter(|value| value.is_finite())
}

/// Draws the largest contour error over the feed, one curve for each row. If there are more rows than colours, it
/// draws as many rows as there are colours, evenly chosen, with the first and the last. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn sweep_curves(figure: &SweepFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw_curves(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw_curves(figure: &SweepFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let rows = figure.max_abs_um.len();
    let drawn = rows.min(COLOURS.len());
    let title = if drawn < rows {
        format!("{} ({drawn} of {rows} gains drawn)", figure.title)
    } else {
        figure.title.to_owned()
    };
    let feeds = range(figure.feeds.iter().copied());
    let errors = range(cells(figure).chain([0.0]));
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, &title);
    let mut chart = builder.build_cartesian_2d(feeds, errors).ok()?;
    mesh(&mut chart, &format!("feed [{}]", figure.feed_unit), "largest contour error [µm]")?;
    for index in 0..drawn {
        let row = if drawn > 1 { index * (rows - 1) / (drawn - 1) } else { 0 };
        let cells = figure.max_abs_um.get(row)?;
        let style = colour(index).stroke_width(2);
        // A missing cell interrupts the curve.
        let mut parts: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
        for (feed, cell) in figure.feeds.iter().zip(cells) {
            match (cell, parts.last_mut()) {
                (Some(error), Some(part)) if error.is_finite() => part.push((*feed, *error)),
                _ => parts.push(Vec::new()),
            }
        }
        let label = figure.gains.get(row).map_or("", String::as_str);
        for (k, part) in parts.into_iter().enumerate() {
            let dots: Vec<_> = part.iter().map(|at| Circle::new(*at, 3, colour(index).filled())).collect();
            let line = chart.draw_series(LineSeries::new(part, style)).ok()?;
            if k == 0 {
                line.label(label).legend(swatch(colour(index).stroke_width(3)));
            }
            chart.draw_series(dots).ok()?;
        }
    }
    legend(&mut chart, SeriesLabelPosition::UpperLeft, 0.85)?;
    drop(chart);
    root.present().ok()
}

/// Draws the grid as coloured cells with a colour bar, and marks the cell with the least error. Cells without a
/// result stay grey. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn sweep_map(figure: &SweepFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw_map(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw_map(figure: &SweepFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let (rows, columns) = (figure.max_abs_um.len().max(1) as f64, figure.feeds.len().max(1) as f64);
    let most = cells(figure).fold(0.0, f64::max);
    let (area, bar) = root.split_horizontally(SIZE.0 - 130);
    let name_of = |place: f64, names: &dyn Fn(usize) -> Option<String>| {
        // Whole numbers are the middles of cells; other positions get no label.
        if (place - place.round()).abs() > 1e-6 {
            return String::new();
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, saturating"
        )]
        let index = place.round().max(0.0) as usize;
        names(index).unwrap_or_default()
    };
    let feed_name = |index: usize| figure.feeds.get(index).map(|feed| plain(*feed));
    let gain_name = |index: usize| figure.gains.get(index).cloned();
    let mut chart = ChartBuilder::on(&area)
        .caption(figure.title, ("sans-serif", 18))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(130)
        .build_cartesian_2d(-0.5..columns - 0.5, -0.5..rows - 0.5)
        .ok()?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(format!("feed [{}]", figure.feed_unit))
        .x_labels(figure.feeds.len().clamp(2, 11))
        .y_labels(figure.gains.len().clamp(2, 13))
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 15))
        .x_label_formatter(&|place| name_of(*place, &feed_name))
        .y_label_formatter(&|place| name_of(*place, &gain_name))
        .draw()
        .ok()?;
    let mut best: Option<(f64, (f64, f64))> = None;
    let mut boxes = Vec::new();
    for (row, cells) in figure.max_abs_um.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            let (x, y) = (column as f64, row as f64);
            let value = cell.filter(|value| value.is_finite());
            let fill = value.map_or(NOTHING, |value| ramp(if most > 0.0 { value / most } else { 0.0 }));
            boxes.push(Rectangle::new([(x - 0.5, y - 0.5), (x + 0.5, y + 0.5)], fill.filled()));
            if let Some(value) = value
                && best.is_none_or(|(least, _)| value < least)
            {
                best = Some((value, (x, y)));
            }
        }
    }
    chart.draw_series(boxes).ok()?;
    if let Some((least_um, at)) = best {
        let (anchor, shift) = if at.0 > 0.7 * columns { (HPos::Right, -9) } else { (HPos::Left, 9) };
        let style = ("sans-serif", 14).into_font().color(&BLACK).pos(Pos::new(anchor, VPos::Center));
        let mark = EmptyElement::at(at)
            + Circle::new((0, 0), 6, BLACK.stroke_width(2))
            + Text::new(format!("{} µm", plain(least_um)), (shift, 0), style);
        chart.draw_series(std::iter::once(mark)).ok()?;
    }
    drop(chart);
    let top = if most > 0.0 { most } else { 1.0 };
    let mut chart = ChartBuilder::on(&bar)
        .margin_top(44)
        .margin_bottom(64)
        .margin_left(8)
        .right_y_label_area_size(72)
        .build_cartesian_2d(0.0..1.0, 0.0..top)
        .ok()?
        .set_secondary_coord(0.0..1.0, 0.0..top);
    let step = top / f64::from(BAR_STEPS);
    chart
        .draw_series((0..BAR_STEPS).map(|k| {
            let from = f64::from(k) * step;
            Rectangle::new([(0.0, from), (1.0, from + step)], ramp((from + 0.5 * step) / top).filled())
        }))
        .ok()?;
    right_axis(&mut chart, "largest contour error [µm]", 13)?;
    drop(chart);
    root.present().ok()
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
        let curves = sweep_curves(&figure).expect("a figure");
        for part in ["feed [mm/min]", "[µm]", "C × 0.6", "6 of 9 gains drawn"] {
            assert!(curves.contains(part), "{part}");
        }
        let map = sweep_map(&figure).expect("a figure");
        // 300 · 0.01 · 0.1 at the matched gain.
        for part in ["feed [mm/min]", "largest contour error [µm]", "0.3 µm", "C × 1"] {
            assert!(map.contains(part), "{part}");
        }
        assert_eq!(map, sweep_map(&figure).expect("a figure"));
        assert_eq!(curves, sweep_curves(&figure).expect("a figure"));
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
                let svg = svg.expect("a figure");
                assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
            }
        }
    }
}
