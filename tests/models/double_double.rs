//! Arithmetic with twice the digits of a double (Dekker, Knuth): 106 bits, for second methods.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The unevaluated sum of two doubles, the second below half a unit of the first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Double2(pub(crate) f64, pub(crate) f64);

fn sum(a: f64, b: f64) -> Double2 {
    let s = a + b;
    let t = s - a;
    Double2(s, (a - (s - t)) + (b - t))
}

fn product(a: f64, b: f64) -> Double2 {
    let p = a * b;
    Double2(p, a.mul_add(b, -p))
}

impl Double2 {
    pub(crate) fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self(0.0, 0.0);
        }
        // two steps of Newton from the double root
        let mut root = Self(self.0.sqrt(), 0.0);
        for _ in 0..2 {
            root = (root + self / root) * Self(0.5, 0.0);
        }
        root
    }
}

impl From<f64> for Double2 {
    fn from(value: f64) -> Self {
        Self(value, 0.0)
    }
}

impl Neg for Double2 {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Add for Double2 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let high = sum(self.0, other.0);
        let low = sum(self.1, other.1);
        let step = sum(high.0, high.1 + low.0);
        sum(step.0, step.1 + low.1)
    }
}

impl Sub for Double2 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double2 {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = product(self.0, other.0);
        sum(high.0, high.1 + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for Double2 {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * Self::from(first);
        let second = rest.0 / other.0;
        let rest = rest - other * Self::from(second);
        sum(first, second) + Self::from(rest.0 / other.0)
    }
}
