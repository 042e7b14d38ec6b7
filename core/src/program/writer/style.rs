//! The style of a block's words: blanks, columns, signs, points, case.

use super::NewWord;
use crate::program::decimal::{BUFFER, Look, print_into};
use crate::program::{Address, Batch, Block, Word, WordForm};

/// The style of the number of a word.
#[derive(Debug, Clone, Copy)]
struct NumberStyle {
    /// Bytes from after the letter to the end of the number, and whether there are blanks among them.
    field: usize,
    has_gap: bool,
    look: Look,
}

/// The style of one word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting<'a> {
    /// Blanks before the word.
    separator: &'a [u8],
    /// The text between the letter and the number: `=`, or nothing.
    mark: &'a [u8],
    lower: bool,
    number: NumberStyle,
}

const BLANKS: [u8; 64] = [b' '; 64];

/// The styles of a block's words.
#[derive(Debug, Clone, Copy)]
pub(in crate::program) struct Style<'a> {
    batch: &'a Batch,
    words: &'a [Word],
    /// For words that the block does not have.
    usual: Setting<'a>,
}

impl<'a> Style<'a> {
    pub(in crate::program) fn new(batch: &'a Batch, block: &Block) -> Self {
        let words = batch.words(block);
        let is_plain = |word: &&Word| word.form == WordForm::Number;
        let look =
            Look { drops_zero: batch.habits.drops_zero, ends_in_point: batch.habits.points, plus: false };
        let number = NumberStyle { field: 0, has_gap: false, look };
        let fallback = Setting { separator: b" ", mark: b"", lower: false, number };
        let mut style = Self { batch, words, usual: fallback };
        let last = words.iter().rposition(|word| is_plain(&word) && word.address.is_coordinate());
        let model = last.or_else(|| words.iter().rposition(|word| is_plain(&word)));
        if let Some((index, word)) = model.and_then(|index| Some((index, words.get(index)?))) {
            let separator = if index > 0 {
                style.separator_before(index)
            } else if words.len() > 1 {
                style.separator_before(1)
            } else {
                b" "
            };
            style.usual = style.setting_of(word, separator);
            style.usual.number.look = Look { plus: style.usual.number.look.plus, ..look };
        }
        style
    }

    /// The blanks between a word and the word before; one blank if other text is between them.
    fn separator_before(&self, index: usize) -> &'a [u8] {
        let (Some(before), Some(word)) =
            (index.checked_sub(1).and_then(|i| self.words.get(i)), self.words.get(index))
        else {
            return b" ";
        };
        let between = self.batch.text.get(before.end as usize..word.start as usize).unwrap_or_default();
        if between.iter().all(|byte| matches!(byte, b' ' | b'\t')) { between } else { b" " }
    }

    fn setting_of(&self, word: &Word, separator: &'a [u8]) -> Setting<'a> {
        let first = self.batch.text.get(word.start as usize).filter(|_| word.start < word.end);
        Setting {
            separator,
            mark: self.mark(word),
            lower: first.is_some_and(u8::is_ascii_lowercase),
            number: number_style(self.batch, word),
        }
    }

    /// The `=` after the letter of a word of one letter, with its blanks.
    fn mark(&self, word: &Word) -> &'a [u8] {
        if !self.batch.dialect.rules().writing.has_equals {
            return b"";
        }
        let text = self.batch.word_text(word);
        let mark = text.get(1..usize::from(word.lead)).unwrap_or_default();
        if mark.iter().all(|byte| b" \t=".contains(byte)) { mark } else { b"" }
    }

    /// The style for a word of this address.
    fn setting(&self, address: Address) -> Setting<'a> {
        let same = |word: &Word| word.address == address && word.form == WordForm::Number;
        let found = self.words.iter().position(same);
        if let Some((index, word)) = found.and_then(|index| Some((index, self.words.get(index)?))) {
            let separator = if index == 0 { self.usual.separator } else { self.separator_before(index) };
            return self.setting_of(word, separator);
        }
        let mut usual = self.usual;
        // F does not take the plus sign that coordinates have.
        usual.number.look.plus &= address.is_coordinate();
        usual
    }

    /// Appends a word of this name with the blanks before it.
    pub(in crate::program) fn print_named(&self, new: &NewWord, name: &[u8], out: &mut Vec<u8>) {
        let mut setting = self.setting(new.address);
        let look = &mut setting.number.look;
        look.plus = (look.plus && new.address.is_coordinate()) || always_signs(self.batch, new.address);
        push_few(setting.separator, out);
        if setting.lower {
            out.extend(name.iter().map(u8::to_ascii_lowercase));
        } else {
            out.extend_from_slice(name);
        }
        print_value(self.batch, setting.number, new, out);
    }

    /// Appends a number in the usual style of the block.
    pub(in crate::program) fn print_usual(&self, new: &NewWord, out: &mut Vec<u8>) {
        let number = NumberStyle { has_gap: false, ..self.usual.number };
        print_value(self.batch, number, new, out);
    }

    /// Appends a whole word, with the blanks before it unless it is the first of its block.
    pub(in crate::program) fn print_word(&self, new: &NewWord, letter: u8, first: bool, out: &mut Vec<u8>) {
        let setting = self.setting(new.address);
        if !first {
            push_few(setting.separator, out);
        }
        out.push(if setting.lower { letter.to_ascii_lowercase() } else { letter });
        push_few(setting.mark, out);
        print_value(self.batch, setting.number, new, out);
    }

    /// Appends a block number in the style of the source block: the same letter, and at least as many digits.
    pub(in crate::program) fn print_block_number(&self, new: &NewWord, out: &mut Vec<u8>) {
        let Some(own) = self.words.iter().find(|word| word.address == Address::N) else { return };
        let text = self.batch.word_text(own);
        let digits = text.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
        out.extend_from_slice(text.get(..text.len() - digits).unwrap_or_default());
        let mut buffer = [0; BUFFER];
        let start = print_into(new.value, 0, Look::default(), &mut buffer);
        let zeros = digits.saturating_sub(BUFFER - start);
        out.extend(std::iter::repeat_n(b'0', zeros));
        out.extend_from_slice(&buffer[start..]);
    }

    /// Appends a word of the source block unchanged.
    pub(in crate::program) fn print_same(&self, word: &Word, first: bool, out: &mut Vec<u8>) {
        if !first {
            out.extend_from_slice(self.usual.separator);
        }
        out.extend_from_slice(self.batch.word_text(word));
    }
}

/// Whether the program writes coordinates with their sign, also a plus.
fn always_signs(batch: &Batch, address: Address) -> bool {
    batch.habits.plus_signs && address.is_coordinate() && batch.dialect.rules().writing.keeps_plus
}

/// The styles of the plain numbers of a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlainLooks<'a> {
    text: &'a [u8],
    drops_zero: bool,
    /// Coordinates have their sign, also a plus.
    signs: bool,
}

impl<'a> PlainLooks<'a> {
    /// `None` if the program has decimal commas.
    #[inline]
    pub(super) fn of(batch: &'a Batch) -> Option<Self> {
        let signs = always_signs(batch, Address::X);
        let looks = Self { text: &batch.text, drops_zero: batch.habits.drops_zero, signs };
        (!batch.habits.decimal_comma).then_some(looks)
    }

    /// The style of this word; `None` if it is not a plain number, or if blanks are before the number.
    #[inline]
    pub(super) fn of_word(&self, word: &Word) -> Option<Look> {
        let first = *self.text.get(word.start as usize + usize::from(word.lead))?;
        let is_plain = word.form == WordForm::Number && !matches!(first, b' ' | b'\t');
        let plus = first == b'+' || (self.signs && word.address.is_coordinate());
        is_plain.then_some(Look { drops_zero: self.drops_zero, ends_in_point: word.has_point, plus })
    }
}

#[inline]
fn look(batch: &Batch, word: &Word, sign: u8) -> Look {
    Look {
        drops_zero: batch.habits.drops_zero,
        ends_in_point: word.has_point,
        // The sign of an expression is not that of its value.
        plus: (sign == b'+' && word.form == WordForm::Number) || always_signs(batch, word.address),
    }
}

fn number_style(batch: &Batch, word: &Word) -> NumberStyle {
    let start = word.start as usize + usize::from(word.lead);
    let number = batch.text.get(start..word.end as usize).unwrap_or_default();
    let first = number.first().copied().unwrap_or_default();
    let has_gap = matches!(first, b' ' | b'\t');
    let sign = number.iter().find(|byte| !matches!(byte, b' ' | b'\t')).copied();
    NumberStyle {
        // The width of an expression is not that of a column.
        field: if word.form == WordForm::Number { number.len() } else { 0 },
        has_gap,
        look: look(batch, word, sign.unwrap_or_default()),
    }
}

/// Appends a number in place of the number of one of the block's own words.
#[inline]
pub(in crate::program) fn print_number(batch: &Batch, word: &Word, new: &NewWord, out: &mut Vec<u8>) {
    print_value(batch, number_style(batch, word), new, out);
}

/// The number, with a decimal comma if the program has decimal commas.
#[inline]
fn print_value(batch: &Batch, style: NumberStyle, new: &NewWord, out: &mut Vec<u8>) {
    let from = out.len();
    print_field(style, new, out);
    if batch.habits.decimal_comma {
        out.iter_mut().skip(from).filter(|byte| **byte == b'.').for_each(|byte| *byte = b',');
    }
}

/// The number, right-aligned in its column if the program has columns.
#[inline]
fn print_field(style: NumberStyle, new: &NewWord, out: &mut Vec<u8>) {
    let mut buffer = [0; BUFFER];
    let start = print_into(new.value, new.decimals, style.look, &mut buffer);
    if style.has_gap {
        let gap = style.field.saturating_sub(BUFFER - start).clamp(1, BLANKS.len());
        out.extend_from_slice(&BLANKS[..gap]);
    }
    out.extend_from_slice(&buffer[start..]);
}

/// Appends a text that nearly always has one byte or none.
#[inline]
fn push_few(text: &[u8], out: &mut Vec<u8>) {
    match text {
        [] => {}
        [byte] => out.push(*byte),
        more => out.extend_from_slice(more),
    }
}
