//! Which instructions a loop over lanes may use. The results do not depend on it.

/// The widest instructions a batch loop may use; what the processor lacks is left out by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InstructionSet {
    /// Those every processor of the target has (SSE2 on x86-64).
    Baseline,
    /// Up to AVX2.
    Avx2,
    /// Up to AVX-512.
    Avx512,
    /// What has been found the fastest here.
    #[default]
    Fastest,
}
