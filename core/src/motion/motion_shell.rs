//! A motion but for its places: what modes, words and offsets say of it.

use super::block_words::BlockWords;
use super::interpreter::Interpreter;
use super::modal::ToolLength;
use super::travel::{CENTRE, CONTACT, NORMAL, NORMALS, VECTOR, VECTORS};
use super::{ArcCourse, ContactWords, Decimals, Interpolation, Motion, MotionKind};
use crate::program::{Address, Block};

const LINEAR: [Address; 3] = [Address::X, Address::Y, Address::Z];

impl Interpreter {
    /// A motion with all that modes and words say but for places.
    #[inline]
    pub(super) fn motion_shell(&mut self, index: usize, block: &Block, kind: MotionKind) -> Motion {
        let decimals = self.decimals();
        let program_decimals = self.note_decimals(decimals);
        Motion {
            block: u32::try_from(index).unwrap_or(u32::MAX),
            line: block.line,
            called: self.called,
            kind,
            arc: if kind == MotionKind::Arc { self.arc_course() } else { ArcCourse::Carried },
            further_turns: self.this_block.further_turns.filter(|_| kind == MotionKind::Arc),
            interpolation: match self.modal.tool_length {
                Some(ToolLength::Tcp | ToolLength::Vector) => Interpolation::Tcp,
                Some(ToolLength::Plain | ToolLength::OtherTcp) | None => Interpolation::Machine,
            },
            start: None,
            end: None,
            linear_end_mm: None,
            tool_axis: None,
            vector_start: None,
            program_offset_mm: self.modal.program_offset_mm.filter(|_| !self.may_place_gauge_point()),
            frame: None,
            in_machine: false,
            repeats: false,
            contact: ContactWords::None,
            feed: self.feed(),
            extra: None,
            plane: self.modal.plane,
            incremental: self.modal.incremental == Some(true),
            mm_per_unit: self.modal.mm_per_unit.unwrap_or(1.0),
            decimals,
            program_decimals,
            unfollowable: None,
            offset_changed: self.offset_changed(),
            is_shifted: self.modal.is_shifted(),
            work_offset: self.modal.work_offset,
            tool: self.modal.spindle.tool(),
            compensation: self.radius_compensation(),
            exact_stop: self.modal.exact_stop || self.this_block.exact_stop,
            is_only_offset: self.modal.work_offset.is_some_and(|offset| self.is_only_offset(offset)),
        }
    }

    /// Takes a block's decimals into the most of the program, and gives these.
    #[inline]
    pub(super) fn note_decimals(&mut self, decimals: Decimals) -> Decimals {
        let most = &mut self.program_decimals;
        most.linear = most.linear.max(decimals.linear);
        most.rotary = most.rotary.max(decimals.rotary);
        most.contact = most.contact.max(decimals.contact);
        most.extra = most.extra.max(decimals.extra);
        *most
    }

    /// The values that the current arc depends on.
    fn arc_course(&self) -> ArcCourse {
        // `I=AC(…)` does not move with the ends.
        let centre_stands = self.block.absolute & CENTRE != 0;
        if self.rules.is_of_points || self.this_block.about_centre || centre_stands {
            ArcCourse::Centre
        } else if self.this_block.tangent {
            ArcCourse::Neighbour
        } else {
            ArcCourse::Carried
        }
    }

    /// Of the words of the block; a class without a word takes its modal values.
    #[inline]
    pub(super) fn decimals(&self) -> Decimals {
        let modal = self.position.modal_decimals();
        let most = |addresses: &[Address], modal: u8| {
            let mut found = false;
            let mut most = 0;
            for &address in addresses {
                if self.block.has(address) {
                    found = true;
                    most = most.max(self.block.decimals[address.index()]);
                }
            }
            if found { most } else { modal }
        };
        let mut contact = most(&CONTACT, modal.contact);
        if self.block.present & NORMALS != 0 {
            contact = most(&NORMAL, contact);
        }
        Decimals {
            linear: most(&LINEAR, modal.linear),
            rotary: if self.block.present & VECTORS != 0 {
                most_decimals(&self.block)
            } else {
                most(&self.axes.rotary(), modal.rotary)
            },
            contact,
            extra: modal.extra,
        }
    }

    /// Whether the motion stands under a work offset that is neither the program's only one nor stated, or under a
    /// shift of it.
    #[inline]
    fn offset_changed(&self) -> bool {
        self.modal.is_shifted()
            || self.modal.program_offset_mm != Some([0.0; 3])
            || self.modal.work_offset.is_some_and(|offset| {
                !self.is_only_offset(offset) && self.options.work_offsets.of(offset, false).is_none()
            })
    }

    #[inline]
    pub(super) fn note_offset(&mut self, motion: &mut Motion) {
        let is_complete =
            motion.end.is_some() || (motion.linear_end_mm.is_some() && motion.tool_axis.is_some());
        if is_complete && self.only_offset.is_none() {
            self.only_offset = self.modal.work_offset;
        }
        motion.is_shifted = self.modal.is_shifted();
        motion.offset_changed = self.offset_changed();
        motion.is_only_offset = self.modal.work_offset.is_some_and(|offset| self.is_only_offset(offset));
    }
}

/// Of a block's tool vector.
pub(super) fn most_decimals(block: &BlockWords) -> u8 {
    let decimals = VECTOR.map(|address| if block.has(address) { block.decimals[address.index()] } else { 0 });
    decimals.into_iter().max().unwrap_or(0)
}
