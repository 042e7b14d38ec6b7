//! The parts that are left to a limit, and what that rests on.

use serde::Serialize;
use utoipa::ToSchema;

use crate::units::UM_PER_MM;
use crate::wear::{
    CutterLife, LifeEnds, LifeKind, STAGE_RATES, STAGES_PER_SPAN, STANDSTILL_OF_AGE, STANDSTILLS, WearCourse,
};

/// What can be told of the parts that are left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PartsOutlookKind {
    /// Where the limit is most likely reached.
    Predicted,
    /// Nothing but an early end: of no edge it is sure that it still wears.
    NoRise,
    /// The limit lies beyond three times the stretch that was measured.
    BeyondReach,
    /// The newest entry of an edge is at the limit or over it.
    Passed,
    /// No edge was measured at three numbers of parts.
    TooFewEntries,
}

/// Numbers of parts; 95 % lie between the earliest and the latest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct PartsInterval {
    /// The early end; null beyond what can be told.
    pub earliest: Option<u64>,
    /// As likely less as more, if the wear goes on as it does now; null where there is no telling.
    pub estimate: Option<u64>,
    /// The late end; null beyond what can be told.
    pub latest: Option<u64>,
}

/// What the entries of one edge say of how they were measured and of how steadily the edge wears.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct EdgeBasis {
    /// The edge; null where the cutter was measured as a whole.
    pub edge: Option<String>,
    /// Entries used.
    pub entries: usize,
    /// Different numbers of parts among them.
    pub numbers_of_parts: usize,
    /// Parts at the first of them.
    pub first_parts: u32,
    /// Parts at the last of them: the stretch measured is from the first to here.
    pub last_parts: u32,
    /// Standard deviation of a typical entry about the course.
    pub scatter_um: f64,
    /// Correlation of the errors of neighbouring entries, 0 to 0.7.
    pub correlation: f64,
    /// How far the rate strays over the stretch measured (standard deviation), as a share of the reference rate.
    pub rate_drift: f64,
    /// The mean rate that drift and stages are measured by.
    pub reference_rate_um_per_part: f64,
}

/// The stages of wear that may come, as the ends count on them: the same for every cutter, no entry shows them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct StageBasis {
    /// New stages that begin in as many parts as the stretch measured, in the mean.
    pub stages_per_stretch: f64,
    /// Share of the new stages in which the wear nearly stands still.
    pub standstill_share: f64,
    /// Mean length of these, as a share of the parts since the cutter was new.
    pub standstill_of_age: f64,
    /// Least and largest rate of any other new stage, over the reference rate.
    pub rate_ratios: [f64; 2],
}

/// What the numbers of parts rest on.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct OutlookBasis {
    /// The model: `straying-rate-with-stages`.
    #[schema(example = "straying-rate-with-stages")]
    pub model: &'static str,
    /// The parts beyond which nothing is told.
    pub reach_parts: u64,
    /// Each edge that the numbers are from.
    pub edges: Vec<EdgeBasis>,
    /// The stages that may come.
    pub stages: StageBasis,
}

impl OutlookBasis {
    /// What numbers from these edges and courses rest on, told up to `reach` parts.
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

/// The parts that are left to the limit.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct PartsOutlook {
    /// What can be told.
    pub kind: PartsOutlookKind,
    /// Counted from the newest entry; null where nothing can be told, and once the limit is passed.
    pub parts_left: Option<PartsInterval>,
    /// The same counted since the cutter was new.
    pub parts_at_limit: Option<PartsInterval>,
    /// The narrower interval that holds as long as no new stage of wear begins, counted since the cutter was new: a rapid
    /// stage or a standstill makes it wrong.
    pub parts_at_limit_in_this_stage: Option<PartsInterval>,
    /// The edge that is most likely first, or that has passed; null where the cutter was measured as a whole too.
    pub first_edge: Option<String>,
    /// What the numbers rest on; null where there are none.
    pub basis: Option<OutlookBasis>,
    /// The same in words, and why a number is missing.
    #[schema(example = "150 µm are most likely reached at 271 parts, 21 more than now")]
    pub words: String,
}

impl PartsOutlook {
    /// Without numbers.
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

    /// What the life of a cutter tells, `now` being the parts at its newest entry.
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
            "Whatever stage of wear comes next, it is {} (95 %). If no new stage begins, it is {}",
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
                    "it is less than 90 % sure that the wear still grows: nobody can tell when {limit_um} µm are reached. {ends}"
                );
                (PartsOutlookKind::NoRise, words)
            }
            LifeKind::BeyondReach => {
                let words = format!(
                    "{limit_um} µm are most likely reached after {reach} parts: the stretch that was measured tells no farther. {ends}"
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

/// Both ends in words.
fn between(interval: &PartsInterval, reach: u64) -> String {
    match (interval.earliest, interval.latest) {
        (Some(earliest), Some(latest)) => format!("between {earliest} and {latest} parts"),
        (Some(earliest), None) => {
            format!("not before {earliest} parts, with no late end up to {reach} parts, where telling ends")
        }
        (None, _) => format!("not before {reach} parts, where telling ends"),
    }
}

/// An edge's name in a sentence.
pub(super) fn named(edge: Option<&str>) -> String {
    edge.map(|edge| format!(" of edge {edge}")).unwrap_or_default()
}

/// Whole parts below a number of them: what is cut when it is reached.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 4e9")]
fn whole(parts: f64) -> u64 {
    parts.max(0.0) as u64
}
