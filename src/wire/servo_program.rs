//! A program on the drives of its machine: parameters and report.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::servo::{check_period, scale_gains};
use super::statements::program_parameters;
use super::{
    AxisResult, AxisResults, ContourErrorDoc, Dialect, Drives, Fault, FaultList, FeedProfileDoc, GainScales,
    LocationErrors, Plane, ResolvedInputs, ServoPathDoc, ServoSamples, SimulationRequest,
};
use crate::description::ToSchema;
use crate::process::{LeftOut, ProgramSetup, ProgramSimulation, SimulationParameters};
use crate::servo::DriveSet;

program_parameters! {
/// Parameters of the simulation of a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ServoProgramParameters {
    /// Sample period of the command.
    #[serde(default = "one_millisecond")]
    #[schema(default = 0.001, minimum = 0.00001, maximum = 0.1)]
    pub sample_period_s: f64,
    /// Factors of the position gains, one query parameter for each: `position_gain_scale.C`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub position_gain_scale: GainScales,
    /// Jerk-limited feed, one query parameter for each limit: `feed_profile.acceleration_mm_per_s2`. Without
    /// it, every block runs at its own feed and no corner is a stop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feed_profile: Option<FeedProfileDoc>,
    /// Plane that gives the contour error a sign.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<Plane>,
    /// Whether measured errors of the machine are applied.
    #[serde(default)]
    pub location_errors: LocationErrors,
}
}

fn one_millisecond() -> f64 {
    0.001
}

impl ServoProgramParameters {
    /// The parameters of a request whose path is a program; `None` for every other kind of path.
    #[must_use]
    pub fn of(request: &SimulationRequest) -> Option<Self> {
        let ServoPathDoc::Program {
            interpolation,
            unit,
            work_offsets_mm,
            tool_number,
            start,
            dialect,
            plane,
            ..
        } = &request.path
        else {
            return None;
        };
        Some(Self {
            sample_period_s: request.sample_period_s,
            interpolation: *interpolation,
            unit: *unit,
            work_offset_mm: request.work_offset_mm,
            work_offsets_mm: work_offsets_mm.clone(),
            radius_offsets_mm: None,
            tool_length_mm: request.tool_length_mm,
            tool_number: *tool_number,
            start: *start,
            feed_mm_per_min: request.feed_mm_per_min,
            position_gain_scale: request.position_gain_scale.clone(),
            feed_profile: request.feed_profile,
            plane: *plane,
            location_errors: request.location_errors,
            dialect: *dialect,
        })
    }

    /// The parameters in the core's terms, without the set-up of the program, with the drives of the
    /// machine's profile. Faults are added to `faults`.
    pub fn to_core(&self, drives: Option<&Drives>, faults: &mut FaultList) -> SimulationParameters {
        if drives.is_none() {
            faults.push(|| {
                Fault::new("/machine_id", "missing: a program needs a machine whose profile has drives")
            });
        }
        let mut set = drives.map(|drives| drives.to_core("/drives", faults)).unwrap_or_default();
        scale_gains(drives, &mut set, &self.position_gain_scale, faults);
        check_period(self.sample_period_s, faults);
        let profile = self.feed_profile.map(|profile| profile.to_core(faults));
        self.statements().check(faults);
        let plain = SimulationParameters::new(set, ProgramSetup::default());
        SimulationParameters {
            period_s: self.sample_period_s,
            profile: profile.map(|(profile, _)| profile),
            stop_at_corners_above_rad: profile.map_or(plain.stop_at_corners_above_rad, |(_, corner)| corner),
            plane_normal: self.plane.map(Plane::normal),
            ..plain
        }
    }
}

/// Motions that were left out for one reason.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = LeftOut)]
pub struct LeftOutDoc {
    /// A stable word for the reason.
    #[schema(example = "arc")]
    pub kind: String,
    /// The reason in words.
    pub detail: String,
    /// Number of motions.
    pub count: u64,
    /// First line of the upload, 1-based.
    pub line: u64,
}

impl From<&LeftOut> for LeftOutDoc {
    fn from(core: &LeftOut) -> Self {
        Self {
            kind: core.reason.name().to_owned(),
            detail: core.reason.text(),
            count: core.count,
            line: core.first_line,
        }
    }
}

/// The report of a program's servo simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ServoReport {
    /// Revision of the machine that was used.
    pub machine_revision: i64,
    /// Version of the service.
    pub software_version: String,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// Inputs that were resolved beside the parameters.
    #[serde(default)]
    pub resolved: Option<ResolvedInputs>,
    /// Dialect in which the text was read.
    pub dialect: Dialect,
    /// Number of blocks in the upload.
    pub blocks: u64,
    /// Number of motions at feed that were simulated.
    pub motions_simulated: u64,
    /// Number of passes: motions between two rapids. Each pass starts with the axes at rest.
    pub passes: u64,
    /// Duration of the simulated motions.
    pub duration_s: f64,
    /// Results of the axes that move, by letter.
    #[schema(value_type = BTreeMap<String, AxisResult>)]
    pub axes: AxisResults,
    /// Contour error on the part.
    pub contour_error: ContourErrorDoc,
    /// Number of samples.
    pub sample_count: u64,
    /// The run, down-sampled.
    pub samples: ServoSamples,
    /// Motions at feed that were not simulated.
    pub left_out: Vec<LeftOutDoc>,
}

impl ServoReport {
    /// The report of a simulation.
    #[must_use]
    pub fn of(
        machine_revision: i64,
        input_sha256: String,
        resolved: ResolvedInputs,
        drives: &DriveSet,
        simulation: &ProgramSimulation,
    ) -> Self {
        let outcome = &simulation.outcome;
        let axes = simulation.axes.iter().zip(&outcome.following).filter_map(|(axis, following)| {
            Some((axis.to_string(), AxisResult::of(*axis, following.as_ref()?, drives)))
        });
        Self {
            machine_revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            input_sha256,
            resolved: Some(resolved),
            dialect: simulation.dialect.into(),
            blocks: simulation.blocks,
            motions_simulated: simulation.motions,
            passes: simulation.passes,
            duration_s: simulation.duration_s,
            axes: axes.collect(),
            contour_error: ContourErrorDoc::of(&outcome.contour),
            sample_count: outcome.samples,
            samples: ServoSamples::of(&outcome.trace, &simulation.axes, false),
            left_out: simulation.left_out.iter().map(Into::into).collect(),
        }
    }
}
