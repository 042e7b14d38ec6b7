//! Dialects that the service recognises but does not read. Their marks occur in no text of a dialect that is read.
//!
//! If a mark is not certain, no foreign dialect is reported. The text is then read as the dialect that it looks like.

use super::detect::{ends_word, starts, without_number};
use super::okuma;
use std::fmt;

/// A dialect that is recognised so that it can be named, but that is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForeignDialect {
    /// `%PM9001`: in this dialect G93 shifts the zero point, and centres of arcs are places.
    MillPlus,
    /// `%4711 G71 *`: blocks in the letters of ISO that end with `*`.
    HeidenhainDin,
    /// `VC1=…`, `NOEX`: statements of the dialect that are not read.
    Okuma,
    /// The printed list of units of a conversational program.
    Mazatrol,
    /// `%NAME,MX--,`: in this dialect statements are in round brackets, where ISO has comments.
    Fagor,
    /// `#RTCP ON`, `#VAR`.
    HashStatements,
    /// `%100` with jumps (`G79 N…`), calls (`G77 H…`) or variables (`L1=…`, `E80000=…`).
    Num,
    /// `%MPF 90` with `@371`.
    OldSinumerik,
    /// `(UAO,1)`: statements of three letters in round brackets.
    Osai,
}

impl fmt::Display for ForeignDialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::MillPlus => "Heidenhain MillPlus (Philips, Maho)",
            Self::HeidenhainDin => "Heidenhain DIN/ISO",
            Self::Okuma => "Okuma OSP with its own variables and statements",
            Self::Mazatrol => "Mazatrol",
            Self::Fagor => "Fagor 8055",
            Self::HashStatements => "Fagor 8070 or ISG",
            Self::Num => "NUM",
            Self::OldSinumerik => "Sinumerik 810 to 880",
            Self::Osai => "OSAI",
        })
    }
}

/// The marks of the text's lines so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Marks {
    has_lines: bool,
    /// The first line that is not empty was `%` and a whole number.
    has_number_head: bool,
    /// The text has had `%MPF 90` or `%SPF 90`.
    has_old_head: bool,
}

/// Statements of Fagor 8070 and ISG controls after their `#`.
const HASH_STATEMENTS: [&[u8]; 10] = [
    b"RTCP ON",
    b"RTCP OFF",
    b"MCS ON",
    b"CS ON",
    b"CS DEF",
    b"ACS ON",
    b"HSC ON",
    b"KIN ID",
    b"TOOL ORI",
    b"VAR",
];
/// Statements of OSAI controls, with their comma.
const OSAI: [&[u8]; 4] = [b"(UAO,", b"(UTO,", b"(UIO,", b"(UCG,"];

impl Marks {
    /// The dialect that this line, the next one of the text, shows.
    pub(super) fn see(&mut self, line: &[u8]) -> Option<ForeignDialect> {
        let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line).trim_ascii();
        if line.is_empty() {
            return None;
        }
        let is_first = !std::mem::replace(&mut self.has_lines, true);
        if let Some(head) = line.strip_prefix(b"%") {
            return self.head(head, is_first);
        }
        if OSAI.iter().any(|mark| starts(line, mark)) {
            return Some(ForeignDialect::Osai);
        }
        if starts(line, b"UNo.") && [&b"MAT"[..], b"UNIT"].iter().any(|word| has_word(line, word)) {
            return Some(ForeignDialect::Mazatrol);
        }
        let statement = without_number(line);
        if let Some(hash) = statement.strip_prefix(b"#")
            && HASH_STATEMENTS.iter().any(|mark| starts(hash, mark) && ends_word(hash, mark.len()))
        {
            return Some(ForeignDialect::HashStatements);
        }
        if let Some(okuma) = okuma::unread_statement(line) {
            return Some(okuma);
        }
        if self.has_number_head && is_num(statement) {
            return Some(ForeignDialect::Num);
        }
        let is_cycle =
            matches!(statement, [b'@', a, b, c, ..] if [a, b, c].into_iter().all(u8::is_ascii_digit));
        (self.has_old_head && is_cycle).then_some(ForeignDialect::OldSinumerik)
    }

    /// The part after the `%` of a line that begins with `%`.
    fn head(&mut self, head: &[u8], is_first: bool) -> Option<ForeignDialect> {
        let is_number = |text: &[u8]| !text.is_empty() && text.iter().all(u8::is_ascii_digit);
        let word = head.split(|byte| matches!(byte, b' ' | b'\t' | b'(')).next().unwrap_or_default();
        if is_first
            && let Some(number) = word.strip_prefix(b"PM").or_else(|| word.strip_prefix(b"MM"))
            && (number.is_empty() || is_number(number))
        {
            return Some(ForeignDialect::MillPlus);
        }
        if let Some(block) = head.strip_suffix(b"*")
            && [&b"G71"[..], b"G70"].iter().any(|unit| has_word(block, unit))
        {
            return Some(ForeignDialect::HeidenhainDin);
        }
        if is_first && has_fagor_attributes(head) {
            return Some(ForeignDialect::Fagor);
        }
        self.has_number_head |= is_first && is_number(word);
        let old = [&b"MPF"[..], b"SPF"].iter().find_map(|mark| head.strip_prefix(*mark));
        self.has_old_head |= old.is_some_and(|number| is_number(number.trim_ascii()));
        None
    }
}

/// Whether the line has this word between blanks.
fn has_word(line: &[u8], wanted: &[u8]) -> bool {
    line.split(u8::is_ascii_whitespace).any(|word| word.eq_ignore_ascii_case(wanted))
}

/// `G79 N100`, `G79 L1>5 N100`, `G77 H9001`, `L1=5`, `E80000=1`, in a program with a number at its head.
fn is_num(statement: &[u8]) -> bool {
    let code = |name: &[u8]| starts(statement, name) && ends_word(statement, name.len());
    let has = |letters: &[u8]| {
        statement.windows(2).any(|pair| letters.contains(&pair[0]) && pair[1].is_ascii_digit())
    };
    if code(b"G79") {
        return has(b"N");
    }
    if code(b"G77") {
        return has(b"HN");
    }
    let Some((b'L' | b'E', rest)) = statement.split_first() else { return false };
    let count = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    count > 0 && rest.get(count..).unwrap_or_default().trim_ascii_start().starts_with(b"=")
}

/// `NAME,MX--,`: a name and the attributes of a Fagor program.
fn has_fagor_attributes(head: &[u8]) -> bool {
    let mut parts = head.split(|byte| *byte == b',');
    let (Some(name), Some(attributes)) = (parts.next(), parts.next()) else { return false };
    !name.is_empty()
        && attributes.len() == 4
        && attributes.iter().all(|byte| matches!(byte, b'M' | b'X' | b'O' | b'H' | b'-'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> Option<(u64, ForeignDialect)> {
        let mut marks = Marks::default();
        (1..).zip(text.split('\n')).find_map(|(line, text)| Some((line, marks.see(text.as_bytes())?)))
    }

    #[test]
    fn dialects_are_told_by_marks_of_their_own() {
        use ForeignDialect as F;
        for (text, expected) in [
            ("%PM9001\nN9001 (TEST)\nN1 G17\n", (1, F::MillPlus)),
            ("\n%PM\nN9000 (PHILIPS)\n", (2, F::MillPlus)),
            ("%MM9002\r\nN9002\r\n", (1, F::MillPlus)),
            ("%BLOCK G70*\n", (1, F::HeidenhainDin)),
            ("%4711 G71 *\nN10 G30 G17 X+0 Y+0 Z-40*\n", (1, F::HeidenhainDin)),
            ("$FLANGE.MIN%\nVC1=2\n", (2, F::Okuma)),
            ("O1\nG15 H1\nN2 VC1 = 5\n", (3, F::Okuma)),
            ("OTEST\nNOEX VC10=VC10+1\n", (2, F::Okuma)),
            ("O1\nVZOFZ[1]=VC1\n", (2, F::Okuma)),
            ("UNo. MAT. INITIAL-Z ATC MODE MULTI MODE UNIT\n0 FC 50.\n", (1, F::Mazatrol)),
            ("%PIECE,MX--,\nN10 G0 X0\n", (1, F::Fagor)),
            ("%TEST\nN10 T1 M6\nN20 #RTCP ON\n", (3, F::HashStatements)),
            ("%100 (TEST)\nN10 G0 X0\nN20 G79 N10\n", (3, F::Num)),
            ("%100\nN10 G77 H9001\n", (2, F::Num)),
            ("%100\nL1=5\n", (2, F::Num)),
            ("%100\nN5 E80000=100\n", (2, F::Num)),
            ("%MPF  90\nN1 @371 R52 K2 K0\n", (2, F::OldSinumerik)),
            ("(UAO,1)\nG0 X0\n", (1, F::Osai)),
        ] {
            assert_eq!(shown(text), Some(expected), "{text}");
        }
    }

    #[test]
    fn texts_of_dialects_that_are_read_show_none() {
        for text in [
            "%\nO1001(PM)\nN10 G0 X0\nM30\n%\n",
            "%100\nG0 X0 Y0\nM30\n",
            "%PMILL\nG0 X0\n",
            "%_N_PM_MPF\nVC=5\nL10\n",
            "%MPF100\nN10 G0 X0\n",
            "(VC1=5)\n; NOEX\nG0 X0\n",
            "#100=5\n#<name>=3\n#_VAR[1]=2\n#VARIABLE=1\n",
            "G77 X10 H5\nG79 X5 N10\nO1\nE5\nL1\n",
            "O0001\nN0090 G90 X1.9685 S556 M03\nN0100 G56 Z4.3307 H01\nCALL O100\n",
            "(UNIT 5, UAO)\n(DIS,)\nG0\n",
            "GOTO/1,2,3\nCUTTER/10\n",
            "0 BEGIN PGM VC1 MM\n1 L X+0\n",
        ] {
            assert_eq!(shown(text), None, "{text}");
        }
    }
}
