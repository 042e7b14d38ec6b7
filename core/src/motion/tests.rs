//! Unusual spellings and modes, one test for each habit of programs.

use super::*;
use crate::machine::{Machine, Preset};
use crate::program::{Address, Batch, DiagnosticCode, Diagnostics, ReadLimits, Reader, Severity};
use crate::units::LengthUnit;

/// A and C tables through the origin, no limits.
fn machine() -> Machine {
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    parts.rotary_axes[0].travel_deg = None;
    Machine::new(parts).unwrap()
}

pub(super) fn run_with(text: &str, options: InterpreterOptions) -> (Vec<Motion>, Diagnostics) {
    let (_, motions, diagnostics) = interpreted(text, options);
    (motions, diagnostics)
}

pub(super) fn interpreted(
    text: &str,
    options: InterpreterOptions,
) -> (Interpreter, Vec<Motion>, Diagnostics) {
    let mut reader = Reader::new(None, ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let mut interpreter = Interpreter::new(&machine(), options);
    let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
    while reader.next_batch(&mut batch).unwrap() {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    (interpreter, motions, diagnostics)
}

pub(super) fn run(text: &str) -> Vec<Motion> {
    run_with(text, InterpreterOptions::in_mm()).0
}

/// The motions after a line that makes all five axes known at zero.
pub(super) fn run_from_zero(text: &str) -> Vec<Motion> {
    run(&format!("G0 X0 Y0 Z0 A0 C0\n{text}")).split_off(1)
}

pub(super) fn end(motion: &Motion) -> [f64; 5] {
    let end = motion.end.unwrap();
    let [x, y, z] = end.linear_mm;
    [x, y, z, end.rotary_deg[0], end.rotary_deg[1]]
}

#[test]
fn a_start_is_known_once_all_five_axes_are() {
    let motions = run("G0 X1 Y2\nZ3 A4\nC5\nG1 X6 F100\n");
    let known: Vec<_> = motions.iter().map(|motion| (motion.start.is_some(), motion.end.is_some())).collect();
    assert_eq!(known, [(false, false), (false, false), (false, true), (true, true)]);
    assert_eq!(motions[2].kind, MotionKind::Rapid);
    assert_eq!(motions[3].kind, MotionKind::Linear);
    assert!((end(&motions[3])[0] - 6.0).abs() < 1e-15);
}

#[test]
fn inches_become_millimetres_and_degrees_stay() {
    let motions = run_from_zero("G20 G1 X1. A10. F2.5\nG21 X1. F100\n");
    assert!((end(&motions[0])[0] - 25.4).abs() < 1e-12);
    assert!((end(&motions[0])[3] - 10.0).abs() < 1e-15);
    assert_eq!(motions[0].feed.value, Some(2.5 * 25.4));
    assert!((motions[0].feed.raw - 2.5).abs() < 1e-15);
    assert_eq!(motions[0].feed.decimals, 1);
    assert!((motions[1].mm_per_unit - 1.0).abs() < 1e-15);
    assert!((end(&motions[1])[0] - 1.0).abs() < 1e-15);
}

#[test]
fn incremental_words_count_from_the_position_before() {
    let motions = run_from_zero("G91 G1 X1 C-200 F1\nX2 C-200\nG90 X2\n");
    assert!(motions[1].incremental && !motions[2].incremental);
    assert_eq!(end(&motions[1]), [3.0, 0.0, 0.0, 0.0, -400.0]);
    assert_eq!(end(&motions[2]), [2.0, 0.0, 0.0, 0.0, -400.0]);
}

#[test]
fn tool_centre_point_switches_lose_the_linear_axes_but_for_words_of_the_block() {
    let motions = run_from_zero("G1 X1 F100\nG43.4 Z2 H8\nX1 Y1\nX2\nG49\nX3\nY1 Z1\n");
    let seen: Vec<_> = motions.iter().map(|motion| (motion.interpolation, motion.end.is_some())).collect();
    assert_eq!(
        seen,
        [
            (Interpolation::Machine, true),
            (Interpolation::Tcp, false),
            (Interpolation::Tcp, true),
            (Interpolation::Tcp, true),
            (Interpolation::Machine, false),
            (Interpolation::Machine, true)
        ]
    );
    assert!(motions[2].start.is_none() && motions[3].start.is_some());
    assert!(motions.iter().all(|motion| motion.unfollowable.is_none()));
}

#[test]
fn another_length_behind_the_first_moves_the_tip() {
    let ends =
        |text: &str| -> Vec<bool> { run_from_zero(text).iter().map(|motion| motion.end.is_some()).collect() };
    // Z is unknown until the program states it.
    assert_eq!(ends("G43 H1 Z5\nH2\nX1\nX2 Z5\nX3\n"), [true, false, true, true]);
    assert_eq!(ends("G43 H1 Z5\nX1 H2\nZ5 H3\n"), [true, false, true]);
    assert_eq!(ends("G43 H1 Z5\nH1\nX1\nH#1\nX2\n"), [true, true, false]);
    assert_eq!(ends("G43 H1 Z5\n/H2\nX1\nZ5\nH2\nX1\n"), [true, false, true, false]);
    // With a tilted tool every linear axis is unknown.
    assert_eq!(ends("G43.4 H1 X0 Y0 Z5\nH2\nZ5\nX1 Y1\n"), [true, false, true]);
    // Outside the plane G17 the length may count along another axis.
    assert_eq!(ends("G18 G43 H1 X0 Y0 Z5\nH2\nZ5\n"), [true, false]);
}

#[test]
fn plain_length_compensation_loses_z_only() {
    let motions = run_from_zero("G43 H1\nX1\nZ5\n");
    assert!(motions[0].end.is_none());
    assert_eq!(end(&motions[1]), [1.0, 0.0, 5.0, 0.0, 0.0]);
}

#[test]
fn g53_is_for_one_block() {
    let motions = run_from_zero("G53 G0 Z0\nX1\nZ5\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::MachineCoordinates));
    assert_eq!((motions[0].start, motions[0].end, motions[1].end), (None, None, None));
    assert_eq!(motions[1].unfollowable, None);
    assert_eq!(end(&motions[2]), [1.0, 0.0, 5.0, 0.0, 0.0]);
    assert!(run_from_zero("G53\n").is_empty());
}

#[test]
fn reference_returns_lose_the_axes_they_name() {
    let motions = run_from_zero("G91 G28 Z0\nG90 G0 X1\nZ1\nG28\nX1\n");
    assert_eq!(motions[0].kind, MotionKind::Opaque);
    assert!(motions[1].end.is_none() && motions[2].end.is_some());
    assert_eq!(motions[3].unfollowable, Some(Unfollowable::Reference));
    assert!(motions[4].end.is_none());
}

#[test]
fn a_start_that_is_stated_is_where_the_axes_stand_until_words_say_otherwise() {
    let start = [None, None, Some(50.0), Some(0.0), Some(0.0)];
    let options = InterpreterOptions { start, ..InterpreterOptions::in_mm() };
    let (motions, _) = run_with("G54 G17\nG0 X1 Y2\nG1 X2 F100\n", options.clone());
    assert_eq!(end(&motions[0]), [1.0, 2.0, 50.0, 0.0, 0.0]);
    assert!(motions[1].start.is_some());
    let (motions, _) = run_with("G0 X1 Y2\nG55 X1 Y2\n", options);
    assert!(motions[1].end.is_none(), "the position of G55 is not stated");
}

#[test]
fn a_length_needs_a_unit_that_somebody_states() {
    let unstated = InterpreterOptions::default();
    let refused = |text: &str, options: &InterpreterOptions| {
        let (_, diagnostics) = run_with(text, options.clone());
        let unit =
            diagnostics.refusals().find(|found| matches!(found.code, DiagnosticCode::UnitUnknown { .. }));
        unit.map(|found| found.line)
    };
    for (text, line) in [
        ("G90\nG0 X1 Y2\nX3\n", Some(2)),
        ("G20 G0 X1\n", None),
        ("G0 X1 G21\n", None),
        ("G91 G28 Z0\nG53 G0 Z0\nG21\nX1\n", None),
        ("G91 G28 Z5\n", Some(1)),
        ("G4 X2\nS100 M3\nG0 A30 C20\nF500\n", None),
        ("G0 X0\n", Some(1)),
        ("G2 A1 I5\n", Some(1)),
    ] {
        assert_eq!(refused(text, &unstated), line, "{text}");
        assert_eq!(refused(text, &InterpreterOptions::in_mm()), None, "{text}");
    }
    let inch = InterpreterOptions { unit: Some(LengthUnit::Inch), ..unstated };
    let (motions, _) = run_with("G0 X1 Y2 Z3 A0 C0\n", inch.clone());
    assert_eq!(end(&motions[0]), [25.4, 50.8, 3.0 * 25.4, 0.0, 0.0]);
    let (interpreter, motions, _) = interpreted("G90\nG21 G0 X1 Y2 Z3 A0 C0\n", inch);
    assert_eq!(end(&motions[0]), [1.0, 2.0, 3.0, 0.0, 0.0]);
    assert_eq!(interpreter.unit_disagrees_at(), Some(2));
    assert!(interpreter.states_unit() && interpreter.unit() == Some(LengthUnit::Millimetre));
}

#[test]
fn g92_loses_the_position_but_not_for_the_extruder() {
    let motions = run_from_zero("G1 X1 E1 F1\nG92 E0\nX2 E1.5\nG92 X0\nX3\n");
    assert_eq!(motions[0].extra, Some(Extra { start: None, end: 1.0 }));
    assert_eq!(motions[1].extra, Some(Extra { start: Some(0.0), end: 1.5 }));
    assert_eq!(motions[1].decimals.extra, 1);
    assert!(motions[1].start.is_some() && !motions[1].offset_changed);
    assert!(motions[2].end.is_none() && motions[2].offset_changed);
}

#[test]
fn calls_leave_nothing_known() {
    for call in ["M98 P1000", "G65 P9000 X1", "o<name> call [1]", "o100 call"] {
        let text = format!("{call}\nX1\nG90 G21 G94 G40 G49 G69 G54 G1 X1 Y1 Z1 A1 C1\nX2 F100\nX3\n");
        let motions = run_from_zero(&text);
        assert_eq!(
            (motions[0].kind, motions[0].unfollowable),
            (MotionKind::Opaque, Some(Unfollowable::Call)),
            "{call}"
        );
        assert_eq!(motions[1].unfollowable, Some(Unfollowable::ModeUnknown { group: ModalGroup::Motion }));
        assert!(motions[2].start.is_none() && motions[3].start.is_some());
        assert_eq!(motions[3].unfollowable, None);
        assert_eq!(motions[4].feed.value, Some(100.0));
    }
    let motions = run_from_zero("M98 P1\nG1 G90 G21 G94 G40 G69 X1\nG49 X1\n");
    assert_eq!(motions[1].unfollowable, Some(Unfollowable::ModeUnknown { group: ModalGroup::ToolLength }));
    assert_eq!(motions[2].unfollowable, None);
}

#[test]
fn cutter_compensation_and_transformations_are_not_followed() {
    for (on, off, reason) in [
        ("G41 D1", "G40", Unfollowable::CutterCompensation),
        ("G68 X0 Y0 R30", "G69", Unfollowable::Transformation),
        ("G68.2 X0 Y0 Z0 I0 J30 K0", "G69", Unfollowable::TiltedPlane),
        ("G51 X0 Y0 Z0 P2", "G50", Unfollowable::Transformation),
        ("G16", "G15", Unfollowable::Transformation),
        ("G66 P9000", "G67", Unfollowable::ModalCall),
    ] {
        let restored = "G0 G90 G21 G94 G40 G49 G69 G54 X1 Y1 Z1 A1 C1";
        let motions = run_from_zero(&format!("G1 F1\n{on}\nG0 G90 G21 G94 G49 X1\n{off}\n{restored}\nX2\n"));
        let during: Vec<_> = motions.iter().filter(|motion| motion.line == 4).collect();
        assert_eq!(during[0].unfollowable, Some(reason), "{on}");
        let after = motions.last().unwrap();
        assert_eq!((after.unfollowable, after.start.is_some()), (None, true), "{on}");
    }
}

#[test]
fn after_radius_compensation_the_tool_is_beside_its_place_until_both_axes_are_named() {
    let motions = run_from_zero("G1 F1 G41 D1 X1\nX2\nG40 X5 Y5\nX6\n");
    assert_eq!((motions[2].unfollowable, motions[2].start), (None, None));
    assert_eq!(end(&motions[2]), [5.0, 5.0, 0.0, 0.0, 0.0]);
    assert!(motions[3].start.is_some());
    let motions = run_from_zero("G18 G1 F1 G42 D1 X1\nG40 Y5\nX6 Z1\nX7\n");
    assert_eq!([motions[1].end, motions[2].start], [None, None]);
    assert_eq!(end(&motions[3]), [7.0, 5.0, 1.0, 0.0, 0.0]);
    // Nothing was on.
    assert!(run_from_zero("G40 G1 F1 X1\n")[0].start.is_some());
}

#[test]
fn canned_cycles_last_until_g80() {
    let motions = run_from_zero("G81 X1 Z-5 R1 F1\nX2\nG80\nX3\nG0 X4\nZ1\nX5\n");
    assert!(motions[..2].iter().all(|motion| motion.unfollowable == Some(Unfollowable::CannedCycle)));
    // G0 was in force before the series.
    assert_eq!((motions[2].unfollowable, motions[2].kind), (None, MotionKind::Rapid));
    assert!(motions[3].end.is_none());
    let after_g1 = run_from_zero("G1 X0 F1\nG81 X1 Z-5 R1 F1\nG80\nX3\n");
    assert_eq!(after_g1[2].unfollowable, Some(Unfollowable::ModeUnknown { group: ModalGroup::Motion }));
    assert_eq!(end(&motions[5]), [5.0, 0.0, 1.0, 0.0, 0.0]);
    // A safety line's G80 changes nothing.
    assert_eq!(run_from_zero("G0 G17 G40 G80\nX1\n")[0].kind, MotionKind::Rapid);
}

#[test]
fn axis_words_of_a_dwell_are_seconds() {
    assert!(run_from_zero("G4 X2.\nG04 P100\nG10 L1 P1 Z5\n").is_empty());
    let motions = run_from_zero("G4 X2.\nY1\n");
    assert_eq!(end(&motions[0]), [0.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn values_that_cannot_be_seen_leave_the_axis_unknown() {
    let motions = run_from_zero("G1 X#1 F1\nY1\nX[#1*2]\nX3\nY-#<a>\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::Expression { address: Address::X }));
    assert!(motions[0].start.is_some() && motions[0].end.is_none());
    assert!(motions[1].end.is_none() && motions[1].unfollowable.is_none());
    assert!(motions[3].start.is_none() && motions[3].end.is_some());
    assert_eq!(motions[4].unfollowable, Some(Unfollowable::Expression { address: Address::Y }));
    // A value that the program has set is known.
    assert_eq!(end(&run_from_zero("#1 = 5\nX[#1*2]\n")[0])[0], 10.0);
    // A system parameter may be an offset.
    assert!(run_from_zero("#5221 = 1\nX1\n")[0].end.is_none());
    assert!(run_from_zero("#3000 = 1\nX1\n")[0].end.is_some());
}

#[test]
fn repeated_addresses_and_conflicting_codes_are_left_alone() {
    let (motions, diagnostics) =
        run_with("G0 X0 Y0 Z0 A0 C0\nX1 X2\nY1\nX1\nG0 G1 Y2\n", InterpreterOptions::in_mm());
    assert_eq!(motions[1].unfollowable, Some(Unfollowable::RepeatedAddress { address: Address::X }));
    assert!(motions[2].end.is_none() && motions[3].end.is_some());
    assert!(motions[4].unfollowable.is_some());
    assert_eq!((diagnostics.count(Severity::Warning), diagnostics.count(Severity::Refusal)), (1, 0));
    assert_eq!((diagnostics.kept()[0].line, diagnostics.kept()[0].column), (2, 4));
}

#[test]
fn blocks_the_operator_can_skip_leave_their_axes_unknown() {
    let motions = run_from_zero("G1 F1\n/X1\nY1\nX2\n/Z0\nX3\n/G91\nX1\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::BlockDelete));
    assert!(motions[1].end.is_none() && motions[2].end.is_some());
    // Z is at zero whether the block is skipped or not.
    assert!(motions[4].end.is_some());
    assert_eq!(motions[5].unfollowable, Some(Unfollowable::ModeUnknown { group: ModalGroup::Distance }));
    assert_eq!(run_from_zero("/M30\nX1\n").len(), 1);
}

#[test]
fn nothing_moves_behind_the_end() {
    let (motions, diagnostics) =
        run_with("%\nO1\nG0 X1\nX2 M30\nX3\nO2 sub\nbroken\n", InterpreterOptions::in_mm());
    assert_eq!(motions.len(), 2);
    assert_eq!(diagnostics.kept(), []);
    assert_eq!(run("%\nG0 X1\n%\nX2\n").len(), 1);
    assert_eq!(run("G0 X1\nM2\nX2\n").len(), 1);
}

#[test]
fn an_axis_the_machine_does_not_have_matters_when_it_changes() {
    let motions = run_from_zero("G1 X1 B5 F1\nX2 B5\nX3 B6\nX4\n");
    let seen: Vec<_> = motions.iter().map(|motion| motion.unfollowable.is_some()).collect();
    assert_eq!(seen, [true, false, true, false]);
}

#[test]
fn corners_change_both_their_neighbours() {
    let motions = run_from_zero("G1 X1 ,R2 F1\nY5\nX2\nX3 R1\nY1\n");
    let seen: Vec<_> =
        motions.iter().map(|motion| motion.unfollowable == Some(Unfollowable::Corner)).collect();
    assert_eq!(seen, [true, true, false, true, true]);
}

#[test]
fn arcs_end_at_their_words_and_full_circles_where_they_start() {
    let motions = run_from_zero("G2 X10 I5 F1\nI-5\nZ-1 I-5\nG3 X0 R5\n");
    assert!(motions.iter().all(|motion| motion.kind == MotionKind::Arc && motion.unfollowable.is_none()));
    assert_eq!(end(&motions[1]), [10.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(end(&motions[3]), [0.0, 0.0, -1.0, 0.0, 0.0]);
}

#[test]
fn decimals_are_those_of_the_block_or_else_of_what_stands() {
    let motions = run_from_zero("G1 X1.25 A1.5 F1\nY2\nC10.125\n");
    assert_eq!((motions[0].decimals.linear, motions[0].decimals.rotary), (2, 1));
    assert_eq!((motions[1].decimals.linear, motions[1].decimals.rotary), (0, 1));
    assert_eq!((motions[2].decimals.linear, motions[2].decimals.rotary), (2, 3));
    assert_eq!((motions[2].program_decimals.linear, motions[2].program_decimals.rotary), (2, 3));
}

#[test]
fn odd_spellings_mean_what_they_mean() {
    for text in [
        "g01x1.5y-.25z+.5a10c-3f100",
        "G 1 X 1.5 Y -.25 Z + .5 A\t10 C-3. F100",
        "N10 G1 (X9) X1.5 Y-0.25 Z00.5 A10.0 C-3 F100 ; X8",
        "N0010G01X1.500Y-.2500Z.5A10.C-3.F100.(END)",
        "/1 ; nothing\nG1X1.5Y-.25Z.5A10C-3F1E2.\rF100",
    ] {
        let motions = run(text);
        let [motion] = motions.as_slice() else { panic!("{text}: {motions:?}") };
        assert_eq!(end(motion), [1.5, -0.25, 0.5, 10.0, -3.0], "{text}");
    }
}

#[test]
fn smooth_modes_are_no_splines_and_splines_are() {
    let motions = run_from_zero("G05.1 Q1\nG05 P10000\nG08 P1\nG64 P.1\nG1 X1 F1\nG5.1 X1 I2\nX3\n");
    assert_eq!(motions[0].unfollowable, None);
    assert!(motions[1..].iter().all(|motion| motion.unfollowable == Some(Unfollowable::Spline)));
}

#[test]
fn rows_of_a_table_are_linear_motions() {
    let motions = run("x,y,z,a,c,f,nx,ny,nz\n1,2,3,4,5,600,0,0,1\n2,2,3,4,-5.5,,0,1,0\n");
    assert_eq!(motions.len(), 2);
    assert_eq!(motions[1].contact, ContactWords::Normal([0.0, 1.0, 0.0]));
    assert_eq!(motions[1].feed.value, Some(600.0));
    assert_eq!((motions[1].line, motions[1].block, motions[1].kind), (3, 2, MotionKind::Linear));
    assert!(motions[1].start.is_some() && motions[1].unfollowable.is_none());
}

#[test]
fn faults_have_line_and_column() {
    let (_, diagnostics) =
        run_with("G0 X1\nG0 X1.2.3\n  Y\nX1e400\nX2000000000\n[\n", InterpreterOptions::in_mm());
    let places: Vec<_> =
        diagnostics.refusals().map(|fault| (fault.line, fault.column, fault.code.name())).collect();
    assert_eq!(
        places,
        [
            (2, 8, "unexpected_text"),
            (3, 3, "missing_number"),
            (4, 1, "exponent"),
            (5, 1, "too_large"),
            (6, 1, "unexpected_text")
        ]
    );
    let spans: Vec<_> = diagnostics.refusals().map(|fault| (fault.span.start, fault.span.end)).collect();
    assert_eq!(spans[0], (13, 15));
}

#[test]
fn a_line_has_a_bounded_number_of_words() {
    let line = |words: usize| format!("G0 X1\n{}\nX2\n", "X1".repeat(words));
    let (motions, diagnostics) = run_with(&line(256), InterpreterOptions::in_mm());
    assert_eq!((motions.len(), diagnostics.count(Severity::Refusal)), (3, 0));
    assert_eq!(motions[1].unfollowable, Some(Unfollowable::RepeatedAddress { address: Address::X }));
    for text in [line(257), line(32_000), format!("G0 X1\nX1{}\nX2\n", ",R1".repeat(256))] {
        let (_, diagnostics) = run_with(&text, InterpreterOptions::in_mm());
        let refusals: Vec<_> = diagnostics.refusals().map(|fault| (fault.line, fault.code.name())).collect();
        assert_eq!(refusals, [(2, "too_many_words")]);
    }
}

#[test]
fn a_number_and_an_expression_for_one_address_are_two_words() {
    let motions = run_from_zero("G1 F1 X1 X#1\nX2\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::RepeatedAddress { address: Address::X }));
    assert!(motions[0].end.is_none());
}

#[test]
fn the_extruder_is_relative_in_g91() {
    let motions = run_from_zero("G1 X1 E1 F1\nG91 X1 E1\nX1\nG90 X5 E9\nX6 E10\n");
    let seen: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    assert_eq!(seen, [None, Some(Unfollowable::RelativeExtruder), None, None, None]);
    assert_eq!(motions[1].extra, Some(Extra { start: None, end: 1.0 }));
    // Only an absolute word states its value.
    assert_eq!(motions[3].extra, Some(Extra { start: None, end: 9.0 }));
    assert_eq!(motions[4].extra, Some(Extra { start: Some(9.0), end: 10.0 }));
}

#[test]
fn codes_for_one_block_are_never_divided() {
    for block in ["G53 X5", "G53 G1 X5", "G28 X5", "G30 X5", "G4 G1 X5", "G04 P1 G1 X5", "G92 X5", "G60 X5"] {
        let motions = run_from_zero(&format!("G1 X1 F1\n{block}\nX6\n"));
        let own: Vec<_> = motions.iter().filter(|motion| motion.line == 3).collect();
        assert!(own.iter().all(|motion| motion.unfollowable.is_some()), "{block}");
        assert!(motions.last().unwrap().start.is_none(), "{block}");
    }
}

#[test]
fn blocks_behind_the_end_are_counted() {
    for (text, line, count) in [
        ("G0 X1\nX2\n", None, 0),
        ("%\nG0 X1\nM30\n%\n\n(end)\n", Some(3), 0),
        ("%\nG0 X1\n%\nX2\n?\n", Some(3), 2),
        ("G0 X1 M2\nX2\n(note)\nX3\n", Some(1), 2),
        ("G0 X1\nM30\nO2\nX3\nM99\n", Some(2), 3),
        ("G0 X1\n/M30\nX3\n", None, 0),
    ] {
        let (interpreter, ..) = interpreted(text, InterpreterOptions::in_mm());
        assert_eq!((interpreter.end_line(), interpreter.blocks_after_end()), (line, count), "{text}");
    }
    let long = format!("M30\n{}", "X1\n".repeat(2000));
    assert_eq!(interpreted(&long, InterpreterOptions::in_mm()).0.blocks_after_end(), 2000);
}

#[test]
fn a_return_is_one_opaque_motion_of_unknown_ends() {
    for block in ["M99", "N9 M99", "X5 M99", "G0 Z5 M99", "G28 Z0 M99", "M98 P1 M99", "/M99"] {
        let motions = run_from_zero(&format!("G1 X1 F100\n{block}\nX6\n"));
        let own: Vec<_> = motions.iter().filter(|motion| motion.line == 3).collect();
        let [motion] = own.as_slice() else { panic!("{block}: {own:?}") };
        assert_eq!((motion.kind, motion.start, motion.end), (MotionKind::Opaque, None, None), "{block}");
        assert!(motion.unfollowable.is_some(), "{block}");
        // The program continues only if the operator can choose to skip the block.
        assert_eq!(motions.last().unwrap().line == 4, block.starts_with('/'), "{block}");
    }
    let motions = run_from_zero("G1 X1 F100\nM99\n");
    assert_eq!(motions[1].unfollowable, Some(Unfollowable::Return));
    assert_eq!((motions[1].feed.value, motions[1].feed.word_in_block), (Some(100.0), false));
}
