//! Statement words of conversational and cutter location programs: the modes that they set, and their effects on their
//! own block only.

use super::block_words::AXES;
use super::dialect::PlainStatement;
use super::execute::Action;
use super::interpreter::Interpreter;
use super::meaning::Statement;
use super::modal::{ModalFeed, MotionMode, ToolLength, Transformation};
use super::start_modes::StartModes;
use super::travel::VECTOR;
use super::{FeedMode, Unfollowable, WorkOffset};
use crate::program::Address;

/// The facts of a block that hold for this block only.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about one block")]
pub(super) struct ThisBlock {
    /// M91, M92: other coordinates than those of the program.
    pub(super) machine_coordinates: bool,
    /// The block counts from the zero of the machine.
    pub(super) from_machine_zero: bool,
    /// The block counts from another place, whatever else it says.
    pub(super) from_other_zero: bool,
    /// A cycle runs where the block ends.
    pub(super) runs_cycle: bool,
    /// The defined cycle makes a hole where the block ends.
    pub(super) makes_hole: bool,
    /// The program ends here.
    pub(super) ends: bool,
    /// The block's F is not a path feed in the program's unit.
    pub(super) other_feed: bool,
    /// M129 acts after the motion.
    pub(super) tcp_off_behind: bool,
    /// M127 acts after the motion.
    pub(super) shortest_off_behind: bool,
    /// The axis words state where the tool is. They are not a motion.
    pub(super) states_position: bool,
    /// A jump, or a repetition of text that was already followed.
    pub(super) flow: bool,
    /// The index of the known section that is called.
    pub(super) section: Option<usize>,
    /// An arc without an end: a full circle.
    pub(super) full_circle: bool,
    /// An arc about a centre that a separate statement gave.
    pub(super) about_centre: bool,
    /// An arc that continues in the direction of the motion before.
    pub(super) tangent: bool,
    /// `TURN=`: full circles in addition to the path to the arc's end.
    pub(super) further_turns: Option<u16>,
    /// `TURN=` with a value that is not a whole number or is not known.
    pub(super) odd_turns: bool,
    /// After the block the linear axes are somewhere else.
    pub(super) forgets_linear: bool,
    /// Axes move that the block does not name.
    pub(super) moves_elsewhere: bool,
    /// A series of canned cycles begins.
    pub(super) begins_cycle: bool,
    /// G9: the machine stops at the block's end.
    pub(super) exact_stop: bool,
}

/// The most full circles that an arc makes in addition to the path to its end.
const MAX_FURTHER_TURNS: u16 = 999;
/// From this angle on a rotary axis has a shorter way \[deg\].
const HALF_TURN_DEG: f64 = 180.0;
/// Directions this close to +Z are +Z \[components\].
const SAME_AXIS: f64 = 1e-9;

impl Interpreter {
    /// The dialect is now known. Sets the modes with which its programs start.
    pub(super) fn begin_dialect(&mut self) {
        self.modal.tool_length = Some(self.rules.tool_length);
        self.is_rs274 &= self.rules.has_rs274_codes;
        if self.rules.is_of_points {
            self.position.tool_axis = [Some(0.0), Some(0.0), Some(1.0)];
        }
        self.modal.motion = self.modal.motion.or(self.rules.motion);
        self.begin_in_stated_modes();
        self.begin_unit();
        self.stand_at_start();
        self.find_obstacle();
    }

    /// The modes that the caller states, unless the dialect has no modal motion or begins in one of its own.
    fn begin_in_stated_modes(&mut self) {
        if self.modal.motion.is_some() || !self.rules.motion_is_modal {
            return;
        }
        let StartModes { is_rapid, plane, incremental, is_per_turn, retract } = self.options.start_modes;
        self.modal.motion = is_rapid.map(|rapid| if rapid { MotionMode::Rapid } else { MotionMode::Linear });
        self.modal.plane = plane.or(self.modal.plane);
        self.modal.incremental = incremental.or(self.modal.incremental);
        self.modal.cycle.retract = retract;
        if let Some(per_turn) = is_per_turn {
            self.modal.count_feed(Some(if per_turn { FeedMode::PerRevolution } else { FeedMode::PerMinute }));
        }
    }

    /// Prepares for the words of a block. In dialects whose statements name the motion, no motion is modal.
    #[inline]
    pub(super) fn begin_block(&mut self) {
        self.this_block = ThisBlock::default();
        if !self.rules.motion_is_modal {
            self.modal.motion = None;
        }
    }

    /// Whether the block is only a line or a point. Its mode is set then.
    #[inline]
    pub(super) fn is_plain_statement(&mut self) -> bool {
        let Some((keyword, statement)) = self.rules.plain_statement else { return false };
        if self.block.only_statement() != Some(keyword) || self.sections.is_called_text {
            return false;
        }
        match statement {
            PlainStatement::Line => self.modal.motion = Some(MotionMode::Linear),
            PlainStatement::Point => self.point_mode(),
        }
        true
    }

    /// Sets the mode of a statement word. Returns the other actions of the block.
    #[expect(clippy::too_many_lines, reason = "one arm for every kind of statement")]
    pub(super) fn apply_statement(
        &mut self,
        statement: Statement,
        reason: &mut Option<Unfollowable>,
    ) -> Option<Action> {
        match statement {
            Statement::ArcAboutCentre => {
                self.modal.motion = Some(MotionMode::Arc);
                self.this_block.full_circle = self.block.present & AXES == 0;
                self.this_block.about_centre = true;
            }
            Statement::TangentArc => {
                self.modal.motion = Some(MotionMode::Arc);
                self.this_block.tangent = true;
            }
            Statement::RapidHere if self.modal.motion == Some(MotionMode::Linear) => {
                self.modal.motion = Some(MotionMode::Rapid);
            }
            Statement::RapidHere => {}
            Statement::Corner => *reason = Some(Unfollowable::Corner),
            Statement::Feedrate => {
                // Systems differ on whether RAPID or a feed after it holds. A cut must not become a rapid.
                if self.modal.next_motion == Some(MotionMode::Rapid) {
                    self.modal.next_motion = None;
                }
            }
            Statement::OtherFeed => {
                self.this_block.other_feed = true;
                self.modal.feed = ModalFeed::Unknown;
            }
            Statement::FeedUnit(mode, mm_per_unit) => self.feed_unit(mode, mm_per_unit),
            Statement::End => self.this_block.ends = true,
            Statement::ToolCall => {
                self.position.forget_linear();
                self.modal.plane = Some(2);
                self.transform(Transformation::ToolAxis, false);
            }
            Statement::OtherToolAxis => self.transform(Transformation::ToolAxis, true),
            Statement::DatumShift => {
                self.shift_datum();
                return Some(Action::Consume);
            }
            Statement::AxisScaling => {
                self.scale_axes();
                return Some(Action::Consume);
            }
            Statement::DatumReset => self.set_datum([Some(0.0); 3]),
            Statement::DatumTable => self.set_datum([None; 3]),
            Statement::Preset => self.take_preset(),
            Statement::TiltOff => {
                self.transform(Transformation::Tilt, false);
                self.position.forget_axes();
            }
            Statement::TcpOther => self.lose_tool_length(),
            Statement::Tcp(on) => self.set_tcp(on),
            // Sections of a program that is followed as it runs are entered where they are called.
            Statement::Label | Statement::LabelEnd if self.options.as_it_runs => {}
            Statement::Label => self.pass_label(),
            Statement::LabelEnd => self.end_section(),
            Statement::CallLabel | Statement::RepeatLabel if self.options.as_it_runs => {
                return Some(Action::Call);
            }
            Statement::CallLabel => return self.call_label(false),
            Statement::RepeatLabel => return self.call_label(true),
            Statement::CycleCall => {
                self.this_block.runs_cycle = true;
                return Some(Action::Odd(Unfollowable::CannedCycle));
            }
            Statement::CycleCallHere => {
                self.this_block.runs_cycle = true;
                return Some(Action::Consume);
            }
            Statement::DefineHole => return Some(self.define_hole()),
            Statement::OtherCycle => self.modal.hole = None,
            Statement::Contour => {
                self.modal.next_motion = None;
                self.this_block.forgets_linear = true;
                self.forget_stated_axis();
                return Some(Action::Odd(Unfollowable::ContourElement));
            }
            Statement::Probe => {
                // A probing cycle may write presets and rotations.
                self.shift_offsets();
                return Some(Action::Unknown);
            }
            Statement::Point => self.point_mode(),
            Statement::From => {
                self.this_block.states_position = true;
                self.point_mode();
            }
            Statement::NextRapid => self.modal.next_motion = Some(MotionMode::Rapid),
            Statement::Circle => {
                self.modal.next_motion = Some(MotionMode::Arc);
                self.state_circle();
                return Some(Action::Consume);
            }
            Statement::InCycle(on) => self.begin_point_cycle(on),
            Statement::WorldPoints => self.enter_world(),
            Statement::Multax(on) => self.modal.multax = on,
            Statement::ToolAxis => {
                self.this_block.states_position = true;
                self.take_tool_axis();
            }
            Statement::CoordinateSystem => self.enter_system(),
            Statement::FurtherTurns => self.take_further_turns(),
            Statement::GoHome => {
                self.modal.next_motion = None;
                self.this_block.forgets_linear = true;
                return Some(Action::Odd(Unfollowable::Reference));
            }
        }
        None
    }

    /// `TURN=2`
    fn take_further_turns(&mut self) {
        let turns = self
            .block
            .value(Address::P)
            .and_then(|value| (0..=MAX_FURTHER_TURNS).find(|turns| (f64::from(*turns) - value).abs() <= 0.0));
        self.this_block.further_turns = turns;
        self.this_block.odd_turns = turns.is_none();
    }

    /// Cycle 247: selects another preset.
    fn take_preset(&mut self) {
        let preset = self.number_of(Address::P).map(WorkOffset::Preset);
        self.set_work_offset(preset);
        // Newer controls cancel a datum shift here. They also cancel mirror, rotation and scaling, but nothing is
        // followed while one of these is on.
        if self.modal.datum_mm != [Some(0.0); 3] {
            self.set_datum([None; 3]);
        }
        self.position.forget_axes();
    }

    /// `TRNTYP/WORLD,0,0,0`: the systems of the set-ups after it do not move the points.
    fn enter_world(&mut self) {
        self.change_system(Some(WorkOffset::Unnamed));
        self.modal.points_in_world = true;
    }

    /// `CSYS/`, `MSYS/`: the points after it belong to another set-up, unless it names the same system again.
    fn enter_system(&mut self) {
        if self.modal.points_in_world {
            return;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "23 bits")]
        let system = self.block.value(Address::P).map(|digest| WorkOffset::System(digest as u32));
        self.change_system(system);
    }

    fn change_system(&mut self, system: Option<WorkOffset>) {
        if system.is_none() || system != self.modal.work_offset {
            self.position.axes = [None; 5];
            if self.modal.axis_stated || !self.is_upright() {
                self.position.forget_tool_axis();
            }
        }
        self.modal.work_offset = system;
    }

    /// A feed with its own unit. If that is not the program's unit, the number is not taken.
    fn feed_unit(&mut self, mode: FeedMode, mm_per_unit: Option<f64>) {
        self.modal.count_feed(Some(mode));
        let differs =
            mm_per_unit.is_some_and(|mm| self.modal.mm_per_unit.is_none_or(|unit| (mm - unit).abs() > 0.0));
        self.this_block.other_feed |= differs;
    }

    /// Applies the codes that act after the motion.
    pub(super) fn finish_block(&mut self) {
        if self.this_block.forgets_linear || self.this_block.runs_cycle {
            self.position.forget_linear();
        }
        if self.this_block.tcp_off_behind {
            self.set_tcp(false);
        }
        if self.this_block.shortest_off_behind {
            self.modal.shortest_path = false;
        }
        if self.this_block.tcp_off_behind {
            self.find_obstacle();
        }
    }

    /// The mode of a GOTO: the mode for which RAPID or CIRCLE before it asked.
    fn point_mode(&mut self) {
        let next = self.modal.next_motion.take();
        let mode = if self.modal.in_cycle { MotionMode::Cycle } else { next.unwrap_or(MotionMode::Linear) };
        self.modal.motion = Some(mode);
        let states_axis = self.block.has(Address::TI);
        if !states_axis && self.modal.axis_stated && !self.modal.multax && !self.is_upright() {
            // If the axis is left out, some systems mean the last axis and others mean Z.
            self.position.forget_tool_axis();
        }
        self.modal.axis_stated |= states_axis;
    }

    fn is_upright(&self) -> bool {
        let [Some(i), Some(j), Some(k)] = self.position.tool_axis else { return false };
        i.abs() < SAME_AXIS && j.abs() < SAME_AXIS && k > 0.0
    }

    /// TLAXIS: the axis of points with three values.
    fn take_tool_axis(&mut self) {
        self.position.tool_axis = VECTOR.map(|address| self.block.value(address));
        self.modal.axis_stated = false;
    }

    /// Forgets the tool axis if a vector stated it.
    fn forget_stated_axis(&mut self) {
        if self.modal.axis_stated || self.modal.tool_length != Some(ToolLength::Vector) {
            self.position.forget_tool_axis();
        }
    }

    fn shift_datum(&mut self) {
        let mut datum = self.modal.datum_mm;
        for (slot, address) in datum.iter_mut().zip([Address::X, Address::Y, Address::Z]) {
            if !self.block.has(address) {
                continue;
            }
            let value = self.block.value(address).and_then(|value| Some(value * self.modal.mm_per_unit?));
            *slot = match self.block.is_incremental(address, Some(false)) {
                Some(true) => slot.and_then(|at| Some(at + value?)),
                _ => value,
            };
        }
        // A shift of a rotary axis is a rotation that is not followed.
        let turned = [Address::A, Address::B, Address::C].into_iter().any(|address| {
            self.block.has(address) && self.block.value(address).is_none_or(|value| value.abs() > 0.0)
        });
        self.set_datum(if turned { [None; 3] } else { datum });
    }

    /// Cycle 26: an axis stays scaled until its factor is 1.
    fn scale_axes(&mut self) {
        let mut scaled = self.modal.scaled_axes;
        if self.block.present & AXES == 0 {
            scaled = u32::MAX;
        }
        let axes = [Address::X, Address::Y, Address::Z, Address::A, Address::B, Address::C];
        for address in axes.into_iter().filter(|address| self.block.has(*address)) {
            if self.block.value(address) == Some(1.0) {
                scaled &= !address.bit();
            } else {
                scaled |= address.bit();
            }
        }
        self.modal.scaled_axes = scaled;
        self.transform(Transformation::AxisScaling, scaled != 0);
    }

    fn set_datum(&mut self, datum_mm: [Option<f64>; 3]) {
        let same = datum_mm == self.modal.datum_mm && datum_mm.iter().all(Option::is_some);
        if !same {
            self.position.forget_axes();
        }
        self.modal.datum_mm = datum_mm;
    }

    /// Whether a rotary axis would take the shorter way around, not the way that its words say.
    pub(super) fn takes_other_way(&self, start: Option<[f64; 2]>, end: Option<[f64; 2]>) -> bool {
        let (Some(start), Some(end)) = (start, end) else { return false };
        self.modal.shortest_path
            && start.iter().zip(&end).any(|(from, to)| (to - from).abs() >= HALF_TURN_DEG)
    }
}
