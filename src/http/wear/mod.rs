//! Scallop heights, advice for a worn cutter, and wear histories.

mod advise_wear;
mod history;
mod scallop_height;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(scallop_height::compute_scallop_height))
        .routes(routes!(advise_wear::advise_wear))
        .merge(history::router())
}
