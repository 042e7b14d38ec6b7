//! Where the poses of a path are kept, and how they are handed over: block by block.

use super::lanes::{BLOCK, Lane};
use super::{PoseLanes, ToolPose};

/// Poses of a path, wherever they are kept: in memory, or in a file that the caller reads.
///
/// A path goes along its poses more than once, in order, and looks back at single ones. Every call for the same poses
/// has to give the same bits. A source that cannot read its poses any more hands over any poses, and remembers that it
/// failed. Its caller then says, at the next question, that it wants to stop. [`super::Kinematics::decide_path`] and
/// [`super::DecidedPath::next_piece`] ask once more before they hand anything over, so nothing that was made of these
/// poses leaves.
pub trait PoseSource: Sync {
    /// The number of poses.
    fn count(&self) -> usize;

    /// The poses from `start` on, which is below [`PoseSource::count`]: [`PoseBlock::LEN`] of them, or as many as there
    /// are. They are where they are kept, or were put into `copy`.
    fn block<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> Poses<'a>;

    /// One pose. A source that can do this faster than by a whole block should say how.
    fn pose(&self, index: usize) -> ToolPose {
        self.block(index, &mut PoseBlock::new()).pose(0)
    }

    /// Only the tips \[mm\] of [`PoseSource::block`].
    #[doc(hidden)]
    fn tips<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> [&'a [f64; PoseBlock::LEN]; 3] {
        self.block(start, copy).tip_mm
    }
}

/// A block of poses where they are: at most [`PoseBlock::LEN`].
#[derive(Debug, Clone, Copy)]
pub struct Poses<'a> {
    /// The number of poses; the values after them mean nothing.
    pub(super) count: usize,
    /// x y z.
    pub(super) tip_mm: [&'a Lane; 3],
    /// i j k.
    pub(super) axis: [&'a Lane; 3],
}

impl Poses<'_> {
    /// One pose of the block.
    pub(super) fn pose(&self, lane: usize) -> ToolPose {
        ToolPose {
            tip_mm: self.tip_mm.map(|values| values[lane]).into(),
            axis: self.axis.map(|values| values[lane]).into(),
        }
    }
}

/// Memory for a block of poses.
#[derive(Debug)]
#[repr(align(64))]
pub struct PoseBlock {
    tip_mm: [Lane; 3],
    axis: [Lane; 3],
}

impl PoseBlock {
    /// The number of poses of a block.
    pub const LEN: usize = BLOCK;

    pub(super) fn new() -> Self {
        Self { tip_mm: [[0.0; BLOCK]; 3], axis: [[0.0; BLOCK], [0.0; BLOCK], [1.0; BLOCK]] }
    }

    /// Puts poses into the block, up to [`PoseBlock::LEN`]. Each is the tip \[mm\] in W, then the unit axis.
    #[inline]
    pub fn fill(&mut self, poses: impl IntoIterator<Item = [f64; 6]>) -> Poses<'_> {
        let ([x, y, z], [i, j, k]) = (&mut self.tip_mm, &mut self.axis);
        let places = x.iter_mut().zip(y).zip(z).zip(i).zip(j).zip(k);
        let mut count = 0;
        for ((((((x, y), z), i), j), k), pose) in places.zip(poses) {
            [*x, *y, *z, *i, *j, *k] = pose;
            count += 1;
        }
        self.poses(count)
    }

    fn poses(&self, count: usize) -> Poses<'_> {
        Poses { count, tip_mm: self.tip_mm.each_ref(), axis: self.axis.each_ref() }
    }
}

impl PoseSource for [ToolPose] {
    fn count(&self) -> usize {
        self.len()
    }
    fn block<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> Poses<'a> {
        let poses = &self[start..self.len().min(start + BLOCK)];
        copy.fill(
            poses
                .iter()
                .map(|ToolPose { tip_mm, axis }| [tip_mm.x, tip_mm.y, tip_mm.z, axis.x, axis.y, axis.z]),
        )
    }
    fn pose(&self, index: usize) -> ToolPose {
        self[index]
    }
    fn tips<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> [&'a Lane; 3] {
        let poses = &self[start..self.len().min(start + BLOCK)];
        let [x, y, z] = &mut copy.tip_mm;
        for (((x, y), z), pose) in x.iter_mut().zip(y).zip(z).zip(poses) {
            (*x, *y, *z) = (pose.tip_mm.x, pose.tip_mm.y, pose.tip_mm.z);
        }
        copy.tip_mm.each_ref()
    }
}

impl PoseSource for PoseLanes {
    fn count(&self) -> usize {
        self.len()
    }
    fn block<'a>(&'a self, start: usize, copy: &'a mut PoseBlock) -> Poses<'a> {
        let end = self.len().min(start + BLOCK);
        let whole = |lane: &'a Vec<f64>| lane.get(start..end)?.as_array::<BLOCK>();
        let here = || {
            Some(Poses {
                count: BLOCK,
                tip_mm: [whole(&self.x_mm)?, whole(&self.y_mm)?, whole(&self.z_mm)?],
                axis: [whole(&self.i)?, whole(&self.j)?, whole(&self.k)?],
            })
        };
        if let Some(poses) = here() {
            return poses;
        }
        let [x, y, z] = &mut copy.tip_mm;
        let [i, j, k] = &mut copy.axis;
        let pairs =
            [(x, &self.x_mm), (y, &self.y_mm), (z, &self.z_mm), (i, &self.i), (j, &self.j), (k, &self.k)];
        for (lane, from) in pairs {
            lane[..end - start].copy_from_slice(&from[start..end]);
        }
        copy.poses(end - start)
    }
    fn pose(&self, index: usize) -> ToolPose {
        Self::pose(self, index)
    }
}
