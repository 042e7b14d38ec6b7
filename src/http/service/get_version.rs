//! Which version is running?

use http::HeaderMap;
use serde::Serialize;

use crate::description::{ToSchema, operation};
use crate::http::extract::Json;
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;

refusals!(Refusals: NotAcceptable, Busy);

/// The running version.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Version {
    /// `trunnion`.
    name: &'static str,
    /// The version that reports and jobs name.
    version: &'static str,
}

/// Which version is running
///
/// The version that reports and jobs name as `software_version`.
#[operation(
    get,
    path = "/v1/version",
    tag = "service",
    operation_id = "get_version",
    responses(
        (status = 200, description = "The version", body = Version, example = json!({"name": "trunnion", "version": "0.1.0"})),
        Refusals,
    )
)]
pub(super) async fn get_version(headers: HeaderMap) -> Result<Json<Version>, Problem> {
    choose(&headers, &["application/json"])?;
    Ok(Json(Version { name: env!("CARGO_PKG_NAME"), version: env!("CARGO_PKG_VERSION") }))
}
