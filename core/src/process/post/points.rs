//! From the motions of cutter location data to points of a posted program.

use super::arc::{ArcSeen, WrittenCircle};
use super::parameters::{PostForm, PostParameters};
use super::statement::{Coolant, Posted, Spindle, posted};
use super::tool::{Load, selects_register};
use crate::geometry::Vec3;
use crate::kinematics::{MAX_COORDINATE_MM, ToolPose};
use crate::motion::{FeedMode, Motion, MotionKind, Unfollowable, last_decimal_mm};
use crate::process::fault::NotPosted;
use crate::program::{Address, Batch, Block, CycleUnread, Excerpt, Keyword, Word, WordForm};
use crate::units::Feedrate;

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
        /// H.
        length_number: u32,
        /// Line of the source.
        line: u64,
    },
    ClPoint(ClPoint),
}

impl Item {
    /// The point, if the item is one.
    pub(super) fn point(&self) -> Option<&ClPoint> {
        match self {
            Self::ClPoint(point) => Some(point),
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
    tool: Option<Load>,
    /// The words depend on the tool's length.
    depends_on_length: bool,
    /// A motion has been made since the tool came.
    has_moved: bool,
    /// Why the cycle under way is not followed, as far as its statement shows.
    cycle: Option<NotPosted>,
    /// A statement may have changed what no later one states again. It is refused, and what comes after it is not.
    is_lost: bool,
    /// The value that distinguishes the cutter from others.
    cutter: Option<f64>,
    /// The request states something that holds for one tool only.
    states_one: bool,
    /// Whether a motion at feed has reached a point with the tool in the spindle.
    has_cut: bool,
    /// The cutter changed after a cut, and no other tool has come since.
    cutter_changed: bool,
    spindle: Spindle,
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

impl ClPoints {
    /// At the start of the data. `states_one`: the request states something that holds for one tool only.
    /// `depends_on_length`: the words depend on the tool's length.
    pub(super) fn new(states_one: bool, depends_on_length: bool) -> Self {
        Self { depends_on_length, states_one, ..Self::default() }
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
            Keyword::PostWord if selects_register(text) => {
                if parameters.takes_length_of_data() {
                    return Err(NotPosted::LengthRegister);
                }
                return Ok(Some(self.not_done(text, block.line)));
            }
            Keyword::PostWord => match posted(text, &mut self.coolant) {
                Posted::Words(words) => {
                    self.words += 1;
                    self.spindle.see(&words);
                    return Ok(Some(Item::Words(words)));
                }
                Posted::Comment => return Ok(Some(self.note(text))),
                Posted::NotDone => return Ok(Some(self.not_done(text, block.line))),
            },
            Keyword::CycleOn => {
                let unread = CycleUnread::of(text).map(NotPosted::Cycle);
                self.cycle = unread.or_else(|| unsound_cycle(|address| value_of(batch, block, address)));
            }
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

    /// A comment, although the machine should act on it.
    fn not_done(&mut self, statement: &[u8], line: u64) -> Item {
        self.not_done += 1;
        self.first_not_done_line.get_or_insert(line);
        self.note(statement)
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
        let text = batch.block_text(block);
        if Load::unloads(text) {
            return Ok(None);
        }
        let load = Load::of(text, value_of(batch, block, Address::T));
        self.last = None;
        let is_same = self.tool.as_ref().is_some_and(|tool| tool.name == load.name);
        if let Some(item) = load.odd.filter(|_| parameters.takes_length_of_data()) {
            self.tool = Some(load);
            return Err(NotPosted::LoadItem { item });
        }
        if load.states_length && self.depends_on_length {
            self.tool = Some(load);
            return Err(NotPosted::LoadLength);
        }
        if is_same {
            return self.load_again(parameters, &load);
        }
        self.cutter_changed = false;
        let number = load.number();
        let length_number = load.register.or(number);
        let is_further = self.tool.replace(load).is_some() || self.has_cut;
        if !parameters.changes_tools {
            return if self.has_cut { Err(NotPosted::ToolChange) } else { Ok(None) };
        }
        if is_further && self.states_one {
            return Err(NotPosted::OneTool);
        }
        let (Some(number), Some(length_number)) = (number, length_number) else {
            return Err(NotPosted::ToolWithoutNumber);
        };
        (self.has_cut, self.has_moved) = (false, false);
        self.spindle = Spindle::StoppedByChange;
        Ok(Some(Item::ToolChange { number, length_number, line: block.line }))
    }

    /// A call of the tool that is in the spindle: no change, but its length must stay the same.
    fn load_again(&mut self, parameters: &PostParameters, load: &Load) -> Result<Option<Item>, NotPosted> {
        let Some(tool) =
            self.tool.as_mut().filter(|tool| load.register.is_some_and(|other| tool.register != Some(other)))
        else {
            return Ok(None);
        };
        let is_taken = tool.register.is_some() || self.has_moved || parameters.changes_tools;
        tool.register = load.register;
        if is_taken && parameters.takes_length_of_data() { Err(NotPosted::LengthRegister) } else { Ok(None) }
    }

    /// The number of the tool, if `LOADTL/` states one that is valid as a length number.
    pub(super) fn tool_number(&self) -> Option<u32> {
        self.tool.as_ref().and_then(Load::number)
    }

    /// The length register of the tool, if its statement names one.
    pub(super) fn length_register(&self) -> Option<u32> {
        self.tool.as_ref().and_then(|tool| tool.register)
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
            // What a CIRCLE has that is not understood is said below.
            None | Some(Unfollowable::ToolVector | Unfollowable::CircleUnread) => {}
            Some(Unfollowable::CutterCompensation) => return Err(NotPosted::Cutcom),
            Some(Unfollowable::CannedCycle) => return Err(self.cycle.unwrap_or(NotPosted::CycleHere)),
            Some(Unfollowable::StateLost) if self.is_lost => return Ok(()),
            Some(Unfollowable::UnknownCode) => {
                self.is_lost = true;
                let block = batch.blocks().get(motion.block as usize);
                let text = block.map_or(&[][..], |block| batch.block_text(block)).trim_ascii();
                return Err(NotPosted::ForTheControl { text: Excerpt::new(text) });
            }
            Some(Unfollowable::Call) => {
                self.is_lost = true;
                return Err(NotPosted::Unfollowable(Unfollowable::Call));
            }
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
        for (axis, value_mm) in ['X', 'Y', 'Z'].into_iter().zip(tip) {
            if value_mm.abs() > MAX_COORDINATE_MM {
                return Err(NotPosted::TooFar { axis, value_mm, max_mm: MAX_COORDINATE_MM });
            }
        }
        let rapid = motion.kind == MotionKind::Rapid;
        if self.cutter_changed {
            return Err(NotPosted::CutterChange);
        }
        self.has_moved = true;
        if let Some(why) = self.spindle.against_cut().filter(|_| !rapid) {
            return Err(why);
        }
        let feed = if rapid { None } else { Some(feed(parameters, motion)?) };
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
            let unit_mm = last_decimal_mm(motion.mm_per_unit, motion.program_decimals.linear);
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

fn feed(parameters: &PostParameters, motion: &Motion) -> Result<(FeedMode, f64), NotPosted> {
    let max = parameters.max_feed.map_or(f64::INFINITY, Feedrate::mm_per_min);
    match (motion.feed.mode, motion.feed.value) {
        (Some(FeedMode::PerRevolution), Some(_)) if parameters.form == PostForm::Machine => {
            Err(NotPosted::FeedPerTurn)
        }
        (Some(FeedMode::PerMinute), Some(mm_per_min)) if mm_per_min > max => {
            Err(NotPosted::OverMaxFeed { mm_per_min, max_mm_per_min: max })
        }
        (Some(mode), Some(value)) if value > 0.0 => Ok((mode, value)),
        _ => Err(NotPosted::NoFeed),
    }
}

/// Why the numbers of a cycle that is read make no motions.
fn unsound_cycle(value: impl Fn(Address) -> Option<f64>) -> Option<NotPosted> {
    let [plane, depth, retract, feed] =
        [Address::R, Address::D, Address::Q, Address::S].map(|address| value(address).unwrap_or_default());
    let pecks = [Address::P, Address::K].map(&value);
    let why = if depth.abs() <= 0.0 {
        "FEDTO is 0"
    } else if plane < 0.0 {
        "RAPTO is below the point"
    } else if retract < plane {
        "RTRCTO is below RAPTO"
    } else if feed <= 0.0 {
        "its feed is not above 0"
    } else if pecks.into_iter().flatten().any(|peck| peck <= 0.0) {
        "a peck is not above 0"
    } else {
        return None;
    };
    Some(NotPosted::CycleValue { why })
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
