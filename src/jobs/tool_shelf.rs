//! The tools of a machine as they were when work was accepted: its tool table, and the wear that was asked for.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::machine::Tool;
use crate::motion::ToolName;
use crate::process::{ListedTool, ToolTable};
use crate::store::StoredTool;
use crate::units::Length;
use crate::wire::{ResolvedWear, TablePlace};

/// The tools of a machine.
#[derive(Debug, Clone, Default)]
pub struct ToolShelf {
    tools: Arc<[StoredTool]>,
    worn: Arc<[ResolvedWear]>,
    table: Arc<ToolTable>,
}

/// What has to be kept of a shelf so that it can be set up again: revisions never change.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct KeptShelf {
    /// The tools and their revisions.
    pub tools: Vec<(String, i64)>,
    /// The wear that was asked for.
    pub wear: Vec<ResolvedWear>,
}

impl ToolShelf {
    /// A shelf of these tools.
    #[must_use]
    pub fn new(tools: Vec<StoredTool>) -> Self {
        Self::with(tools.into(), Arc::default())
    }

    fn with(tools: Arc<[StoredTool]>, worn: Arc<[ResolvedWear]>) -> Self {
        let listed = tools.iter().map(|tool| {
            let cutter = tool.document.cutter();
            let wear = worn.iter().find(|wear| wear.tool_id == tool.tool_id);
            ListedTool {
                number: tool.document.number,
                name: tool.document.name.as_ref().and_then(|name| ToolName::new(name.as_bytes())),
                cutter,
                length: tool.document.length_mm.map(Length::from_mm),
                worn: cutter.zip(wear).and_then(|(cutter, wear)| worn_cutter(cutter, wear)),
            }
        });
        let table = Arc::new(ToolTable::new(listed.collect()));
        Self { tools, worn, table }
    }

    /// The same with the wear of these tools.
    #[must_use]
    pub fn worn(&self, worn: Vec<ResolvedWear>) -> Self {
        Self::with(Arc::clone(&self.tools), worn.into())
    }

    /// In the core's terms.
    #[must_use]
    pub fn table(&self) -> &Arc<ToolTable> {
        &self.table
    }

    /// Whether it is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tools.is_empty()
    }

    /// The tools.
    #[must_use]
    pub fn tools(&self) -> &[StoredTool] {
        &self.tools
    }

    /// The wear that was asked for.
    #[must_use]
    pub fn wear(&self) -> &[ResolvedWear] {
        &self.worn
    }

    /// The tool at a place of the table.
    pub(super) fn tool(&self, place: usize) -> Option<&StoredTool> {
        self.tools.get(place)
    }

    /// The same for the report.
    pub(super) fn place(&self, place: usize) -> Option<TablePlace> {
        self.tool(place).map(|tool| TablePlace { tool_id: tool.tool_id.clone(), revision: tool.revision })
    }

    /// What has to be kept of it.
    #[must_use]
    pub fn kept(&self) -> KeptShelf {
        let tools = self.tools.iter().map(|tool| (tool.tool_id.clone(), tool.revision)).collect();
        KeptShelf { tools, wear: self.worn.to_vec() }
    }
}

/// A cutter that wore evenly along its contour: both radii are smaller. A sharp corner stays one.
fn worn_cutter(nominal: Tool, wear: &ResolvedWear) -> Option<Tool> {
    let wear = Length::from_um(wear.radius_wear_um);
    let corner = nominal.corner_radius() - wear;
    let corner = if corner.mm() > 0.0 { corner } else { Length::ZERO };
    Tool::new(nominal.radius() - wear, corner).ok()
}
