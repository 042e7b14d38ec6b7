//! A motion of a region, as it waits until the region is whole.

use std::sync::Arc;

use crate::contact::Station;
use crate::kinematics::Kinematics;
use crate::machine::Tool;
use crate::motion::{ContactWords, Interpolation, Motion};

/// How a coordinate stands in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StatedContact {
    Absent,
    /// By a number that says where to.
    Absolute,
    /// By a number that says how far.
    Incremental,
}

/// A motion of a region.
#[derive(Debug, Clone)]
pub(super) struct Pending {
    pub(super) motion: Motion,
    /// The machine as it is set up for it.
    pub(super) kinematics: Arc<Kinematics>,
    /// Its cutter; one that nothing depends on where it is not known.
    pub(super) tool: Tool,
    /// Its number among the motions of the program.
    pub(super) index: u64,
    pub(super) mode: Interpolation,
    pub(super) ends: [Station; 2],
    /// Contact words at the start: those of the point itself.
    pub(super) start_contact: ContactWords,
    /// The last ones stated before, which still stand.
    pub(super) standing: ContactWords,
    /// X Y Z, the rotaries in the order of the profile.
    pub(super) axes: [StatedContact; 5],
    /// U V W.
    pub(super) contact: [bool; 3],
    /// Least and largest φ on the way \[rad\].
    pub(super) polar_rad: [f64; 2],
    /// A rotary axis turns.
    pub(super) turns: bool,
}
