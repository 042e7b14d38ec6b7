//! A block divided into parts, and what must hold for each part when the written program is read back.

use super::checked::Checked;
use super::division::Division;
use crate::contact::{BlockTime, Segment, Station, block_time_s};
use crate::motion::{ContactWords, Interpolation, Motion, MotionKind};
use crate::process::fault::Fault;
use crate::process::pipeline::{SAME_READ_BACK, TIME_ROUNDING, failed, same_words};

/// A difference in the last bit of a word may push a value that was just inside over its limit (share).
pub(in crate::process) const LAST_BIT: f64 = 1e-9;
/// The extruder word of a part may be rounded beyond the block's ends by this \[program units\].
const SAME_EXTRA: f64 = 1e-3;

/// A divided block with its plan.
#[derive(Debug)]
pub(in crate::process) struct DividedBlock<'a> {
    pub(in crate::process) source: Motion,
    pub(in crate::process) checked: Checked<'a>,
    pub(in crate::process) division: Division,
    /// Largest distance of a part's end from where the source block has it \[mm\].
    pub(in crate::process) correction_mm: f64,
}

impl DividedBlock<'_> {
    /// Checks kind, place and carried words of the part of this index, and returns the part between the words that
    /// were read. `stated` is the caller's interpolation mode.
    ///
    /// # Errors
    /// The part is not the one that was planned.
    pub(in crate::process) fn check_part(
        &self,
        read: &Motion,
        index: usize,
        stated: Option<Interpolation>,
    ) -> Result<Segment, Fault> {
        let (line, block, nodes) = (self.source.line, &self.checked.block, &self.division.nodes);
        let node = nodes.get(index).ok_or(failed(line, "the block has one part more than planned"))?;
        let (Some(start), Some(end)) = (read.start, read.end) else {
            return Err(failed(line, "a part of a divided block has no known end"));
        };
        let before = index.checked_sub(1).and_then(|before| nodes.get(before));
        let planned_start = before.map_or(block.ends[0].words, |before| before.station.words);
        let mode = read.mode(stated);
        let same_modes = read.kind == MotionKind::Linear
            && read.unfollowable.is_none()
            && mode == block.mode
            && read.feed.mode == self.source.feed.mode
            && read.incremental == self.source.incremental
            && read.frame == self.source.frame;
        if !same_modes {
            return Err(failed(line, "a part of a divided block is another kind of motion"));
        }
        if !same_words(Some(start), Some(planned_start)) || !same_words(Some(end), Some(node.station.words)) {
            return Err(failed(line, "a part of a divided block is not where it was planned"));
        }
        self.check_carried_words(read, index)?;
        let ends = [start, end].map(|words| Station::new(block.machine, &block.kinematics, mode, words));
        Ok(Segment { ends, fraction: [before.map_or(0.0, |before| before.fraction), node.fraction] })
    }

    /// Checks the words that move with the axes: contact words of the same kind, and the extruder. Both end where the
    /// source block ends them. The extruder stays between its values at the block's ends.
    fn check_carried_words(&self, read: &Motion, index: usize) -> Result<(), Fault> {
        let (line, source) = (self.source.line, &self.source);
        let last = index + 1 == self.division.nodes.len();
        let same_kind = std::mem::discriminant(&read.contact) == std::mem::discriminant(&source.contact);
        // If the block began without a contact, only its last part may state one.
        let fits = match self.checked.start_contact {
            Some(_) => same_kind,
            None => last || read.contact == ContactWords::None,
        };
        if !fits || (last && !same_contact(read.contact, source.contact)) {
            return Err(failed(line, "a part of a divided block has other contact words than planned"));
        }
        match (read.extra, source.extra) {
            (None, None) => Ok(()),
            (Some(part), Some(whole)) => {
                let start = whole.start.unwrap_or(whole.end);
                let between = part.end >= start.min(whole.end) - SAME_EXTRA
                    && part.end <= start.max(whole.end) + SAME_EXTRA;
                let ends = !last || (part.end - whole.end).abs() <= SAME_READ_BACK;
                if between && ends {
                    Ok(())
                } else {
                    Err(failed(line, "the extruder of a divided block goes to another place than planned"))
                }
            }
            _ => Err(failed(line, "the extruder word of a divided block is missing or was added")),
        }
    }

    /// Checks that every part takes its share of the source block's time.
    pub(in crate::process) fn check_time(&self, read: &Motion, segment: &Segment) -> Result<(), Fault> {
        let (source, block) = (&self.source, &self.checked.block);
        let Some(mode) = source.feed.mode.filter(|_| self.division.carries_feed) else { return Ok(()) };
        let time_s = |feed, segment: &Segment| {
            block_time_s(mode, feed, &BlockTime::of(block, segment, source.mm_per_unit, source.feed.paths))
        };
        // In G95 the time depends on the spindle, so only the formula of the plan is available.
        let Some(whole_s) = time_s(source.feed.raw, &block.whole()) else { return Ok(()) };
        let share_s = whole_s * (segment.fraction[1] - segment.fraction[0]);
        match time_s(read.feed.raw, segment) {
            Some(part_s) if (part_s - share_s).abs() <= TIME_ROUNDING * share_s => Ok(()),
            _ => Err(failed(source.line, "a part of a divided block does not take its share of the time")),
        }
    }
}

fn same_contact(a: ContactWords, b: ContactWords) -> bool {
    match (a, b) {
        (ContactWords::Point(a), ContactWords::Point(b))
        | (ContactWords::Normal(a), ContactWords::Normal(b)) => {
            a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= SAME_READ_BACK)
        }
        (a, b) => a == b,
    }
}
