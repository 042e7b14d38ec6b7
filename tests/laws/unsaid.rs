//! What a block means and does not say itself: the feed that stands, the centre of an arc, the tool that cuts. One
//! test a danger, seen without the code that reads programs back.
#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::machine::{LocationError, Machine, Preset};
use trunnion::process::{
    CcParameters, CcStep, CompensationParameters, ContactSource, Fault, LineFaultKind, NotPosted,
    PostParameters, SingularityAction, SingularityParameters, ToolUnknown, WarningKind, WearParameters,
    WornCutter, compensate, compensate_wear, post, treat_singular_regions,
};
use trunnion::program::Dialect;
use trunnion::units::{Angle, Length};

use crate::models::displaced::{errors, with_errors};
use crate::models::finishing::{ac_machine, tool};
use crate::models::pole_passes;
use crate::models::set_ups::at_zero;
use crate::one_pass;
use trunnion::process::ProgramSetup;

/// A block that has to be divided, behind its start.
const DIVIDED: &str =
    "G1 X0.000 Y0.000 Z5.000 A10.000 C0.000 F1000\nG1 X20.000 Y0.000 Z5.000 A25.000 C60.000\n";

fn compensated(text: &str) -> String {
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    let go_on = || ControlFlow::Continue(());
    compensate(&ac_machine(), &CcParameters::new(tool(5.0, 5.0), at_zero()), &source, &mut output, &go_on)
        .unwrap_or_else(|fault| panic!("{text}{fault:?}"));
    String::from_utf8(output).expect("text")
}

/// A control that takes F as it comes.
#[derive(Clone, Copy)]
struct Control {
    skips: bool,
    /// F of a dwell stays.
    keeps_dwell: bool,
}

impl Control {
    /// F at each block, and its text without block delete.
    fn run(self, text: &str) -> Vec<(f64, &str)> {
        let mut modal = 0.0;
        let mut blocks = Vec::new();
        for line in text.lines() {
            if line.starts_with('/') && self.skips {
                continue;
            }
            let line = line.trim_start_matches('/');
            let feed = line.split(' ').find_map(|word| word.strip_prefix('F')?.parse().ok());
            if !line.starts_with("G4 ") || self.keeps_dwell {
                modal = feed.unwrap_or(modal);
            }
            blocks.push((modal, line));
        }
        blocks
    }

    fn feed_at(self, text: &str, block: &str) -> f64 {
        let found = self.run(text).into_iter().find(|(_, line)| line.starts_with(block));
        found.unwrap_or_else(|| panic!("{block}: {text}")).0
    }
}

#[test]
fn every_motion_has_the_sources_feed_whether_blocks_are_skipped_or_not() {
    for between in [
        "/G1 X21.000 F300\n",
        "/G0 X21.000 F300\n",
        "/G1 X21.000\n",
        "/F300\n",
        "/G0 Z9.000\nG0 Z8.000\n/G1 F300\n",
        "G4 F2\n",
        "G0 X21.000\nG4 F2\n",
        "",
    ] {
        let source = format!("{DIVIDED}{between}G1 X22.000 Y1.000\nM30\n");
        let output = compensated(&source);
        assert!(output.lines().count() > source.lines().count(), "{output}");
        for (skips, keeps_dwell) in [(false, false), (false, true), (true, false), (true, true)] {
            let control = Control { skips, keeps_dwell };
            for block in ["G1 X22.000", "G1 X21.000"] {
                if source.contains(block) && !(skips && block.contains("21")) {
                    let [meant, found] = [&source, &output].map(|text| control.feed_at(text, block));
                    assert!((meant - found).abs() < 1e-9, "{block} {meant} {found}\n{output}");
                }
            }
        }
    }
}

#[test]
fn the_feed_is_back_before_its_meaning_changes_behind_words_that_move_nothing() {
    for shift in ["G92 X5.000", "G10 L2 P1 X5.000"] {
        let output = compensated(&format!("{DIVIDED}{shift}\nG95\nG94\nG1 X22.000\nM30\n"));
        let control = Control { skips: false, keeps_dwell: false };
        assert!((control.feed_at(&output, "G95") - 1000.0).abs() < 1e-9, "{output}");
    }
}

/// Motions past the pole of an AC table.
const OVER_THE_POLE: &str = "G21 G90 G94\nG1 X-10.0000 Y0.0000 Z5.0000 A0.6000 C10.0000 F1000\nX-5.0000 A0.3000 C20.0000\nX0.0000 A0.1500 C60.0000\nX5.0000 A0.3000 C110.0000\nX10.0000 A0.6000 C120.0000\nX15.0000 A0.9000 C124.0000\n";

fn regions(action: SingularityAction) -> SingularityParameters {
    SingularityParameters { axis_tolerance: Angle::from_deg(0.2), ..SingularityParameters::new(action) }
}

#[test]
fn treated_regions_give_the_feed_back_before_its_meaning_changes() {
    let machine = pole_passes::machine("ac-table");
    let parameters = CcParameters { contact: ContactSource::Tip, ..tip_parameters() };
    for action in [SingularityAction::Densify, SingularityAction::Smooth] {
        for modes in ["G95\nG94\n", "G20\nG21\n", "/G1 F300\n"] {
            let source = format!("{OVER_THE_POLE}{modes}G1 X22.0000\nM30\n");
            let mut output = Vec::new();
            let go_on = || ControlFlow::Continue(());
            let bytes = source.clone().into_bytes();
            treat_singular_regions(&machine, &parameters, &regions(action), &bytes, &mut output, &go_on)
                .unwrap_or_else(|fault| panic!("{fault:?}"));
            let output = String::from_utf8(output).expect("text");
            assert_ne!(source, output);
            let control = Control { skips: true, keeps_dwell: false };
            let first = modes.lines().next().expect("a mode");
            let blocks: Vec<f64> = control.run(&output).into_iter().map(|(feed, _)| feed).collect();
            assert!(blocks.iter().any(|feed| *feed > 0.0 && (feed - 1000.0).abs() > 1.0), "{output}");
            let at = if first.starts_with('/') { "G1 X22" } else { first };
            assert!((control.feed_at(&output, at) - 1000.0).abs() < 1e-9, "{action:?} {modes}{output}");
        }
    }
}

fn tip_parameters() -> CcParameters {
    CcParameters::new(tool(5.0, 5.0), at_zero())
}

#[test]
fn lines_that_were_put_in_twice_lead_to_those_of_the_upload() {
    let machine = with_errors(&pole_passes::machine("ac-table"), errors());
    // C alone gains X and Y, and with them another F, which is given back before the reference return.
    let text = format!(
        "{OVER_THE_POLE}C160.0000\nG28 Z0.0000\nG1 X20.0000 Y0.0000 Z5.0000 A5.0000 C160.0000\nX30.0000 A30.0000 C200.0000\nM30\nG0 X1\n"
    );
    let parameters = CompensationParameters {
        location_errors: true,
        singularity: Some(regions(SingularityAction::Densify)),
        cc: Some(CcStep { contact: ContactSource::Tip, ..CcStep::new(tool(5.0, 5.0)) }),
        ..CompensationParameters::new(at_zero())
    };
    let (output, report, changes) = one_pass::done(&machine, &parameters, &text);
    assert!(report.singularity.as_ref().is_some_and(|found| found.blocks_inserted > 10), "{report:?}");
    let fed_back = output.lines().position(|line| line.starts_with("G28")).expect("G28");
    assert_eq!(output.lines().nth(fed_back - 1), Some("F1000."), "{output}");
    let lines: Vec<u64> = changes.iter().map(|change| change.line).collect();
    assert!(lines.is_sorted() && lines.last() == Some(&11), "{lines:?}");
    for (line, wanted) in
        text.lines().zip(1_u64..).filter(|(line, _)| line.contains('X') && !line.contains("G0"))
    {
        assert!(lines.contains(&wanted), "{line}: {lines:?}");
    }
    let end = report.warnings.iter().find(|warning| warning.kind == WarningKind::TextAfterEnd);
    assert_eq!(end.and_then(|warning| warning.line), Some(12), "{:?}", report.warnings);
}

/// The second axis stands elsewhere by so much.
fn moved_table(offset_mm: Vec3) -> Machine {
    let parts = Preset::by_id("ac-table").expect("a preset").parts();
    let error = LocationError { translation_mm: offset_mm, ..LocationError::default() };
    with_errors(&Machine::new(parts).expect("a machine"), [LocationError::default(), error])
}

#[test]
fn an_arc_whose_centre_stays_is_not_moved_away_from_it() {
    let location = CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    let head = "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nL X+8.000 Y+0.000 Z+0.000 A+0.000 C+90.000 R0 F500\n";
    let program = |arc: &str| format!("{head}{arc}END PGM T MM\n");
    let sideways = moved_table(Vec3::new(0.04, 0.0, 0.0));
    let by_radius = program("CR X-8.000 Y+0.000 R+8.000 DR+\n");
    let (output, _, _) = one_pass::done(&sideways, &location, &by_radius);
    assert_ne!(output, by_radius, "both ends move");
    for (arc, line) in [
        ("CC X+0.000 Y+0.000\nC X-8.000 Y+0.000 DR+\n", 5),
        ("CC X+0.000 Y+0.000\nC DR+\n", 5),
        ("CR X-8.000 Y+0.000 R+8.000 DR+\nCT X-8.000 Y-9.000\n", 4),
        ("CC X+0.000 Y+0.000\nCT X-8.000 Y-9.000\n", 5),
    ] {
        let text = program(arc);
        let Err(Fault::Lines(faults)) = one_pass::run(&sideways, &location, &text) else { panic!("{text}") };
        assert_eq!(faults.kept[0].line, line, "{faults:?}");
        assert!(matches!(faults.kept[0].kind, LineFaultKind::ArcShift { .. } | LineFaultKind::NotMovable(_)));
    }
    // The full circle of cutter location data has a centre as well, in a plane of any direction.
    let text = "UNITS/MM\nFEDRAT/500.,MMPM\nGOTO/8.0,0,0,0,0,1\nCIRCLE/0,0,0,0,0,1,8.0\nGOTO/8.0,0,0,0,0,1\n";
    let shorter = WearParameters {
        contact: ContactSource::FeedPlane,
        shorter_by: Length::from_mm(0.25),
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(5.0, 4.5)), at_zero())
    };
    let moved = worn(&shorter, text);
    assert!(matches!(moved, Err(Fault::Lines(_))), "{moved:?}");
}

fn worn(parameters: &WearParameters, text: &str) -> Result<String, Fault> {
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    compensate_wear(&ac_machine(), parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok(String::from_utf8(output).expect("text"))
}

#[test]
fn a_tool_that_only_t_puts_in_and_another_edge_are_another_cutter() {
    let by_feed = WearParameters {
        contact: ContactSource::FeedPlane,
        program: ProgramSetup { dialect: Some(Dialect::Siemens), ..at_zero() },
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero())
    };
    let pass =
        |x: u32| format!("G0 X{x}.000 Y0.000 Z20.000 A-30.000 C0.000\nG1 Y10.000 Z24.000 F800\nG0 Z90.000\n");
    let refused = |between: [&str; 2]| {
        let [first, second] = between;
        let text = format!("{first}\n{}{second}\n{}M30\n", pass(0), pass(5));
        match worn(&by_feed, &text) {
            Ok(_) => None,
            Err(Fault::Tool(ToolUnknown::Several { count: 2, tools, is_for_one: true })) => Some(tools),
            Err(fault) => panic!("{fault:?}"),
        }
    };
    let tools = |first: &str, second: &str| Some(format!("{first}, {second}"));
    let other_edge = "a tool that the text does not name";
    assert_eq!(refused(["T=\"MILL_10\" D1", "T=\"BALL_6\" D1"]), tools("\"MILL_10\"", "\"BALL_6\""));
    assert_eq!(refused(["T1 D1", "T2 D1"]), tools("T1", "T2"));
    assert_eq!(refused(["T1 D1", "T1 D1"]), None);
    assert_eq!(refused(["T1 D1", "D2"]), tools("T1", other_edge));
    assert_eq!(refused(["T1 M6", "D2"]), tools("T1", other_edge));
    assert_eq!(refused(["T1 M6\nD1", "D1"]), None);
    // With a changer T only makes ready.
    assert_eq!(refused(["T1\nM6", "T2"]), None);
    assert_eq!(refused(["T1\nM6", "T2\nM6"]), tools("T1", "T2"));
}

#[test]
fn the_end_of_a_subprogram_stays_at_the_end_of_its_last_block() {
    for end in ["M17", "RET"] {
        let text =
            format!("G1 G90 X0.000 Y0.000 Z5.000 A10.000 C0.000 F1000\nN40 X20.000 A25.000 C60.000 {end}\n");
        let parameters = CcParameters {
            program: ProgramSetup { dialect: Some(Dialect::Siemens), ..at_zero() },
            ..tip_parameters()
        };
        let mut output = Vec::new();
        let go_on = || ControlFlow::Continue(());
        compensate(&ac_machine(), &parameters, &text.clone().into_bytes(), &mut output, &go_on)
            .unwrap_or_else(|fault| panic!("{fault:?}"));
        let output = String::from_utf8(output).expect("text");
        let lines: Vec<&str> = output.lines().collect();
        assert!(lines.len() > 2, "{output}");
        let ends: Vec<bool> = lines.iter().map(|line| line.ends_with(end)).collect();
        assert_eq!(ends.iter().filter(|ends| **ends).count(), 1, "{output}");
        assert_eq!(ends.last(), Some(&true), "{output}");
    }
}

#[test]
fn an_arc_between_two_points_that_are_one_but_for_the_last_decimal_is_refused() {
    let posted = |start: &str, end: &str| {
        let text =
            format!("RAPID\nGOTO/{start},0,0,1\nFEDRAT/500.,MMPM\nCIRCLE/0,0,0,0,0,1,10\nGOTO/{end},0,0,1\n");
        let mut output = Vec::new();
        let go_on = || ControlFlow::Continue(());
        let source = text.into_bytes();
        post(&ac_machine(), &PostParameters::new(at_zero()), &source, &mut output, &go_on)
            .map(|report| report.points)
    };
    for y in ["0.0001", "-0.0001", "0.0002"] {
        let Err(Fault::Lines(faults)) = posted("10.0000,0,0", &format!("10.0000,{y},0")) else {
            panic!("{y}")
        };
        assert_eq!(faults.kept[0].line, 5);
        assert!(matches!(faults.kept[0].kind, LineFaultKind::NotPosted(NotPosted::Arc { .. })));
    }
    let count = |start: &str, end: &str| posted(start, end).unwrap_or_else(|fault| panic!("{fault:?}"));
    let circle = count("10.0000,0,0", "10.0000,0,0");
    assert!(circle > 50, "{circle}");
    assert_eq!(count("10.0000,0,0", "10.0000,0.0010,0"), 2, "a short arc");
    assert!(count("10.0000,0,0", "10.0000,-0.0010,0").abs_diff(circle) <= 1, "nearly all the way around");
    assert_eq!(count("10.0000,0,0", "10.0000,0,3.0000"), circle, "one turn of a helix");
}
