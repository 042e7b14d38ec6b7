//! Programs with tilted planes on a machine with location errors: the rotary words before a plane change, and the
//! control turns from the changed words to the plane.

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{LocationError, Machine, PlaneRule, PlaneSolution, Preset, RotaryLetter};
use trunnion::motion::Unfollowable;
use trunnion::process::{CompensationParameters, Fault, LineFaultKind};

use super::one_pass::{Outcome, run};
use crate::models::displaced::{errors, with_errors};
use crate::models::set_ups::in_mm;

fn tables(errors: [LocationError; 2]) -> Machine {
    let preset = Preset::by_id("ac-table").expect("a preset");
    let rule = PlaneSolution { rule: PlaneRule::Shortest, axis: Some(RotaryLetter::A) };
    let nominal = Machine::new(preset.parts()).expect("a machine");
    with_errors(&nominal, errors).with_plane_solution(Some(rule))
}

fn posted(errors: [LocationError; 2], text: &str) -> Result<Outcome, Fault> {
    let program = in_mm(&Setup::default());
    let parameters = CompensationParameters { location_errors: true, ..CompensationParameters::new(program) };
    run(&tables(errors), &parameters, text)
}

/// The words of the blocks that state this letter, by line.
fn words(text: &str, letter: char) -> Vec<(usize, f64)> {
    let word = |line: &str| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse().ok());
    text.lines().enumerate().filter_map(|(line, text)| Some((line + 1, word(text)?))).collect()
}

/// A plane across the axis of C does not turn C: it stays at the changed word. After the plane C keeps its correction.
#[test]
fn an_axis_that_stays_in_a_plane_keeps_its_changed_word() {
    let text = "G90 G21 G94 G17 G54\nG0 X0.0000 Y0.0000 Z50.0000 A-30.0000 C40.0000\nG1 X10.0000 F500\n\
                G68.2 X5 Y0 Z10 I0 J0 K0\nG53.1\nG0 X1.0000 Y2.0000 Z30.0000\nG1 Z3.0000 F400\nX8.0000\n\
                G2 X10.0000 I1.0000 J0.0000\nG0 Z50.0000\nG69\nG0 X1.0000 Y2.0000 Z80.0000\nG1 C50.0000 F900\nM30\n";
    let (output, report, _) = posted(errors(), text).expect("a program");
    let (source, written): (Vec<&str>, Vec<&str>) = (text.lines().collect(), output.lines().collect());
    // The stamp is a line of its own.
    let stamp = written.iter().position(|line| !source.contains(line) && line.contains("trunnion"));
    let lines: Vec<&str> =
        written.iter().enumerate().filter(|(k, _)| Some(*k) != stamp).map(|(_, line)| *line).collect();
    assert_eq!(lines.len(), source.len(), "{output}");
    assert_eq!(lines[3..11], source[3..11], "{output}");
    let c = words(&lines.join("\n"), 'C');
    let corrected = c[0].1 - 40.0;
    assert!(c[0].0 == 2 && corrected.abs() > 1e-3, "{output}");
    // C turns on from the word at which it has stayed, by the same correction: the tool is upright.
    let last = c.last().expect("a word").1 - 50.0;
    assert!((last - corrected).abs() < 1.01e-4, "{output}");
    assert!(report.location_errors.expect("a step").held_at_pole > 0);
}

/// A plane that turns C: afterwards C has no correction until the program turns it again.
#[test]
fn an_axis_that_the_plane_turns_is_where_the_plane_puts_it() {
    let text = "G90 G21 G94 G17 G54\nG0 X0.0000 Y0.0000 Z50.0000 A-30.0000 C40.0000\nG1 X10.0000 F500\n\
                G68.2 X5 Y0 Z10 I50 J20 K0\nG53.1\nG69\nG0 X1.0000 Y2.0000 Z80.0000\n\
                G68.2 X5 Y0 Z10 I50 J20 K0\nG53.1\nG0 X1.0000 Y2.0000 Z30.0000\nG1 Z3.0000 F400\nG69\nM30\n";
    let (output, _, _) = posted(errors(), text).expect("a program");
    let lines: Vec<&str> = output.lines().filter(|line| !line.contains("trunnion")).collect();
    let source: Vec<&str> = text.lines().collect();
    assert_eq!((&lines[3..6], &lines[7..]), (&source[3..6], &source[7..]), "{output}");
    // Before the plane and after it the words point the tool of the real machine.
    for line in [1, 6] {
        assert!(lines[line].contains('A') && lines[line].contains('C'), "{output}");
        assert_ne!(lines[line], source[line]);
    }
}

/// From here both positions on the plane are nearly as near for A, and the location errors turn A to one side. If the
/// control then takes another position than before, the program is refused with the line of the turn.
#[test]
fn a_plane_to_which_the_control_turns_otherwise_is_refused() {
    let program = |a: &str| {
        format!(
            "G90 G21 G94 G17 G54\nG0 X0.0000 Y0.0000 Z50.0000 A{a} C90.0000\nG68.2 X0 Y0 Z0 I90 J30 K0\nG53.1\n\
             G0 X1.0000 Y2.0000 Z30.0000\nG1 Z3.0000 F400\nG69\nM30\n"
        )
    };
    // The table C leans by a turn about X, so A turns by this much to point the tool as meant.
    let lean = LocationError { rotation_rad: Vec3::new(8.1e-5, 0.0, 0.0), ..LocationError::default() };
    let tilted = [LocationError::default(), lean];
    let mut refused = 0;
    for a in ["0.00001", "-0.00001"] {
        match posted(tilted, &program(a)) {
            Ok((output, ..)) => {
                assert!(output.contains("G0 X1.0000 Y2.0000 Z30.0000\nG1 Z3.0000 F400\n"), "{output}");
            }
            Err(Fault::Lines(faults)) => {
                let first = &faults.kept[0];
                let undecided = LineFaultKind::NotMovable(Unfollowable::PlaneSolution);
                assert!((4..=5).contains(&first.line) && first.kind == undecided, "{faults:?}");
                refused += 1;
            }
            Err(other) => assert!(matches!(other, Fault::Lines(_)), "{other:?}"),
        }
    }
    assert_eq!(refused, 1, "A turns to the same side both times");
}
