//! The effect of a block's M codes.

use super::interpreter::Interpreter;
use super::meaning::MFunction;
use super::modal::Transformation;

impl Interpreter {
    /// Whether the program ends here, and whether something is called.
    pub(super) fn apply_m_codes(&mut self) -> (bool, bool) {
        let (mut ends, mut called) = (false, false);
        for index in 0..self.block.m_count {
            match self.rules.m_function(self.block.m_codes[index]) {
                MFunction::Plain => {}
                MFunction::End | MFunction::Return => ends = true,
                MFunction::Call => called = true,
                MFunction::ToolChange => {
                    self.position.forget_linear();
                    self.modal.edge = None;
                }
                MFunction::KinematicsSwitch => {
                    self.position.forget_linear();
                    self.modal.kinematics_switched |= self.options.interpolation.is_none();
                }
                MFunction::MachineCoordinates => {
                    (self.this_block.machine_coordinates, self.this_block.from_machine_zero) = (true, true);
                }
                MFunction::OtherCoordinates => {
                    (self.this_block.machine_coordinates, self.this_block.from_other_zero) = (true, true);
                }
                MFunction::CycleCall => {
                    self.this_block.runs_cycle = true;
                    self.modal.macro_call = Some(false);
                }
                MFunction::CycleModal => {
                    self.this_block.runs_cycle = true;
                    self.modal.macro_call = Some(true);
                    // A setting of the control decides whether this is a call.
                    self.modal.hole = None;
                }
                MFunction::Tcp(true) => self.set_tcp(true),
                MFunction::Tcp(false) => self.this_block.tcp_off_behind = true,
                MFunction::TcpOther => self.lose_tool_length(),
                MFunction::RotaryFeedInMm(on) => self.modal.rotary_feed_in_mm = on,
                MFunction::ShortestPath(true) => self.modal.shortest_path = true,
                MFunction::ShortestPath(false) => self.this_block.shortest_off_behind = true,
                MFunction::Feed(mode) => self.modal.count_feed(Some(mode)),
                MFunction::ForgetRotary => self.position.forget_rotary_words(),
                MFunction::Elsewhere => self.this_block.moves_elsewhere = true,
                MFunction::Unknown => self.block.odd_code = true,
                MFunction::OtherSpindle => {
                    self.position.forget_linear();
                    self.modal.spindle.forget();
                    self.modal.edge = None;
                }
                MFunction::TurnsHead => {
                    self.position.forget_linear();
                    self.transform(Transformation::ToolAxis, true);
                }
                MFunction::ExtruderAbsolute => self.modal.relative_extruder = false,
                MFunction::ExtruderRelative => self.modal.relative_extruder = true,
            }
        }
        (ends, called)
    }
}
