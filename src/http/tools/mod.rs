//! The tool table of a machine: tools as immutable revisions. Their wear entries are in `http/wear/history`.

mod delete_tool;
mod get_tool;
mod get_tool_revision;
mod list_tool_revisions;
mod list_tools;
mod put_tool;

use super::AppState;
use super::current_machine::current_machine;
use super::described::resource;
use super::problem::Problem;

resource! {
    put_tool::put_tool,
    get_tool::get_tool,
    delete_tool::delete_tool,
    list_tools::list_tools,
    list_tool_revisions::list_tool_revisions,
    get_tool_revision::get_tool_revision,
}

/// The refusal for a missing tool; the machine may be missing too.
async fn not_found(app: &AppState, machine_id: &str, tool_id: &str) -> Problem {
    match current_machine(app, machine_id).await {
        Ok(_machine) => Problem::tool_not_found(machine_id, tool_id),
        Err(problem) => problem,
    }
}
