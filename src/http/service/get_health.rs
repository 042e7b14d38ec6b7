//! Is the process alive?

use serde::Serialize;
use utoipa::ToSchema;

use crate::http::extract::Json;
use crate::http::refusals::refusals;

refusals!(Refusals: Busy);

/// How the process is.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Health {
    /// `ok`.
    #[schema(example = "ok")]
    status: &'static str,
}

/// Is the process alive
///
/// Answers 200 as long as the process serves requests at all.
#[utoipa::path(
    get,
    path = "/healthz",
    tag = "service",
    operation_id = "get_health",
    responses((status = 200, description = "It is", body = Health, example = json!({"status": "ok"})), Refusals)
)]
pub(super) async fn get_health() -> Json<Health> {
    Json(Health { status: "ok" })
}
