//! Predictions made in the middle of a real cutter's life, against what became of it: flank wear of the three flutes of a
//! 6 mm ball over 315 cuts (data/INDEX.md). The published curves are smooth and have two plateaus and a rapid end.

use trunnion::wear::{LifeKind, WearCourse, WearReading, cutter_life};

use crate::shared_file;

const UM: f64 = 1e-3;
/// Scatter put on the smooth curves, as a microscope's reading has it [µm].
const SCATTER_UM: f64 = 3.0;
const LIMITS_UM: [f64; 4] = [100.0, 120.0, 150.0, 180.0];
/// Shares of the life at which predictions are made [per cent].
const SHARES: [usize; 4] = [25, 50, 75, 90];

/// Wear of the three flutes after each cut [µm].
fn flutes(text: &str) -> Vec<[f64; 3]> {
    text.lines()
        .skip(1)
        .map(|line| {
            let numbers: Vec<f64> =
                line.split(',').skip(1).map(|word| word.parse().expect("a number")).collect();
            [numbers[0], numbers[1], numbers[2]]
        })
        .collect()
}

/// Scatter that is the same everywhere: the sum of twelve uniform numbers.
fn scatter(state: &mut u64) -> f64 {
    let mut sum = -6.0;
    for _ in 0..12 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (*state >> 11) as f64 / (1_u64 << 53) as f64;
    }
    sum
}

/// What was told at a share of the lives.
#[derive(Debug, Default, Clone)]
struct Told {
    tries: u32,
    early: u32,
    late: u32,
    open: u32,
    /// Estimate over the truth.
    ratios: Vec<f64>,
    /// Early end over the truth.
    early_ratios: Vec<f64>,
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[test]
fn predictions_in_the_middle_of_a_real_life_hold_the_truth() {
    let Some(path) = shared_file("data/phm2010_c4_flank_wear_um.csv") else { return };
    let wear_um = flutes(&std::fs::read_to_string(path).unwrap());
    assert_eq!(wear_um.len(), 315);
    let mut state = 7;
    let mut misses = (0, 0, 0);
    println!(
        "| every | scatter | at | early miss | late miss | no estimate | no late end | early end / truth | estimate / truth |"
    );
    for every in [5_usize, 10, 20] {
        for scatter_um in [0.0, SCATTER_UM] {
            for share in SHARES {
                let mut told = Told::default();
                for limit_um in LIMITS_UM {
                    for flute in 0..3 {
                        let truth = 1 + wear_um.iter().position(|wear| wear[flute] >= limit_um).unwrap();
                        let now = share * truth / 100;
                        // Counted back from now: the newest entry is fresh.
                        let cuts: Vec<usize> =
                            (1..=now).filter(|cut| (now - cut).is_multiple_of(every)).collect();
                        let readings: Vec<WearReading> = cuts
                            .iter()
                            .map(|cut| WearReading {
                                parts_cut: u32::try_from(*cut).unwrap(),
                                wear_mm: (wear_um[cut - 1][flute] + scatter_um * scatter(&mut state))
                                    .max(0.0)
                                    * UM,
                                standard_uncertainty_mm: None,
                            })
                            .collect();
                        let Ok(course) = WearCourse::of(&readings) else { continue };
                        let life = cutter_life(&[&course], limit_um * UM, u32::try_from(now).unwrap());
                        let truth = truth as f64;
                        told.tries += 1;
                        let is_early = life.earliest.is_none_or(|earliest| earliest > truth);
                        told.early += u32::from(is_early);
                        if is_early {
                            let limit = format!("{limit_um} µm, flute {}", flute + 1);
                            println!("missed: {limit} at {now}: {:?} for {truth}", life.earliest);
                        }
                        // The limit was reached within the cut before.
                        told.late += u32::from(life.latest.is_some_and(|latest| latest < truth - 1.0));
                        told.open += u32::from(life.latest.is_none());
                        told.ratios.extend(life.estimate.map(|estimate| estimate / truth));
                        told.early_ratios.extend(life.earliest.map(|earliest| earliest / truth));
                        assert_eq!(life.estimate.is_some(), life.kind == LifeKind::Predicted);
                    }
                }
                misses = (misses.0 + told.tries, misses.1 + told.early, misses.2 + told.late);
                println!(
                    "| {every} | {scatter_um} | {share} % | {} of {} | {} | {} | {} | {:.2} | {:.2} |",
                    told.early,
                    told.tries,
                    told.late,
                    told.tries as usize - told.ratios.len(),
                    told.open,
                    middle(told.early_ratios.clone()),
                    middle(told.ratios.clone())
                );
                if share == 90 && every <= 10 {
                    // Near the end the rapid stage is seen.
                    assert!((0.95..1.1).contains(&middle(told.ratios.clone())), "{told:?}");
                    assert!(middle(told.early_ratios.clone()) > 0.9, "{told:?}");
                }
            }
        }
    }
    println!("of {} predictions {} were early, {} late", misses.0, misses.1, misses.2);
    let share = f64::from(misses.1 + misses.2) / f64::from(misses.0);
    assert!(misses.0 > 250 && share <= 0.1, "{misses:?}");
}

/// The three flutes as one cutter, an entry every ten cuts, limit 150 µm: what a shop would have been told.
#[test]
fn the_worst_flute_governs_a_real_cutter() {
    let Some(path) = shared_file("data/phm2010_c4_flank_wear_um.csv") else { return };
    let wear_um = flutes(&std::fs::read_to_string(path).unwrap());
    let limit_um = 150.0;
    let truth = 1 + wear_um.iter().position(|wear| wear.iter().any(|wear| *wear >= limit_um)).unwrap();
    for now in [66_u32, 133, 200, 210, 220, 230, 240, 250, 260] {
        let courses: Vec<WearCourse> = (0..3)
            .map(|flute| {
                let readings: Vec<WearReading> = (1..=now)
                    .filter(|cut| (now - cut).is_multiple_of(10))
                    .map(|cut| WearReading {
                        parts_cut: cut,
                        wear_mm: wear_um[cut as usize - 1][flute] * UM,
                        standard_uncertainty_mm: None,
                    })
                    .collect();
                WearCourse::of(&readings).unwrap()
            })
            .collect();
        let life = cutter_life(&courses.iter().collect::<Vec<_>>(), limit_um * UM, now);
        println!(
            "at {now} (truth {truth}): {:?} {:?} {:?} {:?}",
            life.kind, life.earliest, life.estimate, life.latest
        );
        assert!(life.earliest.unwrap() <= truth as f64, "{now}: {life:?}");
        assert!(life.latest.is_none_or(|latest| latest >= truth as f64 - 1.0), "{now}: {life:?}");
    }
}
