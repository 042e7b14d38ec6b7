//! A surface over two parameters: its point, normal and normal curvature from exact derivatives.

use std::ops::ControlFlow;

use super::asking::Asking;
use super::samples::even_samples;
use super::{EvenSamples, MeshFault};
use crate::geometry::{Vec3, across};

/// A point of a part's nominal surface in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The point \[mm\].
    pub point_mm: Vec3,
    /// Unit normal out of the part.
    pub normal: Vec3,
}

/// The side of a curved surface on which the part lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bulge {
    /// The part is inside: it bulges toward the tool.
    Convex,
    /// The part is outside: the tool sits in the hollow.
    Concave,
}

impl Bulge {
    /// +1 convex, −1 concave.
    pub(super) fn sign(self) -> f64 {
        match self {
            Self::Convex => 1.0,
            Self::Concave => -1.0,
        }
    }
}

/// A point of a parametric surface and its derivatives by the parameters u and v \[mm per unit of parameter\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceDerivatives {
    /// The point \[mm\].
    pub point_mm: Vec3,
    /// ∂p/∂u.
    pub by_u: Vec3,
    /// ∂p/∂v.
    pub by_v: Vec3,
    /// ∂²p/∂u².
    pub by_uu: Vec3,
    /// ∂²p/∂u∂v.
    pub by_uv: Vec3,
    /// ∂²p/∂v².
    pub by_vv: Vec3,
}

impl SurfaceDerivatives {
    /// Unit normal out of the part, ∂p/∂u × ∂p/∂v normalised.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        self.by_u.cross(&self.by_v).normalize()
    }

    /// Normal curvature in a direction \[1/mm\]: second over first fundamental form, positive if the part is
    /// convex. Only the direction's component along the surface counts; without one the result is 0.
    #[must_use]
    pub fn curvature_per_mm(&self, direction: Vec3) -> f64 {
        let normal = self.normal();
        let along = across(direction, normal);
        let (e, f, g) = (self.by_u.norm_squared(), self.by_u.dot(&self.by_v), self.by_v.norm_squared());
        let (p, q) = (along.dot(&self.by_u), along.dot(&self.by_v));
        let determinant = e * g - f * f;
        let (a, b) = ((p * g - q * f) / determinant, (q * e - p * f) / determinant);
        let second = a * a * normal.dot(&self.by_uu)
            + 2.0 * a * b * normal.dot(&self.by_uv)
            + b * b * normal.dot(&self.by_vv);
        let first = along.norm_squared();
        if first > 0.0 { -second / first } else { 0.0 }
    }
}

/// A surface over a rectangle of two parameters u and v, regular everywhere in it: ∂p/∂u × ∂p/∂v points out of the
/// part and is nowhere zero.
pub trait ParametricSurface {
    /// Smallest and largest u, smallest and largest v.
    fn domain(&self) -> [[f64; 2]; 2];

    /// The point at (u, v) of the domain and its exact derivatives.
    fn derivatives(&self, parameters: [f64; 2]) -> SurfaceDerivatives;

    /// The point at (u, v) with its normal.
    fn at(&self, parameters: [f64; 2]) -> SurfacePoint {
        let found = self.derivatives(parameters);
        SurfacePoint { point_mm: found.point_mm, normal: found.normal() }
    }

    /// Normal curvature at (u, v) in a direction of W \[1/mm\], positive if the part is convex.
    fn curvature_per_mm(&self, parameters: [f64; 2], direction: Vec3) -> f64 {
        self.derivatives(parameters).curvature_per_mm(direction)
    }

    /// `count` points spread evenly over the area, always the same ones, in rows of rising v, each of rising u.
    ///
    /// The rows are as far apart as the points in them. Within its row's band each point is shifted by the golden
    /// ratio, so that no pattern of passes coincides with them. Parts of the surface as small as 1/128 of the
    /// domain in each direction are still weighted by their own area.
    fn samples(&self, count: usize) -> EvenSamples {
        self.samples_until(count, &|| ControlFlow::Continue(())).unwrap_or_else(|_never| EvenSamples::none())
    }

    /// The same, until the caller stops.
    ///
    /// # Errors
    /// `stop` broke.
    fn samples_until(
        &self,
        count: usize,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<EvenSamples, MeshFault> {
        even_samples(self, count, &mut Asking::new(stop))
    }
}
