//! Lists the runs of a machine.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use serde::Deserialize;

use super::ever_existed;
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{CSV, Listed, PageQuery, table_page};
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::period;
use crate::store::CalibrationFilter;
use crate::wire::{CalibrationKind, Fault, FaultList, calibration_table};

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest);

/// Filters and page.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct CalibrationQuery {
    /// Number of items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
    /// Only runs of this kind.
    #[param(inline)]
    kind: Option<CalibrationKind>,
    /// Only runs measured at this time or later (RFC 3339).
    measured_from: Option<String>,
    /// Only runs measured at this time or earlier (RFC 3339).
    measured_to: Option<String>,
}

/// The bounds of a query in the form in which stored times are compared; adds every fault.
pub(super) fn bounds(
    from: Option<&str>,
    to: Option<&str>,
) -> Result<(Option<String>, Option<String>), Vec<Fault>> {
    let mut faults = FaultList::default();
    let bounds = period(["/measured_from", "/measured_to"], from, to, &mut faults);
    faults.into_result().map(|()| bounds)
}

/// List calibration runs
///
/// The last stored run comes first. Runs of a deleted machine are listed too. `Accept: text/csv` gives a table with one
/// row for each run; the header `Trunnion-Next-Cursor` then has the cursor of the next page.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/calibrations",
    tag = "calibrations",
    operation_id = "list_calibrations",
    params(("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"), CalibrationQuery),
    responses(
        (status = 200, description = "A page of runs", content(
            (Listed<crate::wire::CalibrationDocument> = "application/json", example = json!({"items": [], "next_cursor": null})),
            (String = "text/csv")),
            headers(("Trunnion-Next-Cursor" = String, description = "Of a table: cursor of the next page, if there is one"))),
        Refusals,
    )
)]
pub(super) async fn list_calibrations(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(query): Query<CalibrationQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind_of_answer = choose(&headers, &["application/json", CSV])?;
    let CalibrationQuery { limit, cursor, kind, measured_from, measured_to } = query;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    let (measured_from, measured_to) = bounds(measured_from.as_deref(), measured_to.as_deref())
        .map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    let filter = CalibrationFilter { kind, measured_from, measured_to };
    let page = app.store.calibrations(&machine_id, &filter, limit, before).await?;
    if page.items.is_empty() {
        ever_existed(&app, &machine_id).await?;
    }
    if kind_of_answer == CSV {
        let table = calibration_table(&page.items).map_err(|fault| Problem::internal(&fault))?;
        return Ok(table_page(table, page.next));
    }
    Ok(Json(Listed::new(page, |document| document)).into_response())
}
