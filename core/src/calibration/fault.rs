//! Why a run is not evaluated.

use thiserror::Error;

use crate::units::{UM_PER_MM, legible};

/// One reason why a ball-bar run is not evaluated. Tests and readings are counted from 0; `test: None` is the
/// spindle step.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RunFault {
    /// The bar's length is not plausible.
    #[error(
        "the bar's length {} mm is not between {min_mm} and {max_mm} mm; give the length of the bar at its start", legible(.length_mm))]
    BarLength {
        /// The length given \[mm\].
        length_mm: f64,
        /// Smallest \[mm\].
        min_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// The tool's length is negative or not plausible.
    #[error("the tool length {} mm is not between 0 and {max_mm} mm", legible(.length_mm))]
    ToolLength {
        /// The test.
        test: usize,
        /// The length given \[mm\].
        length_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// The instrument's uncertainty is negative or not plausible.
    #[error("the instrument's uncertainty {} µm is not between 0 and {} µm", value_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    InstrumentUncertainty {
        /// The uncertainty given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// A component of the set-up error is not plausible.
    #[error("a set-up error of {} µm is not between -{} and {} µm", value_mm * UM_PER_MM, max_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    SetupError {
        /// 0 `e_xs`, 1 `e_ys`.
        component: usize,
        /// The value given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// No test, or too many.
    #[error("a run must have 1 to {max} tests, but this one has {tests}")]
    TestCount {
        /// Number given.
        tests: usize,
        /// Largest number.
        max: usize,
    },
    /// The machine has no such axis.
    #[error("the machine has {axes} rotary axes, but none with index {index}; name one of its axes")]
    NoSuchAxis {
        /// The test.
        test: usize,
        /// The index given.
        index: usize,
        /// Number of rotary axes.
        axes: usize,
    },
    /// A ball too far away.
    #[error("a ball coordinate of {} mm is not between -{max_mm} and {max_mm} mm", legible(.value_mm))]
    Ball {
        /// The test.
        test: usize,
        /// 0 x, 1 y, 2 z.
        component: usize,
        /// The coordinate given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// The weight of a test is out of range.
    #[error("a reading's standard uncertainty of {value} is not between {min} and {max}")]
    ReadingUncertainty {
        /// The test.
        test: usize,
        /// The value given.
        value: f64,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// An eccentricity too large.
    #[error("an eccentricity of {} µm is not between -{} and {} µm", value_mm * UM_PER_MM, max_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    Eccentricity {
        /// The test.
        test: usize,
        /// 0 or 1.
        component: usize,
        /// The value given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// An angle too large.
    #[error(
        "an angle of {} degrees is more than a thousand turns, the limit; give angles in degrees", legible(.angle_deg))]
    Angle {
        /// The test.
        test: Option<usize>,
        /// The reading.
        reading: usize,
        /// The angle given \[deg\].
        angle_deg: f64,
    },
    /// A change of length beyond the range of any bar.
    #[error("a change of length of {} µm is not between -{} and {} µm: a bar measures about 1 mm either way", value_mm * UM_PER_MM, max_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    LengthChange {
        /// The test.
        test: Option<usize>,
        /// The reading.
        reading: usize,
        /// The change given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// Too few different angles.
    #[error(
        "the test has {angles} different angles, but a circle with its offset needs at least {min}; add readings"
    )]
    TooFewAngles {
        /// The test.
        test: Option<usize>,
        /// Number of different angles.
        angles: usize,
        /// Smallest number.
        min: usize,
    },
    /// More readings than a run may have.
    #[error("the run has {readings} readings in all, but the limit is {max}; send fewer")]
    TooManyReadings {
        /// Number given.
        readings: usize,
        /// Largest number.
        max: usize,
    },
    /// The readings show none of the errors.
    #[error(
        "these tests determine none of the location errors; add a test of another axis, bar direction or ball position"
    )]
    NothingDetermined,
    /// The fit exceeds its limits: no machine gives these readings.
    #[error(
        "no location errors within {max_mm} mm and {max_rad} rad explain the readings; check their unit, the ball position and the direction of the bar"
    )]
    NoFit {
        /// Largest translation accepted \[mm\].
        max_mm: f64,
        /// Largest rotation accepted \[rad\].
        max_rad: f64,
    },
}
