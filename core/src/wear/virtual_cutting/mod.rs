//! Virtual cutting: the residual of the stock over a surface after cutting, sample by sample (P3 §4.2).
//!
//! Every sample has a *needle* `p + s·ν` along its normal, with s up to the stock's height H. A tool position
//! counts if the part of the needle inside the cutter contains s = H: it reaches the outside, unlike a tool on the
//! far side of a thin wall. It also counts if that part contains s = 0, the surface itself: from any side, it
//! gouges. The residual is the smallest s at which a counting position enters (+ excess, − gouge). A needle without
//! a counting position is uncut.

mod bed;
mod boxes;
mod leave;
mod residual;
mod section;
mod sweep;
mod tile;

pub use bed::{CutCounts, NeedleBed};
pub use leave::CutLeave;
pub use residual::Residual;
pub use sweep::SweepBatch;
