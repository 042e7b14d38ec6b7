//! `CYCLE/`: drilling cycles that state all their distances, as words.

use super::line::{Upper, has_minor, rest, said};
use super::point::feed_unit;
use crate::program::dialect::line::Line;
use crate::program::dialect::number::{Number, Spelling, number};
use crate::program::{Address, BlockKind, Keyword, WordForm};

/// A number of the statement, and where it begins.
type Placed = (usize, Number);

/// What the statement says of a drilling cycle.
#[derive(Debug, Default)]
struct Stated {
    /// A name says that it drills in pecks.
    is_deep: bool,
    plane: Option<Placed>,
    depth: Option<Placed>,
    retract: Option<Placed>,
    first_peck: Option<Placed>,
    further_peck: Option<Placed>,
    feed: Option<(Keyword, Placed)>,
}

/// `CYCLE/OFF`, or the cycle of the points after it. Its keyword stands alone if the cycle is not read.
pub(super) fn cycle(scan: &mut Line<'_>, start: usize) -> BlockKind {
    if has_minor(scan, scan.at, b"OFF") {
        return said(scan, Keyword::CycleOff, start);
    }
    let stated = stated(scan);
    let kind = said(scan, Keyword::CycleOn, start);
    if let Some(stated) = stated.filter(Stated::is_whole) {
        let words = [
            (Address::R, stated.plane),
            (Address::D, stated.depth),
            (Address::Q, stated.retract),
            (Address::P, stated.first_peck),
            (Address::K, stated.further_peck),
            (Address::S, stated.feed.map(|(_, placed)| placed)),
            (Address::H, stated.feed.map(|(unit, (at, number))| (at, of_unit(unit, number.end)))),
        ];
        for (address, placed) in words {
            if let Some((at, number)) = placed {
                scan.number_word(address, WordForm::Number, at, 0, number);
            }
        }
    }
    kind
}

/// The unit of a feed as a number.
fn of_unit(unit: Keyword, end: usize) -> Number {
    Number::standing_for(f64::from(unit.number()), end)
}

impl Stated {
    /// Pecks have to be stated if the name says that there are some, and only then.
    fn is_whole(&self) -> bool {
        self.plane.is_some()
            && self.depth.is_some()
            && self.retract.is_some()
            && self.feed.is_some()
            && self.first_peck.is_some() == self.is_deep
            && (self.further_peck.is_none() || self.is_deep)
    }
}

/// The items of the statement in pairs, as `FEDTO,2.5`; `None` if one of them is not known or stands twice.
fn stated(scan: &Line<'_>) -> Option<Stated> {
    let body = rest(scan, scan.at);
    let mut items = items(body, scan.at);
    let mut stated = Stated::default();
    let name = |word: &[u8]| (word.eq_ignore_ascii_case(b"DRILL"), is_deep(word));
    let (drills, deep) = name(items.next()?.1);
    stated.is_deep = deep;
    if !drills && !deep {
        return None;
    }
    while let Some((_, item)) = items.next() {
        if is_deep(item) && !stated.is_deep {
            stated.is_deep = true;
            continue;
        }
        let (at, value) = items.next()?;
        let read = number(value, 0, Spelling::Exponent).filter(|read| read.end == value.len())?;
        let placed = (at, Number { end: at + read.end, ..read });
        let slot = match Upper::of(item).as_bytes() {
            b"RAPTO" => &mut stated.plane,
            b"FEDTO" => &mut stated.depth,
            b"RTRCTO" => &mut stated.retract,
            b"STEP" | b"1STPECK" => &mut stated.first_peck,
            b"SUBPECK" => &mut stated.further_peck,
            // A dwell is no motion, but a program without it is another one.
            b"DWELL" if read.value.abs() <= 0.0 => continue,
            unit => {
                let unit = feed_unit(unit)?;
                if stated.feed.replace((unit, placed)).is_some() {
                    return None;
                }
                continue;
            }
        };
        if slot.replace(placed).is_some() {
            return None;
        }
    }
    Some(stated)
}

fn is_deep(word: &[u8]) -> bool {
    word.eq_ignore_ascii_case(b"DEEP") || word.eq_ignore_ascii_case(b"DEEP2")
}

/// The items between slash, commas and line ends, with their places in the text.
fn items(body: &[u8], from: usize) -> impl Iterator<Item = (usize, &[u8])> {
    let is_between = |byte: &u8| matches!(byte, b',' | b'/' | b' ' | b'\t' | b'$' | b'\r' | b'\n');
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = body.get(at..)?;
        at += rest.iter().position(|byte| !is_between(byte))?;
        let rest = body.get(at..)?;
        let length = rest.iter().position(is_between).unwrap_or(rest.len());
        let found = (from + at, rest.get(..length)?);
        at += length;
        Some(found)
    })
}
