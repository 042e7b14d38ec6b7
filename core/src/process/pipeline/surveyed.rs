//! The demands of a step on a program, and the facts that the step has before it reads the motions.

use super::resources::Resources;
use crate::process::fault::Fault;
use crate::process::set_up::{ContactSource, ProgramSetup};
use crate::process::text::{ProgramSource, Survey};
use crate::program::Steps;

/// What a step asks of a program.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct Asked<'p> {
    pub(in crate::process) program: &'p ProgramSetup,
    /// The steps that must not have been done to it before. Empty for a step that changes nothing.
    pub(in crate::process) steps: Steps,
    pub(in crate::process) contact: ContactSource,
    /// Whether a part was sent with it.
    pub(in crate::process) has_part: bool,
}

/// What a step knows of a program before it follows it.
#[derive(Clone, Copy)]
pub(in crate::process) struct Surveyed<'s> {
    pub(in crate::process) source: &'s dyn ProgramSource,
    pub(in crate::process) survey: Survey,
    /// Whether the survey covers the whole program. Otherwise the rest is surveyed while it is read.
    pub(in crate::process) is_whole: bool,
    /// The source of its contacts, with `auto` resolved.
    pub(in crate::process) contact: ContactSource,
    /// The set-up with the tools that the contacts need, if the step has found them.
    pub(in crate::process) program: Option<&'s ProgramSetup>,
}

impl<'s> Surveyed<'s> {
    /// Surveys a program for a step.
    ///
    /// # Errors
    /// The program already had this step, has no such contacts, or cannot be read; or the caller no longer waits.
    pub(in crate::process) fn of(
        source: &'s dyn ProgramSource,
        asked: &Asked<'_>,
        with: &Resources<'_>,
    ) -> Result<Self, Fault> {
        let ProgramSetup { dialect, survey: extent, steps_done, allow_repeated, .. } = *asked.program;
        let (mut survey, is_whole) = Survey::of(with.machine, dialect, source, extent, with.stop)?;
        survey.borne.steps = survey.borne.steps.and(steps_done);
        let contact = survey
            .refuse_repeated(asked.steps, allow_repeated)
            .and_then(|()| survey.contact(asked.contact, asked.has_part))
            .map_err(|fault| if is_whole { fault } else { before_the_end(fault) })?;
        Ok(Self { source, survey, is_whole, contact, program: None })
    }

    /// A fault from before the end of the program. If only the head was surveyed, the head may be its cause.
    pub(in crate::process) fn before_the_end(&self, fault: Fault) -> Fault {
        if self.is_whole { fault } else { before_the_end(fault) }
    }

    /// Checks that the survey holds for the program, which was surveyed to its end while a step read it.
    ///
    /// # Errors
    /// The rest of the program shows what its head did not.
    pub(in crate::process) fn confirm(&self, read: Option<Survey>) -> Result<(), Fault> {
        let Some(mut whole) = read else { return Ok(()) };
        // Steps that the caller knows of were added to those of the stamps.
        whole.borne.steps = whole.borne.steps.and(self.survey.borne.steps);
        if self.survey.holds_for(&whole) { Ok(()) } else { Err(Fault::HeadMisled) }
    }

    /// The same with the set-up that has the tools of the contacts.
    pub(in crate::process) fn with_tools_of(self, program: &'s ProgramSetup) -> Self {
        Self { program: Some(program), ..self }
    }
}

/// The fault of a step that has only surveyed the head of its program, and has not read it to its end.
fn before_the_end(fault: Fault) -> Fault {
    match fault {
        // A second attempt would end in the same way.
        Fault::Cancelled | Fault::Io(_) | Fault::TooCostly { .. } => fault,
        _ => Fault::HeadMisled,
    }
}
