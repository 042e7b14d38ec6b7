//! Nominal surfaces of a part in W: points with normals, analytic surfaces, samples spread evenly over them.

mod blade;
mod blade_profile;
mod cylinder;
mod fault;
mod parametric;
mod placed;
mod plane;
mod saddle;
mod samples;
mod sphere;

pub use blade::{Blade, BladeSizes};
pub use cylinder::Cylinder;
pub use fault::{SurfaceFault, SurfaceQuantity};
pub use parametric::{Bulge, ParametricSurface, SurfaceDerivatives, SurfacePoint};
pub use placed::Placed;
pub use plane::Plane;
pub use saddle::Saddle;
pub use samples::EvenSamples;
pub use sphere::Sphere;

#[cfg(test)]
mod tests;
