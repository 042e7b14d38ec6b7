//! Blocks of axis words and nothing else, one after the other, as programs mostly are: each is the motion before to another
//! place.

use super::interpreter::{AXES, Interpreter, bit};
use super::modal::{ModalFeed, MotionMode};
use super::travel::CONTACTS;
use super::{ContactWords, Motion, MotionKind};
use crate::program::{Address, Block, Dialect};

/// Words that leave every mode as it is, a feed apart.
const PLAIN: u32 = AXES | CONTACTS | bit(Address::F) | bit(Address::N);

impl Interpreter {
    /// The motion of a block that is plain: no codes but G0 and G1, or a statement that says no more than they do.
    #[inline]
    pub(super) fn move_plainly(&mut self, index: usize, block: &Block, motions: &mut Vec<Motion>) {
        let motion = self.repeated(index, block, motions.last());
        if let Some(motion) = motion {
            motions.push(motion);
        } else {
            let before = motions.len();
            self.move_axes(index, block, None, motions);
            self.repeats = motions.len() > before && motions.last().is_some_and(|last| self.can_repeat(last));
        }
    }

    /// Whether a block of axis words behind this motion, the last one, says all that its own motion is not like it.
    fn can_repeat(&self, motion: &Motion) -> bool {
        let is_straight = matches!(motion.kind, MotionKind::Linear | MotionKind::Rapid);
        let is_followed = motion.start.is_some() && motion.end.is_some() && motion.unfollowable.is_none();
        let counts_from_zero = self.modal.incremental == Some(false) && self.modal.mm_per_unit.is_some();
        is_straight
            && is_followed
            && counts_from_zero
            && self.obstacle.is_none()
            && motion.extra.is_none()
            && motion.tool_axis.is_none()
            && self.position.tool_axis == [None; 3]
            && !self.corner_open
            && !self.modal.shortest_path
            && !self.modal.rotary_feed_in_mm
    }

    #[inline]
    fn repeated(&mut self, index: usize, block: &Block, before: Option<&Motion>) -> Option<Motion> {
        let before = before.filter(|_| self.repeats)?;
        let words = &self.block;
        let same_kind = match self.modal.motion? {
            MotionMode::Linear => before.kind == MotionKind::Linear,
            MotionMode::Rapid => before.kind == MotionKind::Rapid,
            _ => false,
        };
        let is_odd = words.odd | words.comma != 0;
        let present = words.present;
        let moves = present & AXES != 0 && present & bit(self.foreign_address) == 0;
        if !same_kind || is_odd || !moves || present & !PLAIN != 0 {
            return None;
        }
        self.set_feed();
        let feed = if (present & bit(Address::F) != 0) || before.feed.word_in_block {
            self.feed()
        } else {
            before.feed
        };
        self.take_absolute_words();
        let (mut contact, mut decimals) = (ContactWords::None, self.position.modal_decimals());
        if present & CONTACTS != 0 {
            self.take_other_words();
            contact = self.contact();
        }
        if present & self.own_axes() != self.own_axes() || present & CONTACTS != 0 {
            decimals = self.decimals();
        }
        Some(Motion {
            block: u32::try_from(index).unwrap_or(u32::MAX),
            line: block.line,
            start: before.end,
            end: self.position.axis_words(),
            linear_end_mm: self.position.linear_mm(),
            repeats: present & CONTACTS == 0 || contact != ContactWords::None,
            contact,
            feed,
            decimals,
            program_decimals: self.note_decimals(decimals),
            ..*before
        })
    }

    /// X Y Z and the rotary axes of the machine.
    #[inline]
    fn own_axes(&self) -> u32 {
        AXES & !bit(self.foreign_address)
    }

    /// Moves the axes to where plain numbers in the sense of G90 say, in a unit that is known.
    #[inline]
    fn take_absolute_words(&mut self) {
        let mm_per_unit = self.modal.mm_per_unit.unwrap_or(1.0);
        let [first, second] = self.rotary_addresses;
        for (slot, address) in [Address::X, Address::Y, Address::Z, first, second].into_iter().enumerate() {
            let index = address.index() & 31;
            if self.block.present & (1 << index) != 0 {
                let scale = if slot < 3 { mm_per_unit } else { 1.0 };
                self.position.decimals[slot] = self.block.decimals[index];
                self.position.axes[slot] = Some(self.block.values[index] * scale);
            }
        }
    }

    /// Whether motions that [repeat](Motion::repeats) the last one would be the same here as where they were read: what
    /// the control knows beside their words is in that motion. In dialects whose statements may run over lines a
    /// line alone does not say what it is.
    #[must_use]
    pub fn can_pass_over(&self) -> bool {
        let is_by_lines = matches!(self.dialect, Dialect::Iso | Dialect::Siemens | Dialect::Csv);
        self.repeats && is_by_lines && !self.has_ended() && !self.sections.is_passing()
    }

    /// Goes on behind repeating motions that were not read, of which this is the last. All of them state a feed or none,
    /// and a contact of the same kind.
    pub fn pass_over(&mut self, last: &Motion) {
        if let Some(end) = last.end {
            let ([x, y, z], [first, second]) = (end.linear_mm, end.rotary_deg);
            self.position.axes = [x, y, z, first, second].map(Some);
        }
        match last.contact {
            ContactWords::None => {}
            ContactWords::Point(at) => self.position.contact_mm = at.map(Some),
            ContactWords::Normal(normal) => self.position.normal = normal.map(Some),
        }
        if last.feed.word_in_block {
            self.modal.feed = ModalFeed::Given(last.feed.raw, last.feed.decimals);
        }
    }
}
