//! Wear histories: the interval of straight wear, lines against the textbook, and what cannot be told.

use trunnion::wear::{CourseFault, LifeKind, WearCourse, WearReading, cutter_life, wear_ahead};

use crate::wear_back_test_model::{Draws, Microscope, Tallies, Trial, UM};

fn reading(parts_cut: u32, wear_mm: f64) -> WearReading {
    WearReading { parts_cut, wear_mm, standard_uncertainty_mm: None }
}

/// Cutters of each case: an end that holds 97.5 % is found to hold less than 94.2 % once in seven hundred.
const CUTTERS: u32 = 200;

/// A rate of 0.5 µm a part from 20 µm on, an entry every ten parts.
#[test]
fn the_interval_of_straight_wear_holds_the_truth_nineteen_times_in_twenty() {
    for (count, scatter_um, limit_um) in
        [(4, 3.0, 50.0), (5, 1.0, 60.0), (8, 3.0, 80.0), (8, 6.0, 90.0), (15, 3.0, 130.0), (30, 2.0, 260.0)]
    {
        let mut draws = Draws(11);
        let mut tallies = Tallies::default();
        let (mut predicted, mut before_estimate) = (0_u32, 0_u32);
        let truth = (limit_um - 20.0) / 0.5;
        for _ in 0..CUTTERS {
            let mut microscope = Microscope::new(scatter_um, 0.0, &mut draws);
            let readings =
                (0..count).map(|k| microscope.read(10 * k, 20.0 + 5.0 * k as f64, &mut draws)).collect();
            let life = tallies.add(&Trial { readings, limit_um, truth });
            predicted += u32::from(life.estimate.is_some());
            before_estimate += u32::from(life.estimate.is_some_and(|estimate| estimate > truth));
        }
        let Tallies { whole, same_stage } = &tallies;
        println!("{count} readings, scatter {scatter_um} µm, limit {limit_um} µm: {}", whole.row());
        println!("same stage: {}; {predicted} predicted", same_stage.row());
        assert!(whole.holds(), "{count}: {}", whole.row());
        assert!(same_stage.holds(), "{count}: {}", same_stage.row());
        if count >= 8 && scatter_um < 5.0 {
            // Wide enough, and not so wide that nothing is said.
            assert!(same_stage.told_share() > 0.8, "{count}: {}", same_stage.row());
            assert!(f64::from(predicted) > 0.9 * f64::from(CUTTERS), "{count}: {predicted}");
            let half = f64::from(before_estimate) / f64::from(predicted);
            assert!((0.35..0.65).contains(&half), "{count}: {half}");
        }
    }
}

/// Two readings at each of many parts along an exact line with equal and opposite errors: what remains of the textbook.
#[test]
fn the_rate_of_a_line_is_that_of_least_squares() {
    let readings: Vec<WearReading> = (0..20)
        .flat_map(|k| {
            let wear = (10.0 + 0.4 * f64::from(5 * k)) * UM;
            [reading(5 * k, wear + 2.0 * UM), reading(5 * k, wear - 2.0 * UM)]
        })
        .collect();
    let course = WearCourse::of(&readings).unwrap();
    let now = course.now();
    assert!((now.rate_mm_per_part - 0.4 * UM).abs() < 1e-9, "{now:?}");
    assert!((now.wear_mm - 48.0 * UM).abs() < 1e-9, "{now:?}");
    assert!(now.chance_rising > 0.999, "{now:?}");
    // 38 degrees of freedom: √(40/38) of 2 µm, or less where the rate takes some.
    assert!((1.8..2.06).contains(&(course.scatter_mm() / UM)), "{}", course.scatter_mm());
    for (k, fitted_mm) in (0_u32..).zip(course.fitted_mm()) {
        let wear = (10.0 + 0.4 * f64::from(5 * (k / 2))) * UM;
        assert!((fitted_mm - wear).abs() < 1e-8, "{k}: {fitted_mm}");
    }
    let life = cutter_life(&[&course], 70.0 * UM, 95);
    assert_eq!((life.kind, life.first_edge), (LifeKind::Predicted, Some(0)));
    assert!((life.estimate.unwrap() - 150.0).abs() < 1.0, "{life:?}");
    let within = life.same_stage;
    assert!(within.earliest.unwrap() < 149.0 && within.latest.unwrap() > 151.0, "{life:?}");
    assert!(life.ends.earliest < within.earliest, "{life:?}");
    assert!(life.ends.latest.is_none_or(|latest| latest > within.latest.unwrap()), "{life:?}");
}

#[test]
fn an_exact_line_is_not_trusted_beyond_what_a_reading_resolves() {
    let readings: Vec<WearReading> = (0..6).map(|k| reading(10 * k, f64::from(10 * k) * 0.5 * UM)).collect();
    let course = WearCourse::of(&readings).unwrap();
    // Little more than the least, since six readings may be good by luck.
    assert!((0.3..0.6).contains(&(course.scatter_mm() / UM)), "{}", course.scatter_mm());
    let life = cutter_life(&[&course], 40.0 * UM, 50);
    assert!((life.estimate.unwrap() - 80.0).abs() < 0.5, "{life:?}");
    let within = life.same_stage;
    assert!(within.earliest.unwrap() < 79.5 && within.latest.unwrap() > 80.5, "{life:?}");
}

#[test]
fn what_cannot_be_told_is_none() {
    let few = [reading(0, 0.0), reading(0, 0.001), reading(10, 0.01)];
    assert_eq!(WearCourse::of(&few).unwrap_err(), CourseFault::TooFew { found: 2 });
    assert_eq!(WearCourse::of(&[]).unwrap_err(), CourseFault::TooFew { found: 0 });
    let back = [reading(5, 0.0), reading(0, 0.0), reading(9, 0.0)];
    assert_eq!(WearCourse::of(&back).unwrap_err(), CourseFault::OutOfOrder { reading: 1 });

    // Wear that stands still: no estimate, but an early end.
    let still: Vec<WearReading> =
        (0..10_u32).map(|k| reading(10 * k, (50.0 + f64::from(k * 7 % 5)) * UM)).collect();
    let course = WearCourse::of(&still).unwrap();
    let life = cutter_life(&[&course], 60.0 * UM, 90);
    assert_eq!((life.kind, life.estimate, life.ends.latest), (LifeKind::NoRise, None, None), "{life:?}");
    assert_eq!(life.same_stage.latest, None, "{life:?}");
    assert!(life.ends.earliest.unwrap() > 90.0, "{life:?}");

    // A limit far beyond the readings.
    let rising: Vec<WearReading> = (0..10).map(|k| reading(10 * k, f64::from(k) * UM)).collect();
    let course = WearCourse::of(&rising).unwrap();
    let life = cutter_life(&[&course], 1.0, 90);
    assert_eq!((life.kind, life.estimate), (LifeKind::BeyondReach, None), "{life:?}");
    assert!((life.reach - 360.0).abs() < 1e-12);
}

#[test]
fn the_edge_that_is_first_governs_and_more_edges_never_last_longer() {
    let edge = |rate_um: f64| -> WearCourse {
        let readings: Vec<WearReading> = (0..12_u32)
            .map(|k| reading(10 * k, (rate_um * f64::from(10 * k) + f64::from(k * 5 % 7) * 0.3) * UM))
            .collect();
        WearCourse::of(&readings).unwrap()
    };
    let (slow, fast) = (edge(0.4), edge(0.5));
    let alone = |course: &WearCourse| cutter_life(&[course], 80.0 * UM, 110);
    let both = cutter_life(&[&slow, &fast], 80.0 * UM, 110);
    assert_eq!(both.first_edge, Some(1));
    assert_eq!(
        (both.estimate, both.same_stage.latest),
        (alone(&fast).estimate, alone(&fast).same_stage.latest)
    );
    assert!(
        both.ends.earliest <= alone(&fast).ends.earliest && both.ends.earliest < alone(&slow).ends.earliest
    );
    let twins = cutter_life(&[&fast, &fast], 80.0 * UM, 110);
    assert!(twins.ends.earliest < alone(&fast).ends.earliest && twins.first_edge == Some(0));
    assert!(twins.same_stage.earliest < alone(&fast).same_stage.earliest);
}

#[test]
fn stated_uncertainties_weigh_and_widen() {
    let rough = |k: u32| [0.0, 3.0, -3.0][k as usize % 3];
    let with = |uncertainty: &dyn Fn(u32) -> Option<f64>| -> WearCourse {
        let readings: Vec<WearReading> = (0..12)
            .map(|k| WearReading {
                parts_cut: 10 * k,
                wear_mm: (20.0 + 5.0 * f64::from(k) + rough(k)) * UM,
                standard_uncertainty_mm: uncertainty(k).map(|um| um * UM),
            })
            .collect();
        WearCourse::of(&readings).unwrap()
    };
    let life = |course: &WearCourse| cutter_life(&[course], 100.0 * UM, 110);
    let (unstated, wide) = (with(&|_| None), with(&|_| Some(8.0)));
    assert!((8.0..11.0).contains(&(wide.scatter_mm() / UM)), "{}", wide.scatter_mm());
    assert!(life(&wide).same_stage.earliest < life(&unstated).same_stage.earliest);
    // Good readings carry the course: here every third, which lie on the line.
    let weighed = with(&|k| Some(if k % 3 == 0 { 0.3 } else { 3.0 }));
    // The last good one is the last but two: the rate may have strayed a little since.
    assert!((weighed.now().rate_mm_per_part - 0.5 * UM).abs() < 0.02 * UM, "{:?}", weighed.now());
    assert!((unstated.now().rate_mm_per_part - 0.5 * UM).abs() > 0.02 * UM, "{:?}", unstated.now());
    // One that states nothing makes all count alike.
    let mixed = with(&|k| (k > 0).then_some(0.3));
    assert_eq!(mixed.now(), unstated.now());
}

/// The drift of a course that turns is told larger than that of a straight one, and so is the correlation of errors
/// that come in runs.
#[test]
fn what_the_interval_rests_on_is_seen_in_the_readings() {
    let course = |wear_um: &dyn Fn(u32) -> f64| -> WearCourse {
        let readings: Vec<WearReading> = (0..30_u32).map(|k| reading(10 * k, wear_um(k) * UM)).collect();
        WearCourse::of(&readings).unwrap()
    };
    let rough = |k: u32| [0.4, -0.9, 1.1, -0.3, 0.1, -0.6, 0.8][k as usize % 7];
    let straight = course(&|k| 20.0 + 5.0 * f64::from(k) + rough(k)).basis();
    let turning = course(&|k| 20.0 + 0.25 * f64::from(k).powi(2) + rough(k)).basis();
    assert!(straight.drift < 0.2 && turning.drift > 0.5, "{straight:?} {turning:?}");
    let runs = course(&|k| 20.0 + 5.0 * f64::from(k) + 2.0 * rough(k / 4)).basis();
    assert!(straight.correlation < 0.1 && runs.correlation > 0.3, "{straight:?} {runs:?}");
    assert_eq!((straight.readings, straight.places), (30, 30));
    assert!((straight.reference_mm_per_part - 0.5 * UM).abs() < 0.02 * UM, "{straight:?}");
    assert!((0.5..1.0).contains(&(straight.scatter_mm / UM)), "{straight:?}");
}

/// A limit that is higher is reached later, and what is to come rises and widens.
#[test]
fn what_is_to_come_is_in_order() {
    let readings: Vec<WearReading> = (0..9_u32)
        .map(|k| reading(20 * k, (30.0 + 4.0 * f64::from(k) + f64::from(k * 5 % 4)) * UM))
        .collect();
    let course = WearCourse::of(&readings).unwrap();
    let lives: Vec<_> = (70..110).map(|limit| cutter_life(&[&course], f64::from(limit) * UM, 160)).collect();
    for pair in lives.windows(2) {
        let [one, next] = pair else { unreachable!() };
        assert!(one.ends.earliest <= next.ends.earliest, "{one:?} {next:?}");
        assert!(one.estimate < next.estimate, "{one:?} {next:?}");
    }
    let parts: Vec<f64> = (160..300).map(f64::from).collect();
    let ahead = wear_ahead(&course, &parts);
    assert_eq!(ahead.len(), parts.len());
    for pair in ahead.windows(2) {
        let [one, next] = pair else { unreachable!() };
        let ([low, high], [same_low, same_high]) = (next.ends_mm, next.same_stage_mm);
        // Courses are drawn: fifty in two thousand are not quite the same in both.
        let drawn_mm = 0.3 * UM;
        assert!(low <= same_low + drawn_mm && same_low <= next.middle_mm, "{next:?}");
        assert!(next.middle_mm <= same_high && same_high <= high + drawn_mm, "{next:?}");
        assert!(one.ends_mm[0] <= low && one.ends_mm[1] <= high, "{one:?} {next:?}");
    }
    // The band and the ends say the same: at the early end 2.5 % are above the limit.
    let limit_mm = 80.0 * UM;
    let earliest = cutter_life(&[&course], limit_mm, 160).ends.earliest.unwrap();
    let [there] = wear_ahead(&course, &[earliest])[..] else { unreachable!() };
    assert!((there.ends_mm[1] - limit_mm).abs() < 2.0 * UM, "{earliest} {there:?}");
}

/// The same readings get the same numbers, and so do readings of a cutter whose parts are counted in thousands.
#[test]
fn the_scale_of_the_parts_does_not_matter() {
    let at = |scale: u32| -> WearCourse {
        let readings: Vec<WearReading> = (0..10_u32)
            .map(|k| reading(scale * 10 * k, (20.0 + 3.0 * f64::from(k) + f64::from(k * 3 % 5) * 0.4) * UM))
            .collect();
        WearCourse::of(&readings).unwrap()
    };
    let (one, other) = (at(1), at(1000));
    let (near, far) = (cutter_life(&[&one], 70.0 * UM, 90), cutter_life(&[&other], 70.0 * UM, 90_000));
    for (near, far) in [
        (near.ends.earliest, far.ends.earliest),
        (near.estimate, far.estimate),
        (near.same_stage.latest, far.same_stage.latest),
    ] {
        assert!((1000.0 * near.unwrap() / far.unwrap() - 1.0).abs() < 1e-9, "{near:?} {far:?}");
    }
    assert_eq!(near, cutter_life(&[&at(1)], 70.0 * UM, 90));
}
