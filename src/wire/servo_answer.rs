//! Answers of the servo operations.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::description::ToSchema;
use crate::servo::{
    AxisLetter, ContourErrorSummary, DriveSet, FeedLimit, FollowingErrorSummary, MatchedGains, Matching,
    ServoFault, Simulation, Stability, TracePoint,
};
use crate::units::{Feedrate, UM_PER_MM, URAD_PER_RAD};

/// A pole of the closed loop (1/s).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Pole)]
pub struct PoleDoc {
    /// Real part.
    pub re_per_s: f64,
    /// Imaginary part.
    pub im_per_s: f64,
}

/// Distance of an axis from its stability limits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Stability)]
pub struct StabilityDoc {
    /// Commanded speed divided by the following error of a ramp; null if feed-forward leaves no error.
    pub kv_per_s: Option<f64>,
    /// Lowest frequency at which the closed loop's gain falls below 1/√2.
    pub bandwidth_hz: Option<f64>,
    /// Factor by which the position gain can grow before the loop oscillates; null if it can grow without
    /// limit.
    pub gain_margin: Option<f64>,
    /// Phase that is left at the frequency where the open loop's gain is 1.
    pub phase_margin_deg: Option<f64>,
    /// Largest gain of the closed loop over all frequencies.
    pub resonance_peak: f64,
    /// Poles of the closed loop, slowest first.
    pub poles: Vec<PoleDoc>,
}

/// Results of one axis: µm and mm/min for a linear axis, µrad and deg/min for a rotary axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AxisResult {
    /// Largest following error over the evaluated samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_following_error_um: Option<f64>,
    /// Root mean square of the following error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_following_error_um: Option<f64>,
    /// Following error in steady state at the largest commanded speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_state_following_error_um: Option<f64>,
    /// Largest commanded speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_mm_per_min: Option<f64>,
    /// Largest following error over the evaluated samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_following_error_urad: Option<f64>,
    /// Root mean square of the following error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_following_error_urad: Option<f64>,
    /// Following error in steady state at the largest commanded speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steady_state_following_error_urad: Option<f64>,
    /// Largest commanded speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_deg_per_min: Option<f64>,
    /// Margins, bandwidth and poles.
    pub stability: StabilityDoc,
}

/// Results by axis letter.
pub type AxisResults = BTreeMap<String, AxisResult>;

/// Second harmonic of the radius error over the commanded φ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Oval)]
pub struct OvalDoc {
    /// Half of the peak-to-peak value.
    pub amplitude_um: f64,
    /// Direction of the major axis, in [0, 180).
    pub major_axis_deg: f64,
}

/// Contour error over the evaluated samples. On a circle it is the radius error, positive outside. On other
/// paths it is the distance from the commanded path, with a sign if a plane is given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ContourError)]
pub struct ContourErrorDoc {
    /// Smallest value.
    pub min_um: f64,
    /// Largest value.
    pub max_um: f64,
    /// Root mean square.
    pub rms_um: f64,
    /// Largest absolute value.
    pub max_abs_um: f64,
    /// Largest angle between the actual and the commanded tool axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_max_urad: Option<f64>,
    /// Root mean square of this angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_rms_urad: Option<f64>,
    /// Time of the largest absolute value.
    pub worst_at_s: f64,
    /// Line of the program at that time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_line: Option<u64>,
    /// Oval form of a circle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub oval: Option<OvalDoc>,
}

/// The whole run in at most 2000 points, as columns; each point is the worst of the samples that it
/// represents.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ServoSamples {
    /// Time from the start.
    pub t_s: Vec<f64>,
    /// φ of the command; only for a circle.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub phi_deg: Vec<f64>,
    /// Line of the upload; only for a program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub line: Vec<u64>,
    /// Contour error.
    pub contour_error_um: Vec<f64>,
    /// Angle between the tool axes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub axis_error_urad: Vec<f64>,
    /// Following errors of linear axes, by letter.
    pub following_error_um: BTreeMap<String, Vec<f64>>,
    /// Following errors of rotary axes, by letter.
    pub following_error_urad: BTreeMap<String, Vec<f64>>,
}

/// Result of a servo simulation.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SimulationAnswer {
    /// Revision of the machine; null if the drives came with the request.
    pub machine_revision: Option<i64>,
    /// Version of the service.
    pub software_version: String,
    /// Results of the axes that move, by letter.
    #[schema(value_type = BTreeMap<String, AxisResult>)]
    pub axes: AxisResults,
    /// Contour error on the part.
    pub contour_error: ContourErrorDoc,
    /// Number of samples.
    pub sample_count: u64,
    /// Time at which the evaluated part begins.
    pub judged_from_s: f64,
    /// The run, down-sampled.
    pub samples: ServoSamples,
}

/// A cell of a sweep without a result.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SweepFault {
    /// Row, from 0.
    pub gain: usize,
    /// Column, from 0.
    pub feed: usize,
    /// The reason.
    pub detail: String,
}

/// One path with many gains and feeds.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SweepAnswer {
    /// Revision of the machine; null if the drives came with the request.
    pub machine_revision: Option<i64>,
    /// Version of the service.
    pub software_version: String,
    /// Label of each row.
    pub gains: Vec<String>,
    /// Feed of each column.
    pub feed_mm_per_min: Vec<f64>,
    /// Contour errors, row by row; null if a cell has no result.
    pub contour_error: Vec<Vec<Option<ContourErrorDoc>>>,
    /// Reasons for null cells; the first hundred.
    pub faults: Vec<SweepFault>,
}

/// A gain to set at the control.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
pub struct MatchedGain {
    /// The position gain.
    pub position_gain_per_s: f64,
    /// New gain divided by the present gain.
    pub scale: f64,
}

/// Fastest feed of the path for one target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, ToSchema)]
#[schema(as = FeedLimit)]
pub struct FeedLimitDoc {
    /// Largest contour error allowed.
    pub target_um: f64,
    /// Feed limit with the present gains; null if even the slowest feed in the range exceeds the target.
    pub present_mm_per_min: Option<f64>,
    /// True if even the fastest feed in the range keeps the target.
    pub present_beyond_range: bool,
    /// Feed limit with the matched gains; null if even the slowest feed in the range exceeds the target.
    pub matched_mm_per_min: Option<f64>,
    /// True if even the fastest feed in the range keeps the target.
    pub matched_beyond_range: bool,
}

/// Gains that reach the target.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MatchingAnswer {
    /// Revision of the machine; null if the drives came with the request.
    pub machine_revision: Option<i64>,
    /// Version of the service.
    pub software_version: String,
    /// Contour error with the present gains, at the feed of the request.
    pub present: ContourErrorDoc,
    /// Gains by axis letter. All axes reach the same Kv, the smallest that keeps the first target.
    #[schema(value_type = BTreeMap<String, MatchedGain>)]
    pub gains: BTreeMap<String, MatchedGain>,
    /// True if these gains keep the first target; otherwise they are the best within the margins.
    pub reached: bool,
    /// Contour error with these gains, at the feed of the request.
    pub matched: ContourErrorDoc,
    /// Largest common Kv within the margins.
    pub largest_kv_per_s: f64,
    /// Feed limits, one for each target.
    pub feed_limits: Vec<FeedLimitDoc>,
}

impl StabilityDoc {
    fn of(drives: &DriveSet, axis: AxisLetter) -> Self {
        let drive = drives.get(axis);
        let stability = drive.and_then(|drive| Stability::of(drive).ok());
        let stability = stability.as_ref();
        Self {
            kv_per_s: drive.and_then(crate::servo::Drive::velocity_gain_factor_per_s),
            bandwidth_hz: stability.and_then(|stability| stability.bandwidth_hz),
            gain_margin: stability.and_then(|stability| stability.gain_margin),
            phase_margin_deg: stability.and_then(|stability| stability.phase_margin_rad).map(f64::to_degrees),
            resonance_peak: stability.map_or(1.0, |stability| stability.resonance_peak),
            poles: stability.map_or_else(Vec::new, |stability| {
                let pole = |pole: &nalgebra::Complex<f64>| PoleDoc { re_per_s: pole.re, im_per_s: pole.im };
                stability.poles_per_s.iter().map(pole).collect()
            }),
        }
    }
}

impl AxisResult {
    /// The results of an axis.
    #[must_use]
    pub fn of(axis: AxisLetter, following: &FollowingErrorSummary, drives: &DriveSet) -> Self {
        let unit = if axis.is_linear() { UM_PER_MM } else { URAD_PER_RAD };
        let linear = |value: f64| axis.is_linear().then_some(value * unit);
        let rotary = |value: f64| (!axis.is_linear()).then_some(value * unit);
        let per_min = following.max_speed_per_s * crate::units::S_PER_MIN;
        Self {
            max_following_error_um: linear(following.max),
            rms_following_error_um: linear(following.rms),
            steady_state_following_error_um: linear(following.steady_state),
            max_speed_mm_per_min: axis.is_linear().then_some(per_min),
            max_following_error_urad: rotary(following.max),
            rms_following_error_urad: rotary(following.rms),
            steady_state_following_error_urad: rotary(following.steady_state),
            max_speed_deg_per_min: (!axis.is_linear()).then_some(per_min.to_degrees()),
            stability: StabilityDoc::of(drives, axis),
        }
    }
}

impl ContourErrorDoc {
    /// The summary of a run.
    #[must_use]
    pub fn of(summary: &ContourErrorSummary) -> Self {
        Self {
            min_um: summary.min_mm * UM_PER_MM,
            max_um: summary.max_mm * UM_PER_MM,
            rms_um: summary.rms_mm * UM_PER_MM,
            max_abs_um: summary.max_abs_mm * UM_PER_MM,
            axis_max_urad: summary.axis_max_rad.map(|angle_rad| angle_rad * URAD_PER_RAD),
            axis_rms_urad: summary.axis_rms_rad.map(|angle_rad| angle_rad * URAD_PER_RAD),
            worst_at_s: summary.worst_at_s,
            worst_line: (summary.worst_line > 0).then_some(summary.worst_line),
            oval: None,
        }
    }

    /// The contour error of a simulation, with its oval.
    #[must_use]
    pub fn of_simulation(simulation: &Simulation) -> Self {
        let oval = simulation.oval.map(|oval| OvalDoc {
            amplitude_um: oval.amplitude_mm * UM_PER_MM,
            major_axis_deg: oval.major_axis_rad.to_degrees(),
        });
        Self { oval, ..Self::of(&simulation.contour) }
    }
}

impl ServoSamples {
    /// The trace of a run of these axes, in the order given.
    #[must_use]
    pub fn of(trace: &[TracePoint], axes: &[AxisLetter], is_circle: bool) -> Self {
        let column = |value: &dyn Fn(&TracePoint) -> f64| trace.iter().map(value).collect::<Vec<f64>>();
        let mut samples = Self {
            t_s: column(&|point| point.time_s),
            phi_deg: if is_circle { column(&|point| point.phi_rad.to_degrees()) } else { Vec::new() },
            line: Vec::new(),
            contour_error_um: column(&|point| point.contour_mm * UM_PER_MM),
            axis_error_urad: if is_circle {
                Vec::new()
            } else {
                column(&|point| point.axis_rad * URAD_PER_RAD)
            },
            following_error_um: BTreeMap::new(),
            following_error_urad: BTreeMap::new(),
        };
        if trace.iter().any(|point| point.line > 0) {
            samples.line = trace.iter().map(|point| point.line).collect();
        }
        for (slot, axis) in axes.iter().enumerate() {
            let (unit, map) = if axis.is_linear() {
                (UM_PER_MM, &mut samples.following_error_um)
            } else {
                (URAD_PER_RAD, &mut samples.following_error_urad)
            };
            map.insert(
                axis.to_string(),
                column(&|point| point.following.get(slot).map_or(0.0, |error| error * unit)),
            );
        }
        samples
    }
}

impl SimulationAnswer {
    /// The answer for a path. `axes` is the order of the trace's following errors.
    #[must_use]
    pub fn of(
        machine_revision: Option<i64>,
        simulation: &Simulation,
        drives: &DriveSet,
        axes: &[AxisLetter],
    ) -> Self {
        let results = simulation.axes.iter().map(|outcome| {
            (outcome.axis.to_string(), AxisResult::of(outcome.axis, &outcome.following, drives))
        });
        Self {
            machine_revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            axes: results.collect(),
            contour_error: ContourErrorDoc::of_simulation(simulation),
            sample_count: simulation.samples,
            judged_from_s: simulation.judged_from_s,
            samples: ServoSamples::of(&simulation.trace, axes, simulation.oval.is_some()),
        }
    }
}

/// Columns of a sweep: a result or a fault for each row.
pub type SweepColumns = Vec<Vec<Result<Simulation, ServoFault>>>;

impl SweepAnswer {
    /// How many faults are reported.
    const MAX_FAULTS: usize = 100;

    /// The answer for columns in the order of the feeds.
    #[must_use]
    pub fn of(
        machine_revision: Option<i64>,
        gains: Vec<String>,
        feeds: &[f64],
        columns: &SweepColumns,
    ) -> Self {
        let mut faults = Vec::new();
        let mut rows = vec![Vec::with_capacity(feeds.len()); gains.len()];
        for (feed, column) in columns.iter().enumerate() {
            for (gain, (row, cell)) in rows.iter_mut().zip(column).enumerate() {
                row.push(cell.as_ref().ok().map(ContourErrorDoc::of_simulation));
                if let Err(fault) = cell
                    && faults.len() < Self::MAX_FAULTS
                {
                    faults.push(SweepFault { gain, feed, detail: fault.to_string() });
                }
            }
        }
        Self {
            machine_revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            gains,
            feed_mm_per_min: feeds.to_vec(),
            contour_error: rows,
            faults,
        }
    }
}

impl MatchingAnswer {
    /// The answer for a matching of these drives.
    #[must_use]
    pub fn of(machine_revision: Option<i64>, matching: &Matching, drives: &DriveSet) -> Self {
        let MatchedGains { position_gain_per_s, simulation, reached, largest_per_s } = &matching.gains;
        let gains = position_gain_per_s.iter().map(|(axis, gain_per_s)| {
            let present = drives.get(*axis).map_or(*gain_per_s, |drive| drive.position_gain_per_s);
            let gain = MatchedGain { position_gain_per_s: *gain_per_s, scale: gain_per_s / present };
            (axis.to_string(), gain)
        });
        let limits = matching.limits_before.iter().zip(&matching.limits_after);
        let feed = |limit: &FeedLimit| limit.feed.map(Feedrate::mm_per_min);
        Self {
            machine_revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            present: ContourErrorDoc::of_simulation(&matching.before),
            gains: gains.collect(),
            reached: *reached,
            matched: ContourErrorDoc::of_simulation(simulation),
            largest_kv_per_s: *largest_per_s,
            feed_limits: limits
                .map(|(before, after)| FeedLimitDoc {
                    target_um: before.target_mm * UM_PER_MM,
                    present_mm_per_min: feed(before),
                    present_beyond_range: before.beyond_range,
                    matched_mm_per_min: feed(after),
                    matched_beyond_range: after.beyond_range,
                })
                .collect(),
        }
    }
}
