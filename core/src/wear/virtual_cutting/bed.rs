//! All needles of a surface, sorted by position, and their residuals.

use std::ops::ControlFlow;

use super::boxes::AxisBox;
use super::leave::{CutLeave, Share};
use super::tile::Tile;
use super::{Residual, SweepBatch};
use crate::contact::CutterBody;
use crate::side_by_side::SideBySide;
use crate::surface::SurfacePoint;
use crate::units::Length;

/// Most samples in one tile.
const TILE: usize = 512;

/// The needles of all samples of a surface.
///
/// They are sorted into tiles of neighbours once, by their positions alone. The result therefore does not depend,
/// to the bit, on the number of parts among which the tiles are shared.
#[derive(Debug, Clone)]
pub struct NeedleBed {
    tiles: Vec<Tile>,
    samples: usize,
}

/// Counts of the comparisons made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CutCounts {
    /// Pairs of a needle and a piece that were compared one by one.
    pub pairs: u64,
    /// Comparisons of pieces with clumps of needles.
    pub looks: u64,
    /// Comparisons of boxes around pieces with the box around a clump of needles.
    pub boxes: u64,
    /// Pairs that shortened the needle.
    pub cuts: u64,
}

/// Number of boxes compared in the time of one pair.
const BOXES_PER_PAIR: u64 = 16;

impl CutCounts {
    /// All work that took time.
    #[must_use]
    pub fn work(&self) -> u64 {
        self.pairs + self.looks + self.boxes / BOXES_PER_PAIR
    }
}

impl NeedleBed {
    /// Needles up to the height `stock` over finite samples with unit normals.
    ///
    /// `None` if `stop` broke.
    #[must_use]
    pub fn new(samples: &[SurfacePoint], stock: Length, stop: &dyn Fn() -> ControlFlow<()>) -> Option<Self> {
        let mut order: Vec<usize> = (0..samples.len()).collect();
        let mut tiles = Vec::new();
        let made = divide(samples, &mut order, TILE, stop, &mut |part| {
            tiles.push(Tile::new(samples, part, stock.mm()));
        });
        made.is_continue().then_some(Self { tiles, samples: samples.len() })
    }

    /// Cuts the needles with a batch of pieces, in as many parts as `parts` asks for. It breaks off if `leave` is
    /// over: the needles then mean nothing, and the counts show whether the work limit was the reason.
    pub fn cut(
        &mut self,
        body: &CutterBody,
        batch: &SweepBatch,
        leave: &CutLeave<'_>,
        parts: &dyn SideBySide,
    ) -> ControlFlow<()> {
        if batch.is_empty() {
            return ControlFlow::Continue(());
        }
        let count = parts.parts().clamp(1, self.tiles.len().max(1));
        let mut shares: Vec<Vec<&mut Tile>> = (0..count).map(|_| Vec::new()).collect();
        for (index, tile) in self.tiles.iter_mut().enumerate() {
            shares[index % count].push(tile);
        }
        let mut flows = vec![ControlFlow::Continue(()); count];
        parts.run(
            shares
                .into_iter()
                .zip(&mut flows)
                .map(|(share, flow)| {
                    let work = move || {
                        let mut leave = Share::new(leave);
                        *flow = share.into_iter().try_for_each(|tile| tile.cut(body, batch, &mut leave));
                    };
                    Box::new(work) as Box<dyn FnOnce() + Send + '_>
                })
                .collect(),
        );
        flows.into_iter().find(ControlFlow::is_break).unwrap_or(ControlFlow::Continue(()))
    }

    /// The residual of every sample, in their order; `None` is uncut.
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

    /// The comparisons made so far.
    #[must_use]
    pub fn counts(&self) -> CutCounts {
        self.tiles.iter().fold(CutCounts::default(), |sum, tile| CutCounts {
            pairs: sum.pairs + tile.counts.pairs,
            looks: sum.looks + tile.counts.looks,
            boxes: sum.boxes + tile.counts.boxes,
            cuts: sum.cuts + tile.counts.cuts,
        })
    }
}

/// From this number of samples on, a division first asks whether to continue: a millisecond or two.
const ASKED_FROM: usize = 4096;

/// Divides samples at the median of their longest side until no part has more than `most`, and hands the parts out.
pub(super) fn divide(
    samples: &[SurfacePoint],
    order: &mut [usize],
    most: usize,
    stop: &dyn Fn() -> ControlFlow<()>,
    take: &mut dyn FnMut(&[usize]),
) -> ControlFlow<()> {
    if order.len() >= ASKED_FROM {
        stop()?;
    }
    if order.len() <= most {
        if !order.is_empty() {
            order.sort_unstable();
            take(order);
        }
        return ControlFlow::Continue(());
    }
    let mut around = AxisBox::NOTHING;
    for &index in order.iter() {
        around.take(samples[index].point_mm);
    }
    let side = (around.high_mm - around.low_mm).imax();
    let middle = order.len() / 2;
    // Equal positions are ordered by their indices, so that the halves are the same whatever the method.
    order.select_nth_unstable_by(middle, |&a, &b| {
        samples[a].point_mm[side].total_cmp(&samples[b].point_mm[side]).then(a.cmp(&b))
    });
    let (left, right) = order.split_at_mut(middle);
    divide(samples, left, most, stop, take)?;
    divide(samples, right, most, stop, take)
}
