//! Vectors, rotations and screws: arithmetic without any knowledge of machines.

mod angles;
mod circle;
mod great_circle;
mod plane_frame;
mod plane_path;
mod screw;
pub mod trig;
pub(crate) mod trig_lanes;
mod turn;

pub use angles::{angle_about, angle_between, shortest_turn_rad, wrap_rad};
pub use circle::AxisCircle;
pub use great_circle::GreatCircle;
pub use plane_frame::PlaneFrame;
pub use plane_path::{Corner, PlaneCircle, PlanePiece};
pub use screw::{RigidMotion, Screw};
pub use turn::{MAX_SLANT, Turn};

/// A vector or point; the name of the variable says frame and unit.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A rotation or a linear map of [`Vec3`].
pub type Mat3 = nalgebra::Matrix3<f64>;

/// The rotation whose rotation vector is `rotation_vector_rad` (Rodrigues; direction times angle).
///
/// A zero vector gives the identity exactly.
#[must_use]
pub fn rotation_from_vector(rotation_vector_rad: Vec3) -> Mat3 {
    let angle_rad = rotation_vector_rad.norm();
    if angle_rad == 0.0 {
        return Mat3::identity();
    }
    let axis = rotation_vector_rad / angle_rad;
    let (sin, cos) = trig::sin_cos(angle_rad);
    Mat3::identity() * cos + axis.cross_matrix() * sin + axis * axis.transpose() * (1.0 - cos)
}

/// The component of `v` across the unit vector `axis`.
#[must_use]
pub fn across(v: Vec3, axis: Vec3) -> Vec3 {
    v - axis * v.dot(&axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_those_of_the_platform_but_for_rounding() {
        /// Rounding of a handful of operations on numbers up to 1.
        const ROUNDING: f64 = 1e-15;
        assert_eq!(rotation_from_vector(Vec3::zeros()), Mat3::identity());
        for size in [1e-12, 1e-5, 0.05, 1.0, 3.0, 7.0] {
            let vector_rad = Vec3::new(0.6, -0.7, 0.3) * size;
            let rotation = rotation_from_vector(vector_rad);
            assert!(
                (rotation - nalgebra::Rotation3::new(vector_rad).into_inner()).norm() < ROUNDING,
                "{size}"
            );
            assert!((rotation * rotation.transpose() - Mat3::identity()).norm() < ROUNDING, "{size}");
        }
    }
}
