//! The service itself: health, readiness, metrics, limits, version, problems.

mod get_health;
mod get_metrics;
mod get_problem;
mod get_readiness;
mod get_version;
mod list_limits;

use super::described::resource;

resource! {
    get_health::get_health,
    get_readiness::get_readiness,
    get_metrics::get_metrics,
    get_version::get_version,
    list_limits::list_limits,
    get_problem::list_problems,
    get_problem::get_problem,
}
