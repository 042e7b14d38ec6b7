//! A text that was written out makes the motions of its program.

use std::ops::ControlFlow;

use crate::machine::Machine;
use crate::motion::{Motion, MotionKind};
use crate::process::fault::Fault;
use crate::process::set_up::{ProgramSetup, Stop};
use crate::process::text::{Passages, ProgramSource};
use crate::program::{ByteSpan, Diagnostic, DiagnosticCode, Diagnostics, Excerpt};

/// Numbers are written with six decimals, and several may add up in incremental words \[mm, deg\].
const WRITTEN: f64 = 1e-4;

/// What a motion is compared by.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    kind: MotionKind,
    line: u64,
    is_followed: bool,
    /// X Y Z and the rotary axes at its end, NaN if not known.
    at: [f64; 5],
    /// F, NaN if not known.
    feed: f64,
}

impl Seen {
    fn of(motion: &Motion, position: [Option<f64>; 5]) -> Self {
        Self {
            kind: motion.kind,
            line: motion.line,
            is_followed: motion.unfollowable.is_none(),
            at: position.map(|at| at.unwrap_or(f64::NAN)),
            feed: motion.feed.value.unwrap_or(f64::NAN),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= WRITTEN || (a.is_nan() && b.is_nan());
        self.kind == other.kind
            && self.is_followed == other.is_followed
            && self.at.iter().zip(other.at).all(|(a, b)| near(*a, b))
            && near(self.feed, other.feed)
    }
}

fn motions(
    machine: &Machine,
    program: &ProgramSetup,
    source: &dyn ProgramSource,
    stop: &Stop<'_>,
    take: &mut dyn FnMut(Seen) -> ControlFlow<()>,
) -> Result<(), Fault> {
    let passages = Passages::open(source, machine, program)?;
    let mut passages = passages.following_its_run(machine, program).keeping_positions();
    let mut has_ended = false;
    passages.work(stop, |passage, _, _| {
        for (motion, position) in passage.motions.iter().zip(&passage.positions) {
            has_ended = has_ended || take(Seen::of(motion, *position)).is_break();
        }
        Ok(())
    })
}

/// Compares the motions of a text that was written out with those of its program.
///
/// # Errors
/// They differ, one of them cannot be read, or the caller no longer waits.
pub(super) fn check(
    machine: &Machine,
    program: &ProgramSetup,
    source: &dyn ProgramSource,
    written: &dyn ProgramSource,
    stop: &Stop<'_>,
) -> Result<(), Fault> {
    let mut expected = Vec::new();
    motions(machine, program, source, stop, &mut |seen| {
        expected.push(seen);
        ControlFlow::Continue(())
    })?;
    let (mut count, mut differs) = (0, None);
    motions(machine, program, written, stop, &mut |seen| {
        let like = expected.get(count).filter(|expected| expected.is_like(&seen));
        if like.is_none() {
            differs = Some(expected.get(count).map_or(0, |expected| expected.line));
            return ControlFlow::Break(());
        }
        count += 1;
        ControlFlow::Continue(())
    })?;
    if differs.is_none() && count < expected.len() {
        differs = expected.get(count).map(|expected| expected.line);
    }
    let Some(line) = differs else { return Ok(()) };
    let reason = "the motion written out is not that of the program: rounded values add up, or a code is computed; write numbers, or send the program without flatten";
    let mut refusals = Diagnostics::new();
    refusals.push(Diagnostic {
        code: DiagnosticCode::NotWrittenOut { text: Excerpt::new(b"motion"), reason },
        line,
        column: 1,
        span: ByteSpan { start: 0, end: 0 },
    });
    Err(Fault::Program(Box::new(refusals)))
}
