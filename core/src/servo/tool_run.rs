//! The drives of a whole machine along its commands, streamed: joints in, contour error of the tool out.

use std::collections::VecDeque;
use std::sync::Arc;

use super::simulate::samples_in;
use super::statistics::{
    ContourErrorStatistics, ContourErrorSummary, FollowingErrorStatistics, FollowingErrorSummary, Trace,
    TracePoint,
};
use super::{AxisLetter, AxisServo, DriveSet, FootTracker, LOOK_AHEAD, ServoFault};
use crate::geometry::Vec3;
use crate::kinematics::{JointLanes, Kinematics, PoseLanes, ToolPose};

/// The result for the tool and its five axes.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolOutcome {
    /// Following error of each axis, in the order of the run; `None` if the axis never moved.
    pub following: [Option<FollowingErrorSummary>; 5],
    /// Contour error.
    pub contour: ContourErrorSummary,
    /// Samples in all.
    pub samples: u64,
    /// The run in a limited number of points.
    pub trace: Vec<TracePoint>,
}

/// A run of the whole machine, in any number of parts.
///
/// Sample k is judged once the command is known up to k + [`LOOK_AHEAD`]. Memory does not grow with the run.
#[derive(Debug)]
pub struct ToolRun<'a> {
    kinematics: Arc<Kinematics>,
    axes: [AxisLetter; 5],
    drives: &'a DriveSet,
    period_s: f64,
    plane_normal: Option<Vec3>,
    servos: [Servo; 5],
    tracker: FootTracker,
    longest_lag: usize,
    /// Time since which the tool has been too far behind for its foot to be found \[s\]; only if the search is
    /// shorter than the lag can be.
    lost_at_s: Option<f64>,
    is_search_cut: bool,
    /// Actual poses that wait for the command to continue.
    waiting: VecDeque<Waiting>,
    /// The next sample of this stretch to be judged, and the number of samples commanded.
    next: usize,
    commanded: usize,
    /// Samples of the whole run.
    samples: u64,
    judged_from: u64,
    /// Last commanded positions of the axes.
    last: [Option<f64>; 5],
    following: [FollowingErrorStatistics; 5],
    contour: ContourErrorStatistics,
    trace: Trace,
    /// Largest contour error of consecutive lines \[mm\], until they are taken; `None` unless asked for.
    line_peaks: Option<Vec<(u64, f64)>>,
    commanded_poses: PoseLanes,
    actual: JointLanes,
    actual_poses: PoseLanes,
}

/// An axis is behind its command by 1/Kpp, and never by ten times that.
const LAG_TIMES: f64 = 10.0;
/// Bounds of the search for the foot \[samples\]. The upper one limits its cost.
const SHORTEST_LAG: f64 = 64.0;
const LONGEST_LAG: f64 = 20_000.0;

#[derive(Debug)]
enum Servo {
    /// Has not moved yet: it is at its commanded position.
    Resting,
    /// Follows its commands.
    Moving(Box<AxisServo>),
}

#[derive(Debug, Clone, Copy)]
struct Waiting {
    pose: ToolPose,
    line: u64,
    following: [f64; 5],
}

impl<'a> ToolRun<'a> {
    /// Continues with the machine in this set-up. The axes are at rest at this moment.
    pub fn set_up(&mut self, kinematics: &Arc<Kinematics>) {
        self.kinematics = Arc::clone(kinematics);
    }

    /// A run before its start. `axes`: X, Y, Z and the rotary axes in the profile's order. `plane_normal` gives
    /// contour errors a sign. Samples before `judged_from` count in no summary.
    #[must_use]
    pub fn new(
        kinematics: &Arc<Kinematics>,
        axes: [AxisLetter; 5],
        drives: &'a DriveSet,
        period_s: f64,
        plane_normal: Option<Vec3>,
        judged_from: u64,
    ) -> Self {
        let slowest_per_s = axes
            .iter()
            .filter_map(|axis| drives.get(*axis))
            .fold(f64::INFINITY, |least, drive| least.min(drive.position_gain_per_s));
        let lag = LAG_TIMES / (slowest_per_s * period_s);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let longest_lag = lag.clamp(SHORTEST_LAG, LONGEST_LAG) as usize;
        Self {
            kinematics: Arc::clone(kinematics),
            axes,
            drives,
            period_s,
            plane_normal,
            servos: std::array::from_fn(|_| Servo::Resting),
            tracker: FootTracker::new(plane_normal, longest_lag),
            longest_lag,
            lost_at_s: None,
            is_search_cut: lag > LONGEST_LAG,
            waiting: VecDeque::new(),
            next: 0,
            commanded: 0,
            samples: 0,
            judged_from,
            last: [None; 5],
            following: Default::default(),
            contour: ContourErrorStatistics::default(),
            trace: Trace::new(),
            line_peaks: None,
            commanded_poses: PoseLanes::default(),
            actual: JointLanes::default(),
            actual_poses: PoseLanes::default(),
        }
    }

    /// Follows the next samples. `lines` are those of the program; empty without a program.
    ///
    /// # Errors
    /// An axis begins to move whose drive is missing, unstable or too stiff; the tool is farther behind than the
    /// search for it.
    pub fn follow(&mut self, commands: &JointLanes, lines: &[u64]) -> Result<(), ServoFault> {
        let lanes = lanes(commands);
        let actual = lanes_mut(&mut self.actual);
        for (slot, (lane, out)) in lanes.into_iter().zip(actual).enumerate() {
            out.clear();
            let (Some(first), Some(last)) = (lane.first(), lane.last()) else { return Ok(()) };
            let rest = self.last[slot].replace(*last).unwrap_or(*first);
            if matches!(self.servos[slot], Servo::Resting) && lane.iter().any(|at| (*at - rest).abs() > 0.0) {
                let servo = self.drives.servo(self.axes[slot], self.period_s, rest)?;
                self.servos[slot] = Servo::Moving(Box::new(servo));
            }
            match &mut self.servos[slot] {
                Servo::Resting => out.extend_from_slice(lane),
                Servo::Moving(servo) => servo.follow(lane, out),
            }
            let unjudged = self.judged_from.saturating_sub(self.samples).min(lane.len() as u64);
            #[expect(clippy::cast_possible_truncation, reason = "at most the length of a lane")]
            let unjudged = unjudged as usize;
            if let Servo::Moving(_) = self.servos[slot] {
                self.following[slot].take(&lane[unjudged..], &out[unjudged..]);
            }
        }
        self.kinematics.forward_lanes(commands, &mut self.commanded_poses);
        self.kinematics.forward_lanes(&self.actual, &mut self.actual_poses);
        for k in 0..commands.len() {
            let line = lines.get(k).copied().unwrap_or(0);
            self.tracker.command(&pose_of(&self.commanded_poses, k));
            let now = lanes.map(|lane| lane[k]);
            let is = self::lanes(&self.actual).map(|lane| lane[k]);
            let following = std::array::from_fn(|slot| now[slot] - is[slot]);
            self.waiting.push_back(Waiting { pose: pose_of(&self.actual_poses, k), line, following });
        }
        self.commanded += commands.len();
        self.samples += commands.len() as u64;
        self.judge(LOOK_AHEAD);
        self.tracker.trim();
        self.check_foot()
    }

    /// The largest contour errors \[mm\] of the lines judged since the last call, in order. They are kept from the
    /// first call on. The same line may come again at the start of the next call's result.
    pub fn take_line_peaks(&mut self) -> Vec<(u64, f64)> {
        self.line_peaks.replace(Vec::new()).unwrap_or_default()
    }

    fn check_foot(&self) -> Result<(), ServoFault> {
        match self.lost_at_s {
            Some(at_s) => Err(ServoFault::TooFarBehind { at_s, samples: self.longest_lag }),
            None => Ok(()),
        }
    }

    /// Number of further samples after the command came to rest until the slowest moved axis is at rest too. The
    /// tool then arrives, and overshoot is seen.
    #[must_use]
    pub fn settling_samples(&self) -> usize {
        let moving = |slot: &usize| matches!(self.servos[*slot], Servo::Moving(_));
        let axes: Vec<AxisLetter> = (0..self.axes.len()).filter(moving).map(|slot| self.axes[slot]).collect();
        samples_in(self.drives.settling_s(&axes), self.period_s)
    }

    /// The command leaves the path here: the next samples start from rest, at another position.
    pub fn lift(&mut self) {
        self.judge(0);
        self.tracker = FootTracker::new(self.plane_normal, self.longest_lag);
        (self.next, self.commanded) = (0, 0);
        self.servos = std::array::from_fn(|_| Servo::Resting);
        self.last = [None; 5];
        for statistics in &mut self.following {
            statistics.lift();
        }
    }

    /// The result of all samples.
    ///
    /// # Errors
    /// The tool was farther behind its command than the search for it.
    pub fn finish(mut self) -> Result<ToolOutcome, ServoFault> {
        self.judge(0);
        self.check_foot()?;
        let following = std::array::from_fn(|slot| {
            let drive = self.drives.get(self.axes[slot])?;
            let statistics = &self.following[slot];
            statistics
                .has_moved()
                .then(|| statistics.summary(self.period_s, drive.velocity_gain_factor_per_s()))
        });
        Ok(ToolOutcome {
            following,
            contour: self.contour.summary(true),
            samples: self.samples,
            trace: self.trace.into_points(),
        })
    }

    fn judge(&mut self, ahead: usize) {
        while self.next + ahead < self.commanded
            && let Some(Waiting { pose, line, following }) = self.waiting.pop_front()
        {
            let error = self.tracker.judge(&pose, self.next);
            // Sample of the whole run: the waiting samples are its last.
            let sample = self.samples - self.waiting.len() as u64 - 1;
            let time_s = sample as f64 * self.period_s;
            if self.tracker.is_lost() && self.is_search_cut {
                self.lost_at_s = self.lost_at_s.or(Some(time_s));
            }
            if sample >= self.judged_from {
                self.contour.take(error.tip_mm, error.axis_rad, time_s, line);
                if let Some(peaks) = &mut self.line_peaks {
                    match peaks.last_mut() {
                        Some((same, peak_mm)) if *same == line => *peak_mm = peak_mm.max(error.tip_mm.abs()),
                        _ => peaks.push((line, error.tip_mm.abs())),
                    }
                }
            }
            self.trace.take(TracePoint {
                time_s,
                line,
                phi_rad: 0.0,
                contour_mm: error.tip_mm,
                axis_rad: error.axis_rad,
                following,
            });
            self.next += 1;
        }
    }
}

fn lanes(joints: &JointLanes) -> [&[f64]; 5] {
    [&joints.x_mm, &joints.y_mm, &joints.z_mm, &joints.first_rad, &joints.second_rad]
}

fn lanes_mut(joints: &mut JointLanes) -> [&mut Vec<f64>; 5] {
    [&mut joints.x_mm, &mut joints.y_mm, &mut joints.z_mm, &mut joints.first_rad, &mut joints.second_rad]
}

fn pose_of(poses: &PoseLanes, k: usize) -> ToolPose {
    ToolPose {
        tip_mm: Vec3::new(poses.x_mm[k], poses.y_mm[k], poses.z_mm[k]),
        axis: Vec3::new(poses.i[k], poses.j[k], poses.k[k]),
    }
}
