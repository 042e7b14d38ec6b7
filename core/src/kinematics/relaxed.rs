//! Axes of several turns, chosen as if they were unlimited: two states per pose instead of one for every turn.

use super::aligned::Aligned;
use super::choice::Way;
use super::cost::TIE_DEG;
use super::decided::{Along, Course};
use super::grid::Grid;
use super::joining::has_step_over;
use super::lanes::{BLOCK, Lane};
use super::path::RELAX_ABOVE;
use super::pose_source::PoseSource;
use super::walk::{Stop, Walk};
use super::{COMPUTED_WORD_SLACK, InverseError};
use crate::machine::Travel;

/// A path chosen as if axes of several turns were unlimited. Its words are not kept: to compute them again is faster
/// than to fetch them from memory.
pub(super) struct Relaxed {
    grid: Grid,
    way: Way,
    /// Whole turns that bring the words of u, v into their travels \[deg\]; `None` on an axis that was not relaxed.
    shift_deg: [Option<f64>; 2],
    /// The number of warnings along it.
    warnings: usize,
}

/// What the words of one axis have in common.
#[derive(Clone, Copy)]
struct Extent {
    /// The smallest and the largest word \[deg\].
    range_deg: [f64; 2],
    /// Whether no step is so near to half a turn that it could also go the other way round.
    one_way: bool,
    latest_deg: Option<f64>,
    /// Whether a word is −0: its sign depends on the sign of a shift of 0.
    has_negative_zero: bool,
}

impl Extent {
    fn take(&mut self, words_deg: &[f64], steps_are_short: bool) {
        let [low, high] = extremes(words_deg);
        self.range_deg = [self.range_deg[0].min(low), self.range_deg[1].max(high)];
        if let (false, Some(first)) = (steps_are_short, words_deg.first()) {
            let entered = self.latest_deg.unwrap_or(*first);
            self.one_way &= !has_step_over((180.0 - TIE_DEG).next_down(), entered, words_deg);
        }
        let negative_zeros = words_deg.iter().map(|word| u64::from(word.to_bits() == (-0.0_f64).to_bits()));
        self.has_negative_zero |= negative_zeros.fold(0, |any, zero| any | zero) != 0;
        self.latest_deg = words_deg.last().copied();
    }
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// With several turns: the path as if those axes were unlimited. No path within travels is cheaper, and one of
    /// the same cost differs by whole turns only. So if it fits after a shift by these, it is the answer. `None` if
    /// it does not fit, or if paths tied that cannot be distinguished afterwards.
    pub(super) fn relaxed(&mut self, grid: Grid) -> Result<Option<Course>, InverseError> {
        let travel = self.kinematics.travel_deg;
        let is_relaxed: [bool; 2] = std::array::from_fn(|k| travel[k].is_some() && grid.count[k] > 1);
        if is_relaxed == [false; 2] {
            return Ok(None);
        }
        let narrow = Grid::new(std::array::from_fn(|k| travel[k].filter(|_| !is_relaxed[k])));
        let Ok(choice) = self.costs::<true>(narrow) else {
            self.go_on()?;
            return Ok(None);
        };
        let Some(best) = choice.best() else { return Ok(None) };
        let mut fitting: Vec<Relaxed> = Vec::new();
        for state in (0..narrow.states()).filter(|state| *state == best || choice.ties(best, *state)) {
            let (way, warnings) = (choice.way(state), choice.warnings(state));
            let mut path = Relaxed { grid: narrow, way, shift_deg: [None; 2], warnings };
            let extents = self.extents(&path);
            let one_way = (0..2).all(|k| narrow.period[k] == 0.0 || extents[k].one_way);
            if !(choice.is_only(state) && one_way) && grid.states() <= RELAX_ABOVE {
                return Ok(None);
            }
            let mut fits = true;
            for k in 0..2 {
                let (true, Some(travel)) = (is_relaxed[k], travel[k]) else { continue };
                path.shift_deg[k] = self.best_shift(&path, k, &extents[k], travel);
                fits &= path.shift_deg[k].is_some();
            }
            if fits {
                fitting.push(path);
            }
        }
        let chosen = if fitting.len() < 2 {
            fitting.pop()
        } else {
            let sums: Vec<f64> = fitting.iter().map(|path| self.sum_deg(path)).collect();
            let least = sums.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(n, _)| n);
            Some(fitting.swap_remove(least))
        };
        Ok(chosen.map(|path| Course { warnings: path.warnings, along: Along::Relaxed(path) }))
    }

    /// Writes the words of u, v \[deg\] of a block along a relaxed path. `previous` are the words before the block,
    /// without the shift. True if it is known that all steps are clearly below [`super::REWIND_DEG`].
    pub(super) fn follow_relaxed(
        &self,
        path: &Relaxed,
        begin: usize,
        previous: &mut Option<[f64; 2]>,
        words_deg: [&mut [f64]; 2],
    ) -> bool {
        let [us, vs] = words_deg;
        let block = begin..begin + us.len();
        let is_small = self.follow(&path.grid, &path.way, block, previous, [&mut *us, &mut *vs]);
        for (words, shift) in [us, vs].into_iter().zip(path.shift_deg) {
            if let Some(shift) = shift {
                for word in words {
                    *word += shift;
                }
            }
        }
        is_small
    }

    /// Shows the words of u, v \[deg\] along a relaxed path, block by block, and whether all steps are known to be
    /// short.
    fn look_along(&self, path: &Relaxed, mut look: impl FnMut([&[f64]; 2], bool)) {
        let mut words: Aligned<[Lane; 2]> = Aligned([[0.0; BLOCK]; 2]);
        let mut previous = self.start;
        for begin in (0..path.way.len()).step_by(BLOCK) {
            let size = (path.way.len() - begin).min(BLOCK);
            let [us, vs] = words.each_mut().map(|words| &mut words[..size]);
            let is_small = self.follow_relaxed(path, begin, &mut previous, [&mut *us, &mut *vs]);
            look([us, vs], is_small);
        }
    }

    fn extents(&self, path: &Relaxed) -> [Extent; 2] {
        let mut extents: [Extent; 2] = std::array::from_fn(|k| Extent {
            range_deg: [f64::INFINITY, f64::NEG_INFINITY],
            one_way: true,
            latest_deg: self.start.map(|start| start[k]),
            has_negative_zero: false,
        });
        self.look_along(path, |words, is_small| {
            for k in 0..2 {
                if path.grid.period[k] > 0.0 {
                    extents[k].take(words[k], is_small);
                }
            }
        });
        extents
    }

    /// Σ|word| of u, then of v \[deg\].
    fn sum_deg(&self, path: &Relaxed) -> f64 {
        let mut sum = 0.0;
        for k in 0..2 {
            self.look_along(path, |words, _| words[k].iter().for_each(|word| sum += word.abs()));
        }
        sum
    }

    /// The shift by whole turns \[deg\] that brings all words of axis k into the travel with the smallest Σ|word|. With
    /// a given start, only no shift.
    fn best_shift(&self, path: &Relaxed, k: usize, extent: &Extent, travel: Travel) -> Option<f64> {
        let [low, high] = extent.range_deg;
        let slack = COMPUTED_WORD_SLACK;
        let first = ((travel.min - slack - low) / 360.0).ceil();
        let last = ((travel.max + slack - high) / 360.0).floor();
        if first > last || (self.start.is_some() && !(first..=last).contains(&0.0)) {
            return None;
        }
        if self.start.is_some() {
            return Some(0.0);
        }
        // One or two shifts fit, and the best of all is not beyond them: there is no need to look for it.
        let few = last - first < 1.5 && turns_to_zero(low) <= last && turns_to_zero(high) >= first;
        let turns = if few && !extent.has_negative_zero {
            [first, last, last]
        } else {
            // Σ|word + 360 k| is least where the median word is nearest to zero.
            let middle = self.turns_to_middle(path, k, [low, high]);
            [middle - 1.0, middle, middle + 1.0].map(|turns| turns.clamp(first, last))
        };
        if turns.iter().all(|turn| turn.total_cmp(&turns[0]).is_eq()) {
            return Some(360.0 * turns[0]);
        }
        let mut sums = [0.0; 3];
        self.look_along(path, |words, _| {
            for word in words[k] {
                for (sum, turns) in sums.iter_mut().zip(turns) {
                    *sum += (word + 360.0 * turns).abs();
                }
            }
        });
        turns.into_iter().zip(sums).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(turns, _)| 360.0 * turns)
    }

    /// The whole turns that bring the median word of axis k next to zero, with the sign of the zero that the rounded
    /// median has.
    fn turns_to_middle(&self, path: &Relaxed, k: usize, [low, high]: [f64; 2]) -> f64 {
        let half = path.way.len() / 2;
        let median = largest(turns_to_zero(high), turns_to_zero(low), |turns| {
            self.count(path, k, |word| needs_turns(word, turns)) > half
        });
        if median.abs() > 0.5 {
            return median;
        }
        if half < self.count(path, k, f64::is_sign_negative) { 0.0 } else { -0.0 }
    }

    /// How many words of axis k have a property.
    fn count(&self, path: &Relaxed, k: usize, has: impl Fn(f64) -> bool) -> usize {
        let mut count = 0;
        self.look_along(path, |words, _| {
            count += words[k].iter().map(|word| usize::from(has(*word))).sum::<usize>();
        });
        count
    }
}

/// The whole turns that bring a word next to zero.
fn turns_to_zero(word_deg: f64) -> f64 {
    (-word_deg / 360.0).round()
}

/// The largest whole number from `low` to `high` that fulfils a condition. `low` fulfils it, and so does every number
/// below one that does. The interval is halved each time: a path may wind over thousands of turns, and each look at the
/// condition goes along the whole path.
fn largest(mut low: f64, mut high: f64, mut fulfils: impl FnMut(f64) -> bool) -> f64 {
    while low < high {
        let middle = low + (0.5 * (high - low)).ceil();
        if fulfils(middle) {
            low = middle;
        } else {
            high = middle - 1.0;
        }
    }
    low
}

/// Whether [`turns_to_zero`] of the word is `turns` or more. It needs no rounding, which would be a call for each word.
fn needs_turns(word_deg: f64, turns: f64) -> bool {
    let (exact, least) = (-word_deg / 360.0, turns - 0.5);
    if turns > 0.0 { exact >= least } else { exact > least }
}

/// The smallest and the largest word.
fn extremes(words_deg: &[f64]) -> [f64; 2] {
    const SIDE_BY_SIDE: usize = 16;
    let (mut low, mut high) = ([f64::INFINITY; SIDE_BY_SIDE], [f64::NEG_INFINITY; SIDE_BY_SIDE]);
    for words in words_deg.chunks(SIDE_BY_SIDE) {
        for ((low, high), word) in low.iter_mut().zip(&mut high).zip(words) {
            *low = if *word < *low { *word } else { *low };
            *high = if *word > *high { *word } else { *high };
        }
    }
    [low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_number_is_found_in_few_looks() {
        for high in -5..40 {
            for end in -5..=high {
                let (low, high, end) = (-5.0, f64::from(high), f64::from(end));
                let mut looks = 0;
                let found = largest(low, high, |number| {
                    looks += 1;
                    number <= end
                });
                assert!((found - end).abs() < 0.5, "{found} of {end}");
                assert!(f64::from(looks) <= (high - low + 1.0).log2().ceil(), "{looks} looks up to {high}");
            }
        }
    }

    #[test]
    fn a_comparison_needs_no_rounding() {
        for turns in -3..=3 {
            let turns = f64::from(turns);
            for halves in -8..=8 {
                let edge = 180.0 * f64::from(halves);
                for word in [edge.next_down(), edge, edge.next_up(), edge + 17.0] {
                    assert_eq!(needs_turns(word, turns), turns_to_zero(word) >= turns, "{word} {turns}");
                }
            }
        }
    }
}
