//! The stamp of a compensated program: one comment that states which steps changed it, so that no step is done twice.

mod find;
mod place;
mod steps;

pub use find::{Borne, StampFinder, borne_by};
pub use place::{StampPlace, place_stamp};
pub use steps::{StepName, Steps};

use std::fmt;

/// The contents of a stamp. They do not depend on when or by which job the program was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp {
    /// Version of the software.
    pub version: String,
    /// The operation, by its name in the contract.
    pub operation: String,
    /// The steps that changed something.
    pub steps: Steps,
    /// The machine, and its revision.
    pub machine: String,
    /// See [`Self::machine`].
    pub revision: i64,
    /// The tool, if exactly one was used.
    pub tool: Option<String>,
    /// The beginning of the digest of the source, in hexadecimal digits.
    pub source: String,
    /// The beginning of the digest of the resolved parameters, in hexadecimal digits.
    pub parameters: String,
}

/// The word with which a stamp begins.
const MARK: &str = "Trunnion";
/// The word before the steps.
const STEPS: &str = "steps";
/// The word after the steps.
const MACHINE: &str = "machine";

impl fmt::Display for Stamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, operation, steps, machine, revision, tool, source, parameters } = self;
        let machine = plain(machine);
        write!(f, "{MARK} {version} {operation} {STEPS} {steps} {MACHINE} {machine} revision {revision}")?;
        if let Some(tool) = tool {
            write!(f, " tool {}", plain(tool))?;
        }
        write!(f, " source {source} parameters {parameters}")
    }
}

/// A name in a form for comments of every dialect: letters, digits, `.`, `_` and `-` stay, and `_` replaces all other
/// characters.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || ".-".contains(c) { c } else { '_' }).collect()
}
