//! States of a control that only seem to have ended, and values that only seem to be known: one test for each rule.

use super::tests::{run, run_from_zero, run_with};
use super::*;
use crate::machine::{Machine, Preset};
use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};

fn machine(id: &str) -> Machine {
    let mut parts = Preset::by_id(id).unwrap().parts();
    for axis in &mut parts.rotary_axes {
        axis.travel_deg = None;
    }
    Machine::new(parts).unwrap()
}

fn motions_on(machine: &Machine, options: InterpreterOptions, dialect: Dialect, text: &str) -> Vec<Motion> {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let mut interpreter = Interpreter::new(machine, options);
    let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
    while reader.next_batch(&mut batch).unwrap() {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    motions
}

fn motions(dialect: Dialect, text: &str) -> Vec<Motion> {
    motions_on(&machine("ac-table"), InterpreterOptions::in_mm(), dialect, text)
}

/// After a motion that makes all axes known: X1 Y2 Z3 A0 C0.
fn heidenhain(text: &str) -> Vec<Motion> {
    let head = "BEGIN PGM T MM\nL X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\n";
    motions(Dialect::Heidenhain, &format!("{head}{text}")).split_off(1)
}

/// After a block that makes all axes known, at zero.
fn iso(text: &str) -> Vec<Motion> {
    motions(Dialect::Iso, &format!("G0 X0 Y0 Z0 A0 C0\nG1 F500\n{text}")).split_off(1)
}

fn apt(text: &str) -> Vec<Motion> {
    motions(Dialect::Apt, text)
}

fn reason(motions: &[Motion]) -> Option<Unfollowable> {
    motions.last().unwrap().unfollowable
}

const COMPLETE: &str = "G1 X1 Y1 Z1 A0 C0\nX2\n";

#[test]
fn what_the_control_puts_into_a_parameter_is_not_its_value_before() {
    for function in [
        "FN 13: Q25 = +10 ANG -Q1",
        "FN 18: SYSREAD Q25 = ID210 NR4 IDX3",
        "FN18: SYSREAD Q25 = ID210 NR4 IDX3",
        "FN 24: TABREAD Q25 = 1",
        "FN 28: TABREAD Q10 = 6/\"X,Y,D\"",
        "Q25 = Q900 + 1",
    ] {
        let motions = heidenhain(&format!("Q25 = +7\nL X+5 Z+Q25 F100\n{function}\nL X+0 Y+0 Z+Q25\n"));
        assert_eq!(motions[0].end.unwrap().linear_mm[2], 7.0);
        assert_eq!((motions[1].end, motions[1].unfollowable.is_some()), (None, true), "{function}");
    }
    let motions = heidenhain("Q25 = +7\nFN 18: SYSREAD Q1 = ID210 NR4 IDX3\nQS2 = \"A\"\nL Z+Q25 F100\n");
    assert_eq!(motions[0].end.unwrap().linear_mm[2], 7.0, "others stay");
}

#[test]
fn what_is_no_number_is_no_value() {
    for text in ["CYCL DEF 200 DRILLING ~\n    Q200=+0/+0 ;SET-UP\nL X+Q200 F100\n", "Q1 = 0 / 0\nL X+Q1\n"] {
        assert_eq!(heidenhain(text)[0].end, None, "{text}");
    }
    let sign = |of: &str| heidenhain(&format!("Q1 = SGN {of}\nL X+Q1 F100\n"))[0].end;
    assert_eq!(sign("-4").unwrap().linear_mm[0], -1.0);
    assert_eq!(sign("4").unwrap().linear_mm[0], 1.0);
    assert_eq!(sign("0"), None, "0 on some controls, 1 on others");
}

#[test]
fn axes_scaled_each_for_itself_are_scaled_until_each_is_given_one() {
    let scaled = "CYCL DEF 26.0 AXIS-SPEC. SCALING\nCYCL DEF 26.1 X0.99 Y0.99 CCX+15 CCY+20\n";
    let again = "CYCL DEF 26.0 AXIS-SPEC. SCALING\nCYCL DEF 26.1 ";
    let line = "L X+1 Y+1 Z+1 A+0 C+0 F100\n";
    for (end, expected) in [
        ("X1", Some(Unfollowable::Transformation)),
        ("X1 Y1", None),
        ("X1\nCYCL DEF 26.1 Y 1", None),
        ("X1 Y1 Z1.5", Some(Unfollowable::Transformation)),
        ("X1 YQ7", Some(Unfollowable::Transformation)),
    ] {
        assert_eq!(reason(&heidenhain(&format!("{scaled}{again}{end}\n{line}"))), expected, "{end}");
    }
    let other = format!("{scaled}CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1\n{line}");
    assert_eq!(reason(&heidenhain(&other)), Some(Unfollowable::Transformation), "another cycle");
}

#[test]
fn a_rotation_by_nothing_more_is_a_rotation() {
    let text = |end: &str| {
        format!(
            "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 {end}\nL X+1 Y+1 Z+1 A+0 C+0 F100\n"
        )
    };
    assert_eq!(reason(&heidenhain(&text("IROT+0"))), Some(Unfollowable::Transformation));
    assert_eq!(reason(&heidenhain(&text("ROT+0"))), None);
}

#[test]
fn a_tilted_plane_ends_with_angles_of_nothing_or_none() {
    let tilted = "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+30 B+0 C+0\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 ";
    let line = "\nL X+1 Y+1 Z+1 A+0 C+0 F100\n";
    for (end, expected) in [
        ("A+0 B+0 C+0", None),
        ("A+0 B+0 C+0 F1000 ABST50\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1", None),
        ("; none", None),
        ("A+Q120 C+0", Some(Unfollowable::TiltedPlane)),
        ("IA+0", Some(Unfollowable::TiltedPlane)),
    ] {
        assert_eq!(reason(&heidenhain(&format!("{tilted}{end}{line}"))), expected, "{end}");
    }
}

#[test]
fn a_datum_that_the_text_sets_or_takes_back_unseen_is_another_offset() {
    let line = "L X+1 Y+1 Z+1 A+0 C+0 F100\n";
    assert!(heidenhain(&format!("FN 25: PRESET = X/+0/+10\n{line}"))[1].offset_changed);
    let preset = "CYCL DEF 247 DATUM SETTING\n    Q339=+1 ;NUMBER\n";
    let head = "BEGIN PGM T MM\n";
    let shift = "CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 Z+50\n";
    let text = format!("{head}{preset}{shift}{line}{preset}L X+80\n{line}");
    let shifted = motions(Dialect::Heidenhain, &text);
    assert_eq!(shifted[1].start, None);
    assert!(shifted.last().unwrap().offset_changed, "the shift is gone on some controls");
    let plain = motions(Dialect::Heidenhain, &format!("{head}{preset}{line}{preset}{line}L X+2\n"));
    let last = plain.last().unwrap();
    assert!(last.start.is_some() && !last.offset_changed);
}

#[test]
fn every_call_of_a_section_that_shifts_is_another_offset() {
    let section = "LBL 1\nTCH PROBE 410\n    Q321=+0 ;CENTRE\nCYCL DEF 247 DATUM SETTING\n    Q339=+1 ;NUMBER\nTRANS DATUM RESET\nLBL 0\n";
    let line = "L X+1 Y+1 Z+1 A+0 C+0 R0 F100\n";
    let modes = "PLANE RESET STAY\nCYCL DEF 10.1 ROT+0\nM129\n";
    let part = format!("CALL LBL 1\n{modes}{line}");
    let text = format!("BEGIN PGM T MM\n{section}{part}{part}");
    let motions = motions(Dialect::Heidenhain, &text);
    let changed: Vec<_> =
        motions.iter().filter(|motion| motion.end.is_some()).map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [true, true]);
}

#[test]
fn the_path_before_an_arc_that_goes_on_in_its_direction_keeps_its_end() {
    for next in ["CT X+9 Y+9", "CTP PA+10", "DEP LT LEN5", "RND R2"] {
        let motions = heidenhain(&format!("L X+5 F100\n{next}\n"));
        assert_eq!(motions[0].unfollowable, Some(Unfollowable::Corner), "{next}");
    }
    let motions = heidenhain("L X+5 F100\nCC X+0 Y+0\nC X+5 Y+4 DR+\nCR X+7 Y+7 R+20 DR+\nCT X+9 Y+9\n");
    let arcs: Vec<_> = motions.iter().map(|motion| (motion.arc, motion.unfollowable)).collect();
    use ArcCourse::{Carried, Centre, Neighbour};
    let corner = Some(Unfollowable::Corner);
    assert_eq!(arcs, [(Carried, None), (Centre, None), (Carried, corner), (Neighbour, None)]);
    assert_eq!(apt("GOTO/1,0,0\nCIRCLE/0,0,0,0,0,1,1\nGOTO/0,1,0\n")[1].arc, Centre);
}

#[test]
fn a_mirror_is_taken_back_for_the_axes_named() {
    for (end, expected) in [
        ("G50.1 X0\n", Some(Unfollowable::Transformation)),
        ("G50.1 X0 Y0\n", None),
        ("G50.1 X0\nG50.1 Y0\n", None),
        ("G50.1\n", None),
    ] {
        assert_eq!(reason(&iso(&format!("G51.1 X0 Y0\n{end}{COMPLETE}"))), expected, "{end}");
    }
    assert_eq!(reason(&iso(&format!("G51.1\nG50.1 X0\n{COMPLETE}"))), Some(Unfollowable::Transformation));
}

#[test]
fn offsets_that_follow_the_table_are_no_work_offsets() {
    for on in ["G54.2 P1", "G54.4 P1"] {
        let code = &on[..5];
        assert_eq!(reason(&iso(&format!("{on}\nG54\n{COMPLETE}"))), Some(Unfollowable::Transformation));
        let off = iso(&format!("{on}\nG54\n{COMPLETE}{code} P0\n{COMPLETE}"));
        assert!(reason(&off).is_none() && !off.last().unwrap().offset_changed);
        let unknown = Unfollowable::ModeUnknown { group: ModalGroup::Transformation };
        assert_eq!(reason(&iso(&format!("{code} P#500\n{COMPLETE}"))), Some(unknown));
    }
}

#[test]
fn g15_with_h_selects_a_work_coordinate_system() {
    let changed = |text: &str| -> Vec<bool> {
        motions(Dialect::Iso, text).iter().map(|motion| motion.offset_changed).collect()
    };
    assert_eq!(changed(&format!("G15 H1\n{COMPLETE}G15 H2\n{COMPLETE}")), [false, false, true, true]);
    assert_eq!(changed(&format!("G15 H1\n{COMPLETE}G15 H1\n{COMPLETE}G15\n{COMPLETE}")), [false; 6]);
    assert!(changed(&format!("{COMPLETE}G15 H#5\n{COMPLETE}"))[3]);
}

#[test]
fn a_length_along_the_tool_is_not_known_where_a_head_turns_it() {
    let text = "G43.1 H1\nG1 X0 Y0 Z0 B0 C0 F1000\nX80 B30\n";
    let on = |id: &str, is_stated: bool| {
        let interpolation = is_stated.then_some(Interpolation::Tcp);
        let options = InterpreterOptions { interpolation, ..InterpreterOptions::in_mm() };
        let text = if id == "ac-table" { text.replace('B', "A") } else { text.to_owned() };
        reason(&motions_on(&machine(id), options, Dialect::Iso, &text))
    };
    assert_eq!(on("bc-head", false), Some(Unfollowable::ModeUnknown { group: ModalGroup::ToolLength }));
    assert_eq!([on("bc-head", true), on("ac-table", false)], [None, None]);
}

#[test]
fn g107_is_on_with_an_axis_and_off_without() {
    let motions = iso(&format!("G107 A0. Y0. R2.\n{COMPLETE}G107\n{COMPLETE}"));
    let reasons: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    let on = Some(Unfollowable::Transformation);
    assert_eq!(reasons, [on, on, None, None], "the axes named are no motion");
    let motions = iso(&format!("G7.1 C20.\n{COMPLETE}G7.1 C0\n{COMPLETE}"));
    assert_eq!(motions.iter().map(|motion| motion.unfollowable).collect::<Vec<_>>()[1..].last(), Some(&None));
}

#[test]
fn statements_of_a_post_that_move_leave_nothing_known() {
    let first = "GOTO/0,0,0,0,0,1\n";
    for moves in [
        "RETRCT",
        "RETRCT/ON",
        "PREFUN/28",
        "INSERT G0 Z100",
        "INSERT/G55",
        "INSERT M98 P7",
        "INSERT SUPA G0 Z0",
        "OPSKIP/ON",
    ] {
        let motions = apt(&format!("{first}{moves}\nGOTO/80,0,0,0.5,0,0.866\n"));
        assert_eq!(motions.len(), 3, "{moves}");
        assert!(motions[1].kind == MotionKind::Opaque && motions[2].vector_start.is_none(), "{moves}");
    }
    for harmless in [
        "INSERT M8",
        "INSERT/Stock Size X95. Y150. Z120.",
        "INSERT (X5 TO GO)",
        "PREFUN/64",
        "INSERT G64 P0.01",
        "PPRINT X5",
        "COOLNT/ON",
    ] {
        let motions = apt(&format!("{first}{harmless}\nGOTO/80,0,0,0.5,0,0.866\n"));
        assert_eq!(motions.len(), 2, "{harmless}");
        assert!(motions[1].vector_start.is_some() && !motions[1].offset_changed, "{harmless}");
    }
}

#[test]
fn every_system_of_an_operation_is_a_set_up_of_its_own() {
    let system = ["MSYS/0,0,0,1,0,0,0,1,0\n", "MSYS/0,0,100,1,0,0,0,0,1\n"];
    let [first, second] = system;
    let text = format!("{first}GOTO/1,1,1\n{first}GOTO/2,1,1\n{second}GOTO/3,1,1\n");
    let changed: Vec<_> = apt(&text).iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, false, true]);
    // Some systems state the machining axes in comments.
    let matrix = |z: &str| {
        format!(
            "$$*CATIA0\n$$ Operation.1\n$$  1.0 0.0 0.0 0.0\n$$  0.0 1.0 0.0 0.0\n$$  0.0 0.0 1.0 {z}\nPARTNO A\n"
        )
    };
    let [first_axes, second_axes] = ["0.0", "25.0"].map(matrix);
    let text = format!("{first_axes}GOTO/1,1,1\n{first_axes}GOTO/2,1,1\n{second_axes}GOTO/3,1,1\n$$ 1 2 3\n");
    let changed: Vec<_> = apt(&text).iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, false, true]);
    // An axis that is stated in one system has no meaning in another.
    let text = format!("{first}MULTAX/ON\nGOTO/1,1,1,0,.6,.8\n{second}GOTO/3,1,1\n");
    assert_eq!(apt(&text)[1].tool_axis, None);
}

/// The reason for the last motion of an ISO program, and whether its start is known.
fn last_on(dialect: Dialect, text: &str) -> (Option<Unfollowable>, bool) {
    let motions = motions(dialect, text);
    let last = motions.last().unwrap();
    (last.unfollowable, last.start.is_some())
}

#[test]
fn two_codes_of_one_group_in_one_block_leave_the_group_unknown_until_one_is_stated() {
    let unknown = |group| Some(Unfollowable::ModeUnknown { group });
    let head = "G0 X0 Y0 Z0 A0 C0\nG1 F500\n";
    for (pair, group, one) in [
        ("G90 G91", ModalGroup::Distance, "G90"),
        ("G91 G90", ModalGroup::Distance, "G90"),
        ("G94 G93", ModalGroup::FeedMode, "G94 F500"),
        ("G93 G94", ModalGroup::FeedMode, "G94 F500"),
        ("G41 G40", ModalGroup::CutterCompensation, "G40"),
        ("G43.4 G49", ModalGroup::ToolLength, "G49"),
        ("G49 G43.4", ModalGroup::ToolLength, "G43.4"),
        ("G68 G69", ModalGroup::Transformation, "G69"),
        ("G68.2 G69", ModalGroup::Transformation, "G69"),
        ("G16 G15", ModalGroup::Transformation, "G15"),
        ("G0 G1", ModalGroup::Motion, "G1"),
        ("G2 G3", ModalGroup::Motion, "G1"),
    ] {
        let behind = last_on(Dialect::Iso, &format!("{head}{pair}\n{COMPLETE}").replace("\nG1 X1", "\nX1"));
        assert_eq!(behind.0, unknown(group), "{pair}");
        let stated = last_on(Dialect::Iso, &format!("{head}{pair}\n{one}\n{COMPLETE}"));
        assert_eq!(stated, (None, true), "{pair}, then {one}");
        // The same state twice is one state.
        let twice = last_on(Dialect::Iso, &format!("{head}{one} {one}\n{COMPLETE}"));
        assert_eq!(twice.0.filter(|reason| *reason == unknown(group).unwrap()), None, "{one} twice");
    }
    let sinumerik = last_on(Dialect::Siemens, &format!("{head}G90 G91\n{COMPLETE}"));
    assert_eq!(sinumerik.0, unknown(ModalGroup::Distance));
}

#[test]
fn two_planes_in_one_block_are_no_plane_and_two_offsets_no_offset() {
    assert_eq!(iso("G17 G18\nG2 X1 I5 F500\n").last().unwrap().plane, None);
    assert_eq!(iso("G17 G18\nG18\nG2 X1 I5 F500\n").last().unwrap().plane, Some(1));
    for pair in ["G54 G55", "G55 G54", "G54 G54.1 P3"] {
        let last = iso(&format!("{pair}\n{COMPLETE}")).pop().unwrap();
        assert_eq!(last.work_offset, None, "{pair}");
        assert!(iso(&format!("{pair}\nX5\n")).pop().unwrap().start.is_none(), "{pair}");
        let stated = iso(&format!("{pair}\nG54\n{COMPLETE}")).pop().unwrap();
        assert_eq!(stated.work_offset, Some(WorkOffset::G54), "{pair}");
    }
}

#[test]
fn two_units_in_one_block_refuse_the_program_whoever_states_one() {
    let refusals = |text: &str, unit| {
        let mut reader = Reader::new(Some(Dialect::Iso), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let options = InterpreterOptions { unit, ..InterpreterOptions::default() };
        let mut interpreter = Interpreter::new(&machine("ac-table"), options);
        let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
        while reader.next_batch(&mut batch).unwrap() {
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
        }
        let said: Vec<String> = diagnostics.refusals().map(ToString::to_string).collect();
        said
    };
    for unit in [None, Some(crate::units::LengthUnit::Inch)] {
        for (pair, codes) in
            [("G20 G21", "G20 and G21"), ("G21 G20", "G21 and G20"), ("G71 G20", "G71 and G20")]
        {
            let said = refusals(&format!("G90\n{pair}\nG0 X1\nG21\nX2\n"), unit);
            assert_eq!(said.len(), 1, "{pair}: {said:?}");
            assert!(said[0].starts_with("line 2, column 5: ") && said[0].contains(codes), "{said:?}");
        }
        assert_eq!(refusals("G90\nG20 G70\nG0 X1\n", unit).len(), 0, "one unit by two names");
    }
}

#[test]
fn a_user_code_that_switches_the_kinematics_needs_the_interpolation_stated() {
    const SWITCHED: Option<Unfollowable> = Some(Unfollowable::KinematicsSwitched);
    let stated =
        InterpreterOptions { interpolation: Some(Interpolation::Tcp), ..InterpreterOptions::in_mm() };
    for code in [
        "M428",
        "M429",
        "M430",
        "/M428",
        "G43 H1 M428",
        "M428\nG43 H1\nG90 G21 G54",
        "M429\nM98 P1\nG0 G90 G21 G94 G40 G43 G69 G54",
    ] {
        let text = format!("G1 X0 Y0 Z0 A0 C0 F1\n{code}\nG1 X1 Y1 Z1 A1 C1\nX2\n");
        let motions = run(&text);
        let [.., first, last] = motions.as_slice() else { panic!("{code}") };
        assert_eq!(
            (motions[0].unfollowable, first.unfollowable, last.unfollowable),
            (None, SWITCHED, SWITCHED),
            "{code}"
        );
        let (motions, _) = run_with(&text, stated.clone());
        let [.., first, last] = motions.as_slice() else { panic!("{code}") };
        assert_eq!((first.start, first.unfollowable, last.unfollowable), (None, None, None), "{code}");
        assert!(last.start.is_some(), "{code}");
    }
    for (code, interpolation) in [("G43.4 H1", Interpolation::Tcp), ("G49", Interpolation::Machine)] {
        let motions = run_from_zero(&format!("M428\nG1 X1 Y1 Z1 F1\n{code}\nX1 Y1 Z1\nX2\n"));
        assert_eq!((motions[0].unfollowable, motions[2].unfollowable), (SWITCHED, None), "{code}");
        assert_eq!(motions[2].interpolation, interpolation);
    }
    assert_eq!(run_from_zero("M428\n/G49\nG1 X1\n")[0].unfollowable, SWITCHED);
    assert_eq!(run_from_zero("M427 M431\nG1 X1\n")[0].unfollowable, None);
}
