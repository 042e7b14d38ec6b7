//! What the treatment of singular regions has to show.

use super::parameters::SingularityAction;
use crate::kinematics::SingularityKind;
use crate::process::fault::Warning;
use crate::program::{Dialect, StepName, Steps};
use crate::units::{Angle, Length};

/// Why a region, or a motion of it, is left as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftReason {
    /// Its motions keep the tolerances and the step already, or other words would need nearly as fast axes.
    NothingToGain,
    /// The decimals of the rotary words use up the tolerance of the tool axis, or those of X Y Z that of the contact.
    DecimalsTooCoarse,
    /// More parts than a block is divided into.
    TooManyParts,
    /// The great circle, or the path with less travel, leaves what the rotary axes reach.
    OutOfReach,
    /// The axes would leave their travel.
    OutOfTravel,
    /// G93 without F.
    NoInverseTime,
    /// E counts from an unknown value.
    ExtruderUnknown,
    /// An F word would be too small to be written.
    FeedTooSmall,
    /// An F word would be more than allowed.
    FeedTooHigh,
    /// Some blocks of the region state a contact and others do not.
    MixedContacts,
    /// The program was smoothed before.
    SmoothedBefore,
    /// The program states the tool axis as a vector: its control chooses the rotary words.
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

    /// The warning in words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NothingToGain => {
                "the motions keep what is asked for already, or no words within the tolerance need slower rotary axes"
            }
            Self::DecimalsTooCoarse => "the decimals of the program's words cannot keep the tolerance",
            Self::TooManyParts => {
                "the rotary axes turn so far near the pole that a block would become more than 2048 parts"
            }
            Self::OutOfReach => "the way lies outside what the two rotary axes can reach",
            Self::OutOfTravel => "an axis would leave its travel",
            Self::NoInverseTime => "G93 needs an F word in every block, and a block has none",
            Self::ExtruderUnknown => "E counts from an unknown value",
            Self::FeedTooSmall => "an F word would be too small to be written",
            Self::FeedTooHigh => {
                "a block would need more feed than max_feed_mm_per_min, or than ten times the programmed feed where that is not stated"
            }
            Self::SmoothedBefore => {
                "the program bears the stamp of this step: the tolerance of the tool axis was spent when it was smoothed"
            }
            Self::MixedContacts => "some blocks state a contact and others do not",
            Self::ToolVectors => {
                "the tool axis is programmed as a vector; the control chooses the rotary words"
            }
        }
    }
}

impl SingularityReport {
    /// The steps that changed something: this one, or none.
    #[must_use]
    pub fn steps(&self) -> Steps {
        let is_changed = self.blocks_changed > 0 || self.blocks_inserted > 0;
        if is_changed { Steps::of(&[StepName::Singularity]) } else { Steps::NONE }
    }
}

/// What the motions of a region need and leave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RegionFigures {
    /// The largest speed of a rotary axis \[deg/s\], mean over a block; `None` where no block's time is known.
    pub rotary_deg_per_s: Option<f64>,
    /// Motions that need more than the largest speed.
    pub motions_over_speed: u64,
    /// The largest turn of a rotary axis in one block \[deg\].
    pub step_deg: f64,
    /// Turns of both rotary axes, summed \[deg\].
    pub travel_deg: f64,
    /// Largest distance of the contact (the tip where none is known) from its line.
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

/// What was done about a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegionTreatment {
    /// It was reported.
    Reported,
    /// It was left as it is.
    Left(LeftReason),
    /// Motions were divided.
    Densified {
        /// How many.
        divided: u64,
        /// Blocks inserted.
        inserted: u64,
        /// Motions that needed it and could not be divided.
        left: u64,
        /// Why the first of them.
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
    /// Of its last one.
    pub last_line: u64,
    /// How many.
    pub motions: u64,
    /// What is singular where it comes nearest.
    pub kind: SingularityKind,
    /// The least angle of the tool axis to the singularity.
    pub least_angle: Angle,
    /// How far the tool axis turns there at least for a turn of the rotary axes by 1.
    pub least_gain: f64,
    /// What its motions need as uploaded.
    pub before: RegionFigures,
    /// As written, from the written text; `None` where nothing was changed.
    pub after: Option<RegionFigures>,
    /// What was done.
    pub treatment: RegionTreatment,
}

/// Regions left alone for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RegionsLeft {
    /// Why.
    pub reason: LeftReason,
    /// How many.
    pub count: u64,
    /// First line of the first one.
    pub first_line: u64,
}

/// The report of the treatment of singular regions.
#[derive(Debug, Clone, PartialEq)]
pub struct SingularityReport {
    /// The dialect read and written.
    pub dialect: Dialect,
    /// What was to be done.
    pub action: SingularityAction,
    /// Blocks of the upload.
    pub blocks_in: u64,
    /// Blocks written.
    pub blocks_out: u64,
    /// Motions at feed that were looked at.
    pub motions_checked: u64,
    /// Motions in regions.
    pub motions_singular: u64,
    /// Regions found; the first [`SingularityReport::MAX_REGIONS`] are in `regions`.
    pub regions_found: u64,
    /// The first faults, in program order.
    pub regions: Vec<SingularRegion>,
    /// Regions in which something was changed.
    pub regions_treated: u64,
    /// Regions left alone, by reason.
    pub left: Vec<RegionsLeft>,
    /// The line of the region that comes nearest to a singularity, and how near.
    pub nearest: Option<(u64, Angle)>,
    /// The line of the region that needs the fastest rotary axis as uploaded, and how fast \[deg/s\].
    pub fastest: Option<(u64, f64)>,
    /// Of all regions, as uploaded.
    pub before: RegionFigures,
    /// Of all regions, as written; those left alone as they were.
    pub after: RegionFigures,
    /// Blocks whose words changed.
    pub blocks_changed: u64,
    /// Blocks inserted.
    pub blocks_inserted: u64,
    /// Blocks that only got their F word back.
    pub feeds_restored: u64,
    /// Largest angle between a written and a programmed tool axis at a point.
    pub axis_spent: Angle,
    /// What the caller should know about the text.
    pub warnings: Vec<Warning>,
}

impl SingularityReport {
    /// Most regions that are listed.
    pub const MAX_REGIONS: usize = 200;
}
