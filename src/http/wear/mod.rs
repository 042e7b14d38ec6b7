//! Scallop heights, advice for a worn cutter, and wear histories.

mod advise_wear;
mod history;
mod scallop_height;

use super::described::resource;

resource! {
    scallop_height::compute_scallop_height,
    advise_wear::advise_wear,
    ; history
}
