//! The figure of a wear trend.

use crate::plot::{WearBand, WearEdgeCurve, WearEnd, WearTrendFigure, wear_trend};
use crate::units::UM_PER_MM;
use crate::wear::{CutterLife, WearCourse, wear_ahead};
use crate::wire::{FollowedWear, PartsOutlookKind, WearEdge, WearQuantity};

/// Media type of a figure.
pub(super) const SVG: &str = "image/svg+xml";

/// A figure with more entries of an edge than this would not show more.
const MOST_DRAWN: usize = 1000;
/// Number of points of the band.
const BAND: u32 = 40;
/// Most edges with a band: more would hide each other.
const MOST_BANDS: usize = 3;

/// The figure of a trend.
pub(super) fn figure(followed: &FollowedWear) -> String {
    let FollowedWear { trend, courses, life } = followed;
    let until = shown_until(followed);
    // The edge that reaches the limit first has the band, if there is one.
    let predicted = trend.outlook.as_ref().filter(|outlook| outlook.kind == PartsOutlookKind::Predicted);
    let first_edge = predicted.map(|outlook| &outlook.first_edge);
    let edges: Vec<WearEdgeCurve> = trend
        .edges
        .iter()
        .zip(courses)
        .enumerate()
        .map(|(index, (edge, course))| {
            let drawn = first_edge.map_or(index < MOST_BANDS, |first| first == &edge.edge);
            let course = course.as_ref().filter(|_| drawn);
            curve(edge, course.map(|course| band(course, until)).unwrap_or_default())
        })
        .collect();
    let wear_name = match trend.quantity {
        Some(WearQuantity::Radius) => "wear of the radius [µm]",
        Some(WearQuantity::Flank) => "wear of the flank [µm]",
        None => "wear [µm]",
    };
    let cutter = trend.cutter_id.as_ref().map_or_else(String::new, |cutter| format!(", cutter {cutter}"));
    let title = format!("{}, tool {}{cutter}", trend.machine_id, trend.tool_id);
    let end = life.map(|CutterLife { ends, estimate, same_stage, .. }| WearEnd {
        ends: [ends.earliest, ends.latest],
        same_stage: [same_stage.earliest, same_stage.latest],
        estimate,
    });
    wear_trend(&WearTrendFigure { title: &title, wear_name, edges: &edges, limit_um: trend.limit_um, end })
}

/// End of the drawn outlook: half the measured range further, or a little past the estimate and the early end.
fn shown_until(followed: &FollowedWear) -> f64 {
    let now = f64::from(followed.trend.parts_now.unwrap_or(0));
    let courses = followed.courses.iter().flatten();
    let first = courses.map(WearCourse::first_parts).min().map_or(now, f64::from);
    let shortest = now + 0.5 * (now - first);
    let past = |parts: f64| now + 1.3 * (parts - now);
    let life = followed.life.iter().flat_map(|life| [life.estimate, life.ends.earliest]).flatten();
    let late =
        followed.life.and_then(|life| life.same_stage.latest).filter(|latest| *latest <= now + (now - first));
    life.map(past).chain(late.map(past)).fold(shortest, f64::max)
}

fn band(course: &WearCourse, until: f64) -> Vec<WearBand> {
    let from = f64::from(course.last_parts());
    let parts: Vec<f64> =
        (0..=BAND).map(|k| from + (until - from) * f64::from(k) / f64::from(BAND)).collect();
    let um = |ends_mm: [f64; 2]| ends_mm.map(|mm| mm * UM_PER_MM);
    let ahead = wear_ahead(course, &parts);
    let bands = ahead.into_iter().map(|ahead| WearBand {
        parts: ahead.parts,
        ends_um: um(ahead.ends_mm),
        same_stage_um: um(ahead.same_stage_mm),
        middle_um: ahead.middle_mm * UM_PER_MM,
    });
    bands.collect()
}

fn curve(edge: &WearEdge, ahead: Vec<WearBand>) -> WearEdgeCurve {
    // Counted from the last entry, which is always drawn.
    let every = edge.entries.len().div_ceil(MOST_DRAWN).max(1);
    let last = edge.entries.len().saturating_sub(1);
    let drawn: Vec<_> = edge
        .entries
        .iter()
        .enumerate()
        .filter(|(index, _)| (last - index).is_multiple_of(every))
        .map(|(_, entry)| entry)
        .collect();
    let thinned = if every > 1 { format!(", every {every} entries one") } else { String::new() };
    let name = edge.edge.as_deref().map_or_else(|| "wear".to_owned(), |edge| format!("edge {edge}"));
    WearEdgeCurve {
        label: format!("{name}{thinned}"),
        dots: drawn.iter().map(|entry| (f64::from(entry.parts_cut), entry.wear_um)).collect(),
        line: drawn.iter().filter_map(|entry| Some((f64::from(entry.parts_cut), entry.fitted_um?))).collect(),
        ahead,
    }
}
