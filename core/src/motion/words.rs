//! Axis, contact and extra words with their values, and the decimals with which they are written.

/// The five axis words of one point of a program: NC words, not kinematic angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisWords {
    /// X Y Z \[mm\], in W under tool-centre-point interpolation, in machine axes otherwise.
    pub linear_mm: [f64; 3],
    /// The two rotary words in the order of the machine profile \[deg\], never wrapped.
    pub rotary_deg: [f64; 2],
}

/// What the program says about the cutter contact at the end of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactWords {
    /// The program says nothing.
    None,
    /// The contact point, U V W \[mm\], as absolute words. U V W are modal among themselves.
    Point([f64; 3]),
    /// The contact normal `nx ny nz`, as written (not normalised).
    Normal([f64; 3]),
}

/// The extruder word E, in program units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extra {
    /// Value before the motion; `None` if not known.
    pub start: Option<f64>,
    /// Value after the motion.
    pub end: f64,
}

/// Digits after the decimal point, by class of word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Decimals {
    /// X Y Z.
    pub linear: u8,
    /// The machine's two rotary words, or the tool vector instead of them.
    pub rotary: u8,
    /// U V W or nx ny nz.
    pub contact: u8,
    /// E.
    pub extra: u8,
}
