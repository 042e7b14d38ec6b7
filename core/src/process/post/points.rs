//! From the motions of cutter location data to points of a posted program.

use super::arc::Circle;
use super::{NotPosted, PostForm, PostParameters};
use crate::geometry::Vec3;
use crate::kinematics::ToolPose;
use crate::motion::{FeedMode, Motion, MotionKind, Unfollowable};
use crate::program::{Batch, Block, Keyword};

/// What goes into the posted program, in its order.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// A statement for the post-processor, as a comment.
    Note(Vec<u8>),
    Point(Point),
}

impl Item {
    /// The point that it is, if it is one.
    pub(super) fn point(&self) -> Option<Point> {
        match self {
            Self::Point(point) => Some(*point),
            Self::Note(_) => None,
        }
    }
}

/// A point to go to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// Of the source.
    pub(super) line: u64,
    pub(super) rapid: bool,
    pub(super) pose: ToolPose,
    /// mm/min or mm a turn; of rapids none.
    pub(super) feed: Option<(FeedMode, f64)>,
}

/// Longest statement that is carried along \[bytes\].
const MAX_NOTE_BYTES: usize = 200;
/// Tool axes of an arc's ends may differ by this \[length of the difference\].
const SAME_AXIS: f64 = 1e-6;

/// Reads the source's blocks and motions.
#[derive(Debug, Clone, Default)]
pub(super) struct Points {
    circle: Option<Circle>,
    mm_per_unit: Option<f64>,
    last: Option<ToolPose>,
    pub(super) arcs: u64,
    pub(super) notes: u64,
}

impl Points {
    /// What a block without a motion says.
    pub(super) fn statement(&mut self, batch: &Batch, block: &Block) -> Option<Item> {
        let keyword = batch.words(block).iter().find_map(crate::program::Word::keyword)?;
        match keyword {
            Keyword::BeginMm => self.mm_per_unit = Some(1.0),
            Keyword::BeginInch => self.mm_per_unit = Some(crate::units::MM_PER_INCH),
            Keyword::Circle => {
                self.circle = Circle::read(batch.block_text(block), self.mm_per_unit.unwrap_or(1.0));
            }
            Keyword::PostWord | Keyword::ToolCall | Keyword::Cutter => {
                self.notes += 1;
                return Some(Item::Note(note(batch.block_text(block))));
            }
            _ => {}
        }
        None
    }

    /// The points of a motion.
    ///
    /// # Errors
    /// Why it cannot be posted.
    pub(super) fn motion(
        &mut self,
        parameters: &PostParameters,
        motion: &Motion,
        out: &mut Vec<Item>,
    ) -> Result<(), NotPosted> {
        let before = self.last.take();
        match motion.unfollowable {
            None | Some(Unfollowable::ToolVector) => {}
            Some(reason) => return Err(NotPosted::Unfollowable(reason)),
        }
        if motion.offset_changed {
            return Err(NotPosted::OtherSetup);
        }
        let (Some(tip), Some(axis)) = (motion.linear_end_mm, motion.tool_axis) else {
            return Err(NotPosted::Unknown);
        };
        let axis = Vec3::from(axis).try_normalize(f64::EPSILON).ok_or(NotPosted::Unknown)?;
        let pose = ToolPose { tip_mm: Vec3::from(tip), axis };
        let rapid = motion.kind == MotionKind::Rapid;
        let feed = if rapid { None } else { Some(feed(parameters.form, motion)?) };
        let point = |tip_mm: Vec3| {
            Item::Point(Point { line: motion.line, rapid, pose: ToolPose { tip_mm, axis }, feed })
        };
        if motion.kind == MotionKind::Arc {
            self.arcs += 1;
            let circle = self.circle.take().ok_or(NotPosted::Arc { why: "its circle cannot be read" })?;
            let start = before.ok_or(NotPosted::Arc { why: "where it starts is not known" })?;
            if (start.axis - axis).norm() > SAME_AXIS {
                return Err(NotPosted::Arc { why: "the tool axis turns along it" });
            }
            let decimals = i32::from(motion.program_decimals.linear);
            let unit_mm = motion.mm_per_unit * 10.0_f64.powi(-decimals);
            let ends = [start.tip_mm, pose.tip_mm];
            let chords = circle.chords(ends, unit_mm, parameters.arc_tolerance.mm())?;
            out.extend(chords.into_iter().map(point));
        } else {
            out.push(point(pose.tip_mm));
        }
        self.last = Some(pose);
        Ok(())
    }
}

fn feed(form: PostForm, motion: &Motion) -> Result<(FeedMode, f64), NotPosted> {
    match (motion.feed.mode, motion.feed.value) {
        (Some(FeedMode::PerRevolution), Some(_)) if form == PostForm::Machine => Err(NotPosted::FeedPerTurn),
        (Some(mode), Some(value)) if value > 0.0 => Ok((mode, value)),
        _ => Err(NotPosted::NoFeed),
    }
}

/// The statement on one line between round brackets.
fn note(statement: &[u8]) -> Vec<u8> {
    let mut note = vec![b'('];
    for byte in statement.trim_ascii().iter().take(MAX_NOTE_BYTES) {
        note.push(match byte {
            b'(' => b'[',
            b')' => b']',
            b' '..=b'~' => *byte,
            _ => b' ',
        });
    }
    note.push(b')');
    note
}
