//! A rotary axis as a line in space: a screw of zero pitch.

use super::{Mat3, Vec3, rotation_from_vector, trig};

/// A line with a direction: unit `direction` through `point_mm`. The turn by θ about it is `exp(θ ξ)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screw {
    /// Unit direction of the line.
    pub direction: Vec3,
    /// Any point of the line \[mm\].
    pub point_mm: Vec3,
}

impl Screw {
    /// The rotation part of `exp(θ ξ)`.
    #[must_use]
    pub fn rotation(&self, angle_rad: f64) -> Mat3 {
        let d = self.direction;
        let (sin, cos) = trig::sin_cos(angle_rad);
        Mat3::identity() * cos + d * d.transpose() * (1.0 - cos) + d.cross_matrix() * sin
    }

    /// The direction `v` turned by θ about the line's direction (Rodrigues).
    #[must_use]
    pub fn turn(&self, angle_rad: f64, v: Vec3) -> Vec3 {
        self.turn_by(trig::sin_cos(angle_rad), v)
    }

    /// [`Screw::turn`] with sine and cosine of the angle given.
    #[must_use]
    pub fn turn_by(&self, (sin, cos): (f64, f64), v: Vec3) -> Vec3 {
        let d = self.direction;
        let along = d * d.dot(&v);
        along + (v - along) * cos + d.cross(&v) * sin
    }

    /// The point `p_mm` carried along by `exp(θ ξ)`.
    #[must_use]
    pub fn carry(&self, angle_rad: f64, p_mm: Vec3) -> Vec3 {
        self.carry_by(trig::sin_cos(angle_rad), p_mm)
    }

    /// [`Screw::carry`] with sine and cosine of the angle given.
    #[must_use]
    pub fn carry_by(&self, sin_cos: (f64, f64), p_mm: Vec3) -> Vec3 {
        self.turn_by(sin_cos, p_mm - self.point_mm) + self.point_mm
    }

    /// This line displaced by a rigid motion: rotated by `rotation`, then shifted by `shift_mm` (the adjoint
    /// action on a zero-pitch screw).
    #[must_use]
    pub fn displaced(&self, rotation: &Mat3, shift_mm: Vec3) -> Self {
        Self {
            direction: (rotation * self.direction).normalize(),
            point_mm: rotation * self.point_mm + shift_mm,
        }
    }
}

/// A rigid motion p ↦ `rotation`·p + `shift_mm`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidMotion {
    /// Rotation part.
    pub rotation: Mat3,
    /// Image of the origin \[mm\].
    pub shift_mm: Vec3,
}

impl RigidMotion {
    /// No motion.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: Mat3::identity(), shift_mm: Vec3::zeros() }
    }

    /// A rotation vector taken about `about_mm`, followed by a translation.
    #[must_use]
    pub fn small(translation_mm: Vec3, rotation_vector_rad: Vec3, about_mm: Vec3) -> Self {
        let rotation = rotation_from_vector(rotation_vector_rad);
        Self { rotation, shift_mm: about_mm - rotation * about_mm + translation_mm }
    }

    /// First `inner`, then this motion.
    #[must_use]
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            shift_mm: self.rotation * inner.shift_mm + self.shift_mm,
        }
    }
}
