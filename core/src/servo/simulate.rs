//! Drives along a command, and the result on the part.

use std::sync::Arc;

use std::ops::ControlFlow;

use multiversion::multiversion;

use super::statistics::{
    ContourErrorStatistics, ContourErrorSummary, FollowingErrorStatistics, FollowingErrorSummary, Oval,
    Trace, TracePoint,
};
use super::{
    AxisLetter, AxisServo, Circle, CircleCommand, Drive, ServoFault, ToolCommand, ToolRun, settling_s,
    stable_poles,
};
use crate::geometry::{Vec3, trig};
use crate::kinematics::{JointLanes, Kinematics};

/// Drives by axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveSet {
    drives: [Option<Drive>; 6],
}

/// Number of samples in a time.
pub(super) fn samples_in(time_s: f64, period_s: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, saturating")]
    let samples = (time_s / period_s).ceil().max(0.0) as usize;
    samples
}

impl DriveSet {
    /// The drive of an axis.
    #[must_use]
    pub fn get(&self, axis: AxisLetter) -> Option<&Drive> {
        self.drives[axis as usize].as_ref()
    }

    /// Gives an axis a drive.
    pub fn set(&mut self, axis: AxisLetter, drive: Drive) {
        self.drives[axis as usize] = Some(drive);
    }

    /// All axes that have a drive.
    pub fn iter(&self) -> impl Iterator<Item = (AxisLetter, &Drive)> {
        AxisLetter::ALL.into_iter().filter_map(|axis| self.get(axis).map(|drive| (axis, drive)))
    }

    /// Time that the slowest of these axes needs to come to rest \[s\].
    #[must_use]
    pub fn settling_s(&self, axes: &[AxisLetter]) -> f64 {
        axes.iter().filter_map(|axis| self.get(*axis)).map(settling_s).fold(0.0, f64::max)
    }

    /// The axis at rest at `start` (mm, or rad), to be stepped with this period.
    ///
    /// # Errors
    /// The drive is missing, unstable or too stiff for the period.
    pub fn servo(&self, axis: AxisLetter, period_s: f64, start: f64) -> Result<AxisServo, ServoFault> {
        let drive = self.get(axis).ok_or(ServoFault::NoDrive { axis })?;
        stable_poles(drive).map_err(|fault| ServoFault::Unstable { axis, fault })?;
        AxisServo::new(drive, period_s, start).map_err(|fault| ServoFault::TooStiff { axis, fault })
    }
}

/// The result for one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisOutcome {
    /// Which axis.
    pub axis: AxisLetter,
    /// Its following error over the judged samples.
    pub following: FollowingErrorSummary,
}

/// The result for a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// The axes that moved.
    pub axes: Vec<AxisOutcome>,
    /// Contour error over the judged samples.
    pub contour: ContourErrorSummary,
    /// Second harmonic, on a circle.
    pub oval: Option<Oval>,
    /// Samples of the run.
    pub samples: u64,
    /// Start of the judged part \[s\].
    pub judged_from_s: f64,
    /// The whole run in a limited number of points; empty unless asked for.
    pub trace: Vec<TracePoint>,
}

/// The detail of a simulation's result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Sums only.
    Summary,
    /// The trace as well.
    Trace,
}

/// Samples between two checks of the stop signal, a multiple of a block.
const CHUNK: usize = 4096;

/// Runs two drives along a circle and judges the radius: ΔR = √((xa − x0)² + ya²) − r, positive outside (P2 eq. (8)).
///
/// # Errors
/// A drive is missing, unstable or too stiff; stopped by the caller.
pub fn simulate_circle(
    command: &CircleCommand,
    drives: &DriveSet,
    detail: Detail,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Simulation, ServoFault> {
    let CircleCommand { circle, period_s, phi_rad, positions, judged_from } = command;
    let letters = circle.axes();
    let mut servos = Vec::with_capacity(2);
    for (axis, lane) in letters.into_iter().zip(positions) {
        servos.push(drives.servo(axis, *period_s, lane.first().copied().unwrap_or(0.0))?);
    }
    let mut statistics = [FollowingErrorStatistics::default(); 2];
    let mut contour = ContourErrorStatistics::default();
    let mut harmonic = SecondHarmonic::default();
    let mut trace = Trace::new();
    let mut actual = [Vec::new(), Vec::new()];
    let mut radius_error_mm = Vec::new();
    for start in (0..phi_rad.len()).step_by(CHUNK) {
        if stop().is_break() {
            return Err(ServoFault::Stopped);
        }
        let end = (start + CHUNK).min(phi_rad.len());
        let judged = judged_from.saturating_sub(start).min(end - start);
        for k in 0..2 {
            let commands = &positions[k][start..end];
            servos[k].follow(commands, &mut actual[k]);
            statistics[k].take(&commands[judged..], &actual[k][judged..]);
        }
        radius_error_mm.clear();
        radius_error_mm.resize(end - start, 0.0);
        radius_errors(circle, &actual[0], &actual[1], &mut radius_error_mm);
        for (k, (error_mm, phi)) in radius_error_mm.iter().zip(&phi_rad[start..end]).enumerate() {
            let time_s = (start + k) as f64 * period_s;
            if k >= judged {
                contour.take(*error_mm, 0.0, time_s, 0);
                harmonic.take(*phi, *error_mm);
            }
            if detail == Detail::Trace {
                let following = |slot: usize| positions[slot][start + k] - actual[slot][k];
                trace.take(TracePoint {
                    time_s,
                    line: 0,
                    phi_rad: *phi,
                    contour_mm: *error_mm,
                    axis_rad: 0.0,
                    following: [following(0), following(1), 0.0, 0.0, 0.0],
                });
            }
        }
    }
    let outcome = |k: usize| {
        let kv_per_s = drives.get(letters[k]).and_then(Drive::velocity_gain_factor_per_s);
        AxisOutcome { axis: letters[k], following: statistics[k].summary(*period_s, kv_per_s) }
    };
    Ok(Simulation {
        axes: vec![outcome(0), outcome(1)],
        contour: contour.summary(false),
        oval: harmonic.oval(),
        samples: phi_rad.len() as u64,
        judged_from_s: *judged_from as f64 * period_s,
        trace: trace.into_points(),
    })
}

/// Runs the drives of a machine along a path of its tool. `plane_normal` gives the contour error a sign.
///
/// # Errors
/// As for [`simulate_circle`].
pub fn simulate_tool_path(
    command: &ToolCommand,
    kinematics: &Kinematics,
    drives: &DriveSet,
    plane_normal: Option<Vec3>,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Simulation, ServoFault> {
    let ToolCommand { axes, period_s, joints, judged_from, comes_to_rest } = command;
    let kinematics = Arc::new(kinematics.clone());
    let mut run = ToolRun::new(&kinematics, *axes, drives, *period_s, plane_normal, *judged_from as u64);
    let mut piece = JointLanes::default();
    let moving = joints.len();
    // From here on the command rests at its last sample.
    let mut length = moving;
    let mut start = 0;
    while start < length {
        if stop().is_break() {
            return Err(ServoFault::Stopped);
        }
        let end = (start + CHUNK).min(length);
        piece.clear();
        let pairs = [
            (&mut piece.x_mm, &joints.x_mm),
            (&mut piece.y_mm, &joints.y_mm),
            (&mut piece.z_mm, &joints.z_mm),
            (&mut piece.first_rad, &joints.first_rad),
            (&mut piece.second_rad, &joints.second_rad),
        ];
        for (to, from) in pairs {
            to.extend_from_slice(&from[start.min(moving)..end.min(moving)]);
            to.resize(end - start, from.last().copied().unwrap_or(0.0));
        }
        run.follow(&piece, &[])?;
        start = end;
        if *comes_to_rest && start == moving {
            length += run.settling_samples();
        }
    }
    let outcome = run.finish()?;
    let axes = axes.iter().zip(outcome.following);
    Ok(Simulation {
        axes: axes
            .filter_map(|(axis, following)| Some(AxisOutcome { axis: *axis, following: following? }))
            .collect(),
        contour: outcome.contour,
        oval: None,
        samples: outcome.samples,
        judged_from_s: *judged_from as f64 * period_s,
        trace: outcome.trace,
    })
}

/// ΔR of each sample \[mm\].
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn radius_errors(circle: &Circle, first: &[f64], second: &[f64], out: &mut [f64]) {
    match *circle {
        Circle::XC { radius_mm, center_x_mm } => {
            for ((error, x), c) in out.iter_mut().zip(first).zip(second) {
                let (sin, cos) = trig::sin_cos(*c);
                let (x, y) = (x * cos - center_x_mm, x * sin);
                *error = (x * x + y * y).sqrt() - radius_mm;
            }
        }
        Circle::Linear { radius_mm, .. } => {
            for ((error, x), y) in out.iter_mut().zip(first).zip(second) {
                *error = (x * x + y * y).sqrt() - radius_mm;
            }
        }
    }
}

/// The second Fourier coefficient of ΔR over one turn of φ, by the trapezoidal rule on the circle.
#[derive(Debug, Clone, Copy, Default)]
struct SecondHarmonic {
    cos: f64,
    sin: f64,
    count: u64,
    first: Option<[f64; 2]>,
    last: [f64; 2],
    last_sin_cos: (f64, f64),
}

impl SecondHarmonic {
    fn take(&mut self, phi_rad: f64, error_mm: f64) {
        let (sin, cos) = trig::sin_cos(2.0 * phi_rad);
        if self.first.is_none() {
            self.first = Some([phi_rad, error_mm]);
        } else {
            // Half a step on either side of each sample.
            let half = 0.5 * (phi_rad - self.last[0]);
            let (last_sin, last_cos) = self.last_sin_cos;
            self.cos += half * (error_mm * cos + self.last[1] * last_cos);
            self.sin += half * (error_mm * sin + self.last[1] * last_sin);
        }
        self.last = [phi_rad, error_mm];
        self.last_sin_cos = (sin, cos);
        self.count += 1;
    }

    fn oval(mut self) -> Option<Oval> {
        let [first_phi, first_error] = self.first?;
        // The gap between the last sample and the first.
        let end = first_phi + std::f64::consts::TAU;
        if end > self.last[0] {
            self.take(end, first_error);
        }
        let (cos, sin) = (self.cos / std::f64::consts::PI, self.sin / std::f64::consts::PI);
        let axis = 0.5 * trig::atan2(sin, cos);
        let major_axis_rad = if axis < 0.0 { axis + std::f64::consts::PI } else { axis };
        Some(Oval { amplitude_mm: (cos * cos + sin * sin).sqrt(), major_axis_rad })
    }
}
