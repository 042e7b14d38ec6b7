//! The figure of a wear trend.

use crate::plot::{PlotFault, WearEdgeCurve, WearEnd, WearTrendFigure, wear_trend};
use crate::units::UM_PER_MM;
use crate::wear::{CutterLife, WearCourse};
use crate::wire::{FollowedWear, PartsOutlookKind, WearEdge, WearQuantity};

/// Media type of a figure.
pub(super) const SVG: &str = "image/svg+xml";

/// Entries of an edge beyond which a figure shows no more by drawing more.
const MOST_DRAWN: usize = 1000;
/// Places of the band.
const BAND: u32 = 40;
/// Most edges with a band: more would hide each other.
const MOST_BANDS: usize = 3;
/// What is exceeded with these probabilities bounds the band and is its middle.
const EXCEEDED: [f64; 3] = [0.975, 0.5, 0.025];

/// The figure of a trend.
pub(super) fn figure(followed: &FollowedWear) -> Result<String, PlotFault> {
    let FollowedWear { trend, courses, life } = followed;
    let until = shown_until(followed);
    let most_um =
        trend.edges.iter().flat_map(|edge| &edge.entries).map(|entry| entry.wear_um).fold(0.0, f64::max);
    let top_um = 4.0 * f64::max(most_um, trend.limit_um.unwrap_or(0.0)) + 1.0;
    // The edge that is first has the band, if there is one.
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
            curve(edge, course.map(|course| band(course, until, top_um)).unwrap_or_default())
        })
        .collect();
    let wear_name = match trend.quantity {
        Some(WearQuantity::Radius) => "wear of the radius [µm]",
        Some(WearQuantity::Flank) => "wear of the flank [µm]",
        None => "wear [µm]",
    };
    let cutter = trend.cutter_id.as_deref().unwrap_or("none");
    let title = format!("{}, tool {}, cutter {cutter}", trend.machine_id, trend.tool_id);
    let end =
        life.map(|CutterLife { earliest, estimate, latest, .. }| WearEnd { earliest, estimate, latest });
    wear_trend(&WearTrendFigure { title: &title, wear_name, edges: &edges, limit_um: trend.limit_um, end })
}

/// Up to where what is to come is drawn: half a stretch further, or a little past the estimate and the early end.
fn shown_until(followed: &FollowedWear) -> f64 {
    let now = f64::from(followed.trend.parts_now.unwrap_or(0));
    let courses = followed.courses.iter().flatten();
    let first = courses.map(WearCourse::first_parts).min().map_or(now, f64::from);
    let shortest = now + 0.5 * (now - first);
    let past = |parts: f64| now + 1.3 * (parts - now);
    let life = followed.life.iter().flat_map(|life| [life.estimate, life.earliest]).flatten();
    let late = followed.life.and_then(|life| life.latest).filter(|latest| *latest <= now + (now - first));
    life.map(past).chain(late.map(past)).fold(shortest, f64::max)
}

fn band(course: &WearCourse, until: f64, top_um: f64) -> Vec<(f64, [f64; 3])> {
    let from = f64::from(course.last_parts());
    let bounds_mm = [0.0, top_um / UM_PER_MM];
    (0..=BAND)
        .map(|k| {
            let parts = from + (until - from) * f64::from(k) / f64::from(BAND);
            (parts, EXCEEDED.map(|chance| course.exceeded_mm(parts, chance, bounds_mm) * UM_PER_MM))
        })
        .collect()
}

fn curve(edge: &WearEdge, ahead: Vec<(f64, [f64; 3])>) -> WearEdgeCurve {
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
