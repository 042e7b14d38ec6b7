//! What all steps of a program work with.

use crate::machine::Machine;
use crate::process::set_up::Stop;
use crate::side_by_side::SideBySide;

/// The resources that all steps share.
#[derive(Clone, Copy)]
pub(in crate::process) struct Resources<'a> {
    pub(in crate::process) machine: &'a Machine,
    pub(in crate::process) parts: &'a dyn SideBySide,
    pub(in crate::process) stop: &'a Stop<'a>,
}
