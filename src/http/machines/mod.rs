//! Machines: profiles as immutable revisions.

mod delete_machine;
mod get_machine;
mod get_revision;
mod list_machines;
mod list_presets;
mod list_revisions;
mod put_machine;

use super::described::resource;

resource! {
    put_machine::put_machine,
    get_machine::get_machine,
    delete_machine::delete_machine,
    list_machines::list_machines,
    list_revisions::list_machine_revisions,
    get_revision::get_machine_revision,
    list_presets::list_machine_presets,
}
