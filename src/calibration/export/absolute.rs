//! Location errors as ISO 230-7 names them: each axis against the machine frame.

use crate::calibration::rotation_vector_rad;
use crate::geometry::{RigidMotion, Vec3};
use crate::machine::{Machine, RotaryLetter};

/// Displacement of one rotary axis against the machine frame M.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AbsoluteError {
    /// The axis.
    pub letter: RotaryLetter,
    /// Translation of the axis' reference point \[mm\]: `E_X0r E_Y0r E_Z0r`.
    pub translation_mm: Vec3,
    /// Rotation vector \[rad\]: `E_A0r E_B0r E_C0r`.
    pub rotation_rad: Vec3,
    /// 0, 1 or 2 where the nominal direction is along X, Y or Z: the components along and about it move no line.
    pub principal: Option<usize>,
}

impl AbsoluteError {
    /// The symbol of a component: 0–2 translations, 3–5 rotations, as in `E_X0C`.
    #[must_use]
    pub fn symbol(&self, component: usize) -> String {
        let of = ['X', 'Y', 'Z', 'A', 'B', 'C'].get(component).copied().unwrap_or('?');
        format!("E_{of}0{}", self.letter.as_char())
    }

    /// Whether a component (0–5) is redundant: along or about the axis' own nominal direction.
    #[must_use]
    pub fn is_redundant(&self, component: usize) -> bool {
        self.principal.is_some_and(|own| component % 3 == own)
    }
}

/// The absolute errors of both axes, in the profile's order: the translation of the axis' reference point, and the
/// rotation vector, under `G_1 … G_r` along its own side's chain (`math.md` §1, last paragraph of "Location errors",
/// without its linearisation).
#[must_use]
pub fn absolute_errors(machine: &Machine) -> [AbsoluteError; 2] {
    let mut chain = [RigidMotion::identity(), RigidMotion::identity()];
    std::array::from_fn(|index| {
        let axis = &machine.rotary_axes()[index];
        let moved = &mut chain[axis.side as usize];
        *moved = moved.after(&axis.location_error.displacement(axis.point_mm));
        AbsoluteError {
            letter: axis.letter,
            translation_mm: moved.rotation * axis.point_mm + moved.shift_mm - axis.point_mm,
            rotation_rad: rotation_vector_rad(&moved.rotation),
            principal: (0..3).find(|&k| (axis.direction[k].abs() - 1.0).abs() < 1e-12),
        }
    })
}
