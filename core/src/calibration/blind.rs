//! The errors that a run cannot distinguish, and the further run that can.

use nalgebra::DMatrix;

use super::decomposition::Decomposition;
use super::eccentricity::reachable_turns;
use super::observations::{Observations, Predicted};
use super::parameters::MovedLines;
use super::prediction::TestModel;
use super::{BallBarRun, BallBarTest, BarDirection, ErrorParameter, Observed, Unknown};
use crate::geometry::Vec3;
use crate::machine::{LocationError, Machine, Side};
use crate::units::UM_PER_MM;

/// A combination of unknowns that changes no reading, or only the offsets of readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Blind {
    /// Share of each unknown \[µm or µrad\]; the largest is 1.
    pub parts: Vec<(Unknown, f64)>,
    /// Tests whose offset, the zero of the bar, is part of the combination.
    pub offsets: Vec<usize>,
    /// The ball-bar test that would separate the parts, if there is one.
    pub separated_by: Option<FurtherRun>,
}

/// A run that a metrologist can add.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FurtherRun {
    /// The bar read at several spindle angles, both axes at zero.
    SpindleStep,
    /// One additional test.
    Test {
        /// The turning axis.
        axis: usize,
        /// The bar's direction.
        bar: BarDirection,
        /// The programmed spindle ball \[mm\].
        ball_mm: Vec3,
        /// Distance from the gauge point to the ball \[mm\]; used if the axis is on the head.
        tool_length_mm: f64,
    },
}

/// Parts of a combination below this share of the largest are rounding.
const PART: f64 = 1e-6;
/// A further run must show a combination at least this well \[µm of reading per µm or µrad\].
const SEEN_UM: f64 = 0.01;
/// Additional length of a proposed tool \[mm\], for an axis on the head.
const LONGER_MM: f64 = 100.0;
/// Proposed ball positions, besides those of the run \[mm\]: a good plan has C tests far out, A tests high.
const FURTHER_BALLS_MM: [[f64; 3]; 3] = [[150.0, 0.0, 60.0], [150.0, 0.0, 160.0], [0.0, 150.0, 60.0]];

/// The combinations of `unknowns` that `counted` does not determine, each with as few parts as elimination leaves.
/// `at_zero` is the model's prediction of the observations without errors.
pub(super) fn blind_combinations(
    machine: &Machine,
    run: &BallBarRun,
    unknowns: &[Unknown],
    counted: &Decomposition,
    observations: &Observations,
    at_zero: &Predicted,
) -> Vec<Blind> {
    let basis = counted.unscaled_blind();
    if basis.ncols() == 0 {
        return Vec::new();
    }
    let natural = DMatrix::from_fn(basis.ncols(), basis.nrows(), |row, column| {
        basis[(column, row)] * unknowns[column].told_per_unit()
    });
    let parameters: Vec<ErrorParameter> = unknowns
        .iter()
        .filter_map(|unknown| match unknown {
            Unknown::Error(parameter) => Some(*parameter),
            Unknown::SetupError(_) => None,
        })
        .collect();
    let mut combinations = Vec::new();
    for row in reduced(natural).row_iter() {
        let parts: Vec<(Unknown, f64)> =
            unknowns.iter().copied().zip(row.iter().copied()).filter(|(_, part)| *part != 0.0).collect();
        // In the units of the slopes, for 1 µm or µrad.
        let change: Vec<f64> =
            unknowns.iter().zip(row.iter()).map(|(unknown, part)| part / unknown.told_per_unit()).collect();
        let offsets = observations
            .blocks
            .iter()
            .filter(|block| block.offset)
            .filter_map(|block| {
                let sum: f64 = (block.first..block.first + block.rows)
                    .map(|row| at_zero.slopes.row(row).iter().zip(&change).map(|(s, c)| s * c).sum::<f64>())
                    .sum();
                let mean_um = sum / block.rows as f64 * UM_PER_MM;
                block.test.filter(|_| mean_um.abs() > PART)
            })
            .collect();
        let separated_by = further_run(machine, run, &parameters, &change);
        combinations.push(Blind { parts, offsets, separated_by });
    }
    combinations
}

/// Combines rows so that each has a leading part that no other row has, scaled to a largest part of 1.
fn reduced(mut rows: DMatrix<f64>) -> DMatrix<f64> {
    let mut leads = Vec::new();
    for row in 0..rows.nrows() {
        let mut lead = (0, 0.0_f64);
        for column in (0..rows.ncols()).filter(|column| !leads.contains(column)) {
            if rows[(row, column)].abs() > lead.1.abs() {
                lead = (column, rows[(row, column)]);
            }
        }
        if lead.1 == 0.0 {
            continue;
        }
        leads.push(lead.0);
        for other in 0..rows.nrows() {
            if other != row {
                let factor = rows[(other, lead.0)] / lead.1;
                for column in 0..rows.ncols() {
                    let taken = rows[(row, column)] * factor;
                    rows[(other, column)] -= taken;
                }
            }
        }
    }
    for mut row in rows.row_iter_mut() {
        let largest = row
            .iter()
            .fold(0.0_f64, |largest, part| if part.abs() > largest.abs() { *part } else { largest });
        for part in row.iter_mut() {
            *part = if part.abs() > PART * largest.abs() { *part / largest } else { 0.0 };
        }
    }
    rows
}

/// The run that shows a change of the unknowns best. The set-up error's own run comes first.
fn further_run(
    machine: &Machine,
    run: &BallBarRun,
    parameters: &[ErrorParameter],
    change: &[f64],
) -> Option<FurtherRun> {
    if change.iter().skip(parameters.len()).any(|part| *part != 0.0) {
        return Some(FurtherRun::SpindleStep);
    }
    let lines = MovedLines::new(machine, &[LocationError::default(); 2]);
    let nominal = machine.screws(false);
    let mut best = (SEEN_UM, None);
    for test in further_tests(machine, run) {
        let model = TestModel::new(machine, run, &test);
        let mut slopes = vec![0.0; parameters.len() + 2];
        let seen: Vec<f64> = reachable_turns(&machine.rotary_axes()[test.axis])
            .into_iter()
            .map(|turn| {
                model.reading(turn, &lines, &nominal, Vec3::zeros(), parameters, &mut slopes);
                slopes.iter().zip(change).map(|(slope, change)| slope * change).sum::<f64>() * UM_PER_MM
            })
            .collect();
        let mean_um = seen.iter().sum::<f64>() / seen.len() as f64;
        let squares = seen.iter().map(|value| (value - mean_um).powi(2)).sum::<f64>();
        let rms_um = (squares / seen.len() as f64).sqrt();
        // Better by more than rounding, so that the first of equal runs is proposed.
        if rms_um > best.0 * (1.0 + PART) {
            let BallBarTest { axis, bar, ball_mm, tool_length_mm, .. } = test;
            best = (rms_um, Some(FurtherRun::Test { axis, bar, ball_mm, tool_length_mm }));
        }
    }
    best.1
}

/// Tests that could be added: every axis and direction of the bar, at the balls of the run and a few others. A head
/// axis also gets the tools of the run and a longer one.
fn further_tests(machine: &Machine, run: &BallBarRun) -> Vec<BallBarTest> {
    let mut places: Vec<(Vec3, f64)> =
        run.tests.iter().map(|test| (test.ball_mm, test.tool_length_mm)).collect();
    let longest_mm = run.tests.iter().map(|test| test.tool_length_mm).fold(0.0, f64::max);
    places.extend(FURTHER_BALLS_MM.map(|ball_mm| (Vec3::from(ball_mm), longest_mm)));
    if machine.rotary_axes().iter().any(|axis| axis.side == Side::Head) {
        let longer: Vec<_> = places.iter().map(|(ball_mm, _)| (*ball_mm, longest_mm + LONGER_MM)).collect();
        places.extend(longer);
    }
    let mut tests = Vec::new();
    for axis in 0..2 {
        for bar in BarDirection::ALL {
            for (ball_mm, tool_length_mm) in places.iter().copied() {
                let observed = Observed::Readings(Vec::new());
                tests.push(BallBarTest {
                    axis,
                    bar,
                    ball_mm,
                    tool_length_mm,
                    reading_uncertainty: 1.0,
                    observed,
                });
            }
        }
    }
    tests
}
