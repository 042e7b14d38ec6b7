//! Blocks printed again with other values, and new blocks in the style of an old one.

mod body;
mod conversational;
mod cutter_location;
mod row;
mod style;

use self::body::{insert_block, print_body};
use self::cutter_location::{insert_point, print_point};
use self::row::print_row;
use super::batch::LineEnding;
use super::{Address, Batch, Block, Dialect, MAX_MAGNITUDE, Word, WriteFault};

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

/// M codes that act when the block's motion is done, in tenths.
const END_CODES: [u32; 8] = [0, 10, 20, 50, 90, 300, 600, 990];
/// M17, and RET: the end of a Sinumerik subprogram.
const END_OF_SUBPROGRAM: u32 = 170;
/// The exact stop at the end of one block, in tenths.
const EXACT_STOP: u32 = 90;

/// M codes of Heidenhain controls that act when the block's motion is done, in tenths.
const END_CODES_CONVERSATIONAL: [u32; 17] =
    [0, 10, 20, 50, 60, 90, 300, 890, 970, 990, 1110, 1170, 1270, 1290, 1370, 1450, 1490];

/// Whether a word acts when its block's motion is done.
fn acts_at_end(batch: &Batch, word: &Word) -> bool {
    match batch.dialect {
        Dialect::Heidenhain => {
            word.address == Address::M
                && word.code_tenths().is_some_and(|code| END_CODES_CONVERSATIONAL.contains(&code))
        }
        Dialect::Siemens if word.address == Address::M => {
            is_end_code(word) || word.code_tenths() == Some(END_OF_SUBPROGRAM)
        }
        _ => is_end_code(word),
    }
}

fn is_end_code(word: &Word) -> bool {
    match word.address {
        Address::M => word.code_tenths().is_some_and(|code| END_CODES.contains(&code)),
        Address::G => word.code_tenths() == Some(EXACT_STOP),
        _ => false,
    }
}

/// Appends the block of index `block` with these words in place of its own of the same address, all other bytes
/// kept; words the block does not have are added behind its last coordinate word in the block's own style.
///
/// `without_end_codes` says that more blocks made of this one follow: the words that act at the end of a block
/// (G9 M0 M1 M2 M5 M9 M30 M60 M99, M17 and RET) are left out, and a last line without an ending gets one.
///
/// # Errors
/// A value that cannot be printed, a word the table has no column for, no such block; nothing is appended.
pub fn print_changed(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    without_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    print_changed_without(batch, block, words, &[], without_end_codes, out)
}

/// The same, and without the words of these addresses that get no new value (in CSV: with their cells empty).
///
/// # Errors
/// A value that cannot be printed, a word the table has no column for, no such block; nothing is appended.
pub fn print_changed_without(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    dropped: &[Address],
    without_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    let source = checked(batch, block, words)?;
    match batch.dialect {
        Dialect::Csv => print_row(batch, source, words, dropped, out),
        Dialect::Apt => print_point(batch, source, words, dropped, out),
        Dialect::Iso | Dialect::Siemens | Dialect::Heidenhain => {
            print_body(batch, source, words, dropped, without_end_codes, out);
        }
    }
    if source.end > source.body_end || without_end_codes {
        print_line_ending(batch, source, out);
    }
    Ok(())
}

/// Appends a new block in the style of the block of index `block` (spacing with padded columns, letter case,
/// leading-zero habit, line ending): these words and no others; a word N is written as the source block has its own. With `with_end_codes` the source
/// block's words that act at its end follow. In CSV a whole row; a column without a word takes the source's cell.
///
/// The block always has a line ending, and starts on a line of its own.
///
/// # Errors
/// A value that cannot be printed, a word the table has no column for, no such block; nothing is appended.
pub fn print_inserted(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    with_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    print_inserted_without(batch, block, words, &[], with_end_codes, out)
}

/// The same; in CSV the cells of these addresses stay empty where they get no new value.
///
/// # Errors
/// A value that cannot be printed, a word the table has no column for, no such block; nothing is appended.
pub fn print_inserted_without(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    dropped: &[Address],
    with_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    let source = checked(batch, block, words)?;
    start_line(batch, out);
    match batch.dialect {
        Dialect::Csv => print_row(batch, source, words, dropped, out),
        Dialect::Apt => insert_point(batch, source, words, dropped, out),
        Dialect::Heidenhain => conversational::insert_block(batch, source, words, with_end_codes, out),
        Dialect::Iso | Dialect::Siemens => insert_block(batch, source, words, with_end_codes, out),
    }
    print_line_ending(batch, source, out);
    Ok(())
}

/// Appends a block that holds only this feed word, in the style of the block of index `block`.
///
/// # Errors
/// A value that cannot be printed, no such block, a CSV program; nothing is appended.
pub fn print_feed_only(
    batch: &Batch,
    block: usize,
    value: f64,
    decimals: u8,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    if batch.dialect == Dialect::Csv {
        return Err(WriteFault::NoFeedRow);
    }
    print_inserted(batch, block, &[NewWord { address: Address::F, value, decimals }], false, out)
}

fn checked<'a>(batch: &'a Batch, index: usize, words: &[NewWord]) -> Result<&'a Block, WriteFault> {
    let Some(block) = batch.blocks.get(index) else {
        return Err(WriteFault::NoBlock { index, blocks: batch.blocks.len() });
    };
    for word in words {
        let (address, value) = (word.address, word.value);
        // NaN is not in the range either.
        if !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&value) {
            return Err(WriteFault::NotPrintable { address, value, max_abs: MAX_MAGNITUDE });
        }
        let writable = match batch.dialect {
            Dialect::Iso => written_letter(address).is_some(),
            Dialect::Siemens | Dialect::Heidenhain | Dialect::Apt => true,
            Dialect::Csv => batch.columns.contains(&address),
        };
        if !writable {
            return Err(WriteFault::NoColumn { address });
        }
    }
    Ok(block)
}

/// The letter of a word: the tool axis of G43.5 is I J K.
fn written_letter(address: Address) -> Option<u8> {
    match address {
        Address::TI => Some(b'I'),
        Address::TJ => Some(b'J'),
        Address::TK => Some(b'K'),
        other => other.letter(),
    }
}

fn line_ending<'a>(batch: &'a Batch, block: &Block) -> &'a [u8] {
    match batch.text.get(block.body_end as usize..block.end as usize) {
        Some(ending) if !ending.is_empty() => ending,
        _ => batch.habits.line_ending.bytes(),
    }
}

fn print_line_ending(batch: &Batch, block: &Block, out: &mut Vec<u8>) {
    out.extend_from_slice(line_ending(batch, block));
}

/// Ends the line before, where it was the upload's last and had no ending.
fn start_line(batch: &Batch, out: &mut Vec<u8>) {
    if !matches!(out.last(), None | Some(b'\n' | b'\r')) {
        let ending: LineEnding = batch.habits.line_ending;
        out.extend_from_slice(ending.bytes());
    }
}
