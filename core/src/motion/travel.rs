//! Makes a motion from axis words.

use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::modal::{ACROSS_G17, MotionMode, ToolLength};
use super::motion_shell::most_decimals;
use super::{AxisWords, ContactWords, Extra, Interpolation, ModalGroup, Motion, MotionKind, Unfollowable};
use crate::geometry::PlaneFrame;
use crate::program::{Address, Block};

pub(super) const CONTACT: [Address; 3] = [Address::U, Address::V, Address::W];
pub(super) const NORMAL: [Address; 3] = [Address::NX, Address::NY, Address::NZ];
pub(super) const VECTOR: [Address; 3] = [Address::TI, Address::TJ, Address::TK];
pub(super) const NORMALS: u32 = Address::NX.bit() | Address::NY.bit() | Address::NZ.bit();
pub(super) const VECTORS: u32 = Address::TI.bit() | Address::TJ.bit() | Address::TK.bit();
/// Words of the centre and the radius of an arc.
const I: u32 = 1 << 8;
const J: u32 = 1 << 9;
const K: u32 = 1 << 10;
const R: u32 = 1 << 17;
pub(super) const CENTRE: u32 = I | J | K;
/// Repetitions of a cycle.
const L: u32 = 1 << 11;
pub(super) const POINTS: u32 = Address::U.bit() | Address::V.bit() | Address::W.bit();
/// Words that state where the cutter touches.
pub(super) const CONTACTS: u32 = POINTS | NORMALS;

impl Interpreter {
    /// The end of every block: the feed, then the motion that its axis words make in the present modes. `reason` is
    /// the block's own reason against being followed.
    #[inline]
    pub(super) fn move_axes(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) {
        if self.modal.hole_at_motions {
            return self.move_to_hole(index, block, reason, motions);
        }
        self.move_by_words(index, block, reason, motions);
    }

    /// The feed and the motion, without the cycle that may run at every motion.
    #[inline]
    pub(super) fn move_by_words(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) {
        let present = self.block.present;
        self.set_feed();
        let is_arc = self.modal.motion == Some(MotionMode::Arc)
            && (present & (I | J | K | R) != 0 || self.this_block.full_circle);
        if self.this_block.states_position {
            self.take_axis_words();
            return;
        }
        if present & (AXES | VECTORS) == 0 && !is_arc {
            if self.modal.motion == Some(MotionMode::Cycle) {
                self.doubt_cycle();
            }
            self.take_other_words();
            return;
        }
        let kind = match self.modal.motion {
            Some(MotionMode::Rapid) => MotionKind::Rapid,
            Some(MotionMode::Linear) => MotionKind::Linear,
            Some(MotionMode::Arc) => MotionKind::Arc,
            None => return self.move_unseen(index, block, mode_unknown(ModalGroup::Motion), motions),
            Some(MotionMode::Cycle) => return self.run_cycle(index, block, reason, motions),
            Some(MotionMode::Spline) => return self.move_unseen(index, block, Unfollowable::Spline, motions),
            Some(MotionMode::Thread) => {
                return self.move_unseen(index, block, Unfollowable::SpecialMotion, motions);
            }
            Some(MotionMode::Probing) => {
                return self.move_unseen(index, block, Unfollowable::Probing, motions);
            }
        };
        let start = self.position.axis_words();
        let vector_start = self.position.linear_mm().zip(self.position.tool_axis());
        let word_reason = self.word_reason(kind);
        self.take_axis_words();
        if self.modal.vectors_in_machine && present & VECTORS != 0 {
            self.position.forget_rotary();
        }
        let extra = self.take_other_words();
        let mut motion = self.motion_shell(index, block, kind);
        let in_program_axes = !matches!(
            self.obstacle(),
            Some(
                Unfollowable::Transformation
                    | Unfollowable::OtherTransformation
                    | Unfollowable::TiltedPlane
                    | Unfollowable::PlaneSolution
                    | Unfollowable::ModeUnknown { group: ModalGroup::Transformation }
            )
        );
        let counts_elsewhere =
            matches!(reason, Some(Unfollowable::MachineCoordinates | Unfollowable::OffsetHere));
        if in_program_axes && !counts_elsewhere {
            motion.start = start;
            motion.end = self.position.axis_words();
            motion.linear_end_mm = self.position.linear_mm();
            motion.tool_axis = self.position.tool_axis();
            motion.vector_start = vector_start;
        }
        let is_turned = !in_program_axes
            && !counts_elsewhere
            && (self.turn_ends(&mut motion, start) || self.move_in_plane(&mut motion, start));
        if !counts_elsewhere && !is_turned {
            motion.contact = self.contact();
        }
        motion.extra = extra;
        let on_circle = if self.has_point_arc() {
            let from_mm = vector_start.map(|(tip_mm, _)| tip_mm);
            self.pass_point_arc(kind, from_mm, motion.linear_end_mm)
        } else {
            None
        };
        // The machine's words for a vector can be found later, but nothing else can.
        let vector = Some(Unfollowable::ToolVector);
        let reason = match reason {
            None if self.block.has(Address::Z) && self.places_gauge_point() => {
                self.position.axes[2] = None;
                Some(mode_unknown(ModalGroup::ToolLength))
            }
            reason => reason,
        };
        let obstacle = if is_turned { None } else { self.as_in_plane(self.obstacle()) };
        motion.unfollowable =
            reason.or(obstacle.filter(|_| obstacle != vector)).or(word_reason).or(on_circle);
        if motion.unfollowable.is_none() {
            let rotary_deg = |words: Option<AxisWords>| words.map(|words| words.rotary_deg);
            if self.takes_other_way(rotary_deg(motion.start), rotary_deg(motion.end)) {
                motion.unfollowable = Some(Unfollowable::ShortestPath);
            } else if self.modal.rotary_feed_in_mm && feeds_a_turn(&motion) {
                motion.unfollowable = Some(Unfollowable::RotaryFeed);
            }
        }
        if extra.is_some() && self.is_extruder_relative() && motion.unfollowable.is_none() {
            motion.unfollowable = Some(Unfollowable::RelativeExtruder);
        }
        if motion.unfollowable.is_none() && motion.end.is_none() && motion.tool_axis.is_some() {
            motion.unfollowable = vector;
        }
        motion.unfollowable = motion.unfollowable.or(obstacle);
        self.note_offset(&mut motion);
        motions.push(motion);
    }

    /// Gives a motion in a turned frame its ends in the work offset. Returns whether it is followed.
    #[cold]
    pub(super) fn turn_ends(&self, motion: &mut Motion, start: Option<AxisWords>) -> bool {
        let Some((turn, end_mm)) = self.modal.turn.zip(self.position.linear_mm()) else { return false };
        let is_known = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear | MotionKind::Arc);
        let has_directions = self.block.present & (VECTORS | CONTACTS) != 0;
        let is_compensated = self.modal.compensation != Some(false);
        if is_compensated || !is_known || has_directions || self.modal.obstacle_beside_turn().is_some() {
            return false;
        }
        let turned = |words: AxisWords| AxisWords { linear_mm: turn.of(words.linear_mm), ..words };
        motion.start = start.map(turned);
        motion.end = self.position.axis_words().map(turned);
        motion.linear_end_mm = Some(turn.of(end_mm));
        // The centre and the plane of an arc are those of the frame.
        motion.frame = Some(PlaneFrame::new([0.0; 3], turn));
        true
    }

    /// The reason against following the block that lies in its words.
    #[inline]
    fn word_reason(&mut self, kind: MotionKind) -> Option<Unfollowable> {
        let block = &self.block;
        let corner_before = std::mem::replace(&mut self.corner_open, block.comma != 0);
        let mut reason = corner_before.then_some(Unfollowable::Corner);
        if block.has(Address::E) && !self.rules.has_extruder {
            reason = Some(Unfollowable::ControlWord);
        }
        if kind != MotionKind::Arc && block.present & (I | J | K | R) != 0 {
            reason = Some(match block.present {
                present if present & R != 0 => Unfollowable::Corner,
                present => Unfollowable::VectorWord { address: first_address(present & (I | J | K)) },
            });
            self.corner_open |= block.present & R != 0;
        }
        let has_turns = self.this_block.further_turns.is_some();
        if self.this_block.odd_turns || (has_turns && kind != MotionKind::Arc) {
            reason = Some(Unfollowable::ControlWord);
        }
        if block.present & self.axes.foreign().bit() != 0
            && (block.value(self.axes.foreign()).is_none()
                || block.value(self.axes.foreign()) != self.position.foreign_deg
                || block.is_incremental(self.axes.foreign(), self.modal.incremental) == Some(true))
        {
            reason = Some(Unfollowable::NoSuchAxis { address: self.axes.foreign() });
        }
        if let Some(address) = self.lone_letter() {
            reason = Some(Unfollowable::NoSuchAxis { address });
        }
        let block = &self.block;
        let has_axis = matches!(self.modal.tool_length, Some(ToolLength::Tcp | ToolLength::Vector) | None);
        if block.present & VECTORS != 0 && !has_axis {
            reason = Some(Unfollowable::VectorWord { address: Address::TI });
        }
        if block.present & VECTORS != 0 && self.modal.vectors_in_machine {
            reason = Some(Unfollowable::ControlWord);
        }
        if block.present & POINTS != 0
            && CONTACT.iter().any(|&address| {
                block.has(address) && block.is_incremental(address, self.modal.incremental) == Some(true)
            })
        {
            reason = Some(Unfollowable::IncrementalContact);
        }
        let relevant = AXES | POINTS | VECTORS | Address::E.bit() | Address::F.bit();
        if block.unknown & relevant != 0 {
            reason = Some(Unfollowable::Expression { address: first_address(block.unknown & relevant) });
        }
        reason
    }

    /// U, V or W if not all three are known. It is then not a contact but an axis in addition to the five. An axis
    /// that does not move has no effect.
    pub(super) fn lone_letter(&self) -> Option<Address> {
        let block = &self.block;
        if block.present & POINTS == 0 {
            return None;
        }
        let mut known = CONTACT.into_iter().zip(self.position.contact_mm);
        if known.clone().all(|(address, at)| block.has(address) || at.is_some()) {
            return None;
        }
        let moves = |address: Address, at: Option<f64>| {
            let to = block.value(address).zip(self.modal.mm_per_unit).map(|(value, scale)| value * scale);
            let stays = to.is_some()
                && to == at
                && block.is_incremental(address, self.modal.incremental) == Some(false);
            block.has(address) && !stays
        };
        known.find(|(address, at)| moves(*address, *at)).map(|(address, _)| address)
    }

    /// Moves the five axes, and the letter that the machine lacks, to the places that the words state.
    #[inline]
    pub(super) fn take_axis_words(&mut self) {
        let block = &self.block;
        let scale = self.modal.mm_per_unit;
        let repeated_or_unknown = block.unknown;
        for (slot, address) in self.axes.all().into_iter().enumerate() {
            let index = address.index();
            if block.present & (1 << index) == 0 {
                continue;
            }
            self.position.decimals[slot] = block.decimals[index];
            let scale = if slot < 3 { scale } else { Some(1.0) };
            self.position.axes[slot] = match (scale, block.is_incremental(address, self.modal.incremental)) {
                _ if repeated_or_unknown & (1 << index) != 0 => None,
                (Some(scale), Some(false)) => Some(block.values[index] * scale),
                (Some(scale), Some(true)) => {
                    self.position.axes[slot].map(|at| at + block.values[index] * scale)
                }
                _ => None,
            };
        }
        if block.present & self.axes.foreign().bit() != 0 {
            let sense = block.is_incremental(self.axes.foreign(), self.modal.incremental);
            let absolute = sense == Some(false);
            self.position.foreign_deg = block.value(self.axes.foreign()).filter(|_| absolute);
        }
        let [first, second] = self.axes.rotary();
        if block.present & VECTORS != 0 {
            // The control turns its rotary axes according to the vector.
            self.position.tool_axis = VECTOR.map(|address| block.value(address));
            self.position.forget_rotary_words();
            self.position.decimals[3..].fill(most_decimals(block));
        } else if block.present & (first.bit() | second.bit()) != 0 {
            self.position.forget_tool_axis();
        }
        if block.comma & Address::A.bit() != 0 {
            // An angle replaces a coordinate, so the control computes the end.
            self.position.forget_linear();
        }
    }

    /// Takes contact, normal and extruder words. Returns the motion of the extruder.
    #[inline]
    pub(super) fn take_other_words(&mut self) -> Option<Extra> {
        let block = &self.block;
        for (slot, address) in CONTACT.into_iter().enumerate() {
            let index = address.index();
            if block.present & (1 << index) != 0 {
                self.position.contact_decimals[slot] = block.decimals[index];
                let value = block.value(address);
                let before = self.position.contact_mm[slot];
                let sense = block.is_incremental(address, self.modal.incremental);
                self.position.contact_mm[slot] = match (self.modal.mm_per_unit, sense) {
                    (Some(scale), Some(false)) => value.map(|value| value * scale),
                    (Some(scale), Some(true)) => before.and_then(|at| value.map(|value| at + value * scale)),
                    _ => None,
                };
            }
        }
        if block.present & NORMALS != 0 {
            for (slot, address) in NORMAL.into_iter().enumerate() {
                if block.has(address) {
                    self.position.contact_decimals[slot] = block.decimals[address.index()];
                    self.position.normal[slot] = block.value(address);
                }
            }
        }
        if !block.has(Address::E) || !self.rules.has_extruder {
            return None;
        }
        self.position.extra_decimals = block.decimals[Address::E.index()];
        let start = self.position.extruder;
        let value = block.value(Address::E);
        let relative = self.is_extruder_relative();
        self.position.extruder = if relative { None } else { value };
        value.map(|end| Extra { start: start.filter(|_| !relative), end })
    }

    /// M83, or G91, or an unknown state of G90 and G91. On some controls E follows these codes.
    #[inline]
    fn is_extruder_relative(&self) -> bool {
        self.modal.relative_extruder
            || self.block.is_incremental(Address::E, self.modal.incremental) != Some(false)
    }

    /// The contact words of this block, completed from earlier blocks.
    #[inline]
    pub(super) fn contact(&self) -> ContactWords {
        if self.block.present & POINTS != 0 {
            if let [Some(u), Some(v), Some(w)] = self.position.contact_mm {
                return ContactWords::Point([u, v, w]);
            }
        } else if self.block.present & NORMALS != 0
            && let [Some(x), Some(y), Some(z)] = self.position.normal
        {
            return ContactWords::Normal([x, y, z]);
        }
        ContactWords::None
    }

    /// A block in cycle mode: the plane's axes end where the words say, the others somewhere else.
    fn run_cycle(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) {
        if self.follow_cycle(index, block, reason, motions)
            || self.follow_point_cycle(index, block, reason, motions)
        {
            return;
        }
        self.opaque(index, block, Unfollowable::CannedCycle, motions);
        let certain = self.modal.incremental == Some(false) && self.block.present & L == 0;
        self.take_axis_words();
        self.take_other_words();
        // In G18 and G19 some controls drill along Z, others across the plane.
        match self.modal.plane.filter(|_| certain) {
            Some(ACROSS_G17) => self.position.axes[2] = None,
            _ => self.position.forget_linear(),
        }
    }

    /// A motion whose course and end are not followed.
    fn move_unseen(&mut self, index: usize, block: &Block, reason: Unfollowable, motions: &mut Vec<Motion>) {
        self.opaque(index, block, reason, motions);
        self.take_other_words();
        self.forget_named(self.block.present);
        if reason == Unfollowable::Probing {
            self.position.forget_axes();
        }
    }
}

/// Whether F counts along a turn: rotary axes turn at feed, and no tip moves in W along which F could count.
fn feeds_a_turn(motion: &Motion) -> bool {
    let (Some(start), Some(end)) = (motion.start, motion.end) else { return false };
    let same = |from: &[f64], to: &[f64]| from.iter().zip(to).all(|(from, to)| (to - from).abs() <= 0.0);
    motion.kind != MotionKind::Rapid
        && !same(&start.rotary_deg, &end.rotary_deg)
        && (motion.interpolation == Interpolation::Machine || same(&start.linear_mm, &end.linear_mm))
}

fn mode_unknown(group: ModalGroup) -> Unfollowable {
    Unfollowable::ModeUnknown { group }
}

fn first_address(bits: u32) -> Address {
    if bits & !VECTORS == 0 {
        return Address::TI;
    }
    let letter = b'A' + u8::try_from(bits.trailing_zeros()).unwrap_or(0).min(25);
    Address::from_letter(letter).unwrap_or(Address::X)
}
