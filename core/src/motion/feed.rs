//! Feed as the program gives it.

use super::FeedPaths;

/// How an F word is meant.
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
    /// In mm/min, 1/min or mm/rev by mode, inches converted; a control takes the same F as deg/min where only
    /// rotary axes move, and then inches do not matter: use `raw`. `None`: not given yet, or not known.
    /// In inverse time it is that of this block only.
    pub value: Option<f64>,
    /// The number as written, in program units; 0 where `value` is `None`.
    pub raw: f64,
    /// Digits behind the point of that number.
    pub decimals: u8,
    /// What it counts along where it is a speed.
    pub paths: FeedPaths,
    /// Whether the F word stands in the motion's own block.
    pub word_in_block: bool,
}
