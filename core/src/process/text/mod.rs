//! A program read piece by piece, from text to blocks and motions. Its head or its whole text is surveyed first.

mod course;
mod dialect_fit;
mod find_tools;
mod inventory;
mod line_map;
mod look_through;
mod name_unknown_axes;
mod numbering;
mod radius_path;
mod radius_way;
mod reading;
mod source;
mod step_store;
mod stream;
mod survey;
mod surveyor;

pub use reading::{OffsetUse, ProgramReading, ToolUse};
pub use source::{OpenSubprogram, ProgramSource};
pub use step_store::{MemoryStepStore, Place, StepStore};

pub(in crate::process) use dialect_fit::DialectFit;
pub(in crate::process) use inventory::Inventory;
pub(in crate::process) use line_map::{LineCursor, LineMap, line_ends};
pub(in crate::process) use name_unknown_axes::naming_unknown_axes;
pub(in crate::process) use numbering::Numbering;
pub(in crate::process) use source::{CHUNK_BYTES, read_some};
pub(in crate::process) use step_store::StoredText;
pub(in crate::process) use stream::{MotionPoses, Passage, Passages, Stretch};
pub(in crate::process) use survey::Survey;
