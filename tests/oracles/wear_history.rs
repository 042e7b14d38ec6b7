//! Wear histories: how often the interval holds the truth on simulated wear, and lines against the textbook.

use trunnion::wear::{CourseFault, LifeKind, WearCourse, WearReading, cutter_life};

const UM: f64 = 1e-3;

/// Random numbers that are the same everywhere: xorshift, and normal ones by Box and Muller.
struct Draws(u64);

impl Draws {
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let (length, turn) = (self.uniform(), self.uniform());
        (-2.0 * length.ln()).sqrt() * (std::f64::consts::TAU * turn).cos()
    }
}

fn reading(parts_cut: u32, wear_mm: f64) -> WearReading {
    WearReading { parts_cut, wear_mm, standard_uncertainty_mm: None }
}

/// What a simulation counted.
#[derive(Debug, Default)]
struct Counted {
    tries: u32,
    /// The limit reached before the early end.
    early: u32,
    /// The limit reached after the late end.
    late: u32,
    /// No late end within reach.
    open: u32,
    predicted: u32,
    /// Reached before the estimate.
    before_estimate: u32,
}

/// `tries` cutters of `count` readings 10 parts apart; `truth` gives the wear \[mm\] at each part for one of them.
fn simulated(
    seed: u64,
    tries: u32,
    count: u32,
    scatter_mm: f64,
    limit_mm: f64,
    mut truth: impl FnMut(&mut Draws) -> Vec<f64>,
) -> Counted {
    let mut draws = Draws(seed);
    let mut counted = Counted::default();
    while counted.tries < tries {
        let wear_mm = truth(&mut draws);
        let now = 10 * (count - 1);
        let crossing = wear_mm.iter().position(|wear| *wear >= limit_mm);
        let Some(crossing) = crossing.filter(|parts| *parts > now as usize) else { continue };
        let readings: Vec<WearReading> = (0..count)
            .map(|k| reading(10 * k, wear_mm[10 * k as usize] + scatter_mm * draws.normal()))
            .collect();
        let course = WearCourse::of(&readings).expect("a course");
        let life = cutter_life(&[&course], limit_mm, now);
        let crossing = crossing as f64;
        counted.tries += 1;
        // The crossing lies within the last part.
        counted.early += u32::from(life.earliest.is_none_or(|earliest| earliest > crossing));
        counted.late += u32::from(life.latest.is_some_and(|latest| latest < crossing - 1.0));
        counted.open += u32::from(life.latest.is_none());
        counted.predicted += u32::from(life.estimate.is_some());
        counted.before_estimate += u32::from(life.estimate.is_some_and(|estimate| estimate > crossing));
    }
    counted
}

fn line(rate_mm: f64) -> impl FnMut(&mut Draws) -> Vec<f64> {
    move |_| (0..2000).map(|parts| 20.0 * UM + rate_mm * f64::from(parts)).collect()
}

/// Share of misses on either side that 95 % allows, with three standard deviations of 400 draws for luck.
const MOST_MISSED_A_SIDE: f64 = 0.025 + 3.0 * 0.0078;

#[test]
fn the_interval_of_straight_wear_holds_the_truth_nineteen_times_in_twenty() {
    for (count, scatter_um, limit_um) in
        [(4, 3.0, 50.0), (5, 1.0, 60.0), (8, 3.0, 80.0), (8, 6.0, 90.0), (15, 3.0, 130.0), (30, 2.0, 260.0)]
    {
        let counted = simulated(11, 400, count, scatter_um * UM, limit_um * UM, line(0.5 * UM));
        let share = |number: u32| f64::from(number) / f64::from(counted.tries);
        println!("{count} readings, scatter {scatter_um} µm, limit {limit_um} µm: {counted:?}");
        assert!(share(counted.early) <= MOST_MISSED_A_SIDE, "{count}: {counted:?}");
        assert!(share(counted.late) <= MOST_MISSED_A_SIDE, "{count}: {counted:?}");
        if count >= 8 && scatter_um < 5.0 {
            // Wide enough, and not so wide that nothing is said.
            assert!(share(counted.open) < 0.15, "{count}: {counted:?}");
            assert!(share(counted.predicted) > 0.9, "{count}: {counted:?}");
            let half = f64::from(counted.before_estimate) / f64::from(counted.predicted);
            assert!((0.35..0.65).contains(&half), "{count}: {counted:?}");
        }
    }
}

/// A rate that strays: each part adds to it, and it never falls below a tenth of its first value.
fn straying(rate_mm: f64, stray_mm: f64) -> impl FnMut(&mut Draws) -> Vec<f64> {
    move |draws| {
        let (mut wear, mut rate) = (20.0 * UM, rate_mm);
        let mut course = Vec::with_capacity(2000);
        for _ in 0..2000 {
            course.push(wear);
            wear += rate;
            rate = (rate + stray_mm * draws.normal()).max(0.1 * rate_mm);
        }
        course
    }
}

/// Share of misses where the rate strays by an amount that so few readings hardly show: found to be 7 to 17 per cent, and
/// told in docs/wear.md.
const MOST_MISSED_STRAYING: f64 = 0.2;

#[test]
fn the_interval_of_straying_wear_holds_the_truth_five_times_in_six() {
    for (count, stray_um) in [(8, 0.02), (15, 0.05), (15, 0.02), (30, 0.05)] {
        let counted = simulated(
            5,
            400,
            count,
            2.0 * UM,
            (30.0 + 7.0 * f64::from(count)) * UM,
            straying(0.5 * UM, stray_um * UM),
        );
        let share = |number: u32| f64::from(number) / f64::from(counted.tries);
        println!("{count} readings, rate straying {stray_um} µm a part: {counted:?}");
        assert!(share(counted.early + counted.late) <= MOST_MISSED_STRAYING, "{count}: {counted:?}");
    }
}

/// Wear that goes faster and faster is later than it thinks: the early end holds, the estimate does not.
#[test]
fn the_early_end_holds_where_wear_goes_faster_and_faster() {
    let accelerating = |_: &mut Draws| -> Vec<f64> {
        (0..2000)
            .map(|parts| (20.0 + 0.2 * f64::from(parts) + 0.002 * f64::from(parts).powi(2)) * UM)
            .collect()
    };
    let counted = simulated(3, 200, 12, 2.0 * UM, 100.0 * UM, accelerating);
    println!("accelerating: {counted:?}");
    assert!(f64::from(counted.early) <= MOST_MISSED_A_SIDE * 200.0, "{counted:?}");
    // Most estimates are late by then: the curve goes on turning.
    assert!(counted.before_estimate > counted.predicted / 2, "{counted:?}");
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
    assert!(now.chance_rising > 0.9999, "{now:?}");
    // 38 degrees of freedom: √(40/38) of 2 µm, or less where the rate takes some.
    assert!((1.8..2.06).contains(&(course.scatter_mm() / UM)), "{}", course.scatter_mm());
    for (k, fitted_mm) in (0_u32..).zip(course.fitted_mm()) {
        let wear = (10.0 + 0.4 * f64::from(5 * (k / 2))) * UM;
        assert!((fitted_mm - wear).abs() < 1e-8, "{k}: {fitted_mm}");
    }
    let life = cutter_life(&[&course], 90.0 * UM, 95);
    assert_eq!((life.kind, life.first_edge), (LifeKind::Predicted, Some(0)));
    assert!((life.estimate.unwrap() - 200.0).abs() < 1.0, "{life:?}");
    assert!(life.earliest.unwrap() < 199.0 && life.latest.unwrap() > 201.0, "{life:?}");
}

#[test]
fn an_exact_line_is_not_trusted_beyond_what_a_reading_resolves() {
    let readings: Vec<WearReading> = (0..6).map(|k| reading(10 * k, f64::from(10 * k) * 0.5 * UM)).collect();
    let course = WearCourse::of(&readings).unwrap();
    assert!((course.scatter_mm() - 0.3 * UM).abs() < 1e-9, "{}", course.scatter_mm());
    let life = cutter_life(&[&course], 40.0 * UM, 50);
    assert!((life.estimate.unwrap() - 80.0).abs() < 0.5, "{life:?}");
    assert!(life.earliest.unwrap() < 79.5 && life.latest.unwrap() > 80.5, "{life:?}");
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
    assert_eq!((life.kind, life.estimate, life.latest), (LifeKind::NoRise, None, None), "{life:?}");
    assert!(life.earliest.unwrap() > 90.0, "{life:?}");

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
    assert_eq!((both.estimate, both.latest), (alone(&fast).estimate, alone(&fast).latest));
    assert!(both.earliest <= alone(&fast).earliest && both.earliest < alone(&slow).earliest);
    let twins = cutter_life(&[&fast, &fast], 80.0 * UM, 110);
    assert!(twins.earliest < alone(&fast).earliest && twins.first_edge == Some(0));
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
    assert!((wide.scatter_mm() - 8.0 * UM).abs() < 1e-9, "{}", wide.scatter_mm());
    assert!(life(&wide).earliest < life(&unstated).earliest);
    // Good readings carry the course: here every third, which lie on the line.
    let weighed = with(&|k| Some(if k % 3 == 0 { 0.3 } else { 3.0 }));
    assert!((weighed.now().rate_mm_per_part - 0.5 * UM).abs() < 0.005 * UM, "{:?}", weighed.now());
    // One that states nothing makes all count alike.
    let mixed = with(&|k| (k > 0).then_some(0.3));
    assert_eq!(mixed.now(), unstated.now());
}
