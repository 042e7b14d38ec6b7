//! Whole files of cutter location data, as CAM systems write them: several tools, drilling cycles, set-ups in one
//! system, and radius compensation that the points have in them.

#![expect(clippy::panic, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use nalgebra::Vector3;
use trunnion::machine::Machine;
use trunnion::process::{
    Fault, LineFaultKind, NotPosted, PostForm, PostParameters, PostReport, ProgramSetup, Tools, post,
};
use trunnion::units::Length;

use crate::models::finishing::ac_machine;
use crate::models::set_ups::at_zero;
use crate::models::witness::scan;

fn run(machine: &Machine, parameters: &PostParameters, text: &str) -> Result<(String, PostReport), Fault> {
    let mut output = Vec::new();
    let report =
        post(machine, parameters, &text.as_bytes().to_vec(), &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

/// Tool changes, on a machine that does not turn its tools, so that no length is stated.
fn with_changes() -> PostParameters {
    let program = ProgramSetup { tools: Tools::default(), ..at_zero() };
    PostParameters { changes_tools: true, ..PostParameters::new(program) }
}

/// Line and reason of every refusal.
fn refusals(parameters: &PostParameters, text: &str) -> Vec<(u64, NotPosted)> {
    let Err(Fault::Lines(faults)) = run(&ac_machine(), parameters, text) else { panic!("{text} is posted") };
    let why = |kind: &LineFaultKind| match kind {
        LineFaultKind::NotPosted(why) => *why,
        other => panic!("{other:?}"),
    };
    faults.kept.iter().map(|fault| (fault.line, why(&fault.kind))).collect()
}

/// The blocks between the head and the end of the program, without comments.
fn blocks(output: &str) -> Vec<&str> {
    let lines = output.lines().filter(|line| !line.starts_with(['(', '%']));
    lines.skip(2).take_while(|line| *line != "M30").collect()
}

const TWO_TOOLS: &str = "LOADTL/3\nSPINDL/900,CLW\nRAPID\nGOTO/0,0,9\nFEDRAT/100,MMPM\nGOTO/0,0,1\nRAPID\nGOTO/0,0,50\n\
                         CUTTER/4\nLOADTL/12\nSPINDL/500,CLW\nRAPID\nGOTO/8,0,9\nFEDRAT/70,MMPM\nGOTO/8,0,2\n";

#[test]
fn each_tool_is_put_in_with_its_length_and_comes_near_as_the_first_one_did() {
    let (output, report) = run(&ac_machine(), &with_changes(), TWO_TOOLS).expect("posted");
    let approach = |z: &str, x: &str, h: u32| {
        vec!["G0 A0.0000 C0.0000".to_owned(), format!("G43.4 H{h}"), format!("X{x} Y0.0000"), format!("Z{z}")]
    };
    let mut wanted = vec!["T3 M6".to_owned(), "S900 M3".to_owned()];
    wanted.extend(approach("9.0000", "0.0000", 3));
    wanted.extend(["G1 X0.0000 Y0.0000 Z1.0000 A0.0000 C0.0000 F100.0".to_owned()]);
    wanted.extend(["G0 X0.0000 Y0.0000 Z50.0000 A0.0000 C0.0000".to_owned()]);
    wanted.extend(["G49", "T12 M6", "S500 M3"].map(str::to_owned));
    wanted.extend(approach("9.0000", "8.0000", 12));
    wanted.extend(["G1 X8.0000 Y0.0000 Z2.0000 A0.0000 C0.0000 F70.0", "G49"].map(str::to_owned));
    assert_eq!(blocks(&output), wanted, "{output}");
    assert_eq!((report.tool_changes, report.points), (2, 5));
    // On some controls G49 moves the tool. A comment before it tells the operator.
    let told = "(G49 CAN MOVE THE TOOL BY ITS LENGTH. IT MUST BE CLEAR OF THE PART)\nG49\n";
    assert_eq!(output.matches(told).count(), output.matches("\nG49\n").count());
    // In the other form, inverse time ends before the change.
    let machine = PostParameters { form: PostForm::Machine, ..with_changes() };
    let (output, _) = run(&ac_machine(), &machine, TWO_TOOLS).expect("posted");
    assert!(output.contains("\nG94\nT12 M6\n") && !output.contains("G49"), "{output}");
}

#[test]
fn what_holds_for_one_tool_is_not_taken_for_several() {
    let with_h = PostParameters { length_number: Some(7), ..with_changes() };
    let tools = Tools::of_length(Some(Length::from_mm(80.0)));
    let with_length = PostParameters { program: ProgramSetup { tools, ..at_zero() }, ..with_changes() };
    for parameters in [with_h, with_length] {
        assert_eq!(refusals(&parameters, TWO_TOOLS), [(10, NotPosted::OneTool)]);
        let one = TWO_TOOLS.split_inclusive('\n').take(8).collect::<String>();
        run(&ac_machine(), &parameters, &one).expect("one tool");
    }
    let unnamed = "LOADTL/3\nSPINDL/900,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,1\nLOADTL/BALL\nGOTO/1,0,1\n";
    assert_eq!(refusals(&with_changes(), unnamed), [(5, NotPosted::ToolWithoutNumber)]);
    // The same tool again is no change, and another cutter without another tool is a mistake.
    let again = "LOADTL/3\nSPINDL/900,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,1\nLOADTL/3\nGOTO/1,0,1\n";
    let (_, report) = run(&ac_machine(), &with_changes(), again).expect("posted");
    assert_eq!(report.tool_changes, 1);
    let cutter = "LOADTL/3\nSPINDL/900,CLW\nCUTTER/4\nFEDRAT/100,MMPM\nGOTO/0,0,1\nCUTTER/6\nGOTO/1,0,1\n";
    assert_eq!(refusals(&with_changes(), cutter), [(7, NotPosted::CutterChange)]);
}

#[test]
fn a_spindle_that_nobody_started_again_cuts_nothing() {
    let text = TWO_TOOLS.replace("SPINDL/500,CLW\n", "");
    assert_eq!(refusals(&with_changes(), &text), [(14, NotPosted::SpindleStands)]);
    // M6 puts in the first tool too, and stops a spindle that was started before it.
    let text = text.replace("SPINDL/900,CLW\n", "");
    let stands = [(5, NotPosted::SpindleStands), (13, NotPosted::SpindleStands)];
    assert_eq!(refusals(&with_changes(), &text), stands);
    assert_eq!(refusals(&with_changes(), &format!("SPINDL/900,CLW\n{text}")).len(), 2);
    // A form of SPINDL that is not understood starts nothing.
    let odd = TWO_TOOLS.replace("SPINDL/500,CLW", "SPINDL/SFM,90,CLW");
    assert_eq!(refusals(&with_changes(), &odd), [(15, NotPosted::SpindleStands)]);
    // Without tool changes the caller's frame starts it. After SPINDL/OFF nobody does.
    let one = "FEDRAT/100,MMPM\nGOTO/0,0,1\nSPINDL/OFF\nRAPID\nGOTO/0,0,9\nGOTO/0,0,2\n";
    for form in [PostForm::Tcp, PostForm::Machine] {
        let parameters = PostParameters { form, ..PostParameters::new(at_zero()) };
        assert_eq!(refusals(&parameters, one), [(6, NotPosted::SpindleStopped)]);
        let started = one.replace("RAPID\n", "SPINDL/CCLW,700\nRAPID\n");
        run(&ac_machine(), &parameters, &started).expect("posted");
        run(&ac_machine(), &parameters, &one.replace("SPINDL/OFF\n", "")).expect("posted");
    }
}

/// Tips where the tool goes from block to block, after the approach.
fn tips(output: &str) -> Vec<Vector3<f64>> {
    scan(output, ['A', 'C']).into_iter().skip(2).map(|line| line.q).collect()
}

#[test]
fn a_drilling_cycle_is_the_motions_along_the_tool_axis() {
    let axis = Vector3::new(0.6, 0.0, 0.8);
    let [first, second] = [Vector3::new(10.0, 4.0, -2.0), Vector3::new(10.0, 30.0, -2.0)];
    let goto = |at: Vector3<f64>| format!("GOTO/{},{},{},0.6,0,0.8\n", at.x, at.y, at.z);
    for (cycle, depths) in [
        ("DRILL,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10", vec![5.0]),
        ("DRILL,RAPTO,3,FEDTO,-5.,RTRCTO,10.,MMPM,200,DWELL,0", vec![5.0]),
        // Pecks count from the height at which the feed begins: 4 − 3 = 1, then 2 more each.
        ("DEEP,FEDTO,5,1STPECK,4,SUBPECK,2,MMPM,200,RAPTO,3,RTRCTO,10", vec![1.0, 3.0, 5.0]),
        ("DRILL,DEEP,STEP,4,FEDTO,-5,MMPM,200,RAPTO,3,RTRCTO,10", vec![1.0, 5.0]),
    ] {
        let text = format!(
            "FEDRAT/900,MMPM\nRAPID\n{}CYCLE/{cycle}\n{}{}CYCLE/OFF\nRAPID\n{}",
            goto(first + axis * 20.0),
            goto(first),
            goto(second),
            goto(second + axis * 40.0),
        );
        let (output, _) = run(&ac_machine(), &PostParameters::new(at_zero()), &text).expect(cycle);
        let mut wanted = vec![first + axis * 20.0];
        for (mouth, level) in [(first, 20.0), (second, 10.0)] {
            wanted.extend([mouth + axis * level, mouth + axis * 3.0]);
            for depth in &depths {
                wanted.extend([mouth - axis * *depth, mouth + axis * 3.0]);
            }
            wanted.pop();
            wanted.push(mouth + axis * 10.0);
        }
        wanted.push(second + axis * 40.0);
        // The first hole lies straight below the place before it.
        wanted.remove(1);
        let found = tips(&output);
        assert_eq!(found.len(), wanted.len(), "{cycle}\n{output}");
        for (found, wanted) in found.iter().zip(&wanted) {
            assert!((found - wanted).norm() < 1e-4, "{cycle}: {found} is not {wanted}\n{output}");
        }
        let feeds = output.lines().filter(|line| line.contains("F200.0")).count();
        assert_eq!(feeds, 1, "the feed of the cycle\n{output}");
        assert_eq!(
            output.lines().filter(|line| line.starts_with("G1 ")).count(),
            2 * depths.len(),
            "{output}"
        );
    }
}

#[test]
fn a_cycle_that_does_not_say_all_is_refused_by_its_points() {
    let whole = "DRILL,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10";
    for (cycle, names) in [
        ("DRILL,FEDTO,5,MMPM,200,RAPTO,3", "RTRCTO"),
        ("DRILL,MMPM,200,RAPTO,3,RTRCTO,10", "FEDTO"),
        ("DRILL,FEDTO,5,RAPTO,3,RTRCTO,10", "feed"),
        ("DRILL,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,2", "RTRCTO is below RAPTO"),
        ("DRILL,FEDTO,5,MMPM,200,RAPTO,-3,RTRCTO,10", "RAPTO is below the point"),
        ("DRILL,FEDTO,0,MMPM,200,RAPTO,3,RTRCTO,10", "FEDTO is 0"),
        ("DRILL,FEDTO,5,FEDTO,6,MMPM,200,RAPTO,3,RTRCTO,10", "FEDTO"),
        ("DRILL,FEDTO,5,MMPM,0,RAPTO,3,RTRCTO,10", "feed"),
        ("DRILL,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10,DWELL,2", "the item DWELL"),
        ("DRILL,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10,ORIENT,2", "the item ORIENT"),
        ("DEEP,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10", "STEP"),
        ("DRILL,STEP,2,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10", "DEEP"),
        ("DEEP,STEP,0.01,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10", "100 pecks"),
        ("TAP,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10", "the cycle TAP"),
        ("BORE,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10", "the cycle BORE"),
        ("INIT", "the cycle INIT"),
    ] {
        let text = format!("RAPID\nGOTO/0,0,20\nCYCLE/{cycle}\nGOTO/0,0,0\nCYCLE/OFF\n");
        let [(4, why @ (NotPosted::Cycle(_) | NotPosted::CycleValue { .. } | NotPosted::CycleHere))] =
            refusals(&PostParameters::new(at_zero()), &text)[..]
        else {
            panic!("{cycle}")
        };
        assert!(why.to_string().contains(names), "{cycle}: {why}");
    }
    // From below the plane, with another tool axis, and from an unknown place.
    for (before, point) in
        [("RAPID\nGOTO/0,0,2\n", "0,0,0"), ("RAPID\nGOTO/0,0,20\n", "0,0,0,0.6,0,0.8"), ("", "0,0,0")]
    {
        let text = format!("{before}CYCLE/{whole}\nGOTO/{point}\nCYCLE/OFF\n");
        assert_eq!(refusals(&PostParameters::new(at_zero()), &text).len(), 1, "{before}{point}");
    }
}

#[test]
fn points_in_the_world_do_not_move_with_the_systems_of_set_ups() {
    let body = "CSYS/1,0,0,0,0,1,0,0,0,0,1,0\nFEDRAT/100,MMPM\nGOTO/1,2,3\nCSYS/0,0,1,0,1,0,0,0,0,1,0,0\n";
    let after = "GOTO/4,5,6,0,0,1\n";
    let (output, _) =
        run(&ac_machine(), &PostParameters::new(at_zero()), &format!("TRNTYP/WORLD,0,0,0\n{body}{after}"))
            .expect("posted");
    assert_eq!(tips(&output), [Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)]);
    for other in ["", "TRNTYP/LOCAL,0,0,0\n", "TRNTYP/WORLD,1,0,0\n"] {
        let text = format!("{other}{body}{after}");
        assert!(!refusals(&PostParameters::new(at_zero()), &text).is_empty(), "{other}");
    }
}

#[test]
fn points_of_the_centre_need_no_radius_compensation() {
    let text = "FEDRAT/100,MMPM\nGOTO/0,0,0\nCUTCOM/LEFT\nGOTO/1,2,3\nCUTCOM/OFF\nGOTO/4,5,6\n";
    let refused = refusals(&PostParameters::new(at_zero()), text);
    assert_eq!(refused[0].0, 4);
    let program = ProgramSetup { cutcom_at_centre: true, ..at_zero() };
    let (output, report) = run(&ac_machine(), &PostParameters::new(program), text).expect("posted");
    assert_eq!(tips(&output)[1..], [Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)]);
    assert_eq!((report.cutcoms, report.first_cutcom_line), (1, Some(3)));
    assert!(!output.contains("G41") && output.contains("(CUTCOM/LEFT)"), "{output}");
}
