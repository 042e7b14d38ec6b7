//! How a program was read: its unit, its work offsets and its tools, with their lines.

use crate::motion::{CalledTool, Motion, ToolName, WorkOffset};
use crate::process::set_up::Tooling;
use crate::units::LengthUnit;

/// How a program was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProgramReading {
    /// The unit of its lengths; `None` if it has no length.
    pub unit: Option<LengthUnit>,
    /// Whether the text itself states the unit.
    pub unit_is_stated: bool,
    /// The work offsets under which it moves, in order of first use.
    pub work_offsets: Vec<OffsetUse>,
    /// The tools in the spindle while it moves, in order of first use.
    pub tools: Vec<ToolUse>,
}

/// The motions under one work offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffsetUse {
    /// The offset; `None` for all motions whose offset is unknown, or shifted by an unknown amount.
    pub offset: Option<WorkOffset>,
    /// It is the offset of the program's first point, or the one in force before the program names any.
    pub is_only: bool,
    /// Its motions are left unchanged, because its position is not stated.
    pub is_left_alone: bool,
    /// First and last line of the upload with such a motion.
    pub lines: [u64; 2],
    /// Number of such motions.
    pub motions: u64,
}

/// The motions with one tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolUse {
    /// How it was called.
    pub called: CalledTool,
    /// Its name, if it was called by name.
    pub name: Option<ToolName>,
    /// Its place in the machine's tool table, if any value was taken from there.
    pub listed: Option<usize>,
    /// Nothing is known of this tool, while other tools are known.
    pub is_unknown: bool,
    /// First and last line of the upload with such a motion.
    pub lines: [u64; 2],
    /// Number of such motions, including rapids.
    pub motions: u64,
}

/// Most tools that are distinguished. The motions of further tools are counted with the last.
const MAX_TOOLS: usize = 1000;
/// Most work offsets that are distinguished. The motions of further offsets are counted with the last.
const MAX_OFFSETS: usize = 1000;

impl ProgramReading {
    /// Takes motions in program order.
    pub(in crate::process) fn see(&mut self, motions: &[Motion]) {
        for alike in motions.chunk_by(are_read_alike) {
            let (Some(first), Some(last)) = (alike.first(), alike.last()) else { continue };
            let count = alike.len() as u64;
            if let Some(used) = self.tool(first) {
                used.lines[1] = last.line;
                used.motions += count;
            }
            if let Some(used) = self.work_offset(first) {
                used.lines[1] = last.line;
                used.motions += count;
            }
        }
    }

    /// The place of a motion's tool. It is new if no motion had this tool before.
    fn tool(&mut self, motion: &Motion) -> Option<&mut ToolUse> {
        let known = self.tools.iter().position(|used| used.called == motion.tool);
        let index = known.unwrap_or_else(|| {
            if self.tools.len() < MAX_TOOLS {
                self.tools.push(ToolUse {
                    called: motion.tool,
                    name: None,
                    listed: None,
                    is_unknown: false,
                    lines: [motion.line; 2],
                    motions: 0,
                });
            }
            self.tools.len() - 1
        });
        self.tools.get_mut(index)
    }

    /// The place of a motion's work offset. It is new if no motion had this offset before.
    fn work_offset(&mut self, motion: &Motion) -> Option<&mut OffsetUse> {
        let offset = motion.work_offset.filter(|_| !motion.is_shifted);
        let key = (offset, motion.offset_changed);
        let known = self.work_offsets.iter().position(|used| (used.offset, used.is_left_alone) == key);
        let index = known.unwrap_or_else(|| self.add(motion, offset));
        self.work_offsets.get_mut(index)
    }

    /// The same with the values used for each tool, and with the names by which tools were called.
    pub(in crate::process) fn with_tools(mut self, tooling: &Tooling, names: &[ToolName]) -> Self {
        for used in &mut self.tools {
            let tool = tooling.tool(used.called);
            used.is_unknown = tool.is_none();
            used.listed = tool.and_then(|tool| tool.listed);
            used.name = names.iter().find(|name| Some(name.key()) == used.called.key()).copied();
        }
        self
    }

    fn add(&mut self, motion: &Motion, offset: Option<WorkOffset>) -> usize {
        if self.work_offsets.len() < MAX_OFFSETS {
            self.work_offsets.push(OffsetUse {
                offset,
                is_only: motion.is_only_offset,
                is_left_alone: motion.offset_changed,
                lines: [motion.line; 2],
                motions: 0,
            });
        }
        self.work_offsets.len() - 1
    }
}

/// Whether two motions have the same tool and the same work offset.
fn are_read_alike(a: &Motion, b: &Motion) -> bool {
    let key = |motion: &Motion| (motion.work_offset, motion.is_shifted, motion.offset_changed, motion.tool);
    key(a) == key(b)
}
