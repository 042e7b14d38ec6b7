//! `PLANE SPATIAL SPA… SPB… SPC… TURN`, `PLANE VECTOR BX… BY… BZ… NX… NY… NZ… TURN`.

use crate::program::dialect::rules::without_comment;
use crate::program::plane::{
    FreeAxisWord, PlaneDirections, PlaneStatement, PlaneTurning, StatedSide, plain_number,
};
use crate::program::{Batch, Block};

/// The words of spatial angles, in their order in the statement's result.
const ANGLES: [&[u8]; 3] = [b"SPA", b"SPB", b"SPC"];
/// The words of vectors.
const VECTORS: [&[u8]; 6] = [b"BX", b"BY", b"BZ", b"NX", b"NY", b"NZ"];

/// The plane of a statement with numbers. Angles and vectors count from the plane that is not tilted.
///
/// The directions are turned about the axes that do not move: about X by SPA, then about Y by SPB, then about Z by
/// SPC. This is the same as turns about the turned axes in the opposite order.
pub(super) fn read(batch: &Batch, block: &Block) -> Option<PlaneStatement> {
    let text = without_comment(batch.block_text(block), b";~");
    let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).peekable();
    words.next_if(|word| word.iter().all(u8::is_ascii_digit));
    words.next_if(|word| word.eq_ignore_ascii_case(b"PLANE"))?;
    let kind = words.next()?.to_ascii_uppercase();
    let names: &[&[u8]] = match kind.as_slice() {
        b"SPATIAL" => &ANGLES,
        b"VECTOR" => &VECTORS,
        _ => return None,
    };
    let mut values = [None; 6];
    let (mut turning, mut side, mut free_axis) = (None, None, None);
    while let Some(word) = words.next() {
        let word = word.to_ascii_uppercase();
        let turn_to = |word: &[u8]| word.eq_ignore_ascii_case(b"ROT").then_some(());
        let is_repeated = match word.as_slice() {
            b"TURN" | b"MOVE" => turning.replace(PlaneTurning::Here).is_some(),
            b"STAY" => turning.replace(PlaneTurning::Elsewhere).is_some(),
            b"SEQ+" => side.replace(StatedSide { positive: true, or_other: false }).is_some(),
            b"SEQ-" => side.replace(StatedSide { positive: false, or_other: false }).is_some(),
            b"COORD" => {
                turn_to(words.next()?)?;
                free_axis.replace(FreeAxisWord::Stays).is_some()
            }
            b"TABLE" => {
                turn_to(words.next()?)?;
                free_axis.replace(FreeAxisWord::Turns).is_some()
            }
            b"FMAX" | b"FAUTO" => false,
            _ => match names.iter().position(|name| word.starts_with(name)) {
                Some(index) => {
                    let value = plain_number(word.get(names[index].len()..)?)?;
                    values.get_mut(index)?.replace(value).is_some()
                }
                // The feed of the turn, and the distance of its centre from the tip.
                None if word.starts_with(b"DIST") => plain_number(word.get(4..)?).is_none(),
                None if word.starts_with(b"F") => plain_number(word.get(1..)?).is_none(),
                None => true,
            },
        };
        if is_repeated {
            return None;
        }
    }
    let directions = match (names.len(), values) {
        (3, [a, b, c, ..]) => PlaneDirections::Turns([(2, c?), (1, b?), (0, a?)]),
        (_, [x, y, z, i, j, k]) => PlaneDirections::Axes { x: [x?, y?, z?], normal: [i?, j?, k?] },
    };
    Some(PlaneStatement {
        zero: [0.0; 3],
        directions,
        shift: [0.0; 3],
        counts_in_unit: true,
        replaces: true,
        turning: turning?,
        side,
        free_axis,
    })
}
