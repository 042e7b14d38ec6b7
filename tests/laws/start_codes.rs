//! The codes in which a control begins: a program without them, run on such a control, is the program with them.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset};
use trunnion::motion::StartModes;
use trunnion::process::{Interpreted, InterpretedKind, ProgramSetup, StartPosition, interpret_program};
use trunnion::program::Dialect;

type Told = (InterpretedKind, [Option<f64>; 5], Option<f64>);

/// Every motion, or the line that is left unchanged.
fn run(dialect: Dialect, codes: &str, text: &str) -> Vec<Result<Told, u64>> {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let start = StartPosition { linear_mm: [Some(0.0); 3], rotary_deg: [Some(0.0); 2] };
    let program = ProgramSetup {
        dialect: Some(dialect),
        start,
        start_modes: StartModes::from_codes(codes).unwrap(),
        ..ProgramSetup::in_mm(&Setup::default())
    };
    let mut all = Vec::new();
    let mut take = |told: &Interpreted| {
        all.push(match told {
            Interpreted::Motion(motion) => Ok((motion.kind, motion.joints, motion.feed_mm_per_min)),
            Interpreted::LeftAlone { line, .. } => Err(*line),
        });
        Ok(())
    };
    interpret_program(
        &machine,
        &program,
        &text.as_bytes().to_vec(),
        &mut take,
        &|| ControlFlow::Continue(()),
    )
    .unwrap();
    all
}

#[test]
fn codes_at_the_start_are_those_before_the_first_block() {
    for dialect in [Dialect::Iso, Dialect::Siemens] {
        for (codes, body) in [
            ("G1", "F500\nX10 Y5\nZ-2\nM30\n"),
            ("G0 G91", "X10\nX10 Y5\nG90 X0\nM30\n"),
            ("G1 G17 G90 G94", "X1 F100\nG0 X2\nX3\nM30\n"),
            ("G1 G18", "F100 X1\nG2 X3 Z2 I1 K1\nM30\n"),
        ] {
            let with = run(dialect, "", &format!("{codes}\n{body}"));
            assert!(!with.is_empty() && with.iter().all(Result::is_ok), "{codes} {body} {with:?}");
            let line_for_line = run(dialect, codes, &format!("\n{body}"));
            assert_eq!(line_for_line, with, "{codes} {body}");
        }
        if dialect == Dialect::Iso {
            for (level, height) in [("G98", 50.0), ("G99", 3.0)] {
                let body = "G0 X0 Y0 Z50\nG81 X1 Z-5 R3 F100\nG80\nG0 X2\nM30\n";
                let found = run(dialect, level, body);
                assert_eq!(found, run(dialect, "", &body.replace("G81", &format!("{level} G81"))), "{level}");
                let last = found.last().and_then(|told| told.ok());
                assert_eq!(last.and_then(|(_, joints, _)| joints[2]), Some(height), "{level}");
            }
        }
        // Without them it is not known how the tool moves.
        assert_eq!(run(dialect, "", "X10 F500\nG1 X20\nM30\n").first(), Some(&Err(1)));
    }
}

#[test]
fn dialects_that_name_every_motion_take_no_codes() {
    let text = "BEGIN PGM A MM\nL X+1 Y+2 F100\nL X+3 FMAX\nEND PGM A MM\n";
    assert_eq!(run(Dialect::Heidenhain, "G0 G91", text), run(Dialect::Heidenhain, "", text));
    let text = "X,Y,Z,A,C\n1,2,3,0,0\n4,5,6,0,0\n";
    assert_eq!(run(Dialect::Csv, "G0 G91", text), run(Dialect::Csv, "", text));
}
