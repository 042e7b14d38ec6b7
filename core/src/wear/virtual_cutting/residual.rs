//! The residual at one sample.

/// The residual of a program at one sample of the surface, along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// + excess (material left), − gouge \[mm\].
    pub residual_mm: f64,
    /// Line of the program with the motion that made it. If several leave the same residual, one of them.
    pub line: u64,
    /// Whether that motion is a rapid.
    pub by_rapid: bool,
}
