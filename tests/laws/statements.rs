//! Laws of readers whose statements run over lines: any text comes back byte for byte, in whatever chunks it came, and
//! the interpreter takes whatever the reader makes of it.

use proptest::prelude::*;
use trunnion::motion::{Interpreter, InterpreterOptions};
use trunnion::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};

use crate::models::finishing::ac_machine;

const HEIDENHAIN: [&str; 46] = [
    "L ",
    "LN ",
    "C ",
    "CC ",
    "CR ",
    "X+1.5 ",
    "IY-2,25 ",
    "Z Q1 ",
    "A-QL2 ",
    "NX+0.6 ",
    "TZ-1 ",
    "R0 ",
    "RL ",
    "DR+ ",
    "F100 ",
    "FMAX ",
    "FAUTO ",
    "F ",
    "M128 ",
    "M99 ",
    "M140 MB MAX F1 ",
    "M118 X1 ",
    "LBL 1 ",
    "LBL 0 ",
    "LBL \"a\" ",
    "CALL LBL 1 ",
    "CALL LBL 1 REP 2/2 ",
    "CALL PGM X ",
    "CYCL DEF 7.1 X+1 ",
    "CYCL DEF 200 ~",
    "    Q200=+2 ;SET-UP ~",
    "CYCL DEF 10.1 ROT+0 ",
    "Q1 = 2 * ( Q2 - 3 ) ^ 2 ",
    "FN 0: Q1 = -5 ",
    "FN 9: IF +Q1 EQU +0 GOTO LBL 1 ",
    "PLANE RESET ",
    "TOOL CALL \"T\" Z S1 F2 ",
    "BEGIN PGM A MM ",
    "END PGM A MM ",
    "RND R2 ",
    "; note ~",
    "~",
    "\n",
    "\r\n",
    "17 ",
    "é%/",
];
const APT: [&str; 34] = [
    "GOTO/",
    "GOTO / ",
    "GODLTA/",
    "FROM/",
    "1.5,",
    "-.25,",
    "0,",
    "1E-3,",
    "6.D+02",
    " ",
    "2",
    "RAPID",
    "FEDRAT/",
    "MMPM",
    ",MMPR",
    "CIRCLE/",
    "CYCLE/OFF",
    "CUTCOM/LEFT",
    "MULTAX/ON",
    "TLAXIS/0,0,1",
    "UNITS/INCHES",
    "CSYS/1,0",
    "ROTABL/1.5,AAXIS",
    "TLON,GOFWD/",
    "PPRINT $",
    "CALL/A",
    "JUMPTO/1",
    "$$ note",
    "$",
    "\n",
    "\r\n",
    "FINI",
    "é",
    "/",
];

fn batches(text: &[u8], dialect: Dialect, chunk: usize) -> Vec<Batch> {
    let mut reader = Reader::new(Some(dialect), ReadLimits { batch_blocks: 5, ..ReadLimits::default() });
    let (mut batches, mut batch) = (Vec::new(), Batch::new());
    let mut take = |reader: &mut Reader| {
        while reader.next_batch(&mut batch).expect("readable lines") {
            batches.push(batch.clone());
        }
    };
    for piece in text.chunks(chunk) {
        reader.feed(piece);
        take(&mut reader);
    }
    reader.finish();
    take(&mut reader);
    batches
}

fn law(tokens: &[&str], dialect: Dialect, chunk: usize) -> Result<(), TestCaseError> {
    let text = tokens.concat();
    let read = batches(text.as_bytes(), dialect, usize::MAX >> 1);
    let printed: Vec<u8> = read.iter().flat_map(|batch| batch.text().to_vec()).collect();
    prop_assert_eq!(printed, text.as_bytes());
    let mut interpreter = Interpreter::new(&ac_machine(), InterpreterOptions::in_mm());
    let (mut motions, mut diagnostics) = (Vec::new(), Diagnostics::new());
    let mut line = 1;
    for batch in &read {
        for block in batch.blocks() {
            prop_assert_eq!(block.line, line);
            let body = batch.block_text(block);
            line += body.split(|byte| *byte == b'\n').count() as u64 - 1;
            for word in batch.words(block) {
                prop_assert!(
                    block.start <= word.start && word.start <= word.end && word.end <= block.body_end
                );
            }
        }
        interpreter.interpret(&mut batch.clone(), &mut motions, &mut diagnostics);
    }
    prop_assert!(batches(text.as_bytes(), dialect, chunk) == read);
    Ok(())
}

/// Pieces of OSP programs.
const OKUMA: [&str; 34] = [
    "\n",
    "\r\n",
    " ",
    "$PART.MIN%",
    "%",
    "OPART",
    "O0001",
    "NLAP1",
    "N0010",
    "G15",
    "G16",
    "H1",
    "H02",
    "G56",
    "G54",
    "G53",
    "G0",
    "G1",
    "G169",
    "X1.5",
    "Y-.25",
    "Z 3",
    "A10.",
    "C=VC1",
    "VC1=5",
    "CALL O1000",
    "IF[VC1 EQ 2] N10",
    "NOEX",
    "(note)",
    "(open",
    "/1",
    "X[2]",
    ";",
    "M06",
];

proptest! {
    #[test]
    fn any_text_for_osp_comes_back(
        tokens in prop::collection::vec(prop::sample::select(&OKUMA[..]), 0..120),
        chunk in 1_usize..40,
    ) {
        law(&tokens, Dialect::Okuma, chunk)?;
    }

    #[test]
    fn any_conversational_text_comes_back(
        tokens in prop::collection::vec(prop::sample::select(&HEIDENHAIN[..]), 0..120),
        chunk in 1_usize..40,
    ) {
        law(&tokens, Dialect::Heidenhain, chunk)?;
    }

    #[test]
    fn any_cutter_location_text_comes_back(
        tokens in prop::collection::vec(prop::sample::select(&APT[..]), 0..120),
        chunk in 1_usize..40,
    ) {
        law(&tokens, Dialect::Apt, chunk)?;
    }
}
