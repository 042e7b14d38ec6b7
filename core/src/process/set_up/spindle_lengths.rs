//! The length of the tool in the spindle, where the height of the spindle decides where the tip is.

use super::tooling::{ToolUsed, Tools, by_t};
use super::tools_at_work::ToolsAtWork;
use crate::motion::{CalledTool, ToolKey, ToolLengths};
use crate::units::Length;

impl Tools {
    /// The lengths of tools where the height of the spindle depends on them. The stated length is that of the tool
    /// with the stated number, or of the only tool that cuts. It holds for no other tool.
    pub(super) fn lengths_in_spindle(&self, at_work: &ToolsAtWork) -> ToolLengths {
        let mut own = self.clone();
        own.length = None;
        let of = |given: &Self, key: Option<ToolKey>| {
            ToolUsed::of(given, None, key.and_then(|key| self.table.find(key))).length.map(Length::mm)
        };
        let by_key_mm = self.table.keys().filter_map(|key| Some((key, of(&own, Some(key))?))).collect();
        let only = match (self.number, at_work.tools.as_slice()) {
            (Some(number), []) => {
                let key = ToolKey::Number(number);
                Some((CalledTool::NotCalled, Some(key)))
            }
            (Some(number), _) => {
                let key = ToolKey::Number(number);
                Some((CalledTool::Changed(key), Some(key)))
            }
            (None, [only]) => Some((*only, only.key())),
            (None, _) => None,
        };
        let only = only.and_then(|(tool, key)| Some((tool, of(self, key)?)));
        ToolLengths { by_key_mm, only, by_t: by_t(at_work) }
    }
}
