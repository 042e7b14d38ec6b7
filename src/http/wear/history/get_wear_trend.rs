//! The wear of a cutter over time, and the parts left until a limit.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use serde::Deserialize;

use super::figure::{SVG, figure};
use super::{checked, ever_existed};
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Path, Query, json_response};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::{FaultList, FollowedWear, WearTrendHead, wear_trend_table};

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest, Busy, TooCostly);

/// The cutter and the limit.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct WearTrendQuery {
    /// Id of the cutter; default the cutter of the newest entry.
    cutter_id: Option<String>,
    /// Wear at which the cutter will be changed; without it there is no prediction.
    #[param(example = 150.0, minimum = 0.001, maximum = 10_000)]
    limit_um: Option<f64>,
}

/// Limits that are accepted \[µm\].
const LIMIT_UM: [f64; 2] = [1e-3, 10_000.0];

/// Follow the wear of a cutter
///
/// Entries by edge, with the fitted course. With `limit_um` the answer also has the number of parts left, between an
/// early and a late end. These ends hold with 95 % for any next stage of wear. `outlook.basis` gives their basis. A
/// narrower interval is valid as long as no new stage begins. A value that cannot be determined is null, and `words`
/// gives the reason. `Accept: text/csv` gives the entries as a table, `Accept: image/svg+xml` a figure with the limit
/// and the outlook.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/wear-trend",
    tag = "wear",
    operation_id = "get_wear_trend",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        WearTrendQuery,
    ),
    responses(
        (status = 200, description = "The trend", content(
            (crate::wire::WearTrend = "application/json"), (String = "text/csv"), (String = "image/svg+xml"))),
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
            SVG => Ok(([(CONTENT_TYPE, SVG)], figure(&followed)).into_response()),
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
