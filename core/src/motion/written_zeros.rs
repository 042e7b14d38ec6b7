//! What an RS274/NGC program has written of its zeros, and the places of words in them.

use std::collections::BTreeMap;

use super::WorkOffset;
use crate::geometry::Turn;

/// The zero of one work offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Zero {
    /// In M \[mm\].
    pub(super) origin_mm: [f64; 3],
    /// About Z \[deg\].
    pub(super) turn_deg: f64,
}

/// What a program has written so far.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct WrittenZeros {
    /// `None` is not known.
    pub(super) systems: BTreeMap<WorkOffset, Option<Zero>>,
    /// The shift of G92, along the axes of the offset in force \[mm\].
    pub(super) shift_mm: [f64; 3],
    /// The reference position of G28 that the program has stored, in machine coordinates: X Y Z \[mm\], then the
    /// rotary axes in the profile's order \[deg\]. `Some(None)` is not known.
    #[expect(clippy::option_option, reason = "nothing stored, and a place that is not known")]
    pub(super) home: Option<Option<[f64; 5]>>,
    /// A height of a zero was written. Without a tool length in force, words Z place the gauge point.
    pub(super) has_height: bool,
    /// None of it holds any more.
    pub(super) is_lost: bool,
}

impl WrittenZeros {
    /// Whether words may have other places than those that the request states, and the zeros are known.
    pub(super) fn has_written(&self) -> bool {
        !self.is_lost
            && (!self.systems.is_empty() || self.shift_mm.iter().any(|shift_mm| shift_mm.abs() > 0.0))
    }
}

impl Zero {
    /// The turn, if there is one.
    pub(super) fn turn(self) -> Option<Turn> {
        (self.turn_deg.abs() > 0.0).then(|| Turn::NONE.then_about(2, self.turn_deg))
    }

    /// Where words are in M.
    pub(super) fn place(self, shift_mm: [f64; 3], words_mm: [Option<f64>; 3]) -> [Option<f64>; 3] {
        let [x, y, z] = std::array::from_fn(|k| words_mm[k].map(|word_mm| word_mm + shift_mm[k]));
        let [x, y] = in_xy(self.turn(), Turn::of, [x, y]);
        let moved = [x, y, z];
        std::array::from_fn(|k| moved[k].map(|at_mm| at_mm + self.origin_mm[k]))
    }

    /// The words of a place in M.
    pub(super) fn words(self, shift_mm: [f64; 3], place_mm: [Option<f64>; 3]) -> [Option<f64>; 3] {
        let [x, y, z] = std::array::from_fn(|k| place_mm[k].map(|at_mm| at_mm - self.origin_mm[k]));
        let [x, y] = in_xy(self.turn(), Turn::back, [x, y]);
        let moved = [x, y, z];
        std::array::from_fn(|k| moved[k].map(|at_mm| at_mm - shift_mm[k]))
    }
}

/// Takes X and Y through a turn about Z. Both have to be known if there is one.
fn in_xy(
    turn: Option<Turn>,
    through: fn(Turn, [f64; 3]) -> [f64; 3],
    at: [Option<f64>; 2],
) -> [Option<f64>; 2] {
    let Some(turn) = turn else { return at };
    let [Some(x), Some(y)] = at else { return [None; 2] };
    let [x, y, _] = through(turn, [x, y, 0.0]);
    [Some(x), Some(y)]
}
