//! The instructions that a loop over lanes may use. The results do not depend on them.

/// The widest instructions a batch loop may use. Instructions that the processor lacks are not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InstructionSet {
    /// The instructions of every processor of the target (SSE2 on x86-64).
    Baseline,
    /// Up to AVX2.
    Avx2,
    /// Up to AVX-512.
    Avx512,
    /// The fastest instructions found on this processor.
    #[default]
    Fastest,
}
