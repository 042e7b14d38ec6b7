//! Blocks printed again with other values, and new blocks in the style of an old one.

mod body;
mod numbers;
mod style;

use self::body::{insert_block, print_body};
pub(super) use self::style::{Style, print_number};
use super::batch::LineEnding;
use super::{Address, Batch, Block, Code, MAX_MAGNITUDE, Word, WriteFault};

/// A word to be written. A control reads [`super::round_to_decimals`] of its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewWord {
    /// Its address.
    pub address: Address,
    /// Its value in the program's own unit.
    pub value: f64,
    /// Digits after the point.
    pub decimals: u8,
}

/// Appends a block, or its text, again. The first arguments are the source, the words to be written, and the addresses
/// whose words are left out. The flag acts on the codes that take effect at a block's end: a block that is printed
/// again leaves them out, and a new block takes them along.
pub(super) type Print = fn(&Batch, &Block, &[NewWord], &[Address], bool, &mut Vec<u8>);

/// The index of the word of a block after which another word goes.
type Anchor = fn(&[Word]) -> Option<usize>;

/// How a dialect is written, where dialects differ.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent habits of dialects")]
pub(super) struct Writing {
    /// Codes that act after the block's motion has ended.
    pub(super) end_codes: &'static [&'static [Code]],
    /// Names of words that are not a letter, up to their values.
    pub(super) names: &'static [(Address, &'static [u8])],
    /// `=` may be between a letter and its number, and it stays there.
    pub(super) has_equals: bool,
    /// Coordinates have their sign, also a plus, if the program writes them so.
    pub(super) keeps_plus: bool,
    /// Words of every address can be written, not only letters.
    pub(super) any_address: bool,
    /// Blocks are rows of a table. Only its columns are written, and no block can hold only a feed.
    pub(super) has_rows: bool,
    /// The word after which a new feed word goes; `None`: the feed goes with all other new words.
    pub(super) feed_anchor: Option<Anchor>,
    /// Prints a block again.
    pub(super) change: Print,
    /// Prints a new block in the style of an old one.
    pub(super) insert: Print,
}

impl Writing {
    /// Letters and numbers.
    pub(super) const LETTERS: Self = Self {
        end_codes: &[END_CODES],
        names: &[],
        has_equals: false,
        keeps_plus: false,
        any_address: false,
        has_rows: false,
        feed_anchor: None,
        change: print_body,
        insert: insert_block,
    };
}

/// G9, and the M codes that act after the block's motion has ended.
pub(super) const END_CODES: &[Code] = &[
    Code::G(90),
    Code::M(0),
    Code::M(10),
    Code::M(20),
    Code::M(50),
    Code::M(90),
    Code::M(300),
    Code::M(600),
    Code::M(990),
];

/// Whether a word acts after its block's motion has ended.
pub(super) fn acts_at_end(batch: &Batch, word: &Word) -> bool {
    matches!(word.address, Address::G | Address::M)
        && word.code().is_some_and(|code| {
            batch.dialect.rules().writing.end_codes.iter().any(|codes| codes.contains(&code))
        })
}

/// Appends the block of index `block` with these words instead of its own words of the same addresses. All other bytes
/// are kept. Words that the block does not have are added after its last coordinate word, in the block's own style.
///
/// `without_end_codes` says that more blocks made from this one follow. The words that act at the end of a block are
/// then left out (G9 M0 M1 M2 M5 M9 M30 M60 M99, M17 and RET). A last line without an ending gets one.
///
/// # Errors
/// A value cannot be printed, the table has no column for a word, or there is no such block. Nothing is appended then.
pub fn print_changed(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    without_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    print_changed_without(batch, block, words, &[], without_end_codes, out)
}

/// The same, but without the words of these addresses if they get no new value (in CSV: with empty cells).
///
/// # Errors
/// A value cannot be printed, the table has no column for a word, or there is no such block. Nothing is appended then.
pub fn print_changed_without(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    dropped: &[Address],
    without_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    let source = checked(batch, block, words)?;
    (batch.dialect.rules().writing.change)(batch, source, words, dropped, without_end_codes, out);
    if source.end > source.body_end || without_end_codes {
        print_line_ending(batch, source, out);
    }
    Ok(())
}

/// Appends a new block with only these words, in the style of the block of index `block`: spacing with padded columns,
/// letter case, habit of leading zeros, line ending. A word N is written as in the source block. With `with_end_codes`
/// the source block's words that act at its end follow. In CSV the block is a whole row, and a column without a word
/// takes the source's cell.
///
/// The block always has a line ending and starts on a separate line.
///
/// # Errors
/// A value cannot be printed, the table has no column for a word, or there is no such block. Nothing is appended then.
pub fn print_inserted(
    batch: &Batch,
    block: usize,
    words: &[NewWord],
    with_end_codes: bool,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    print_inserted_without(batch, block, words, &[], with_end_codes, out)
}

/// The same. In CSV the cells of these addresses stay empty if they get no new value.
///
/// # Errors
/// A value cannot be printed, the table has no column for a word, or there is no such block. Nothing is appended then.
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
    (batch.dialect.rules().writing.insert)(batch, source, words, dropped, with_end_codes, out);
    print_line_ending(batch, source, out);
    Ok(())
}

/// Appends a block with only this feed word, in the style of the block of index `block`.
///
/// # Errors
/// A value cannot be printed, there is no such block, or the program is CSV. Nothing is appended then.
pub fn print_feed_only(
    batch: &Batch,
    block: usize,
    value: f64,
    decimals: u8,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    if batch.dialect.rules().writing.has_rows {
        return Err(WriteFault::NoFeedRow);
    }
    print_inserted(batch, block, &[NewWord { address: Address::F, value, decimals }], false, out)
}

fn checked<'a>(batch: &'a Batch, index: usize, words: &[NewWord]) -> Result<&'a Block, WriteFault> {
    let Some(block) = batch.blocks.get(index) else {
        return Err(WriteFault::NoBlock { index, blocks: batch.blocks.len() });
    };
    let writing = &batch.dialect.rules().writing;
    for word in words {
        let (address, value) = (word.address, word.value);
        // NaN is outside the range, too.
        if !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&value) {
            return Err(WriteFault::NotPrintable { address, value, max_abs: MAX_MAGNITUDE });
        }
        let writable = if writing.has_rows {
            batch.columns.contains(&address)
        } else {
            writing.any_address || has_letter(address)
        };
        if !writable {
            return Err(WriteFault::NoColumn { address });
        }
    }
    Ok(block)
}

/// Whether [`written_letter`] gives a letter: all but the components of normals have one.
const fn has_letter(address: Address) -> bool {
    address.bit() & (Address::NX.bit() | Address::NY.bit() | Address::NZ.bit()) == 0
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

pub(super) fn line_ending<'a>(batch: &'a Batch, block: &Block) -> &'a [u8] {
    match batch.text.get(block.body_end as usize..block.end as usize) {
        Some(ending) if !ending.is_empty() => ending,
        _ => batch.habits.line_ending.bytes(),
    }
}

fn print_line_ending(batch: &Batch, block: &Block, out: &mut Vec<u8>) {
    match line_ending(batch, block) {
        [byte] => out.push(*byte),
        ending => out.extend_from_slice(ending),
    }
}

/// Ends the line before, if it was the upload's last line and had no ending.
fn start_line(batch: &Batch, out: &mut Vec<u8>) {
    if !matches!(out.last(), None | Some(b'\n' | b'\r')) {
        let ending: LineEnding = batch.habits.line_ending;
        out.extend_from_slice(ending.bytes());
    }
}
