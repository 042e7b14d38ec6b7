//! How a cutter wore, and the parts that are left to a limit.

use serde::Serialize;
use utoipa::ToSchema;

use super::table_text::table_text;
use super::wear_outlook::{OutlookBasis, PartsOutlook, PartsOutlookKind, named};
use super::{WearEntry, WearQuantity};
use crate::units::UM_PER_MM;
use crate::wear::{CutterLife, WearCourse, WearReading, cutter_life};

/// One entry of a trend.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearTrendPoint {
    /// The entry.
    #[schema(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    pub id: String,
    /// When it was measured.
    #[schema(example = "2025-03-14T09:26:53.000Z")]
    pub measured_at: String,
    /// Parts cut since the cutter was new.
    pub parts_cut: u32,
    /// The wear.
    pub wear_um: f64,
    /// Its standard uncertainty; null where none was stated.
    pub standard_uncertainty_um: Option<f64>,
    /// The wear there, all entries of the edge known; null without a fit.
    pub fitted_um: Option<f64>,
}

/// What the entries of an edge say of it at the last of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct WearFit {
    /// The wear.
    pub wear_um: f64,
    /// How fast it grows.
    pub rate_um_per_part: f64,
    /// Whether it is more than 90 % sure that it grows at all.
    pub is_rising: bool,
    /// Standard deviation of a typical entry about the fit.
    pub scatter_um: f64,
}

/// One edge.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearEdge {
    /// Its name; null where the cutter was measured as a whole.
    pub edge: Option<String>,
    /// Its entries, by the number of parts.
    pub entries: Vec<WearTrendPoint>,
    /// Null where there are too few entries.
    pub fit: Option<WearFit>,
}

/// Something that a person should look at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct WearWarning {
    /// `wear-falls`, `edge-without-fit`, `edge-behind`, `uncertainties-left-out`.
    #[schema(example = "wear-falls")]
    pub kind: &'static str,
    /// The edge; null where the cutter was measured as a whole, or where it is about all.
    pub edge: Option<String>,
    /// In words.
    pub detail: String,
}

/// How a cutter wore.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WearTrend {
    /// The machine.
    pub machine_id: String,
    /// The tool.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// The cutter; null where the tool has no entries.
    #[schema(example = "1")]
    pub cutter_id: Option<String>,
    /// What was measured; null without entries.
    pub quantity: Option<WearQuantity>,
    /// Parts at the newest entry; null without entries.
    pub parts_now: Option<u32>,
    /// The limit asked for.
    pub limit_um: Option<f64>,
    /// Its edges.
    pub edges: Vec<WearEdge>,
    /// The parts that are left; null where no limit was asked for.
    pub outlook: Option<PartsOutlook>,
    /// What a person should look at.
    pub warnings: Vec<WearWarning>,
}

/// Which cutter is followed, and to what limit.
#[derive(Debug, Clone, PartialEq)]
pub struct WearTrendHead {
    /// The machine.
    pub machine_id: String,
    /// The tool.
    pub tool_id: String,
    /// The cutter, where the tool has any.
    pub cutter_id: Option<String>,
    /// The limit \[µm\].
    pub limit_um: Option<f64>,
}

/// A trend with what it was computed from.
#[derive(Debug, Clone)]
pub struct FollowedWear {
    /// The document.
    pub trend: WearTrend,
    /// The course of each edge, where it has one.
    pub courses: Vec<Option<WearCourse>>,
    /// When the first edge reaches the limit, unless one has.
    pub life: Option<CutterLife>,
}

/// Falling by more than so many standard deviations of an entry is no scatter.
const FALL: f64 = 4.0;
/// Times that of neighbours, which a standard deviation is not larger than: errors that hang together make it twice as large at
/// most, while a misread entry or a changed cutter widens the fit as much as it likes.
const OF_NEIGHBOURS: f64 = 3.0;

impl FollowedWear {
    /// The trend of entries that are in the order of edges and parts.
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

/// That an edge's newest entry is at the limit.
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
    let words = format!("entries at {most} numbers of parts say nothing of the next; {needed} are needed");
    PartsOutlook::without_numbers(PartsOutlookKind::TooFewEntries, None, words)
}

/// Different numbers of parts that an edge was measured at.
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
                format!("measured at {} numbers of parts; it is left out of the outlook", places(edge)),
            );
        }
        if let (Some(newest), Some(now)) = (edge.entries.last(), parts_now)
            && newest.parts_cut < now
        {
            warn(
                "edge-behind",
                format!("last measured at {} parts, the newest entry is at {now}", newest.parts_cut),
            );
        }
        let stated = edge.entries.iter().filter(|entry| entry.standard_uncertainty_um.is_some()).count();
        if stated > 0 && stated < edge.entries.len() {
            let count = edge.entries.len();
            warn(
                "uncertainties-left-out",
                format!("{stated} of {count} entries state an uncertainty; they weigh only where all do"),
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
                        "{count} entries lie far below an earlier one, the first at {} parts: withdraw what was misread; a new or reground cutter needs a cutter_id of its own",
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
/// The table cannot be written, which memory never refuses.
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
