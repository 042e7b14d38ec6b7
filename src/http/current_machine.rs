//! The machine that a request names, at its current revision.

use std::sync::Arc;

use super::AppState;
use super::problem::Problem;
use crate::jobs::{MachineUsed, ToolShelf};

/// The machine with this id, at its current revision.
pub(super) async fn current_machine(app: &AppState, machine_id: &str) -> Result<Arc<MachineUsed>, Problem> {
    let writes = app.store.writes();
    // Another service may have changed it a moment ago.
    if !app.store.is_shared()
        && let Some(held) = app.machines.get(machine_id, writes)
    {
        return Ok(held);
    }
    // Boxed because it is rare: otherwise its memory would be part of every request's.
    Box::pin(read(app, machine_id, writes)).await
}

/// The machine from the database; it is kept for the next request if nothing is written meanwhile.
async fn read(app: &AppState, machine_id: &str, writes: u64) -> Result<Arc<MachineUsed>, Problem> {
    let found = app.store.machine(machine_id).await?.ok_or_else(|| Problem::machine_not_found(machine_id))?;
    let shelf = ToolShelf::new(app.store.tools(machine_id).await?);
    let (revision, profile) = (found.document.revision, found.document.profile);
    let used = MachineUsed::new(machine_id.to_owned(), revision, profile, shelf)
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    let used = Arc::new(used);
    app.machines.keep(machine_id, writes, &used);
    Ok(used)
}
