//! Withdraws a wrong wear entry.

use axum::extract::State;
use http::HeaderMap;

use super::ever_existed;
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::{FaultList, NoParameters, WearEntry, Withdrawal, WithdrawalRequest};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, WearEntryNotFound, NotAcceptable, RequestTimeout,
    AlreadyWithdrawn, BodyTooLarge, UnsupportedMediaType, InvalidRequest
);

/// Withdraw a wear entry
///
/// The entry stays with the time and the reason of the withdrawal, and trends leave it out. The same reason again
/// returns the same answer. Post the right numbers as a new entry.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/wear-entries/{id}/withdraw",
    tag = "wear",
    operation_id = "withdraw_wear_entry",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        ("id" = String, Path, description = "The entry", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
    ),
    request_body(content = WithdrawalRequest, description = "The reason", example = json!({"reason": "read the wrong flute"})),
    responses((status = 200, description = "The entry, withdrawn", body = WearEntry), Refusals)
)]
pub(super) async fn withdraw_wear_entry(
    State(app): State<AppState>,
    Path((machine_id, tool_id, id)): Path<(String, String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    By(actor): By,
    Json(request): Json<WithdrawalRequest>,
) -> Result<Json<WearEntry>, Problem> {
    choose(&headers, &["application/json"])?;
    let mut faults = FaultList::default();
    request.check(&mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    let new = Withdrawal { withdrawn_at: app.sources.timestamp(), reason: request.reason };
    let Some(entry) = app.store.withdraw_wear_entry(&machine_id, &tool_id, &id, &new, &actor).await? else {
        ever_existed(&app, &machine_id).await?;
        return Err(Problem::wear_entry_not_found(&tool_id, &id));
    };
    match &entry.withdrawn {
        Some(kept) if kept.reason != new.reason => {
            let Withdrawal { withdrawn_at, reason } = kept;
            let detail = format!("entry {id} was withdrawn at {withdrawn_at}: {reason}");
            Err(Problem::new(ProblemType::AlreadyWithdrawn, detail))
        }
        _ => Ok(Json(entry)),
    }
}
