//! How programs of tests are set up: in millimetres unless they say otherwise, work offset and tool length stated.

use trunnion::kinematics::Setup;
use trunnion::process::ProgramSetup;

/// Work offset and tool length zero.
pub fn at_zero() -> ProgramSetup {
    in_mm(&Setup::default())
}

/// This work offset and this tool length.
pub fn in_mm(setup: &Setup) -> ProgramSetup {
    ProgramSetup::in_mm(setup)
}

/// The same for the tool with this number, in a program that may have several.
pub fn with_tool(number: u32) -> ProgramSetup {
    let mut setup = at_zero();
    setup.tools.number = Some(number);
    setup
}
