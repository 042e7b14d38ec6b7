//! A surface turned and shifted.

use super::{ParametricSurface, SurfaceDerivatives};
use crate::geometry::RigidMotion;

/// A surface that a rigid motion has moved in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed<S> {
    /// The surface before the motion.
    pub surface: S,
    /// The motion.
    pub motion: RigidMotion,
}

impl<S: ParametricSurface> ParametricSurface for Placed<S> {
    fn domain(&self) -> [[f64; 2]; 2] {
        self.surface.domain()
    }

    fn derivatives(&self, parameters: [f64; 2]) -> SurfaceDerivatives {
        let (found, turn) = (self.surface.derivatives(parameters), self.motion.rotation);
        SurfaceDerivatives {
            point_mm: turn * found.point_mm + self.motion.shift_mm,
            by_u: turn * found.by_u,
            by_v: turn * found.by_v,
            by_uu: turn * found.by_uu,
            by_uv: turn * found.by_uv,
            by_vv: turn * found.by_vv,
        }
    }
}
