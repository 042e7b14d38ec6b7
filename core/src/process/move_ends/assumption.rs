//! Counts for how much of a program a contact can be assumed from the feed.

use crate::units::Length;

/// Cuts of a program whose contacts are assumed from the feed, counted by result.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Assumption {
    /// Straight motions at feed.
    pub cuts: u64,
    /// Cuts at whose end a contact is assumed. Only there can the effect of the wear be compensated.
    pub compensated: u64,
    /// Cuts whose feed leaves the contact open: the tool plunges, or moves across its axis, as along a wall or on a
    /// floor.
    pub open: u64,
    /// Cuts where no rotary axis turns next to the point, so nothing is assumed.
    pub not_turning: u64,
    /// Path of the tip in all of these cuts, and in those that are compensated.
    pub path: Length,
    /// See [`Self::path`].
    pub path_compensated: Length,
}

impl Assumption {
    /// Counts a cut of this length \[mm\].
    pub(super) fn take(&mut self, path_mm: f64, turns: bool, has_contact: bool) {
        let path = Length::from_mm(path_mm);
        self.cuts += 1;
        self.path = self.path + path;
        if has_contact {
            self.compensated += 1;
            self.path_compensated = self.path_compensated + path;
        } else if turns {
            self.open += 1;
        } else {
            self.not_turning += 1;
        }
    }
}
