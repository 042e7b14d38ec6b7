//! Values in the notation of RS274 and Fanuc controls: numbers, `[…]`, parameters, functions.
//!
//! The two families agree on most values. If they do not agree, and nothing has shown that the program is for
//! RS274/NGC, the value is not known. These values are:
//!
//! - FIX and FUP of negative numbers,
//! - AND OR XOR of anything but 0 and 1,
//! - MOD of anything but whole positive numbers,
//! - negative angles from ATAN,
//! - ROUND in an address.

use super::{Name, Parameters, Target};
use crate::program::constants::arithmetic as functions;
use crate::program::number::read_unsigned;

/// The deepest nesting of brackets, and of parameters whose number is a parameter.
pub(super) const MAX_DEPTH: u32 = 32;
/// Numbers closer than this may compare either way, because RS274 takes them as equal.
const NEARLY_EQUAL: f64 = 1e-4;
/// A number this close to the edge of a rounding may round either way in another control's arithmetic.
const ON_EDGE: f64 = 1e-6;
/// The largest number that a parameter can have in RS274/NGC.
const MAX_NUMBER_RS274: f64 = 5601.0;
/// Functions whose value is not computed here, although it is not a mistake to call them.
const OTHER_FUNCTIONS: [&[u8]; 8] = [b"BIN", b"BCD", b"ADP", b"PRM", b"POW", b"RO", b"FI", b"FU"];

/// A value. `None` is known only when the program runs.
pub(super) type Value = Option<f64>;

/// The mistake in a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mistake {
    /// The text is not what is expected here.
    Unexpected,
    /// A bracket or a name is not closed.
    Unclosed,
    /// A division by zero, a root of a negative number or a similar operation.
    Undefined,
    /// There is no function with this name.
    NoFunction,
    /// Too many nested brackets.
    TooDeep,
}

/// A mistake and the bytes in which it was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wrong {
    pub(super) mistake: Mistake,
    pub(super) start: usize,
    pub(super) end: usize,
}

type Read<T> = Result<T, Wrong>;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operator {
    Or,
    Xor,
    And,
    Eq,
    Ne,
    Gt,
    Ge,
    Lt,
    Le,
    Plus,
    Minus,
    Times,
    Over,
    Mod,
    Power,
}

const LETTERS: [(&[u8], Operator); 10] = [
    (b"MOD", Operator::Mod),
    (b"AND", Operator::And),
    (b"XOR", Operator::Xor),
    (b"OR", Operator::Or),
    (b"EQ", Operator::Eq),
    (b"NE", Operator::Ne),
    (b"GT", Operator::Gt),
    (b"GE", Operator::Ge),
    (b"LT", Operator::Lt),
    (b"LE", Operator::Le),
];

impl Operator {
    const fn precedence(self) -> u8 {
        match self {
            Self::Or | Self::Xor | Self::And => 1,
            Self::Eq | Self::Ne | Self::Gt | Self::Ge | Self::Lt | Self::Le => 2,
            Self::Plus | Self::Minus => 3,
            Self::Times | Self::Over | Self::Mod => 4,
            Self::Power => 5,
        }
    }
}

/// Reads values from one line, with the parameters as they are before it.
#[expect(clippy::struct_excessive_bools, reason = "independent facts about the reading")]
pub(super) struct Expression<'a> {
    text: &'a [u8],
    pub(super) at: usize,
    parameters: &'a Parameters,
    /// The value belongs to an address, not to an assignment.
    in_word: bool,
    pub(super) is_rs274: bool,
    depth: u32,
    /// Whether the present brackets have an operator of logic, and another operator.
    logic: bool,
    other: bool,
}

impl<'a> Expression<'a> {
    /// Starts at byte `at` of a text that ends with the line.
    pub(super) fn new(text: &'a [u8], at: usize, parameters: &'a Parameters, in_word: bool) -> Self {
        let is_rs274 = parameters.is_rs274;
        Self { text, at, parameters, in_word, is_rs274, depth: 0, logic: false, other: false }
    }

    /// Operands with operators between them, as in brackets. An assignment of Fanuc has no brackets around it.
    pub(super) fn chain(&mut self) -> Read<Value> {
        let outside = (self.logic, self.other);
        (self.logic, self.other) = (false, false);
        let value = self.operators(1)?;
        // In RS274, logic binds last. In Fanuc, it binds as products and sums do.
        let is_certain = self.is_rs274 || !(self.logic && self.other);
        (self.logic, self.other) = outside;
        Ok(value.filter(|_| is_certain))
    }

    /// One operand with its sign, as it may come after a letter.
    pub(super) fn operand(&mut self) -> Read<Value> {
        let mut negative = false;
        loop {
            self.skip_blanks();
            match self.byte() {
                b'-' => negative = !negative,
                b'+' => {}
                _ => break,
            }
            self.at += 1;
        }
        let value = self.primary()?;
        Ok(if negative { value.map(|value| 0.0 - value) } else { value })
    }

    fn operators(&mut self, least: u8) -> Read<Value> {
        let start = self.at;
        let mut left = self.operand()?;
        while let Some((operator, end)) =
            self.operator().filter(|(operator, _)| operator.precedence() >= least)
        {
            self.logic |= operator.precedence() == 1;
            self.other |= operator.precedence() > 1;
            self.is_rs274 |= operator == Operator::Power;
            self.at = end;
            let right = self.operators(operator.precedence() + 1)?;
            left = match (left, right) {
                (Some(left), Some(right)) => self.apply(operator, left, right, start)?,
                // Whatever the other operand is.
                (_, Some(0.0)) if matches!(operator, Operator::Over | Operator::Mod) => {
                    return Err(self.wrong(Mistake::Undefined, start));
                }
                _ => None,
            };
        }
        Ok(left)
    }

    fn operator(&mut self) -> Option<(Operator, usize)> {
        self.skip_blanks();
        let rest = self.text.get(self.at..)?;
        let one = self.at + 1;
        match rest.first()? {
            b'+' => Some((Operator::Plus, one)),
            b'-' => Some((Operator::Minus, one)),
            b'/' => Some((Operator::Over, one)),
            b'*' if rest.get(1) == Some(&b'*') => Some((Operator::Power, one + 1)),
            b'*' => Some((Operator::Times, one)),
            _ => LETTERS.into_iter().find_map(|(name, operator)| {
                let found = rest.get(..name.len())?.eq_ignore_ascii_case(name);
                found.then_some((operator, self.at + name.len()))
            }),
        }
    }

    fn apply(&self, operator: Operator, left: f64, right: f64, start: usize) -> Read<Value> {
        let truth = |holds: bool| Some(f64::from(u8::from(holds)));
        let difference = (left - right).abs();
        let nearly = left != right && difference < NEARLY_EQUAL;
        let at_edge = left != right && difference < ON_EDGE * left.abs().max(1.0);
        let are_truths = [left, right].iter().all(|value| *value == 0.0 || *value == 1.0);
        let value = match operator {
            Operator::Plus => Some(left + right),
            Operator::Minus => Some(left - right),
            Operator::Times => Some(left * right),
            Operator::Over | Operator::Mod if right == 0.0 => {
                return Err(self.wrong(Mistake::Undefined, start));
            }
            Operator::Over => Some(left / right),
            Operator::Mod => {
                let plain = left >= 0.0 && right > 0.0 && left == left.trunc() && right == right.trunc();
                let rest = left % right;
                let rest = if rest < 0.0 { rest + right.abs() } else { rest };
                (plain || self.is_rs274).then_some(rest)
            }
            Operator::Power => {
                let value = functions::power(left, right);
                return value.map(Some).ok_or(self.wrong(Mistake::Undefined, start));
            }
            Operator::Eq if !nearly => truth(left == right),
            Operator::Ne if !nearly => truth(left != right),
            Operator::Gt | Operator::Ge if !at_edge => {
                truth(left > right || (left == right && operator == Operator::Ge))
            }
            Operator::Lt | Operator::Le if !at_edge => {
                truth(left < right || (left == right && operator == Operator::Le))
            }
            Operator::And | Operator::Or | Operator::Xor if are_truths || self.is_rs274 => {
                let [left, right] = [left != 0.0, right != 0.0];
                truth(match operator {
                    Operator::And => left && right,
                    Operator::Or => left || right,
                    _ => left != right,
                })
            }
            _ => None,
        };
        match value {
            Some(value) if !value.is_finite() => Err(self.wrong(Mistake::Undefined, start)),
            value => Ok(value),
        }
    }

    fn primary(&mut self) -> Read<Value> {
        self.skip_blanks();
        match self.byte() {
            b'[' => self.brackets(),
            b'#' => {
                self.at += 1;
                let target = self.target()?;
                Ok(self.parameters.value(&target))
            }
            byte if byte.is_ascii_alphabetic() => self.function(),
            _ => {
                let number = read_unsigned(self.text, self.at).filter(|number| number.value.is_finite());
                let Some(number) = number else { return Err(self.unexpected()) };
                self.at = number.end;
                Ok(Some(number.value))
            }
        }
    }

    fn brackets(&mut self) -> Read<Value> {
        let start = self.at;
        self.enter(start)?;
        self.at += 1;
        let value = self.chain()?;
        self.close(start)?;
        self.depth -= 1;
        Ok(value)
    }

    fn enter(&mut self, start: usize) -> Read<()> {
        self.depth += 1;
        if self.depth > MAX_DEPTH { Err(self.wrong(Mistake::TooDeep, start)) } else { Ok(()) }
    }

    /// Takes the bracket that closes the one at `start`.
    fn close(&mut self, start: usize) -> Read<()> {
        self.skip_blanks();
        match self.text.get(self.at) {
            Some(b']') => {
                self.at += 1;
                Ok(())
            }
            None => Err(self.wrong(Mistake::Unclosed, start)),
            Some(_) => Err(self.unexpected()),
        }
    }

    /// The parameter that the text after `#` means.
    pub(super) fn target(&mut self) -> Read<Target> {
        let start = self.at;
        self.skip_blanks();
        match self.byte() {
            b'<' => {
                let rest = self.text.get(self.at..).unwrap_or_default();
                let Some(length) = memchr::memchr(b'>', rest) else {
                    return Err(self.wrong(Mistake::Unclosed, start));
                };
                self.is_rs274 = true;
                self.at += length + 1;
                Ok(Name::new(rest.get(1..length).unwrap_or_default()).map_or(Target::Unseen, Target::Named))
            }
            b'_' => {
                while matches!(self.byte(), b'_' | b'0'..=b'9') || self.byte().is_ascii_alphabetic() {
                    self.at += 1;
                }
                if self.byte() == b'[' {
                    self.brackets()?;
                }
                Ok(Target::System)
            }
            _ => {
                self.enter(start)?;
                let number = self.primary()?;
                self.depth -= 1;
                Ok(number.map_or(Target::Unseen, Target::of_number))
            }
        }
    }

    fn function(&mut self) -> Read<Value> {
        let start = self.at;
        while self.byte().is_ascii_alphabetic() {
            self.at += 1;
        }
        let name = self.text.get(start..self.at).unwrap_or_default().to_ascii_uppercase();
        self.skip_blanks();
        if self.byte() != b'[' {
            self.at = start;
            return Err(self.unexpected());
        }
        match name.as_slice() {
            b"EXISTS" => return self.exists(start),
            b"ATAN" => return self.arc_tangent(),
            name if OTHER_FUNCTIONS.contains(&name) => {
                self.skip_arguments()?;
                return Ok(None);
            }
            b"ABS" | b"ACOS" | b"ASIN" | b"COS" | b"EXP" | b"FIX" | b"FUP" | b"LN" | b"ROUND" | b"SIN"
            | b"SQRT" | b"TAN" => {}
            _ => return Err(self.wrong(Mistake::NoFunction, start)),
        }
        let Some(argument) = self.brackets()? else { return Ok(None) };
        let edge = argument != argument.round() && (argument - argument.round()).abs() < ON_EDGE;
        let value = match name.as_slice() {
            b"ABS" => Some(argument.abs()),
            b"ACOS" => functions::acos_deg(argument),
            b"ASIN" => functions::asin_deg(argument),
            b"COS" => functions::cos_deg(argument),
            b"EXP" => functions::exp(argument),
            b"LN" => functions::ln(argument),
            b"SIN" => functions::sin_deg(argument),
            b"SQRT" => functions::sqrt(argument),
            b"TAN" => functions::tan_deg(argument),
            b"ROUND" => return Ok(self.rounded(argument)),
            whole => {
                // RS274 rounds towards minus and plus infinity, Fanuc towards and away from zero.
                let agrees = argument >= 0.0 || argument == argument.trunc() || self.is_rs274;
                let value = if whole == b"FIX" { argument.floor() } else { argument.ceil() };
                return Ok((agrees && !edge).then_some(value));
            }
        };
        value.map(Some).ok_or(self.wrong(Mistake::Undefined, start))
    }

    /// Rounds to a whole number. In an address, Fanuc rounds to the least increment.
    fn rounded(&self, value: f64) -> Value {
        let half = (value - value.trunc()).abs() - 0.5;
        let is_certain = half == 0.0 || half.abs() > ON_EDGE;
        let agrees = !self.in_word || self.is_rs274 || value == value.trunc();
        (is_certain && agrees).then_some(value.round())
    }

    /// `ATAN[y]/[x]`: −180° to 180° in RS274; 0° to 360° on Fanuc controls with that setting.
    fn arc_tangent(&mut self) -> Read<Value> {
        let y = self.brackets()?;
        let slash = self.at;
        self.skip_blanks();
        let x = if self.byte() == b'/' {
            self.at += 1;
            self.skip_blanks();
            if self.byte() == b'[' {
                Some(self.brackets()?)
            } else {
                self.at = slash;
                None
            }
        } else {
            None
        };
        let (Some(y), Some(x)) = (y, x.unwrap_or(Some(1.0))) else { return Ok(None) };
        let angle = functions::atan2_deg(y, x);
        Ok((angle >= 0.0 || self.is_rs274).then_some(angle))
    }

    /// `EXISTS[#…]`: only RS274 has it.
    fn exists(&mut self, start: usize) -> Read<Value> {
        let bracket = self.at;
        self.is_rs274 = true;
        self.at += 1;
        self.skip_blanks();
        if self.byte() != b'#' {
            return Err(self.unexpected());
        }
        self.at += 1;
        self.skip_blanks();
        let target = if self.byte() == b'#' {
            // The number is a parameter's value, which must be known.
            self.enter(start)?;
            self.at += 1;
            let inner = self.target()?;
            self.depth -= 1;
            if matches!(inner, Target::Beyond(number) if number > MAX_NUMBER_RS274) {
                return Err(self.wrong(Mistake::Undefined, start));
            }
            self.parameters.value(&inner).map_or(Target::Unseen, Target::of_number)
        } else {
            self.target()?
        };
        self.close(bracket)?;
        let holds = match target {
            Target::Numbered(_) => Some(true),
            Target::Beyond(number) => Some((1.0..=MAX_NUMBER_RS274).contains(&number)),
            Target::Named(name) => self.parameters.exists(&name),
            Target::Unseen | Target::System => None,
        };
        Ok(holds.map(|holds| f64::from(u8::from(holds))))
    }

    /// Brackets whose contents are not read.
    fn skip_arguments(&mut self) -> Read<()> {
        let start = self.at;
        let mut depth = 0_u32;
        loop {
            match self.text.get(self.at) {
                Some(b'[') => depth += 1,
                Some(b']') => depth = depth.saturating_sub(1),
                None => return Err(self.wrong(Mistake::Unclosed, start)),
                Some(_) => {}
            }
            self.at += 1;
            if depth == 0 {
                return Ok(());
            }
        }
    }

    pub(super) fn skip_blanks(&mut self) {
        while matches!(self.byte(), b' ' | b'\t') {
            self.at += 1;
        }
    }

    /// The present byte; a line end after the text.
    pub(super) fn byte(&self) -> u8 {
        self.text.get(self.at).copied().unwrap_or(b'\n')
    }

    fn wrong(&self, mistake: Mistake, start: usize) -> Wrong {
        Wrong { mistake, start, end: self.at.max(start + 1) }
    }

    fn unexpected(&self) -> Wrong {
        let end = self.text.len().max(self.at);
        Wrong { mistake: Mistake::Unexpected, start: self.at, end }
    }
}
