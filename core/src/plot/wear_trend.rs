//! The wear of a cutter over the parts it cut, and its prediction.

use super::axis::{Axis, plain, range, range_from_zero};
use super::chart::{Chart, Panel, Sample, TALL};
use super::svg::{BLACK, Dot, INKS, Stroke};

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
#[must_use]
pub fn wear_trend(figure: &WearTrendFigure<'_>) -> String {
    let edges = figure.edges;
    let dots = || edges.iter().flat_map(|edge| edge.dots.iter().chain(&edge.line)).copied();
    let ahead = || edges.iter().flat_map(|edge| &edge.ahead);
    let most_um = dots().map(|(_, wear)| wear).filter(|wear| wear.is_finite()).fold(0.0, f64::max);
    let ceiling_um = if most_um > 0.0 { HIGHEST * most_um } else { f64::INFINITY };
    let limit_um = figure.limit_um.filter(|limit| limit.is_finite() && *limit <= ceiling_um);
    let band_ends = ahead().flat_map(WearBand::all_um).map(|wear| wear.clamp(0.0, ceiling_um));
    // Up to the limit and a little above it: wear far above it is never reached.
    let top_um = limit_um.map_or(ceiling_um, |limit| f64::max(1.25 * limit, most_um));
    let heights = range_from_zero(
        dots().map(|(_, wear)| wear).chain(band_ends.map(|wear| wear.min(top_um))).chain(limit_um),
    );
    let places = range(dots().map(|(parts, _)| parts).chain(ahead().map(|band| band.parts)));
    let parts = Axis::linear(places.start.max(0.0_f64.min(places.end - 1e-6))..places.end, "parts cut");
    let mut chart = Chart::new(figure.title);
    let panel = chart.panel(TALL, parts, Axis::linear(heights.clone(), figure.wear_name));
    for (index, edge) in edges.iter().enumerate() {
        let stroke = Stroke::of_curve(index);
        prediction(&mut chart, &panel, edge, stroke, heights.end);
        chart.line(&panel, edge.line.iter().copied(), stroke);
        chart.dots(&panel, edge.dots.iter().copied(), 3.0, Dot::Disk(stroke.ink));
        chart.explain(Sample::Dotted(stroke, Dot::Disk(stroke.ink)), edge.label.as_str());
    }
    if let Some(ink) =
        edges.iter().position(|edge| edge.ahead.len() > 1).map(|index| INKS[index % INKS.len()])
    {
        chart.explain(Sample::Line(Stroke::new(ink, 1.8).dashed(MEDIAN)), "predicted median");
        chart.explain(Sample::Area(ink, INNER), "95 % if no new stage of wear begins");
        chart.explain(Sample::Area(ink, OUTER), "95 % whatever comes next");
    }
    let mut description = format!("{} over the parts cut: {} µm measured.", figure.wear_name, plain(most_um));
    if let Some(limit_um) = limit_um {
        chart.level(&panel, limit_um, LIMIT);
        chart.explain(Sample::Line(LIMIT), format!("limit {} µm", plain(limit_um)));
        if let Some(end) = &figure.end {
            let shown = places.start.max(0.0)..places.end;
            life(&mut chart, &panel, end, limit_um, &shown);
            if let Some(parts) = end.estimate.filter(|parts| parts.is_finite()) {
                let parts = plain(parts.round());
                description = format!(
                    "{description} The limit of {} µm is expected at {parts} parts.",
                    plain(limit_um)
                );
            }
        }
    }
    chart.finish(&description)
}

/// A limit or a band higher than this multiple of the measured wear would make the measured course look flat.
const HIGHEST: f64 = 4.0;
const LIMIT: Stroke = Stroke::new(BLACK, 1.4).dashed("9 5");
const MEDIAN: &str = "6 4";
/// Opacities of the bands. The inner band is drawn over the outer one.
const INNER: f64 = 0.3;
const OUTER: f64 = 0.14;

fn prediction(chart: &mut Chart, panel: &Panel, edge: &WearEdgeCurve, stroke: Stroke, top_um: f64) {
    let sound: Vec<WearBand> = edge.ahead.iter().copied().filter(WearBand::is_sound).collect();
    if sound.len() < 2 {
        return;
    }
    let band = |ends: fn(&WearBand) -> [f64; 2]| {
        let ends = sound.iter().map(move |band| (band.parts, ends(band)));
        ends.map(|(parts, [low, high])| (parts, low, high)).collect::<Vec<_>>()
    };
    chart.band(panel, band(|band| band.ends_um), stroke.ink, OUTER);
    chart.band(panel, band(|band| band.same_stage_um), stroke.ink, INNER - OUTER);
    let middle = sound.iter().map(|band| (band.parts, band.middle_um)).filter(|(_, wear)| *wear <= top_um);
    chart.line(panel, middle, stroke.dashed(MEDIAN));
}

/// When the limit is reached: bars on the limit.
fn life(chart: &mut Chart, panel: &Panel, end: &WearEnd, limit_um: f64, shown: &std::ops::Range<f64>) {
    let bar = |ends: [Option<f64>; 2]| {
        let within = |parts: f64| parts.clamp(shown.start, shown.end);
        ends.map(|parts| (parts.filter(|parts| parts.is_finite()).map_or(shown.end, within), limit_um))
    };
    let (thin, thick) = (Stroke::new(BLACK, 2.0), Stroke::new(BLACK, 6.0));
    chart.line(panel, bar(end.ends), thin);
    chart.explain(Sample::Line(thin), "the limit is reached (95 %)");
    chart.line(panel, bar(end.same_stage), thick);
    chart.explain(Sample::Line(thick), "the same if no new stage begins");
    let at = end.estimate.filter(|parts| shown.contains(parts));
    chart.dots(panel, at.map(|parts| (parts, limit_um)), 5.0, Dot::Ring(BLACK));
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
        let svg = wear_trend(&figure);
        for part in
            ["limit 70 µm", "edge 1", "parts cut", "reached (95 %)", "if no new stage begins", "<polygon"]
        {
            assert!(svg.contains(part), "{part}");
        }
        // Twenty entries, the estimate, and the samples of two edges.
        assert_eq!(svg.matches("<circle").count(), 23);
        // Two bands of each edge, and two samples.
        assert_eq!(svg.matches("<polygon").count(), 6);
        assert_eq!(svg, wear_trend(&figure));
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
            let svg = wear_trend(&figure);
            assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"));
        }
    }
}
