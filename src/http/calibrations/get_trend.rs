//! The trend of one location error over the runs.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use serde::Deserialize;

use super::ever_existed;
use super::figures::{SVG, trend_figure};
use super::list_calibrations::bounds;
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::store::TrendQuery;
use crate::wire::{Fault, Trend, trend_table, trend_unit};

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest, Busy, TooCostly);

/// The error, and the runs.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct TrendParameters {
    /// Letter of the axis.
    #[param(example = "A")]
    axis: String,
    /// Name of the error: cascaded (`e_x e_y e_z e_a e_b e_c`) or against the machine's frame (`E_Y0A` …).
    #[param(example = "e_y")]
    error: String,
    /// Largest number of runs; the newest are taken.
    #[param(minimum = 1, maximum = 100_000, default = 10_000)]
    limit: Option<i64>,
    /// Only runs measured at this time or later (RFC 3339).
    measured_from: Option<String>,
    /// Only runs measured at this time or earlier (RFC 3339).
    measured_to: Option<String>,
}

/// Default and largest number of runs in a trend.
const DEFAULT_RUNS: i64 = 10_000;
const MAX_RUNS: i64 = 100_000;

/// Follow a location error over the runs
///
/// Oldest first, with standard uncertainties. `Accept: text/csv` gives a table, `Accept: image/svg+xml` a figure with
/// uncertainty bars.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/calibrations/trend",
    tag = "calibrations",
    operation_id = "get_calibration_trend",
    params(("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"), TrendParameters),
    responses(
        (status = 200, description = "The runs", content(
            (Trend = "application/json"), (String = "text/csv"), (String = "image/svg+xml"))),
        Refusals,
    )
)]
pub(super) async fn get_calibration_trend(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(parameters): Query<TrendParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind = choose(&headers, &["application/json", "text/csv", SVG])?;
    let TrendParameters { axis, error, limit, measured_from, measured_to } = parameters;
    let limit = limit.unwrap_or(DEFAULT_RUNS);
    let mut faults = Vec::new();
    if !(1..=MAX_RUNS).contains(&limit) {
        faults.push(Fault::new("/limit", format!("limit is not between 1 and {MAX_RUNS}")));
    }
    if !["A", "B", "C"].contains(&axis.as_str()) {
        faults.push(Fault::new("/axis", "the name of a rotary axis must be A, B or C"));
    }
    let unit = trend_unit(&axis, &error);
    if unit.is_none() {
        let detail = format!(
            "{error:?} is not an error of this axis; use e_x e_y e_z e_a e_b e_c or E_X0{axis} … E_C0{axis}"
        );
        faults.push(Fault::new("/error", detail));
    }
    let (from, to) = bounds(measured_from.as_deref(), measured_to.as_deref()).unwrap_or_else(|found| {
        faults.extend(found);
        (None, None)
    });
    let Some(unit) = unit.filter(|_| faults.is_empty()) else {
        return Err(Problem::invalid(ProblemType::InvalidRequest, faults));
    };
    ever_existed(&app, &machine_id).await?;
    let wanted = TrendQuery {
        machine_id: &machine_id,
        axis: &axis,
        error: &error,
        measured_from: from.as_deref(),
        measured_to: to.as_deref(),
        limit,
    };
    let points = app.store.calibration_trend(&wanted).await?;
    let trend = Trend { machine_id, axis, error, unit: unit.to_owned(), points };
    match kind {
        SVG => {
            let svg = app.compute.run(move |_stop| trend_figure(&trend)).await??;
            Ok(([(CONTENT_TYPE, SVG)], svg).into_response())
        }
        "text/csv" => {
            let table = trend_table(&trend).map_err(|fault| Problem::internal(&fault))?;
            Ok(([(CONTENT_TYPE, "text/csv")], table).into_response())
        }
        _ => Ok(Json(trend).into_response()),
    }
}
