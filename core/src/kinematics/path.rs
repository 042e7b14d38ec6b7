//! One set of joints for each pose of a path: `path` selection of §1.

use std::ops::ControlFlow;

use super::grid::Grid;
use super::pose_source::PoseSource;
use super::walk::{Stop, Walk};
use super::{InstructionSet, InverseError, JointLanes, Joints, Kinematics, PoseLanes, ToolPose};
use crate::machine::{Motion, Travel};

/// A rotary step above this is a rewind \[deg\].
pub const REWIND_DEG: f64 = 120.0;
/// Largest number of poses times combinations of branch and turn of one path. It limits the memory.
pub const MAX_CELLS: usize = 1 << 26;
/// With more states than this, a path that fits is taken even if ties were decided without the travels.
pub(super) const RELAX_ABOVE: usize = 64;

/// How one candidate of each pose is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Selection {
    /// The cheapest way through all poses (dynamic programming).
    #[default]
    Cheapest,
    /// At each pose the candidate nearest to the previous one. This is faster, but the path may run into the end of
    /// a travel.
    Nearest,
}

/// Largest number of poses that are solved one by one. A block of lanes costs the same for any number of poses, as
/// much as seven to ten poses one by one (measured: 1 pose 0.6 µs against 2.7 µs, 8 poses 3 to 3.9 against 2.7 to 4.1,
/// 16 poses 6 to 7.8 against 2.8 to 4.5).
const FEW: usize = 8;

/// Whether poses are solved side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Lanes {
    /// If there are enough of them.
    #[default]
    ByCount,
    /// Always: to prove that the result is the same.
    Always,
    /// Never: to prove that the result is the same.
    Never,
}

/// The settings of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOptions {
    /// NC words of the rotary axes before the first pose, in the profile's order \[deg\]. Without them the first
    /// pose costs nothing.
    pub start_words_deg: Option<[f64; 2]>,
    /// A rotary step above this is a rewind \[deg\].
    pub rewind_deg: f64,
    /// The method of choice.
    pub selection: Selection,
    /// The widest instructions to use. The result does not depend on them.
    pub instructions: InstructionSet,
    /// Which poses are solved in lanes. The result does not depend on it.
    pub lanes: Lanes,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self {
            start_words_deg: None,
            rewind_deg: REWIND_DEG,
            selection: Selection::Cheapest,
            instructions: InstructionSet::Fastest,
            lanes: Lanes::ByCount,
        }
    }
}

/// A warning about a pose of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathWarning {
    /// 0-based index of the pose.
    pub pose: usize,
    /// The kind.
    pub kind: WarningKind,
    /// Angle between the tool axis and the pose's \[rad\].
    pub axis_residual_rad: f64,
}

/// Kinds of [`PathWarning`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WarningKind {
    /// A rotary axis turns by more than the threshold to reach this pose.
    Rewind,
    /// Inside the pole cone: the axis next to the workpiece was held.
    PoleHold,
    /// Beyond the reach limit by no more than the tilt of the location errors: best fit.
    ReachLimit,
}

/// Joints along a path, one set per pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// Axis positions; words through [`crate::machine::RotaryAxis::word_deg`].
    pub joints: JointLanes,
    /// |t·(u × v′)| of each pose: 0 at the pole and at the reach limit.
    pub conditioning: Vec<f64>,
    /// Warnings in the order of the poses.
    pub warnings: Vec<PathWarning>,
}

impl Path {
    /// The joints of one pose.
    #[must_use]
    pub fn get(&self, pose: usize) -> Option<Joints> {
        Some(Joints {
            linear_mm: [
                *self.joints.x_mm.get(pose)?,
                *self.joints.y_mm.get(pose)?,
                *self.joints.z_mm.get(pose)?,
            ]
            .into(),
            rotary_rad: [*self.joints.first_rad.get(pose)?, *self.joints.second_rad.get(pose)?],
        })
    }
}

impl Kinematics {
    /// Chooses one set of joints for each pose. Travels are hard limits, for X Y Z too. An unlimited axis takes the
    /// nearest turn. Cost: rewinds first, then travel Σ(|Δu| + |Δv|); travels within 1e-6° tie, and the smaller
    /// Σ|angle| wins. Inside the pole cone ([`Kinematics::pole_cone_rad`]) u keeps its previous word (first pose:
    /// the start's, otherwise that of the next pose outside, otherwise 0). v gets its best fit, and the tip stays
    /// exact.
    ///
    /// `stop` is asked once per block of poses.
    ///
    /// # Errors
    /// The first pose without direction, out of reach or out of travel; too many turns; a stop by the caller.
    pub fn path(
        &self,
        poses: &[ToolPose],
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Path, InverseError> {
        let mut path = Path::default();
        self.path_of(poses, options, stop, &mut path)?;
        Ok(path)
    }

    /// [`Kinematics::path`] into a path whose memory is used again, for many paths one after the other.
    ///
    /// # Errors
    /// As for [`Kinematics::path`]; `path` then means nothing.
    pub fn path_into(
        &self,
        poses: &[ToolPose],
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
        path: &mut Path,
    ) -> Result<(), InverseError> {
        self.path_of(poses, options, stop, path)
    }

    /// [`Kinematics::path`] for poses in arrays: faster, because nothing is rearranged.
    ///
    /// # Errors
    /// As for [`Kinematics::path`].
    pub fn path_lanes(
        &self,
        poses: &PoseLanes,
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Path, InverseError> {
        let mut path = Path::default();
        self.path_of(poses, options, stop, &mut path)?;
        Ok(path)
    }

    /// [`Kinematics::path_lanes`] into a path whose memory is used again, for many paths one after the other.
    ///
    /// # Errors
    /// As for [`Kinematics::path`]; `path` then means nothing.
    pub fn path_lanes_into(
        &self,
        poses: &PoseLanes,
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
        path: &mut Path,
    ) -> Result<(), InverseError> {
        self.path_of(poses, options, stop, path)
    }

    /// Combinations of branch and turns kept per pose, for estimates before the work starts.
    #[must_use]
    pub fn path_states(&self) -> usize {
        let states = Grid::new(self.travel_deg).states();
        if states > RELAX_ABOVE { 2 } else { states }
    }

    /// Whether a rotary axis has several turns within its travel. The choice then takes many passes along a path, so
    /// its solutions stay in memory.
    #[must_use]
    pub fn has_several_turns(&self) -> bool {
        Grid::new(self.travel_deg).count != [1; 2]
    }

    /// The number of combinations of branch and turns that a choice over all poses keeps for `poses` poses. Each
    /// takes two bytes of memory.
    #[must_use]
    pub fn path_cells(&self, poses: usize) -> usize {
        Grid::new(self.travel_deg).states().saturating_mul(poses).min(MAX_CELLS)
    }

    fn path_of<P: PoseSource + ?Sized>(
        &self,
        poses: &P,
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
        out: &mut Path,
    ) -> Result<(), InverseError> {
        let mut walk = self.walk(poses, options, stop, std::mem::take(out))?;
        let solved = walk.solve(Grid::new(self.travel_deg));
        *out = walk.out;
        solved
    }

    /// A path before its first step. `out` is memory to use again.
    pub(super) fn walk<'a, P: PoseSource + ?Sized, S: ?Sized>(
        &'a self,
        poses: &'a P,
        options: &'a PathOptions,
        stop: &'a S,
        out: Path,
    ) -> Result<Walk<'a, P, S>, InverseError> {
        let start = options.start_words_deg.map(|words| self.profile_index.map(|index| words[index]));
        if let Some(words) = start {
            self.check_start(words)?;
        }
        let singly = match options.lanes {
            Lanes::ByCount => poses.count() <= FEW,
            Lanes::Always => false,
            Lanes::Never => true,
        };
        let (marks, first_kept, window) = (Vec::new(), 0, None);
        Ok(Walk { kinematics: self, poses, options, singly, start, stop, out, marks, first_kept, window })
    }

    fn check_start(&self, words_deg: [f64; 2]) -> Result<(), InverseError> {
        for (k, commanded) in words_deg.into_iter().enumerate() {
            let axis = Motion::Rotary(self.profile_index[k]);
            let max_abs = crate::machine::Machine::MAX_TRAVEL_DEG;
            let Travel { min, max } = self.travel_deg[k].unwrap_or(Travel { min: -max_abs, max: max_abs });
            // NaN is outside too.
            if !(Travel { min, max }).contains(commanded, super::COMPUTED_WORD_SLACK) {
                return Err(InverseError::StartOutOfTravel { axis, commanded, min, max });
            }
        }
        Ok(())
    }
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    fn solve(&mut self, grid: Grid) -> Result<(), InverseError> {
        let count = self.poses.count();
        if count == 0 {
            self.begin(0);
            return Ok(());
        }
        // A single pose has at most the start before it: the nearest state is the cheapest, without memory to
        // compare paths.
        let selection = if count == 1 { Selection::Nearest } else { self.options.selection };
        match selection {
            Selection::Nearest => self.take_nearest(grid),
            Selection::Cheapest => self.take_cheapest(grid),
        }
    }
}
