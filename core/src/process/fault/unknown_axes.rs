//! Axes whose positions are not known, for the text of a refusal.

use std::fmt;

/// The letters of the axes whose positions are not known; at least one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnknownAxes {
    letters: [Option<char>; 5],
    first: char,
}

impl UnknownAxes {
    /// The axes whose position is missing; `None` if all are known.
    pub(in crate::process) fn of(letters: [char; 5], position: [Option<f64>; 5]) -> Option<Self> {
        let unknown: [Option<char>; 5] = std::array::from_fn(|k| position[k].is_none().then_some(letters[k]));
        // `start` is needed most often for a rotary axis that the program never names.
        let first = unknown[3..].iter().chain(&unknown).flatten().next().copied()?;
        Some(Self { letters: unknown, first })
    }

    /// One of the axes, for an example.
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
