//! Axes of which nobody knows where they stand, for the words of a refusal.

use std::fmt;
use std::ops::ControlFlow;

use super::pipeline::LineCursor;
use super::stream::Passages;
use super::{Fault, LineFaultKind, LineFaults, ProgramSetup, ProgramSource};
use crate::machine::Machine;

/// The letters of axes that are not known; at least one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnknownAxes {
    letters: [Option<char>; 5],
    first: char,
}

impl UnknownAxes {
    /// Those of these letters that stand nowhere known; `None` where all of them do.
    fn of(letters: [char; 5], position: [Option<f64>; 5]) -> Option<Self> {
        let unknown: [Option<char>; 5] = std::array::from_fn(|k| position[k].is_none().then_some(letters[k]));
        // A rotary axis that is never named is what `start` is for most often.
        let first = unknown[3..].iter().chain(&unknown).flatten().next().copied()?;
        Some(Self { letters: unknown, first })
    }

    /// One of them, for an example.
    #[must_use]
    pub const fn first(&self) -> char {
        self.first
    }
}

impl fmt::Display for UnknownAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, letter) in self.letters.iter().flatten().enumerate() {
            write!(f, "{}{letter}", if index > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

/// The faults, with the axes named where not all of them are known. The program is read once more for it.
///
/// # Errors
/// It cannot be read, or nobody waits any more.
pub(super) fn naming_unknown_axes(
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
