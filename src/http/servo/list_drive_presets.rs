//! Lists drives that profiles can start from.

use http::HeaderMap;
use serde::Serialize;

use crate::description::{ToSchema, operation};
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::{DrivePresetDoc, NoParameters, drive_presets};

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Every preset.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct DrivePresets {
    /// The presets.
    items: Vec<DrivePresetDoc>,
    /// Always null: the list has one page.
    next_cursor: Option<String>,
}

/// List the drive presets
///
/// Drives with published constants, to copy into a profile. Each states which of its numbers are assumed.
#[operation(
    get,
    path = "/v1/drive-presets",
    tag = "servo",
    operation_id = "list_drive_presets",
    responses(
        (status = 200, description = "Every preset", body = DrivePresets, example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_drive_presets(
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Json<DrivePresets>, Problem> {
    choose(&headers, &["application/json"])?;
    Ok(Json(DrivePresets { items: drive_presets(), next_cursor: None }))
}
