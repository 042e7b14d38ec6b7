//! Predictions made in the middle of a real cutter's life, against what became of it: flank wear of the three flutes
//! of a 6 mm ball over 315 cuts (data/INDEX.md). The published curves are smooth and have two plateaus and a rapid
//! end.

use trunnion::wear::{LifeKind, WearCourse, WearReading, cutter_life};

use crate::shared_file;
use crate::wear_back_test_model::{Draws, Microscope, Tallies, Trial, UM};

const LIMITS_UM: [f64; 5] = [80.0, 100.0, 120.0, 150.0, 180.0];

/// Wear of the three flutes after each cut [µm].
fn flutes() -> Option<[Vec<f64>; 3]> {
    let path = shared_file("data/phm2010_c4_flank_wear_um.csv")?;
    let text = std::fs::read_to_string(path).expect("the record");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').skip(1).map(|word| word.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 315);
    Some([0, 1, 2].map(|flute| rows.iter().map(|row| row[flute]).collect()))
}

/// The cut after which the wear is at the limit.
fn reached(wear_um: &[f64], limit_um: f64) -> usize {
    1 + wear_um.iter().position(|wear| *wear >= limit_um).expect("a limit that is reached")
}

/// Predictions for each flute and limit.
const PREDICTIONS: u32 = 60;

/// Held out: whatever comes after the newest reading. Each prediction is made at any cut before the limit, from 4 to
/// 40 readings at uneven places back to the first cut or to any later one, as published or with 0.5 to 5 µm of
/// scatter, whose errors hang together by up to 0.7 in half of them. The predictions share three curves of one
/// cutter, so that they are fewer than they seem; the bound takes them as independent, which makes it the stricter
/// one.
#[test]
fn both_ends_hold_at_any_cut_of_a_real_life() {
    let Some(flutes) = flutes() else { return };
    let mut draws = Draws(5);
    let mut all = Tallies::default();
    println!("| flute | holds | early misses | late misses of those told | to early end | width |");
    for (flute, wear_um) in flutes.iter().enumerate() {
        let mut tallies = Tallies::default();
        for limit_um in LIMITS_UM {
            let truth = reached(wear_um, limit_um);
            for _ in 0..PREDICTIONS {
                if let Some(readings) = held_out(wear_um, truth, limit_um, &mut draws) {
                    // The limit was reached within the cut before.
                    tallies.add(&Trial { readings, limit_um, truth: truth as f64 - 0.5 });
                }
            }
        }
        println!("| {} | {}", flute + 1, tallies.whole.row());
        println!("| {}, same stage | {}", flute + 1, tallies.same_stage.row());
        all.join(&tallies);
    }
    println!("| all | {}", all.whole.row());
    println!("| all, same stage | {}", all.same_stage.row());
    assert!(all.whole.tries > 700, "{}", all.whole.row());
    assert!(all.whole.holds(), "{}", all.whole.row());
    // Late ends that are told: fewer than on simulated wear, since this cutter stands still half of its life.
    assert!(all.whole.told_share() > 0.1, "{}", all.whole.row());
    // The interval that knows of no stages does not hold here, and the back-test sees it.
    assert!(!all.same_stage.holds(), "{}", all.same_stage.row());
}

/// Readings of a flute up to a cut before the limit is reached; none where they are too few or at the limit by their
/// scatter.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cuts")]
fn held_out(wear_um: &[f64], truth: usize, limit_um: f64, draws: &mut Draws) -> Option<Vec<WearReading>> {
    let now = (truth as f64 * draws.between(0.05, 0.98)) as usize;
    let step = (now as f64 / draws.ratio(4.0, 40.0)).max(1.0);
    let scatter_um = if draws.uniform() < 0.3 { 0.0 } else { draws.ratio(0.5, 5.0) };
    let correlation = if draws.uniform() < 0.5 { 0.0 } else { draws.between(0.0, 0.7) };
    let from = if draws.uniform() < 0.6 { 1.0 } else { 1.0 + draws.between(0.0, 0.6) * now as f64 };
    let mut cuts = vec![now];
    let mut place = now as f64;
    loop {
        place -= (step * draws.between(0.4, 1.6)).max(1.0);
        if place < from {
            break;
        }
        cuts.push(place as usize);
    }
    cuts.dedup();
    cuts.reverse();
    let mut microscope = Microscope::new(scatter_um, correlation, draws);
    let readings: Vec<WearReading> = cuts
        .iter()
        .filter(|cut| **cut > 0)
        .map(|cut| microscope.read(*cut, wear_um[cut - 1], draws))
        .collect();
    let is_below = readings.last().is_some_and(|newest| newest.wear_mm < limit_um * UM);
    (readings.len() >= 4 && is_below).then_some(readings)
}

/// Shares of the life at which predictions are made [per cent].
const SHARES: [usize; 4] = [25, 50, 75, 90];

fn middle(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// An entry every ten cuts, as published: what is told at a share of the life that is to come out, for limits of 100
/// to 180 µm.
#[test]
fn near_the_end_of_a_real_life_it_is_told() {
    let Some(flutes) = flutes() else { return };
    println!(
        "| at | early misses | late misses | estimates | late ends | early end / truth | estimate / truth |"
    );
    for share in SHARES {
        let mut tallies = Tallies::default();
        let (mut earliest, mut estimates) = (Vec::new(), Vec::new());
        for limit_um in &LIMITS_UM[1..] {
            for wear_um in &flutes {
                let truth = reached(wear_um, *limit_um);
                let now = share * truth / 100;
                // Counted back from now: the newest entry is fresh.
                let cuts = (1..=now).filter(|cut| (now - cut).is_multiple_of(10));
                let readings: Vec<WearReading> = cuts
                    .map(|cut| WearReading {
                        parts_cut: u32::try_from(cut).unwrap(),
                        wear_mm: wear_um[cut - 1] * UM,
                        standard_uncertainty_mm: None,
                    })
                    .collect();
                let truth = truth as f64;
                let life = tallies.add(&Trial { readings, limit_um: *limit_um, truth: truth - 0.5 });
                assert_eq!(life.estimate.is_some(), life.kind == LifeKind::Predicted);
                estimates.extend(life.estimate.map(|estimate| estimate / truth));
                earliest.extend(life.ends.earliest.map(|earliest| earliest / truth));
            }
        }
        let whole = &tallies.whole;
        println!(
            "| {share} % | {} of {} | {} | {} | {} | {:.2} | {:.2} |",
            whole.early,
            whole.tries,
            whole.late,
            estimates.len(),
            whole.told,
            middle(&earliest),
            middle(&estimates)
        );
        assert_eq!((whole.early, whole.late), (0, 0), "{share}: {}", whole.row());
        if share == 90 {
            // Near the end the rapid stage is seen.
            assert!((0.95..1.1).contains(&middle(&estimates)), "{estimates:?}");
            assert!(middle(&earliest) > 0.9, "{earliest:?}");
        }
    }
}

/// The three flutes as one cutter, an entry every ten cuts, limit 150 µm: what a shop would have been told.
#[test]
fn the_worst_flute_governs_a_real_cutter() {
    let Some(flutes) = flutes() else { return };
    let limit_um = 150.0;
    let truth = flutes.iter().map(|wear_um| reached(wear_um, limit_um)).min().unwrap();
    for now in [66_u32, 133, 200, 210, 220, 230, 240, 250, 260] {
        let courses: Vec<WearCourse> = flutes
            .iter()
            .map(|wear_um| {
                let readings: Vec<WearReading> = (1..=now)
                    .filter(|cut| (now - cut).is_multiple_of(10))
                    .map(|cut| WearReading {
                        parts_cut: cut,
                        wear_mm: wear_um[cut as usize - 1] * UM,
                        standard_uncertainty_mm: None,
                    })
                    .collect();
                WearCourse::of(&readings).unwrap()
            })
            .collect();
        let life = cutter_life(&courses.iter().collect::<Vec<_>>(), limit_um * UM, now);
        println!(
            "at {now} (truth {truth}): {:?} {:?} {:?}; same stage {:?}",
            life.kind, life.ends, life.estimate, life.same_stage
        );
        assert!(life.ends.earliest.unwrap() <= truth as f64, "{now}: {life:?}");
        assert!(life.ends.latest.is_none_or(|latest| latest >= truth as f64 - 1.0), "{now}: {life:?}");
    }
}
