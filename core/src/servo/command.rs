//! A path as commands to the drives: one position for each axis and sample.

use super::feed_profile::distances_mm;
use super::{Circle, FeedProfile, ServoFault};
use crate::geometry::trig;
use crate::units::{Feedrate, S_PER_MIN};

/// Most samples of one command. It limits time and memory.
pub const MAX_SAMPLES: usize = 2_000_000;

/// How a path is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Feed along the path.
    pub feed: Feedrate,
    /// Sample period of the command \[s\].
    pub period_s: f64,
    /// Number of laps on a closed path; the last lap is judged.
    pub laps: u32,
    /// Jerk-limited feed. Without it the command starts and ends with a step of speed.
    pub profile: Option<FeedProfile>,
    /// With a profile: the command stops exactly at corners sharper than this \[rad\].
    pub stop_at_corners_above_rad: f64,
}

impl Run {
    /// A run at this feed: 1 ms, two laps, no profile, and stops at corners above 10° if there is a profile.
    #[must_use]
    pub fn at(feed: Feedrate) -> Self {
        Self { feed, period_s: 0.001, laps: 2, profile: None, stop_at_corners_above_rad: 10_f64.to_radians() }
    }

    /// Approximate number of samples of the command for such a path, including starts, stops and ends with a
    /// profile.
    #[must_use]
    pub fn samples(&self, extent: &PathExtent) -> f64 {
        let speed_mm_per_s = self.feed.mm_per_min() / S_PER_MIN;
        let mut samples = extent.length / (speed_mm_per_s * self.period_s);
        if let Some(profile) = self.profile {
            let [a, b] = profile.averages(speed_mm_per_s, self.period_s);
            samples += (a as f64 + b as f64 + 2.0) * (extent.stops as f64 + 1.0);
        }
        samples
    }

    /// Refuses a path with too many samples, or with too few in a lap to show its course, before any sample is
    /// made.
    pub(super) fn check_samples(&self, extent: &PathExtent) -> Result<(), ServoFault> {
        if extent.length.is_nan() || extent.length <= 0.0 {
            return Err(ServoFault::NoLength);
        }
        let samples = self.samples(extent);
        if samples.is_nan() || samples > MAX_SAMPLES as f64 {
            return Err(ServoFault::TooManySamples { samples, max: MAX_SAMPLES });
        }
        if let Some(lap) = extent.lap {
            let samples = lap / (self.feed.mm_per_min() / S_PER_MIN * self.period_s);
            if samples < LEAST_SAMPLES_IN_A_LAP {
                return Err(ServoFault::TooFewSamples { samples, least: LEAST_SAMPLES_IN_A_LAP });
            }
        }
        Ok(())
    }
}

/// The length of a path as the feed counts it: mm of the tip, or degrees if only rotary axes turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathExtent {
    /// Length of all laps.
    pub length: f64,
    /// Length of one lap, if the path is closed.
    pub lap: Option<f64>,
    /// Number of exact stops on the way, with a profile.
    pub stops: usize,
}

impl PathExtent {
    /// The extent of a circle with this number of laps.
    pub(super) fn of_circle(circle: &Circle, laps: u32) -> Self {
        let lap = std::f64::consts::TAU * circle.radius_mm();
        Self { length: lap * f64::from(laps.max(1)), lap: Some(lap), stops: 0 }
    }
}

/// One sample for each quarter of a radian of a circle. With fewer, the commanded path is no longer the circle.
const LEAST_SAMPLES_IN_A_LAP: f64 = 25.0;

/// The commands of the two axes of a circle.
#[derive(Debug, Clone, PartialEq)]
pub struct CircleCommand {
    /// The circle.
    pub circle: Circle,
    /// Sample period \[s\].
    pub period_s: f64,
    /// φ of each sample \[rad\].
    pub phi_rad: Vec<f64>,
    /// Positions of the first and the second axis (mm, or rad), one for each sample.
    pub positions: [Vec<f64>; 2],
    /// First sample that is judged: the last lap begins here.
    pub judged_from: usize,
}

/// Largest turn of C from one sample to the next \[rad\]. Beyond it the commanded path is no longer a circle.
const MAX_TURN_RAD: f64 = 0.25;

impl CircleCommand {
    /// Samples a circle (P2 eq. (4), (5)): φ = F t / r.
    ///
    /// # Errors
    /// Too many samples, or too few in a lap; an XC circle too near the line of C.
    pub fn new(circle: Circle, run: &Run) -> Result<Self, ServoFault> {
        let radius_mm = circle.radius_mm();
        let extent = PathExtent::of_circle(&circle, run.laps);
        run.check_samples(&extent)?;
        let length_mm = extent.length;
        let step_mm = run.feed.mm_per_min() / S_PER_MIN * run.period_s;
        let distances = distances_mm(length_mm, run.feed, run.period_s, run.profile, &[]);
        let judged_mm = length_mm - std::f64::consts::TAU * radius_mm;
        let judged_from = distances.partition_point(|at_mm| *at_mm < judged_mm - 1e-9 * step_mm);
        let phi_rad: Vec<f64> = distances.iter().map(|at_mm| at_mm / radius_mm).collect();
        let mut first = Vec::with_capacity(phi_rad.len());
        let mut second = Vec::with_capacity(phi_rad.len());
        match circle {
            Circle::XC { center_x_mm, .. } => {
                let distance_mm = (center_x_mm.abs() - radius_mm).abs();
                let turn_rad = if distance_mm > 0.0 { step_mm / distance_mm } else { std::f64::consts::PI };
                if turn_rad.is_nan() || turn_rad > MAX_TURN_RAD {
                    return Err(ServoFault::ThroughRotaryCenter {
                        distance_mm,
                        turn_rad,
                        max_rad: MAX_TURN_RAD,
                    });
                }
                for phi in &phi_rad {
                    let (sin, cos) = trig::sin_cos(*phi);
                    let (x, y) = (center_x_mm + radius_mm * cos, radius_mm * sin);
                    first.push((x * x + y * y).sqrt());
                    second.push(trig::atan2(y, x));
                }
                unwrap(&mut second);
            }
            Circle::Linear { .. } => {
                for phi in &phi_rad {
                    let (sin, cos) = trig::sin_cos(*phi);
                    first.push(radius_mm * cos);
                    second.push(radius_mm * sin);
                }
            }
        }
        let period_s = run.period_s;
        Ok(Self { circle, period_s, phi_rad, positions: [first, second], judged_from })
    }
}

/// Restores the turns that principal values hide.
fn unwrap(angles_rad: &mut [f64]) {
    let mut turns = 0.0;
    let mut before = angles_rad.first().copied().unwrap_or(0.0);
    for angle in angles_rad {
        let step = *angle - before;
        before = *angle;
        if step > std::f64::consts::PI {
            turns -= 1.0;
        } else if step < -std::f64::consts::PI {
            turns += 1.0;
        }
        *angle += turns * std::f64::consts::TAU;
    }
}
