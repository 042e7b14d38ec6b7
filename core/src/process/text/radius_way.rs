//! A path under compensation of the cutter's radius while it is under way: its pieces in the plane, and what all controls
//! do alike at their ends.

use crate::geometry::{PlaneCircle, PlanePiece, trig};
use crate::motion::{AxisWords, FeedMode, Interpolation, Motion, MotionKind, RadiusCompensation, RadiusRule};
use crate::process::arc_path::{ArcModes, ArcPath};
use crate::program::{Address, Batch, Code};

/// X Y Z.
pub(super) const LINEAR: [Address; 3] = [Address::X, Address::Y, Address::Z];

/// A compensated path.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnderWay {
    pub(super) number: u32,
    pub(super) beside_mm: f64,
    pub(super) rule: RadiusRule,
    pub(super) plane: u8,
    /// It is not followed any more.
    pub(super) is_lost: bool,
    /// The last piece in the plane, as programmed, and where the tool begins it \[mm\].
    pub(super) last: Option<(PlanePiece, [f64; 2])>,
    /// The programmed end of it \[mm\].
    pub(super) programmed_mm: [f64; 2],
    /// It is the way in.
    pub(super) enters: bool,
    /// Where it is in the text: its file and its line.
    pub(super) place: Place,
}

/// A file, 0 for the program itself, and a line of it.
pub(super) type Place = (u16, u64);

/// A tool of a smaller radius is not followed \[mm\].
const MIN_RADIUS_MM: f64 = 1e-3;
/// The circle of a programmed arc misses its end by no more than words of three decimals explain. Controls differ in
/// which of its two radii they cut with at a corner \[mm\].
const MOST_MISSED_MM: f64 = 0.003;
/// Controls differ in where they join pieces of a path that go on in nearly the same direction. The places are no more
/// than this apart \[mm\]: words of three decimals say no more of a direction.
const JOINED_MM: f64 = 0.005;
/// A path that turns by more than this goes back \[rad\].
const MOST_TURN_RAD: f64 = 3.0;
/// G40.
const OFF: [Code; 1] = [Code::G(400)];

impl UnderWay {
    pub(super) fn new(motion: &Motion, compensation: RadiusCompensation, beside_mm: f64) -> Self {
        let RadiusCompensation { number, rule, .. } = compensation;
        let plane = motion.plane.unwrap_or(2);
        // LinuxCNC compensates in XY and ZX alone.
        let is_lost = motion.plane.is_none() || plane == 0 || beside_mm.abs() < MIN_RADIUS_MM;
        let (programmed_mm, place) = ([0.0; 2], place_of(motion));
        Self { number, beside_mm, rule, plane, is_lost, last: None, programmed_mm, enters: false, place }
    }

    /// Whether at most one block is between the last piece and this motion, and none after the way in. Controls look a
    /// few blocks ahead, and differ in how many.
    pub(super) fn goes_on_to(&self, motion: &Motion) -> bool {
        let ((file, line), (next_file, next_line)) = (self.place, place_of(motion));
        let most = if self.enters { 1 } else { 2 };
        file == next_file && (1..=most).contains(&next_line.saturating_sub(line))
    }

    /// Whether the next piece goes on in nearly the same direction; `None` unless it does, or turns towards the tool.
    pub(super) fn turns_inwards(&self, last: &PlanePiece, next: &PlanePiece) -> Option<bool> {
        let turn_rad = last.inward_turn_rad(next, self.beside_mm)?;
        let (sin, cos) = trig::sin_cos(0.5 * turn_rad);
        let is_straight_on = sin.abs() * self.beside_mm.abs() <= JOINED_MM * cos;
        (is_straight_on || (0.0..MOST_TURN_RAD).contains(&turn_rad)).then_some(is_straight_on)
    }

    /// Whether all controls leave the path alike: straight from beside the end of the last piece, with G40 in the block.
    pub(super) fn is_left_alike(&self, batch: &Batch, motion: &Motion, last: &PlanePiece) -> bool {
        let is_straight = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear);
        let ends_mm = motion
            .start
            .zip(motion.end)
            .map(|ends| [ends.0, ends.1].map(|words| of_plane(words, self.plane)));
        let next = ends_mm
            .filter(|ends_mm| is_same(ends_mm[0], self.programmed_mm))
            .and_then(|[from_mm, to_mm]| PlanePiece::line(from_mm, to_mm));
        is_straight
            && self.goes_on_to(motion)
            && names(batch, motion, &OFF)
            && next.is_some_and(|next| self.turns_inwards(last, &next).is_some())
    }

    /// Whether a motion that does not move in the plane lies between two pieces as if it were not there. A motion over no
    /// distance does not: there, some controls end the piece before it beside its end.
    pub(super) fn passes(&self, batch: &Batch, motion: &Motion) -> bool {
        let block = batch.blocks().get(motion.block as usize);
        let mut words = block.map(|block| batch.words(block)).unwrap_or_default().iter();
        let named = plane_axes(self.plane).map(|axis| LINEAR[axis]);
        self.rule == RadiusRule::Rs274
            || (motion.start != motion.end && !words.any(|word| named.contains(&word.address)))
    }

    /// Whether a motion is one of this path: apart from the compensation it is followed, and it turns no rotary axis.
    pub(super) fn takes(&self, motion: &Motion) -> bool {
        let at_rest = motion.start.zip(motion.end).is_some_and(|(start, end)| {
            (0..2).all(|k| start.rotary_deg[k].to_bits() == end.rotary_deg[k].to_bits())
        });
        motion.unfollowable.is_none()
            && motion.kind != MotionKind::Opaque
            && motion.plane == Some(self.plane)
            && motion.interpolation == Interpolation::Machine
            && motion.feed.mode != Some(FeedMode::InverseTime)
            && at_rest
    }

    pub(super) fn piece(
        &self,
        batch: &Batch,
        motion: &Motion,
        compensation: RadiusCompensation,
    ) -> Option<PlanePiece> {
        let [start, end] = [motion.start?, motion.end?];
        let [from_mm, to_mm] = [start, end].map(|words| of_plane(words, self.plane));
        if motion.kind != MotionKind::Arc {
            return PlanePiece::line(from_mm, to_mm);
        }
        let modes = ArcModes::new(compensation.is_clockwise?, compensation.absolute_centres?);
        let arc = ArcPath::of(modes, batch, motion, [start, end]).ok()?;
        let centre_mm = of_plane(arc.centre()[0], self.plane);
        if missed_mm(centre_mm, from_mm, to_mm) > MOST_MISSED_MM {
            return None;
        }
        PlanePiece::arc(from_mm, to_mm, PlaneCircle { centre_mm, is_clockwise: arc.sweep_rad() < 0.0 })
    }
}

/// Whether the block of a motion has one of these codes.
pub(super) fn names(batch: &Batch, motion: &Motion, codes: &[Code]) -> bool {
    let words = batch.blocks().get(motion.block as usize).map(|block| batch.words(block));
    words.unwrap_or_default().iter().any(|word| word.code().is_some_and(|code| codes.contains(&code)))
}

pub(super) fn place_of(motion: &Motion) -> Place {
    motion.called.map_or((0, motion.line), |called| (called.file.get(), u64::from(called.line)))
}

/// By how much a circle about this centre through one place misses another \[mm\].
pub(super) fn missed_mm(centre_mm: [f64; 2], from_mm: [f64; 2], to_mm: [f64; 2]) -> f64 {
    let radius_mm = |at_mm: [f64; 2]| (0..2).map(|k| (at_mm[k] - centre_mm[k]).powi(2)).sum::<f64>().sqrt();
    (radius_mm(from_mm) - radius_mm(to_mm)).abs()
}

/// The axes of a plane among X Y Z, in its right-handed order.
pub(super) fn plane_axes(plane: u8) -> [usize; 2] {
    let across = usize::from(plane);
    [(across + 1) % 3, (across + 2) % 3]
}

/// Which of X Y Z are axes of the plane; all if it is not known.
pub(super) fn axes_of(plane: Option<u8>) -> [bool; 3] {
    std::array::from_fn(|axis| plane.is_none_or(|plane| plane_axes(plane).contains(&axis)))
}

pub(super) fn is_same(a_mm: [f64; 2], b_mm: [f64; 2]) -> bool {
    a_mm.iter().zip(b_mm).all(|(a, b)| (a - b).abs() <= 0.0)
}

pub(super) fn of_plane(words: AxisWords, plane: u8) -> [f64; 2] {
    plane_axes(plane).map(|axis| words.linear_mm[axis])
}
