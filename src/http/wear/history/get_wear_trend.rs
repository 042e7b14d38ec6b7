//! How a cutter wore, and the parts that are left to a limit.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use serde::Deserialize;
use utoipa::IntoParams;

use super::figure::{SVG, figure};
use super::{checked, ever_existed};
use crate::http::AppState;
use crate::http::extract::{Path, Query, json_response};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::{FaultList, FollowedWear, WearTrend, WearTrendHead, wear_trend_table};

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest, Busy, TooCostly);

/// Which cutter, and to what limit.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct WearTrendQuery {
    /// The cutter; that of the newest entry unless said.
    cutter_id: Option<String>,
    /// The wear at which the cutter is to be changed; without it nothing is predicted.
    #[param(example = 150.0, minimum = 0.001, maximum = 10_000)]
    limit_um: Option<f64>,
}

/// Limits taken for real \[µm\].
const LIMIT_UM: [f64; 2] = [1e-3, 10_000.0];

/// Follow the wear of a cutter
///
/// Its entries by edge with the course fitted to them, and with `limit_um` the number of parts that are left, between an
/// early and a late end that hold 95 % whatever stage of wear comes next. `outlook.basis` says what they rest on. A narrower
/// interval holds as long as no new stage begins. What cannot be told is null, and `words` says why. `Accept: text/csv` gives
/// the entries as a table, `Accept: image/svg+xml` a figure with the limit and what is to come.
#[utoipa::path(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/wear-trend",
    tag = "wear",
    operation_id = "get_wear_trend",
    params(
        ("machine_id" = String, Path, description = "The client's slug", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "The client's name of the tool", example = "T12"),
        WearTrendQuery,
    ),
    responses(
        (status = 200, description = "The trend", content(
            (WearTrend = "application/json"), (String = "text/csv"), (String = "image/svg+xml"))),
        Refusals,
    )
)]
pub(super) async fn get_wear_trend(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(WearTrendQuery { cutter_id, limit_um }): Query<WearTrendQuery>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind = choose(&headers, &["application/json", "text/csv", SVG])?;
    let mut faults = FaultList::default();
    if let Some(limit_um) = limit_um {
        faults.check_range(|| "/limit_um".to_owned(), limit_um, LIMIT_UM[0], LIMIT_UM[1]);
    }
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    checked("/tool_id", &tool_id)?;
    let cutter_id = match cutter_id {
        None => app.store.newest_cutter(&machine_id, &tool_id).await?,
        Some(given) => Some(given),
    };
    let entries = match &cutter_id {
        None => Vec::new(),
        Some(cutter_id) => app.store.wear_of_cutter(&machine_id, &tool_id, cutter_id).await?,
    };
    if entries.is_empty() {
        ever_existed(&app, &machine_id).await?;
    }
    let head = WearTrendHead { machine_id, tool_id, cutter_id, limit_um };
    let printed = app.compute.run(move |_stop| {
        let followed = FollowedWear::of(head, &entries);
        match kind {
            SVG => figure(&followed)
                .map(|svg| ([(CONTENT_TYPE, SVG)], svg).into_response())
                .map_err(Problem::from),
            "text/csv" => wear_trend_table(&followed.trend)
                .map(|table| ([(CONTENT_TYPE, "text/csv")], table).into_response())
                .map_err(|fault| Problem::internal(&fault)),
            _ => serde_json::to_vec(&followed.trend)
                .map(json_response)
                .map_err(|fault| Problem::internal(&fault)),
        }
    });
    printed.await?
}
