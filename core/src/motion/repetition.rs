//! Blocks that have only axis words, one after the other. Most programs consist mainly of such blocks. Each repeats
//! the motion before it to another place.

use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::modal::{ModalFeed, MotionMode};
use super::motion_shell::most_decimals;
use super::travel::{CONTACTS, POINTS, VECTOR, VECTORS};
use super::{ContactWords, Motion, MotionKind, Unfollowable};
use crate::program::{Address, Block};

/// Words that leave every mode unchanged, except the feed.
const PLAIN: u32 = AXES | CONTACTS | Address::F.bit() | Address::N.bit();

impl Interpreter {
    /// The motion of a plain block: it has no codes except G0 and G1, or its statement says no more than these codes.
    #[inline]
    pub(super) fn move_plainly(&mut self, index: usize, block: &Block, motions: &mut Vec<Motion>) {
        let motion = self.repeated(index, block, motions.last());
        if let Some(motion) = motion {
            motions.push(motion);
        } else {
            let before = motions.len();
            self.move_axes(index, block, None, motions);
            self.states_vector = self.block.present & VECTORS == VECTORS;
            self.repeats = motions.len() > before && motions.last().is_some_and(|last| self.can_repeat(last));
        }
    }

    /// Whether a block of axis words after this motion, the last one, states every difference between its own motion
    /// and this one.
    fn can_repeat(&self, motion: &Motion) -> bool {
        let is_straight = matches!(motion.kind, MotionKind::Linear | MotionKind::Rapid);
        let is_followed = if motion.tool_axis.is_some() {
            self.is_by_vector(motion)
        } else {
            motion.start.is_some()
                && motion.end.is_some()
                && motion.unfollowable.is_none()
                && self.obstacle().is_none()
                && self.position.tool_axis == [None; 3]
        };
        let counts_from_zero = self.modal.incremental == Some(false) && self.modal.mm_per_unit.is_some();
        is_straight
            && is_followed
            && counts_from_zero
            && motion.extra.is_none()
            && !self.corner_open
            && !self.has_point_arc()
            && !self.modal.shortest_path
            && !self.places_gauge_point()
            && !self.modal.rotary_feed_in_mm
    }

    /// Whether a point of cutter location data goes from a known point and vector to another, and only the vector
    /// prevents following it.
    fn is_by_vector(&self, motion: &Motion) -> bool {
        let vector = Some(Unfollowable::ToolVector);
        self.rules.is_of_points
            && motion.start.is_none()
            && motion.end.is_none()
            && motion.vector_start.is_some()
            && motion.linear_end_mm.is_some()
            && motion.unfollowable == vector
            && self.obstacle() == vector
            && !self.modal.vectors_in_machine
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
        let moves = present & AXES != 0 && present & self.axes.foreign().bit() == 0;
        if !same_kind || is_odd || !moves || present & !(PLAIN | VECTORS) != 0 {
            return None;
        }
        // One or two of U V W are not a contact.
        if !matches!(present & POINTS, 0 | POINTS) {
            return None;
        }
        // All blocks state the vector or none does, and the tool axis is still that of the motion before.
        let vectors = if self.states_vector { VECTORS } else { 0 };
        if present & VECTORS != vectors || self.position.tool_axis() != before.tool_axis {
            return None;
        }
        self.set_feed();
        let feed = if (present & Address::F.bit() != 0) || before.feed.word_in_block {
            self.feed()
        } else {
            before.feed
        };
        self.take_absolute_words();
        if vectors != 0 {
            self.take_vector();
        }
        let (mut contact, mut decimals) = (ContactWords::None, self.position.modal_decimals());
        if present & CONTACTS != 0 {
            self.take_other_words();
            contact = self.contact();
        }
        if present & self.own_axes() != self.own_axes() || present & (CONTACTS | VECTORS) != 0 {
            decimals = self.decimals();
        }
        Some(Motion {
            block: u32::try_from(index).unwrap_or(u32::MAX),
            line: block.line,
            called: self.called,
            start: before.end,
            end: self.position.axis_words(),
            linear_end_mm: self.position.linear_mm(),
            tool_axis: self.position.tool_axis(),
            vector_start: before.linear_end_mm.zip(before.tool_axis),
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
        AXES & !self.axes.foreign().bit()
    }

    /// Moves the axes to the plain numbers in the sense of G90, in a known unit.
    #[inline]
    fn take_absolute_words(&mut self) {
        let mm_per_unit = self.modal.mm_per_unit.unwrap_or(1.0);
        for (slot, address) in self.axes.all().into_iter().enumerate() {
            let index = address.index() & 31;
            if self.block.present & (1 << index) != 0 {
                let scale = if slot < 3 { mm_per_unit } else { 1.0 };
                self.position.decimals[slot] = self.block.decimals[index];
                self.position.axes[slot] = Some(self.block.values[index] * scale);
            }
        }
    }

    /// Turns the tool axis to the plain numbers of a vector.
    #[inline]
    fn take_vector(&mut self) {
        self.position.tool_axis = VECTOR.map(|address| Some(self.block.values[address.index() & 31]));
        self.position.forget_rotary_words();
        self.position.decimals[3..].fill(most_decimals(&self.block));
    }

    /// Whether motions that [repeat](Motion::repeats) the last one would be the same here as in the place where they
    /// were read. The last motion holds everything that the control knows besides their words.
    #[must_use]
    pub fn can_pass_over(&self) -> bool {
        self.repeats && !self.has_ended() && !self.sections.is_passing()
    }

    /// Continues after repeating motions that were not read. Either all of them state a feed or none does, and all
    /// have a contact of the same kind.
    pub fn pass_over(&mut self, motions: &[Motion]) {
        let Some(last) = motions.last() else { return };
        if self.rules.has_sections {
            self.sections.count(motions);
        }
        if let (Some([x, y, z]), Some(axis)) = (last.linear_end_mm, last.tool_axis) {
            self.position.axes = [Some(x), Some(y), Some(z), None, None];
            self.position.tool_axis = axis.map(Some);
        } else if let Some(end) = last.end {
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
    use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};

    /// The motions of a text. The text is read in one batch, or line by line so that no motion has a motion before it
    /// to repeat.
    fn motions(dialect: Dialect, text: &str, line_by_line: bool) -> Vec<Motion> {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let mut interpreter = Interpreter::new(&machine, InterpreterOptions::in_mm());
        let (mut batch, mut diagnostics) = (Batch::new(), Diagnostics::new());
        let (mut all, mut new) = (Vec::new(), Vec::new());
        let mut take = |reader: &mut Reader, interpreter: &mut Interpreter| {
            while reader.next_part(&mut batch).unwrap() {
                interpreter.interpret(&mut batch, &mut new, &mut diagnostics);
                all.append(&mut new);
            }
        };
        for line in text.split_inclusive('\n') {
            reader.feed(line.as_bytes());
            if line_by_line {
                take(&mut reader, &mut interpreter);
                interpreter.repeats = false;
            }
        }
        reader.finish();
        take(&mut reader, &mut interpreter);
        all
    }

    /// Lines that mostly repeat, and other lines between them.
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

    /// Lines of conversational programs, with statements that continue and with statements that change the one before
    /// them.
    fn conversational_line() -> impl Strategy<Value = String> {
        let words = ["X", " Y", "z", "\tA", "C", "X", "Y", "Z"];
        let word = (prop::sample::select(words.to_vec()), -900_i32..900, 0_usize..4)
            .prop_map(|(letter, value, decimals)| format!("{letter}{:+.decimals$} ", f64::from(value) / 8.0));
        let plain = (any::<bool>(), 0_u32..99, prop::collection::vec(word, 1..5)).prop_map(
            |(is_numbered, number, words)| {
                let number = if is_numbered { format!("{number} ") } else { String::new() };
                format!("{number}L {}", words.concat())
            },
        );
        let feed = (plain.clone(), 1_u32..900).prop_map(|(words, feed)| format!("{words} F{feed}"));
        let ends = [
            "~\n X+3.5",
            " ; note",
            " ; note ~\n Y-2",
            " ~",
            " FMAX",
            " R0",
            " RL",
            " M3",
            " M91",
            "\r",
            " NX+0 NY+0 NZ+1",
        ];
        let longer =
            (plain.clone(), prop::sample::select(ends.to_vec())).prop_map(|(words, end)| words + end);
        let other: Vec<&str> = "|;|; L X+1|* - part|/L X+1|RND R1|7 RND R1 F20|CHF 1|CT X+1 Y+2|CC X+1 Y+1|\
            C X+2 Y+2 DR+|DEP LT LEN5|FN 0: Q1 = +2|Q1 = 3|L X+Q1|L IX+1|L B+1|L X+1,5|\
            LN X+1 Y+1 Z+1 NX+0 NY+0 NZ+1|LBL 1|LBL 0|CALL LBL 1|CALL LBL 1 REP2|TOOL CALL 2 Z S900|\
            CYCL DEF 7.0 DATUM|CYCL DEF 7.1 X+5|CYCL DEF 247 PRESET ~\n Q339=+1|CYCL CALL|M128|M129|\
            M126|L M127|M116|PLANE RESET STAY|STOP M8|L|L X|CALL PGM A|END PGM P MM|TOOL CALL 3"
            .split('|')
            .collect();

        prop_oneof![7 => plain, 2 => feed, 2 => longer, 2 => prop::sample::select(other).prop_map(str::to_owned)]
    }

    /// Lines of cutter location data.
    fn cutter_location_line() -> impl Strategy<Value = String> {
        let numbers = |count: usize| {
            prop::collection::vec((-900_i32..900, 0_usize..4), count).prop_map(|numbers| {
                let number = |(value, decimals)| format!("{:.decimals$}", f64::from(value) / 8.0);
                numbers.into_iter().map(number).collect::<Vec<_>>()
            })
        };
        let points = |count| numbers(count).prop_map(|numbers| format!("GOTO/{}", numbers.join(",")));
        let broken = numbers(6).prop_map(|numbers| {
            format!("goto /\t{}, $\n {}", numbers[..2].join(","), numbers[2..].join(" , "))
        });
        let touching = numbers(6).prop_map(|numbers| format!("GOTO/{},0,0.6,0.8", numbers.join(",")));
        let ends = [" $$ note", " ", "$\n", "\r", ","];
        let longer = (points(6), prop::sample::select(ends.to_vec())).prop_map(|(point, end)| point + end);
        let other: Vec<&str> =
            "|$$ note|$$ 1.0 0.0 0.0 2.5\n$$ 0.0 1.0 0.0 0.0\n$$ 0.0 0.0 1.0 0.0|$$ 1.0 0.0 0.0 2.5|\
            RAPID|FEDRAT/200.,MMPM|FEDRAT/2.,IPM|FEDRAT/0.2,MMPR|MULTAX/ON|MULTAX/OFF|MULTAX|\
            TLAXIS/0,0,1|TLAXIS/0,0.6,0.8|FROM/1,2,3|FROM/1,2,3,0,0,1|GODLTA/1,2,3|GODLTA/1|GOHOME|\
            CYCLE/DRILL,5|CYCLE/OFF|CUTCOM/LEFT|CUTCOM/OFF|UNITS/INCHES|UNITS/MM|LOADTL/2|CSYS/1|\
            PPRINT GOTO/1,2,3 $|COOLNT/ON|CIRCLE/0,0,0,0,0,1,5|TRACUT/1|GOFWD/1|GOTO/1,2|\
            GOTO/1E1,2,3|INSERT G91|CALL/SUB|GOTO/1,2,3,0,0,0|STOP|FINI"
                .split('|')
                .collect();

        prop_oneof![5 => points(6), 4 => points(3), 1 => broken, 1 => touching, 1 => longer, 2 => prop::sample::select(other).prop_map(str::to_owned)]
    }

    /// The start of both ways: after a first motion of the dialect.
    fn in_dialect() -> impl Strategy<Value = (Dialect, &'static str, Vec<String>)> {
        let iso = "G0 X0 Y0 Z0 A0 C0\nG1 F100 X1.";
        let conversational = "BEGIN PGM P MM\nL X+0 Y+0 Z+0 A+0 C+0 R0 F100\nL X+1";
        let cutter_locations = "UNITS/MM\nFEDRAT/100.,MMPM\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0,0,1";
        prop_oneof![
            prop::collection::vec(line(), 1..40).prop_map(move |lines| (Dialect::Iso, iso, lines)),
            prop::collection::vec(line(), 1..40).prop_map(move |lines| (Dialect::Siemens, iso, lines)),
            prop::collection::vec(conversational_line(), 1..40).prop_map(move |lines| (
                Dialect::Heidenhain,
                conversational,
                lines
            )),
            prop::collection::vec(cutter_location_line(), 1..40).prop_map(move |lines| (
                Dialect::Apt,
                cutter_locations,
                lines
            )),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        /// The short way for repeating blocks makes the same motions as the long way, whatever is between them.
        /// Because of this law, copied blocks need not be read a second time.
        #[test]
        fn a_repeated_motion_is_the_motion_that_the_long_way_makes(
            (dialect, head, lines) in in_dialect(),
        ) {
            let text = format!("{head}\n{}\n", lines.join("\n"));
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
        let text =
            "BEGIN PGM P MM\nL X0 Y0 Z0 A0 C0 F100 R0\nL X+1\nL X2 ~\n Y+1 ; note\n\n; note\n7 L Y3 C4 F50\n";
        let short = motions(Dialect::Heidenhain, text, false);
        assert_eq!(short.iter().map(|motion| motion.repeats).collect::<Vec<_>>(), [false, false, true, true]);
        let text = "UNITS/MM\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0,0,1\nGOTO/2,0,0,$\n0,0.6,0.8\n$$ note\ngoto/3,0,0,0,0,1\n";
        let short = motions(Dialect::Apt, text, false);
        assert_eq!(short.iter().map(|motion| motion.repeats).collect::<Vec<_>>(), [false, false, true, true]);
    }
}
