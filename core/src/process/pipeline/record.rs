//! The changes of every motion, stored between two steps in single precision, which is finer than any control.

use std::io;
use std::io::{Read, Write};

use super::motion_change::{ErrorShares, MotionChange, MotionError};
use crate::motion::MotionKind;

const KINDS: [MotionKind; 4] = [MotionKind::Rapid, MotionKind::Linear, MotionKind::Arc, MotionKind::Opaque];
const NUMBERS: usize = 16;
const BYTES: usize = 8 + 4 + 1 + 4 * NUMBERS;

/// Writes one record.
pub(in crate::process) fn put(change: &MotionChange, out: &mut dyn Write) -> io::Result<()> {
    let &MotionChange { line, kind, location_errors_mm, axis_rad, wear_mm, cc_mm, blocks_out, error } =
        change;
    let MotionError { before, after, axis_before_rad, axis_after_rad } = error;
    let changes = [location_errors_mm, axis_rad, wear_mm, cc_mm];
    let numbers =
        changes.into_iter().chain(before.list()).chain(after.list()).chain([axis_before_rad, axis_after_rad]);
    let mut bytes = [0; BYTES];
    let kind = KINDS.iter().position(|known| *known == kind).unwrap_or(0);
    let (head, tail) = bytes.split_at_mut(13);
    head[..8].copy_from_slice(&line.to_le_bytes());
    head[8..12].copy_from_slice(&blocks_out.to_le_bytes());
    head[12] = u8::try_from(kind).unwrap_or(0);
    for (number, place) in numbers.zip(tail.chunks_exact_mut(4)) {
        #[expect(clippy::cast_possible_truncation, reason = "seven digits are enough here")]
        place.copy_from_slice(&(number as f32).to_le_bytes());
    }
    out.write_all(&bytes)
}

/// Reads one record; `None` at the end.
pub(in crate::process) fn take(input: &mut dyn Read) -> io::Result<Option<MotionChange>> {
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
    let [location_errors_mm, axis_rad, wear_mm, cc_mm, shares @ .., axis_before_rad, axis_after_rad] =
        numbers;
    let [b0, b1, b2, b3, b4, a0, a1, a2, a3, a4] = shares;
    let [before, after] = [[b0, b1, b2, b3, b4], [a0, a1, a2, a3, a4]].map(ErrorShares::of_list);
    Ok(Some(MotionChange {
        line: u64::from_le_bytes(line),
        kind: KINDS.get(usize::from(head[12])).copied().unwrap_or(MotionKind::Opaque),
        location_errors_mm,
        axis_rad,
        wear_mm,
        cc_mm,
        blocks_out: u32::from_le_bytes(blocks),
        error: MotionError { before, after, axis_before_rad, axis_after_rad },
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
        // Every member has another number, and all of them are exact in single precision.
        let shares = |first: f64| ErrorShares::of_list([0.0, 1.0, 2.0, 3.0, 4.0].map(|k| first + k));
        let change = MotionChange {
            line: 1 << 40,
            kind: MotionKind::Arc,
            location_errors_mm: 0.5,
            axis_rad: 0.001_953_125,
            wear_mm: 0.25,
            cc_mm: 0.125,
            blocks_out: 7,
            error: MotionError {
                before: shares(10.0),
                after: shares(20.0),
                axis_before_rad: 0.000_976_562_5,
                axis_after_rad: 0.000_030_517_578_125,
            },
        };
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
