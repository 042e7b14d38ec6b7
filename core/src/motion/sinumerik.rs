//! Further effects of Sinumerik blocks: tools and their edges, the programmable frame.

use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::meaning::ProgramFrame;
use super::modal::Transformation;
use crate::geometry::Turn;
use crate::program::{Address, Code, Keyword};

const LINEAR: [Address; 3] = [Address::X, Address::Y, Address::Z];
const ROTARY: u32 = Address::A.bit() | Address::B.bit() | Address::C.bit();
const FRAMES: [Transformation; 3] =
    [Transformation::Rotation, Transformation::Scaling, Transformation::Mirror];

impl Interpreter {
    /// T and D: another tool or another edge has another length, so the tip is elsewhere. D takes effect with its own
    /// block.
    #[inline]
    pub(super) fn take_tool_words(&mut self, may_be_skipped: bool) {
        if self.block.present & (Address::T.bit() | Address::D.bit()) == 0 {
            return;
        }
        if self.block.has(Address::T) {
            self.modal.edge = None;
            self.position.forget_linear();
        }
        if self.block.has(Address::D) {
            let edge = self.block.value(Address::D);
            if edge.is_none() || edge != self.modal.edge {
                self.position.forget_linear();
            }
            self.modal.edge = edge;
            self.modal.had_length |= edge.is_some_and(|edge| edge > 0.0);
        }
        if may_be_skipped {
            self.modal.edge = None;
        }
    }

    /// TRANS, ROT, SCALE, MIRROR. Without `added` they replace the whole programmable frame. Without words they remove
    /// the frame.
    pub(super) fn program_frame(&mut self, frame: ProgramFrame, added: bool) {
        let has_angle = self.block.g_codes().contains(&Code::Keyword(Keyword::PlaneAngle));
        let has_words = self.block.present & AXES != 0 || has_angle;
        if !added {
            for which in FRAMES {
                self.transform(which, false);
            }
            self.offset_by(Some([0.0; 3]));
        }
        if !has_words {
            return;
        }
        match frame {
            ProgramFrame::Offset => self.add_offset(),
            ProgramFrame::Rotation => self.turn_frame(has_angle),
            ProgramFrame::Scaling => self.transform(Transformation::Scaling, true),
            ProgramFrame::Mirror => self.transform(Transformation::Mirror, true),
        }
    }

    /// ROT and AROT with the words of the block. A turn about one axis is followed if the program is followed as it
    /// runs. The order of several turns in one block depends on a setting of the control.
    fn turn_frame(&mut self, by_plane: bool) {
        let is_turned =
            self.modal.transformations.get(Transformation::Rotation as usize) != Some(&Some(false));
        let before = if is_turned { self.modal.turn } else { Some(Turn::NONE) };
        let stated = self.block.present & AXES;
        let mut axes = LINEAR.into_iter().enumerate().filter(|(_, address)| stated == address.bit());
        let about = axes.next().and_then(|(axis, address)| Some((axis, self.block.value(address)?)));
        let turn = before.zip(about).map(|(turn, (axis, angle_deg))| turn.then_about(axis, angle_deg));
        if let Some(turn) = turn.filter(|_| self.options.as_it_runs && !by_plane) {
            self.position.forget_linear();
            self.modal.transformations[Transformation::Rotation as usize] = Some(true);
            self.modal.turn = Some(turn);
        } else {
            self.position.forget_axes();
            self.transform(Transformation::Rotation, true);
        }
    }

    /// ATRANS with the words of the block. After a rotation, a scale or a mirror the offset counts along the changed
    /// axes. It is not known then.
    fn add_offset(&mut self) {
        let is_off = |which: Transformation| {
            let is_followed = which == Transformation::Rotation && self.modal.turn.is_some();
            is_followed || self.modal.transformations.get(which as usize) == Some(&Some(false))
        };
        let is_straight = FRAMES.into_iter().all(is_off);
        let turns = self.block.present & ROTARY != 0;
        let offset = self.modal.program_offset_mm.filter(|_| is_straight && !turns);
        let mut added = Some([0.0; 3]);
        for (slot, address) in LINEAR.into_iter().enumerate().filter(|(_, address)| self.block.has(*address))
        {
            let value = self.block.value(address).zip(self.modal.mm_per_unit);
            added = added.zip(value).map(|(mut added, (value, scale))| {
                added[slot] = value * scale;
                added
            });
        }
        if let Some(turn) = self.modal.turn {
            self.position.forget_linear();
            added = added.map(|added| turn.of(added));
        }
        let sum = offset.zip(added).map(|(offset, added)| std::array::from_fn(|k| offset[k] + added[k]));
        self.offset_by(sum);
    }

    /// Sets another programmable offset. A setting of the control decides whether the axes keep their machine
    /// positions or their words, and this shows in incremental words. So no linear position that has moved is known.
    fn offset_by(&mut self, offset_mm: Option<[f64; 3]>) {
        if offset_mm.is_none() {
            self.position.forget_axes();
        } else {
            let before = self.modal.program_offset_mm;
            for slot in 0..LINEAR.len() {
                if offset_mm.map(|offset| offset[slot]) != before.map(|offset| offset[slot]) {
                    self.position.axes[slot] = None;
                    self.position.contact_mm[slot] = None;
                }
            }
        }
        self.modal.program_offset_mm = offset_mm;
    }
}

#[cfg(test)]
mod tests;
