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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::machine::{Machine, Preset};
    use crate::motion::InterpreterOptions;
    use crate::program::{Batch, Diagnostics, ReadLimits, Reader};

    /// The motions of a text, read in one batch, or line by line so that none has one before it to repeat.
    fn motions(dialect: Dialect, text: &str, line_by_line: bool) -> Vec<Motion> {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::default());
        let (mut batch, mut diagnostics) = (Batch::new(), Diagnostics::new());
        let (mut all, mut new) = (Vec::new(), Vec::new());
        let mut take = |reader: &mut Reader| {
            while reader.next_part(&mut batch).unwrap() {
                interpreter.interpret(&mut batch, &mut new, &mut diagnostics);
                all.append(&mut new);
            }
        };
        for line in text.split_inclusive('\n') {
            reader.feed(line.as_bytes());
            if line_by_line {
                take(&mut reader);
            }
        }
        reader.finish();
        take(&mut reader);
        all
    }

    /// Lines that mostly repeat, and what stands between such lines.
    fn line() -> impl Strategy<Value = String> {
        let word =
            (prop::sample::select(vec!["X", "Y", "Z", "A", "C", "U", "V", "W"]), -900_i32..900, 0_usize..4)
                .prop_map(|(letter, value, decimals)| {
                    format!("{letter}{:.decimals$}", f64::from(value) / 8.0)
                });
        let plain = prop::collection::vec(word, 1..5).prop_map(|words| words.join(" "));
        let feed = (plain.clone(), 1_u32..900).prop_map(|(words, feed)| format!("{words} F{feed}"));
        let other = prop::sample::select(vec![
            "G0",
            "G1",
            "G1 X1.5",
            "G0 Z5.",
            "G90",
            "G91",
            "G91 X1.",
            "G90 C2.",
            "G20",
            "G21",
            "G93",
            "G94",
            "G94 F50",
            "G95",
            "G17",
            "G18",
            "G2 X1. I0.5",
            "G1 X9.",
            "G41",
            "G40",
            "G43.4 H1",
            "G49",
            "G54",
            "G55",
            "G52 X1.",
            "G92 X0.",
            "M8",
            "M6 T2",
            "T3",
            "G28 X0.",
            "G53 X1.",
            "G68 X0. Y0. R30.",
            "G69",
            "G81 Z-1. R1. F9",
            "G80",
            "(note)",
            "",
            "/X1.",
            "N10 X1.",
            "X1. (note)",
            "B1.",
            "X1. B0.",
            "E1.",
            "G4 P1.",
            "G4 F2.",
            "#1=2",
            "X#1",
            "X[1+1]",
            "G51 X0. P2.",
            "G50",
            "G5 X1.",
            "S900",
            "X1. ,R2.",
            "X",
            "I1. X2.",
            "G10 L2 P1 X0.",
            "M428",
            "M98 P7",
            "G61",
            "X-.0",
            "X1. X2.",
        ]);
        prop_oneof![6 => plain, 2 => feed, 3 => other.prop_map(str::to_owned)]
    }

    proptest! {
        /// The short way for blocks that repeat makes the motions of the long way, whatever stands between them: on this
        /// rests that copied blocks need not be read a second time.
        #[test]
        fn a_repeated_motion_is_the_motion_that_the_long_way_makes(
            lines in prop::collection::vec(line(), 1..40),
            siemens in any::<bool>(),
        ) {
            let dialect = if siemens { Dialect::Siemens } else { Dialect::Iso };
            let text = format!("G0 X0 Y0 Z0 A0 C0\nG1 F100 X1.\n{}\n", lines.join("\n"));
            let short = motions(dialect, &text, false);
            let long = motions(dialect, &text, true);
            let plain = |motion: &Motion| Motion { block: 0, repeats: false, ..*motion };
            prop_assert_eq!(
                short.iter().map(plain).collect::<Vec<_>>(),
                long.iter().map(plain).collect::<Vec<_>>()
            );
        }
    }

    #[test]
    fn plain_lines_take_the_short_way() {
        let text = "G0 X0 Y0 Z0 A0 C0\nG1 F100 X1.\nX2.\nY3. C4.\nX5.\n";
        let short = motions(Dialect::Iso, text, false);
        assert!(short[2..].iter().all(|motion| motion.repeats), "{short:?}");
    }
}
