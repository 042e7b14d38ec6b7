//! Decides where a motion of the source must end for the worn cutter and the machine as it is, or why it cannot be
//! moved.

use super::assumption::Assumption;
use super::contact::{TIP, WornContact, by_normal, carried, flat};
use super::moves::Moves;
use super::parameters::WearParameters;
use super::points::{EndPoses, rests};
use super::report::CurvatureAcross;
use super::worn_tool::WornTool;
use super::written::{Axes, Resolution};
use crate::contact::{Effort, rotary_rad};
use crate::geometry::Vec3;
use crate::kinematics::{InverseError, NearWords, ToolPose};
use crate::machine::{Machine, Side};
use crate::motion::{ArcCourse, AxisWords, ContactWords, Interpolation, Motion, MotionKind, Unfollowable};
use crate::process::fault::{LineFaultKind, WarningKind, Warnings};
use crate::process::set_up::{ContactSource, SetUps, turn_between};

/// The direction of a chord shorter than this comes from rounding alone \[mm\].
pub(super) const RESTING_MM: f64 = 1e-6;

/// The decision about a motion.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "lives for one motion")]
pub(super) enum EndChoice {
    /// The motion is copied.
    Leave,
    /// The motion ends at another place.
    Move {
        goal: Goal,
        /// The source's pose and the kept contact. `None` if the point was looked at before.
        point: Option<MovedPoint>,
    },
}

/// The place where a motion must end.
#[derive(Debug, Clone, Copy)]
pub(super) enum Goal {
    /// At these words.
    Words(AxisWords),
    /// At these rotary words. The linear words put the tip where the point needs it, for the rotary words as written.
    Point { rotary_deg: [f64; 2] },
}

/// A point that was looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct MovedPoint {
    /// The pose as meant.
    pub(super) pose: ToolPose,
    /// The pose that the machine would take for the source's words.
    pub(super) real: ToolPose,
    /// The contact, or the tip itself if no contact is known.
    pub(super) contact: WornContact,
    pub(super) has_contact: bool,
    /// The contact is assumed from the feed.
    pub(super) is_assumed: bool,
    /// How much the length in the control is too long \[mm\].
    pub(super) behind_mm: f64,
    /// The motion ends inside the pole cone.
    pub(super) held: bool,
}

/// Decides motion after motion, in the order of the program.
pub(super) struct Pilot<'a> {
    pub(super) machine: &'a Machine,
    pub(super) moves: Moves<'a>,
    pub(super) parameters: &'a WearParameters,
    /// The worn cutter of the current section. `None` without wear, and for a tool of which nothing is known.
    pub(super) worn: Option<WornTool>,
    /// The set-up of the machine that runs the written program.
    pub(super) written: SetUps,
    pub(super) contact: ContactSource,
    pub(super) points: EndPoses<'a>,
    /// G90.1 is active: centres of arcs are points.
    pub(super) absolute_centres: bool,
    /// The shift of the last contact, without ΔL \[mm\].
    pub(super) carried_mm: Vec3,
    /// The last correction of the axis next to the workpiece that was found outside the pole cone \[deg\].
    pub(super) held_deg: f64,
    /// Whether the words of every point mean another place.
    pub(super) moves_everything: bool,
    pub(super) warnings: Warnings,
    /// The curvature of the part across the feed, at the contacts.
    pub(super) curvature: CurvatureAcross,
    /// Counts of contacts that are assumed from the feed.
    pub(super) assumption: Assumption,
    /// The effort of the search for contacts on the part.
    pub(super) effort: Effort<'a>,
}

impl Pilot<'_> {
    /// The decision about the motion of this index. `following` is the first motion after the batch. `axes` holds the
    /// place of the written program, `resolutions` the form of linear and rotary words.
    pub(super) fn decide(
        &mut self,
        motions: &[Motion],
        index: usize,
        following: Option<&Motion>,
        axes: &Axes,
        resolutions: [Resolution; 2],
    ) -> Result<EndChoice, LineFaultKind> {
        let motion = &motions[index];
        self.points.enter(motion);
        if self.written.enter(motion) {
            self.take_tool();
        }
        if self.is_other_tool() {
            self.carried_mm = Vec3::zeros();
            if !self.moves.recalibrates {
                let cuts = matches!(motion.kind, MotionKind::Linear | MotionKind::Arc)
                    && motion.unfollowable.is_none()
                    && motion.end.is_some();
                if cuts && self.written.tells_unknown_tools() {
                    self.warnings.add(WarningKind::ToolUnknown, Some(motion.line));
                }
                return as_in_the_source(motion, axes);
            }
        }
        if let Some(reason) = motion.unfollowable {
            self.carried_mm = Vec3::zeros();
            return self.unfollowed(motion, reason, axes);
        }
        if motion.offset_changed {
            if motion.kind != MotionKind::Rapid && self.would_move(motion, axes) {
                return Err(LineFaultKind::OtherWorkOffset);
            }
            self.carried_mm = Vec3::zeros();
            self.warnings.add(WarningKind::WorkOffsetChanged, Some(motion.line));
            return Ok(EndChoice::Leave);
        }
        let Some(end) = motion.end else {
            if motion.kind != MotionKind::Rapid && self.would_move(motion, axes) {
                return Err(LineFaultKind::PositionUnknown);
            }
            if self.moves_everything || axes.is_off() {
                self.warnings.add(WarningKind::PositionUnknown, Some(motion.line));
            }
            return Ok(EndChoice::Leave);
        };
        if motion.tool_axis.is_some() && axes.rotary.is_off() {
            // Earlier rotary words were changed, so the place from which the control turns to the vector is not
            // known.
            return Err(LineFaultKind::NotMovable(Unfollowable::ToolVector));
        }
        if let Some(kind) = self.missing(motion) {
            return Err(kind);
        }
        let pose = self.points.pose(motion, index, &end);
        let mut real = self.points.real_pose(motion, index, &end);
        if motion.tool_axis.is_some() {
            real.axis = pose.axis;
        }
        let touched = match self.contact {
            ContactSource::Surface if !rests(motion) => self.on_surface(&pose),
            _ => None,
        };
        let stated = match (&self.worn, self.contact, &touched) {
            (None, ..) | (_, ContactSource::Surface, None) => None,
            (Some(worn), ContactSource::Surface, Some(touched)) => {
                Some(by_normal(worn, &pose, touched.normal)?)
            }
            (Some(worn), ..) => self.stated(worn, motion, &end, &pose)?,
        };
        if stated.is_none() && rests(motion) {
            return Ok(EndChoice::Move { goal: Goal::Words(axes.standing(motion, &end)), point: None });
        }
        let near = self.near(motion, &pose, &end, axes)?;
        if motion.kind == MotionKind::Arc {
            return self.arc(motion, &end, [pose, real], near, stated, axes, resolutions);
        }
        let is_assumed = self.contact == ContactSource::FeedPlane && self.worn.is_some();
        let contact = if is_assumed { self.feed_plane(motions, index, following, &pose)? } else { stated };
        if contact.is_none() && motion.kind == MotionKind::Linear && self.worn.is_some() && !is_assumed {
            self.warnings.add(WarningKind::NoContactAtEnd, Some(motion.line));
        }
        if contact.is_some() {
            self.note_curvature(motion, &pose, touched);
        }
        let mut point = self.point(motion, [pose, real], near, contact);
        point.is_assumed = is_assumed && point.has_contact;
        Ok(EndChoice::Move { goal: Goal::Point { rotary_deg: near.words_deg }, point: Some(point) })
    }

    /// Switches to the cutter of the current section.
    pub(super) fn take_tool(&mut self) {
        self.worn = self.moves.worn_tool(self.written.now.tool);
    }

    /// The tool in the spindle is not one for which the wear is compensated.
    pub(super) fn is_other_tool(&self) -> bool {
        self.moves.has_wear && self.worn.is_none()
    }

    /// The missing value that is needed to know where this motion must end, if any.
    fn missing(&self, motion: &Motion) -> Option<LineFaultKind> {
        let mode = self.points.mode(motion);
        let set_up = &self.points.source.now;
        if mode == Interpolation::Machine && (self.moves.recalibrates || self.looks_at_part()) {
            return set_up.missing_for_place();
        }
        if self.contact == ContactSource::FeedPlane && self.worn.is_some() {
            return set_up.missing_for_turning(mode, motion);
        }
        None
    }

    /// Whether contacts are looked for on the part.
    fn looks_at_part(&self) -> bool {
        self.contact == ContactSource::Surface && self.worn.is_some()
    }

    /// Whether linear words depend on the length of the tool.
    pub(super) fn needs_length(&self, motion: &Motion) -> bool {
        self.points.mode(motion) == Interpolation::Machine
            && self.machine.rotary_axes().iter().any(|axis| axis.side == Side::Head)
    }

    /// The rotary words that point the tool as meant, on the machine that runs the program.
    fn near(
        &mut self,
        motion: &Motion,
        pose: &ToolPose,
        end: &AxisWords,
        axes: &Axes,
    ) -> Result<NearWords, LineFaultKind> {
        // In a tilted plane the rotary axes have no words, and stand where the control has turned them.
        let standing = motion.frame.map(|_| axes.rotary.standing(&end.rotary_deg));
        let words_deg = standing.unwrap_or(end.rotary_deg);
        let as_they_are = NearWords { words_deg, axis_residual_rad: 0.0, held: false };
        // A vector states the axis direction in W, on any machine.
        if !self.moves.recalibrates || motion.tool_axis.is_some() || standing.is_some() {
            return Ok(as_they_are);
        }
        let near = self.written.now.kinematics.words_near(pose.axis, end.rotary_deg, self.held_deg).map_err(
            |fault| match fault {
                InverseError::OutOfReach { tilt_deg, min_deg, max_deg, .. } => {
                    LineFaultKind::OutOfReach { tilt_deg, min_deg, max_deg }
                }
                _ => LineFaultKind::PositionUnknown,
            },
        )?;
        if !near.held {
            let kinematics = &self.written.now.kinematics;
            self.held_deg = kinematics.turn_next_to_workpiece(end.rotary_deg, near.words_deg);
        }
        Ok(near)
    }

    fn point(
        &mut self,
        motion: &Motion,
        [pose, real]: [ToolPose; 2],
        near: NearWords,
        contact: Option<WornContact>,
    ) -> MovedPoint {
        let behind_mm = self.worn.as_ref().map_or(0.0, |worn| worn.unknown_to_control.mm());
        if let Some(found) = &contact {
            self.note(motion.line, found);
            self.carried_mm = found.shift_mm + pose.axis * behind_mm;
        }
        let has_contact = contact.is_some();
        // A larger cutter that returned to the nominal tip would cut into the surface that it has just left.
        let contact = contact.unwrap_or_else(|| match &self.worn {
            None => TIP,
            Some(worn) if worn.is_larger() => carried(worn, &pose, self.carried_mm),
            Some(worn) => flat(worn, &pose, 0.0),
        });
        MovedPoint { pose, real, contact, has_contact, is_assumed: false, behind_mm, held: near.held }
    }

    /// The linear words that put the written program's tip at the place that a point needs, with rotary words as
    /// written.
    pub(in crate::process) fn linear_mm(
        &self,
        motion: &Motion,
        rotary_deg: [f64; 2],
        point: &MovedPoint,
    ) -> [f64; 3] {
        let rotary_rad = rotary_rad(self.machine, rotary_deg);
        let MovedPoint { pose, contact, behind_mm, .. } = point;
        let mut tip_mm = pose.tip_mm + contact.shift_mm;
        if self.moves.recalibrates {
            let by_vector = motion.tool_axis.is_some();
            let axis = if by_vector { pose.axis } else { self.written.now.kinematics.axis(rotary_rad) };
            tip_mm += (pose.axis - axis) * *behind_mm;
            if let Some(worn) = &self.worn {
                tip_mm += contact.hold.turn_mm([&worn.nominal, &worn.actual()], pose.axis, axis);
            }
        }
        match self.points.mode(motion) {
            Interpolation::Tcp => tip_mm.into(),
            Interpolation::Machine => self.written.now.kinematics.linear_mm(tip_mm, rotary_rad).into(),
        }
    }

    /// Decides about an arc. It remains an arc if both ends move by the same vector.
    #[expect(clippy::too_many_arguments, reason = "the findings for one motion, used here only")]
    fn arc(
        &mut self,
        motion: &Motion,
        end: &AxisWords,
        poses: [ToolPose; 2],
        near: NearWords,
        stated: Option<WornContact>,
        axes: &Axes,
        [linear, rotary]: [Resolution; 2],
    ) -> Result<EndChoice, LineFaultKind> {
        // An arc does not turn the tool, so no contact is assumed for it.
        let point = self.point(motion, poses, near, stated);
        let together = axes.standing(motion, end);
        let far = |wanted: &[f64], kept: &[f64], half: f64| {
            wanted.iter().zip(kept).any(|(wanted, kept)| (wanted - kept).abs() > half)
        };
        if far(&near.words_deg, &together.rotary_deg, rotary.half()) {
            return Err(LineFaultKind::ArcShift { why: "the rotary axes have to turn along it" });
        }
        let linear_mm = self.linear_mm(motion, together.rotary_deg, &point);
        let [target, kept] =
            [AxisWords { linear_mm, ..together }, together].map(|words| motion.stated(words));
        if far(&target.linear_mm, &kept.linear_mm, linear.half()) {
            return Err(LineFaultKind::ArcShift { why: "its ends move by different vectors" });
        }
        if axes.is_off() {
            let why = match motion.start {
                None => Some("its start is not known"),
                Some(start) if turn_between(&start, end) => Some("rotary axes turn along it"),
                Some(_) if self.absolute_centres && axes.linear.is_off() => {
                    Some("its centre is an absolute point (G90.1)")
                }
                Some(_) if motion.arc == ArcCourse::Neighbour => {
                    Some("it continues in the direction in which the motion before it ends")
                }
                Some(_) if motion.arc == ArcCourse::Centre && moves_across(motion, end, &together) => {
                    Some("its centre is a separate point that does not move")
                }
                Some(_) => None,
            };
            if let Some(why) = why {
                return Err(LineFaultKind::ArcShift { why });
            }
        }
        Ok(EndChoice::Move { goal: Goal::Words(together), point: Some(point) })
    }

    /// Decides about a motion that cannot be followed. It is left unchanged only if it would not have to move.
    fn unfollowed(
        &mut self,
        motion: &Motion,
        reason: Unfollowable,
        axes: &Axes,
    ) -> Result<EndChoice, LineFaultKind> {
        let has_to_move = match reason {
            // These motions go to places of the machine, or nowhere.
            // In a tilted plane X Y Z begin anew.
            Unfollowable::Reference
            | Unfollowable::MachineCoordinates
            | Unfollowable::Return
            | Unfollowable::TurnToPlane => return Ok(EndChoice::Leave),
            // The called program moves by its own words and expects to start at the source's position.
            Unfollowable::Call | Unfollowable::UnknownCode => axes.is_off(),
            _ => self.would_move(motion, axes),
        };
        if has_to_move {
            return Err(LineFaultKind::NotMovable(reason));
        }
        self.warnings.add(WarningKind::NotFollowed, Some(motion.line)).reason.get_or_insert(reason);
        Ok(EndChoice::Leave)
    }

    /// Whether this motion would have to move if it could be followed.
    fn would_move(&self, motion: &Motion, axes: &Axes) -> bool {
        let touches = match (self.contact, motion.contact) {
            (ContactSource::Program, ContactWords::Point(_))
            | (ContactSource::Normals, ContactWords::Normal(_)) => true,
            (ContactSource::FeedPlane | ContactSource::Surface, _) => {
                matches!(motion.kind, MotionKind::Linear | MotionKind::Arc)
            }
            _ => false,
        };
        let touches = touches && self.worn.as_ref().is_some_and(|worn| !worn.has_nominal_shape());
        axes.is_off() || self.moves_everything || touches
    }
}

/// The decision about a motion of another tool: the place that the source states, so that axes with an offset come
/// back.
fn as_in_the_source(motion: &Motion, axes: &Axes) -> Result<EndChoice, LineFaultKind> {
    let goes_to_the_machine = matches!(
        motion.unfollowable,
        Some(
            Unfollowable::Reference
                | Unfollowable::MachineCoordinates
                | Unfollowable::Return
                | Unfollowable::TurnToPlane
        )
    );
    if !axes.is_off() || goes_to_the_machine {
        return Ok(EndChoice::Leave);
    }
    match (motion.unfollowable, motion.end) {
        (Some(reason), _) => Err(LineFaultKind::NotMovable(reason)),
        (None, _) if motion.offset_changed => Err(LineFaultKind::OtherWorkOffset),
        (None, _) if motion.kind == MotionKind::Arc => {
            Err(LineFaultKind::ArcShift { why: "it starts at a place to which another tool was moved" })
        }
        (None, None) if motion.kind == MotionKind::Rapid => Ok(EndChoice::Leave),
        (None, None) => Err(LineFaultKind::PositionUnknown),
        // A cut would start at a place to which another tool was moved.
        (None, Some(_)) if motion.start.is_none() && motion.kind != MotionKind::Rapid => {
            Err(LineFaultKind::PositionUnknown)
        }
        (None, Some(end)) => Ok(EndChoice::Move { goal: Goal::Words(end), point: None }),
    }
}

/// Whether these ends of an arc differ by more than rounding in a direction other than the axis normal to its plane.
/// Cutter location data has planes of any direction.
fn moves_across(motion: &Motion, end: &AxisWords, moved: &AxisWords) -> bool {
    let plane = motion.plane.filter(|_| motion.tool_axis.is_none()).map(usize::from);
    let [end, moved] = [end, moved].map(|words| motion.stated(*words));
    (0..3).any(|k| Some(k) != plane && (moved.linear_mm[k] - end.linear_mm[k]).abs() > RESTING_MM)
}
