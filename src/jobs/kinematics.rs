//! Many poses or joints at a time, inside the pool.

use std::io;
use std::ops::ControlFlow;
use std::sync::Arc;

use thiserror::Error;

use super::{Cost, MachineUsed, ReceivedPoses, TooCostly, WaitingPoses};
use crate::kinematics::{
    DecidedPath, InverseError, Kinematics, PathOptions, PathWarning, PoseLanes, PoseSource, Setup, ToolPose,
    WarningKind,
};
use crate::machine::{Machine, Motion};
use crate::meter;
use crate::process::Stop;
use crate::units::Angle;
use crate::wire::{
    Fault, FaultList, JointWords, PathWords, Pose, PoseColumns, PoseWarning, PoseWarningKind, Selection,
    Solutions,
};

/// How many poses are computed between two checks of the stop.
const BETWEEN_STOPS: usize = 4096;

/// Memory of the solutions of one pose: joints, conditioning and a mark \[bytes\].
const SOLVED_BYTES: u64 = 6 * size_of::<f64>() as u64 + 1;

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum KinematicsFault {
    /// Bad values, each with its pointer.
    #[error("{} values are wrong", .0.len())]
    Values(Vec<Fault>),
    /// More poses than the limit.
    #[error("{count} poses are more than the limit of {limit}; split the request")]
    TooMany {
        /// Number of poses.
        count: usize,
        /// Limit.
        limit: usize,
    },
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// A pose cannot be reached.
    #[error("{detail}")]
    Unreachable {
        /// Index of the first such pose.
        pose: usize,
        /// The reason, with numbers.
        detail: String,
    },
    /// The client has left.
    #[error("cancelled")]
    Cancelled,
}

/// Most candidates that one answer may hold: a wide travel has tens of thousands for a single pose.
const MAX_CANDIDATES: usize = 1_000_000;

/// The largest cost of a computation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Most poses.
    pub max_poses: usize,
    /// Largest estimate \[s of one core\].
    pub max_cost_s: f64,
}

impl Limits {
    fn check(&self, count: usize, candidates: usize) -> Result<(), KinematicsFault> {
        if count > self.max_poses {
            return Err(KinematicsFault::TooMany { count, limit: self.max_poses });
        }
        Ok(Cost::of_poses(count, candidates).within(self.max_cost_s)?)
    }
}

/// The poses of `joints`.
///
/// # Errors
/// Every bad value, too many joints, or the client has left.
pub fn forward(
    machine: &Machine,
    setup: &Setup,
    joints: &[JointWords],
    limits: Limits,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Vec<Pose>, KinematicsFault> {
    limits.check(joints.len(), 0)?;
    let kinematics = Kinematics::new(machine, setup);
    let mut faults = FaultList::default();
    let mut poses = Vec::with_capacity(joints.len());
    for (chunk_index, chunk) in joints.chunks(BETWEEN_STOPS).enumerate() {
        if stop().is_break() {
            return Err(KinematicsFault::Cancelled);
        }
        for (offset, words) in chunk.iter().enumerate() {
            let index = chunk_index * BETWEEN_STOPS + offset;
            if let Some(joints) = words.to_core(machine, index, &mut faults) {
                poses.push(Pose::from(kinematics.forward(&joints)));
            }
        }
    }
    faults.into_result().map_err(KinematicsFault::Values)?;
    meter::POSES.add(poses.len() as u64);
    Ok(poses)
}

/// Solutions and their warnings.
#[derive(Debug, Clone, PartialEq)]
pub struct InverseAnswer {
    /// Solutions pose after pose.
    pub solutions: Solutions,
    /// Warnings.
    pub warnings: Vec<PoseWarning>,
}

/// A task for the inverse kinematics on one machine.
#[derive(Debug, Clone)]
pub struct InverseTask {
    on: Arc<MachineUsed>,
    kinematics: Kinematics,
    selection: Selection,
    start_words_deg: Option<[f64; 2]>,
}

impl InverseTask {
    /// The task with this selection and this set-up (work offset, tool length, errors). `start_words_deg` are the
    /// rotary words before the first pose, in the profile's order.
    #[must_use]
    pub fn new(
        on: Arc<MachineUsed>,
        setup: &Setup,
        selection: Selection,
        start_words_deg: Option<[f64; 2]>,
    ) -> Self {
        Self { kinematics: on.kinematics(setup), on, selection, start_words_deg }
    }

    /// Whether this many poses are so few that they are solved on the thread of the request.
    #[must_use]
    pub fn is_trifling(&self, poses: usize) -> bool {
        Cost::of_poses(poses, self.answers()).is_trifling()
    }

    /// The machine.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.on.machine
    }

    /// How many answers one pose can have.
    fn answers(&self) -> usize {
        match self.selection {
            Selection::Path => self.kinematics.path_states(),
            Selection::All => self.kinematics.max_candidates(),
        }
    }

    /// Whether there is one answer for each pose.
    #[must_use]
    pub fn is_path(&self) -> bool {
        self.selection == Selection::Path
    }

    /// Whether the poses of a table may wait in a file: there is then a fixed number of passes along the path, in
    /// order.
    #[must_use]
    pub fn may_wait(&self) -> bool {
        self.is_path() && !self.kinematics.has_several_turns()
    }

    /// Memory to decide the path through this many poses, in addition to the poses \[bytes\]: for each pose its state,
    /// and the way to every state. With several turns, the solutions too.
    #[must_use]
    pub fn deciding_bytes(&self, poses: usize) -> u64 {
        let solved = if self.kinematics.has_several_turns() { SOLVED_BYTES } else { 0 };
        self.way_bytes(poses) + (poses as u64) * solved
    }

    fn way_bytes(&self, poses: usize) -> u64 {
        let cells = self.kinematics.path_cells(poses).saturating_add(poses);
        cells.saturating_mul(size_of::<u16>()) as u64
    }

    /// Memory of the joints of this many poses while they are solved, in addition to the poses \[bytes\]: for each
    /// pose the joints, their conditioning and a mark, and what it takes to decide the path.
    #[must_use]
    pub fn working_bytes(&self, poses: usize) -> u64 {
        let bytes = match self.selection {
            Selection::Path => return self.way_bytes(poses) + (poses as u64) * SOLVED_BYTES,
            // Their list grows by doubling.
            Selection::All => {
                let count = poses.saturating_mul(self.kinematics.max_candidates()).min(MAX_CANDIDATES);
                count.saturating_mul(3 * size_of::<JointWords>() / 2)
            }
        };
        bytes as u64
    }

    /// The joints of `poses`.
    ///
    /// # Errors
    /// Every bad value, too many poses, a pose out of reach, or the client has left.
    pub fn solve(
        &self,
        poses: PoseColumns,
        limits: Limits,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<InverseAnswer, KinematicsFault> {
        let poses = self.checked(poses, limits)?;
        let answer = match self.selection {
            Selection::Path => self.path(&poses, stop),
            Selection::All => self.all(&poses, stop),
        }?;
        meter::POSES.add(poses.len() as u64);
        Ok(answer)
    }

    /// The poses, if there are not too many.
    ///
    /// # Errors
    /// Every bad value, or too many poses.
    fn checked(&self, poses: PoseColumns, limits: Limits) -> Result<PoseLanes, KinematicsFault> {
        let answers = self.answers();
        limits.check(poses.len(), answers)?;
        let count = poses.len().saturating_mul(answers);
        if self.selection == Selection::All && count > MAX_CANDIDATES {
            return Err(KinematicsFault::TooMany { count, limit: MAX_CANDIDATES });
        }
        poses.into_core().map_err(KinematicsFault::Values)
    }

    /// The poses where they wait, if there are not too many. Blocks.
    ///
    /// # Errors
    /// Every bad value, too many poses, or their file cannot be written.
    pub fn waiting<E: From<KinematicsFault> + From<io::Error>>(
        &self,
        poses: ReceivedPoses,
        limits: Limits,
    ) -> Result<WaitingPoses, E> {
        let (columns, file) = poses.parts();
        Ok(WaitingPoses::new(self.checked(columns, limits)?, file)?)
    }

    /// How the path is chosen.
    #[must_use]
    pub fn path_options(&self) -> PathOptions {
        PathOptions { start_words_deg: self.start_words_deg, ..PathOptions::default() }
    }

    /// Decides the path through `poses`. Its joints are made later, and then only a stop can end it.
    ///
    /// # Errors
    /// A pose out of reach, or the client has left.
    pub fn decide<'a>(
        &'a self,
        poses: &'a dyn PoseSource,
        options: &'a PathOptions,
        stop: &'a Stop<'a>,
    ) -> Result<DecidedPath<'a>, KinematicsFault> {
        let decided = self.kinematics.decide_path(poses, options, stop);
        let decided = decided.map_err(|error| self.fault(error))?;
        meter::POSES.add(poses.count() as u64);
        Ok(decided)
    }

    /// The fault that an error of the core is for the client.
    #[must_use]
    pub fn fault(&self, error: InverseError) -> KinematicsFault {
        refused(&self.on.machine, error)
    }

    fn path(
        &self,
        poses: &PoseLanes,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<InverseAnswer, KinematicsFault> {
        let solved = self.kinematics.path_lanes(poses, &self.path_options(), stop);
        let solved = solved.map_err(|error| self.fault(error))?;
        let warnings = solved.warnings.iter().map(warning).collect();
        Ok(InverseAnswer { solutions: Solutions::Path(PathWords::new(&self.on.machine, solved)), warnings })
    }

    fn all(
        &self,
        poses: &PoseLanes,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<InverseAnswer, KinematicsFault> {
        let (mut joints, mut warnings) = (Vec::new(), Vec::new());
        let mut ends = Vec::with_capacity(poses.len());
        for (index, pose) in listed(poses).enumerate() {
            if index % BETWEEN_STOPS == 0 && stop().is_break() {
                return Err(KinematicsFault::Cancelled);
            }
            let found = self.kinematics.candidates(index, &pose, 0.0).map_err(|error| self.fault(error))?;
            for candidate in &found {
                joints.push(JointWords::from_core(
                    &self.on.machine,
                    &candidate.joints,
                    Some(candidate.conditioning),
                ));
            }
            let residual_rad = found.iter().map(|candidate| candidate.axis_residual_rad).fold(0.0, f64::max);
            if residual_rad > 0.0 {
                let axis_residual_urad = Some(Angle::from_rad(residual_rad).urad());
                warnings.push(PoseWarning {
                    pose: index,
                    kind: PoseWarningKind::ReachLimit,
                    axis_residual_urad,
                });
            }
            ends.push(joints.len());
        }
        Ok(InverseAnswer { solutions: Solutions::All { joints, ends }, warnings })
    }
}

/// The poses of all lanes.
fn listed(poses: &PoseLanes) -> impl Iterator<Item = ToolPose> {
    let PoseLanes { x_mm, y_mm, z_mm, i, j, k } = poses;
    let tips = x_mm.iter().zip(y_mm).zip(z_mm).map(|((x, y), z)| [*x, *y, *z].into());
    let axes = i.iter().zip(j).zip(k).map(|((i, j), k)| [*i, *j, *k].into());
    tips.zip(axes).map(|(tip_mm, axis)| ToolPose { tip_mm, axis })
}

fn warning(warning: &PathWarning) -> PoseWarning {
    let (kind, has_residual) = match warning.kind {
        WarningKind::Rewind => (PoseWarningKind::Rewind, false),
        WarningKind::PoleHold => (PoseWarningKind::PoleHold, true),
        WarningKind::ReachLimit => (PoseWarningKind::ReachLimit, true),
    };
    let axis_residual_urad = has_residual.then(|| Angle::from_rad(warning.axis_residual_rad).urad());
    PoseWarning { pose: warning.pose, kind, axis_residual_urad }
}

fn refused(machine: &Machine, error: InverseError) -> KinematicsFault {
    let letter = |axis: Motion| match axis {
        Motion::Rotary(index) => machine.rotary_axes().get(index).map_or('?', |axis| axis.letter.as_char()),
        Motion::Linear(index) => ['X', 'Y', 'Z'].get(index).copied().unwrap_or('?'),
    };
    match error {
        InverseError::OutOfTravel { pose, axis, commanded, min, max } => {
            let letter = letter(axis);
            let detail = format!("pose {pose}: {letter} {commanded} is outside the travel {min} to {max}");
            KinematicsFault::Unreachable { pose, detail }
        }
        InverseError::NoDirection { pose }
        | InverseError::OutOfReach { pose, .. }
        | InverseError::NoWay { pose } => KinematicsFault::Unreachable { pose, detail: error.to_string() },
        InverseError::StartOutOfTravel { axis, .. } => {
            KinematicsFault::Values(vec![Fault::new(format!("/start/{}", letter(axis)), error.to_string())])
        }
        InverseError::TooManyStates { poses, max_cells, states } => {
            KinematicsFault::TooMany { count: poses, limit: max_cells / states.max(1) }
        }
        InverseError::Stopped => KinematicsFault::Cancelled,
    }
}
