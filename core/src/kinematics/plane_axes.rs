//! The rotary positions for a tilted plane: which of both solutions, and in which turn, the control takes.

use super::inverse::turn_range;
use super::pointing::principal_deg;
use super::{Kinematics, Setup, ToolPose};
use crate::geometry::Vec3;
use crate::machine::{Machine, PlaneRule, PlaneSolution, Travel};

/// Words and ways this close are the same, so that rounding decides nothing \[deg\].
const SAME_DEG: f64 = 1e-6;
/// A normal closer to the axis next to the workpiece than this, and not along it, may be meant as along it \[rad\].
const ALMOST_POLE_RAD: f64 = 1e-8;

/// Chooses rotary positions as the control of one machine does. What neither the machine's rule nor the program
/// decides is not chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneAxes {
    /// The nominal machine: the control knows no other.
    kinematics: Kinematics,
    rule: PlaneRule,
    /// The axis of the rule, by its index in the profile.
    axis: Option<usize>,
    /// In the profile's order \[deg\].
    travel_deg: [Option<Travel>; 2],
}

/// What the program itself says about the choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PlaneWish {
    /// The sign of the axis of the rule.
    pub side: Option<PlaneSide>,
    /// What happens to an axis that does not change the direction of the tool.
    pub free_axis: FreeAxis,
}

/// The sign that the program states for the axis of the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlaneSide {
    /// Positive, or negative.
    pub positive: bool,
    /// The control takes the other position if the travel has no position on this side.
    pub or_other: bool,
}

/// What happens to an axis that does not change the direction of the tool, if the plane is across it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FreeAxis {
    /// The rule of the machine decides.
    #[default]
    ByRule,
    /// It does not turn.
    Stays,
    /// This is not known.
    Unknown,
}

/// One position, in the profile's order.
#[derive(Debug, Clone, Copy)]
struct Position {
    /// In the turn that the control takes; `None` if this is not known \[deg\].
    turned_deg: [Option<f64>; 2],
    /// Whether the word is positive; `None` if it is zero, or if it depends on the turn.
    is_positive: [Option<bool>; 2],
}

impl PlaneAxes {
    /// For a machine whose profile states a rule.
    #[must_use]
    pub fn of(machine: &Machine) -> Option<Self> {
        let PlaneSolution { rule, axis } = machine.plane_solution()?;
        let axes = machine.rotary_axes();
        let setup = Setup { apply_errors: false, ..Setup::default() };
        Some(Self {
            kinematics: Kinematics::new(machine, &setup),
            rule,
            axis: axis.and_then(|letter| axes.iter().position(|axis| axis.letter == letter)),
            travel_deg: axes.each_ref().map(|axis| axis.travel_deg),
        })
    }

    /// The words of the rotary axes \[deg\] with which the tool points along `normal` in W, in the profile's order.
    /// `from_deg` are their present words. `None`: out of reach or travel, or rule and program do not decide.
    ///
    /// Positions out of travel are no choice. A limited axis takes the turn next to its present word, or its only
    /// turn. An axis without limits takes the turn next to its present word, or a word in (−180, 180].
    #[must_use]
    pub fn choose(&self, normal: [f64; 3], from_deg: [Option<f64>; 2], wish: PlaneWish) -> Option<[f64; 2]> {
        let pose = ToolPose { tip_mm: Vec3::zeros(), axis: Vec3::from(normal) };
        let solution = self.kinematics.solution(0, &pose).ok()?;
        let [u, v] = self.kinematics.profile_index;
        if !solution.at_pole && solution.polar_distance_rad < ALMOST_POLE_RAD {
            return None;
        }
        let mut positions = [None; 2];
        for (slot, words_deg) in positions.iter_mut().zip(solution.words_deg).take(solution.branches) {
            let mut words = [0.0; 2];
            (words[u], words[v]) = words_deg.into();
            if solution.at_pole {
                words[u] = self.free_word(from_deg[u], wish)?;
            }
            *slot = self.reached(words, from_deg);
        }
        let chosen = match positions {
            [Some(first), Some(second)] => self.better(&first, &second, from_deg, wish)?,
            [Some(only), None] | [None, Some(only)] => {
                let side = wish.side.filter(|side| !side.or_other);
                only_on(side, only, self.axis)?
            }
            [None, None] => return None,
        };
        let [Some(first), Some(second)] = chosen.turned_deg else { return None };
        Some([first, second])
    }

    /// The word of an axis that does not change the direction.
    fn free_word(&self, from_deg: Option<f64>, wish: PlaneWish) -> Option<f64> {
        let stays = match wish.free_axis {
            FreeAxis::Stays => true,
            FreeAxis::ByRule => self.rule == PlaneRule::Shortest,
            FreeAxis::Unknown => false,
        };
        from_deg.filter(|_| stays && wish.side.is_none())
    }

    /// These words within travel; `None` if an axis has no such turn.
    fn reached(&self, words_deg: [f64; 2], from_deg: [Option<f64>; 2]) -> Option<Position> {
        let mut position = Position { turned_deg: [None; 2], is_positive: [None; 2] };
        for k in 0..2 {
            let (word, travel) = (principal_deg(words_deg[k]), self.travel_deg[k]);
            let turned = |turn: i32| word + 360.0 * f64::from(turn);
            let turns = turn_range(word, travel);
            if turns.is_empty() {
                return None;
            }
            // Without limits, the word just above −180 or below 180 is of either sign.
            let least =
                sign(turned(turns.start)).filter(|_| travel.is_some() || word.abs() < 180.0 - SAME_DEG);
            position.is_positive[k] = least.filter(|_| least == sign(turned(turns.end - 1)));
            position.turned_deg[k] = match (from_deg[k], travel) {
                (None, None) => Some(word),
                (None, Some(_)) => (turns.len() == 1).then(|| turned(turns.start)),
                // Half a turn ahead and half a turn back are the same place.
                (Some(from), None) => {
                    Some(word + 360.0 * (((from - 180.0 + SAME_DEG - word) / 360.0).floor() + 1.0))
                }
                (Some(from), Some(_)) => nearest(turns.map(turned), from),
            };
        }
        Some(position)
    }

    fn better(
        &self,
        first: &Position,
        second: &Position,
        from_deg: [Option<f64>; 2],
        wish: PlaneWish,
    ) -> Option<Position> {
        let takes_first = match (wish.side, self.rule) {
            (Some(side), _) => {
                // A control may count an axis without limits from 0 to 360, where the lower word is another one.
                let is_counted = |k: usize| !side.or_other || self.travel_deg[k].is_some();
                self.same_for_axes(|k| is_on_side(first, second, k, side.positive).filter(|_| is_counted(k)))
            }
            (None, PlaneRule::PositiveFirst) => self.same_for_axes(|k| is_on_side(first, second, k, true)),
            (None, PlaneRule::NegativeFirst) => self.same_for_axes(|k| is_on_side(first, second, k, false)),
            (None, PlaneRule::Shortest) => {
                let way =
                    |position: &Position, k: usize| Some((position.turned_deg[k]? - from_deg[k]?).abs());
                let ways = |position: &Position| Some([way(position, 0)?, way(position, 1)?]);
                if let Some(k) = self.axis {
                    is_less(way(first, k)?, way(second, k)?)
                } else {
                    dominates(ways(first)?, ways(second)?)
                }
            }
        }?;
        Some(if takes_first { *first } else { *second })
    }

    /// A decision by the axis of the rule, or one that is the same by both axes.
    fn same_for_axes(&self, decide: impl Fn(usize) -> Option<bool>) -> Option<bool> {
        match self.axis {
            Some(k) => decide(k),
            None => decide(0).filter(|first| decide(1) == Some(*first)),
        }
    }
}

fn sign(word_deg: f64) -> Option<bool> {
    (word_deg.abs() > SAME_DEG).then_some(word_deg > 0.0)
}

/// Whether an axis has the wanted sign in the first position, if it has it in only one of the two.
fn is_on_side(first: &Position, second: &Position, k: usize, positive: bool) -> Option<bool> {
    let (first, second) = (first.is_positive[k]?, second.is_positive[k]?);
    (first != second).then_some(first == positive)
}

/// The only position, if it is on the side that the program insists on.
fn only_on(side: Option<PlaneSide>, only: Position, axis: Option<usize>) -> Option<Position> {
    let Some(side) = side else { return Some(only) };
    let is_there = |k: usize| only.is_positive[k] == Some(side.positive);
    let agrees = axis.map_or_else(|| is_there(0) && is_there(1), is_there);
    agrees.then_some(only)
}

/// Whether the first way is the shorter one; `None` if both are the same.
fn is_less(first: f64, second: f64) -> Option<bool> {
    ((first - second).abs() > SAME_DEG).then_some(first < second)
}

/// Whether the first position is nearer by one axis and not farther by the other; `None` if neither position is.
fn dominates(first: [f64; 2], second: [f64; 2]) -> Option<bool> {
    match [0, 1].map(|k| is_less(first[k], second[k])) {
        [Some(a), Some(b)] if a != b => None,
        [Some(is), _] | [_, Some(is)] => Some(is),
        [None, None] => None,
    }
}

/// The word nearest to `from`; `None` if two are equally near.
fn nearest(words_deg: impl IntoIterator<Item = f64>, from_deg: f64) -> Option<f64> {
    let mut best: Option<(f64, f64)> = None;
    let mut is_tied = false;
    for word in words_deg {
        let way = (word - from_deg).abs();
        match best {
            Some((least, _)) if (way - least).abs() <= SAME_DEG => is_tied = true,
            Some((least, _)) if way > least => {}
            _ => (best, is_tied) = (Some((way, word)), false),
        }
    }
    best.filter(|_| !is_tied).map(|(_, word)| word)
}

#[cfg(test)]
#[path = "plane_axes/tests.rs"]
mod tests;
