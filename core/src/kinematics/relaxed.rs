//! Axes of several turns, chosen as if they were unlimited: two states per pose instead of one for every turn.

use super::cost::TIE_DEG;
use super::grid::Grid;
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
        let mut told: Option<(f64, [Vec<f64>; 2])> = None;
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
            let sum = words.iter().flatten().map(|word| word.abs()).sum::<f64>();
            if fits && told.as_ref().is_none_or(|(least, _)| sum < *least) {
                told = Some((sum, words));
            }
        }
        Ok(told.map(|(_, words)| words))
    }
}

/// Whether no step is so near to half a turn that it could also go the other way round.
fn turns_one_way(words_deg: &[f64], start_deg: Option<f64>) -> bool {
    let before = start_deg.iter().chain(words_deg);
    let after = if start_deg.is_some() { words_deg } else { words_deg.get(1..).unwrap_or_default() };
    before.zip(after).all(|(before, after)| (after - before).abs() < 180.0 - TIE_DEG)
}

/// The shift by whole turns that brings all words into the travel with the smallest Σ|word|. With a given start,
/// only no shift.
fn best_shift(words_deg: &[f64], travel: Travel, fixed: bool) -> Option<f64> {
    let (low, high) = words_deg
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), word| (low.min(*word), high.max(*word)));
    let slack = COMPUTED_WORD_SLACK;
    let first = ((travel.min - slack - low) / 360.0).ceil();
    let last = ((travel.max + slack - high) / 360.0).floor();
    if first > last || (fixed && !(first..=last).contains(&0.0)) {
        return None;
    }
    if fixed {
        return Some(0.0);
    }
    #[expect(clippy::float_cmp, reason = "whole numbers")]
    if first == last {
        return Some(360.0 * first);
    }
    // Σ|word + 360 k| is least where the median word is nearest to zero.
    let mut sorted = words_deg.to_vec();
    let half = sorted.len() / 2;
    let (_, median, _) = sorted.select_nth_unstable_by(half, f64::total_cmp);
    let middle = (-*median / 360.0).round();
    let sum = |turns: f64| words_deg.iter().map(|word| (word + 360.0 * turns).abs()).sum::<f64>();
    [middle - 1.0, middle, middle + 1.0]
        .map(|turns| turns.clamp(first, last))
        .into_iter()
        .min_by(|a, b| sum(*a).total_cmp(&sum(*b)))
        .map(|turns| 360.0 * turns)
}
