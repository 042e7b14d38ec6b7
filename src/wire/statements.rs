//! What a request states about a program if its text does not: members that every operation on programs has.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{
    CcParameters, Dialect, Fault, FaultList, Fixed, Interpolation, ProgramUnit, RadiusOffsets, WorkOffsets,
};
use crate::description::ToSchema;
use crate::machine::Machine;
use crate::motion::{self, StartModes, WorkOffset};
use crate::process::{ProgramSetup, StartPosition, ToolTable, Tools};
use crate::units::{Feedrate, Length};

/// Declares the parameters of an operation on programs: first its own members, then the members that all of
/// these operations have.
macro_rules! program_parameters {
    (
        $(#[$meta:meta])*
        pub struct $name:ident { $($(#[$member_meta:meta])* pub $member:ident: $kind:ty,)* }
    ) => {
        $(#[$meta])*
        pub struct $name {
            $($(#[$member_meta])* pub $member: $kind,)*
            /// Interpolation of the control. If it is absent, the program decides.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub interpolation: Option<$crate::wire::Interpolation>,
            /// Unit of the lengths if the program does not state one. If it is absent, the machine's
            /// `program_unit` is used.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub unit: Option<$crate::wire::ProgramUnit>,
            /// Origin of the workpiece in machine coordinates at zero pose, for a program that names at most
            /// one work offset. Zero is a valid answer. If it is absent, the machine's `work_offsets_mm` are
            /// used.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(example = json!([0.0, 0.0, 0.0]))]
            pub work_offset_mm: Option<$crate::wire::Fixed<3>>,
            /// Origins of the work offsets that the program names. In a query: `work_offsets_mm.G54.1 P3`.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub work_offsets_mm: Option<$crate::wire::WorkOffsets>,
            /// Radii in the registers that G41 and G42 name, geometry and wear together.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub radius_offsets_mm: Option<$crate::wire::RadiusOffsets>,
            /// Length of the tool, for head axes and machine coordinates. Zero is a valid answer. If it is absent,
            /// the machine's tool table is used.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub tool_length_mm: Option<f64>,
            /// Number of the tool to work on, if the program has several; motions with other tools are left
            /// unchanged. A program that calls no tool runs with this one. If it is absent, each section gets
            /// its tool from the machine's tool table.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            #[schema(example = 12)]
            pub tool_number: Option<u32>,
            /// Positions of the axes before the first block, as words in the program's first work offset.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub start: Option<$crate::wire::StartWords>,
            /// Feed, if the program has none.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub feed_mm_per_min: Option<f64>,
            /// Dialect of the program text.
            #[serde(default)]
            pub dialect: $crate::wire::Dialect,
        }

        impl $name {
            /// What the request states about the program.
            #[must_use]
            pub fn statements(&self) -> $crate::wire::Statements<'_> {
                $crate::wire::Statements {
                    interpolation: self.interpolation,
                    unit: self.unit,
                    work_offset_mm: self.work_offset_mm,
                    work_offsets_mm: self.work_offsets_mm.as_ref(),
                    radius_offsets_mm: self.radius_offsets_mm.as_ref(),
                    tool_length_mm: self.tool_length_mm,
                    tool_number: self.tool_number,
                    start: self.start,
                    feed_mm_per_min: self.feed_mm_per_min,
                    dialect: self.dialect,
                }
            }
        }
    };
}
pub(super) use program_parameters;

/// Axis words before the first block; leave out words that are not known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "UPPERCASE")]
pub struct StartWords {
    /// Position of X before the first block, as a word in the program's first work offset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0)]
    pub x: Option<f64>,
    /// Position of Y before the first block, as a word in the program's first work offset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0)]
    pub y: Option<f64>,
    /// Position of Z before the first block, as a word in the program's first work offset.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0)]
    pub z: Option<f64>,
    /// Position of A before the first block, if the machine has this axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0)]
    pub a: Option<f64>,
    /// Position of B before the first block, if the machine has this axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0)]
    pub b: Option<f64>,
    /// Position of C before the first block, if the machine has this axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0)]
    pub c: Option<f64>,
}

/// Whether a changed program says so in its text.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StampForm {
    /// One comment names the steps that changed the program, the machine's revision, and the digests of
    /// source and parameters.
    #[default]
    Comment,
    /// Nothing is added to the program. Its text then does not show that it was compensated.
    None,
}

/// What a request states about a program.
#[derive(Debug, Clone, Copy)]
#[expect(missing_docs, reason = "the members are described where requests declare them")]
pub struct Statements<'a> {
    pub interpolation: Option<Interpolation>,
    pub unit: Option<ProgramUnit>,
    pub work_offset_mm: Option<Fixed<3>>,
    pub work_offsets_mm: Option<&'a WorkOffsets>,
    pub radius_offsets_mm: Option<&'a RadiusOffsets>,
    pub tool_length_mm: Option<f64>,
    pub tool_number: Option<u32>,
    pub start: Option<StartWords>,
    pub feed_mm_per_min: Option<f64>,
    pub dialect: Dialect,
}

/// What the machine's profile states about the programs that run on it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MachineStatements {
    /// Unit of a program that does not state one.
    pub unit: Option<ProgramUnit>,
    /// Modes before the first block.
    pub start_modes: StartModes,
    /// Origins of the work offsets.
    pub work_offsets_mm: Option<WorkOffsets>,
    /// Largest F that may be written.
    pub max_feed_mm_per_min: Option<f64>,
    /// Shortest time of a block.
    pub block_time_ms: Option<f64>,
}

impl MachineStatements {
    /// The statements of a profile.
    #[must_use]
    pub fn of(profile: &super::MachineProfile) -> Self {
        Self {
            unit: profile.program_unit,
            // A stored profile was checked.
            start_modes: profile
                .start_codes
                .as_deref()
                .map(StartModes::from_codes)
                .and_then(Result::ok)
                .unwrap_or_default(),
            work_offsets_mm: profile.work_offsets_mm.clone(),
            max_feed_mm_per_min: profile.max_feed_mm_per_min,
            block_time_ms: profile.block_time_ms,
        }
    }

    /// Largest F that may be written: the request wins over the profile.
    #[must_use]
    pub fn max_feed(&self, stated_mm_per_min: Option<f64>) -> Option<Feedrate> {
        stated_mm_per_min.or(self.max_feed_mm_per_min).map(Feedrate::from_mm_per_min)
    }

    /// Shortest time of a block \[s\].
    #[must_use]
    pub fn block_time_s(&self) -> Option<f64> {
        self.block_time_ms.map(|time_ms| time_ms / MS_PER_S)
    }
}

/// Milliseconds in a second.
const MS_PER_S: f64 = 1000.0;

impl Statements<'_> {
    /// Reports every bad value that can be found without a machine.
    pub fn check(&self, faults: &mut FaultList) {
        let max_mm = CcParameters::MAX_OFFSET_MM;
        for (index, offset_mm) in self.work_offset_mm.into_iter().flat_map(|offset| offset.0).enumerate() {
            faults.check_range(|| format!("/work_offset_mm/{index}"), offset_mm, -max_mm, max_mm);
        }
        if let Some(offsets) = self.work_offsets_mm {
            offsets.check("/work_offsets_mm", faults);
        }
        if let Some(radii) = self.radius_offsets_mm {
            radii.check(faults);
        }
        if let Some(length_mm) = self.tool_length_mm {
            faults.check_range(|| "/tool_length_mm".to_owned(), length_mm, -max_mm, max_mm);
        }
        if let Some(feed) = self.feed_mm_per_min {
            let max = CcParameters::MAX_FEED_MM_PER_MIN;
            faults.check_range(|| "/feed_mm_per_min".to_owned(), feed, 1e-6, max);
        }
        if let Some(start) = self.start {
            start.check(faults);
        }
    }

    /// The program's set-up on this machine, in the core's terms. Letters that the machine lacks are added to
    /// `faults`.
    pub fn to_core(
        &self,
        machine: &Machine,
        of_machine: &MachineStatements,
        table: &Arc<ToolTable>,
        apply_errors: bool,
        faults: &mut FaultList,
    ) -> ProgramSetup {
        let work_offsets = motion::WorkOffsets {
            only_mm: self.work_offset_mm.map(|offset| offset.0),
            named_mm: self.work_offsets_mm.map(by_name).unwrap_or_default(),
            of_machine_mm: of_machine.work_offsets_mm.as_ref().map(by_name).unwrap_or_default(),
        };
        ProgramSetup {
            dialect: self.dialect.to_core(),
            unit: self.unit.or(of_machine.unit).map(ProgramUnit::to_core),
            interpolation: self.interpolation.map(Interpolation::to_core),
            feed: self.feed_mm_per_min.map(Feedrate::from_mm_per_min),
            work_offsets: Arc::new(work_offsets),
            radius_offsets: Arc::new(self.radius_offsets_mm.map(RadiusOffsets::to_core).unwrap_or_default()),
            tools: Tools::with(self.tool_number, self.tool_length_mm.map(Length::from_mm), Arc::clone(table)),
            start_modes: of_machine.start_modes,
            start: self.start.map_or_else(StartPosition::default, |start| start.to_core(machine, faults)),
            apply_errors,
            ..ProgramSetup::default()
        }
    }
}

fn by_name(offsets: &WorkOffsets) -> std::collections::BTreeMap<WorkOffset, [f64; 3]> {
    offsets.iter().filter_map(|(name, offset_mm)| Some((WorkOffset::from_name(name)?, offset_mm))).collect()
}

impl StartWords {
    /// Letters with their words.
    fn words(self) -> [(char, Option<f64>); 6] {
        [('X', self.x), ('Y', self.y), ('Z', self.z), ('A', self.a), ('B', self.b), ('C', self.c)]
    }

    fn check(self, faults: &mut FaultList) {
        for (letter, word) in self.words() {
            let max =
                if "XYZ".contains(letter) { CcParameters::MAX_OFFSET_MM } else { Machine::MAX_TRAVEL_DEG };
            if let Some(word) = word {
                faults.check_range(|| format!("/start/{letter}"), word, -max, max);
            }
        }
    }

    fn to_core(self, machine: &Machine, faults: &mut FaultList) -> StartPosition {
        let axes = machine.rotary_axes();
        let mut start = StartPosition { linear_mm: [self.x, self.y, self.z], rotary_deg: [None; 2] };
        for (letter, word) in self.words().into_iter().skip(3) {
            let Some(word) = word else { continue };
            match axes.iter().position(|axis| axis.letter.as_char() == letter) {
                Some(index) => start.rotary_deg[index] = Some(word),
                None => faults.push(|| {
                    let [first, second] = axes.each_ref().map(|axis| axis.letter.as_char());
                    let detail =
                        format!("the machine has no axis {letter}; its rotary axes are {first} and {second}");
                    Fault::new(format!("/start/{letter}"), detail)
                }),
            }
        }
        start
    }
}
