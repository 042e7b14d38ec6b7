//! The surface across the feed, as its normal curvature there.

use crate::units::Length;

/// The surface between neighbouring passes, across the feed: flat, or of constant normal curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface {
    /// A flat surface.
    Flat,
    /// The part bulges toward the tool.
    Convex {
        /// Radius of normal curvature Rs.
        radius: Length,
    },
    /// The part is hollow: the tool is inside.
    Concave {
        /// Radius of normal curvature Rs.
        radius: Length,
    },
}

impl Surface {
    /// k (+1 convex, −1 concave) and Rs \[mm\]; `None` for a flat surface.
    pub(super) fn curvature(self) -> Option<(f64, f64)> {
        match self {
            Self::Flat => None,
            Self::Convex { radius } => Some((1.0, radius.mm())),
            Self::Concave { radius } => Some((-1.0, radius.mm())),
        }
    }
}
