//! Programs that are followed as they run: loops, jumps and calls make the motions that their text makes when it is
//! written out.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at the first surprise, helpers included"
)]

use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::process::{
    CcParameters, ContactSource, Fault, Interpreted, ProgramSetup, SimulationParameters,
    VerificationParameters, compensate, interpret_program, simulate, verify_part,
};
use trunnion::program::Dialect;
use trunnion::servo::{AxisLetter, DrivePreset, DriveSet};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::surface::SurfacePoint;
use trunnion::units::Length;

fn machine() -> Machine {
    Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap()
}

fn understood(dialect: Dialect, text: &str) -> Result<Vec<Interpreted>, Fault> {
    let program = ProgramSetup {
        dialect: Some(dialect),
        apply_errors: false,
        ..ProgramSetup::in_mm(&Setup::default())
    };
    let mut all = Vec::new();
    let mut take = |told: &Interpreted| {
        all.push(*told);
        Ok(())
    };
    let source = text.as_bytes().to_vec();
    interpret_program(&machine(), &program, &source, &mut take, &|| ControlFlow::Continue(()))?;
    Ok(all)
}

/// X Y Z A C after every motion, and its feed.
type Place = ([Option<f64>; 5], Option<f64>);

/// Places of all motions, none of which is left alone.
pub(crate) fn places(dialect: Dialect, text: &str) -> Vec<Place> {
    let found = understood(dialect, text).unwrap_or_else(|fault| panic!("{text}\n{fault}"));
    let places = found.into_iter().map(|told| match told {
        Interpreted::Motion(motion) => (motion.joints, motion.feed_mm_per_min),
        Interpreted::LeftAlone { line, reason, .. } => panic!("{text}\nline {line}: {reason}"),
    });
    places.collect()
}

fn refusal(dialect: Dialect, text: &str) -> String {
    understood(dialect, text).expect_err(text).to_string()
}

/// A program, and the same motions written out.
pub(crate) const ALIKE: [(Dialect, &str, &str); 14] = [
    // O words: own parameters, conditions, loops of every kind.
    (
        Dialect::Iso,
        "o100 sub (#1=x)\n#2=[#1+1]\nG1 X#1 Y#2 F100\no100 endsub\nG0 X0 Y0 Z5 A0 C0\n#1=7\no100 call [2]\no100 call [#1]\nG1 X#1 Y0\nM2\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 X2 Y3 F100\nX7 Y8\nX7 Y0\n",
    ),
    (
        Dialect::Iso,
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\n#1=0\no1 while [#1 LT 3]\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 elseif [#1 EQ 3]\nX30\no2 else\nX10\no2 endif\no1 endwhile\nM2\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nX10\nX30\n",
    ),
    (
        Dialect::Iso,
        "G0 X0 Y0 Z5 A0 C0\no1 repeat [3]\nG91 G1 X1 F50\no1 endrepeat\n#<n>=0\no2 do\n#<n>=[#<n>+1]\nG90 X#<n>\no3 if [#<n> GT 1]\no2 break\no3 endif\no2 while [#<n> LT 9]\nX0\nM2\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 X1 F50\nX2\nX3\nX1\nX2\nX0\n",
    ),
    (
        Dialect::Iso,
        "o<a> sub\nG1 X1 F10\no<b> call\no<a> endsub\no<b> sub\no9 if [1]\no<b> return\no9 endif\nX99\no<b> endsub\nG0 X0 Y0 Z5 A0 C0\no<a> call\nX3\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 X1 F10\nX3\n",
    ),
    // Macros: loops by number, jumps to block numbers.
    (
        Dialect::Iso,
        "O1\nG0 X0 Y0 Z5 A0 C0\nG1 F100\n#1=1\nWHILE [#1 LE 2] DO1\n#2=1\nWHILE [#2 LE 2] DO2\nX[#1*10.+#2]\n#2=#2+1\nEND2\n#1=#1+1\nEND1\nM30\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nX11\nX12\nX21\nX22\n",
    ),
    (
        Dialect::Iso,
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\n#1=3\nN10 X#1\n#1=#1-1\nIF [#1 GT 0] GOTO 10\nGOTO 30\nN20 X99\nN30 Y1\nM30\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nX3\nX2\nX1\nY1\n",
    ),
    // Subprograms behind the end of the main program, with repetitions, and in the state of the caller.
    (
        Dialect::Iso,
        "O1000\nG0 X0 Y0 Z5 A0 C0\nM98 P2000 L2\nG90 G1 Y0\nM30\nO2000\nG91 G1 X1 F100\nM98 P3000\nM99\nO3000\nY1\nM99\n%\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 X1 F100\nY1\nX2\nY2\nY0\n",
    ),
    // Structures and jumps of Sinumerik programs.
    (
        Dialect::Siemens,
        "DEF INT n\nG0 X0 Y0 Z5 A0 C0\nG1 F100\nFOR n=1 TO 3\nIF n==2\nY=n\nELSE\nX=n\nENDIF\nENDFOR\nM30\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nX1\nY2\nX3\n",
    ),
    (
        Dialect::Siemens,
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nR1=0\nWHILE R1<2\nR1=R1+1\nX=R1\nENDWHILE\nREPEAT\nR1=R1-1\nX=IC(-1)\nUNTIL R1<=0\nLOOP\nIF R1>1 GOTOF OUT\nR1=R1+1\nY=R1\nENDLOOP\nOUT: Z1\nM30\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nX1\nX2\nX1\nX0\nY1\nY2\nZ1\n",
    ),
    (
        Dialect::Siemens,
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nR4=2\nLA1: X=R4\nR4=R4-1\nIF R4>0 GOTOB LA1\nGOTOC NOWHERE\nGOTOF N100\nX99\nN100 Y1\nCASE(4+3) OF 7 GOTOF SEVEN 9 GOTOF NINE DEFAULT GOTOF OTHER\nNINE: X9\nSEVEN: X7\nGOTOF FIN\nOTHER: X0\nFIN: M30\n",
        "G0 X0 Y0 Z5 A0 C0\nG1 F100\nX2\nX1\nY1\nX7\n",
    ),
    // Labels of conversational programs.
    (
        Dialect::Heidenhain,
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 CALL LBL 5\n3 L X+9\n4 CALL LBL 5\n5 M30\n6 LBL 5\n7 L IX+1 F100\n8 L IY+1\n9 LBL 0\n10 END PGM A MM\n",
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 L X+1 F100\n3 L Y+1\n4 L X+9\n5 L X+10\n6 L Y+2\n7 END PGM A MM\n",
    ),
    (
        Dialect::Heidenhain,
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 LBL 1\n3 L IX+1 F100\n4 CALL LBL 1 REP 2\n5 L Y+1\n6 END PGM A MM\n",
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 L X+1 F100\n3 L X+2\n4 L X+3\n5 L Y+1\n6 END PGM A MM\n",
    ),
    (
        Dialect::Heidenhain,
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 Q1 = 0\n3 LBL 1\n4 Q1 = Q1 + 1\n5 L X+Q1 F100\n6 FN 12: IF +Q1 LT +3 GOTO LBL 1\n7 FN 9: IF +0 EQU +0 GOTO LBL 9\n8 L X+99\n9 LBL 9\n10 L Y+1\n11 END PGM A MM\n",
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 L X+1 F100\n3 L X+2\n4 L X+3\n5 L Y+1\n6 END PGM A MM\n",
    ),
    // What is passed before a call is passed once.
    (
        Dialect::Heidenhain,
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 LBL 5\n3 L IX+1 F100\n4 LBL 0\n5 CALL LBL 5\n6 END PGM A MM\n",
        "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+5 A+0 C+0 FMAX\n2 L X+1 F100\n3 L X+2\n4 END PGM A MM\n",
    ),
];

#[test]
fn a_program_with_loops_and_calls_makes_the_motions_of_its_text_written_out() {
    for (dialect, program, written_out) in ALIKE {
        assert_eq!(places(dialect, program), places(dialect, written_out), "{program}");
    }
}

#[test]
fn motions_of_a_loop_have_the_line_of_their_block() {
    let text = "G0 X0 Y0 Z5 A0 C0\no1 repeat [2]\nG1 X1 F50\nX0\no1 endrepeat\nY1\n";
    let lines: Vec<u64> = understood(Dialect::Iso, text)
        .unwrap()
        .into_iter()
        .map(|told| match told {
            Interpreted::Motion(motion) => motion.line,
            Interpreted::LeftAlone { line, .. } => panic!("line {line} is left alone"),
        })
        .collect();
    assert_eq!(lines, [1, 3, 4, 3, 4, 6]);
}

#[test]
fn a_program_that_never_ends_or_calls_itself_is_refused_with_line_and_count() {
    let endless = "G0 X0 Y0 Z5 A0 C0\no1 while [1]\nG1 X1 F50\no1 endwhile\n";
    for text in [
        endless,
        "G0 X0 Y0 Z5 A0 C0\nN10 G1 X1 F50\nGOTO 10\n",
        "G0 X0 Y0 Z5 A0 C0\no1 do\no1 while [1]\n",
        "G0 X0 Y0 Z5 A0 C0\nM98 P7 L99999\nM30\nO7\nM98 P8 L99999\nM99\nO8\nM99\n",
    ] {
        let refused = refusal(Dialect::Iso, text);
        assert!(refused.contains("250000 blocks"), "{refused}");
        assert!(refused.contains("line "), "{refused}");
    }
    for text in [
        "o1 sub\no1 call\no1 endsub\nG0 X0\no1 call\n",
        "G0 X0 Y0 Z5 A0 C0\nM98 P7\nM30\nO7\nG1 X1 F5\nM98 P7\nM99\n",
    ] {
        let refused = refusal(Dialect::Iso, text);
        assert!(
            refused.contains("call 33 inside calls") && refused.contains("must not call itself"),
            "{refused}"
        );
    }
}

#[test]
fn a_course_that_the_text_does_not_fix_is_refused_with_its_line() {
    for (dialect, text, line) in [
        (Dialect::Iso, "G0 X0\no1 if [#<_x> GT 0]\nX1\no1 endif\n", 2),
        (Dialect::Iso, "G0 X0\nIF [#500 GT 0] GOTO 10\nX1\nN10 X2\n", 2),
        (Dialect::Iso, "G0 X0\n/GOTO 10\nX1\nN10 X2\n", 2),
        (Dialect::Iso, "G0 X0\nGOTO 10\nX1\n", 2),
        (Dialect::Iso, "G0 X0\no1 while [1]\nX1\n", 2),
        (Dialect::Iso, "o1 sub\nX1\n", 1),
        (Dialect::Siemens, "G0 X0\nIF $AA_IW[X]>5\nX1\nENDIF\n", 2),
        (Dialect::Siemens, "G0 X0\nREPEAT LA P=3\nX1\n", 2),
        (Dialect::Heidenhain, "0 BEGIN PGM A MM\n1 L X+0 FMAX\n2 FN 9: IF +Q1 EQU +0 GOTO LBL 1\n", 3),
    ] {
        let refused = refusal(dialect, text);
        assert!(refused.contains(&format!("line {line}")), "{text}: {refused}");
    }
}

#[test]
fn after_a_call_of_a_program_that_is_not_there_nothing_is_known() {
    let text = "G0 X0 Y0 Z5 A0 C0\no1 repeat [2]\nM98 P9000\nX1\no1 endrepeat\nG21 G90 G94 G17 G40 G49 G69 G54 G0 X1\n";
    let found = understood(Dialect::Iso, text).unwrap();
    let left = found.iter().filter(|told| matches!(told, Interpreted::LeftAlone { .. })).count();
    assert_eq!(left, 4);
    let Some(Interpreted::Motion(last)) = found.last() else { panic!("{found:?}") };
    assert_eq!(last.joints, [Some(1.0), None, None, None, None]);
}

#[test]
fn steps_that_write_refuse_what_only_a_run_shows() {
    let text = "G0 X0 Y0 Z5 A0 C0\no1 repeat [2]\nG1 X1 A9 F50\nX0\no1 endrepeat\n".as_bytes().to_vec();
    let radius = Length::from_mm(5.0);
    let tool = Tool::new(radius, radius).unwrap();
    let parameters = CcParameters {
        program: ProgramSetup { dialect: Some(Dialect::Iso), ..ProgramSetup::in_mm(&Setup::default()) },
        contact: ContactSource::Tip,
        ..CcParameters::new(tool, ProgramSetup::in_mm(&Setup::default()))
    };
    let mut output = Vec::new();
    let refused = compensate(&machine(), &parameters, &text, &mut output, &|| ControlFlow::Continue(()));
    let refused = refused.expect_err("a program with a loop").to_string();
    assert!(refused.contains("line 2") && refused.contains("control flow"), "{refused}");
}

#[test]
fn however_a_text_is_made_its_run_costs_no_more_than_its_steps() {
    let head = "G0 X0 Y0 Z5 A0 C0\nG1 F100\n";
    // A hundred thousand blocks of one number, and a jump that passes over them again and again.
    let alike =
        format!("{head}{}#1=0\nN2 #1=[#1+1]\nIF [#1 LT 60000] GOTO 2\nM2\n", "N1 X1\n".repeat(50_000));
    let told = refusal(Dialect::Iso, &alike.replace("GOTO 2", "GOTO 1"));
    assert!(told.contains("250000 blocks"), "{told}");
    assert_eq!(places(Dialect::Iso, &alike).len(), 50_001);
    // Branches that are all asked for every time.
    let branches = "o1 elseif [#1 LT 0]\n".repeat(20_000);
    let asked = format!("{head}#1=0\no9 while [1]\no1 if [#1 LT 0]\n{branches}o1 endif\no9 endwhile\nM2\n");
    let told = refusal(Dialect::Iso, &asked);
    assert!(told.contains("250000 blocks"), "{told}");
    // More structures inside each other than are followed.
    let nested = |count: usize| {
        let opened: Vec<_> = (0..count).map(|at| format!("o{at} if [1]\n")).collect();
        let closed: Vec<_> = (0..count).rev().map(|at| format!("o{at} endif\n")).collect();
        format!("{head}{}X1\n{}X2\nM2\n", opened.concat(), closed.concat())
    };
    assert_eq!(places(Dialect::Iso, &nested(256)).len(), 3);
    assert!(refusal(Dialect::Iso, &nested(258)).contains("line 3"));
    // A text of more blocks than are kept.
    let long = format!("{head}{}o1 repeat [2]\nX2\no1 endrepeat\nM2\n", "X1\n".repeat(250_000));
    assert!(refusal(Dialect::Iso, &long).contains("o1 repeat"));
}

/// A program with a loop, a call and a cycle, and the same motions written out.
const RUN: [&str; 2] = [
    "G90 G17 G94 G0 X0 Y0 Z5 A0 C0\n#1=0\no1 while [#1 LT 3]\nG1 X[#1*2] Y0 Z0 F600\nY5\n#1=[#1+1]\no1 endwhile\nM98 P7\n\
     G0 Z5\nG99 G81 X4 Y2 Z-1 R2 F300\nG80\nM30\nO7\nG1 X0 Y0\nM99\n",
    "G90 G17 G94 G0 X0 Y0 Z5 A0 C0\nG1 X0 Y0 Z0 F600\nY5\nX2 Y0\nY5\nX4 Y0\nY5\nX0 Y0\nG0 Z5\nX4 Y2\nZ2\nG1 Z-1 F300\nG0 Z2\nM30\n",
];

fn at_zero() -> ProgramSetup {
    ProgramSetup { dialect: Some(Dialect::Iso), ..ProgramSetup::in_mm(&Setup::default()) }
}

#[test]
fn a_run_takes_the_time_of_its_motions_written_out() {
    let mut drives = DriveSet::default();
    for axis in [AxisLetter::X, AxisLetter::Y, AxisLetter::Z] {
        drives.set(axis, DrivePreset::by_id("reference-linear").unwrap().drive);
    }
    for axis in [AxisLetter::A, AxisLetter::C] {
        drives.set(axis, DrivePreset::by_id("reference-rotary").unwrap().drive);
    }
    let parameters = SimulationParameters::new(drives, at_zero());
    let simulated = RUN.map(|text| {
        let source = text.as_bytes().to_vec();
        simulate(&machine(), &parameters, &source, &|| ControlFlow::Continue(())).unwrap()
    });
    let [run, written_out] = &simulated;
    assert_eq!((run.motions, run.passes), (written_out.motions, written_out.passes));
    assert!((run.duration_s - written_out.duration_s).abs() < 1e-12 && run.motions == 8, "{run:?}");
    assert!(run.left_out.is_empty());
}

#[test]
fn a_run_cuts_what_its_motions_written_out_cut() {
    let samples: Vec<SurfacePoint> = (0..49)
        .map(|k| SurfacePoint {
            point_mm: Vec3::new(f64::from(k % 7) - 1.0, f64::from(k / 7) - 1.0, 0.0),
            normal: Vec3::new(0.0, 0.0, 1.0),
        })
        .collect();
    let radius = Length::from_mm(2.0);
    let parameters = VerificationParameters::new(Tool::new(radius, radius).unwrap(), at_zero());
    let verified = RUN.map(|text| {
        let source = text.as_bytes().to_vec();
        let stop = || ControlFlow::Continue(());
        verify_part(&machine(), &parameters, &samples, &source, &OneAfterAnother, &stop).unwrap()
    });
    let [run, written_out] = &verified;
    assert_eq!(run.motions, written_out.motions);
    let residuals = |verification: &trunnion::process::Verification| -> Vec<Option<f64>> {
        verification.residuals.iter().map(|residual| residual.map(|residual| residual.residual_mm)).collect()
    };
    assert_eq!(residuals(run), residuals(written_out));
    // The hole of the cycle is there.
    assert!(residuals(run).iter().flatten().any(|residual| *residual < -0.9), "{:?}", residuals(run));
}
