//! A text that was written out makes the motions of its program.

use crate::machine::Machine;
use crate::motion::{Motion, MotionKind};
use crate::process::fault::Fault;
use crate::process::set_up::{ProgramSetup, Stop};
use crate::process::text::{Passage, Passages, ProgramSource};
use crate::program::{ByteSpan, Diagnostic, DiagnosticCode, Diagnostics, Excerpt};

/// A tenth of what the controls count, for numbers with six decimals that add up in incremental words \[mm, deg\].
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

/// The motions of a program, one after the other.
struct Motions<'a> {
    passages: Passages<'a>,
    present: Passage,
    /// The next motion of the present passage.
    next: usize,
}

impl<'a> Motions<'a> {
    fn open(machine: &Machine, program: &ProgramSetup, source: &'a dyn ProgramSource) -> Result<Self, Fault> {
        let passages = Passages::open(source, machine, program)?;
        let passages = passages.following_its_run(machine, program).keeping_positions();
        Ok(Self { passages, present: Passage::default(), next: 0 })
    }

    fn next(&mut self, stop: &Stop<'_>) -> Result<Option<Seen>, Fault> {
        loop {
            let Passage { motions, positions, .. } = &self.present;
            if let Some((motion, position)) = motions.get(self.next).zip(positions.get(self.next)) {
                self.next += 1;
                return Ok(Some(Seen::of(motion, *position)));
            }
            if stop().is_break() {
                return Err(Fault::Cancelled);
            }
            let Some((passage, _)) = self.passages.next()? else { return Ok(None) };
            self.passages.recycle(std::mem::replace(&mut self.present, passage));
            self.next = 0;
        }
    }
}

/// Compares the motions of a text that was written out with those of its program, side by side, so that their number
/// takes no memory.
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
    let mut expected = Motions::open(machine, program, source)?;
    let mut found = Motions::open(machine, program, written)?;
    let mut last_line = 0;
    let line = loop {
        match (expected.next(stop)?, found.next(stop)?) {
            (None, None) => break None,
            (Some(one), Some(other)) if one.is_like(&other) => last_line = one.line,
            (Some(one), _) => break Some(one.line),
            (None, Some(_)) => break Some(last_line),
        }
    };
    expected.passages.refusals()?;
    found.passages.refusals()?;
    let Some(line) = line else { return Ok(()) };
    let reason = "the motion written out is not that of the program: rounded values add up, or a code is computed; write numbers, or send the program without flatten";
    let mut refusals = Diagnostics::new();
    refusals.push(Diagnostic {
        code: DiagnosticCode::NotWrittenOut { text: Excerpt::new(b"motion"), reason },
        line,
        called: None,
        column: 1,
        span: ByteSpan { start: 0, end: 0 },
    });
    Err(Fault::Program(Box::new(refusals)))
}
