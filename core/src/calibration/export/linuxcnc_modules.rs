//! The public kinematics modules of `LinuxCNC` that can hold a five-axis machine, as rows of data.

use crate::geometry::{Screw, Vec3};
use crate::machine::{RotaryLetter, Side};

/// A kinematics module: its axes, the machine axis about which each turns, their directions, and the effect of its
/// pins.
///
/// Sources, read as formulas and described in our own words (no code is taken over): repository
/// `LinuxCNC/linuxcnc`, `src/emc/kinematics/trtfuncs.c` (both `trt` modules),
/// `src/hal/components/xyzab_tdr_kins.comp`, `src/emc/kinematics/5axiskins.c`; the manual's chapter "5-Axis
/// Kinematics" (`docs/src/motion/5-axis-kinematics.adoc`) for the offsets, the direction and the tool's length;
/// pull request 3482 for `conventional-directions`, issue 2435 for the directions, pull request 2320 for
/// `xyzab_tdr_kins`.
///
/// w is the tip in the workpiece, and q the words of X Y Z, without tool lengths:
///
/// - `trt`: `q = p₁ + R₁(p₂ − p₁ + R_C(w − p₂))` with p₂ = `rot-point` on C and p₁ = `rot-point` + `offset` on the tilting
///   axis; the tool length (`tool-offset`) only moves Z to the tip. R turns by the word, not by its negative, which is
///   opposite to ISO 841, unless `conventional-directions` is set.
/// - `xyzab_tdr_kins`: `w = p₂ + R_A(p₁ − p₂ + R_B(q − p₁))` with `rot-point` = p₁ on B, p₂ = p₁ + (0, 0,
///   `z-offset`) on A (its y is that of `rot-point`); both words as ISO 841. Its `x-offset` cancels out.
/// - `5axiskins`: `w = q + (0, 0, L) + L·(sin B cos C, sin B sin C, −cos B)`, L = `pivot-length`: C as ISO 841, B opposite.
///
/// `maxkins` (head B, table C) is left out: it adds the head's displacement without turning it by C, so no machine
/// of this crate moves like it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinuxCncModule {
    /// `xyzac-trt-kins`: table A on the bed carries table C.
    XyzacTrt,
    /// `xyzbc-trt-kins`: table B on the bed carries table C.
    XyzbcTrt,
    /// `xyzab_tdr_kins`: table B on the bed carries table A.
    XyzabTdr,
    /// `5axiskins`: head C under the ram carries head B, both through one point of the spindle's line.
    FiveAxis,
}

/// The directions in which a module counts its two axes; +1 is ISO 841.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Senses {
    /// Only these.
    Fixed([f64; 2]),
    /// Both in the same way: as ISO 841 with the pin `conventional-directions`, otherwise opposite.
    Alike,
}

impl LinuxCncModule {
    /// All modules.
    pub const ALL: [Self; 4] = [Self::XyzacTrt, Self::XyzbcTrt, Self::XyzabTdr, Self::FiveAxis];

    /// The name by which it is loaded, and the prefix of its pins.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::XyzacTrt => "xyzac-trt-kins",
            Self::XyzbcTrt => "xyzbc-trt-kins",
            Self::XyzabTdr => "xyzab_tdr_kins",
            Self::FiveAxis => "5axiskins",
        }
    }

    /// Letters, in the order of a profile.
    pub(super) const fn letters(self) -> [RotaryLetter; 2] {
        use RotaryLetter::{A, B, C};
        match self {
            Self::XyzacTrt => [A, C],
            Self::XyzbcTrt => [B, C],
            Self::XyzabTdr => [B, A],
            Self::FiveAxis => [C, B],
        }
    }

    /// Side of both axes.
    pub(super) const fn side(self) -> Side {
        match self {
            Self::FiveAxis => Side::Head,
            _ => Side::Table,
        }
    }

    /// Directions that the module assumes to be exact.
    pub(super) fn directions(self) -> [Vec3; 2] {
        self.letters().map(|letter| match letter {
            RotaryLetter::A => Vec3::x(),
            RotaryLetter::B => Vec3::y(),
            RotaryLetter::C => Vec3::z(),
        })
    }

    pub(super) const fn senses(self) -> Senses {
        match self {
            Self::XyzacTrt | Self::XyzbcTrt => Senses::Alike,
            Self::XyzabTdr => Senses::Fixed([1.0, 1.0]),
            Self::FiveAxis => Senses::Fixed([1.0, -1.0]),
        }
    }

    /// Name of the pin for the tool's length, if there is one.
    pub(super) const fn tool_pin(self) -> Option<&'static str> {
        match self {
            Self::XyzacTrt | Self::XyzbcTrt => Some("tool-offset"),
            Self::XyzabTdr => Some("tool-offset-z"),
            Self::FiveAxis => None,
        }
    }

    /// Pins and their values \[mm\] for axes through these points, in the profile's order.
    pub(super) fn pins(self, points_mm: [Vec3; 2]) -> Vec<(&'static str, f64)> {
        let [first, second] = points_mm;
        let rot_point = |p: Vec3| [("x-rot-point", p.x), ("y-rot-point", p.y), ("z-rot-point", p.z)];
        let mut pins = Vec::with_capacity(5);
        match self {
            Self::XyzacTrt => {
                pins.extend(rot_point(second));
                pins.extend([("y-offset", first.y - second.y), ("z-offset", first.z - second.z)]);
            }
            Self::XyzbcTrt => {
                pins.extend(rot_point(second));
                pins.extend([("x-offset", first.x - second.x), ("z-offset", first.z - second.z)]);
            }
            Self::XyzabTdr => {
                pins.extend(rot_point(Vec3::new(first.x, second.y, first.z)));
                pins.push(("z-offset", second.z - first.z));
            }
            Self::FiveAxis => pins.push(("pivot-length", second.z)),
        }
        pins
    }

    /// The lines with which the module moves if its pins have these values; the inverse of [`Self::pins`].
    pub(super) fn lines(self, pins: &[(&'static str, f64)]) -> [Screw; 2] {
        let pin = |name: &str| pins.iter().find(|(pin, _)| *pin == name).map_or(0.0, |(_, value)| *value);
        let rot_point = Vec3::new(pin("x-rot-point"), pin("y-rot-point"), pin("z-rot-point"));
        let offset = Vec3::new(pin("x-offset"), pin("y-offset"), pin("z-offset"));
        let points = match self {
            Self::XyzacTrt | Self::XyzbcTrt => [rot_point + offset, rot_point],
            Self::XyzabTdr => [rot_point, rot_point + offset],
            Self::FiveAxis => [Vec3::z() * pin("pivot-length"); 2],
        };
        let directions = self.directions();
        std::array::from_fn(|k| Screw { direction: directions[k], point_mm: points[k] })
    }
}
