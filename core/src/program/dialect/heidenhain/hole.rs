//! `CYCL DEF 200 …`: cycles that make one hole, as words; and the parameters by which they are changed later.

use crate::program::dialect::line::Line;
use crate::program::dialect::number::{Spelling, number};
use crate::program::number::MAX_MAGNITUDE;
use crate::program::{Address, Keyword, Word, WordForm};

/// The parameters of cycles that wait for their call.
const OF_CYCLES: std::ops::Range<u32> = 200..500;

/// What a parameter says of the hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// A word of this address.
    Is(Address),
    /// No motion depends on it, but perhaps for the way between the ends of a stroke.
    Free,
    /// With another value than 0 the motions are others.
    Zero,
    /// A number above 0.
    Positive,
}

use Role::{Free, Is, Positive, Zero};

/// The parameters that every cycle has: clearance, depth, surface, second clearance.
const LEVELS: [(u32, Role); 4] =
    [(200, Is(Address::K)), (201, Is(Address::J)), (203, Is(Address::Q)), (204, Is(Address::R))];
const FEED: (u32, Role) = (206, Is(Address::S));
const FEED_BACK: (u32, Role) = (208, Is(Address::L));
/// Dwells at the bottom and at the top.
const DWELL: (u32, Role) = (211, Free);
const DWELL_ABOVE: (u32, Role) = (210, Free);
/// The depth counts to the tip of the tool.
const TIP: (u32, Role) = (395, Zero);
const PECK: (u32, Role) = (202, Positive);

/// The further parameters that a cycle has to state, and those that it may state; `None` for cycles that are not read.
const fn parameters(cycle: u32) -> Option<[&'static [(u32, Role)]; 2]> {
    Some(match cycle {
        200 => [&[FEED, PECK], &[DWELL, DWELL_ABOVE, TIP]],
        201 => [&[FEED, FEED_BACK], &[DWELL]],
        // Q214: the tool moves aside before it goes up. Q336: the angle of the spindle.
        202 => [&[FEED, FEED_BACK, (214, Zero)], &[DWELL, (336, Free)]],
        // Q212, Q213, Q205: smaller pecks, breaks of chips, the least peck. Q256: how far it goes back for a break.
        203 => [
            &[FEED, FEED_BACK, PECK],
            &[DWELL, DWELL_ABOVE, (212, Free), (213, Free), (205, Free), (256, Free), TIP],
        ],
        // Q343: the depth follows from the diameter Q344. Q342 and Q253: a hole that is there already.
        240 => [&[FEED, (343, Zero)], &[DWELL, (344, Free), (342, Zero), (253, Free)]],
        206 => [&[FEED], &[DWELL]],
        207 => [&[(239, Free)], &[]],
        209 => [&[(239, Free)], &[(257, Free), (256, Free), (336, Free), (403, Free)]],
        _ => return None,
    })
}

/// A parameter of the statement between two bytes, with its value if that is a number.
#[derive(Debug, Clone, Copy)]
struct Stated {
    number: u32,
    start: usize,
    end: usize,
    value: Option<(f64, u8)>,
}

/// Adds the words of a cycle whose parameters stand after this byte. Returns whether it was read: otherwise nothing is
/// added.
pub(super) fn hole(scan: &mut Line<'_>, cycle: u32, start: usize, head: usize) -> bool {
    let Some(words) = words(scan, cycle, head) else { return false };
    scan.keyword(Keyword::Hole, start, head);
    let number = Stated { number: cycle, start: head, end: head, value: Some((f64::from(cycle), 0)) };
    push(scan, Address::P, number);
    for (address, stated) in words {
        push(scan, address, stated);
    }
    scan.skip_all();
    true
}

fn words(scan: &Line<'_>, cycle: u32, head: usize) -> Option<Vec<(Address, Stated)>> {
    let [needed, possible] = parameters(cycle)?;
    let stated = stated(scan, head)?;
    let mut words = Vec::new();
    let known = LEVELS.iter().chain(needed).map(|role| (role, true));
    let mut seen = 0;
    for ((parameter, role), is_needed) in known.chain(possible.iter().map(|role| (role, false))) {
        let mut same = stated.iter().filter(|stated| stated.number == *parameter);
        let Some(found) = same.next() else {
            if is_needed {
                return None;
            }
            continue;
        };
        if same.next().is_some() {
            return None;
        }
        seen += 1;
        match role {
            Is(address) => words.push((*address, *found)),
            Free => {}
            Zero if found.value.is_some_and(|(value, _)| value.abs() <= 0.0) => {}
            Positive if found.value.is_some_and(|(value, _)| value > 0.0) => {}
            Zero | Positive => return None,
        }
    }
    words.sort_by_key(|(_, stated)| stated.start);
    // A parameter that is not known may change the motions.
    (seen == stated.len()).then_some(words)
}

/// Every `Q200=+2` of the statement; `None` if a value is neither a number nor a parameter of the program.
fn stated(scan: &Line<'_>, head: usize) -> Option<Vec<Stated>> {
    let mut all = Vec::new();
    let text = scan.text.get(..scan.extent.body_end).unwrap_or_default();
    let mut at = head;
    while at < text.len() {
        let line_length = memchr::memchr2(b'\n', b'\r', text.get(at..)?).unwrap_or(text.len() - at);
        let line_end = at + line_length;
        let comment = memchr::memchr(b';', text.get(at..line_end)?).map_or(line_end, |length| at + length);
        let code = text.get(..comment)?;
        while let Some(equals) = memchr::memchr(b'=', code.get(at..)?) {
            let before = code.get(at..at + equals)?.trim_ascii_end();
            let digits = before.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
            let (name, number_text) = before.split_at(before.len() - digits);
            let is_parameter = matches!(name.last(), Some(b'Q' | b'q'));
            let parameter = std::str::from_utf8(number_text).ok()?.parse().ok().filter(|_| is_parameter)?;
            at += equals + 1;
            while matches!(code.get(at), Some(b' ' | b'\t')) {
                at += 1;
            }
            let (end, value) = value(code, at)?;
            let next = code.get(end..)?.trim_ascii_start().first();
            if !matches!(next, None | Some(b'~' | b'Q' | b'q')) {
                return None;
            }
            all.push(Stated { number: parameter, start: at, end, value });
            at = end;
        }
        at = line_end + 1;
    }
    Some(all)
}

/// Where a value ends, and the value of a number. It may also be a parameter that no cycle sets.
fn value(code: &[u8], at: usize) -> Option<(usize, Option<(f64, u8)>)> {
    if let Some(number) = number(code, at, Spelling::Comma) {
        let is_sound = number.value.abs() <= MAX_MAGNITUDE;
        return is_sound.then_some((number.end, Some((number.value, number.decimals))));
    }
    let name = at + usize::from(matches!(code.get(at), Some(b'+' | b'-')));
    if !matches!(code.get(name), Some(b'Q' | b'q')) {
        return None;
    }
    let is_local = matches!(code.get(name + 1), Some(b'L' | b'l' | b'R' | b'r'));
    let from = name + 1 + usize::from(is_local);
    let digits = code.get(from..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number: u32 = std::str::from_utf8(code.get(from..from + digits)?).ok()?.parse().ok()?;
    (is_local || !OF_CYCLES.contains(&number)).then_some((from + digits, None))
}

fn push(scan: &mut Line<'_>, address: Address, stated: Stated) {
    let Stated { start, end, value, .. } = stated;
    let word = Word {
        value: value.map_or(0.0, |(value, _)| value),
        start: scan.in_batch(start),
        end: scan.in_batch(end),
        address,
        lead: 0,
        decimals: value.map_or(0, |(_, decimals)| decimals),
        form: if value.is_some() { WordForm::Number } else { WordForm::Expression },
        has_point: false,
    };
    scan.push(word);
}

/// Whether an assignment names a parameter of cycles. It may change a cycle that is defined already.
pub(super) fn sets_cycle(text: &[u8]) -> bool {
    let code = text.split(|byte| *byte == b';').next().unwrap_or_default();
    code.iter().enumerate().any(|(at, byte)| {
        let rest = code.get(at + 1..).unwrap_or_default();
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let number = rest.get(..digits).and_then(|digits| std::str::from_utf8(digits).ok()?.parse().ok());
        byte.eq_ignore_ascii_case(&b'Q') && number.is_some_and(|number: u32| OF_CYCLES.contains(&number))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_of_cycles_are_found_wherever_an_assignment_names_them() {
        for (text, sets) in [
            ("Q201 = -5", true),
            ("FN 0: Q200 = +2", true),
            ("FN 18: SYSREAD Q203 = ID270", true),
            ("Q5 = 2 ; Q201", false),
            ("QL201 = 2", false),
            ("Q20 = 2 * Q199", false),
        ] {
            assert_eq!(sets_cycle(text.as_bytes()), sets, "{text}");
        }
    }
}
