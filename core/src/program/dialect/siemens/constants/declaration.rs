//! `DEF` of a Sinumerik program, and lists of values.

use super::elements::Elements;
use super::expression::{Names, Number, Walk, operand_name_end};
use super::variables::{Kind, MAX_DIMENSIONS, Variable, key};

/// The most elements of one variable that are kept.
const MAX_VARIABLE: usize = 50_000;
/// Words between `DEF` and the name, each with a number after it: access rights, limits, units.
const WITH_NUMBER: [&[u8]; 9] = [b"APR", b"APW", b"APRP", b"APWP", b"APRB", b"APWB", b"APX", b"PHU", b"LLI"];
const LIMITS: [&[u8]; 2] = [b"LLI", b"ULI"];
/// Words between `DEF` and the type. They state the scope of the variable.
const SCOPES: [&[u8]; 8] = [b"NCK", b"CHAN", b"SYNR", b"SYNW", b"SYNRW", b"PHYS", b"INIPO", b"INIRE"];

/// The values after the `=` of an assignment.
#[derive(Debug, Clone)]
pub(super) enum Values {
    One(Option<Number>),
    /// `SET(…)` or a list in brackets. An empty place leaves its element unchanged.
    List(Vec<Element>),
    /// `REP(value)`, `REP(value, count)`.
    Repeated(Option<Number>, Option<usize>),
    /// Not known.
    Unknown,
}

/// The value that an element of an array gets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Element {
    Left,
    Value(Option<Number>),
}

impl Values {
    /// Whether this number of elements is enough for them.
    pub(super) fn fit(&self, room: usize) -> bool {
        match self {
            Self::One(_) => room >= 1,
            Self::List(list) => list.len() <= room,
            Self::Repeated(_, count) => count.is_none_or(|count| count <= room),
            Self::Unknown => false,
        }
    }
}

/// The values of a text that starts after `=`.
pub(super) fn values<N: Names>(text: &[u8], names: &mut N) -> Values {
    read_values(&mut Walk::new(text, 0, names), text)
}

fn read_values<N: Names>(walk: &mut Walk<'_, N>, text: &[u8]) -> Values {
    walk.skip_blanks();
    let start = walk.at;
    let end = operand_name_end(text, start);
    let name = text.get(start..end).unwrap_or_default();
    if name.eq_ignore_ascii_case(b"SET") || name.eq_ignore_ascii_case(b"REP") {
        walk.at = end;
        if walk.is_next(b'(') {
            let Some(list) = elements(walk) else { return Values::Unknown };
            return if name.eq_ignore_ascii_case(b"SET") { Values::List(list) } else { repeated(&list) };
        }
        walk.at = start;
    }
    if walk.is_next(b'(') {
        // One value in brackets, or a list of several.
        if let Ok(value) = walk.expression() {
            return Values::One(value);
        }
        walk.at = start;
        return elements(walk).map_or(Values::Unknown, Values::List);
    }
    walk.expression().map_or(Values::Unknown, Values::One)
}

fn repeated(list: &[Element]) -> Values {
    match *list {
        [Element::Value(value)] => Values::Repeated(value, None),
        [Element::Value(value), Element::Value(Some(count))] if count.is_whole && count.value >= 0.0 =>
        {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates; not negative"
            )]
            Values::Repeated(value, Some(count.value as usize))
        }
        _ => Values::Unknown,
    }
}

/// The elements of a list in round brackets. An empty element is left unchanged.
fn elements<N: Names>(walk: &mut Walk<'_, N>) -> Option<Vec<Element>> {
    let mut list = Vec::new();
    if !walk.take(b'(') {
        return None;
    }
    if walk.take(b')') {
        return Some(list);
    }
    loop {
        if list.len() >= MAX_VARIABLE {
            return None;
        }
        if walk.is_next(b',') || walk.is_next(b')') {
            list.push(Element::Left);
        } else {
            list.push(Element::Value(walk.expression().ok()?));
        }
        if walk.take(b',') {
            continue;
        }
        return walk.take(b')').then_some(list);
    }
}

/// The variables of a `DEF` block, from its `DEF` on. The list ends at text that cannot be read. `REDEF` declares
/// nothing.
pub(super) fn read<N: Names>(text: &[u8], names: &mut N) -> Vec<(Vec<u8>, Variable)> {
    let mut declared = Vec::new();
    let mut walk = Walk::new(text, operand_name_end(text, 0), names);
    let mut kind = None;
    while let Some(name) = next_name(&mut walk, text) {
        if let Some(found) = kind_of(&name) {
            kind = Some(found);
            // The length of a string.
            if name == b"STRING" && walk.is_next(b'[') && walk.list(b']').is_err() {
                return declared;
            }
        } else if SCOPES.contains(&&name[..]) && kind.is_none() {
        } else if WITH_NUMBER.contains(&&name[..]) || LIMITS.contains(&&name[..]) {
            if walk.operand().is_err() {
                return declared;
            }
        } else {
            let Some(kind) = kind else { return declared };
            let Some(variable) = variable(&mut walk, text, kind) else { return declared };
            declared.push((name, variable));
            if !walk.take(b',') {
                return declared;
            }
        }
    }
    declared
}

/// The next name, in upper case.
fn next_name<N: Names>(walk: &mut Walk<'_, N>, text: &[u8]) -> Option<Vec<u8>> {
    walk.skip_blanks();
    let end = operand_name_end(text, walk.at);
    let name = text.get(walk.at..end).filter(|name| !name.is_empty())?;
    walk.at = end;
    Some(key(name))
}

fn kind_of(name: &[u8]) -> Option<Kind> {
    match name {
        b"REAL" => Some(Kind::Real),
        b"INT" => Some(Kind::Whole),
        b"BOOL" => Some(Kind::Truth),
        b"CHAR" | b"STRING" | b"AXIS" | b"FRAME" => Some(Kind::Other),
        _ => None,
    }
}

/// The sizes and the values after the name of a variable. Numbers without a value are zero.
fn variable<N: Names>(walk: &mut Walk<'_, N>, text: &[u8], kind: Kind) -> Option<Variable> {
    let mut sizes = [1; MAX_DIMENSIONS];
    let mut dimensions = 0;
    if walk.is_next(b'[') {
        let list = walk.list(b']').ok()?;
        dimensions = list.count;
        if dimensions > MAX_DIMENSIONS {
            return None;
        }
        for (size, value) in sizes.iter_mut().zip(list.values()) {
            let value = value.filter(|number| number.is_whole && (1.0..1e6).contains(&number.value))?.value;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked range")]
            let whole = value as usize;
            *size = whole;
        }
    }
    let count = sizes.iter().try_fold(1_usize, |count, size| count.checked_mul(*size))?;
    let count = if count > MAX_VARIABLE { 0 } else { count };
    let zero = (kind != Kind::Other).then_some(0.0);
    let elements = Elements::new(count, zero);
    let mut variable = Variable { kind, sizes, dimensions, elements, is_declared: true };
    if walk.take_equals() {
        let values = read_values(walk, text);
        let is_one = matches!(values, Values::One(_));
        // One number for an array: in the manuals' example only REP gives it to all elements.
        if is_one == (dimensions == 0) {
            variable.take(0, &values, false);
        } else {
            variable.elements.fill(None);
        }
    }
    Some(variable)
}
