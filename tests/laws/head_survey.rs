//! A survey of the head alone leads to the same program and report as a survey of the whole text, or to a fault after
//! which the whole text is surveyed.

use std::fmt::Write as _;
use std::ops::ControlFlow;

use trunnion::machine::{Machine, Preset};
use trunnion::process::{
    CcParameters, CcReport, ContactSource, Fault, ProgramSetup, SurveyExtent, WearParameters, WearReport,
    WornCutter, compensate, compensate_wear,
};

use crate::models::finishing::{ac_machine, tool};
use crate::models::set_ups::at_zero;

/// More blocks than any head has.
const BLOCKS: u32 = 12_000;

/// A pass whose every fiftieth block is over tolerance. `late` comes after three quarters of it.
fn program(late: &str) -> Vec<u8> {
    let mut text = String::from("G21 G90 G94\nG1 F3000\n");
    let mut turn = 0.0;
    for block in 0..BLOCKS {
        turn += if block % 50 == 0 { 2.6 } else { 0.31 };
        let phase = f64::from(block) / 400.0;
        let (x, a) = (80.0 + 15.0 * phase.cos(), 35.0 + 12.0 * phase.sin());
        writeln!(text, "X{x:.4} Y-20.5 Z40.25 A{a:.4} C{turn:.4}").expect("a string takes all text");
        if block == BLOCKS / 4 * 3 {
            text.push_str(late);
        }
    }
    text.push_str("M30\n");
    text.into_bytes()
}

fn set_up(survey: SurveyExtent) -> ProgramSetup {
    ProgramSetup { survey, ..at_zero() }
}

fn cc(text: &[u8], survey: SurveyExtent) -> Result<(Vec<u8>, CcReport), Fault> {
    let parameters = CcParameters::new(tool(5.0, 5.0), set_up(survey));
    let mut output = Vec::new();
    let report =
        compensate(&ac_machine(), &parameters, &text.to_vec(), &mut output, &|| ControlFlow::Continue(()))?;
    Ok((output, report))
}

fn wear(text: &[u8], survey: SurveyExtent) -> Result<(Vec<u8>, WearReport), Fault> {
    let worn = WornCutter::Tool(tool(4.9, 4.9));
    let parameters = WearParameters {
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(tool(5.0, 5.0), worn, set_up(survey))
    };
    let mut output = Vec::new();
    let report = compensate_wear(&ac_machine(), &parameters, &text.to_vec(), &mut output, &|| {
        ControlFlow::Continue(())
    })?;
    Ok((output, report))
}

#[test]
fn a_program_whose_head_shows_all_of_it_is_read_once_with_the_same_result() {
    let text = program("");
    let [whole, head] = [SurveyExtent::Whole, SurveyExtent::Head].map(|extent| cc(&text, extent).unwrap());
    assert!(whole.1.motions_over_tolerance > 100, "{:?}", whole.1.motions_over_tolerance);
    assert!(whole == head, "the results differ");
    let [whole, head] = [SurveyExtent::Whole, SurveyExtent::Head].map(|extent| wear(&text, extent).unwrap());
    assert!(whole == head, "the results differ");
}

#[test]
fn what_only_the_rest_shows_is_never_missed() {
    // Finer decimals, a contact point, normals, block numbers, another tool, a stamp.
    let lates = [
        "X80.12345 Y-20.5 Z40.25\n",
        "X80.1 Y-20.5 Z40.25 A30.123456\n",
        "G1 X80.5 Y-20.5 Z40.25 U80.5 V-20.5 W40.25\n",
        "N10 X80.5\n",
        "T4 M6\n",
        "(Trunnion 0.2.0 cc-compensation steps cc machine m revision 1 source 0 parameters 0)\n",
        "(Trunnion 0.2.0 cc-compensation steps)\n",
    ];
    for late in lates {
        let text = program(late);
        for fault in [cc(&text, SurveyExtent::Head).map(drop), wear(&text, SurveyExtent::Head).map(drop)] {
            // The wear of a program with contact points in a single block ends with another refusal.
            assert!(fault.is_err(), "{late}: the head alone was believed");
        }
        match cc(&text, SurveyExtent::Head) {
            Err(Fault::HeadMisled) => {}
            other => panic!("{late}: {:?}", other.map(|(_, report)| report.blocks_out)),
        }
    }
}

#[test]
fn what_changes_nothing_does_not_mislead() {
    // A rapid, coarser decimals, a comment, the same codes again.
    for late in ["G0 X81.5\nG1\n", "X80. Y-20\n", "(note U1 V2 W3)\n", "G21 G90\nM8\n"] {
        let text = program(late);
        let [whole, head] =
            [SurveyExtent::Whole, SurveyExtent::Head].map(|extent| cc(&text, extent).unwrap());
        assert!(whole == head, "{late}: the results differ");
    }
}

#[test]
fn a_refusal_after_the_end_of_the_program_is_final() {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let text = program("X80. Y-20.5 Z40.25 A500.\n");
    let faults = [SurveyExtent::Whole, SurveyExtent::Head].map(|extent| {
        let parameters = CcParameters::new(tool(5.0, 5.0), set_up(extent));
        compensate(&machine, &parameters, &text, &mut Vec::new(), &|| ControlFlow::Continue(())).unwrap_err()
    });
    assert!(matches!(faults[1], Fault::Lines(_)), "{}", faults[1]);
    assert_eq!(faults[0].to_string(), faults[1].to_string());
}
