//! The codes of G words, M words and statement words, without their meaning.

use super::Keyword;
use std::fmt;

/// A code. Numbers count in tenths, because some have a decimal: `G1` is `G(10)`, `G43.4` is `G(434)`, `M30` is
/// `M(300)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// A G code \[tenths\].
    G(u32),
    /// An M code \[tenths\].
    M(u32),
    /// A statement word.
    Keyword(Keyword),
}

impl Code {
    /// The statement word, if the code is one.
    #[must_use]
    pub const fn keyword(self) -> Option<Keyword> {
        match self {
            Self::Keyword(keyword) => Some(keyword),
            Self::G(_) | Self::M(_) => None,
        }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (letter, tenths) = match *self {
            Self::G(tenths) => ('G', tenths),
            Self::M(tenths) => ('M', tenths),
            Self::Keyword(keyword) => return write!(f, "{keyword:?}"),
        };
        match tenths % 10 {
            0 => write!(f, "{letter}{}", tenths / 10),
            tenth => write!(f, "{letter}{}.{tenth}", tenths / 10),
        }
    }
}
