//! Zeros that programs of RS274/NGC controls write: the tip stands where origin, turn, shift and words place it.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at the first surprise, helpers included"
)]

use std::collections::BTreeMap;
use std::sync::Arc;

use proptest::prelude::*;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, MachineCoordinates, Preset};
use trunnion::motion::{WorkOffset, WorkOffsets};
use trunnion::process::{Interpreted, InterpretedMotion, ProgramSetup, StartPosition};
use trunnion::program::Dialect;

use crate::models::told::all_told;

/// Rounding of double precision at a few hundred millimetres [mm].
const ROUNDING_MM: f64 = 1e-9;
const ZERO_MM: [f64; 3] = [12.5, -7.25, 640.0];
const G54_MM: [f64; 3] = [70.0, -40.0, 95.0];
const G55_MM: [f64; 3] = [-110.0, 35.5, 60.25];

fn machine() -> Machine {
    let coordinates = MachineCoordinates {
        zero_mm: ZERO_MM,
        length_counts: Some(false),
        references: vec![[Some(0.0); 5]],
        ..MachineCoordinates::default()
    };
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    machine.with_machine_coordinates(Some(coordinates)).with_rs274_control(true)
}

fn told(machine: &Machine, text: &str) -> Vec<Interpreted> {
    told_with(0.0, machine, text)
}

/// With a tool of this length.
fn told_with(tool_length_mm: f64, machine: &Machine, text: &str) -> Vec<Interpreted> {
    let named = [("G54", G54_MM), ("G55", G55_MM)];
    let named_mm = BTreeMap::from(named.map(|(name, mm)| (WorkOffset::from_name(name).unwrap(), mm)));
    let program = ProgramSetup {
        dialect: Some(Dialect::Iso),
        apply_errors: false,
        work_offsets: Arc::new(WorkOffsets { only_mm: Some(G54_MM), named_mm, ..WorkOffsets::default() }),
        start: StartPosition { linear_mm: [Some(0.0); 3], rotary_deg: [Some(0.0); 2] },
        ..ProgramSetup::in_mm(&Setup { tool_length_mm, ..Setup::default() })
    };
    all_told(machine, &program, text)
}

fn followed(text: &str) -> Vec<InterpretedMotion> {
    let told = told(&machine(), text).into_iter().map(|told| match told {
        Interpreted::Motion(motion) => motion,
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    told.collect()
}

fn assert_at(text: &str, motion: &InterpretedMotion, stated_mm: [f64; 3], machine_mm: [f64; 3]) {
    // Tips count in the work offset as it was stated.
    let tip_mm = motion.tip_mm.unwrap_or_else(|| panic!("{text}\nline {}: no tip", motion.line));
    for k in 0..3 {
        let found_mm = tip_mm[k] + stated_mm[k] - ZERO_MM[k];
        assert!(
            (found_mm - machine_mm[k]).abs() < ROUNDING_MM,
            "{text}\nline {}: axis {k} at {found_mm}, not {machine_mm:?}",
            motion.line
        );
    }
}

/// `origin + Rz(turn) · (shift + words)`
fn place(origin: [f64; 3], turn_deg: f64, shift: [f64; 3], words: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let [x, y, z]: [f64; 3] = std::array::from_fn(|k| shift[k] + words[k]);
    [origin[0] + cos * x - sin * y, origin[1] + sin * x + cos * y, origin[2] + z]
}

fn triple() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-400i32..400).prop_map(|at| at.map(|mm| f64::from(mm) / 8.0))
}

proptest! {
    #[test]
    fn words_count_from_the_origin_the_turn_and_the_shift_that_the_program_writes(
        origin in triple(), second in triple(), turn in -180i32..180, here in triple(), to in triple(), shifted in triple(),
    ) {
        let turn_deg = f64::from(turn);
        let words = |[x, y, z]: [f64; 3]| format!("X{x:.3} Y{y:.3} Z{z:.3}");
        let text = format!(
            "G90 G21 G54\nG10 L2 P1 {} R{turn}\nG10 L2 P2 {}\nG0 {}\nG92 {}\nG1 {} F100\nG91 G1 X1.\nG90\nG55\nG1 X3.\nG92.1\nG1 X3.\n\
             G53 G0 {}\nG54\nG0 X5.\nM2\n",
            words(origin), words(second), words(here), words(shifted), words(to), words(second),
        );
        let motions = followed(&text);
        prop_assert_eq!(motions.len(), 7);
        let none = [0.0; 3];
        assert_at(&text, &motions[0], G54_MM, place(origin, turn_deg, none, here));
        // G92 names the present place anew.
        let shift = std::array::from_fn(|k| here[k] - shifted[k]);
        assert_at(&text, &motions[1], G54_MM, place(origin, turn_deg, shift, to));
        let moved = place(origin, turn_deg, shift, [to[0] + 1.0, to[1], to[2]]);
        assert_at(&text, &motions[2], G54_MM, moved);
        // The axes stay where they are when another offset is selected: only X moves.
        assert_at(&text, &motions[3], G55_MM, [second[0] + shift[0] + 3.0, moved[1], moved[2]]);
        assert_at(&text, &motions[4], G55_MM, [second[0] + 3.0, moved[1], moved[2]]);
        // Whatever the zeros are.
        assert_at(&text, &motions[5], G55_MM, second);
        // Along the turned axis.
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let arm = [second[0] - origin[0], second[1] - origin[1]];
        let across = cos * arm[1] - sin * arm[0];
        assert_at(&text, &motions[6], G54_MM, place(origin, turn_deg, none, [5.0, across, second[2] - origin[2]]));
    }

    #[test]
    fn the_present_place_gets_the_words_that_the_program_writes(origin in triple(), turn in -180i32..180, here in triple(), named in triple()) {
        let words = |[x, y, z]: [f64; 3]| format!("X{x:.3} Y{y:.3} Z{z:.3}");
        let text = format!(
            "G90 G21 G54\nG10 L2 P1 {} R{turn}\nG0 {}\nG10 L20 P1 X{:.3} Z{:.3}\nG1 X{:.3} Z{:.3} F100\nG1 Y0.\nM2\n",
            words(origin), words(here), named[0], named[2], named[0], named[2],
        );
        let motions = followed(&text);
        let stands = place(origin, f64::from(turn), [0.0; 3], here);
        assert_at(&text, &motions[1], G54_MM, stands);
        let (sin, cos) = f64::from(turn).to_radians().sin_cos();
        assert_at(&text, &motions[2], G54_MM, [stands[0] + sin * here[1], stands[1] - cos * here[1], stands[2]]);
    }
}

#[test]
fn g28_1_stores_the_place_to_which_g28_goes() {
    let text = "G90 G21 G54\nG10 L2 P1 X1. Y2. Z3. R30.\nG0 X10. Y20. Z5. A10. C0.\nA0.\nG28.1\nG55\nG0 X0. Y0. Z0. C90.\nC0.\nG28\nM2\n";
    let motions = followed(text);
    let stored = place([1.0, 2.0, 3.0], 30.0, [0.0; 3], [10.0, 20.0, 5.0]);
    assert_at(text, motions.last().unwrap(), G55_MM, stored);
    // Elsewhere the code is not known.
    let bare = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let left = told(&bare, "G90 G21 G54\nG0 X0. Y0. Z0. A0. C0.\nG28.1\nG0 X1.\n");
    assert!(matches!(left[1], Interpreted::LeftAlone { .. }), "{left:?}");
}

#[test]
fn zeros_that_are_not_certain_leave_the_tip_unknown() {
    let begin = "G90 G21 G54\nG10 L2 P1 X1. Y2. Z3.\nG0 X0. Y0. Z0. A0. C0.\n";
    let tip_after = |text: &str, machine: &Machine| {
        let text = format!("{begin}{text}G0 X1. Y1. Z1. A0. C0.\n");
        match told(machine, &text).last() {
            Some(Interpreted::Motion(motion)) => motion.tip_mm.is_some(),
            _ => false,
        }
    };
    assert!(tip_after("", &machine()), "the reference of the cases below");
    for text in [
        "/G10 L2 P1 X5.\n",
        "G10 L2 P1 X#500\n",
        "G10 L2 P#500 X5.\n",
        "G10 L2 P1 A5.\n",
        "G92 A5.\n",
        "G52 X5.\n",
        "G92 X5.\nG52 X0.\n",
        "G10 L2 P1 R45.\n/G10 L2 P1 X5.\n",
        "G10 L2 P1 R45.\n#5221=7\n",
        "M6 T1\nG92 X5.\n",
        "G92 X5.\nG92.3\n",
        "#5221=7\n",
        "G92 X5.\nG10 L20 P1 X0.\n",
        "G10 L20 P2 X0.\nG55\n",
        "G92 X5.\nG68 X0. Y0. R30.\nG69\n",
    ] {
        assert!(!tip_after(text, &machine()), "{text}");
    }
    let silent = machine().with_rs274_control(false);
    assert!(!tip_after("", &silent), "no one says how the control reads G10");
}

/// Controls add an offset of their own to the origins that a program writes.
const EXTERNAL_MM: [f64; 3] = [0.5, -1.25, 2.0];

fn other_control() -> Machine {
    let stated = machine().machine_coordinates().unwrap().clone();
    let coordinates = MachineCoordinates { external_mm: Some(EXTERNAL_MM), ..stated };
    machine().with_rs274_control(false).with_machine_coordinates(Some(coordinates))
}

#[test]
fn on_every_control_g10_l2_writes_an_origin_beside_the_stated_external_offset() {
    let text = "G90 G21 G54\nG10 L2 P1 X-269.39 Y-254.65 Z-689.\nG10 L2 P2 X10.\n#501=1\nG10 L2 P#501 Y-200.\nG0 X1. Y2. Z3. A0. C0.\nG53 G0 Z0.\nG53 X-508. Y0.\nG55\nG0 X4. Y5. Z6.\nM30\n";
    let motions: Vec<_> = told(&other_control(), text)
        .into_iter()
        .map(|told| match told {
            Interpreted::Motion(motion) => motion,
            Interpreted::LeftAlone { line, reason, .. } => panic!("line {line}: {reason}"),
        })
        .collect();
    let with_external = |at: [f64; 3]| std::array::from_fn(|k| EXTERNAL_MM[k] + at[k]);
    assert_at(text, &motions[0], G54_MM, with_external([-268.39, -198.0, -686.0]));
    // Places of the machine are the same whatever the zeros are.
    let [x, y, _] = with_external([-268.39, -198.0, 0.0]);
    assert_at(text, &motions[1], G54_MM, [x, y, 0.0]);
    assert_at(text, &motions[2], G54_MM, [-508.0, 0.0, 0.0]);
    // What the program does not write is as it was stated.
    let [_, y, z]: [f64; 3] = std::array::from_fn(|k| G55_MM[k] - ZERO_MM[k]);
    assert_at(text, &motions[3], G55_MM, [EXTERNAL_MM[0] + 14.0, y + 5.0, z + 6.0]);
}

#[test]
fn what_controls_read_differently_in_g10_leaves_the_tip_unknown() {
    let begin = "G90 G21 G54\nG0 X0. Y0. Z0. A0. C0.\n";
    let tip_after = |text: &str| {
        let text = format!("{begin}{text}G90 G0 X1. Y1. Z1. A0. C0.\n");
        match told(&other_control(), &text).last() {
            Some(Interpreted::Motion(motion)) => motion.tip_mm.is_some(),
            _ => false,
        }
    };
    assert!(tip_after("G10 L2 P1 X5. Y6. Z7.\n"), "the reference of the cases below");
    for text in [
        "G91 G10 L2 P1 X5.\n",
        "G10 G91 L2 P1 X5.\n",
        "G10 L2 P1 X5. G91\n",
        "G10 L2 P0 X5.\n",
        "G10 L2 P7 X5.\n",
        "G10 L2 P1 X5. R30.\n",
        "G10 L20 P1 X5.\n",
        "G10 L2 P1 C5.\n",
        "G10 L2 P1 X5.\nG92 X5.\n",
        "G10 L2 P1 X5.\nG52 X5.\n",
        "/G10 L2 P1 X5.\n",
    ] {
        assert!(!tip_after(text), "{text}");
    }
}

#[test]
fn a_height_that_the_program_writes_needs_the_length_of_the_tool() {
    let begin = "G90 G21 G54\nG10 L2 P1 X1. Y2. Z3.\n";
    let found = told_with(
        80.0,
        &machine(),
        &format!("{begin}G0 X0. Y0. Z5.\nG43 H1 X0. Y0. Z5.\nG49\nX0. Y0. Z8.\n"),
    );
    let tips: Vec<_> = found
        .iter()
        .map(|told| match told {
            Interpreted::Motion(motion) => motion.tip_mm.is_some(),
            Interpreted::LeftAlone { .. } => false,
        })
        .collect();
    assert_eq!(tips, [false, true, false], "{found:?}");
    let text = format!("{begin}G43 H1\nG0 X0. Y0. Z5.\n");
    let found = told_with(80.0, &machine(), &text);
    let Some(Interpreted::Motion(motion)) = found.last() else { panic!("{found:?}") };
    assert_at(&text, motion, G54_MM, [1.0, 2.0, 8.0]);
}
