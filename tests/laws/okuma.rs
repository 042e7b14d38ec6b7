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
        // One of the two alone is a work offset of other controls.
        (format!("O0001 (PART)\nG15 H1\n{CUT}"), Dialect::Iso),
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
