//! The service itself: health, readiness, metrics, limits, version, problems.

mod get_health;
mod get_metrics;
mod get_problem;
mod get_readiness;
mod get_version;
mod list_limits;

use super::described::{Described, routes};

/// The routes of this resource.
pub(super) fn router() -> Described {
    Described::default()
        .routes(routes!(get_health::get_health))
        .routes(routes!(get_readiness::get_readiness))
        .routes(routes!(get_metrics::get_metrics))
        .routes(routes!(get_version::get_version))
        .routes(routes!(list_limits::list_limits))
        .routes(routes!(get_problem::list_problems))
        .routes(routes!(get_problem::get_problem))
}
