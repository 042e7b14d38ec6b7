//! Axes of which nobody knows where they stand, for the words of a refusal.

use std::fmt;

/// The letters of axes that are not known; at least one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnknownAxes {
    letters: [Option<char>; 5],
    first: char,
}

impl UnknownAxes {
    /// Those of these letters that stand nowhere known; `None` where all of them do.
    pub(in crate::process) fn of(letters: [char; 5], position: [Option<f64>; 5]) -> Option<Self> {
        let unknown: [Option<char>; 5] = std::array::from_fn(|k| position[k].is_none().then_some(letters[k]));
        // A rotary axis that is never named is what `start` is for most often.
        let first = unknown[3..].iter().chain(&unknown).flatten().next().copied()?;
        Some(Self { letters: unknown, first })
    }

    /// One of them, for an example.
    #[must_use]
    pub const fn first(&self) -> char {
        self.first
    }
}

impl fmt::Display for UnknownAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, letter) in self.letters.iter().flatten().enumerate() {
            write!(f, "{}{letter}", if index > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}
