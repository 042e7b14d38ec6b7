//! Merges the routes of the resources, and the description that they make.

use axum::Router;
use serde_json::Value;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;

use super::openapi::{Base, all, completed, published};
use super::{
    AppState, audit, calibrations, jobs, keys, kinematics, machines, programs, service, servo, tools, wear,
    webhooks,
};

/// Every described route, and the part of the description that the routes give: a start needs no more of it.
pub(super) fn described() -> (Router<AppState>, utoipa::openapi::OpenApi) {
    OpenApiRouter::with_openapi(Base::openapi())
        .merge(machines::router())
        .merge(tools::router())
        .merge(kinematics::router())
        .merge(programs::router())
        .merge(servo::router())
        .merge(wear::router())
        .merge(calibrations::router())
        .merge(jobs::router())
        .merge(webhooks::router())
        .merge(keys::router())
        .merge(audit::router())
        .merge(service::router())
        .split_for_parts()
}

/// The description of the interface.
#[must_use]
pub fn document() -> Value {
    published(&completed(described().1))
}

/// One line for each operation: method, path, id.
#[must_use]
pub fn operations() -> String {
    let document = described().1;
    let mut lines: Vec<String> =
        all(&document).map(|(method, path, id)| format!("{method:6} {path:58} {id}")).collect();
    lines.sort_by(|a, b| a.get(7..).cmp(&b.get(7..)));
    lines.join("\n") + "\n"
}
