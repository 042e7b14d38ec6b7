//! A first look at the tool calls in a program's text: none, one or several tools.

use crate::motion::{CalledTool, Spindle, ToolKey, ToolName};
use crate::program::{Address, Batch, Block, Word, WordForm};

/// Words that may call a tool.
const CALLING: u32 = Address::T.bit() | Address::M.bit() | Address::D.bit();

/// The tool calls found in a text so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) struct ToolCalls {
    spindle: Spindle,
    /// The first tool put into the spindle.
    first: Option<CalledTool>,
    /// A second tool was put in, or something may have moved before the first.
    several: bool,
    has_moved: bool,
    /// The name called last.
    name: Option<ToolName>,
    /// The text has a `CUTTER/` statement.
    pub(in crate::process) has_shapes: bool,
}

impl Default for ToolCalls {
    fn default() -> Self {
        Self {
            spindle: Spindle::START,
            first: None,
            several: false,
            has_moved: false,
            name: None,
            has_shapes: false,
        }
    }
}

impl ToolCalls {
    /// Takes a block that was read, with the [bits](Address::bit) of its words' addresses.
    #[inline]
    pub(in crate::process) fn see(&mut self, batch: &Batch, block: &Block, addresses: u32) {
        let is_keyword = |word: &Word| word.address == Address::G && word.form == WordForm::Keyword;
        let calls = addresses & CALLING != 0
            || addresses & Address::G.bit() != 0 && batch.words(block).iter().any(is_keyword);
        self.has_moved |= addresses & Address::AXES != 0;
        if calls {
            self.take(batch, block);
        }
    }

    fn take(&mut self, batch: &Batch, block: &Block) {
        let before = self.spindle.tool();
        let name = self.spindle.see(batch, block);
        self.has_shapes |= self.spindle.has_shape();
        self.name = name.or(self.name);
        let tool = self.spindle.tool();
        let is_same = tool.key().is_some() && tool.key() == before.key();
        if tool == before || is_same || tool.key() == Some(ToolKey::NONE) {
            return;
        }
        let is_first = |first: CalledTool| first.key().is_some() && first.key() == tool.key();
        self.several |= self.has_moved && self.first.is_none() || !self.first.is_none_or(is_first);
        self.first = self.first.or(Some(tool));
    }

    /// Whether both show the same tools, without following the program.
    pub(in crate::process) fn holds_for(&self, whole: &Self) -> bool {
        let facts = |of: &Self| (of.only(), of.has_changer(), of.has_shapes);
        facts(self) == facts(whole)
    }

    /// The only tool that can be in use, as far as the text shows without being followed. `None` if there may be
    /// several.
    pub(in crate::process) fn only(&self) -> Option<(CalledTool, Option<ToolName>)> {
        let tool = self.first.unwrap_or_default();
        let name = self.name.filter(|name| Some(name.key()) == tool.key());
        (!self.several).then_some((tool, name))
    }

    /// Whether M6 changes tools in the text so far.
    pub(in crate::process) fn has_changer(&self) -> bool {
        self.spindle.has_changer()
    }
}
