//! Why an analytic surface makes no sense.

use thiserror::Error;

/// Which size of a surface a fault is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceQuantity {
    /// Where the surface stands.
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

/// Why an analytic surface makes no sense; every bound is in the message.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SurfaceFault {
    /// A length that is not one of a real surface.
    #[error("{value_mm:e} mm is not between {min_mm:e} mm and {max_mm:e} mm")]
    Length {
        /// Which size.
        quantity: SurfaceQuantity,
        /// Its value \[mm\].
        value_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// An angle that is not one of this surface.
    #[error("{} deg is not between {} deg and {} deg", value_rad.to_degrees(), min_rad.to_degrees(), max_rad.to_degrees())]
    Angle {
        /// Which angle.
        quantity: SurfaceQuantity,
        /// Its value \[rad\].
        value_rad: f64,
        /// Smallest accepted \[rad\].
        min_rad: f64,
        /// Largest accepted \[rad\].
        max_rad: f64,
    },
    /// A blade's edge thicker than the blade.
    #[error("an edge of radius {radius_mm} mm is thicker than the blade: at most {max_mm} mm")]
    EdgeTooThick {
        /// Which edge.
        quantity: SurfaceQuantity,
        /// Its radius \[mm\].
        radius_mm: f64,
        /// Half the largest thickness \[mm\].
        max_mm: f64,
    },
    /// A blade that grows thicker faster than any profile can: the radius changes by more than the way along the
    /// camber line.
    #[error(
        "half the thickness changes by {slope} per unit of camber line: at most {max_slope}; lengthen it"
    )]
    TooSteep {
        /// Largest change of half the thickness, per length.
        slope: f64,
        /// Largest accepted.
        max_slope: f64,
    },
    /// A camber line so bent that the hollow side of the blade would fold.
    #[error("a camber line of radius {camber_radius_mm} mm folds the hollow side: at least {min_mm} mm")]
    CamberTooTight {
        /// Its radius \[mm\].
        camber_radius_mm: f64,
        /// The smallest radius at this thickness \[mm\].
        min_mm: f64,
    },
}

/// Lengths taken for real \[mm\].
pub(super) const LENGTHS_MM: [f64; 2] = [1e-3, 1e4];
/// Coordinates taken for real \[mm\].
const MAX_PLACE_MM: f64 = 1e5;

/// Collects what is wrong with the sizes of one surface.
#[derive(Debug, Default)]
pub(super) struct SizeCheck {
    faults: Vec<SurfaceFault>,
}

impl SizeCheck {
    /// A length must be one of a real surface.
    pub(super) fn length(&mut self, quantity: SurfaceQuantity, value_mm: f64) {
        let [min_mm, max_mm] = LENGTHS_MM;
        if !(min_mm..=max_mm).contains(&value_mm) {
            self.faults.push(SurfaceFault::Length { quantity, value_mm, min_mm, max_mm });
        }
    }

    /// An angle must lie in its range.
    pub(super) fn angle(&mut self, quantity: SurfaceQuantity, value_rad: f64, [min_rad, max_rad]: [f64; 2]) {
        if !(min_rad..=max_rad).contains(&value_rad) {
            self.faults.push(SurfaceFault::Angle { quantity, value_rad, min_rad, max_rad });
        }
    }

    /// A place must be within reach of a machine.
    pub(super) fn place(&mut self, place_mm: crate::geometry::Vec3) {
        for value_mm in place_mm.iter().copied() {
            if !(-MAX_PLACE_MM..=MAX_PLACE_MM).contains(&value_mm) {
                let (min_mm, max_mm) = (-MAX_PLACE_MM, MAX_PLACE_MM);
                let quantity = SurfaceQuantity::Position;
                self.faults.push(SurfaceFault::Length { quantity, value_mm, min_mm, max_mm });
            }
        }
    }

    /// Anything else.
    pub(super) fn push(&mut self, fault: SurfaceFault) {
        self.faults.push(fault);
    }

    /// Whether nothing is wrong so far.
    pub(super) fn is_clean(&self) -> bool {
        self.faults.is_empty()
    }

    /// The surface, or all that is wrong with it.
    pub(super) fn finish<S>(self, surface: S) -> Result<S, Vec<SurfaceFault>> {
        if self.faults.is_empty() { Ok(surface) } else { Err(self.faults) }
    }
}
