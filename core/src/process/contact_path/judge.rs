//! Decides which motions are checked, where the cutter touches at their ends, and how far the contact deviates
//! between them.

mod assumed;
mod glance;
mod travel;

use super::contact_finder::ContactFinder;
use super::parameters::CcParameters;
use crate::contact::{
    Carry, CutterContact, Effort, QuickLook, Sampled, SourceBlock, Station, Touch, quick_look,
    sample_until_sure,
};
use crate::geometry::{Vec3, across};
use crate::kinematics::ToolPose;
use crate::machine::{Machine, Tool};
use crate::motion::{AxisWords, ContactWords, Interpolation, Motion, MotionKind, Unfollowable};
use crate::process::divided::Checked;
use crate::process::fault::{LineFaultKind, LineFaults, WarningKind, Warnings};
use crate::process::set_up::{ContactSource, SetUps, may_roll_over};
use crate::process::text::{MotionPoses, Passage};
use crate::program::Dialect;

/// If a quick look leaves less than this share of the tolerance open, no closer look is needed.
const NEGLIGIBLE: f64 = 0.02;
/// Mean square of a parabola over its arc, as a share of its top squared.
const PARABOLA_MEAN_SQUARE: f64 = 8.0 / 15.0;

/// The result for a checked motion.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "lives for one call")]
pub(in crate::process) enum Verdict<'a> {
    /// Within tolerance.
    Within {
        /// Length of the contact line \[mm\].
        path_mm: f64,
        before: Sampled,
    },
    /// To be divided.
    Over(Checked<'a>),
}

/// A program point on the path.
#[derive(Debug, Clone, Copy)]
struct JudgedPoint {
    station: Station,
    mode: Interpolation,
    words: ContactWords,
    touch: Option<Touch>,
    /// The stated contact is impossible. The fault is recorded.
    faulty: bool,
    /// The contact point that follows from the touch, in W \[mm\].
    contact_mm: Vec3,
    line: u64,
}

impl JudgedPoint {
    fn new(station: Station, mode: Interpolation, motion: &Motion) -> Self {
        let contact_mm = station.pose.tip_mm;
        Self {
            station,
            mode,
            words: motion.contact,
            touch: None,
            faulty: false,
            contact_mm,
            line: motion.line,
        }
    }

    /// Reuses a point that is no longer needed as the end of a motion.
    #[inline]
    fn arrive(&mut self, words: &AxisWords, pose: &ToolPose, mode: Interpolation, motion: &Motion) {
        // The fields are set one by one. A point built elsewhere and moved here would be read before it is written.
        let Self { station, mode: own_mode, words: contact, touch, faulty, contact_mm, line } = self;
        let Station { words: own_words, pose: own_pose } = station;
        (*own_words, *own_pose, *own_mode) = (*words, *pose, mode);
        (*contact, *touch, *faulty) = (motion.contact, None, false);
        (*contact_mm, *line) = (pose.tip_mm, motion.line);
    }
}

/// Judges motion after motion, in the order of the program.
pub(in crate::process) struct Judge<'a> {
    pub(super) machine: &'a Machine,
    pub(super) set_ups: SetUps,
    /// The cutter in the spindle. If it is not known, a placeholder on which nothing depends.
    tool: Tool,
    parameters: &'a CcParameters,
    finder: ContactFinder<'a>,
    dialect: Dialect,
    /// The last program point, if it is known, and the memory for the next one. Points are too large to be passed by
    /// value.
    point: Option<Box<JudgedPoint>>,
    spare: Option<Box<JudgedPoint>>,
    /// The last motions were only glanced at, so the last point is not theirs.
    has_glanced: bool,
    /// The feed of the last motion of the pass whose tip shows it.
    feed_before: Option<Vec3>,
    /// The last contact words stated, and those that held before the current motion.
    stated: ContactWords,
    stated_before: ContactWords,
    /// Motions whose contacts were assumed.
    pub(in crate::process) assumed: u64,
    pub(in crate::process) warnings: Warnings,
    pub(in crate::process) faults: LineFaults,
    pub(in crate::process) effort: Effort<'a>,
}

impl<'a> Judge<'a> {
    pub(in crate::process) fn new(
        machine: &'a Machine,
        parameters: &'a CcParameters,
        dialect: Dialect,
        contact: ContactSource,
        effort: Effort<'a>,
    ) -> Self {
        let set_ups = SetUps::new(machine, &parameters.program);
        Self {
            machine,
            tool: set_ups.now.cutter().unwrap_or(Tool::UNIT_BALL),
            set_ups,
            parameters,
            finder: ContactFinder { machine, parameters, source: contact },
            dialect,
            point: None,
            spare: None,
            has_glanced: false,
            feed_before: None,
            stated: ContactWords::None,
            stated_before: ContactWords::None,
            assumed: 0,
            warnings: Warnings::default(),
            faults: LineFaults::default(),
            effort,
        }
    }

    /// The mode in which a motion is judged. The parameter overrides the program's own switches.
    pub(in crate::process) fn mode(&self, motion: &Motion) -> Interpolation {
        motion.mode(self.parameters.program.interpolation)
    }

    /// The finder of contacts.
    pub(in crate::process) fn finder(&self) -> &ContactFinder<'a> {
        &self.finder
    }

    /// Judges the motion of this index in a prepared passage. `following` is the first motion after the passage,
    /// `text` the motion's block. Deviations that could be the largest so far (`largest_after_mm`) are measured;
    /// smaller ones are only bounded. Returns `None` if the motion is not checked.
    pub(in crate::process) fn judge(
        &mut self,
        passage: &Passage,
        index: usize,
        following: Option<&Motion>,
        text: &[u8],
        largest_after_mm: f64,
    ) -> Option<Verdict<'a>> {
        if let Some(before) = index.checked_sub(1) {
            self.catch_up(passage, before);
        }
        let motion = &passage.motions[index];
        let mode = self.mode(motion);
        if self.set_ups.enter(motion) {
            // The same words now mean another place, or another cutter touches at another point.
            self.point = None;
            self.tool = self.set_ups.now.cutter().unwrap_or(Tool::UNIT_BALL);
        }
        self.stated_before = self.stated;
        if motion.contact != ContactWords::None || motion.kind == MotionKind::Opaque {
            // The effect of a call or a cycle on the contact words is not known.
            self.stated = motion.contact;
        }
        let pose = &passage.poses[index].end;
        let mut end = motion.end.as_ref().map(|words| self.arrived(words, pose, mode, motion));
        if let Some(end) = &end {
            self.check_travel(motion, &end.station.words, text);
        }
        if self.rests(motion, mode) {
            self.spare = end;
            return None;
        }
        let mut start = self.point.take();
        let verdict = match (motion.start, &mut end) {
            (Some(_), Some(_)) if self.looks_at(motion) && self.is_missing_something(motion, mode, text) => {
                // The path depends on a missing value, so nothing more can be said about this motion.
                self.feed_before = None;
                None
            }
            (Some(start_words), Some(end)) if self.looks_at(motion) => {
                let known = start.take().filter(|at| at.mode == mode && at.station.words == start_words);
                if known.is_none() {
                    self.feed_before = None;
                }
                let mut start_point = known.unwrap_or_else(|| {
                    let kinematics = &self.set_ups.now.kinematics;
                    let station = Station::new(self.machine, kinematics, mode, start_words);
                    Box::new(JudgedPoint {
                        words: ContactWords::None,
                        ..JudgedPoint::new(station, mode, motion)
                    })
                });
                let verdict =
                    self.between(&mut start_point, end, passage, index, following, text, largest_after_mm);
                start = Some(start_point);
                verdict
            }
            _ => {
                self.feed_before = None;
                self.say_why_not(motion);
                None
            }
        };
        self.point = end;
        if start.is_some() {
            self.spare = start;
        }
        verdict
    }

    /// The point at the end of a motion.
    #[inline]
    fn arrived(
        &mut self,
        words: &AxisWords,
        pose: &ToolPose,
        mode: Interpolation,
        motion: &Motion,
    ) -> Box<JudgedPoint> {
        match self.spare.take() {
            Some(mut point) => {
                point.arrive(words, pose, mode, motion);
                point
            }
            None => Box::new(JudgedPoint::new(Station { words: *words, pose: *pose }, mode, motion)),
        }
    }

    /// Whether a value is missing on which the path of this motion depends. If so, records a fault.
    fn is_missing_something(&mut self, motion: &Motion, mode: Interpolation, text: &[u8]) -> bool {
        let missing = self.set_ups.now.missing_for_turning(mode, motion);
        let is_missing = missing.is_some();
        if let Some(kind) = missing {
            self.faults.add(motion.line, text, kind);
        }
        is_missing
    }

    /// Judges the motion of this index between the points at its ends.
    #[expect(clippy::too_many_arguments, reason = "the arguments of `judge`, and its two points")]
    #[inline]
    fn between(
        &mut self,
        start: &mut JudgedPoint,
        end: &mut JudgedPoint,
        passage: &Passage,
        index: usize,
        following: Option<&Motion>,
        text: &[u8],
        largest_after_mm: f64,
    ) -> Option<Verdict<'a>> {
        let motion = &passage.motions[index];
        let mut pass_feed = None;
        if self.finder.assumes() {
            let feed = self.feed(start, end, passage, index, following);
            pass_feed = feed;
            self.assume(start, end, feed, motion);
        } else {
            if start.touch.is_none() && !start.faulty {
                self.touch(start, text);
            }
            self.touch(end, text);
        }
        let (Some(from), Some(to)) = (start.touch, end.touch) else {
            self.warnings.add(WarningKind::NoContact, Some(motion.line));
            return None;
        };
        let mut contacts = [from.contact, to.contact];
        if from.is_open || to.is_open {
            self.warnings.add(WarningKind::ContactOpen, Some(motion.line));
            contacts = [CutterContact::Tip; 2];
        }
        if self.contact_swings([start, end], &contacts) {
            self.warnings.add(WarningKind::ContactSwings, Some(motion.line));
            return None;
        }
        Some(self.measure([start, end], contacts, pass_feed, &passage.poses[index], largest_after_mm))
    }

    /// Whether the touching side of a bull-nose or flat cutter turns too far within a block for a line to join the
    /// two contacts. The limit is 90° for stated contacts and 45° for assumed ones.
    fn contact_swings(&self, ends: [&JudgedPoint; 2], contacts: &[CutterContact; 2]) -> bool {
        if self.tool.is_ball() {
            return false;
        }
        let least = if self.finder.assumes() { std::f64::consts::FRAC_1_SQRT_2 } else { 0.0 };
        let side = |k: usize| match contacts[k] {
            CutterContact::Tip => None,
            CutterContact::Offset { radial_mm, .. } if radial_mm < CutterContact::ON_AXIS_MM => None,
            CutterContact::Offset { inward, .. } => Some(inward),
            CutterContact::Normal { direction, .. } => {
                across(direction, ends[k].station.pose.axis).try_normalize(f64::EPSILON)
            }
        };
        matches!((side(0), side(1)), (Some(a), Some(b)) if a.dot(&b) < least)
    }

    /// Whether a straight motion goes nowhere. It is then no motion; at most it states another contact for the point.
    fn rests(&mut self, motion: &Motion, mode: Interpolation) -> bool {
        let rests = motion.kind == MotionKind::Linear && motion.start.is_some() && motion.start == motion.end;
        if rests {
            self.point = self.point.take().filter(|point| point.mode == mode);
            if let (Some(point), true) = (&mut self.point, motion.contact != ContactWords::None) {
                (point.words, point.line) = (motion.contact, motion.line);
                (point.touch, point.faulty) = (None, false);
            }
        }
        rests
    }

    fn measure(
        &mut self,
        [start, end]: [&JudgedPoint; 2],
        contacts: [CutterContact; 2],
        pass_feed: Option<Vec3>,
        MotionPoses { middle, .. }: &MotionPoses,
        largest_after_mm: f64,
    ) -> Verdict<'a> {
        let tool = self.tool;
        let tolerance_mm = self.parameters.tolerance.mm();
        let mode = end.mode;
        let kinematics = &self.set_ups.now.kinematics;
        let ends = [&start.station, &end.station];
        let contacts_mm = match &contacts {
            [CutterContact::Tip, CutterContact::Tip] => ends.map(|end| end.pose.tip_mm),
            _ => [start.contact_mm, end.contact_mm],
        };
        let both = [&contacts[0], &contacts[1]];
        self.effort.spend(1);
        let look = quick_look(kinematics, &tool, mode, ends, both, contacts_mm, middle);
        if let Some(before) = look.and_then(|look| self.by_look(&look, largest_after_mm)) {
            return Verdict::Within { path_mm: (contacts_mm[1] - contacts_mm[0]).norm(), before };
        }
        let carry = Carry::between(&tool, both, ends.map(|end| end.pose.axis));
        let ends = ends.map(|end| *end);
        let block = SourceBlock::new(self.machine, kinematics, tool, mode, ends, carry);
        let before = sample_until_sure(&block, &block.whole(), tolerance_mm);
        self.effort.spend(before.evaluations);
        if before.max_mm <= tolerance_mm {
            return Verdict::Within { path_mm: block.line.length_mm, before };
        }
        let standing = if start.words == ContactWords::None { self.stated_before } else { start.words };
        let start_contact = match standing {
            ContactWords::None => None,
            ContactWords::Point(words) | ContactWords::Normal(words) => Some(words),
        };
        let contact_from_words = self.finder.source == ContactSource::Program;
        Verdict::Over(Checked { block, before, contact_from_words, start_contact, contacts, pass_feed })
    }

    /// The deviation of a motion, if a look at it is enough.
    #[inline]
    fn by_look(&self, look: &QuickLook, largest_after_mm: f64) -> Option<Sampled> {
        let tolerance_mm = self.parameters.tolerance.mm();
        let QuickLook { middle, at_most_mm } = *look;
        let is_enough =
            at_most_mm <= tolerance_mm.min(largest_after_mm) && look.is_telling(NEGLIGIBLE * tolerance_mm);
        is_enough.then(|| Sampled {
            max_mm: middle.distance_mm,
            mean_square_mm2: PARABOLA_MEAN_SQUARE * middle.distance_mm.powi(2),
            max_excess_mm: middle.along_normal_mm.max(0.0),
            max_gouge_mm: (-middle.along_normal_mm).max(0.0),
            evaluations: 1,
        })
    }

    /// Finds the contact at a point. Records faults; the point then has no contact.
    fn touch(&mut self, point: &mut JudgedPoint, text: &[u8]) {
        let kinematics = &self.set_ups.now.kinematics;
        let tool = &self.tool;
        let (station, effort) = (&point.station, &mut self.effort);
        let found = match self.finder.find(kinematics, tool, station, point.mode, point.words, effort) {
            Ok(found) => found,
            Err(fault) => {
                point.faulty = true;
                self.faults.add(point.line, text, LineFaultKind::Contact(fault));
                None
            }
        };
        if let Some(touch) = found.filter(|touch| touch.off_tool_mm > Touch::ON_TOOL_MM) {
            self.warnings.add_distance(WarningKind::ContactOffTool, point.line, touch.off_tool_mm);
        }
        self.put(point, found);
    }

    /// Stores a contact in a point.
    fn put(&self, point: &mut JudgedPoint, touch: Option<Touch>) {
        point.touch = touch;
        if let Some(touch) = &point.touch {
            let pose = &point.station.pose;
            point.contact_mm = pose.tip_mm + touch.contact.offset_mm(&self.tool, pose.axis);
        }
    }

    fn say_why_not(&mut self, motion: &Motion) {
        let silent = matches!(
            motion.unfollowable,
            Some(Unfollowable::Reference | Unfollowable::Return | Unfollowable::TurnToPlane)
        );
        if motion.kind == MotionKind::Rapid || silent {
            return;
        }
        if let Some(reason) = motion.unfollowable {
            let warning = self.warnings.add(WarningKind::NotFollowed, Some(motion.line));
            warning.reason.get_or_insert(reason);
        } else if motion.offset_changed {
            self.warnings.add(WarningKind::WorkOffsetChanged, Some(motion.line));
        } else if self.may_roll_over(motion) {
            self.warnings.add(WarningKind::MayRollOver, Some(motion.line));
        } else if motion.kind == MotionKind::Linear && self.set_ups.now.is_foreign() {
            if self.set_ups.tells_unknown_tools() {
                self.warnings.add(WarningKind::ToolUnknown, Some(motion.line));
            }
        } else if motion.kind == MotionKind::Arc
            && let (Some(start), Some(end)) = (motion.start, motion.end)
            && start.rotary_deg.iter().zip(&end.rotary_deg).any(|(from, to)| (to - from).abs() > 0.0)
        {
            self.warnings.add(WarningKind::ArcWithRotary, Some(motion.line));
        }
    }

    /// Whether the motion is to be checked.
    fn looks_at(&self, motion: &Motion) -> bool {
        checkable(motion) && !self.may_roll_over(motion) && !self.set_ups.now.is_foreign()
    }

    fn may_roll_over(&self, motion: &Motion) -> bool {
        may_roll_over(self.machine, self.dialect, motion)
    }
}

fn checkable(motion: &Motion) -> bool {
    motion.kind == MotionKind::Linear
        && motion.start.is_some()
        && motion.end.is_some()
        && motion.unfollowable.is_none()
        && !motion.offset_changed
}
