//! Questions of a metrologist about a run that can be evaluated.

use super::identify::Outlier;
use super::{BallBarRun, BallBarTest, Observed};
use crate::machine::Machine;

/// A fact that makes a run less trustworthy than its numbers show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RunWarning {
    /// The axis turned one way only: play and friction do not show.
    SingleSweep {
        /// The test.
        test: usize,
    },
    /// One sweep has the same angle twice.
    DuplicateAngle {
        /// The test.
        test: usize,
        /// The second reading at that angle.
        reading: usize,
        /// The angle \[deg\], kinematic.
        angle_deg: f64,
    },
    /// The readings cover only a small part of a turn.
    SmallArc {
        /// The test.
        test: usize,
        /// From the smallest to the largest angle \[deg\].
        arc_deg: f64,
    },
    /// Readings outside the axis' travel.
    OutsideTravel {
        /// The test.
        test: usize,
        /// Number of readings.
        readings: usize,
    },
    /// All values are so small that they may be mm given in a field for µm.
    SuspiciouslySmall {
        /// Largest magnitude \[mm\].
        largest_mm: f64,
    },
    /// The values exceed the range of a ball bar.
    SuspiciouslyLarge {
        /// Largest magnitude \[mm\].
        largest_mm: f64,
    },
    /// The axis is on the head, and the ball is at the gauge point: no tool length was given.
    NoToolLength {
        /// The test.
        test: usize,
    },
    /// Readings left out as outliers.
    OutliersLeftOut {
        /// The test.
        test: usize,
        /// Number of readings.
        readings: usize,
    },
    /// Many readings of a test were left out, so the others may be the wrong ones.
    ManyOutliers {
        /// The test.
        test: usize,
        /// Number of readings left out.
        left_out: usize,
        /// Number of readings in the test.
        readings: usize,
    },
    /// The tests hardly separate some errors.
    IllConditioned {
        /// Condition number.
        condition_number: f64,
    },
}

/// An arc below this is small \[deg\].
const SMALL_ARC_DEG: f64 = 90.0;
/// A sweep is at least this far in one direction \[deg\]. A shorter motion is the axis settling.
const SWEEP_DEG: f64 = 5.0;
/// Magnitudes below this are not plausible for a machine \[mm\]: half the repeatability of a good machine.
const SMALL_MM: f64 = 0.5e-3;
/// Range of common ball bars either way \[mm\].
const BAR_RANGE_MM: f64 = 1.0;
/// One reading in this number, or more, left out is many. If a third agree in a wrong value, the fit may side
/// with them.
const MANY_OUTLIERS: usize = 5;
/// Tests of a good plan stay below 10.
const ILL_CONDITION: f64 = 1000.0;

/// All warnings of a run.
pub(super) fn warnings(
    machine: &Machine,
    run: &BallBarRun,
    outliers: &[Outlier],
    condition_number: f64,
) -> Vec<RunWarning> {
    let mut warnings = Vec::new();
    let mut largest_mm = 0.0_f64;
    for (index, test) in run.tests.iter().enumerate() {
        match &test.observed {
            Observed::Readings(readings) => {
                for reading in readings {
                    largest_mm = largest_mm.max(reading.length_change_mm.abs());
                }
                of_angles(machine, index, test, &mut warnings);
            }
            Observed::Eccentricity(pair_mm) => {
                largest_mm = pair_mm.iter().fold(largest_mm, |largest, value| largest.max(value.abs()));
            }
        }
        if !test.on_table(machine) && test.tool_length_mm == 0.0 {
            warnings.push(RunWarning::NoToolLength { test: index });
        }
        let readings = outliers.iter().filter(|outlier| outlier.test == index).count();
        if readings > 0 {
            warnings.push(RunWarning::OutliersLeftOut { test: index, readings });
        }
        let all = test.readings().len();
        if MANY_OUTLIERS * readings > all {
            warnings.push(RunWarning::ManyOutliers { test: index, left_out: readings, readings: all });
        }
    }
    if largest_mm < SMALL_MM {
        warnings.push(RunWarning::SuspiciouslySmall { largest_mm });
    }
    if largest_mm > BAR_RANGE_MM {
        warnings.push(RunWarning::SuspiciouslyLarge { largest_mm });
    }
    if condition_number > ILL_CONDITION {
        warnings.push(RunWarning::IllConditioned { condition_number });
    }
    warnings
}

fn of_angles(machine: &Machine, index: usize, test: &BallBarTest, warnings: &mut Vec<RunWarning>) {
    let angles_deg: Vec<f64> = test.readings().iter().map(|reading| reading.angle_rad.to_degrees()).collect();
    let (least, largest) =
        angles_deg.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, largest), angle| {
            (least.min(*angle), largest.max(*angle))
        });
    if largest - least < SMALL_ARC_DEG {
        warnings.push(RunWarning::SmallArc { test: index, arc_deg: largest - least });
    }
    if sweeps(&angles_deg) < 2 {
        warnings.push(RunWarning::SingleSweep { test: index });
    }
    if let Some(reading) = duplicate(&angles_deg) {
        let angle_deg = angles_deg[reading];
        warnings.push(RunWarning::DuplicateAngle { test: index, reading, angle_deg });
    }
    let axis = &machine.rotary_axes()[test.axis];
    if let Some(travel) = axis.travel_deg {
        /// Rounding of a word converted to radians and back \[deg\].
        const ROUNDING_DEG: f64 = 1e-9;
        let outside = test
            .readings()
            .iter()
            .filter(|reading| !travel.contains(axis.word_deg(reading.angle_rad), ROUNDING_DEG))
            .count();
        if outside > 0 {
            warnings.push(RunWarning::OutsideTravel { test: index, readings: outside });
        }
    }
}

/// Number of sweeps in one direction, without settling.
fn sweeps(angles_deg: &[f64]) -> usize {
    let Some(first) = angles_deg.first() else { return 0 };
    let (mut sweeps, mut sense, mut turning_deg) = (0, 0.0, *first);
    for angle in angles_deg {
        let way = angle - turning_deg;
        if sense != 0.0 && way * sense > 0.0 {
            turning_deg = *angle;
        } else if way.abs() >= SWEEP_DEG {
            sense = way.signum();
            turning_deg = *angle;
            sweeps += 1;
        }
    }
    sweeps
}

/// The first reading at the angle of the one before it, if the axis did not reverse between them.
fn duplicate(angles_deg: &[f64]) -> Option<usize> {
    let same_deg = BallBarRun::SAME_ANGLE_RAD.to_degrees();
    (1..angles_deg.len()).find(|index| {
        let (before, here) = (angles_deg[index - 1], angles_deg[*index]);
        let came = index.checked_sub(2).and_then(|earlier| angles_deg.get(earlier)).map(|angle| here - angle);
        let goes = angles_deg.get(index + 1).map(|angle| angle - here);
        let turns_back = came.zip(goes).is_some_and(|(came, goes)| came * goes < 0.0);
        (here - before).abs() < same_deg && !turns_back
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_are_counted_by_turning_points() {
        let there: Vec<f64> = (0..37).map(|k| f64::from(k) * 10.0).collect();
        let back: Vec<f64> = there.iter().rev().copied().collect();
        assert_eq!(sweeps(&there), 1);
        assert_eq!(sweeps(&[there.clone(), back.clone()].concat()), 2);
        assert_eq!(sweeps(&[there.clone(), back, there].concat()), 3);
        assert_eq!(sweeps(&[0.0, 0.01, -0.01]), 0);
    }

    #[test]
    fn an_angle_twice_in_one_sweep_is_seen_and_at_the_turning_point_is_not() {
        assert_eq!(duplicate(&[0.0, 10.0, 10.0, 20.0]), Some(2));
        assert_eq!(duplicate(&[0.0, 10.0, 20.0, 20.0, 10.0, 0.0]), None);
        assert_eq!(duplicate(&[0.0, 10.0, 20.0]), None);
    }
}
