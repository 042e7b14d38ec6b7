//! Words as they are written: an address and a value.

use super::{Address, Code, Keyword};

/// How the value of a word is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WordForm {
    /// A plain number, in the modal sense of the block (G90 or G91).
    Number,
    /// A number that is absolute whatever the modal sense: `AC(…)`.
    Absolute,
    /// A number that counts from the position before whatever the modal sense: `IC(…)`, `IX+5`.
    Incremental,
    /// A plain number after a comma: `,R2`, `,C1`, `,A30`.
    Comma,
    /// An expression whose value is fixed at this block, in the modal sense of the block.
    Evaluated,
    /// An expression, parameter or function with an unknown value, which reads as 0.
    Expression,
    /// A name instead of a number: `T="BALL_10"`, `O<POCKET>`. The value reads as 0; the name is `Batch::name`.
    Name,
    /// A statement word, `TRAORI` or `FMAX`: address G, the value is the number of its [`Keyword`].
    Keyword,
}

/// One word of a block: address and value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Word {
    /// The value in the program's own unit: the f64 nearest to the written decimal. −0 reads as 0.
    pub value: f64,
    /// First byte of the word in the batch's text.
    pub start: u32,
    /// One after its last byte.
    pub end: u32,
    /// Its address.
    pub address: Address,
    /// Bytes from `start` to the beginning of the written value: 1 in `X10`, 2 in `X=10`, 0 for a bare number.
    pub lead: u8,
    /// Digits after the decimal point, as written.
    pub decimals: u8,
    /// How the value is written.
    pub form: WordForm,
    /// Whether a decimal point is written.
    pub has_point: bool,
}

impl Word {
    /// A statement word between two bytes of the batch's text.
    pub(super) fn of_keyword(keyword: Keyword, start: u32, end: u32) -> Self {
        Self {
            value: f64::from(keyword.number()),
            start,
            end,
            address: Address::G,
            lead: 0,
            decimals: 0,
            form: WordForm::Keyword,
            has_point: false,
        }
    }

    /// The statement word, if this is one.
    #[must_use]
    pub fn keyword(&self) -> Option<Keyword> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small whole number")]
        let number = self.value as u16;
        (self.form == WordForm::Keyword).then(|| Keyword::of_number(number)).flatten()
    }

    /// Whether its value is known: a number in any notation, and not a statement.
    #[must_use]
    pub const fn is_known(&self) -> bool {
        matches!(
            self.form,
            WordForm::Number | WordForm::Absolute | WordForm::Incremental | WordForm::Evaluated
        )
    }

    /// The word's code as a G word, an M word or a statement word; `None` for other words, and if its number is not a
    /// [code](Self::code_tenths).
    #[must_use]
    #[inline]
    pub fn code(&self) -> Option<Code> {
        if self.form == WordForm::Keyword {
            return self.keyword().map(Code::Keyword);
        }
        match self.address {
            Address::G => self.code_tenths().map(Code::G),
            Address::M => self.code_tenths().map(Code::M),
            _ => None,
        }
    }

    /// A G or M number in tenths (`G43.4` is 434, `M6` is 60); `None` if it is not a plain number, has more than one
    /// significant decimal, or is not below 100 000.
    #[must_use]
    pub fn code_tenths(&self) -> Option<u32> {
        let tenths = self.value * 10.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates; checked below"
        )]
        let whole = (tenths + 0.5) as u32;
        let is_code = self.form == WordForm::Number
            && whole < 1_000_000
            && (tenths - f64::from(whole)).abs() < 1e-6 * f64::from(whole.max(1));
        is_code.then_some(whole)
    }
}
