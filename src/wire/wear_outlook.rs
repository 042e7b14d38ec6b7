//! The number of parts left until a limit, and the basis of this number.

use serde::Serialize;

use crate::description::ToSchema;
use crate::units::UM_PER_MM;
use crate::wear::{
    CutterLife, LifeEnds, LifeKind, STAGE_RATES, STAGES_PER_SPAN, STANDSTILL_OF_AGE, STANDSTILLS, WearCourse,
};

/// What the entries say about the parts that are left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PartsOutlookKind {
    /// The number of parts at which the limit is most likely reached is known.
    Predicted,
    /// Only the early end is known: it is not sure that any edge still wears.
    NoRise,
    /// The limit is beyond three times the measured range of parts.
    BeyondReach,
    /// The newest entry of an edge is at or over the limit.
    Passed,
    /// No edge was measured at three different numbers of parts.
    TooFewEntries,
}

/// Numbers of parts; the true number is between the earliest and the latest with 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct PartsInterval {
    /// Early end; null if it is beyond the reach.
    pub earliest: Option<u64>,
    /// Median estimate, if the wear continues as now; null if no estimate is possible.
    pub estimate: Option<u64>,
    /// Late end; null if it is beyond the reach.
    pub latest: Option<u64>,
}

/// What the entries of one edge say about the measurement and about how steadily the edge wears.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct EdgeBasis {
    /// Name of the edge; null for the whole cutter.
    pub edge: Option<String>,
    /// Number of entries that were used.
    pub entries: usize,
    /// Number of different part counts among these entries.
    pub numbers_of_parts: usize,
    /// Parts at the first part count.
    pub first_parts: u32,
    /// Parts at the last part count; the measured range is from the first to the last.
    pub last_parts: u32,
    /// Standard deviation of a typical entry about the fitted course.
    pub scatter_um: f64,
    /// Correlation of the errors of neighbouring entries, 0 to 0.7.
    pub correlation: f64,
    /// Standard deviation of the rate over the measured range, as a share of the reference rate.
    pub rate_drift: f64,
    /// The mean rate, to which drift and stages refer.
    pub reference_rate_um_per_part: f64,
}

/// Wear stages that may come, as the two ends take them into account. They are the same for every cutter; no
/// entry shows them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct StageBasis {
    /// Mean number of new stages that begin in as many parts as the measured range.
    pub stages_per_stretch: f64,
    /// Share of the new stages in which wear nearly stops.
    pub standstill_share: f64,
    /// Mean length of such a standstill, as a share of the parts since the cutter was new.
    pub standstill_of_age: f64,
    /// Smallest and largest rate of any other new stage, divided by the reference rate.
    pub rate_ratios: [f64; 2],
}

/// The basis of the numbers of parts.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct OutlookBasis {
    /// The model: `straying-rate-with-stages`.
    #[schema(example = "straying-rate-with-stages")]
    pub model: &'static str,
    /// Number of parts up to which an outlook is given.
    pub reach_parts: u64,
    /// The edges that the numbers come from.
    pub edges: Vec<EdgeBasis>,
    /// The wear stages that may come.
    pub stages: StageBasis,
}

impl OutlookBasis {
    /// The basis of the numbers from these edges and courses, up to `reach` parts.
    pub(super) fn of<'a>(edges: impl Iterator<Item = (Option<&'a str>, &'a WearCourse)>, reach: f64) -> Self {
        let edges = edges.map(|(edge, course)| {
            let basis = course.basis();
            EdgeBasis {
                edge: edge.map(str::to_owned),
                entries: basis.readings,
                numbers_of_parts: basis.places,
                first_parts: course.first_parts(),
                last_parts: course.last_parts(),
                scatter_um: basis.scatter_mm * UM_PER_MM,
                correlation: basis.correlation,
                rate_drift: basis.drift,
                reference_rate_um_per_part: basis.reference_mm_per_part * UM_PER_MM,
            }
        });
        let stages = StageBasis {
            stages_per_stretch: STAGES_PER_SPAN,
            standstill_share: STANDSTILLS,
            standstill_of_age: STANDSTILL_OF_AGE,
            rate_ratios: STAGE_RATES,
        };
        Self { model: "straying-rate-with-stages", reach_parts: whole(reach), edges: edges.collect(), stages }
    }
}

/// The parts left until the limit.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PartsOutlook {
    /// What can be said.
    pub kind: PartsOutlookKind,
    /// Parts from the newest entry on; null if nothing can be said, or if the limit has been passed.
    pub parts_left: Option<PartsInterval>,
    /// Parts since the cutter was new.
    pub parts_at_limit: Option<PartsInterval>,
    /// A narrower interval, in parts since the cutter was new. It is valid only while no new stage of wear
    /// begins; a rapid stage or a standstill makes it wrong.
    pub parts_at_limit_in_this_stage: Option<PartsInterval>,
    /// The edge that most likely reaches the limit first, or has passed it; null also if the cutter was
    /// measured as a whole.
    pub first_edge: Option<String>,
    /// Basis of the numbers; null if there are no numbers.
    pub basis: Option<OutlookBasis>,
    /// The outlook in words, with the reason if a number is missing.
    #[schema(example = "150 µm are most likely reached at 271 parts, 21 more than now")]
    pub words: String,
}

impl PartsOutlook {
    /// An outlook without numbers.
    pub(super) fn without_numbers(kind: PartsOutlookKind, first_edge: Option<String>, words: String) -> Self {
        Self {
            kind,
            parts_left: None,
            parts_at_limit: None,
            parts_at_limit_in_this_stage: None,
            first_edge,
            basis: None,
            words,
        }
    }

    /// The outlook from the life of a cutter; `now` is the number of parts at its newest entry.
    pub(super) fn told(
        life: &CutterLife,
        limit_um: f64,
        now: u32,
        first_edge: Option<String>,
        basis: OutlookBasis,
    ) -> Self {
        let interval = |ends: &LifeEnds| PartsInterval {
            earliest: ends.earliest.map(whole),
            estimate: life.estimate.map(whole),
            latest: ends.latest.map(f64::ceil).map(whole),
        };
        let (at, in_this_stage) = (interval(&life.ends), interval(&life.same_stage));
        let left = |parts: Option<u64>| parts.map(|parts| parts.saturating_sub(u64::from(now)));
        let parts_left = PartsInterval {
            earliest: left(at.earliest),
            estimate: left(at.estimate),
            latest: left(at.latest),
        };
        let reach = basis.reach_parts;
        let ends = format!(
            "With any next stage of wear it is {} (95 %). If no new stage begins, it is {}",
            between(&at, reach),
            between(&in_this_stage, reach)
        );
        let (kind, words) = match life.kind {
            LifeKind::Predicted => {
                let estimate = at.estimate.unwrap_or_default();
                let more = parts_left.estimate.unwrap_or_default();
                let name = named(first_edge.as_deref());
                let words = format!(
                    "{limit_um} µm{name} are most likely reached at {estimate} parts, {more} more than now. {ends}"
                );
                (PartsOutlookKind::Predicted, words)
            }
            LifeKind::NoRise => {
                let words = format!(
                    "the probability that the wear still grows is less than 90 %, so no number of parts can be given for {limit_um} µm. {ends}"
                );
                (PartsOutlookKind::NoRise, words)
            }
            LifeKind::BeyondReach => {
                let words = format!(
                    "{limit_um} µm are most likely reached after {reach} parts: the measured range does not allow a longer prediction. {ends}"
                );
                (PartsOutlookKind::BeyondReach, words)
            }
        };
        Self {
            kind,
            parts_left: Some(parts_left),
            parts_at_limit: Some(at),
            parts_at_limit_in_this_stage: Some(in_this_stage),
            first_edge,
            basis: Some(basis),
            words,
        }
    }
}

/// Both ends, in words.
fn between(interval: &PartsInterval, reach: u64) -> String {
    match (interval.earliest, interval.latest) {
        (Some(earliest), Some(latest)) => format!("between {earliest} and {latest} parts"),
        (Some(earliest), None) => {
            format!(
                "not before {earliest} parts, with no late end up to {reach} parts, where the prediction ends"
            )
        }
        (None, _) => format!("not before {reach} parts, where the prediction ends"),
    }
}

/// An edge's name in a sentence.
pub(super) fn named(edge: Option<&str>) -> String {
    edge.map(|edge| format!(" of edge {edge}")).unwrap_or_default()
}

/// The whole number of parts that are finished at this number of parts.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 4e9")]
fn whole(parts: f64) -> u64 {
    parts.max(0.0) as u64
}
