//! The machine that a request names, as it is now.

use super::AppState;
use super::problem::Problem;
use crate::machine::Machine;
use crate::wire::Drives;

/// A machine with the number of its current revision.
#[derive(Debug)]
pub(super) struct CurrentMachine {
    /// Its current revision.
    pub(super) revision: i64,
    /// The machine.
    pub(super) machine: Machine,
    /// Its drives, if the profile has any.
    pub(super) drives: Option<Drives>,
}

/// The machine with this id.
pub(super) async fn current_machine(app: &AppState, machine_id: &str) -> Result<CurrentMachine, Problem> {
    let found = app.store.machine(machine_id).await?.ok_or_else(|| Problem::machine_not_found(machine_id))?;
    let revision = found.document.revision;
    let drives = found.document.profile.drives.clone();
    let (_, machine) = found
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    Ok(CurrentMachine { revision, machine, drives })
}
