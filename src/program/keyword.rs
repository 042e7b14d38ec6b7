//! Statement words: what controls write in letters where ISO has a code.

macro_rules! keywords {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        /// A statement word of some dialect. Its meaning for the path is in `motion`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Keyword {
            $($(#[$doc])* $name,)*
        }

        impl Keyword {
            /// All of them, by number.
            pub const ALL: &[Self] = &[$(Self::$name),*];
        }
    };
}

keywords! {
    // --- Siemens
    /// `TRAORI`: tool-centre-point control on.
    Traori,
    /// `TRAFOOF`: transformations off.
    Trafoof,
    /// `SUPA`: machine coordinates, offsets suppressed, in this block.
    Supa,
    // --- Heidenhain
    /// `L`: a straight line.
    L,
    /// `FMAX`: at rapid traverse, in this block.
    Fmax,
    // --- APT
    /// `GOTO/`: a straight motion to a point.
    Goto,
    /// `RAPID`: the next motion is one at rapid traverse.
    Rapid,
}

impl Keyword {
    /// Its number, the value of its words.
    #[must_use]
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// The keyword of this number.
    #[must_use]
    pub fn of_number(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_keywords_belong_together() {
        for (number, keyword) in (0..).zip(Keyword::ALL) {
            assert_eq!(keyword.number(), number);
            assert_eq!(Keyword::of_number(number), Some(*keyword));
        }
        assert_eq!(Keyword::of_number(u16::MAX), None);
    }
}
