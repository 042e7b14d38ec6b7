//! One line of a Sinumerik program into words.

use super::statement;
use crate::program::comment::comment_end;
use crate::program::constants::exponent_end;
use crate::program::dialect::LineRead;
use crate::program::line;
use crate::program::number::{MAX_MAGNITUDE, exponent_at, follows_number, number_start, read_unsigned};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Excerpt, Keyword,
    Word, WordForm,
};

const SPECIAL: u8 = 0;
const LETTER: u8 = 1;
const BLANK: u8 = 2;
const LINE_END: u8 = 3;

/// What a byte can begin. Control bytes are blanks; an underscore begins names as letters do.
const CLASSES: [u8; 256] = {
    let mut classes = [SPECIAL; 256];
    let mut byte = 0;
    while byte < 256 {
        if byte <= b' ' as usize || byte == 0x7f {
            classes[byte] = BLANK;
        }
        byte += 1;
    }
    let mut letter = b'A';
    while letter <= b'Z' {
        classes[letter as usize] = LETTER;
        classes[letter.to_ascii_lowercase() as usize] = LETTER;
        letter += 1;
    }
    classes[b'\n' as usize] = LINE_END;
    classes[b'\r' as usize] = LINE_END;
    classes
};

/// Most words of a line: the control takes 512 bytes a block.
const MAX_LINE_WORDS: usize = 256;
/// Addresses that may stand several times in a block: G, M, N and, for several functions at once, H.
const REPEATABLE: u32 = (1 << Address::G.index())
    | (1 << Address::M.index())
    | (1 << Address::N.index())
    | (1 << Address::H.index());

/// A line while it is read.
pub(super) struct Line<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    start: usize,
    /// Added to a position in `text` to get one in the batch's text.
    shift: usize,
    number: u64,
    first_word: usize,
    batch: &'a mut Batch,
    /// Addresses seen, by index.
    seen: u32,
    pub(super) flags: BlockFlags,
    pub(super) kind: Option<BlockKind>,
}

/// Reads the line that starts at `start` of `text` and adds it to the batch. `shift` (wrapping) takes positions in
/// `text` to positions in the batch's text.
pub(in crate::program) fn read_line(
    text: &[u8],
    start: usize,
    shift: usize,
    number: u64,
    batch: &mut Batch,
) -> LineRead {
    let first_word = batch.words.len();
    let flags = BlockFlags::default();
    let mut line =
        Line { text, at: start, start, shift, number, first_word, batch, seen: 0, flags, kind: None };
    while let Some(&byte) = text.get(line.at) {
        match CLASSES[byte as usize] {
            LETTER => line.word(byte),
            BLANK => line.at += 1,
            LINE_END => break,
            _ => line.special(byte),
        }
    }
    LineRead::one(line.close())
}

impl Line<'_> {
    /// A letter with a number behind it; anything else is a statement.
    #[inline]
    fn word(&mut self, letter: u8) {
        let start = self.at;
        if letter | 0x20 == b'e' && self.is_exponent(start) {
            return self.fail_exponent(start);
        }
        let mut at = start + 1;
        let mut byte = self.byte(at);
        if byte == b'=' {
            return self.equals_word(letter);
        }
        while byte == b' ' || byte == b'\t' {
            at += 1;
            byte = self.byte(at);
        }
        let negative = byte == b'-';
        let signed = negative || byte == b'+';
        if signed {
            at += 1;
            while matches!(self.byte(at), b' ' | b'\t') {
                at += 1;
            }
        }
        let Some(number) = read_unsigned(self.text, at) else { return statement::named(self, start) };
        // `X1=`, `L340(…)`, `M[1]=` and their kin are names; so is what has a letter's meaning of its own.
        let next = self.byte(number.end);
        let takes_argument = matches!(letter, b'M' | b'm' | b'H' | b'h');
        let is_odd = matches!(next, b'=' | b'[' | b'_' | b'"' | b'E' | b'e')
            || (next == b'(' && !takes_argument)
            || (matches!(next, b' ' | b'\t') && self.has_equals(number.end))
            || matches!(letter, b'L' | b'l' | b'R' | b'r');
        if is_odd && (!signed || matches!(next, b'E' | b'e' | b'_')) {
            return statement::odd_number(self, start, at, number.end, negative);
        }
        if number.value > MAX_MAGNITUDE {
            return self.too_large(letter, if negative { -number.value } else { number.value }, number.end);
        }
        self.at = number.end;
        // 0 − 0 is +0: a negative zero never enters.
        let value = if negative { 0.0 - number.value } else { number.value };
        self.batch.habits.drops_zero |= !number.has_whole;
        self.batch.habits.points |= number.has_point;
        self.push(Word {
            value,
            start: self.in_batch(start),
            end: self.in_batch(number.end),
            address: Address::of_letter(letter),
            lead: 1,
            decimals: number.decimals,
            form: WordForm::Number,
            has_point: number.has_point,
        });
    }

    /// `X=10.5`: a letter and `=`. With nothing but a number behind it, the word is as plain as `X10.5`.
    #[inline]
    fn equals_word(&mut self, letter: u8) {
        let start = self.at;
        let mut at = start + 2;
        let negative = self.byte(at) == b'-';
        at += usize::from(negative || self.byte(at) == b'+');
        let number = match read_unsigned(self.text, at) {
            Some(number) if number.value <= MAX_MAGNITUDE && self.is_value_end(number.end) => number,
            _ => return statement::named(self, start),
        };
        if matches!(letter, b'L' | b'l' | b'N' | b'n' | b'R' | b'r') {
            return statement::named(self, start);
        }
        self.at = number.end;
        self.note_number(number.has_point, number.has_whole);
        self.push(Word {
            value: if negative { 0.0 - number.value } else { number.value },
            start: self.in_batch(start),
            end: self.in_batch(number.end),
            address: Address::of_letter(letter),
            lead: 2,
            decimals: number.decimals,
            form: WordForm::Number,
            has_point: number.has_point,
        });
    }

    /// Whether a value surely ends at a byte: with the line, or with blanks and no operator behind them. Operators of
    /// letters have a second one; letters of words have none.
    #[inline]
    fn is_value_end(&self, at: usize) -> bool {
        match self.byte(at) {
            b'\n' | b'\r' | b';' => true,
            b' ' | b'\t' => {
                let next = self.skip_blanks(at);
                let byte = self.byte(next);
                let second = self.byte(next + 1);
                matches!(byte, b'\n' | b'\r' | b';')
                    || (byte.is_ascii_alphabetic() && !second.is_ascii_alphabetic() && second != b'_')
            }
            _ => false,
        }
    }

    /// Whether `=` (and not `==`) comes next behind blanks.
    #[inline]
    pub(super) fn has_equals(&self, at: usize) -> bool {
        let at = self.skip_blanks(at);
        self.byte(at) == b'=' && self.byte(at + 1) != b'='
    }

    #[cold]
    pub(super) fn too_large(&mut self, letter: u8, value: f64, end: usize) {
        let code = DiagnosticCode::TooLarge {
            address: Address::of_letter(letter),
            value: value.clamp(f64::MIN, f64::MAX),
            max_abs: MAX_MAGNITUDE,
        };
        self.fail(code, self.at, end);
    }

    #[inline]
    pub(super) fn push(&mut self, word: Word) {
        if self.batch.words.len() - self.first_word >= MAX_LINE_WORDS {
            return self.fail(
                DiagnosticCode::TooManyWords { max: MAX_LINE_WORDS },
                self.start,
                line::line_end(self.text, self.at),
            );
        }
        if word.form == WordForm::Comma {
            self.flags.set(BlockFlags::COMMA);
        } else {
            let bit = 1 << word.address.index();
            if self.seen & bit & !REPEATABLE != 0 {
                self.flags.set(BlockFlags::REPEATED);
            }
            self.seen |= bit;
        }
        if matches!(word.form, WordForm::Expression | WordForm::Name) {
            self.flags.set(BlockFlags::EXPRESSION);
        }
        self.batch.words.push(word);
    }

    /// Adds a statement word between two bytes of the line.
    pub(super) fn push_keyword(&mut self, keyword: Keyword, start: usize, end: usize) {
        self.at = self.at.max(end);
        let (from, to) = (self.in_batch(start), self.in_batch(end));
        self.push(Word::of_keyword(keyword, from, to));
    }

    /// Notes that a number was written with a point, or without a zero before it.
    pub(super) fn note_number(&mut self, has_point: bool, has_whole: bool) {
        self.batch.habits.drops_zero |= !has_whole;
        self.batch.habits.points |= has_point;
    }

    fn special(&mut self, byte: u8) {
        match byte {
            b';' => {
                self.flags.set(BlockFlags::COMMENT);
                self.at = line::line_end(self.text, self.at);
            }
            b'_' | b'$' => statement::named(self, self.at),
            b'%' if self.is_untouched() => {
                self.kind = Some(BlockKind::Percent);
                self.at = line::line_end(self.text, self.at);
            }
            b'/' if self.has_only_number() => {
                self.flags.set(BlockFlags::DELETE);
                self.at += 1;
                if self.byte(self.at).is_ascii_digit() && !self.byte(self.at + 1).is_ascii_digit() {
                    self.at += 1;
                }
            }
            // A main block's number.
            b':' if self.is_untouched() => match read_unsigned(self.text, self.at + 1) {
                Some(number) if !number.has_point && number.value <= MAX_MAGNITUDE => {
                    let start = self.in_batch(self.at);
                    self.at = number.end;
                    self.push(Word {
                        value: number.value,
                        start,
                        end: self.in_batch(number.end),
                        address: Address::N,
                        lead: 1,
                        decimals: 0,
                        form: WordForm::Number,
                        has_point: false,
                    });
                }
                _ => self.fail_unexpected(self.at),
            },
            b'(' if self.take_argument() => {}
            // A byte order mark.
            0xef if self.number == 1
                && self.at == self.start
                && self.text.get(self.at..).is_some_and(|rest| rest.starts_with(b"\xef\xbb\xbf")) =>
            {
                self.at += 3;
            }
            _ => self.fail_unexpected(self.at),
        }
    }

    /// `M202(0.0059)`: an argument in round brackets behind an M or an H code belongs to its word.
    fn take_argument(&mut self) -> bool {
        let Ok(end) = comment_end(self.text, self.at) else { return false };
        let is_closed = self.text.get(self.at..end).is_some_and(|argument| argument.ends_with(b")"));
        let end_in_batch = self.in_batch(end);
        let code_end = self.text.get(self.start..self.at).unwrap_or_default().trim_ascii_end().len();
        let code_end = self.in_batch(self.start + code_end);
        match self.batch.words.get_mut(self.first_word..).and_then(<[Word]>::last_mut) {
            Some(word)
                if is_closed
                    && matches!(word.address, Address::M | Address::H)
                    && word.form != WordForm::Keyword
                    && word.end == code_end =>
            {
                word.end = end_in_batch;
                self.at = end;
                true
            }
            _ => false,
        }
    }

    /// The byte at `at`, or a line end behind the text.
    #[inline]
    pub(super) fn byte(&self, at: usize) -> u8 {
        self.text.get(at).copied().unwrap_or(b'\n')
    }

    pub(super) fn skip_blanks(&self, mut at: usize) -> usize {
        while matches!(self.byte(at), b' ' | b'\t') {
            at += 1;
        }
        at
    }

    #[inline]
    pub(super) fn in_batch(&self, at: usize) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
        let position = at.wrapping_add(self.shift) as u32;
        position
    }

    /// Whether nothing but blanks has been read on this line.
    fn is_untouched(&self) -> bool {
        self.batch.words.len() == self.first_word
            && self.flags == BlockFlags::default()
            && self.kind.is_none()
    }

    /// Whether the line holds nothing but its block number so far.
    pub(super) fn has_only_number(&self) -> bool {
        let words = self.batch.words.get(self.first_word..).unwrap_or_default();
        words.iter().all(|word| word.address == Address::N)
    }

    /// Where the line ending starts, from the present position on.
    pub(super) fn line_end(&self) -> usize {
        line::line_end(self.text, self.at)
    }

    /// Says what the line as a whole is; the rest of it is walked over, its comment apart.
    pub(super) fn settle(&mut self, kind: BlockKind) {
        if self.kind != Some(BlockKind::Malformed) {
            self.kind = Some(kind);
        }
        self.at = self.line_end();
    }

    /// Gives the line up: its words are dropped, the reason is kept.
    pub(super) fn fail(&mut self, code: DiagnosticCode, start: usize, end: usize) {
        let offset = self.batch.offset + u64::from(self.in_batch(start));
        self.batch.faults.push(Diagnostic {
            code,
            line: self.number,
            column: u32::try_from(start - self.start + 1).unwrap_or(u32::MAX),
            span: ByteSpan { start: offset, end: offset + end.saturating_sub(start) as u64 },
        });
        self.kind = Some(BlockKind::Malformed);
        self.batch.words.truncate(self.first_word);
        self.at = self.line_end();
    }

    /// What stands from here on is not part of a block.
    #[cold]
    pub(super) fn fail_unexpected(&mut self, start: usize) {
        let end = line::line_end(self.text, start);
        let text = Excerpt::new(self.text.get(start..end).unwrap_or_default());
        self.fail(DiagnosticCode::UnexpectedText { text }, start, end);
    }

    /// Whether the letter at a byte is the `E` of an exponent, directly after a number. The control's own exponents are
    /// written `EX`, and `E` alone begins none of its words there.
    fn is_exponent(&self, at: usize) -> bool {
        follows_number(self.text, self.start, at) && exponent_at(self.text, at).is_some()
    }

    /// Gives up a line with an exponent whose letter stands at this byte.
    #[cold]
    pub(super) fn fail_exponent(&mut self, at: usize) {
        let start = number_start(self.text, self.start, at);
        let end = line::line_end(self.text, at);
        let text = Excerpt::new(self.text.get(start..end).unwrap_or_default());
        self.fail(DiagnosticCode::Exponent { text }, start, end);
    }

    /// A number is missing, or a bracket is not closed.
    #[cold]
    pub(super) fn fail_value(&mut self, start: usize, is_unclosed: bool) {
        let end = line::line_end(self.text, start);
        let text = Excerpt::new(self.text.get(start..end).unwrap_or_default());
        let code = if is_unclosed {
            DiagnosticCode::Unclosed { text }
        } else {
            DiagnosticCode::MissingNumber { text }
        };
        self.fail(code, start, end);
    }

    fn close(self) -> usize {
        let body_end = self.at;
        let end = line::next_line(self.text, body_end);
        let words_end = self.batch.words.len();
        let kind = self.kind.unwrap_or({
            let body = self.text.get(self.start..body_end).unwrap_or_default();
            if words_end > self.first_word || self.flags.has(BlockFlags::DELETE) {
                BlockKind::Words
            } else if self.flags.has(BlockFlags::ASSIGNS) {
                BlockKind::Assignment
            } else if body.trim_ascii().first().is_none_or(|byte| *byte == b';') {
                if self.flags.has(BlockFlags::COMMENT) { BlockKind::Comment } else { BlockKind::Blank }
            } else {
                // A message, a label, a statement without meaning for the path: a block without words.
                BlockKind::Words
            }
        });
        #[expect(clippy::cast_possible_truncation, reason = "fewer words than bytes")]
        let (words_start, words_end) = (self.first_word as u32, words_end as u32);
        let block = Block {
            line: self.number,
            start: self.in_batch(self.start),
            body_end: self.in_batch(body_end),
            end: self.in_batch(end),
            words_start,
            words_end,
            kind,
            flags: self.flags,
        };
        self.batch.blocks.push(block);
        end
    }
}

/// Whether an exponent `EX…` stands at a byte.
pub(super) fn has_exponent(text: &[u8], at: usize) -> Option<usize> {
    exponent_end(text, at)
}
