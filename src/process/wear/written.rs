//! Where the axes of the written program stand against those of the source, and the words that take them elsewhere.

use crate::motion::Motion;
use crate::program::{Address, Batch, NewWord, Word, WordForm, round_to_decimals};

/// Places closer than this are the same [program units].
const SAME_WORD: f64 = 1e-9;

/// Three coordinates that are written together: X Y Z, or U V W.
#[derive(Debug, Clone, Copy)]
pub(super) struct Written {
    addresses: [Address; 3],
    /// Written minus source, of the values that stand \[mm\].
    offset_mm: [f64; 3],
    /// The values written last, to the bit \[mm\].
    last_mm: [Option<f64>; 3],
}

/// A block's words and where they lead.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    /// Words that change or come in.
    pub(super) words: [Option<NewWord>; 3],
    /// Where the coordinates stand behind the block \[mm\].
    pub(super) end_mm: [f64; 3],
}

/// The values of three addresses that a block states.
pub(super) type Stated = [Option<f64>; 3];

impl Written {
    pub(super) fn new(addresses: [Address; 3]) -> Self {
        Self { addresses, offset_mm: [0.0; 3], last_mm: [None; 3] }
    }

    /// Whether a value stands elsewhere than in the source.
    pub(super) fn is_off(&self) -> bool {
        self.offset_mm.iter().any(|offset_mm| offset_mm.abs() > SAME_WORD)
    }

    /// The values the block of this motion states.
    pub(super) fn stated(&self, batch: &Batch, motion: &Motion) -> Stated {
        let block = batch.blocks().get(motion.block as usize);
        self.stated_in(block.map_or(&[][..], |block| batch.words(block)))
    }

    /// The values among these words.
    pub(super) fn stated_in(&self, words: &[Word]) -> Stated {
        let mut stated = [None; 3];
        for word in words.iter().filter(|word| word.is_known() && word.form != WordForm::Incremental) {
            for (address, value) in self.addresses.iter().zip(&mut stated) {
                if word.address == *address {
                    *value = Some(word.value);
                }
            }
        }
        stated
    }

    /// A block that is left alone, from and to where is not known: its absolute words stand in both programs.
    pub(super) fn leave(&mut self, stated: &Stated, incremental: bool) {
        let values = self.offset_mm.iter_mut().zip(&mut self.last_mm);
        for ((offset_mm, last_mm), _) in values.zip(stated).filter(|(_, stated)| stated.is_some()) {
            *offset_mm = if incremental { *offset_mm } else { 0.0 };
            *last_mm = None;
        }
    }

    /// Axes that go to a place of the machine, all of them where none is named: both programs stand there.
    pub(super) fn meet(&mut self, named: &Stated) {
        let all = named.iter().all(Option::is_none);
        self.leave(&named.map(|value| if all { Some(0.0) } else { value }), false);
    }

    /// The place where these coordinates stand, if the source's are here \[mm\].
    pub(super) fn standing_mm(&self, source_mm: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| source_mm[k] + self.offset_mm[k])
    }

    /// The words that bring the coordinates from where they stand to `target_mm`, with so many decimals. A word that
    /// stands within half a unit of the last decimal of what is wanted is left as it is, and so is an absent one.
    pub(super) fn plan(
        &mut self,
        motion: &Motion,
        stated: &Stated,
        source_mm: [&[f64; 3]; 2],
        target_mm: &[f64; 3],
        decimals: u8,
    ) -> Plan {
        let unit = motion.mm_per_unit;
        let half = 0.5 * 0.1_f64.powi(i32::from(decimals)) + SAME_WORD;
        let mut plan = Plan { words: [None; 3], end_mm: *target_mm };
        for k in 0..3 {
            let [start_mm, end_mm] = [source_mm[0][k], source_mm[1][k]];
            // What the block's word counts from, and what it is without one.
            let from_mm = if motion.incremental { start_mm + self.offset_mm[k] } else { 0.0 };
            let standing = stated[k].unwrap_or_else(|| {
                if motion.incremental { 0.0 } else { (end_mm + self.offset_mm[k]) / unit }
            });
            let wanted = (target_mm[k] - from_mm) / unit;
            if (wanted - standing).abs() <= half {
                plan.end_mm[k] = match stated[k] {
                    Some(_) if !motion.incremental => end_mm,
                    Some(value) => from_mm + value * unit,
                    None if motion.incremental => from_mm,
                    None => {
                        let standing_mm = end_mm + self.offset_mm[k];
                        self.last_mm[k]
                            .filter(|last_mm| (last_mm - standing_mm).abs() <= SAME_WORD)
                            .unwrap_or(standing_mm)
                    }
                };
            } else {
                let value = round_to_decimals(wanted, decimals);
                plan.words[k] = Some(NewWord { address: self.addresses[k], value, decimals });
                plan.end_mm[k] = from_mm + value * unit;
            }
            self.last_mm[k] = Some(plan.end_mm[k]);
            let offset_mm = plan.end_mm[k] - end_mm;
            self.offset_mm[k] = if offset_mm.abs() <= SAME_WORD { 0.0 } else { offset_mm };
        }
        plan
    }
}
