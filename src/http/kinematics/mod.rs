//! Tool poses to axis words and back, many at a time, as JSON or as streamed CSV.

mod solve_forward;
mod solve_inverse;
mod table;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(solve_inverse::solve_inverse_kinematics))
        .routes(routes!(solve_forward::solve_forward_kinematics))
}
