//! The number of parts until one of a cutter's edges reaches the limit.

use super::WearCourse;
use super::ahead::{Ahead, DRAWN, Stages};

/// Probability outside a 95 % interval on each side.
const TAIL: f64 = 0.025;
/// Largest prediction, in spans of the readings: later stages of the wear are unknown.
const REACH: f64 = 3.0;
/// Positions searched for the estimate.
const PLACES: u32 = 120;
/// Halvings of the interval between two of them.
const HALVINGS: u32 = 40;

/// The kind of prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LifeKind {
    /// The number of parts at which an edge reaches the limit if it continues to wear as before.
    Predicted,
    /// No edge is known to wear still (probability below 90 %).
    NoRise,
    /// The limit is reached beyond the range of prediction.
    BeyondReach,
}

/// Parts between which the limit is reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LifeEnds {
    /// Reached before this with a probability of at most 2.5 %; `None` if it is beyond the range.
    pub earliest: Option<f64>,
    /// Reached before this with a probability of at least 97.5 %; `None` if it is beyond the range, or if no edge
    /// is known to wear.
    pub latest: Option<f64>,
}

/// Parts cut since the cutter was new at which the first edge reaches the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterLife {
    /// The kind of prediction.
    pub kind: LifeKind,
    /// The ends, whatever stage of wear comes next.
    pub ends: LifeEnds,
    /// The median for the edge that is first, if its rate continues to vary as before.
    pub estimate: Option<f64>,
    /// The ends if no new stage of wear begins before the limit is reached.
    pub same_stage: LifeEnds,
    /// Index of the edge to which the estimate belongs, if there is one.
    pub first_edge: Option<usize>,
    /// The parts beyond which nothing is predicted.
    pub reach: f64,
}

/// The parts at which the first of the edges with these courses reaches `limit_mm`, counted from `parts_now`, the
/// parts at the newest reading of any edge.
///
/// The probability that one edge has reached the limit is between the largest probability of one edge and their
/// sum, whatever the edges have in common. The sum gives the early ends, the largest the estimate and the late
/// ends. Estimate and late ends come from edges whose wear still rises.
#[must_use]
pub fn cutter_life(courses: &[&WearCourse], limit_mm: f64, parts_now: u32) -> CutterLife {
    let now = f64::from(parts_now);
    let first = courses.iter().map(|course| course.first_parts()).min().unwrap_or(parts_now);
    let reach = now + REACH * (now - f64::from(first));
    let rises: Vec<bool> = courses.iter().map(|course| course.is_rising()).collect();
    let (mut new, mut same) = (Ends::default(), Ends::default());
    for (course, rises) in courses.iter().zip(&rises) {
        let ahead = Ahead::of(course, reach);
        new.add(ahead.reached(Stages::New, limit_mm), *rises);
        same.add(ahead.reached(Stages::Same, limit_mm), *rises);
    }
    let each = courses.iter().zip(&rises).enumerate().filter(|(_, (_, rises))| **rises);
    let estimates =
        each.filter_map(|(index, (course, _))| Some((index, middle(course, limit_mm, now, reach)?)));
    let estimate = estimates.min_by(|one, other| one.1.total_cmp(&other.1).then(one.0.cmp(&other.0)));
    let kind = match (estimate, rises.contains(&true)) {
        (Some(_), _) => LifeKind::Predicted,
        (None, true) => LifeKind::BeyondReach,
        (None, false) => LifeKind::NoRise,
    };
    let ends = |ends: Ends| ends.within(now, reach, estimate.map(|(_, parts)| parts));
    CutterLife {
        kind,
        ends: ends(new),
        estimate: estimate.map(|(_, parts)| parts),
        same_stage: ends(same),
        first_edge: estimate.map(|(index, _)| index),
        reach,
    }
}

/// The ends for several edges.
#[derive(Debug, Default)]
struct Ends {
    /// Parts reached by the courses of any edge, as far as the early end may need them.
    any: Vec<f64>,
    latest: Option<f64>,
}

impl Ends {
    /// Adds the courses of another edge, in the order of the parts at which they reach the limit.
    fn add(&mut self, reached: Vec<f64>, rises: bool) {
        let late = reached.get(rank(1.0 - TAIL)).copied().filter(|_| rises);
        self.latest = match (self.latest, late) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        };
        self.any.extend(reached.into_iter().take(rank(TAIL) + 1));
    }

    fn within(mut self, now: f64, reach: f64, estimate: Option<f64>) -> LifeEnds {
        self.any.sort_by(f64::total_cmp);
        let told = |parts: f64| (parts <= reach).then_some(parts.max(now));
        let earliest = self.any.get(rank(TAIL)).copied().and_then(told);
        let latest = self.latest.and_then(told);
        // The estimate is not one of the simulated courses: rounding may put it just outside the ends.
        LifeEnds {
            earliest: match (earliest, estimate) {
                (Some(parts), Some(estimate)) => Some(parts.min(estimate)),
                (None, estimate) => estimate,
                (earliest, None) => earliest,
            },
            latest: latest.map(|parts| estimate.map_or(parts, |estimate| parts.max(estimate))),
        }
    }
}

/// Index of the first ordered course that has this share of all courses before it.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the courses drawn")]
fn rank(share: f64) -> usize {
    (share * DRAWN as f64).round() as usize
}

/// The first parts from now on at which the limit is reached with a probability of one half, if no new stage
/// begins.
fn middle(course: &WearCourse, limit_mm: f64, now: f64, reach: f64) -> Option<f64> {
    let is_reached = |parts: f64| course.chance_above(parts, limit_mm) >= 0.5;
    let places = (0..=PLACES).map(|k| now + (reach - now) * f64::from(k) / f64::from(PLACES));
    let mut before: Option<f64> = None;
    for place in places {
        if is_reached(place) {
            let Some(mut low) = before else { return Some(place) };
            let mut high = place;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if is_reached(middle) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            return Some(high);
        }
        before = Some(place);
    }
    None
}
