//! Machines: profiles as immutable revisions.

mod delete_machine;
mod get_machine;
mod get_revision;
mod list_machines;
mod list_presets;
mod list_revisions;
mod put_machine;

use super::described::{Described, routes};

/// The routes of this resource.
pub(super) fn router() -> Described {
    Described::default()
        .routes(routes!(put_machine::put_machine, get_machine::get_machine, delete_machine::delete_machine))
        .routes(routes!(list_machines::list_machines))
        .routes(routes!(list_revisions::list_machine_revisions))
        .routes(routes!(get_revision::get_machine_revision))
        .routes(routes!(list_presets::list_machine_presets))
}
