//! The style of a block's words: blanks, columns, signs, points, case.

use super::NewWord;
use crate::program::decimal::{BUFFER, Look, print_into};
use crate::program::{Address, Batch, Block, Word, WordForm};

/// The style of one word.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setting<'a> {
    /// Blanks before the word.
    separator: &'a [u8],
    /// The text between the letter and the number: `=`, or nothing.
    mark: &'a [u8],
    /// Bytes from after the letter to the end of the number, and whether there are blanks among them.
    field: usize,
    has_gap: bool,
    lower: bool,
    look: Look,
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
        let fallback = Setting { separator: b" ", mark: b"", field: 0, has_gap: false, lower: false, look };
        let mut style = Self { batch, words, usual: fallback };
        let last = words.iter().rposition(|word| is_plain(&word) && word.address.is_coordinate());
        let model = last.or_else(|| words.iter().rposition(|word| is_plain(&word)));
        if let Some(index) = model {
            style.usual = style.setting_at(index);
            style.usual.look = Look { plus: style.usual.look.plus, ..look };
            if index == 0 && words.len() > 1 {
                style.usual.separator = style.separator_before(1);
            } else if index == 0 {
                style.usual.separator = b" ";
            }
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

    fn setting_at(&self, index: usize) -> Setting<'a> {
        let Some(word) = self.words.get(index) else { return self.usual };
        let text = self.batch.word_text(word);
        let number = text.get(usize::from(word.lead)..).unwrap_or_default();
        // The width of an expression is not that of a column.
        let is_plain = word.form == WordForm::Number;
        let sign = number.iter().find(|byte| !matches!(byte, b' ' | b'\t')).copied().unwrap_or_default();
        Setting {
            separator: self.separator_before(index),
            mark: self.mark(word),
            field: if is_plain { number.len() } else { 0 },
            has_gap: matches!(number.first(), Some(b' ' | b'\t')),
            lower: text.first().is_some_and(u8::is_ascii_lowercase),
            look: Look {
                drops_zero: self.batch.habits.drops_zero,
                ends_in_point: word.has_point,
                plus: (is_plain && sign == b'+') || self.always_signs(word.address),
            },
        }
    }

    /// The `=` after the letter of a word of one letter, with its blanks.
    fn mark(&self, word: &Word) -> &'a [u8] {
        let text = self.batch.word_text(word);
        let mark = text.get(1..usize::from(word.lead)).unwrap_or_default();
        let is_mark =
            self.batch.dialect.rules().writing.has_equals && mark.iter().all(|byte| b" \t=".contains(byte));
        if is_mark { mark } else { b"" }
    }

    /// Whether the program writes coordinates with their sign, also a plus.
    fn always_signs(&self, address: Address) -> bool {
        self.batch.dialect.rules().writing.keeps_plus
            && self.batch.habits.plus_signs
            && address.is_coordinate()
    }

    /// The style for a word of this address.
    fn setting(&self, address: Address) -> Setting<'a> {
        let same = |word: &Word| word.address == address && word.form == WordForm::Number;
        let found = self.words.iter().position(same).map(|index| Setting {
            separator: if index == 0 { self.usual.separator } else { self.separator_before(index) },
            ..self.setting_at(index)
        });
        // F does not take the plus sign that coordinates have.
        let plus = self.usual.look.plus && address.is_coordinate();
        found.unwrap_or(Setting { look: Look { plus, ..self.usual.look }, ..self.usual })
    }

    /// Appends a word of this name with the blanks before it.
    pub(in crate::program) fn print_named(&self, new: &NewWord, name: &[u8], out: &mut Vec<u8>) {
        let mut setting = self.setting(new.address);
        setting.look.plus =
            (setting.look.plus && new.address.is_coordinate()) || self.always_signs(new.address);
        out.extend_from_slice(setting.separator);
        if setting.lower {
            out.extend(name.iter().map(u8::to_ascii_lowercase));
        } else {
            out.extend_from_slice(name);
        }
        self.print_value(&setting, new, out);
    }

    /// Appends a number in the usual style of the block.
    pub(in crate::program) fn print_usual(&self, new: &NewWord, out: &mut Vec<u8>) {
        let setting = Setting { has_gap: false, ..self.usual };
        self.print_value(&setting, new, out);
    }

    /// The number, with a decimal comma if the program has decimal commas.
    fn print_value(&self, setting: &Setting<'_>, new: &NewWord, out: &mut Vec<u8>) {
        let from = out.len();
        print_field(setting, new, out);
        if self.batch.habits.decimal_comma {
            out.iter_mut().skip(from).filter(|byte| **byte == b'.').for_each(|byte| *byte = b',');
        }
    }

    /// Appends a number in place of the number of one of the block's own words.
    pub(in crate::program) fn print_number(&self, index: usize, new: &NewWord, out: &mut Vec<u8>) {
        self.print_value(&self.setting_at(index), new, out);
    }

    /// Appends a whole word, with the blanks before it unless it is the first of its block.
    pub(in crate::program) fn print_word(&self, new: &NewWord, letter: u8, first: bool, out: &mut Vec<u8>) {
        let setting = self.setting(new.address);
        if !first {
            out.extend_from_slice(setting.separator);
        }
        out.push(if setting.lower { letter.to_ascii_lowercase() } else { letter });
        out.extend_from_slice(setting.mark);
        self.print_value(&setting, new, out);
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

/// The number, right-aligned in its column if the program has columns.
#[inline]
fn print_field(setting: &Setting<'_>, new: &NewWord, out: &mut Vec<u8>) {
    let mut buffer = [0; BUFFER];
    let start = print_into(new.value, new.decimals, setting.look, &mut buffer);
    if setting.has_gap {
        let gap = setting.field.saturating_sub(BUFFER - start).clamp(1, BLANKS.len());
        out.extend_from_slice(&BLANKS[..gap]);
    }
    out.extend_from_slice(&buffer[start..]);
}
