//! Machines in memory, so that a small computation does not wait for the database. A machine is taken from here only
//! if nothing was written since it was read.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

use foldhash::fast::RandomState;

use crate::jobs::MachineUsed;

/// Largest number of machines held.
const MOST: usize = 256;

/// How long a machine is trusted without asking the database. Writes of this process are seen at once; this time is
/// for changes that come in any other way.
const TRUSTED: Duration = Duration::from_secs(1);

/// The machines that were used last.
#[derive(Debug, Default)]
pub(super) struct HeldMachines(RwLock<HashMap<Box<str>, Held, RandomState>>);

#[derive(Debug)]
struct Held {
    writes: u64,
    at: Instant,
    machine: Arc<MachineUsed>,
}

impl HeldMachines {
    /// The machine, if the number of writes is the same as when it was read.
    pub(super) fn get(&self, machine_id: &str, writes: u64) -> Option<Arc<MachineUsed>> {
        let held = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let found = held.get(machine_id)?;
        (found.writes == writes && found.at.elapsed() < TRUSTED).then(|| Arc::clone(&found.machine))
    }

    /// Keeps a machine that was read after this number of writes.
    pub(super) fn keep(&self, machine_id: &str, writes: u64, machine: &Arc<MachineUsed>) {
        let mut held = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if held.len() >= MOST && !held.contains_key(machine_id) {
            held.clear();
        }
        held.insert(machine_id.into(), Held { writes, at: Instant::now(), machine: Arc::clone(machine) });
    }
}
