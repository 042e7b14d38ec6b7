//! Reads a machine.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::{machine_response, machine_tag, unless_known};
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest);

/// Read a machine
///
/// The current revision. If `If-None-Match` has its `ETag`, the answer is 304.
#[operation(
    get,
    path = "/v1/machines/{machine_id}",
    tag = "machines",
    operation_id = "get_machine",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the revision that you have"),
    ),
    responses(
        (status = 200, description = "The current revision", body = crate::wire::MachineDocument,
            headers(("ETag" = String, description = "Tag of the revision"),
                ("Trunnion-Calibration" = Option<String>, description = "The calibration run whose errors the revision has, if it comes from a run"))),
        (status = 304, description = "Not changed: your revision is current"),
        Refusals,
    )
)]
pub(super) async fn get_machine(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let found =
        app.store.machine(&machine_id).await?.ok_or_else(|| Problem::machine_not_found(&machine_id))?;
    unless_known(&headers, &machine_tag(&found), || machine_response(found))
}
