//! Sinumerik programs as they leave: what is divided looks like its neighbours, everything else is there as it was.

#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;

use crate::models::set_ups::at_zero;
use proptest::prelude::*;
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::motion::{AxisWords, Interpreter, InterpreterOptions};
use trunnion::process::{
    CcParameters, CcReport, ContactSource, WearParameters, WornCutter, compensate, compensate_wear,
};
use trunnion::program::{Batch, Diagnostics, Dialect, MAX_MAGNITUDE, ReadLimits, Reader};
use trunnion::units::Length;

fn machine(id: &str) -> Machine {
    Machine::new(Preset::by_id(id).expect("a preset").parts()).expect("a machine")
}

fn run(id: &str, tolerance_um: f64, text: &str) -> (String, CcReport) {
    let tool = Tool::new(Length::from_mm(6.0), Length::from_mm(1.5)).expect("a tool");
    let parameters = CcParameters {
        contact: ContactSource::FeedPlane,
        tolerance: Length::from_um(tolerance_um),
        ..CcParameters::new(tool, at_zero())
    };
    let mut output = Vec::new();
    let report = compensate(&machine(id), &parameters, &text.as_bytes().to_vec(), &mut output, &|| {
        ControlFlow::Continue(())
    })
    .unwrap_or_else(|fault| panic!("{fault:?}"));
    assert_eq!(report.dialect, Dialect::Siemens);
    (String::from_utf8(output).expect("text"), report)
}

#[test]
fn divided_blocks_look_like_their_neighbours_and_expressions_stay() {
    let (output, report) = run("ac-table", 10.0, MACHINE_WORDS);
    assert!(report.after.max_mm <= 0.010 && report.motions_over_tolerance == 2, "{report:?}");
    let lines: Vec<&str> = output.lines().collect();
    let kept = |line: &str| lines.contains(&line);
    for line in MACHINE_WORDS.lines().filter(|line| !line.starts_with("N30") && !line.starts_with("N40")) {
        assert!(kept(line), "{line}: {output}");
    }
    let first = lines.iter().position(|line| line.starts_with("N40")).expect("N40");
    // The value of an expression that does not change keeps its text; new words take the form of the block.
    assert!(lines[first].contains(" A=TILT ") && lines[first].ends_with("; last"), "{}", lines[first]);
    assert!(lines[first].contains("N40 X=2") && !lines[first].contains("IC("), "{}", lines[first]);
    // Words without `=` in the source block have none in the new ones, and the last part ends where the block did.
    let last = lines[lines.len() - 2];
    assert!(
        last.starts_with("N4") && last.contains("X25.0000 Y10.0000 Z2.5000 A20.5000 C1.5000"),
        "{output}"
    );
    let second = lines.iter().position(|line| line.starts_with("N30")).expect("N30") + 1;
    assert!(lines[second].contains("X=") && lines[second].contains(" A="), "{}", lines[second]);
}

const MACHINE_WORDS: &str = "%_N_PART_MPF
DEF REAL DEPTH=2.5, TILT=20.5
N10 G17 G71 G90 G54 D1
N20 G0 X0 Y0 Z=DEPTH A20 C0
N25 G1 X10.0000 F1000
N30 G1 X=20.0000 Y=10.0000 Z=DEPTH+0 A=20.5000 C=1.0000 F=1000
N40 X=IC(5) Z=AC(2.5) A=TILT C1.5000 F1000 ; last
N50 MSG(\"done\") M30
";

/// The same path for a Sinumerik, with every form of a word, and in plain ISO words.
const PATHS: [[&str; 2]; 2] = [
    [
        "DEF REAL STEP=2, DEPTH[2]=SET(-1.5,0.25)
R1=4*STEP R2=30
TRAORI
G0 X0.0000 Y0.0000 Z=DEPTH[0] A20.0000 C=R2
G1 X=R1 Y=2.5000 A=22.0000 C=IC(1.5) F=100*STEP
X=IC(STEP) Y=AC(5.0000) Z=DEPTH[1] A=IC(STEP)
G91 X=AC(15) Y2.0000 A=AC(24.5) C=SIN(30)*2
G90 X=SQRT(POT(12)+POT(16)) Y=IC(-1) Z1.0000 C=R2+5
M30
",
        "G43.4 H1
G0 X0.0000 Y0.0000 Z-1.5000 A20.0000 C30.0000
G1 X8.0000 Y2.5000 A22.0000 C31.5000 F200
X10.0000 Y5.0000 Z0.2500 A24.0000
X15.0000 Y7.0000 A24.5000 C32.5000
X20.0000 Y6.0000 Z1.0000 C35.0000
M30
",
    ],
    [
        "R10=0.5 R11=200
G1 F600 X0.0000 Y0.0000 Z0.0000 A20.0000 C10.0000
X=R11*R10*0.1 Y=2*R10 A=20+R10 C=IC(R10)
X=IC(10.0000) Y=AC(2.5000) A=AC(21.0000) C11.0000
X=R11/10+10 Z=IC(-R10) C=IC(0.5000)
M30
",
        "G1 F600 X0.0000 Y0.0000 Z0.0000 A20.0000 C10.0000
X10.0000 Y1.0000 A20.5000 C10.5000
X20.0000 Y2.5000 A21.0000 C11.0000
X30.0000 Z-0.5000 C11.5000
M30
",
    ],
];

/// Where the motions of a program end, in its decimals.
fn ends(text: &str, dialect: Dialect) -> Vec<AxisWords> {
    let mut reader = Reader::new(Some(dialect), ReadLimits::default());
    reader.feed(text.as_bytes());
    reader.finish();
    let mut interpreter = Interpreter::new(&machine("ac-table"), InterpreterOptions::in_mm());
    let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
    while reader.next_batch(&mut batch).expect("blocks") {
        interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
    }
    assert_eq!(diagnostics.kept(), []);
    motions.iter().map(|motion| motion.end.expect("five axes")).collect()
}

/// Sums in another order differ in the last bits [mm, deg].
const SAME: f64 = 1e-9;

fn assert_same(name: &str, texts: [&str; 2]) {
    let [siemens, iso] = [ends(texts[0], Dialect::Siemens), ends(texts[1], Dialect::Iso)];
    assert_eq!(siemens.len(), iso.len(), "{name}: {} {}", texts[0], texts[1]);
    for (a, b) in siemens.iter().zip(&iso) {
        let linear = a.linear_mm.iter().zip(&b.linear_mm);
        let same = linear.chain(a.rotary_deg.iter().zip(&b.rotary_deg)).all(|(a, b)| (a - b).abs() <= SAME);
        assert!(same, "{name}: {a:?}, not {b:?}: {} {}", texts[0], texts[1]);
    }
}

#[test]
fn every_form_of_a_word_means_what_plain_words_mean_and_is_compensated_alike() {
    for (texts, tolerance_um) in PATHS.into_iter().zip([1.0, 10.0]) {
        assert_same("source", texts);
        let machine = machine("ac-table");
        let tool =
            |radius, corner| Tool::new(Length::from_mm(radius), Length::from_mm(corner)).expect("a tool");
        let parameters = CcParameters {
            contact: ContactSource::FeedPlane,
            tolerance: Length::from_um(tolerance_um),
            ..CcParameters::new(tool(6.0, 1.5), at_zero())
        };
        let go_on = || ControlFlow::Continue(());
        let mut over = 0;
        let outputs = texts.map(|text| {
            let mut output = Vec::new();
            let report = compensate(&machine, &parameters, &text.as_bytes().to_vec(), &mut output, &go_on)
                .unwrap_or_else(|fault| panic!("{fault:?}: {text}"));
            over = report.motions_over_tolerance;
            String::from_utf8(output).expect("text")
        });
        assert!(over > 0, "{}", texts[0]);
        assert_same("contact path", [&outputs[0], &outputs[1]]);
        let parameters = WearParameters {
            contact: ContactSource::FeedPlane,
            ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.9, 4.9)), at_zero())
        };
        let outputs = texts.map(|text| {
            let mut output = Vec::new();
            compensate_wear(&machine, &parameters, &text.as_bytes().to_vec(), &mut output, &go_on)
                .unwrap_or_else(|fault| panic!("{fault:?}: {text}"));
            String::from_utf8(output).expect("text")
        });
        assert!(outputs[0] != texts[0]);
        assert_same("worn", [&outputs[0], &outputs[1]]);
    }
}

/// Pieces of which programs are made, good and bad.
fn program_text() -> impl Strategy<Value = Vec<u8>> {
    let piece = prop::sample::select(vec![
        &b"G1"[..],
        b" ",
        b" ",
        b"X1.5",
        b"Y=-.25",
        b"Z = IC(2)",
        b"A=AC(",
        b"C=DC(30)",
        b"\n",
        b"\r\n",
        b"\r",
        b"\n",
        b"\n",
        b";note",
        b"%_N_A_MPF",
        b"/",
        b"N10",
        b":20",
        b"L100",
        b"R1=",
        b"R[R1]=5",
        b"R1",
        b"+",
        b"-",
        b"*",
        b"(",
        b")",
        b"[",
        b"]",
        b",",
        b"=",
        b"\"text\"",
        b"\"",
        b"'HFF'",
        b"'",
        b"1EX3",
        b"EX-4",
        b"DEF REAL A_1, B_1[2]=SET(1,2)",
        b"DEF INT ",
        b"A_1=",
        b"A_1",
        b"B_1[1]",
        b"SET(",
        b"REP(1,2)",
        b"SIN(30)",
        b" DIV ",
        b" MOD ",
        b"NOT ",
        b"TRAORI",
        b"SUPA",
        b"TRANS X10",
        b"ROT RPL=30",
        b"CYCLE800(",
        b"CYCLE832(0.1,1)",
        b"MCALL ",
        b"CYCLE81(1,2)",
        b"MSG(\"a\")",
        b"GOTOF X_",
        b"X_:",
        b"A3=0.1",
        b"X1=5",
        b"AX[1]=2",
        b"M=QU(3)",
        b"M2=3",
        b"G[1]=2",
        b"$P_UIFR[1]=",
        b"$AA_IM[X]",
        b"T=\"A\"",
        b"D1",
        b"CR=5",
        b"RND=2",
        b"F=R1*2",
        b"\xe9",
        b"\0",
        b"\t",
        b"99999999999",
        b"<<",
        b"==",
        b"WHEN TRUE DO M5",
        b"NAME(1)",
        b"E10E5",
        b"_",
        b"$",
        b".",
        b"M30",
    ]);
    prop::collection::vec(piece, 0..60).prop_map(|pieces| pieces.concat())
}

fn read(text: &[u8], chunk: usize) -> Vec<Batch> {
    let limits = ReadLimits { batch_blocks: 7, ..ReadLimits::default() };
    let mut reader = Reader::new(Some(Dialect::Siemens), limits);
    let (mut batch, mut batches) = (Batch::new(), Vec::new());
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

proptest! {
    #[test]
    fn every_byte_is_in_one_block_and_every_word_in_its_block(text in program_text(), chunk in 1_usize..40) {
        let batches = read(&text, chunk);
        let mut printed = Vec::new();
        for batch in &batches {
            for block in batch.blocks() {
                printed.extend_from_slice(batch.block_text(block));
                let mut from = block.start;
                for word in batch.words(block) {
                    prop_assert!(from <= word.start && word.start + u32::from(word.lead) <= word.end);
                    prop_assert!(word.end <= block.body_end && word.value.is_finite());
                    from = word.end;
                }
            }
        }
        prop_assert!(printed == text);
        prop_assert!(read(&text, usize::MAX) == batches);
    }

    #[test]
    fn no_text_gives_places_that_are_no_numbers(text in program_text()) {
        let mut interpreter = Interpreter::new(&machine("ac-table"), InterpreterOptions::in_mm());
        let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
        for mut batch in read(&text, usize::MAX) {
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
            for word in batch.blocks().iter().flat_map(|block| batch.words(block)) {
                prop_assert!(word.value.is_finite() && word.value.abs() <= MAX_MAGNITUDE);
            }
        }
        for end in motions.iter().filter_map(|motion| motion.end) {
            prop_assert!(end.linear_mm.iter().chain(&end.rotary_deg).all(|value| value.is_finite()));
        }
    }
}
