//! Programs of several files: a called file makes the motions of its text, in the state of its caller.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at the first surprise, helpers included"
)]

use std::io::{self, Read};
use std::ops::ControlFlow;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset};
use trunnion::process::{
    Fault, Interpreted, OpenSubprogram, ProgramSetup, ProgramSource, WarningKind, interpret_program,
};
use trunnion::program::Dialect;

/// A main program, and the files that it may call with their names.
pub(crate) struct Several<'a> {
    pub(crate) main: &'a str,
    pub(crate) files: &'a [(&'a str, &'a str)],
}

impl ProgramSource for Several<'_> {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(self.main.as_bytes()))
    }

    fn open_subprogram(&self, index: usize) -> io::Result<Option<OpenSubprogram<'_>>> {
        Ok(self
            .files
            .get(index)
            .map(|(name, text)| OpenSubprogram { name: (*name).to_owned(), text: Box::new(text.as_bytes()) }))
    }
}

fn understood(dialect: Dialect, source: &Several<'_>) -> Result<Vec<Interpreted>, Fault> {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
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
    interpret_program(&machine, &program, source, &mut take, &|| ControlFlow::Continue(()))?;
    Ok(all)
}

/// X Y Z A C after every motion and its feed, none of which is left alone.
pub(crate) fn places(dialect: Dialect, source: &Several<'_>) -> Vec<([Option<f64>; 5], Option<f64>)> {
    let found = understood(dialect, source).unwrap_or_else(|fault| panic!("{}\n{fault}", source.main));
    let places = found.into_iter().map(|told| match told {
        Interpreted::Motion(motion) => (motion.joints, motion.feed_mm_per_min),
        Interpreted::LeftAlone { line, reason, .. } => panic!("{}\nline {line}: {reason}", source.main),
    });
    places.collect()
}

/// Where every motion is: its file and its line.
fn lines(dialect: Dialect, source: &Several<'_>) -> Vec<(u16, u64)> {
    let lines = understood(dialect, source).unwrap().into_iter().map(|told| match told {
        Interpreted::Motion(motion) => (motion.called, motion.line),
        Interpreted::LeftAlone { called, line, .. } => (called, line),
    });
    lines.map(|(called, line)| called.map_or((0, line), |at| (at.file.get(), at.line.into()))).collect()
}

/// Where every program begins.
pub(crate) fn start(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::Heidenhain => "0 BEGIN PGM P MM\n1 L X+0 Y+0 Z+5 A+0 C+0 R0 F100\n",
        _ => "G0 X0 Y0 Z5 A0 C0\nG1 F100\n",
    }
}

/// A dialect, a program, its files, and words of its refusal.
type Refused<'a> = (Dialect, String, &'a [(&'a str, &'a str)], &'a str);

/// A dialect, a program behind its start, its files, and the same motions written out.
pub(crate) type Alike = (Dialect, &'static str, &'static [(&'static str, &'static str)], &'static str);

pub(crate) const ALIKE: [Alike; 9] = [
    // By number, with repetitions; the tape marks, the program's name and a text behind the tape are no part of it.
    (
        Dialect::Iso,
        "M98 P2000 L2\nG90 Y0\nM30\n",
        &[("O2000.nc", "%\n(POCKET)\nO2000\nG91 X1\nM98 P3\nM99\n%\nG90 X99\n"), ("o0003", "Y1\nM99\n")],
        "X1\nY1\nX2\nY2\nY0\n",
    ),
    // A file may have further programs.
    (Dialect::Iso, "M98 P7\nM30\n", &[("7.nc", "O7\nX1\nM98 P2\nM99\nO2\nY2\nM99\n")], "X1\nY2\n"),
    // A program in the same text comes before a file.
    (Dialect::Iso, "M98 P7\nM30\nO7\nX7\nM99\n", &[("O7.nc", "X9\nM99\n")], "X7\n"),
    // O words, with parameters of their own, and a subprogram beside the called one.
    (
        Dialect::Iso,
        "#1=7\no<Square> call [3]\nX#1\nM2\n",
        &[(
            "square.ngc",
            "o<side> sub\nY#1\no<side> endsub\no<square> sub\nX#1\no<side> call [2]\no<square> endsub\nM2\n",
        )],
        "X3\nY2\nX7\n",
    ),
    // A loop in a file and in its caller, with the same number.
    (
        Dialect::Iso,
        "o1 repeat [2]\nM98 P5\no1 endrepeat\nX0\nM2\n",
        &[("5.ngc", "o1 repeat [2]\nG91 X1\no1 endrepeat\nG90\nM99\n")],
        "X1\nX2\nX3\nX4\nX0\n",
    ),
    // Variables belong to their program, R parameters to all; the end of the file, M17 and RET return.
    (
        Dialect::Siemens,
        "DEF REAL D=3\nR1=5\nL54 P2\nPOCKET\nX=D Y=R1\nEXTCALL \"/_N_WKS_DIR/_N_LAST_SPF\"\nM30\n",
        &[
            ("L54.SPF", "%_N_L54_SPF\n;$PATH=/_N_SPF_DIR\nDEF REAL D=1\nX=D\nR1=R1+1\nM17\n"),
            ("pocket.spf", "PROC POCKET DISPLOF\nY=R1\nIF R1==7 GOTOF HERE\nY99\nHERE: Y1\nRET\n"),
            ("_N_LAST_SPF", "Z1\n"),
        ],
        "X1\nX1\nY7\nY1\nX3 Y7\nZ1\n",
    ),
    // Labels and QL parameters belong to their program, Q parameters to all.
    (
        Dialect::Heidenhain,
        "Q1 = 5\nQL1 = 7\nCALL PGM TNC:\\PARTS\\POCKET.H\nL X+QL1 Y+Q1\nCALL LBL 1\nM30\nLBL 1\nL Z+1\nLBL 0\n",
        &[(
            "pocket.h",
            "BEGIN PGM POCKET MM\nQ1 = Q1 + 1\nL X+Q1 R0 F100\nCALL LBL 1\nEND PGM POCKET MM\nLBL 1\nL Y+1\nLBL 0\n",
        )],
        "L X+6\nL Y+1\nL X+7 Y+6\nL Z+1\n",
    ),
    // A name in quotation marks without its extension.
    (
        Dialect::Heidenhain,
        "CALL PGM \"POCKET\"\nL Y+2\n",
        &[("POCKET.H", "0 BEGIN PGM POCKET MM\n1 L X+1\n2 END PGM POCKET MM\n")],
        "L X+1\nL Y+2\n",
    ),
    // Files that call files.
    (
        Dialect::Siemens,
        "OUTER\nX0\nM30\n",
        &[("OUTER.SPF", "X1\nINNER P2\nX3\n"), ("INNER.SPF", "Y=IC(1)\nM17\n")],
        "X1\nY1\nY2\nX3\nX0\n",
    ),
];

#[test]
fn a_called_file_makes_the_motions_of_its_text_written_out() {
    for (dialect, program, files, written_out) in ALIKE {
        let text = |body: &str| format!("{}{body}", start(dialect));
        let (main, plain) = (text(program), text(written_out));
        let found = places(dialect, &Several { main: &main, files });
        assert_eq!(found, places(dialect, &Several { main: &plain, files: &[] }), "{main}");
    }
}

#[test]
fn a_motion_tells_its_file_and_its_line_there() {
    let main = "G0 X0 Y0 Z5 A0 C0\nM98 P2\nX3\nM98 P3\n";
    let files = [("O2.nc", "%\nO2\nG1 X1 F50\nM98 P3\nM99\n"), ("O3.nc", "Y1\nM99\n")];
    let found = lines(Dialect::Iso, &Several { main, files: &files });
    assert_eq!(found, [(0, 1), (1, 3), (2, 1), (0, 3), (2, 1)]);
}

#[test]
fn a_file_that_cannot_be_followed_refuses_the_program_at_its_call() {
    let iso = start(Dialect::Iso);
    let mm = start(Dialect::Heidenhain);
    let long = "X".repeat(1 << 20);
    let too_long = format!("M99\n(O2)\n{long}\n");
    let unreadable = [("2.nc", too_long.as_str())];
    let cases: [Refused<'_>; 9] = [
        (
            Dialect::Iso,
            format!("{iso}M98 P2\n"),
            &unreadable,
            "in the called file `2.nc`: line 3 is longer than",
        ),
        (
            Dialect::Iso,
            format!("{iso}o2 call\n"),
            &[("2.ngc", "o2 sub\nM73\nG91 X1\no2 endsub\n")],
            "line 3 (called file `2.ngc`, line 2), column 1: `M73`",
        ),
        (
            Dialect::Iso,
            format!("{iso}M98 P2\n"),
            &[("2.nc", "X1\nY2\n")],
            "line 3 (called file `2.nc`, line 2), column 1: `Y2`: the called file ends",
        ),
        (Dialect::Iso, format!("{iso}M98 P2\n"), &[("2.nc", "")], "line 3, column 1: `M98 P2`"),
        (Dialect::Iso, format!("{iso}M98 P2\n"), &[("2.nc", "X1\nM98 P2\nM99\n")], "must not call itself"),
        (
            Dialect::Iso,
            format!("{iso}M98 P2\n"),
            &[("2.nc", "X1\nGOTO 5\nM99\n")],
            "line 3 (called file `2.nc`, line 2), column 1: `GOTO 5`",
        ),
        (
            Dialect::Siemens,
            format!("{iso}POCKET\n"),
            &[("POCKET.SPF", "PROC POCKET SAVE\nG91\nM17\n")],
            "line 3 (called file `POCKET.SPF`, line 1)",
        ),
        (
            Dialect::Siemens,
            format!("{iso}POCKET\n"),
            &[("POCKET.SPF", "X1 M17\n")],
            "line 3 (called file `POCKET.SPF`, line 1), column 1",
        ),
        (
            Dialect::Heidenhain,
            format!("{mm}CALL PGM P2\n"),
            &[("P2.H", "0 BEGIN PGM P2 INCH\n1 L X+1\n2 END PGM P2 INCH\n")],
            "line 3 (called file `P2.H`, line ",
        ),
    ];
    for (dialect, main, files, wanted) in cases {
        let refused = understood(dialect, &Several { main: &main, files }).expect_err(&main).to_string();
        assert!(refused.contains(wanted), "{main}{files:?}: {refused}");
    }
}

#[test]
fn a_program_without_end_is_refused_wherever_its_limit_is_reached() {
    // The limit comes at the call, in the file, at its end or at the jump.
    for before in 0..5 {
        let main =
            format!("{}{}LAB:\nPOCKET\nGOTOB LAB\nM30\n", start(Dialect::Siemens), "POCKET\n".repeat(before));
        for files in [&[("POCKET.SPF", "X1\n")][..], &[("POCKET.SPF", "X1\n"), ("ZZ.SPF", "Y7 ; other\n")]] {
            let refused = understood(Dialect::Siemens, &Several { main: &main, files }).expect_err(&main);
            let refused = refused.to_string();
            assert!(refused.contains("250000") && !refused.contains("other"), "{before}: {refused}");
        }
    }
}

#[test]
fn every_faulty_line_of_a_called_file_is_told_with_its_own_fault() {
    let main = format!("{}M98 P2\nM30\n", start(Dialect::Iso));
    let faults =
        |file: &str| match understood(Dialect::Iso, &Several { main: &main, files: &[("parts/2.nc", file)] })
        {
            Err(Fault::Program(told)) => told.refusals().map(ToString::to_string).collect::<Vec<_>>(),
            other => panic!("{file}: {other:?}"),
        };
    for (file, wanted) in [
        ("O2\nX1..2\nY5\nZ3..4 K\nM99\n", [(2, ".2"), (4, ".4")]),
        ("O2\nX[1/0]\nY2\nX1..2\nM99\n", [(2, "1/0"), (4, ".2")]),
        ("O2\nX1..2\nY2\nX[1/0]\nM99\n", [(2, ".2"), (4, "1/0")]),
    ] {
        let found = faults(file);
        assert_eq!(found.len(), 2, "{file}{found:?}");
        for (told, (line, text)) in found.iter().zip(wanted) {
            let place = format!("line 3 (called file `2.nc`, line {line}), column ");
            assert!(told.starts_with(&place) && told.contains(text), "{file}{told}");
        }
    }
}

#[test]
fn two_files_of_one_name_and_a_call_with_parameters_are_not_followed() {
    for (dialect, call, files) in [
        (Dialect::Iso, "M98 P2", [("2.nc", "X1\nM99\n"), ("O0002.nc", "X2\nM99\n")]),
        (Dialect::Iso, "M98 P2", [("2.nc", "O1\nX1\nM99\n"), ("O3.nc", "X2\nM99\n")]),
        (Dialect::Siemens, "CALL \"POCKET.SPF\"", [("POCKET.MPF", "X1\n"), ("OTHER.SPF", "X2\n")]),
        (Dialect::Siemens, "POCKET(5)", [("POCKET.SPF", "X1\n"), ("OTHER.SPF", "X2\n")]),
        (Dialect::Siemens, "L1", [("L01.SPF", "X1\n"), ("L11.SPF", "X2\n")]),
    ] {
        let main = format!("{}{call}\nX5\n", start(dialect));
        let found = understood(dialect, &Several { main: &main, files: &files }).unwrap();
        let left: Vec<_> =
            found.iter().filter(|told| matches!(told, Interpreted::LeftAlone { .. })).collect();
        assert_eq!(left.len(), 2, "{main}{found:?}");
    }
}

#[test]
fn a_call_costs_no_more_for_many_places_of_its_name() {
    // Every call looks among a hundred thousand places of the same name.
    let places = "N1\n".repeat(100_000);
    let main = format!("{}o1 repeat [100000]\nM98 P2\no1 endrepeat\nGOTO 1\n", start(Dialect::Iso));
    let file = format!("M99\n{places}");
    let files = [("2.nc", file.as_str())];
    let refused = understood(Dialect::Iso, &Several { main: &main, files: &files }).expect_err("too long");
    assert!(refused.to_string().contains("250000 blocks"), "{refused}");
}

#[test]
fn a_call_costs_no_more_for_many_variables() {
    // Ninety thousand parameters and nine thousand variables are known at every one of some sixty thousand calls.
    let lines = |count: u32, line: fn(u32) -> String| (0..count).map(line).collect::<Vec<_>>().concat();
    let parameters = lines(90_000, |number| format!("R{number}=1\n"));
    let variables = lines(9_000, |number| format!("DEF REAL V{number}=1\n"));
    let start = start(Dialect::Siemens);
    let main = format!("{variables}{start}{parameters}LOOP\nEMPTY\nENDLOOP\n");
    let files = [("EMPTY.SPF", "DEF REAL V1\nRET\n")];
    let refused =
        understood(Dialect::Siemens, &Several { main: &main, files: &files }).expect_err("too long");
    assert!(refused.to_string().contains("250000 blocks"), "{refused}");
}

/// How many files the warning about files that no call reaches counts.
fn idle(main: &str, files: &[(&str, &str)]) -> Option<u64> {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let program = ProgramSetup { dialect: Some(Dialect::Iso), ..ProgramSetup::in_mm(&Setup::default()) };
    let mut take = |_: &Interpreted| Ok(());
    let go_on = || ControlFlow::Continue(());
    let told = interpret_program(&machine, &program, &Several { main, files }, &mut take, &go_on);
    let warnings = told.unwrap().warnings;
    warnings.iter().find(|warning| warning.kind == WarningKind::FileNotCalled).map(|warning| warning.count)
}

#[test]
fn files_that_no_call_reaches_are_counted() {
    let files = &[("O2.nc", "O2\nX1\nM99\n"), ("O3.nc", "O3\nM98 P2\nM99\n"), ("O4.nc", "O4\nX3\nM99\n")];
    let start = "G21 G90 G54\nG0 X0 Y0 Z5 A0 C0\n";
    for (calls, wanted) in [
        ("", Some(3)),
        ("M98 P2\n", Some(2)),
        // A called file calls another one.
        ("M98 P3\n", Some(1)),
        ("M98 P3\nM98 P4\n", None),
        // The name of no file, and a call after the end.
        ("M98 P7\n", Some(3)),
        ("M98 P3\nM30\nM98 P4\n", Some(1)),
    ] {
        assert_eq!(idle(&format!("{start}{calls}M30\n"), files), wanted, "{calls}");
    }
    assert_eq!(idle(&format!("{start}M30\n"), &[]), None);
}
