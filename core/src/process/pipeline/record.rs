//! The changes of every motion, stored between two steps in single precision, which is finer than any control.

use std::io;
use std::io::{Read, Write};

use super::block_change::{BlockChange, BlockError, ErrorShares};
use crate::motion::MotionKind;

const KINDS: [MotionKind; 4] = [MotionKind::Rapid, MotionKind::Linear, MotionKind::Arc, MotionKind::Opaque];
const NUMBERS: usize = 10;
const BYTES: usize = 8 + 4 + 1 + 4 * NUMBERS;

/// Writes one record, without servo lag.
pub(in crate::process) fn put(change: &BlockChange, out: &mut dyn Write) -> io::Result<()> {
    let BlockError { before, after, axis_after_rad, .. } = change.error;
    let numbers: [f64; NUMBERS] = [
        change.location_errors_mm,
        change.axis_rad,
        change.wear_mm,
        change.cc_mm,
        before.interpolation_mm,
        before.location_errors_mm,
        before.wear_mm,
        after.interpolation_mm,
        after.rounding_mm,
        axis_after_rad,
    ];
    let mut bytes = [0; BYTES];
    let kind = KINDS.iter().position(|kind| *kind == change.kind).unwrap_or(0);
    let (head, tail) = bytes.split_at_mut(13);
    head[..8].copy_from_slice(&change.line.to_le_bytes());
    head[8..12].copy_from_slice(&change.blocks_out.to_le_bytes());
    head[12] = u8::try_from(kind).unwrap_or(0);
    for (number, place) in numbers.into_iter().zip(tail.chunks_exact_mut(4)) {
        #[expect(clippy::cast_possible_truncation, reason = "seven digits are enough here")]
        place.copy_from_slice(&(number as f32).to_le_bytes());
    }
    out.write_all(&bytes)
}

/// Reads one record; `None` at the end.
pub(in crate::process) fn take(input: &mut dyn Read) -> io::Result<Option<BlockChange>> {
    let mut bytes = [0; BYTES];
    if !fill(input, &mut bytes)? {
        return Ok(None);
    }
    let (head, tail) = bytes.split_at(13);
    let mut line = [0; 8];
    line.copy_from_slice(&head[..8]);
    let mut blocks = [0; 4];
    blocks.copy_from_slice(&head[8..12]);
    let mut numbers = [0.0; NUMBERS];
    for (number, place) in numbers.iter_mut().zip(tail.chunks_exact(4)) {
        let mut single = [0; 4];
        single.copy_from_slice(place);
        *number = f64::from(f32::from_le_bytes(single));
    }
    let [location_errors_mm, axis_rad, wear_mm, cc_mm, from, location, wear, to, rounding_mm, axis_after_rad] =
        numbers;
    let before = ErrorShares {
        interpolation_mm: from,
        location_errors_mm: location,
        wear_mm: wear,
        ..ErrorShares::default()
    };
    let after = ErrorShares { interpolation_mm: to, rounding_mm, ..ErrorShares::default() };
    Ok(Some(BlockChange {
        line: u64::from_le_bytes(line),
        kind: KINDS.get(usize::from(head[12])).copied().unwrap_or(MotionKind::Opaque),
        location_errors_mm,
        axis_rad,
        wear_mm,
        cc_mm,
        blocks_out: u32::from_le_bytes(blocks),
        error: BlockError { before, after, axis_before_rad: axis_rad, axis_after_rad },
    }))
}

/// Writes the largest contour error of a line.
pub(in crate::process) fn put_lag(line: u64, lag_mm: f64, out: &mut dyn Write) -> io::Result<()> {
    out.write_all(&line.to_le_bytes())?;
    #[expect(clippy::cast_possible_truncation, reason = "seven digits are enough here")]
    out.write_all(&(lag_mm as f32).to_le_bytes())
}

/// Reads one record; `None` at the end.
pub(in crate::process) fn take_lag(input: &mut dyn Read) -> io::Result<Option<(u64, f64)>> {
    let mut bytes = [0; 12];
    if !fill(input, &mut bytes)? {
        return Ok(None);
    }
    let (mut line, mut lag) = ([0; 8], [0; 4]);
    line.copy_from_slice(&bytes[..8]);
    lag.copy_from_slice(&bytes[8..]);
    Ok(Some((u64::from_le_bytes(line), f64::from(f32::from_le_bytes(lag)))))
}

/// Fills the buffer; false if nothing is left.
fn fill(input: &mut dyn Read, bytes: &mut [u8]) -> io::Result<bool> {
    let mut filled = 0;
    while filled < bytes.len() {
        match input.read(&mut bytes[filled..]) {
            Ok(0) if filled == 0 => return Ok(false),
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(count) => filled += count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_comes_back() {
        let mut change = BlockChange::none(1 << 40, MotionKind::Arc);
        (change.location_errors_mm, change.wear_mm, change.cc_mm) = (0.5, 0.25, 0.125);
        (change.axis_rad, change.blocks_out) = (0.001_953_125, 7);
        change.error.before.interpolation_mm = 0.0625;
        change.error.after.rounding_mm = 0.000_976_562_5;
        change.error.axis_before_rad = change.axis_rad;
        change.error.axis_after_rad = 0.000_030_517_578_125;
        let mut bytes = Vec::new();
        put(&change, &mut bytes).unwrap();
        put_lag(9, 0.5, &mut bytes).unwrap();
        assert_eq!(bytes.len(), BYTES + 12);
        let mut input = bytes.as_slice();
        assert_eq!(take(&mut input).unwrap(), Some(change));
        assert_eq!(take_lag(&mut input).unwrap(), Some((9, 0.5)));
        assert_eq!(take(&mut input).unwrap(), None);
        assert!(take(&mut &bytes[..20]).is_err());
    }
}
