//! The path of the tool under compensation of its radius: beside the programmed path, with arcs around outer corners
//! and cut off at inner ones, and the way into it and out of it.
//!
//! The end of a motion depends on the motion after it, so motions are held back until it is known. A path that a
//! control would refuse is left unchanged, and so is a path whose radius is not known. The tool is then somewhere
//! beside the programmed place until the program names the axes of the plane again.
//!
//! Controls other than `LinuxCNC` differ in the way in, in outer corners and in the way out. Of these, only what all do
//! alike is followed.

use super::radius_way::{
    LINEAR, UnderWay, axes_of, is_same, missed_mm, names, of_plane, place_of, plane_axes,
};
use crate::geometry::{Corner, PlaneCircle, PlanePiece};
use crate::motion::{
    ArcCourse, AxisWords, ContactWords, Motion, MotionKind, RadiusCompensation, RadiusRule, Unfollowable,
};
use crate::process::arc_path::RADIUS_SLACK_MM;
use crate::program::{Batch, Code};

/// Positions of X Y Z \[mm\] and of the rotary axes \[deg\], as far as known.
type Position = [Option<f64>; 5];

/// A motion, and the position after it.
type Placed = (Motion, Position);

/// Where the tool is when compensation ends.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Standing {
    /// Where the program says.
    AsProgrammed,
    /// In this place of this plane instead \[mm\].
    Beside([f64; 2], u8),
    /// Somewhere else in these of X Y Z.
    Unknown([bool; 3]),
}

impl Standing {
    /// The tool is also somewhere else in the axes of this plane.
    fn and_unknown(self, plane: u8) -> Self {
        let before = match self {
            Self::AsProgrammed => [false; 3],
            Self::Beside(_, plane) => axes_of(Some(plane)),
            Self::Unknown(elsewhere) => elsewhere,
        };
        let now = axes_of(Some(plane));
        Self::Unknown(std::array::from_fn(|axis| before[axis] || now[axis]))
    }
}

/// Gives motions under compensation the path of the tool.
#[derive(Debug)]
pub(super) struct RadiusPath {
    under_way: Option<UnderWay>,
    standing: Standing,
    /// The motion of the last piece, and the motions after it that do not move in the plane.
    held: Vec<Placed>,
    /// The motions of the piece before and of the corner after it: as programmed, if they are, and on the path of the tool.
    /// They are certain once the last piece is known to run forwards. Otherwise some controls stop before them, or end them
    /// elsewhere.
    settled: Vec<(Option<Placed>, Placed)>,
    done: Vec<Placed>,
}

/// A corner of the programmed path.
struct Turn<'a> {
    last: PlanePiece,
    /// The place from which the tool goes through the last piece \[mm\].
    last_from_mm: [f64; 2],
    next: PlanePiece,
    /// The motion of the next piece.
    motion: &'a Motion,
}

/// Most motions that are held back.
const MAX_HELD: usize = 256;
/// A piece may be cut off beyond its beginning by up to this, as rounding does \[mm\].
const BACKWARDS_MM: f64 = 1e-9;
/// An arc that is cut off, or that ends at an outer corner, may run through an angle that is larger than before by up
/// to this: the limit of `LinuxCNC` \[rad\].
const MORE_SWEEP_RAD: f64 = 1e-3;
/// The same of an arc that is not cut off, whose ends are smoothed corners \[rad\].
const MORE_SMOOTHED_RAD: f64 = 0.2;
/// Places this close are one \[mm\].
const SAME_MM: f64 = 2e-6;
/// G41 and G42.
const ON: [Code; 2] = [Code::G(410), Code::G(420)];

impl RadiusPath {
    pub(super) fn new() -> Self {
        Self {
            under_way: None,
            standing: Standing::AsProgrammed,
            held: Vec::new(),
            settled: Vec::new(),
            done: Vec::new(),
        }
    }

    /// Whether motions are held back.
    pub(super) fn holds_back(&self) -> bool {
        !self.held.is_empty() || !self.settled.is_empty()
    }

    /// Replaces the motions of a batch by those that the tool makes. `positions` has one for each motion, or is empty.
    pub(super) fn follow(&mut self, batch: &Batch, motions: &mut Vec<Motion>, positions: &mut Vec<Position>) {
        let is_idle = self.under_way.is_none() && self.standing == Standing::AsProgrammed;
        if is_idle && motions.iter().all(|motion| motion.compensation.is_none()) {
            return;
        }
        // Their own blocks may have been in another batch: then no text is quoted for them.
        self.held.iter_mut().for_each(|(motion, _)| motion.block = 0);
        for (programmed, made) in &mut self.settled {
            programmed.iter_mut().chain([made]).for_each(|(motion, _)| motion.block = 0);
        }
        for (index, motion) in motions.iter().enumerate() {
            let placed = (*motion, positions.get(index).copied().unwrap_or_default());
            match motion.compensation {
                None => {
                    let mut beside = motions.iter().skip(index.saturating_sub(1)).take(3);
                    let is_alone =
                        beside.all(|other| other.line != motion.line || std::ptr::eq(other, motion));
                    self.leave(batch, &placed, is_alone);
                }
                Some(compensation) => self.compensate(batch, &placed, compensation),
            }
        }
        self.hand_over(motions, positions);
    }

    /// The motions held back, at the end of the program.
    pub(super) fn finish(&mut self, motions: &mut Vec<Motion>, positions: &mut Vec<Position>) {
        self.end(None);
        self.hand_over(motions, positions);
    }

    fn hand_over(&mut self, motions: &mut Vec<Motion>, positions: &mut Vec<Position>) {
        motions.clear();
        positions.clear();
        for (motion, position) in self.done.drain(..) {
            motions.push(motion);
            positions.push(position);
        }
    }

    /// A motion without compensation, and whether it is the only one of its block.
    fn leave(&mut self, batch: &Batch, placed: &Placed, is_alone: bool) {
        let (mut motion, mut position) = *placed;
        self.end(Some((batch, &motion)));
        if !is_alone && self.standing != Standing::AsProgrammed {
            // The strokes of a cycle, and the ways through a point, were made from the programmed place.
            motion.unfollowable.get_or_insert(Unfollowable::CutterCompensation);
            (motion.start, motion.end, motion.linear_end_mm, motion.vector_start) = (None, None, None, None);
            self.standing = Standing::Unknown([true; 3]);
            self.done.push((motion, [None, None, None, position[3], position[4]]));
            return;
        }
        let is_followed = motion.unfollowable.is_none() && motion.kind != MotionKind::Opaque;
        match self.standing {
            Standing::AsProgrammed => {}
            Standing::Beside(at_mm, plane) => {
                let is_straight = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear);
                // The program does not say that the tool leaves the path in the plane on its way in machine coordinates.
                let is_way_out = is_followed && is_straight && motion.end.is_some() && !motion.in_machine;
                if let Some(start) = motion.start.filter(|_| is_way_out) {
                    motion.start = Some(in_plane(start, plane, at_mm));
                    self.standing = Standing::AsProgrammed;
                } else {
                    motion.unfollowable.get_or_insert(Unfollowable::CutterCompensation);
                    motion.start = None;
                    self.standing = Standing::Unknown(axes_of(Some(plane)));
                }
            }
            Standing::Unknown(mut elsewhere) => {
                // An increment counts from the place that is not known.
                if is_followed && !motion.incremental {
                    let words = batch.blocks().get(motion.block as usize).map(|block| batch.words(block));
                    for word in words.unwrap_or_default() {
                        if let Some(axis) = LINEAR.iter().position(|address| *address == word.address) {
                            elsewhere[axis] = false;
                        }
                    }
                }
                self.standing = Standing::Unknown(elsewhere);
                (motion.start, motion.vector_start) = (None, None);
                if elsewhere == [false; 3] {
                    self.standing = Standing::AsProgrammed;
                } else {
                    (motion.end, motion.linear_end_mm) = (None, None);
                    for (at, _) in position.iter_mut().zip(elsewhere).filter(|(_, elsewhere)| *elsewhere) {
                        *at = None;
                    }
                }
            }
        }
        self.done.push((motion, position));
    }

    fn compensate(&mut self, batch: &Batch, placed: &Placed, compensation: RadiusCompensation) {
        if self.under_way.as_ref().is_some_and(|way| way.number != compensation.number) {
            self.end(None);
        }
        match compensation.beside_mm {
            Some(beside_mm) if beside_mm.abs() <= 0.0 => self.leave(batch, placed, true),
            Some(beside_mm) => {
                if self.under_way.is_none() {
                    self.under_way = Some(UnderWay::new(&placed.0, compensation, beside_mm));
                }
                if self.step(batch, placed, compensation).is_none() {
                    self.lose(placed);
                }
            }
            // Its radius is not certain any more.
            None if self.under_way.is_some() => self.lose(placed),
            // After it the interpreter does not know the place.
            None => self.done.push(*placed),
        }
    }

    /// From the motions held back on, the path is not followed.
    fn lose(&mut self, placed: &Placed) {
        let (mut motion, position) = *placed;
        if let Some(way) = &mut self.under_way {
            way.is_lost = true;
            self.standing = self.standing.and_unknown(way.plane);
        }
        motion.unfollowable.get_or_insert(Unfollowable::CutterCompensation);
        self.give_up();
        self.done.push((motion, position));
    }

    /// The motions held back are not followed.
    fn give_up(&mut self) {
        let programmed = self.settled.drain(..).filter_map(|(programmed, _)| programmed);
        for (mut motion, position) in programmed.chain(self.held.drain(..)) {
            motion.unfollowable = Some(Unfollowable::CutterCompensation);
            self.done.push((motion, position));
        }
    }

    /// The last piece runs forwards, so the motions before it are certain.
    fn confirm(&mut self) {
        self.done.extend(self.settled.drain(..).map(|(_, made)| made));
    }

    /// Compensation ends after the motions held back, with the next motion if there is one.
    fn end(&mut self, next: Option<(&Batch, &Motion)>) {
        let Some(way) = self.under_way.take() else { return };
        if way.is_lost {
            return;
        }
        let Some((piece, from_mm)) = way.last else { return };
        let place = piece.beside(way.beside_mm).map(|beside| beside.end_mm);
        let is_certain = way.rule == RadiusRule::Rs274
            || next.is_some_and(|(batch, motion)| way.is_left_alike(batch, motion, &piece));
        let reached = place
            .filter(|_| is_certain && (!way.enters || way.rule == RadiusRule::Rs274))
            .filter(|at_mm| self.let_go(&way, &piece, from_mm, *at_mm, false).is_some());
        if let Some(at_mm) = reached {
            self.confirm();
            self.standing = Standing::Beside(at_mm, way.plane);
            return;
        }
        self.standing = Standing::Unknown(axes_of(Some(way.plane)));
        self.give_up();
    }

    /// One motion of a compensated path; `None` if it is not followed.
    fn step(&mut self, batch: &Batch, placed: &Placed, compensation: RadiusCompensation) -> Option<()> {
        let motion = &placed.0;
        let way = self.under_way.clone().filter(|way| !way.is_lost && way.takes(motion))?;
        let [start, end] = [motion.start?, motion.end?];
        let ends_mm = [start, end].map(|words| of_plane(words, way.plane));
        if way.last.is_some() && !is_same(ends_mm[0], way.programmed_mm) {
            return None;
        }
        if motion.kind != MotionKind::Arc && is_same(ends_mm[0], ends_mm[1]) {
            // There is no way in without a motion in the plane.
            let is_followed = way.last.is_some() && self.held.len() < MAX_HELD && way.passes(batch, motion);
            is_followed.then(|| self.held.push(*placed))?;
            return Some(());
        }
        let piece = way.piece(batch, motion, compensation)?;
        let from_mm = match (way.last, way.rule) {
            (None, RadiusRule::Rs274) => self.enter(&way, &piece)?,
            (None, RadiusRule::Common) => {
                (self.standing == Standing::AsProgrammed && names(batch, motion, &ON)).then_some(())?;
                self.enter(&way, &piece)?
            }
            (Some((last, last_from_mm)), rule) => {
                let turn = Turn { last, last_from_mm, next: piece, motion };
                match rule {
                    RadiusRule::Rs274 => self.take(&way, &turn)?,
                    RadiusRule::Common => self.take_alike(&way, &turn)?,
                }
            }
        };
        self.held.push(*placed);
        let way = self.under_way.as_mut()?;
        way.enters = way.last.is_none();
        (way.last, way.programmed_mm, way.place) = (Some((piece, from_mm)), ends_mm[1], place_of(motion));
        Some(())
    }

    /// The place from which the tool goes in \[mm\]. The way in is straight and longer than the radius.
    fn enter(&mut self, way: &UnderWay, piece: &PlanePiece) -> Option<[f64; 2]> {
        let long_mm = (0..2).map(|k| (piece.end_mm[k] - piece.start_mm[k]).powi(2)).sum::<f64>().sqrt();
        if piece.circle.is_some() || long_mm <= way.beside_mm.abs() {
            return None;
        }
        let from_mm = match self.standing {
            Standing::AsProgrammed => piece.start_mm,
            Standing::Beside(at_mm, plane) if plane == way.plane => at_mm,
            Standing::Beside(..) | Standing::Unknown(_) => return None,
        };
        self.standing = Standing::AsProgrammed;
        Some(from_mm)
    }

    /// The corner between the last piece and the next one: the motions held back end there. Gives the place where the
    /// tool begins the next piece \[mm\].
    fn take(&mut self, way: &UnderWay, turn: &Turn) -> Option<[f64; 2]> {
        let Turn { last, last_from_mm, next, motion } = turn;
        let last_end_mm = last.beside(way.beside_mm)?.end_mm;
        match last.corner(next, way.beside_mm) {
            Corner::OutOfReach => None,
            Corner::Meet(at_mm) => {
                self.let_go(way, last, *last_from_mm, at_mm, true)?;
                Some(at_mm)
            }
            Corner::Smooth => {
                self.let_go(way, last, *last_from_mm, last_end_mm, false)?;
                Some(last_end_mm)
            }
            Corner::Around => {
                let next_start_mm = next.beside(way.beside_mm)?.start_mm;
                // The control allows no arc before such a corner to grow.
                self.let_go(way, last, *last_from_mm, last_end_mm, true)?;
                let start = motion.start?;
                let mut around = **motion;
                // A rapid goes around a corner in a straight line.
                if motion.kind != MotionKind::Rapid {
                    around.kind = MotionKind::Arc;
                    let is_clockwise = way.beside_mm > 0.0;
                    around.arc = ArcCourse::About { centre_mm: next.start_mm, is_clockwise };
                }
                around.end = Some(in_plane(start, way.plane, next_start_mm));
                around.start = Some(in_plane(start, way.plane, last_end_mm));
                self.settled.push((None, (made_of(&around), position_of(around.end))));
                Some(next_start_mm)
            }
        }
    }

    /// A corner that all controls run alike: an inner corner, where the paths beside meet, or a corner that is nearly
    /// straight. The way in ends beside the beginning of the next piece.
    fn take_alike(&mut self, way: &UnderWay, turn: &Turn) -> Option<[f64; 2]> {
        let Turn { last, last_from_mm, next, motion } = turn;
        way.goes_on_to(motion).then_some(())?;
        let is_straight_on = way.turns_inwards(last, next)?;
        let at_mm = if way.enters {
            next.beside(way.beside_mm)?.start_mm
        } else if is_straight_on {
            last.beside(way.beside_mm)?.end_mm
        } else {
            last.meeting_mm(next, way.beside_mm)?
        };
        self.let_go(way, last, *last_from_mm, at_mm, !is_straight_on)?;
        Some(at_mm)
    }

    /// Ends the motions held back at a place in the plane \[mm\]; `None` if a piece would run backwards.
    fn let_go(
        &mut self,
        way: &UnderWay,
        piece: &PlanePiece,
        from_mm: [f64; 2],
        to_mm: [f64; 2],
        is_cut: bool,
    ) -> Option<()> {
        let direction = piece.direction_at(to_mm)?;
        let along_mm = (0..2).map(|k| (to_mm[k] - from_mm[k]) * direction[k]).sum::<f64>();
        let is_forwards = if piece.circle.is_none() {
            along_mm >= -BACKWARDS_MM
        } else {
            let is_one_place = (0..2).all(|k| (to_mm[k] - from_mm[k]).abs() < SAME_MM);
            let was_round = (0..2).all(|k| (piece.end_mm[k] - piece.start_mm[k]).abs() < SAME_MM);
            let more_rad = if is_cut { MORE_SWEEP_RAD } else { MORE_SMOOTHED_RAD };
            let programmed_rad = piece.sweep_rad(piece.start_mm, piece.end_mm);
            is_one_place == was_round && piece.sweep_rad(from_mm, to_mm) <= programmed_rad + more_rad
        };
        // The course of an arc would not be known.
        let is_circle =
            piece.circle.is_none_or(|circle| missed_mm(circle.centre_mm, from_mm, to_mm) <= RADIUS_SLACK_MM);
        if !(is_forwards && is_circle) {
            return None;
        }
        self.confirm();
        for (index, programmed) in self.held.drain(..).enumerate() {
            let mut motion = programmed.0;
            let from_mm = if index == 0 { from_mm } else { to_mm };
            motion.start = motion.start.map(|start| in_plane(start, way.plane, from_mm));
            motion.end = motion.end.map(|end| in_plane(end, way.plane, to_mm));
            if let Some(PlaneCircle { centre_mm, is_clockwise }) = piece.circle.filter(|_| index == 0) {
                motion.arc = ArcCourse::About { centre_mm, is_clockwise };
            }
            self.settled.push((Some(programmed), (made_of(&motion), position_of(motion.end))));
        }
        Some(())
    }
}

/// The words with this place in the plane \[mm\].
fn in_plane(mut words: AxisWords, plane: u8, at_mm: [f64; 2]) -> AxisWords {
    for (axis, at_mm) in plane_axes(plane).into_iter().zip(at_mm) {
        words.linear_mm[axis] = at_mm;
    }
    words
}

fn position_of(words: Option<AxisWords>) -> Position {
    let Some(AxisWords { linear_mm: [x, y, z], rotary_deg: [first, second] }) = words else {
        return [None; 5];
    };
    [x, y, z, first, second].map(Some)
}

/// A motion with the ends that the control computed. Words that state a contact belong to the programmed path.
fn made_of(motion: &Motion) -> Motion {
    Motion {
        linear_end_mm: motion.end.map(|end| end.linear_mm),
        tool_axis: None,
        vector_start: None,
        contact: ContactWords::None,
        repeats: false,
        ..*motion
    }
}
