//! Vectors, rotations and screws: arithmetic that knows no machine.

mod angles;
mod great_circle;
mod screw;
pub mod trig;

pub use angles::{angle_about, angle_between, wrap_rad};
pub use great_circle::GreatCircle;
pub use screw::{RigidMotion, Screw};

/// A vector or point; the name of the variable says frame and unit.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A rotation or a linear map of [`Vec3`].
pub type Mat3 = nalgebra::Matrix3<f64>;

/// The rotation whose rotation vector is `rotation_vector_rad` (Rodrigues; direction times angle).
///
/// A zero vector gives the identity exactly.
#[must_use]
pub fn rotation_from_vector(rotation_vector_rad: Vec3) -> Mat3 {
    nalgebra::Rotation3::new(rotation_vector_rad).into_inner()
}

/// The component of `v` across the unit vector `axis`.
#[must_use]
pub fn across(v: Vec3, axis: Vec3) -> Vec3 {
    v - axis * v.dot(&axis)
}
