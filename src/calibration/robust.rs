//! Readings far from all others are left out, not averaged in.

use super::RunFault;
use super::identify::{Fit, Solution};

/// A reading is left out beyond this many standard deviations: of normal noise it loses one in two million, so that
/// the stated uncertainties stay true.
const LIMIT_SIGMAS: f64 = 5.0;
/// What is closer than this is never left out \[mm\]: the resolution of common ball bars, 0.1 µm.
const LEAST_LIMIT_MM: f64 = 1e-4;
/// Readings of a test below which none is judged: too few to tell an outlier from the rest.
const MIN_READINGS: usize = 12;
/// Passes that weigh by the inverse of the distance, which is what far readings pull least at.
const MEDIAN_PASSES: usize = 12;
/// Passes that judge anew; more never change anything but by one borderline reading.
const JUDGING_PASSES: usize = 10;
/// Standard deviation of a normal distribution over the median of its magnitudes.
const SIGMA_PER_MEDIAN: f64 = 1.482_602_218_505_602;

/// A fit with what it leaves out.
pub(super) struct Outliers {
    pub(super) solution: Solution,
    /// Root weights, zero for what is left out.
    pub(super) weights: Vec<f64>,
    /// Rows, ascending.
    pub(super) left_out: Vec<usize>,
}

/// Least squares of all readings; where some stand far out, of those that remain when the far ones are judged from a
/// fit that they hardly pull.
pub(super) fn keep(fit: &Fit<'_>, start: Solution) -> Result<Outliers, RunFault> {
    let weights = fit.observations.weights.clone();
    let judged: Vec<usize> = fit
        .observations
        .blocks
        .iter()
        .filter(|block| block.rows >= MIN_READINGS)
        .flat_map(|block| block.first..block.first + block.rows)
        .collect();
    let plain = fit.descend(start, &weights)?;
    // As many unknowns as readings leave no residual to judge by.
    if judged.is_empty() || 2 * fit.degrees_of_freedom(&weights) < judged.len() {
        return Ok(Outliers { solution: plain, weights, left_out: Vec::new() });
    }
    // Not only where some stand out already: readings that are all wrong the same way pull the fit after them, and
    // none of them looks far from it.
    let mut solution = plain.clone();
    let mut passing = weights.clone();
    for _ in 0..MEDIAN_PASSES {
        let residuals = distances(fit, &solution, &passing, &weights);
        for row in &judged {
            passing[*row] = weights[*row] / residuals[*row].max(LEAST_LIMIT_MM).sqrt();
        }
        // Only the ratio of weights counts; rows that are not judged keep the mean one.
        let mean = judged.iter().map(|row| passing[*row]).sum::<f64>() / judged.len() as f64;
        for weight in &mut passing {
            *weight /= mean;
        }
        for block in fit.observations.blocks.iter().filter(|block| block.rows < MIN_READINGS) {
            let rows = block.first..block.first + block.rows;
            passing[rows.clone()].copy_from_slice(&weights[rows]);
        }
        (solution, _) = fit.step(&solution, &passing)?;
    }
    let mut left_out = far(fit, &solution, &passing, &judged);
    if left_out.is_empty() {
        return Ok(Outliers { solution: plain, weights, left_out });
    }
    for _ in 0..JUDGING_PASSES {
        let mut kept = weights.clone();
        for row in &left_out {
            kept[*row] = 0.0;
        }
        solution = fit.descend(solution, &kept)?;
        let again = far(fit, &solution, &kept, &judged);
        if again == left_out {
            return Ok(Outliers { solution, weights: kept, left_out });
        }
        left_out = again;
    }
    let mut kept = weights;
    for row in &left_out {
        kept[*row] = 0.0;
    }
    solution = fit.descend(solution, &kept)?;
    Ok(Outliers { solution, weights: kept, left_out })
}

/// Every row's distance from the fit, offsets (by `passing`) taken out, in units of its own test's readings.
fn distances(fit: &Fit<'_>, solution: &Solution, passing: &[f64], weights: &[f64]) -> Vec<f64> {
    let residuals = solution.residuals_mm.as_slice();
    let offsets = fit.observations.offsets(passing, residuals);
    let mut distances = vec![0.0; residuals.len()];
    for (block, offset) in fit.observations.blocks.iter().zip(offsets) {
        for row in block.first..block.first + block.rows {
            distances[row] = (residuals[row] - offset).abs() * weights[row];
        }
    }
    distances
}

/// The judged rows that stand out, ascending.
fn far(fit: &Fit<'_>, solution: &Solution, passing: &[f64], judged: &[usize]) -> Vec<usize> {
    let distances = distances(fit, solution, passing, &fit.observations.weights);
    let mut sizes: Vec<f64> = judged.iter().map(|row| distances[*row]).collect();
    if sizes.is_empty() {
        return Vec::new();
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    let limit = (LIMIT_SIGMAS * SIGMA_PER_MEDIAN * *median).max(LEAST_LIMIT_MM);
    judged.iter().copied().filter(|row| distances[*row] > limit).collect()
}
