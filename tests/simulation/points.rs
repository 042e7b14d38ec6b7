//! As many points as are asked for, by as many threads as there are processors.

use std::sync::Mutex;
use std::time::Instant;

use crate::disk::{Crash, Disk};
use crate::recorder::Op;
use crate::run::{Point, Run, alone, run};

/// Points where nothing else is asked for.
const POINTS: usize = 250;
/// Most points of one run: more runs see more than more points of one.
const POINTS_OF_A_RUN: usize = 2000;
/// Findings that are told.
const TOLD: usize = 12;

/// A number from the environment.
fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap())
}

/// What is wrong at points of one run, by all processors together; with `first` no more is looked at once something is.
pub(crate) fn wrong(run: &Run, points: &[Point], first: bool) -> Vec<(Point, String)> {
    // A point waits as long as it computes: for the threads of its database, and for its jobs.
    let threads = 4 * std::thread::available_parallelism().map_or(2, usize::from);
    let (sender, receiver) = std::sync::mpsc::sync_channel(2 * threads);
    let (receiver, found) = (Mutex::new(receiver), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let next = receiver.lock().unwrap().recv();
                    let Ok((point, tree)) = next else { break };
                    if first && !found.lock().unwrap().is_empty() {
                        continue;
                    }
                    let findings = run.look(point, &tree, None);
                    found.lock().unwrap().extend(findings.into_iter().map(|finding| (point, finding)));
                }
            });
        }
        run.each(points, |point, tree| sender.send((point, tree)).unwrap());
        drop(sender);
    });
    let mut found = found.into_inner().unwrap();
    found.sort();
    found
}

#[test]
fn whatever_breaks_at_whatever_write_nothing_that_was_answered_is_lost() {
    let _alone = alone();
    let wanted = setting("TRUNNION_SIMULATION_POINTS").map_or(POINTS, |points| points.try_into().unwrap());
    let first = setting("TRUNNION_SIMULATION_SEED").unwrap_or(1);
    let one = setting("TRUNNION_SIMULATION_POINT").map(|number| usize::try_from(number).unwrap());
    let (began, mut done, mut told, mut seed) = (Instant::now(), 0, Vec::new(), first);
    // Twelve runs at least, so that every kind of fault has one.
    let each = (wanted / 12).clamp(1, POINTS_OF_A_RUN);
    while done < wanted && told.len() < TOLD {
        let ran = run(seed);
        let points = match one {
            Some(number) => vec![Point {
                length: number / Crash::ALL.len(),
                crash: Crash::ALL[number % Crash::ALL.len()],
            }],
            None => ran.points(each.min(wanted - done)),
        };
        let found = wrong(&ran, &points, false);
        println!(
            "seed {seed}: {} writes and the like, {} requests, fault {:?}: {} points, {} findings, {:.1} s",
            ran.log.len(),
            ran.ledger.lines.len(),
            ran.fault,
            points.len(),
            found.len(),
            began.elapsed().as_secs_f64()
        );
        for (point, finding) in found {
            let number = point.length * Crash::ALL.len() + point.crash as usize;
            told.push(format!(
                "TRUNNION_SIMULATION_SEED={seed} TRUNNION_SIMULATION_POINT={number}: {:?} after {} of the log, {:?} last: {finding}",
                point.crash, point.length, ran.log.get(point.length.wrapping_sub(1)).map(short)
            ));
        }
        done += points.len();
        seed += 1;
        if one.is_some() {
            break;
        }
    }
    let took_s = began.elapsed().as_secs_f64();
    println!("{done} points from seed {first} on in {took_s:.1} s, {:.0} a second", done as f64 / took_s);
    told.truncate(TOLD);
    assert!(told.is_empty(), "{}", told.join("\n"));
}

/// An entry of the log without its bytes.
pub(crate) fn short(op: &Op) -> String {
    let mut text = format!("{op:?}");
    text.truncate(110);
    text
}

#[test]
fn the_log_played_again_gives_the_files_that_stand_on_the_disk() {
    let _alone = alone();
    for seed in [5, 1, 3] {
        let ran = run(seed);
        let mut disk = Disk::holding(&ran.base);
        ran.log.iter().for_each(|op| disk.step(op));
        let held = disk.held();
        let differs: Vec<_> =
            held.keys().chain(ran.end.keys()).filter(|path| held.get(*path) != ran.end.get(*path)).collect();
        assert!(differs.is_empty(), "seed {seed}: {differs:?}");
    }
}

#[test]
fn a_seed_does_the_same_to_the_byte() {
    let _alone = alone();
    // The first seed alone takes a minute on a slow computer.
    let is_thorough = std::env::var_os("TRUNNION_THOROUGH_TESTS").is_some();
    for seed in [2, 5, 9].into_iter().take(if is_thorough { 3 } else { 1 }) {
        let (one, other) = (run(seed), run(seed));
        for (at, (left, right)) in one.log.iter().zip(&other.log).enumerate() {
            if left != right && !format!("{left:?}").contains("spool/") {
                let around = at.saturating_sub(4)..(at + 5).min(one.log.len()).min(other.log.len());
                for at in around {
                    println!(
                        "seed {seed} at {at}:\n    {}\n    {}",
                        short(&one.log[at]),
                        short(&other.log[at])
                    );
                }
                let asked = one.ledger.lines.iter().rfind(|line| line.sent <= at);
                println!("{asked:?}");
                for at in at..(at + 2).min(one.log.len()) {
                    if let (Op::Write { bytes: left, .. }, Op::Write { bytes: right, .. }) =
                        (&one.log[at], &other.log[at])
                    {
                        let first = left
                            .iter()
                            .zip(right.iter())
                            .position(|(left, right)| left != right)
                            .unwrap_or(0);
                        let part = first.saturating_sub(40)..(first + 60);
                        let text = |bytes: &[u8]| {
                            String::from_utf8_lossy(&bytes[part.start..part.end.min(bytes.len())])
                                .into_owned()
                        };
                        println!("{:?}\n{:?}", text(left), text(right));
                    }
                }
                break;
            }
        }
        assert_eq!((one.log.len(), one.digest()), (other.log.len(), other.digest()), "seed {seed}");
    }
}
