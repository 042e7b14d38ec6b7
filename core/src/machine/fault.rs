//! The faults of a machine profile, as facts with numbers.

use thiserror::Error;

use crate::units::legible;

/// A number-bearing field of one rotary axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisField {
    /// Component of the direction.
    Direction(usize),
    /// Component of the reference point.
    Point(usize),
    /// One end of the travel: 0 lower, 1 upper.
    Travel(usize),
    /// Component of the location error: 0–2 `e_x e_y e_z`, 3–5 `e_a e_b e_c`.
    LocationError(usize),
}

/// A number-bearing field of the profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProfileField {
    /// A field of the rotary axis with this index.
    Axis(usize, AxisField),
    /// Linear axis 0–2 and end 0–1 of its travel.
    LinearTravel(usize, usize),
    /// 0 `e_c0y`, 1 `e_b0z`, 2 `e_a0z`.
    Squareness(usize),
    /// The interpolation period.
    InterpolationPeriod,
}

/// Which axis a travel belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Rotary axis by index.
    Rotary(usize),
    /// Linear axis by index, X Y Z.
    Linear(usize),
}

/// One reason why a profile does not describe a five-axis machine.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum MachineFault {
    /// Not exactly two rotary axes.
    #[error("a five-axis machine has two rotary axes, this profile has {count}; list exactly two")]
    AxisCount {
        /// Number of rotary axes given.
        count: usize,
    },
    /// Two axes of the same letter.
    #[error("rotary axis {index} repeats the letter {letter}; give each axis its own letter")]
    RepeatedLetter {
        /// Index of the second one.
        index: usize,
        /// The letter.
        letter: char,
    },
    /// NaN, infinite or too large.
    #[error("{} is not a finite number of magnitude at most {max_abs}", legible(.value))]
    Absurd {
        /// The field.
        field: ProfileField,
        /// The value given.
        value: f64,
        /// Largest magnitude accepted, in the field's own unit.
        max_abs: f64,
    },
    /// A direction without length.
    #[error("direction of rotary axis {index} has length {length}; it must be above {min_length}")]
    ZeroDirection {
        /// Index of the axis.
        index: usize,
        /// Length given.
        length: f64,
        /// Smallest length accepted.
        min_length: f64,
    },
    /// The lower end is not below the upper end.
    #[error("travel from {min} to {max} is empty: its lower end must be below its upper end")]
    TravelUpsideDown {
        /// The axis of the travel.
        motion: Motion,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// The two rotary axes are parallel, so that they cannot point the tool.
    #[error("the rotary axes are parallel within {angle_deg}°; at least {min_deg}° is needed")]
    ParallelRotaries {
        /// Angle between the lines, 0–90 \[deg\].
        angle_deg: f64,
        /// Smallest angle accepted \[deg\].
        min_deg: f64,
    },
    /// The tool axis lies along the rotary axis next to the tool. That axis only spins the tool.
    #[error(
        "rotary axis {index} cannot tilt the tool: the tool axis is within {angle_deg}° of it; at least {min_deg}° is needed"
    )]
    ToolAlongLastRotary {
        /// Index of the axis in the profile.
        index: usize,
        /// Angle between tool axis and rotary axis, 0–90 \[deg\].
        angle_deg: f64,
        /// Smallest angle accepted \[deg\].
        min_deg: f64,
    },
    /// The interpolation period is not in its range.
    #[error("interpolation period {period_s} s is not between {min_s} s and {max_s} s")]
    InterpolationPeriod {
        /// The period given \[s\].
        period_s: f64,
        /// Smallest period accepted \[s\].
        min_s: f64,
        /// Largest period accepted \[s\].
        max_s: f64,
    },
}
