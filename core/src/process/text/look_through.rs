//! A first look through a program, at its text only: through all of it, or through its head.

use std::ops::ControlFlow;

use super::source::{CHUNK_BYTES, ProgramSource, read_some};
use super::survey::Survey;
use super::surveyor::Surveyor;
use crate::machine::Machine;
use crate::process::fault::Fault;
use crate::process::set_up::SurveyExtent;
use crate::program::{Batch, Dialect, ReadLimits, Reader};

/// The part of a program that its head survey reads \[bytes\]: some thousand blocks.
const SURVEY_HEAD_BYTES: usize = 4 * CHUNK_BYTES;

impl Survey {
    /// Surveys the program to this extent. Returns whether the survey covers all of it, which is always so for a
    /// short program.
    pub(in crate::process) fn of(
        machine: &Machine,
        dialect: Option<Dialect>,
        source: &dyn ProgramSource,
        extent: SurveyExtent,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<(Self, bool), Fault> {
        let mut surveyor = Surveyor::new(machine);
        let mut reader = Reader::new(dialect, ReadLimits::default());
        let mut input = source.open()?;
        let mut batch = Batch::new();
        let mut chunk = vec![0; CHUNK_BYTES];
        let mut read_bytes = 0;
        loop {
            if stop().is_break() {
                return Err(Fault::Cancelled);
            }
            let count = read_some(&mut *input, &mut chunk)?;
            let text = &chunk[..count];
            surveyor.see_text(text);
            if count == 0 {
                reader.finish();
            } else {
                reader.feed(text);
            }
            while reader.next_batch(&mut batch)? {
                surveyor.see(&batch);
            }
            read_bytes += count;
            if count == 0 {
                return Ok((surveyor.finish(), true));
            }
            if extent == SurveyExtent::Head && read_bytes >= SURVEY_HEAD_BYTES {
                return Ok((surveyor.so_far(), false));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use proptest::prelude::*;

    use super::*;
    use crate::machine::Preset;
    use crate::program::{Address, Grammar};

    /// The survey of the whole text with every word read.
    fn read(text: &[u8], dialect: Dialect, rotary: [Address; 2]) -> Survey {
        let mut survey = Survey::nothing();
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        let mut batch = Batch::new();
        reader.feed(text);
        reader.finish();
        while reader.next_batch(&mut batch).unwrap() {
            survey.see(&batch, rotary);
        }
        survey
    }

    fn lines(dialect: Dialect) -> impl Strategy<Value = String> {
        let (plain, odd): (&str, &str) = match dialect.rules().grammar {
            Grammar::Conversational => (
                "L X+1.25 Y-2.5 A+30.5|L  C+1.125 F500|L Z5 B1.2345|L X+2.5 R0",
                "RND R2.5|L X+1.5 ~|CYCL DEF 7.0 NULL|; L X1.23456|* - note|L X+Q1 Y+1.123456|CC X+1.5|LBL 1",
            ),
            Grammar::Assignments => (
                "X1.25 A=-30.5|X3 C=1.125 F20|Y-2.5 Z.5",
                "; X1.23456|MSG(\"X1.2345\")|X=R1|X1.5 U1. V2. W3.|R1=5.12345|G4 F1.5|A3=0.1 B3=0 C3=1",
            ),
            Grammar::Points => (
                "GOTO/1.5,2.25,-3,0.1234567,0.,1.|GOTO/ 1. , 2. ,3.125|GOTO/1,2,3",
                "GOTO/1.5,2.5, $|4.125,0,0,1|$$ GOTO/1.23456,2,3|PPRINT/1.23456|FEDRAT/100.,MMPM|RAPID|CIRCLE/0,0,0,0,0,1,5.1234",
            ),
            Grammar::Letters => (
                "X1.25 Y-2.5 A30.5|G1 Z.5 F500|C1.125",
                "N10 X1.5|(X1.23456)|X1.12345|A1.12345|O100|U1. V2. W3.",
            ),
            Grammar::Cells => {
                ("1.5,2.5,3.5,4.5,5.5|1.25,2,3,4,5", "1.12345,2,3,4,5|1,2,3,4.12345,5| 1 ,2,3,4,5")
            }
        };
        let of = |text: &str| {
            let lines: Vec<String> = text.split('|').map(str::to_owned).collect();
            proptest::sample::select(lines)
        };
        let line = prop_oneof![400 => of(plain), 1 => of(odd)];
        let numbered = dialect == Dialect::Heidenhain;
        prop::collection::vec((line, any::<bool>()), 600..2000).prop_map(move |lines| {
            let mut text = if dialect == Dialect::Csv { "X,Y,Z,A,C\n".to_owned() } else { String::new() };
            for (number, (line, crlf)) in lines.into_iter().enumerate() {
                if numbered && number % 7 < 5 {
                    write!(text, "{number} ").unwrap();
                }
                text.push_str(&line);
                text.push_str(if crlf { "\r\n" } else { "\n" });
            }
            text
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn a_survey_tells_what_reading_every_word_does(
            (dialect, text) in proptest::sample::select(Dialect::ALL.to_vec()).prop_flat_map(|dialect| (Just(dialect), lines(dialect))),
        ) {
            let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
            let source = text.clone().into_bytes();
            let whole = SurveyExtent::Whole;
            let (found, _) =
                Survey::of(&machine, Some(dialect), &source, whole, &|| ControlFlow::Continue(())).unwrap();
            prop_assert_eq!(found, read(text.as_bytes(), dialect, [Address::A, Address::C]));
        }
    }
}
