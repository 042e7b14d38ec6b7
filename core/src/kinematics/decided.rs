//! A path that is decided, and whose joints are made piece by piece when they are wanted.

use std::ops::{ControlFlow, Range};

use super::choice::Way;
use super::grid::Grid;
use super::joining::Joiner;
use super::lanes::{BLOCK, Lane};
use super::pose_source::PoseSource;
use super::relaxed::Relaxed;
use super::walk::{Stop, Walk};
use super::{InverseError, Kinematics, Path, PathOptions, REWIND_DEG};

/// The cheapest way through all poses.
pub(super) struct Course {
    pub(super) along: Along,
    /// The number of warnings along it.
    pub(super) warnings: usize,
}

/// How the words of a course are found.
pub(super) enum Along {
    /// As if axes of several turns were unlimited, and then shifted.
    Relaxed(Relaxed),
    /// State by state.
    States(Grid, Way),
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// Writes the words of u, v \[deg\] of a block along a course. `previous` are the words before the block. True if
    /// it is known that no step is a rewind.
    pub(super) fn follow_course(
        &self,
        course: &Course,
        block: Range<usize>,
        previous: &mut Option<[f64; 2]>,
        [us, vs]: &mut [Lane; 2],
    ) -> bool {
        let words = [&mut us[..block.len()], &mut vs[..block.len()]];
        let is_small = match &course.along {
            Along::Relaxed(path) => self.follow_relaxed(path, block.start, previous, words),
            Along::States(grid, way) => self.follow(grid, way, block, previous, words),
        };
        is_small && self.options.rewind_deg >= REWIND_DEG
    }
}

/// Says whether the caller wants to stop, on any thread.
type SharedStop<'a> = dyn Fn() -> ControlFlow<()> + Sync + 'a;

/// A path whose choice is made, and whose joints are made block by block.
pub struct DecidedPath<'a> {
    walk: Walk<'a, dyn PoseSource + 'a, SharedStop<'a>>,
    course: Course,
    joiner: Joiner,
    /// Words of u, v before the next block, as [`Walk::follow_course`] wants them \[deg\].
    previous: Option<[f64; 2]>,
    /// The first pose without joints.
    next: usize,
}

impl Kinematics {
    /// Decides the cheapest path through the poses, as [`Kinematics::path_lanes`] does with
    /// [`super::Selection::Cheapest`]. Its joints are made later, piece by piece, with the same bits. Beside the poses it
    /// needs few bytes for each, unless [`Kinematics::has_several_turns`].
    ///
    /// `stop` is asked once per block of poses, and once more before the decision is handed over.
    ///
    /// # Errors
    /// As for [`Kinematics::path`]. Once a path is decided, only a stop can end it.
    pub fn decide_path<'a>(
        &'a self,
        poses: &'a (dyn PoseSource + 'a),
        options: &'a PathOptions,
        stop: &'a SharedStop<'a>,
    ) -> Result<DecidedPath<'a>, InverseError> {
        let mut walk = self.walk(poses, options, stop, Path::default())?;
        if self.has_several_turns() {
            walk.examine_all()?;
        } else {
            walk.open_window()?;
        }
        let course = walk.decide(Grid::new(self.travel_deg))?;
        walk.go_on()?;
        let (joiner, previous) = (walk.joiner(), walk.start);
        Ok(DecidedPath { walk, course, joiner, previous, next: 0 })
    }
}

impl DecidedPath<'_> {
    /// The number of poses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.walk.poses.count()
    }

    /// Whether there is no pose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of warnings that the path has.
    #[must_use]
    pub fn warnings(&self) -> usize {
        self.course.warnings
    }

    /// Replaces `piece` by the joints of the next poses: whole blocks, so that there are at least `poses` of them, or
    /// the last. After the last pose, `piece` is empty. The warnings count poses from the first of the path. The stop is
    /// asked once per block, and once more before the piece is handed over.
    ///
    /// # Errors
    /// The caller wants to stop.
    pub fn next_piece(&mut self, poses: usize, piece: &mut Path) -> Result<(), InverseError> {
        piece.joints.clear();
        piece.conditioning.clear();
        piece.warnings.clear();
        let end = self.len().min(self.next.saturating_add(poses));
        while self.next < end {
            let block = self.next..self.len().min(self.next + BLOCK);
            self.next = block.end;
            let Self { walk, course, joiner, previous, .. } = self;
            walk.go_on()?;
            walk.bring(block.clone())?;
            let is_small = walk.follow_course(course, block.clone(), previous, &mut joiner.words_deg);
            walk.join(joiner, block.clone(), is_small);
            let (places, out) = (walk.places(&block), &mut walk.out);
            for (lane, joined) in piece.joints.each_mut().into_iter().zip(out.joints.each_mut()) {
                lane.extend_from_slice(&joined[places.clone()]);
            }
            piece.conditioning.extend_from_slice(&out.conditioning[places]);
            piece.warnings.append(&mut out.warnings);
        }
        self.walk.go_on()
    }
}
