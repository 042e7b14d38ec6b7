//! Why sphere centres give no axis, and lines no location errors.

use thiserror::Error;

/// One reason why sphere centres do not determine an axis. Readings are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SphereFault {
    /// Fewer centres than a circle has unknowns, or more than are taken.
    #[error("{count} sphere centres were given; {min} to {max} are taken")]
    ReadingCount {
        /// Given.
        count: usize,
        /// Least.
        min: usize,
        /// Most.
        max: usize,
    },
    /// Fewer angles than determine an axis.
    #[error("the spheres stood at {count} different angles; at least {min} are needed")]
    TooFewAngles {
        /// Different ones, whole turns apart counted once.
        count: usize,
        /// Least.
        min: usize,
    },
    /// NaN, infinite or absurdly large.
    #[error("reading {reading}: a coordinate of {value_mm:e} mm is not between -{max_mm} and {max_mm} mm")]
    Coordinate {
        /// Index of the reading.
        reading: usize,
        /// 0 x, 1 y, 2 z.
        component: usize,
        /// Given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// NaN, infinite or absurdly large.
    #[error("reading {reading}: an angle of {angle_rad:e} rad is not between -{max_rad} and {max_rad} rad")]
    Angle {
        /// Index of the reading.
        reading: usize,
        /// Given \[rad\].
        angle_rad: f64,
        /// Largest \[rad\].
        max_rad: f64,
    },
    /// The sphere did not move.
    #[error(
        "all centres lie within {spread_mm} mm of each other's mean: the sphere did not move; {min_mm} mm are needed"
    )]
    SamePoint {
        /// Largest distance from the mean \[mm\].
        spread_mm: f64,
        /// Least \[mm\].
        min_mm: f64,
    },
    /// The centres lie on a straight line, or too little off one to tell a plane from scatter.
    #[error(
        "the centres lie on a straight line: {across_mm} mm off it, {along_mm} mm along it, {scatter_mm} mm out of their plane (root mean square)"
    )]
    OnALine {
        /// Root mean square across the line, in the plane \[mm\].
        across_mm: f64,
        /// Root mean square along the line \[mm\].
        along_mm: f64,
        /// Root mean square out of the plane \[mm\].
        scatter_mm: f64,
    },
    /// The sphere stands on the axis, whose direction it then does not show.
    #[error(
        "the sphere stands {radius_mm} mm from the axis; at least {min_mm} mm are needed to see its direction"
    )]
    OnAxis {
        /// Radius of the circle \[mm\].
        radius_mm: f64,
        /// Least \[mm\].
        min_mm: f64,
    },
    /// Directions of the unknowns that the readings do not see.
    #[error("the readings determine {rank} of the {unknowns} unknowns of the axis")]
    Undetermined {
        /// How many are determined.
        rank: usize,
        /// Two tilts and two offsets.
        unknowns: usize,
    },
    /// The axis found is not the one expected.
    #[error(
        "the axis found stands {angle_rad} rad from the nominal one, more than {max_rad} rad: another axis turned, or the coordinates are not those of the machine"
    )]
    DirectionFar {
        /// Angle between the lines \[rad\].
        angle_rad: f64,
        /// Largest \[rad\].
        max_rad: f64,
    },
    /// The angles run against the nominal direction.
    #[error(
        "the spheres turn against the stated angles: {as_stated_mm} mm are left as stated, {reversed_mm} mm with all signs changed (root mean square); does the control count this axis the other way?"
    )]
    SenseReversed {
        /// Root mean square of what is left with the angles as stated \[mm\].
        as_stated_mm: f64,
        /// The same with reversed angles \[mm\].
        reversed_mm: f64,
    },
}

/// One reason why lines give no location errors. Axes are counted as in the profile.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LocationFault {
    /// No line: a number that is not finite or absurd, or a direction without length.
    #[error(
        "axis {axis}: the line is none: a number is not finite or too large, or its direction has no length"
    )]
    NoLine {
        /// Index of the axis.
        axis: usize,
    },
    /// Too far from the nominal direction to be an error of it.
    #[error(
        "axis {axis}: the line stands {angle_rad} rad from its nominal direction, more than {max_rad} rad"
    )]
    DirectionFar {
        /// Index of the axis.
        axis: usize,
        /// Angle between both, senses counted \[rad\].
        angle_rad: f64,
        /// Largest \[rad\].
        max_rad: f64,
    },
    /// The two lines are parallel.
    #[error("the two lines are parallel")]
    Parallel,
    /// An error larger than a profile takes for real.
    #[error(
        "axis {axis}: location error component {component} would be {value} [mm or rad], beyond {max_abs}: is the nominal point the right one?"
    )]
    TooLarge {
        /// Index of the axis.
        axis: usize,
        /// 0–2 `e_x e_y e_z`, 3–5 `e_a e_b e_c`.
        component: usize,
        /// Its value \[mm or rad\].
        value: f64,
        /// Largest taken for real \[mm or rad\].
        max_abs: f64,
    },
}
