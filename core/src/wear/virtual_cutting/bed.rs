//! All needles of a surface, sorted by place, and what is left of them.

use super::boxes::AxisBox;
use super::tile::Tile;
use super::{Residual, SideBySide, SweepBatch};
use crate::contact::CutterBody;
use crate::surface::SurfacePoint;
use crate::units::Length;

/// Samples in one tile, at most.
const TILE: usize = 512;

/// The needles of all samples of a surface.
///
/// They are sorted into tiles of neighbours once, by their places alone: so what comes out does not depend on how many
/// parts the tiles are shared among, bit for bit.
#[derive(Debug, Clone)]
pub struct NeedleBed {
    tiles: Vec<Tile>,
    samples: usize,
}

/// Counts of what was looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CutCounts {
    /// Pairs of a needle and a piece that were looked at one by one.
    pub pairs: u64,
    /// Pieces compared with clumps of needles.
    pub looks: u64,
    /// Pairs that shortened the needle.
    pub cuts: u64,
}

impl CutCounts {
    /// Everything that took time.
    #[must_use]
    pub fn work(&self) -> u64 {
        self.pairs + self.looks
    }
}

impl NeedleBed {
    /// Needles up to the height `stock` over finite samples with unit normals.
    #[must_use]
    pub fn new(samples: &[SurfacePoint], stock: Length) -> Self {
        let mut order: Vec<usize> = (0..samples.len()).collect();
        let mut tiles = Vec::new();
        divide(samples, &mut order, TILE, &mut |part| {
            tiles.push(Tile::new(samples, part, stock.mm()));
        });
        Self { tiles, samples: samples.len() }
    }

    /// Cuts the needles with a batch of pieces, in as many parts as `parts` wants.
    pub fn cut(&mut self, body: &CutterBody, batch: &SweepBatch, parts: &dyn SideBySide) {
        if batch.is_empty() {
            return;
        }
        let count = parts.parts().clamp(1, self.tiles.len().max(1));
        let mut shares: Vec<Vec<&mut Tile>> = (0..count).map(|_| Vec::new()).collect();
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            shares[index % count].push(tile);
        }
        parts.run(
            shares
                .into_iter()
                .map(|share| {
                    let work = move || {
                        for tile in share {
                            tile.cut(body, batch);
                        }
                    };
                    Box::new(work) as Box<dyn FnOnce() + Send + '_>
                })
                .collect(),
        );
    }

    /// What is left at every sample, in their order; `None` is uncut.
    #[must_use]
    pub fn residuals(&self) -> Vec<Option<Residual>> {
        let mut residuals = vec![None; self.samples];
        for needle in self.tiles.iter().flat_map(|tile| &tile.needles) {
            if let Some(residual) = residuals.get_mut(needle.index) {
                *residual = needle.residual();
            }
        }
        residuals
    }

    /// What was looked at so far.
    #[must_use]
    pub fn counts(&self) -> CutCounts {
        self.tiles.iter().fold(CutCounts::default(), |sum, tile| CutCounts {
            pairs: sum.pairs + tile.counts.pairs,
            looks: sum.looks + tile.counts.looks,
            cuts: sum.cuts + tile.counts.cuts,
        })
    }
}

/// Divides samples at the median of their longest side until no part holds more than `most`, and hands the parts out.
pub(super) fn divide(
    samples: &[SurfacePoint],
    order: &mut [usize],
    most: usize,
    take: &mut dyn FnMut(&[usize]),
) {
    if order.len() <= most {
        if !order.is_empty() {
            order.sort_unstable();
            take(order);
        }
        return;
    }
    let mut around = AxisBox::NOTHING;
    for &index in order.iter() {
        around.take(samples[index].point_mm);
    }
    let side = (around.high_mm - around.low_mm).imax();
    let middle = order.len() / 2;
    // equal places are told apart by their indices, so that the halves are the same however they are found
    order.select_nth_unstable_by(middle, |&a, &b| {
        samples[a].point_mm[side].total_cmp(&samples[b].point_mm[side]).then(a.cmp(&b))
    });
    let (left, right) = order.split_at_mut(middle);
    divide(samples, left, most, take);
    divide(samples, right, most, take);
}
