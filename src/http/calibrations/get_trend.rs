//! The trend of one location error over the runs.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use serde::Deserialize;

use super::ever_existed;
use super::figures::{SVG, TrendContext, trend_figure};
use super::list_calibrations::bounds;
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::store::TrendQuery;
use crate::wire::{Fault, Trend, error_in_profile, trend_table, trend_unit};

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
    /// Largest allowed size of a linear error: the figure has lines at plus and minus this value.
    #[param(exclusive_minimum = 0)]
    tolerance_um: Option<f64>,
    /// The same for an angle.
    #[param(exclusive_minimum = 0)]
    tolerance_urad: Option<f64>,
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
/// expanded uncertainties (k = 2), the applied runs, the value in the profile, and the tolerance as limits.
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
    let TrendParameters { axis, error, limit, tolerance_um, tolerance_urad, measured_from, measured_to } =
        parameters;
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
    let mut tolerance = None;
    for (name, of_unit, value) in
        [("tolerance_um", "um", tolerance_um), ("tolerance_urad", "urad", tolerance_urad)]
    {
        let Some(value) = value else { continue };
        if !(value.is_finite() && value > 0.0) {
            faults.push(Fault::new(format!("/{name}"), format!("{name} is {value}; state a number above 0")));
        } else if unit.is_some_and(|unit| unit != of_unit) {
            let detail = format!("{error} is not in the unit of {name}; state the other tolerance");
            faults.push(Fault::new(format!("/{name}"), detail));
        }
        tolerance = Some(value);
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
            let applied = app.store.applied_calibrations(&trend.machine_id).await?;
            let profile = in_profile(&app, &trend).await?;
            let context = TrendContext { applied, profile, tolerance };
            let svg = app.compute.run(move |_stop| trend_figure(&trend, &context)).await?;
            Ok(([(CONTENT_TYPE, SVG)], svg).into_response())
        }
        "text/csv" => {
            let table = trend_table(&trend).map_err(|fault| Problem::internal(&fault))?;
            Ok(([(CONTENT_TYPE, "text/csv")], table).into_response())
        }
        _ => Ok(Json(trend).into_response()),
    }
}

/// The error in the current profile, and the revision; `None` if the machine was deleted or its axes have changed.
async fn in_profile(app: &AppState, trend: &Trend) -> Result<Option<(f64, i64)>, Problem> {
    let Some(current) = app.store.machine(&trend.machine_id).await? else { return Ok(None) };
    let revision = current.document.revision;
    let (_, machine) = current
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    Ok(error_in_profile(&machine, &trend.axis, &trend.error).map(|value| (value, revision)))
}
