//! Which tool is in the spindle, as far as the program states it.

use std::fmt;

use super::Interpreter;
use super::dialect::MotionRules;
use crate::program::{Address, Batch, Block, Code, Keyword, Word, WordForm};
use crate::units::Length;

/// M6.
const TOOL_CHANGE: Code = Code::M(60);
/// M61: Q is the number of the tool that is in the spindle.
const TOOL_SET: Code = Code::M(610);
/// The edge that holds if no D is written, and D0, which removes its lengths.
const FIRST_EDGES: [f64; 2] = [1.0, 0.0];

/// The name of a tool: at most 64 bytes, compared without regard to case.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ToolName {
    /// In upper case, filled with zeros after its end.
    bytes: [u8; Self::MAX_BYTES],
    length: u8,
}

impl ToolName {
    /// The longest name.
    pub const MAX_BYTES: usize = 64;

    /// A name; `None` if the text is empty or longer than [`Self::MAX_BYTES`].
    #[must_use]
    pub fn new(text: &[u8]) -> Option<Self> {
        let text = text.trim_ascii();
        let mut name = Self { bytes: [0; Self::MAX_BYTES], length: u8::try_from(text.len()).ok()? };
        name.bytes.get_mut(..text.len())?.copy_from_slice(text);
        name.bytes.make_ascii_uppercase();
        (!text.is_empty()).then_some(name)
    }

    /// The name in upper case.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }

    /// The tool with this name.
    #[must_use]
    pub fn key(&self) -> ToolKey {
        // FNV-1a, 64 bits.
        let digest = self.as_bytes().iter().fold(0xcbf2_9ce4_8422_2325_u64, |digest, &byte| {
            (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        ToolKey::Name(digest)
    }
}

impl fmt::Debug for ToolName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", String::from_utf8_lossy(self.as_bytes()))
    }
}

impl fmt::Display for ToolName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{}\"", String::from_utf8_lossy(self.as_bytes()))
    }
}

/// The number or name by which a tool is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ToolKey {
    /// The number of its T word.
    Number(u32),
    /// The digest of its [name](ToolName::key).
    Name(u64),
}

impl ToolKey {
    /// No tool: T0 empties the spindle.
    pub const NONE: Self = Self::Number(0);
}

/// The tool in the spindle, as the program called it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum CalledTool {
    /// The tool that was in the spindle from the start, because none was called so far.
    #[default]
    NotCalled,
    /// A tool that the text does not determine: T is an expression, an edge is not the first, or a subprogram may have
    /// changed it. The number counts such tools so far, so that two of them are not taken for one tool.
    Unknown(u16),
    /// A change put it into the spindle (M6, `TOOL CALL`, `LOADTL/`).
    Changed(ToolKey),
    /// A T word called it in a Sinumerik program that has had no M6 yet, so T may have been the change itself.
    Selected(ToolKey),
}

impl CalledTool {
    /// The number or name by which the tool was called.
    #[must_use]
    pub const fn key(self) -> Option<ToolKey> {
        match self {
            Self::NotCalled | Self::Unknown(_) => None,
            Self::Changed(key) | Self::Selected(key) => Some(key),
        }
    }
}

/// The shape that `CUTTER/` states for the tool that cuts after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedCutter {
    /// The tool.
    pub tool: CalledTool,
    /// Its diameter.
    pub diameter: Length,
    /// Its corner radius, if it is stated.
    pub corner_radius: Option<Length>,
    /// Line of the first motion with the tool.
    pub line: u64,
}

/// The most stated cutters that are kept.
const MAX_STATED: usize = 1000;

/// The names by which tools were called, and the shapes that a cutter location program states for them.
#[derive(Debug, Clone, Default)]
pub(super) struct ToolsNamed {
    names: Vec<ToolName>,
    cutters: Vec<StatedCutter>,
}

impl Interpreter {
    /// Notes the shape after a motion of a cutter location program.
    #[inline]
    pub(super) fn note_shape(&mut self) {
        let spindle = &mut self.modal.spindle;
        if !std::mem::take(&mut spindle.is_described) {
            return;
        }
        let stated = spindle.shape.and_then(|shape| shape.diameter_and_corner).zip(self.modal.mm_per_unit);
        if let Some(((diameter, corner), mm)) = stated.filter(|_| self.tools.cutters.len() < MAX_STATED) {
            self.tools.cutters.push(StatedCutter {
                tool: self.modal.spindle.tool(),
                diameter: Length::from_mm(diameter * mm),
                corner_radius: corner.map(|corner| Length::from_mm(corner * mm)),
                line: self.line,
            });
        }
    }

    /// Takes the words of a block that are about tools.
    pub(super) fn see_tools(&mut self, batch: &Batch, block: &Block) {
        let name = self.modal.spindle.see(batch, block);
        if let Some(name) = name.filter(|name| !self.tools.names.contains(name))
            && self.tools.names.len() < MAX_STATED
        {
            self.tools.names.push(name);
        }
        if self.block.g_codes().contains(&Code::Keyword(Keyword::ToolCall)) {
            // A difference of the length is not followed.
            let states_difference = |two: &[u8]| two.eq_ignore_ascii_case(b"DL");
            self.modal.writes_lengths |= batch.block_text(block).windows(2).any(states_difference);
        }
    }

    /// The names by which tools were called so far, each once. Only the first 1000 are kept.
    #[must_use]
    pub fn tool_names(&self) -> &[ToolName] {
        &self.tools.names
    }

    /// The shapes that `CUTTER/` states for the tools that have cut so far. Only the first 1000 are kept.
    #[must_use]
    pub fn stated_cutters(&self) -> &[StatedCutter] {
        &self.tools.cutters
    }
}

/// The shape of a cutter as stated by `CUTTER/`, in the program's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StatedShape {
    /// Equal texts have equal digests.
    digest: u64,
    /// Diameter and corner radius, if they are plain numbers.
    pub(super) diameter_and_corner: Option<(f64, Option<f64>)>,
}

/// The spindle along a program. A T word makes a tool ready, and M6 puts it into the spindle. `TOOL CALL` and
/// `LOADTL/` do both. In a Sinumerik program that has had no M6 yet, T may be the change itself, and another D is
/// another edge. A `CUTTER/` describes the tool of the `LOADTL/` next to it. If there is no `LOADTL/` next to it,
/// another shape is another tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spindle {
    /// `None`: no tool, or a tool that is not known.
    ready: Option<ToolKey>,
    holds: CalledTool,
    has_changer: bool,
    is_other_edge: bool,
    /// The number of unknown tools so far.
    unknown: u16,
    pub(super) shape: Option<StatedShape>,
    /// A `LOADTL/` or `CUTTER/` has come since the last motion, or nothing has moved yet.
    pub(super) is_described: bool,
}

impl Spindle {
    /// Before the first block.
    pub(crate) const START: Self = Self {
        ready: None,
        holds: CalledTool::NotCalled,
        has_changer: false,
        is_other_edge: false,
        unknown: 0,
        shape: None,
        is_described: true,
    };

    /// Nothing is known of the spindle.
    pub(super) const UNKNOWN: Self = Self { holds: CalledTool::Unknown(0), ..Self::START };

    /// The tool in the spindle.
    #[inline]
    pub(crate) fn tool(&self) -> CalledTool {
        if self.is_other_edge { CalledTool::Unknown(self.unknown) } else { self.holds }
    }

    /// Whether a `CUTTER/` states the tool's shape.
    pub(crate) fn has_shape(&self) -> bool {
        self.shape.is_some()
    }

    /// Whether M6 changed a tool so far.
    pub(crate) fn has_changer(&self) -> bool {
        self.has_changer
    }

    /// Takes the words of a block, in the order of the program. Returns the name if a T word calls a tool by name. T
    /// counts for an M6 of its own block wherever T is in the block. If one T is before the M6 and another after it,
    /// M6 puts the first tool into the spindle and the second is made ready.
    pub(crate) fn see(&mut self, batch: &Batch, block: &Block) -> Option<ToolName> {
        let rules = MotionRules::of(batch.dialect()).tools;
        let (mut puts_in, mut is_cutter, mut names_tool, mut edge) = (false, false, false, None);
        let mut name = None;
        let (mut sets, mut set, mut has_builders_code, mut calls_another) = (false, None, false, false);
        // The tool of the T words before an M6.
        let mut named_before = None;
        for word in batch.words(block) {
            match word.address {
                Address::G => match word.keyword() {
                    Some(Keyword::ToolCall) => (puts_in, self.ready) = (true, None),
                    Some(Keyword::Cutter) => is_cutter = true,
                    _ => {}
                },
                Address::P if is_cutter => self.take_shape(word.value.to_bits(), batch.block_text(block)),
                Address::T => {
                    names_tool = true;
                    let before = self.ready;
                    (self.ready, name) = called_by(batch, word);
                    calls_another |= before.is_some() && before != self.ready;
                }
                Address::D if rules.d_is_edge => {
                    let value = if word.form == WordForm::Number { word.value } else { f64::NAN };
                    edge = Some(value);
                }
                Address::M if word.code() == Some(TOOL_CHANGE) => {
                    puts_in = true;
                    self.has_changer = true;
                    named_before = names_tool.then_some(self.ready);
                }
                Address::M if word.code() == Some(TOOL_SET) && rules.m61_sets => sets = true,
                Address::M if !word.code_tenths().is_some_and(is_known_m) => has_builders_code = true,
                Address::Q => set = called_by(batch, word).0,
                _ => {}
            }
        }
        if names_tool || edge.is_some() {
            // NaN is not a first edge.
            self.is_other_edge = edge.is_some_and(|edge| !FIRST_EDGES.contains(&edge));
            self.unknown = self.unknown.saturating_add(u16::from(self.is_other_edge));
        }
        if puts_in {
            let put_in = named_before.unwrap_or(self.ready);
            self.hold(put_in.map(CalledTool::Changed));
            self.is_described = true;
            // The next change without a T takes the tool that is ready in the magazine.
            if named_before.is_none() || self.ready == put_in {
                self.ready = None;
            }
        } else if sets {
            self.hold(set.map(CalledTool::Changed));
        } else if names_tool
            && (has_builders_code || (calls_another && rules.second_t_changes && !self.has_changer))
        {
            // A code of the machine's builder beside T, or a second T in a program in which no M6 has changed a tool.
            self.hold(None);
        } else if names_tool && rules.t_may_change && !self.has_changer {
            self.hold(self.ready.map(CalledTool::Selected));
        }
        name
    }

    /// Sets this tool, or a tool that is not known.
    fn hold(&mut self, tool: Option<CalledTool>) {
        if tool.is_none() {
            self.unknown = self.unknown.saturating_add(1);
        }
        self.holds = tool.unwrap_or(CalledTool::Unknown(self.unknown));
    }

    /// `CUTTER/10.,2.`
    fn take_shape(&mut self, digest: u64, text: &[u8]) {
        if self.shape.is_some_and(|shape| shape.digest == digest) {
            return;
        }
        let numbers = text.split(|byte| *byte == b'/').nth(1).unwrap_or_default();
        let numbers = numbers.split(|byte| matches!(byte, b'$' | b'\r' | b'\n')).next().unwrap_or_default();
        let mut numbers = numbers.split(|byte| *byte == b',').map(|number| {
            std::str::from_utf8(number).ok().and_then(|number| number.trim().parse::<f64>().ok())
        });
        let diameter_and_corner = match (numbers.next().flatten(), numbers.next()) {
            (Some(diameter), None) => Some((diameter, None)),
            (Some(diameter), Some(Some(corner))) => Some((diameter, Some(corner))),
            _ => None,
        };
        self.shape = Some(StatedShape { digest, diameter_and_corner });
        if !self.is_described {
            self.hold(None);
            self.is_described = true;
        }
    }

    /// After a call of a text that is not read: a tool that was made ready may now be in the spindle.
    pub(super) fn pass_call(&mut self) {
        if self.ready.is_some() && self.ready != self.holds.key() {
            self.hold(None);
        }
    }

    /// The tool in the spindle is not known from here on.
    pub(super) fn forget(&mut self) {
        self.hold(None);
    }

    /// The values that are the same whether a block was executed or skipped.
    pub(super) fn common(&self, skipped: &Self) -> Self {
        if self == skipped {
            return *self;
        }
        let unknown = self.unknown.saturating_add(1);
        let holds = CalledTool::Unknown(unknown);
        Self { holds, unknown, has_changer: self.has_changer, ..Self::START }
    }
}

/// Whether an M code changes no tool on any control: stops, spindle, coolant, clamps, gears, overrides.
const fn is_known_m(tenths: u32) -> bool {
    let is_whole = tenths.is_multiple_of(10);
    is_whole && matches!(tenths / 10, 0..=14 | 17 | 19 | 29..=30 | 40..=45 | 48..=49 | 88..=89 | 98..=99)
}

/// The number or digest by which a T word calls a tool, and the name if it has one. Both are `None` if the tool cannot
/// be determined.
fn called_by(batch: &Batch, word: &Word) -> (Option<ToolKey>, Option<ToolName>) {
    if let Some(name) = batch.name(word) {
        let name = ToolName::new(name);
        return (name.as_ref().map(ToolName::key), name);
    }
    let is_number = word.form == WordForm::Number && word.value.fract() == 0.0;
    if !is_number || !(0.0..=f64::from(u32::MAX)).contains(&word.value) {
        return (None, None);
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number in range")]
    let number = word.value as u32;
    (Some(ToolKey::Number(number)), None)
}

#[cfg(test)]
mod tests;
