//! A ball-bar run as measured.

use super::RunFault;
use super::angles::different_angles;
use crate::geometry::{Vec3, across};
use crate::machine::{Machine, RotaryLetter, Side};

/// The direction of the bar at the start of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum BarDirection {
    /// Across the axis: x for C, z for A and B.
    Radial,
    /// Across the axis and the radial direction: y for A and C, x for B.
    Tangential,
    /// Along the axis.
    Axial,
}

/// Sine below which a direction is nearly along an axis: 6°.
const NEARLY_ALONG: f64 = 0.1;

impl BarDirection {
    /// Every direction.
    pub const ALL: [Self; 3] = [Self::Radial, Self::Tangential, Self::Axial];

    /// The name of the direction.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Radial => "radial",
            Self::Tangential => "tangential",
            Self::Axial => "axial",
        }
    }

    /// Unit vector at zero from the ball on the table to the ball on the spindle. On an axis that is not parallel
    /// to X, Y or Z, the named direction is projected across the axis.
    #[must_use]
    pub fn unit(self, letter: RotaryLetter, axis: Vec3) -> Vec3 {
        let (radial, tangential) = match letter {
            RotaryLetter::A => (Vec3::z(), Vec3::y()),
            RotaryLetter::B => (Vec3::z(), Vec3::x()),
            RotaryLetter::C => (Vec3::x(), Vec3::y()),
        };
        // An axis along its own radial direction (a B axis that points in z) takes the tangential one instead.
        let radial = across(radial, axis);
        let radial = if radial.norm() < NEARLY_ALONG { across(tangential, axis) } else { radial }.normalize();
        match self {
            Self::Radial => radial,
            Self::Axial => axis,
            Self::Tangential => {
                let side = axis.cross(&radial);
                if side.dot(&tangential) < 0.0 { -side } else { side }
            }
        }
    }
}

/// One reading of the bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Kinematic angle of the axis \[rad\].
    pub angle_rad: f64,
    /// Bar length minus its length at the start, longer positive \[mm\].
    pub length_change_mm: f64,
}

/// The result of a test.
#[derive(Debug, Clone, PartialEq)]
pub enum Observed {
    /// Every reading.
    Readings(Vec<Reading>),
    /// The eccentricities alone \[mm\]: (x, y) of a C axis, (y, z) of an A axis, (z, x) of a B axis.
    Eccentricity([f64; 2]),
}

/// One rotary axis turned with the ball held by RTCP, the other axes' words at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct BallBarTest {
    /// The turning axis, in the profile's order.
    pub axis: usize,
    /// Direction of the bar at zero.
    pub bar: BarDirection,
    /// The programmed spindle ball at zero, from the reference point of the table axis next to the workpiece \[mm\].
    pub ball_mm: Vec3,
    /// Distance from the gauge point to the spindle ball along the tool axis \[mm\]; used if an axis is on the
    /// head.
    pub tool_length_mm: f64,
    /// Standard uncertainty of one reading \[µm\], relative to the other tests' (its weight is 1/u²). It is 1
    /// unless tests differ.
    pub reading_uncertainty: f64,
    /// The readings.
    pub observed: Observed,
}

/// The offset of the spindle ball from the spindle's line, at spindle angle zero.
#[derive(Debug, Clone, PartialEq)]
pub enum SetupError {
    /// Known `(e_xs, e_ys)` \[mm\].
    Known([f64; 2]),
    /// Measured by turning the spindle at zero of both axes.
    Spindle(SpindleStep),
    /// Not known: held at zero, and the hidden effects are reported.
    Unknown,
}

/// Readings at several spindle angles, both rotary axes at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct SpindleStep {
    /// Unit vector from the ball on the table to the ball on the spindle.
    pub bar: Vec3,
    /// The readings; the angle is the spindle's, positive about +z.
    pub readings: Vec<Reading>,
}

/// All tests of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct BallBarRun {
    /// Length L of the bar at the start \[mm\].
    pub bar_length_mm: f64,
    /// Whether the bar's zero is arbitrary: one offset per test is then fitted.
    pub offset_per_test: bool,
    /// Standard uncertainty of the instrument, if it contributes to the result \[mm\].
    pub instrument_uncertainty_mm: Option<f64>,
    /// Knowledge of the spindle ball's offset.
    pub setup_error: SetupError,
    /// The tests.
    pub tests: Vec<BallBarTest>,
}

impl BallBarRun {
    /// Most tests of a run.
    pub const MAX_TESTS: usize = 64;
    /// Most readings of a run, all tests together.
    pub const MAX_READINGS: usize = 100_000;
    /// Shortest and longest bar \[mm\].
    pub const BAR_LENGTH_RANGE_MM: [f64; 2] = [10.0, 5000.0];
    /// Farthest ball from the axis' reference point, and longest tool \[mm\].
    pub const MAX_DISTANCE_MM: f64 = 1e4;
    /// Largest change of length accepted \[mm\]: ten times the range of common ball bars.
    pub const MAX_CHANGE_MM: f64 = 10.0;
    /// Largest angle of an axis \[rad\]: a thousand turns.
    pub const MAX_ANGLE_RAD: f64 = 1000.0 * std::f64::consts::TAU;
    /// Fewest different angles of a test: three numbers, offset, sine and cosine, describe its circle.
    pub const MIN_ANGLES: usize = 3;
    /// Smallest and largest standard uncertainty of a reading. Beyond this ratio, rounding of the best test hides
    /// the weakest test's weight, and effects that only the weakest test shows would count as not seen.
    pub const READING_UNCERTAINTY_RANGE: [f64; 2] = [1e-3, 1e3];
    /// Angles closer than this are the same angle \[rad\]: 0.001°.
    pub const SAME_ANGLE_RAD: f64 = 1.745e-5;

    /// Checks every number.
    ///
    /// # Errors
    /// Every fault found.
    pub fn check(&self, machine: &Machine) -> Result<(), Vec<RunFault>> {
        let mut faults = Vec::new();
        let [min_mm, max_mm] = Self::BAR_LENGTH_RANGE_MM;
        if !(min_mm..=max_mm).contains(&self.bar_length_mm) {
            faults.push(RunFault::BarLength { length_mm: self.bar_length_mm, min_mm, max_mm });
        }
        let max_mm = Self::MAX_CHANGE_MM;
        if let Some(value_mm) = self.instrument_uncertainty_mm
            && !(0.0..=max_mm).contains(&value_mm)
        {
            faults.push(RunFault::InstrumentUncertainty { value_mm, max_mm });
        }
        match &self.setup_error {
            SetupError::Known(error_mm) => {
                for (component, value_mm) in error_mm.iter().copied().enumerate() {
                    if !(-max_mm..=max_mm).contains(&value_mm) {
                        faults.push(RunFault::SetupError { component, value_mm, max_mm });
                    }
                }
            }
            SetupError::Spindle(step) => check_readings(None, &step.readings, &mut faults),
            SetupError::Unknown => {}
        }
        let (tests, max) = (self.tests.len(), Self::MAX_TESTS);
        if !(1..=max).contains(&tests) {
            faults.push(RunFault::TestCount { tests, max });
            return Err(faults);
        }
        for (test, described) in self.tests.iter().enumerate() {
            described.check(test, machine, &mut faults);
        }
        let (readings, max) = (self.readings(), Self::MAX_READINGS);
        if readings > max {
            faults.push(RunFault::TooManyReadings { readings, max });
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// Number of readings, all tests together.
    #[must_use]
    pub fn readings(&self) -> usize {
        self.tests.iter().map(|test| test.readings().len()).sum()
    }
}

impl BallBarTest {
    /// The readings; empty if only eccentricities are known.
    #[must_use]
    pub fn readings(&self) -> &[Reading] {
        match &self.observed {
            Observed::Readings(readings) => readings,
            Observed::Eccentricity(_) => &[],
        }
    }

    /// Whether the axis is on the table.
    pub(super) fn on_table(&self, machine: &Machine) -> bool {
        machine.rotary_axes()[self.axis].side == Side::Table
    }

    fn check(&self, test: usize, machine: &Machine, faults: &mut Vec<RunFault>) {
        let axes = machine.rotary_axes().len();
        if self.axis >= axes {
            faults.push(RunFault::NoSuchAxis { test, index: self.axis, axes });
        }
        for component in 0..3 {
            let (value_mm, max_mm) = (self.ball_mm[component], BallBarRun::MAX_DISTANCE_MM);
            if !(-max_mm..=max_mm).contains(&value_mm) {
                faults.push(RunFault::Ball { test, component, value_mm, max_mm });
            }
        }
        let max_mm = BallBarRun::MAX_DISTANCE_MM;
        if !(0.0..=max_mm).contains(&self.tool_length_mm) {
            faults.push(RunFault::ToolLength { test, length_mm: self.tool_length_mm, max_mm });
        }
        let [min, max] = BallBarRun::READING_UNCERTAINTY_RANGE;
        if !(min..=max).contains(&self.reading_uncertainty) {
            faults.push(RunFault::ReadingUncertainty { test, value: self.reading_uncertainty, min, max });
        }
        match &self.observed {
            Observed::Readings(readings) => check_readings(Some(test), readings, faults),
            Observed::Eccentricity(values_mm) => {
                for (component, value_mm) in values_mm.iter().copied().enumerate() {
                    let max_mm = BallBarRun::MAX_CHANGE_MM;
                    if !(-max_mm..=max_mm).contains(&value_mm) {
                        faults.push(RunFault::Eccentricity { test, component, value_mm, max_mm });
                    }
                }
            }
        }
    }
}

fn check_readings(test: Option<usize>, readings: &[Reading], faults: &mut Vec<RunFault>) {
    let before = faults.len();
    for (reading, value) in readings.iter().enumerate() {
        let max_rad = BallBarRun::MAX_ANGLE_RAD;
        if !(-max_rad..=max_rad).contains(&value.angle_rad) {
            faults.push(RunFault::Angle { test, reading, angle_deg: value.angle_rad.to_degrees() });
        }
        let max_mm = BallBarRun::MAX_CHANGE_MM;
        if !(-max_mm..=max_mm).contains(&value.length_change_mm) {
            faults.push(RunFault::LengthChange { test, reading, value_mm: value.length_change_mm, max_mm });
        }
    }
    let angles_rad = readings.iter().map(|reading| reading.angle_rad);
    let (angles, min) = (different_angles(angles_rad, BallBarRun::SAME_ANGLE_RAD), BallBarRun::MIN_ANGLES);
    // Angles that are not numbers are not counted.
    if faults.len() == before && angles < min {
        faults.push(RunFault::TooFewAngles { test, angles, min });
    }
}
