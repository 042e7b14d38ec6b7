//! A rotary axis from a sphere. Centres probed at several angles of one axis give its direction and a point of it;
//! lines of the axes give the machine's location errors.
//!
//! With unknown angles: [`fit_circle`]. With known angles and any number of spheres: [`fit_rotation`]. Then
//! [`location_errors`]. A whole run at once: [`identify_spheres`].

mod axis_fit;
mod circle;
mod fault;
mod identify;
mod location;
mod outliers;
mod rotation;
mod symmetric;

pub use axis_fit::{AxisFit, Ball, ExpectedAxis, Residual, SphereReading};
pub use circle::fit_circle;
pub use fault::{LocationFault, SphereFault};
pub use identify::{AxisCenters, Center, SphereIdentified, SphereRunFault, identify_spheres};
pub use location::location_errors;
pub use outliers::Outlier;
pub use rotation::fit_rotation;
