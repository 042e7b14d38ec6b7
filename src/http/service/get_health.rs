//! Is the process alive?

use http::HeaderMap;
use serde::Serialize;

use crate::description::{ToSchema, operation};
use crate::http::extract::Json;
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;

refusals!(Refusals: NotAcceptable, Busy);

/// State of the process.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Health {
    /// `ok`.
    #[schema(example = "ok")]
    status: &'static str,
}

/// Is the process alive
///
/// Answers 200 as long as the process serves requests at all.
#[operation(
    get,
    path = "/healthz",
    tag = "service",
    operation_id = "get_health",
    responses((status = 200, description = "The process is alive", body = Health, example = json!({"status": "ok"})), Refusals)
)]
pub(super) async fn get_health(headers: HeaderMap) -> Result<Json<Health>, Problem> {
    choose(&headers, &["application/json"])?;
    Ok(Json(Health { status: "ok" }))
}
