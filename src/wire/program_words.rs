//! Words that the parameters and reports of all operations on programs share.

use serde::{Deserialize, Serialize};

use crate::description::ToSchema;
use crate::{motion, process, program};

/// Where the cutter contact comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Contact {
    /// The first available of program, normals and surface; else the tip.
    #[default]
    Auto,
    /// U V W words of the program.
    Program,
    /// Contact normals nx ny nz.
    Normals,
    /// The surface of the part.
    Surface,
    /// Assumed from the feed direction, where rotary axes turn.
    FeedPlane,
    /// The tool tip itself.
    Tip,
}

impl From<process::ContactSource> for Contact {
    fn from(core: process::ContactSource) -> Self {
        match core {
            process::ContactSource::Auto => Self::Auto,
            process::ContactSource::Program => Self::Program,
            process::ContactSource::Normals => Self::Normals,
            process::ContactSource::FeedPlane => Self::FeedPlane,
            process::ContactSource::Surface => Self::Surface,
            process::ContactSource::Tip => Self::Tip,
        }
    }
}

/// Interpolation of the control. If it is absent, the program decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The axis words.
    Machine,
    /// The tool tip in the workpiece, with tool centre point control on.
    Tcp,
}

impl Interpolation {
    /// The value in the core's terms.
    #[must_use]
    pub const fn to_core(self) -> motion::Interpolation {
        match self {
            Self::Machine => motion::Interpolation::Machine,
            Self::Tcp => motion::Interpolation::Tcp,
        }
    }
}

impl From<motion::Interpolation> for Interpolation {
    fn from(core: motion::Interpolation) -> Self {
        match core {
            motion::Interpolation::Machine => Self::Machine,
            motion::Interpolation::Tcp => Self::Tcp,
        }
    }
}

/// Dialect of the program text.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dialect {
    /// The service finds it from the text.
    #[default]
    Auto,
    /// ISO G-code.
    Iso,
    /// Siemens.
    Siemens,
    /// Heidenhain.
    Heidenhain,
    /// APT CL data.
    Apt,
    /// Columns separated by commas.
    Csv,
    /// Okuma OSP for machining centres.
    Okuma,
}

impl From<program::Dialect> for Dialect {
    fn from(core: program::Dialect) -> Self {
        match core {
            program::Dialect::Iso => Self::Iso,
            program::Dialect::Siemens => Self::Siemens,
            program::Dialect::Heidenhain => Self::Heidenhain,
            program::Dialect::Apt => Self::Apt,
            program::Dialect::Csv => Self::Csv,
            program::Dialect::Okuma => Self::Okuma,
        }
    }
}

impl Dialect {
    /// The dialect in the core's terms; `None` if it is to be found from the text.
    #[must_use]
    pub fn to_core(self) -> Option<program::Dialect> {
        match self {
            Self::Auto => None,
            Self::Iso => Some(program::Dialect::Iso),
            Self::Siemens => Some(program::Dialect::Siemens),
            Self::Heidenhain => Some(program::Dialect::Heidenhain),
            Self::Apt => Some(program::Dialect::Apt),
            Self::Csv => Some(program::Dialect::Csv),
            Self::Okuma => Some(program::Dialect::Okuma),
        }
    }
}

/// A step of a compensation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StepName {
    /// Ends of motions were moved for a worn cutter.
    Wear,
    /// Ends of motions were moved for the location errors of the machine.
    LocationErrors,
    /// The cutter-contact path between the ends was corrected.
    Cc,
    /// Singular regions were treated.
    Singularity,
}

impl StepName {
    /// The names of steps.
    #[must_use]
    pub fn all_of(steps: program::Steps) -> Vec<Self> {
        steps.iter().map(Self::of).collect()
    }

    const fn of(step: program::StepName) -> Self {
        match step {
            program::StepName::Wear => Self::Wear,
            program::StepName::LocationErrors => Self::LocationErrors,
            program::StepName::Cc => Self::Cc,
            program::StepName::Singularity => Self::Singularity,
        }
    }
}
