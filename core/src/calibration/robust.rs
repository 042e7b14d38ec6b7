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
/// Passes that weigh squares by the inverse of the distance, so that a reading pulls alike however far it is.
const MEDIAN_PASSES: usize = 12;
/// Most passes that judge anew; where a borderline reading still goes in and out, the last judgement stands.
const JUDGING_PASSES: usize = 10;
/// Standard deviation of a normal distribution over the median of its magnitudes.
const SIGMA_PER_MEDIAN: f64 = 1.482_602_218_505_602;

/// Middle over mean square of residuals below which they are looked at again; 1 for normal noise, above it for the
/// waves that a machine adds.
const TOO_PEAKED: f64 = 0.85;
/// Third over second moment (to 3/2) of a test's residuals above which they are looked at again: 0 for normal noise
/// (± 0.13 for 360 readings, ± 0.35 for 48), 1.5 where one reading in five is far off to one side, whatever its size.
const TOO_SKEWED: f64 = 0.4;

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
        // Only the ratio of weights counts: 1 in the mean, beside the rows that are not judged.
        let mean = judged.iter().map(|row| passing[*row]).sum::<f64>() / judged.len() as f64;
        for row in &judged {
            passing[*row] /= mean;
        }
        (solution, _) = fit.step(&solution, &passing)?;
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

/// Whether the residuals look like normal noise with something else in it: a reading stands far out, or the middle of
/// the distances is too small for their mean square (outliers that the fit follows hide from the first question), or
/// a test's residuals lean to one side (many that are wrong the same way hide from both).
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

/// The middle one of the judged rows' distances.
fn median(distances: &[f64], judged: &[usize]) -> Option<f64> {
    let mut sizes: Vec<f64> = judged.iter().map(|row| distances[*row]).collect();
    if sizes.is_empty() {
        return None;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

/// Whether a judged test's residuals, offsets taken out, lean to one side.
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

/// The judged rows that stand out, ascending. A test that scatters more than all together is judged by its own scatter:
/// what all its readings share is no outlier.
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
