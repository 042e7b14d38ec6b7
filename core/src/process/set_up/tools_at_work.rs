//! The tools that cut in a program.

use crate::motion::{CalledTool, Motion, MotionKind, StatedCutter, ToolKey, ToolName, Unfollowable};

/// Most tools that are distinguished, as many as a large magazine has places. A program with more has several tools
/// in any case.
pub(in crate::process) const MAX_TOOLS: usize = 1000;

/// The tools that cut in a program.
#[derive(Debug, Clone, Default, PartialEq)]
pub(in crate::process) struct ToolsAtWork {
    /// Each tool once, in the order of its first cut.
    pub(in crate::process) tools: Vec<CalledTool>,
    /// The names by which tools are called.
    pub(in crate::process) names: Vec<ToolName>,
    /// The cutters that `CUTTER/` states.
    pub(in crate::process) cutters: Vec<StatedCutter>,
    /// M6 changes tools.
    pub(in crate::process) has_changer: bool,
    /// The program calls something that is not read.
    pub(in crate::process) has_calls: bool,
}

impl ToolsAtWork {
    /// Takes the tool of a motion, if the motion cuts.
    #[inline]
    pub(in crate::process) fn see(&mut self, motion: &Motion) {
        self.has_calls |= motion.unfollowable == Some(Unfollowable::Call);
        let cuts = matches!(motion.kind, MotionKind::Linear | MotionKind::Arc)
            && motion.unfollowable.is_none()
            && motion.end.is_some()
            && motion.tool.key() != Some(ToolKey::NONE);
        if cuts
            && !self.tools.iter().rev().any(|known| is_one(*known, motion.tool))
            && self.tools.len() < MAX_TOOLS
        {
            self.tools.push(motion.tool);
        }
    }

    /// The name of a tool, for messages.
    pub(in crate::process) fn told(&self, tool: CalledTool) -> String {
        told(tool, &self.names)
    }
}

/// Whether two calls are of the same tool.
fn is_one(a: CalledTool, b: CalledTool) -> bool {
    a == b || (a.key().is_some() && a.key() == b.key())
}

/// The name of a tool, for messages.
pub(in crate::process) fn told(tool: CalledTool, names: &[ToolName]) -> String {
    match (tool, tool.key()) {
        (_, Some(ToolKey::Number(number))) => format!("T{number}"),
        (_, Some(key @ ToolKey::Name(_))) => names
            .iter()
            .find(|name| name.key() == key)
            .map_or_else(|| "a tool called by its name".to_owned(), ToString::to_string),
        (CalledTool::NotCalled, None) => "the tool in the spindle at the start".to_owned(),
        (_, None) => "a tool that the text does not name".to_owned(),
    }
}
