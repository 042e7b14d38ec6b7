//! Deletes a machine.

use axum::extract::State;
use http::{HeaderMap, StatusCode};

use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::conditional::{expected, stale};
use crate::http::extract::{Path, Query};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::store::Stale;
use crate::wire::NoParameters;

refusals!(
    Refusals: MalformedRequest, MachineNotFound, PreconditionFailed, PreconditionRequired, InvalidRequest
);

/// Delete a machine
///
/// `If-Match` is required. The tools of the machine are deleted too. The revisions of both stay readable for the jobs
/// that name them, and so do calibrations and wear entries. If a machine is stored again under the same id, the
/// revision numbers continue.
#[operation(
    delete,
    path = "/v1/machines/{machine_id}",
    tag = "machines",
    operation_id = "delete_machine",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "dmu-80-t"),
        ("If-Match" = String, Header, description = "ETag of the current revision; `*` fits every revision", example = "*"),
    ),
    responses((status = 204, description = "The machine is deleted"), Refusals)
)]
pub(super) async fn delete_machine(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    By(actor): By,
) -> Result<StatusCode, Problem> {
    let expected = expected(&headers)?;
    let now = app.sources.timestamp();
    match app.store.delete_machine(&machine_id, expected, &now, &actor).await? {
        Ok(()) => Ok(StatusCode::NO_CONTENT),
        Err(Stale::Missing) => Err(Problem::machine_not_found(&machine_id)),
        Err(reason) => Err(stale(reason, &machine_id)),
    }
}
