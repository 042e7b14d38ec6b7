//! Reads one revision of a machine.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::{machine_response, machine_tag, unless_known};
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, RevisionNotFound, NotAcceptable, InvalidRequest);

/// Read one revision of a machine
///
/// A revision never changes, and stays after its machine is deleted.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/revisions/{revision}",
    tag = "machines",
    operation_id = "get_machine_revision",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("revision" = i64, Path, description = "Number of the revision", example = 1),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the revision that you have"),
    ),
    responses(
        (status = 200, description = "The revision", body = crate::wire::MachineDocument,
            headers(("ETag" = String, description = "Tag of the revision"),
                ("Trunnion-Calibration" = Option<String>, description = "The calibration run whose errors the revision has, if it comes from a run"))),
        (status = 304, description = "Not changed: your revision is current"),
        Refusals,
    )
)]
pub(super) async fn get_machine_revision(
    State(app): State<AppState>,
    Path((machine_id, revision)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let found = match revision.parse() {
        Ok(number) => app.store.machine_revision(&machine_id, number).await?,
        Err(_) => None,
    };
    let found = found.ok_or_else(|| {
        Problem::new(
            ProblemType::RevisionNotFound,
            format!("machine {machine_id:?} has no revision {revision:?}"),
        )
    })?;
    unless_known(&headers, &machine_tag(&found), || machine_response(found))
}
