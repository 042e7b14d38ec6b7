//! Reads the written program back as a control would. It checks every motion against the plan, and the worn cutter's
//! contact against the nominal one's, from the words that were read.

use super::moves::Moves;
use super::parameters::WearParameters;
use super::pilot::MovedPoint;
use super::recalibration::Largest;
use super::worn_tool::WornTool;
use super::written::Resolution;
use crate::contact::{Sampled, Station};
use crate::geometry::{Vec3, angle_between};
use crate::machine::Machine;
use crate::motion::{AxisWords, Motion, MotionKind, Unfollowable};

use crate::process::fault::{Fault, LineFaultKind, LineFaults};
use crate::process::pipeline::{
    ARITHMETIC_MM, BeforeAfter, DeviationTotals, ErrorShares, Expected, KeptMotion, LINEAR_ROUNDING,
    MotionChange, MotionError, ReadBack, SAME_READ_BACK, StepCheck, failed,
};
use crate::process::set_up::{SetUps, Stop};
use crate::process::text::Stretch;
use crate::program::Dialect;
use crate::units::Angle;

/// The caller is asked once in this many motions whether to continue, because each may search for a contact on a
/// surface.
pub(super) const ASK_EVERY: usize = 32;
/// Half a unit of the last decimal on two rotary axes.
const TURNED: f64 = std::f64::consts::SQRT_2 * 1.1;

/// The expected next motion of the written program.
#[derive(Debug)]
pub(super) struct ExpectedEnd {
    /// The source's motion with the planned ends, contact words and F.
    pub(super) motion: Motion,
    /// The point that was looked at. Its rotary words equal the source's to the bit, unless it was computed anew.
    pub(super) point: Option<MovedPoint>,
    /// How linear and rotary words were written.
    pub(super) resolutions: [Resolution; 2],
}

impl Expected for ExpectedEnd {
    fn line(&self) -> u64 {
        self.motion.line
    }

    fn missing(&self) -> &'static str {
        "a motion is missing"
    }
}

/// Reads the output back and sums up what it leaves.
pub(super) struct EndsCheck<'a> {
    read_back: ReadBack<ExpectedEnd>,
    pub(super) ends: ComparedEnds<'a>,
    stop: &'a Stop<'a>,
}

/// The comparison of the motions read with those planned, one after the other.
pub(super) struct ComparedEnds<'a> {
    machine: &'a Machine,
    parameters: &'a WearParameters,
    moves: Moves<'a>,
    written: SetUps,
    recalibrates: bool,
    has_wear: bool,
    /// The worn cutter of the current section. `None` without wear, and for a tool of which nothing is known.
    worn: Option<WornTool>,
    /// The last contact of the source, if a motion at feed may continue from it.
    contact_mm: Option<Vec3>,
    pub(super) found: BeforeAfter,
    /// The remaining deviation at assumed contacts, if the assumptions are right.
    pub(super) if_assumed: DeviationTotals,
    /// Angle between the tool axis that was read and the one meant \[rad\].
    pub(super) axis_left: Largest<Angle>,
    /// The outcomes of the motions read back, for the caller to collect.
    changes: Vec<MotionChange>,
}

impl StepCheck for EndsCheck<'_> {
    type Expected = ExpectedEnd;
    type Outcome = MotionChange;

    fn read_back(&mut self) -> &mut ReadBack<ExpectedEnd> {
        &mut self.read_back
    }

    fn compare(&mut self, _of: &Stretch) -> Result<(), Fault> {
        self.read()
    }

    fn outcomes(&mut self) -> &mut Vec<MotionChange> {
        &mut self.ends.changes
    }
}

impl<'a> EndsCheck<'a> {
    pub(in crate::process) fn new(
        machine: &'a Machine,
        moves: &Moves<'a>,
        dialect: Dialect,
        stop: &'a Stop<'a>,
    ) -> Self {
        let parameters = moves.parameters;
        let [_, written] = moves.set_ups(machine);
        let ends = ComparedEnds {
            machine,
            parameters,
            worn: moves.worn_tool(written.now.tool),
            moves: moves.clone(),
            written,
            recalibrates: moves.recalibrates,
            has_wear: moves.has_wear,
            contact_mm: None,
            found: BeforeAfter::default(),
            if_assumed: DeviationTotals::default(),
            axis_left: Largest::default(),
            changes: Vec::new(),
        };
        Self { read_back: ReadBack::new(machine, dialect, &moves.source_program), ends, stop }
    }

    /// Blocks of the output.
    pub(super) fn blocks(&self) -> u64 {
        self.read_back.inventory.blocks
    }

    fn read(&mut self) -> Result<(), Fault> {
        // Motions are large: they are compared where they are.
        while self.read_back.advance()? {
            if self.ends.changes.len().is_multiple_of(ASK_EVERY) && (self.stop)().is_break() {
                return Err(Fault::Cancelled);
            }
            if let Some((read, next)) = self.read_back.pair() {
                self.ends.compare(read, next)?;
            }
            self.read_back.drop_pair();
        }
        Ok(())
    }
}

impl ComparedEnds<'_> {
    fn compare(&mut self, read: &Motion, next: &ExpectedEnd) -> Result<(), Fault> {
        let mut change = MotionChange::none(next.motion.line, next.motion.kind);
        self.check(read, next, &mut change)?;
        self.changes.push(change);
        Ok(())
    }

    fn check(&mut self, read: &Motion, next: &ExpectedEnd, change: &mut MotionChange) -> Result<(), Fault> {
        let line = next.motion.line;
        if self.recalibrates && turns_otherwise(read, &next.motion) {
            let mut faults = LineFaults::default();
            faults.add(line, &[], LineFaultKind::NotMovable(Unfollowable::PlaneSolution));
            return Err(Fault::Lines(faults));
        }
        KeptMotion::of(&next.motion).check(read)?;
        if read.tool_axis != next.motion.tool_axis {
            return Err(failed(line, "a stated tool axis changed"));
        }
        // The last bits of words that are solved from a stated axis depend on the neighbouring points, and those of a
        // position on a plane on the position before it.
        if !self.recalibrates && read.tool_axis.is_none() && !has_same_rotary_end(read, &next.motion) {
            return Err(failed(line, "a rotary word changed"));
        }
        let (Some(point), Some(words)) = (&next.point, read.end) else {
            self.contact_mm = self.contact_mm.filter(|_| read.end.is_some());
            return Ok(());
        };
        let mode = read.mode(self.parameters.program.interpolation);
        if self.written.enter(read) {
            self.worn = self.moves.worn_tool(self.written.now.tool);
        }
        let written = &self.written.now.kinematics;
        let mut pose = Station::new(self.machine, written, mode, words).pose;
        if read.tool_axis.is_some() {
            pose.axis = point.pose.axis;
        }
        // If the control uses the nominal length, the worn tip is ΔL further back along the tool axis.
        pose.tip_mm += pose.axis * point.behind_mm;
        let hold = &point.contact.hold;
        let off_mm = match &self.worn {
            Some(worn) => hold.residual_mm([&worn.nominal, &worn.actual()], &point.pose, &pose),
            None => pose.tip_mm - point.pose.tip_mm,
        };
        let [linear, turned] = next.resolutions;
        let limit_mm = LINEAR_ROUNDING * linear.half() + ARITHMETIC_MM;
        if off_mm.norm().is_nan() || off_mm.norm() > limit_mm {
            return Err(failed(line, "the worn cutter's contact is not where it was planned"));
        }
        let axis_rad = if self.recalibrates { angle_between(pose.axis, point.pose.axis) } else { 0.0 };
        // Near the pole the axis may be missed, by no more than the cone.
        let cone_rad = if point.held { written.pole_cone_rad() } else { written.tilt_rad() };
        if axis_rad > (TURNED * turned.half()).to_radians() + 2.0 * cone_rad {
            return Err(failed(line, "the tool axis differs from the planned one"));
        }
        self.axis_left.take(Angle::from_rad(axis_rad), line);
        self.tell(point, [axis_rad, off_mm.norm()], read.frame.is_none(), change);
        let Some(worn) = self.worn.as_ref().filter(|_| point.has_contact) else {
            self.contact_mm = None;
            return Ok(());
        };
        let contact_mm = point.pose.tip_mm + hold.offset_mm(&worn.nominal, point.pose.axis);
        let from_mm = self.contact_mm.filter(|_| read.kind != MotionKind::Rapid).unwrap_or(contact_mm);
        let normal = hold.normal(point.pose.axis);
        let left_mm = -point.contact.shift_mm.dot(&normal);
        let path_mm = (contact_mm - from_mm).norm();
        self.contact_mm = Some(contact_mm);
        let (before, after) = (sampled(left_mm.abs(), left_mm), sampled(off_mm.norm(), off_mm.dot(&normal)));
        if point.is_assumed {
            self.if_assumed.add(line, path_mm, &after);
        }
        self.found.record(line, path_mm, &before, if point.is_assumed { &before } else { &after });
        Ok(())
    }

    /// Records the effect of the move on a motion and on its errors. `turns`: its rotary words could be changed.
    fn tell(
        &self,
        point: &MovedPoint,
        [axis_left_rad, rounding_mm]: [f64; 2],
        turns: bool,
        change: &mut MotionChange,
    ) {
        let contact = &point.contact;
        let (mut before, mut after) = (ErrorShares::default(), ErrorShares::default());
        after.rounding_mm = rounding_mm;
        if self.has_wear {
            change.wear_mm = contact.shift_mm.norm();
            if point.has_contact {
                before.wear_mm = contact.shift_mm.dot(&contact.hold.normal(point.pose.axis)).abs();
                if point.is_assumed {
                    after.wear_mm = before.wear_mm;
                }
            }
        }
        let mut axis_before_rad = 0.0;
        if self.recalibrates {
            change.location_errors_mm = (point.real.tip_mm - point.pose.tip_mm).norm();
            axis_before_rad = angle_between(point.real.axis, point.pose.axis);
            change.axis_rad = if turns { axis_before_rad } else { 0.0 };
            let miss_mm = match &self.worn {
                Some(worn) => contact.hold.miss_mm(&worn.nominal, &point.pose, &point.real),
                None => point.real.tip_mm - point.pose.tip_mm,
            };
            before.location_errors_mm = miss_mm.norm();
        }
        change.error = MotionError { before, after, axis_before_rad, axis_after_rad: axis_left_rad };
    }
}

/// Whether the control does not turn the rotary axes to a plane as planned. From changed rotary words another of their
/// positions may be the nearer one.
fn turns_otherwise(read: &Motion, planned: &Motion) -> bool {
    let turns = planned.unfollowable == Some(Unfollowable::TurnToPlane);
    let same_end = read.end.is_none() || planned.end.is_none() || has_same_rotary_end(read, planned);
    (turns || planned.frame.is_some())
        && (read.unfollowable != planned.unfollowable || read.frame != planned.frame || !same_end)
}

/// Whether the rotary words at the end are known in both or in neither, and are the same but for rounding.
fn has_same_rotary_end(read: &Motion, planned: &Motion) -> bool {
    let near = |read: AxisWords, planned: AxisWords| {
        let mut pairs = read.rotary_deg.iter().zip(planned.rotary_deg);
        pairs.all(|(read, planned)| (read - planned).abs() <= SAME_READ_BACK)
    };
    match (read.end, planned.end) {
        (Some(read), Some(planned)) => near(read, planned),
        (read, planned) => read.is_none() && planned.is_none(),
    }
}

/// The distance at one place, and its component along the normal.
fn sampled(distance_mm: f64, along_mm: f64) -> Sampled {
    Sampled {
        max_mm: distance_mm,
        mean_square_mm2: distance_mm * distance_mm,
        max_excess_mm: along_mm.max(0.0),
        max_gouge_mm: (-along_mm).max(0.0),
        evaluations: 1,
    }
}
