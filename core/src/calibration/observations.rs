//! The rows of the least-squares problem: the readings, the model's predictions, and their derivatives.

use nalgebra::{DMatrix, DVector};

use super::eccentricity::{Harmonic, HarmonicFit, full_turn};
use super::parameters::MovedLines;
use super::prediction::{Control, TestModel, spindle_reading};
use super::turned_bars::Moved;
use super::{BallBarRun, ErrorParameter, Observed, Reading, SetupError, SpindleStep};
use crate::geometry::{Vec3, trig};
use crate::machine::{LocationError, Machine};

/// Weight of an eccentricity given alone, relative to a reading. P4 takes it as half the difference of two
/// readings; its variance is half a reading's.
const ECCENTRICITY_WEIGHT: f64 = 2.0;

/// Rows that share an offset.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Index of the test; `None` for the spindle step.
    pub(super) test: Option<usize>,
    pub(super) first: usize,
    pub(super) rows: usize,
    /// Whether an offset is fitted.
    pub(super) offset: bool,
    /// Sine and cosine of the angles: of the rows, or of the grid from which two eccentricities follow.
    pub(super) turns: Vec<(f64, f64)>,
    source: Source,
}

#[derive(Debug, Clone)]
enum Source {
    Readings(TestModel),
    Eccentricity(TestModel, HarmonicFit),
    Spindle(Vec3),
}

/// All observations, as rows.
#[derive(Debug, Clone)]
pub(super) struct Observations {
    pub(super) blocks: Vec<Block>,
    /// The readings \[mm\].
    pub(super) values_mm: DVector<f64>,
    /// Square root of each row's weight.
    pub(super) weights: Vec<f64>,
    bar_length_mm: f64,
}

/// Values and slopes of the model in every row.
#[derive(Debug, Clone)]
pub(super) struct Predicted {
    /// \[mm\]
    pub(super) values_mm: DVector<f64>,
    /// One column for each parameter, then `e_xs`, `e_ys`.
    pub(super) slopes: DMatrix<f64>,
}

impl Observations {
    pub(super) fn new(machine: &Machine, run: &BallBarRun) -> Self {
        let (mut blocks, mut values_mm, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        // Only ratios matter. The best test has weight 1, so that distances keep their unit.
        let best = run.tests.iter().map(|test| test.reading_uncertainty).fold(f64::INFINITY, f64::min);
        for (index, test) in run.tests.iter().enumerate() {
            let model = TestModel::new(machine, run, test);
            let weight = best / test.reading_uncertainty;
            let first = values_mm.len();
            let block =
                |rows, offset, turns, source| Block { test: Some(index), first, rows, offset, turns, source };
            match &test.observed {
                Observed::Readings(readings) => {
                    values_mm.extend(readings.iter().map(|reading| reading.length_change_mm));
                    weights.extend(readings.iter().map(|_| weight));
                    let (rows, turns) = (readings.len(), turns(readings));
                    blocks.push(block(rows, run.offset_per_test, turns, Source::Readings(model)));
                }
                Observed::Eccentricity(pair_mm) => {
                    let turns = full_turn();
                    let harmonic = Harmonic::new(&machine.rotary_axes()[test.axis], test.bar);
                    // A full turn determines the harmonic of any axis.
                    let Some(fit) = HarmonicFit::new(&harmonic, &turns) else { continue };
                    values_mm.extend(pair_mm);
                    weights.extend([weight * ECCENTRICITY_WEIGHT.sqrt(); 2]);
                    blocks.push(block(2, false, turns, Source::Eccentricity(model, fit)));
                }
            }
        }
        if let SetupError::Spindle(SpindleStep { bar, readings }) = &run.setup_error {
            let first = values_mm.len();
            values_mm.extend(readings.iter().map(|reading| reading.length_change_mm));
            weights.extend(readings.iter().map(|_| 1.0));
            blocks.push(Block {
                test: None,
                first,
                rows: readings.len(),
                offset: run.offset_per_test,
                turns: turns(readings),
                source: Source::Spindle(*bar),
            });
        }
        Self { blocks, values_mm: DVector::from_vec(values_mm), weights, bar_length_mm: run.bar_length_mm }
    }

    /// Room for a prediction with this number of parameters.
    pub(super) fn nothing_predicted(&self, parameters: usize) -> Predicted {
        let rows = self.values_mm.len();
        Predicted { values_mm: DVector::zeros(rows), slopes: DMatrix::zeros(rows, parameters + 2) }
    }

    /// The model's values in every row, for the machine with these errors under this control.
    pub(super) fn predict(
        &self,
        machine: &Machine,
        control: &Control,
        parameters: &[ErrorParameter],
        errors: &[LocationError; 2],
        setup_error_mm: [f64; 2],
    ) -> Predicted {
        let mut predicted = self.nothing_predicted(parameters.len());
        self.predict_into(&mut predicted, machine, control, parameters, errors, setup_error_mm);
        predicted
    }

    /// The same in the memory of an earlier prediction with these parameters.
    pub(super) fn predict_into(
        &self,
        predicted: &mut Predicted,
        machine: &Machine,
        control: &Control,
        parameters: &[ErrorParameter],
        errors: &[LocationError; 2],
        setup_error_mm: [f64; 2],
    ) {
        let lines = MovedLines::new(machine, errors);
        let ball_offset_mm = Vec3::new(setup_error_mm[0], setup_error_mm[1], 0.0);
        let moved = Moved { lines: &lines, control, setup_error_mm: ball_offset_mm };
        let (rows, columns) = (self.values_mm.len(), parameters.len() + 2);
        let Predicted { values_mm, slopes } = predicted;
        for block in &self.blocks {
            match &block.source {
                Source::Readings(model) => {
                    let of_block = block.first..block.first + block.rows;
                    let of_columns = slopes.as_mut_slice().chunks_exact_mut(rows);
                    let of_columns = of_columns.map(|column| &mut column[of_block.clone()]);
                    let readings_mm = &mut values_mm.as_mut_slice()[of_block.clone()];
                    model.readings(&block.turns, &moved, parameters, readings_mm, of_columns);
                }
                Source::Eccentricity(model, fit) => {
                    let mut readings_mm = vec![0.0; block.turns.len()];
                    let mut by_column = vec![vec![0.0; block.turns.len()]; columns];
                    let of_columns = by_column.iter_mut().map(Vec::as_mut_slice);
                    model.readings(&block.turns, &moved, parameters, &mut readings_mm, of_columns);
                    for (row, value) in (block.first..).zip(fit.of(&readings_mm)) {
                        values_mm[row] = value;
                    }
                    for (column, slopes_of_turns) in by_column.iter().enumerate() {
                        for (row, slope) in (block.first..).zip(fit.of(slopes_of_turns)) {
                            slopes[(row, column)] = slope;
                        }
                    }
                }
                Source::Spindle(bar) => {
                    for (row, turn) in (block.first..).zip(&block.turns) {
                        let mut pair = [0.0; 2];
                        values_mm[row] =
                            spindle_reading(*turn, *bar, self.bar_length_mm, ball_offset_mm, &mut pair);
                        for (component, slope) in pair.into_iter().enumerate() {
                            slopes[(row, parameters.len() + component)] = slope;
                        }
                    }
                }
            }
        }
    }

    /// Prepares columns of all rows for the fit: subtracts each block's own offset and multiplies rows by the roots
    /// of their weights. Rows of weight zero become zero.
    pub(super) fn project(&self, weights: &[f64], columns: &mut [f64]) {
        let mut columns: Vec<&mut [f64]> = columns.chunks_exact_mut(self.values_mm.len().max(1)).collect();
        let (fours, others) = columns.as_chunks_mut::<4>();
        for block in &self.blocks {
            let rows = block.first..block.first + block.rows;
            let weights = &weights[rows.clone()];
            for four in &mut *fours {
                prepare(weights, four.each_mut().map(|column| &mut column[rows.clone()]), block.offset);
            }
            for other in &mut *others {
                prepare(weights, [&mut other[rows.clone()]], block.offset);
            }
        }
    }

    /// The offset of each block in these residuals; zero if none is fitted.
    pub(super) fn offsets(&self, weights: &[f64], residuals: &[f64]) -> Vec<f64> {
        self.blocks
            .iter()
            .map(|block| {
                let rows = block.first..block.first + block.rows;
                match (block.offset, residuals.get(rows.clone()), weights.get(rows)) {
                    (true, Some(residuals), Some(weights)) => weighted_mean(weights, residuals),
                    _ => 0.0,
                }
            })
            .collect()
    }
}

fn turns(readings: &[Reading]) -> Vec<(f64, f64)> {
    readings.iter().map(|reading| trig::sin_cos(reading.angle_rad)).collect()
}

/// Prepares the rows of one block in some columns, whose sums then do not wait for one another.
fn prepare<const COLUMNS: usize>(root_weights: &[f64], columns: [&mut [f64]; COLUMNS], offset: bool) {
    let offsets = if offset {
        weighted_means(root_weights, columns.each_ref().map(|column| &**column))
    } else {
        [0.0; COLUMNS]
    };
    for (column, offset) in columns.into_iter().zip(offsets) {
        for (value, weight) in column.iter_mut().zip(root_weights) {
            *value = (*value - offset) * weight;
        }
    }
}

fn weighted_means<const COLUMNS: usize>(root_weights: &[f64], columns: [&[f64]; COLUMNS]) -> [f64; COLUMNS] {
    let (mut sums, mut whole) = ([0.0; COLUMNS], 0.0);
    for (row, root) in root_weights.iter().enumerate() {
        let weight = root * root;
        for (sum, column) in sums.iter_mut().zip(&columns) {
            *sum += weight * column[row];
        }
        whole += weight;
    }
    sums.map(|sum| if whole > 0.0 { sum / whole } else { 0.0 })
}

fn weighted_mean(root_weights: &[f64], values: &[f64]) -> f64 {
    let [mean] = weighted_means(root_weights, [values]);
    mean
}
