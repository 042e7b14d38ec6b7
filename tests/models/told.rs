//! What an interpretation tells of a program, all of it in memory.

use std::ops::ControlFlow;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset};
use trunnion::process::{Interpreted, ProgramSetup, interpret_program};
use trunnion::program::Dialect;

/// The nominal machine of the preset `ac-table`.
pub fn ac_table() -> Machine {
    Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine")
}

/// A program in millimetres without work offset, on the nominal machine.
pub fn nominal(dialect: Dialect) -> ProgramSetup {
    ProgramSetup { dialect: Some(dialect), apply_errors: false, ..ProgramSetup::in_mm(&Setup::default()) }
}

/// Everything that the interpretation tells of a text.
pub fn all_told(machine: &Machine, program: &ProgramSetup, text: &str) -> Vec<Interpreted> {
    let mut all = Vec::new();
    let mut take = |told: &Interpreted| {
        all.push(*told);
        Ok(())
    };
    let source = text.as_bytes().to_vec();
    interpret_program(machine, program, &source, &mut take, &|| ControlFlow::Continue(())).expect(text);
    all
}
