//! The effect of a block's G codes and statement words.

use super::block_words::{AXES, DWELL};
use super::execute::Action;
use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::{MotionMode, ToolLength, Transformation};
use super::{RadiusRule, Unfollowable, WorkOffset};
use crate::program::{Address, Code};

/// Words that belong to cycles and not to a change of units.
const CYCLE_WORDS: u32 = Address::P.bit()
    | Address::Q.bit()
    | Address::I.bit()
    | Address::J.bit()
    | Address::K.bit()
    | Address::L.bit();

impl Interpreter {
    /// Sets the modes. Returns the other actions of the block, and the reason why the block counts from another place,
    /// if it does.
    #[expect(clippy::too_many_lines, reason = "one arm for every kind of code")]
    pub(super) fn apply_g_codes(
        &mut self,
        reason: &mut Option<Unfollowable>,
    ) -> (Option<Action>, Option<Unfollowable>) {
        let mut action = None;
        let mut counts_elsewhere = None;
        let mut motion_codes = 0;
        let mut ends_cycle = false;
        let axis_words = self.block.present & AXES;
        let also = |action: &mut Option<Action>, new: Action| {
            // Two codes use the axis words. The code that moves unseen wins.
            let wins =
                !matches!(action, Some(Action::Call | Action::Unknown | Action::Elsewhere | Action::ToPlane));
            if action.is_some() && *action != Some(new) && axis_words != 0 {
                *action = Some(Action::Odd(Unfollowable::ConflictingCodes));
            } else if wins {
                *action = Some(new);
            }
        };
        for index in 0..self.block.g_count {
            let meaning = self.meaning(index);
            match meaning {
                Meaning::Motion(mode) => {
                    motion_codes += u32::from(motion_codes == 0 || self.modal.motion != Some(mode));
                    if mode == MotionMode::Cycle && self.modal.motion != Some(MotionMode::Cycle) {
                        self.this_block.begins_cycle = true;
                        self.modal.cycle.after_rapid = self.modal.motion == Some(MotionMode::Rapid);
                    }
                    self.modal.motion = Some(mode);
                    if mode == MotionMode::Arc {
                        self.note_arc(index);
                    }
                }
                Meaning::CycleRetract(retract) => self.modal.cycle.retract = Some(retract),
                Meaning::MotionWithAxes(MotionMode::Spline) if axis_words != 0 => {
                    self.modal.motion = Some(MotionMode::Spline);
                }
                Meaning::MotionWithAxes(_) if axis_words != 0 => {
                    also(&mut action, Action::Odd(Unfollowable::SpecialMotion));
                }
                Meaning::EndCycle => ends_cycle = true,
                _ if axis_words != 0 && self.may_name_axes(meaning) => {
                    // The words name axes, or they are offsets. On some controls the block moves all the same.
                    self.set_mode(meaning);
                    also(&mut action, Action::Odd(Unfollowable::ConflictingCodes));
                }
                Meaning::CylinderOfAxis => {
                    self.transform(Transformation::Cylinder, axis_words != 0);
                    also(&mut action, Action::Consume);
                }
                Meaning::HypotheticalAxis if axis_words != 0 => {
                    self.transform(Transformation::Cylinder, !self.is_hypothetical_end());
                    also(&mut action, Action::Consume);
                }
                Meaning::Plane(_)
                | Meaning::Incremental(_)
                | Meaning::Units(_)
                | Meaning::Feed(_)
                | Meaning::Compensation(_)
                | Meaning::CompensationByDiameter { .. }
                | Meaning::CompensationByRegister { .. }
                | Meaning::ToolLength(_)
                | Meaning::TipControl(_)
                | Meaning::SwitchTip(_)
                | Meaning::LengthAlongTool
                | Meaning::TipControlApart(_)
                | Meaning::LengthAlong(_)
                | Meaning::OffsetByH
                | Meaning::WorkOffset(_)
                | Meaning::WorkOffsetByP(_)
                | Meaning::ModeByP(_)
                | Meaning::Transform(..)
                | Meaning::EndRotation { .. }
                | Meaning::EndScaling
                | Meaning::MirrorNamed(_)
                | Meaning::EndPolarOrOffset
                | Meaning::HypotheticalAxis
                | Meaning::ToolOffset
                | Meaning::RoundsCorners(_)
                | Meaning::VectorsInMachine(_)
                | Meaning::ExactStop(_)
                | Meaning::ExactStopHere => self.set_mode(meaning),
                Meaning::NoMotion => also(&mut action, Action::Consume),
                Meaning::WriteOffsets => {
                    self.write_offsets();
                    also(&mut action, Action::Consume);
                }
                Meaning::Shift | Meaning::LocalShift => also(&mut action, Action::Shift),
                Meaning::EndShift | Meaning::OtherShift => {
                    let is_ended = meaning == Meaning::EndShift && self.end_shift();
                    if !is_ended && !self.ends_no_shift() {
                        self.shift_offsets();
                        self.shift_offsets();
                    }
                    also(&mut action, Action::Consume);
                }
                Meaning::MachineCoordinates => {
                    counts_elsewhere = Some(Unfollowable::MachineCoordinates);
                    self.this_block.from_machine_zero = true;
                }
                Meaning::NearMachineZero => {
                    counts_elsewhere = Some(Unfollowable::MachineCoordinates);
                    self.this_block.from_other_zero = true;
                }
                Meaning::OffsetByHHere => counts_elsewhere = Some(self.offset_here()),
                Meaning::Reference => also(&mut action, Action::Reference),
                Meaning::StoreReference => {
                    self.store_reference();
                    also(&mut action, Action::Consume);
                }
                Meaning::Elsewhere => also(&mut action, Action::Elsewhere),
                Meaning::ToPlane => also(&mut action, Action::ToPlane),
                Meaning::Call => also(&mut action, Action::Call),
                Meaning::ModalCall => {
                    self.modal.macro_call = Some(true);
                    self.modal.hole_at_motions = false;
                    also(&mut action, Action::Call);
                }
                Meaning::EndModalCall => self.end_modal_call(),
                Meaning::Statement(statement) => {
                    if let Some(new) = self.apply_statement(statement, reason) {
                        also(&mut action, new);
                    }
                }
                Meaning::ProgramFrame(frame, added) => {
                    self.program_frame(frame, added);
                    also(&mut action, Action::Frame);
                }
                Meaning::ModalCycle
                | Meaning::Cycle
                | Meaning::Swivel(_)
                | Meaning::Probing
                | Meaning::PolarEnd
                | Meaning::OrientationWord
                | Meaning::OtherAxis => {
                    if let Some(new) = self.leave(meaning) {
                        also(&mut action, new);
                    }
                }
                Meaning::BlockWord => also(&mut action, Action::Odd(Unfollowable::ControlWord)),
                Meaning::ForeignWord => *reason = Some(Unfollowable::ControlWord),
                Meaning::Harmless => self.note_centres(index),
                Meaning::MotionWithAxes(_) => {}
                Meaning::Unknown | Meaning::UnitsUnlessCycle(_) | Meaning::HarmlessUnlessAxes => {
                    also(&mut action, Action::Unknown);
                }
            }
        }
        if ends_cycle && motion_codes == 0 && self.modal.motion == Some(MotionMode::Cycle) {
            // The modes of motion and of cycles are two groups, or G80 begins G0. Others refuse words without a mode.
            let is_rapid = self.modal.cycle.after_rapid && self.rules.has_rs274_codes && !self.is_rs274;
            self.modal.motion = (is_rapid && axis_words == 0).then_some(MotionMode::Rapid);
        }
        if motion_codes > 1 {
            *reason = Some(Unfollowable::ConflictingCodes);
            self.modal.motion = None;
        }
        // A dwell and a motion: it depends on the control which of them the axis words belong to.
        let is_dwell = self.block.g_codes().contains(&DWELL);
        let of_motion = match motion_codes {
            0 if is_dwell => axis_words & !self.rules.feed.dwell_times,
            0 => 0,
            _ => axis_words,
        };
        if action == Some(Action::Consume) && of_motion != 0 {
            action = Some(Action::Odd(Unfollowable::ConflictingCodes));
        }
        // A conflict never hides unknown codes or calls.
        if (0..self.block.g_count).any(|index| self.meaning(index) == Meaning::Unknown) {
            action = Some(Action::Unknown);
        }
        (action, counts_elsewhere)
    }

    /// Whether axis words in a block with this code may be something other than a motion.
    fn may_name_axes(&self, meaning: Meaning) -> bool {
        match meaning {
            Meaning::LengthAlongTool
            | Meaning::EndScaling
            | Meaning::MirrorNamed(false)
            | Meaning::TipControlApart(_) => true,
            Meaning::EndRotation { names_axes } => names_axes && !self.says_how_to_move(),
            _ => false,
        }
    }

    /// G0 to G3.
    fn says_how_to_move(&self) -> bool {
        self.block.g_codes().iter().any(|code| matches!(code, Code::G(0 | 10 | 20 | 30)))
    }

    /// Sets the mode that a code names.
    fn set_mode(&mut self, meaning: Meaning) {
        match meaning {
            Meaning::Plane(plane) => self.modal.plane = Some(plane),
            Meaning::Incremental(incremental) => self.modal.incremental = Some(incremental),
            Meaning::Units(mm_per_unit) => self.set_unit(mm_per_unit),
            Meaning::Feed(mode) => self.modal.count_feed(Some(mode)),
            Meaning::Compensation(on) => self.compensate_radius(on, None, RadiusRule::Common),
            Meaning::CompensationByDiameter { left } => {
                self.compensate_radius(true, self.diameter_beside_mm(left), RadiusRule::Rs274);
            }
            Meaning::CompensationByRegister { left } => {
                self.compensate_radius(true, self.register_beside_mm(left), self.radius_rule());
            }
            // A repeated TRAORI or TRAFOOF changes nothing.
            Meaning::SwitchTip(length) => self.switch_tip(length),
            Meaning::LengthAlongTool if self.axes.has_head_axis() && self.options.interpolation.is_none() => {
                self.lose_tool_length();
            }
            Meaning::LengthAlongTool => self.set_tool_length(ToolLength::Plain),
            Meaning::ToolLength(length) => {
                self.set_tool_length(length);
                (self.modal.has_no_length, self.modal.length_on) = (false, true);
            }
            Meaning::TipControl(length) | Meaning::TipControlApart(length) => {
                self.set_tool_length(length);
                self.modal.has_no_length = length == ToolLength::Plain;
                self.modal.length_on = !self.modal.has_no_length;
                self.modal.kinematics_switched = false;
            }
            Meaning::LengthAlong(axis) => self.take_length_along(axis),
            // H0 is the machine's zero, which is no work offset.
            Meaning::OffsetByH => {
                let number = self.number_of(Address::H).filter(|number| *number > 0);
                self.set_work_offset(number.map(WorkOffset::by_h));
            }
            Meaning::WorkOffset(code) => self.select_offset(code, None),
            Meaning::WorkOffsetByP(code) => self.select_offset(code, Some(Address::P)),
            Meaning::ModeByP(mode) => self.set_mode_by_p(mode),
            Meaning::EndPolarOrOffset => {
                self.transform(Transformation::PolarWords, false);
                if self.block.has(Address::H) {
                    self.set_work_offset(self.number_of(Address::H).map(WorkOffset::by_h));
                }
            }
            Meaning::EndRotation { .. } => {
                self.transform(Transformation::Tilt, false);
                self.transform(Transformation::Rotation, false);
            }
            Meaning::EndScaling => self.transform(Transformation::Scaling, false),
            Meaning::MirrorNamed(on) => self.mirror(on),
            // The axis at zero ends G7.1.
            Meaning::Transform(Transformation::Cylinder, on) => {
                self.transform(Transformation::Cylinder, on && !self.is_cylinder_end());
            }
            Meaning::HypotheticalAxis => {
                self.transform(Transformation::Cylinder, !self.is_cylinder_end());
            }
            Meaning::Transform(which, on) => self.transform(which, on),
            Meaning::ToolOffset => {
                self.position.forget_linear();
                self.modal.edge = None;
            }
            Meaning::RoundsCorners(on) => self.modal.rounds_corners = on,
            Meaning::VectorsInMachine(on) => self.modal.vectors_in_machine = on,
            Meaning::ExactStop(on) => self.modal.exact_stop = on,
            Meaning::ExactStopHere => self.this_block.exact_stop = true,
            _ => {}
        }
    }

    /// Leaves the motion of the words unchanged. Returns the other actions.
    fn leave(&mut self, meaning: Meaning) -> Option<Action> {
        match meaning {
            Meaning::ModalCycle => return Some(self.begin_modal_hole()),
            Meaning::Cycle => return Some(Action::Hole),
            Meaning::Swivel(on) => {
                self.transform(Transformation::Swivel, on);
                if on {
                    self.position.forget_axes();
                    return Some(Action::Odd(Unfollowable::Transformation));
                }
            }
            Meaning::Probing => {
                self.position.forget_axes();
                return Some(Action::Odd(Unfollowable::Probing));
            }
            Meaning::PolarEnd => {
                self.position.forget_linear();
                return Some(Action::Odd(Unfollowable::ControlWord));
            }
            Meaning::OrientationWord => {
                self.position.forget_rotary();
                return Some(Action::Odd(Unfollowable::ControlWord));
            }
            Meaning::OtherAxis => {
                self.position.forget_axes();
                return Some(Action::Odd(Unfollowable::ControlWord));
            }
            _ => {}
        }
        None
    }

    /// The meaning of a G code in this block. G70 and G71 are cycles if the block also has words of cycles, of turning
    /// (P Q) or of holes in a circle (I J K L). G11 and G62 with axis words are frames. If G0 to G3 states how the
    /// block moves, they are not.
    pub(super) fn meaning(&self, index: usize) -> Meaning {
        let Some(&code) = self.block.g_codes().get(index) else { return Meaning::Unknown };
        match self.rules.meaning(code) {
            Meaning::StoreReference if !self.is_rs274 => Meaning::Unknown,
            Meaning::UnitsUnlessCycle(mm_per_unit) => self.unless(CYCLE_WORDS, Meaning::Units(mm_per_unit)),
            Meaning::HarmlessUnlessAxes => self.unless(AXES, Meaning::Harmless),
            meaning => meaning,
        }
    }

    /// This meaning, unless the block has words of these addresses and no code that states how it moves.
    fn unless(&self, words: u32, meaning: Meaning) -> Meaning {
        let is_other = self.block.present & words != 0 && !self.says_how_to_move();
        if is_other { Meaning::Unknown } else { meaning }
    }
}
