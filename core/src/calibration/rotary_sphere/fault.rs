//! Why sphere centres do not give an axis, or lines do not give location errors.

use thiserror::Error;

/// One reason why sphere centres do not determine an axis. Readings are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SphereFault {
    /// Fewer centres than a circle has unknowns, or more than the limit.
    #[error("the number of sphere centres is {count}, but it must be {min} to {max}")]
    ReadingCount {
        /// Number given.
        count: usize,
        /// Smallest number.
        min: usize,
        /// Largest number.
        max: usize,
    },
    /// Fewer angles than determine an axis.
    #[error(
        "the spheres were probed at {count} different angles, but at least {min} are needed; probe more angles"
    )]
    TooFewAngles {
        /// Number of different angles, without whole turns.
        count: usize,
        /// Smallest number.
        min: usize,
    },
    /// NaN, infinite or too large.
    #[error("reading {reading}: a coordinate of {value_mm:e} mm is not between -{max_mm} and {max_mm} mm")]
    Coordinate {
        /// Index of the reading.
        reading: usize,
        /// 0 x, 1 y, 2 z.
        component: usize,
        /// The coordinate given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// NaN, infinite or too large.
    #[error("reading {reading}: an angle of {angle_rad:e} rad is not between -{max_rad} and {max_rad} rad")]
    Angle {
        /// Index of the reading.
        reading: usize,
        /// The angle given \[rad\].
        angle_rad: f64,
        /// Largest \[rad\].
        max_rad: f64,
    },
    /// The sphere did not move.
    #[error(
        "the sphere did not move: all centres are within {spread_mm} mm of their mean; at least {min_mm} mm are needed. Turn the axis between readings"
    )]
    SamePoint {
        /// Largest distance from the mean \[mm\].
        spread_mm: f64,
        /// Smallest \[mm\].
        min_mm: f64,
    },
    /// The centres lie on a straight line, or too near to one to distinguish a plane from scatter.
    #[error(
        "the centres lie on a straight line: {across_mm} mm off it, {along_mm} mm along it, {scatter_mm} mm out of their plane (root mean square). Probe over a larger arc"
    )]
    OnALine {
        /// Root mean square across the line, in the plane \[mm\].
        across_mm: f64,
        /// Root mean square along the line \[mm\].
        along_mm: f64,
        /// Root mean square out of the plane \[mm\].
        scatter_mm: f64,
    },
    /// The sphere is on the axis, so it does not show the axis' direction.
    #[error(
        "the sphere is {radius_mm} mm from the axis; at least {min_mm} mm are needed to find its direction. Move the sphere outward"
    )]
    OnAxis {
        /// Radius of the circle \[mm\].
        radius_mm: f64,
        /// Smallest \[mm\].
        min_mm: f64,
    },
    /// The readings do not determine all unknowns.
    #[error(
        "the readings determine only {rank} of the {unknowns} unknowns of the axis; probe more angles, or a sphere farther from the axis"
    )]
    Undetermined {
        /// Number of determined unknowns.
        rank: usize,
        /// Two tilts and two offsets.
        unknowns: usize,
    },
    /// The axis found is not the expected one.
    #[error(
        "the axis found is {angle_rad} rad from the nominal one, more than the limit of {max_rad} rad: another axis turned, or the coordinates are not those of the machine"
    )]
    DirectionFar {
        /// Angle between the lines \[rad\].
        angle_rad: f64,
        /// Largest \[rad\].
        max_rad: f64,
    },
    /// The angles increase against the nominal direction.
    #[error(
        "the spheres turn against the stated angles: the residual is {as_stated_mm} mm as stated, and {reversed_mm} mm with all signs changed (root mean square). Check whether the control counts this axis in the opposite direction"
    )]
    SenseReversed {
        /// Root mean square residual with the angles as stated \[mm\].
        as_stated_mm: f64,
        /// Root mean square residual with reversed angles \[mm\].
        reversed_mm: f64,
    },
}

/// One reason why lines do not give location errors. Axes are counted as in the profile.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LocationFault {
    /// Not a valid line: a number is not finite or too large, or the direction has no length.
    #[error(
        "axis {axis}: the line is not valid: a number is not finite or too large, or its direction has no length"
    )]
    NoLine {
        /// Index of the axis.
        axis: usize,
    },
    /// Too far from the nominal direction to be a location error.
    #[error(
        "axis {axis}: the line is {angle_rad} rad from its nominal direction, more than the limit of {max_rad} rad"
    )]
    DirectionFar {
        /// Index of the axis.
        axis: usize,
        /// Angle between both directions, 0 to π \[rad\].
        angle_rad: f64,
        /// Largest \[rad\].
        max_rad: f64,
    },
    /// The two lines are parallel.
    #[error(
        "the two lines are parallel, so they give no location errors; check which axis turned in each run"
    )]
    Parallel,
    /// An error larger than a profile accepts.
    #[error(
        "axis {axis}: location error component {component} would be {value} [mm or rad], beyond the limit of {max_abs}. Check the nominal point"
    )]
    TooLarge {
        /// Index of the axis.
        axis: usize,
        /// 0–2 `e_x e_y e_z`, 3–5 `e_a e_b e_c`.
        component: usize,
        /// Its value \[mm or rad\].
        value: f64,
        /// Largest accepted \[mm or rad\].
        max_abs: f64,
    },
}
