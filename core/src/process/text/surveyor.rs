//! A survey that grows while another part reads the text.

use super::survey::Survey;
use crate::machine::Machine;
use crate::motion::rotary_addresses;
use crate::program::{Address, Batch, StampFinder};

/// A survey under way. It gets the text, and the batches that were read from it.
#[derive(Debug)]
pub(in crate::process) struct Surveyor {
    survey: Survey,
    stamps: StampFinder,
    rotary: [Address; 2],
}

impl Surveyor {
    /// Nothing is surveyed yet.
    pub(in crate::process) fn new(machine: &Machine) -> Self {
        let (survey, stamps) = (Survey::nothing(), StampFinder::default());
        Self { survey, stamps, rotary: rotary_addresses(machine) }
    }

    /// Looks at the next piece of the text.
    pub(in crate::process) fn see_text(&mut self, text: &[u8]) {
        self.stamps.see(text);
    }

    /// Looks at the next batch of its blocks.
    pub(in crate::process) fn see(&mut self, batch: &Batch) {
        self.survey.see(batch, self.rotary);
    }

    /// The survey so far. It leaves out a stamp that may not be complete.
    pub(super) fn so_far(&self) -> Survey {
        Survey { borne: self.stamps.so_far(), ..self.survey }
    }

    /// The survey of the text, which has ended.
    pub(in crate::process) fn finish(self) -> Survey {
        Survey { borne: self.stamps.finish(), ..self.survey }
    }
}
