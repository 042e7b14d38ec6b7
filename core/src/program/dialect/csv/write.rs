//! Rows of tables.

use crate::program::{Address, Batch, Block, NewWord};

/// A row of a table. Cells with a new word are written again, and the blanks before them are kept. Cells beyond the
/// columns of the table are kept. Missing cells stay missing unless a new value comes after them.
pub(super) fn print_row(
    batch: &Batch,
    block: &Block,
    new: &[NewWord],
    dropped: &[Address],
    _: bool,
    out: &mut Vec<u8>,
) {
    let body = batch.text.get(block.start as usize..block.body_end as usize).unwrap_or_default();
    if new.is_empty() && dropped.is_empty() {
        return out.extend_from_slice(body);
    }
    let mut cells = body.split(|&byte| byte == batch.separator).peekable();
    for (index, address) in batch.columns.iter().enumerate() {
        let later = batch.columns.get(index..).unwrap_or_default();
        if cells.peek().is_none()
            && !later.iter().any(|address| new.iter().any(|word| word.address == *address))
        {
            return;
        }
        if index > 0 {
            out.push(batch.separator);
        }
        let cell = cells.next().unwrap_or_default();
        match new.iter().find(|word| word.address == *address) {
            Some(word) => {
                let blanks = cell.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
                out.extend_from_slice(cell.get(..blanks).unwrap_or_default());
                crate::program::print_decimal(word.value, word.decimals, out);
            }
            None if dropped.contains(address) => {}
            None => out.extend_from_slice(cell),
        }
    }
    for cell in cells {
        out.push(batch.separator);
        out.extend_from_slice(cell);
    }
}
