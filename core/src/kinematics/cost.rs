//! The cost of a path so far, and the comparison of paths.

use super::pointing::nearest_integer;

/// Travels closer than this tie \[deg\].
pub(super) const TIE_DEG: f64 = 1e-6;
/// Distance from an equality at which it is certain which side is which \[deg\]: above a tie and the rounding of a
/// few words of up to a million turns.
pub(super) const SLACK_DEG: f64 = 1e-5;
/// Words are compared in steps of 2⁻³⁰° so that sums of travels are exact and symmetric solutions tie.
pub(super) const STEPS_PER_DEG: f64 = 1_073_741_824.0;

/// The cost of a path to a state so far. Infinite rewinds mean that there is no path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost {
    pub(super) rewinds: f64,
    /// Travel \[deg\].
    pub(super) travel: f64,
    /// Σ|word| \[deg\].
    pub(super) sum: f64,
    /// The previous state.
    pub(super) from: u32,
    /// Another path of the same cost, except for Σ|word|, was not kept.
    pub(super) tied: bool,
}

pub(super) const NO_WAY: Cost = Cost { rewinds: f64::INFINITY, travel: 0.0, sum: 0.0, from: 0, tied: false };

impl Cost {
    #[inline]
    pub(super) fn beats(&self, other: &Self) -> bool {
        let travel = self.travel - other.travel;
        self.rewinds < other.rewinds
            || (self.rewinds <= other.rewinds
                && (travel < -TIE_DEG || (travel <= TIE_DEG && self.sum < other.sum)))
    }
    /// Whether both have equally many rewinds and the same travel.
    #[inline]
    pub(super) fn ties(&self, other: &Self) -> bool {
        self.rewinds.is_finite()
            && self.rewinds.total_cmp(&other.rewinds).is_eq()
            && (self.travel - other.travel).abs() <= TIE_DEG
    }
    #[inline]
    pub(super) fn keep_better(&mut self, other: Self) {
        let tied = self.ties(&other);
        if other.beats(self) {
            *self = other;
        }
        self.tied |= tied;
    }
    #[inline]
    pub(super) fn coming_from(self, state: usize) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
        let from = state as u32;
        Self { from, ..self }
    }
    #[inline]
    pub(super) fn plus_travel(self, travel: f64) -> Self {
        Self { travel: self.travel + travel, ..self }
    }
}

/// The word in steps of 2⁻³⁰°.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub(super) fn in_steps(word_deg: f64) -> f64 {
    nearest_integer(word_deg * STEPS_PER_DEG) * (1.0 / STEPS_PER_DEG)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slack_is_above_a_tie_and_all_rounding() {
        // A comparison has the travels of two steps on both sides: eight words. Each is rounded when it is computed,
        // and again to a step.
        let rounding = 8.0 * (360e6 * f64::EPSILON + 0.5 / STEPS_PER_DEG);
        assert!(SLACK_DEG > 4.0 * (TIE_DEG + rounding), "{rounding:e}");
    }
}
