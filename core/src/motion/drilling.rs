//! Canned cycles that drill along the axis of the plane, as the motions that they are: to the place, to the retract
//! plane, down, and back up.
//!
//! A cycle is followed only if every control makes these motions of it, or if the machine's profile says that its
//! control runs programs as RS274/NGC does. Chip breaking and pecking are one stroke: the
//! retracts in between depend on parameters of the control. Dwells are no motions.

use super::block_words::AXES;
use super::cycle::{Retract, Stroke};
use super::interpreter::Interpreter;
use super::modal::{ACROSS_G17, ToolLength};
use super::tilted_plane::place_in;
use super::{FeedMode, Motion, MotionKind, Unfollowable};
use crate::program::{Address, Block};

/// The places of one cycle along the axis of the plane \[mm\].
#[derive(Debug, Clone, Copy)]
struct Levels {
    plane_mm: f64,
    depth_mm: f64,
    end_mm: f64,
    /// The cycle begins below the retract plane, and first goes up to it.
    rises: bool,
}

/// The most repetitions of a cycle.
const MAX_TIMES: f64 = 999.0;
/// Most strokes of a program's cycles in addition to one for each block: repetitions and pecks. A few bytes could ask
/// for motions without end.
const MAX_FURTHER_STROKES: u32 = 20_000;
/// Words that a followed cycle may have: X Y Z, R, the increment or time P and Q, repetitions, and words that no motion
/// depends on.
const CYCLE_WORDS: u32 = Address::X.bit()
    | Address::Y.bit()
    | Address::Z.bit()
    | Address::R.bit()
    | Address::P.bit()
    | Address::Q.bit()
    | Address::L.bit()
    | Address::K.bit()
    | Address::F.bit()
    | Address::S.bit()
    | Address::N.bit()
    | Address::H.bit()
    | Address::D.bit()
    | Address::T.bit();
/// Words that decide where a cycle moves.
const DECIDING_WORDS: u32 =
    AXES | Address::R.bit() | Address::L.bit() | Address::K.bit() | Address::P.bit() | Address::Q.bit();
/// Levels this close are one \[mm\].
const SAME_LEVEL_MM: f64 = 1e-9;

impl Interpreter {
    /// Follows the cycles of a block. Returns false, and changes nothing but the data of the cycle, if they are not
    /// followed.
    pub(super) fn follow_cycle(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) -> bool {
        let cycles = self.options.as_it_runs.then_some(self.rules.cycles).flatten();
        let Some(plane) = self.modal.plane.filter(|_| cycles.is_some()) else { return false };
        self.take_cycle_words(plane);
        let levels = self.levels(plane);
        // In G18 and G19 some controls drill along Z all the same.
        let is_followed = reason.is_none()
            && (plane == ACROSS_G17 || self.is_rs274)
            && (self.obstacle().is_none() || (plane == ACROSS_G17 && self.plane_in_force().is_some()))
            && !self.places_gauge_point()
            && self.cycle_words_are_known();
        let times = self.times().filter(|times| is_followed && self.may_repeat(times - 1));
        let (Some(levels), Some(times)) = (levels, times) else {
            // The drilled axis is somewhere else after it.
            self.modal.cycle.forget();
            return false;
        };
        // Where the way up to R runs is known only if the place before it is.
        let rises_at_known_place = !levels.rises || self.position.linear_mm().is_some();
        let is_seen = rises_at_known_place && self.next_place(plane).is_some();
        if !is_seen {
            self.opaque(index, block, Unfollowable::CannedCycle, motions);
        }
        self.further_strokes += times - 1;
        if let (true, Some(place_mm)) = (levels.rises && is_seen, self.position.linear_mm()) {
            self.go(index, block, MotionKind::Rapid, at_level(place_mm, plane, levels.plane_mm), motions);
        }
        for _ in 0..times {
            match self.next_place(plane).filter(|_| is_seen) {
                Some(place_mm) => self.drill(index, block, plane, place_mm, levels, motions),
                None => self.pass_hole(plane, levels.end_mm),
            }
        }
        self.take_other_words();
        true
    }

    /// Whether the cycles of the program may make this number of further strokes.
    pub(super) fn may_repeat(&self, strokes: u32) -> bool {
        self.further_strokes.saturating_add(strokes) <= MAX_FURTHER_STROKES
    }

    /// A block without axis words may run a cycle on some controls, if it has other words of cycles.
    pub(super) fn doubt_cycle(&mut self) {
        let deciding = self.block.present & DECIDING_WORDS;
        if let (true, Some(plane)) = (deciding != 0, self.modal.plane) {
            self.modal.cycle.forget();
            if let Some(drilled) = self.position.axes.get_mut(usize::from(plane)) {
                *drilled = None;
            }
        }
    }

    /// Takes the code, R and the depth of the block.
    fn take_cycle_words(&mut self, plane: u8) {
        let codes = self.block.g_codes();
        let stroke = codes.iter().rev().find_map(|code| self.rules.cycles.and_then(|of| of(*code)));
        let drilled = [Address::X, Address::Y, Address::Z].get(usize::from(plane)).copied();
        let drilled = drilled.unwrap_or(Address::Z);
        let word = |address: Address| {
            let value = self.block.value(address)?;
            Some((value * self.modal.mm_per_unit?, self.modal.incremental?))
        };
        let mut cycle = self.modal.cycle;
        let written_in = self.modal.mm_per_unit.map(|unit| (plane, unit));
        if self.this_block.begins_cycle || cycle.written_in != written_in {
            cycle.forget();
            cycle.written_in = written_in;
        }
        if self.this_block.begins_cycle {
            cycle.initial_mm = self.position.axes.get(usize::from(plane)).copied().flatten();
        }
        if let Some(stroke) = stroke {
            if stroke != cycle.stroke {
                // Controls differ in which values hold for another cycle.
                (cycle.plane, cycle.depth, cycle.has_increment) = (None, None, false);
            }
            cycle.stroke = stroke;
        }
        if self.block.has(Address::Q) {
            cycle.has_increment = self.block.value(Address::Q).is_some_and(|increment| increment > 0.0);
        }
        if self.block.has(Address::R) {
            cycle.plane = word(Address::R);
        }
        if self.block.has(drilled) {
            cycle.depth = word(drilled);
        }
        self.modal.cycle = cycle;
    }

    /// The levels of the cycle, if all controls agree in them: it begins at or above the retract plane, and drills
    /// down from there.
    fn levels(&self, plane: u8) -> Option<Levels> {
        let cycle = self.modal.cycle;
        let start_mm = (*self.position.axes.get(usize::from(plane))?)?;
        let incremental = self.modal.incremental?;
        let ((plane_value, plane_counts), (depth, depth_counts)) = (cycle.plane?, cycle.depth?);
        if plane_counts != incremental || depth_counts != incremental {
            return None;
        }
        let plane_mm = if incremental { start_mm + plane_value } else { plane_value };
        let depth_mm = if incremental { plane_mm + depth } else { depth };
        let initial_mm = cycle.initial_mm?;
        let is_same = |a_mm: f64, b_mm: f64| (a_mm - b_mm).abs() <= SAME_LEVEL_MM;
        let [rises, began_below] = [start_mm, initial_mm].map(|at_mm| at_mm < plane_mm - SAME_LEVEL_MM);
        let highest_mm = initial_mm.max(plane_mm);
        let end_mm = match cycle.retract {
            Some(Retract::Plane) => plane_mm,
            Some(Retract::Initial) => highest_mm,
            // It is the same whatever holds.
            None if is_same(highest_mm, plane_mm) => plane_mm,
            None => return None,
        };
        let is_of_series = is_same(start_mm, initial_mm);
        // Some controls go up to the retract plane above the hole. RS274/NGC controls go up first. Among these, some
        // take the level before the series for the initial level, and others the level before each cycle.
        let begins_soundly = if self.is_rs274 {
            rises == began_below && (rises || is_of_series || cycle.retract == Some(Retract::Plane))
        } else {
            !rises && !began_below
        };
        let is_sound = begins_soundly
            // In G91, R counts from the initial level or from the present one.
            && (!incremental || is_of_series)
            && depth_mm < plane_mm - SAME_LEVEL_MM;
        let is_agreed = match cycle.stroke {
            Stroke::Drill | Stroke::Bore => true,
            // K is the number of repetitions on some controls, and of increments on others.
            Stroke::Peck => cycle.has_increment && !self.block.has(Address::K),
            Stroke::Other => false,
        };
        (is_sound && is_agreed).then_some(Levels { plane_mm, depth_mm, end_mm, rises })
    }

    fn cycle_words_are_known(&self) -> bool {
        let present = self.block.present;
        present & !CYCLE_WORDS == 0
            && self.block.unknown & (DECIDING_WORDS | Address::F.bit()) == 0
            && self.block.incremental & present == 0
            && self.block.absolute & present == 0
            && self.block.comma == 0
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.modal.compensation == Some(false)
            && matches!(self.modal.feed_mode(), Some(FeedMode::PerMinute | FeedMode::PerRevolution))
    }

    /// The place of the next hole, at the present height, as far as it is known \[mm\].
    fn place_of_words(&self, plane: u8) -> [Option<f64>; 3] {
        let [x, y, z, ..] = self.position.axes;
        let mut place_mm = [x, y, z];
        let scale = self.modal.mm_per_unit.unwrap_or(1.0);
        for (slot, address) in [Address::X, Address::Y, Address::Z].into_iter().enumerate() {
            let Some(value) = self.block.value(address).filter(|_| slot != usize::from(plane)) else {
                continue;
            };
            let from_mm = if self.modal.incremental == Some(true) { place_mm[slot] } else { Some(0.0) };
            place_mm[slot] = from_mm.map(|from_mm| from_mm + value * scale);
        }
        place_mm
    }

    fn next_place(&self, plane: u8) -> Option<[f64; 3]> {
        let [Some(x), Some(y), Some(z)] = self.place_of_words(plane) else { return None };
        Some([x, y, z])
    }

    /// A hole whose motions are not followed. Its end is known as far as its place.
    fn pass_hole(&mut self, plane: u8, end_mm: f64) {
        let place_mm = self.place_of_words(plane);
        self.position.axes[..3].copy_from_slice(&place_mm);
        if let Some(drilled) = self.position.axes.get_mut(usize::from(plane)) {
            *drilled = Some(end_mm);
        }
    }

    /// How often the cycle runs. Only in G91 does it move on in between.
    fn times(&self) -> Option<u32> {
        let stated = [Address::L, Address::K].map(|address| self.block.value(address));
        let times = match stated {
            [None, None] => 1.0,
            [Some(times), None] | [None, Some(times)] => times,
            [Some(_), Some(_)] => return None,
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small whole number")]
        ((1.0..=MAX_TIMES).contains(&times) && times.fract() == 0.0).then_some(times as u32)
    }

    /// One cycle.
    fn drill(
        &mut self,
        index: usize,
        block: &Block,
        plane: u8,
        place_mm: [f64; 3],
        levels: Levels,
        motions: &mut Vec<Motion>,
    ) {
        let drilled = usize::from(plane);
        for (slot, address) in [Address::X, Address::Y, Address::Z].into_iter().enumerate() {
            if slot != drilled && self.block.has(address) {
                self.position.decimals[slot] = self.block.decimals[address.index()];
            }
        }
        let at = |level_mm: f64| at_level(place_mm, plane, level_mm);
        let Levels { plane_mm, depth_mm, end_mm, .. } = levels;
        let is_slow = self.modal.cycle.stroke == Stroke::Bore;
        for (kind, to_mm) in [
            (MotionKind::Rapid, place_mm),
            (MotionKind::Rapid, at(plane_mm)),
            (MotionKind::Linear, at(depth_mm)),
        ] {
            self.go(index, block, kind, to_mm, motions);
        }
        if !is_slow {
            return self.go(index, block, MotionKind::Rapid, at(end_mm), motions);
        }
        if self.is_rs274 {
            return self.go(index, block, MotionKind::Linear, at(end_mm), motions);
        }
        self.go(index, block, MotionKind::Linear, at(plane_mm), motions);
        // Some controls go on at rapid traverse, others at the feed.
        let before = motions.len();
        self.go(index, block, MotionKind::Linear, at(end_mm), motions);
        for motion in motions.iter_mut().skip(before) {
            motion.feed = motion.feed.unknown();
        }
    }

    /// One motion of a cycle, unless the tool is there already.
    fn go(
        &mut self,
        index: usize,
        block: &Block,
        kind: MotionKind,
        to_mm: [f64; 3],
        motions: &mut Vec<Motion>,
    ) {
        if self.position.linear_mm() == Some(to_mm) {
            return;
        }
        let mut motion = self.motion_shell(index, block, kind);
        motion.start = self.position.axis_words();
        self.stand_at(to_mm);
        motion.end = self.position.axis_words();
        motion.linear_end_mm = Some(to_mm);
        if let Some(frame) = self.plane_in_force() {
            place_in(frame, &mut motion);
        }
        self.note_offset(&mut motion);
        motions.push(motion);
    }

    pub(super) fn stand_at(&mut self, place_mm: [f64; 3]) {
        for (axis, to_mm) in self.position.axes.iter_mut().zip(place_mm) {
            *axis = Some(to_mm);
        }
    }
}

/// A place at another level along the axis of the plane \[mm\].
fn at_level(mut place_mm: [f64; 3], plane: u8, level_mm: f64) -> [f64; 3] {
    if let Some(level) = place_mm.get_mut(usize::from(plane)) {
        *level = level_mm;
    }
    place_mm
}
