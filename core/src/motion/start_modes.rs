//! The modes in which a control begins a program, as its owner states them.

use super::cycle::Retract;

/// The modes in force before a program's first block. A mode that is not stated is that of
/// [`Interpreter`](super::Interpreter).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StartModes {
    /// G0, not G1.
    pub(super) is_rapid: Option<bool>,
    /// The axis across the plane: 0 to 2 for X to Z.
    pub(super) plane: Option<u8>,
    pub(super) incremental: Option<bool>,
    /// G95, not G94.
    pub(super) is_per_turn: Option<bool>,
    /// The level to which canned cycles retract.
    pub(super) retract: Option<Retract>,
}

/// Why codes do not state modes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum StartCodesFault {
    /// Another word than the codes below.
    #[error("{0:?} is not allowed here; the codes are G0 G1 G17 G18 G19 G90 G91 G94 G95 G98 G99")]
    NoMode(String),
    /// Two codes of one group.
    #[error("{0:?} is of the same group as a code before it")]
    Twice(String),
}

/// How many characters of a wrong word a fault shows.
const SHOWN: usize = 16;

impl StartModes {
    /// The modes of these codes, separated by blanks: G0 or G1, G17 G18 or G19, G90 or G91, G94 or G95, G98 or
    /// G99, at most one of each group.
    ///
    /// # Errors
    /// The first word that is no such code, or the second code of a group.
    pub fn from_codes(codes: &str) -> Result<Self, StartCodesFault> {
        let mut modes = Self::default();
        for code in codes.split_ascii_whitespace() {
            let shown = || code.chars().take(SHOWN).collect();
            let number = code
                .strip_prefix(['G', 'g'])
                .filter(|digits| digits.len() <= 2 && digits.bytes().all(|byte| byte.is_ascii_digit()));
            let is_first = match number.and_then(|digits| digits.parse::<u8>().ok()) {
                Some(0) => modes.is_rapid.replace(true).is_none(),
                Some(1) => modes.is_rapid.replace(false).is_none(),
                Some(17) => modes.plane.replace(2).is_none(),
                Some(18) => modes.plane.replace(1).is_none(),
                Some(19) => modes.plane.replace(0).is_none(),
                Some(90) => modes.incremental.replace(false).is_none(),
                Some(91) => modes.incremental.replace(true).is_none(),
                Some(94) => modes.is_per_turn.replace(false).is_none(),
                Some(95) => modes.is_per_turn.replace(true).is_none(),
                Some(98) => modes.retract.replace(Retract::Initial).is_none(),
                Some(99) => modes.retract.replace(Retract::Plane).is_none(),
                _ => return Err(StartCodesFault::NoMode(shown())),
            };
            if !is_first {
                return Err(StartCodesFault::Twice(shown()));
            }
        }
        Ok(modes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_modes_and_everything_else_is_named() {
        let modes = StartModes::from_codes("G01 g17 G90  G95 g98").unwrap();
        let expected = StartModes {
            is_rapid: Some(false),
            plane: Some(2),
            incremental: Some(false),
            is_per_turn: Some(true),
            retract: Some(Retract::Initial),
        };
        assert_eq!(modes, expected);
        assert_eq!(StartModes::from_codes("").unwrap(), StartModes::default());
        for wrong in ["G2", "G", "G1X", "1", "G001", "G-1", "G+1", "X5", "G1.0", "G256", "GG1", "é"] {
            assert_eq!(
                StartModes::from_codes(wrong),
                Err(StartCodesFault::NoMode(wrong.to_owned())),
                "{wrong}"
            );
        }
        for twice in ["G0 G1", "G17 G17", "G90 G91", "G94 G95", "G98 G99"] {
            assert!(matches!(StartModes::from_codes(twice), Err(StartCodesFault::Twice(_))), "{twice}");
        }
    }
}
