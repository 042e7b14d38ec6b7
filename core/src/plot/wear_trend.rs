//! The wear of a cutter over the parts it cut, and its prediction.

use plotters::prelude::*;

use super::PlotFault;
use super::style::{MUTED, SIZE, colour, frame, legend, mesh, plain, range, swatch};

/// The predicted wear at one number of parts \[µm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearBand {
    /// Parts cut.
    pub parts: f64,
    /// Exceeded with a probability of 97.5 and 2.5 per cent, whatever stage of wear comes next.
    pub ends_um: [f64; 2],
    /// The same if no new stage begins.
    pub same_stage_um: [f64; 2],
    /// Median if no new stage begins.
    pub middle_um: f64,
}

impl WearBand {
    fn all_um(&self) -> [f64; 5] {
        let ([low, high], [same_low, same_high]) = (self.ends_um, self.same_stage_um);
        [low, high, same_low, same_high, self.middle_um]
    }

    fn is_sound(&self) -> bool {
        self.parts.is_finite() && self.all_um().iter().all(|wear| wear.is_finite())
    }
}

/// One edge: parts and wear \[µm\].
#[derive(Debug, Clone, PartialEq)]
pub struct WearEdgeCurve {
    /// Its name.
    pub label: String,
    /// The entries.
    pub dots: Vec<(f64, f64)>,
    /// The fitted course, in order.
    pub line: Vec<(f64, f64)>,
    /// The prediction, in order of the parts.
    pub ahead: Vec<WearBand>,
}

/// Parts at which the first edge reaches the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearEnd {
    /// The early and the late end, if known.
    pub ends: [Option<f64>; 2],
    /// The same if no new stage of wear begins.
    pub same_stage: [Option<f64>; 2],
    /// The median, if known.
    pub estimate: Option<f64>,
}

/// The content of the figure.
#[derive(Debug, Clone, Copy)]
pub struct WearTrendFigure<'a> {
    /// One line.
    pub title: &'a str,
    /// Name and unit of the wear.
    pub wear_name: &'a str,
    /// The edges.
    pub edges: &'a [WearEdgeCurve],
    /// The limit \[µm\].
    pub limit_um: Option<f64>,
    /// When the limit is reached.
    pub end: Option<WearEnd>,
}

/// Draws the entries as dots, with the fitted course through them. The prediction is two bands of 95 %; the inner
/// band, with a dashed median, holds if no new stage of wear begins. On the limit are two bars from the early to
/// the late end, with a dot at the estimate; the thick bar holds if no new stage begins. Same numbers, same bytes.
///
/// # Errors
/// The drawing library fails.
pub fn wear_trend(figure: &WearTrendFigure<'_>) -> Result<String, PlotFault> {
    let mut svg = String::new();
    draw(figure, &mut svg).ok_or(PlotFault)?;
    Ok(svg)
}

/// A limit or a band higher than this multiple of the measured wear would make the measured course look flat.
const HIGHEST: f64 = 4.0;

fn draw(figure: &WearTrendFigure<'_>, svg: &mut String) -> Option<()> {
    let root = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    root.fill(&WHITE).ok()?;
    let edges = figure.edges;
    let dots = || edges.iter().flat_map(|edge| edge.dots.iter().chain(&edge.line)).copied();
    let ahead = || edges.iter().flat_map(|edge| &edge.ahead);
    let most_um = dots().map(|(_, wear)| wear).filter(|wear| wear.is_finite()).fold(0.0, f64::max);
    let ceiling_um = if most_um > 0.0 { HIGHEST * most_um } else { f64::INFINITY };
    let limit_um = figure.limit_um.filter(|limit| limit.is_finite() && *limit <= ceiling_um);
    let band_ends = ahead().flat_map(WearBand::all_um).map(|wear| wear.clamp(0.0, ceiling_um));
    // Up to the limit and a little above it: wear far above it is never reached.
    let top_um = limit_um.map_or(ceiling_um, |limit| f64::max(1.25 * limit, most_um));
    let heights =
        range(dots().map(|(_, wear)| wear).chain(band_ends.map(|wear| wear.min(top_um))).chain(limit_um));
    let places = range(dots().map(|(parts, _)| parts).chain(ahead().map(|band| band.parts)));
    let mut builder = ChartBuilder::on(&root);
    frame(&mut builder, figure.title);
    let mut chart = builder.build_cartesian_2d(places.clone(), heights.clone()).ok()?;
    mesh(&mut chart, "parts cut", figure.wear_name)?;
    let inside = |wear: f64| wear.clamp(heights.start, heights.end);
    for (index, edge) in edges.iter().enumerate() {
        let sound = |(parts, wear): &(f64, f64)| parts.is_finite() && wear.is_finite();
        let band: Vec<WearBand> = edge.ahead.iter().copied().filter(WearBand::is_sound).collect();
        if band.len() > 1 {
            let outline = |ends: fn(&WearBand) -> [f64; 2]| -> Vec<(f64, f64)> {
                let low = band.iter().map(|band| (band.parts, inside(ends(band)[0])));
                low.chain(band.iter().rev().map(|band| (band.parts, inside(ends(band)[1])))).collect()
            };
            let bands = [outline(|band| band.ends_um), outline(|band| band.same_stage_um)];
            chart.draw_series(bands.map(|outline| Polygon::new(outline, colour(index).mix(0.11)))).ok()?;
            let middle = band.iter().map(|band| (band.parts, band.middle_um));
            let middle: Vec<(f64, f64)> = middle.filter(|(_, wear)| *wear <= heights.end).collect();
            if middle.len() > 1 {
                chart.draw_series(DashedLineSeries::new(middle, 6, 4, colour(index).stroke_width(2))).ok()?;
            }
        }
        let line = edge.line.iter().copied().filter(sound);
        chart
            .draw_series(LineSeries::new(line, colour(index).stroke_width(2)))
            .ok()?
            .label(&edge.label)
            .legend(swatch(colour(index).stroke_width(3)));
        let dots = edge.dots.iter().copied().filter(sound);
        chart.draw_series(dots.map(|at| Circle::new(at, 3, colour(index).filled()))).ok()?;
    }
    if let Some(limit_um) = limit_um {
        let ends = [(places.start, limit_um), (places.end, limit_um)];
        chart
            .draw_series(DashedLineSeries::new(ends, 8, 5, MUTED.stroke_width(2)))
            .ok()?
            .label(format!("limit {} µm", plain(limit_um)))
            .legend(swatch(MUTED.stroke_width(2)));
        if let Some(end) = figure.end {
            let within = |parts: Option<f64>| {
                (parts.map_or(places.end, |parts| parts.clamp(places.start, places.end)), limit_um)
            };
            for (ends, width, label) in [
                (end.ends, 2, "the limit is reached (95 %)"),
                (end.same_stage, 5, "the same if no new stage begins"),
            ] {
                let [early, late] = ends.map(within);
                chart
                    .draw_series(std::iter::once(PathElement::new([early, late], BLACK.stroke_width(width))))
                    .ok()?
                    .label(label)
                    .legend(swatch(BLACK.stroke_width(width)));
            }
            let at = end.estimate.filter(|parts| places.contains(parts));
            chart.draw_series(at.map(|parts| Circle::new((parts, limit_um), 5, BLACK.filled()))).ok()?;
        }
    }
    legend(&mut chart, SeriesLabelPosition::UpperLeft, 0.85)?;
    drop(chart);
    root.present().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(scale: f64) -> WearEdgeCurve {
        let line: Vec<(f64, f64)> = (0..10_u32).map(|k| (f64::from(10 * k), scale * f64::from(k))).collect();
        let ahead = (9..20_u32).map(|k| {
            let um = |factor: f64| factor * scale * f64::from(k);
            WearBand {
                parts: f64::from(10 * k),
                ends_um: [um(0.5), um(3.0)],
                same_stage_um: [um(0.8), um(1.3)],
                middle_um: um(1.0),
            }
        });
        WearEdgeCurve { label: "edge 1".to_owned(), dots: line.clone(), line, ahead: ahead.collect() }
    }

    #[test]
    fn the_figure_has_dots_band_limit_and_end() {
        let edges = [edge(5.0), edge(4.0)];
        let end = WearEnd {
            ends: [Some(120.0), None],
            same_stage: [Some(130.0), Some(150.0)],
            estimate: Some(140.0),
        };
        let figure = WearTrendFigure {
            title: "T12",
            wear_name: "wear of the flank [µm]",
            edges: &edges,
            limit_um: Some(70.0),
            end: Some(end),
        };
        let svg = wear_trend(&figure).expect("a figure");
        for part in
            ["limit 70 µm", "edge 1", "parts cut", "reached (95 %)", "if no new stage begins", "<polygon"]
        {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg.matches("<circle").count(), 21);
        assert_eq!(svg.matches("<polygon").count(), 4);
        assert_eq!(svg, wear_trend(&figure).expect("a figure"));
    }

    #[test]
    fn nothing_and_what_is_no_number_are_drawn() {
        for edges in [vec![], vec![edge(0.0)], vec![edge(f64::NAN)], vec![edge(1e200)]] {
            let end = WearEnd { ends: [None, None], same_stage: [None, None], estimate: Some(f64::NAN) };
            let figure = WearTrendFigure {
                title: "",
                wear_name: "",
                edges: &edges,
                limit_um: Some(50.0),
                end: Some(end),
            };
            let svg = wear_trend(&figure).expect("a figure");
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
