//! Lists the presets.

use http::HeaderMap;
use serde::Serialize;

use crate::description::{ToSchema, operation};
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::{NoParameters, Preset, presets};

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Every preset.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Presets {
    /// The presets.
    items: Vec<Preset>,
    /// Always null: the list has one page.
    next_cursor: Option<String>,
}

/// List the machine presets
///
/// Common layouts as profiles. Fill in the numbers and store the profile as a machine.
#[operation(
    get,
    path = "/v1/machine-presets",
    tag = "machines",
    operation_id = "list_machine_presets",
    responses(
        (status = 200, description = "Every preset", body = Presets, example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_machine_presets(
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Json<Presets>, Problem> {
    choose(&headers, &["application/json"])?;
    Ok(Json(Presets { items: presets(), next_cursor: None }))
}
