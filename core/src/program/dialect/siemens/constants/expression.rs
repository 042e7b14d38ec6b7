//! Expressions of the Sinumerik: operands, operators by priority, functions. The same walk finds the end of an
//! expression (for the reader) and its value (for the variables).

use super::functions::function;
use super::operators::{binary, operator};
use crate::program::number::{exponent_at, read_unsigned};

/// Deeper nesting of brackets and signs is not read.
pub(in crate::program) const MAX_DEPTH: u8 = 40;
/// The most arguments or subscripts that are examined. The ones after them are skipped.
pub(super) const MAX_ARGUMENTS: usize = 8;

/// A value that follows from the text alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::program) struct Number {
    pub(in crate::program) value: f64,
    /// INT or BOOL, not REAL.
    pub(in crate::program) is_whole: bool,
}

impl Number {
    pub(super) const fn real(value: f64) -> Self {
        Self { value, is_whole: false }
    }

    pub(super) const fn whole(value: f64) -> Self {
        Self { value, is_whole: true }
    }

    pub(super) fn truth(truth: bool) -> Self {
        Self::whole(f64::from(u8::from(truth)))
    }
}

/// The reason why a text is not an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) enum Mistake {
    /// An operand is missing at this byte.
    NoOperand(usize),
    /// The bracket or quotation mark at this byte is not closed.
    Unclosed(usize),
    /// The nesting is too deep from this byte on.
    TooDeep(usize),
    /// A number continues at this byte with an exponent that is not written `EX`.
    Exponent(usize),
}

/// The values of names.
pub(in crate::program) trait Names {
    /// The value of a variable with its subscripts; `None` if it is not known.
    fn value(&mut self, name: &[u8], subscripts: &[Option<Number>]) -> Option<Number>;
}

/// No name has a known value.
pub(in crate::program) struct NoNames;

impl Names for NoNames {
    fn value(&mut self, _name: &[u8], _subscripts: &[Option<Number>]) -> Option<Number> {
        None
    }
}

/// A list of values, up to the number that is examined.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::program) struct Arguments {
    values: [Option<Number>; MAX_ARGUMENTS],
    pub(in crate::program) count: usize,
}

impl Arguments {
    /// The examined values.
    pub(in crate::program) fn values(&self) -> &[Option<Number>] {
        self.values.get(..self.count.min(MAX_ARGUMENTS)).unwrap_or_default()
    }
}

/// A walk along an expression.
pub(in crate::program) struct Walk<'a, N> {
    text: &'a [u8],
    pub(in crate::program) at: usize,
    depth: u8,
    names: &'a mut N,
}

impl<'a, N: Names> Walk<'a, N> {
    /// Starts at this byte of a text.
    pub(in crate::program) fn new(text: &'a [u8], at: usize, names: &'a mut N) -> Self {
        Self { text, at, depth: 0, names }
    }

    fn byte(&self, at: usize) -> u8 {
        self.text.get(at).copied().unwrap_or(b'\n')
    }

    pub(super) fn skip_blanks(&mut self) {
        while matches!(self.byte(self.at), b' ' | b'\t') {
            self.at += 1;
        }
    }

    /// Moves over the byte if it comes next, after blanks.
    pub(in crate::program) fn take(&mut self, byte: u8) -> bool {
        self.skip_blanks();
        let found = self.byte(self.at) == byte;
        self.at += usize::from(found);
        found
    }

    /// Whether this byte comes next, after blanks.
    pub(in crate::program) fn is_next(&mut self, byte: u8) -> bool {
        self.skip_blanks();
        self.byte(self.at) == byte
    }

    /// Moves over a single `=` if it comes next. Otherwise it stays.
    pub(in crate::program) fn take_equals(&mut self) -> bool {
        let before = self.at;
        self.skip_blanks();
        let found = self.byte(self.at) == b'=' && self.byte(self.at + 1) != b'=';
        self.at = if found { self.at + 1 } else { before };
        found
    }

    /// The text after `=`: an expression, or a list of values in brackets, which has no single value.
    pub(in crate::program) fn value(&mut self) -> Result<Option<Number>, Mistake> {
        self.skip_blanks();
        let (at, depth) = (self.at, self.depth);
        let result = self.expression();
        if result.is_ok() || self.byte(at) != b'(' {
            return result;
        }
        (self.at, self.depth) = (at, depth);
        self.list(b')').map(|_| None)
    }

    /// An expression. Afterwards `at` is one after its last byte.
    pub(in crate::program) fn expression(&mut self) -> Result<Option<Number>, Mistake> {
        self.level(0)
    }

    /// Operands, and the operators between them that bind at least as tightly as this level.
    fn level(&mut self, least: u8) -> Result<Option<Number>, Mistake> {
        let mut value = self.operand()?;
        loop {
            let end = self.at;
            self.skip_blanks();
            let found = operator(self.text, self.at).filter(|(operator, _)| operator.level() >= least);
            let Some((operator, length)) = found else {
                self.at = end;
                return Ok(value);
            };
            self.at += length;
            // Operators of the same level go from left to right, so the right side binds tighter.
            let right = self.level(operator.level() + 1)?;
            value = match (value, right) {
                (Some(left), Some(right)) => binary(operator, left, right),
                _ => None,
            };
        }
    }

    fn deeper(&mut self) -> Result<(), Mistake> {
        self.depth += 1;
        if self.depth > MAX_DEPTH { Err(Mistake::TooDeep(self.at)) } else { Ok(()) }
    }

    /// One operand with its signs.
    pub(super) fn operand(&mut self) -> Result<Option<Number>, Mistake> {
        self.skip_blanks();
        let at = self.at;
        match self.byte(at) {
            sign @ (b'+' | b'-') => {
                self.at += 1;
                self.deeper()?;
                let value = self.operand()?;
                self.depth -= 1;
                // 0 − 0 is +0, so a negative zero never gets in.
                Ok(value.map(|number| {
                    if sign == b'-' { Number { value: 0.0 - number.value, ..number } } else { number }
                }))
            }
            b'(' => {
                self.at += 1;
                self.deeper()?;
                let value = self.expression()?;
                self.depth -= 1;
                if self.take(b')') { Ok(value) } else { Err(Mistake::Unclosed(at)) }
            }
            b'"' => {
                self.at = string_end(self.text, at).ok_or(Mistake::Unclosed(at))?;
                Ok(None)
            }
            b'\'' => self.quoted(),
            b'0'..=b'9' | b'.' => self.number(),
            // A text may begin with an empty part: `<<` as a prefix.
            b'<' if self.byte(at + 1) == b'<' => {
                self.at += 2;
                self.deeper()?;
                self.operand()?;
                self.depth -= 1;
                Ok(None)
            }
            byte if byte.is_ascii_alphabetic() || matches!(byte, b'_' | b'$') => self.name(),
            _ => Err(Mistake::NoOperand(at)),
        }
    }

    fn number(&mut self) -> Result<Option<Number>, Mistake> {
        let at = self.at;
        let Some(number) = read_unsigned(self.text, at) else { return Err(Mistake::NoOperand(at)) };
        self.at = number.end;
        let mut value = number.value;
        let mut is_whole = !number.has_point;
        if let Some(end) = exponent_end(self.text, number.end) {
            value = with_exponent(self.text, at, number.end, end);
            is_whole = false;
            self.at = end;
        } else if exponent_at(self.text, number.end).is_some() {
            return Err(Mistake::Exponent(number.end));
        }
        Ok(value.is_finite().then_some(Number { value, is_whole }))
    }

    /// `'H7F'`, `'B101'`. Other quoted text is characters.
    fn quoted(&mut self) -> Result<Option<Number>, Mistake> {
        let at = self.at;
        let rest = self.text.get(at + 1..).unwrap_or_default();
        let length = memchr::memchr3(b'\'', b'\n', b'\r', rest).filter(|&end| rest.get(end) == Some(&b'\''));
        let Some(length) = length else { return Err(Mistake::Unclosed(at)) };
        self.at = at + length + 2;
        let inner = rest.get(..length).unwrap_or_default();
        let radix = match inner.first() {
            Some(b'H' | b'h') => 16,
            Some(b'B' | b'b') => 2,
            _ => return Ok(None),
        };
        let digits = std::str::from_utf8(inner.get(1..).unwrap_or_default()).unwrap_or_default();
        let value = u32::from_str_radix(digits, radix).ok();
        Ok(value.filter(|_| !digits.starts_with('+')).map(|value| Number::whole(f64::from(value))))
    }

    /// A variable, a function, or `NOT` and `B_NOT` with their operand.
    fn name(&mut self) -> Result<Option<Number>, Mistake> {
        let start = self.at;
        let end = operand_name_end(self.text, start);
        let name = self.text.get(start..end).unwrap_or_default();
        self.at = end;
        if name.eq_ignore_ascii_case(b"NOT") || name.eq_ignore_ascii_case(b"B_NOT") {
            self.deeper()?;
            let value = self.operand()?;
            self.depth -= 1;
            let is_bitwise = name.len() > 3;
            return Ok(value.and_then(|number| negated(number, is_bitwise)));
        }
        self.skip_blanks();
        match self.byte(self.at) {
            b'(' => {
                let arguments = self.list(b')')?;
                Ok(function(name, &arguments))
            }
            b'[' => {
                let subscripts = self.list(b']')?;
                if subscripts.count > MAX_ARGUMENTS {
                    return Ok(None);
                }
                Ok(self.names.value(name, subscripts.values()))
            }
            _ => {
                self.at = end;
                Ok(self.names.value(name, &[]))
            }
        }
    }

    /// A list in brackets, from the opening bracket on. An empty element has no value.
    pub(in crate::program) fn list(&mut self, close: u8) -> Result<Arguments, Mistake> {
        let open = self.at;
        let mut arguments = Arguments::default();
        self.at += 1;
        self.deeper()?;
        if self.take(close) {
            self.depth -= 1;
            return Ok(arguments);
        }
        loop {
            self.skip_blanks();
            let next = self.byte(self.at);
            let value = if next == b',' || next == close { None } else { self.expression()? };
            if let Some(slot) = arguments.values.get_mut(arguments.count) {
                *slot = value;
            }
            arguments.count += 1;
            if self.take(b',') {
                continue;
            }
            if self.take(close) {
                self.depth -= 1;
                return Ok(arguments);
            }
            return Err(Mistake::Unclosed(open));
        }
    }
}

fn negated(number: Number, is_bitwise: bool) -> Option<Number> {
    if is_bitwise {
        // In two's complement ~n is −n − 1.
        return (number.is_whole && number.value.abs() < 2e9).then(|| Number::whole(-1.0 - number.value));
    }
    Some(Number::truth(number.value == 0.0))
}

/// One after the quotation mark that closes the one at `at`; `None` if its line has none.
pub(in crate::program) fn string_end(text: &[u8], at: usize) -> Option<usize> {
    let rest = text.get(at + 1..)?;
    let length = memchr::memchr3(b'"', b'\n', b'\r', rest)?;
    (rest.get(length) == Some(&b'"')).then_some(at + length + 2)
}

/// One after an exponent `EX3`, `EX-4` at `at`.
pub(in crate::program) fn exponent_end(text: &[u8], at: usize) -> Option<usize> {
    let mark = text.get(at..at + 2)?;
    if !mark.eq_ignore_ascii_case(b"EX") {
        return None;
    }
    let sign = usize::from(matches!(text.get(at + 2), Some(b'+' | b'-')));
    let digits = at + 2 + sign;
    let count = text.get(digits..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
    (count > 0).then_some(digits + count)
}

/// The number from `start`, with digits up to `mantissa_end` and an exponent up to `end`; infinite if it is too large.
pub(in crate::program) fn with_exponent(text: &[u8], start: usize, mantissa_end: usize, end: usize) -> f64 {
    let part = |from: usize, to: usize| std::str::from_utf8(text.get(from..to).unwrap_or_default());
    let (Ok(mantissa), Ok(exponent)) = (part(start, mantissa_end), part(mantissa_end + 2, end)) else {
        return f64::INFINITY;
    };
    format!("{mantissa}e{exponent}").parse().unwrap_or(f64::INFINITY)
}

/// One after a name: letters, digits and underscores, with its `$` marks. One letter with digits is a separate name
/// (`R12`, `X1`), whatever letter follows, because no other name has a digit in its second place.
pub(in crate::program) fn operand_name_end(text: &[u8], start: usize) -> usize {
    let run = |from: usize, fits: fn(u8) -> bool| {
        from + text.get(from..).unwrap_or_default().iter().take_while(|byte| fits(**byte)).count()
    };
    let letters = run(start, |byte| byte == b'$');
    if letters == start
        && text.get(start).is_some_and(u8::is_ascii_alphabetic)
        && text.get(start + 1).is_some_and(u8::is_ascii_digit)
    {
        return run(start + 1, |byte| byte.is_ascii_digit());
    }
    run(letters, |byte| byte.is_ascii_alphanumeric() || byte == b'_')
}
