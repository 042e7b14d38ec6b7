//! The words of a block whose ends were moved. A word that is right within half a unit of its last decimal keeps its
//! text.

use super::pending::{Pending, StatedAxes};
use crate::machine::Machine;
use crate::motion::{AxisWords, ContactWords, rotary_addresses};
use crate::process::pipeline::{SAME_WORD, exact_decimals, in_units};
use crate::program::{Address, NewWord, round_to_decimals};

/// U V W.
pub(super) const POINT: [Address; 3] = [Address::U, Address::V, Address::W];

/// How closely a value must be reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// Within half a unit of this decimal.
    Near(u8),
    /// Exactly, with at least this number of decimals.
    Exact(u8),
}

/// The place of the written program, in program units and degrees.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    at: [f64; 5],
    /// U V W, if they are stated \[mm\].
    point_mm: [f64; 3],
    addresses: [Address; 5],
}

impl Pen {
    /// Starts at the start of this motion, where source and written program are at the same place.
    pub(super) fn at_start(machine: &Machine, first: &Pending) -> Self {
        let rotary = rotary_addresses(machine);
        let point_mm = match first.standing {
            ContactWords::Point(point_mm) => point_mm,
            _ => [f64::NAN; 3],
        };
        Self {
            at: in_units(&first.ends[0].words, first.motion.mm_per_unit),
            point_mm,
            addresses: [Address::X, Address::Y, Address::Z, rotary[0], rotary[1]],
        }
    }

    /// The place, in millimetres and degrees.
    pub(super) fn words(&self, mm_per_unit: f64) -> AxisWords {
        let [x, y, z, first, second] = self.at;
        AxisWords { linear_mm: [x, y, z].map(|units| units * mm_per_unit), rotary_deg: [first, second] }
    }

    /// Moves coordinate `k` of the block to `target` [program units, deg]. Adds a word only if the block does not get
    /// there by itself.
    pub(super) fn move_to(
        &mut self,
        block: &Pending,
        k: usize,
        target: f64,
        wanted: Wanted,
        words: &mut Vec<NewWord>,
    ) {
        let unit = block.motion.mm_per_unit;
        let [start, end] = block.ends.map(|station| in_units(&station.words, unit)[k]);
        let standing = match block.axes[k] {
            StatedAxes::Absent => self.at[k],
            StatedAxes::Absolute => end,
            StatedAxes::Incremental => self.at[k] + (end - start),
        };
        let from = if block.motion.incremental { self.at[k] } else { 0.0 };
        let (room, decimals) = match wanted {
            Wanted::Near(decimals) => (0.5 * 0.1_f64.powi(i32::from(decimals)) + SAME_WORD, decimals),
            Wanted::Exact(decimals) => (SAME_WORD, exact_decimals(target - from, decimals)),
        };
        self.at[k] = if (target - standing).abs() <= room {
            standing
        } else {
            let value = round_to_decimals(target - from, decimals);
            words.push(NewWord { address: self.addresses[k], value, decimals });
            from + value
        };
    }

    /// Moves U V W to the point. Returns the contact words as they will be read.
    pub(super) fn point_to(
        &mut self,
        block: &Pending,
        target_mm: [f64; 3],
        wanted: Wanted,
        words: &mut Vec<NewWord>,
    ) -> ContactWords {
        let ContactWords::Point(source_mm) = block.motion.contact else { return block.motion.contact };
        let unit = block.motion.mm_per_unit;
        for k in 0..3 {
            let standing_mm = if block.contact[k] { source_mm[k] } else { self.point_mm[k] };
            let (room, decimals) = match wanted {
                Wanted::Near(decimals) => (0.5 * 0.1_f64.powi(i32::from(decimals)) + SAME_WORD, decimals),
                Wanted::Exact(decimals) => (SAME_WORD, exact_decimals(target_mm[k] / unit, decimals)),
            };
            // An unknown value (NaN) is never near.
            self.point_mm[k] = if ((target_mm[k] - standing_mm) / unit).abs() <= room {
                standing_mm
            } else {
                let value = round_to_decimals(target_mm[k] / unit, decimals);
                words.push(NewWord { address: POINT[k], value, decimals });
                value * unit
            };
        }
        ContactWords::Point(self.point_mm)
    }
}
