//! Lists the audit log.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;

use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::store::AuditFilter;
use crate::wire::{AuditAction, AuditEntry};

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Filters and page.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct AuditQuery {
    /// Number of items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
    /// Only changes that concern this machine.
    machine_id: Option<String>,
    /// Only changes made with this key.
    key_id: Option<String>,
    /// Only changes of this kind.
    #[param(inline)]
    action: Option<AuditAction>,
}

/// Read the audit log
///
/// Every change of the stored data, newest first: who made it, with which request, and the machine's revision before
/// and after. An entry is written together with its change, and never changes. Calls that changed nothing have no
/// entry.
#[operation(
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
