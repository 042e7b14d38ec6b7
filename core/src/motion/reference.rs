//! Returns to a reference position: the axes that a block names go through the point of its words first.

use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::modal::ToolLength;
use super::{Motion, MotionKind, Unfollowable};
use crate::program::{Address, Block};

/// Words that a return through a known point may have: axes, the number of the reference position, and words that no
/// motion depends on. A return at a feed is one of a printer, which passes no point.
const WORDS: u32 =
    AXES | Address::P.bit() | Address::S.bit() | Address::N.bit() | Address::T.bit() | Address::D.bit();

impl Interpreter {
    /// The way to the point of the words, at rapid traverse, if it is certain and the axes are not there already.
    /// Returns whether the axes go on from that point, so that no other way is possible.
    pub(super) fn pass_point(
        &mut self,
        index: usize,
        block: &Block,
        reason: Option<Unfollowable>,
        motions: &mut Vec<Motion>,
    ) -> bool {
        let words = &self.block;
        let present = words.present;
        let is_certain = self.options.as_it_runs
            && self.rules.reference_passes_point
            && reason.is_none()
            && self.obstacle().is_none()
            && present & AXES != 0
            && present & !WORDS == 0
            && present & self.axes.foreign().bit() == 0
            && words.unknown & present == 0
            && (words.absolute | words.incremental) & present == 0
            && words.comma == 0
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.modal.compensation == Some(false);
        // Printers also go home by zeros.
        let is_zero = |address: Address| self.block.value(address).is_none_or(|value| value.abs() <= 0.0);
        let is_home = self.modal.incremental == Some(false) && self.axes.all().into_iter().all(is_zero);
        if !is_certain || is_home {
            return false;
        }
        let (before, start) = (self.position.axes, self.position.axis_words());
        self.take_axis_words();
        let named = self.axes.all().map(|address| present & address.bit() != 0);
        let mut ends = named.into_iter().zip(before.iter().zip(&self.position.axes));
        let (mut moves, mut is_known) = (false, true);
        ends.by_ref().filter(|(is_named, _)| *is_named).for_each(|(_, (from, to))| {
            moves |= from != to;
            is_known &= to.is_some();
        });
        if !(moves && is_known) {
            return true;
        }
        let mut motion = self.motion_shell(index, block, MotionKind::Rapid);
        motion.start = start;
        motion.end = self.position.axis_words();
        motion.linear_end_mm = self.position.linear_mm();
        self.note_offset(&mut motion);
        motions.push(motion);
        true
    }
}
