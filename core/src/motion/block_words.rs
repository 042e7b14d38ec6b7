//! The words of one block, by address.

use super::dialect::MotionRules;
use super::meaning::MFunction;
use crate::program::{Address, Code, Keyword, Word, WordForm};

/// The words of the present block, by address.
#[derive(Debug, Clone)]
pub(super) struct BlockWords {
    pub(super) values: [f64; 32],
    pub(super) decimals: [u8; 32],
    /// Addresses in the block, bit by index. Those of `,R` and similar words are kept apart.
    pub(super) present: u32,
    /// The present addresses whose value is not a plain number.
    pub(super) unknown: u32,
    pub(super) comma: u32,
    /// The present addresses that state by themselves from where they count.
    pub(super) absolute: u32,
    pub(super) incremental: u32,
    /// The present addresses that are written with a decimal point.
    pub(super) points: u32,
    /// The present addresses that are not plain numbers.
    pub(super) odd: u32,
    /// G codes and statement words, and M codes.
    pub(super) g_codes: [Code; 16],
    pub(super) g_count: usize,
    pub(super) m_codes: [Code; 16],
    pub(super) m_count: usize,
    /// A G or M word without a plain code, or too many of them.
    pub(super) odd_code: bool,
}

impl BlockWords {
    pub(super) const EMPTY: Self = Self {
        values: [0.0; 32],
        decimals: [0; 32],
        present: 0,
        unknown: 0,
        comma: 0,
        absolute: 0,
        incremental: 0,
        points: 0,
        odd: 0,
        g_codes: [Code::G(0); 16],
        g_count: 0,
        m_codes: [Code::M(0); 16],
        m_count: 0,
        odd_code: false,
    };

    #[inline]
    pub(super) fn gather(&mut self, words: &[Word]) {
        (self.g_count, self.m_count, self.odd_code) = (0, 0, false);
        // The sums of bits stay in registers.
        let (mut present, mut unknown, mut comma, mut points) = (0, 0, 0, 0);
        let (mut absolute, mut incremental, mut odd) = (0, 0, 0);
        for word in words {
            let index = word.address.index() & 31;
            match word.address {
                Address::G => Self::add_code(word, &mut self.g_codes, &mut self.g_count, &mut self.odd_code),
                Address::M => Self::add_code(word, &mut self.m_codes, &mut self.m_count, &mut self.odd_code),
                _ if word.form == WordForm::Comma => comma |= 1 << index,
                _ => {
                    let bit = 1 << index;
                    present |= bit;
                    self.values[index] = word.value;
                    self.decimals[index] = word.decimals;
                    points |= u32::from(word.has_point) << index;
                    if word.form != WordForm::Number {
                        odd |= bit;
                        unknown |= u32::from(!word.is_known()) << index;
                        absolute |= u32::from(word.form == WordForm::Absolute) << index;
                        incremental |= u32::from(word.form == WordForm::Incremental) << index;
                    }
                }
            }
        }
        (self.present, self.unknown, self.comma, self.points) = (present, unknown, comma, points);
        (self.absolute, self.incremental, self.odd) = (absolute, incremental, odd);
    }

    #[inline]
    fn add_code(word: &Word, codes: &mut [Code; 16], count: &mut usize, odd: &mut bool) {
        match (word.code(), codes.get_mut(*count)) {
            (Some(code), Some(slot)) => {
                *slot = code;
                *count += 1;
            }
            _ => *odd = true,
        }
    }

    #[inline]
    pub(super) fn has(&self, address: Address) -> bool {
        self.present & (1 << address.index()) != 0
    }

    /// The value of a word, if the block has it with a plain number.
    #[inline]
    pub(super) fn value(&self, address: Address) -> Option<f64> {
        let bit = address.bit();
        (self.present & bit != 0 && self.unknown & bit == 0).then(|| self.values[address.index()])
    }

    pub(super) fn g_codes(&self) -> &[Code] {
        self.g_codes.get(..self.g_count).unwrap_or_default()
    }

    /// Whether the block has an M code of this meaning.
    pub(super) fn has_m(&self, rules: &MotionRules, wanted: MFunction) -> bool {
        self.m_codes().iter().any(|&code| rules.m_function(code) == wanted)
    }

    /// The M codes of the block.
    pub(super) fn m_codes(&self) -> &[Code] {
        self.m_codes.get(..self.m_count).unwrap_or_default()
    }

    /// Whether a word counts from the position before (G91) or from zero; `None` if the modal sense is not known.
    #[inline]
    pub(super) fn is_incremental(&self, address: Address, modal: Option<bool>) -> Option<bool> {
        let bit = address.bit();
        if self.incremental & bit != 0 {
            Some(true)
        } else if self.absolute & bit != 0 {
            Some(false)
        } else {
            modal
        }
    }

    /// The statement word of a block that has no other, and no M codes.
    #[inline]
    pub(super) fn only_statement(&self) -> Option<Keyword> {
        if self.m_count > 0 || self.g_count != 1 || self.odd_code {
            return None;
        }
        self.g_codes.first().and_then(|code| code.keyword())
    }

    /// Whether the block has only G0 and G1 and no M codes. Such a block can only move.
    #[inline]
    pub(super) fn is_simple(&self) -> bool {
        self.m_count == 0
            && self.g_count <= 1
            && !self.odd_code
            && self.g_codes().iter().all(|code| matches!(code, Code::G(0 | 10)))
    }
}

/// G4.
pub(super) const DWELL: Code = Code::G(40);
/// Bits of X Y Z A B C.
pub(super) const AXES: u32 = Address::AXES;
