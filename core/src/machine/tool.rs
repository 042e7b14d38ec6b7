//! The cutter as (R, r): ball, bull-nose and flat in one description.

use thiserror::Error;

use crate::units::{Length, legible};

/// A milling cutter by cutter radius R and corner radius r: ball `r = R`, flat `r = 0`, bull-nose between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tool {
    radius: Length,
    corner_radius: Length,
}

/// Why a tool is not valid.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ToolFault {
    /// The cutter radius is not positive or not plausible.
    #[error("cutter radius {} mm is not between {min_mm} mm and {max_mm} mm", legible(.radius_mm))]
    Radius {
        /// The radius asked for \[mm\].
        radius_mm: f64,
        /// The smallest accepted \[mm\].
        min_mm: f64,
        /// The largest accepted \[mm\].
        max_mm: f64,
    },
    /// The corner radius is negative or larger than the cutter radius.
    #[error("corner radius {} mm is not between 0 and the cutter radius {radius_mm} mm", legible(.corner_radius_mm))]
    CornerRadius {
        /// The corner radius asked for \[mm\].
        corner_radius_mm: f64,
        /// The cutter radius \[mm\].
        radius_mm: f64,
    },
}

impl Tool {
    /// The smallest cutter radius accepted \[mm\].
    pub const MIN_RADIUS_MM: f64 = 0.001;
    /// The largest cutter radius accepted \[mm\].
    pub const MAX_RADIUS_MM: f64 = 1000.0;

    /// A ball of radius 1 mm, for places where no number depends on the cutter.
    pub const UNIT_BALL: Self = Self { radius: Length::from_mm(1.0), corner_radius: Length::from_mm(1.0) };

    /// A tool of cutter radius R and corner radius r.
    ///
    /// # Errors
    /// R is not in [0.001, 1000] mm, or r is not in [0, R].
    pub fn new(radius: Length, corner_radius: Length) -> Result<Self, ToolFault> {
        let (radius_mm, corner_radius_mm) = (radius.mm(), corner_radius.mm());
        let (min_mm, max_mm) = (Self::MIN_RADIUS_MM, Self::MAX_RADIUS_MM);
        if !(min_mm..=max_mm).contains(&radius_mm) {
            return Err(ToolFault::Radius { radius_mm, min_mm, max_mm });
        }
        if !(0.0..=radius_mm).contains(&corner_radius_mm) {
            return Err(ToolFault::CornerRadius { corner_radius_mm, radius_mm });
        }
        Ok(Self { radius, corner_radius })
    }

    /// Cutter radius R.
    #[must_use]
    pub fn radius(&self) -> Length {
        self.radius
    }

    /// Corner radius r.
    #[must_use]
    pub fn corner_radius(&self) -> Length {
        self.corner_radius
    }

    /// R − r: the radius of the circle on which the corner's centres lie; 0 for a ball.
    #[must_use]
    pub fn core_radius(&self) -> Length {
        self.radius - self.corner_radius
    }

    /// Whether the end is a full ball.
    #[must_use]
    pub fn is_ball(&self) -> bool {
        self.radius == self.corner_radius
    }
}
