//! `CIRCLE/`: the circle on which the next point is reached, as words.

use super::line::{rest, said};
use crate::program::dialect::line::Line;
use crate::program::dialect::number::{Number, Spelling, number};
use crate::program::{Address, BlockKind, Keyword, WordForm};

/// Centre, axis and radius in their order. The letters of the axis are none of an axis of the machine or a vector.
const NUMBERS: [Address; 7] =
    [Address::I, Address::J, Address::K, Address::P, Address::Q, Address::S, Address::R];
/// Centre and axis are needed.
const FEWEST: usize = 6;
/// After the radius come at most tolerance, its share inside, diameter and corner radius of the tool.
const MOST: usize = 11;

/// A number of the statement, and where it begins.
type Placed = (usize, Number);

/// `CIRCLE/x,y,z,i,j,k[,r[,t,f,d,e]][,TIMES,n]`. Its keyword stands alone if it has anything else.
pub(super) fn circle(scan: &mut Line<'_>, start: usize) -> BlockKind {
    let stated = stated(rest(scan, scan.at), scan.at);
    let kind = said(scan, Keyword::Circle, start);
    if let Some((numbers, turns)) = stated {
        for (address, (at, number)) in NUMBERS.into_iter().zip(numbers) {
            scan.number_word(address, WordForm::Number, at, 0, number);
        }
        if let Some((at, number)) = turns {
            scan.number_word(Address::H, WordForm::Number, at, 0, number);
        }
    }
    kind
}

/// The numbers of the circle, and the number of turns.
fn stated(body: &[u8], from: usize) -> Option<(Vec<Placed>, Option<Placed>)> {
    let slash = memchr::memchr(b'/', body)? + 1;
    if !body.get(..slash - 1)?.trim_ascii().is_empty() {
        return None;
    }
    let mut at = from + slash;
    let mut numbers = Vec::new();
    let mut turns = None;
    let list = body.get(slash..)?;
    let is_blank = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'$';
    let mut items = list.split(|byte| *byte == b',').peekable();
    while let Some(item) = items.next() {
        let blanks = item.iter().take_while(|byte| is_blank(byte)).count();
        let end = item.iter().rposition(|byte| !is_blank(byte)).map_or(blanks, |last| last + 1);
        let (place, text) = (at + blanks, item.get(blanks..end)?);
        at += item.len() + 1;
        if text.is_empty() && items.peek().is_none() {
            break;
        }
        if text.eq_ignore_ascii_case(b"TIMES") && numbers.len() >= FEWEST && turns.is_none() {
            let item = items.next()?;
            let blanks = item.iter().take_while(|byte| is_blank(byte)).count();
            let end = item.iter().rposition(|byte| !is_blank(byte))? + 1;
            turns = Some(placed(item.get(blanks..end)?, at + blanks)?);
            at += item.len() + 1;
            continue;
        }
        if turns.is_some() || numbers.len() == MOST {
            return None;
        }
        numbers.push(placed(text, place)?);
    }
    (numbers.len() >= FEWEST).then_some((numbers, turns))
}

fn placed(text: &[u8], at: usize) -> Option<Placed> {
    let read = number(text, 0, Spelling::Exponent).filter(|read| read.end == text.len())?;
    Some((at, Number { end: at + read.end, ..read }))
}
