//! Tool poses to axis words and back, many at a time, as JSON or as streamed CSV.

mod solve_forward;
mod solve_inverse;
mod table;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;
use super::problem::Problem;
use crate::machine::Machine;

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(solve_inverse::solve_inverse_kinematics))
        .routes(routes!(solve_forward::solve_forward_kinematics))
}

/// A machine with the number of its current revision.
async fn find(app: &AppState, machine_id: &str) -> Result<(i64, Machine), Problem> {
    let found = app.store.machine(machine_id).await?.ok_or_else(|| Problem::machine_not_found(machine_id))?;
    let revision = found.document.revision;
    let (_, machine) = found
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    Ok((revision, machine))
}
