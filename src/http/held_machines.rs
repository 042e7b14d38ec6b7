//! Machines as handlers use them, in memory, so that a small computation does not wait for the database. A machine is
//! only taken from here as long as nothing at all was written since it was read.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

use crate::jobs::MachineUsed;

/// Machines held at most.
const MOST: usize = 256;

/// How long a machine is trusted without asking the database. What this process writes is seen at once; this is for what
/// comes in any other way.
const TRUSTED: Duration = Duration::from_secs(1);

/// The machines that were used last.
#[derive(Debug, Default)]
pub(super) struct HeldMachines(RwLock<HashMap<Box<str>, Held>>);

#[derive(Debug)]
struct Held {
    writes: u64,
    at: Instant,
    machine: Arc<MachineUsed>,
}

impl HeldMachines {
    /// The machine, if so many writes have been seen as when it was read.
    pub(super) fn get(&self, machine_id: &str, writes: u64) -> Option<Arc<MachineUsed>> {
        let held = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let found = held.get(machine_id)?;
        (found.writes == writes && found.at.elapsed() < TRUSTED).then(|| Arc::clone(&found.machine))
    }

    /// Keeps a machine that was read after so many writes.
    pub(super) fn keep(&self, machine_id: &str, writes: u64, machine: &Arc<MachineUsed>) {
        let mut held = self.0.write().unwrap_or_else(PoisonError::into_inner);
        if held.len() >= MOST && !held.contains_key(machine_id) {
            held.clear();
        }
        held.insert(machine_id.into(), Held { writes, at: Instant::now(), machine: Arc::clone(machine) });
    }
}
