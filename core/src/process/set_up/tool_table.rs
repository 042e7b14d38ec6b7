//! The tools of a machine, found by the number or name that programs call.

use std::collections::BTreeMap;

use crate::machine::Tool;
use crate::motion::{ToolKey, ToolName};
use crate::process::fault::UnfitWear;
use crate::units::Length;

/// A tool of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedTool {
    /// The number by which programs call it.
    pub number: Option<u32>,
    /// The name by which programs call it.
    pub name: Option<ToolName>,
    /// The nominal cutter; missing for a drill or a probe.
    pub cutter: Option<Tool>,
    /// Its length.
    pub length: Option<Length>,
    /// The cutter at its last measurement, if the request asks for wear.
    pub worn: Option<Tool>,
}

/// The tool table of a machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ToolTable {
    tools: Vec<ListedTool>,
    by_key: BTreeMap<ToolKey, usize>,
    /// By the tools' places in the table.
    unfit: BTreeMap<usize, UnfitWear>,
}

impl ToolTable {
    /// A table of these tools, in this order. If two have the same number or name, the first is used.
    #[must_use]
    pub fn new(tools: Vec<ListedTool>) -> Self {
        let mut by_key = BTreeMap::new();
        for (place, tool) in tools.iter().enumerate() {
            let number = tool.number.map(ToolKey::Number).filter(|key| *key != ToolKey::NONE);
            for key in number.into_iter().chain(tool.name.as_ref().map(ToolName::key)) {
                by_key.entry(key).or_insert(place);
            }
        }
        Self { tools, by_key, unfit: BTreeMap::new() }
    }

    /// The same table. The wear entries of the tools at these places do not give their worn cutters.
    #[must_use]
    pub fn with_unfit_wear(self, unfit: BTreeMap<usize, UnfitWear>) -> Self {
        Self { unfit, ..self }
    }

    /// Why the wear entries of the tool with this key do not give its worn cutter, if so.
    pub(in crate::process) fn unfit_wear(&self, key: ToolKey) -> Option<&UnfitWear> {
        self.unfit.get(self.by_key.get(&key)?)
    }

    /// The numbers and names by which programs call its tools.
    pub(in crate::process) fn keys(&self) -> impl Iterator<Item = ToolKey> + '_ {
        self.by_key.keys().copied()
    }

    /// Whether the table has no tool.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tools.is_empty()
    }

    /// The tool with this key, and its place in the table.
    #[must_use]
    pub fn find(&self, key: ToolKey) -> Option<(usize, &ListedTool)> {
        let place = *self.by_key.get(&key)?;
        Some((place, self.tools.get(place)?))
    }
}
