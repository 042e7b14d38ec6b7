//! The text of a posted program.

use super::approach::{Approach, Coordinates};
use super::parameters::{PostForm, PostParameters};
use super::points::ClPoint;
use crate::contact::rotary_rad;
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{AxisWords, FeedMode};
use crate::program::{print_decimal, round_to_decimals};

/// The note for the operator before G49.
const CLEAR: &str = "(G49 CAN MOVE THE TOOL BY ITS LENGTH. IT MUST BE CLEAR OF THE PART)";
/// Largest relative rounding error of an F word.
const FEED_ROUNDING: f64 = 1e-3;
const MAX_FEED_DECIMALS: u8 = 9;

/// Writes blocks and keeps the modal state.
#[derive(Debug, Clone, Default)]
pub(super) struct Writer {
    rapid: Option<bool>,
    mode: Option<FeedMode>,
    feed: Option<f64>,
    /// H of the G43 that the next Z has.
    length: Option<u32>,
    pub(super) blocks: u64,
}

/// A point as written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WrittenPoint {
    pub(super) words: AxisWords,
    /// F in the block, or the one in force before it.
    pub(super) feed: Option<f64>,
}

impl Writer {
    pub(super) fn line(&mut self, text: &str, out: &mut Vec<u8>) {
        out.extend_from_slice(text.as_bytes());
        out.push(b'\n');
        self.blocks += 1;
    }

    pub(super) fn open(&mut self, out: &mut Vec<u8>) {
        self.line("%", out);
        self.line("G21 G17 G90 G40 G80 G94", out);
        self.line("G54", out);
        self.mode = Some(FeedMode::PerMinute);
    }

    /// Writes the operator's notes on an approach, before its blocks.
    pub(super) fn announce(approach: Approach, machine: &Machine, is_first: bool, out: &mut Vec<u8>) {
        for note in approach.notes(machine, is_first) {
            out.extend_from_slice(note.as_bytes());
            out.push(b'\n');
        }
    }

    /// Switches tool-centre-point control on, with its length.
    pub(super) fn take_length(&mut self, number: u32, out: &mut Vec<u8>) {
        self.line(&format!("G43.4 H{number}"), out);
    }

    /// Switches the length on in the next block that states Z. Alone in a block, G43 moves Z on some controls.
    pub(super) fn take_length_with_z(&mut self, number: u32) {
        self.length = Some(number);
    }

    /// Switches tool-centre-point control off. On some controls the tool moves by its length.
    fn drop_length(&mut self, out: &mut Vec<u8>) {
        out.extend_from_slice(CLEAR.as_bytes());
        out.push(b'\n');
        self.line("G49", out);
    }

    /// Puts another tool in, with tool-centre-point control off and in the feed mode of the start. Returns the text of
    /// the change.
    pub(super) fn change_tool(
        &mut self,
        number: u32,
        form: PostForm,
        has_moved: bool,
        out: &mut Vec<u8>,
    ) -> String {
        if self.mode != Some(FeedMode::PerMinute) {
            self.line("G94", out);
            self.mode = Some(FeedMode::PerMinute);
        }
        if form == PostForm::Tcp && has_moved {
            self.drop_length(out);
        }
        let text = format!("T{number} M6");
        self.line(&text, out);
        // The first block after it says again how it moves, and at what feed.
        (self.rapid, self.feed) = (None, None);
        text
    }

    /// Leaves the control in its initial state. M30 does not reset inverse time and tool-centre-point control
    /// everywhere, and the caller's frame may end the program without it.
    pub(super) fn close(&mut self, parameters: &PostParameters, out: &mut Vec<u8>) {
        if self.mode != Some(FeedMode::PerMinute) {
            self.line("G94", out);
        }
        // A plain length is replaced by the next G43, and G49 would move Z on some controls.
        if parameters.form == PostForm::Tcp {
            self.drop_length(out);
        }
        self.line("M30", out);
        self.line("%", out);
    }

    /// A block with the given words. F is written if it changes, and always in inverse time.
    #[expect(clippy::too_many_arguments, reason = "all that makes one block, used here only")]
    pub(super) fn point(
        &mut self,
        machine: &Machine,
        words: &AxisWords,
        coordinates: Coordinates,
        point: &ClPoint,
        minutes: Option<f64>,
        parameters: &PostParameters,
        out: &mut Vec<u8>,
    ) -> WrittenPoint {
        self.blocks += 1;
        let mut blank = false;
        let mut put = |text: &[u8], out: &mut Vec<u8>| {
            if std::mem::replace(&mut blank, true) {
                out.push(b' ');
            }
            out.extend_from_slice(text);
        };
        let (mode, feed) = match (point.feed, minutes) {
            (Some(_), Some(minutes)) => (Some(FeedMode::InverseTime), Some(1.0 / minutes)),
            (Some((mode, feed)), None) => (Some(mode), Some(feed)),
            (None, _) => (self.mode, None),
        };
        if let Some(mode) = mode.filter(|mode| self.mode != Some(*mode)) {
            put(
                match mode {
                    FeedMode::PerMinute => b"G94",
                    FeedMode::InverseTime => b"G93",
                    FeedMode::PerRevolution => b"G95",
                },
                out,
            );
            (self.mode, self.feed) = (Some(mode), None);
        }
        if self.rapid != Some(point.rapid) {
            put(if point.rapid { b"G0" } else { b"G1" }, out);
            self.rapid = Some(point.rapid);
        }
        let length = if coordinates[2] { self.length.take() } else { None };
        if length.is_some() {
            put(b"G43", out);
        }
        let [first, second] = machine.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
        let [x, y, z] = words.linear_mm;
        let [a, b] = words.rotary_deg;
        let (linear, rotary) = (parameters.linear_decimals, parameters.rotary_decimals);
        let all =
            [('X', x, linear), ('Y', y, linear), ('Z', z, linear), (first, a, rotary), (second, b, rotary)];
        for ((letter, value, decimals), _) in
            all.into_iter().zip(coordinates).filter(|(_, is_stated)| *is_stated)
        {
            let mut text = [0; 4];
            put(letter.encode_utf8(&mut text).as_bytes(), out);
            print_decimal(value, decimals, out);
        }
        if let Some(number) = length {
            put(format!("H{number}").as_bytes(), out);
        }
        let written = feed.map(|feed| {
            let decimals = (1..MAX_FEED_DECIMALS)
                .find(|decimals| (round_to_decimals(feed, *decimals) / feed - 1.0).abs() <= FEED_ROUNDING)
                .unwrap_or(MAX_FEED_DECIMALS);
            (round_to_decimals(feed, decimals), decimals)
        });
        if let Some((value, decimals)) = written {
            let same = self.feed.is_some_and(|before| (before - value).abs() <= 0.0);
            if !same || self.mode == Some(FeedMode::InverseTime) {
                put(b"F", out);
                print_decimal(value, decimals, out);
                self.feed = Some(value);
            }
        }
        out.push(b'\n');
        WrittenPoint { words: *words, feed: written.map(|(value, _)| value) }
    }
}

/// Whether an F word can state this value.
pub(super) fn can_state(feed: f64) -> bool {
    (round_to_decimals(feed, MAX_FEED_DECIMALS) / feed - 1.0).abs() <= FEED_ROUNDING
}

/// The words of a point: rotary words are rounded first, then the linear words are computed from them and rounded.
pub(super) fn words(
    machine: &Machine,
    kinematics: &Kinematics,
    point: &ClPoint,
    rotary_deg: [f64; 2],
    parameters: &PostParameters,
) -> AxisWords {
    let rotary_deg = rotary_deg.map(|word| round_to_decimals(word, parameters.rotary_decimals));
    let linear_mm: [f64; 3] = match parameters.form {
        PostForm::Tcp => point.pose.tip_mm.into(),
        PostForm::Machine => kinematics.linear_mm(point.pose.tip_mm, rotary_rad(machine, rotary_deg)).into(),
    };
    AxisWords {
        linear_mm: linear_mm.map(|word| round_to_decimals(word, parameters.linear_decimals)),
        rotary_deg,
    }
}
