//! A motion of a region that waits for the end of the region.

use std::sync::Arc;

use crate::contact::Station;
use crate::kinematics::Kinematics;
use crate::machine::Tool;
use crate::motion::{ContactWords, Interpolation, Motion};

/// How a block states a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StatedAxes {
    Absent,
    /// By the number of the place.
    Absolute,
    /// By the number of the distance.
    Incremental,
}

/// A motion of a region.
#[derive(Debug, Clone)]
pub(super) struct Pending {
    pub(super) motion: Motion,
    /// The machine with the set-up of the motion.
    pub(super) kinematics: Arc<Kinematics>,
    /// The cutter of the motion. If it is not known, a placeholder on which nothing depends.
    pub(super) tool: Tool,
    /// Whether the positions of the axes are known under tool-centre-point control.
    pub(super) is_stated: bool,
    /// The number of the motion in the program.
    pub(super) index: u64,
    pub(super) mode: Interpolation,
    pub(super) ends: [Station; 2],
    /// Contact words of the start point itself.
    pub(super) start_contact: ContactWords,
    /// The last contact words stated up to the start, which still hold.
    pub(super) standing: ContactWords,
    /// X Y Z, then the rotary axes in the order of the profile.
    pub(super) axes: [StatedAxes; 5],
    /// U V W.
    pub(super) contact: [bool; 3],
    /// Least and largest φ along the motion \[rad\].
    pub(super) polar_rad: [f64; 2],
    /// A rotary axis turns.
    pub(super) turns: bool,
}
