//! Laws of posting: every point of the source is reached, seen by the witness' own kinematics.

use std::fmt::Write;
use std::ops::ControlFlow;

use nalgebra::Vector3;
use trunnion::machine::Machine;
use trunnion::process::{
    ContactSource, Fault, LineFaultKind, NotPosted, PostForm, PostParameters, PostReport, WearParameters,
    WornCutter, compensate_wear, post,
};
use trunnion::units::Length;

use crate::compensation::witness;
use crate::conversational::apt;
use crate::models::finishing::{ac_machine, blade, dome_near_pole, impeller_flank, tool};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::witness::{Line, scan};

/// Half the last of four decimals in each of three words [mm].
const ROUNDING_MM: f64 = 0.000_05 * 1.732_051 + 1e-6;
/// The same for two rotary words, and for the eight decimals of the source's vectors [rad].
const ROUNDING_RAD: f64 = 2.0 * 0.000_05 * std::f64::consts::PI / 180.0 + 1e-7;

fn run(machine: &Machine, parameters: &PostParameters, text: &str) -> Result<(String, PostReport), Fault> {
    let mut output = Vec::new();
    let report =
        post(machine, parameters, &text.as_bytes().to_vec(), &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

/// Where a posted program has gone at each of its points: the blocks behind the two that lead to the first one.
fn reached(output: &str, letters: [char; 2]) -> Vec<Line> {
    scan(output, letters).split_off(2)
}

/// Tip and tool axis of every point of cutter location data.
fn points(text: &str) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let number = |value: &str| value.parse::<f64>().expect("a number");
    let rows = text.lines().filter_map(|line| line.strip_prefix("GOTO/"));
    rows.map(|row| row.split(',').map(number).collect::<Vec<_>>())
        .map(|row| (Vector3::new(row[0], row[1], row[2]), Vector3::new(row[3], row[4], row[5]).normalize()))
        .collect()
}

#[test]
fn the_machine_reaches_every_point_with_its_tool_axis_in_both_forms() {
    let tool = tool(6.0, 1.5);
    for part in [
        blade(ac_machine(), tool, 25, 3),
        impeller_flank(ac_machine(), tool, 30, 3),
        dome_near_pole(ac_machine(), tool, 41, 3),
    ] {
        let source = apt(&part).0;
        let points = points(&source);
        for form in [PostForm::Tcp, PostForm::Machine] {
            let parameters =
                PostParameters { program: in_mm(&part.setup), form, ..PostParameters::new(at_zero()) };
            let (output, report) = run(&part.machine, &parameters, &source).expect("posted");
            let tables = witness(&part, form == PostForm::Tcp);
            let lines = reached(&output, tables.letters);
            assert_eq!(lines.len(), points.len(), "{}", part.name);
            let mut worst = [0.0_f64; 2];
            for (line, (tip, axis)) in lines.iter().zip(&points) {
                let (w, t) = tables.forward(line.q, line.angle);
                worst[0] = worst[0].max((w - tip).norm());
                worst[1] = worst[1].max(t.cross(axis).norm());
            }
            println!("{} {form:?}: {:.2e} mm {:.2e} rad, {report:?}", part.name, worst[0], worst[1]);
            assert!(worst[0] <= ROUNDING_MM && worst[1] <= ROUNDING_RAD + report.largest_axis_error.rad());
            assert!(report.largest_tip_error_mm <= ROUNDING_MM && report.points == points.len() as u64);
            assert!(report.pole_holds > 0 || worst[1] <= ROUNDING_RAD);
            // The posted program is one of this machine: it is read as it was written.
            assert!(output.starts_with("%\nG21") && output.ends_with("M30\n%\n"));
        }
    }
}

#[test]
fn feeds_are_the_tips_under_tcp_and_times_in_machine_coordinates() {
    let part = impeller_flank(ac_machine(), tool(6.0, 1.5), 30, 3);
    let source = apt(&part).0;
    for form in [PostForm::Tcp, PostForm::Machine] {
        let parameters =
            PostParameters { program: in_mm(&part.setup), form, ..PostParameters::new(at_zero()) };
        let (output, _) = run(&part.machine, &parameters, &source).expect("posted");
        let tables = witness(&part, form == PostForm::Tcp);
        let lines = reached(&output, tables.letters);
        for pair in lines.windows(2).filter(|pair| !pair[1].rapid) {
            let [from, to] = [&pair[0], &pair[1]].map(|line| tables.forward(line.q, line.angle).0);
            let minutes = (to - from).norm() / 1200.0;
            let written = if form == PostForm::Machine {
                1.0 / pair[1].feed
            } else {
                (to - from).norm() / pair[1].feed
            };
            assert_eq!(pair[1].inverse_time, form == PostForm::Machine);
            assert!((written / minutes - 1.0).abs() < 0.002, "{written} {minutes}");
        }
    }
}

#[test]
fn long_programs_are_posted_window_by_window_without_a_rewind() {
    let mut text = String::from("UNITS/MM\nMULTAX/ON\nFEDRAT/1000.,MMPM\n");
    for k in 0..11_000_i32 {
        let turn = f64::from(k) * 0.02;
        let (sin, cos) = turn.sin_cos();
        let (x, y, z) = (40.0 * cos, 40.0 * sin, -0.001 * f64::from(k));
        writeln!(text, "GOTO/{x:.4},{y:.4},{z:.4},{:.8},{:.8},{:.8}", 0.3 * cos, 0.3 * sin, 0.91_f64.sqrt())
            .expect("text");
    }
    let mut parts = trunnion::machine::Preset::by_id("ac-table").expect("a preset").parts();
    parts.rotary_axes[1].travel_deg = None;
    let machine = Machine::new(parts).expect("a machine");
    let (output, report) = run(&machine, &PostParameters::new(at_zero()), &text).expect("posted");
    assert!(report.windows >= 3 && report.rewinds == 0 && report.points == 11_000, "{report:?}");
    // 220 rad are 35 turns of C, unwound.
    let lines = scan(&output, ['A', 'C']);
    let way = lines.last().expect("lines").angle[1] - lines[0].angle[1];
    assert!((way.abs() - 10_999.0 * 0.02_f64.to_degrees()).abs() < 0.01, "{way}");
    assert!(lines.windows(2).all(|pair| (pair[1].angle[0] - pair[0].angle[0]).abs() < 0.01));
}

#[test]
fn arcs_become_chords_within_their_tolerance_in_the_sense_of_their_axis() {
    for (axis, middle) in [("0,0,1.", 10.0), ("0,0,-1.", -10.0)] {
        let text =
            format!("RAPID\nGOTO/10.,0,5.\nFEDRAT/500.,MMPM\nCIRCLE/0,0,5.,{axis},10.\nGOTO/-10.,0,5.\n");
        let (output, report) = run(&ac_machine(), &PostParameters::new(at_zero()), &text).expect("posted");
        let lines = reached(&output, ['A', 'C']);
        assert_eq!((report.arcs, lines.len() as u64), (1, report.points));
        let half = lines[lines.len() / 2].q;
        assert!((half.y - middle).abs() < 1.0 && half.x.abs() < 2.0, "{half}");
        for pair in lines.windows(2) {
            let sagitta = 10.0 - ((pair[0].q + pair[1].q) / 2.0).xy().norm();
            assert!((pair[1].q.xy().norm() - 10.0).abs() < 1e-4 && sagitta < 0.0051, "{sagitta}");
        }
        // Fewest chords: 2 acos(1 − 0.005/10) each.
        let fewest = (std::f64::consts::PI / (2.0 * 0.9995_f64.acos())).ceil();
        assert!((report.points as f64 - 1.0 - fewest).abs() < 0.5, "{}", report.points);
    }
}

#[test]
fn lines_that_cannot_be_posted_are_all_named() {
    let text = "GOTO/1,1,1\nFEDRAT/100,MMPM\nCUTCOM/LEFT\nGOTO/2,1,1\nCUTCOM/OFF\nCYCLE/DRILL,5\nGOTO/3,1,1\nCYCLE/OFF\nCIRCLE/0,0,0,0,0,1\nGOTO/9,9,1\nCSYS/0,0,1.,0,1.,0,0,0,0,1.,0,0\nGOTO/1,1,1\n";
    let Err(Fault::Lines(faults)) = run(&ac_machine(), &PostParameters::new(at_zero()), text) else {
        panic!("not refused");
    };
    let lines: Vec<u64> = faults.kept.iter().map(|fault| fault.line).collect();
    assert_eq!(lines, [1, 4, 7, 10, 12]);
    assert!(matches!(faults.kept[0].kind, LineFaultKind::NotPosted(NotPosted::NoFeed)));
    let iso = run(&ac_machine(), &PostParameters::new(at_zero()), "G1 X1 F100\n");
    assert!(matches!(iso, Err(Fault::NotCutterLocationData { .. })));
    let parts = trunnion::machine::Preset::by_id("ac-table").expect("a preset").parts();
    let limited = Machine::new(parts).expect("a machine");
    // A does not reach 180 degrees. Every such point is named, also one in a window of its own.
    let mut text = "FEDRAT/100,MMPM\nGOTO/1,1,1,0,0,-1\nGOTO/1,1,1,0,0,1\nGOTO/1,1,1,0,0.01,-1\n".to_owned();
    for k in 0..5000 {
        writeln!(text, "GOTO/{k},1,1,0,0,1").expect("text");
    }
    text.push_str("GOTO/1,1,1,0,-0.01,-1\n");
    let Err(Fault::Lines(faults)) = run(&limited, &PostParameters::new(at_zero()), &text) else {
        panic!("A does not reach 180 degrees");
    };
    let lines: Vec<u64> = faults.kept.iter().map(|fault| fault.line).collect();
    assert_eq!(lines, [2, 4, 5005]);
    assert!(
        faults.kept.iter().all(|fault| matches!(fault.kind, LineFaultKind::OutOfTravel { axis: 'A', .. }))
    );
}

/// The blocks of a posted program without its comments.
fn blocks(text: &str, parameters: &PostParameters) -> Vec<String> {
    let (output, _) = run(&ac_machine(), parameters, text).expect("posted");
    output.lines().filter(|line| !line.starts_with('(')).map(str::to_owned).collect()
}

#[test]
fn a_posted_program_leaves_the_control_in_feed_per_minute_and_without_tool_centre_point_control() {
    let machine = PostParameters { form: PostForm::Machine, ..PostParameters::new(at_zero()) };
    let text = "FEDRAT/100,MMPM\nGOTO/1,1,1\nGOTO/2,1,1\n";
    let written = blocks(text, &machine);
    assert_eq!(written[written.len() - 3..], ["G94", "M30", "%"]);
    let per_turn = "FEDRAT/0.1,MMPR\nGOTO/1,1,1\nGOTO/2,1,1\n";
    let written = blocks(per_turn, &PostParameters::new(at_zero()));
    assert_eq!(written[written.len() - 4..], ["G94", "G49", "M30", "%"]);
    let written = blocks(text, &PostParameters::new(at_zero()));
    assert_eq!(written[written.len() - 3..], ["G49", "M30", "%"]);
    assert!(!written.iter().skip(2).any(|block| block.contains("G94")), "{written:?}");
}

#[test]
fn the_first_cut_takes_its_feed_and_the_next_one_its_time() {
    let parameters = PostParameters { form: PostForm::Machine, ..PostParameters::new(at_zero()) };
    // Where the machine stands before the first point nobody knows, whatever FROM/ says.
    for head in ["", "FROM/8,0,0\n"] {
        let first = blocks(&format!("{head}FEDRAT/100,MMPM\nGOTO/10,0,0\nGOTO/15,0,0\n"), &parameters);
        assert_eq!(first[3..6], ["G1 A0.0000 C0.0000 F100.0", "X10.0000 Y0.0000", "Z0.0000"], "{first:?}");
        // 5 mm at 100 mm/min are a twentieth of a minute.
        assert!(first[6].starts_with("G93 X15.0000") && first[6].ends_with(" F20.0"), "{first:?}");
    }
    // FROM/ behind a point does not move it: the longer way counts, and no block is lost.
    for from in ["FROM/100,0,0", "FROM/99.99,0,0"] {
        let text = format!("FEDRAT/100,MMPM\nGOTO/0,0,0\n{from}\nGOTO/100,0,0\nGOTO/200,0,0\n");
        let behind = blocks(&text, &parameters);
        assert!(behind[6].starts_with("G93 X100.0000") && behind[6].ends_with(" F1.0"), "{behind:?}");
        assert!(behind[7].starts_with("X200.0000") && behind[7].ends_with(" F1.0"), "{behind:?}");
    }
    // A tool change moves the machine.
    let behind_a_change = "RAPID\nGOTO/0,0,9\nLOADTL/1\nFEDRAT/100,MMPM\nGOTO/10,0,0\n";
    let changed = blocks(behind_a_change, &parameters);
    assert!(changed[6].starts_with("G1 X10.0000") && changed[6].ends_with(" F100.0"), "{changed:?}");
}

/// The lines of a posted program up to the first point.
fn opening(machine: &Machine, form: PostForm, text: &str) -> Vec<String> {
    let parameters = PostParameters { form, ..PostParameters::new(at_zero()) };
    let (output, report) = run(machine, &parameters, text).expect("posted");
    assert_eq!(report.blocks_out, output.lines().filter(|line| !line.starts_with('(')).count() as u64);
    output.lines().map(str::to_owned).collect()
}

#[test]
fn the_first_approach_turns_the_table_alone_and_comes_along_the_tool_last() {
    let upright =
        "SPINDL/RPM,900,CLW\nMULTAX/ON\nRAPID\nGOTO/10,20,5,0,0,1\nFEDRAT/100,MMPM\nGOTO/15,20,5,0,0,1\n";
    let retract = "(RETRACT THE TOOL BEFORE THE START. THE START POSITION IS NOT KNOWN)";
    let order = "(A C TURN FIRST AND ALONE, THEN X Y MOVE, Z COMES LAST)";
    let tcp = opening(&ac_machine(), PostForm::Tcp, upright);
    let start = ["%", "G21 G17 G90 G40 G80 G94", "G54", "S900 M3", retract, order, "G0 A0.0000 C0.0000"];
    assert_eq!(tcp[..7], start);
    // With tool-centre-point control on, the turn would take the linear axes along.
    assert_eq!(tcp[7..10], ["G43.4 H1", "X10.0000 Y20.0000", "Z5.0000"]);
    let machine = opening(&ac_machine(), PostForm::Machine, upright);
    assert_eq!(machine[..7], start);
    assert_eq!(machine[7..9], ["X10.0000 Y20.0000", "Z5.0000"]);
    // A cut becomes no rapid.
    let cut = opening(&ac_machine(), PostForm::Tcp, "FEDRAT/100,MMPM\nGOTO/10,20,5\nGOTO/15,20,5\n");
    assert_eq!(cut[5..9], ["G1 A0.0000 C0.0000 F100.0", "G43.4 H1", "X10.0000 Y20.0000", "Z5.0000"]);
    assert!(cut.iter().all(|line| !line.contains("G0 ")), "{cut:?}");
}

#[test]
fn the_length_is_that_of_the_tool() {
    let points = "RAPID\nGOTO/10,20,5,0,0,1\nFEDRAT/100,MMPM\nGOTO/15,20,5,0,0,1\n";
    let posted = |head: &str, stated: Option<u32>, tool: Option<u32>| {
        let mut program = at_zero();
        program.tools.number = tool;
        let parameters = PostParameters { length_number: stated, ..PostParameters::new(program) };
        let (mut out, source) = (Vec::new(), format!("MULTAX/ON\n{head}{points}").into_bytes());
        let report =
            post(&ac_machine(), &parameters, &source, &mut out, &|| ControlFlow::Continue(())).unwrap();
        let text = String::from_utf8(out).unwrap();
        let line = text.lines().find(|line| line.starts_with("G43.4")).unwrap().to_owned();
        assert_eq!(line, format!("G43.4 H{}", report.length_number.unwrap()));
        (report.length_number.unwrap(), report.length_number_is_assumed)
    };
    for (head, stated, tool, number, is_assumed) in [
        ("LOADTL/5\n", None, None, 5, false),
        ("LOADTL/5\n", Some(7), None, 7, false),
        ("LOADTL/5\n", None, Some(5), 5, false),
        ("", None, Some(12), 12, false),
        ("", None, None, 1, true),
        ("LOADTL/BALL\n", None, None, 1, true),
        ("LOADTL/0\n", None, None, 1, true),
    ] {
        assert_eq!(posted(head, stated, tool), (number, is_assumed), "{head} {stated:?} {tool:?}");
    }
}

#[test]
fn a_posted_program_can_be_moved_where_its_first_point_is_a_rapid() {
    let shorter = WearParameters {
        shorter_by: Length::from_mm(0.5),
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(5.0, 5.0)), at_zero())
    };
    let points = "GOTO/10,20,5,0,0,1\nFEDRAT/100,MMPM\nGOTO/15,20,5,0,0,1\n";
    let moved = |text: &str| {
        let (posted, _) = run(&ac_machine(), &PostParameters::new(at_zero()), text).expect("posted");
        let (source, mut output) = (posted.into_bytes(), Vec::new());
        compensate_wear(&ac_machine(), &shorter, &source, &mut output, &|| ControlFlow::Continue(()))
            .map(|_| String::from_utf8(output).expect("text"))
    };
    let output = moved(&format!("MULTAX/ON\nRAPID\n{points}")).expect("moved");
    // The tool is upright: the last block of the approach goes lower, and so do the points.
    let approach = "G0 A0.0000 C0.0000\nG43.4 H1\nX10.0000 Y20.0000\nZ4.5000\nG1 X15.0000 Y20.0000 Z4.5000 ";
    assert!(output.contains(approach), "{output}");
    match moved(&format!("MULTAX/ON\nFEDRAT/100,MMPM\n{points}")) {
        Err(Fault::Lines(faults)) => {
            let first = &faults.kept[0];
            assert_eq!(first.line, 6);
            let LineFaultKind::AxesUnknown { axes } = &first.kind else { panic!("{first:?}") };
            // The first block of the approach names the rotary axes alone.
            assert!(axes.to_string().starts_with("X, Y"), "{axes}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_axis_that_is_nearest_to_the_tool_comes_last() {
    let head = |id: &str| {
        let mut parts = trunnion::machine::Preset::by_id(id).expect("a preset").parts();
        parts.rotary_axes.iter_mut().for_each(|axis| axis.travel_deg = None);
        Machine::new(parts).expect("a machine")
    };
    let last = |machine: &Machine, form, axis: &str| {
        let text = format!("MULTAX/ON\nRAPID\nGOTO/10,20,5,{axis}\nFEDRAT/100,MMPM\nGOTO/10,20,6,{axis}\n");
        let lines = opening(machine, form, &text);
        let turn = lines.iter().position(|line| line.starts_with("G0 ")).expect("a turn");
        let letters = |line: &str| -> String { line.chars().filter(|c| "XYZABC".contains(*c)).collect() };
        let parts: Vec<String> =
            lines[turn..].iter().map(|line| letters(line)).filter(|letters| !letters.is_empty()).collect();
        assert!(parts[0].len() == 2 && parts[0].chars().all(|c| "ABC".contains(c)), "{lines:?}");
        assert!(parts[1].len() == 2 && parts[2].len() == 1 && parts[3].len() == 5, "{lines:?}");
        assert!(parts[1..3].concat().chars().all(|c| "XYZ".contains(c)), "{lines:?}");
        parts[2].clone()
    };
    let tables = head("ac-table");
    for (axis, expected) in
        [("0,0,1", "Z"), ("0,-0.8,0.6", "Y"), ("0,0.6,0.8", "Z"), ("0.9,0.1,0.4242641", "X")]
    {
        assert_eq!(last(&tables, PostForm::Tcp, axis), expected, "{axis}");
        // The table turns the part: the spindle stays upright.
        assert_eq!(last(&tables, PostForm::Machine, axis), "Z", "{axis}");
    }
    // Heads turn the tool: words of the machine count along it as tips do.
    for form in [PostForm::Tcp, PostForm::Machine] {
        assert_eq!(last(&head("ac-head"), form, "0,-0.8,0.6"), "Y");
        assert_eq!(last(&head("bc-head"), form, "0.8,0,0.6"), "X");
        assert_eq!(last(&head("bc-head"), form, "0.6,0,0.8"), "Z");
    }
}

#[test]
fn where_a_from_behind_a_point_says_the_tool_is_no_way_of_the_machine_is_left_out_or_made_faster() {
    for form in [PostForm::Tcp, PostForm::Machine] {
        let parameters = PostParameters { form, ..PostParameters::new(at_zero()) };
        for from in ["100,0,0", "99.99,0,0", "100,0,0.0003", "0,0,50", "700,0,0"] {
            let text = format!(
                "FEDRAT/100,MMPM\nGOTO/0,0,50\nFROM/{from}\nGOTO/100,0,0\nGOTO/200,0,0\nGOTO/200,0,0\n"
            );
            let (output, _) = run(&ac_machine(), &parameters, &text).expect("posted");
            let lines = reached(&output, ['A', 'C']);
            let places: Vec<_> = lines.iter().map(|line| (line.q.x, line.q.z)).collect();
            assert_eq!(places[..3], [(0.0, 50.0), (100.0, 0.0), (200.0, 0.0)], "{from} {places:?}");
            if form == PostForm::Machine {
                // The way from the point before, or a longer one, at 100 mm/min.
                let way_mm = 100.0 / lines[1].feed;
                let said_mm = if from == "700,0,0" { 600.0 } else { 100.0_f64.hypot(50.0) };
                assert!((way_mm / said_mm - 1.0).abs() < 0.002, "{from} {way_mm}");
                assert_eq!(lines.len(), 3, "the last one rests");
            }
        }
    }
}

#[test]
fn steps_that_are_each_too_short_for_a_block_are_no_way_left_out() {
    let parameters = PostParameters { form: PostForm::Machine, ..PostParameters::new(at_zero()) };
    let mut text = "FEDRAT/100,MMPM\nGOTO/0,0,0\n".to_owned();
    // Half a circle with a radius of 0.1 mm in steps under half the last decimal.
    let steps = 8_000;
    for k in 1..=steps {
        let (sin, cos) = (std::f64::consts::PI * f64::from(k) / f64::from(steps)).sin_cos();
        writeln!(text, "GOTO/{:.6},{:.6},0", 0.1 - 0.1 * cos, 0.1 * sin).expect("text");
    }
    let (output, _) = run(&ac_machine(), &parameters, &text).expect("posted");
    let lines = scan(&output, ['A', 'C']);
    let highest = lines.iter().map(|line| line.q.y).fold(0.0, f64::max);
    assert!((highest - 0.1).abs() < 2e-4, "{highest} in {} blocks", lines.len());
}

#[test]
fn stops_dwells_spindle_and_coolant_are_words_in_their_place() {
    let text = "SPINDL/RPM,900,CCLW\nCOOLNT/FLOOD\nFEDRAT/100,MMPM\nGOTO/1,0,0\nOPSTOP\nDELAY/1.5\nGOTO/2,0,0\nSTOP\n\
                GOTO/3,0,0\nSPINDL/OFF\nFINI\nSTOP\n";
    for form in [PostForm::Tcp, PostForm::Machine] {
        let parameters = PostParameters { form, ..PostParameters::new(at_zero()) };
        let written = blocks(text, &parameters);
        let (_, report) = run(&ac_machine(), &parameters, text).expect("posted");
        assert_eq!((report.words, report.notes, report.blocks_out), (6, 0, written.len() as u64));
        let at = |block: &str| written.iter().position(|written| written == block).expect("a block");
        let point = |word: &str| written.iter().position(|block| block.contains(word)).expect("a point");
        let places = [
            at("S900 M4"),
            at("M8"),
            point("X1.0000"),
            at("M1"),
            at("G4 P1500"),
            point("X2.0000"),
            at("M0"),
            point("X3.0000"),
            at("M5"),
        ];
        assert!(places.is_sorted(), "{written:?}");
        assert_eq!(written.iter().filter(|block| *block == "M0").count(), 1, "the end is the end");
    }
}

#[test]
fn a_cut_too_quick_for_any_control_is_refused_and_a_note_ends_no_tape() {
    let machine = PostParameters { form: PostForm::Machine, ..PostParameters::new(at_zero()) };
    let text = "FEDRAT/1000000000,MMPM\nGOTO/0,0,0\nGOTO/0.001,0,0\nGOTO/9,0,0\n";
    let Err(Fault::Lines(faults)) = run(&ac_machine(), &machine, text) else { panic!("posted") };
    assert_eq!(faults.kept.iter().map(|fault| fault.line).collect::<Vec<_>>(), [2, 3, 4]);
    let text = "PPRINT/ 5 % OF IT; ALL\nFEDRAT/100,MMPM\nGOTO/0,0,0\n";
    let (noted, _) = run(&ac_machine(), &PostParameters::new(at_zero()), text).expect("posted");
    assert!(noted.contains("\n(PPRINT/ 5   OF IT  ALL)\n"), "{noted}");
}

/// The lines refused, with the reason of the first; none where the program is posted.
fn refused(text: &str) -> (Vec<u64>, Option<LineFaultKind>) {
    match run(&ac_machine(), &PostParameters::new(at_zero()), text) {
        Err(Fault::Lines(faults)) => {
            let lines = faults.kept.iter().map(|fault| fault.line).collect();
            (lines, faults.kept.first().map(|fault| fault.kind.clone()))
        }
        _ => (Vec::new(), None),
    }
}

#[test]
fn another_tool_behind_a_cut_is_refused_and_the_one_before_it_is_not() {
    let change = Some(LineFaultKind::NotPosted(NotPosted::ToolChange));
    let cutter = Some(LineFaultKind::NotPosted(NotPosted::CutterChange));
    let head = "LOADTL/1\nCUTTER/10\nFEDRAT/100,MMPM\nGOTO/1,0,0\n";
    for (behind, lines, kind) in [
        ("LOADTL/2\nGOTO/2,0,0\n", vec![5], &change),
        ("TURRET/2\nCUTTER/8\nGOTO/2,0,0\n", vec![5, 6], &change),
        ("UNLOAD/1\nLOADTL/2\n", vec![6], &change),
        ("CUTTER/8\nGOTO/2,0,0\n", vec![5], &cutter),
        ("LOADTL/2\nGOTO/2,0,0\nLOADTL/1\nGOTO/3,0,0\n", vec![5, 7], &change),
    ] {
        let (found, why) = refused(&format!("{head}{behind}"));
        assert_eq!((&found, &why), (&lines, kind), "{behind}");
    }
    let (found, why) = refused("FEDRAT/100,MMPM\nGOTO/1,0,0\nLOADTL/1\nGOTO/2,0,0\n");
    assert_eq!((found, &why), (vec![3], &change));
    for sound in [
        format!("LOADTL/7\nCUTTER/2\n{head}GOTO/2,0,0\n"),
        format!("RAPID\nGOTO/0,0,9\n{head}TURRET/1\nCUTTER/ 10\nGOTO/2,0,0\nUNLOAD/1\n"),
    ] {
        run(&ac_machine(), &PostParameters::new(at_zero()), &sound).expect("one tool");
    }
}

#[test]
fn a_circle_whose_radius_is_not_that_of_its_ends_is_refused() {
    let arc =
        |radius: &str| format!("FEDRAT/100,MMPM\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1{radius}\nGOTO/0,10,0\n");
    let (lines, why) = refused(&arc(",12"));
    let stated = NotPosted::ArcRadius { stated_mm: 12.0, start_mm: 10.0, end_mm: 10.0 };
    assert_eq!((lines, why), (vec![4], Some(LineFaultKind::NotPosted(stated))));
    // A hundredth of a millimetre is rounding.
    assert_eq!(refused(&arc(",10.011")).0, [4]);
    let large = "FEDRAT/100,MMPM\nGOTO/1000.0000,0,0\nCIRCLE/0,0,0,0,0,1,1000.05\nGOTO/0,1000.0000,0\n";
    assert_eq!(refused(large).0, [4], "and stays that on a large circle");
    // Whole numbers are no rounded ones: a half circle of half a millimetre.
    let half = "FEDRAT/100,MMPM\nGOTO/0,0,10\nCIRCLE/.5,0,10,0,0,1,.5\nGOTO/1,0,10\n";
    assert_eq!(refused(half).0, [0_u64; 0]);
    for sound in [",10.009", ",10,0.06,0.5", "", ","] {
        let (_, report) = run(&ac_machine(), &PostParameters::new(at_zero()), &arc(sound)).expect("an arc");
        assert_eq!(report.arcs, 1, "{sound}");
    }
}

#[test]
fn a_circle_without_its_end_is_refused() {
    let head = "FEDRAT/100,MMPM\nGOTO/10,0,0\n";
    for (behind, lines) in [
        ("CIRCLE/0,0,0,0,0,1\n", vec![3]),
        ("CIRCLE/0,0,0,0,0,1\nFINI\nGOTO/0,10,0\n", vec![3]),
        ("CIRCLE/0,0,0,0,0,1\nCIRCLE/0,0,0,0,0,-1\nGOTO/0,10,0\n", vec![4]),
        ("CIRCLE/0,0,0,0,0,1\nRAPID\nGOTO/0,10,0\n", vec![5]),
        ("CIRCLE/0,0,0,0,0,1\nFEDRAT/50,MMPM\nGOTO/0,10,0\n", vec![]),
    ] {
        let (found, why) = refused(&format!("{head}{behind}"));
        assert_eq!(found, lines, "{behind}");
        let is_arc = matches!(why, Some(LineFaultKind::NotPosted(NotPosted::Arc { .. })));
        assert_eq!(is_arc, !lines.is_empty(), "{behind}");
    }
}

#[test]
fn a_feed_behind_rapid_keeps_the_next_point_at_feed() {
    for (between, rapid) in [
        ("", true),
        ("FEDRAT/100,MMPM\n", false),
        ("FEDRAT/ 100.\n", false),
        ("FEDRAT/MMPM,100\n", false),
        ("COOLNT/ON\n", true),
    ] {
        let text = format!("FEDRAT/200,MMPM\nGOTO/0,0,5\nRAPID\n{between}GOTO/9,0,5\n");
        let (output, _) = run(&ac_machine(), &PostParameters::new(at_zero()), &text).expect("posted");
        let last = output.lines().rfind(|line| line.contains("X9")).expect("the point");
        assert_eq!(last.contains("G0"), rapid, "{output}");
    }
}

#[test]
fn what_stands_behind_the_end_is_counted() {
    let text = "FEDRAT/100,MMPM\nGOTO/0,0,5\nEND\nGOTO/9,0,5\n\nSTOP\nFINI\n";
    let (output, report) = run(&ac_machine(), &PostParameters::new(at_zero()), text).expect("posted");
    assert!(!output.contains("X9"), "{output}");
    assert_eq!((report.points, report.blocks_after_end, report.end_line), (1, 2, Some(3)));
}
