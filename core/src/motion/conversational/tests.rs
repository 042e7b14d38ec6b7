//! The meaning of Heidenhain and APT programs, one test for each rule.

use super::*;
use crate::machine::{Machine, Preset};
use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, Severity};

fn machine() -> Machine {
    let mut parts = Preset::by_id("ac-table").unwrap().parts();
    parts.rotary_axes[0].travel_deg = None;
    Machine::new(parts).unwrap()
}

fn interpreted(text: &str, dialect: Dialect) -> (Vec<Motion>, Diagnostics) {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let mut interpreter = Interpreter::new(&machine(), InterpreterOptions::in_mm());
    let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
    while reader.next_batch(&mut batch).unwrap() {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    (motions, diagnostics)
}

/// The motions after a motion that makes all axes known: X1 Y2 Z3 A0 C0.
fn heidenhain(text: &str) -> Vec<Motion> {
    let head = "0 BEGIN PGM T MM\n1 L X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\n";
    interpreted(&format!("{head}{text}"), Dialect::Heidenhain).0.split_off(1)
}

fn apt(text: &str) -> Vec<Motion> {
    interpreted(text, Dialect::Apt).0
}

fn refusals(text: &str) -> Vec<u64> {
    interpreted(text, Dialect::Heidenhain).1.refusals().map(|refusal| refusal.line).collect()
}

fn end(motion: &Motion) -> [f64; 5] {
    let end = motion.end.unwrap();
    let [x, y, z] = end.linear_mm;
    [x, y, z, end.rotary_deg[0], end.rotary_deg[1]]
}

#[test]
fn words_are_absolute_or_count_from_the_point_before_each_for_itself() {
    let motions = heidenhain("2 L IX+2 Y-4,5 F100\n3 L X5 IC-10\n");
    assert_eq!(end(&motions[0]), [3.0, -4.5, 3.0, 0.0, 0.0]);
    assert_eq!(end(&motions[1]), [5.0, -4.5, 3.0, 0.0, -10.0]);
    assert!(motions.iter().all(|motion| motion.unfollowable.is_none() && motion.kind == MotionKind::Linear));
}

#[test]
fn rapid_traverse_holds_for_its_block_and_the_feed_before_goes_on() {
    let motions = heidenhain("L X+2 F250\nL X+3 FMAX M3\nL X+4\nL X+5 FAUTO\n");
    let kinds: Vec<_> = motions.iter().map(|motion| motion.kind).collect();
    assert_eq!(kinds, [MotionKind::Linear, MotionKind::Rapid, MotionKind::Linear, MotionKind::Linear]);
    assert_eq!(motions[2].feed.value, Some(250.0));
    assert_eq!(motions[3].feed.value, None, "the feed of the tool call is not known");
}

#[test]
fn the_header_sets_the_unit_and_feeds_are_in_it_a_minute() {
    for unit in ["INCH", "IN"] {
        let text = format!("BEGIN PGM T {unit}\nL X+1 Y+0 Z+0 A+10 C+0 R0 FMAX\nL X+2 F10\n");
        let motions = interpreted(&text, Dialect::Heidenhain).0;
        assert_eq!(end(&motions[1]), [50.8, 0.0, 0.0, 10.0, 0.0]);
        assert_eq!(motions[1].feed.value, Some(254.0));
    }
}

#[test]
fn m128_is_tool_centre_point_control_with_a_feed_of_its_own_and_m129_acts_behind_the_motion() {
    let motions =
        heidenhain("L X+2 F100 M128 F9000\nL X+2 Y+0 Z+0 A+5 C+5\nL X+3 M129\nL X+4 Y+4 Z+4 A+5 C+5\n");
    let modes: Vec<_> = motions.iter().map(|motion| motion.interpolation).collect();
    use Interpolation::{Machine, Tcp};
    assert_eq!(modes, [Tcp, Tcp, Tcp, Machine]);
    assert!(motions.iter().all(|motion| motion.feed.value == Some(100.0)));
    assert_eq!(motions[3].start, None, "the coordinates of the point before were others");
    let motions = heidenhain(
        "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\nL X+1 Y+1 Z+1 A+1 C+1 F100\nFUNCTION RESET TCPM\nL X+2 Y+1 Z+1 A+1 C+1\nFUNCTION TCPM F CONT AXIS SPAT PATHCTRL VECTOR\nL X+1 Y+1 Z+1 A+1 C+1\n",
    );
    assert_eq!([motions[0].interpolation, motions[1].interpolation], [Tcp, Machine]);
    assert_eq!(motions[2].unfollowable, Some(Unfollowable::ModeUnknown { group: ModalGroup::ToolLength }));
}

#[test]
fn machine_coordinates_hold_for_one_block_and_leave_the_axes_unknown() {
    let motions = heidenhain("L Z-1 R0 FMAX M91\nL X+2 F100\nL X+2 Z+3\nL X+3\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::MachineCoordinates));
    assert_eq!([motions[1].end, motions[2].start], [None, None]);
    assert!(motions[3].start.is_some());
}

#[test]
fn arcs_end_where_their_words_say_and_the_pole_is_no_place_to_go_to() {
    let motions = heidenhain("CC X+50 Y+60\nC X+7 Y+8 DR- F100\nCR X+9 Y+9 R+20 DR+\nC DR+\nL X+1\n");
    assert_eq!(motions.len(), 4);
    assert!(
        motions[..3].iter().all(|motion| motion.kind == MotionKind::Arc && motion.unfollowable.is_none())
    );
    assert_eq!(end(&motions[0])[..2], [7.0, 8.0]);
    assert_eq!(end(&motions[1])[..2], [9.0, 9.0]);
    assert_eq!(motions[2].start, motions[2].end);
}

#[test]
fn what_the_control_works_out_is_left_alone_and_so_are_corners_that_are_cut() {
    let motions =
        heidenhain("L X+10 F100\n; a note\nRND R2\nL Y+10\nL X+10 Y+20 Z+3\nLP PR+5 PA+30\nL X+1\n");
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::Corner));
    assert_eq!(motions[1].unfollowable, Some(Unfollowable::ContourElement));
    assert_eq!([motions[2].end, motions[5].end], [None, None]);
    assert_eq!(motions[4].unfollowable, Some(Unfollowable::ContourElement));
}

#[test]
fn radius_compensation_planes_and_mirrors_are_left_alone_until_they_are_off() {
    for (on, off) in [
        ("L X+2 RL F100", "L X+3 Y+2 R0"),
        (
            "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30\nL X+2 F100",
            "CYCL DEF 10.1 ROT+0\nL X+3 Y+2 Z+3 A+0 C+0",
        ),
        ("CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X+2 F100", "CYCL DEF 8.1\nL X+3 Y+2 Z+3 A+0 C+0"),
        (
            "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.99\nL X+2 F100",
            "CYCL DEF 11.1 SCL 1\nL X+3 Y+2 Z+3 A+0 C+0",
        ),
        ("PLANE SPATIAL SPA+0 SPB+45 SPC+0 TURN FMAX\nL X+2 F100", "PLANE RESET STAY\nL X+3 Y+2 Z+3 A+0 C+0"),
        (
            "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+45 C+0\nL X+2 F100",
            "CYCL DEF 19.1 A+0 B+0 C+0\nL X+3 Y+2 Z+3 A+0 C+0",
        ),
        ("TOOL CALL 5 Y S1000\nL X+2 F100", "TOOL CALL 5 Z S1000\nL X+3 Y+2 Z+3 A+0 C+0"),
    ] {
        let motions = heidenhain(&format!("{on}\n{off}\nL Y+9\n"));
        assert!(motions[0].unfollowable.is_some(), "{on}");
        let last = motions.last().unwrap();
        assert_eq!((last.unfollowable, last.start.is_some()), (None, true), "{on}");
    }
}

#[test]
fn a_datum_shift_is_another_offset_unless_it_is_the_same() {
    let shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+5\n";
    let text = format!(
        "{shift}L X+1 Y+2 Z+3 A+0 C+0 F100\nCYCL DEF 7.1 X+0\nCYCL DEF 7.1 X+0\nL X+1 Y+2 Z+3 A+0 C+0\n{shift}"
    );
    let motions = heidenhain(&text);
    assert!(motions[0].offset_changed && motions[0].start.is_none());
    assert!(!motions[1].offset_changed);
    // A shift of zero leaves positions known where no shift was active.
    let motions = heidenhain("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+2 F100\n");
    assert!(motions[0].start.is_some() && !motions[0].offset_changed);
}

#[test]
fn cycles_run_where_they_are_called() {
    let text = "CYCL DEF 200 DRILLING ~\n    Q200=+2 ;SET-UP ~\n    Q201=-20 ;DEPTH\nL X+2 FMAX M99\nCYCL DEF 247 DATUM SETTING\n    Q339=+1 ;NUMBER\nL X+2 Y+2 Z+2 A+0 C+0 FMAX M8\nCYCL CALL M8\nL X+1 Y+1 Z+1 F100\n";
    let motions = heidenhain(text);
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::CannedCycle));
    assert!(
        motions[1].offset_changed && motions[1].start.is_none(),
        "a preset after points without a preset"
    );
    assert_eq!(motions[2].unfollowable, Some(Unfollowable::CannedCycle));
    assert_eq!(motions[3].start, None);
    let motions =
        heidenhain(&text.replace("CYCL CALL M8", "CYCL DEF 247 DATUM SETTING\n    Q339=+2 ;NUMBER"));
    assert!(motions[2].offset_changed, "another preset");
}

#[test]
fn parameters_with_fixed_values_are_numbers_and_others_are_not() {
    let text = "FN 0: Q1 = +12,5\nQ2 = ( Q1 + 2,5 ) * 2 - SQ 3\nFN 4: Q3 = +Q2 DIV +2\nFN 18: SYSREAD Q4 = ID270 NR1 IDX1\nL X+Q1 IY-Q2 F Q3\nL X+Q4\nL X+Q108\nCALL PGM OTHER\nL X-Q1\n";
    let motions = heidenhain(text);
    // (12.5 + 2.5) * 2 - 9 = 21
    assert_eq!(end(&motions[0])[..2], [12.5, 2.0 - 21.0]);
    assert_eq!(motions[0].feed.value, Some(10.5));
    for motion in [&motions[1], &motions[2], &motions[4]] {
        assert_eq!((motion.end, motion.unfollowable.is_some()), (None, true));
    }
}

#[test]
fn jumps_and_repetitions_of_text_that_was_followed_are_refused_with_their_lines() {
    let body = "BEGIN PGM T MM\nL X+1 Y+2 Z+3 A+0 C+0 R0 FMAX\nLBL 1\nL IX+2 F100\n";
    assert_eq!(refusals(&format!("{body}CALL LBL 1 REP 3\n")), [5]);
    assert_eq!(refusals(&format!("{body}LBL 0\nCALL LBL 1\n")), [6]);
    assert_eq!(refusals(&format!("{body}FN 9: IF +Q1 EQU +0 GOTO LBL 1\n")), [5]);
    assert_eq!(refusals(&format!("{body}LBL 2\nL X+9\n")), [0_u64; 0], "a label alone is harmless");
}

#[test]
fn a_section_without_followed_motions_is_known_where_it_is_called() {
    let section = "LBL 500\nPLANE RESET STAY\nL Z-1 R0 FMAX M91\nLBL 0\n";
    let text = format!(
        "BEGIN PGM T INCH\n{section}L M128\nL X+1 Y+1 Z+1 A+0 C+0 FMAX\nCALL LBL 500\nL X+2 Y+1 Z+1 A+0 C+0 FMAX\nL X+3 F5\n"
    );
    let (motions, diagnostics) = interpreted(&text, Dialect::Heidenhain);
    assert_eq!(diagnostics.kept(), []);
    let last = motions.last().unwrap();
    // M128 was on before the call, and the section leaves it unchanged.
    assert_eq!((last.unfollowable, last.interpolation), (None, Interpolation::Tcp));
    assert_eq!(end(last)[0], 3.0 * 25.4);
    assert_eq!(motions[motions.len() - 2].start, None);
}

#[test]
fn behind_the_call_of_a_section_not_yet_seen_modes_are_unknown_and_its_text_is_left_alone() {
    let text = "CALL LBL 7\nL X+1 Y+1 Z+1 A+0 C+0 R0 F100\nLBL 7\nL X+1 Y+1 Z+1 A+0 C+0 R0 F100 M129\nPLANE RESET STAY\nL X+1 Y+1 Z+1 A+0 C+0 F100\nLBL 0\n";
    let motions = heidenhain(text);
    assert_eq!(motions[0].unfollowable, Some(Unfollowable::Call));
    assert!(matches!(motions[1].unfollowable, Some(Unfollowable::ModeUnknown { .. })));
    assert!(motions[2..].iter().all(|motion| motion.unfollowable.is_some()));
}

#[test]
fn lines_with_vectors_state_normal_and_tool_axis() {
    let motions = heidenhain(
        "L M128\nL X+0 Y+0 Z+0 A+0 C+0 FMAX\nLN X+1 Y+2 Z+3 NX+0 NY+0.6 NZ+0.8 TX+0 TY+0 TZ+1 R0 F500\n",
    );
    let last = motions.last().unwrap();
    assert_eq!(last.contact, ContactWords::Normal([0.0, 0.6, 0.8]));
    assert_eq!(last.tool_axis, Some([0.0, 0.0, 1.0]));
    assert_eq!(last.linear_end_mm, Some([1.0, 2.0, 3.0]));
    assert_eq!(last.unfollowable, Some(Unfollowable::ToolVector));
}

#[test]
fn a_rotary_axis_that_takes_the_shorter_way_is_left_alone() {
    let motions = heidenhain("M126\nL C+170 F100\nL C-170\nM127\nL C+170\n");
    let reasons: Vec<_> = motions.iter().map(|motion| motion.unfollowable).collect();
    assert_eq!(reasons, [None, Some(Unfollowable::ShortestPath), None]);
}

#[test]
fn a_turn_whose_feed_counts_along_a_circle_is_left_alone() {
    let reasons =
        |text: &str| -> Vec<_> { heidenhain(text).iter().map(|motion| motion.unfollowable).collect() };
    let left = Some(Unfollowable::RotaryFeed);
    // Straight motions and rapids keep their meaning, and so does everything after M117.
    assert_eq!(
        reasons("L M116\nL C+10 F100\nL X+5\nL X+6 C+20\nL C+30 FMAX\nL C+40 M117\nL X+7 C+50\n"),
        [left, None, left, None, None, None]
    );
    // With TCP, F counts along the path of the tip, if the tip moves.
    assert_eq!(reasons("L M116\nL M128\nL X+5 Y+5 Z+5 C+10 F100\nL X+6 C+20\nL C+30\n"), [None, None, left]);
}

#[test]
fn points_of_cutter_location_data_are_tips_with_the_axis_last_stated() {
    let motions = apt(
        "UNITS/MM\nFROM/0,0,50.\nGOTO/1.,2.,3.\nMULTAX/ON\nGOTO/4.,5.,6.,0,.6,.8\nGOTO/7,8,9\nGODLTA/1,0,-1\n",
    );
    assert!(motions.iter().all(|motion| motion.unfollowable == Some(Unfollowable::ToolVector)));
    assert!(motions.iter().all(|motion| motion.interpolation == Interpolation::Tcp));
    let axes: Vec<_> = motions.iter().map(|motion| motion.tool_axis.unwrap()).collect();
    assert_eq!(axes, [[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.6, 0.8], [0.0, 0.6, 0.8]]);
    assert_eq!(motions[3].linear_end_mm, Some([8.0, 8.0, 8.0]));
    // Without MULTAX, three values after six may mean the axis of the point before, or Z.
    let motions = apt("GOTO/4.,5.,6.,0,.6,.8\nGOTO/7,8,9\nTLAXIS/1,0,0\nGOTO/7,8,9\n");
    assert_eq!(motions[1].tool_axis, None);
    assert_eq!(motions[2].tool_axis, Some([1.0, 0.0, 0.0]));
}

#[test]
fn rapid_and_circle_hold_for_the_next_point_only() {
    let motions = apt(
        "RAPID/\nGOTO/1,0,0\nFEDRAT/100.,MMPM\nGOTO/2,0,0\nCIRCLE/0,0,0,0,0,1,2\nGOTO/0,2,0\nGOTO/1,1,1\n",
    );
    let kinds: Vec<_> = motions.iter().map(|motion| motion.kind).collect();
    use MotionKind::{Arc, Linear, Rapid};
    assert_eq!(kinds, [Rapid, Linear, Arc, Linear]);
    assert_eq!(motions[3].feed.value, Some(100.0));
    // A motion that went home at rapid does not reach the point after it. A feed of any form is not a rapid.
    for between in ["GOHOME", "GOFWD/P1", "RETRCT", "FEDRAT/100", "FEDRAT/ 100., MMPM"] {
        let motions = apt(&format!("FEDRAT/100.,MMPM\nGOTO/1,0,0\nRAPID\n{between}\nGOTO/2,0,0\n"));
        assert_eq!(motions.last().unwrap().kind, Linear, "{between}");
    }
}

#[test]
fn feeds_of_cutter_location_data_have_their_unit_before_or_behind_and_keep_it() {
    let motions = apt(
        "UNITS/MM\nFEDRAT/ MMPM,171.5 \nGOTO/1,0,0\nFEDRAT/200\nGOTO/2,0,0\nFEDRAT/0.2,MMPR\nGOTO/3,0,0\nFEDRAT/10,IPM\nGOTO/4,0,0\n",
    );
    let feeds: Vec<_> = motions.iter().map(|motion| (motion.feed.mode, motion.feed.value)).collect();
    let minute = Some(FeedMode::PerMinute);
    let expected = [
        (minute, Some(171.5)),
        (minute, Some(200.0)),
        (Some(FeedMode::PerRevolution), Some(0.2)),
        // Inches per minute in a program in millimetres are not taken.
        (minute, None),
    ];
    assert_eq!(feeds, expected);
    let motions = apt("UNITS/INCHES\nFEDRAT/10,IPM\nGOTO/4,0,0\n");
    assert_eq!((motions[0].feed.value, motions[0].linear_end_mm), (Some(254.0), Some([101.6, 0.0, 0.0])));
}

#[test]
fn cycles_compensation_and_turned_coordinates_of_cutter_location_data_are_left_alone() {
    let motions = apt(
        "CYCLE/DRILL,5\nGOTO/1,1,1\nCYCLE/OFF\nGOTO/1,1,2\nCUTCOM/LEFT\nGOTO/2,2,2\nCUTCOM/OFF\nGOTO/3,2,2\nROTABL/ -0.000000,BAXIS\nGOTO/3,3,3\nROTABL/ 1.570796,AAXIS,TABLE\nGOTO/4,4,4\n",
    );
    let reasons: Vec<_> = motions.iter().map(|motion| motion.unfollowable.unwrap()).collect();
    use Unfollowable::{CannedCycle, CutterCompensation, ToolVector, Transformation};
    assert_eq!(
        reasons,
        [CannedCycle, ToolVector, CutterCompensation, ToolVector, ToolVector, Transformation]
    );
}

#[test]
fn nine_values_end_in_a_contact_normal_and_what_is_no_direction_is_refused() {
    let (motions, _) = interpreted("GOTO/1,2,3,0,0,1,.6,0,.8 $$ note\nGOTO/1,2,3,0,0,1\n", Dialect::Apt);
    assert_eq!(motions[0].contact, ContactWords::Normal([0.6, 0.0, 0.8]));
    assert_eq!(motions[1].contact, ContactWords::None);
    let (_, diagnostics) = interpreted("GOTO/1,2,3,0,0,1,10,20,30\nGOTO/1,2\nGOTO/1,2,x\n", Dialect::Apt);
    assert_eq!(diagnostics.count(Severity::Refusal), 3);
}

#[test]
fn statements_run_on_behind_a_dollar_and_text_does_not() {
    let motions = apt(
        "PPRINT 5$\nGOTO / 1.0, 2.0, 3.0, $\n   0.0, 0.0, 1.0E+00\nPARTNO A$\nGOTO/4,5,6,\nFINI\nGOTO/9,9,9\n",
    );
    assert_eq!(motions.len(), 2);
    assert_eq!(motions[0].tool_axis, Some([0.0, 0.0, 1.0]));
    assert_eq!((motions[1].line, motions[1].linear_end_mm), (5, Some([4.0, 5.0, 6.0])));
}

#[test]
fn another_coordinate_system_is_another_offset() {
    let csys = ["CSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\n", "CSYS/0,0,1.,0,1.,0,0,0,0,1.,0,0\n"];
    let [first, second] = csys;
    let text = format!("{first}GOTO/1,1,1\n{first}GOTO/2,1,1\n{second}GOTO/3,1,1\n");
    let changed: Vec<_> = apt(&text).iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, false, true]);
    // In the world the points of every system count alike.
    let motions = apt(&format!("TRNTYP/WORLD,0,0,0\n{text}"));
    assert!(motions.iter().all(|motion| !motion.offset_changed));
    assert_eq!(motions[2].linear_end_mm, Some([3.0, 1.0, 1.0]));
    // The points before the first named system have a system of their own.
    let text = format!("GOTO/1,1,1\n{second}GOTO/2,1,1\n");
    let changed: Vec<_> = apt(&text).iter().map(|motion| motion.offset_changed).collect();
    assert_eq!(changed, [false, true]);
}
