//! Lines of conversational, Sinumerik and cutter location programs whose bytes alone tell the survey all it needs:
//! block numbers and decimals of points. Their words are not read.

use super::survey::{CONTROL_DECIMALS, Survey};
use crate::program::{Dialect, Grammar};

/// Longer lines are read \[bytes\]. A line of this length cannot hold more words than a reader accepts.
const MAX_LINE_BYTES: usize = 256;
/// Block numbers with more digits are read.
const MAX_NUMBER_DIGITS: usize = 8;
/// Values with more digits before or after the point are read.
const MAX_WHOLE_DIGITS: usize = 6;
const MAX_FRACTION_DIGITS: usize = 9;

/// How the lines of a program are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::process) struct PlainLines {
    grammar: Grammar,
    rotary: [char; 2],
}

impl PlainLines {
    /// For a program of this dialect; `None` if its lines are not looked at in this way.
    pub(in crate::process) fn of(dialect: Dialect, rotary: [char; 2]) -> Option<Self> {
        let grammar = dialect.rules().grammar;
        (!matches!(grammar, Grammar::Letters | Grammar::Cells)).then_some(Self { grammar, rotary })
    }

    /// The survey after these whole lines, and their number. `None` if one of them has to be read. The lines begin
    /// with a statement.
    pub(in crate::process) fn behind(self, lines: &[u8], survey: &Survey) -> Option<(Survey, u64)> {
        let mut survey = *survey;
        survey.tools.pass_over();
        let mut line = Line { text: lines, at: 0 };
        let mut count = 0;
        while line.at < lines.len() {
            let start = line.at;
            match self.grammar {
                Grammar::Conversational => self.conversational(&mut line, &mut survey)?,
                Grammar::Assignments => self.siemens(&mut line, &mut survey)?,
                Grammar::Points => point(&mut line, &mut survey)?,
                Grammar::Letters | Grammar::Cells => return None,
            }
            line.end()?;
            if line.at - start > MAX_LINE_BYTES {
                return None;
            }
            count += 1;
        }
        Some((survey, count))
    }

    #[inline]
    fn conversational(self, line: &mut Line<'_>, survey: &mut Survey) -> Option<()> {
        if line.byte().is_ascii_digit() {
            survey.numbering.see_number(line.block_number()?);
            if line.skip_blanks() == 0 {
                return None;
            }
        }
        line.take(b'L')?;
        self.words(line, survey)
    }

    #[inline]
    fn siemens(self, line: &mut Line<'_>, survey: &mut Survey) -> Option<()> {
        if line.byte() == b'N' {
            line.at += 1;
            survey.numbering.see_number(line.block_number()?);
        } else {
            self.word(line, survey)?;
        }
        self.words(line, survey)
    }

    /// Words with a blank before each.
    #[inline]
    fn words(self, line: &mut Line<'_>, survey: &mut Survey) -> Option<()> {
        while line.skip_blanks() > 0 && !matches!(line.byte(), b'\r' | b'\n') {
            self.word(line, survey)?;
        }
        Some(())
    }

    #[inline]
    fn word(self, line: &mut Line<'_>, survey: &mut Survey) -> Option<()> {
        let letter = line.byte();
        line.at += 1;
        if self.grammar == Grammar::Assignments && line.byte() == b'=' {
            line.at += 1;
        }
        let decimals = line.number()?;
        match letter {
            b'X' | b'Y' | b'Z' => survey.linear_decimals = survey.linear_decimals.max(decimals),
            b'A' | b'B' | b'C' if self.rotary.contains(&char::from(letter)) => {
                survey.rotary_decimals = survey.rotary_decimals.max(decimals);
            }
            b'A' | b'B' | b'C' | b'F' => {}
            _ => return None,
        }
        Some(())
    }
}

/// A point, with or without a tool axis.
#[inline]
fn point(line: &mut Line<'_>, survey: &mut Survey) -> Option<()> {
    b"GOTO/".iter().try_for_each(|byte| line.take(*byte))?;
    let mut count = 0;
    loop {
        line.skip_blanks();
        let decimals = line.number()?;
        if count < 3 {
            survey.linear_decimals = survey.linear_decimals.max(decimals);
        }
        count += 1;
        line.skip_blanks();
        if line.byte() != b',' {
            break;
        }
        line.at += 1;
    }
    matches!(count, 3 | 6).then_some(())
}

/// A place in the lines.
struct Line<'a> {
    text: &'a [u8],
    at: usize,
}

impl Line<'_> {
    /// The current byte; a line end after the last one.
    #[inline]
    fn byte(&self) -> u8 {
        self.text.get(self.at).copied().unwrap_or(b'\n')
    }

    #[inline]
    fn take(&mut self, byte: u8) -> Option<()> {
        let is_there = self.byte() == byte;
        self.at += 1;
        is_there.then_some(())
    }

    /// Number of blanks skipped.
    #[inline]
    fn skip_blanks(&mut self) -> usize {
        let start = self.at;
        while self.byte() == b' ' {
            self.at += 1;
        }
        self.at - start
    }

    /// Moves to after LF or CR LF.
    #[inline]
    fn end(&mut self) -> Option<()> {
        self.at += usize::from(self.byte() == b'\r');
        self.take(b'\n')
    }

    #[inline]
    fn digits(&mut self) -> usize {
        let start = self.at;
        while self.byte().is_ascii_digit() {
            self.at += 1;
        }
        self.at - start
    }

    #[inline]
    fn block_number(&mut self) -> Option<u64> {
        let start = self.at;
        let count = self.digits();
        let digits = self.text.get(start..self.at)?;
        let value = digits.iter().fold(0, |value, digit| 10 * value + u64::from(digit - b'0'));
        (1..=MAX_NUMBER_DIGITS).contains(&count).then_some(value)
    }

    /// The decimals of a number with its sign, as far as a survey counts them.
    #[inline]
    fn number(&mut self) -> Option<u8> {
        self.at += usize::from(matches!(self.byte(), b'+' | b'-'));
        let whole = self.digits();
        let mut decimals = 0;
        if self.byte() == b'.' {
            self.at += 1;
            decimals = self.digits();
        }
        if whole == 0 || whole > MAX_WHOLE_DIGITS || decimals > MAX_FRACTION_DIGITS {
            return None;
        }
        Some(u8::try_from(decimals).unwrap_or(CONTROL_DECIMALS).min(CONTROL_DECIMALS))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::program::{Batch, ReadLimits, Reader};

    const ROTARY: [char; 2] = ['A', 'C'];

    fn survey() -> Survey {
        let mut survey = Survey::nothing();
        survey.tools.pass_over();
        survey
    }

    /// The survey after these lines were read as words.
    fn read(lines: &str, dialect: Dialect, mut survey: Survey) -> Survey {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        let mut batch = Batch::new();
        reader.feed(lines.as_bytes());
        reader.finish();
        while reader.next_batch(&mut batch).unwrap() {
            survey.see(&batch, ROTARY);
        }
        survey
    }

    fn look(lines: &str, dialect: Dialect, survey: &Survey) -> Option<(Survey, u64)> {
        PlainLines::of(dialect, ROTARY).unwrap().behind(lines.as_bytes(), survey)
    }

    #[test]
    fn usual_lines_need_no_reading() {
        let texts = [
            (Dialect::Heidenhain, "7 L X+1.25 Y-2. A+30.5 F500\r\n8 L  C+1.125\nL Z5 B1.2345 \n"),
            (Dialect::Siemens, "N10 X1.25 A=-30.5\nX3 C=1.12345 F20 \r\nN20 Z.5\n"),
            (Dialect::Apt, "GOTO/1.5,2.25,-3,0.1234567,0.,1.\nGOTO/ 1. , 2. ,3.125\r\n"),
        ];
        for (dialect, text) in texts {
            for line in text.split_inclusive('\n').filter(|line| !line.contains("Z.5")) {
                let (seen, count) = look(line, dialect, &survey()).expect(line);
                assert_eq!((seen, count), (read(line, dialect, survey()), 1), "{line}");
            }
        }
        assert_eq!(look("N20 Z.5\n", Dialect::Siemens, &survey()), None);
        assert_eq!(PlainLines::of(Dialect::Iso, ROTARY), None);
    }

    /// Parts of plain lines, and things that make a line not plain.
    fn lines(dialect: Dialect) -> impl Strategy<Value = String> {
        let words = match dialect {
            Dialect::Heidenhain => {
                "L|L | X+1.25| Y-2,5| A+30.123|X1| x1.5| C.5|\tZ+1.2345| IX+1.5| R0| FMAX| F100.5| M3| ~|\
                 ~\n| ;1.234| Q1=+1.5| X+Q1| X1.2E3| NX+1| Z+1.2345678901| X1234567.5|CC| |\r| X| X1. Y|\
                 /| TX+1| B1.123456"
            }
            Dialect::Siemens => {
                "X1.25| Y-2.5| A=30.123| A=-1.5| C=DC(1.5)|\tZ1.2345| X1=5| G1|G91| U1.5| ;1.234| X=R1| X1EX2| M3|\
                 :10| |\r| F100.5| X =5| X1 =5| N7| V1 W2| X1234567.5| B1.123456| x1.5| AC1.5| H1| A3=0.1| L1|\
                 N|/"
            }
            _ => {
                "GOTO/|1.25|,|-2.5|+.5|$\n|$$ 1.2345| |\t|\r|goto/|1.5E-3|FROM/|FEDRAT/100.,MMPM|\
                 1.23456,2.,3.,0.,0.,1.|1.,2.,3.|,0.,0.,1.|1.5,|/|GOTO /1,2.25,3|1234567.5|RAPID|\
                 PPRINT GOTO/1.5,2.5,3.5|$|GODLTA/1.5|CUTTER/10.123"
            }
        };
        let words: Vec<&str> = words.split('|').collect();
        let words = prop::collection::vec(prop::sample::select(words), 0..6);
        (any::<bool>(), 0_u32..40, words).prop_map(move |(numbered, number, words)| {
            let number = match dialect {
                Dialect::Heidenhain if numbered => format!("{number} L"),
                Dialect::Siemens if numbered => format!("N{number}"),
                Dialect::Apt if numbered => "GOTO/".to_owned(),
                _ => String::new(),
            };
            format!("{number}{}\n", words.concat())
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The bytes tell the same as reading the words, for any lines.
        #[test]
        fn what_bytes_tell_is_what_words_tell(
            (dialect, lines) in prop::sample::select(vec![Dialect::Heidenhain, Dialect::Siemens, Dialect::Apt])
                .prop_flat_map(|dialect| (Just(dialect), prop::collection::vec(lines(dialect), 1..3))),
        ) {
            let text = lines.concat();
            if let Some((seen, count)) = look(&text, dialect, &survey()) {
                prop_assert_eq!(seen, read(&text, dialect, survey()));
                prop_assert_eq!(count, text.matches('\n').count() as u64);
            }
        }
    }
}
