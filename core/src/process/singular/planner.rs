//! Plans the changes to the motions of a region.

use super::contact::Cutting;
use super::figures::Limits;
use super::parameters::SingularityParameters;
use super::pending::Pending;
use super::report::LeftReason;
use crate::contact::{BlockTime, CutterContact, Effort, SourceBlock, Station};
use crate::motion::{AxisWords, ContactWords, FeedMode, Interpolation, Motion};
use crate::process::divided::{Checked, Division};
use crate::process::pipeline::{FeedInTime, feed_in_time, rounded_feed};
use crate::process::set_up::{TravelCheck, Travels};
use crate::process::text::Survey;
use crate::program::NewWord;

/// A block whose path changes gets a new F word if its time would change by more than this share.
const NOTICEABLE_TIME: f64 = 0.002;

/// The planned change to a motion.
#[derive(Debug, Default)]
pub(super) enum Change<'a> {
    /// Its block is copied.
    #[default]
    Keep,
    /// It gets new ends.
    Move(Box<SmoothedMotion>),
    /// It is divided.
    Divide(Box<DensifiedMotion<'a>>),
}

/// A motion with new ends.
#[derive(Debug, Clone)]
pub(super) struct SmoothedMotion {
    pub(super) pending: Pending,
    /// The new ends, as written.
    pub(super) ends: [AxisWords; 2],
    pub(super) contact: ContactWords,
    /// Changed or inserted words.
    pub(super) words: Vec<NewWord>,
    /// The F word that keeps the motion's time, if the source's F does not.
    pub(super) feed: Option<NewWord>,
    /// The contact that is kept at its end.
    pub(super) touch: Option<CutterContact>,
    /// Half a unit of the last decimal \[mm\].
    pub(super) half_mm: f64,
}

/// A divided motion.
#[derive(Debug)]
pub(super) struct DensifiedMotion<'a> {
    pub(super) source: Motion,
    pub(super) checked: Checked<'a>,
    pub(super) division: Division,
}

/// The inputs of a plan.
#[derive(Debug, Clone)]
pub(super) struct Planner<'a> {
    pub(super) cutting: Cutting<'a>,
    pub(super) survey: Survey,
    pub(super) singularity: SingularityParameters,
}

impl<'a> Planner<'a> {
    pub(super) fn limits(&self) -> Limits {
        Limits {
            tolerance_mm: self.cutting.parameters.tolerance.mm(),
            axis_tolerance_rad: self.singularity.axis_tolerance.rad(),
            max_deg_per_s: self.singularity.max_rotary_deg_per_s,
        }
    }

    /// The source block of a motion, with its contacts if both are known.
    pub(super) fn block(&self, pending: &Pending, effort: &mut Effort<'_>) -> SourceBlock<'a> {
        let mut touch = |k: usize, words| self.cutting.touch(&pending.ends[k], pending.mode, words, effort);
        let contacts = [touch(0, pending.start_contact), touch(1, pending.motion.contact)];
        self.cutting.block(pending.mode, pending.ends, contacts)
    }

    /// The same, with the set-up and the cutter of this motion.
    pub(super) fn on(&self, pending: &Pending) -> Self {
        Self { cutting: self.cutting.on(pending), ..*self }
    }

    pub(super) fn station(&self, mode: Interpolation, words: AxisWords) -> Station {
        Station::new(self.cutting.machine, &self.cutting.kinematics, mode, words)
    }

    /// Decimals of linear and rotary words that are rewritten: the finest of the program, and no coarser than a
    /// control's increments. Postprocessors strip trailing zeros.
    pub(super) fn decimals(&self, motion: &Motion) -> [u8; 2] {
        self.survey.written_decimals(motion.mm_per_unit)
    }

    /// Whether an axis would leave its travel at these words, as far as the positions of the axes are known.
    pub(super) fn is_outside(&self, mode: Interpolation, words: &AxisWords) -> bool {
        let Cutting { machine, kinematics, is_stated, .. } = &self.cutting;
        let mut is_outside = false;
        let check = TravelCheck { machine, kinematics, is_stated: *is_stated };
        // The step after this one (move ends or contact path) warns of travels that cannot be checked.
        let (Travels::Checked | Travels::NotChecked) = check.see(mode, words, |_| is_outside = true);
        is_outside
    }

    /// The F word with which a motion between these ends takes the source's time, if the source's own F does not.
    pub(super) fn feed(
        &self,
        pending: &Pending,
        ends: [AxisWords; 2],
    ) -> Result<Option<NewWord>, LeftReason> {
        let feed = &pending.motion.feed;
        let (Some(mode), Some(_)) = (feed.mode, feed.value) else { return Ok(None) };
        if mode == FeedMode::InverseTime || !self.survey.has_feed_column {
            return Ok(None);
        }
        let unit = pending.motion.mm_per_unit;
        let time = |block: &SourceBlock<'_>| BlockTime::of(block, &block.whole(), unit, feed.paths);
        let source = self.cutting.block(pending.mode, pending.ends, [None, None]);
        let stations = ends.map(|words| self.station(pending.mode, words));
        let written = self.cutting.block(pending.mode, stations, [None, None]);
        let times = [&time(&source), &time(&written)];
        let in_time = feed_in_time(&pending.motion, times, 1.0, self.cutting.parameters.max_feed);
        match in_time.filter(|in_time| (in_time.value() / feed.raw - 1.0).abs() > NOTICEABLE_TIME) {
            None => Ok(None),
            Some(FeedInTime::Fits(value)) => Ok(Some(rounded_feed(feed, value))),
            Some(FeedInTime::TooLow(_)) => Err(LeftReason::FeedTooSmall),
            Some(FeedInTime::TooHigh(_)) => Err(LeftReason::FeedTooHigh),
        }
    }
}
