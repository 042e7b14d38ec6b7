//! The inputs of a result beside its parameters: unit, work offsets, tools and wear, and who stated them.

use serde::{Deserialize, Serialize};

use super::{Fault, Fixed, MachineStatements, ProgramUnit, Statements};
use crate::description::ToSchema;
use crate::motion::{ToolKey, WorkOffset};
use crate::process::{OffsetUse, ProgramReading, ToolUse};

/// Who stated a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StatedBy {
    /// The text of the program.
    Program,
    /// The request.
    Request,
    /// The machine's profile.
    Profile,
    /// The machine's tool table.
    ToolTable,
    /// Nobody: a rule of the service applies.
    Rule,
}

/// A work offset of the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedOffset {
    /// The name in the program; null before the program names one, and if it is not known.
    #[schema(example = "G54")]
    pub name: Option<String>,
    /// Origin of the workpiece in machine coordinates at zero pose; null if it is not stated.
    #[schema(value_type = Option<Vec<f64>>)]
    pub origin_mm: Option<Fixed<3>>,
    /// Source of the origin.
    pub stated_by: Option<StatedBy>,
    /// True: the motions under this offset are left unchanged. Its position is not stated, or the program
    /// shifts it in a way that is not understood.
    pub is_left_alone: bool,
    /// First line of the upload with such a motion.
    pub first_line: u64,
    /// Last line of the upload with such a motion.
    pub last_line: u64,
    /// Number of such motions.
    pub motions: u64,
}

/// A tool of the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedTool {
    /// The number by which the program calls it.
    #[schema(example = 12)]
    pub number: Option<u32>,
    /// The name by which the program calls it.
    pub name: Option<String>,
    /// Id in the machine's tool table, if any value was taken from there.
    #[schema(example = "T12")]
    pub tool_id: Option<String>,
    /// Revision of that tool.
    pub tool_revision: Option<i64>,
    /// True: the motions with this tool are left unchanged. Another tool was requested, or neither the
    /// request nor the table gives its dimensions.
    pub is_left_alone: bool,
    /// First line of the upload with such a motion, rapids included.
    pub first_line: u64,
    /// Last line of the upload with such a motion, rapids included.
    pub last_line: u64,
    /// Number of such motions, rapids included.
    pub motions: u64,
}

/// The wear of a cutter from its entries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedWear {
    /// Id of the tool.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// Id of the cutter in the tool.
    pub cutter_id: String,
    /// Amount by which the radius is smaller: the largest wear of its edges.
    pub radius_wear_um: f64,
    /// Time of that measurement.
    pub measured_at: String,
    /// Age of that measurement at the time of the request \[d\].
    pub age_days: f64,
    /// Ids of the entries that were used.
    pub entry_ids: Vec<String>,
}

/// Inputs that were resolved beside the parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedInputs {
    /// Unit of the program's lengths; null if the program has no lengths.
    pub unit: Option<ProgramUnit>,
    /// Source of the unit.
    pub unit_stated_by: Option<StatedBy>,
    /// Work offsets under which the program moves, in the order of their first use.
    pub work_offsets: Vec<ResolvedOffset>,
    /// Tools that are in the spindle while the program moves, in the order of their first use.
    pub tools: Vec<ResolvedTool>,
    /// Largest F that the service writes; null if the limit is ten times the programmed feed.
    pub max_feed_mm_per_min: Option<f64>,
    /// Source of this limit; null if no F is written.
    pub max_feed_stated_by: Option<StatedBy>,
    /// Wear of these tools that was taken from the machine's wear entries.
    pub wear: Vec<ResolvedWear>,
}

/// A tool's row in the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TablePlace {
    /// The tool's id, chosen by the client.
    pub tool_id: String,
    /// Revision of the tool.
    pub revision: i64,
}

impl ResolvedInputs {
    /// The resolved inputs of a program that was read in this way.
    #[must_use]
    pub fn of(
        statements: &Statements<'_>,
        of_machine: &MachineStatements,
        table: &dyn Fn(usize) -> Option<TablePlace>,
        reading: &ProgramReading,
    ) -> Self {
        let unit_stated_by = match (reading.unit, reading.unit_is_stated, statements.unit) {
            (None, ..) => None,
            (_, true, _) => Some(StatedBy::Program),
            (_, _, Some(_)) => Some(StatedBy::Request),
            _ => Some(StatedBy::Profile),
        };
        let offset = |used: &OffsetUse| resolved_offset(statements, of_machine, used);
        let tool = |used: &ToolUse| {
            let listed = used.listed.and_then(table);
            ResolvedTool {
                number: match used.called.key() {
                    Some(ToolKey::Number(number)) => Some(number),
                    // The requested tool, if the text calls none or does not say which one.
                    None if !used.is_unknown => statements.tool_number,
                    Some(ToolKey::Name(_)) | None => None,
                },
                name: used.name.map(|name| String::from_utf8_lossy(name.as_bytes()).into_owned()),
                tool_id: listed.as_ref().map(|listed| listed.tool_id.clone()),
                tool_revision: listed.map(|listed| listed.revision),
                is_left_alone: used.is_unknown,
                first_line: used.lines[0],
                last_line: used.lines[1],
                motions: used.motions,
            }
        };
        Self {
            unit: reading.unit.map(Into::into),
            unit_stated_by,
            work_offsets: reading.work_offsets.iter().map(offset).collect(),
            tools: reading.tools.iter().map(tool).collect(),
            max_feed_mm_per_min: None,
            max_feed_stated_by: None,
            wear: Vec::new(),
        }
    }

    /// The values alone: two equal results have these in common, wherever in the program they apply.
    #[must_use]
    pub fn values(&self) -> serde_json::Value {
        let offset = |offset: &ResolvedOffset| serde_json::json!([offset.name, offset.origin_mm]);
        let tool = |tool: &ResolvedTool| {
            serde_json::json!([tool.number, tool.name, tool.tool_id, tool.tool_revision, tool.is_left_alone])
        };
        let wear = |wear: &ResolvedWear| {
            serde_json::json!([wear.tool_id, wear.cutter_id, wear.radius_wear_um, wear.entry_ids])
        };
        serde_json::json!({
            "unit": self.unit,
            "work_offsets": self.work_offsets.iter().map(offset).collect::<Vec<_>>(),
            "tools": self.tools.iter().map(tool).collect::<Vec<_>>(),
            "max_feed_mm_per_min": self.max_feed_mm_per_min,
            "wear": self.wear.iter().map(wear).collect::<Vec<_>>(),
        })
    }

    /// Whether a tool of the table is in the spindle while the program moves.
    #[must_use]
    pub fn has_tool(&self, tool_id: &str) -> bool {
        self.tools.iter().any(|tool| tool.tool_id.as_deref() == Some(tool_id))
    }

    /// The one tool that was used, as the program calls it; `None` if there were several, or if none is
    /// named.
    #[must_use]
    pub fn only_tool(&self) -> Option<String> {
        let used = self.tools.iter().filter(|tool| !tool.is_left_alone && tool.number != Some(0));
        let mut names: Vec<String> = used
            .filter_map(|tool| tool.number.map(|number| number.to_string()).or_else(|| tool.name.clone()))
            .collect();
        names.dedup();
        match names.as_slice() {
            [only] => Some(only.clone()),
            _ => None,
        }
    }

    /// The same, for a change that does not depend on the tool: no section is left unchanged because of its
    /// tool.
    #[must_use]
    pub fn whatever_the_tool(mut self) -> Self {
        for tool in &mut self.tools {
            tool.is_left_alone = false;
        }
        self
    }

    /// The same, with the largest F that is written.
    #[must_use]
    pub fn with_max_feed(self, stated_mm_per_min: Option<f64>, of_machine: &MachineStatements) -> Self {
        let (max_feed_mm_per_min, by) = match (stated_mm_per_min, of_machine.max_feed_mm_per_min) {
            (Some(feed), _) => (Some(feed), StatedBy::Request),
            (None, Some(feed)) => (Some(feed), StatedBy::Profile),
            (None, None) => (None, StatedBy::Rule),
        };
        Self { max_feed_mm_per_min, max_feed_stated_by: Some(by), ..self }
    }
}

/// The fault of a request that states the offset of this program twice with different values: by name and by
/// `work_offset_mm`.
#[must_use]
pub fn two_statements(statements: &Statements<'_>, reading: &ProgramReading) -> Option<Fault> {
    let Fixed(alone_mm) = statements.work_offset_mm?;
    let named = statements.work_offsets_mm?;
    let offsets = reading.work_offsets.iter().filter(|used| used.is_only).filter_map(|used| used.offset);
    offsets.into_iter().find_map(|offset| {
        let (name, at_mm) = named.iter().find(|(name, _)| WorkOffset::from_name(name) == Some(offset))?;
        let differ = at_mm.iter().zip(alone_mm).any(|(a, b)| (a - b).abs() > 0.0);
        let [x, y, z] = alone_mm;
        let [named_x, named_y, named_z] = at_mm;
        differ.then(|| {
            let detail = format!(
                "the program runs under {name}, but the request states it twice: {x}, {y}, {z} here and {named_x}, {named_y}, {named_z} in `work_offsets_mm`. Leave one of them out"
            );
            Fault::new("/work_offset_mm", detail)
        })
    })
}

fn resolved_offset(
    statements: &Statements<'_>,
    of_machine: &MachineStatements,
    used: &OffsetUse,
) -> ResolvedOffset {
    let named = |offsets: Option<&super::WorkOffsets>| {
        let name = used.offset?;
        offsets?
            .iter()
            .find(|(known, _)| WorkOffset::from_name(known) == Some(name))
            .map(|(_, at_mm)| Fixed(at_mm))
    };
    let of_request = named(statements.work_offsets_mm).or(statements.work_offset_mm.filter(|_| used.is_only));
    let (origin_mm, stated_by) = match (of_request, named(of_machine.work_offsets_mm.as_ref())) {
        _ if used.offset.is_none() => (None, None),
        (Some(origin_mm), _) => (Some(origin_mm), Some(StatedBy::Request)),
        (None, Some(origin_mm)) => (Some(origin_mm), Some(StatedBy::Profile)),
        (None, None) => (None, None),
    };
    ResolvedOffset {
        name: used.offset.filter(|offset| *offset != WorkOffset::Unnamed).map(|offset| offset.to_string()),
        origin_mm,
        stated_by,
        is_left_alone: used.is_left_alone,
        first_line: used.lines[0],
        last_line: used.lines[1],
        motions: used.motions,
    }
}
