//! The wear of a cutter over time, and the parts left until a limit.

use serde::Serialize;

use super::table_text::table_text;
use super::wear_outlook::{OutlookBasis, PartsOutlook, PartsOutlookKind, named};
use super::{WearEntry, WearQuantity};
use crate::description::ToSchema;
use crate::units::UM_PER_MM;
use crate::wear::{CutterLife, WearCourse, WearReading, cutter_life};

/// One entry of a trend.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearTrendPoint {
    /// Id of the entry.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// Time of the measurement.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// Parts cut since the cutter was new.
    pub parts_cut: u32,
    /// The wear.
    pub wear_um: f64,
    /// Standard uncertainty of the wear; null if none was stated.
    pub standard_uncertainty_um: Option<f64>,
    /// Fitted wear at this entry, from all entries of the edge; null without a fit.
    pub fitted_um: Option<f64>,
}

/// What the entries of an edge say about it at the last entry.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct WearFit {
    /// Fitted wear.
    pub wear_um: f64,
    /// Rate of growth.
    pub rate_um_per_part: f64,
    /// True if it is more than 90 % sure that the wear grows.
    pub is_rising: bool,
    /// Standard deviation of a typical entry about the fit.
    pub scatter_um: f64,
}

/// The wear of one edge.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearEdge {
    /// Name of the edge; null for the whole cutter.
    pub edge: Option<String>,
    /// Entries of the edge, ordered by the number of parts.
    pub entries: Vec<WearTrendPoint>,
    /// The fit; null if there are too few entries.
    pub fit: Option<WearFit>,
}

/// Something that a person should check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct WearWarning {
    /// `wear-falls`, `edge-without-fit`, `edge-behind`, `uncertainties-left-out`.
    #[schema(example = "wear-falls")]
    pub kind: &'static str,
    /// Name of the edge; null if the cutter was measured as a whole, or if the warning concerns all edges.
    pub edge: Option<String>,
    /// The warning in words.
    pub detail: String,
}

/// The wear of a cutter over time.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearTrend {
    /// Id of the machine.
    pub machine_id: String,
    /// Id of the tool.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// Id of the cutter; null if the tool has no entries.
    #[schema(example = "1")]
    pub cutter_id: Option<String>,
    /// Quantity that was measured; null without entries.
    pub quantity: Option<WearQuantity>,
    /// Parts at the newest entry; null without entries.
    pub parts_now: Option<u32>,
    /// The requested limit.
    pub limit_um: Option<f64>,
    /// The edges of the cutter.
    pub edges: Vec<WearEdge>,
    /// The parts left until the limit; null if no limit was requested.
    pub outlook: Option<PartsOutlook>,
    /// Points that a person should check.
    pub warnings: Vec<WearWarning>,
}

/// The cutter of the trend, and the limit.
#[derive(Debug, Clone, PartialEq)]
pub struct WearTrendHead {
    /// Id of the machine.
    pub machine_id: String,
    /// Id of the tool.
    pub tool_id: String,
    /// Id of the cutter, if the tool has any.
    pub cutter_id: Option<String>,
    /// The limit \[µm\].
    pub limit_um: Option<f64>,
}

/// A trend with the data that it was computed from.
#[derive(Debug, Clone)]
pub struct FollowedWear {
    /// The document.
    pub trend: WearTrend,
    /// The course of each edge, if it has one.
    pub courses: Vec<Option<WearCourse>>,
    /// When the first edge reaches the limit; `None` if an edge has reached it.
    pub life: Option<CutterLife>,
}

/// A fall by more than this many standard deviations of an entry is not scatter.
const FALL: f64 = 4.0;
/// Upper bound of a standard deviation, as a multiple of that of neighbouring entries. Correlated errors make
/// it at most twice as large, but a misread entry or a changed cutter can widen the fit without limit.
const OF_NEIGHBOURS: f64 = 3.0;

impl FollowedWear {
    /// The trend of entries that are ordered by edge and parts.
    #[must_use]
    pub fn of(head: WearTrendHead, entries: &[WearEntry]) -> Self {
        let by_edge: Vec<&[WearEntry]> = entries.chunk_by(|one, next| one.edge == next.edge).collect();
        let courses: Vec<Option<WearCourse>> = by_edge.iter().map(|edge| course(edge)).collect();
        let edges: Vec<WearEdge> =
            by_edge.iter().zip(&courses).map(|(edge, course)| edge_doc(edge, course.as_ref())).collect();
        let parts_now = entries.iter().map(|entry| entry.parts_cut).max();
        let mut life = None;
        let outlook = head.limit_um.map(|limit_um| {
            passed(&edges, limit_um).unwrap_or_else(|| {
                let fitted: Vec<(usize, &WearCourse)> = courses
                    .iter()
                    .enumerate()
                    .filter_map(|(index, course)| Some((index, course.as_ref()?)))
                    .collect();
                let (Some(now), false) = (parts_now, fitted.is_empty()) else {
                    return too_few(&edges);
                };
                let alone: Vec<&WearCourse> = fitted.iter().map(|(_, course)| *course).collect();
                let found = cutter_life(&alone, limit_um / UM_PER_MM, now);
                life = Some(found);
                let first = found
                    .first_edge
                    .and_then(|index| fitted.get(index))
                    .and_then(|(index, _)| edges.get(*index));
                let first_edge = first.and_then(|edge| edge.edge.clone());
                let each = fitted
                    .iter()
                    .filter_map(|(index, course)| Some((edges.get(*index)?.edge.as_deref(), *course)));
                let basis = OutlookBasis::of(each, found.reach);
                PartsOutlook::told(&found, limit_um, now, first_edge, basis)
            })
        });
        let warnings = warnings(&edges, &courses, parts_now);
        let quantity = entries.first().map(|entry| entry.wear().0);
        let WearTrendHead { machine_id, tool_id, cutter_id, limit_um } = head;
        let trend = WearTrend {
            machine_id,
            tool_id,
            cutter_id,
            quantity,
            parts_now,
            limit_um,
            edges,
            outlook,
            warnings,
        };
        Self { trend, courses, life }
    }
}

fn course(edge: &[WearEntry]) -> Option<WearCourse> {
    let readings: Vec<WearReading> = edge
        .iter()
        .map(|entry| WearReading {
            parts_cut: entry.parts_cut,
            wear_mm: entry.wear().1 / UM_PER_MM,
            standard_uncertainty_mm: entry.standard_uncertainty_um.map(|um| um / UM_PER_MM),
        })
        .collect();
    WearCourse::of(&readings).ok()
}

fn edge_doc(edge: &[WearEntry], course: Option<&WearCourse>) -> WearEdge {
    let fitted = course.map_or(&[][..], WearCourse::fitted_mm);
    let entries = edge
        .iter()
        .enumerate()
        .map(|(index, entry)| WearTrendPoint {
            id: entry.id.clone(),
            measured_at: entry.measured_at.clone(),
            parts_cut: entry.parts_cut,
            wear_um: entry.wear().1,
            standard_uncertainty_um: entry.standard_uncertainty_um,
            fitted_um: fitted.get(index).map(|mm| mm * UM_PER_MM),
        })
        .collect();
    let fit = course.map(|course| {
        let now = course.now();
        WearFit {
            wear_um: now.wear_mm * UM_PER_MM,
            rate_um_per_part: now.rate_mm_per_part * UM_PER_MM,
            is_rising: course.is_rising(),
            scatter_um: course.scatter_mm() * UM_PER_MM,
        }
    });
    WearEdge { edge: edge.first().and_then(|entry| entry.edge.clone()), entries, fit }
}

/// The outlook if an edge's newest entry is at the limit.
fn passed(edges: &[WearEdge], limit_um: f64) -> Option<PartsOutlook> {
    let over = |edge: &&WearEdge| edge.entries.last().is_some_and(|newest| newest.wear_um >= limit_um);
    let begun = |edge: &&WearEdge| {
        edge.entries.iter().rposition(|entry| entry.wear_um < limit_um).map_or(0, |below| below + 1)
    };
    let parts = |edge: &&WearEdge| edge.entries.get(begun(edge)).map(|entry| entry.parts_cut);
    let first = edges.iter().filter(over).min_by_key(parts)?;
    let at = begun(&first);
    let to = parts(&first).unwrap_or_default();
    let name = named(first.edge.as_deref());
    let newest_um = first.entries.last().map_or(0.0, |entry| entry.wear_um);
    let when = match at.checked_sub(1).and_then(|below| first.entries.get(below)) {
        Some(below) => format!("between {} and {to} parts", below.parts_cut),
        None => format!("at {to} parts or before"),
    };
    let words =
        format!("the limit of {limit_um} µm was passed {when}: the newest entry{name} is {newest_um} µm");
    Some(PartsOutlook::without_numbers(PartsOutlookKind::Passed, first.edge.clone(), words))
}

fn too_few(edges: &[WearEdge]) -> PartsOutlook {
    let most = edges.iter().map(places).max().unwrap_or(0);
    let needed = crate::wear::LEAST_PLACES;
    let words = format!(
        "entries at {most} different numbers of parts are not enough for an outlook; {needed} are needed"
    );
    PartsOutlook::without_numbers(PartsOutlookKind::TooFewEntries, None, words)
}

/// How many different numbers of parts an edge was measured at.
fn places(edge: &WearEdge) -> usize {
    edge.entries.chunk_by(|one, next| one.parts_cut == next.parts_cut).count()
}

fn warnings(edges: &[WearEdge], courses: &[Option<WearCourse>], parts_now: Option<u32>) -> Vec<WearWarning> {
    let mut warnings = Vec::new();
    let any_fit = edges.iter().any(|edge| edge.fit.is_some());
    for (edge, course) in edges.iter().zip(courses) {
        let mut warn = |kind, detail| warnings.push(WearWarning { kind, edge: edge.edge.clone(), detail });
        if any_fit && edge.fit.is_none() {
            warn(
                "edge-without-fit",
                format!(
                    "measured at {} different numbers of parts; the outlook leaves this edge out",
                    places(edge)
                ),
            );
        }
        if let (Some(newest), Some(now)) = (edge.entries.last(), parts_now)
            && newest.parts_cut < now
        {
            warn(
                "edge-behind",
                format!("last measured at {} parts, but the newest entry is at {now}", newest.parts_cut),
            );
        }
        let stated = edge.entries.iter().filter(|entry| entry.standard_uncertainty_um.is_some()).count();
        if stated > 0 && stated < edge.entries.len() {
            let count = edge.entries.len();
            warn(
                "uncertainties-left-out",
                format!(
                    "{stated} of {count} entries state an uncertainty; it is used only if all entries state it"
                ),
            );
        }
        if let Some(course) = course {
            let scatter_mm = course.scatter_mm().min(OF_NEIGHBOURS * course.neighbour_scatter_mm());
            let fall_um = FALL * scatter_mm * UM_PER_MM;
            let mut most_um = f64::NEG_INFINITY;
            let mut fallen = edge.entries.iter().filter(|entry| {
                let falls = entry.wear_um < most_um - fall_um;
                most_um = most_um.max(entry.wear_um);
                falls
            });
            if let Some(first) = fallen.next() {
                let count = 1 + fallen.count();
                warn(
                    "wear-falls",
                    format!(
                        "{count} entries are far below an earlier one, the first at {} parts: withdraw a misread entry; a new or reground cutter needs a cutter_id of its own",
                        first.parts_cut
                    ),
                );
            }
        }
    }
    warnings
}

/// The entries of a trend as a table.
///
/// # Errors
/// The table cannot be written; this does not happen in memory.
pub fn wear_trend_table(trend: &WearTrend) -> Result<Vec<u8>, csv::Error> {
    let member = trend.quantity.map_or("wear_um", WearQuantity::member);
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record([
        "edge",
        "parts_cut",
        member,
        "standard_uncertainty_um",
        "fitted_um",
        "measured_at",
        "id",
    ])?;
    for edge in &trend.edges {
        for entry in &edge.entries {
            table.write_record([
                &*table_text(edge.edge.as_deref().unwrap_or_default()),
                &entry.parts_cut.to_string(),
                &entry.wear_um.to_string(),
                &entry.standard_uncertainty_um.map(|um| um.to_string()).unwrap_or_default(),
                &entry.fitted_um.map(|um| um.to_string()).unwrap_or_default(),
                &entry.measured_at,
                &entry.id,
            ])?;
        }
    }
    table.into_inner().map_err(|fault| fault.into_error().into())
}
