//! Laws of programs for Okuma OSP.

use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::machine::{Machine, Preset};
use trunnion::process::{CcParameters, CcReport, ContactSource, Fault, ProgramSetup, compensate};
use trunnion::program::{Dialect, ReadLimits, Reader};
use trunnion::units::Length;

use crate::models::finishing::tool;
use crate::models::set_ups::at_zero;

fn machine() -> Machine {
    Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine")
}

fn compensated(dialect: Option<Dialect>, text: &str) -> Result<(String, CcReport), Fault> {
    let parameters = CcParameters {
        contact: ContactSource::FeedPlane,
        tolerance: Length::from_um(10.0),
        ..CcParameters::new(tool(5.0, 5.0), ProgramSetup { dialect, ..at_zero() })
    };
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    let report = compensate(&machine(), &parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok((String::from_utf8(output).expect("text"), report))
}

fn shown(text: &str) -> Option<Dialect> {
    let mut reader = Reader::new(None, ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let _ = reader.next_batch(&mut trunnion::program::Batch::new());
    reader.dialect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_same_cuts_are_divided_alike_for_osp_and_for_iso(
        ends in prop::collection::vec((-40_i32..40, -40_i32..40, 0_i32..30, -25_i32..25), 1..6),
        feed in 200_i32..3000,
    ) {
        let cut = |(x, y, a, c): &(i32, i32, i32, i32)| format!("G1 X{x}.000 Y{y}.000 A{a}.000 C{c}.000 F{feed}\n");
        let cuts = ends.iter().map(cut).collect::<Vec<_>>().concat();
        // The length is named where the level is, by another code; behind it the text is the same.
        let osp = format!("$P.MIN%\nOP1\nG15 H1\nG21 G90 G94 G17\nT1 M6\nG0 X0.000 Y0.000 A0.000 C0.000\nG56 Z50.000 H1\n{cuts}M02\n%\n");
        let iso = format!("%\nO1\nG54\nG21 G90 G94 G17\nT1 M6\nG0 X0.000 Y0.000 A0.000 C0.000\nG43 Z50.000 H1\n{cuts}M02\n%\n");
        let (osp_out, report) = compensated(None, &osp).map_err(|fault| TestCaseError::fail(format!("{fault}\n{osp}")))?;
        let (iso_out, as_iso) = compensated(None, &iso).map_err(|fault| TestCaseError::fail(format!("{fault}\n{iso}")))?;
        prop_assert_eq!((report.dialect, as_iso.dialect), (Dialect::Okuma, Dialect::Iso));
        prop_assert_eq!(report.blocks_out, as_iso.blocks_out);
        let behind = |text: &str| text.lines().skip(7).map(str::to_owned).collect::<Vec<_>>();
        prop_assert_eq!(behind(&osp_out), behind(&iso_out));
        prop_assert!(osp_out.starts_with("$P.MIN%\nOP1\nG15 H1\n"));
    }
}

const CUT: &str = "G21 G90 G94 G17\nG0 X50.000 Y0.000 Z0.000 A0.000 C0.000\n\
                   G1 X50.000 Y20.000 A20.000 C20.000 F1000\nM02\n";

#[test]
fn a_text_is_for_osp_where_it_plainly_says_so_and_stays_what_it_was_elsewhere() {
    for (text, dialect) in [
        (format!("$PART.MIN%\nOPART\n{CUT}"), Dialect::Okuma),
        (format!("OPART\nG15 H1\nG56 Z5. H1\n{CUT}"), Dialect::Okuma),
        (format!("O0001 (PART)\nG15 H1\n{CUT}"), Dialect::Okuma),
        // Polar words that end beside a length, and a work offset beside the number of a length.
        (format!("O0001 (PART)\nG17 G15 G43 H1\nG56 G43 H2\n{CUT}"), Dialect::Iso),
        (format!("O0001 (PART)\nG56 Z5. H1\n{CUT}"), Dialect::Iso),
    ] {
        assert_eq!(shown(&text), Some(dialect), "{text}");
        // A caller who states it is believed.
        assert_eq!(compensated(Some(Dialect::Okuma), &text).expect("as stated").1.dialect, Dialect::Okuma);
    }
}

#[test]
fn a_code_that_is_no_length_for_osp_moves_nothing_unseen() {
    // G55 with H puts the tool along Y: as ISO it would be a work offset, and the cut be divided for a tool along Z.
    let along_y = format!("$P.MIN%\nOP\nG15 H1\nG55 X0 Y50. Z0 H2\n{CUT}");
    match compensated(None, &along_y) {
        Ok((output, report)) => {
            assert_eq!(output, along_y, "nothing is changed");
            assert_eq!(report.motions_over_tolerance, 0);
        }
        Err(fault) => assert!(matches!(fault, Fault::NothingFollowed { .. } | Fault::NoMotion), "{fault:?}"),
    }
    let variables = format!("OP\n{CUT}").replace("X50.000 Y20.000", "X=VC1 Y20.000");
    let Err(Fault::Program(diagnostics)) = compensated(Some(Dialect::Okuma), &variables) else {
        panic!("a program with variables is refused")
    };
    let refusal = diagnostics.refusals().next().expect("one").to_string();
    assert!(refusal.contains("line 4") && refusal.contains("post the program with numbers"), "{refusal}");
}

/// A program whose start is known, so that a cut would be divided.
const BEGIN: &str =
    "$PART.MIN%\nOPART\nG15 H1\nG21 G90 G17 G94 G40\nT1 M6\nG0 X0.000 Y0.000 A0.000 C0.000\nG56 Z50.000 H1\n";
const LONG_CUT: &str = "G0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nG1 X40.000 Y20.000 A20.000 C20.000 F500\n";

#[test]
fn no_cut_is_divided_where_the_control_would_do_something_else() {
    let (plain, report) = compensated(None, &format!("{BEGIN}{LONG_CUT}M02\n")).expect("a program");
    assert!(report.motions_over_tolerance > 0 && plain.len() > 400, "the cut itself is divided: {report:?}");
    for line in [
        // A frame in space, whichever of the two codes begins it.
        "G69 X0 Y0 Z0 P30. Q0 R0",
        "G68 X0 Y0 Z0 P30. Q0 R0",
        // The direction of a rotary axis, a mirror, a tilted offset, smoothing by another code, a call.
        "M16",
        "G1 X0.000 M115",
        "G62 X1 Y0 Z0",
        "G605",
        "G445",
        "CALL OO88",
        // The head looks to a side, and no length has named its axis again.
        "M73",
        "G15 H0",
    ] {
        let text = format!("{BEGIN}{line}\n{LONG_CUT}M02\n");
        match compensated(None, &text) {
            Ok((output, report)) => {
                assert_eq!((output == text, report.motions_over_tolerance), (true, 0), "{line}: {output}");
            }
            Err(fault) => assert!(matches!(fault, Fault::NothingFollowed { .. }), "{line}: {fault:?}"),
        }
    }
    // Text that would be read as another one is refused with its line.
    for line in ["$ Y40.000 C5.000", "NLAPG91", "G1 X6.12E-17", "OMIT R2"] {
        let refused = compensated(None, &format!("{BEGIN}{line}\n{LONG_CUT}M02\n"));
        let Err(Fault::Program(diagnostics)) = refused else { panic!("{line}: {refused:?}") };
        let refusal = diagnostics.refusals().next().expect("one").to_string();
        assert!(refusal.contains("line 8"), "{line}: {refusal}");
    }
}

#[test]
fn smoothing_of_the_control_changes_no_cut() {
    let with = format!("{BEGIN}G131 F1000. J1 E0.010\n{LONG_CUT}G130\nM02\n");
    let without = format!("{BEGIN}{LONG_CUT}M02\n");
    let [with, without] = [with, without].map(|text| compensated(None, &text).expect("a program").0);
    let [with, without] = [with, without].map(|text| {
        text.lines().filter(|line| !line.starts_with("G13")).map(str::to_owned).collect::<Vec<_>>()
    });
    assert_eq!(with, without);
}
