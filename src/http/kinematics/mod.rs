//! Tool poses to axis words and back, many at a time, as JSON or as streamed CSV.

mod solve_forward;
mod solve_inverse;
mod table;

use super::described::{Described, routes};

/// The routes of this resource.
pub(super) fn router() -> Described {
    Described::default()
        .routes(routes!(solve_inverse::solve_inverse_kinematics))
        .routes(routes!(solve_forward::solve_forward_kinematics))
}
