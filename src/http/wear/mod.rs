//! Scallop heights, and what to do about a worn cutter.

mod advise_wear;
mod scallop_height;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(scallop_height::compute_scallop_height))
        .routes(routes!(advise_wear::advise_wear))
}
