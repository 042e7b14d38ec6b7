//! A path of the tool as commands to the drives of a machine.

use std::ops::ControlFlow;

use super::command::Run;
use super::feed_profile::distances_mm;
use super::path::Waypoint;
use super::{AxisLetter, ServoFault, ToolPath};
use crate::kinematics::{InverseError, JointLanes, Kinematics, PathOptions, PoseLanes, ToolPose};
use crate::machine::{Machine, Travel};

/// The commands of all five axes along a path of the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolCommand {
    /// X, Y, Z and the rotary axes in the profile's order.
    pub axes: [AxisLetter; 5],
    /// Sample period \[s\].
    pub period_s: f64,
    /// Linear words \[mm\] and kinematic angles \[rad\], one lane for each sample.
    pub joints: JointLanes,
    /// First judged sample.
    pub judged_from: usize,
    /// Whether the tool is followed until it comes to rest: at the end of an open path.
    pub comes_to_rest: bool,
}

/// Largest turn of a rotary axis in one sample \[rad\]. No drive could follow a larger one.
const JUMP_RAD: f64 = 0.5;

impl ToolCommand {
    /// Samples a path of the tool through the machine's kinematics (poses to joints by the cheapest path).
    ///
    /// # Errors
    /// Too many samples, out of reach or travel, a rotary axis that would have to jump.
    pub fn new(
        machine: &Machine,
        kinematics: &Kinematics,
        path: &ToolPath,
        run: &Run,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, ServoFault> {
        let once = path.stretches();
        let laps = if path.is_closed() { run.laps.max(1) as usize } else { 1 };
        let lap: f64 = once.iter().sum();
        run.check_samples(&path.extent(run))?;
        let mut ends = Vec::with_capacity(once.len() * laps);
        let mut stops = Vec::new();
        let mut at = 0.0;
        for stretch in 0..once.len() * laps {
            at += once[stretch % once.len()];
            ends.push(at);
            let corner = path.has_corner_after(stretch % once.len(), run.stop_at_corners_above_rad);
            if corner && stretch + 1 < once.len() * laps {
                stops.push(at);
            }
        }
        let mut distances = distances_mm(at, run.feed, run.period_s, run.profile, &stops);
        let judged_from = if laps > 1 { distances.partition_point(|done| *done < at - lap) } else { 0 };
        let comes_to_rest = !path.is_closed();
        if comes_to_rest && distances.last().is_some_and(|last| *last < at) {
            // The path ends between two samples: its end becomes the next sample.
            distances.push(at);
        }
        let waypoints = Waypoints { path, ends: &ends, stretches: once.len() };
        let joints = joints(machine, kinematics, &waypoints, &distances, run.period_s, stop)?;
        check_steps(machine, &joints, run.period_s)?;
        Ok(Self { axes: letters_of(machine), period_s: run.period_s, joints, judged_from, comes_to_rest })
    }
}

/// X Y Z and the machine's rotary letters, in the profile's order.
#[must_use]
pub fn letters_of(machine: &Machine) -> [AxisLetter; 5] {
    use crate::machine::RotaryLetter;
    use AxisLetter::{A, B, C, X, Y, Z};
    let [first, second] = machine.rotary_axes().each_ref().map(|axis| match axis.letter {
        RotaryLetter::A => A,
        RotaryLetter::B => B,
        RotaryLetter::C => C,
    });
    [X, Y, Z, first, second]
}

/// A path with the distances at which its stretches end, continued over all laps.
struct Waypoints<'a> {
    path: &'a ToolPath,
    ends: &'a [f64],
    stretches: usize,
}

impl Waypoints<'_> {
    fn at(&self, distance: f64) -> Waypoint {
        let last = self.ends.len().saturating_sub(1);
        let stretch = self.ends.partition_point(|end| *end < distance).min(last);
        let from = stretch.checked_sub(1).map_or(0.0, |before| self.ends[before]);
        let length = self.ends[stretch] - from;
        let u = if length > 0.0 { ((distance - from) / length).clamp(0.0, 1.0) } else { 1.0 };
        self.path.at(stretch % self.stretches, u)
    }
}

fn joints(
    machine: &Machine,
    kinematics: &Kinematics,
    waypoints: &Waypoints<'_>,
    distances: &[f64],
    period_s: f64,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<JointLanes, ServoFault> {
    let mut poses = PoseLanes::default();
    let mut held = JointLanes::default();
    for distance in distances {
        match waypoints.at(*distance) {
            Waypoint::Pose(pose) => push_pose(&mut poses, &pose),
            Waypoint::Held { tip_mm, rotary_rad } => {
                held.push(kinematics.linear_mm(tip_mm, rotary_rad).into(), rotary_rad);
            }
        }
    }
    if poses.is_empty() {
        check_travel(machine, &held, period_s)?;
        return Ok(held);
    }
    let path = kinematics.path_lanes(&poses, &PathOptions::default(), stop).map_err(|fault| {
        use InverseError as E;
        match fault {
            E::Stopped => ServoFault::Stopped,
            E::NoDirection { pose }
            | E::OutOfReach { pose, .. }
            | E::OutOfTravel { pose, .. }
            | E::NoWay { pose } => ServoFault::Unreachable { at_s: pose as f64 * period_s, fault },
            E::StartOutOfTravel { .. } | E::TooManyStates { .. } => {
                ServoFault::Unreachable { at_s: 0.0, fault }
            }
        }
    })?;
    Ok(path.joints)
}

fn push_pose(poses: &mut PoseLanes, pose: &ToolPose) {
    poses.x_mm.push(pose.tip_mm.x);
    poses.y_mm.push(pose.tip_mm.y);
    poses.z_mm.push(pose.tip_mm.z);
    poses.i.push(pose.axis.x);
    poses.j.push(pose.axis.y);
    poses.k.push(pose.axis.z);
}

fn check_travel(machine: &Machine, joints: &JointLanes, period_s: f64) -> Result<(), ServoFault> {
    let linear = [&joints.x_mm, &joints.y_mm, &joints.z_mm];
    for (k, lane) in linear.into_iter().enumerate() {
        let Some(travel) = machine.linear_travel_mm()[k] else { continue };
        for (sample, word) in lane.iter().enumerate() {
            if !travel.contains(*word, Travel::WORD_SLACK) {
                let at_s = sample as f64 * period_s;
                let axis = AxisLetter::ALL[k].as_char();
                return Err(ServoFault::OutOfTravel {
                    at_s,
                    axis,
                    commanded: *word,
                    min: travel.min,
                    max: travel.max,
                });
            }
        }
    }
    for (axis, lane) in machine.rotary_axes().iter().zip([&joints.first_rad, &joints.second_rad]) {
        let Some(travel) = axis.travel_deg else { continue };
        for (sample, angle_rad) in lane.iter().enumerate() {
            let commanded = axis.word_deg(*angle_rad);
            if !travel.contains(commanded, Travel::WORD_SLACK) {
                let at_s = sample as f64 * period_s;
                let axis = axis.letter.as_char();
                return Err(ServoFault::OutOfTravel {
                    at_s,
                    axis,
                    commanded,
                    min: travel.min,
                    max: travel.max,
                });
            }
        }
    }
    Ok(())
}

fn check_steps(machine: &Machine, joints: &JointLanes, period_s: f64) -> Result<(), ServoFault> {
    for (axis, lane) in machine.rotary_axes().iter().zip([&joints.first_rad, &joints.second_rad]) {
        for (sample, pair) in lane.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            if step.is_nan() || step.abs() > JUMP_RAD {
                return Err(ServoFault::Jump {
                    at_s: sample as f64 * period_s,
                    axis: axis.letter.as_char(),
                    step_deg: step.to_degrees(),
                });
            }
        }
    }
    Ok(())
}
