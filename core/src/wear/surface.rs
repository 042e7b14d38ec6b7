//! The surface across the feed, as its normal curvature there.

use crate::units::Length;

/// The surface between neighbouring passes, across the feed: flat, or of constant normal curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface {
    /// No curvature.
    Flat,
    /// The part bulges toward the tool.
    Convex {
        /// Radius of normal curvature Rs.
        radius: Length,
    },
    /// The part is hollow: the tool sits inside.
    Concave {
        /// Radius of normal curvature Rs.
        radius: Length,
    },
}

impl Surface {
    /// k (+1 convex, −1 concave) and Rs \[mm\]; none where the surface is flat.
    pub(super) fn curvature(self) -> Option<(f64, f64)> {
        match self {
            Self::Flat => None,
            Self::Convex { radius } => Some((1.0, radius.mm())),
            Self::Concave { radius } => Some((-1.0, radius.mm())),
        }
    }
}
