//! Habits of programs that a compensation must respect, one small program each.
#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use trunnion::machine::Tool;
use trunnion::motion::Interpolation;
use trunnion::process::{
    Budget, CcParameters, CcReport, ContactSource, Fault, LineFaultKind, OutputForm, compensate,
};
use trunnion::program::Dialect;
use trunnion::units::{Feedrate, Length};

use crate::models::finishing::{ac_machine, tool};
use crate::models::set_ups::at_zero;
use trunnion::process::ProgramSetup;

/// A long first block that has to be divided.
const START: &str = "G1 X0.000 Y0.000 Z5.000 A10.000 C0.000 F1000\n";
const LONG: &str = "G1 X20.000 Y0.000 Z5.000 A25.000 C60.000\n";

fn ball() -> Tool {
    tool(5.0, 5.0)
}

fn with(parameters: &CcParameters, program: &str) -> Result<(String, CcReport), Fault> {
    let mut output = Vec::new();
    let source = program.as_bytes().to_vec();
    let report = compensate(&ac_machine(), parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

fn done(program: &str) -> (String, CcReport) {
    with(&CcParameters::new(ball(), at_zero()), program).unwrap_or_else(|fault| panic!("{program}{fault:?}"))
}

fn feed_of(line: &str) -> Option<f64> {
    line.split(' ').find_map(|word| word.strip_prefix('F')).and_then(|number| number.parse().ok())
}

#[test]
fn a_rest_is_no_motion() {
    let (output, report) =
        done(&format!("{START}{LONG}{LONG}G1 X21.000 Y0.000 Z5.000 A25.000 C60.000\nM30\n"));
    assert_eq!(report.motions_checked, 2);
    // The second one stays where it is, and brings the feed back.
    let rest = output.lines().find(|line| line.starts_with(LONG.trim_end())).expect("the rest");
    assert_eq!(feed_of(rest), Some(1000.0));
    let csv = "X,Y,Z,A,C,nx,ny,nz,F\n0,0,5,10,0,0,0,1,900\n0,0,5,10,0,0,0.1,1,900\n1,0,5,10,0,0,0.1,1,900\n";
    assert_eq!(done(csv).0, csv);
}

#[test]
fn the_feed_is_given_back_to_the_next_block_that_uses_it() {
    let after = "G1 X21.000\nG1 X22.000\n";
    let (output, report) = done(&format!("{START}{LONG}G0 X20.500\n{after}M30\n"));
    let lines: Vec<&str> = output.lines().collect();
    let restored = lines.iter().position(|line| line.starts_with("G1 X21.000")).expect("the line");
    assert_eq!(feed_of(lines[restored]), Some(1000.0));
    assert!(lines.contains(&"G0 X20.500") && lines.contains(&"G1 X22.000"));
    assert_eq!(report.feeds_restored, 1);
    // Before a subprogram returns, and not in a block that the operator may skip.
    for (program, next) in [
        (format!("O1000\n{START}{LONG}M99\n"), "M99"),
        (format!("{START}{LONG}M98 P7\nM30\n"), "M98 P7"),
        (format!("{START}{LONG}/G1 X21.500\nG1 X22.000\nM30\n"), "/G1 X21.500"),
    ] {
        let (output, _) = done(&program);
        let lines: Vec<&str> = output.lines().collect();
        let at = lines.iter().position(|line| *line == next).unwrap_or_else(|| panic!("{output}"));
        assert_eq!((feed_of(lines[at - 1]), lines[at - 1].contains('X')), (Some(1000.0), false), "{output}");
    }
}

#[test]
fn divided_blocks_keep_their_functions_in_order() {
    let program = format!("{START}N20 G1 X20.000 Y0.000 Z5.000 A25.000 C60.000 M8 M9 (half way)\nN30 M30\n");
    let (output, _) = done(&program);
    let lines: Vec<&str> = output.lines().collect();
    let first = lines[1];
    assert!(
        first.starts_with("N20 G1 X") && first.contains("M8") && first.ends_with("(half way)"),
        "{first}"
    );
    assert!(!first.contains("M9"));
    let last = lines[lines.len() - 2];
    assert!(last.contains("X20.000") && last.ends_with("M9"), "{last}");
    assert_eq!(output.matches("N20").count(), 1);
}

#[test]
fn coarse_blocks_use_the_decimals_that_the_program_has_elsewhere() {
    let coarse = "G1 X10. Y0. Z5. A10. C20. F1000.\nG1 X11. Y0. Z5. A12. C25.\n";
    let fine = format!("{coarse}G1 X12.345 Y0. Z5. A12. C25.123\nM30\n");
    assert!(done(&fine).1.after.max_mm <= 0.010);
    // Without a finer word anywhere the tolerance is out of reach, and the value that is not comes back.
    let Err(Fault::Lines(faults)) = with(&CcParameters::new(ball(), at_zero()), &format!("{coarse}M30\n"))
    else {
        panic!("whole millimetres cannot keep 10 µm");
    };
    let LineFaultKind::ToleranceOutOfReach { reachable_um, .. } = faults.kept[0].kind else {
        panic!("{faults:?}")
    };
    assert!(reachable_um > 10.0);
    assert_eq!(faults.kept[0].line, 2);
    let loose = CcParameters {
        tolerance: Length::from_um(reachable_um * 1.01),
        ..CcParameters::new(ball(), at_zero())
    };
    assert!(with(&loose, &format!("{coarse}M30\n")).is_ok());
}

#[test]
fn increments_inches_and_modal_words_are_followed() {
    // Off the grid of the increments' decimals.
    let (output, _) =
        done("G1 X0.1234 Y0 Z5 A10 C0 F1000\nG91 G1 X20.000 A15.000 C60.000\nG90 G1 X21.000\nM30\n");
    let parts: Vec<f64> = output
        .lines()
        .skip(1)
        .take_while(|line| !line.starts_with("G90"))
        .map(|line| line.split(['X', ' ']).find_map(|word| word.parse::<f64>().ok()).expect("X"))
        .collect();
    assert!(parts.len() > 2 && (parts.iter().sum::<f64>() - 20.0).abs() < 1e-9, "{parts:?}");
    let (_, report) =
        done("G20\nG1 X0.0000 Y0.0000 Z0.2000 A10.000 C0.000 F40.\nX0.8000 A25.000 C60.000\nM30\n");
    assert_eq!(report.motions_over_tolerance, 1);
    // Y and Z are modal: the corrected path needs them, the end puts them back.
    let (output, _) = done(&format!("{START}X20.000 A25.000 C60.000\nX21.000\nM30\n"));
    let last = output.lines().rev().nth(2).expect("a line");
    assert!(last.contains("Y0.000") && last.contains("Z5.000"), "{output}");
}

#[test]
fn a_feed_parameter_counts_where_the_program_has_none() {
    let program = format!("{}{LONG}G1 X21.000\nM30\n", START.replace(" F1000", ""));
    let (plain, report) = done(&program);
    assert!(!plain.contains('F'));
    assert_eq!(report.warnings.iter().filter(|warning| warning.kind.name() == "no_feed").count(), 1);
    let given = CcParameters {
        program: ProgramSetup { feed: Some(Feedrate::from_mm_per_min(1500.5)), ..at_zero() },
        ..CcParameters::new(ball(), at_zero())
    };
    let (output, _) = with(&given, &program).expect("compensated");
    assert!(output.contains("G1 X21.000 F1500.5"), "{output}");
    let interpolated =
        CcParameters { output: OutputForm::Interpolated, ..CcParameters::new(ball(), at_zero()) };
    let Err(Fault::Lines(faults)) = with(&interpolated, &program) else { panic!("needs a feed") };
    assert_eq!(faults.kept[0].kind, LineFaultKind::NoFeed);
}

#[test]
fn one_bad_contact_is_one_fault() {
    let csv = "X,Y,Z,A,C,nx,ny,nz\n0,0,5,0,0,0,0,1\n1,0,5,0,0,0,0,-1\n2,0,5,0,0,0,0,1\n3,0,5,0,0,0,0,1\n";
    let Err(Fault::Lines(faults)) = with(&CcParameters::new(ball(), at_zero()), csv) else {
        panic!("an undercut")
    };
    assert_eq!((faults.total, faults.kept[0].line), (1, 3));
}

#[test]
fn words_that_are_no_contact_points_do_not_choose_the_contact() {
    let (output, report) = done(&format!("G28 U0 V0 W0\n{START}{LONG}M30\n"));
    assert_eq!(report.contact, ContactSource::Tip);
    assert!(report.motions_over_tolerance == 1 && output.lines().count() > 5);
}

#[test]
fn what_a_program_costs_is_bounded() {
    let parameters = CcParameters {
        output: OutputForm::Interpolated,
        budget: Budget { max_blocks_out: 1000, ..Budget::default() },
        ..CcParameters::new(ball(), at_zero())
    };
    // Five minutes of two-millisecond steps in one block, a thousand blocks allowed.
    assert!(matches!(
        with(&parameters, &format!("{START}{}M30\n", LONG.replace('\n', " F150\n"))),
        Err(Fault::TooCostly { .. })
    ));
    let Err(Fault::Lines(faults)) =
        with(&parameters, &format!("{START}{}M30\n", LONG.replace('\n', " F0.001\n")))
    else {
        panic!("a block of hours");
    };
    assert!(matches!(faults.kept[0].kind, LineFaultKind::TooManyParts { .. }));
    let cancelled = compensate(
        &ac_machine(),
        &CcParameters::new(ball(), at_zero()),
        &format!("{START}{LONG}").into_bytes(),
        &mut Vec::new(),
        &|| ControlFlow::Break(()),
    );
    assert!(matches!(cancelled, Err(Fault::Cancelled)));
}

#[test]
fn a_contact_that_swings_round_the_tool_is_left_alone() {
    // Feed-plane contact of a flat cutter jumps from one side to the other where the lead changes its sign.
    let program = "G1 X0.000 Y0.000 Z5.000 A1.000 C0.000 F1000\nY15.000\nY30.000 A-1.000\nY45.000\nM30\n";
    let flat = CcParameters {
        contact: ContactSource::FeedPlane,
        program: ProgramSetup { interpolation: Some(Interpolation::Tcp), ..at_zero() },
        ..CcParameters::new(tool(8.0, 0.0), at_zero())
    };
    let (output, report) = with(&flat, program).expect("compensated");
    assert_eq!(output, program);
    assert!(
        report.warnings.iter().any(|warning| warning.kind.name() == "contact_swings"),
        "{:?}",
        report.warnings
    );
}

#[test]
fn contact_words_go_on_from_the_last_ones_stated() {
    let program = |first: &str| {
        format!(
            "G90 G21 G94 G17\nG1 X0.0000 Y0.0000 Z0.0000 A-30.0000 C0.0000{first} F1200\nA-31.0000\n\
             X20.0000 Y10.0000 A-35.0000 C20.0000 U1.0000 V2.0000 W3.0000\nM30\n"
        )
    };
    let parameters = CcParameters { contact: ContactSource::Tip, ..CcParameters::new(ball(), at_zero()) };
    let (output, report) = with(&parameters, &program(" U0.0000 V0.0000 W0.0000")).expect("a program");
    assert!(report.blocks_out > report.blocks_in, "{report:?}");
    let u: Vec<f64> = output
        .lines()
        .filter_map(|line| line.split(' ').find_map(|word| word.strip_prefix('U'))?.parse().ok())
        .collect();
    assert!(u.len() > 10 && u.windows(2).all(|pair| pair[0] < pair[1]), "{output}");
    assert!((u[u.len() - 1] - 1.0).abs() < 1e-12);
    // Stated for the first time: where they begin is not known, so only their end has them.
    let (output, _) = with(&parameters, &program("")).expect("a program");
    let stated: Vec<&str> = output.lines().filter(|line| line.contains('U')).collect();
    assert!(matches!(stated[..], [last] if last.contains("U1.0000 V2.0000 W3.0000")), "{output}");
}

/// The F that every axis word of the program runs at, modal and by block.
fn feeds(program: &str) -> Vec<f64> {
    let mut modal = 0.0;
    program
        .lines()
        .filter_map(|line| {
            modal = feed_of(line).unwrap_or(modal);
            line.contains('X').then_some(modal)
        })
        .collect()
}

#[test]
fn the_feed_is_back_before_anything_changes_what_it_means() {
    for modes in ["G20\nG21\n", "G95\nG94\n", "G0 Z5.000\nG20\nG21\nG1\n"] {
        let (output, report) = done(&format!("{START}{LONG}{modes}X0.000\nM30\n"));
        assert!(report.motions_over_tolerance > 0 && report.feeds_restored == 1, "{output}");
        let last = feeds(&output).last().copied();
        assert_eq!(last, Some(1000.0), "{modes}{output}");
        let mode = output.find(&modes[modes.len() - 8..]).expect("the modes are there");
        let given_back = output.rfind("F1000").expect("given back");
        assert!(given_back < mode || modes.starts_with("G0"), "{output}");
    }
}

#[test]
fn words_beside_a_cancelled_mirror_or_a_tool_offset_are_no_motion() {
    for block in ["G50.1 X0 Y0", "G50 X0", "G69 X0", "G43.1 Z7."] {
        let program = format!("{START}{LONG}{block}\nX110.000 C17.000\nM30\n");
        let (output, _) = done(&program);
        assert!(output.contains(&format!("\n{block}\n")), "{output}");
        assert!(output.ends_with("X110.000 C17.000\nM30\n"), "{output}");
    }
}

#[test]
fn f_has_no_sign_where_coordinates_have_one() {
    let program = "G1 X+0.000 Y+0.000 Z+5.000 A+10.000 C+0.000 F1000\nX+20.000 A+25.000 C+60.000\nX+40.000 A+10.000 C+0.000\nM30\n";
    let (output, report) = done(program);
    assert!(report.motions_over_tolerance == 2 && !output.contains("F+"), "{output}");
}

#[test]
fn the_number_of_a_divided_block_in_g93_is_back_before_a_cycle_or_another_mode_takes_it() {
    let start = "G93 G1 X0.000 Y0.000 Z5.000 A10.000 C0.000 F30\n";
    let long = "G1 X20.000 Y0.000 Z5.000 A25.000 C60.000 F6\n";
    let last_f = |text: &str, behind: &str| {
        let (before, _) = text.split_once(behind).unwrap_or_else(|| panic!("{text}"));
        before.lines().rev().find_map(feed_of)
    };
    for (behind, restored) in [
        ("G81 X20.000 Y1.000 Z2.000 R6.000\n", 1),
        ("M98 P100\n", 1),
        ("G94\nG1 X21.000\n", 1),
        ("G94\nG81 X20.000 Y1.000 Z2.000 R6.000\n", 1),
        ("G0 Z90.000\nG94\nX21.000\nM30\n", 0),
        ("G94 G1 X21.000 F500\n", 0),
        ("G94\nG1 X21.000 F500\n", 0),
        ("G1 X21.000 Y0.000 Z5.000 A25.000 C60.000 F30\n", 0),
    ] {
        let (output, report) = done(&format!("{start}{long}{behind}M30\n"));
        assert!(report.motions_over_tolerance == 1, "{output}");
        assert_eq!(report.feeds_restored, restored, "{output}");
        let first = behind.lines().next().unwrap_or_default();
        if restored > 0 {
            assert_eq!(last_f(&output, &format!("{first}\n")), Some(6.0), "{output}");
        }
    }
}

#[test]
fn a_text_of_which_the_stated_dialect_reads_nothing_is_refused() {
    let iso = format!("{START}{LONG}M30\n");
    let heidenhain =
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+10 C+0 R0 F1000\n2 L X+20 A+25 C+60\n3 END PGM A MM\n";
    for (text, dialect) in [
        (iso.as_str(), Dialect::Heidenhain),
        (iso.as_str(), Dialect::Apt),
        (heidenhain, Dialect::Iso),
        (heidenhain, Dialect::Siemens),
        (heidenhain, Dialect::Apt),
        ("GOTO/0,0,0,0,0,1\nGOTO/10,0,0,0.1,0,0.99\nFINI\n", Dialect::Siemens),
        ("GOTO/0,0,0,0,0,1\nGOTO/10,0,0,0.1,0,0.99\nFINI\n", Dialect::Heidenhain),
    ] {
        let parameters = CcParameters {
            program: ProgramSetup { dialect: Some(dialect), ..at_zero() },
            ..CcParameters::new(ball(), at_zero())
        };
        match with(&parameters, text) {
            Err(Fault::NothingFollowed { .. } | Fault::NoMotion | Fault::Program(_)) => {}
            other => panic!("{dialect:?} {text}{other:?}"),
        }
    }
    // Read and understood, but with nothing to check: three axes, cycles, radius compensation, a called program.
    for text in [
        "G1 X0. Y0. Z5. F500\nX10.\nM30\n",
        "G81 X10. Y0. Z-5. R2. F100\nX20.\nG80\nM30\n",
        "G41 D1\nG1 X0. Y0. Z5. A0. C0. F500\nX10.\nM30\n",
        "M98 P100\nG1 X10. F500\nM30\n",
    ] {
        let parameters = CcParameters {
            program: ProgramSetup { dialect: Some(Dialect::Iso), ..at_zero() },
            ..CcParameters::new(ball(), at_zero())
        };
        let (output, report) = with(&parameters, text).unwrap_or_else(|fault| panic!("{text}{fault:?}"));
        assert!(output == text && report.motions_checked == 0);
    }
}

#[test]
fn whether_to_go_on_is_asked_within_a_single_dear_block() {
    let asked = AtomicU64::new(0);
    let turns = format!("{START}G91 G1 A25.000 C9000.000\nM30\n").into_bytes();
    let parameters = CcParameters { tolerance: Length::from_um(5.0), ..CcParameters::new(ball(), at_zero()) };
    let machine = ac_machine();
    let run = |most: u64| {
        asked.store(0, Ordering::Relaxed);
        compensate(&machine, &parameters, &turns, &mut Vec::new(), &|| {
            let now = asked.fetch_add(1, Ordering::Relaxed);
            if now < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })
    };
    let whole = run(u64::MAX);
    let times = asked.load(Ordering::Relaxed);
    assert!(times > 20, "{times}: {whole:?}");
    for most in [times / 4, times / 2] {
        assert!(matches!(run(most), Err(Fault::Cancelled)));
    }
    let parameters =
        CcParameters { budget: Budget { max_evaluations: 20_000, ..Budget::default() }, ..parameters };
    let dear = with(&parameters, std::str::from_utf8(&turns).expect("text"));
    assert!(matches!(dear, Err(Fault::TooCostly { .. })));
}

#[test]
fn a_line_that_is_too_long_is_named_by_its_number_behind_lines_that_were_only_glanced_at() {
    for (head, row, end) in [
        ("G21 G90\nG1 F1000\n", "X1.000 Y2.000\n", "\n"),
        ("G21 G90\r\nG1 F1000\r\n", "X1.000 Y2.000\r\n", "\r\n"),
        ("X,Y,Z,A,C\n", "1.0,2.0,3.0,4.0,5.0\n", "\n"),
    ] {
        let rows = 20_000;
        let text = format!("{head}{}{}{end}{row}", row.repeat(rows), "X1 ".repeat(40_000));
        let line = head.lines().count() + rows + 1;
        match with(&CcParameters::new(ball(), at_zero()), &text) {
            Err(Fault::Unreadable(fault)) => {
                let told = fault.to_string();
                assert!(told.contains(&line.to_string()), "{told}: it is line {line}");
            }
            other => panic!("{other:?}"),
        }
    }
}
