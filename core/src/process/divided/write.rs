//! Writes a divided block: its parts in the block's own style.

use super::checked::Checked;
use super::contact_ends::{ContactEnds, contact_decimals};
use super::division::Division;
use crate::contact::{BlockTime, Effort, Node, Resolution, Segment, feed_word, segments};
use crate::motion::{Feed, FeedForm, FeedMode, Motion, rotary_addresses};
use crate::process::pipeline::{Emitter, differs, exact_decimals, form, in_units, rounded_feed};
use crate::program::{
    Address, Batch, Block, NewWord, WriteFault, print_changed_without, print_inserted_without,
    round_to_decimals,
};

/// Writing a part takes as long as this number of evaluations.
const PART_EVALUATIONS: u64 = 8;

/// Writes a divided block: the source block with the first part's words, then one block for each further part. Stops
/// early if the effort has ended.
pub(in crate::process) fn write_division(
    emitter: &mut Emitter,
    batch: &Batch,
    checked: &Checked<'_>,
    motion: &Motion,
    division: &Division,
    effort: &mut Effort<'_>,
    out: &mut Vec<u8>,
) -> Result<(), WriteFault> {
    let block = &checked.block;
    let index = motion.block as usize;
    let mut words = Words::new(batch, checked, motion, division);
    let source_time = BlockTime::of(block, &block.whole(), motion.mm_per_unit, motion.feed.paths);
    let mut modal_feed = emitter.modal_feed_before(&motion.feed);
    let last = division.nodes.len() - 1;
    let mut number = emitter.number_after(batch, index, last as u64);
    for (k, (node, segment)) in division.nodes.iter().zip(segments(block, &division.nodes)).enumerate() {
        effort.pass(PART_EVALUATIONS);
        if effort.is_over() {
            return Ok(());
        }
        let mut list = words.at(node, k == last, k > 0);
        if division.carries_feed
            && let Some(feed) = part_feed(&motion.feed, &source_time, checked, &segment, motion)
        {
            let form = form(batch);
            let always = motion.feed.mode == Some(FeedMode::InverseTime) || form == FeedForm::Cell;
            if always || differs(feed.value, modal_feed) {
                list.push(feed);
                modal_feed = feed.value;
                emitter.count_feed(batch, &[feed]);
            }
        }
        let dropped = words.dropped(k == last);
        if k == 0 {
            print_changed_without(batch, index, &list, dropped, last > 0, out)?;
        } else {
            if let Some(next) = number {
                let value = next as f64;
                list.insert(0, NewWord { address: Address::N, value, decimals: 0 });
                emitter.count_number(value);
                number = Some(next + 1);
            }
            print_inserted_without(batch, index, &list, dropped, k == last, out)?;
        }
    }
    if !division.carries_feed {
        emitter.owe_nothing();
        return Ok(());
    }
    emitter.owe_after_division(batch, index, &motion.feed, modal_feed, out)
}

fn part_feed(
    feed: &Feed,
    source_time: &BlockTime,
    checked: &Checked<'_>,
    segment: &Segment,
    motion: &Motion,
) -> Option<NewWord> {
    let (mode, _) = (feed.mode?, feed.value?);
    let share = segment.fraction[1] - segment.fraction[0];
    let part_time = BlockTime::of(&checked.block, segment, motion.mm_per_unit, motion.feed.paths);
    let value = feed_word(mode, feed.raw, source_time, &part_time, share)?;
    Some(rounded_feed(feed, value))
}

/// Builds the words of each part: absolute, or in G91 counted from the point before.
struct Words<'a> {
    checked: &'a Checked<'a>,
    motion: &'a Motion,
    resolution: Resolution,
    letters: [Address; 5],
    present: [bool; 5],
    /// A neighbouring block omits the word, so inserted blocks omit it where it does not change.
    left_out: [bool; 5],
    /// The written position so far: X Y Z in program units, rotary axes in degrees.
    written: [f64; 5],
    /// The source block states the tool axis as a vector.
    states_axis: bool,
    contact: ContactEnds,
    extra: Option<(f64, f64)>,
}

const VECTOR: [Address; 3] = [Address::TI, Address::TJ, Address::TK];

impl<'a> Words<'a> {
    fn new(batch: &Batch, checked: &'a Checked<'a>, motion: &'a Motion, division: &Division) -> Self {
        let rotary = rotary_addresses(checked.block.machine);
        let letters = [Address::X, Address::Y, Address::Z, rotary[0], rotary[1]];
        let source = batch.blocks().get(motion.block as usize).map_or(&[][..], |block| batch.words(block));
        let present = letters.map(|letter| source.iter().any(|word| word.address == letter));
        let states_axis = source.iter().any(|word| word.address == Address::TI);
        let contact = ContactEnds::of(checked, motion);
        let extra = motion.extra.and_then(|extra| extra.start.map(|start| (start, extra.end)));
        Self {
            checked,
            motion,
            resolution: division.resolution,
            letters,
            present,
            left_out: left_out(batch, motion.block as usize, letters),
            written: in_units(&motion.stated(checked.block.ends[0].words), motion.mm_per_unit),
            contact,
            extra,
            states_axis,
        }
    }

    /// The words of the part that ends at `node`. `inserted` means that the part is a block of its own.
    fn at(&mut self, node: &Node, last: bool, inserted: bool) -> Vec<NewWord> {
        let target = in_units(&self.motion.stated(node.station.words), self.motion.mm_per_unit);
        let mut list = Vec::with_capacity(12);
        let mut standing = None;
        // In a tilted plane the rotary axes stand, wherever the control has turned them.
        let has_rotary = self.motion.tool_axis.is_none() && self.motion.frame.is_none();
        let axes = if has_rotary { 5 } else { 3 };
        for (k, target) in target.into_iter().enumerate().take(axes) {
            let decimals =
                if k < 3 { self.resolution.linear_decimals } else { self.resolution.rotary_decimals };
            let from = if self.motion.incremental { self.written[k] } else { 0.0 };
            let value = target - from;
            let decimals = if last { exact_decimals(value, decimals) } else { decimals };
            let rounded = round_to_decimals(value, decimals);
            let position = from + rounded;
            let word = NewWord { address: self.letters[k], value: rounded, decimals };
            if differs(position, self.written[k]) || (self.present[k] && !(inserted && self.left_out[k])) {
                list.push(word);
            } else if self.present[k] {
                standing.get_or_insert(word);
            }
            self.written[k] = position;
        }
        self.axis_words(node, last, &mut list);
        if list.is_empty() {
            // A block without an axis word would not be a motion.
            list.extend(standing);
        }
        self.contact_words(node, last, &mut list);
        if let Some((start, end)) = self.extra {
            let decimals = self.motion.decimals.extra;
            let value = if last { end } else { start + (end - start) * node.fraction };
            list.push(NewWord { address: Address::E, value, decimals });
        }
        list
    }

    /// The tool axis, if the program states it as a vector: all three components, where it turns.
    fn axis_words(&self, node: &Node, last: bool, list: &mut Vec<NewWord>) {
        let Some(decimals) = self.resolution.axis_decimals else { return };
        let axis = if last { self.motion.tool_axis.filter(|_| self.states_axis) } else { node.written_axis };
        for (address, value) in VECTOR.into_iter().zip(axis.into_iter().flatten()) {
            let decimals = if last { exact_decimals(value, decimals) } else { decimals };
            list.push(NewWord { address, value, decimals });
        }
    }

    /// The words of the source block that a part omits.
    fn dropped(&self, last: bool) -> &[Address] {
        match &self.contact {
            ContactEnds::End(addresses, ..) if !last => addresses,
            _ => &[],
        }
    }

    fn contact_words(&self, node: &Node, last: bool, list: &mut Vec<NewWord>) {
        let Some((addresses, values, unit)) = self.contact.at(self.checked, self.motion, node, last) else {
            return;
        };
        for (address, value) in addresses.into_iter().zip(values) {
            let decimals = self.motion.decimals.contact;
            let decimals = if last {
                exact_decimals(value / unit, decimals)
            } else {
                contact_decimals(addresses, decimals)
            };
            list.push(NewWord { address, value: value / unit, decimals });
        }
    }
}

/// For each of these words, whether a neighbouring block with any of them omits it.
fn left_out(batch: &Batch, index: usize, letters: [Address; 5]) -> [bool; 5] {
    let has =
        |block: &Block| letters.map(|letter| batch.words(block).iter().any(|word| word.address == letter));
    let (before, from) = batch.blocks().split_at(index.min(batch.blocks().len()));
    let moves = |words: &[bool; 5]| words.contains(&true);
    let neighbours = [before.iter().rev().map(has).find(moves), from.iter().skip(1).map(has).find(moves)];
    std::array::from_fn(|k| neighbours.iter().flatten().any(|words| !words[k]))
}
