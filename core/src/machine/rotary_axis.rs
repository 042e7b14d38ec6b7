//! One rotary axis: its line, its side, its travel, its counting direction.

use super::LocationError;
use crate::geometry::{Screw, Vec3};

/// The address letter of a rotary axis (ISO 841).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RotaryLetter {
    /// Nominally about X.
    A,
    /// Nominally about Y.
    B,
    /// Nominally about Z.
    C,
}

impl RotaryLetter {
    /// The letter as in a program.
    #[must_use]
    pub const fn as_char(self) -> char {
        match self {
            Self::A => 'A',
            Self::B => 'B',
            Self::C => 'C',
        }
    }
}

/// Whether an axis carries the workpiece or the tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Between bed and workpiece.
    Table,
    /// Between ram and tool.
    Head,
}

/// The range of an axis word, both ends included, in degrees or millimetres as the field name says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Smallest word.
    pub min: f64,
    /// Largest word.
    pub max: f64,
}

impl Travel {
    /// A word of a program that lies outside the travel by no more is at its end: controls round words to their
    /// decimals \[mm or deg\].
    pub const WORD_SLACK: f64 = 1e-6;

    /// Whether `word` lies within the travel, widened by `slack` at both ends.
    #[must_use]
    pub fn contains(&self, word: f64, slack: f64) -> bool {
        word >= self.min - slack && word <= self.max + slack
    }
}

/// A rotary axis of the profile. Its nominal line and its measured errors are separate.
#[derive(Debug, Clone, PartialEq)]
pub struct RotaryAxis {
    /// Address letter.
    pub letter: RotaryLetter,
    /// Workpiece or tool side.
    pub side: Side,
    /// Nominal unit direction in M.
    pub direction: Vec3,
    /// Reference point on the nominal line: in M \[mm\] for a table axis, relative to the zero-pose gauge point
    /// for a head axis.
    pub point_mm: Vec3,
    /// Range of the NC word \[deg\]; `None` turns without limit.
    pub travel_deg: Option<Travel>,
    /// Whether the control counts in the direction opposite to ISO 841.
    pub reversed: bool,
    /// Measured displacement of the axis' own frame.
    pub location_error: LocationError,
}

impl RotaryAxis {
    /// The kinematic angle θ \[rad\] that the NC word `word_deg` commands.
    #[must_use]
    pub fn angle_rad(&self, word_deg: f64) -> f64 {
        if self.reversed { -word_deg.to_radians() } else { word_deg.to_radians() }
    }

    /// The NC word \[deg\] that commands the kinematic angle `angle_rad`.
    #[must_use]
    pub fn word_deg(&self, angle_rad: f64) -> f64 {
        if self.reversed { -angle_rad.to_degrees() } else { angle_rad.to_degrees() }
    }

    /// The nominal line.
    #[must_use]
    pub fn nominal_screw(&self) -> Screw {
        Screw { direction: self.direction, point_mm: self.point_mm }
    }
}
