//! A statement while it is read: what the readers of conversational and cutter location text have in common.

use crate::program::line::{line_end, next_line};
use crate::program::number::{MAX_MAGNITUDE, read_unsigned};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Excerpt, Keyword,
    Word, WordForm,
};

/// Most words of a statement.
const MAX_WORDS: usize = 256;
/// Most physical lines of a statement.
const MAX_LINES: u64 = 200;
/// Longest number with a decimal comma or an exponent.
const MAX_NUMBER: usize = 64;

/// The physical lines of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extent {
    /// One past the last byte before the last line's ending.
    pub(super) body_end: usize,
    /// Where the next statement starts.
    pub(super) next: usize,
    pub(super) lines: u64,
}

/// Joins lines as long as `runs_on` says so, given a line (without its ending) and all text behind its ending; `None`
/// where that needs text that is not there yet. `runs_on` answers `None` where the next line decides and is missing.
pub(super) fn extent(
    text: &[u8],
    start: usize,
    last: bool,
    runs_on: impl Fn(&[u8], &[u8]) -> Option<bool>,
) -> Option<Extent> {
    let mut at = start;
    let mut lines = 1;
    loop {
        let body_end = line_end(text, at);
        let next = next_line(text, body_end);
        let line = text.get(at..body_end).unwrap_or_default();
        let rest = text.get(next..).unwrap_or_default();
        let more = match runs_on(line, rest) {
            Some(more) => more && lines < MAX_LINES,
            None if last => false,
            None => return None,
        };
        if !more || (rest.is_empty() && last) {
            return Some(Extent { body_end, next, lines });
        }
        if rest.is_empty() {
            return None;
        }
        at = next;
        lines += 1;
    }
}

/// A number with its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about its spelling")]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) decimals: u8,
    pub(super) has_point: bool,
    pub(super) has_whole: bool,
    pub(super) has_comma: bool,
    pub(super) has_plus: bool,
    pub(super) end: usize,
}

impl Number {
    /// A value that stands for text ending at `end`.
    pub(super) const fn standing_for(value: f64, end: usize) -> Self {
        Self { value, decimals: 0, has_point: false, has_whole: true, has_comma: false, has_plus: false, end }
    }
}

/// A number below 2²³ that tells texts apart: FNV-1a, cut to what a number word holds.
pub(super) fn fingerprint(text: impl Iterator<Item = u8>) -> f64 {
    let hash = text.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    #[expect(clippy::cast_precision_loss, reason = "23 bits")]
    let number = (hash >> 41) as f64;
    number
}

/// What may stand in a number besides digits, sign and point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spelling {
    /// A decimal comma.
    Comma,
    /// An exponent: `1.5E-03`.
    Exponent,
}

/// Reads a number at `at`, blanks behind its sign included; `None` where there is none.
#[inline]
pub(super) fn number(text: &[u8], at: usize, spelling: Spelling) -> Option<Number> {
    let mut from = at;
    let negative = text.get(from) == Some(&b'-');
    if negative || text.get(from) == Some(&b'+') {
        from += 1;
        while matches!(text.get(from), Some(b' ' | b'\t')) {
            from += 1;
        }
    }
    let (read, has_comma) = match spelling {
        Spelling::Comma => match read_unsigned(text, from) {
            Some(read) if read.has_point || text.get(read.end) != Some(&b',') => (read, false),
            None if text.get(from) != Some(&b',') => return None,
            _ => (read_respelled(text, from, |byte| if byte == b',' { b'.' } else { byte })?, true),
        },
        Spelling::Exponent => (read_unsigned(text, from)?, false),
    };
    let mut number = Number {
        value: read.value,
        decimals: read.decimals,
        has_point: read.has_point,
        has_whole: read.has_whole,
        has_comma,
        has_plus: text.get(at) == Some(&b'+'),
        end: read.end,
    };
    if spelling == Spelling::Exponent && matches!(text.get(number.end), Some(b'E' | b'e' | b'D' | b'd')) {
        number = with_exponent(text, from, number)?;
    }
    // 0 − 0 is +0: a negative zero never enters.
    number.value = if negative { 0.0 - number.value } else { number.value };
    Some(number)
}

/// The number at `from` read with other bytes in place of some.
fn read_respelled(
    text: &[u8],
    from: usize,
    spell: impl Fn(u8) -> u8,
) -> Option<crate::program::number::Unsigned> {
    let mut buffer = [b' '; MAX_NUMBER + 8];
    for (slot, byte) in buffer.iter_mut().zip(text.get(from..)?).take(MAX_NUMBER) {
        *slot = spell(*byte);
    }
    let mut read = read_unsigned(&buffer, 0)?;
    read.end += from;
    Some(read)
}

/// The same number with the exponent behind it; exponents count as decimals needed to write the value out.
fn with_exponent(text: &[u8], from: usize, number: Number) -> Option<Number> {
    let mut end = number.end + 1;
    end += usize::from(matches!(text.get(end), Some(b'+' | b'-')));
    let digits = text.get(end..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if digits == 0 || end + digits - from > MAX_NUMBER {
        return None;
    }
    end += digits;
    let mut buffer = [0; MAX_NUMBER];
    let spelled = buffer.get_mut(..end - from)?;
    spelled.copy_from_slice(text.get(from..end)?);
    for byte in spelled.iter_mut().filter(|byte| matches!(byte, b'D' | b'd')) {
        *byte = b'e';
    }
    let spelled = std::str::from_utf8(spelled).ok()?;
    let exponent: i64 = spelled.get(number.end - from + 1..)?.parse().ok()?;
    let decimals = (i64::from(number.decimals) - exponent).clamp(0, 15);
    let value = spelled.parse::<f64>().ok()?;
    Some(Number { value, decimals: u8::try_from(decimals).unwrap_or(15), end, ..number })
}

/// A statement on its way into the batch.
pub(super) struct Scan<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    pub(super) start: usize,
    pub(super) extent: Extent,
    /// Added to a position in `text` to get one in the batch's text.
    shift: usize,
    line: u64,
    first_word: usize,
    batch: &'a mut Batch,
    /// Addresses seen, by index.
    seen: u64,
    pub(super) flags: BlockFlags,
    pub(super) kind: Option<BlockKind>,
}

/// Addresses that may stand several times in a block: G (keywords), M, N.
const REPEATABLE: u64 = (1 << Address::G.index()) | (1 << Address::M.index()) | (1 << Address::N.index());

impl<'a> Scan<'a> {
    pub(super) fn new(
        text: &'a [u8],
        start: usize,
        extent: Extent,
        shift: usize,
        line: u64,
        batch: &'a mut Batch,
    ) -> Self {
        let first_word = batch.words.len();
        let flags = BlockFlags::default();
        Self { text, at: start, start, extent, shift, line, first_word, batch, seen: 0, flags, kind: None }
    }

    /// The byte at `at`, or a line end behind the statement.
    #[inline]
    pub(super) fn byte(&self, at: usize) -> u8 {
        if at < self.extent.body_end { self.text.get(at).copied().unwrap_or(b'\n') } else { b'\n' }
    }

    /// The bytes between two positions of the statement.
    #[inline]
    pub(super) fn slice(&self, from: usize, to: usize) -> &'a [u8] {
        self.text.get(from..to.min(self.extent.body_end)).unwrap_or_default()
    }

    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        while matches!(self.byte(self.at), b' ' | b'\t') {
            self.at += 1;
        }
    }

    /// One past the letters that start at `from`.
    #[inline]
    pub(super) fn letters_end(&self, from: usize) -> usize {
        let mut end = from;
        while self.byte(end).is_ascii_alphabetic() {
            end += 1;
        }
        end
    }

    /// Goes to the end of the statement.
    pub(super) fn skip_all(&mut self) {
        self.at = self.extent.body_end;
    }

    /// Adds a word of the statement's grammar.
    pub(super) fn keyword(&mut self, keyword: Keyword, start: usize, end: usize) {
        let (start, end) = (self.in_batch(start), self.in_batch(end));
        self.push(Word::of_keyword(keyword, start, end));
    }

    /// Adds a word with a number; `lead` bytes stand before it from `start` on.
    #[inline]
    pub(super) fn number_word(
        &mut self,
        address: Address,
        form: WordForm,
        start: usize,
        lead: usize,
        number: Number,
    ) {
        if number.value.abs() > MAX_MAGNITUDE {
            let value = number.value.clamp(f64::MIN, f64::MAX);
            let code = DiagnosticCode::TooLarge { address, value, max_abs: MAX_MAGNITUDE };
            return self.fail(code, start, number.end);
        }
        let habits = &mut self.batch.habits;
        habits.drops_zero |= !number.has_whole;
        habits.points |= number.has_point;
        habits.decimal_comma |= number.has_comma;
        habits.plus_signs |= number.has_plus;
        let word = Word {
            value: number.value,
            start: self.in_batch(start),
            end: self.in_batch(number.end),
            address,
            decimals: number.decimals,
            form,
            has_point: number.has_point,
            lead: u8::try_from(lead).unwrap_or(u8::MAX),
        };
        self.at = number.end;
        self.push(word);
    }

    /// Adds a word whose value is not written as a number.
    pub(super) fn expression(&mut self, address: Address, start: usize, lead: usize, end: usize) {
        self.flags.set(BlockFlags::EXPRESSION);
        let word = Word {
            value: 0.0,
            start: self.in_batch(start),
            end: self.in_batch(end),
            address,
            decimals: 0,
            form: WordForm::Expression,
            has_point: false,
            lead: u8::try_from(lead).unwrap_or(u8::MAX),
        };
        self.at = end;
        self.push(word);
    }

    /// Adds a word with a name in place of a number.
    pub(super) fn name(&mut self, address: Address, start: usize, end: usize) {
        self.expression(address, start, 0, end);
        if self.kind != Some(BlockKind::Malformed)
            && let Some(word) = self.batch.words.last_mut()
        {
            word.form = WordForm::Name;
        }
    }

    #[inline]
    fn push(&mut self, word: Word) {
        if self.kind == Some(BlockKind::Malformed) {
            return;
        }
        if self.batch.words.len() - self.first_word >= MAX_WORDS {
            return self.fail(
                DiagnosticCode::TooManyWords { max: MAX_WORDS },
                self.start,
                self.extent.body_end,
            );
        }
        let bit = 1 << word.address.index();
        if self.seen & bit & !REPEATABLE != 0 {
            self.flags.set(BlockFlags::REPEATED);
        }
        self.seen |= bit;
        self.batch.words.push(word);
    }

    #[inline]
    fn in_batch(&self, at: usize) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
        let position = at.wrapping_add(self.shift) as u32;
        position
    }

    /// Gives the statement up: its words are dropped, the reason is kept.
    pub(super) fn fail(&mut self, code: DiagnosticCode, start: usize, end: usize) {
        if self.kind == Some(BlockKind::Malformed) {
            return;
        }
        let offset = self.batch.offset + u64::from(self.in_batch(start));
        self.batch.faults.push(Diagnostic {
            code,
            line: self.line,
            column: u32::try_from(start.saturating_sub(self.start) + 1).unwrap_or(u32::MAX),
            span: ByteSpan { start: offset, end: offset + end.saturating_sub(start) as u64 },
        });
        self.kind = Some(BlockKind::Malformed);
        self.batch.words.truncate(self.first_word);
        self.skip_all();
    }

    /// Fails with the text from `start` on, which does not belong there.
    pub(super) fn fail_unexpected(&mut self, start: usize) {
        let text = Excerpt::new(self.slice(start, self.extent.body_end));
        self.fail(DiagnosticCode::UnexpectedText { text }, start, self.extent.body_end);
    }

    /// Fails with the text from `start` on, where a number is missing.
    pub(super) fn fail_number(&mut self, start: usize) {
        let text = Excerpt::new(self.slice(start, self.extent.body_end));
        self.fail(DiagnosticCode::MissingNumber { text }, start, self.extent.body_end);
    }

    /// Adds the block; `kind` is what it is unless it was said before.
    pub(super) fn close(mut self, kind: BlockKind) -> super::LineRead {
        let kind = self.kind.unwrap_or(kind);
        if kind == BlockKind::Malformed {
            self.batch.words.truncate(self.first_word);
        }
        let words_end = self.batch.words.len();
        let Extent { body_end, next, lines } = self.extent;
        #[expect(clippy::cast_possible_truncation, reason = "fewer words than bytes")]
        let (words_start, words_end) = (self.first_word as u32, words_end as u32);
        let block = Block {
            line: self.line,
            start: self.in_batch(self.start),
            body_end: self.in_batch(body_end),
            end: self.in_batch(next),
            words_start,
            words_end,
            kind,
            flags: std::mem::take(&mut self.flags),
        };
        self.batch.blocks.push(block);
        super::LineRead { next, lines }
    }
}
