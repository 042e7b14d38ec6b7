//! Which tool cuts is not assumed: each section of a program takes its own from the machine's tool table, sections of
//! unknown tools stay as they are and are named, and one tool of a request is not taken for several. And no feed is
//! written that nobody asked for.
#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::sync::Arc;

use trunnion::machine::Tool;
use trunnion::motion::{CalledTool, ToolKey, ToolName};
use trunnion::process::{
    CcParameters, CcReport, ContactSource, Fault, ListedTool, ProgramSetup, ToolTable, ToolUnknown, Tools,
    WarningKind,
};
use trunnion::units::{Feedrate, Length};

use crate::assume_nothing::{cc, warning};
use crate::models::finishing::{FeedForm, Form, ac_machine, blade, dome_near_pole, impeller_flank, tool};
use crate::models::set_ups::{at_zero, in_mm};
use crate::models::witness::scan;

/// A cut to be divided, from a point of its own; how finely hangs on the cutter.
const SECTION: &str = "G0 X50.000 Y0.000 Z9.000 A-20.000 C0.000\nG1 X50.000 Y20.000 Z2.000 A-40.000 C20.000 F1000\nG0 Z80.000\n";

fn listed(number: u32, cutter: Option<Tool>) -> ListedTool {
    let name = ToolName::new(format!("BALL_{number}").as_bytes());
    ListedTool { number: Some(number), name, cutter, length: Some(Length::from_mm(90.0)), worn: None }
}

fn with(cutter: Option<Tool>, number: Option<u32>, table: Vec<ListedTool>) -> CcParameters {
    let tools = Tools::with(number, Some(Length::ZERO), Arc::new(ToolTable::new(table)));
    let program = ProgramSetup { tools, ..at_zero() };
    CcParameters { contact: ContactSource::FeedPlane, ..CcParameters::new(cutter, program) }
}

fn done(parameters: &CcParameters, text: &str) -> (String, CcReport) {
    cc(&ac_machine(), parameters, text).unwrap_or_else(|fault| panic!("{text}{fault}"))
}

/// The section as this cutter alone has it.
fn section_of(cutter: Tool) -> String {
    let (output, report) = done(&with(Some(cutter), None, Vec::new()), &format!("G21 G90 G94\n{SECTION}"));
    assert!(report.blocks_out > report.blocks_in, "the cut is one to be divided");
    output.replace("G21 G90 G94\n", "")
}

#[test]
fn each_section_is_computed_with_the_tool_of_the_table_and_those_of_unknown_tools_stay_and_are_named() {
    let (small, large) = (tool(3.0, 3.0), tool(12.0, 12.0));
    assert_ne!(section_of(small), section_of(large));
    let text = format!("G21 G90 G94\nT3 M6\n{SECTION}T7 M6\n{SECTION}T12 M6\n{SECTION}M30\n");
    // A drill has no cutter in the table, and T7 is not there at all.
    for table in [
        vec![listed(3, Some(small)), listed(12, Some(large))],
        vec![listed(3, Some(small)), listed(7, None), listed(12, Some(large))],
    ] {
        for stated in [None, Some(tool(5.0, 5.0))] {
            let (output, report) = done(&with(stated, None, table.clone()), &text);
            let expected = format!(
                "G21 G90 G94\nT3 M6\n{}T7 M6\n{SECTION}T12 M6\n{}M30\n",
                section_of(small),
                section_of(large)
            );
            assert_eq!(output, expected);
            let used: Vec<_> =
                report.reading.tools.iter().map(|used| (used.called, used.is_unknown, used.lines)).collect();
            let called = |number| CalledTool::Changed(ToolKey::Number(number));
            assert_eq!(
                used,
                [(called(3), false, [3, 5]), (called(7), true, [7, 9]), (called(12), false, [11, 13])]
            );
            let told = warning(&report.warnings, WarningKind::ToolUnknown).expect("a warning");
            assert_eq!((told.count, told.line), (1, Some(8)));
            // A tool of the request that is not taken is said aloud.
            let unused = warning(&report.warnings, WarningKind::StatedToolUnused);
            assert_eq!(unused.is_some(), stated.is_some(), "{report:?}");
        }
    }
}

#[test]
fn one_tool_for_several_without_a_table_is_refused_with_their_numbers_and_one_number_is_an_answer() {
    let text = format!("G21 G90 G94\nT3 M6\n{SECTION}T7 M6\n{SECTION}T12 M6\n{SECTION}M30\n");
    let stated = Some(tool(5.0, 5.0));
    match cc(&ac_machine(), &with(stated, None, Vec::new()), &text) {
        Err(Fault::Tool(fault @ ToolUnknown::Several { count: 3, .. })) => {
            let said = fault.to_string();
            assert!(said.contains("T3, T7, T12") && said.contains("`tool_number`"), "{said}");
        }
        other => panic!("{other:?}"),
    }
    // The tip has no shape, and needs no tool. One that is stated is one of several.
    let by_tip = |cutter| CcParameters { contact: ContactSource::Tip, ..with(cutter, None, Vec::new()) };
    let several = cc(&ac_machine(), &by_tip(stated), &text);
    assert!(matches!(several, Err(Fault::Tool(ToolUnknown::Several { .. }))), "{several:?}");
    let by_tip = by_tip(None);
    assert_eq!(done(&by_tip, &text).1.motions_checked, 3);
    let (output, report) = done(&with(stated, Some(7), Vec::new()), &text);
    let expected =
        format!("G21 G90 G94\nT3 M6\n{SECTION}T7 M6\n{}T12 M6\n{SECTION}M30\n", section_of(tool(5.0, 5.0)));
    assert_eq!((output, report.motions_checked), (expected, 1));
    // No tool at all, and a table without any of them.
    for table in [Vec::new(), vec![listed(4, stated)]] {
        let refused = cc(&ac_machine(), &with(None, None, table), &text);
        assert!(matches!(refused, Err(Fault::Tool(ToolUnknown::NotListed { .. }))), "{refused:?}");
    }
    let missing = cc(&ac_machine(), &with(None, None, Vec::new()), &format!("G21 G90 G94\n{SECTION}M30\n"));
    assert!(matches!(missing, Err(Fault::Tool(ToolUnknown::Missing { .. }))), "{missing:?}");
    let other = cc(&ac_machine(), &with(stated, Some(8), Vec::new()), &text);
    assert!(matches!(other, Err(Fault::Tool(ToolUnknown::NoSuchTool { number: 8, .. }))), "{other:?}");
}

#[test]
fn a_change_that_prepares_the_next_tool_in_its_block_puts_in_the_one_before_it() {
    let (small, large) = (tool(3.0, 3.0), tool(12.0, 12.0));
    let table = vec![listed(1, Some(small)), listed(2, Some(large))];
    for (first, second) in [("T1 M6 T2", "M6"), ("T1 M6\nT2", "M6"), ("T1\nM6 (A)\nT2", "M6 T1")] {
        let text = format!("G21 G90 G94\n{first}\n{SECTION}{second}\n{SECTION}M30\n");
        let (output, _) = done(&with(None, None, table.clone()), &text);
        let second_tool = if second == "M6 T1" { small } else { large };
        let expected =
            format!("G21 G90 G94\n{first}\n{}{second}\n{}M30\n", section_of(small), section_of(second_tool));
        assert_eq!(output, expected, "{first} {second}");
    }
}

// ---- Feed ----------------------------------------------------------------------------------------------------------------

/// The largest F in blocks that move at a speed [mm/min].
fn fastest(text: &str) -> f64 {
    scan(text, ['A', 'C']).iter().filter(|line| !line.rapid).map(|line| line.feed).fold(0.0, f64::max)
}

#[test]
fn no_f_is_written_above_the_largest_and_blocks_that_need_more_stay_and_are_counted_and_told() {
    let ball = tool(5.0, 5.0);
    let mut left = 0;
    for part in [
        blade(ac_machine(), ball, 9, 3),
        impeller_flank(ac_machine(), ball, 9, 3),
        dome_near_pole(ac_machine(), ball, 13, 3),
    ] {
        for form in [Form::Plain, Form::ContactWords] {
            let text = part.program(form, FeedForm::PerMinute);
            // F1200 is programmed.
            for (stated, most) in
                [(None, 12_000.0), (Some(1250.0), 1250.0), (Some(1500.0), 1500.0), (Some(5000.0), 5000.0)]
            {
                for contact in [ContactSource::Auto, ContactSource::FeedPlane] {
                    let parameters = CcParameters {
                        contact,
                        max_feed: stated.map(Feedrate::from_mm_per_min),
                        tolerance: Length::from_um(2.0),
                        ..CcParameters::new(ball, in_mm(&part.setup))
                    };
                    let (output, report) = cc(&part.machine, &parameters, &text).expect("compensated");
                    let told = format!("{} {form:?} {stated:?} {contact:?}", part.name);
                    assert!(fastest(&output) <= most, "{told}: {}", fastest(&output));
                    let warned = warning(&report.warnings, WarningKind::FeedTooHigh);
                    assert_eq!(warned.map_or(0, |warning| warning.count), report.motions_left_over, "{told}");
                    assert!(report.motions_left_over <= report.motions_over_tolerance, "{told}");
                    if let Some(warned) = warned {
                        // It stands in the output as it did, and what is left of it is in `after`.
                        let line = usize::try_from(warned.line.expect("a line")).expect("few");
                        let block = text.lines().nth(line - 1).expect("the block");
                        let is_there = |written: &str| {
                            written.trim_end_matches(" F1200.") == block.trim_end_matches(" F1200.")
                        };
                        assert!(output.lines().any(is_there), "{told}: {block}");
                        assert!(report.after.max_mm > parameters.tolerance.mm(), "{told}");
                        assert!(
                            (report.after.max_mm - warned.max_distance_mm.expect("a distance")).abs() < 1e-12,
                            "{told}"
                        );
                        left += report.motions_left_over;
                    } else {
                        assert!(report.after.max_mm <= parameters.tolerance.mm(), "{told}");
                    }
                }
            }
        }
    }
    assert!(left > 0, "some blocks need more");
}

#[test]
fn an_exact_stop_in_a_divided_block_is_told_and_so_are_blocks_shorter_than_the_block_time() {
    let body = "G0 X50.000 Y0.000 Z0.000 A0.000 C0.000\nG1 X50.000 Y20.000 A20.000 C20.000 F1000\nX50.000 Y30.000 A0.000 C0.000\nM30\n";
    let parameters = |block_time_s| CcParameters {
        contact: ContactSource::Tip,
        block_time_s,
        ..CcParameters::new(tool(5.0, 5.0), at_zero())
    };
    for (head, more, told) in [
        ("G61", "", Some((2, Some(3)))),
        ("G64", "", None),
        ("G64", "G9 ", Some((1, Some(4)))),
        ("%_N_P_MPF\nG60", "", Some((2, Some(4)))),
        ("%_N_P_MPF\nG60 G64", "", None),
    ] {
        let text =
            format!("{head} G21 G90 G94\n{}", body.replace("\nX50.000 Y30", &format!("\n{more}X50.000 Y30")));
        let text = if head.starts_with('%') { text.replace("G21", "G71") } else { text };
        let (_, report) = done(&parameters(None), &text);
        assert_eq!(report.motions_over_tolerance, 2, "{text}");
        let stops = warning(&report.warnings, WarningKind::ExactStop);
        assert_eq!(stops.map(|stops| (stops.count, stops.line)), told, "{text}");
        assert!(warning(&report.warnings, WarningKind::ShortBlocks).is_none(), "no block time is stated");
    }
    // 20 mm and 10 mm at F1000 take 1.2 s and 0.6 s, in equal parts.
    let text = format!("G21 G90 G94\n{body}");
    let (output, _) = done(&parameters(None), &text);
    let moves = scan(&output, ['A', 'C']);
    let first = moves.iter().position(|line| line.text.contains("A20.000 C20.000")).expect("its end");
    let second = moves.len() - 1 - first;
    let [first_s, second_s] = [1.2 / first as f64, 0.6 / second as f64];
    for (block_time_s, count) in
        [(0.9 * first_s.min(second_s), 0), (1.1 * first_s.max(second_s), first + second)]
    {
        let (_, report) = done(&parameters(Some(block_time_s)), &text);
        let short = warning(&report.warnings, WarningKind::ShortBlocks);
        assert_eq!(short.map_or(0, |short| short.count), count as u64, "{block_time_s}");
        if let Some(short) = short {
            let least_s = short.min_time_s.expect("a time");
            assert!((least_s - first_s.min(second_s)).abs() < 1e-9, "{least_s} {first_s} {second_s}");
        }
    }
}
