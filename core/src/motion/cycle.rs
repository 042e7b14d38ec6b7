//! The canned cycle under way.

/// How a cycle drills.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stroke {
    /// Down at feed, and up at rapid traverse.
    Drill,
    /// Down and up at feed. Controls differ in how it goes on from the retract plane to a higher level.
    Bore,
    /// Its course depends on the spindle. It ends where a drilling cycle ends.
    Tap,
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
    /// The axis of the plane and the unit in which the values were written.
    pub(super) written_in: Option<(u8, f64)>,
    /// G98 or G99, if the program has stated it.
    pub(super) retract: Option<Retract>,
}

impl Cycle {
    pub(super) const NONE: Self = Self {
        stroke: Stroke::Other,
        initial_mm: None,
        plane: None,
        depth: None,
        written_in: None,
        retract: None,
    };

    /// The values that are the same whether a block was executed or skipped.
    pub(super) fn common(self, skipped: Self) -> Self {
        let retract = self.retract.filter(|retract| skipped.retract == Some(*retract));
        if self == skipped { self } else { Self { retract, ..Self::NONE } }
    }

    /// Nothing is known of it but the level of retraction.
    pub(super) fn forget(&mut self) {
        *self = Self { retract: self.retract, ..Self::NONE };
    }
}
