//! Tracks where the axes of the written program are relative to the source, and plans the words that move them.

use crate::motion::{AxisWords, Motion};
use crate::process::pipeline::SAME_WORD;
use crate::program::{Address, Batch, NewWord, Word, WordForm, round_to_decimals};

/// Coordinates that are written together: X Y Z, U V W, or the two rotary axes. Lengths are mm, angles degrees.
#[derive(Debug, Clone, Copy)]
pub(super) struct Written<const N: usize> {
    addresses: [Address; N],
    /// Written value minus source value, at the current place [mm or deg].
    offset: [f64; N],
    /// The values written last, to the bit [mm or deg].
    last: [Option<f64>; N],
}

/// A block's new words and the place to which the block leads.
#[derive(Debug, Clone, Copy)]
pub(super) struct WordPlan<const N: usize> {
    /// Changed or inserted words.
    pub(super) words: [Option<NewWord>; N],
    /// The coordinates after the block [mm or deg].
    pub(super) end: [f64; N],
}

/// How words are written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Resolution {
    /// Digits after the decimal point.
    pub(super) decimals: u8,
    /// Millimetres, or degrees, per program unit.
    pub(super) unit: f64,
}

impl Resolution {
    /// Half a unit of the last decimal [mm or deg].
    pub(super) fn half(self) -> f64 {
        0.5 * 0.1_f64.powi(i32::from(self.decimals)) * self.unit + SAME_WORD
    }
}

/// A word that a block states.
#[derive(Debug, Clone, Copy)]
pub(super) struct StatedWord {
    value: f64,
    /// Whether the word is absolute even in an incremental block.
    is_absolute: bool,
}

/// The words of these addresses that a block states. Words that are incremental by their own form are left out,
/// because they carry an existing offset along.
pub(super) type Stated<const N: usize> = [Option<StatedWord>; N];

impl<const N: usize> Written<N> {
    pub(super) fn new(addresses: [Address; N]) -> Self {
        Self { addresses, offset: [0.0; N], last: [None; N] }
    }

    /// Whether a value differs from the source's.
    pub(super) fn is_off(&self) -> bool {
        self.offset.iter().any(|offset| offset.abs() > SAME_WORD)
    }

    /// The values that the block of this motion states.
    pub(super) fn stated(&self, batch: &Batch, motion: &Motion) -> Stated<N> {
        let block = batch.blocks().get(motion.block as usize);
        self.stated_in(block.map_or(&[][..], |block| batch.words(block)))
    }

    /// The values among these words.
    pub(super) fn stated_in(&self, words: &[Word]) -> Stated<N> {
        let mut stated = [None; N];
        for word in words.iter().filter(|word| word.is_known() && word.form != WordForm::Incremental) {
            for (address, value) in self.addresses.iter().zip(&mut stated) {
                if word.address == *address {
                    let is_absolute = word.form == WordForm::Absolute;
                    *value = Some(StatedWord { value: word.value, is_absolute });
                }
            }
        }
        stated
    }

    /// The axes that these words move to a stated place, whether the number is known or not.
    fn placed_in(&self, words: &[Word]) -> Stated<N> {
        let mut placed = [None; N];
        for word in words.iter().filter(|word| word.form != WordForm::Incremental) {
            for (address, place) in self.addresses.iter().zip(&mut placed) {
                if word.address == *address {
                    *place = Some(StatedWord { value: 0.0, is_absolute: word.form == WordForm::Absolute });
                }
            }
        }
        placed
    }

    /// The coordinate of this index is at the same place in both programs, wherever that is.
    pub(super) fn meet(&mut self, index: usize) {
        if let (Some(offset), Some(last)) = (self.offset.get_mut(index), self.last.get_mut(index)) {
            (*offset, *last) = (0.0, None);
        }
    }

    /// Takes a block that is left unchanged and whose start and end are not known. Its absolute words then hold in
    /// both programs.
    pub(super) fn leave(&mut self, stated: &Stated<N>, incremental: bool) {
        let values = self.offset.iter_mut().zip(&mut self.last);
        for ((offset, last), stated) in values.zip(stated) {
            let Some(stated) = stated else { continue };
            *offset = if incremental && !stated.is_absolute { *offset } else { 0.0 };
            *last = None;
        }
    }

    /// The place of these coordinates in the written program if the source's are at `source` [mm or deg].
    pub(super) fn standing(&self, source: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|k| source[k] + self.offset[k])
    }

    /// Plans the words that bring the coordinates from their current place to `target`. A word within half a unit of
    /// the last decimal of the wanted value is left unchanged; a missing word stays missing in the same way. `source`
    /// holds the start and the end of the source's motion.
    pub(super) fn plan(
        &mut self,
        incremental: bool,
        stated: &Stated<N>,
        source: [&[f64; N]; 2],
        target: &[f64; N],
        resolution: Resolution,
    ) -> WordPlan<N> {
        let Resolution { decimals, unit } = resolution;
        let half = 0.5 * 0.1_f64.powi(i32::from(decimals)) + SAME_WORD;
        let mut plan = WordPlan { words: [None; N], end: *target };
        for k in 0..N {
            let [start, end] = [source[0][k], source[1][k]];
            // The place from which a new word counts, and the place from which the block's own word counts.
            let from = if incremental { start + self.offset[k] } else { 0.0 };
            let counts = incremental && !stated[k].is_some_and(|stated| stated.is_absolute);
            let own_from = if counts { from } else { 0.0 };
            // The value without a new word. A coordinate without a stated word stays where it is, or a tool vector or a
            // word that is incremental by its own form carries it along.
            let standing = stated[k].map_or_else(
                || if incremental { (end - start) / unit } else { (end + self.offset[k]) / unit },
                |stated| stated.value,
            );
            let wanted = (target[k] - from) / unit;
            if ((target[k] - own_from) / unit - standing).abs() <= half {
                plan.end[k] = match stated[k] {
                    Some(_) if !counts => end,
                    Some(stated) => from + stated.value * unit,
                    None if incremental => end + self.offset[k],
                    None => {
                        let standing = end + self.offset[k];
                        self.last[k].filter(|last| (last - standing).abs() <= SAME_WORD).unwrap_or(standing)
                    }
                };
            } else {
                let value = round_to_decimals(wanted, decimals);
                plan.words[k] = Some(NewWord { address: self.addresses[k], value, decimals });
                plan.end[k] = from + value * unit;
            }
            self.last[k] = Some(plan.end[k]);
            let offset = plan.end[k] - end;
            self.offset[k] = if offset.abs() <= SAME_WORD { 0.0 } else { offset };
        }
        plan
    }
}

/// The five axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    pub(super) linear: Written<3>,
    pub(super) rotary: Written<2>,
}

/// The words of the five axes that a block states.
#[derive(Debug, Clone, Copy)]
pub(super) struct StatedAxes {
    pub(super) linear: Stated<3>,
    pub(super) rotary: Stated<2>,
}

impl Axes {
    pub(super) fn new(rotary: [Address; 2]) -> Self {
        Self { linear: Written::new([Address::X, Address::Y, Address::Z]), rotary: Written::new(rotary) }
    }

    /// Whether any axis is at another place than in the source.
    pub(super) fn is_off(&self) -> bool {
        self.linear.is_off() || self.rotary.is_off()
    }

    /// The words of the five axes among these words.
    pub(super) fn stated_in(&self, words: &[Word]) -> StatedAxes {
        StatedAxes { linear: self.linear.stated_in(words), rotary: self.rotary.stated_in(words) }
    }

    pub(super) fn stated(&self, batch: &Batch, motion: &Motion) -> StatedAxes {
        StatedAxes { linear: self.linear.stated(batch, motion), rotary: self.rotary.stated(batch, motion) }
    }

    /// The place of the written program when the source is at `words` of this motion. In a tilted plane, the
    /// difference of X Y Z counts in the plane.
    pub(super) fn standing(&self, motion: &Motion, words: &AxisWords) -> AxisWords {
        let stated = motion.stated(*words);
        motion.placed(AxisWords {
            linear_mm: self.linear.standing(&stated.linear_mm),
            rotary_deg: self.rotary.standing(&stated.rotary_deg),
        })
    }

    /// Takes a block that is left unchanged.
    pub(super) fn leave(&mut self, stated: &StatedAxes, incremental: bool) {
        self.linear.leave(&stated.linear, incremental);
        self.rotary.leave(&stated.rotary, incremental);
    }

    /// Takes a block in machine coordinates. Axes that it moves to a stated place are at the same place in both
    /// programs. Axes that it does not name, or moves by a distance, keep their difference.
    pub(super) fn meet_in_machine(&mut self, batch: &Batch, motion: &Motion) {
        let block = batch.blocks().get(motion.block as usize);
        let words = block.map_or(&[][..], |block| batch.words(block));
        self.linear.leave(&self.linear.placed_in(words), motion.incremental);
        self.rotary.leave(&self.rotary.placed_in(words), motion.incremental);
    }

    /// Takes axes that go to a reference position, or all axes if none is named. Both programs are then at the same
    /// place.
    pub(super) fn meet(&mut self, named: &StatedAxes) {
        let all = named.linear.iter().chain(&named.rotary).all(Option::is_none);
        let everywhere = StatedWord { value: 0.0, is_absolute: true };
        let meets = |stated: Option<StatedWord>| if all { Some(everywhere) } else { stated };
        self.linear.leave(&named.linear.map(meets), false);
        self.rotary.leave(&named.rotary.map(meets), false);
    }
}
