//! The state of a tilted working plane.

use super::{Unfollowable, WorkOffset};
use crate::geometry::PlaneFrame;
use crate::kinematics::PlaneWish;

/// A plane whose definition is understood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TiltedPlane {
    pub(super) frame: PlaneFrame,
    pub(super) wish: PlaneWish,
    pub(super) standing: Standing,
    /// The offsets when it was defined. Under other offsets its place is not known.
    pub(super) offsets: Offsets,
}

/// How the rotary axes stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Standing {
    /// They have not been turned to the plane, or it is not known that they were.
    Apart,
    /// The control has turned them. Which of its positions it took is not known.
    Undecided,
    /// The control has turned them to these words \[deg\].
    On([f64; 2]),
}

/// Everything that decides where the zero of the program is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Offsets {
    pub(super) work_offset: Option<WorkOffset>,
    pub(super) shifts: u32,
    pub(super) program_offset_mm: Option<[f64; 3]>,
    pub(super) datum_mm: [Option<f64>; 3],
}

impl TiltedPlane {
    /// Why a motion in this plane is not one of the machine's words.
    pub(super) fn obstacle(&self) -> Unfollowable {
        match self.standing {
            Standing::Apart | Standing::On(_) => Unfollowable::TiltedPlane,
            Standing::Undecided => Unfollowable::PlaneSolution,
        }
    }
}
