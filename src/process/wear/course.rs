//! Where a motion of the source has to end for the worn cutter, or why it cannot be moved there.

use super::super::fault::LineFaultKind;
use super::super::warnings::Warnings;
use super::super::{ContactSource, WarningKind};
use super::contact::{WornContact, by_normal, by_point, carried, flat};
use super::parameters::WearParameters;
use super::points::{Points, rests};
use super::report::CurvatureAcross;
use super::written::Written;
use crate::contact::{SurfaceContact, Touch, contact_on_surface, feed_plane_normal, rotary_rad};
use crate::geometry::Vec3;
use crate::kinematics::{Kinematics, ToolPose};
use crate::machine::Machine;
use crate::motion::{AxisWords, ContactWords, Interpolation, Motion, MotionKind, Unfollowable};
use crate::wear::{FlatContact, ShiftFault};

/// A chord shorter than this has no direction but that of rounding \[mm\].
const RESTING_MM: f64 = 1e-6;
/// An arc's plane is across the tool axis when its directions are to this (cosine, mm).
const ACROSS: f64 = 1e-6;

/// What becomes of a motion.
#[derive(Debug, Clone, Copy)]
pub(super) enum Course {
    /// It is copied.
    Leave,
    /// Its linear axes end here.
    Move {
        target_mm: [f64; 3],
        /// The source's pose, and the contact kept; none where the point was looked at before.
        point: Option<Point>,
    },
}

/// A point looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) pose: ToolPose,
    /// The contact, or the tip itself where none is known.
    pub(super) contact: WornContact,
    pub(super) has_contact: bool,
}

/// Finds the course of motion after motion, in the order of the program.
pub(super) struct Pilot<'a> {
    pub(super) machine: &'a Machine,
    pub(super) parameters: &'a WearParameters,
    /// The machine under which the written program runs.
    pub(super) written: &'a Kinematics,
    pub(super) source: &'a Kinematics,
    pub(super) contact: ContactSource,
    pub(super) points: Points<'a>,
    /// G90.1 is active: centres of arcs are points.
    pub(super) absolute_centres: bool,
    /// The cutter that is compensated for is in the spindle.
    pub(super) is_its_tool: bool,
    /// The shift of the last contact, ΔL apart \[mm\].
    pub(super) carried_mm: Vec3,
    /// Whether the length alone moves every point.
    pub(super) moves_everything: bool,
    pub(super) warnings: Warnings,
    /// Of the part across the feed, at the contacts.
    pub(super) curvature: CurvatureAcross,
}

impl Pilot<'_> {
    /// The course of the motion of this index; `following` is the first motion behind the batch, `axes` say where the
    /// written program stands, `half_mm` is half a unit of the last decimal.
    pub(super) fn course(
        &mut self,
        motions: &[Motion],
        index: usize,
        following: Option<&Motion>,
        axes: &Written,
        half_mm: f64,
    ) -> Result<Course, LineFaultKind> {
        let motion = &motions[index];
        if !self.is_its_tool {
            self.carried_mm = Vec3::zeros();
            return as_in_the_source(motion, axes);
        }
        if let Some(reason) = motion.unfollowable {
            self.carried_mm = Vec3::zeros();
            return self.unfollowed(motion, reason, axes);
        }
        if motion.offset_changed {
            if self.would_move(motion, axes) {
                return Err(LineFaultKind::OtherWorkOffset);
            }
            self.warnings.add(WarningKind::WorkOffsetChanged, Some(motion.line));
            return Ok(Course::Leave);
        }
        let Some(end) = motion.end else {
            if motion.kind != MotionKind::Rapid && self.would_move(motion, axes) {
                return Err(LineFaultKind::PositionUnknown);
            }
            if self.moves_everything || axes.is_off() {
                self.warnings.add(WarningKind::PositionUnknown, Some(motion.line));
            }
            return Ok(Course::Leave);
        };
        let pose = self.points.pose(motion, index, &end);
        let touched = match self.contact {
            ContactSource::Surface if !rests(motion) => self.on_surface(&pose),
            _ => None,
        };
        let stated = match (self.contact, &touched) {
            (ContactSource::Surface, None) => None,
            (ContactSource::Surface, Some(touched)) => {
                Some(by_normal(self.parameters, &pose, touched.normal)?)
            }
            _ => self.stated(motion, &end, &pose)?,
        };
        if stated.is_none() && rests(motion) {
            return Ok(Course::Move { target_mm: axes.standing_mm(&end.linear_mm), point: None });
        }
        if motion.kind == MotionKind::Arc {
            return self.arc(motion, &end, &pose, stated, axes, half_mm);
        }
        let contact = match stated {
            Some(contact) => Some(contact),
            None => self.feed_plane(motions, index, following, &pose)?,
        };
        if contact.is_none() && motion.kind == MotionKind::Linear {
            self.warnings.add(WarningKind::NoContactAtEnd, Some(motion.line));
        }
        if contact.is_some() {
            self.note_curvature(motion, &pose, touched);
        }
        Ok(self.moved(motion, &end, pose, contact))
    }

    fn moved(
        &mut self,
        motion: &Motion,
        end: &AxisWords,
        pose: ToolPose,
        contact: Option<WornContact>,
    ) -> Course {
        if let Some(found) = &contact {
            self.note(motion.line, found);
            self.carried_mm = found.shift_mm + pose.axis * self.parameters.unknown_to_control().mm();
        }
        let has_contact = contact.is_some();
        // A larger cutter that went back to the nominal tip would cut into what it has just left.
        let contact = contact.unwrap_or_else(|| {
            if self.parameters.is_larger() {
                carried(self.parameters, &pose, self.carried_mm)
            } else {
                flat(self.parameters, &pose, 0.0)
            }
        });
        let target_mm = self.target_mm(motion, end, &pose, contact.shift_mm);
        Course::Move { target_mm, point: Some(Point { pose, contact, has_contact }) }
    }

    /// The linear words that put the written program's tip at the shifted place.
    fn target_mm(&self, motion: &Motion, end: &AxisWords, pose: &ToolPose, shift_mm: Vec3) -> [f64; 3] {
        let tip_mm = pose.tip_mm + shift_mm;
        match self.points.mode(motion) {
            Interpolation::Tcp => tip_mm.into(),
            Interpolation::Machine => {
                self.written.linear_mm(tip_mm, rotary_rad(self.machine, end.rotary_deg)).into()
            }
        }
    }

    /// The contact that the block states in the words asked for.
    fn stated(
        &self,
        motion: &Motion,
        end: &AxisWords,
        pose: &ToolPose,
    ) -> Result<Option<WornContact>, ShiftFault> {
        match (self.contact, motion.contact) {
            (ContactSource::Program, ContactWords::Point(words)) => {
                let contact_mm = match self.points.mode(motion) {
                    Interpolation::Tcp => Vec3::from(words),
                    Interpolation::Machine => {
                        self.source.tip_mm(Vec3::from(words), rotary_rad(self.machine, end.rotary_deg))
                    }
                };
                by_point(self.parameters, pose, contact_mm).map(Some)
            }
            (ContactSource::Normals, ContactWords::Normal(normal)) => {
                by_normal(self.parameters, pose, Vec3::from(normal)).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Where the nominal cutter touches the part.
    fn on_surface(&self, pose: &ToolPose) -> Option<SurfaceContact> {
        contact_on_surface(self.parameters.part.as_ref()?, &self.parameters.nominal, pose)
    }

    /// The contact by the feed-plane rule: at the ends of motions at feed, and where a rapid hands over to one. A tip
    /// that rests or plunges along its axis touches with its lowest point.
    fn feed_plane(
        &self,
        motions: &[Motion],
        index: usize,
        following: Option<&Motion>,
        pose: &ToolPose,
    ) -> Result<Option<WornContact>, ShiftFault> {
        if self.contact != ContactSource::FeedPlane {
            return Ok(None);
        }
        let motion = &motions[index];
        let beyond_mm = self.points.beyond_mm(motions, index, following);
        let from_mm = match (motion.kind, motion.start, beyond_mm) {
            (MotionKind::Linear, Some(start), _) => self.points.tip_mm(self.points.mode(motion), start),
            (MotionKind::Linear, None, _) | (_, _, Some(_)) => pose.tip_mm,
            _ => return Ok(None),
        };
        let chord_mm = beyond_mm.unwrap_or(pose.tip_mm) - from_mm;
        let normal = chord_mm.try_normalize(RESTING_MM).and_then(|feed| feed_plane_normal(pose.axis, feed));
        by_normal(self.parameters, pose, normal.unwrap_or(pose.axis)).map(Some)
    }

    /// An arc stays one where both ends move alike.
    fn arc(
        &mut self,
        motion: &Motion,
        end: &AxisWords,
        pose: &ToolPose,
        stated: Option<WornContact>,
        axes: &Written,
        half_mm: f64,
    ) -> Result<Course, LineFaultKind> {
        let contact = match stated {
            None if self.contact == ContactSource::FeedPlane && !self.parameters.has_nominal_shape() => {
                if !self.runs_across_the_axis(motion, end, pose) {
                    let why = "it does not run across the tool axis, and where it touches between its ends is not known";
                    return Err(LineFaultKind::ArcShift { why });
                }
                Some(by_normal(self.parameters, pose, pose.axis)?)
            }
            stated => stated,
        };
        let course = self.moved(motion, end, *pose, contact);
        let Course::Move { target_mm, point } = course else { return Ok(course) };
        let together_mm = axes.standing_mm(&end.linear_mm);
        if target_mm.iter().zip(&together_mm).any(|(wanted, kept)| (wanted - kept).abs() > half_mm) {
            return Err(LineFaultKind::ArcShift { why: "its ends move by different vectors" });
        }
        if axes.is_off() {
            let why = match motion.start {
                None => Some("where it starts is not known"),
                Some(start) if turns(&start, end) => Some("rotary axes turn along it"),
                Some(_) if self.absolute_centres => Some("its centre is an absolute point (G90.1)"),
                Some(_) => None,
            };
            if let Some(why) = why {
                return Err(LineFaultKind::ArcShift { why });
            }
        }
        Ok(Course::Move { target_mm: together_mm, point })
    }

    fn runs_across_the_axis(&self, motion: &Motion, end: &AxisWords, pose: &ToolPose) -> bool {
        let (Some(start), Some(plane)) = (motion.start, motion.plane) else { return false };
        let mode = self.points.mode(motion);
        let is_across = |to_mm: Vec3| (to_mm - pose.tip_mm).dot(&pose.axis).abs() <= ACROSS;
        let beside = |k: usize| {
            let mut words = *end;
            words.linear_mm[k] += 1.0;
            self.points.tip_mm(mode, words)
        };
        !turns(&start, end)
            && is_across(self.points.tip_mm(mode, start))
            && (0..3).filter(|k| *k != usize::from(plane)).all(|k| is_across(beside(k)))
    }

    /// A motion that cannot be followed is left alone only where it would not have to move.
    fn unfollowed(
        &mut self,
        motion: &Motion,
        reason: Unfollowable,
        axes: &Written,
    ) -> Result<Course, LineFaultKind> {
        let has_to_move = match reason {
            // These go to places of the machine, or nowhere.
            Unfollowable::Reference | Unfollowable::MachineCoordinates | Unfollowable::Return => {
                return Ok(Course::Leave);
            }
            // What is called moves by its own words, from where the source would stand.
            Unfollowable::Call | Unfollowable::UnknownCode => axes.is_off(),
            _ => self.would_move(motion, axes),
        };
        if has_to_move {
            return Err(LineFaultKind::NotMovable(reason));
        }
        self.warnings.add(WarningKind::NotFollowed, Some(motion.line)).reason.get_or_insert(reason);
        Ok(Course::Leave)
    }

    /// Whether this motion could not stay as it is, were it to be followed.
    fn would_move(&self, motion: &Motion, axes: &Written) -> bool {
        let touches = match (self.contact, motion.contact) {
            (ContactSource::Program, ContactWords::Point(_))
            | (ContactSource::Normals, ContactWords::Normal(_)) => true,
            (ContactSource::FeedPlane | ContactSource::Surface, _) => {
                matches!(motion.kind, MotionKind::Linear | MotionKind::Arc)
            }
            _ => false,
        };
        axes.is_off() || self.moves_everything || (touches && !self.parameters.has_nominal_shape())
    }

    /// How the part is curved across the feed where the nominal cutter touches it, by the contact `touched` if that was
    /// looked for already.
    fn note_curvature(&mut self, motion: &Motion, pose: &ToolPose, touched: Option<SurfaceContact>) {
        let Some(part) = &self.parameters.part else { return };
        let (MotionKind::Linear, Some(start)) = (motion.kind, motion.start) else { return };
        let feed_mm = pose.tip_mm - self.points.tip_mm(self.points.mode(motion), start);
        if feed_mm.norm() <= RESTING_MM {
            return;
        }
        let across = touched
            .or_else(|| self.on_surface(pose))
            .and_then(|touched| touched.curvature_across_per_mm(&part.mesh, feed_mm));
        if let Some(curvature_per_mm) = across {
            self.curvature.note(curvature_per_mm, motion.line);
        }
    }

    fn note(&mut self, line: u64, contact: &WornContact) {
        if contact.off_tool_mm > Touch::ON_TOOL_MM {
            self.warnings.add_distance(WarningKind::NearestContact, line, contact.off_tool_mm);
        }
        match contact.note {
            Some(FlatContact::Whole) => {
                self.warnings.add(WarningKind::FlatContact, Some(line));
            }
            Some(FlatContact::Nearly { .. }) => {
                self.warnings.add(WarningKind::NearlyFlatContact, Some(line));
            }
            None => {}
        }
    }
}

/// The course of a motion of another tool: where the source leads, so that what stands elsewhere comes back.
fn as_in_the_source(motion: &Motion, axes: &Written) -> Result<Course, LineFaultKind> {
    let goes_to_the_machine = matches!(
        motion.unfollowable,
        Some(Unfollowable::Reference | Unfollowable::MachineCoordinates | Unfollowable::Return)
    );
    if !axes.is_off() || goes_to_the_machine {
        return Ok(Course::Leave);
    }
    match (motion.unfollowable, motion.end) {
        (Some(reason), _) => Err(LineFaultKind::NotMovable(reason)),
        (None, _) if motion.offset_changed => Err(LineFaultKind::OtherWorkOffset),
        (None, _) if motion.kind == MotionKind::Arc => {
            Err(LineFaultKind::ArcShift { why: "it begins where another tool was moved to" })
        }
        (None, None) if motion.kind == MotionKind::Rapid => Ok(Course::Leave),
        (None, None) => Err(LineFaultKind::PositionUnknown),
        // A cut would begin where another tool was moved to.
        (None, Some(_)) if motion.start.is_none() && motion.kind != MotionKind::Rapid => {
            Err(LineFaultKind::PositionUnknown)
        }
        (None, Some(end)) => Ok(Course::Move { target_mm: end.linear_mm, point: None }),
    }
}

/// Whether rotary axes move between these words.
fn turns(start: &AxisWords, end: &AxisWords) -> bool {
    start.rotary_deg.iter().zip(&end.rotary_deg).any(|(from, to)| (to - from).abs() > 0.0)
}
