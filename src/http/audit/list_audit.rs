//! Lists the audit log.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use serde::Deserialize;

use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{CSV, Listed, PageQuery, table_page};
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::period;
use crate::store::AuditFilter;
use crate::wire::{AuditAction, FaultList, audit_table};

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
    /// Only changes at this time or later (RFC 3339).
    #[param(format = "date-time", example = "2026-03-14T00:00:00.000Z")]
    from: Option<String>,
    /// Only changes at this time or earlier (RFC 3339).
    #[param(format = "date-time", example = "2026-03-15T00:00:00.000Z")]
    to: Option<String>,
}

/// Read the audit log
///
/// Every change of the stored data, newest first: who made it, with which request, and the machine's revision before
/// and after. An entry is written together with its change, and never changes. Calls that changed nothing have no
/// entry. `Accept: text/csv` gives a table; the header `Trunnion-Next-Cursor` then has the cursor of the next page.
#[operation(
    get,
    path = "/v1/audit",
    tag = "keys",
    operation_id = "list_audit_entries",
    params(AuditQuery),
    responses(
        (status = 200, description = "A page of changes", content(
            (Listed<crate::wire::AuditEntry> = "application/json", example = json!({"items": [], "next_cursor": null})),
            (String = "text/csv")),
            headers(("Trunnion-Next-Cursor" = String, description = "Of a table: cursor of the next page, if there is one"))),
        Refusals,
    )
)]
pub(super) async fn list_audit_entries(
    State(app): State<AppState>,
    Query(query): Query<AuditQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind = choose(&headers, &["application/json", CSV])?;
    let AuditQuery { limit, cursor, machine_id, key_id, action, from, to } = query;
    let mut faults = FaultList::default();
    let (from, to) = period(["/from", "/to"], from.as_deref(), to.as_deref(), &mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    let filter = AuditFilter { machine_id, key_id, action, from, to };
    let page = app.store.audit_entries(&filter, limit, before).await?;
    if kind == CSV {
        let table = audit_table(&page.items).map_err(|fault| Problem::internal(&fault))?;
        return Ok(table_page(table, page.next));
    }
    Ok(Json(Listed::new(page, |entry| entry)).into_response())
}
