//! Pages of a list, newest first.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Start of a page: before the row with this sequence number. Opaque to clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cursor(pub(super) i64);

/// The cursor did not come from this service.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("not a cursor of this list; use next_cursor of the previous page")]
pub struct CursorFault;

/// Hides the number, so that clients do not calculate with cursors.
const VEIL: u64 = 0x5bd1_e995_9e37_79b9;

impl fmt::Display for Cursor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0.cast_unsigned().rotate_left(29) ^ VEIL)
    }
}

impl FromStr for Cursor {
    type Err = CursorFault;

    fn from_str(text: &str) -> Result<Self, CursorFault> {
        if text.len() != 16
            || !text.bytes().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte))
        {
            return Err(CursorFault);
        }
        let veiled = u64::from_str_radix(text, 16).map_err(|_not_hex| CursorFault)?;
        let seq = (veiled ^ VEIL).rotate_right(29).cast_signed();
        // Sequence numbers start at 1 and stay far below 2^40.
        if (1..1 << 40).contains(&seq) { Ok(Self(seq)) } else { Err(CursorFault) }
    }
}

/// One page.
#[derive(Debug, Clone, PartialEq)]
pub struct Page<T> {
    /// The rows, newest first.
    pub items: Vec<T>,
    /// Start of the next page, if there is one.
    pub next: Option<Cursor>,
}

impl<T> Page<T> {
    /// A page of at most `limit` rows; `rows` contains one more if there is a next page.
    pub(super) fn cut(mut rows: Vec<(i64, T)>, limit: u32) -> Self {
        let limit = limit as usize;
        let more = rows.len() > limit;
        rows.truncate(limit);
        let next = if more { rows.last().map(|(seq, _)| Cursor(*seq)) } else { None };
        Self { items: rows.into_iter().map(|(_, row)| row).collect(), next }
    }
}
