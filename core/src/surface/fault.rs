//! Why an analytic surface is not valid.

use thiserror::Error;

use crate::units::legible;

/// The quantity of a surface that has a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceQuantity {
    /// The position of the surface.
    Position,
    /// Length along the first parameter.
    Length,
    /// Width along the second parameter.
    Width,
    /// Radius of a sphere or cylinder.
    Radius,
    /// Radius of curvature of a saddle where it is convex.
    ConvexRadius,
    /// Radius of curvature of a saddle where it is concave.
    ConcaveRadius,
    /// Half the angle that a patch of a sphere or cylinder spans.
    HalfAngle,
    /// Length of a blade's camber line.
    CamberLength,
    /// Angle by which a blade's camber line turns.
    CamberAngle,
    /// Largest thickness of a blade.
    Thickness,
    /// Radius of a blade's leading edge.
    LeadingRadius,
    /// Radius of a blade's trailing edge.
    TrailingRadius,
    /// Span of a blade.
    Span,
    /// Angle by which a blade's profile turns over the span.
    Twist,
}

/// Why an analytic surface is not valid. Every bound is in the message.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SurfaceFault {
    /// A length that is not plausible for a surface.
    #[error("{value_mm:e} mm is not between {min_mm:e} mm and {max_mm:e} mm")]
    Length {
        /// The quantity.
        quantity: SurfaceQuantity,
        /// Its value \[mm\].
        value_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// An angle outside the range of this surface.
    #[error("{} deg is not between {} deg and {} deg", value_rad.to_degrees(), min_rad.to_degrees(), max_rad.to_degrees())]
    Angle {
        /// The angle.
        quantity: SurfaceQuantity,
        /// Its value \[rad\].
        value_rad: f64,
        /// Smallest accepted \[rad\].
        min_rad: f64,
        /// Largest accepted \[rad\].
        max_rad: f64,
    },
    /// A blade's edge thicker than the blade.
    #[error("an edge of radius {} mm is thicker than the blade; it must be at most {max_mm} mm", legible(.radius_mm))]
    EdgeTooThick {
        /// The edge.
        quantity: SurfaceQuantity,
        /// Its radius \[mm\].
        radius_mm: f64,
        /// Half the largest thickness \[mm\].
        max_mm: f64,
    },
    /// A blade whose thickness grows faster than any profile can: the radius changes by more than the distance
    /// along the camber line.
    #[error(
        "half the thickness changes by {slope} per unit of camber line; the limit is {max_slope}. Make the camber line longer"
    )]
    TooSteep {
        /// Largest change of half the thickness, per length.
        slope: f64,
        /// Largest accepted.
        max_slope: f64,
    },
    /// The camber line is bent so much that the hollow side of the blade would fold.
    #[error(
        "a camber line of radius {} mm folds the concave side; the radius must be at least {min_mm} mm", legible(.camber_radius_mm))]
    CamberTooTight {
        /// Its radius \[mm\].
        camber_radius_mm: f64,
        /// The smallest radius at this thickness \[mm\].
        min_mm: f64,
    },
}

/// Accepted lengths \[mm\].
pub(super) const LENGTHS_MM: [f64; 2] = [1e-3, 1e4];
/// Largest accepted coordinate \[mm\].
const MAX_PLACE_MM: f64 = 1e5;

/// Collects the faults of the sizes of one surface.
#[derive(Debug, Default)]
pub(super) struct SizeCheck {
    faults: Vec<SurfaceFault>,
}

impl SizeCheck {
    /// Checks that a length is plausible.
    pub(super) fn length(&mut self, quantity: SurfaceQuantity, value_mm: f64) {
        let [min_mm, max_mm] = LENGTHS_MM;
        if !(min_mm..=max_mm).contains(&value_mm) {
            self.faults.push(SurfaceFault::Length { quantity, value_mm, min_mm, max_mm });
        }
    }

    /// Checks that an angle is in its range.
    pub(super) fn angle(&mut self, quantity: SurfaceQuantity, value_rad: f64, [min_rad, max_rad]: [f64; 2]) {
        if !(min_rad..=max_rad).contains(&value_rad) {
            self.faults.push(SurfaceFault::Angle { quantity, value_rad, min_rad, max_rad });
        }
    }

    /// Checks that a position is within reach of a machine.
    pub(super) fn place(&mut self, place_mm: crate::geometry::Vec3) {
        for value_mm in place_mm.iter().copied() {
            if !(-MAX_PLACE_MM..=MAX_PLACE_MM).contains(&value_mm) {
                let (min_mm, max_mm) = (-MAX_PLACE_MM, MAX_PLACE_MM);
                let quantity = SurfaceQuantity::Position;
                self.faults.push(SurfaceFault::Length { quantity, value_mm, min_mm, max_mm });
            }
        }
    }

    /// Adds any other fault.
    pub(super) fn push(&mut self, fault: SurfaceFault) {
        self.faults.push(fault);
    }

    /// Whether there is no fault so far.
    pub(super) fn is_clean(&self) -> bool {
        self.faults.is_empty()
    }

    /// The surface, or all its faults.
    pub(super) fn finish<S>(self, surface: S) -> Result<S, Vec<SurfaceFault>> {
        if self.faults.is_empty() { Ok(surface) } else { Err(self.faults) }
    }
}
