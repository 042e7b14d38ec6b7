//! One line of ISO G-code into words. The plain case is one loop over letters, blanks and numbers; everything else
//! is in `statement`.

use super::statement;
use crate::program::comment::comment_end;
use crate::program::line;
use crate::program::number::{
    MAX_MAGNITUDE, exponent_at, follows_number, number_start, read_short, read_unsigned,
};
use crate::program::{
    Address, Batch, Block, BlockFlags, BlockKind, ByteSpan, Diagnostic, DiagnosticCode, Excerpt, Word,
    WordForm,
};

const SPECIAL: u8 = 0;
const LETTER: u8 = 1;
const BLANK: u8 = 2;
const LINE_END: u8 = 3;

/// What a byte can begin. O begins words and statements, so it is special; control bytes are blanks.
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
        if letter != b'O' {
            classes[letter as usize] = LETTER;
            classes[letter.to_ascii_lowercase() as usize] = LETTER;
        }
        letter += 1;
    }
    classes[b'\n' as usize] = LINE_END;
    classes[b'\r' as usize] = LINE_END;
    classes
};

/// A line while it is read.
pub(super) struct Line<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    pub(super) start: usize,
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

/// Most words of a line: controls take a few dozen.
const MAX_LINE_WORDS: usize = 256;
/// Addresses that may stand several times in a block: G, M, N.
const REPEATABLE: u32 = (1 << Address::G.index()) | (1 << Address::M.index()) | (1 << Address::N.index());

/// Reads a line of letters, short numbers and blanks, as nearly all are; `None` for any other line, a last one and an
/// empty one. Words may have been added then.
#[inline]
fn read_plain_line(text: &[u8], start: usize, shift: usize, number: u64, batch: &mut Batch) -> Option<usize> {
    #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
    let in_batch = |at: usize| at.wrapping_add(shift) as u32;
    let words = &mut batch.words;
    let first_word = words.len();
    let (mut seen, mut repeated) = (0_u32, 0_u32);
    let (mut drops_zero, mut points) = (false, false);
    let mut at = start;
    loop {
        let letter = *text.get(at)?;
        match CLASSES[letter as usize] {
            LETTER => {}
            BLANK => {
                at += 1;
                continue;
            }
            LINE_END => break,
            _ => return None,
        }
        if letter | 0x20 == b'e' && follows_number(text, start, at) {
            return None;
        }
        let sign = *text.get(at + 1)?;
        let negative = sign == b'-';
        let read = read_short(text, at + 1 + usize::from(negative || sign == b'+'))?;
        let address = Address::of_letter(letter);
        let bit = 1 << address.index();
        repeated |= seen & bit;
        seen |= bit;
        drops_zero |= !read.has_whole;
        points |= read.has_point;
        words.push(Word {
            // 0 − 0 is +0: a negative zero never enters.
            value: if negative { 0.0 - read.value } else { read.value },
            start: in_batch(at),
            end: in_batch(read.end),
            address,
            lead: 1,
            decimals: read.decimals,
            form: WordForm::Number,
            has_point: read.has_point,
        });
        at = read.end;
    }
    let words_end = words.len();
    if words_end == first_word || words_end - first_word > MAX_LINE_WORDS {
        return None;
    }
    batch.habits.drops_zero |= drops_zero;
    batch.habits.points |= points;
    let mut flags = BlockFlags::default();
    if repeated & !REPEATABLE != 0 {
        flags.set(BlockFlags::REPEATED);
    }
    let end = line::next_line(text, at);
    #[expect(clippy::cast_possible_truncation, reason = "fewer words than bytes")]
    let (words_start, words_end) = (first_word as u32, words_end as u32);
    batch.blocks.push(Block {
        line: number,
        start: in_batch(start),
        body_end: in_batch(at),
        end: in_batch(end),
        words_start,
        words_end,
        kind: BlockKind::Words,
        flags,
    });
    Some(end)
}

/// Reads the line that starts at `start` of `text` and adds it to the batch; returns where the next one starts.
/// `shift` (wrapping) takes positions in `text` to positions in the batch's text.
pub(in crate::program) fn read_line(
    text: &[u8],
    start: usize,
    shift: usize,
    number: u64,
    batch: &mut Batch,
) -> usize {
    let first_word = batch.words.len();
    if let Some(next) = read_plain_line(text, start, shift, number, batch) {
        return next;
    }
    batch.words.truncate(first_word);
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
    line.close()
}

impl Line<'_> {
    #[inline]
    fn word(&mut self, letter: u8) {
        let start = self.at;
        if letter | 0x20 == b'e' && follows_number(self.text, self.start, start) && self.is_exponent() {
            return self.fail_exponent();
        }
        let mut at = start + 1;
        let mut byte = self.byte(at);
        while byte == b' ' || byte == b'\t' {
            at += 1;
            byte = self.byte(at);
        }
        let negative = byte == b'-';
        if negative || byte == b'+' {
            at += 1;
            while matches!(self.byte(at), b' ' | b'\t') {
                at += 1;
            }
        }
        match read_unsigned(self.text, at) {
            Some(number) if number.value <= MAX_MAGNITUDE => {
                self.at = number.end;
                // 0 − 0 is +0: a negative zero never enters.
                let value = if negative { 0.0 - number.value } else { number.value };
                let address = Address::of_letter(letter);
                self.batch.habits.drops_zero |= !number.has_whole;
                self.batch.habits.points |= number.has_point;
                self.push(Word {
                    value,
                    start: self.in_batch(start),
                    end: self.in_batch(number.end),
                    address,
                    lead: 1,
                    decimals: number.decimals,
                    form: WordForm::Number,
                    has_point: number.has_point,
                });
            }
            Some(number) => {
                let value = if negative { -number.value } else { number.value }.clamp(f64::MIN, f64::MAX);
                let address = Address::of_letter(letter);
                let code = DiagnosticCode::TooLarge { address, value, max_abs: MAX_MAGNITUDE };
                self.fail(code, start, number.end);
            }
            None => statement::odd_word(self, letter),
        }
    }

    /// Whether an `E` directly after a number is its exponent: with a decimal point it is a word, `X10.5E3.2`.
    #[cold]
    fn is_exponent(&self) -> bool {
        exponent_at(self.text, self.at).is_some_and(|(_, has_point)| !has_point)
    }

    /// Gives up a line with an exponent at the present position.
    #[cold]
    fn fail_exponent(&mut self) {
        let start = number_start(self.text, self.start, self.at);
        self.fail_with(|text| DiagnosticCode::Exponent { text }, start);
    }

    #[inline]
    fn push(&mut self, word: Word) {
        if self.batch.words.len() - self.first_word >= MAX_LINE_WORDS {
            return self.fail_full();
        }
        let bit = 1 << word.address.index();
        if self.seen & bit & !REPEATABLE != 0 {
            self.flags.set(BlockFlags::REPEATED);
        }
        self.seen |= bit;
        self.batch.words.push(word);
    }

    /// Gives up a line that has as many words as are read.
    #[cold]
    fn fail_full(&mut self) {
        self.fail(DiagnosticCode::TooManyWords { max: MAX_LINE_WORDS }, self.start, self.line_end());
    }

    /// Adds a word whose value ends at `end` and is not plain.
    pub(super) fn push_odd(
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
        match form {
            // `,R2` is no second R.
            WordForm::Comma => {
                self.flags.set(BlockFlags::COMMA);
                if self.batch.words.len() - self.first_word >= MAX_LINE_WORDS {
                    return self.fail_full();
                }
                self.batch.words.push(word);
            }
            WordForm::Expression | WordForm::Name => {
                self.flags.set(BlockFlags::EXPRESSION);
                self.push(word);
            }
            _ => self.push(word),
        }
    }

    fn special(&mut self, byte: u8) {
        match byte {
            b'(' => self.comment(),
            b';' => {
                self.flags.set(BlockFlags::COMMENT);
                self.at = self.line_end();
            }
            b'%' if self.is_untouched() => {
                self.kind = Some(BlockKind::Percent);
                self.at = self.line_end();
            }
            b'/' => {
                self.flags.set(BlockFlags::DELETE);
                self.at += 1;
                if matches!(self.byte(self.at), b'1'..=b'9') && !self.byte(self.at + 1).is_ascii_digit() {
                    self.at += 1;
                }
            }
            // A byte order mark.
            0xef if self.number == 1
                && self.at == self.start
                && self.text[self.at..].starts_with(b"\xef\xbb\xbf") =>
            {
                self.at += 3;
            }
            _ => statement::special(self, byte),
        }
    }

    /// A comment. Behind an M code it may be its argument, `M202(0.0059)`: it stays with the code.
    fn comment(&mut self) {
        let start = self.at;
        let Ok(end) = comment_end(self.text, start) else {
            return self.fail_with(|text| DiagnosticCode::NestedComment { text }, start);
        };
        self.flags.set(BlockFlags::COMMENT);
        self.at = end;
        let (from, to) = (self.in_batch(start), self.in_batch(end));
        let is_closed = self.text.get(start..end).is_some_and(|comment| comment.ends_with(b")"));
        if let Some(word) = self.batch.words.get_mut(self.first_word..).and_then(<[Word]>::last_mut)
            && word.address == Address::M
            && word.end == from
            && is_closed
        {
            word.end = to;
        }
    }

    /// The byte at `at`, or a line end behind the text.
    #[inline]
    pub(super) fn byte(&self, at: usize) -> u8 {
        self.text.get(at).copied().unwrap_or(b'\n')
    }

    #[inline]
    fn in_batch(&self, at: usize) -> u32 {
        #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
        let position = at.wrapping_add(self.shift) as u32;
        position
    }

    /// Adds a word with a name in place of a number, which begins `lead` bytes behind `start`.
    pub(super) fn push_name(&mut self, address: Address, start: usize, lead: usize, end: usize) {
        self.push_odd(address, WordForm::Name, start, end, 0.0);
        if let Some(word) = self.batch.words.last_mut().filter(|_| self.kind.is_none()) {
            word.lead = u8::try_from(lead).unwrap_or(u8::MAX);
        }
    }

    /// Whether nothing but blanks and a block number stands before the present position.
    pub(super) fn opens(&self) -> bool {
        let words = self.batch.words.get(self.first_word..).unwrap_or_default();
        words.iter().all(|word| word.address == Address::N)
            && self.flags == BlockFlags::default()
            && self.kind.is_none()
    }

    /// Whether nothing but blanks has been read on this line.
    pub(super) fn is_untouched(&self) -> bool {
        self.batch.words.len() == self.first_word
            && self.flags == BlockFlags::default()
            && self.kind.is_none()
    }

    /// Where the line ending starts, from the present position on.
    pub(super) fn line_end(&self) -> usize {
        line::line_end(self.text, self.at)
    }

    /// Gives the line up: its words are dropped, the reason is kept.
    pub(super) fn fail(&mut self, code: DiagnosticCode, start: usize, end: usize) {
        let offset = self.batch.offset + u64::from(self.in_batch(start));
        self.batch.faults.push(Diagnostic {
            code,
            line: self.number,
            column: u32::try_from(start - self.start + 1).unwrap_or(u32::MAX),
            span: ByteSpan { start: offset, end: offset + (end - start) as u64 },
        });
        self.kind = Some(BlockKind::Malformed);
        self.batch.words.truncate(self.first_word);
        self.at = self.line_end();
    }

    /// Fails at `start` with the text from there on.
    pub(super) fn fail_with(&mut self, code: fn(Excerpt) -> DiagnosticCode, start: usize) {
        let end = self.line_end().max(start);
        self.fail(code(Excerpt::new(self.text.get(start..end).unwrap_or_default())), start, end);
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
            } else if self.flags.has(BlockFlags::COMMENT) {
                BlockKind::Comment
            } else if body.trim_ascii().is_empty() {
                BlockKind::Blank
            } else {
                // Control bytes, as old tapes and systems leave them: a block without words.
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
