//! Loops and calls that are written out: one text with the same motions, which every step follows.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::ops::ControlFlow;

use trunnion::kinematics::Setup;
use trunnion::machine::{Machine, Preset};
use trunnion::process::{Fault, ProgramSetup, WrittenOut, write_out};
use trunnion::program::Dialect;

use crate::called_files::{self, Several, places, start};
use crate::course;

fn written(dialect: Dialect, source: &Several<'_>) -> Result<Option<(WrittenOut, String)>, Fault> {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let program = ProgramSetup { dialect: Some(dialect), ..ProgramSetup::in_mm(&Setup::default()) };
    let stop = || ControlFlow::Continue(());
    let found = write_out(&machine, &program, source, Vec::new(), Ok, &stop)?;
    Ok(found.map(|(done, text)| (done, String::from_utf8(text).unwrap())))
}

#[test]
fn a_text_that_is_written_out_makes_the_same_motions() {
    let of_one_text = course::ALIKE.map(|(dialect, program, _)| (dialect, program.to_owned(), &[][..]));
    let of_files = called_files::ALIKE
        .map(|(dialect, program, files, _)| (dialect, format!("{}{program}", start(dialect)), files));
    let mut count = 0;
    for (dialect, main, files) in of_one_text.into_iter().chain(of_files) {
        let source = Several { main: &main, files };
        let found = written(dialect, &source).unwrap_or_else(|fault| panic!("{main}\n{fault}"));
        let Some((_, text)) = found else { continue };
        count += 1;
        let plain = Several { main: &text, files: &[] };
        assert_eq!(places(dialect, &source), places(dialect, &plain), "{main}\n{text}");
        // Nothing is left to be written out.
        assert_eq!(written(dialect, &plain).unwrap(), None, "{text}");
    }
    assert!(count > 15, "{count} programs have loops or calls");
}

#[test]
fn words_get_numbers_and_the_text_before_the_first_loop_stays_as_it_is() {
    for (dialect, main, files, wanted) in [
        (
            Dialect::Iso,
            "%\r\nO1 (PART)\r\nG0 X#5 (a) Y0 Z5\r\n#1=2\r\nM98 P2 L2\r\nG1 X[#1*10] F[#1*100]\r\nM30\r\n%\r\n",
            &[("2.nc", "%\nO2\nT[#1+3] G1 X[#1/3]\n#1=[#1+1]\nM99\n%\n")][..],
            "%\r\nO1 (PART)\r\nG0 X#5 (a) Y0 Z5\r\n#1=2\r\nT5 G1 X0.666667\nT6 G1 X1.0000\nG1 X40.0000 F400.\r\nM30\r\n%\r\n",
        ),
        (
            Dialect::Siemens,
            "DEF INT N\nG0 X0\nFOR N=1 TO 2\nN5 R1=N R2=7 X=N*10 Y=IC(N)\nR3=4\nENDFOR\nM30\n",
            &[],
            "DEF INT N\nG0 X0\nN5   X=10.0000 Y=IC(1.0000)\nN5   X=20.0000 Y=IC(2.0000)\nM30\n",
        ),
        (
            Dialect::Siemens,
            "G0 X0 Y0 Z9 A0 C0\nR2=0\nLOOP\nR2=R2+1\nMCALL CYCLE82(R2+5, 2+1,1 ,,R2*3,1) ; R2\nX=R2\nMCALL\nGOTOF OUT\nENDLOOP\nOUT: M30\n",
            &[],
            "G0 X0 Y0 Z9 A0 C0\nR2=0\nMCALL CYCLE82(6.0000, 2+1,1 ,,3.0000,1) ; R2\nX=1.0000\nMCALL\nOUT: M30\n",
        ),
        (
            Dialect::Heidenhain,
            "0 BEGIN PGM P MM ; x\n1 L X+0 R0 F100\n2 Q1 = 5\n3 CALL LBL 1\n4 M30\n5 LBL 1\n6 L X+Q1 IY-Q1\n7 LBL 0\n8 END PGM P MM\n",
            &[],
            "0 BEGIN PGM P MM ; x\n1 L X+0 R0 F100\n2 Q1 = 5\n6 L X+5.0000 IY-5.0000\n4 M30\nEND PGM P MM\n",
        ),
    ] {
        let (_, text) = written(dialect, &Several { main, files }).unwrap().unwrap();
        assert_eq!(text, wanted);
    }
    let told = written(
        Dialect::Iso,
        &Several { main: "G0 X0\no1 repeat [3]\n#1=[#1+1]\nG91 X1\no1 endrepeat\n", files: &[] },
    );
    let (told, _) = told.unwrap().unwrap();
    assert_eq!(
        told,
        WrittenOut {
            dialect: Dialect::Iso,
            assignments: 3,
            first_assignment: Some(3),
            files_never_called: 0
        }
    );
    let files = &[("O2.nc", "O2\nX1\nM99\n"), ("O3.nc", "O3\nX2\nM99\n"), ("O4.nc", "O4\nX3\nM99\n")];
    let (told, _) = written(Dialect::Iso, &Several { main: "G0 X0\nM98 P3\nM30\n", files }).unwrap().unwrap();
    assert_eq!(told.files_never_called, 2);
}

#[test]
fn what_cannot_be_written_out_is_refused_with_its_line_and_the_cure() {
    for (dialect, main, line, wanted) in [
        (Dialect::Iso, "G0 X0\nM98 P2\n", 2, "its file is missing"),
        (Dialect::Iso, "G0 X0\nM98 P2 L100000\nM30\nO2\nM99\n", 2, "its number or its count"),
        (Dialect::Iso, "G0 X0\no1 repeat [1]\nG65 P9 A1\no1 endrepeat\n", 3, "this call is not followed"),
        (Dialect::Iso, "G0 X0\no1 repeat [1]\nG1 X#<_x> F5\no1 endrepeat\n", 3, "does not fix"),
        (Dialect::Iso, "G0 X0\no1 repeat [1]\n#5221=5\no1 endrepeat\n", 3, "offsets or other values"),
        (Dialect::Iso, "G0 X0\no1 repeat [1]\n#1=3 G1 X5 F5\no1 endrepeat\n", 3, "in one block"),
        (
            Dialect::Siemens,
            "DEF REAL D\nD=3\nLOOP\nCYCLE832(D)\nGOTOF OUT\nENDLOOP\nOUT: M30\n",
            4,
            "does not fix",
        ),
        (Dialect::Iso, "G0 X0\nG65 P1\n", 2, "this call is not followed"),
        (
            Dialect::Iso,
            "G0 X0\no1 repeat [1]\n#3000=1 (ALARM)\no1 endrepeat\n",
            3,
            "other values of the control",
        ),
        (
            Dialect::Iso,
            "G0 X0 Y0 Z0 A0 C0\nG1 F9\no1 repeat [1000]\nG91 X[1/3]\no1 endrepeat\n",
            4,
            "rounded values add up",
        ),
        (
            Dialect::Siemens,
            "R7=5\nLOOP\nR7=45\nPOCKET3(R[7],2)\nGOTOF OUT\nENDLOOP\nOUT: M30\n",
            4,
            "does not fix",
        ),
        (
            Dialect::Siemens,
            "LOOP\n_ZSD[1]=1\nGOTOF OUT\nENDLOOP\nOUT: M30\n",
            2,
            "other values of the control",
        ),
        (
            Dialect::Heidenhain,
            "0 BEGIN PGM P MM\n1 L X+1 R0 F9\n2 CYCL DEF 200 DRILLING ~\n Q200=+2 ;UP ~\n Q201=-9 ;DEPTH\n3 LBL 1\n4 L X+20 R0 FMAX M99\n5 Q201 = Q201 - 5\n6 CALL LBL 1 REP 2\n7 M30\n8 END PGM P MM\n",
            8,
            "a program with cycles",
        ),
        (
            Dialect::Heidenhain,
            "0 BEGIN PGM P MM\n1 L X+1 R0 F9\n2 CALL LBL 1\n3 Q5 = 3\n4 RND RQ5\n5 M30\n6 LBL 1\n7 LBL 0\n8 END PGM P MM\n",
            5,
            "does not fix",
        ),
        (Dialect::Siemens, "G0 X0\nPOCKET\n", 2, "its file is missing"),
        (Dialect::Iso, "G0 X0\no1 while [1]\nX1\no1 endwhile\n", 4, "250000 blocks"),
    ] {
        let refused = written(dialect, &Several { main, files: &[] }).expect_err(main).to_string();
        assert!(refused.contains(&format!("line {line}")) && refused.contains(wanted), "{main}: {refused}");
    }
    assert_eq!(written(Dialect::Iso, &Several { main: "G0 X#1\nX5\n", files: &[] }).unwrap(), None);
}
