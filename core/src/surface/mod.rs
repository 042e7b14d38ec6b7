//! Nominal surfaces of a part in W: points with normals, analytic surfaces, samples spread evenly over them.

mod asking;
mod blade;
mod blade_profile;
mod cylinder;
mod fault;
mod mesh;
mod mesh_fault;
mod mesh_samples;
mod nearest;
mod pace;
mod parametric;
mod placed;
mod plane;
mod saddle;
mod samples;
mod smoothing;
mod sphere;
mod stl;
mod stl_text;
mod tree;
mod weld;

pub use blade::{Blade, BladeSizes};
pub use cylinder::Cylinder;
pub use fault::{SurfaceFault, SurfaceQuantity};
pub use mesh::{Mesh, MeshReport, MeshSettings};
pub use mesh_fault::{MAX_FACETS, MeshFault, MeshParameter, StlFault};
pub use nearest::MeshPoint;
pub(crate) use nearest::nearest_weights;
pub use pace::{Pace, Uncounted};
pub use parametric::{Bulge, ParametricSurface, SurfaceDerivatives, SurfacePoint};
pub use placed::Placed;
pub use plane::Plane;
pub use saddle::Saddle;
pub use samples::EvenSamples;
pub use sphere::Sphere;
pub use stl::{STL_HEADER_BYTES, stl_facets_at_most};

#[cfg(test)]
mod tests;
