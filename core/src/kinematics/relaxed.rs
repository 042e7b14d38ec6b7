//! Axes of several turns, chosen as if they were unlimited: two states per pose instead of one for every turn.

use super::cost::TIE_DEG;
use super::grid::Grid;
use super::joining::has_step_over;
use super::lanes::{BLOCK, PoseSource};
use super::path::RELAX_ABOVE;
use super::walk::Walk;
use super::{COMPUTED_WORD_SLACK, InverseError};
use crate::machine::Travel;

impl<P: PoseSource + ?Sized> Walk<'_, P> {
    /// With several turns: the path as if those axes were unlimited. No path within travels is cheaper, and one of
    /// the same cost differs by whole turns only. So if it fits after a shift by these, it is the answer. `None` if
    /// it does not fit, or if paths tied that cannot be distinguished afterwards.
    pub(super) fn relaxed_words(&mut self, grid: Grid) -> Result<Option<[Vec<f64>; 2]>, InverseError> {
        let travel = self.kinematics.travel_deg;
        let one_turn = |k: usize| grid.count[k] == 1;
        let relaxed: [Option<Travel>; 2] =
            std::array::from_fn(|k| if one_turn(k) { travel[k] } else { None });
        if relaxed == travel {
            return Ok(None);
        }
        let narrow = Grid::new(relaxed);
        let Ok(choice) = self.costs::<true>(narrow) else {
            self.go_on()?;
            return Ok(None);
        };
        let Some(best) = choice.best() else { return Ok(None) };
        let mut fitting: Vec<[Vec<f64>; 2]> = Vec::new();
        for state in (0..narrow.states()).filter(|state| *state == best || choice.ties(best, *state)) {
            let way = choice.way(state);
            let mut begin = 0;
            let mut words = [vec![0.0; way.len()], vec![0.0; way.len()]];
            let [us, vs] = &mut words;
            let mut previous = self.start;
            for ((way, us), vs) in way.chunks(BLOCK).zip(us.chunks_mut(BLOCK)).zip(vs.chunks_mut(BLOCK)) {
                self.follow(&narrow, way, begin, &mut previous, [us, vs]);
                begin += way.len();
            }
            let only = choice.is_only(state)
                && (0..2).all(|k| relaxed[k].is_some() || turns_one_way(&words[k], self.start.map(|s| s[k])));
            if !only && grid.states() <= RELAX_ABOVE {
                return Ok(None);
            }
            let mut fits = true;
            for k in 0..2 {
                let (Some(travel), None) = (travel[k], relaxed[k]) else { continue };
                match best_shift(&words[k], travel, self.start.is_some()) {
                    Some(shift) => words[k].iter_mut().for_each(|word| *word += shift),
                    None => fits = false,
                }
            }
            if fits {
                fitting.push(words);
            }
        }
        if fitting.len() < 2 {
            return Ok(fitting.pop());
        }
        let sum = |words: &[Vec<f64>; 2]| words.iter().flatten().map(|word| word.abs()).sum::<f64>();
        let sums: Vec<f64> = fitting.iter().map(sum).collect();
        let least = sums.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(n, _)| n);
        Ok(Some(fitting.swap_remove(least)))
    }
}

/// Whether no step is so near to half a turn that it could also go the other way round.
fn turns_one_way(words_deg: &[f64], start_deg: Option<f64>) -> bool {
    let Some(first) = words_deg.first() else { return true };
    !has_step_over((180.0 - TIE_DEG).next_down(), start_deg.unwrap_or(*first), words_deg)
}

/// The shift by whole turns that brings all words into the travel with the smallest Σ|word|. With a given start,
/// only no shift.
fn best_shift(words_deg: &[f64], travel: Travel, fixed: bool) -> Option<f64> {
    let [low, high] = extremes(words_deg);
    let slack = COMPUTED_WORD_SLACK;
    let first = ((travel.min - slack - low) / 360.0).ceil();
    let last = ((travel.max + slack - high) / 360.0).floor();
    if first > last || (fixed && !(first..=last).contains(&0.0)) {
        return None;
    }
    if fixed {
        return Some(0.0);
    }
    // Σ|word + 360 k| is least where the median word is nearest to zero.
    let middle = turns_to_middle(words_deg, [low, high]);
    let turns = [middle - 1.0, middle, middle + 1.0].map(|turns| turns.clamp(first, last));
    if turns.iter().all(|turn| turn.total_cmp(&turns[0]).is_eq()) {
        return Some(360.0 * turns[0]);
    }
    let mut sums = [0.0; 3];
    for word in words_deg {
        for (sum, turns) in sums.iter_mut().zip(turns) {
            *sum += (word + 360.0 * turns).abs();
        }
    }
    turns.into_iter().zip(sums).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(turns, _)| 360.0 * turns)
}

/// The whole turns that bring the median word next to zero, with the sign of zero that they have without a short way.
fn turns_to_middle(words_deg: &[f64], [low, high]: [f64; 2]) -> f64 {
    let half = words_deg.len() / 2;
    let turns_of = |word: f64| (-word / 360.0).round();
    let turns = turns_of(low);
    if (turns - turns_of(high)).abs() > 0.5 {
        let mut sorted = words_deg.to_vec();
        let (_, median, _) = sorted.select_nth_unstable_by(half, f64::total_cmp);
        return turns_of(*median);
    }
    if turns.abs() > 0.5 {
        return turns;
    }
    let negative: usize = words_deg.iter().map(|word| usize::from(word.is_sign_negative())).sum();
    if half < negative { 0.0 } else { -0.0 }
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
