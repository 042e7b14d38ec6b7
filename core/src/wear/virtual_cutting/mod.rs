//! Virtual cutting: what a cutter leaves of the stock over a surface, sample by sample (P3 §4.2).
//!
//! Every sample has a *needle* `p + s·ν` along its normal, s up to the stock's height H. A tool position counts where the
//! stretch of the needle inside the cutter contains s = H: it reaches the outside, as a tool on the far side of a thin
//! wall does not. It counts too where that stretch contains s = 0, the surface itself: wherever it came from, it gouges.
//! The residual is the least s at which a counting position enters (+ excess, − gouge); a needle
//! that no position counts on is uncut.

mod bed;
mod boxes;
mod leave;
mod residual;
mod section;
mod side_by_side;
mod sweep;
mod tile;

pub use bed::{CutCounts, NeedleBed};
pub use leave::CutLeave;
pub use residual::Residual;
pub use side_by_side::{OneAfterAnother, SideBySide};
pub use sweep::SweepBatch;
