//! Feed as the program gives it.

use super::FeedPaths;

/// The meaning of an F word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedMode {
    /// G94: length (or degrees) per minute.
    PerMinute,
    /// G93: one over the minutes the block takes.
    InverseTime,
    /// G95: length per spindle turn.
    PerRevolution,
}

/// The feed of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feed {
    /// `None`: unknown, after a call.
    pub mode: Option<FeedMode>,
    /// In mm/min, 1/min or mm/rev by mode, with inches converted. If only rotary axes move, a control takes the same F
    /// as deg/min. Inches do not matter then: use `raw`. `None`: not given yet, or not known. In inverse time the
    /// value is that of this block only.
    pub value: Option<f64>,
    /// The number as written, in program units; 0 where `value` is `None`.
    pub raw: f64,
    /// Digits after the decimal point of that number.
    pub decimals: u8,
    /// The path along which it counts if it is a speed.
    pub paths: FeedPaths,
    /// Whether the F word is in the motion's own block.
    pub word_in_block: bool,
}

impl Feed {
    /// The same without a number: the control feeds by something that the text does not state.
    pub(super) fn unknown(self) -> Self {
        Self { value: None, raw: 0.0, decimals: 0, ..self }
    }
}
