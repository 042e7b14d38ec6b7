//! Quantities and the only conversion constants of the crate.
//!
//! One type per quantity, not per unit, like [`std::time::Duration`]. Inside the core a bare `f64` carries its
//! unit in its name (`point_mm`, `tilt_rad`); a quantity type never does. Lengths are millimetres and angles are
//! radians inside; degrees, micrometres and microradians exist only at an interface.

use std::borrow::Borrow;
use std::ops::{Add, Div, Mul, Neg, Range, Sub};

/// Micrometres in a millimetre.
pub const UM_PER_MM: f64 = 1000.0;
/// Microradians in a radian.
pub const URAD_PER_RAD: f64 = 1e6;
/// Millimetres in an inch, exact by definition.
pub const MM_PER_INCH: f64 = 25.4;
/// Seconds in a minute.
pub const S_PER_MIN: f64 = 60.0;

/// A number in a form that people read: with an exponent where it would have very many digits.
#[must_use]
pub fn legible(value: impl Borrow<f64>) -> String {
    let value = *value.borrow();
    let size = value.abs();
    if size == 0.0 || LEGIBLE.contains(&size) { value.to_string() } else { format!("{value:e}") }
}

/// The sizes of numbers that are written without an exponent.
const LEGIBLE: Range<f64> = 1e-6..1e9;

/// A unit of length used in programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Millimetre,
    /// Inches.
    Inch,
}

impl LengthUnit {
    /// Its length \[mm\].
    #[must_use]
    pub const fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Inch => MM_PER_INCH,
        }
    }

    /// The name in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Inch => "inch",
        }
    }
}

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
        pub struct $name(f64);

        impl $name {
            /// Zero.
            pub const ZERO: Self = Self(0.0);
            /// The magnitude, without sign.
            #[must_use]
            pub fn abs(self) -> Self {
                Self(self.0.abs())
            }
            /// Whether the value is neither NaN nor infinite.
            #[must_use]
            pub fn is_finite(self) -> bool {
                self.0.is_finite()
            }
        }
        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }
        impl Sub for $name {
            type Output = Self;
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }
        impl Neg for $name {
            type Output = Self;
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }
        impl Mul<f64> for $name {
            type Output = Self;
            fn mul(self, factor: f64) -> Self {
                Self(self.0 * factor)
            }
        }
        impl Div for $name {
            type Output = f64;
            fn div(self, other: Self) -> f64 {
                self.0 / other.0
            }
        }
    };
}

quantity! {
    /// A length or a signed distance.
    Length
}
quantity! {
    /// A plane angle.
    Angle
}
quantity! {
    /// A feedrate along the path, as an F word in G94 means it.
    Feedrate
}

impl Length {
    /// From millimetres.
    #[must_use]
    pub const fn from_mm(mm: f64) -> Self {
        Self(mm)
    }
    /// From micrometres.
    #[must_use]
    pub fn from_um(um: f64) -> Self {
        Self(um / UM_PER_MM)
    }
    /// In millimetres.
    #[must_use]
    pub const fn mm(self) -> f64 {
        self.0
    }
    /// In micrometres.
    #[must_use]
    pub fn um(self) -> f64 {
        self.0 * UM_PER_MM
    }
}

impl Angle {
    /// From radians.
    #[must_use]
    pub const fn from_rad(rad: f64) -> Self {
        Self(rad)
    }
    /// From degrees.
    #[must_use]
    pub fn from_deg(deg: f64) -> Self {
        Self(deg.to_radians())
    }
    /// From microradians.
    #[must_use]
    pub fn from_urad(urad: f64) -> Self {
        Self(urad / URAD_PER_RAD)
    }
    /// In radians.
    #[must_use]
    pub const fn rad(self) -> f64 {
        self.0
    }
    /// In degrees.
    #[must_use]
    pub fn deg(self) -> f64 {
        self.0.to_degrees()
    }
    /// In microradians.
    #[must_use]
    pub fn urad(self) -> f64 {
        self.0 * URAD_PER_RAD
    }
}

impl Feedrate {
    /// From millimetres per minute.
    #[must_use]
    pub const fn from_mm_per_min(mm_per_min: f64) -> Self {
        Self(mm_per_min)
    }
    /// In millimetres per minute.
    #[must_use]
    pub const fn mm_per_min(self) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::legible;

    #[test]
    fn a_number_is_written_as_people_read_it() {
        let read = [
            (0.0, "0"),
            (-5.0, "-5"),
            (0.000_25, "0.00025"),
            (123_456.75, "123456.75"),
            (-3e300, "-3e300"),
            (5e-324, "5e-324"),
            (1e9, "1e9"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (value, text) in read {
            assert_eq!(legible(value), text);
        }
    }
}
