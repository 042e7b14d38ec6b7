//! `CYCLE800(_FR, _TC, _ST, _MODE, _X0, _Y0, _Z0, _A, _B, _C, _X1, _Y1, _Z1, _DIR, _FR_I, _DMODE)`.

use crate::program::dialect::rules::without_comment;
use crate::program::plane::{PlaneDirections, PlaneStatement, PlaneTurning, StatedSide, plain_number};
use crate::program::{Batch, Block};

/// The most arguments that are understood.
const MOST: usize = 16;
/// Places in the list of arguments.
const RETRACT: usize = 0;
const DATA_SET: usize = 1;
const STATE: usize = 2;
const MODE: usize = 3;
const ZERO: usize = 4;
const ANGLES: usize = 7;
const SHIFT: usize = 10;
const DIRECTION: usize = 13;
const RETRACT_BY: usize = 14;
const PLANE: usize = 15;

/// The plane of a cycle whose arguments are numbers: a new plane (`_ST` 0), turned axis by axis, with a direction for
/// the rotary axes (`_DIR` 1 or −1).
///
/// `_MODE` names the axes in pairs of bits from the lowest on, 1 X, 2 Y, 3 Z. `_A`, `_B` and `_C` are the angles of the
/// first, second and third of them, each about the turned axes. The zero moves by `_X0 _Y0 _Z0` before and by `_X1 _Y1
/// _Z1` after the turns.
pub(super) fn read(batch: &Batch, block: &Block) -> Option<PlaneStatement> {
    let text = without_comment(batch.block_text(block), b";");
    let open = memchr::memchr(b'(', text)?;
    let (head, rest) = (text.get(..open)?.trim_ascii(), text.get(open + 1..)?);
    let is_alone = head.len() >= 8
        && head.get(head.len() - 8..)?.eq_ignore_ascii_case(b"CYCLE800")
        && is_block_number(head.get(..head.len() - 8)?.trim_ascii());
    let mut list = rest.trim_ascii_end().strip_suffix(b")").filter(|_| is_alone)?;
    let mut arguments = [&b""[..]; MOST];
    let mut count = 0;
    loop {
        let end = end_of_argument(list)?;
        *arguments.get_mut(count)? = list.get(..end)?.trim_ascii();
        count += 1;
        match list.get(end + 1..) {
            Some(behind) => list = behind,
            None => break,
        }
    }
    let number = |index: usize| match *arguments.get(index)? {
        b"" => Some(0.0),
        text => plain_number(text),
    };
    let is_named = matches!(arguments[DATA_SET], [b'"', name @ .., b'"'] if name != b"0");
    let numbers = |from: usize| Some([number(from)?, number(from + 1)?, number(from + 2)?]);
    let whole = |index: usize| match *arguments.get(index)? {
        b"" => Some(0),
        text => std::str::from_utf8(text).ok()?.parse::<i32>().ok(),
    };
    if !is_named || whole(STATE)? != 0 || !matches!(whole(PLANE)?, 0 | 1) {
        return None;
    }
    // How far the tool retracts does not matter after it.
    whole(RETRACT).zip(number(RETRACT_BY))?;
    let [first, second, third] = axes(whole(MODE)?)?;
    let [a, b, c] = numbers(ANGLES)?;
    let direction = whole(DIRECTION)?;
    let turns = matches!(direction, -1 | 1);
    Some(PlaneStatement {
        zero: numbers(ZERO)?,
        directions: PlaneDirections::Turns([(first, a), (second, b), (third, c)]),
        shift: numbers(SHIFT)?,
        counts_in_unit: false,
        replaces: true,
        turning: if turns { PlaneTurning::Here } else { PlaneTurning::Elsewhere },
        side: turns.then_some(StatedSide { positive: direction > 0, or_other: true }),
        free_axis: None,
    })
}

/// The axes of the turns, if the mode is axis by axis and each axis turns once.
fn axes(mode: i32) -> Option<[usize; 3]> {
    let mode = u8::try_from(mode).ok().filter(|mode| *mode < 64)?;
    let axes = [0, 2, 4].map(|bit| usize::from((mode >> bit) & 3));
    let mut sorted = axes;
    sorted.sort_unstable();
    (sorted == [1, 2, 3]).then(|| axes.map(|axis| axis - 1))
}

/// Where the first argument of a list ends: at a comma outside a text, or at the end. `None` if a text is open, or if
/// there are brackets.
fn end_of_argument(list: &[u8]) -> Option<usize> {
    let mut is_text = false;
    for (at, byte) in list.iter().enumerate() {
        match byte {
            b'"' => is_text = !is_text,
            b',' if !is_text => return Some(at),
            b'(' | b')' | b'[' | b']' if !is_text => return None,
            _ => {}
        }
    }
    (!is_text).then_some(list.len())
}

/// `N120`, or nothing.
fn is_block_number(text: &[u8]) -> bool {
    match text {
        [] => true,
        [b'N' | b'n', digits @ ..] => !digits.is_empty() && digits.iter().all(u8::is_ascii_digit),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_are_pairs_of_bits_from_the_lowest_on() {
        let rows = [
            (57, Some([0, 1, 2])),
            (45, Some([0, 2, 1])),
            (54, Some([1, 0, 2])),
            (30, Some([1, 2, 0])),
            (39, Some([2, 0, 1])),
            (27, Some([2, 1, 0])),
            (0, None),
            (21, None),
            (121, None),
            (192, None),
            (-57, None),
        ];
        for (mode, expected) in rows {
            assert_eq!(axes(mode), expected, "{mode}");
        }
    }
}
