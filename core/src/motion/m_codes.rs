//! What the M codes of a block do.

use super::codes::{MCode, m_meaning};
use super::interpreter::Interpreter;

impl Interpreter {
    /// Whether the program ends here, and whether something is called.
    pub(super) fn apply_m_codes(&mut self) -> (bool, bool) {
        let (mut ends, mut called) = (false, false);
        for index in 0..self.block.m_count {
            match m_meaning(self.dialect, self.block.m_codes[index]) {
                MCode::Plain => {}
                MCode::End | MCode::Return => ends = true,
                MCode::Call => called = true,
                MCode::ToolChange => {
                    self.position.forget_linear();
                    self.modal.edge = None;
                }
                MCode::KinematicsSwitch => {
                    self.position.forget_linear();
                    self.modal.kinematics_switched |= !self.options.interpolation_stated;
                }
                MCode::MachineCoordinates => self.this_block.machine_coordinates = true,
                MCode::CycleCall => {
                    self.this_block.runs_cycle = true;
                    self.modal.macro_call = Some(false);
                }
                MCode::CycleModal => {
                    self.this_block.runs_cycle = true;
                    self.modal.macro_call = Some(true);
                }
                MCode::Tcp(true) => self.set_tcp(true),
                MCode::Tcp(false) => self.this_block.tcp_off_behind = true,
                MCode::TcpOther => {
                    self.modal.tool_length = None;
                    self.position.forget_linear();
                }
                MCode::RotaryFeedInMm(on) => self.modal.rotary_feed_in_mm = on,
                MCode::ShortestPath(true) => self.modal.shortest_path = true,
                MCode::ShortestPath(false) => self.this_block.shortest_off_behind = true,
                MCode::Feed(mode) => {
                    if self.modal.feed_mode != Some(mode) {
                        self.modal.void_feed();
                        self.modal.feed_mode = Some(mode);
                    }
                }
                MCode::ForgetRotary => {
                    self.position.axes[3..].fill(None);
                    self.position.foreign_deg = None;
                }
                MCode::Elsewhere => self.this_block.moves_elsewhere = true,
                MCode::RestoresModes => self.block.odd_code = true,
                MCode::ExtruderAbsolute => self.modal.relative_extruder = false,
                MCode::ExtruderRelative => self.modal.relative_extruder = true,
            }
        }
        (ends, called)
    }
}
