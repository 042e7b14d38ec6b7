//! What real programs contain besides plain words: arguments of M codes, names, comments within comments, blank lines,
//! arcs of several turns, further transformations, tools by name, dialects that are not read.

#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;

use proptest::prelude::*;
use trunnion::machine::{Machine, Preset};
use trunnion::motion::Unfollowable;
use trunnion::process::{
    CcParameters, CcReport, ContactSource, Fault, LineFaultKind, ProgramSetup, ToolUnknown, WarningKind,
    WearParameters, WornCutter, compensate, compensate_wear,
};
use trunnion::program::{Batch, Dialect, ForeignDialect, Grammar, ReadFault, ReadLimits, Reader};
use trunnion::units::Length;

use crate::models::finishing::tool;
use crate::models::set_ups::{at_zero, with_tool};

fn machine() -> Machine {
    Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine")
}

fn compensated_as(dialect: Option<Dialect>, text: &str) -> Result<(String, CcReport), Fault> {
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

fn compensated(text: &str) -> (String, CcReport) {
    compensated_as(None, text).unwrap_or_else(|fault| panic!("{fault:?}\n{text}"))
}

/// The text of the program refused, if it is.
fn refused(text: &str) -> Option<String> {
    match compensated_as(None, text) {
        Ok(_) => None,
        Err(Fault::Program(diagnostics)) => diagnostics.refusals().next().map(ToString::to_string),
        Err(fault) => panic!("{fault:?}\n{text}"),
    }
}

const BEGIN: &str = "G21 G90 G94 G17\nG0 X50.000 Y0.000 Z0.000 A0.000 C0.000\n";
/// Turns both axes enough to be divided, with `more` in its block.
fn cut(more: &str) -> String {
    format!("{BEGIN}G1 X50.000 Y20.000 A20.000 C20.000 F1000{more}\nM30\n")
}

#[test]
fn an_argument_of_an_m_code_stays_with_it_wherever_its_block_goes() {
    let (plain, _) = compensated(&cut(""));
    assert!(plain.lines().count() > cut("").lines().count(), "the cut is one to be divided");
    // A code that acts where the block ends moves to the last part, and takes its argument along.
    for (more, last) in [(" M202(0.0059)", false), (" M9(0.0059,(2))", true), (" M202(0.0059) M9", false)] {
        let (output, _) = compensated(&cut(more));
        let code = more.split_ascii_whitespace().next().expect("a code");
        assert_eq!(output.matches(code).count(), 1, "{output}");
        let parts: Vec<&str> = output.lines().skip(2).collect();
        let at = parts.iter().position(|part| part.contains(code)).expect("the code");
        assert_eq!(at, if last { parts.len() - 2 } else { 0 }, "{output}");
        assert_eq!(output.replace(more, "").lines().count(), plain.lines().count());
    }
    // It is a block of its own as well, and leaves the path alone.
    let apart = cut("").replace("G1 X", "M202(0.0059)\nG1 X");
    assert_eq!(compensated(&apart).0, plain.replacen("G1 X", "M202(0.0059)\nG1 X", 1));
    // In the other dialects, too.
    let siemens = "%_N_P_MPF\nG71 G90 G94 G17\nG0 X50.000 Y0.000 Z0.000 A0.000 C0.000\n\
                   N10 M202(0.0059)\nN20 G1 X50.000 Y20.000 A20.000 C20.000 F1000 M203(1,2)\nM30\n";
    let conversational = "0 BEGIN PGM P MM\n1 L X+50.000 Y+0.000 Z+0.000 A+0.000 C+0.000 R0 FMAX M202(0.0059)\n\
                          2 L X+50.000 Y+20.000 A+20.000 C+20.000 F1000 M203(1,2)\n9 END PGM P MM\n";
    for text in [siemens, conversational] {
        let (output, report) = compensated(text);
        assert!(report.blocks_out > report.blocks_in, "{output}");
        for code in ["M202(0.0059)", "M203(1,2)"] {
            assert_eq!(output.matches(code).count(), 1, "{output}");
        }
    }
}

#[test]
fn names_at_the_head_are_headers_and_change_nothing() {
    let (plain, _) = compensated(&format!("O1001\n{}", cut("")));
    for head in [
        "O1001(NAME)",
        "O 1001",
        "OPROG1",
        "N5 OPROG-1_A (HEAD)",
        "O<POCKET 1>",
        "o<pocket>(x)",
        "<POCKET.NC>",
        "OSUB",
        "ONAME ;text",
    ] {
        let text = format!("%\n{head}\n{}", cut(""));
        let (output, _) = compensated(&text);
        assert_eq!(output, plain.replacen("O1001", &format!("%\n{head}"), 1), "{head}");
    }
    // Flow of RS274 stays what it is, and a word in the middle of a block is no name.
    for flow in ["o100 sub", "o<pocket> sub", "O SUB", "o100 while [#1 LT 2]", "OPROG1 SUB"] {
        assert!(refused(&format!("{flow}\n{}", cut(""))).is_some(), "{flow}");
    }
    assert!(refused(&cut(" OVER")).is_some_and(|text| text.contains("OVER")));
    let called = compensated(&cut("").replacen("M30", "o<pocket> call\nM30", 1)).1;
    assert!(called.warnings.iter().any(|warning| warning.kind == WarningKind::EffectUnknown), "{called:?}");
}

#[test]
fn another_program_behind_a_name_is_another_program() {
    // Positions and modes of the one are not those of the other.
    for head in ["O2", "OPROG2", "O<PROG2>", "<PROG2>"] {
        let second = "G1 X50.000 Y30.000 A30.000 C30.000 F1000\n";
        let text = cut("").replacen("M30\n", &format!("{head}\n{second}M30\n"), 1);
        let (output, _) = compensated(&text);
        assert!(output.ends_with(&format!("{head}\n{second}M30\n")), "{output}");
    }
}

#[test]
fn a_comment_within_a_comment_hides_no_word() {
    let (plain, _) = compensated(&cut(""));
    let comment = "(T1 (BALL (D10)) 10MM, R5) G1 X";
    assert_eq!(compensated(&cut("").replacen("G1 X", comment, 1)).0, plain.replacen("G1 X", comment, 1));
    // Half of a bracket is text, and what stands behind it counts.
    let open = "(T1 (BALL) G1 X";
    assert_eq!(compensated(&cut("").replacen("G1 X", open, 1)).0, plain.replacen("G1 X", open, 1));
    // On some controls this one moves.
    for line in ["(OLD (Z5) G1 X10.)", "(OLD (Z5) M98 P2)", "N10 (OLD (Z5) F200. )"] {
        let text = cut("").replacen("M30", &format!("{line}\nM30"), 1);
        let why = refused(&text).unwrap_or_else(|| panic!("{line} is not refused"));
        assert!(why.starts_with("line 4,") && why.contains("inside the comment"), "{why}");
    }
}

/// A program of each dialect with a cut that is divided, line by line.
const PROGRAMS: [&str; 5] = [
    "%\nO1\nG21 G90 G94 G17\nG0 X50.000 Y0.000 Z0.000 A0.000 C0.000\nG1 X50.000 Y20.000 A20.000 C20.000 F1000\nM30\n%",
    "%_N_P_MPF\nG71 G90 G94 G17\nG0 X50.000 Y0.000 Z0.000 A0.000 C0.000\nG1 X50.000 Y20.000 A20.000 C20.000 F1000\nM30",
    "0 BEGIN PGM P MM\n1 L X+50.000 Y+0.000 Z+0.000 A+0.000 C+0.000 R0 FMAX\n2 L X+50.000 Y+20.000 A+20.000 C+20.000 F1000\n9 END PGM P MM",
    "X,Y,Z,A,C,F\n50.000,0.000,0.000,0.000,0.000,1000\n50.000,20.000,0.000,20.000,20.000,1000",
    "PARTNO/P\nUNITS/MM\nMULTAX/ON\nFEDRAT/1000.,MMPM\nGOTO/0.0000,0.0000,5.0000,0.000000,0.000000,1.000000\nGOTO/20.0000,0.0000,5.0000,0.342020,0.000000,0.939693\nGOTO/20.0000,20.0000,5.0000,0.000000,0.500000,0.866025\nFINI",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn blank_lines_stay_where_they_are_and_change_nothing(
        program in 0..PROGRAMS.len(),
        blanks in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..5), 1..6),
    ) {
        let lines: Vec<&str> = PROGRAMS[program].lines().collect();
        let (plain, _) = compensated(&format!("{}\n", lines.join("\n")));
        let mut text: Vec<&str> = lines.clone();
        for (at, kind) in blanks {
            let blank = [" ", "", "\t", " \t  ", "\x0c"][kind];
            text.insert(at.index(text.len() + 1), blank);
        }
        let (output, _) = compensated(&format!("{}\n", text.join("\n")));
        let without = |text: &str| -> Vec<String> {
            text.lines().filter(|line| !line.trim_ascii().is_empty()).map(str::to_owned).collect()
        };
        prop_assert_eq!(without(&output), without(&plain));
        let blank = |lines: &mut dyn Iterator<Item = &str>| -> Vec<String> {
            lines.filter(|line| line.trim_ascii().is_empty()).map(str::to_owned).collect()
        };
        prop_assert_eq!(blank(&mut output.lines()), blank(&mut text.iter().copied()));
    }

    #[test]
    fn every_byte_is_in_one_block_in_every_dialect(
        pieces in prop::collection::vec(prop::sample::select(PIECES.to_vec()), 0..40),
        // A table is refused where its header is none.
        dialect in prop::sample::select(Dialect::ALL.to_vec())
            .prop_filter("no table", |dialect| dialect.rules().grammar != Grammar::Cells),
        chunk in 1_usize..30,
    ) {
        let text = pieces.concat();
        let whole = read(text.as_bytes(), dialect, text.len().max(1));
        let printed: Vec<u8> = whole
            .iter()
            .flat_map(|batch| batch.blocks().iter().flat_map(|block| batch.block_text(block).to_vec()).collect::<Vec<_>>())
            .collect();
        prop_assert_eq!(printed, text.as_bytes());
        for batch in &whole {
            for block in batch.blocks() {
                for word in batch.words(block) {
                    prop_assert!(block.start <= word.start && word.end <= block.end);
                    prop_assert!(word.start + u32::from(word.lead) <= word.end);
                    prop_assert!(word.value.is_finite());
                }
            }
        }
        prop_assert_eq!(read(text.as_bytes(), dialect, chunk), whole);
    }
}

#[test]
fn the_control_byte_that_ends_an_old_file_and_those_of_a_printer_are_blank_lines() {
    for program in PROGRAMS {
        let (plain, report) = compensated(&format!("{program}\n"));
        let (first, rest) = program.split_once('\n').expect("lines");
        let (output, with) = compensated(&format!("{first}\n\x0b \x0c\n{rest}\n\x1a"));
        let (first, rest) = plain.split_once('\n').expect("lines");
        assert_eq!(output, format!("{first}\n\x0b \x0c\n{rest}\x1a"));
        assert_eq!(with.blocks_out - with.blocks_in, report.blocks_out - report.blocks_in);
    }
}

/// Pieces of lines, good and bad.
const PIECES: [&str; 34] = [
    "M202(0.0059)",
    "M202 (1)",
    "M9(",
    "(T1 (BALL) 10MM)",
    "(A (B) G1 X5)",
    "((",
    "))",
    "(",
    ")",
    "OPROG1",
    "O<NAME>",
    "<NAME>",
    "O ",
    "OSUB",
    "\n",
    "\r\n",
    " \n",
    "\t\n",
    "\x0c\n",
    "\x1a",
    " ",
    "G1 X5 ",
    "TURN=2 ",
    "TURN=",
    "TURN=R1 ",
    "T=\"BALL_10\" ",
    "T=\"",
    "1 TOOL CALL \"BALL_10\" Z",
    "TRAORI(2)",
    "TRAORI(1,0,0,1)",
    "GOTO/1,2,3",
    ";x",
    "Q1=",
    "~",
];

fn read(text: &[u8], dialect: Dialect, chunk: usize) -> Vec<Batch> {
    let mut reader = Reader::new(Some(dialect), ReadLimits { batch_blocks: 5, ..ReadLimits::default() });
    let (mut batches, mut batch) = (Vec::new(), Batch::new());
    for piece in text.chunks(chunk) {
        reader.feed(piece);
        while reader.next_batch(&mut batch).expect("short lines") {
            batches.push(batch.clone());
        }
    }
    reader.finish();
    while reader.next_batch(&mut batch).expect("short lines") {
        batches.push(batch.clone());
    }
    batches
}

fn worn(parameters: &WearParameters, text: &str) -> Result<String, Fault> {
    let mut output = Vec::new();
    let source = text.as_bytes().to_vec();
    compensate_wear(&machine(), parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok(String::from_utf8(output).expect("text"))
}

/// A cutter of the nominal shape that is 0.5 mm shorter, which the control does not know: every tip goes down.
fn shorter() -> WearParameters {
    WearParameters {
        contact: ContactSource::FeedPlane,
        shorter_by: Length::from_mm(0.5),
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(5.0, 5.0)), at_zero())
    }
}

#[test]
fn an_arc_of_several_turns_is_moved_and_keeps_them() {
    let text = "%_N_P_MPF\nG71 G90 G94 G17\nG0 X10.000 Y0.000 Z5.000 A0.000 C0.000\nG1 Z0.000 F500\n\
                G3 X0.000 Y10.000 Z-1.000 I-10.000 J0.000 TURN=2\nG2 X10.000 Y0.000 Z-2.000 I=AC(0) J=AC(0) TURN=0\n\
                G1 X12.000\nM30\n";
    let expected = ["Z5.000 ", "Z0.000 ", "Z-1.000 ", "Z-2.000 "]
        .iter()
        .zip(["Z4.500 ", "Z-0.500 ", "Z-1.500 ", "Z-2.500 "])
        .fold(text.to_owned(), |text, (from, to)| text.replacen(from, to, 1));
    assert_eq!(worn(&shorter(), text).expect("moved"), expected);
    // A centre that is a place does not go along where the ends move across the plane.
    let tilted = text.replace("A0.000", "A30.000").replacen("G0", "TRAORI\nG0", 1);
    match worn(&shorter(), &tilted) {
        Err(Fault::Lines(faults)) => {
            assert!(faults.kept.iter().any(|fault| fault.line == 7), "{faults:?}");
            assert!(faults.kept.iter().all(|fault| fault.line != 6), "{faults:?}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_second_transformation_is_left_alone_with_its_reason() {
    let text = "%_N_P_MPF\nG71 G90 G94 G17\nTRAORI(2)\nG0 X50.000 Y0.000 Z0.000 A10.000 C0.000\n\
                G1 X50.000 Y20.000 A20.000 C20.000 F1000\nTRAORI(1)\nG0 X50.000 Y0.000 Z0.000 A10.000 C0.000\n\
                G1 X50.000 Y20.000 A20.000 C20.000 F1000\nTRAFOOF\nM30\n";
    let (output, report) = compensated(text);
    let at = text.find("TRAORI(1)").expect("the first one");
    assert!(output.starts_with(&text[..at]) && !output.contains(&text[at..]), "{output}");
    let left = report.warnings.iter().find(|warning| warning.kind == WarningKind::NotFollowed);
    let left = left.unwrap_or_else(|| panic!("{:?}", report.warnings));
    assert_eq!((left.reason, left.line), (Some(Unfollowable::OtherTransformation), Some(5)));
    assert!(Unfollowable::OtherTransformation.to_string().contains("second transformation"));
    // What would have to move cannot.
    match worn(&shorter(), text) {
        Err(Fault::Lines(faults)) => assert!(
            faults
                .kept
                .iter()
                .any(|fault| fault.kind == LineFaultKind::NotMovable(Unfollowable::OtherTransformation)),
            "{faults:?}"
        ),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_tool_before_a_change_is_the_one_that_is_moved_and_names_tell_tools_apart() {
    let pass = "G0 X0.000 Y0.000 Z20.000 A-30.000 C0.000\nG1 Y10.000 Z24.000 F800\nG0 Z90.000\n";
    let numbered = |number| WearParameters { program: with_tool(number), ..shorter() };
    // T2 behind the change is only made ready.
    let text = format!("T1 M6 T2\n{pass}M30\n");
    assert_eq!(
        worn(&numbered(1), &text).expect("moved").replace("T1 M6 T2", "T1 M6"),
        worn(&numbered(1), &format!("T1 M6\n{pass}M30\n")).expect("moved")
    );
    assert!(matches!(worn(&numbered(2), &text), Err(Fault::Tool(ToolUnknown::NoSuchTool { number: 2, .. }))));
    let alone = format!("M6 T2\n{pass}M30\n");
    assert_ne!(worn(&numbered(2), &alone).expect("moved"), alone);
    // Another name is another tool, the same name the same one.
    let refused = |first: &str, second: &str, dialect| {
        let parameters =
            WearParameters { program: ProgramSetup { dialect: Some(dialect), ..at_zero() }, ..by_feed() };
        let text = match dialect {
            Dialect::Heidenhain => {
                let lines = "L X+0.000 Y+0.000 Z+20.000 A-30.000 C+0.000 FMAX\nL Y+10.000 Z+24.000 F800\nL Z+90.000 FMAX\n";
                format!("BEGIN PGM P MM\n{first}\n{lines}{second}\n{lines}END PGM P MM\n")
            }
            _ => format!("{first}\n{pass}{second}\n{pass}M30\n"),
        };
        match worn(&parameters, &text) {
            Ok(_) => false,
            Err(Fault::Tool(ToolUnknown::Several { count: 2, .. })) => true,
            Err(fault) => panic!("{fault:?}"),
        }
    };
    assert!(!refused("T=\"BALL_10\" M6", "T=\"ball_10\" M6", Dialect::Siemens));
    assert!(refused("T=\"BALL_10\" M6", "T=\"BALL_12\" M6", Dialect::Siemens));
    let call = |name: &str| format!("TOOL CALL \"{name}\" Z S1000");
    assert!(!refused(&call("BALL_10"), &call("BALL_10"), Dialect::Heidenhain));
    assert!(refused(&call("BALL_10"), &call("BALL_12"), Dialect::Heidenhain));
}

fn by_feed() -> WearParameters {
    WearParameters {
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)), at_zero())
    }
}

#[test]
fn a_dialect_that_is_not_read_is_called_by_its_name() {
    let body = cut("");
    for (head, line, dialect, name) in [
        ("%PM9001\nN9001 (PART)\n", 1, ForeignDialect::MillPlus, "MillPlus"),
        ("$PART.MIN%\nOPART\nVC1=5\n", 3, ForeignDialect::Okuma, "Okuma"),
        ("OPART\nVC1=5\n", 2, ForeignDialect::Okuma, "Okuma"),
        ("%PART,MX--,\n", 1, ForeignDialect::Fagor, "Fagor 8055"),
        ("%100\nN10 G79 N10\n", 2, ForeignDialect::Num, "NUM"),
        ("(UAO,1)\n", 1, ForeignDialect::Osai, "OSAI"),
    ] {
        match compensated_as(None, &format!("{head}{body}")) {
            Err(Fault::Unreadable(fault)) => {
                assert_eq!(fault, ReadFault::UnsupportedDialect { line, dialect });
                let text = fault.to_string();
                assert!(text.starts_with(&format!("line {line}: ")) && text.contains(name), "{text}");
            }
            other => panic!("{head}: {other:?}"),
        }
    }
    // Where the caller says what it is, it is read as that; and plain words of such a control are as before.
    let stated = compensated_as(Some(Dialect::Iso), &format!("(UAO,1)\n{body}")).expect("as stated").0;
    assert_eq!(stated, format!("(UAO,1)\n{}", compensated(&body).0));
    let okuma = "O0001 (PART)\nG15 H1\n";
    assert!(compensated(&format!("{okuma}{body}")).0.starts_with(okuma));
}
