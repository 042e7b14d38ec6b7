//! The readings of a ball bar at many angles: [`TestModel::reading`], one quantity after the other for a run of angles,
//! so that an instruction works on several angles. Every number is computed as there and has the same bits.

use multiversion::multiversion;

use super::ErrorParameter;
use super::parameters::{MovedLines, ScrewSlope};
use super::prediction::{Control, TestModel};
use crate::geometry::{Screw, Vec3};

/// Angles in a run: few enough for the fastest cache.
const RUN: usize = 64;

/// A vector at each angle of a run, by components.
type Vectors = [[f64; RUN]; 3];

/// The bar at each angle of a run.
struct Bars {
    sin: [f64; RUN],
    cos: [f64; RUN],
    /// From the real line to the ball before it is turned \[mm\].
    arm_mm: Vectors,
    /// The part of the arm along the line \[mm\].
    along_arm_mm: [f64; RUN],
    /// The bar's direction.
    along: Vectors,
}

/// A machine of which readings are predicted: its lines, its control and the set-up error.
pub(super) struct Moved<'a> {
    pub(super) lines: &'a MovedLines,
    pub(super) control: &'a Control,
    pub(super) setup_error_mm: Vec3,
}

impl TestModel {
    /// [`Self::reading`] at many angles, with given sines and cosines. `slopes` are columns as long as `turns`: by each
    /// of `parameters`, then by the two components of the set-up error.
    pub(super) fn readings<'a>(
        &self,
        turns: &[(f64, f64)],
        moved: &Moved<'_>,
        parameters: &[ErrorParameter],
        readings_mm: &mut [f64],
        slopes: impl Iterator<Item = &'a mut [f64]>,
    ) {
        let mut slopes: Vec<&mut [f64]> = slopes.collect();
        let real = self.placed(moved.lines.screws[self.axis]);
        let believed = self.placed(moved.control[self.axis]);
        let mut bars = Bars::new();
        for (run, (turns, readings_mm)) in turns.chunks(RUN).zip(readings_mm.chunks_mut(RUN)).enumerate() {
            for (k, (sin, cos)) in turns.iter().enumerate() {
                (bars.sin[k], bars.cos[k]) = (*sin, *cos);
            }
            turn_bars(self, &real, &believed, moved.setup_error_mm, &mut bars, readings_mm);
            let rows = run * RUN..run * RUN + turns.len();
            let mut columns = slopes.iter_mut().map(|column| &mut column[rows.clone()]);
            for (parameter, column) in parameters.iter().zip(&mut columns) {
                slopes_by_line(&bars, &real, &moved.lines.slope(self.axis, *parameter), column);
            }
            for (component, column) in columns.take(2).enumerate() {
                slopes_by_set_up(&bars, &real, Vec3::ith(component, 1.0), column);
            }
        }
    }
}

impl Bars {
    fn new() -> Self {
        let zeros = [0.0; RUN];
        Self { sin: zeros, cos: zeros, arm_mm: [zeros; 3], along_arm_mm: zeros, along: [zeros; 3] }
    }
}

/// Turns the bar to every angle of the run.
#[multiversion(targets("x86_64+avx2"))]
fn turn_bars(
    model: &TestModel,
    real: &Screw,
    believed: &Screw,
    setup_error_mm: Vec3,
    bars: &mut Bars,
    readings_mm: &mut [f64],
) {
    let at_zero_mm = model.squareness * model.ball_mm + setup_error_mm;
    for (k, reading_mm) in readings_mm.iter_mut().enumerate().take(RUN) {
        let turn = (bars.sin[k], bars.cos[k]);
        let (ball_mm, slides_mm) = if model.on_table {
            let held_mm = believed.carry_by((-turn.0, turn.1), model.ball_mm);
            (model.squareness * held_mm + setup_error_mm, Vec3::zeros())
        } else {
            let slides_mm = model.ball_mm - believed.carry_by(turn, Vec3::zeros());
            (setup_error_mm, model.squareness * slides_mm)
        };
        let arm_mm = ball_mm - real.point_mm;
        let carried_mm = real.point_mm + real.turn_by(turn, arm_mm) + slides_mm;
        let bar_mm = carried_mm - at_zero_mm + model.bar * model.bar_length_mm;
        let length_mm = bar_mm.norm();
        let along = bar_mm / length_mm;
        bars.along_arm_mm[k] = real.direction.dot(&arm_mm);
        for component in 0..3 {
            bars.arm_mm[component][k] = arm_mm[component];
            bars.along[component][k] = along[component];
        }
        *reading_mm = length_mm - model.bar_length_mm;
    }
}

/// The derivatives of the readings by a parameter that moves the line so.
#[multiversion(targets("x86_64+avx2"))]
fn slopes_by_line(bars: &Bars, real: &Screw, line: &ScrewSlope, slopes: &mut [f64]) {
    for (k, slope) in slopes.iter_mut().enumerate().take(RUN) {
        let turn = (bars.sin[k], bars.cos[k]);
        let arm_mm = at(&bars.arm_mm, k);
        let shift = line.point_mm - real.turn_by(turn, line.point_mm);
        let tilt = (line.direction * bars.along_arm_mm[k] + real.direction * line.direction.dot(&arm_mm))
            * (1.0 - turn.1)
            + line.direction.cross(&arm_mm) * turn.0;
        *slope = at(&bars.along, k).dot(&(shift + tilt));
    }
}

/// The derivatives of the readings by a component of the set-up error.
#[multiversion(targets("x86_64+avx2"))]
fn slopes_by_set_up(bars: &Bars, real: &Screw, unit: Vec3, slopes: &mut [f64]) {
    for (k, slope) in slopes.iter_mut().enumerate().take(RUN) {
        let turned = real.turn_by((bars.sin[k], bars.cos[k]), unit);
        *slope = at(&bars.along, k).dot(&(turned - unit));
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn at(vectors: &Vectors, k: usize) -> Vec3 {
    Vec3::new(vectors[0][k], vectors[1][k], vectors[2][k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::{
        BallBarRun, BallBarTest, BarDirection, Observed, SetupError, placing_parameters,
    };
    use crate::machine::{LocationError, Machine, PRESETS};

    fn test(axis: usize, bar: BarDirection) -> BallBarTest {
        BallBarTest {
            axis,
            bar,
            ball_mm: Vec3::new(150.0, -40.0, 60.0),
            tool_length_mm: 120.0,
            reading_uncertainty: 1.0,
            observed: Observed::Readings(Vec::new()),
        }
    }

    #[test]
    fn many_angles_give_the_bits_of_one_at_a_time() {
        for preset in PRESETS {
            let machine = Machine::new(preset.parts()).unwrap();
            let parameters = placing_parameters(&machine);
            let error = LocationError {
                translation_mm: Vec3::new(0.012, -0.021, 0.034),
                rotation_rad: Vec3::new(41e-6, -63e-6, 29e-6),
            };
            let (lines, control) = (MovedLines::new(&machine, &[error; 2]), machine.screws(false));
            let setup_error_mm = Vec3::new(0.003, -0.008, 0.0);
            let moved = Moved { lines: &lines, control: &control, setup_error_mm };
            for (axis, bar) in
                [(0, BarDirection::Radial), (1, BarDirection::Axial), (1, BarDirection::Tangential)]
            {
                let tests = vec![test(axis, bar)];
                let run = BallBarRun {
                    bar_length_mm: 100.0,
                    offset_per_test: true,
                    instrument_uncertainty_mm: None,
                    setup_error: SetupError::Unknown,
                    tests,
                };
                let model = TestModel::new(&machine, &run, &run.tests[0]);
                let turns: Vec<_> = (0..2 * RUN + 7).map(|k| (0.1 * k as f64).sin_cos()).collect();
                let columns = parameters.len() + 2;
                let mut readings_mm = vec![0.0; turns.len()];
                let mut slopes = vec![vec![0.0; turns.len()]; columns];
                let of_columns = slopes.iter_mut().map(Vec::as_mut_slice);
                model.readings(&turns, &moved, &parameters, &mut readings_mm, of_columns);
                for (k, turn) in turns.iter().enumerate() {
                    let mut expected = vec![0.0; columns];
                    let reading =
                        model.reading(*turn, &lines, &control, setup_error_mm, &parameters, &mut expected);
                    assert_eq!(readings_mm[k].to_bits(), reading.to_bits(), "reading {k}");
                    for (column, slope) in slopes.iter().zip(&expected) {
                        assert_eq!(column[k].to_bits(), slope.to_bits(), "slope at {k}");
                    }
                }
            }
        }
    }
}
