//! One path while it is solved, and what all steps of the work ask of it.
//!
//! The steps have a file each. [`super::examining`] finds both solutions of every direction. [`super::greedy`] and
//! [`super::cheapest`] choose among them, with [`super::weighing`]. [`super::joining`] makes joints of the choice.
//! [`super::window`] says of which poses the solutions are in memory.

use std::ops::{ControlFlow, Range};

use super::grid::Stage;
use super::inverse::{ROTARY_RANK, least_excess, turn_range};
use super::pose_source::PoseSource;
use super::window::Window;
use super::{InverseError, JointLanes, Kinematics, Path, PathOptions};
use crate::machine::Motion;

/// Bits of a mark: the branch exists, and X Y Z are within travel.
pub(super) const ALIVE: [u8; 2] = [1, 2];
/// Both branches are alive, and nothing is special.
pub(super) const PLAIN: u8 = 3;
/// Inside the pole cone: u is held.
pub(super) const HELD: u8 = 4;
/// Near the pole or the reach limit: the pose has a residual to report.
pub(super) const LIMIT: u8 = 8;

/// The words of both branches \[deg\]: u and v of the first, then u and v of the second. They are kept in the memory
/// that takes the joints later. Once a choice is made, the first two are the chosen words, whole turns included.
#[inline]
pub(super) fn branch_words(memory: &JointLanes) -> [&[f64]; 4] {
    [&memory.x_mm, &memory.y_mm, &memory.z_mm, &memory.first_rad]
}

/// The same, to be written.
#[inline]
pub(super) fn branch_words_mut(memory: &mut JointLanes) -> [&mut [f64]; 4] {
    [&mut memory.x_mm, &mut memory.y_mm, &mut memory.z_mm, &mut memory.first_rad]
}

/// Says whether the caller wants to stop.
pub(super) trait Stop: Fn() -> ControlFlow<()> {}
impl<S: Fn() -> ControlFlow<()> + ?Sized> Stop for S {}

/// One path being solved. Its output holds [the words](branch_words) until [`Walk::join`] makes joints of them.
pub(super) struct Walk<'a, P: ?Sized, S: ?Sized> {
    /// The machine.
    pub(super) kinematics: &'a Kinematics,
    pub(super) poses: &'a P,
    pub(super) options: &'a PathOptions,
    /// Without lanes.
    pub(super) singly: bool,
    /// Words before the first pose, in the order u, v \[deg\].
    pub(super) start: Option<[f64; 2]>,
    /// Asked once per block.
    pub(super) stop: &'a S,
    /// What is handed over at the end.
    pub(super) out: Path,
    /// What is special about each pose: [`ALIVE`], [`HELD`], [`LIMIT`].
    pub(super) marks: Vec<u8>,
    /// The pose in the first place of the arrays of words and marks.
    pub(super) first_kept: usize,
    /// If not all poses are in memory at the same time.
    pub(super) window: Option<Window>,
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// Fails if the caller wants to stop.
    pub(super) fn go_on(&self) -> Result<(), InverseError> {
        match (self.stop)() {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(InverseError::Stopped),
        }
    }

    /// A pose as the choice sees it, before its choice is written over its words.
    pub(super) fn stage(&self, pose: usize) -> Stage {
        let mark = self.mark(pose);
        let [first_u, first_v, second_u, second_v] = self.both(pose);
        Stage {
            words_deg: [[first_u, first_v], [second_u, second_v]],
            alive: [mark & ALIVE[0] != 0, mark & ALIVE[1] != 0],
            held: mark & HELD != 0,
        }
    }

    /// Why no state of this pose can be reached.
    pub(super) fn no_way(&self, pose: usize) -> InverseError {
        if self.mark(pose) & HELD == 0 {
            if let Err(error) = self.kinematics.candidates(pose, &self.poses.pose(pose), 0.0) {
                return error;
            }
            return InverseError::NoWay { pose };
        }
        let stage = self.stage(pose);
        let kinematics = self.kinematics;
        let mut told: Option<(f64, InverseError)> = None;
        for words in stage.words_deg {
            let linear_mm = kinematics.joints_at(self.poses.pose(pose).tip_mm, words).linear_mm;
            let mut misses = kinematics.linear_miss(pose, linear_mm);
            for (k, word) in words.into_iter().enumerate() {
                if let (true, Some(travel)) =
                    (turn_range(word, kinematics.travel_deg[k]).is_empty(), kinematics.travel_deg[k])
                {
                    let (commanded, excess) = least_excess(word, travel);
                    let axis = Motion::Rotary(kinematics.profile_index[k]);
                    let (min, max) = (travel.min, travel.max);
                    let error = InverseError::OutOfTravel { pose, axis, commanded, min, max };
                    misses = Some((ROTARY_RANK + excess, error));
                }
            }
            if let Some((excess, error)) = misses
                && told.is_none_or(|(least, _)| excess < least)
            {
                told = Some((excess, error));
            }
        }
        told.map_or(InverseError::NoWay { pose }, |(_, error)| error)
    }

    /// Writes the chosen words of u, v \[deg\] over those of the first branch.
    pub(super) fn choose(&mut self, pose: usize, chosen_deg: [f64; 2]) {
        let place = self.place(pose);
        for (kept, word) in branch_words_mut(&mut self.out.joints).into_iter().zip(chosen_deg) {
            kept[place] = word;
        }
    }

    /// [`branch_words`] of one pose.
    pub(super) fn both(&self, pose: usize) -> [f64; 4] {
        let place = self.place(pose);
        branch_words(&self.out.joints).map(|kept| kept[place])
    }

    /// What is special about a pose.
    pub(super) fn mark(&self, pose: usize) -> u8 {
        self.marks[self.place(pose)]
    }

    /// Where a pose is in the arrays of words and marks.
    #[inline]
    pub(super) fn place(&self, pose: usize) -> usize {
        pose - self.first_kept
    }

    /// Where some poses are in the arrays of words and marks.
    #[inline]
    pub(super) fn places(&self, poses: &Range<usize>) -> Range<usize> {
        let begin = self.place(poses.start);
        begin..begin + poses.len()
    }
}
