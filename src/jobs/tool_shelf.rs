//! The tools of a machine at the time when work was accepted: its tool table, and the requested wear.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::machine::Tool;
use crate::motion::ToolName;
use crate::process::{EnteredWear, ListedTool, ToolTable, UnfitWear};
use crate::store::StoredTool;
use crate::units::Length;
use crate::wear::most_wear;
use crate::wire::{ResolvedWear, TablePlace};

/// The tools of a machine.
#[derive(Debug, Clone, Default)]
pub struct ToolShelf {
    tools: Arc<[StoredTool]>,
    worn: Arc<[ResolvedWear]>,
    unfit: Arc<[UnfitEntries]>,
    table: Arc<ToolTable>,
}

/// The stored form of a shelf, from which it can be restored: revisions never change.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct KeptShelf {
    /// The tools and their revisions.
    pub tools: Vec<(String, i64)>,
    /// The requested wear.
    pub wear: Vec<ResolvedWear>,
    /// The tools whose entries do not give the wear.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unfit: Vec<UnfitEntries>,
}

/// A wear entry and its value \[µm\].
pub type KeptWear = (String, f64);

/// Wear entries of a tool that do not give its worn cutter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnfitEntries {
    /// The tool.
    pub tool_id: String,
    /// The reason.
    #[serde(flatten)]
    pub why: WhyUnfit,
}

/// The reason; the core's words are used if the tool is in use.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum WhyUnfit {
    /// The wear is larger than entries may state.
    TooMuch {
        /// The entry with the largest wear.
        largest: KeptWear,
    },
    /// The wear became smaller.
    Fallen {
        /// The last measurement.
        newest: KeptWear,
        /// The measurement before it.
        earlier: KeptWear,
    },
    /// There are only entries of flank wear.
    FlankAlone {
        /// The newest entry.
        newest: String,
    },
}

impl WhyUnfit {
    fn to_core(&self, nominal: Option<Tool>) -> UnfitWear {
        let entered = |(entry, wear_um): &KeptWear| EnteredWear { entry: entry.clone(), wear_um: *wear_um };
        match self {
            Self::TooMuch { largest } => {
                let radius = nominal.map_or(Length::ZERO, |tool| tool.radius());
                UnfitWear::TooMuch { largest: entered(largest), most: most_wear(radius), radius }
            }
            Self::Fallen { newest, earlier } => {
                UnfitWear::Fallen { newest: entered(newest), earlier: entered(earlier) }
            }
            Self::FlankAlone { newest } => UnfitWear::FlankAlone { newest: newest.clone() },
        }
    }
}

impl ToolShelf {
    /// A shelf of these tools.
    #[must_use]
    pub fn new(tools: Vec<StoredTool>) -> Self {
        Self::with(tools.into(), Arc::default(), Arc::default())
    }

    fn with(tools: Arc<[StoredTool]>, worn: Arc<[ResolvedWear]>, unfit: Arc<[UnfitEntries]>) -> Self {
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
        let place = |entries: &UnfitEntries| {
            let at = tools.iter().position(|tool| tool.tool_id == entries.tool_id)?;
            Some((at, entries.why.to_core(tools.get(at)?.document.cutter())))
        };
        let doubts: BTreeMap<_, _> = unfit.iter().filter_map(place).collect();
        let table = Arc::new(ToolTable::new(listed.collect()).with_unfit_wear(doubts));
        Self { tools, worn, unfit, table }
    }

    /// The same shelf with the wear of these tools, and with the tools whose entries do not give it.
    #[must_use]
    pub fn worn(&self, worn: Vec<ResolvedWear>, unfit: Vec<UnfitEntries>) -> Self {
        Self::with(Arc::clone(&self.tools), worn.into(), unfit.into())
    }

    /// The table in the core's terms.
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

    /// The requested wear.
    #[must_use]
    pub fn wear(&self) -> &[ResolvedWear] {
        &self.worn
    }

    /// The tool at a place of the table.
    pub(super) fn tool(&self, place: usize) -> Option<&StoredTool> {
        self.tools.get(place)
    }

    /// The tool at a place of the table, for the report.
    pub(super) fn place(&self, place: usize) -> Option<TablePlace> {
        self.tool(place).map(|tool| TablePlace { tool_id: tool.tool_id.clone(), revision: tool.revision })
    }

    /// The stored form.
    #[must_use]
    pub fn kept(&self) -> KeptShelf {
        let tools = self.tools.iter().map(|tool| (tool.tool_id.clone(), tool.revision)).collect();
        KeptShelf { tools, wear: self.worn.to_vec(), unfit: self.unfit.to_vec() }
    }
}

/// A cutter that wore evenly along its contour: both radii are smaller. A sharp corner stays sharp.
fn worn_cutter(nominal: Tool, wear: &ResolvedWear) -> Option<Tool> {
    let wear = Length::from_um(wear.radius_wear_um);
    let corner = nominal.corner_radius() - wear;
    let corner = if corner.mm() > 0.0 { corner } else { Length::ZERO };
    Tool::new(nominal.radius() - wear, corner).ok()
}
