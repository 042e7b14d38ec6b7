//! The course of ISO programs: O words of RS274/NGC, WHILE, IF and GOTO of macros, M98 and M99.

use crate::program::comment::comment_end;
use crate::program::course::{
    Callee, EndInCall, Piece, PlaceName, Search, Statement, Step, Structure, When, block_number,
};
use crate::program::number::read_unsigned;
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, Word, WordForm};

/// The largest number of a program whose M98 word cannot also state a number of times.
const LAST_PLAIN_PROGRAM: f64 = 9999.0;
/// The most times that a call repeats a subprogram.
const MAX_TIMES: f64 = 99_999.0;

/// What a block does to the course of its program.
pub(super) fn read(batch: &Batch, block: &Block) -> Statement {
    let statement = match block.kind {
        BlockKind::Words => of_words(batch.words(block)),
        BlockKind::Call | BlockKind::Flow => {
            let text = batch.text().get(block.start as usize..block.body_end as usize).unwrap_or_default();
            of_text(text).unwrap_or(Statement::NOT_FOLLOWED)
        }
        _ => Statement::PLAIN,
    };
    let is_plain = matches!(statement.step, Step::Plain | Step::End(_) | Step::Entry | Step::NotInSub);
    if block.flags.has(BlockFlags::DELETE) && !is_plain { Statement::NOT_FOLLOWED } else { statement }
}

/// M2, M30, M98, M99 and the name of a program.
fn of_words(words: &[Word]) -> Statement {
    let (mut present, mut code) = (0, None);
    for word in words {
        present |= word.address.bit();
        if word.address == Address::M
            && let Some(tenths @ (20 | 300 | 730 | 980 | 990)) = word.code_tenths()
        {
            code = Some(tenths);
        }
    }
    let number = |address: Address| {
        let mut found = words.iter().filter(|word| word.address == address);
        found.next().filter(|word| word.form == WordForm::Number).map(|word| word.value)
    };
    let only = |addresses: u32| present & !(addresses | Address::N.bit() | Address::M.bit()) == 0;
    let m_codes = words.iter().filter(|word| word.address == Address::M).count();
    match code {
        // M73: RS274 controls restore the modes when the subprogram ends.
        Some(730) => Statement::of(Step::NotInSub),
        Some(20 | 300) => Statement::of(Step::End(EndInCall::EndsAll)),
        Some(980) if m_codes == 1 && only(Address::P.bit() | Address::L.bit()) => {
            let times = if present & Address::L.bit() == 0 { Some(1.0) } else { number(Address::L) };
            let whole = times.filter(|times| times.fract() == 0.0 && (1.0..=MAX_TIMES).contains(times));
            let program = number(Address::P).filter(|program| *program <= LAST_PLAIN_PROGRAM);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a small whole number"
            )]
            match (program, whole) {
                (Some(program), Some(times)) => {
                    Statement::named(entry(program), Step::Call(Callee::Program, times as u32))
                }
                // The interpreter says what is not known after it.
                _ => Statement::PLAIN,
            }
        }
        Some(990) if m_codes == 1 && only(0) => Statement::of(Step::Return),
        // It returns somewhere else, or a number of times.
        Some(990) => Statement::NOT_FOLLOWED,
        _ if present & Address::O.bit() != 0 => match number(Address::O) {
            Some(program) => Statement::at(entry(program), Step::Entry),
            // A name.
            None => Statement::of(Step::Entry),
        },
        _ => Statement::PLAIN,
    }
}

fn entry(program: f64) -> PlaceName {
    format!("O{program}").into_bytes().into()
}

/// The statement of a block with its text.
fn of_text(text: &[u8]) -> Option<Statement> {
    let mut scan = Scan { text, at: 0 };
    if scan.takes(b'N') {
        scan.number()?;
    }
    match scan.byte()?.to_ascii_uppercase() {
        b'O' => of_o_word(&mut scan),
        _ => of_macro(&mut scan),
    }
}

/// `o100 while [#1 LT 5]`
fn of_o_word(scan: &mut Scan<'_>) -> Option<Statement> {
    scan.at += 1;
    let name = scan.o_name()?;
    let word = scan.spread_word();
    let step = match word.as_slice() {
        b"SUB" => scan.alone(Step::Open(Structure::Sub, None))?,
        // A value after it is returned.
        b"ENDSUB" => Step::Close(Some(Structure::Sub), None),
        b"RETURN" => Step::Return,
        b"CALL" => Step::CallOwn(scan.arguments()?),
        b"DO" => scan.alone(Step::Open(Structure::Do, None))?,
        b"WHILE" => Step::Open(Structure::While, Some(scan.condition()?)),
        b"ENDWHILE" => scan.alone(Step::Close(Some(Structure::While), None))?,
        b"IF" => Step::Open(Structure::If, Some(scan.condition()?)),
        b"ELSEIF" => Step::Else(Some(scan.condition()?)),
        b"ELSE" => scan.alone(Step::Else(None))?,
        b"ENDIF" => scan.alone(Step::Close(Some(Structure::If), None))?,
        b"REPEAT" => Step::Open(Structure::Repeat, Some(scan.condition()?)),
        b"ENDREPEAT" => scan.alone(Step::Close(Some(Structure::Repeat), None))?,
        b"BREAK" => scan.alone(Step::Break)?,
        b"CONTINUE" => scan.alone(Step::Continue)?,
        _ => return None,
    };
    Some(Statement::named(name, step))
}

/// `WHILE [#1 LT 5] DO1`, `END1`, `IF [#1 EQ 0] GOTO 100`, `GOTO 100`
fn of_macro(scan: &mut Scan<'_>) -> Option<Statement> {
    let word = scan.word();
    match word.as_slice() {
        b"WHILE" => {
            let condition = scan.condition()?;
            let name = scan.loop_name(b"DO")?;
            scan.alone(Statement::named(name, Step::Open(Structure::While, Some(condition))))
        }
        b"DO" => {
            let name = scan.digits()?;
            scan.alone(Statement::named(name, Step::Open(Structure::Loop, None)))
        }
        b"END" => {
            let name = scan.digits()?;
            scan.alone(Statement::named(name, Step::Close(None, None)))
        }
        b"GOTO" => jump(scan, When::Always),
        b"IF" => {
            let condition = scan.condition()?;
            if scan.word() != b"GOTO" {
                return None;
            }
            jump(scan, When::Holds(condition))
        }
        _ => None,
    }
}

fn jump(scan: &mut Scan<'_>, when: When) -> Option<Statement> {
    let number = scan.number()?;
    let step = Step::Jump { search: Search::Around, when, may_lack: false };
    scan.alone(Statement::named(block_number(number), step))
}

/// A place in the text of a statement.
struct Scan<'a> {
    text: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    /// The next byte that is not a blank.
    fn byte(&mut self) -> Option<u8> {
        while matches!(self.text.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn takes(&mut self, letter: u8) -> bool {
        let found = self.byte().is_some_and(|byte| byte.eq_ignore_ascii_case(&letter));
        self.at += usize::from(found);
        found
    }

    fn number(&mut self) -> Option<f64> {
        self.byte()?;
        let number = read_unsigned(self.text, self.at)?;
        self.at = number.end;
        Some(number.value)
    }

    /// Letters, in upper case.
    fn word(&mut self) -> Vec<u8> {
        self.byte();
        let rest = self.text.get(self.at..).unwrap_or_default();
        let word: Vec<u8> =
            rest.iter().take_while(|byte| byte.is_ascii_alphabetic()).map(u8::to_ascii_uppercase).collect();
        self.at += word.len();
        word
    }

    /// The same, with blanks in it: RS274 controls read over blanks.
    fn spread_word(&mut self) -> Vec<u8> {
        let mut word = Vec::new();
        loop {
            let more = self.word();
            if more.is_empty() {
                return word;
            }
            word.extend(more);
        }
    }

    /// `DO1`: the number of a loop after its word.
    fn loop_name(&mut self, word: &[u8]) -> Option<PlaceName> {
        if self.word() != word {
            return None;
        }
        self.digits()
    }

    fn digits(&mut self) -> Option<PlaceName> {
        let number = self.number()?;
        Some(format!("{number}").into_bytes().into())
    }

    /// The name of an O word: its number, or its text in lower case without blanks.
    fn o_name(&mut self) -> Option<PlaceName> {
        match self.byte()? {
            b'<' => {
                let rest = self.text.get(self.at + 1..)?;
                let length = memchr::memchr(b'>', rest)?;
                self.at += length + 2;
                let name = rest.get(..length)?.iter().filter(|byte| !matches!(byte, b' ' | b'\t'));
                Some(name.map(u8::to_ascii_uppercase).collect())
            }
            b'0'..=b'9' => self.digits(),
            _ => None,
        }
    }

    /// The piece of a value in brackets.
    fn brackets(&mut self) -> Option<Piece> {
        if self.byte()? != b'[' {
            return None;
        }
        let start = self.at;
        let mut depth = 0_u32;
        loop {
            match self.text.get(self.at)? {
                b'[' => depth += 1,
                b']' => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return Some(Piece { start, end: self.at });
            }
        }
    }

    /// A condition in brackets. Of RS274 statements, nothing may come after it but a comment.
    fn condition(&mut self) -> Option<Piece> {
        let piece = self.brackets()?;
        let next = self.byte();
        let goes_on = next.is_some_and(|byte| byte.is_ascii_alphabetic());
        (goes_on || self.is_done()).then_some(piece)
    }

    fn arguments(&mut self) -> Option<Vec<Piece>> {
        let mut arguments = Vec::new();
        while self.byte() == Some(b'[') {
            arguments.push(self.brackets()?);
        }
        self.alone(arguments)
    }

    /// This, if only a comment follows.
    fn alone<T>(&mut self, read: T) -> Option<T> {
        self.is_done().then_some(read)
    }

    fn is_done(&mut self) -> bool {
        loop {
            match self.byte() {
                None | Some(b';') => return true,
                Some(b'(') => match comment_end(self.text, self.at) {
                    Ok(end) => self.at = end,
                    Err(_) => return false,
                },
                Some(_) => return false,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_read_and_others_are_not_followed() {
        let step = |text: &str| of_text(text.as_bytes()).map(|statement| statement.step);
        let piece = |start, end| Some(Piece { start, end });
        assert_eq!(step("o100 sub (#1=radius)"), Some(Step::Open(Structure::Sub, None)));
        assert_eq!(step("N5 O<a b> endsub [4711]"), Some(Step::Close(Some(Structure::Sub), None)));
        assert_eq!(step("o1 if [#1 NE 0]"), Some(Step::Open(Structure::If, piece(6, 15))));
        assert_eq!(step("o100 end sub"), Some(Step::Close(Some(Structure::Sub), None)));
        assert_eq!(step("o1 WH ILE [#1 LT 5]"), Some(Step::Open(Structure::While, piece(10, 19))));
        let call = step("O0 call [-.5] [#[1+1]] ; note");
        assert_eq!(call, Some(Step::CallOwn([piece(8, 13), piece(14, 22)].into_iter().flatten().collect())));
        assert_eq!(step("WHILE [#1 LE 3] DO 2"), Some(Step::Open(Structure::While, piece(6, 15))));
        assert_eq!(step("END2"), Some(Step::Close(None, None)));
        for text in
            ["IF [#1 EQ 0] THEN", "GOTO #1", "o#1 call", "o1 if #1 EQ 0", "o1 else X5", "END", "WHILE [1]"]
        {
            assert_eq!(step(text), None, "{text}");
        }
    }
}
