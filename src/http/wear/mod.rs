//! Scallop heights, advice for a worn cutter, and wear histories.

mod advise_wear;
mod history;
mod scallop_height;

use super::described::{Described, routes};

/// The routes of this resource.
pub(super) fn router() -> Described {
    Described::default()
        .routes(routes!(scallop_height::compute_scallop_height))
        .routes(routes!(advise_wear::advise_wear))
        .merge(history::router())
}
