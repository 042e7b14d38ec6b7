//! What a result rests on beside its parameters: unit, work offsets, tools and wear, and who stated them.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Fault, Fixed, MachineStatements, ProgramUnit, Statements};
use crate::motion::{ToolKey, WorkOffset};
use crate::process::{OffsetUse, ProgramReading, ToolUse};

/// Who stated something.
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
    /// Nobody: a rule of the service holds.
    Rule,
}

/// A work offset of the program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedOffset {
    /// As the program names it; null before it names one, and where it is not known.
    #[schema(example = "G54")]
    pub name: Option<String>,
    /// Origin of the workpiece in machine coordinates at zero pose; null where nobody states it.
    #[schema(value_type = Option<Vec<f64>>)]
    pub origin_mm: Option<Fixed<3>>,
    /// Who states it.
    pub stated_by: Option<StatedBy>,
    /// Its motions are left as they are: nobody states where it is, or the program shifts it in a way that is not known.
    pub is_left_alone: bool,
    /// First line of the upload with such a motion.
    pub first_line: u64,
    /// Last line.
    pub last_line: u64,
    /// How many motions there are.
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
    /// Its id in the machine's tool table, where something of it was taken from there.
    #[schema(example = "T12")]
    pub tool_id: Option<String>,
    /// Revision of that tool.
    pub tool_revision: Option<i64>,
    /// Its motions are left as they are: another tool was asked for, or neither the request nor the table tells it.
    pub is_left_alone: bool,
    /// First line of the upload with such a motion, rapids too.
    pub first_line: u64,
    /// Last line.
    pub last_line: u64,
    /// How many motions there are, rapids too.
    pub motions: u64,
}

/// The wear of a cutter by its entries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedWear {
    /// The tool.
    #[schema(example = "T12")]
    pub tool_id: String,
    /// The cutter in it.
    pub cutter_id: String,
    /// What the radius is smaller by: the most of its edges.
    pub radius_wear_um: f64,
    /// When that was measured.
    pub measured_at: String,
    /// How long that was before the request \[d\].
    pub age_days: f64,
    /// The entries that were looked at.
    pub entry_ids: Vec<String>,
}

/// What a result rests on beside its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ResolvedInputs {
    /// Unit of the program's lengths; null where it has none.
    pub unit: Option<ProgramUnit>,
    /// Who states it.
    pub unit_stated_by: Option<StatedBy>,
    /// The work offsets under which it moves, in the order in which they come.
    pub work_offsets: Vec<ResolvedOffset>,
    /// The tools that are in the spindle while it moves, in the order in which they come.
    pub tools: Vec<ResolvedTool>,
    /// The fastest F that is written; null where ten times the programmed feed is.
    pub max_feed_mm_per_min: Option<f64>,
    /// Who states it; null where no F is written.
    pub max_feed_stated_by: Option<StatedBy>,
    /// Where it was taken from the machine's wear entries.
    pub wear: Vec<ResolvedWear>,
}

/// A tool of the table, by its place there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TablePlace {
    /// The client's name of it.
    pub tool_id: String,
    /// Its revision.
    pub revision: i64,
}

impl ResolvedInputs {
    /// Of a program that was read in this way.
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
                    // The tool asked for, where the text calls none or does not tell which.
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

    /// The values alone: what two results have in common that are the same, wherever in the program they count.
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

    /// The one tool that was used, as the program calls it; `None` where there were several, or where nobody names it.
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

    /// The same where something changes whatever the tool is, so that no section is left alone for its tool.
    #[must_use]
    pub fn whatever_the_tool(mut self) -> Self {
        for tool in &mut self.tools {
            tool.is_left_alone = false;
        }
        self
    }

    /// The same with the fastest F that is written.
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

/// The fault of a request that states the offset of this program twice, by name and by `work_offset_mm`, and not alike.
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
                "the program runs under {name}, and the request states it twice: {x}, {y}, {z} here and {named_x}, {named_y}, {named_z} in `work_offsets_mm`. Leave one of them out"
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
