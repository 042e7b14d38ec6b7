//! NC programs in, compensated programs out. A program leaves whole or not at all.

pub(super) mod answer;
mod arrival;
mod compensate_cc_path;
mod compensate_program;
mod compensate_wear;
mod interpret_program;
mod post_program;
mod simulate_servo_program;
pub(super) mod upload;
mod verify_part;

use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(compensate_cc_path::compensate_cc_path))
        .routes(routes!(compensate_wear::compensate_wear_of_program))
        .routes(routes!(compensate_program::compensate_program_in_one_pass))
        .routes(routes!(interpret_program::interpret_program))
        .routes(routes!(post_program::post_program))
        .routes(routes!(simulate_servo_program::simulate_servo_program))
        .routes(routes!(verify_part::verify_part_of_program))
}
