//! Eccentricities of a calibration before and after compensation (P4 Table 1 as bars).

use super::axis::{Axis, plain, range};
use super::chart::{Chart, Sample, TALL};
use super::svg::{Anchor, BLACK, INKS, Lettering, MUTED, Stroke};

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

/// Draws three bars for each eccentricity, with their values. Same numbers, same bytes.
#[must_use]
pub fn eccentricity_bars(figure: &EccentricityFigure<'_>) -> String {
    let values = figure.bars.iter().flat_map(|bars| bars.values_um).chain([0.0]);
    let heights = range(values);
    let labels: Vec<String> = figure.bars.iter().map(|bars| bars.label.to_owned()).collect();
    let mut chart = Chart::new(figure.title);
    let panel = chart.panel(TALL, Axis::named(labels, ""), Axis::linear(heights, "eccentricity [µm]"));
    for (index, name) in NAMES.into_iter().enumerate() {
        let ink = INKS[index];
        for (place, bars) in figure.bars.iter().enumerate() {
            let value = bars.values_um[index];
            let left = place as f64 + BAR * (index as f64 - 1.5);
            let ends = [(left, 0.0, value), (left + 0.94 * BAR, 0.0, value)];
            chart.band(&panel, ends, ink, 1.0);
            let Some((x, y)) = panel.at((left + 0.47 * BAR, value)) else { continue };
            // Beside the end of the bar, where it is read without the scale; a ball bar reads tenths.
            let y = if value < 0.0 { y + 14.0 } else { y - 5.0 };
            if figure.bars.len() <= MOST_WITH_NUMBERS {
                let lettering = Lettering::new(11.0, BLACK, Anchor::Middle).with_halo();
                chart.drawing.text((x, y), &plain((value * 10.0).round() / 10.0), lettering);
            }
        }
        chart.explain(Sample::Area(ink, 1.0), name);
    }
    chart.level(&panel, 0.0, Stroke::new(MUTED, 1.0));
    let largest = [0, 1, 2]
        .map(|index| plain(figure.bars.iter().map(|bars| bars.values_um[index].abs()).fold(0.0, f64::max)));
    chart.finish(&format!(
        "Eccentricities of each test. Largest: {} µm before, {} µm with the linear errors compensated, {} µm with all errors compensated.",
        largest[0], largest[1], largest[2]
    ))
}

/// The numbers of more bars would overlap.
const MOST_WITH_NUMBERS: usize = 9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_eccentricity_has_its_three_bars() {
        let bars = [
            EccentricityBars { label: "C radial x", values_um: [6.7, 0.4, 0.4] },
            EccentricityBars { label: "A radial z", values_um: [-69.1, -3.3, -2.8] },
        ];
        let svg = eccentricity_bars(&EccentricityFigure { title: "eccentricities", bars: &bars });
        for part in ["C radial x", "A radial z", "before", "linear errors compensated", "all compensated"] {
            assert!(svg.contains(part), "{part}");
        }
        let none = eccentricity_bars(&EccentricityFigure { title: "", bars: &[] });
        assert!(none.ends_with("</svg>\n"));
    }
}
