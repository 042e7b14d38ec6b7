//! Word addresses.

use std::fmt;

/// The address of a word: a letter A to Z, a component of a contact normal (`nx ny nz`), or one of the tool axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address(u8);

macro_rules! letters {
    ($($name:ident = $byte:literal),*) => { $(#[doc = concat!("The letter ", stringify!($name), ".")] pub const $name: Self = Self($byte);)* };
}

impl Address {
    letters!(
        A = b'A',
        B = b'B',
        C = b'C',
        D = b'D',
        E = b'E',
        F = b'F',
        G = b'G',
        H = b'H',
        I = b'I',
        J = b'J',
        K = b'K',
        L = b'L',
        M = b'M',
        N = b'N',
        O = b'O',
        P = b'P',
        Q = b'Q',
        R = b'R',
        S = b'S',
        T = b'T',
        U = b'U',
        V = b'V',
        W = b'W',
        X = b'X',
        Y = b'Y',
        Z = b'Z'
    );
    /// Contact normal, x component (CSV column `nx`).
    pub const NX: Self = Self(b'Z' + 1);
    /// Contact normal, y component (CSV column `ny`).
    pub const NY: Self = Self(b'Z' + 2);
    /// Contact normal, z component (CSV column `nz`).
    pub const NZ: Self = Self(b'Z' + 3);

    /// Tool axis, first component (Siemens `A3=`, APT i, G43.5 I).
    pub const TI: Self = Self(b'Z' + 4);
    /// Tool axis, second component.
    pub const TJ: Self = Self(b'Z' + 5);
    /// Tool axis, third component.
    pub const TK: Self = Self(b'Z' + 6);

    /// The address written as this letter, upper or lower case; `None` for any other byte.
    #[must_use]
    pub const fn from_letter(letter: u8) -> Option<Self> {
        if letter.is_ascii_alphabetic() { Some(Self(letter.to_ascii_uppercase())) } else { None }
    }

    /// For the lexer, which has already checked that `letter` is a letter.
    pub(super) const fn of_letter(letter: u8) -> Self {
        Self(letter & !0x20)
    }

    /// The upper-case letter; `None` for components of vectors.
    #[must_use]
    pub const fn letter(self) -> Option<u8> {
        if self.0.is_ascii_uppercase() { Some(self.0) } else { None }
    }

    /// A small unique number for every address, below 32: letters 0–25, `nx ny nz` 26–28, tool axis 29–31.
    #[must_use]
    pub const fn index(self) -> usize {
        (self.0 - b'A') as usize
    }

    /// A number with only the bit of [`Self::index`] set, for sets of addresses.
    #[must_use]
    pub const fn bit(self) -> u32 {
        1 << self.index()
    }

    /// The bits of X Y Z A B C.
    pub const AXES: u32 =
        Self::X.bit() | Self::Y.bit() | Self::Z.bit() | Self::A.bit() | Self::B.bit() | Self::C.bit();

    /// The bits of all addresses whose words state a place to go to: X Y Z, A B C, U V W, E, nx ny nz, tool axis.
    pub const COORDINATES: u32 = Self::AXES
        | Self::U.bit()
        | Self::V.bit()
        | Self::W.bit()
        | Self::E.bit()
        | Self::NX.bit()
        | Self::NY.bit()
        | Self::NZ.bit()
        | Self::TI.bit()
        | Self::TJ.bit()
        | Self::TK.bit();

    /// Whether words of this address state a place to go to.
    #[must_use]
    pub const fn is_coordinate(self) -> bool {
        self.bit() & Self::COORDINATES != 0
    }

    /// The address as a column heading or in a message.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        const NAMES: [&str; 32] = [
            "A",
            "B",
            "C",
            "D",
            "E",
            "F",
            "G",
            "H",
            "I",
            "J",
            "K",
            "L",
            "M",
            "N",
            "O",
            "P",
            "Q",
            "R",
            "S",
            "T",
            "U",
            "V",
            "W",
            "X",
            "Y",
            "Z",
            "nx",
            "ny",
            "nz",
            "tool axis i",
            "tool axis j",
            "tool axis k",
        ];
        NAMES[self.index()]
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
