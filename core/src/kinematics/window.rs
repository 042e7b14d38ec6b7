//! Which poses of a path have their solutions in memory: all, or two blocks that move along the path.
//!
//! The choice among the solutions can depend on the last pose, so there are at least two passes along a path. To
//! solve a block again takes less time than it takes to print its joints, and the memory does not grow with the path.
//! Axes of several turns would have their blocks solved many times.

use std::ops::Range;

use super::InverseError;
use super::examining::Examination;
use super::lanes::BLOCK;
use super::pose_source::{PoseBlock, PoseSource};
use super::walk::{PLAIN, Stop, Walk};

/// What is known of a path that moves through the memory. No axis has several turns.
pub(super) struct Window {
    examination: Examination,
    /// Words of u of both branches with which a path begins inside the pole cone \[deg\].
    begins_with: Option<[f64; 2]>,
}

impl Window {
    /// Poses in memory: a block, and the one before it.
    pub(super) const PLACES: usize = 2 * BLOCK;
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// From now on, only two blocks are in memory.
    ///
    /// # Errors
    /// A pose before the first one outside the pole cone cannot be solved.
    pub(super) fn open_window(&mut self) -> Result<(), InverseError> {
        let mut examination = self.begin(Window::PLACES);
        if examination.is_waiting() {
            examination.held_u = Some(self.first_u_outside(examination.cone_rad)?);
        }
        let begins_with = examination.held_u;
        self.window = Some(Window { examination, begins_with });
        Ok(())
    }

    /// The words of u with which both branches leave the pole cone for the first time \[deg\]. They are 0 if no pose is
    /// outside.
    fn first_u_outside(&self, cone_rad: f64) -> Result<[f64; 2], InverseError> {
        let (count, mut copy) = (self.poses.count(), Box::new(PoseBlock::new()));
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let poses = self.poses.block(begin, &mut copy);
            for lane in 0..poses.count {
                let solution = self.kinematics.solution(begin + lane, &poses.pose(lane))?;
                if solution.polar_distance_rad > cone_rad {
                    return Ok(solution.words_deg.map(|words| words[0]));
                }
            }
        }
        Ok([0.0; 2])
    }

    /// Brings the solutions of a block into memory, if they are not there. Blocks are asked for in order, and again
    /// from the first one on.
    ///
    /// # Errors
    /// A pose of the block cannot be solved.
    pub(super) fn bring(&mut self, block: Range<usize>) -> Result<(), InverseError> {
        let Some(mut window) = self.window.take() else { return Ok(()) };
        let brought = self.bring_to(block, &mut window);
        self.window = Some(window);
        brought
    }

    /// Brings every block from `begin` on, only to find a pose that cannot be solved.
    ///
    /// # Errors
    /// There is one, or the caller wants to stop.
    pub(super) fn bring_rest(&mut self, begin: usize) -> Result<(), InverseError> {
        let count = self.poses.count();
        for begin in (begin..if self.window.is_some() { count } else { begin }).step_by(BLOCK) {
            self.go_on()?;
            self.bring(begin..count.min(begin + BLOCK))?;
        }
        Ok(())
    }

    fn bring_to(&mut self, block: Range<usize>, window: &mut Window) -> Result<(), InverseError> {
        let Window { examination, begins_with } = window;
        if block.start == 0 {
            self.first_kept = 0;
            examination.begin_again(*begins_with);
        } else if self.place(block.start) == Window::PLACES {
            let [last, before] = [Window::PLACES - 1, BLOCK - 1];
            for lane in self.out.joints.each_mut() {
                lane[before] = lane[last];
            }
            self.marks[before] = self.marks[last];
            self.first_kept += BLOCK;
        }
        let places = self.places(&block);
        self.marks[places].fill(PLAIN);
        self.point(block.start, examination);
        self.examine(block.start, examination)
    }
}
