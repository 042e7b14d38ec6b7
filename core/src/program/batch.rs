//! Blocks and words, as offsets into the text in which they were written.

use std::num::NonZeroU16;

use super::dialect::Dialect;
use super::{Address, CalledLine, Diagnostic, Excerpt, Keyword, Word, WordForm};

/// The kind of a line of the upload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockKind {
    /// Words to be executed, possibly with comments and assignments.
    Words,
    /// Blanks only.
    Blank,
    /// A comment and nothing else.
    Comment,
    /// The tape mark `%`.
    Percent,
    /// Text before the actual program: a listing's banner.
    Banner,
    /// The header row of a CSV program.
    Header,
    /// Assignments of parameters, or statements that only talk to the outside (`DPRNT`), and no words.
    Assignment,
    /// A call of a subprogram by an O word or a `CALL` statement.
    Call,
    /// Control flow: `o… sub`, `IF`, `WHILE`, `GOTO`, `END1`, …
    Flow,
    /// Text of a template language (`{BEGIN}`), not of a control.
    Template,
    /// A line that cannot be read. The batch has a diagnostic with the reason and the place.
    Malformed,
}

/// Facts about a block that most blocks do not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BlockFlags(u8);

impl BlockFlags {
    /// `/`: the operator can skip the block.
    pub const DELETE: Self = Self(1);
    /// The block has an address other than G, M and N twice.
    pub const REPEATED: Self = Self(2);
    /// The block sets a parameter.
    pub const ASSIGNS: Self = Self(4);
    /// The block sets a system parameter, or perhaps sets one. This may change offsets.
    pub const ASSIGNS_SYSTEM: Self = Self(8);
    /// The block has a word whose value is an expression or a parameter.
    pub const EXPRESSION: Self = Self(16);
    /// The block has a comment.
    pub const COMMENT: Self = Self(32);
    /// The block has a word after a comma.
    pub const COMMA: Self = Self(64);
    /// The block may set a parameter of a cycle that is defined already.
    pub const SETS_CYCLE: Self = Self(128);

    /// Whether all of `other` are set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether no flag is set except perhaps `COMMENT`.
    #[must_use]
    pub const fn is_plain(self) -> bool {
        self.0 & !Self::COMMENT.0 == 0
    }

    pub(super) fn set(&mut self, other: Self) {
        self.0 |= other.0;
    }

    pub(super) fn clear(&mut self, other: Self) {
        self.0 &= !other.0;
    }
}

/// One line of the upload, its line ending included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// 1-based line of the upload.
    pub line: u64,
    /// First byte in the batch's text.
    pub start: u32,
    /// One after the last byte before the line ending.
    pub body_end: u32,
    /// One after the last byte, line ending included. The next block starts here.
    pub end: u32,
    /// Index of its first word among the batch's words.
    pub words_start: u32,
    /// One after its last word.
    pub words_end: u32,
    /// The kind of the line.
    pub kind: BlockKind,
    /// Further facts about the block.
    pub flags: BlockFlags,
}

impl Block {
    /// Whether it counts as a block: it is not empty, not only a comment and not the header of a table.
    #[must_use]
    pub fn counts(&self) -> bool {
        !matches!(self.kind, BlockKind::Blank | BlockKind::Comment | BlockKind::Header)
    }
}

/// The style of the program so far, for blocks that have to be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent habits")]
pub(super) struct Habits {
    /// A number below one was written without its zero: `.5`.
    pub(super) drops_zero: bool,
    /// A number was written with a point.
    pub(super) points: bool,
    /// A number was written with a plus sign.
    pub(super) plus_signs: bool,
    /// The style of the last feed statement of a cutter location program before this batch.
    pub(super) feed_before: FeedStatement,
    /// A number was written with a decimal comma.
    pub(super) decimal_comma: bool,
    /// How lines end.
    pub(super) line_ending: LineEnding,
}

/// The style of a `FEDRAT/`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FeedStatement {
    /// `MMPM` and similar words.
    pub(super) unit: Option<Keyword>,
    /// `FEDRAT/MMPM,100.`
    pub(super) unit_first: bool,
    /// `FEDRAT/ 100.`
    pub(super) blank: bool,
}

impl FeedStatement {
    /// The style in which this block writes a feed, if it is such a statement.
    pub(super) fn of(batch: &Batch, block: &Block) -> Option<Self> {
        let words = batch.words(block);
        let [head, behind @ ..] = words else { return None };
        if head.keyword() != Some(Keyword::Fedrat) {
            return None;
        }
        let unit = behind.iter().find_map(Word::keyword).filter(|unit| *unit != Keyword::FeedElsewhere);
        let unit_first = unit.is_some() && behind.first().is_some_and(|word| word.keyword().is_some());
        let next = batch.text.get(head.end as usize).copied().unwrap_or_default();
        Some(Self { unit, unit_first, blank: matches!(next, b' ' | b'\t') })
    }
}

/// How lines end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum LineEnding {
    /// LF, also if no line has ended yet.
    #[default]
    Lf,
    /// CR LF.
    CrLf,
    /// CR only.
    Cr,
}

impl LineEnding {
    pub(super) const fn bytes(self) -> &'static [u8] {
        match self {
            Self::Lf => b"\n",
            Self::CrLf => b"\r\n",
            Self::Cr => b"\r",
        }
    }
}

/// A line of a file that the program calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlaceInFile {
    /// The file, counted from 1 in the order of the program's files.
    pub file: NonZeroU16,
    /// Its line, counted from 1.
    pub line: u32,
}

/// A few hundred consecutive blocks with their text. Blocks cover the text without gap or overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    pub(super) text: Vec<u8>,
    pub(super) blocks: Vec<Block>,
    pub(super) words: Vec<Word>,
    pub(super) faults: Vec<Diagnostic>,
    pub(super) columns: Vec<Address>,
    pub(super) separator: u8,
    pub(super) offset: u64,
    pub(super) dialect: Dialect,
    pub(super) habits: Habits,
    /// Its expressions have the values that they have at this place of the program's course.
    pub(super) is_evaluated: bool,
    /// Where its blocks are, if they are in a file that the program calls. Their lines are then those of the call.
    pub(super) called: Vec<PlaceInFile>,
    /// The name of the called file.
    pub(super) called_name: Excerpt,
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            text: Vec::new(),
            blocks: Vec::new(),
            words: Vec::new(),
            faults: Vec::new(),
            columns: Vec::new(),
            separator: b',',
            offset: 0,
            dialect: Dialect::Iso,
            habits: Habits::default(),
            is_evaluated: false,
            called: Vec::new(),
            called_name: Excerpt::default(),
        }
    }
}

impl Batch {
    /// An empty batch. [`super::Reader::next_batch`] can fill it again and again.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The text of all its blocks.
    #[must_use]
    pub fn text(&self) -> &[u8] {
        &self.text
    }

    /// Its blocks in the order of the program.
    #[must_use]
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The words of one of its blocks, in the order written; empty for a block that could not be read.
    #[must_use]
    pub fn words(&self, block: &Block) -> &[Word] {
        self.words.get(block.words_start as usize..block.words_end as usize).unwrap_or_default()
    }

    /// The words of some of its blocks, in order.
    pub fn words_of<'b>(&'b self, blocks: &'b [Block]) -> impl Iterator<Item = &'b Word> {
        // A constant may take words from a block. They stay between those of its neighbours.
        blocks.chunk_by(|block, next| block.words_end == next.words_start).flat_map(|run| match run {
            [] => &[][..],
            [first, ..] => {
                let end = run.last().map_or(first.words_end, |last| last.words_end);
                self.words.get(first.words_start as usize..end as usize).unwrap_or_default()
            }
        })
    }

    /// Whether its blocks are those of a program's run, in which loops and calls are followed.
    #[must_use]
    pub fn is_of_run(&self) -> bool {
        self.is_evaluated
    }

    /// Where a block is, if it is in a file that the program calls.
    #[must_use]
    #[inline]
    pub fn place_in_file(&self, block: usize) -> Option<PlaceInFile> {
        self.called.get(block).copied()
    }

    /// The called file and the line of a block in it; `None` for a block of the main program.
    #[must_use]
    pub fn called_line(&self, block: &Block) -> Option<CalledLine> {
        let index = self.blocks.partition_point(|other| other.start < block.start);
        self.called.get(index).map(|place| CalledLine { file: self.called_name, line: place.line })
    }

    /// Makes its blocks those of a called file: they get the line of the call.
    pub(super) fn call_from(&mut self, line: u64, file: NonZeroU16, name: Excerpt) {
        self.called_name = name;
        self.called.clear();
        for block in &mut self.blocks {
            let line_in_file = u32::try_from(block.line).unwrap_or(u32::MAX);
            self.called.push(PlaceInFile { file, line: line_in_file });
            block.line = line;
        }
        for fault in &mut self.faults {
            let line_in_file = u32::try_from(fault.line).unwrap_or(u32::MAX);
            fault.called = Some(CalledLine { file: name, line: line_in_file });
            fault.line = line;
        }
    }

    /// The bytes of one of its blocks, line ending included.
    #[must_use]
    pub fn block_text(&self, block: &Block) -> &[u8] {
        self.text.get(block.start as usize..block.end as usize).unwrap_or_default()
    }

    /// The bytes from block `first` to block `last` (excluded), to be copied unchanged.
    #[must_use]
    pub fn blocks_text(&self, first: usize, last: usize) -> &[u8] {
        let from = self.blocks.get(first).map_or(self.text.len(), |block| block.start as usize);
        let to = self.blocks.get(last).map_or(self.text.len(), |block| block.start as usize);
        self.text.get(from..to).unwrap_or_default()
    }

    /// The bytes of one word of this batch.
    #[must_use]
    pub fn word_text(&self, word: &Word) -> &[u8] {
        self.text.get(word.start as usize..word.end as usize).unwrap_or_default()
    }

    /// The name that one of its words has instead of a number, without its quotation marks or angle brackets.
    #[must_use]
    pub fn name(&self, word: &Word) -> Option<&[u8]> {
        if word.form != WordForm::Name {
            return None;
        }
        let text = self.word_text(word).get(usize::from(word.lead)..)?.trim_ascii();
        if let [b'"', name @ .., b'"'] | [b'<', name @ .., b'>'] = text {
            return Some(name);
        }
        Some(text)
    }

    /// Takes I J K of one of its blocks as components of the tool axis, as under G43.5.
    pub(crate) fn name_tool_axis(&mut self, block: &Block) {
        let words = self.words.get_mut(block.words_start as usize..block.words_end as usize);
        for word in words.into_iter().flatten().filter(|word| word.form != WordForm::Comma) {
            word.address = match word.address {
                Address::I => Address::TI,
                Address::J => Address::TJ,
                Address::K => Address::TK,
                other => other,
            };
        }
    }

    /// The diagnostics of text that could not be read, in the order of the text.
    #[must_use]
    pub fn faults(&self) -> &[Diagnostic] {
        &self.faults
    }

    /// The position of the text's first byte in the upload, counted from 0.
    #[must_use]
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// The dialect in which the batch was read.
    #[must_use]
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// The columns of a CSV program; empty in every other dialect.
    #[must_use]
    pub fn columns(&self) -> &[Address] {
        &self.columns
    }

    /// The separator between the columns of a CSV program.
    #[must_use]
    pub fn separator(&self) -> u8 {
        self.separator
    }

    /// Notes the line ending of the first line that has one.
    pub(super) fn note_line_ending(&mut self) {
        if let Some(block) = self.blocks.iter().find(|block| block.end > block.body_end) {
            self.habits.line_ending = match self.text.get(block.body_end as usize..block.end as usize) {
                Some(b"\r\n") => LineEnding::CrLf,
                Some(b"\r") => LineEnding::Cr,
                _ => LineEnding::Lf,
            };
        }
    }

    /// Removes its blocks and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.text.clear();
        self.blocks.clear();
        self.words.clear();
        self.faults.clear();
        self.is_evaluated = false;
        self.called.clear();
    }

    /// Removes the blocks from this index on.
    pub(crate) fn end_before(&mut self, block: usize) {
        self.blocks.truncate(block);
    }

    /// Makes `copy` a batch of the blocks from `first` to `last` (excluded) of this one.
    pub(super) fn copy_blocks(&self, first: usize, last: usize, copy: &mut Self) {
        copy.clear();
        let blocks = self.blocks.get(first..last).unwrap_or_default();
        let (Some(begin), Some(end)) = (blocks.first(), blocks.last()) else { return };
        let (text, words) = (begin.start, begin.words_start.min(end.words_end));
        copy.text.extend_from_slice(self.blocks_text(first, last));
        let taken = self.words.get(words as usize..end.words_end as usize).unwrap_or_default();
        copy.words.extend(taken.iter().map(|word| Word {
            start: word.start.saturating_sub(text),
            end: word.end.saturating_sub(text),
            ..*word
        }));
        copy.blocks.extend(blocks.iter().map(|block| Block {
            start: block.start - text,
            body_end: block.body_end - text,
            end: block.end - text,
            words_start: block.words_start.saturating_sub(words),
            words_end: block.words_end.saturating_sub(words),
            ..*block
        }));
        let lines = begin.line..=end.line;
        copy.faults.extend(self.faults.iter().filter(|fault| lines.contains(&fault.line)).copied());
        copy.offset = self.offset + u64::from(text);
        (copy.dialect, copy.separator, copy.habits) = (self.dialect, self.separator, self.habits);
        copy.columns.clone_from(&self.columns);
    }
}
