//! One motion, in the form that the compensator takes.

use super::radius::RadiusRule;
use super::{AxisWords, CalledTool, ContactWords, Decimals, Extra, Feed, Unfollowable, WorkOffset};
use crate::geometry::PlaneFrame;
use crate::program::PlaceInFile;

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

/// The coordinates in which the control interpolates linearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The axes; X Y Z are machine axis positions in the work offset.
    Machine,
    /// Tool tip and tool axis in the workpiece (G43.4).
    Tcp,
}

/// What the course of an arc depends on besides its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ArcCourse {
    /// Words that count from its ends (I J K, a radius): the course moves with the ends. Also for motions that are not
    /// arcs.
    Carried,
    /// A centre that is a separate point (`CC`, `CIRCLE/`, `I=AC(…)`).
    Centre,
    /// The direction in which the motion before it ends (`CT`).
    Neighbour,
    /// Nothing else: the control has computed it beside the programmed path.
    About {
        /// The centre, in the coordinates of the motion's plane, in its right-handed order \[mm\].
        centre_mm: [f64; 2],
        /// Whether it runs clockwise.
        is_clockwise: bool,
    },
}

/// How the control compensates the radius of the cutter during a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadiusCompensation {
    /// Counts how often compensation has been switched on so far.
    pub number: u32,
    /// How far the tool runs to the left of the programmed path, negative to the right \[mm\]; `None` if this depends
    /// on tables of the control that are not stated.
    pub beside_mm: Option<f64>,
    /// How the control runs the path.
    pub rule: RadiusRule,
    /// Whether arcs of the present code run clockwise; `None` if it is not known.
    pub is_clockwise: Option<bool>,
    /// G90.1: centres of arcs are points; `None` if it is not known.
    pub absolute_centres: Option<bool>,
}

/// One motion of a program. Blocks without axis words make no motion, except calls and M99.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about the motion")]
pub struct Motion {
    /// Index of its block in the batch.
    pub block: u32,
    /// 1-based line of the upload. For a block in a file that the program calls, it is the line of the call.
    pub line: u64,
    /// Where its block is, if it is in a file that the program calls.
    pub called: Option<PlaceInFile>,
    /// The kind of motion.
    pub kind: MotionKind,
    /// What the course of an arc depends on. It does not state whether I J K are a point (G90.1).
    pub arc: ArcCourse,
    /// Full circles that the arc makes in addition to the path to its end, if a word states them (`TURN=`).
    pub further_turns: Option<u16>,
    /// The interpolation by the program's own switches (G43.4, G49, …). It is also `Machine` if it is not known, and
    /// then the motion is unfollowable.
    pub interpolation: Interpolation,
    /// The start, in the coordinates of this motion; `None` unless all five axes are known.
    pub start: Option<AxisWords>,
    /// The end; `None` unless all five axes are known.
    pub end: Option<AxisWords>,
    /// The end of the linear axes \[mm\]. It is also known if a vector states the tool axis, so that the rotary axes
    /// are not known.
    pub linear_end_mm: Option<[f64; 3]>,
    /// The tool axis at the end, as written (not normalised), if the program states it as a vector. Also the normal of
    /// the plane, for a turn to it.
    pub tool_axis: Option<[f64; 3]>,
    /// X Y Z \[mm\] and the tool axis at the start, if a vector stated the axis before.
    pub vector_start: Option<([f64; 3], [f64; 3])>,
    /// The offset that TRANS and ATRANS add to X Y Z of this motion to give the place in the work offset \[mm\];
    /// `None` if it is not known. If it is not zero, `offset_changed` is set.
    pub program_offset_mm: Option<[f64; 3]>,
    /// The tilted plane in which the block counts. Its places here are those of the tip in the work offset, and the
    /// control follows the tip. [`Motion::stated`] gives them as words of the block.
    pub frame: Option<PlaneFrame>,
    /// The block repeats the motion before it to another place. It has at most numbers for axis and contact words, F,
    /// a block number, G0 or G1, the word of a line or a point, and comments. After the same motion, the same text
    /// makes the same motion. A vector becomes words of the machine later, in the order of the program.
    pub repeats: bool,
    /// Contact words of the block.
    pub contact: ContactWords,
    /// Feed, after the block's own words.
    pub feed: Feed,
    /// The extruder, where the block moves it.
    pub extra: Option<Extra>,
    /// The axis perpendicular to the plane of arcs (0 X, 1 Y, 2 Z); `None` if G17 G18 G19 is not known.
    pub plane: Option<u8>,
    /// G91: the block's words count from the position before.
    pub incremental: bool,
    /// 1, or 25.4 if the block is in inches.
    pub mm_per_unit: f64,
    /// Decimals of the words of this block. A class without a word takes the decimals of its modal values.
    pub decimals: Decimals,
    /// The most decimals seen so far in the program (posts strip trailing zeros).
    pub program_decimals: Decimals,
    /// The block states its places in machine coordinates, or goes to a reference position. Only motions of a program
    /// that is followed as it runs do so.
    pub in_machine: bool,
    /// The reason why the motion has to be left unchanged, if there is one.
    pub unfollowable: Option<Unfollowable>,
    /// The work offset is not the one of the program's first complete point, and no one has stated where it is. Or it
    /// has shifted since that point in a way that is not known (G92, G52, G10).
    pub offset_changed: bool,
    /// The work offset has shifted since that point in a way that is not known (G92, G52, G10), or the work offset
    /// itself is not known.
    pub is_shifted: bool,
    /// The work offset in force; `None` if it is not known.
    pub work_offset: Option<WorkOffset>,
    /// The tool in the spindle.
    pub tool: CalledTool,
    /// The compensation of the cutter's radius; `None` if it is off.
    pub compensation: Option<RadiusCompensation>,
    /// The machine stops at the end of the motion (G60, G61, G9).
    pub exact_stop: bool,
    /// The work offset is the one of the program's first complete point, or the one in force before the program names
    /// any.
    pub is_only_offset: bool,
}

impl Motion {
    /// How the control interpolates it: as the caller states, otherwise as the program's own switches say. In a tilted
    /// plane it follows the tip.
    #[must_use]
    #[inline]
    pub fn mode(&self, stated: Option<Interpolation>) -> Interpolation {
        if self.frame.is_some() { Interpolation::Tcp } else { stated.unwrap_or(self.interpolation) }
    }

    /// Words of this motion as its block states them: in a tilted plane X Y Z are places of the plane.
    #[must_use]
    #[inline]
    pub fn stated(&self, words: AxisWords) -> AxisWords {
        match self.frame {
            Some(frame) => AxisWords { linear_mm: frame.from_workpiece(words.linear_mm), ..words },
            None => words,
        }
    }

    /// Where words as its block states them lead: the inverse of [`Motion::stated`].
    #[must_use]
    #[inline]
    pub fn placed(&self, stated: AxisWords) -> AxisWords {
        match self.frame {
            Some(frame) => AxisWords { linear_mm: frame.to_workpiece(stated.linear_mm), ..stated },
            None => stated,
        }
    }
}
