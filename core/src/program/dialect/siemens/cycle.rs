//! `CYCLE81(RTP, RFP, SDIS, DP, DPR, …)`: cycles that make one hole, as words.

use super::constants::{NoNames, Walk};
use crate::program::dialect::line::Line;
use crate::program::number::MAX_MAGNITUDE;
use crate::program::plane::plain_number;
use crate::program::{Address, Keyword, Word, WordForm};

/// The number of decimals that is assumed for an argument.
const DECIMALS: u8 = 4;
/// The first arguments of every cycle: the retract plane, the surface, the clearance, the depth as a coordinate and the
/// depth below the surface.
const PLANES: [Address; 5] = [Address::R, Address::Q, Address::K, Address::I, Address::J];

/// What an argument after the first five may be, so that the hole is certain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// No motion depends on it, but perhaps for the way between the ends of a stroke.
    Free,
    /// Not stated, or 0.
    Zero,
    /// Not stated, 0 or 1.
    ZeroOrOne,
    Feed(Address),
    /// The pitch of a thread, and the speeds of the spindle down and up. The feed is their product.
    Pitch,
    Speed(Address),
    /// `_DMODE`: 0, or 1 to 3 for the planes G17 to G19.
    Plane,
    /// `_DMODE`, or `_AMODE` as some posts write it here: 10 says nothing of the depth.
    PlaneOrTen,
    /// `_AMODE`: its last digit says which of the two depths counts.
    Depth,
}

use Role::{Depth, Feed, Free, Pitch, Plane, PlaneOrTen, Speed, Zero, ZeroOrOne};

/// The arguments of a cycle after the first five; `None` for cycles that are not read.
const fn roles(number: u32) -> Option<&'static [Role]> {
    Some(match number {
        // DTB, _GMODE, _DMODE, _AMODE
        81 => &[Free, Zero, PlaneOrTen, Depth],
        82 | 89 => &[Free, Zero, Plane, Depth],
        // FDEP, FDPR, DAM, DTB, DTS, FRF, VARI, _AXN, _MDEP, _VRT, _DTD, _DIS1, _GMODE, _DMODE, _AMODE
        83 => &[
            Free, Free, Free, Free, Free, ZeroOrOne, ZeroOrOne, Zero, Free, Free, Free, Free, Zero, Plane,
            Depth,
        ],
        // DTB, SDAC, MPIT, PIT, POSS, SST, SST1
        84 => &[Free, Free, Free, Pitch, Free, Speed(Address::S), Speed(Address::L)],
        // DTB, SDR, SDAC, ENC, MPIT, PIT
        840 => &[Free, Free, Free, Free, Free, Free],
        // DTB, FFR, RFF, _GMODE, _DMODE, _AMODE
        85 => &[Free, Feed(Address::S), Feed(Address::L), Zero, Plane, Depth],
        // DTB, SDIR, RPA, RPO, RPAP, POSS, _GMODE, _DMODE, _AMODE
        86 => &[Free, Free, Zero, Zero, Zero, Free, Zero, Plane, Depth],
        // SDIR
        87 => &[Free],
        // DTB, SDIR
        88 => &[Free, Free],
        _ => return None,
    })
}

/// An argument between two bytes of the line, and its value if it is fixed.
#[derive(Debug, Clone, Copy)]
struct Argument {
    start: usize,
    end: usize,
    value: Option<f64>,
}

/// Adds a keyword, and after it the words of a cycle whose name stands between these two bytes. Returns whether the cycle
/// was read: otherwise nothing is added. If the cycle has to be `last`, nothing but a comment may follow it.
pub(super) fn hole(
    line: &mut Line<'_>,
    keyword: Keyword,
    start: usize,
    name_end: usize,
    number: u32,
    last: bool,
) -> bool {
    let Some(words) = read(line, name_end, number, last) else { return false };
    line.keyword(keyword, start, name_end);
    line.keyword(Keyword::Hole, name_end, name_end);
    line.push(Word {
        value: f64::from(number),
        start: line.in_batch(name_end),
        end: line.in_batch(name_end),
        address: Address::P,
        lead: 0,
        decimals: 0,
        form: WordForm::Number,
        has_point: false,
    });
    for (address, argument) in words {
        push(line, address, argument);
    }
    true
}

type Words = Vec<(Address, Argument)>;

/// The words of the arguments, in the order of the text.
fn read(line: &Line<'_>, from: usize, number: u32, last: bool) -> Option<Words> {
    let roles = roles(number)?;
    let arguments = arguments(line, from, PLANES.len() + roles.len(), last)?;
    let mut words = Words::new();
    let mut pitch = None;
    for (address, argument) in PLANES.into_iter().zip(&arguments) {
        words.extend(argument.map(|argument| (address, argument)));
    }
    for (role, argument) in roles.iter().zip(arguments.iter().skip(PLANES.len())) {
        let Some(argument) = *argument else { continue };
        let text = line.slice(argument.start, argument.end);
        let is = |wanted: &[f64]| {
            plain_number(text).is_some_and(|value| wanted.iter().any(|known| (value - known).abs() <= 0.0))
        };
        let is_certain = match role {
            Free => true,
            Pitch => {
                pitch = argument.value.map(f64::abs);
                true
            }
            Speed(address) => {
                let feed = pitch.zip(argument.value).map(|(pitch, speed)| pitch * speed);
                match feed.filter(|feed| *feed > 0.0 && *feed <= MAX_MAGNITUDE) {
                    Some(feed) => words.push((*address, Argument { value: Some(feed), ..argument })),
                    // A speed of 0 is as if it were missing. Without both speeds no feed is known.
                    None if argument.value == Some(0.0) => {}
                    None => words.retain(|(stated, _)| *stated != Address::S),
                }
                true
            }
            ZeroOrOne => is(&[0.0, 1.0]),
            Plane | PlaneOrTen if is(&[1.0, 2.0, 3.0]) => {
                words.push((Address::H, argument));
                true
            }
            Zero | Plane => is(&[0.0]),
            PlaneOrTen => is(&[0.0, 10.0]),
            Feed(address) => {
                words.push((*address, argument));
                true
            }
            Depth => {
                let other = other_depth(text)?;
                words.retain(|(address, _)| Some(*address) != other);
                true
            }
        };
        if !is_certain {
            return None;
        }
    }
    Some(words)
}

/// The depth that does not count by the last digit of `_AMODE`, if it says so: 1 takes the distance, 2 the coordinate.
/// `None` for a digit that is not known.
#[expect(clippy::option_option, reason = "no digit that is known, and a digit that leaves out no depth")]
fn other_depth(text: &[u8]) -> Option<Option<Address>> {
    let is_number = !text.is_empty() && text.iter().all(u8::is_ascii_digit);
    match text.last().filter(|_| is_number)? {
        b'0' => Some(None),
        b'1' => Some(Some(Address::I)),
        b'2' => Some(Some(Address::J)),
        _ => None,
    }
}

/// The arguments in brackets, each with its value if the text fixes it. `None` if there are more than `most`, or if they
/// cannot be read.
fn arguments(line: &Line<'_>, from: usize, most: usize, last: bool) -> Option<Vec<Option<Argument>>> {
    let open = line.blanks_end(from);
    if line.byte(open) != b'(' {
        return None;
    }
    let (mut list, mut at) = (Vec::new(), open + 1);
    loop {
        at = line.blanks_end(at);
        let mut argument = None;
        if !matches!(line.byte(at), b',' | b')') {
            let mut names = NoNames;
            let mut walk = Walk::new(line.text, at, &mut names);
            let value = walk.expression().ok()?.map(|number| number.value);
            if value.is_some_and(|value| value.abs() > MAX_MAGNITUDE) {
                return None;
            }
            argument = Some(Argument { start: at, end: walk.at, value });
            at = line.blanks_end(walk.at);
        }
        list.push(argument);
        match line.byte(at) {
            b',' if list.len() < most => at += 1,
            b')' => break,
            _ => return None,
        }
    }
    let next = line.byte(line.blanks_end(at + 1));
    (!last || matches!(next, b';' | b'\n' | b'\r')).then_some(list)
}

fn push(line: &mut Line<'_>, address: Address, argument: Argument) {
    let Argument { start, end, value } = argument;
    let word = Word {
        value: value.unwrap_or(0.0),
        start: line.in_batch(start),
        end: line.in_batch(end),
        address,
        lead: 0,
        decimals: if value.is_some() { DECIMALS } else { 0 },
        form: if value.is_some() { WordForm::Evaluated } else { WordForm::Expression },
        has_point: value.is_some(),
    };
    line.push(word);
}
