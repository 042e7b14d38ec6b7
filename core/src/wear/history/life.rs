//! How many parts a cutter's edges still cut before one of them reaches the limit.

use super::WearCourse;

/// What is left outside an interval of 95 % on either side.
const TAIL: f64 = 0.025;
/// How far ahead anything is told, in spans of the readings: nobody has seen farther stages of the wear.
const REACH: f64 = 3.0;
/// Places looked at on the way there.
const PLACES: u32 = 400;
/// Halvings of the stretch between two of them.
const HALVINGS: u32 = 40;

/// What can be told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LifeKind {
    /// The number of parts at which an edge most likely reaches the limit.
    Predicted,
    /// Of no edge it is sure that the wear still rises (less than 90 %).
    NoRise,
    /// The limit is most likely reached beyond what the readings reach to.
    BeyondReach,
}

/// Parts cut since the cutter was new at which the first edge reaches the limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterLife {
    /// What can be told.
    pub kind: LifeKind,
    /// Reached before with a probability of 2.5 % at most; `None` where that lies beyond the reach.
    pub earliest: Option<f64>,
    /// As likely before as after, for the edge that is first.
    pub estimate: Option<f64>,
    /// Reached before with a probability of 97.5 % at least; `None` where that lies beyond the reach.
    pub latest: Option<f64>,
    /// Index of the edge that is most likely first, where there is an estimate.
    pub first_edge: Option<usize>,
    /// The parts beyond which nothing is told.
    pub reach: f64,
}

/// When the first of the edges with these courses reaches `limit_mm`, counted from `parts_now`, the parts at the newest
/// reading of any of them.
///
/// Whatever the edges have in common, the chance that one has reached the limit is between the largest of theirs and
/// their sum: the sum gives the early end, the largest the estimate and the late end. Estimate and late end come from
/// edges whose wear still rises.
#[must_use]
pub fn cutter_life(courses: &[&WearCourse], limit_mm: f64, parts_now: u32) -> CutterLife {
    let now = f64::from(parts_now);
    let first = courses.iter().map(|course| course.first_parts()).min().unwrap_or(parts_now);
    let span = now - f64::from(first);
    let reach = now + REACH * span;
    let rises: Vec<bool> = courses.iter().map(|course| course.is_rising()).collect();
    let any = |parts: f64| -> f64 { courses.iter().map(|course| course.chance_above(parts, limit_mm)).sum() };
    let surely = |parts: f64| -> f64 {
        let rising = courses.iter().zip(&rises).filter(|(_, rises)| **rises);
        rising.map(|(course, _)| course.chance_above(parts, limit_mm)).fold(0.0, f64::max)
    };
    let places = || (0..=PLACES).map(|k| now + (reach - now) * f64::from(k) / f64::from(PLACES));
    let earliest = reached(places(), &any, TAIL);
    let estimate = reached(places(), &surely, 0.5);
    let latest = reached(places(), &surely, 1.0 - TAIL);
    let first_edge = estimate.and_then(|parts| {
        let chances = courses.iter().zip(&rises).enumerate().filter(|(_, (_, rises))| **rises);
        let chances = chances.map(|(index, (course, _))| (index, course.chance_above(parts, limit_mm)));
        chances
            .max_by(|one, other| one.1.total_cmp(&other.1).then(other.0.cmp(&one.0)))
            .map(|(index, _)| index)
    });
    let kind = match (estimate, rises.contains(&true)) {
        (Some(_), _) => LifeKind::Predicted,
        (None, true) => LifeKind::BeyondReach,
        (None, false) => LifeKind::NoRise,
    };
    CutterLife { kind, earliest, estimate, latest, first_edge, reach }
}

/// The first of the `places` at which `chance` is at least `probability`, narrowed down from the one before.
fn reached(places: impl Iterator<Item = f64>, chance: &dyn Fn(f64) -> f64, probability: f64) -> Option<f64> {
    let mut before: Option<f64> = None;
    for place in places {
        if chance(place) >= probability {
            let Some(mut low) = before else { return Some(place) };
            let mut high = place;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if chance(middle) >= probability {
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
