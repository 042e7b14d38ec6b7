//! The report of the treatment of singular regions.

use super::parameters::SingularityAction;
use crate::kinematics::SingularityKind;
use crate::process::fault::Warning;
use crate::program::{Dialect, StepName, Steps};
use crate::units::{Angle, Length};

/// The reason why a region, or a motion of it, is left unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftReason {
    /// The motions already keep the tolerances and the step, or other words would need axes that are nearly as fast.
    NothingToGain,
    /// The decimals of the rotary words use up the tool-axis tolerance, or those of X Y Z use up the contact's
    /// tolerance.
    DecimalsTooCoarse,
    /// The block would need more parts than are allowed.
    TooManyParts,
    /// The great circle, or the path with less travel, leaves the reach of the rotary axes.
    OutOfReach,
    /// The axes would leave their travel.
    OutOfTravel,
    /// G93 without F.
    NoInverseTime,
    /// E counts from an unknown value.
    ExtruderUnknown,
    /// An F word would be too small to be written.
    FeedTooSmall,
    /// An F word would be above its limit.
    FeedTooHigh,
    /// Some blocks of the region state a contact and others do not.
    MixedContacts,
    /// The program was smoothed before.
    SmoothedBefore,
    /// The program states the tool axis as a vector, so its control chooses the rotary words.
    ToolVectors,
}

impl LeftReason {
    /// The name in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NothingToGain => "nothing_to_gain",
            Self::DecimalsTooCoarse => "decimals_too_coarse",
            Self::TooManyParts => "too_many_parts",
            Self::OutOfReach => "out_of_reach",
            Self::OutOfTravel => "out_of_travel",
            Self::NoInverseTime => "no_inverse_time",
            Self::ExtruderUnknown => "extruder_unknown",
            Self::FeedTooSmall => "feed_too_small",
            Self::FeedTooHigh => "feed_too_high",
            Self::MixedContacts => "mixed_contacts",
            Self::SmoothedBefore => "smoothed_before",
            Self::ToolVectors => "tool_vectors",
        }
    }

    /// The meaning of the reason, in a sentence.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NothingToGain => {
                "the motions already keep every limit, or no words within the tolerance let the rotary axes turn more slowly"
            }
            Self::DecimalsTooCoarse => "the program's words have too few decimals to keep the tolerance",
            Self::TooManyParts => {
                "the rotary axes turn so far near the pole that a block would be divided into more than 2048 parts"
            }
            Self::OutOfReach => "the path is outside the reach of the two rotary axes",
            Self::OutOfTravel => "an axis would leave its travel",
            Self::NoInverseTime => "G93 needs an F word in every block, but a block has no F word",
            Self::ExtruderUnknown => "E counts from an unknown value",
            Self::FeedTooSmall => "an F word would be too small to be written",
            Self::FeedTooHigh => {
                "a block would need more feed than max_feed_mm_per_min, or more than ten times the programmed feed if max_feed_mm_per_min is missing"
            }
            Self::SmoothedBefore => {
                "this step was done to the program before, and may have used up the tolerance of the tool axis"
            }
            Self::MixedContacts => "some blocks state a contact and others do not",
            Self::ToolVectors => {
                "the tool axis is programmed as a vector, so the control chooses the rotary words"
            }
        }
    }
}

impl SingularityReport {
    /// The steps that changed something: this step, or no step.
    #[must_use]
    pub fn steps(&self) -> Steps {
        let is_changed = self.blocks_changed > 0 || self.blocks_inserted > 0;
        if is_changed { Steps::of(&[StepName::Singularity]) } else { Steps::NONE }
    }
}

/// What the motions of a region need, and the deviations that they leave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RegionFigures {
    /// The largest speed of a rotary axis \[deg/s\], as a mean over a block. `None` if no block's time is known.
    pub rotary_deg_per_s: Option<f64>,
    /// Motions that need more than the allowed largest speed.
    pub motions_over_speed: u64,
    /// The largest turn of a rotary axis in one block \[deg\].
    pub step_deg: f64,
    /// Sum of the turns of both rotary axes \[deg\].
    pub travel_deg: f64,
    /// Largest distance of the contact from its line, or of the tip if the contact is not known.
    pub deviation: Length,
    /// Largest angle between the tool axis and the great circle between the ends of its source block.
    pub axis_deviation: Angle,
}

impl RegionFigures {
    pub(super) fn take(&mut self, other: &Self) {
        self.rotary_deg_per_s = match (self.rotary_deg_per_s, other.rotary_deg_per_s) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        self.motions_over_speed += other.motions_over_speed;
        self.step_deg = self.step_deg.max(other.step_deg);
        self.travel_deg += other.travel_deg;
        self.deviation = Length::from_mm(self.deviation.mm().max(other.deviation.mm()));
        self.axis_deviation = Angle::from_rad(self.axis_deviation.rad().max(other.axis_deviation.rad()));
    }
}

/// The treatment of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegionTreatment {
    /// The region was reported.
    Reported,
    /// The region was left unchanged.
    Left(LeftReason),
    /// Motions were divided.
    Densified {
        /// Motions divided.
        divided: u64,
        /// Blocks inserted.
        inserted: u64,
        /// Motions that had to be divided but could not be.
        left: u64,
        /// The reason for the first of them.
        reason: Option<LeftReason>,
    },
    /// Rotary words were replaced.
    Smoothed {
        /// Motions whose blocks changed.
        changed: u64,
        /// Largest angle between the written and the programmed tool axis at a point, from the written text.
        axis_spent: Angle,
    },
}

/// Consecutive motions near a singularity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularRegion {
    /// 1-based line of its first motion.
    pub first_line: u64,
    /// 1-based line of its last motion.
    pub last_line: u64,
    /// The number of its motions.
    pub motions: u64,
    /// The kind of the singularity where the region comes nearest to one.
    pub kind: SingularityKind,
    /// The least angle between the tool axis and the singularity.
    pub least_angle: Angle,
    /// The least turn of the tool axis there for a turn of the rotary axes by 1.
    pub least_gain: f64,
    /// The figures of its motions as uploaded.
    pub before: RegionFigures,
    /// The figures as written, from the written text. `None` if nothing was changed.
    pub after: Option<RegionFigures>,
    /// The treatment.
    pub treatment: RegionTreatment,
}

/// Regions left unchanged for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RegionsLeft {
    /// The reason.
    pub reason: LeftReason,
    /// The number of regions.
    pub count: u64,
    /// First line of the first one.
    pub first_line: u64,
}

/// The report of the treatment of singular regions.
#[derive(Debug, Clone, PartialEq)]
pub struct SingularityReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// The requested treatment.
    pub action: SingularityAction,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written.
    pub blocks_out: u64,
    /// Motions at feed that were checked.
    pub motions_checked: u64,
    /// Motions in regions.
    pub motions_singular: u64,
    /// Regions found. The first [`SingularityReport::MAX_REGIONS`] are in `regions`.
    pub regions_found: u64,
    /// The first regions, in the order of the program.
    pub regions: Vec<SingularRegion>,
    /// Regions in which something was changed.
    pub regions_treated: u64,
    /// Regions left unchanged, by reason.
    pub left: Vec<RegionsLeft>,
    /// The line of the region that comes nearest to a singularity, and its least angle.
    pub nearest: Option<(u64, Angle)>,
    /// The line of the region that needs the fastest rotary axis as uploaded, and that speed \[deg/s\].
    pub fastest: Option<(u64, f64)>,
    /// The figures of all regions, as uploaded.
    pub before: RegionFigures,
    /// The figures of all regions, as written. Unchanged regions count as they were.
    pub after: RegionFigures,
    /// Blocks whose words changed.
    pub blocks_changed: u64,
    /// Blocks inserted.
    pub blocks_inserted: u64,
    /// Blocks that changed only because their F word was restored.
    pub feeds_restored: u64,
    /// Largest angle between a written and a programmed tool axis at a point.
    pub axis_spent: Angle,
    /// Warnings for the caller about the text.
    pub warnings: Vec<Warning>,
}

impl SingularityReport {
    /// Largest number of regions that are listed.
    pub const MAX_REGIONS: usize = 200;
}
