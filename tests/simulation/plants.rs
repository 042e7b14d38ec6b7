//! Faults that the service does not have, planted one at a time: each must be found by the same look that finds nothing
//! without them.
//!
//! A fault of the order of writes is planted into the log, as a service that had it would have written that log. A
//! fault of what is stored is planted as a trigger of the database that the run begins with, so that every write of
//! the real service does it.

use std::collections::BTreeMap;
use std::sync::Arc;

use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{AssertSqlSafe, ConnectOptions, Connection};
use trunnion::store::DATABASE_NAME;

use crate::chance::Chance;
use crate::points::wrong;
use crate::recorder::{Node, Op, tree};
use crate::run::{Point, Run, alone, begun, run, run_on, runtime, write_out};
use crate::world::folder;

/// Runs without a fault of the disk in which a fault is looked for; the second and the last but one begin with an
/// empty folder.
const SEEDS: [u64; 8] = [1, 5, 2, 4, 7, 8, 10, 11];
/// Points of each.
const POINTS: usize = 96;
/// Points looked at before it is asked whether the fault is found.
const AT_ONCE: usize = 16;

enum Plant {
    /// Changes the log, or when answers came.
    Log(fn(&mut Run)),
    /// Changes the database that the run begins with.
    Database(&'static [&'static str]),
}

/// What a node was called first.
fn first_names(run: &Run) -> BTreeMap<Node, String> {
    let mut names = BTreeMap::from([(0, String::new())]);
    names.extend((1..).zip(run.base.keys().cloned()));
    for op in &run.log {
        if let Op::Create { node, path } | Op::Folder { node, path } = op {
            names.insert(*node, path.clone());
        }
    }
    names
}

/// Leaves out every synchronisation of what is called so.
fn without_sync(run: &mut Run, of: impl Fn(&str) -> bool) {
    let names = first_names(run);
    for op in &mut run.log {
        if matches!(op, Op::Sync { node } if of(&names[node])) {
            *op = Op::Nothing;
        }
    }
}

fn is_folder_of_files(path: &str) -> bool {
    path.strip_prefix("blobs/").is_some_and(|rest| rest.len() == 2)
}

fn is_log(path: &str) -> bool {
    path.ends_with("-wal")
}

/// Moves what `which` picks to behind the next synchronisation of the write-ahead log.
fn behind_the_row(run: &mut Run, which: impl Fn(&Op, &BTreeMap<Node, String>) -> bool) {
    let names = first_names(run);
    for at in 0..run.log.len() {
        if !which(&run.log[at], &names) {
            continue;
        }
        let row = (at..run.log.len())
            .find(|row| matches!(&run.log[*row], Op::Sync { node } if is_log(&names[node])));
        if let Some(row) = row {
            run.log[at..=row].rotate_left(1);
        }
    }
}

/// Puts an entry into the log; what was answered later was answered with it.
fn insert(run: &mut Run, at: usize, op: Op) {
    run.log.insert(at, op);
    for line in &mut run.ledger.lines {
        line.sent += usize::from(line.sent >= at);
        line.answered = line.answered.map(|answered| answered + usize::from(answered >= at));
    }
    run.ledger.forgets_from = run.ledger.forgets_from.map(|from| from + usize::from(from >= at));
}

const PLANTS: [(&str, Plant); 25] = [
    (
        "the fsync of a file that is kept is left out",
        Plant::Log(|run| without_sync(run, |path| path.starts_with("spool/"))),
    ),
    (
        "the fsync of the folder that a file is kept in is left out",
        Plant::Log(|run| without_sync(run, is_folder_of_files)),
    ),
    (
        "the fsync of the folder of folders is left out",
        Plant::Log(|run| without_sync(run, |path| path == "blobs")),
    ),
    ("the fsync of the data directory is left out", Plant::Log(|run| without_sync(run, str::is_empty))),
    ("the fsync of the write-ahead log is left out", Plant::Log(|run| without_sync(run, is_log))),
    (
        "the write-ahead log is removed before its pages are in the database",
        Plant::Log(|run| {
            let names = first_names(run);
            let is_of = |op: &Op, which: fn(&str) -> bool| matches!(op, Op::Write { node, .. } if which(&names[node]));
            for at in 0..run.log.len() {
                if !matches!(&run.log[at], Op::Remove { path } if is_log(path)) {
                    continue;
                }
                let logged = (0..at).rev().find(|before| is_of(&run.log[*before], is_log)).unwrap_or(0);
                let pages = (logged..at).find(|after| is_of(&run.log[*after], |path| path == DATABASE_NAME));
                if let Some(pages) = pages {
                    run.log[pages..=at].rotate_right(1);
                }
            }
        }),
    ),
    (
        "the fsync of the database is left out",
        Plant::Log(|run| without_sync(run, |path| path == DATABASE_NAME)),
    ),
    (
        "a file is synchronised after the row that names it",
        Plant::Log(|run| {
            behind_the_row(
                run,
                |op, names| matches!(op, Op::Sync { node } if names[node].starts_with("spool/")),
            );
        }),
    ),
    (
        "a file gets its name after the row that names it",
        Plant::Log(|run| {
            behind_the_row(run, |op, _| matches!(op, Op::Rename { from, .. } if from.starts_with("spool/")));
        }),
    ),
    (
        "the last write of a transaction comes after its fsync",
        Plant::Log(|run| {
            let names = first_names(run);
            for at in 1..run.log.len() {
                let is_sync = matches!(&run.log[at], Op::Sync { node } if is_log(&names[node]));
                if is_sync && matches!(&run.log[at - 1], Op::Write { .. }) {
                    run.log.swap(at - 1, at);
                }
            }
        }),
    ),
    (
        "a request is answered before anything is written",
        Plant::Log(|run| {
            for line in &mut run.ledger.lines {
                line.answered = line.answered.map(|_| line.sent);
            }
        }),
    ),
    (
        "a request is answered before its transaction is synchronised",
        Plant::Log(|run| {
            let names = first_names(run);
            for line in &mut run.ledger.lines {
                let Some(answered) = line.answered else { continue };
                let last = (line.sent..answered)
                    .rev()
                    .find(|at| matches!(&run.log[*at], Op::Sync { node } if is_log(&names[node])));
                line.answered = Some(last.unwrap_or(answered));
            }
        }),
    ),
    (
        "files that rows name are removed",
        Plant::Log(|run| {
            let names = first_names(run);
            let kept = run.log.iter().enumerate().find_map(|(at, op)| match op {
                Op::Rename { to, .. } if to.starts_with("blobs/") => Some((at, to.clone())),
                _ => None,
            });
            let Some((at, path)) = kept else { return };
            let row = (at..run.log.len())
                .find(|row| matches!(&run.log[*row], Op::Sync { node } if is_log(&names[node])));
            insert(run, row.unwrap_or(at) + 1, Op::Remove { path });
        }),
    ),
    (
        "a change is not in the audit log",
        Plant::Database(&[
            "DROP TRIGGER audit_never_goes",
            "CREATE TRIGGER plant AFTER INSERT ON audit WHEN NEW.action = 'wear-entries-created'
             BEGIN DELETE FROM audit WHERE seq = NEW.seq; END",
        ]),
    ),
    (
        "a change is in the audit log twice",
        Plant::Database(&["CREATE TRIGGER plant AFTER INSERT ON audit WHEN NEW.action = 'job-created'
             BEGIN INSERT INTO audit (at, origin, action, machine_id, resource)
                   VALUES (NEW.at, NEW.origin, NEW.action, NEW.machine_id, NEW.resource); END"]),
    ),
    (
        "a key comes to allow more than was answered",
        Plant::Database(&[
            "DROP TRIGGER api_keys_allow_what_they_allowed",
            "CREATE TRIGGER plant AFTER INSERT ON jobs
             BEGIN UPDATE api_keys SET scopes = '[\"admin\",\"read\"]' WHERE scopes = '[\"read\"]'; END",
        ]),
    ),
    (
        "a revoked key opens the service again",
        Plant::Database(&[
            "DROP TRIGGER api_keys_stay_revoked",
            "CREATE TRIGGER plant AFTER INSERT ON jobs BEGIN UPDATE api_keys SET revoked_at = NULL; END",
        ]),
    ),
    ("the end of a job is told to nobody", Plant::Database(&["DROP TRIGGER jobs_are_told"])),
    (
        "an idempotency key is forgotten at once",
        Plant::Database(&[
            "CREATE TRIGGER plant AFTER INSERT ON idempotency_keys WHEN NEW.job_id IS NOT NULL
             BEGIN DELETE FROM idempotency_keys WHERE idempotency_key = NEW.idempotency_key; END",
        ]),
    ),
    (
        "an idempotency key stands for another job",
        Plant::Database(&[
            "CREATE TRIGGER plant AFTER INSERT ON idempotency_keys WHEN NEW.job_id IS NOT NULL
             BEGIN UPDATE idempotency_keys SET job_id = (SELECT id FROM jobs ORDER BY seq LIMIT 1)
                   WHERE idempotency_key = NEW.idempotency_key; END",
        ]),
    ),
    (
        "a job ends twice",
        Plant::Database(&[
            "DROP TRIGGER jobs_end_once",
            "CREATE TRIGGER plant AFTER INSERT ON jobs
             BEGIN UPDATE jobs SET finished_at = NEW.created_at WHERE state = 'succeeded'; END",
        ]),
    ),
    (
        "the lease of a job is not checked, and another ends it",
        Plant::Database(&["CREATE TRIGGER plant AFTER UPDATE OF lease ON jobs WHEN NEW.state = 'running'
             BEGIN UPDATE jobs SET state = 'failed', problem = '{\"detail\":\"another holder\"}',
                       finished_at = NEW.started_at, lease = NULL WHERE id = NEW.id; END"]),
    ),
    (
        "jobs of a process that died are not taken up",
        Plant::Database(&["CREATE TRIGGER plant BEFORE UPDATE OF state ON jobs
             WHEN OLD.state = 'running' AND NEW.state = 'queued' AND NEW.attempts = OLD.attempts
             BEGIN SELECT RAISE (IGNORE); END"]),
    ),
    (
        "a cancelled job is computed all the same",
        Plant::Database(&[
            "CREATE TRIGGER plant AFTER UPDATE OF cancel_requested ON jobs WHEN NEW.cancel_requested = 1
             AND NEW.state = 'running' BEGIN UPDATE jobs SET cancel_requested = 0 WHERE id = NEW.id; END",
        ]),
    ),
    (
        "the last revision of a machine is taken back",
        Plant::Database(&["CREATE TRIGGER plant AFTER INSERT ON jobs
             BEGIN UPDATE machines SET last_revision = last_revision - 1 WHERE last_revision > 1; END"]),
    ),
];

/// A run with a fault in it.
fn planted(plant: &Plant, seed: u64) -> Run {
    match plant {
        Plant::Log(change) => {
            let mut run = run(seed);
            change(&mut run);
            run
        }
        Plant::Database(statements) => {
            let place = folder();
            let (base, known) = begun();
            write_out(base, place.path());
            runtime().block_on(async {
                let options = SqliteConnectOptions::new().filename(place.path().join(DATABASE_NAME));
                let mut database = options.connect().await.unwrap();
                for statement in *statements {
                    sqlx::query(AssertSqlSafe(*statement)).execute(&mut database).await.unwrap();
                }
                database.close().await.unwrap();
            });
            run_on(seed, &Arc::new(tree(place.path())), known)
        }
    }
}

/// Every second one is planted; `TRUNNION_THOROUGH_TESTS=1` plants all.
#[test]
fn every_planted_fault_is_found() {
    let _alone = alone();
    // All of them take a minute and a half on a slow computer.
    let is_thorough = std::env::var_os("TRUNNION_THOROUGH_TESTS").is_some();
    let mut missed = Vec::new();
    for (name, plant) in PLANTS.iter().step_by(if is_thorough { 1 } else { 4 }) {
        let (mut looked, mut found) = (0, None);
        for seed in SEEDS {
            let run = planted(plant, seed);
            let mut points = run.points(POINTS);
            // In any order, so that a fault which needs a long log is met as soon as another.
            let mut chance = Chance::of(seed, 8);
            while !points.is_empty() && found.is_none() {
                let mut some: Vec<Point> = (0..AT_ONCE.min(points.len()))
                    .map(|_| points.swap_remove(chance.below(points.len())))
                    .collect();
                some.sort_unstable();
                looked += some.len();
                found = wrong(&run, &some, true)
                    .into_iter()
                    .next()
                    .map(|(point, finding)| (seed, point, finding));
            }
            if found.is_some() {
                break;
            }
        }
        match found {
            Some((seed, point, finding)) => {
                println!("{name}: within {looked} points (seed {seed}, {point:?}): {finding}");
            }
            None => missed.push(*name),
        }
    }
    assert!(missed.is_empty(), "not found: {missed:#?}");
    assert!(PLANTS.len() >= 20);
}
