//! Tool poses to axis words and back, many at a time, as JSON or as streamed CSV.

mod solve_forward;
mod solve_inverse;
mod table;

use super::described::resource;

resource! {
    solve_inverse::solve_inverse_kinematics,
    solve_forward::solve_forward_kinematics,
}
