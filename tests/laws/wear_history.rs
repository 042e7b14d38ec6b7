//! Laws of the parts left, whatever was read.

use proptest::prelude::*;
use trunnion::wear::{LifeEnds, LifeKind, WearCourse, WearReading, cutter_life, wear_ahead};

/// Rounding of a mean over a few hundred shares.
const ROUNDING: f64 = 1e-12;
/// Wear of up to 10 mm.
const MOST_MM: f64 = 10.0;

/// 3 to 12 readings at any parts, of wear that may do anything.
fn readings() -> impl Strategy<Value = Vec<WearReading>> {
    let parts = prop_oneof![
        3 => proptest::collection::btree_set(0_u32..500, 3..12),
        1 => proptest::collection::btree_set(0_u32..1_000_000_000, 3..12),
        1 => proptest::collection::btree_set(999_999_900_u32..1_000_000_000, 3..12),
    ];
    let wear = prop_oneof![
        4 => (0.0..0.1, -1e-3..5e-3).prop_map(|(begun, rate)| vec![begun, rate]),
        1 => Just(vec![0.0, 0.0]),
        1 => Just(vec![MOST_MM, 0.0]),
    ];
    let scatter = prop_oneof![Just(0.0), 0.0..5e-3, 0.0..MOST_MM];
    let stated = prop_oneof![2 => Just(None), 1 => (1e-6..1.0).prop_map(Some)];
    (parts, wear, scatter, stated, proptest::collection::vec(-1.0..1.0, 12)).prop_map(
        |(parts, wear, scatter, stated, errors): (
            std::collections::BTreeSet<u32>,
            Vec<f64>,
            f64,
            Option<f64>,
            Vec<f64>,
        )| {
            parts
                .into_iter()
                .zip(errors)
                .enumerate()
                .map(|(index, (parts_cut, error))| WearReading {
                    parts_cut,
                    wear_mm: (wear[0] + wear[1] * index as f64 + scatter * error).clamp(0.0, MOST_MM),
                    standard_uncertainty_mm: stated,
                })
                .collect()
        },
    )
}

fn is_told(ends: &LifeEnds, now: f64, estimate: Option<f64>, reach: f64) -> bool {
    let within = |parts: Option<f64>| parts.is_none_or(|parts| (now..=reach).contains(&parts));
    let (earliest, latest) = (ends.earliest, ends.latest);
    let in_order =
        |one: Option<f64>, other: Option<f64>| !matches!((one, other), (Some(a), Some(b)) if a > b);
    within(earliest)
        && within(latest)
        && in_order(earliest, estimate)
        && in_order(estimate, latest)
        && in_order(earliest, latest)
        // Whatever is told has an early end.
        && (earliest.is_some() || (estimate.is_none() && latest.is_none()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn what_is_told_is_finite_and_in_order(
        one in readings(),
        other in readings(),
        limit_mm in prop_oneof![1e-6..0.2, 0.2..MOST_MM],
    ) {
        let courses = [WearCourse::of(&one).unwrap(), WearCourse::of(&other).unwrap()];
        for course in &courses {
            let (basis, now) = (course.basis(), course.now());
            for value in [
                basis.scatter_mm, basis.correlation, basis.drift, basis.reference_mm_per_part, now.wear_mm,
                now.rate_mm_per_part, now.chance_rising, course.neighbour_scatter_mm(),
            ] {
                prop_assert!(value.is_finite(), "{basis:?} {now:?}");
            }
            prop_assert!(basis.scatter_mm > 0.0 && basis.drift > 0.0 && basis.reference_mm_per_part > 0.0);
            prop_assert!((0.0..=1.0).contains(&now.chance_rising), "{now:?}");
            prop_assert!((0.0..0.7 + ROUNDING).contains(&basis.correlation), "{basis:?}");
            prop_assert!(course.fitted_mm().iter().all(|wear| wear.is_finite()));
            let parts: Vec<f64> = (0..4).map(|k| f64::from(course.last_parts()) * f64::from(4 + k) / 4.0).collect();
            for ahead in wear_ahead(course, &parts) {
                let ([low, high], [same_low, same_high]) = (ahead.ends_mm, ahead.same_stage_mm);
                prop_assert!(low <= high && same_low <= ahead.middle_mm && ahead.middle_mm <= same_high, "{ahead:?}");
                prop_assert!(low.is_finite() && high.is_finite(), "{ahead:?}");
            }
        }
        let now = courses.iter().map(WearCourse::last_parts).max().unwrap();
        let alone = cutter_life(&[&courses[0]], limit_mm, now);
        let both = cutter_life(&[&courses[0], &courses[1]], limit_mm, now);
        for life in [&alone, &both] {
            prop_assert!(life.reach.is_finite() && life.reach > f64::from(now));
            prop_assert!(is_told(&life.ends, f64::from(now), life.estimate, life.reach), "{life:?}");
            prop_assert!(is_told(&life.same_stage, f64::from(now), life.estimate, life.reach), "{life:?}");
            prop_assert_eq!(life.estimate.is_some(), life.kind == LifeKind::Predicted);
            prop_assert_eq!(life.estimate.is_some(), life.first_edge.is_some());
            if life.kind == LifeKind::NoRise {
                prop_assert_eq!((life.ends.latest, life.same_stage.latest), (None, None));
            }
        }
        // The same readings, the same numbers.
        prop_assert_eq!(both, cutter_life(&[&courses[0], &courses[1]], limit_mm, now));
    }

    #[test]
    fn a_higher_limit_is_never_reached_before_a_lower_one(
        readings in readings(),
        limit_mm in 1e-3..0.3,
        more_mm in 1e-6..0.1,
    ) {
        let course = WearCourse::of(&readings).unwrap();
        let life = |limit_mm: f64| cutter_life(&[&course], limit_mm, course.last_parts());
        let (low, high) = (life(limit_mm), life(limit_mm + more_mm));
        let later = |one: Option<f64>, other: Option<f64>| match (one, other) {
            (Some(one), Some(other)) => one <= other,
            (None, other) => other.is_none(),
            (Some(_), None) => true,
        };
        prop_assert!(later(low.estimate, high.estimate), "{low:?} {high:?}");
        prop_assert!(later(low.ends.earliest, high.ends.earliest), "{low:?} {high:?}");
        prop_assert!(later(low.same_stage.earliest, high.same_stage.earliest), "{low:?} {high:?}");
        prop_assert!(later(low.ends.latest, high.ends.latest), "{low:?} {high:?}");
    }
}
