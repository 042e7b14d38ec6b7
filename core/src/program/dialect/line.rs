//! A line, or a statement of several lines, on its way into a batch. Every dialect adds its words and its block with
//! this type.

use super::LineRead;
use super::number::Number;
use crate::program::line::{line_end, next_line};
use crate::program::number::{MAX_MAGNITUDE, Unsigned};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Excerpt, Keyword,
    Word, WordForm,
};

/// The most words of a line or a statement. Controls take a few dozen.
pub(super) const MAX_WORDS: usize = 256;
/// The most physical lines of a statement.
const MAX_LINES: u64 = 200;
/// Addresses that may occur several times in a block: G (also statement words), M, N.
pub(super) const REPEATABLE: u32 =
    (1 << Address::G.index()) | (1 << Address::M.index()) | (1 << Address::N.index());

/// A line to be read.
#[derive(Debug, Clone, Copy)]
pub(in crate::program) struct Source<'a> {
    /// The text so far, up to its last whole line.
    pub(in crate::program) text: &'a [u8],
    /// The start of the line in it.
    pub(in crate::program) start: usize,
    /// The difference (wrapping) from a position in `text` to a position in the batch's text.
    pub(in crate::program) shift: usize,
    /// 1-based line of the upload.
    pub(in crate::program) line: u64,
    /// No more text follows.
    pub(in crate::program) is_last: bool,
}

/// The physical lines of a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extent {
    /// One after the last byte before the last line's ending.
    pub(super) body_end: usize,
    /// Start of the next statement.
    pub(super) next: usize,
    pub(super) lines: u64,
}

impl Extent {
    /// One line. Its end is found at the end of its words.
    pub(super) const ONE_LINE: Self = Self { body_end: usize::MAX, next: 0, lines: 1 };
}

/// Joins lines as long as `runs_on` says so. `runs_on` gets a line (without its ending) and all text after the ending.
/// It answers `None` if the next line decides and is missing. The result is `None` if it needs text that has not
/// arrived yet.
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

/// A line or a statement that is being read.
pub(super) struct Line<'a> {
    /// The text up to the end of the statement. If the end of a line is not known, all the text.
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    pub(super) start: usize,
    pub(super) extent: Extent,
    /// The difference from a position in `text` to a position in the batch's text.
    shift: usize,
    number: u64,
    first_word: usize,
    batch: &'a mut Batch,
    /// Addresses seen so far, by index, and the addresses that may be seen again.
    seen: u32,
    repeatable: u32,
    pub(super) flags: BlockFlags,
    pub(super) kind: Option<BlockKind>,
}

impl<'a> Line<'a> {
    #[inline]
    pub(super) fn new(source: Source<'a>, extent: Extent, repeatable: u32, batch: &'a mut Batch) -> Self {
        let Source { text, start, shift, line: number, .. } = source;
        Self {
            text: text.get(..extent.body_end).unwrap_or(text),
            at: start,
            start,
            extent,
            shift,
            number,
            first_word: batch.words.len(),
            batch,
            seen: 0,
            repeatable,
            flags: BlockFlags::default(),
            kind: None,
        }
    }

    /// The byte at `at`, or a line end after the text.
    #[inline]
    pub(super) fn byte(&self, at: usize) -> u8 {
        self.text.get(at).copied().unwrap_or(b'\n')
    }

    /// The bytes between two positions.
    #[inline]
    pub(super) fn slice(&self, from: usize, to: usize) -> &'a [u8] {
        self.text.get(from..to.min(self.text.len())).unwrap_or_default()
    }

    /// The end of the line or the statement, without its line ending. The present position is in this line.
    #[inline]
    pub(super) fn end(&self) -> usize {
        if self.extent.body_end == usize::MAX { line_end(self.text, self.at) } else { self.extent.body_end }
    }

    /// One after the blanks that start at `at`.
    #[inline]
    pub(super) fn blanks_end(&self, mut at: usize) -> usize {
        while matches!(self.byte(at), b' ' | b'\t') {
            at += 1;
        }
        at
    }

    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        self.at = self.blanks_end(self.at);
    }

    /// One after the letters that start at `at`.
    #[inline]
    pub(super) fn letters_end(&self, mut at: usize) -> usize {
        while self.byte(at).is_ascii_alphabetic() {
            at += 1;
        }
        at
    }

    /// Moves to the end.
    #[inline]
    pub(super) fn skip_all(&mut self) {
        self.at = self.end();
    }

    /// Whether this is the first line of the upload, nothing of it has been read yet, and a byte order mark is here.
    #[inline]
    pub(super) fn is_at_byte_order_mark(&self) -> bool {
        self.number == 1
            && self.at == self.start
            && self.text.get(self.at..).is_some_and(|rest| rest.starts_with(b"\xef\xbb\xbf"))
    }

    /// The words of the line so far.
    #[inline]
    pub(super) fn words(&self) -> &[Word] {
        self.batch.words.get(self.first_word..).unwrap_or_default()
    }

    /// The last word so far.
    #[inline]
    pub(super) fn last_word(&mut self) -> Option<&mut Word> {
        self.batch.words.get_mut(self.first_word..).and_then(<[Word]>::last_mut)
    }

    /// Whether only blanks have been read.
    #[inline]
    pub(super) fn is_untouched(&self) -> bool {
        self.words().is_empty() && self.flags == BlockFlags::default() && self.kind.is_none()
    }

    /// Whether the line has no word except a block number so far.
    #[inline]
    pub(super) fn has_only_number(&self) -> bool {
        self.words().iter().all(|word| word.address == Address::N)
    }

    /// Whether only blanks and a block number are before the present position.
    #[inline]
    pub(super) fn opens(&self) -> bool {
        self.has_only_number() && self.flags == BlockFlags::default() && self.kind.is_none()
    }

    /// Notes that a number was written with a point, or without a zero before it.
    #[inline]
    pub(super) fn note_number(&mut self, has_point: bool, has_whole: bool) {
        self.batch.habits.drops_zero |= !has_whole;
        self.batch.habits.points |= has_point;
    }

    #[inline]
    pub(super) fn in_batch(&self, at: usize) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
        let position = at.wrapping_add(self.shift) as u32;
        position
    }

    #[inline]
    pub(super) fn push(&mut self, word: Word) {
        if self.kind == Some(BlockKind::Malformed) {
            return;
        }
        if self.batch.words.len() - self.first_word >= MAX_WORDS {
            return self.fail_full();
        }
        if word.form == WordForm::Comma {
            // `,R2` is not a second R.
            self.flags.set(BlockFlags::COMMA);
        } else {
            let bit = 1 << word.address.index();
            if self.seen & bit & !self.repeatable != 0 {
                self.flags.set(BlockFlags::REPEATED);
            }
            self.seen |= bit;
        }
        if matches!(word.form, WordForm::Expression | WordForm::Name) {
            self.flags.set(BlockFlags::EXPRESSION);
        }
        self.batch.words.push(word);
    }

    /// Fails a line that already has the largest number of words.
    #[cold]
    fn fail_full(&mut self) {
        let end = self.end();
        self.fail(DiagnosticCode::TooManyWords { max: MAX_WORDS }, self.start, end);
    }

    /// Adds a statement word between two bytes.
    #[inline]
    pub(super) fn keyword(&mut self, keyword: Keyword, start: usize, end: usize) {
        let (start, end) = (self.in_batch(start), self.in_batch(end));
        self.push(Word::of_keyword(keyword, start, end));
    }

    /// Adds a word with a number whose sign was read separately. `lead` bytes are between `start` and the sign.
    #[inline]
    pub(super) fn unsigned_word(
        &mut self,
        address: Address,
        start: usize,
        lead: u8,
        is_negative: bool,
        number: &Unsigned,
    ) {
        self.at = number.end;
        self.note_number(number.has_point, number.has_whole);
        self.push(Word {
            // 0 − 0 is +0, so a negative zero never gets in.
            value: if is_negative { 0.0 - number.value } else { number.value },
            start: self.in_batch(start),
            end: self.in_batch(number.end),
            address,
            lead,
            decimals: number.decimals,
            form: WordForm::Number,
            has_point: number.has_point,
        });
    }

    /// Adds a word with a number. `lead` bytes are between `start` and the number.
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
            return self.fail_too_large(address, number.value, start, number.end);
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

    /// Adds a word of one letter whose value ends at `end` and is not plain.
    pub(super) fn odd_word(
        &mut self,
        address: Address,
        form: WordForm,
        start: usize,
        end: usize,
        value: f64,
    ) {
        let word = Word {
            value,
            start: self.in_batch(start),
            end: self.in_batch(end),
            address,
            lead: 1,
            decimals: 0,
            form,
            has_point: false,
        };
        self.at = end;
        self.push(word);
    }

    /// Adds a word whose value is not written as a number.
    pub(super) fn expression(&mut self, address: Address, start: usize, lead: usize, end: usize) {
        self.odd_word(address, WordForm::Expression, start, end, 0.0);
        self.lead_by(lead);
    }

    /// Adds a word with a name instead of a number. The name begins `lead` bytes after `start`.
    pub(super) fn name(&mut self, address: Address, start: usize, lead: usize, end: usize) {
        self.odd_word(address, WordForm::Name, start, end, 0.0);
        self.lead_by(lead);
    }

    /// The value of the last word begins `lead` bytes after its start.
    fn lead_by(&mut self, lead: usize) {
        if self.kind != Some(BlockKind::Malformed)
            && let Some(word) = self.last_word()
        {
            word.lead = u8::try_from(lead).unwrap_or(u8::MAX);
        }
    }

    /// Sets the kind of the whole line. The rest of the line is skipped, except its comment.
    pub(super) fn settle(&mut self, kind: BlockKind) {
        if self.kind != Some(BlockKind::Malformed) {
            self.kind = Some(kind);
        }
        self.skip_all();
    }

    /// Fails the line: its words are removed, and the first reason is kept.
    pub(super) fn fail(&mut self, code: DiagnosticCode, start: usize, end: usize) {
        if self.kind == Some(BlockKind::Malformed) {
            return;
        }
        let offset = self.batch.offset + u64::from(self.in_batch(start));
        self.batch.faults.push(Diagnostic {
            code,
            line: self.number,
            called: None,
            column: u32::try_from(start.saturating_sub(self.start) + 1).unwrap_or(u32::MAX),
            span: ByteSpan { start: offset, end: offset + end.saturating_sub(start) as u64 },
        });
        self.kind = Some(BlockKind::Malformed);
        self.batch.words.truncate(self.first_word);
        self.skip_all();
    }

    /// Fails at `start` with the text from `start` on.
    #[cold]
    pub(super) fn fail_with(&mut self, code: fn(Excerpt) -> DiagnosticCode, start: usize) {
        let end = self.end().max(start);
        self.fail(code(Excerpt::new(self.slice(start, end))), start, end);
    }

    /// Fails with the text from `start` on, which does not belong there.
    #[cold]
    pub(super) fn fail_unexpected(&mut self, start: usize) {
        self.fail_with(|text| DiagnosticCode::UnexpectedText { text }, start);
    }

    /// Fails with the text from `start` on, because a number is missing.
    #[cold]
    pub(super) fn fail_number(&mut self, start: usize) {
        self.fail_with(|text| DiagnosticCode::MissingNumber { text }, start);
    }

    /// Fails with the text from `start` on, because something is not closed.
    #[cold]
    pub(super) fn fail_unclosed(&mut self, start: usize) {
        self.fail_with(|text| DiagnosticCode::Unclosed { text }, start);
    }

    /// Fails with a number that is too large for any machine.
    #[cold]
    pub(super) fn fail_too_large(&mut self, address: Address, value: f64, start: usize, end: usize) {
        let value = value.clamp(f64::MIN, f64::MAX);
        self.fail(DiagnosticCode::TooLarge { address, value, max_abs: MAX_MAGNITUDE }, start, end);
    }

    /// Adds the block. `kind` is its kind unless another kind was set before. A line ends at the present position.
    #[inline]
    pub(super) fn close(self, kind: BlockKind) -> LineRead {
        let kind = self.kind.unwrap_or(kind);
        if kind == BlockKind::Malformed {
            self.batch.words.truncate(self.first_word);
        }
        let words_end = self.batch.words.len();
        let Extent { body_end, next, lines } = match self.extent {
            Extent::ONE_LINE => Extent { body_end: self.at, next: next_line(self.text, self.at), lines: 1 },
            known => known,
        };
        #[expect(clippy::cast_possible_truncation, reason = "fewer words than bytes")]
        let (words_start, words_end) = (self.first_word as u32, words_end as u32);
        let block = Block {
            line: self.number,
            start: self.in_batch(self.start),
            body_end: self.in_batch(body_end),
            end: self.in_batch(next),
            words_start,
            words_end,
            kind,
            flags: self.flags,
        };
        self.batch.blocks.push(block);
        LineRead { next, lines }
    }
}
