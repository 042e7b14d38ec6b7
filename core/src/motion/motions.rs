//! One motion, as the compensator takes it.

use super::{AxisWords, CalledTool, ContactWords, Decimals, Extra, Feed, Unfollowable, WorkOffset};

/// The kind of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    /// G0.
    Rapid,
    /// G1.
    Linear,
    /// G2, G3; helix included.
    Arc,
    /// May move or change anything: calls and returns (M99), canned cycles, reference returns, unknown codes.
    Opaque,
}

/// What the control interpolates linearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The axes; X Y Z are machine axis positions in the work offset.
    Machine,
    /// Tool tip and tool axis in the workpiece (G43.4).
    Tcp,
}

/// What the course of an arc hangs on besides its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArcCourse {
    /// Words that count from its ends (I J K, a radius): it moves with them. Also what is no arc.
    Carried,
    /// A centre that is a point of its own (`CC`, `CIRCLE/`, `I=AC(…)`).
    Centre,
    /// The direction in which the motion before it ends (`CT`).
    Neighbour,
}

/// One motion of a program. Blocks without axis words make none, calls and M99 apart.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about the motion")]
pub struct Motion {
    /// Index of its block in the batch.
    pub block: u32,
    /// 1-based line of the upload.
    pub line: u64,
    /// What kind.
    pub kind: MotionKind,
    /// What an arc hangs on. Whether I J K are a point (G90.1) it does not tell.
    pub arc: ArcCourse,
    /// Full circles that it runs beside the way to its end, where a word says so (`TURN=`).
    pub further_turns: Option<u16>,
    /// By the program's own switches (G43.4, G49, …); `Machine` also where it is not known, and then the motion is
    /// unfollowable.
    pub interpolation: Interpolation,
    /// Where it starts, in the coordinates of this motion; `None` unless all five axes are known.
    pub start: Option<AxisWords>,
    /// Where it ends; `None` unless all five axes are known.
    pub end: Option<AxisWords>,
    /// Where the linear axes end \[mm\]; known also where the rotary axes are not, because a vector states the axis.
    pub linear_end_mm: Option<[f64; 3]>,
    /// The tool axis at the end, as written (not normalised), where the program states it as a vector.
    pub tool_axis: Option<[f64; 3]>,
    /// X Y Z \[mm\] and the tool axis at the start, where it was stated as a vector before.
    pub vector_start: Option<([f64; 3], [f64; 3])>,
    /// What TRANS and ATRANS add to X Y Z of this motion to give the place in the work offset \[mm\]; `None` where
    /// that is not known. Where it is not zero, `offset_changed` is set.
    pub program_offset_mm: Option<[f64; 3]>,
    /// Its block has numbers for axis and contact words, F, a block number, G0 or G1, the word of a line or a point and
    /// comments at most, and makes the motion before it again, to another place: behind the same motion the same text makes
    /// the same one. A vector becomes words of the machine later, in the order of the program.
    pub repeats: bool,
    /// Contact words of the block.
    pub contact: ContactWords,
    /// Feed, after the block's own words.
    pub feed: Feed,
    /// The extruder, where the block moves it.
    pub extra: Option<Extra>,
    /// The axis across the plane of arcs (0 X, 1 Y, 2 Z); `None` where G17 G18 G19 is not known.
    pub plane: Option<u8>,
    /// G91: the block's words count from the position before.
    pub incremental: bool,
    /// 1, or 25.4 where the block is in inches.
    pub mm_per_unit: f64,
    /// Of the words of this block; a class without a word takes those of its modal values.
    pub decimals: Decimals,
    /// The most seen so far in the program (posts strip trailing zeros).
    pub program_decimals: Decimals,
    /// Why it has to be left alone, if so.
    pub unfollowable: Option<Unfollowable>,
    /// The work offset is not the one of the program's first complete point, and nobody states it; or it is shifted in a way
    /// that is not known (G92, G52, G10 since that point).
    pub offset_changed: bool,
    /// The work offset is shifted since that point in a way that is not known (G92, G52, G10), or it is not known itself.
    pub is_shifted: bool,
    /// The work offset in force; `None` where it is not known.
    pub work_offset: Option<WorkOffset>,
    /// The tool in the spindle.
    pub tool: CalledTool,
    /// The machine stops at its end (G60, G61, G9).
    pub exact_stop: bool,
    /// It is the one of the program's first complete point, or the one in force before the program names any.
    pub is_only_offset: bool,
}
