//! Requests of the servo operations.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::servo_path::CorePath;
use super::{Drives, Fault, FaultList, Fixed, KinematicsOptions, LocationErrors, ServoPathDoc};
use crate::description::ToSchema;
use crate::kinematics::Setup;
use crate::machine::Machine;
use crate::servo::{AxisLetter, DriveSet, FeedProfile, MatchingOptions, Run};
use crate::units::{Feedrate, UM_PER_MM};

/// Jerk-limited feed. Without it, the command starts and ends with a step in speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = FeedProfile)]
pub struct FeedProfileDoc {
    /// Acceleration along the path.
    #[schema(example = 1000.0)]
    pub acceleration_mm_per_s2: f64,
    /// Jerk along the path.
    #[schema(example = 20_000.0)]
    pub jerk_mm_per_s3: f64,
    /// A corner of the tip's path that is sharper than this is an exact stop.
    #[serde(default = "ten")]
    pub stop_at_corners_above_deg: f64,
}

fn ten() -> f64 {
    10.0
}

/// One number for each axis, by letter.
pub type GainScales = BTreeMap<String, f64>;
/// Numbers for each axis, by letter; every swept axis has the same number of values.
pub type ScaleLists = BTreeMap<String, Vec<f64>>;

macro_rules! servo_request {
    ($(#[$doc:meta])* $name:ident { $($own:tt)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            /// The machine whose drives and kinematics are used; give either this or `drives`.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(example = "example-ac-table")]
            pub machine_id: Option<String>,
            /// Drives by axis letter, without a machine; for the two circles.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub drives: Option<Drives>,
            /// The path that the axes are commanded to follow. All kinds except the two circles need a machine with
            /// drives.
            pub path: ServoPathDoc,
            /// Sample period of the command.
            #[serde(default = "one_millisecond")]
            #[schema(default = 0.001, minimum = 0.00001, maximum = 0.1)]
            pub sample_period_s: f64,
            /// Number of laps on a closed path, default 2; the last lap is evaluated.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(minimum = 1, maximum = 100)]
            pub laps: Option<u32>,
            /// Jerk-limited feed. Without it, the command starts and ends with a step in speed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub feed_profile: Option<FeedProfileDoc>,
            /// Origin of the workpiece in machine coordinates at zero pose. Default: zero. A program has no default:
            /// state it if a result depends on it.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub work_offset_mm: Option<Fixed<3>>,
            /// Tool length, added along the zero-pose tool axis; it matters only for head axes. The default
            /// is as for `work_offset_mm`.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub tool_length_mm: Option<f64>,
            /// Whether measured errors of the machine are applied.
            #[serde(default)]
            pub location_errors: LocationErrors,
            $($own)*
        }

        impl $name {
            /// The part that all servo operations have in common.
            #[must_use]
            pub fn options(&self) -> ServoOptions<'_> {
                ServoOptions {
                    machine_id: self.machine_id.as_deref(),
                    drives: self.drives.as_ref(),
                    path: &self.path,
                    sample_period_s: self.sample_period_s,
                    laps: self.laps,
                    feed_profile: self.feed_profile,
                    kinematics: KinematicsOptions {
                        work_offset_mm: self.work_offset_mm.unwrap_or_default(),
                        tool_length_mm: self.tool_length_mm.unwrap_or_default(),
                        selection: None,
                        start: None,
                        location_errors: self.location_errors,
                    },
                }
            }
        }
    };
}

servo_request! {
    /// One path at one feed.
    SimulationRequest {
        /// Feed along the path; in degrees per minute if the tip rests. For a program: the feed if the
        /// program has none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schema(example = 1800.0)]
        pub feed_mm_per_min: Option<f64>,
        /// Factors of the position gains, by axis letter.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        #[schema(value_type = BTreeMap<String, f64>)]
        pub position_gain_scale: GainScales,
    }
}

servo_request! {
    /// One path with many gains and feeds.
    SweepRequest {
        /// Feeds along the path; in degrees per minute if the tip rests.
        pub feed_mm_per_min: Vec<f64>,
        /// Factors of the position gains, by axis letter: lists of equal length, which are stepped together.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        #[schema(value_type = BTreeMap<String, Vec<f64>>)]
        pub position_gain_scale: ScaleLists,
    }
}

servo_request! {
    /// Request for gains that reach a target.
    MatchingRequest {
        /// Feed at which the gains have to reach the first target.
        pub feed_mm_per_min: f64,
        /// Largest contour errors allowed. The gains are matched to the first; the feed limit is given for
        /// each.
        pub target_um: Vec<f64>,
        /// Factor by which the position gains stay below the stability limit.
        #[serde(default = "two")]
        pub least_gain_margin: f64,
        /// Phase margin that the position loops keep.
        #[serde(default = "forty_five")]
        pub least_phase_margin_deg: f64,
        /// Range of feeds in which the limit is searched.
        #[serde(default = "feed_range")]
        pub feed_range_mm_per_min: Fixed<2>,
    }
}

fn one_millisecond() -> f64 {
    0.001
}

fn two() -> f64 {
    2.0
}

fn forty_five() -> f64 {
    45.0
}

fn feed_range() -> Fixed<2> {
    Fixed([100.0, 20_000.0])
}

/// The part that all servo operations have in common.
#[derive(Debug, Clone)]
pub struct ServoOptions<'a> {
    /// The machine.
    pub machine_id: Option<&'a str>,
    /// Drives without a machine.
    pub drives: Option<&'a Drives>,
    /// The path.
    pub path: &'a ServoPathDoc,
    /// Sample period \[s\].
    pub sample_period_s: f64,
    /// Laps of a closed path.
    pub laps: Option<u32>,
    /// Jerk-limited feed.
    pub feed_profile: Option<FeedProfileDoc>,
    /// Work offset, tool length, errors.
    pub kinematics: KinematicsOptions,
}

/// An incomplete servo task: a faulty part of the request may be missing, so that the rest can still be
/// checked.
#[derive(Debug)]
pub struct ServoDraft<'a> {
    /// The drives in the request, valid or not.
    documents: Option<&'a Drives>,
    drives: DriveSet,
    path: Option<CorePath>,
    run: Run,
    setup: Setup,
}

impl ServoDraft<'_> {
    /// The task; `None` if drives or path are missing, which has been reported as a fault.
    #[must_use]
    pub fn into_task(self) -> Option<ServoTask> {
        let Self { documents, drives, path, run, setup } = self;
        documents?;
        Some(ServoTask { drives, path: path?, run, setup })
    }
}

/// A servo task in the core's terms, without feeds and gains.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoTask {
    /// The drives.
    pub drives: DriveSet,
    /// The path.
    pub path: CorePath,
    /// How the path is run; the feed is set later.
    pub run: Run,
    /// The set-up of the machine.
    pub setup: Setup,
}

/// Accepted ranges, with reasons: no control samples below 10 µs, and a sample period above 0.1 s is no
/// control.
const PERIOD_RANGE_S: [f64; 2] = [1e-5, 0.1];
const LAPS_RANGE: std::ops::RangeInclusive<u32> = 1..=100;
/// A feed below a micrometre per minute is standstill; a feed above 1 km/min is not possible.
const FEED_RANGE: [f64; 2] = [1e-3, 1e6];
/// Factors of a gain.
const SCALE_RANGE: [f64; 2] = [1e-3, 1e3];
/// Accelerations and jerks of machine tools, with a wide margin.
const ACCELERATION_RANGE: [f64; 2] = [1.0, 1e6];
const JERK_RANGE: [f64; 2] = [1.0, 1e9];
/// Most targets of a matching.
const MAX_TARGETS: usize = 10;

impl<'a> ServoOptions<'a> {
    /// The task on a machine (with its drives), or on the drives of the request; faults are added to
    /// `faults`.
    pub fn to_core(
        &self,
        machine: Option<(&Machine, Option<&'a Drives>)>,
        faults: &mut FaultList,
    ) -> ServoDraft<'a> {
        let documents = match (machine, self.drives) {
            (Some(_), Some(drives)) => {
                faults.push(|| Fault::new("/drives", "give either machine_id or drives, not both"));
                Some(drives)
            }
            (None, None) => {
                faults.push(|| Fault::new("/drives", "missing: give machine_id or drives"));
                None
            }
            (Some((_, None)), None) => {
                faults.push(|| {
                    Fault::new(
                        "/machine_id",
                        "the machine's profile has no drives; store them there or give drives here",
                    )
                });
                None
            }
            (Some((_, Some(drives))), None) | (None, Some(drives)) => Some(drives),
        };
        let drives = documents.map(|drives| drives.to_core("/drives", faults)).unwrap_or_default();
        if self.path.needs_machine() && machine.is_none() {
            faults.push(|| {
                Fault::new("/machine_id", "this path needs the kinematics of a machine; give machine_id")
            });
        }
        check_period(self.sample_period_s, faults);
        let laps = self.laps.unwrap_or(2);
        if !LAPS_RANGE.contains(&laps) {
            faults.push(|| Fault::new("/laps", format!("{laps} is not between 1 and 100")));
        }
        if self.laps.is_some() && !self.path.is_closed() {
            faults.push(|| Fault::new("/laps", "an open path has no laps; remove this member"));
        }
        let profile = self.feed_profile.map(|profile| profile.to_core(faults));
        let setup = self.kinematics.setup(faults);
        let path = self.path.to_core(machine.map(|(machine, _)| machine), faults);
        let mut run = Run::at(Feedrate::from_mm_per_min(1.0));
        run.period_s = self.sample_period_s;
        run.laps = laps;
        if let Some((profile, corner_rad)) = profile {
            run.profile = Some(profile);
            run.stop_at_corners_above_rad = corner_rad;
        }
        ServoDraft { documents, drives, path, run, setup }
    }
}

pub(super) fn check_period(sample_period_s: f64, faults: &mut FaultList) {
    let [min, max] = PERIOD_RANGE_S;
    faults.check_range(|| "/sample_period_s".to_owned(), sample_period_s, min, max);
}

impl FeedProfileDoc {
    /// The profile, and the angle above which corners are exact stops \[rad\]; faults are added to `faults`.
    pub(super) fn to_core(self, faults: &mut FaultList) -> (FeedProfile, f64) {
        let at = |name: &str| format!("/feed_profile/{name}");
        let [min, max] = ACCELERATION_RANGE;
        faults.check_range(|| at("acceleration_mm_per_s2"), self.acceleration_mm_per_s2, min, max);
        let [min, max] = JERK_RANGE;
        faults.check_range(|| at("jerk_mm_per_s3"), self.jerk_mm_per_s3, min, max);
        faults.check_range(|| at("stop_at_corners_above_deg"), self.stop_at_corners_above_deg, 0.0, 180.0);
        let profile = FeedProfile {
            acceleration_mm_per_s2: self.acceleration_mm_per_s2,
            jerk_mm_per_s3: self.jerk_mm_per_s3,
        };
        (profile, self.stop_at_corners_above_deg.to_radians())
    }
}

/// Scales position gains; faults are added to `faults`. `documents` are the drives as the client wrote them.
pub(super) fn scale_gains(
    documents: Option<&Drives>,
    drives: &mut DriveSet,
    scales: &GainScales,
    faults: &mut FaultList,
) {
    for (letter, scale) in scales {
        let [min, max] = SCALE_RANGE;
        faults.check_range(|| format!("/position_gain_scale/{letter}"), *scale, min, max);
        let axis = scaled_axis(letter, documents, faults);
        if let Some((axis, drive)) = axis.and_then(|axis| Some((axis, *drives.get(axis)?))) {
            drives.set(axis, drive.with_position_gain_scaled(*scale));
        }
    }
}

pub(super) fn check_feed(feed: f64, pointer: impl FnOnce() -> String, faults: &mut FaultList) {
    let [min, max] = FEED_RANGE;
    faults.check_range(pointer, feed, min, max);
}

/// The axis of a letter in a map of scales. If there are no drives at all, that is the fault, not this
/// letter.
fn scaled_axis(letter: &str, documents: Option<&Drives>, faults: &mut FaultList) -> Option<AxisLetter> {
    let has = |axis: &AxisLetter| {
        documents.is_none_or(|drives| drives.iter().any(|(letter, _)| letter == axis.as_char()))
    };
    let axis = letter.parse().ok().and_then(AxisLetter::from_char).filter(has);
    if axis.is_none() {
        let detail = format!("axis {letter:?} has no drive");
        faults.push(|| Fault::new(format!("/position_gain_scale/{letter}"), detail));
    }
    axis
}

impl SimulationRequest {
    /// Sets the feed and the scaled drives; faults are added to `faults`.
    pub fn apply(&self, task: &mut ServoDraft<'_>, faults: &mut FaultList) {
        match self.feed_mm_per_min {
            Some(feed) => {
                check_feed(feed, || "/feed_mm_per_min".to_owned(), faults);
                task.run.feed = Feedrate::from_mm_per_min(feed);
            }
            None => {
                faults.push(|| Fault::new("/feed_mm_per_min", "missing: this path has no feed of its own"));
            }
        }
        scale_gains(task.documents, &mut task.drives, &self.position_gain_scale, faults);
    }
}

impl SweepRequest {
    /// Largest number of cells in one sweep.
    pub const MAX_CELLS: usize = 10_000;

    /// One set of drives for each row; faults are added to `faults`.
    pub fn rows(&self, task: &ServoDraft<'_>, faults: &mut FaultList) -> Vec<DriveSet> {
        if self.feed_mm_per_min.is_empty() {
            faults.push(|| Fault::new("/feed_mm_per_min", "missing: give at least one feed"));
        }
        let rows = self.position_gain_scale.values().map(Vec::len).max().unwrap_or(1);
        let is_too_large = rows.saturating_mul(self.feed_mm_per_min.len().max(1)) > Self::MAX_CELLS;
        if is_too_large {
            let detail = format!(
                "a sweep has at most {} cells (gains times feeds); use fewer of them",
                Self::MAX_CELLS
            );
            faults.push(|| Fault::new("/feed_mm_per_min", detail));
        }
        for (index, feed) in self.feed_mm_per_min.iter().enumerate() {
            check_feed(*feed, || format!("/feed_mm_per_min/{index}"), faults);
        }
        // A list that is too long is checked to its end, but takes no memory.
        let mut sets = if is_too_large { Vec::new() } else { vec![task.drives; rows] };
        for (letter, scales) in &self.position_gain_scale {
            if scales.len() != rows || scales.is_empty() {
                let detail = format!(
                    "has {} numbers, but the longest list has {rows}; all lists need the same length",
                    scales.len()
                );
                faults.push(|| Fault::new(format!("/position_gain_scale/{letter}"), detail));
            }
            for (index, scale) in scales.iter().enumerate() {
                let [min, max] = SCALE_RANGE;
                faults.check_range(|| format!("/position_gain_scale/{letter}/{index}"), *scale, min, max);
            }
            let Some(axis) = scaled_axis(letter, task.documents, faults) else { continue };
            let Some(drive) = task.drives.get(axis) else { continue };
            for (set, scale) in sets.iter_mut().zip(scales) {
                set.set(axis, drive.with_position_gain_scaled(*scale));
            }
        }
        sets
    }

    /// The label of each row in a figure.
    #[must_use]
    pub fn labels(&self) -> Vec<String> {
        let rows = self.position_gain_scale.values().map(Vec::len).max().unwrap_or(1);
        (0..rows)
            .map(|row| {
                let parts = self.position_gain_scale.iter().filter_map(|(letter, scales)| {
                    scales.get(row).map(|scale| format!("{letter} × {scale}"))
                });
                let label = parts.collect::<Vec<_>>().join(", ");
                if label.is_empty() { "as set".to_owned() } else { label }
            })
            .collect()
    }
}

impl MatchingRequest {
    /// Targets \[mm\] and bounds of the search; sets the feed. Faults are added to `faults`.
    pub fn apply(&self, task: &mut ServoDraft<'_>, faults: &mut FaultList) -> (Vec<f64>, MatchingOptions) {
        check_feed(self.feed_mm_per_min, || "/feed_mm_per_min".to_owned(), faults);
        task.run.feed = Feedrate::from_mm_per_min(self.feed_mm_per_min);
        if !(1..=MAX_TARGETS).contains(&self.target_um.len()) {
            faults.push(|| Fault::new("/target_um", format!("1 to {MAX_TARGETS} targets are needed")));
        }
        for (index, target_um) in self.target_um.iter().enumerate() {
            faults.check_range(|| format!("/target_um/{index}"), *target_um, 1e-3, 1e6);
        }
        faults.check_range(|| "/least_gain_margin".to_owned(), self.least_gain_margin, 1.0, 1e3);
        faults.check_range(|| "/least_phase_margin_deg".to_owned(), self.least_phase_margin_deg, 0.0, 89.0);
        let Fixed([slowest, fastest]) = self.feed_range_mm_per_min;
        for (index, feed) in [slowest, fastest].into_iter().enumerate() {
            check_feed(feed, || format!("/feed_range_mm_per_min/{index}"), faults);
        }
        if slowest >= fastest {
            let detail = format!("{slowest} is not below {fastest}");
            faults.push(|| Fault::new("/feed_range_mm_per_min", detail));
        }
        let options = MatchingOptions {
            least_gain_margin: self.least_gain_margin,
            least_phase_margin_rad: self.least_phase_margin_deg.to_radians(),
            feeds_mm_per_min: [slowest, fastest],
        };
        (self.target_um.iter().map(|target_um| target_um / UM_PER_MM).collect(), options)
    }
}
