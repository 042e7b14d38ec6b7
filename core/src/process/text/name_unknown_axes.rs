//! The unknown axes at a motion that could not be followed, for the text of a refusal.

use super::line_map::LineCursor;
use super::source::ProgramSource;
use super::stream::Passages;
use crate::machine::Machine;
use crate::process::fault::{Fault, LineFaultKind, LineFaults, UnknownAxes};
use crate::process::set_up::ProgramSetup;
use std::ops::ControlFlow;

/// The faults, with the unknown axes named if some are unknown. The program is read once more for this.
///
/// # Errors
/// The program cannot be read, or the caller no longer waits.
pub(in crate::process) fn naming_unknown_axes(
    mut faults: LineFaults,
    machine: &Machine,
    program: &ProgramSetup,
    source: &dyn ProgramSource,
    lines: Vec<LineCursor<'_>>,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<LineFaults, Fault> {
    let is_of_axes = |kind: &LineFaultKind| matches!(kind, LineFaultKind::PositionUnknown);
    if !faults.kept.iter().any(|fault| is_of_axes(&fault.kind)) {
        return Ok(faults);
    }
    let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
    let letters = ['X', 'Y', 'Z', first, second];
    let mut passages = Passages::open(source, machine, program)?.with_lines(lines).keeping_positions();
    let mut before = None;
    passages.work(stop, |passage, _, _| {
        for (motion, position) in passage.motions.iter().zip(&passage.positions) {
            let at_start = before.replace(*position).unwrap_or([None; 5]);
            let here = faults.kept.iter_mut().filter(|fault| fault.line == motion.line);
            for fault in here.filter(|fault| is_of_axes(&fault.kind)) {
                let unknown = UnknownAxes::of(letters, *position).or(UnknownAxes::of(letters, at_start));
                fault.kind = unknown
                    .map_or(LineFaultKind::PositionUnknown, |axes| LineFaultKind::AxesUnknown { axes });
            }
        }
        Ok(())
    })?;
    Ok(faults)
}
