//! Wear histories of a machine's tools: post, list and withdraw entries, and follow them to a limit.

mod create_wear_entries;
mod figure;
mod get_wear_entry;
mod get_wear_trend;
mod list_wear_entries;
mod withdraw_wear_entry;

use crate::http::AppState;
use crate::http::described::resource;
use crate::http::problem::{Problem, ProblemType};
use crate::wire::{FaultList, check_name};

resource! {
    create_wear_entries::create_wear_entries,
    list_wear_entries::list_wear_entries,
    get_wear_entry::get_wear_entry,
    withdraw_wear_entry::withdraw_wear_entry,
    get_wear_trend::get_wear_trend,
}

/// A deleted machine keeps its history.
async fn ever_existed(app: &AppState, machine_id: &str) -> Result<(), Problem> {
    let first = app.store.machine_revision(machine_id, 1).await?;
    first.map(drop).ok_or_else(|| Problem::machine_not_found(machine_id))
}

/// Refuses a name in the path or the query that no tool or cutter can have.
fn checked(pointer: &str, name: &str) -> Result<(), Problem> {
    let mut faults = FaultList::default();
    check_name(|| pointer.to_owned(), name, &mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))
}
