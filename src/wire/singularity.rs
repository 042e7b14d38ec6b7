//! Treatment of singular regions, and the regions that were found.

use serde::{Deserialize, Serialize};

use super::{FaultList, Warning};
use crate::description::ToSchema;
use crate::kinematics::SingularityKind;
use crate::process::{
    self, RegionTreatment, SingularityAction as CoreAction, SingularityParameters as CoreParameters,
};
use crate::units::Angle;

/// Treatment of regions where a rotary axis turns far for a small turn of the tool.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SingularityAction {
    /// The regions are listed and not changed.
    #[default]
    Report,
    /// The motions are divided until tool axis, contact and step keep their tolerances.
    Densify,
    /// Rotary words are replaced by words that need slower rotary axes; the tool axis stays within a
    /// tolerance.
    Smooth,
}

/// How singular regions are found and treated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SingularRegions {
    /// A motion is singular if the tool axis comes within about this angle of a pole or of the reach limit.
    #[serde(default = "zone")]
    #[schema(default = 3.0, minimum = 0.01, maximum = 30.0)]
    pub zone_deg: f64,
    /// Largest angle between the tool axis and the programmed one.
    #[serde(default = "axis_tolerance")]
    #[schema(default = 0.05, minimum = 0.0001, maximum = 5.0)]
    pub axis_tolerance_deg: f64,
    /// Largest turn of a rotary axis in one block that `densify` writes.
    #[serde(default = "max_step")]
    #[schema(default = 5.0, minimum = 0.1, maximum = 180.0)]
    pub max_step_deg: f64,
    /// Motions that need a faster rotary axis than this are counted.
    #[serde(default = "max_rotary")]
    #[schema(default = 120.0, minimum = 0.01, maximum = 100_000.0)]
    pub max_rotary_deg_per_s: f64,
}

const fn zone() -> f64 {
    CoreParameters::ZONE_DEG
}

const fn axis_tolerance() -> f64 {
    CoreParameters::AXIS_TOLERANCE_DEG
}

const fn max_step() -> f64 {
    CoreParameters::MAX_STEP_DEG
}

const fn max_rotary() -> f64 {
    CoreParameters::MAX_ROTARY_DEG_PER_S
}

impl Default for SingularRegions {
    fn default() -> Self {
        Self {
            zone_deg: zone(),
            axis_tolerance_deg: axis_tolerance(),
            max_step_deg: max_step(),
            max_rotary_deg_per_s: max_rotary(),
        }
    }
}

impl SingularRegions {
    /// Checks the values.
    pub fn check(&self, faults: &mut FaultList) {
        for (name, value, [min, max]) in [
            ("zone_deg", self.zone_deg, CoreParameters::ZONE_RANGE_DEG),
            ("axis_tolerance_deg", self.axis_tolerance_deg, CoreParameters::AXIS_TOLERANCE_RANGE_DEG),
            ("max_step_deg", self.max_step_deg, CoreParameters::MAX_STEP_RANGE_DEG),
            ("max_rotary_deg_per_s", self.max_rotary_deg_per_s, CoreParameters::MAX_ROTARY_RANGE_DEG_PER_S),
        ] {
            faults.check_range(|| format!("/singular_regions/{name}"), value, min, max);
        }
    }

    /// The settings in the core's terms.
    #[must_use]
    pub fn to_core(&self, action: SingularityAction) -> CoreParameters {
        let action = match action {
            SingularityAction::Report => CoreAction::Report,
            SingularityAction::Densify => CoreAction::Densify,
            SingularityAction::Smooth => CoreAction::Smooth,
        };
        CoreParameters {
            zone: Angle::from_deg(self.zone_deg),
            axis_tolerance: Angle::from_deg(self.axis_tolerance_deg),
            max_step: Angle::from_deg(self.max_step_deg),
            max_rotary_deg_per_s: self.max_rotary_deg_per_s,
            ..CoreParameters::new(action)
        }
    }
}

/// Speeds, turns and deviations of the motions in a region.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RegionFigures)]
pub struct RegionFiguresDoc {
    /// Largest speed of a rotary axis, as the mean over a block; null if no block's time is known.
    pub rotary_deg_per_s: Option<f64>,
    /// Number of motions that need more than the largest speed.
    pub motions_over_speed: u64,
    /// Largest turn of a rotary axis in one block.
    pub step_deg: f64,
    /// Sum of the turns of both rotary axes.
    pub travel_deg: f64,
    /// Largest distance of the contact from its line; of the tip if no contact is known.
    pub deviation_um: f64,
    /// Largest angle between the tool axis and the great circle of its block.
    pub axis_deviation_deg: f64,
}

impl From<&process::RegionFigures> for RegionFiguresDoc {
    fn from(core: &process::RegionFigures) -> Self {
        Self {
            rotary_deg_per_s: core.rotary_deg_per_s,
            motions_over_speed: core.motions_over_speed,
            step_deg: core.step_deg,
            travel_deg: core.travel_deg,
            deviation_um: core.deviation.um(),
            axis_deviation_deg: core.axis_deviation.deg(),
        }
    }
}

/// Consecutive motions near a singularity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SingularRegion)]
pub struct SingularRegionDoc {
    /// Line of the upload with its first motion.
    pub first_line: u64,
    /// Line of the upload with its last motion.
    pub last_line: u64,
    /// Number of motions.
    pub motions: u64,
    /// `pole` or `reach_limit`.
    #[schema(example = "pole")]
    pub kind: String,
    /// Smallest angle between the tool axis and the singularity.
    pub least_angle_deg: f64,
    /// Smallest turn of the tool axis for a turn of the rotary axes by 1.
    pub least_gain: f64,
    /// Values as uploaded.
    pub before: RegionFiguresDoc,
    /// Values as written; null if nothing changed.
    pub after: Option<RegionFiguresDoc>,
    /// `reported`, `left`, `densified` or `smoothed`.
    #[schema(example = "smoothed")]
    pub treatment: String,
    /// Why the region, or one of its motions, was left unchanged; null if none was.
    pub left_reason: Option<String>,
    /// Blocks whose words changed or that were divided.
    pub blocks_changed: u64,
    /// Number of inserted blocks.
    pub blocks_inserted: u64,
    /// Largest angle between the written and the programmed tool axis at a point, computed from the written
    /// text.
    pub axis_spent_deg: f64,
}

impl From<&process::SingularRegion> for SingularRegionDoc {
    fn from(core: &process::SingularRegion) -> Self {
        let (treatment, reason, changed, inserted, spent) = match core.treatment {
            RegionTreatment::Reported => ("reported", None, 0, 0, Angle::ZERO),
            RegionTreatment::Left(reason) => ("left", Some(reason), 0, 0, Angle::ZERO),
            RegionTreatment::Densified { divided, inserted, reason, .. } => {
                ("densified", reason, divided, inserted, Angle::ZERO)
            }
            RegionTreatment::Smoothed { changed, axis_spent } => ("smoothed", None, changed, 0, axis_spent),
        };
        Self {
            first_line: core.first_line,
            last_line: core.last_line,
            motions: core.motions,
            kind: match core.kind {
                SingularityKind::Pole => "pole",
                SingularityKind::ReachLimit => "reach_limit",
            }
            .to_owned(),
            least_angle_deg: core.least_angle.deg(),
            least_gain: core.least_gain,
            before: (&core.before).into(),
            after: core.after.as_ref().map(Into::into),
            treatment: treatment.to_owned(),
            left_reason: reason.map(|reason| reason.name().to_owned()),
            blocks_changed: changed,
            blocks_inserted: inserted,
            axis_spent_deg: spent.deg(),
        }
    }
}

/// Regions that were left unchanged for the same reason.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RegionsLeft)]
pub struct RegionsLeftDoc {
    /// A stable word for the reason.
    #[schema(example = "nothing_to_gain")]
    pub reason: String,
    /// The reason in words.
    pub detail: String,
    /// Number of regions.
    pub count: u64,
    /// First line of the first region.
    pub line: u64,
}

/// Singular regions of a program. All lines are lines of the upload.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SingularityFindings {
    /// The requested treatment.
    pub action: SingularityAction,
    /// Number of motions at feed that were checked.
    pub motions_checked: u64,
    /// Number of checked motions in singular regions.
    pub motions_singular: u64,
    /// Number of regions.
    pub regions_found: u64,
    /// The first regions, in the order of the program.
    pub regions: Vec<SingularRegionDoc>,
    /// Number of regions in which anything changed.
    pub regions_treated: u64,
    /// Regions that were left unchanged, by reason.
    pub left: Vec<RegionsLeftDoc>,
    /// Values of all regions as uploaded.
    pub before: RegionFiguresDoc,
    /// Values of all regions as written.
    pub after: RegionFiguresDoc,
    /// Number of blocks whose words changed.
    pub blocks_changed: u64,
    /// Number of inserted blocks.
    pub blocks_inserted: u64,
    /// Largest angle between a written and a programmed tool axis at a point.
    pub axis_spent_deg: f64,
    /// Warnings about the text.
    pub warnings: Vec<Warning>,
}

impl From<&process::SingularityReport> for SingularityFindings {
    fn from(core: &process::SingularityReport) -> Self {
        Self {
            action: match core.action {
                CoreAction::Report => SingularityAction::Report,
                CoreAction::Densify => SingularityAction::Densify,
                CoreAction::Smooth => SingularityAction::Smooth,
            },
            motions_checked: core.motions_checked,
            motions_singular: core.motions_singular,
            regions_found: core.regions_found,
            regions: core.regions.iter().map(Into::into).collect(),
            regions_treated: core.regions_treated,
            left: core
                .left
                .iter()
                .map(|left| RegionsLeftDoc {
                    reason: left.reason.name().to_owned(),
                    detail: left.reason.text().to_owned(),
                    count: left.count,
                    line: left.first_line,
                })
                .collect(),
            before: (&core.before).into(),
            after: (&core.after).into(),
            blocks_changed: core.blocks_changed,
            blocks_inserted: core.blocks_inserted,
            axis_spent_deg: core.axis_spent.deg(),
            warnings: core.warnings.iter().map(Into::into).collect(),
        }
    }
}
