//! One run of a seed, and the points of it: a crash after one of its writes, opened again and looked at.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, MutexGuard, Once, PoisonError};

use sha2::{Digest, Sha256};

use crate::chance::Chance;
use crate::disk::{Crash, Disk, Tree};
use crate::interpose::{forget_randomness_of_sqlite, sqlite_counts_no_memory};
use crate::ledger::Ledger;
use crate::recorder::{self, Fault, Illness, Op, tree};
use crate::verify::{Findings, Meddle, look};
use crate::workload::Clients;
use crate::world::folder;

/// Requests of a run.
const REQUESTS: usize = 36;
/// Seed of the folder that most runs begin with.
const BASE: u64 = 0;

/// What a seed did.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) seed: u64,
    pub(crate) fault: Option<Fault>,
    pub(crate) base: Arc<Tree>,
    pub(crate) log: Vec<Op>,
    pub(crate) ledger: Ledger,
    /// What stood on the disk when the run was over.
    pub(crate) end: Tree,
}

/// A crash of a run: its log was so long.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Point {
    pub(crate) length: usize,
    pub(crate) crash: Crash,
}

/// Clock, randomness and recorder are the process' own: one test uses them at a time.
static ALONE: Mutex<()> = Mutex::new(());

/// Held by a test as long as it runs.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static PREPARED: Once = Once::new();
    PREPARED.call_once(sqlite_counts_no_memory);
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(crate) fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

/// Writes a tree into an empty folder.
pub(crate) fn write_out(tree: &Tree, into: &Path) {
    for (path, bytes) in tree {
        match bytes {
            None => fs::create_dir(into.join(path)).unwrap(),
            Some(bytes) => fs::write(into.join(path), bytes).unwrap(),
        }
    }
}

/// A folder that was served from, stopped, and has one key.
static BEGUN: LazyLock<(Arc<Tree>, Ledger)> = LazyLock::new(|| {
    let Run { end, mut ledger, .. } = recorded(BASE, None, &Arc::default(), None, 0);
    for line in &mut ledger.lines {
        (line.sent, line.answered) = (0, line.answered.map(|_| 0));
    }
    (Arc::new(end), ledger)
});

/// The fault that a seed has while it runs: two in three have none.
fn fault_of(seed: u64, calls: usize) -> Option<Fault> {
    let mut chance = Chance::of(seed, 4);
    if !seed.is_multiple_of(3) {
        return None;
    }
    let illness = *chance.pick(&[
        Illness::Full,
        Illness::Writing,
        Illness::Synchronising,
        Illness::Interrupted,
        Illness::Short,
        Illness::Slow,
    ]);
    Some(Fault { illness, at: chance.below(calls), calls: 1 + chance.below(12) })
}

/// Runs a seed: one in five on a folder that was never served from, the others on one that was.
pub(crate) fn run(seed: u64) -> Run {
    if seed.is_multiple_of(5) {
        return recorded(seed, None, &Arc::default(), None, REQUESTS / 2);
    }
    let (base, known) = &*BEGUN;
    recorded(seed, fault_of(seed, 400), base, Some(known), REQUESTS)
}

/// A folder that was served from, stopped, and has one key, and what was answered of it.
pub(crate) fn begun() -> (&'static Arc<Tree>, &'static Ledger) {
    let (base, known) = &*BEGUN;
    (base, known)
}

/// Runs a seed on a folder that is like the one that was served from.
pub(crate) fn run_on(seed: u64, base: &Arc<Tree>, known: &Ledger) -> Run {
    recorded(seed, None, base, Some(known), REQUESTS)
}

fn recorded(
    seed: u64,
    fault: Option<Fault>,
    base: &Arc<Tree>,
    known: Option<&Ledger>,
    requests: usize,
) -> Run {
    let place = folder();
    let data = place.path().join("data");
    fs::create_dir(&data).unwrap();
    write_out(base, &data);
    forget_randomness_of_sqlite();
    recorder::begin(&data, seed, fault);
    let runtime = runtime();
    let mut ledger = runtime.block_on(async {
        let mut clients = Clients::of(&data, seed, known).await;
        if known.is_none() {
            clients.close_the_service().await;
        }
        clients.work(requests).await;
        clients.finish().await
    });
    drop(runtime);
    ledger.ill = fault.is_some();
    let log = recorder::end();
    let end = tree(&data);
    let base = Arc::clone(base);
    Run { seed, fault, base, log, ledger, end }
}

impl Run {
    /// The digest of everything that was done, in which drafts have the names of the order they came in.
    pub(crate) fn digest(&self) -> String {
        let mut names: Vec<String> = Vec::new();
        let mut plain = |path: &str| {
            if !path.starts_with("spool/") {
                return path.to_owned();
            }
            let at = names.iter().position(|known| known == path).unwrap_or_else(|| {
                names.push(path.to_owned());
                names.len() - 1
            });
            format!("spool/{at}")
        };
        let mut hasher = Sha256::new();
        for op in &self.log {
            let line = match op {
                Op::Create { node, path } => format!("create {node} {}", plain(path)),
                Op::Folder { node, path } => format!("folder {node} {}", plain(path)),
                Op::Rename { from, to } => format!("rename {} {}", plain(from), plain(to)),
                Op::Remove { path } => format!("remove {}", plain(path)),
                other => format!("{other:?}"),
            };
            hasher.update(line.as_bytes());
        }
        trunnion::store::sha256_hex(&hasher.finalize())
    }

    /// So many of its points, or all there are, in the order of the log.
    pub(crate) fn points(&self, wanted: usize) -> Vec<Point> {
        let all = (self.log.len() + 1) * Crash::ALL.len();
        let point = |number: usize| Point {
            length: number / Crash::ALL.len(),
            crash: Crash::ALL[number % Crash::ALL.len()],
        };
        if wanted >= all {
            return (0..all).map(point).collect();
        }
        let (mut chance, mut chosen) = (Chance::of(self.seed, 5), BTreeSet::new());
        while chosen.len() < wanted {
            chosen.insert(chance.below(all));
        }
        chosen.into_iter().map(point).collect()
    }

    /// The disk after each of these points, one after the other.
    pub(crate) fn each(&self, points: &[Point], mut take: impl FnMut(Point, Tree)) {
        let (mut disk, mut done) = (Disk::holding(&self.base), 0);
        for point in points {
            while done < point.length {
                disk.step(&self.log[done]);
                done += 1;
            }
            let salt = 1000 + (point.length * Crash::ALL.len()) as u64 + point.crash as u64;
            let luck = &mut Chance::of(self.seed, salt);
            take(*point, disk.after(point.crash, luck));
        }
    }

    /// Opens what a point left and says what does not hold.
    pub(crate) fn look(&self, point: Point, tree: &Tree, meddle: Option<Meddle<'_>>) -> Findings {
        let place = folder();
        write_out(tree, place.path());
        let runtime = runtime();
        let findings = runtime.block_on(look(place.path(), &self.ledger, point.length, meddle));
        runtime.shutdown_background();
        findings
    }
}
