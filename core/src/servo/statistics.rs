//! Summary values of millions of samples: extremes, mean squares, the second harmonic, and a trace that can be
//! drawn.

/// Following error of one axis, r − y, in output units (mm, or rad).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FollowingErrorSummary {
    /// Largest magnitude.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
    /// Steady value on a ramp at the axis' largest commanded speed: speed / Kv.
    pub steady_state: f64,
    /// Largest commanded speed [output units/s].
    pub max_speed_per_s: f64,
}

/// Collects the following error of one axis.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FollowingErrorStatistics {
    max: f64,
    square: f64,
    count: u64,
    max_step: f64,
    last_command: Option<f64>,
}

impl FollowingErrorStatistics {
    /// Takes commands and positions of the same times.
    pub(super) fn take(&mut self, commands: &[f64], positions: &[f64]) {
        for (command, position) in commands.iter().zip(positions) {
            let error = command - position;
            self.max = if error.abs() > self.max { error.abs() } else { self.max };
            self.square += error * error;
            let step = (command - self.last_command.unwrap_or(*command)).abs();
            self.max_step = if step > self.max_step { step } else { self.max_step };
            self.last_command = Some(*command);
        }
        self.count += commands.len() as u64;
    }

    /// The commands continue from another position: this step is not counted.
    pub(super) fn lift(&mut self) {
        self.last_command = None;
    }

    /// Whether the axis moved at all.
    #[must_use]
    pub(super) const fn has_moved(&self) -> bool {
        self.count > 0
    }

    /// The summary. `kv_per_s` is Kv of the drive; `None` if a ramp leaves no error.
    #[must_use]
    pub(super) fn summary(&self, period_s: f64, kv_per_s: Option<f64>) -> FollowingErrorSummary {
        let max_speed_per_s = self.max_step / period_s;
        FollowingErrorSummary {
            max: self.max,
            rms: (self.square / self.count.max(1) as f64).sqrt(),
            steady_state: kv_per_s.map_or(0.0, |kv| max_speed_per_s / kv),
            max_speed_per_s,
        }
    }
}

/// Contour error over a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContourErrorSummary {
    /// Smallest \[mm\]; signed if the error has a sign.
    pub min_mm: f64,
    /// Largest \[mm\].
    pub max_mm: f64,
    /// Root mean square \[mm\].
    pub rms_mm: f64,
    /// Largest magnitude \[mm\].
    pub max_abs_mm: f64,
    /// Largest angle between actual and commanded tool axis \[rad\]; `None` if no rotary axis affects the pose.
    pub axis_max_rad: Option<f64>,
    /// Root mean square of that angle \[rad\].
    pub axis_rms_rad: Option<f64>,
    /// Time of the largest magnitude \[s\].
    pub worst_at_s: f64,
    /// Line of the program where it occurs; 0 without a program.
    pub worst_line: u64,
}

/// Collects contour errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContourErrorStatistics {
    min_mm: f64,
    max_mm: f64,
    square: f64,
    axis_max_rad: f64,
    axis_square: f64,
    count: u64,
    worst: (f64, f64, u64),
}

impl Default for ContourErrorStatistics {
    fn default() -> Self {
        Self {
            min_mm: f64::INFINITY,
            max_mm: f64::NEG_INFINITY,
            square: 0.0,
            axis_max_rad: 0.0,
            axis_square: 0.0,
            count: 0,
            worst: (-1.0, 0.0, 0),
        }
    }
}

impl ContourErrorStatistics {
    /// Takes the contour error \[mm, rad\] at a time \[s\] and a line of the program.
    pub(super) fn take(&mut self, error_mm: f64, axis_rad: f64, at_s: f64, line: u64) {
        self.min_mm = if error_mm < self.min_mm { error_mm } else { self.min_mm };
        self.max_mm = if error_mm > self.max_mm { error_mm } else { self.max_mm };
        self.square += error_mm * error_mm;
        self.axis_max_rad = if axis_rad > self.axis_max_rad { axis_rad } else { self.axis_max_rad };
        self.axis_square += axis_rad * axis_rad;
        self.count += 1;
        if error_mm.abs() > self.worst.0 {
            self.worst = (error_mm.abs(), at_s, line);
        }
    }

    /// The summary; zeros if no sample was taken.
    #[must_use]
    pub(super) fn summary(&self, has_axis: bool) -> ContourErrorSummary {
        let count = self.count.max(1) as f64;
        let taken = self.count > 0;
        ContourErrorSummary {
            min_mm: if taken { self.min_mm } else { 0.0 },
            max_mm: if taken { self.max_mm } else { 0.0 },
            rms_mm: (self.square / count).sqrt(),
            max_abs_mm: self.worst.0.max(0.0),
            axis_max_rad: has_axis.then_some(self.axis_max_rad),
            axis_rms_rad: has_axis.then(|| (self.axis_square / count).sqrt()),
            worst_at_s: self.worst.1,
            worst_line: self.worst.2,
        }
    }
}

/// Second harmonic of ΔR over the commanded φ: P2's oval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oval {
    /// Half peak to peak \[mm\].
    pub amplitude_mm: f64,
    /// Direction of the major axis, in [0, π) \[rad\].
    pub major_axis_rad: f64,
}

/// One point of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracePoint {
    /// Time from the start \[s\].
    pub time_s: f64,
    /// Line of the program; 0 without a program.
    pub line: u64,
    /// φ of the command on a circle \[rad\], otherwise 0.
    pub phi_rad: f64,
    /// Contour error \[mm\].
    pub contour_mm: f64,
    /// Angle between the tool axes \[rad\].
    pub axis_rad: f64,
    /// Following errors in the order of the run's axes (mm, or rad).
    pub following: [f64; 5],
}

/// A run of any length in a limited number of points. Each point covers the same number of samples, and is the one
/// among them with the largest contour error.
#[derive(Debug, Clone)]
pub struct Trace {
    points: Vec<TracePoint>,
    stride: u64,
    in_last: u64,
}

impl Trace {
    /// Most points kept.
    pub const MAX_POINTS: usize = 2000;

    /// An empty trace.
    #[must_use]
    pub fn new() -> Self {
        Self { points: Vec::new(), stride: 1, in_last: 0 }
    }

    /// Takes the next sample.
    pub fn take(&mut self, point: TracePoint) {
        match self.points.last_mut() {
            Some(last) if self.in_last < self.stride => keep_larger(last, &point),
            _ => {
                if self.points.len() == Self::MAX_POINTS {
                    self.halve();
                }
                if self.in_last < self.stride
                    && let Some(last) = self.points.last_mut()
                {
                    keep_larger(last, &point);
                } else {
                    self.points.push(point);
                    self.in_last = 0;
                }
            }
        }
        self.in_last += 1;
    }

    /// The points in the order of time.
    #[must_use]
    pub fn into_points(self) -> Vec<TracePoint> {
        self.points
    }

    fn halve(&mut self) {
        let pairs = self.points.len().div_ceil(2);
        // An odd point at the end is only half full.
        self.in_last = if self.points.len().is_multiple_of(2) { 2 * self.stride } else { self.in_last };
        for k in 0..pairs {
            let mut kept = self.points[2 * k];
            if let Some(second) = self.points.get(2 * k + 1) {
                keep_larger(&mut kept, second);
            }
            self.points[k] = kept;
        }
        self.points.truncate(pairs);
        self.stride *= 2;
    }
}

impl Default for Trace {
    fn default() -> Self {
        Self::new()
    }
}

fn keep_larger(kept: &mut TracePoint, other: &TracePoint) {
    if other.contour_mm.abs() > kept.contour_mm.abs() {
        *kept = *other;
    }
}
