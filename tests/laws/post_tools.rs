//! Laws of the tools of a posted program: lengths, registers, what ends a tool, and what is no tool.

#![expect(clippy::panic, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::machine::{Machine, Preset};
use trunnion::process::{
    Fault, LineFaultKind, NotPosted, PostForm, PostParameters, PostReport, ProgramSetup, Tools, post,
};
use trunnion::units::Feedrate;

use crate::models::finishing::ac_machine;
use crate::models::set_ups::at_zero;

fn run(parameters: &PostParameters, text: &str) -> Result<(String, PostReport), Fault> {
    run_on(&ac_machine(), parameters, text)
}

fn run_on(machine: &Machine, parameters: &PostParameters, text: &str) -> Result<(String, PostReport), Fault> {
    let mut output = Vec::new();
    let report =
        post(machine, parameters, &text.as_bytes().to_vec(), &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

fn in_form(form: PostForm) -> PostParameters {
    PostParameters { form, ..PostParameters::new(at_zero()) }
}

fn with_changes(form: PostForm) -> PostParameters {
    let program = ProgramSetup { tools: Tools::default(), ..at_zero() };
    PostParameters { form, changes_tools: true, ..PostParameters::new(program) }
}

/// Line and reason of every refusal.
fn refusals(parameters: &PostParameters, text: &str) -> Vec<(u64, NotPosted)> {
    let Err(Fault::Lines(faults)) = run(parameters, text) else { panic!("{text} is posted") };
    let why = |kind: &LineFaultKind| match kind {
        LineFaultKind::NotPosted(why) => *why,
        other => panic!("{other:?}"),
    };
    faults.kept.iter().map(|fault| (fault.line, why(&fault.kind))).collect()
}

/// A tool of these statements that cuts, and retracts.
fn cutting(statements: &str) -> String {
    format!(
        "{statements}SPINDL/900,CLW\nRAPID\nGOTO/0,0,9\nFEDRAT/100,MMPM\nGOTO/4,0,1\nRAPID\nGOTO/4,0,50\n"
    )
}

/// The blocks without comments that have an H.
fn lengths(output: &str) -> Vec<&str> {
    output.lines().filter(|line| !line.starts_with('(') && line.contains('H')).collect()
}

#[test]
fn axis_positions_have_the_length_of_each_tool_in_the_block_that_states_z() {
    let text = format!("{}{}", cutting("LOADTL/3\n"), cutting("LOADTL/12,ADJUST,22\n"));
    let (output, report) = run(&with_changes(PostForm::Machine), &text).expect("posted");
    assert_eq!(lengths(&output), ["G43 Z9.0000 H3", "G43 Z9.0000 H22"], "{output}");
    assert!(!report.length_is_left_out && report.length_number == Some(22));
    // The length comes after the turn of the table and after X Y.
    let at = |block: &str| output.find(block).unwrap_or_else(|| panic!("{block}\n{output}"));
    assert!(at("T12 M6") < at("G43 Z9.0000 H22") && !output.contains("G43.4") && !output.contains("G49"));
    // One tool, whose length the request states.
    let parameters = PostParameters { length_number: Some(7), ..in_form(PostForm::Machine) };
    let (output, _) = run(&parameters, &cutting("LOADTL/3\n")).expect("posted");
    assert_eq!(lengths(&output), ["G43 Z9.0000 H7"], "{output}");
    // Nothing is stated: the frame of the caller has it, and the report says so.
    let (output, report) = run(&in_form(PostForm::Machine), &cutting("LOADTL/3\n")).expect("posted");
    assert!(lengths(&output).is_empty() && report.length_is_left_out && report.length_number.is_none());
    // A tool that comes along Y states Z before, and its length with it.
    let mut parts = Preset::by_id("ac-head").expect("a preset").parts();
    parts.rotary_axes.iter_mut().for_each(|axis| axis.travel_deg = None);
    let head = Machine::new(parts).expect("a machine");
    let text = "MULTAX/ON\nRAPID\nGOTO/10,20,5,0,-0.8,0.6\nRAPID\nGOTO/10,20,6,0,-0.8,0.6\n";
    let (output, _) = run_on(&head, &parameters, text).expect("posted");
    let [block] = lengths(&output)[..] else { panic!("{output}") };
    assert!(block.starts_with("G43 X") && block.ends_with(" H7") && !block.contains('Y'), "{block}");
}

#[test]
fn the_register_of_a_tool_is_its_length_and_what_may_select_another_is_refused() {
    for (statement, register) in [
        ("LOADTL/2,ADJUST,22", 22),
        ("LOAD/TOOL,2,ZOFF,0.0000,ADJUST,9", 9),
        ("LOADTL/4,LENGTH,120.5,OSETNO,44", 44),
        ("LOAD/TOOL,4", 4),
    ] {
        let text = cutting(&format!("{statement}\n"));
        for parameters in [in_form(PostForm::Tcp), with_changes(PostForm::Tcp)] {
            let (output, report) = run(&parameters, &text).expect(statement);
            assert_eq!(lengths(&output), [format!("G43.4 H{register}")], "{statement}");
            assert_eq!(report.length_number, Some(register));
        }
        let (output, _) = run(&with_changes(PostForm::Machine), &text).expect(statement);
        assert_eq!(lengths(&output), [format!("G43 Z9.0000 H{register}")], "{statement}");
    }
    for statement in ["LOAD/TOOL,2,ZOFF,3.5,ADJUST,9", "LOADTL/2,5", "LOADTL/ADJUST,5,12", "LOADTL/2,HIGH"] {
        let text = cutting(&format!("{statement}\n"));
        for parameters in
            [in_form(PostForm::Tcp), with_changes(PostForm::Tcp), with_changes(PostForm::Machine)]
        {
            let refused = refusals(&parameters, &text);
            assert!(matches!(refused[0], (1, NotPosted::LoadItem { .. })), "{statement} {refused:?}");
        }
        // The request says the length, and the frame of the caller puts the tool in.
        let stated = PostParameters { length_number: Some(7), ..in_form(PostForm::Tcp) };
        let (output, _) = run(&stated, &text).expect(statement);
        assert_eq!(lengths(&output), ["G43.4 H7"]);
        run(&in_form(PostForm::Machine), &text).expect("the program has no length");
    }
    for statement in ["SET/OFSETL,3", "OFSTNO/4", "OFFSTL/5", "CUTCOM/ON,LENGTH,7", "LOADTL/2,ADJUST,5"] {
        let text = cutting(&format!("LOADTL/2,ADJUST,2\n{statement}\n"));
        for parameters in [in_form(PostForm::Tcp), with_changes(PostForm::Machine)] {
            assert_eq!(refusals(&parameters, &text), [(2, NotPosted::LengthRegister)], "{statement}");
        }
        let stated = PostParameters { length_number: Some(7), ..in_form(PostForm::Tcp) };
        let (_, report) = run(&stated, &text).expect(statement);
        let is_counted = !statement.starts_with("LOADTL");
        assert_eq!(report.first_not_done_line, is_counted.then_some(2), "{statement}");
    }
    // Where the words depend on the length, a stated one is not passed over.
    let mut parts = Preset::by_id("ac-head").expect("a preset").parts();
    parts.rotary_axes.iter_mut().for_each(|axis| axis.travel_deg = None);
    let head = Machine::new(parts).expect("a machine");
    let text = cutting("LOADTL/4,LENGTH,120.5\n");
    let refused = run_on(&head, &in_form(PostForm::Machine), &text);
    let Err(Fault::Lines(faults)) = refused else { panic!("posted") };
    assert!(matches!(faults.kept[0].kind, LineFaultKind::NotPosted(NotPosted::LoadLength)));
}

#[test]
fn only_a_tool_is_put_in_as_a_tool() {
    for statement in ["LOAD/PALLET,2", "LOAD/HEAD,3", "UNLOAD/PALLET,1", "LOAD/5"] {
        let text = format!("{}{statement}\n{}", cutting("LOADTL/1\n"), cutting(""));
        for parameters in [in_form(PostForm::Tcp), with_changes(PostForm::Tcp)] {
            let refused = refusals(&parameters, &text);
            let [(9, why @ NotPosted::ForTheControl { .. })] = refused[..] else { panic!("{refused:?}") };
            assert!(why.to_string().contains(statement), "{why}");
        }
    }
}

#[test]
fn a_change_and_an_end_after_a_cut_are_told_with_their_lines() {
    let cut = "LOADTL/1\nSPINDL/900,CLW\nFEDRAT/100,MMPM\nGOTO/0,0,9\nGOTO/4,0,1\n";
    let other = "LOADTL/2\nSPINDL/900,CLW\nGOTO/0,0,9\n";
    let retract = "RAPID\nGOTO/4,0,50\n";
    for form in [PostForm::Tcp, PostForm::Machine] {
        let told = |text: &str| {
            let (_, report) = run(&with_changes(form), text).expect("posted");
            (report.changes_after_cut, report.first_change_after_cut_line, report.cut_at_end_line)
        };
        assert_eq!(told(&format!("{cut}{other}")), (1, Some(6), Some(8)));
        assert_eq!(told(&format!("{cut}{retract}{other}{retract}")), (0, None, None));
    }
}

#[test]
fn statements_that_may_be_motions_are_refused_with_their_line() {
    for statement in ["HELIX/0,0,0,5,2", "SPLINE/4", "NURBS/3,CNTRL,4", "MOVETO/1,2,3"] {
        let text = format!("FEDRAT/100,MMPM\nGOTO/0,0,1\n{statement}\nGOTO/4,0,1\n");
        let refused = refusals(&in_form(PostForm::Tcp), &text);
        assert!(matches!(refused[0], (3, NotPosted::Unfollowable(_))), "{statement} {refused:?}");
    }
}

#[test]
fn refusals_name_what_is_wrong_and_nothing_else() {
    let tcp = in_form(PostForm::Tcp);
    let insert = "FEDRAT/100,MMPM\nGOTO/0,0,1\nINSERT G0 X5\nGOTO/4,0,1\nCUTCOM/OFF\nGOTO/5,0,1\n";
    let [(3, why @ NotPosted::ForTheControl { .. })] = refusals(&tcp, insert)[..] else { panic!("{insert}") };
    assert!(why.to_string().contains("INSERT G0 X5"), "{why}");
    for (point, axis) in [("9e8,0,-1", 'X'), ("0,-9e8,1", 'Y'), ("0,0,2e6", 'Z')] {
        let refused = refusals(&tcp, &format!("FEDRAT/100,MMPM\nGOTO/0,0,1\nGOTO/{point}\n"));
        assert!(
            matches!(refused[..], [(3, NotPosted::TooFar { axis: found, .. })] if found == axis),
            "{refused:?}"
        );
    }
    for form in [PostForm::Tcp, PostForm::Machine] {
        let text = "FEDRAT/1e-10,MMPM\nGOTO/0,0,1\nGOTO/4,0,1\n";
        let refused = refusals(&in_form(form), text);
        assert!(matches!(refused[0], (2, NotPosted::TooSlow { .. })), "{refused:?}");
        let limited = PostParameters { max_feed: Some(Feedrate::from_mm_per_min(15_000.0)), ..in_form(form) };
        let text = "FEDRAT/99999999,MMPM\nGOTO/0,0,1\nFEDRAT/15000,MMPM\nGOTO/4,0,1\n";
        let refused = refusals(&limited, text);
        assert!(matches!(refused[..], [(2, NotPosted::OverMaxFeed { .. })]), "{refused:?}");
    }
}
