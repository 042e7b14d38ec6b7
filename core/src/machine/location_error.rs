//! Location errors of rotary axes and squareness of linear ones.

use crate::geometry::{Mat3, RigidMotion, Vec3, rotation_from_vector};

/// A small rigid displacement of a rotary axis' own frame, in M. The rotation vector is taken about the axis'
/// reference point, and everything outboard moves along (cascaded; shared notation §1 "Location errors").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocationError {
    /// `(e_x, e_y, e_z)` \[mm\].
    pub translation_mm: Vec3,
    /// `(e_a, e_b, e_c)`, a rotation vector \[rad\].
    pub rotation_rad: Vec3,
}

impl Default for LocationError {
    fn default() -> Self {
        Self { translation_mm: Vec3::zeros(), rotation_rad: Vec3::zeros() }
    }
}

impl LocationError {
    /// The displacement of a frame whose axis has its reference point at `point_mm`.
    #[must_use]
    pub fn displacement(&self, point_mm: Vec3) -> RigidMotion {
        RigidMotion::small(self.translation_mm, self.rotation_rad, point_mm)
    }
}

/// Squareness of the linear axes (ISO 230-1 letters). X is the reference.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Squareness {
    /// `E_C0Y`: Y turned about Z \[rad\].
    pub e_c0y_rad: f64,
    /// `E_B0Z`: Z turned about Y \[rad\].
    pub e_b0z_rad: f64,
    /// `E_A0Z`: Z turned about X \[rad\].
    pub e_a0z_rad: f64,
}

impl Squareness {
    /// The matrix S whose columns are the real directions of X, Y and Z: `[X, Rz(E_C0Y)·Y, R(E_A0Z, E_B0Z)·Z]`.
    /// Without errors it is exactly the identity.
    #[must_use]
    pub fn matrix(&self) -> Mat3 {
        let y = rotation_from_vector(Vec3::z() * self.e_c0y_rad) * Vec3::y();
        let z = rotation_from_vector(Vec3::new(self.e_a0z_rad, self.e_b0z_rad, 0.0)) * Vec3::z();
        Mat3::from_columns(&[Vec3::x(), y, z])
    }
}
