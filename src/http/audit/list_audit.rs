//! Lists the changes.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;
use utoipa::IntoParams;

use crate::http::AppState;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::store::AuditFilter;
use crate::wire::{AuditAction, AuditEntry};

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Which changes, and which page of them.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct AuditQuery {
    /// How many items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the page before.
    cursor: Option<String>,
    /// Only about this machine.
    machine_id: Option<String>,
    /// Only by this key.
    key_id: Option<String>,
    /// Only of this kind.
    #[param(inline)]
    action: Option<AuditAction>,
}

/// Read the audit log
///
/// Every change of what is stored, newest first: who, by which request, from which revision of the machine to which. A
/// row is written with the change it tells of, and never changes. Calls that changed nothing are not in it.
#[utoipa::path(
    get,
    path = "/v1/audit",
    tag = "keys",
    operation_id = "list_audit_entries",
    params(AuditQuery),
    responses(
        (status = 200, description = "A page of changes", body = Listed<AuditEntry>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_audit_entries(
    State(app): State<AppState>,
    Query(query): Query<AuditQuery>,
    headers: HeaderMap,
) -> Result<Json<Listed<AuditEntry>>, Problem> {
    choose(&headers, &["application/json"])?;
    let AuditQuery { limit, cursor, machine_id, key_id, action } = query;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    let page = app.store.audit_entries(&AuditFilter { machine_id, key_id, action }, limit, before).await?;
    Ok(Json(Listed::new(page, |entry| entry)))
}
