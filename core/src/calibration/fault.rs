//! Why a run is not evaluated.

use thiserror::Error;

use crate::units::UM_PER_MM;

/// One reason why a ball-bar run is not evaluated. Tests and readings are counted from 0; `test: None` is the
/// spindle step.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum RunFault {
    /// The bar's length is no bar's.
    #[error("the bar's length {length_mm} mm is not between {min_mm} and {max_mm} mm")]
    BarLength {
        /// Given \[mm\].
        length_mm: f64,
        /// Least \[mm\].
        min_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// The tool's length is negative or absurd.
    #[error("the tool length {length_mm} mm is not between 0 and {max_mm} mm")]
    ToolLength {
        /// The test.
        test: usize,
        /// Given \[mm\].
        length_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// The instrument's uncertainty is negative or absurd.
    #[error("the instrument's uncertainty {} um is not between 0 and {} um", value_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    InstrumentUncertainty {
        /// Given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// A component of the set-up error is absurd.
    #[error("a set-up error of {} um is not between -{} and {} um", value_mm * UM_PER_MM, max_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    SetupError {
        /// 0 `e_xs`, 1 `e_ys`.
        component: usize,
        /// Given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// No test, or too many.
    #[error("a run has 1 to {max} tests, this one has {tests}")]
    TestCount {
        /// Given.
        tests: usize,
        /// Most.
        max: usize,
    },
    /// The machine has no such axis.
    #[error("the machine has {axes} rotary axes, none with index {index}")]
    NoSuchAxis {
        /// The test.
        test: usize,
        /// Given.
        index: usize,
        /// How many there are.
        axes: usize,
    },
    /// A ball too far away.
    #[error("a ball coordinate of {value_mm} mm is not between -{max_mm} and {max_mm} mm")]
    Ball {
        /// The test.
        test: usize,
        /// 0 x, 1 y, 2 z.
        component: usize,
        /// Given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// The weight of a test is none.
    #[error("a reading's standard uncertainty of {value} is not between {min} and {max}")]
    ReadingUncertainty {
        /// The test.
        test: usize,
        /// Given.
        value: f64,
        /// Least.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// An eccentricity too large.
    #[error("an eccentricity of {} um is not between -{} and {} um", value_mm * UM_PER_MM, max_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    Eccentricity {
        /// The test.
        test: usize,
        /// 0 or 1.
        component: usize,
        /// Given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// An angle too large.
    #[error("an angle of {angle_deg} degrees is more than a thousand turns")]
    Angle {
        /// The test.
        test: Option<usize>,
        /// The reading.
        reading: usize,
        /// Given \[deg\].
        angle_deg: f64,
    },
    /// A change of length that no bar measures.
    #[error("a change of length of {} um is not between -{} and {} um: a bar measures about 1 mm either way", value_mm * UM_PER_MM, max_mm * UM_PER_MM, max_mm * UM_PER_MM)]
    LengthChange {
        /// The test.
        test: Option<usize>,
        /// The reading.
        reading: usize,
        /// Given \[mm\].
        value_mm: f64,
        /// Largest \[mm\].
        max_mm: f64,
    },
    /// Too few different angles.
    #[error("{angles} different angles; a circle with its offset takes at least {min}")]
    TooFewAngles {
        /// The test.
        test: Option<usize>,
        /// Different ones.
        angles: usize,
        /// Least.
        min: usize,
    },
    /// More readings than a run may have.
    #[error("{readings} readings in all; a run has at most {max}")]
    TooManyReadings {
        /// Given.
        readings: usize,
        /// Most.
        max: usize,
    },
    /// The readings see none of the errors.
    #[error("these tests determine none of the location errors")]
    NothingDetermined,
    /// The fit runs out of bounds: the readings are no machine's.
    #[error("no location errors within {max_mm} mm and {max_rad} rad explain the readings")]
    NoFit {
        /// Largest translation taken for real \[mm\].
        max_mm: f64,
        /// Largest rotation taken for real \[rad\].
        max_rad: f64,
    },
}
