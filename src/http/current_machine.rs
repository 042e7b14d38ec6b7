//! The machine that a request names, as it is now.

use super::AppState;
use super::problem::Problem;
use crate::jobs::MachineUsed;

/// The machine with this id, at its current revision.
pub(super) async fn current_machine(app: &AppState, machine_id: &str) -> Result<MachineUsed, Problem> {
    let writes = app.store.writes();
    if let Some(held) = app.machines.get(machine_id, writes) {
        return Ok(held);
    }
    let found = app.store.machine(machine_id).await?.ok_or_else(|| Problem::machine_not_found(machine_id))?;
    let revision = found.document.revision;
    let drives = found.document.profile.drives.clone();
    let (_, machine) = found
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    let used = MachineUsed { revision, machine, drives };
    app.machines.keep(machine_id, writes, &used);
    Ok(used)
}
