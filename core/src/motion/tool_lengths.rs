//! The lengths of a program's tools, as the caller and the machine's tool table state them.

use std::collections::BTreeMap;

use super::{CalledTool, ToolKey};

/// The lengths of tools by the numbers and names that call them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ToolLengths {
    /// Of the tools in the table \[mm\].
    pub by_key_mm: BTreeMap<ToolKey, f64>,
    /// The only tool of the program, and its length \[mm\].
    pub only: Option<(CalledTool, f64)>,
    /// A T word alone changes tools.
    pub by_t: bool,
}

impl ToolLengths {
    /// The length of a tool in the spindle \[mm\]; `None` if it is not known.
    #[must_use]
    pub fn of(&self, tool: CalledTool) -> Option<f64> {
        let is_only = |only: CalledTool| only == tool || (tool.key().is_some() && only.key() == tool.key());
        if let Some((_, length_mm)) = self.only.filter(|(only, _)| is_only(*only)) {
            return Some(length_mm);
        }
        let may_be_another = !self.by_t && matches!(tool, CalledTool::Selected(_));
        tool.key().filter(|_| !may_be_another).and_then(|key| self.by_key_mm.get(&key)).copied()
    }
}
