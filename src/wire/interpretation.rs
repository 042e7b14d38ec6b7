//! The motions that the service understands in a program: parameters, and the rows of the answer.

use std::io::Write;

use serde::{Deserialize, Serialize, Serializer};

use super::statements::program_parameters;
use super::{Dialect, ResolvedInputs, Warning};
use crate::description::ToSchema;
use crate::machine::Machine;
use crate::motion::{ToolKey, WorkOffset};
use crate::process::{InterpretedKind, InterpretedMotion};

program_parameters! {
/// Parameters of the interpretation of a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct InterpretationParameters {}
}

/// The kind of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = MotionKind)]
pub enum MotionKindDoc {
    /// Rapid motion at the speed of the axes.
    Rapid,
    /// Straight line.
    Linear,
    /// An arc or a helix.
    Arc,
}

/// Words by their letters: X Y Z, then the rotary axes in the profile's order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointsInOrder {
    letters: [char; 5],
    /// The words, in this order.
    pub words: [Option<f64>; 5],
}

impl Serialize for JointsInOrder {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.letters.iter().zip(self.words))
    }
}

/// A motion as the service understands it. Values that are not known are null. Units are millimetres and
/// degrees, whatever the unit of the program.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = InterpretedMotion)]
pub struct InterpretedMotionDoc {
    /// Line of its file, 1-based.
    pub line: u64,
    /// The file that contains the line; null for the main program.
    pub file: Option<String>,
    /// Kind of the motion.
    pub kind: MotionKindDoc,
    /// The words at the end of the motion by letter, absolute, as the control counts them. Under tool centre
    /// point control X Y Z belong to the tip.
    #[schema(value_type = BTreeMap<String, Option<f64>>, example = json!({"X": 10.0, "Y": 0.0, "Z": 5.0, "A": 10.0, "C": 20.0}))]
    pub joints: JointsInOrder,
    /// Tip position at the end of the motion in W; null if an offset or a rotary position is not known.
    pub tip_mm: Option<[f64; 3]>,
    /// Tool axis at the end of the motion in W, from the tip to the spindle.
    pub axis: Option<[f64; 3]>,
    /// The tip's speed that F asks for; null for a rapid, and if F is per turn of the spindle.
    pub feed_mm_per_min: Option<f64>,
    /// Number of the tool in the spindle. If the program calls the tool by name, the machine's tool table
    /// gives the number.
    pub tool_number: Option<u32>,
    /// Name of the tool, if the program calls it by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_name: Option<String>,
    /// The work offset in force, by the name in the program.
    #[schema(example = "G54")]
    pub work_offset: Option<String>,
    /// For an arc: its centre in W, at the height of the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_mm: Option<[f64; 3]>,
    /// For an arc: the direction in W about which it runs counter-clockwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// For an arc: the number of turns.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.25)]
    pub turns: Option<f64>,
}

/// A motion that the service does not understand; every compensation leaves it unchanged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MotionLeftAlone)]
pub struct LeftAloneDoc {
    /// Line of its file, 1-based.
    pub line: u64,
    /// The file that contains the line, if it is not the main program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The reason.
    pub reason: String,
}

/// The result of the interpretation of a program.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = Interpretation)]
pub struct InterpretationAnswer {
    /// The motions that the service understands, in the order of execution.
    pub motions: Vec<InterpretedMotionDoc>,
    /// The motions that the service does not understand.
    pub left_alone: Vec<LeftAloneDoc>,
    /// Values for the whole program.
    #[serde(flatten)]
    pub end: InterpretationEnd,
}

/// Values that are known after the whole program was read.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct InterpretationEnd {
    /// Warnings to the caller.
    pub warnings: Vec<Warning>,
    /// Revision of the machine.
    pub machine_revision: i64,
    /// Version of the service.
    pub software_version: String,
    /// SHA-256 of the upload.
    pub input_sha256: String,
    /// Dialect of the program text.
    pub dialect: Dialect,
    /// Number of blocks in the upload.
    pub blocks: u64,
    /// Inputs that were resolved beside the parameters.
    pub resolved: ResolvedInputs,
}

impl MotionKindDoc {
    /// The kind of a motion.
    #[must_use]
    pub const fn of(kind: InterpretedKind) -> Self {
        match kind {
            InterpretedKind::Rapid => Self::Rapid,
            InterpretedKind::Linear => Self::Linear,
            InterpretedKind::Arc => Self::Arc,
        }
    }
}

impl InterpretedMotionDoc {
    /// A motion of this file on this machine; `number_of` gives the number that a tool has in the tool table.
    #[must_use]
    pub fn of(
        motion: &InterpretedMotion,
        file: Option<String>,
        machine: &Machine,
        number_of: &dyn Fn(ToolKey) -> Option<u32>,
    ) -> Self {
        let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
        let letters = ['X', 'Y', 'Z', first, second];
        Self {
            line: motion.called.map_or(motion.line, |place| u64::from(place.line)),
            file,
            kind: MotionKindDoc::of(motion.kind),
            joints: JointsInOrder { letters, words: motion.joints },
            tip_mm: motion.tip_mm,
            axis: motion.axis,
            feed_mm_per_min: motion.feed_mm_per_min,
            tool_number: motion.tool.key().and_then(|key| match key {
                ToolKey::Number(number) => Some(number),
                ToolKey::Name(_) => number_of(key),
            }),
            tool_name: motion.tool_name.map(|name| String::from_utf8_lossy(name.as_bytes()).into_owned()),
            work_offset: named(motion.work_offset),
            centre_mm: motion.arc.map(|arc| arc.centre_mm),
            normal: motion.arc.map(|arc| arc.normal),
            turns: motion.arc.map(|arc| arc.turns),
        }
    }
}

fn named(offset: Option<WorkOffset>) -> Option<String> {
    offset.filter(|offset| *offset != WorkOffset::Unnamed).map(|offset| offset.to_string())
}

/// The motions as a table, written row by row.
pub struct InterpretationTable<W: Write> {
    rows: csv::Writer<W>,
}

impl<W: Write> InterpretationTable<W> {
    /// A table with its header, for this machine's letters.
    ///
    /// # Errors
    /// The header cannot be written.
    pub fn new(out: W, machine: &Machine) -> Result<Self, csv::Error> {
        let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char().to_string());
        let mut rows = csv::Writer::from_writer(out);
        rows.write_record([
            "line",
            "file",
            "kind",
            "X",
            "Y",
            "Z",
            &first,
            &second,
            "tip_x_mm",
            "tip_y_mm",
            "tip_z_mm",
            "axis_i",
            "axis_j",
            "axis_k",
            "feed_mm_per_min",
            "tool_number",
            "work_offset",
        ])?;
        Ok(Self { rows })
    }

    /// Writes one motion.
    ///
    /// # Errors
    /// The row cannot be written.
    pub fn add(&mut self, motion: &InterpretedMotionDoc) -> Result<(), csv::Error> {
        fn three(values: Option<[f64; 3]>) -> [Option<f64>; 3] {
            values.map_or([None; 3], |values| values.map(Some))
        }
        self.rows.serialize((
            motion.line,
            &motion.file,
            motion.kind,
            motion.joints.words,
            three(motion.tip_mm),
            three(motion.axis),
            motion.feed_mm_per_min,
            motion.tool_number,
            &motion.work_offset,
        ))
    }

    /// The writer, after the last row.
    ///
    /// # Errors
    /// The rows cannot be written.
    pub fn into_inner(self) -> std::io::Result<W> {
        self.rows.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}
