//! Operators of the Sinumerik and their priorities.
//!
//! From the strongest to the weakest: `* / DIV MOD`, `+ -`, `B_AND`, `B_XOR`, `B_OR`, `AND`, `XOR`, `OR`, `<<`,
//! comparisons. Operators of the same priority go from left to right. (Frames are chained by `:`, the strongest
//! operator.)

use super::expression::Number;

/// INT values of the control.
const MAX_INT: f64 = 2_147_483_647.0;
/// If the relative difference of two REAL values is smaller than this, a control may take them as equal.
const NEARLY_EQUAL: f64 = 1e-9;

/// An operator with two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    Unequal,
    Chain,
    Or,
    Xor,
    And,
    BitOr,
    BitXor,
    BitAnd,
    Plus,
    Minus,
    Times,
    Over,
    Div,
    Mod,
    Frame,
}

impl Operator {
    /// 0 binds weakest.
    pub(super) fn level(self) -> u8 {
        match self {
            Self::Less
            | Self::LessOrEqual
            | Self::Greater
            | Self::GreaterOrEqual
            | Self::Equal
            | Self::Unequal => 0,
            Self::Chain => 1,
            Self::Or => 2,
            Self::Xor => 3,
            Self::And => 4,
            Self::BitOr => 5,
            Self::BitXor => 6,
            Self::BitAnd => 7,
            Self::Plus | Self::Minus => 8,
            Self::Times | Self::Over | Self::Div | Self::Mod => 9,
            Self::Frame => 10,
        }
    }
}

const WORDS: [(&[u8], Operator); 8] = [
    (b"DIV", Operator::Div),
    (b"MOD", Operator::Mod),
    (b"AND", Operator::And),
    (b"OR", Operator::Or),
    (b"XOR", Operator::Xor),
    (b"B_AND", Operator::BitAnd),
    (b"B_OR", Operator::BitOr),
    (b"B_XOR", Operator::BitXor),
];

/// The operator at a byte, and its length.
pub(super) fn operator(text: &[u8], at: usize) -> Option<(Operator, usize)> {
    let first = *text.get(at)?;
    let second = text.get(at + 1).copied().unwrap_or_default();
    let found = match (first, second) {
        (b'<', b'<') => (Operator::Chain, 2),
        (b'<', b'=') => (Operator::LessOrEqual, 2),
        (b'<', b'>') => (Operator::Unequal, 2),
        (b'<', _) => (Operator::Less, 1),
        (b'>', b'=') => (Operator::GreaterOrEqual, 2),
        (b'>', _) => (Operator::Greater, 1),
        (b'=', b'=') => (Operator::Equal, 2),
        (b'+', _) => (Operator::Plus, 1),
        (b'-', _) => (Operator::Minus, 1),
        (b'*', _) => (Operator::Times, 1),
        (b'/', _) => (Operator::Over, 1),
        (b':', _) => (Operator::Frame, 1),
        _ if first.is_ascii_alphabetic() => {
            let rest = text.get(at..).unwrap_or_default();
            let length =
                rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
            let word = rest.get(..length)?;
            let (_, operator) = WORDS.iter().find(|(name, _)| word.eq_ignore_ascii_case(name))?;
            (*operator, length)
        }
        _ => return None,
    };
    Some(found)
}

/// The value of two operands; `None` if the manuals do not state the result, or if it is out of range.
pub(super) fn binary(operator: Operator, left: Number, right: Number) -> Option<Number> {
    let (a, b) = (left.value, right.value);
    let both_whole = left.is_whole && right.is_whole;
    let value = match operator {
        Operator::Plus => Number { value: a + b, is_whole: both_whole },
        Operator::Minus => Number { value: a - b, is_whole: both_whole },
        Operator::Times => Number { value: a * b, is_whole: both_whole },
        // INT / INT is REAL.
        Operator::Over => Number::real(a / b),
        // The manuals describe only positive operands: 7 DIV 4.1 = 1, 7 MOD 4.1 = 2.9.
        Operator::Div if a >= 0.0 && b > 0.0 => Number::whole(quotient(a, b)?),
        Operator::Mod if a >= 0.0 && b > 0.0 => {
            Number { value: a - quotient(a, b)? * b, is_whole: both_whole }
        }
        Operator::And => Number::truth(a != 0.0 && b != 0.0),
        Operator::Or => Number::truth(a != 0.0 || b != 0.0),
        Operator::Xor => Number::truth((a != 0.0) != (b != 0.0)),
        Operator::BitAnd | Operator::BitOr | Operator::BitXor => bits(operator, left, right)?,
        Operator::Equal
        | Operator::Unequal
        | Operator::Less
        | Operator::LessOrEqual
        | Operator::Greater
        | Operator::GreaterOrEqual => compare(operator, left, right)?,
        Operator::Div | Operator::Mod | Operator::Chain | Operator::Frame => return None,
    };
    let in_range = value.value.is_finite() && (!value.is_whole || value.value.abs() <= MAX_INT);
    in_range.then_some(Number { value: value.value + 0.0, ..value })
}

/// How often a contains b; `None` if the result is so close to a whole number that rounding decides.
fn quotient(a: f64, b: f64) -> Option<f64> {
    let exact = a / b;
    let nearest = exact.round();
    if (exact - nearest).abs() > NEARLY_EQUAL * exact.max(1.0) {
        return Some(exact.floor());
    }
    // Exactly whole (7 DIV 3.5) or one rounding away from it (1 DIV 0.1).
    (nearest * b).to_bits().eq(&a.to_bits()).then_some(nearest)
}

fn bits(operator: Operator, left: Number, right: Number) -> Option<Number> {
    if !(left.is_whole && right.is_whole) || left.value.abs() > MAX_INT || right.value.abs() > MAX_INT {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole and in range")]
    let (a, b) = (left.value as i32, right.value as i32);
    Some(Number::whole(f64::from(match operator {
        Operator::BitAnd => a & b,
        Operator::BitOr => a | b,
        _ => a ^ b,
    })))
}

#[expect(clippy::float_cmp, reason = "equal to the last bit or too near to tell")]
fn compare(operator: Operator, left: Number, right: Number) -> Option<Number> {
    let (a, b) = (left.value, right.value);
    if a != b && (a - b).abs() <= NEARLY_EQUAL * a.abs().max(b.abs()) {
        return None;
    }
    Some(Number::truth(match operator {
        Operator::Equal => a == b,
        Operator::Unequal => a != b,
        Operator::Less => a < b,
        Operator::LessOrEqual => a <= b,
        Operator::Greater => a > b,
        _ => a >= b,
    }))
}
