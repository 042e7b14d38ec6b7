//! A few hundred neighbouring needles, and their cutting by a batch of pieces.

use std::ops::ControlFlow;

use super::bed::{CutCounts, divide};
use super::boxes::AxisBox;
use super::leave::Share;
use super::section::Section;
use super::{Residual, SweepBatch};
use crate::contact::CutterBody;
use crate::geometry::Vec3;
use crate::surface::SurfacePoint;

/// Most needles in one clump.
const CLUMP: usize = 8;
/// Largest rounding error of a distance \[mm\].
const ROUNDING_MM: f64 = 1e-9;

/// One needle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needle {
    point_mm: Vec3,
    normal: Vec3,
    /// Height of the lowest entry so far \[mm\]. Before the first entry it is the stock's height.
    height_mm: f64,
    line: u64,
    /// Index of its sample.
    pub(super) index: usize,
    is_cut: bool,
    by_rapid: bool,
}

impl Needle {
    pub(super) fn new(index: usize, sample: &SurfacePoint, stock_mm: f64) -> Self {
        let SurfacePoint { point_mm, normal } = *sample;
        Self { point_mm, normal, height_mm: stock_mm, line: 0, index, is_cut: false, by_rapid: false }
    }

    pub(super) fn residual(&self) -> Option<Residual> {
        let Self { height_mm, line, by_rapid, .. } = *self;
        self.is_cut.then_some(Residual { residual_mm: height_mm, line, by_rapid })
    }

    /// The point of the needle that a cutter from outside contains if it shortens the needle.
    fn top_mm(&self) -> Vec3 {
        self.point_mm + self.normal * self.height_mm
    }

    /// The foot of the needle on the nominal surface, if the needle is still above it. A cutter that contains the
    /// foot gouges, from any side.
    fn foot_mm(&self) -> Option<Vec3> {
        (self.height_mm > 0.0).then_some(self.point_mm)
    }

    /// The lower height to which a piece cuts the needle, if it does.
    fn cut_by(&self, section: &Section, body: &CutterBody, stock_mm: f64) -> Option<f64> {
        let from_outside = section.entry_below(body, stock_mm, self.height_mm);
        let left_mm = from_outside.unwrap_or(self.height_mm);
        section.entry_below(body, 0.0, left_mm.min(0.0)).or(from_outside)
    }
}

/// Needles so near each other that they are excluded together.
#[derive(Debug, Clone)]
struct Clump {
    first: usize,
    end: usize,
    centre_mm: Vec3,
    /// The box around the tops and feet of its needles.
    around: AxisBox,
    /// Distance of the farthest of them from the centre \[mm\].
    reach_mm: f64,
}

impl Clump {
    fn new(first: usize, needles: &[Needle]) -> Self {
        let mut around = AxisBox::NOTHING;
        for needle in needles {
            around.take(needle.point_mm);
        }
        let mut clump =
            Self { first, end: first + needles.len(), centre_mm: around.centre_mm(), around, reach_mm: 0.0 };
        clump.measure(needles);
        clump
    }

    /// Updates the box from the present needles.
    fn measure(&mut self, needles: &[Needle]) {
        self.around = AxisBox::NOTHING;
        let mut square: f64 = 0.0;
        for needle in needles {
            for point_mm in [Some(needle.top_mm()), needle.foot_mm()].into_iter().flatten() {
                self.around.take(point_mm);
                square = square.max((point_mm - self.centre_mm).norm_squared());
            }
        }
        self.reach_mm = square.sqrt() + ROUNDING_MM;
    }
}

/// A tile of needles with their clumps.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    pub(super) needles: Vec<Needle>,
    clumps: Vec<Clump>,
    around: AxisBox,
    stock_mm: f64,
    pub(super) counts: CutCounts,
}

impl Tile {
    pub(super) fn new(samples: &[SurfacePoint], indices: &[usize], stock_mm: f64) -> Self {
        let mut order = indices.to_vec();
        let mut sorted: Vec<Needle> = Vec::with_capacity(order.len());
        let mut clumps = Vec::new();
        let to_the_end = || ControlFlow::Continue(());
        // A few hundred samples are divided before the first question is due.
        let _ = divide(samples, &mut order, CLUMP, &to_the_end, &mut |part| {
            let first = sorted.len();
            sorted.extend(part.iter().map(|&index| Needle::new(index, &samples[index], stock_mm)));
            clumps.push(Clump::new(first, &sorted[first..]));
        });
        let mut tile = Self {
            needles: sorted,
            clumps,
            around: AxisBox::NOTHING,
            stock_mm,
            counts: CutCounts::default(),
        };
        tile.measure();
        tile
    }

    fn measure(&mut self) {
        self.around = AxisBox::NOTHING;
        for clump in &self.clumps {
            self.around.join(&clump.around);
        }
    }

    /// Cuts with every piece of a batch. In each clump the nearest piece goes first, so that most others are then
    /// too far away.
    pub(super) fn cut(
        &mut self,
        body: &CutterBody,
        batch: &SweepBatch,
        leave: &mut Share<'_, '_>,
    ) -> ControlFlow<()> {
        let mut groups = Vec::new();
        let boxes = batch.groups_at(&self.around, &mut groups);
        self.counts.boxes += boxes;
        leave.after(boxes / 16)?;
        if groups.is_empty() {
            return ControlFlow::Continue(());
        }
        let mut near: Vec<(f64, usize)> = Vec::new();
        for clump in &mut self.clumps {
            near.clear();
            let before = self.counts.work();
            self.counts.boxes += batch.boxes_looked_at(&groups, &clump.around);
            for index in batch.pieces_at(&groups, &clump.around) {
                self.counts.looks += 1;
                if let Some(nearness_mm) =
                    batch.sweeps[index].nearness_mm(body, clump.centre_mm, clump.reach_mm)
                {
                    near.push((nearness_mm, index));
                }
            }
            near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let Some(needles) = self.needles.get_mut(clump.first..clump.end) else { continue };
            for &(nearness_mm, index) in &near {
                if nearness_mm > clump.reach_mm {
                    break;
                }
                let sweep = &batch.sweeps[index];
                let mut is_changed = false;
                for needle in needles.iter_mut() {
                    let reach_mm = |point_mm: Vec3| (point_mm - clump.centre_mm).norm() + ROUNDING_MM;
                    let is_far = |point_mm: Vec3| reach_mm(point_mm) < nearness_mm;
                    if is_far(needle.top_mm()) && needle.foot_mm().is_none_or(is_far) {
                        continue;
                    }
                    self.counts.pairs += 1;
                    let section = sweep.section(needle.point_mm, needle.normal);
                    if let Some(height_mm) = needle.cut_by(&section, body, self.stock_mm) {
                        needle.height_mm = height_mm;
                        needle.line = sweep.line;
                        needle.by_rapid = sweep.by_rapid;
                        needle.is_cut = true;
                        self.counts.cuts += 1;
                        is_changed = true;
                    }
                }
                if is_changed {
                    clump.measure(needles);
                }
            }
            leave.after(self.counts.work() - before)?;
        }
        self.measure();
        ControlFlow::Continue(())
    }
}
