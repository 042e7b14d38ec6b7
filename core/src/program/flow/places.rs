//! Where the statements that change the course of a program are, and which of them belong together.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::program::course::{PlaceName, Search, Statement, Step, Structure, block_number};
use crate::program::{Address, Batch, Block, WordForm};

/// A statement that changes the course, and the index of its block in the program.
#[derive(Debug)]
pub(super) struct Turn {
    pub(super) block: usize,
    pub(super) statement: Statement,
    /// The statement that belongs to it, by its index: of an opening one the next branch or the end, of a closing one
    /// the beginning, of a `BREAK` and a `CONTINUE` the beginning of their loop.
    pub(super) partner: Option<usize>,
    /// The end of the structure that it opens or branches, by its index.
    end: Option<usize>,
}

/// The most structures inside each other whose statements are joined. In a program with more, none are followed.
const MAX_NESTED: usize = 256;

/// All of them, in the order of the text.
#[derive(Debug, Default)]
pub(super) struct Turns {
    list: Vec<Turn>,
    /// The blocks of every name, in the order of the text.
    places: BTreeMap<PlaceName, Vec<usize>>,
    /// The subprograms of every name, as indices of turns.
    subprograms: BTreeMap<PlaceName, Vec<usize>>,
    /// The blocks at which programs of the text begin.
    entries: Vec<usize>,
}

/// What a block does to the course of its program.
pub(super) fn statement_at(batch: &Batch, block: &Block) -> Statement {
    batch.dialect().rules().flow.map_or(Statement::PLAIN, |read| read(batch, block))
}

impl Turns {
    /// Those of a program in these batches. Its files begin at the blocks `starts`.
    pub(super) fn of(batches: &[Batch], starts: &[usize]) -> Self {
        let mut turns = Self::default();
        let Some(read) = batches.first().and_then(|batch| batch.dialect().rules().flow) else { return turns };
        let mut index = 0;
        for batch in batches {
            for block in batch.blocks() {
                let statement = read(batch, block);
                if index > 0 && starts.binary_search(&index).is_ok() {
                    turns.entries.push(index);
                }
                if let Some(place) = &statement.place {
                    turns.places.entry(place.clone()).or_default().push(index);
                }
                if statement.step == Step::Entry {
                    turns.entries.push(index);
                }
                if statement.step != Step::Plain {
                    turns.list.push(Turn { block: index, statement, partner: None, end: None });
                }
                index += 1;
            }
        }
        turns.find_partners(starts);
        turns.find_ends();
        let jumps = |turn: &Turn| matches!(turn.statement.step, Step::Jump { .. } | Step::Select { .. });
        if turns.list.iter().any(jumps) {
            turns.find_numbers(batches);
        }
        turns
    }

    /// The blocks of every block number. Only jumps need them.
    fn find_numbers(&mut self, batches: &[Batch]) {
        let blocks = batches.iter().flat_map(|batch| batch.blocks().iter().map(move |block| (batch, block)));
        for (index, (batch, block)) in blocks.enumerate() {
            let numbers = batch.words(block).iter().filter(|word| word.address == Address::N);
            for number in numbers.filter(|word| word.form == WordForm::Number) {
                self.places.entry(block_number(number.value)).or_default().push(index);
            }
        }
        // A label may be spelled like a number.
        self.places.values_mut().for_each(|blocks| blocks.sort_unstable());
    }

    /// Joins the statements of every structure. A statement without partner is not followed when it is reached. A
    /// structure ends in the file in which it begins.
    fn find_partners(&mut self, starts: &[usize]) {
        // The opening statement of every structure that is open, and its last branch.
        let mut open: Vec<[usize; 2]> = Vec::new();
        let mut files = 0;
        for index in 0..self.list.len() {
            let Some(turn) = self.list.get(index) else { break };
            let files_before = files;
            files = starts.partition_point(|start| *start <= turn.block);
            if files != files_before {
                open.clear();
            }
            let Statement { name, step, .. } = turn.statement.clone();
            if open.len() > MAX_NESTED {
                self.list.iter_mut().for_each(|turn| turn.partner = None);
                return;
            }
            let innermost = open.last().copied();
            let matches = |first: usize, wanted: &dyn Fn(Structure) -> bool| {
                self.list.get(first).is_some_and(|turn| {
                    let opened = opened(&turn.statement.step);
                    turn.statement.name == name && opened.is_some_and(wanted)
                })
            };
            match step {
                Step::Open(Structure::While, Some(_))
                    if innermost.is_some_and(|[first, _]| matches(first, &|kind| kind == Structure::Do)) =>
                {
                    // `DO … WHILE […]`
                    open.pop();
                    self.join(innermost.map(|[first, _]| first), index);
                    self.set_partner(index, innermost.map(|[first, _]| first));
                }
                Step::Open(kind, _) => {
                    if kind == Structure::Sub
                        && let Some(name) = name
                    {
                        self.subprograms.entry(name).or_default().push(index);
                    }
                    open.push([index; 2]);
                }
                Step::Count { .. } => open.push([index; 2]),
                Step::Else(_) => {
                    if let Some([first, last]) = innermost
                        && matches(first, &|kind| kind == Structure::If)
                    {
                        self.join(Some(last), index);
                        if let Some(top) = open.last_mut() {
                            *top = [first, index];
                        }
                    }
                }
                Step::Close(kind, _) => {
                    let closes = |opened: Structure| match kind {
                        Some(kind) => opened == kind,
                        None => matches!(opened, Structure::While | Structure::Loop),
                    };
                    if let Some([first, last]) = innermost
                        && matches(first, &closes)
                    {
                        open.pop();
                        self.join(Some(last), index);
                        self.set_partner(index, Some(first));
                    }
                }
                Step::Break | Step::Continue => {
                    let around = open.iter().rev().map(|[first, _]| *first);
                    let is_loop = |kind: Structure| !matches!(kind, Structure::If | Structure::Sub);
                    let found = around.clone().find(|first| matches(*first, &is_loop));
                    self.set_partner(index, found);
                }
                _ => {}
            }
        }
    }

    /// Makes `next` the partner of an opening statement or a branch.
    fn join(&mut self, earlier: Option<usize>, next: usize) {
        if let Some(earlier) = earlier {
            self.set_partner(earlier, Some(next));
        }
    }

    fn set_partner(&mut self, index: usize, partner: Option<usize>) {
        if let Some(turn) = self.list.get_mut(index) {
            turn.partner = partner;
        }
    }

    pub(super) fn get(&self, index: usize) -> Option<&Turn> {
        self.list.get(index)
    }

    /// The index of the first turn at or after a block.
    pub(super) fn first_at(&self, block: usize) -> usize {
        self.list.partition_point(|turn| turn.block < block)
    }

    /// Finds the end of every structure, from the last statement on.
    fn find_ends(&mut self) {
        for at in (0..self.list.len()).rev() {
            let next = self.list.get(at).and_then(|turn| turn.partner).filter(|next| *next > at);
            let end = next.and_then(|next| {
                let turn = self.list.get(next)?;
                match turn.statement.step {
                    Step::Close(..) => Some(next),
                    // The end of `DO` is the `WHILE` whose partner is before it.
                    Step::Open(Structure::While, _) if turn.partner < Some(next) => Some(next),
                    _ => turn.end,
                }
            });
            if let Some(turn) = self.list.get_mut(at) {
                turn.end = end;
            }
        }
    }

    /// The end of the structure that this statement opens or branches.
    pub(super) fn end_of(&self, index: usize) -> Option<usize> {
        self.list.get(index)?.end
    }

    /// The subprogram of this name in these blocks, by the index of its turn, if it is there once.
    pub(super) fn subprogram(&self, name: &PlaceName, within: &Range<usize>) -> Option<usize> {
        let block_of = |turn: &usize| self.list.get(*turn).map_or(usize::MAX, |turn| turn.block);
        only_within(self.subprograms.get(name)?, within, block_of)
    }

    /// The block of a name that is in these blocks once.
    pub(super) fn place(&self, name: &PlaceName, within: &Range<usize>) -> Option<usize> {
        only_within(self.places.get(name)?, within, |block| *block)
    }

    /// The block to which a jump at this block goes. Programs of one text do not jump into each other.
    pub(super) fn find(&self, name: &PlaceName, search: Search, from: usize) -> Option<usize> {
        let next = self.entries.partition_point(|entry| *entry <= from);
        let begin = next.checked_sub(1).and_then(|index| self.entries.get(index)).copied().unwrap_or(0);
        let end = self.entries.get(next).copied().unwrap_or(usize::MAX);
        let places = self.places.get(name)?;
        let inside = |found: Option<&usize>| found.copied().filter(|block| (begin..end).contains(block));
        let later = || inside(places.get(places.partition_point(|block| *block <= from)));
        let first = || inside(places.get(places.partition_point(|block| *block < begin)));
        match search {
            Search::Forward => later(),
            Search::Backward => {
                let before = places.partition_point(|block| *block < from).checked_sub(1);
                inside(before.and_then(|before| places.get(before)))
            }
            Search::Around => later().or_else(first),
        }
    }
}

/// The entry whose block is within these, if there is one alone. The entries are in the order of their blocks.
fn only_within(
    entries: &[usize],
    within: &Range<usize>,
    block_of: impl Fn(&usize) -> usize,
) -> Option<usize> {
    let first = entries.partition_point(|entry| block_of(entry) < within.start);
    let inside = |at: usize| entries.get(at).copied().filter(|entry| block_of(entry) < within.end);
    inside(first).filter(|_| inside(first + 1).is_none())
}

fn opened(step: &Step) -> Option<Structure> {
    match step {
        Step::Open(kind, _) => Some(*kind),
        Step::Count { .. } => Some(Structure::For),
        _ => None,
    }
}
