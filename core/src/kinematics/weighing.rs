//! Weights of the steps into a block of poses, for both choices.

use std::ops::Range;

use super::aligned::Aligned;
use super::grid::Grid;
use super::lanes::{BLOCK, Lane};
use super::pose_source::PoseSource;
use super::staying::Stays;
use super::two_way::{Rules, Weights, weigh};
use super::walk::{Stop, Walk, branch_words};

/// The steps into the poses of a block, with weights computed in lanes.
pub(super) struct Weighed {
    pub(super) rules: Rules,
    /// Principal words of u, v of the first branch, then of the second \[deg\].
    pub(super) words: Box<Aligned<[Lane; 4]>>,
    pub(super) weights: Box<Weights>,
    /// Of a block in which no path changes its branch, once there is one to look at.
    pub(super) stays: Option<Box<Stays>>,
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// The weights of the steps into the poses of a block, starting from the words `before`. With `all` false only the
    /// nearest branches are found.
    pub(super) fn weigh(&self, before: [f64; 4], block: &Range<usize>, all: bool, lanes: &mut Weighed) {
        let places = self.places(block);
        for (lane, from) in lanes.words.iter_mut().zip(branch_words(&self.out.joints)) {
            lane[..block.len()].copy_from_slice(&from[places.clone()]);
        }
        let Weighed { rules, words, weights, .. } = lanes;
        weigh(self.options.instructions, rules, before, words, all, weights);
    }

    /// Memory for the weights of a block, if steps are weighted in lanes.
    pub(super) fn lanes_of(&self, grid: Grid) -> Option<Weighed> {
        let rules = grid.rules(self.options.rewind_deg).filter(|_| !self.singly)?;
        Some(Weighed {
            rules,
            words: Box::new(Aligned([[0.0; BLOCK]; 4])),
            weights: Box::new(Weights::new()),
            stays: None,
        })
    }
}
