//! The radii in the offset registers of a control, as the caller states them.

use std::collections::BTreeMap;

/// A register of a control by the word that names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum RadiusRegister {
    /// D beside G41 and G42.
    D(u16),
    /// H beside G41 and G42, on controls that take radii by H too.
    H(u16),
}

impl RadiusRegister {
    /// The register of a name such as `D4` or `H19`; `None` if no control has it.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let (letter, digits) = name.split_at_checked(1)?;
        let is_number = digits.len() <= 5 && digits.bytes().all(|byte| byte.is_ascii_digit());
        let number: u16 = digits.parse().ok().filter(|number| is_number && *number > 0)?;
        match letter {
            "D" | "d" => Some(Self::D(number)),
            "H" | "h" => Some(Self::H(number)),
            _ => None,
        }
    }
}

/// The radii by which a control compensates: geometry and wear together.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RadiusOffsets {
    /// By register \[mm\].
    pub by_register_mm: BTreeMap<RadiusRegister, f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_register_is_named_by_d_or_h_and_its_number() {
        assert_eq!(RadiusRegister::from_name("D4"), Some(RadiusRegister::D(4)));
        assert_eq!(RadiusRegister::from_name("d04"), Some(RadiusRegister::D(4)));
        assert_eq!(RadiusRegister::from_name("H19"), Some(RadiusRegister::H(19)));
        for name in ["", "D", "D0", "D-1", "D+1", "D1.5", "D000004", "4", "T4", "D70000", "Ä4", "D 4"] {
            assert_eq!(RadiusRegister::from_name(name), None, "{name}");
        }
    }
}
