//! `CYCLE/`: drilling cycles that state all their distances, as words.

use thiserror::Error;

use super::line::{Upper, has_minor, rest, said, without_comment};
use super::point::feed_unit;
use crate::program::dialect::line::Line;
use crate::program::dialect::number::{Number, Spelling, number};
use crate::program::{Address, BlockKind, Excerpt, Keyword, WordForm};

/// Why a cycle of cutter location data is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CycleUnread {
    /// Another cycle than drilling.
    #[error(
        "the cycle {0} is not followed; write its motions as GOTO, or drill with CYCLE/DRILL or CYCLE/DEEP"
    )]
    Kind(Excerpt),
    /// An item that is not known, stands twice, or has no number that is understood.
    #[error(
        "the item {0} of the cycle is not followed; remove it, or write the motions of the cycle as GOTO"
    )]
    Item(Excerpt),
    /// An item is missing.
    #[error("the cycle does not state {0}; add it, or write the motions of the cycle as GOTO")]
    Missing(&'static str),
    /// Pecks in a cycle without `DEEP`.
    #[error("the cycle states pecks, but it is not DEEP; write DEEP, or remove the pecks")]
    PecksWithoutDeep,
}

impl CycleUnread {
    /// Why the statement, which begins a cycle, is not read; `None` if it is read.
    #[must_use]
    pub fn of(statement: &[u8]) -> Option<Self> {
        let text = without_comment(statement).trim_ascii_start();
        let major = text.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let stated = stated(text.get(major..).unwrap_or_default(), 0);
        stated.and_then(|stated| stated.is_whole()).err()
    }
}

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
    let stated = stated(rest(scan, scan.at), scan.at);
    let kind = said(scan, Keyword::CycleOn, start);
    if let Ok(stated) = stated
        && stated.is_whole().is_ok()
    {
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
    fn is_whole(&self) -> Result<(), CycleUnread> {
        let needed = [
            (self.depth.is_some(), "the depth of the hole (FEDTO)"),
            (self.plane.is_some(), "the height from which it feeds (RAPTO)"),
            (self.retract.is_some(), "the height to which it retracts (RTRCTO)"),
            (self.feed.is_some(), "its feed (MMPM, IPM or another unit)"),
            (self.first_peck.is_some() || !self.is_deep, "its pecks (STEP)"),
        ];
        if let Some((_, what)) = needed.into_iter().find(|(is_stated, _)| !is_stated) {
            return Err(CycleUnread::Missing(what));
        }
        if (self.first_peck.is_some() || self.further_peck.is_some()) && !self.is_deep {
            return Err(CycleUnread::PecksWithoutDeep);
        }
        Ok(())
    }
}

/// The items of the statement in pairs, as `FEDTO,2.5`.
fn stated(body: &[u8], from: usize) -> Result<Stated, CycleUnread> {
    let mut items = items(body, from);
    let mut stated = Stated::default();
    let (_, name) = items.next().unwrap_or_default();
    stated.is_deep = is_deep(name);
    if !name.eq_ignore_ascii_case(b"DRILL") && !stated.is_deep {
        return Err(CycleUnread::Kind(Excerpt::new(name)));
    }
    while let Some((_, item)) = items.next() {
        if is_deep(item) && !stated.is_deep {
            stated.is_deep = true;
            continue;
        }
        let not_read = CycleUnread::Item(Excerpt::new(item));
        let (at, value) = items.next().ok_or(not_read)?;
        let read =
            number(value, 0, Spelling::Exponent).filter(|read| read.end == value.len()).ok_or(not_read)?;
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
                let unit = feed_unit(unit).ok_or(not_read)?;
                if stated.feed.replace((unit, placed)).is_some() {
                    return Err(not_read);
                }
                continue;
            }
        };
        if slot.replace(placed).is_some() {
            return Err(not_read);
        }
    }
    Ok(stated)
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
