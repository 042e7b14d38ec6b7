//! From the motions of cutter location data to points of a posted program.

use super::arc::{ArcSeen, WrittenCircle};
use super::parameters::{PostForm, PostParameters};
use super::statement::{Coolant, Posted, posted};
use crate::geometry::Vec3;
use crate::kinematics::ToolPose;
use crate::motion::{FeedMode, Motion, MotionKind, Unfollowable};
use crate::process::fault::NotPosted;
use crate::program::{Address, Batch, Block, Keyword, Word, WordForm};

/// An item of the posted program, in order.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// A statement for the post-processor, as a comment.
    Note(Vec<u8>),
    /// A statement for the post-processor, as words.
    Words(String),
    /// Another tool comes into the spindle.
    ToolChange {
        /// T.
        number: u32,
        /// Line of the source.
        line: u64,
    },
    ClPoint(ClPoint),
}

/// Assumed precision of points written as whole numbers \[decimals\].
const WHOLE_NUMBERS_DECIMALS: i32 = 3;

impl Item {
    /// The point, if the item is one.
    pub(super) fn point(&self) -> Option<ClPoint> {
        match self {
            Self::ClPoint(point) => Some(*point),
            Self::Note(_) | Self::Words(_) | Self::ToolChange { .. } => None,
        }
    }
}

/// A point to go to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClPoint {
    /// Line of the source.
    pub(super) line: u64,
    pub(super) rapid: bool,
    pub(super) pose: ToolPose,
    /// Position of the tip before the motion, as far as the source states it \[mm\].
    pub(super) from_mm: Option<Vec3>,
    /// Feed \[mm/min, or mm per turn\]; rapids have none.
    pub(super) feed: Option<(FeedMode, f64)>,
    /// The circle of the source on which the tip goes there.
    pub(super) on: Option<ArcSeen>,
}

/// Longest statement kept as a comment \[bytes\].
const MAX_NOTE_BYTES: usize = 200;
/// Tool axes of an arc's ends may differ by this \[length of the difference\].
const SAME_AXIS: f64 = 1e-6;

/// Reads the source's blocks and motions.
#[derive(Debug, Clone, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about the data so far")]
pub(super) struct ClPoints {
    /// The circle that ends at the next point, and its line.
    circle: Option<(u64, Option<WrittenCircle>)>,
    last: Option<ToolPose>,
    /// The statement of the tool in the spindle.
    tool: Option<ToolName>,
    /// The value that distinguishes the cutter from others.
    cutter: Option<f64>,
    /// The request states something that holds for one tool only.
    states_one: bool,
    /// Whether a motion at feed has reached a point with the tool in the spindle.
    has_cut: bool,
    /// The cutter changed after a cut, and no other tool has come since.
    cutter_changed: bool,
    spindle: SpindleSaid,
    /// Statements of radius compensation that are left out, and the line of the first.
    pub(super) cutcoms: u64,
    pub(super) first_cutcom_line: Option<u64>,
    ended: bool,
    coolant: Coolant,
    pub(super) arcs: u64,
    pub(super) notes: u64,
    pub(super) words: u64,
    /// Number of statements for the machine that became comments, and the line of the first.
    pub(super) not_done: u64,
    pub(super) first_not_done_line: Option<u64>,
}

/// What the data have said of the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum SpindleSaid {
    /// Nothing: the caller's frame starts it.
    #[default]
    Nothing,
    Started,
    /// It was started, and stands since a tool came.
    StoppedByChange,
}

/// A tool as `LOADTL/` names it: by its number, or by the whole statement if it has no number.
#[derive(Debug, Clone, PartialEq)]
enum ToolName {
    Number(f64),
    Text(Vec<u8>),
}

impl ClPoints {
    /// At the start of the data. `states_one`: the request states something that holds for one tool only.
    pub(super) fn new(states_one: bool) -> Self {
        Self { states_one, ..Self::default() }
    }

    /// Posts a block without a motion.
    ///
    /// # Errors
    /// Why it cannot be posted.
    pub(in crate::process) fn statement(
        &mut self,
        parameters: &PostParameters,
        batch: &Batch,
        block: &Block,
    ) -> Result<Option<Item>, NotPosted> {
        let Some(keyword) = batch.words(block).iter().find_map(Word::keyword).filter(|_| !self.ended) else {
            return Ok(None);
        };
        let text = batch.block_text(block);
        match keyword {
            // The circle counts in the unit of its end.
            Keyword::BeginMm | Keyword::BeginInch if self.circle.is_some() => {
                return Err(NotPosted::Arc { why: "the unit changes between its circle and its end" });
            }
            Keyword::Circle => {
                let circle = WrittenCircle::of(batch.words(block));
                if self.circle.replace((block.line, circle)).is_some() {
                    return Err(NotPosted::Arc { why: "the circle before it has no end" });
                }
            }
            Keyword::EndPgm => self.ended = true,
            Keyword::PostWord => match posted(text, &mut self.coolant) {
                Posted::Words(words) => {
                    self.words += 1;
                    if words.ends_with("M3") || words.ends_with("M4") {
                        self.spindle = SpindleSaid::Started;
                    }
                    return Ok(Some(Item::Words(words)));
                }
                Posted::Comment => return Ok(Some(self.note(text))),
                Posted::NotDone => {
                    self.not_done += 1;
                    self.first_not_done_line.get_or_insert(block.line);
                    return Ok(Some(self.note(text)));
                }
            },
            Keyword::ToolCall => {
                let change = self.load(parameters, batch, block)?;
                return Ok(Some(change.unwrap_or_else(|| self.note(text))));
            }
            Keyword::Cutter => {
                let cutter = value_of(batch, block, Address::P);
                // This also holds for a refused change: the change back is refused too.
                if std::mem::replace(&mut self.cutter, cutter) != cutter && self.has_cut {
                    if !parameters.changes_tools {
                        return Err(NotPosted::CutterChange);
                    }
                    // The tool that has this cutter may be loaded after it.
                    self.cutter_changed = true;
                }
                return Ok(Some(self.note(text)));
            }
            Keyword::RadiusCompensation => {
                self.cutcoms += 1;
                self.first_cutcom_line.get_or_insert(block.line);
                return Ok(Some(self.note(text)));
            }
            _ => {}
        }
        Ok(None)
    }

    /// Line of a circle without an end point.
    pub(super) fn open_circle_line(&self) -> Option<u64> {
        self.circle.as_ref().map(|(line, _)| *line)
    }

    fn note(&mut self, statement: &[u8]) -> Item {
        self.notes += 1;
        Item::Note(note(statement))
    }

    /// `LOADTL/` and similar statements: the change, if the program has one here.
    fn load(
        &mut self,
        parameters: &PostParameters,
        batch: &Batch,
        block: &Block,
    ) -> Result<Option<Item>, NotPosted> {
        let text = batch.block_text(block).trim_ascii().to_ascii_uppercase();
        if text.starts_with(b"UNLOAD") {
            return Ok(None);
        }
        let tool = value_of(batch, block, Address::T).map_or(ToolName::Text(text), ToolName::Number);
        self.last = None;
        if self.tool.as_ref() == Some(&tool) {
            return Ok(None);
        }
        self.cutter_changed = false;
        let is_further = self.tool.replace(tool).is_some() || self.has_cut;
        if !parameters.changes_tools {
            return if self.has_cut { Err(NotPosted::ToolChange) } else { Ok(None) };
        }
        if is_further && self.states_one {
            return Err(NotPosted::OneTool);
        }
        let number = self.tool_number().ok_or(NotPosted::ToolWithoutNumber)?;
        self.has_cut = false;
        if self.spindle == SpindleSaid::Started {
            self.spindle = SpindleSaid::StoppedByChange;
        }
        Ok(Some(Item::ToolChange { number, line: block.line }))
    }

    /// The number of the tool, if `LOADTL/` states one that is valid as a length number.
    pub(super) fn tool_number(&self) -> Option<u32> {
        let Some(ToolName::Number(number)) = self.tool else { return None };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be whole")]
        let whole = number as u32;
        (number.fract() == 0.0 && PostParameters::LENGTH_NUMBERS.contains(&whole)).then_some(whole)
    }

    /// The points of a motion.
    ///
    /// # Errors
    /// Why it cannot be posted.
    pub(super) fn motion(
        &mut self,
        parameters: &PostParameters,
        batch: &Batch,
        motion: &Motion,
        out: &mut Vec<Item>,
    ) -> Result<(), NotPosted> {
        let before = self.last.take();
        let circle = self.circle.take();
        match motion.unfollowable {
            None | Some(Unfollowable::ToolVector) => {}
            Some(Unfollowable::CutterCompensation) => return Err(NotPosted::Cutcom),
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
        if self.cutter_changed {
            return Err(NotPosted::CutterChange);
        }
        if !rapid && self.spindle == SpindleSaid::StoppedByChange {
            return Err(NotPosted::SpindleStands);
        }
        let feed = if rapid { None } else { Some(feed(parameters.form, motion)?) };
        self.has_cut |= !rapid;
        // The position in FROM/ is newer than the previous point.
        let mut from_mm =
            motion.vector_start.map(|(tip, _)| Vec3::from(tip)).or(before.map(|before| before.tip_mm));
        let mut point = |tip_mm: Vec3, on: Option<ArcSeen>| {
            let from_mm = from_mm.replace(tip_mm);
            let pose = ToolPose { tip_mm, axis };
            Item::ClPoint(ClPoint { line: motion.line, rapid, pose, from_mm, feed, on })
        };
        if motion.kind == MotionKind::Arc {
            self.arcs += 1;
            let (_, circle) = circle.unzip();
            let written = circle.flatten().ok_or(NotPosted::Arc {
                why: "its CIRCLE has other items than CIRCLE/x,y,z,i,j,k,r,t,f,d,e: remove what the arc does not need",
            })?;
            let start = before.ok_or(NotPosted::Arc { why: "its start is not known" })?;
            if (start.axis - axis).norm() > SAME_AXIS {
                return Err(NotPosted::Arc { why: "the tool axis turns along it" });
            }
            // Whole numbers are not rounded to millimetres.
            let decimals = match motion.program_decimals.linear {
                0 => WHOLE_NUMBERS_DECIMALS,
                stated => i32::from(stated),
            };
            let unit_mm = motion.mm_per_unit * 10.0_f64.powi(-decimals);
            let ends = [start.tip_mm, pose.tip_mm];
            let circle = written.circle(motion.mm_per_unit)?;
            let chords = circle.chords(ends, unit_mm, parameters.arc_tolerance.mm())?;
            let on = Some(written.seen(ends, scale_of(batch, motion).unwrap_or(motion.mm_per_unit)));
            out.extend(chords.into_iter().map(|tip_mm| point(tip_mm, on)));
        } else if circle.is_some() {
            return Err(NotPosted::Arc {
                why: "a statement between circle and end makes the end belong to another motion",
            });
        } else {
            out.push(point(pose.tip_mm, None));
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

/// Millimetres for one unit of the numbers that the block of a motion states, from where the motion ends.
fn scale_of(batch: &Batch, motion: &Motion) -> Option<f64> {
    let block = batch.blocks().get(motion.block as usize)?;
    let places = [Address::X, Address::Y, Address::Z].into_iter().zip(motion.linear_end_mm?);
    let stated = places.filter_map(|(address, place_mm)| {
        let word = batch.words(block).iter().find(|word| word.address == address)?;
        (word.form == WordForm::Number).then_some((word.value, place_mm))
    });
    let (number, place_mm) = stated.max_by(|one, other| one.0.abs().total_cmp(&other.0.abs()))?;
    (number.abs() > 0.0).then(|| place_mm / number)
}

/// The number of this word of the block, if it has one.
fn value_of(batch: &Batch, block: &Block, address: Address) -> Option<f64> {
    batch.words(block).iter().find(|word| word.address == address && word.is_known()).map(|word| word.value)
}

/// The statement on one line in round brackets.
fn note(statement: &[u8]) -> Vec<u8> {
    let mut note = vec![b'('];
    for byte in statement.trim_ascii().iter().take(MAX_NOTE_BYTES) {
        note.push(match byte {
            b'(' => b'[',
            b')' => b']',
            // For many controls they end the tape or a block, even in comments.
            b'%' | b';' => b' ',
            b' '..=b'~' => *byte,
            _ => b' ',
        });
    }
    note.push(b')');
    note
}
