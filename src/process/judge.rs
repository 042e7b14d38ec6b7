//! Which motions are checked, where the cutter touches at their ends, and how far the contact strays between.

use super::fault::{LineFaultKind, LineFaults};
use super::warnings::Warnings;
use super::{CcParameters, ContactSource, WarningKind};
use crate::contact::{
    Carry, CutterContact, Sampled, SourceBlock, Station, Touch, feed_plane_normal, rotary_rad,
    sample_until_sure,
};
use crate::geometry::Vec3;
use crate::kinematics::Kinematics;
use crate::machine::{Machine, Travel};
use crate::motion::{AxisWords, ContactWords, Interpolation, Motion, MotionKind, Unfollowable};

/// Words this far outside the travel are still rounding of the decimals [mm or deg].
const TRAVEL_SLACK: f64 = 1e-6;
/// With one step in the middle the true maximum exceeds it by at most this share of `|c″|`: `1/(8·2²)`.
const MIDPOINT_SLACK: f64 = 1.0 / 32.0;
/// Mean square of a parabola over its arc, as a share of its top squared.
const PARABOLA_MEAN_SQUARE: f64 = 8.0 / 15.0;

/// A motion that was checked.
#[derive(Debug, Clone)]
pub(super) struct Checked<'a> {
    pub(super) block: SourceBlock<'a>,
    pub(super) before: Sampled,
    pub(super) over_tolerance: bool,
    /// U V W words gave the contacts, so that new blocks get U V W of the contact aimed at.
    pub(super) contact_from_words: bool,
    /// U V W or nx ny nz of the start point, if it has them.
    pub(super) start_contact: Option<[f64; 3]>,
}

/// A program point on the way.
#[derive(Debug, Clone, Copy)]
struct Point {
    station: Station,
    mode: Interpolation,
    words: ContactWords,
    touch: Option<Touch>,
    line: u64,
}

/// Looks at motion after motion, in the order of the program.
pub(super) struct Judge<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    parameters: &'a CcParameters,
    contact: ContactSource,
    point: Option<Point>,
    pub(super) warnings: Warnings,
    pub(super) faults: LineFaults,
    pub(super) evaluations: u64,
}

impl<'a> Judge<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        kinematics: &'a Kinematics,
        parameters: &'a CcParameters,
        contact: ContactSource,
    ) -> Self {
        Self {
            machine,
            kinematics,
            parameters,
            contact,
            point: None,
            warnings: Warnings::default(),
            faults: LineFaults::default(),
            evaluations: 0,
        }
    }

    /// The mode a motion is judged in: the parameter wins over the program's own switches.
    pub(super) fn mode(&self, motion: &Motion) -> Interpolation {
        self.parameters.interpolation.unwrap_or(motion.interpolation)
    }

    /// Judges `motion`; `following` is the motion after it, `text` its block. Deviations that could be the
    /// largest so far (`largest_after_mm`) are measured, smaller ones only bounded. `None`: not checked.
    pub(super) fn judge(
        &mut self,
        motion: &Motion,
        following: Option<&Motion>,
        text: &[u8],
        largest_after_mm: f64,
    ) -> Option<Checked<'a>> {
        let mode = self.mode(motion);
        let end = motion.end.map(|words| Point {
            station: Station::new(self.machine, self.kinematics, mode, words),
            mode,
            words: motion.contact,
            touch: None,
            line: motion.line,
        });
        if let Some(end) = &end {
            self.check_travel(motion, &end.station, text);
        }
        let start = self.point.take();
        self.point = end;
        let (Some(start_words), Some(mut end)) = (motion.start, end) else {
            self.say_why_not(motion);
            return None;
        };
        if !checkable(motion) {
            self.say_why_not(motion);
            return None;
        }
        let mut start = start
            .filter(|point| point.mode == mode && point.station.words == start_words)
            .unwrap_or_else(|| Point {
                station: Station::new(self.machine, self.kinematics, mode, start_words),
                mode,
                words: ContactWords::None,
                touch: None,
                line: motion.line,
            });
        let (from, to) = (start.station.pose.tip_mm, end.station.pose.tip_mm);
        if start.touch.is_none() {
            // The first point of a pass: its neighbour is only the next one.
            start.touch = self.touch(&start, to - from, text);
        }
        let beyond = following
            .filter(|next| checkable(next) && next.start == motion.end && self.mode(next) == mode)
            .and_then(|next| next.end)
            .map_or(to, |words| Station::new(self.machine, self.kinematics, mode, words).pose.tip_mm);
        end.touch = self.touch(&end, beyond - from, text);
        self.point = Some(end);
        let (Some(start_touch), Some(end_touch)) = (start.touch, end.touch) else {
            self.warnings.add(WarningKind::NoContact, Some(motion.line));
            return None;
        };
        let start_contact = match start.words {
            ContactWords::None => None,
            ContactWords::Point(words) | ContactWords::Normal(words) => Some(words),
        };
        let ends = [start.station, end.station];
        Some(self.measure(mode, ends, [&start_touch, &end_touch], start_contact, largest_after_mm))
    }

    fn measure(
        &mut self,
        mode: Interpolation,
        ends: [Station; 2],
        touches: [&Touch; 2],
        start_contact: Option<[f64; 3]>,
        largest_after_mm: f64,
    ) -> Checked<'a> {
        let tool = self.parameters.tool;
        let carry = Carry::between(&tool, touches.map(|touch| &touch.contact), ends.map(|end| end.pose.axis));
        let block = SourceBlock::new(self.machine, self.kinematics, tool, mode, ends, carry);
        let tolerance_mm = self.parameters.tolerance.mm();
        let whole = block.whole();
        let middle = block.deviation_at(&whole, 0.5);
        self.evaluations += 1;
        let at_most = block
            .curvature_bound_mm(&whole)
            .map_or(f64::INFINITY, |bound| middle.distance_mm + MIDPOINT_SLACK * bound);
        let before = if at_most <= tolerance_mm && at_most <= largest_after_mm {
            Sampled {
                max_mm: middle.distance_mm,
                mean_square_mm2: PARABOLA_MEAN_SQUARE * middle.distance_mm.powi(2),
                max_excess_mm: middle.along_normal_mm.max(0.0),
                max_gouge_mm: (-middle.along_normal_mm).max(0.0),
                evaluations: 1,
            }
        } else {
            sample_until_sure(&block, &whole, tolerance_mm)
        };
        self.evaluations += before.evaluations;
        let over_tolerance = before.max_mm > tolerance_mm;
        let contact_from_words = self.contact == ContactSource::Program;
        Checked { block, before, over_tolerance, contact_from_words, start_contact }
    }

    /// The contact at a point; `chord_mm` is the chord of its neighbouring tips. Faults are noted, and no contact
    /// comes back then.
    fn touch(&mut self, point: &Point, chord_mm: Vec3, text: &[u8]) -> Option<Touch> {
        let tool = &self.parameters.tool;
        let pose = &point.station.pose;
        let feed_direction = chord_mm.try_normalize(f64::MIN_POSITIVE);
        let found = match (self.contact, point.words) {
            (ContactSource::Tip, _) => {
                Ok(Touch { contact: CutterContact::Tip, off_tool_mm: 0.0, side_assumed: false })
            }
            (ContactSource::Program, ContactWords::Point(contact)) => {
                let contact_mm = match point.mode {
                    Interpolation::Tcp => Vec3::from(contact),
                    Interpolation::Machine => {
                        let rotary_rad = rotary_rad(self.machine, point.station.words.rotary_deg);
                        self.kinematics.tip_mm(Vec3::from(contact), rotary_rad)
                    }
                };
                Touch::from_point(tool, pose, contact_mm, feed_direction)
            }
            (ContactSource::Normals, ContactWords::Normal(normal)) => {
                Touch::from_normal(tool, pose, Vec3::from(normal), feed_direction)
            }
            (ContactSource::FeedPlane, _) => {
                // A tip that rests or plunges along its axis touches with its lowest point.
                let normal =
                    feed_direction.and_then(|feed| feed_plane_normal(pose.axis, feed)).unwrap_or(pose.axis);
                Touch::from_normal(tool, pose, normal, feed_direction)
            }
            _ => return None,
        };
        match found {
            Ok(touch) => {
                if touch.off_tool_mm > Touch::ON_TOOL_MM {
                    let kind = WarningKind::ContactOffTool;
                    self.warnings.add_distance(kind, point.line, touch.off_tool_mm);
                }
                if touch.side_assumed {
                    self.warnings.add(WarningKind::ContactSideAssumed, Some(point.line));
                }
                Some(touch)
            }
            Err(fault) => {
                self.faults.add(point.line, text, LineFaultKind::Contact(fault));
                None
            }
        }
    }

    fn say_why_not(&mut self, motion: &Motion) {
        if motion.kind == MotionKind::Rapid || motion.unfollowable == Some(Unfollowable::Reference) {
            return;
        }
        if let Some(reason) = motion.unfollowable {
            let warning = self.warnings.add(WarningKind::NotFollowed, Some(motion.line));
            warning.reason.get_or_insert(reason);
        } else if motion.offset_changed {
            self.warnings.add(WarningKind::WorkOffsetChanged, Some(motion.line));
        } else if motion.kind == MotionKind::Arc
            && let (Some(start), Some(end)) = (motion.start, motion.end)
            && start.rotary_deg != end.rotary_deg
        {
            self.warnings.add(WarningKind::ArcWithRotary, Some(motion.line));
        }
    }

    fn check_travel(&mut self, motion: &Motion, station: &Station, text: &[u8]) {
        if motion.kind == MotionKind::Opaque || motion.unfollowable.is_some() || motion.offset_changed {
            return;
        }
        for (axis, word) in self.machine.rotary_axes().iter().zip(station.words.rotary_deg) {
            self.check_word(motion.line, text, axis.letter.as_char(), word, axis.travel_deg);
        }
        let travel = *self.machine.linear_travel_mm();
        if travel.iter().all(Option::is_none) {
            return;
        }
        let words = self.axis_words(self.mode(motion), &station.words, station.pose.tip_mm);
        for ((letter, word), travel) in ['X', 'Y', 'Z'].into_iter().zip(words).zip(travel) {
            self.check_word(motion.line, text, letter, word, travel);
        }
    }

    /// The positions that the linear axes take: the words themselves, or with TCP those that reach the tip.
    pub(super) fn axis_words(&self, mode: Interpolation, words: &AxisWords, tip_mm: Vec3) -> [f64; 3] {
        match mode {
            Interpolation::Machine => words.linear_mm,
            Interpolation::Tcp => {
                self.kinematics.linear_mm(tip_mm, rotary_rad(self.machine, words.rotary_deg)).into()
            }
        }
    }

    pub(super) fn check_word(
        &mut self,
        line: u64,
        text: &[u8],
        axis: char,
        word: f64,
        travel: Option<Travel>,
    ) {
        if let Some(travel) = travel
            && !travel.contains(word, TRAVEL_SLACK)
        {
            let Travel { min, max } = travel;
            self.faults.add(line, text, LineFaultKind::OutOfTravel { axis, commanded: word, min, max });
        }
    }
}

fn checkable(motion: &Motion) -> bool {
    motion.kind == MotionKind::Linear
        && motion.start.is_some()
        && motion.end.is_some()
        && motion.unfollowable.is_none()
        && !motion.offset_changed
}
