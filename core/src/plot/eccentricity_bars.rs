//! Eccentricities of a calibration before and after compensation (P4 Table 1 as bars).

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::PlotFault;
use super::style::{MUTED, SIZE, colour, frame, legend, mesh, range};

/// One eccentricity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EccentricityBars<'a> {
    /// Test and component: `C radial x`.
    pub label: &'a str,
    /// Before, after the linear errors only, after all \[µm\].
    pub values_um: [f64; 3],
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct EccentricityFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// The eccentricities.
    pub bars: &'a [EccentricityBars<'a>],
}

const NAMES: [&str; 3] = ["before", "linear errors compensated", "all compensated"];
/// Width of a bar. Eccentricities are 1 apart.
const BAR: f64 = 0.26;

/// Draws three bars for each eccentricity. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn eccentricity_bars(figure: &EccentricityFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

fn draw(figure: &EccentricityFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let values = figure.bars.iter().flat_map(|bars| bars.values_um).chain([0.0]);
    let heights = range(values);
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, figure.title);
    builder.x_label_area_size(0);
    let count = figure.bars.len().max(1) as f64;
    // Space for the labels below and the legend above.
    let span = heights.end - heights.start;
    let (floor, top) = (heights.start - 0.12 * span, heights.end + 0.22 * span);
    let mut chart = builder.build_cartesian_2d(-0.6..count - 0.4, floor..top).ok()?;
    mesh(&mut chart, "", "eccentricity [µm]")?;
    for (index, name) in NAMES.into_iter().enumerate() {
        let bars = figure.bars.iter().enumerate().filter_map(|(place, bars)| {
            let value = bars.values_um[index];
            let left = place as f64 + BAR * (index as f64 - 1.5);
            let corners = [(left, value.min(0.0)), (left + BAR, value.max(0.0))];
            value.is_finite().then(|| Rectangle::new(corners, colour(index).filled()))
        });
        chart
            .draw_series(bars)
            .ok()?
            .label(name)
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 16, y + 5)], colour(index).filled()));
    }
    let style = ("sans-serif", 14).into_font().color(&MUTED).pos(Pos::new(HPos::Center, VPos::Bottom));
    let labels = figure
        .bars
        .iter()
        .enumerate()
        .map(|(place, bars)| Text::new(bars.label.to_owned(), (place as f64, floor), style.clone()));
    chart.draw_series(labels).ok()?;
    legend(&mut chart, SeriesLabelPosition::UpperRight, 0.85)?;
    drop(chart);
    root.present().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_eccentricity_has_its_three_bars() {
        let bars = [
            EccentricityBars { label: "C radial x", values_um: [6.7, 0.4, 0.4] },
            EccentricityBars { label: "A radial z", values_um: [-69.1, -3.3, -2.8] },
        ];
        let svg = eccentricity_bars(&EccentricityFigure { title: "eccentricities", bars: &bars })
            .expect("a figure");
        for part in ["C radial x", "A radial z", "before", "linear errors compensated", "all compensated"] {
            assert!(svg.contains(part), "{part}");
        }
        let none = eccentricity_bars(&EccentricityFigure { title: "", bars: &[] }).expect("a figure");
        assert!(none.ends_with("</svg>\n"));
    }
}
