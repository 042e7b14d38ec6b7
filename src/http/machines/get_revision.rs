//! Reads one revision of a machine.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use crate::http::AppState;
use crate::http::conditional::{machine_response, machine_tag, unless_known};
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::{MachineDocument, NoParameters};

refusals!(Refusals: MalformedRequest, RevisionNotFound, NotAcceptable, InvalidRequest);

/// Read one revision of a machine
///
/// A revision never changes and stays when its machine is deleted.
#[utoipa::path(
    get,
    path = "/v1/machines/{machine_id}/revisions/{revision}",
    tag = "machines",
    operation_id = "get_machine_revision",
    params(
        ("machine_id" = String, Path, description = "The client's slug", example = "example-ac-table"),
        ("revision" = i64, Path, description = "Its number", example = 1),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the revision that is known"),
    ),
    responses(
        (status = 200, description = "The revision", body = MachineDocument,
            headers(("ETag" = String, description = "Tag of the revision"),
                ("Trunnion-Calibration" = Option<String>, description = "The calibration run whose errors it carries, where it comes from one"))),
        (status = 304, description = "The revision is the one that is known"),
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
