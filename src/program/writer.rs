//! Blocks printed again with other values, and new blocks in the style of an old one.

use super::{Address, Batch, WriteFault};

/// A word to be written: what a control will read is [`super::round_to_decimals`] of the value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewWord {
    /// Its address.
    pub address: Address,
    /// Its value in the program's own unit.
    pub value: f64,
    /// Digits behind the point.
    pub decimals: u8,
}

/// Appends the block with these words in place of its own of the same address, all other bytes kept; words the
/// block does not have are added behind its last coordinate word in the block's own style. With
/// `without_end_codes` the M words that act at the end of a block (M0 M1 M2 M5 M9 M30 M60 M99) are left out.
/// A CSV row keeps its cells.
///
/// # Errors
/// A value that cannot be printed, a word the table has no column for, no such block; nothing is appended.
pub fn print_changed(
    _batch: &Batch,
    _block: usize,
    _words: &[NewWord],
    _without_end_codes: bool,
    _out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    Ok(())
}

/// Appends a new block in the style of the block of index `block` (spacing with padded columns, letter case,
/// leading-zero habit, line ending): these words and no others, no block number. With `with_end_codes` the source
/// block's M words that act at its end follow. In CSV a whole row; a column without a word takes the source's cell.
///
/// # Errors
/// A value that cannot be printed, a word the table has no column for, no such block; nothing is appended.
pub fn print_inserted(
    _batch: &Batch,
    _block: usize,
    _words: &[NewWord],
    _with_end_codes: bool,
    _out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    Ok(())
}

/// Appends a block that holds only this feed word, in the style of the block of index `block`; in CSV the source row
/// with this feed.
///
/// # Errors
/// As [`print_inserted`].
pub fn print_feed_only(
    _batch: &Batch,
    _block: usize,
    _value: f64,
    _decimals: u8,
    _out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    Ok(())
}
