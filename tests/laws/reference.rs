//! Returns to reference positions and motions in machine coordinates: what is known before, during and after them.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset};
use trunnion::motion::Unfollowable;
use trunnion::process::{Interpreted, ProgramSetup, interpret_program};
use trunnion::program::Dialect;

/// X Y Z after every motion, and the reason of those that are left alone.
fn told(dialect: Dialect, text: &str) -> Vec<Result<[Option<f64>; 3], Unfollowable>> {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let program = ProgramSetup {
        dialect: Some(dialect),
        apply_errors: false,
        ..ProgramSetup::in_mm(&Setup::default())
    };
    let mut all = Vec::new();
    let mut take = |told: &Interpreted| {
        all.push(match told {
            Interpreted::Motion(motion) => Ok([motion.joints[0], motion.joints[1], motion.joints[2]]),
            Interpreted::LeftAlone { reason, .. } => Err(*reason),
        });
        Ok(())
    };
    let source = text.as_bytes().to_vec();
    interpret_program(&machine, &program, &source, &mut take, &|| ControlFlow::Continue(())).unwrap();
    all
}

const AWAY: Result<[Option<f64>; 3], Unfollowable> = Err(Unfollowable::Reference);

fn at(x: f64, y: f64, z: f64) -> [Option<f64>; 3] {
    [Some(x), Some(y), Some(z)]
}

#[test]
fn a_return_goes_through_the_point_of_its_words_and_loses_its_axes() {
    let start = "G90 G17 G0 X1 Y2 Z3 A0 C0\n";
    let told = |blocks: &str| told(Dialect::Iso, &format!("{start}{blocks}"))[1..].to_vec();
    let without_z = |x: f64, y: f64| Ok([Some(x), Some(y), None]);
    assert_eq!(
        told("G28 Z39\nX5\nZ7\n"),
        [Ok(at(1.0, 2.0, 39.0)), AWAY, without_z(5.0, 2.0), Ok(at(5.0, 2.0, 7.0))]
    );
    assert_eq!(told("G91 G28 Z10\nG90 X5\n"), [Ok(at(1.0, 2.0, 13.0)), AWAY, without_z(5.0, 2.0)]);
    assert_eq!(told("G30 P2 X8 Y9\nX1 Y1\n"), [Ok(at(8.0, 9.0, 3.0)), AWAY, Ok(at(1.0, 1.0, 3.0))]);
    // Zeros alone are where a printer goes home.
    assert_eq!(told("G28 X0 Z0\nX5 Z5\n"), [AWAY, Ok(at(5.0, 2.0, 5.0))]);
    assert_eq!(told("G28 X0 Z200 F5000\nX5 Z5\n"), [AWAY, Ok(at(5.0, 2.0, 5.0))]);
    // From where the axes are.
    assert_eq!(told("G91 G28 Z0\nG90 X5\n"), [AWAY, without_z(5.0, 2.0)]);
    assert_eq!(told("G28 Z3\nX5\n"), [AWAY, without_z(5.0, 2.0)]);
    assert_eq!(told("G28\nX5\n"), [AWAY, Ok([Some(5.0), None, None])]);
    // The point is not certain.
    assert_eq!(told("G28 Z#500\nX5\n"), [AWAY, without_z(5.0, 2.0)]);
    assert_eq!(told("G28 Z39 U5\n"), [AWAY]);
    assert_eq!(told("G28 Z50\nG91 G28 Z10\n"), [Ok(at(1.0, 2.0, 50.0)), AWAY, AWAY]);
    assert_eq!(told("G68 X0 Y0 R30\nG28 Z39\n"), [Err(Unfollowable::Transformation), AWAY]);
}

#[test]
fn other_controls_go_to_their_reference_positions_directly() {
    let told = told(Dialect::Siemens, "G90 G0 X1 Y2 Z3 A0 C0\nG74 Z1=0\nG0 X5\n");
    assert!(told[1..].iter().all(|told| *told != Ok(at(1.0, 2.0, 0.0))), "{told:?}");
}

#[test]
fn a_motion_in_machine_coordinates_loses_its_axes_until_they_are_named() {
    let start = "G90 G17 G0 X1 Y2 Z3 A0 C0\n";
    let machine = Err(Unfollowable::MachineCoordinates);
    let found = told(Dialect::Iso, &format!("{start}G53 G0 Z0\nX5\nZ7\n"));
    assert_eq!(found[1..], [machine, Ok([Some(5.0), Some(2.0), None]), Ok(at(5.0, 2.0, 7.0))]);
    let found = told(Dialect::Heidenhain, "L X+1 Y+2 Z+3 R0 FMAX\nL Z-1 R0 FMAX M91\nL X+5\nL Z+7\n");
    assert_eq!(found[1..], [machine, Ok([Some(5.0), Some(2.0), None]), Ok(at(5.0, 2.0, 7.0))]);
}
