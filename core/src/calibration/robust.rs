//! Readings far from all others are left out, not averaged in.

use super::RunFault;
use super::identify::{Fit, Solution};

/// A reading is left out beyond this number of standard deviations. Of normal noise this loses one reading in two
/// million, so that the stated uncertainties stay true.
const LIMIT_SIGMAS: f64 = 5.0;
/// Readings closer than this are never left out \[mm\]: the resolution of common ball bars, 0.1 µm.
const LEAST_LIMIT_MM: f64 = 1e-4;
/// Smallest number of readings in a test that is judged. With fewer, an outlier cannot be distinguished from the
/// rest.
const MIN_READINGS: usize = 12;
/// Passes that weight squares by the inverse of the distance, so that every reading has the same influence at any
/// distance.
const MEDIAN_PASSES: usize = 12;
/// Most passes that judge again. If a borderline reading still changes sides, the last judgement is used.
const JUDGING_PASSES: usize = 10;
/// Standard deviation of a normal distribution over the median of the magnitudes.
const SIGMA_PER_MEDIAN: f64 = 1.482_602_218_505_602;

/// Ratio of the median, as a standard deviation, to the root mean square of the residuals, below which they are
/// checked again. It is 1 for normal noise, and above 1 for the waves that a machine adds.
const TOO_PEAKED: f64 = 0.85;
/// Ratio of the third moment to the second (to 3/2) of a test's residuals above which they are checked again. It is
/// 0 for normal noise (± 0.13 for 360 readings, ± 0.35 for 48), and 1.5 if one reading in five is far off to one
/// side, at any distance.
const TOO_SKEWED: f64 = 0.4;

/// A fit with the readings left out.
pub(super) struct Outliers {
    pub(super) solution: Solution,
    /// Root weights; zero for readings left out.
    pub(super) weights: Vec<f64>,
    /// Rows, ascending.
    pub(super) left_out: Vec<usize>,
}

/// Least squares of all readings. If some are far out, of the readings that remain when the far ones are judged
/// from a fit that they hardly influence.
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
    // With as many unknowns as readings there is no residual to judge.
    if 2 * fit.degrees_of_freedom(&weights) < judged.len() || !suspicious(fit, &plain, &weights, &judged) {
        return Ok(Outliers { solution: plain, weights, left_out: Vec::new() });
    }
    let mut solution = plain;
    let mut passing = weights.clone();
    for _ in 0..MEDIAN_PASSES {
        let residuals = distances(fit, &solution, &passing, &weights);
        for row in &judged {
            passing[*row] = weights[*row] / residuals[*row].max(LEAST_LIMIT_MM).sqrt();
        }
        // Only the ratio of weights counts: their mean is 1, like the rows that are not judged.
        let mean = judged.iter().map(|row| passing[*row]).sum::<f64>() / judged.len() as f64;
        for row in &judged {
            passing[*row] /= mean;
        }
        fit.step(&mut solution, &passing)?;
    }
    let mut left_out = far(fit, &solution, &passing, &judged);
    let mut pass = 0;
    loop {
        let mut kept = weights.clone();
        for row in &left_out {
            kept[*row] = 0.0;
        }
        solution = fit.descend(solution, &kept)?;
        let again = far(fit, &solution, &kept, &judged);
        if again == left_out || pass == JUDGING_PASSES {
            return Ok(Outliers { solution, weights: kept, left_out });
        }
        left_out = again;
        pass += 1;
    }
}

/// Whether the residuals look like normal noise with something else in it. A reading may be far out. The median of
/// the distances may be too small for their mean square (the fit follows outliers and hides them from the first
/// check). Or a test's residuals may lean to one side (many errors in the same direction hide from both checks).
fn suspicious(fit: &Fit<'_>, solution: &Solution, weights: &[f64], judged: &[usize]) -> bool {
    if !far(fit, solution, weights, judged).is_empty() {
        return true;
    }
    if skewed(fit, solution, weights) {
        return true;
    }
    let distances = distances(fit, solution, weights, weights);
    let Some(median) = median(&distances, judged) else { return false };
    let squares: f64 = judged.iter().map(|row| distances[*row] * distances[*row]).sum();
    let rms = (squares / judged.len() as f64).sqrt();
    rms > LEAST_LIMIT_MM && SIGMA_PER_MEDIAN * median < TOO_PEAKED * rms
}

/// The median of the judged rows' distances.
fn median(distances: &[f64], judged: &[usize]) -> Option<f64> {
    let mut sizes: Vec<f64> = judged.iter().map(|row| distances[*row]).collect();
    if sizes.is_empty() {
        return None;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// Whether a judged test's residuals, without offsets, lean to one side.
fn skewed(fit: &Fit<'_>, solution: &Solution, weights: &[f64]) -> bool {
    let residuals = solution.residuals_mm.as_slice();
    let offsets = fit.observations.offsets(weights, residuals);
    fit.observations.blocks.iter().zip(offsets).filter(|(block, _)| block.rows >= MIN_READINGS).any(
        |(block, offset)| {
            let of_block =
                residuals.iter().skip(block.first).take(block.rows).map(|residual| residual - offset);
            let (mut squares, mut cubes) = (0.0, 0.0);
            for residual in of_block {
                squares += residual * residual;
                cubes += residual * residual * residual;
            }
            let rows = block.rows as f64;
            let rms = f64::sqrt(squares / rows);
            rms > LEAST_LIMIT_MM && (cubes / rows).abs() > TOO_SKEWED * rms * rms * rms
        },
    )
}

/// Every row's distance from the fit, without offsets (by `passing`), in units of its own test's readings.
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

/// The judged rows that are far out, ascending. A test that scatters more than all together is judged by its own
/// scatter: an error that all its readings share is not an outlier.
fn far(fit: &Fit<'_>, solution: &Solution, passing: &[f64], judged: &[usize]) -> Vec<usize> {
    let distances = distances(fit, solution, passing, &fit.observations.weights);
    let Some(of_all) = median(&distances, judged) else { return Vec::new() };
    let mut far = Vec::new();
    for block in &fit.observations.blocks {
        let end = block.first + block.rows;
        let first = judged.partition_point(|row| *row < block.first);
        let rows = &judged[first..judged.partition_point(|row| *row < end)];
        let Some(of_block) = median(&distances, rows) else { continue };
        let limit = (LIMIT_SIGMAS * SIGMA_PER_MEDIAN * of_block.max(of_all)).max(LEAST_LIMIT_MM);
        far.extend(rows.iter().copied().filter(|row| distances[*row] > limit));
    }
    far
}
