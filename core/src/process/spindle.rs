//! Which tool is in the spindle, as far as the program says.

use std::collections::BTreeSet;

use crate::program::{Address, Batch, Block, Dialect, Keyword, Word, WordForm};

/// M6, in tenths.
const TOOL_CHANGE: u32 = 60;
/// Most tools that are told apart, as the places of a large magazine.
const MAX_TOOLS: usize = 1000;

/// The name of a tool: 64 bytes at most, told apart without regard to case.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ToolName {
    /// In upper case; zeros behind its end.
    bytes: [u8; Self::MAX_BYTES],
    length: u8,
}

impl ToolName {
    /// Longest name.
    pub(super) const MAX_BYTES: usize = 64;

    /// A name; `None` where there is none, or where it is longer than [`Self::MAX_BYTES`].
    pub(super) fn new(text: &[u8]) -> Option<Self> {
        let text = text.trim_ascii();
        let mut name = Self { bytes: [0; Self::MAX_BYTES], length: u8::try_from(text.len()).ok()? };
        name.bytes.get_mut(..text.len())?.copy_from_slice(text);
        name.bytes.make_ascii_uppercase();
        (!text.is_empty()).then_some(name)
    }

    /// The name in upper case.
    pub(super) fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }
}

impl std::fmt::Debug for ToolName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", String::from_utf8_lossy(self.as_bytes()))
    }
}

/// A tool as the program calls it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ToolCall {
    /// The one that was there from the start, or one whose T is an expression.
    #[default]
    Unknown,
    /// By its T word.
    Number(u32),
    /// By its name: `T="BALL_10"`, `TOOL CALL "BALL_10"`.
    Name(ToolName),
}

/// The spindle along a program: a T word makes a tool ready, M6 puts it in; `TOOL CALL` and `LOADTL/` do both. Another
/// `CUTTER/` is another tool. In a Sinumerik program that has had no M6 yet, T may be the change itself, and another D is
/// another edge.
#[derive(Debug, Clone, Default)]
pub(super) struct Spindle {
    ready: ToolCall,
    holds: ToolCall,
    /// What a T word called last that may have been the change itself.
    called: ToolCall,
    /// All tools that came in, or may have.
    tools: BTreeSet<ToolCall>,
    /// P of the last `CUTTER/`.
    cutter: Option<u64>,
    /// The tool of the first cut.
    first_cut_with: Option<ToolCall>,
    /// A tool came in since the first cut that is not known to be the same as the one before.
    was_changed: bool,
    has_changer: bool,
    /// The edge by D of a Sinumerik program, and that of the first cut.
    edge: Option<u64>,
    first_edge: Option<u64>,
}

/// D where none is written.
const FIRST_EDGE: f64 = 1.0;

impl Spindle {
    /// Takes the words of a block, in the order of the program. T counts for an M6 of its own block wherever it stands;
    /// where one stands before the M6 and another one after it, the first is put in and the second made ready.
    pub(super) fn see(&mut self, batch: &Batch, block: &Block) {
        let dialect = batch.dialect();
        let (mut puts_in, mut is_cutter, mut names_tool, mut edge) = (false, false, false, None);
        // What the T words before an M6 say.
        let mut named_before = None;
        for word in batch.words(block) {
            match word.address {
                Address::G => match word.keyword() {
                    Some(Keyword::ToolCall) => (puts_in, self.ready) = (true, ToolCall::Unknown),
                    Some(Keyword::Cutter) => is_cutter = true,
                    _ => {}
                },
                Address::P if is_cutter => {
                    let shape = Some(word.value.to_bits());
                    (puts_in, self.ready) = (self.cutter != shape, ToolCall::Unknown);
                    self.cutter = shape;
                }
                Address::T => (names_tool, self.ready) = (true, ToolCall::of(batch, word)),
                Address::D if dialect == Dialect::Siemens => {
                    let value = if word.form == WordForm::Number { word.value } else { f64::NAN };
                    edge = Some(value.to_bits());
                }
                Address::M if word.code_tenths() == Some(TOOL_CHANGE) => {
                    puts_in = true;
                    named_before = Some(self.ready).filter(|_| names_tool);
                }
                _ => {}
            }
        }
        if names_tool || edge.is_some() {
            self.edge = edge;
        }
        self.has_changer |= puts_in;
        if names_tool && dialect == Dialect::Siemens && !self.has_changer {
            self.was_changed |= self.ready == ToolCall::Unknown || self.ready != self.called;
            self.called = self.ready;
            self.note(self.ready);
        }
        if puts_in {
            let put_in = named_before.unwrap_or(self.ready);
            self.called = put_in;
            let same = put_in != ToolCall::Unknown && put_in == self.holds;
            self.was_changed |= !same;
            self.holds = put_in;
            self.note(put_in);
        }
    }

    fn note(&mut self, tool: ToolCall) {
        if self.tools.len() < MAX_TOOLS {
            self.tools.insert(tool);
        }
    }

    /// The tool in the spindle: `Unknown` at the start, and where its T is an expression. As long as a Sinumerik program has
    /// had no M6 it is the one that T called last.
    #[cfg_attr(not(test), expect(dead_code, reason = "for the look-up of tools by section, with its tests"))]
    pub(super) fn tool(&self) -> ToolCall {
        self.called
    }

    /// The tools that came in so far, or may have, each once: numbers before names. A tool that was there from the start is
    /// none of them; `Unknown` stands for every tool that is not told. The first 1000 are kept.
    #[cfg_attr(not(test), expect(dead_code, reason = "for the look-up of tools by section, with its tests"))]
    pub(super) fn tools(&self) -> impl Iterator<Item = ToolCall> {
        self.tools.iter().copied()
    }

    /// Whether motions are those of the tool with this number; without a number all are.
    pub(super) fn holds(&self, number: Option<u32>) -> bool {
        number.is_none_or(|number| self.holds == ToolCall::Number(number))
    }

    /// A cut: whether an earlier one was made by another tool, as far as can be told.
    pub(super) fn cuts_with_another(&mut self) -> bool {
        let Some(first) = self.first_cut_with else {
            (self.first_cut_with, self.was_changed) = (Some(self.called), false);
            self.first_edge = self.edge;
            return false;
        };
        let bits = |edge: Option<u64>| edge.unwrap_or(FIRST_EDGE.to_bits());
        bits(self.edge) != bits(self.first_edge)
            || (self.was_changed && (first == ToolCall::Unknown || first != self.called))
    }
}

impl ToolCall {
    fn of(batch: &Batch, word: &Word) -> Self {
        if let Some(name) = batch.name(word) {
            return ToolName::new(name).map_or(Self::Unknown, Self::Name);
        }
        let is_number = word.form == WordForm::Number && word.value.fract() == 0.0;
        if !is_number || !(0.0..=f64::from(u32::MAX)).contains(&word.value) {
            return Self::Unknown;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number in range"
        )]
        let number = word.value as u32;
        Self::Number(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{ReadLimits, Reader};

    /// The spindle behind each line of a program.
    fn along(dialect: Dialect, text: &str) -> Vec<Spindle> {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let (mut batch, mut spindle, mut states) = (Batch::new(), Spindle::default(), Vec::new());
        while reader.next_batch(&mut batch).unwrap() {
            for block in batch.blocks() {
                spindle.see(&batch, block);
                states.push(spindle.clone());
            }
        }
        states
    }

    fn tools(dialect: Dialect, text: &str) -> Vec<ToolCall> {
        along(dialect, text).iter().map(Spindle::tool).collect()
    }

    fn named(name: &str) -> ToolCall {
        ToolCall::Name(ToolName::new(name.as_bytes()).unwrap())
    }

    use ToolCall::{Number, Unknown};

    #[test]
    fn the_tool_before_a_change_comes_in_and_the_one_after_it_is_made_ready() {
        let text = "G0 X1\nT1 M6 T2\nG1 X2\nM6\nM6 T3\nT4\nT5 M6\nT#1 M6\n";
        assert_eq!(
            tools(Dialect::Iso, text),
            [Unknown, Number(1), Number(1), Number(2), Number(3), Number(3), Number(5), Unknown]
        );
        let last = along(Dialect::Iso, "T1 M6 T2\n").pop().unwrap();
        assert!(last.holds(Some(1)) && !last.holds(Some(2)));
    }

    #[test]
    fn tools_are_told_apart_by_their_names_whatever_their_case() {
        let text = "T=\"BALL_10\"\nM6\nT1=\"ball_10\"\nM6\nT=\"FLAT 5\" M6\nT7 M6\nT=\"A\"<<\"B\"\nM6\n";
        let ball = named("Ball_10");
        assert_eq!(
            tools(Dialect::Siemens, text),
            [ball, ball, ball, ball, named("FLAT 5"), Number(7), Number(7), Unknown]
        );
        let conversational =
            "1 TOOL CALL \"BALL_10\" Z S1000\n2 TOOL CALL S500\n3 TOOL CALL 5 Z\n4 TOOL CALL QS1 Z\n";
        assert_eq!(tools(Dialect::Heidenhain, conversational), [ball, ball, Number(5), Unknown]);
        let last = along(Dialect::Siemens, text).pop().unwrap();
        assert_eq!(last.tools().collect::<Vec<_>>(), [Unknown, Number(7), ball, named("FLAT 5")]);
    }

    #[test]
    fn a_name_is_kept_up_to_64_bytes_and_no_name_is_none() {
        let longest = "B".repeat(ToolName::MAX_BYTES);
        assert_eq!(ToolName::new(longest.as_bytes()).unwrap().as_bytes(), longest.as_bytes());
        assert_eq!(ToolName::new(format!("{longest}B").as_bytes()), None);
        assert_eq!(ToolName::new(b"  "), None);
        let text = format!("T=\"{longest}B\" M6\nT=\"\" M6\n");
        assert_eq!(tools(Dialect::Siemens, &text), [Unknown, Unknown]);
    }

    #[test]
    fn cuts_with_the_same_name_are_cuts_with_the_same_tool() {
        let cut_again = |first: &str, second: &str| {
            let text = format!("{first}\nG1 X1\n{second}\nG1 X2\n");
            let mut reader = Reader::new(Some(Dialect::Siemens), ReadLimits::default());
            reader.feed(text.as_bytes());
            reader.finish();
            let (mut batch, mut spindle) = (Batch::new(), Spindle::default());
            assert!(reader.next_batch(&mut batch).unwrap());
            let mut with_another = Vec::new();
            for block in batch.blocks() {
                spindle.see(&batch, block);
                if batch.words(block).iter().any(|word| word.address == Address::X) {
                    with_another.push(spindle.cuts_with_another());
                }
            }
            assert_eq!((with_another.len(), with_another[0]), (2, false));
            with_another[1]
        };
        assert!(!cut_again("T=\"A\" M6", "T=\"a\" M6"));
        assert!(cut_again("T=\"A\" M6", "T=\"B\" M6"));
        assert!(cut_again("T=\"A\" M6", "T1 M6"));
        // Without an M6 in the program T is the change itself.
        assert!(!cut_again("T=\"A\"", "T=\"A\""));
        assert!(cut_again("T=\"A\"", "T=\"B\""));
        // A tool made ready is not in.
        assert!(!cut_again("T1 M6 T2", "T3"));
        assert!(cut_again("T1 M6 T2", "M6"));
    }
}
