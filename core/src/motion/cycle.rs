//! Canned cycles: what holds from one to the next, and what each makes.

use crate::program::Keyword;

/// How a cycle drills.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stroke {
    /// Down at feed, and up at rapid traverse.
    Drill,
    /// The same by the increment of Q. In between the control retracts by its own parameters.
    Peck,
    /// Down at feed, and up at feed to the retract plane: a bore, or a thread. Controls differ in the feed from there
    /// to a higher level.
    Bore,
    /// Its course is not followed.
    Other,
}

/// The level to which a cycle retracts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Retract {
    /// G98: where the series of cycles began.
    Initial,
    /// G99: the retract plane.
    Plane,
}

/// What holds from one cycle to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cycle {
    pub(super) stroke: Stroke,
    /// The level at which the series of cycles began \[mm\].
    pub(super) initial_mm: Option<f64>,
    /// R and the depth as written \[mm\], and whether they count from the position.
    pub(super) plane: Option<(f64, bool)>,
    pub(super) depth: Option<(f64, bool)>,
    /// Q states an increment.
    pub(super) has_increment: bool,
    /// The axis of the plane and the unit in which the values were written.
    pub(super) written_in: Option<(u8, f64)>,
    /// G98 or G99, if the program has stated it.
    pub(super) retract: Option<Retract>,
    /// G0 was in force before the series.
    pub(super) after_rapid: bool,
}

impl Cycle {
    pub(super) const NONE: Self = Self {
        stroke: Stroke::Other,
        initial_mm: None,
        plane: None,
        depth: None,
        has_increment: false,
        written_in: None,
        retract: None,
        after_rapid: false,
    };

    /// The values that are the same whether a block was executed or skipped.
    pub(super) fn common(self, skipped: Self) -> Self {
        let retract = self.retract.filter(|retract| skipped.retract == Some(*retract));
        let after_rapid = self.after_rapid && skipped.after_rapid;
        if self == skipped { self } else { Self { retract, after_rapid, ..Self::NONE } }
    }

    /// Nothing is known of it but the level of retraction, and the mode before it.
    pub(super) fn forget(&mut self) {
        *self = Self { retract: self.retract, after_rapid: self.after_rapid, ..Self::NONE };
    }
}

/// A drilling cycle of cutter location data, by distances from its points along the tool axis \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PointCycle {
    /// Height from which it goes down at feed.
    pub(super) plane_mm: f64,
    /// Depth below the point.
    pub(super) depth_mm: f64,
    /// Height to which it goes up in the end.
    pub(super) retract_mm: f64,
    /// Depths of the first peck and of each further one.
    pub(super) pecks_mm: Option<[f64; 2]>,
    /// The feed as written, its decimals, and its unit.
    pub(super) feed: f64,
    pub(super) feed_decimals: u8,
    pub(super) feed_unit: Keyword,
}

/// Most pecks of one hole.
const MAX_PECKS: usize = 100;
/// Depths this close are one \[mm\]: cutter location data has at most seven decimals.
const SAME_PECK_MM: f64 = 1e-6;

impl PointCycle {
    /// The bottoms of its strokes below the mouth of the hole \[mm\]; `None` if they are too many.
    pub(super) fn bottoms_mm(&self) -> Option<Vec<f64>> {
        let Some([first_mm, further_mm]) = self.pecks_mm else { return Some(vec![self.depth_mm]) };
        let mut bottoms_mm = Vec::new();
        // Pecks count from the height at which the feed begins: on no control are they deeper.
        let mut bottom_mm = first_mm - self.plane_mm;
        while bottom_mm < self.depth_mm - SAME_PECK_MM {
            if bottoms_mm.len() + 1 >= MAX_PECKS {
                return None;
            }
            bottoms_mm.push(bottom_mm);
            bottom_mm += further_mm;
        }
        bottoms_mm.push(self.depth_mm);
        Some(bottoms_mm)
    }
}

/// How a cycle makes its hole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HoleStroke {
    /// Down at feed, and up to the end at rapid traverse.
    Drill,
    /// Down and up at the feed in force, and from the clearance above the surface to the end at rapid traverse.
    Bore,
    /// The same with feeds of the cycle.
    Ream,
    /// As a bore. Its feed is the pitch times the speed of the spindle, which may not be stated.
    Tap,
    /// It is not followed.
    Other,
}

/// How the parameters of holes state their levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HoleLevels {
    /// By the coordinates of the surface and of a retract plane.
    Planes,
    /// By clearances above the surface.
    Clearances,
}

/// The cycles of a dialect that state all parameters of a hole.
#[derive(Debug, Clone, Copy)]
pub(super) struct HoleRules {
    pub(super) levels: HoleLevels,
    /// By the number of the cycle.
    pub(super) stroke: fn(u32) -> HoleStroke,
    /// After a cycle with feeds of its own the feed before it holds again.
    pub(super) keeps_feed: bool,
    /// Under tool-centre-point control they run along the same axis.
    pub(super) under_tcp: bool,
}

/// A cycle that makes one hole at the place where it runs, along the axis of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HoleCycle {
    pub(super) stroke: HoleStroke,
    /// Where it begins to go down at feed, the bottom, and where it ends \[mm\].
    pub(super) plane_mm: f64,
    pub(super) depth_mm: f64,
    pub(super) end_mm: f64,
    /// Its own feeds down and up as written, with their decimals. Without them the feed in force holds.
    pub(super) feeds: Option<[(f64, u8); 2]>,
    /// The unit in which it was written, and the axis of the plane if it names one.
    pub(super) mm_per_unit: f64,
    pub(super) axis: Option<u8>,
}

impl HoleCycle {
    /// A cycle that is not followed.
    pub(super) const OTHER: Self = Self {
        stroke: HoleStroke::Other,
        plane_mm: 0.0,
        depth_mm: 0.0,
        end_mm: 0.0,
        feeds: None,
        mm_per_unit: 1.0,
        axis: None,
    };
}
