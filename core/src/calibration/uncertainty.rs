//! The uncertainty of identified errors, one source at a time: readings, instrument, set-up.

use nalgebra::{DMatrix, DVector, Dyn, QR};

use super::absolute::{AbsoluteError, absolute_estimates};
use super::decomposition::product;
use super::eccentricity::Harmonic;
use super::identify::{Fit, Solution};
use super::observations::Observations;
use super::robust::Outliers;
use super::{BallBarRun, RunFault, SetupError, Unknown};
use crate::geometry::Vec3;
use crate::machine::Machine;

/// A source of uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UncertaintySource {
    /// The scatter of the readings about the fit (Type A). A spindle step is part of the readings.
    Readings,
    /// The instrument.
    Instrument,
    /// The offset of the spindle ball, if it was given or held at zero.
    SetupError,
    /// The positions of the spindle ball.
    Ball,
    /// The length of the bar.
    BarLength,
}

impl UncertaintySource {
    /// Every source, in the order of a budget.
    pub const ALL: [Self; 5] =
        [Self::Readings, Self::Instrument, Self::SetupError, Self::Ball, Self::BarLength];
}

/// Standard uncertainties of the inputs that are not measured in the run \[mm\]; `None` if they are not stated.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InputUncertainties {
    /// Each of both components of the set-up error. It has no effect if a spindle step measures them.
    pub setup_error_mm: Option<f64>,
    /// Each coordinate of a ball position. Tests with the same position have the same ball.
    pub ball_mm: Option<f64>,
    /// The length of the bar.
    pub bar_length_mm: Option<f64>,
}

/// The part of one source in the uncertainty of all errors.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertaintyPart {
    /// Covariance of the unknowns \[mm², mm·rad, rad²\].
    pub covariance: DMatrix<f64>,
    /// The errors against the machine's frame, with the variances of this source alone.
    pub absolute: Vec<AbsoluteError>,
}

/// The uncertainty of a run's errors, by source. The sources are independent: covariances add up.
#[derive(Debug, Clone, PartialEq)]
pub struct UncertaintyBudget {
    /// The unknowns, in the order of the covariances.
    pub unknowns: Vec<Unknown>,
    /// Whether the readings do not determine the unknown.
    pub undetermined: Vec<bool>,
    /// Degrees of freedom of the readings.
    pub degrees_of_freedom: usize,
    /// In the order of [`UncertaintySource::ALL`]; `None` if nothing is known about the source.
    pub parts: [Option<UncertaintyPart>; 5],
}

/// The uncertainty budget of the errors that [`identify`](super::identify) finds.
///
/// Readings: Type A, from the residuals. Instrument: an unknown first harmonic of its uncertainty in every test. Set-up
/// error, ball and bar length: the change of the errors, to first order, if the input changes by its standard
/// uncertainty. The parts of independent inputs are added as squares.
///
/// # Errors
/// Everything wrong with the run's numbers; or no plausible errors of a machine explain them.
pub fn uncertainty_budget(
    machine: &Machine,
    run: &BallBarRun,
    inputs: &InputUncertainties,
) -> Result<UncertaintyBudget, Vec<RunFault>> {
    run.check(machine)?;
    let fit = Fit::new(machine, run).map_err(|fault| vec![fault])?;
    let solved = fit.solve().map_err(|fault| vec![fault])?;
    Ok(fit.budget(&solved, inputs))
}

/// The way from changes of the rows to changes of the unknowns.
pub(super) struct Response {
    factors: QR<f64, Dyn, Dyn>,
    /// unknowns = spread · Qᵀ rows
    spread: DMatrix<f64>,
}

impl Response {
    /// `None` if the iteration's last design has no inverse.
    pub(super) fn new(fit: &Fit<'_>, solution: &Solution, weights: &[f64]) -> Option<Self> {
        let factors = fit.design(solution, weights).qr();
        let count = fit.directions.ncols();
        let inverse = factors.r().solve_upper_triangular(&DMatrix::identity(count, count))?;
        let spread = product(&fit.directions, &inverse);
        Some(Self { factors, spread })
    }

    /// The covariance if the rows scatter independently with this variance \[mm²\].
    pub(super) fn scatter(&self, variance_mm2: f64) -> DMatrix<f64> {
        product(&self.spread, &self.spread.transpose()) * variance_mm2
    }

    /// Adds the covariance of one input, which changes the rows by `shape` \[mm\] per unit, `times` its variance.
    fn add(
        &self,
        fit: &Fit<'_>,
        weights: &[f64],
        mut shape: DVector<f64>,
        times: f64,
        to: &mut DMatrix<f64>,
    ) {
        let count = fit.directions.ncols();
        fit.observations.project(weights, shape.as_mut_slice());
        self.factors.q_tr_mul(&mut shape);
        let shifts = product(&self.spread, &DMatrix::from_column_slice(count, 1, &shape.as_slice()[..count]));
        *to += product(&shifts, &shifts.transpose()) * times;
    }

    /// Adds the covariance of an unknown first harmonic of this size in every test.
    pub(super) fn add_instrument(
        &self,
        fit: &Fit<'_>,
        weights: &[f64],
        instrument_mm: f64,
        covariance: &mut DMatrix<f64>,
    ) {
        let rows = fit.observations.values_mm.len();
        for (block, component) in fit.observations.blocks.iter().flat_map(|block| [(block, 0), (block, 1)]) {
            let mut shape = DVector::zeros(rows);
            for row in 0..block.rows {
                shape[block.first + row] = match block.test.map(|test| &fit.run.tests[test]) {
                    // A test with two eccentricities only: each is its own row.
                    Some(test) if test.readings().is_empty() => f64::from(u8::from(row == component)),
                    Some(test) => {
                        let axis = &fit.machine.rotary_axes()[test.axis];
                        Harmonic::new(axis, test.bar).at(block.turns[row])[component]
                    }
                    None if component == 0 => block.turns[row].0,
                    None => block.turns[row].1,
                };
            }
            self.add(fit, weights, shape, instrument_mm * instrument_mm, covariance);
        }
    }
}

impl Fit<'_> {
    fn budget(&self, solved: &Outliers, inputs: &InputUncertainties) -> UncertaintyBudget {
        let Outliers { solution, weights, .. } = solved;
        let degrees_of_freedom = self.degrees_of_freedom(weights);
        let undetermined = self.undetermined();
        let part = |covariance: DMatrix<f64>| UncertaintyPart {
            absolute: absolute_estimates(
                self.machine,
                &solution.errors,
                &self.unknowns,
                Some(&covariance),
                &undetermined,
                &self.blind,
            ),
            covariance,
        };
        let response = Response::new(self, solution, weights);
        let parts = UncertaintySource::ALL.map(|source| {
            let response = response.as_ref()?;
            let nothing = || DMatrix::zeros(self.unknowns.len(), self.unknowns.len());
            let covariance = match source {
                UncertaintySource::Readings => {
                    let mut weighted = solution.residuals_mm.clone();
                    self.observations.project(weights, weighted.as_mut_slice());
                    let variance = weighted.norm_squared() / degrees_of_freedom as f64;
                    (degrees_of_freedom > 0).then(|| response.scatter(variance))?
                }
                UncertaintySource::Instrument => {
                    let mut covariance = nothing();
                    response.add_instrument(
                        self,
                        weights,
                        self.run.instrument_uncertainty_mm?,
                        &mut covariance,
                    );
                    covariance
                }
                UncertaintySource::SetupError => {
                    let measured = matches!(self.run.setup_error, SetupError::Spindle(_));
                    let stated_mm = inputs.setup_error_mm.filter(|_| !measured)?;
                    let mut covariance = nothing();
                    for component in 0..2 {
                        let slopes =
                            solution.predicted.slopes.column(self.parameters.len() + component).into_owned();
                        response.add(self, weights, slopes, stated_mm * stated_mm, &mut covariance);
                    }
                    covariance
                }
                UncertaintySource::Ball => {
                    let stated_mm = inputs.ball_mm?;
                    let mut covariance = nothing();
                    self.move_balls(solution, stated_mm, |shape| {
                        response.add(self, weights, shape, 1.0, &mut covariance);
                    });
                    covariance
                }
                UncertaintySource::BarLength => {
                    let stated_mm = inputs.bar_length_mm?;
                    let mut covariance = nothing();
                    let shape = self.half_difference(solution, |run, sign| {
                        run.bar_length_mm += sign * stated_mm;
                    });
                    response.add(self, weights, shape, 1.0, &mut covariance);
                    covariance
                }
            };
            Some(part(covariance))
        });
        UncertaintyBudget { unknowns: self.unknowns.clone(), undetermined, degrees_of_freedom, parts }
    }

    /// Gives the change of the rows by each coordinate of each ball position, one after the other: there may be many
    /// rows.
    fn move_balls(&self, solution: &Solution, by_mm: f64, mut each: impl FnMut(DVector<f64>)) {
        let mut balls: Vec<Vec3> = Vec::new();
        for test in &self.run.tests {
            if !balls.contains(&test.ball_mm) {
                balls.push(test.ball_mm);
            }
        }
        for component in 0..3 {
            // All balls at once; the rows of other balls do not belong to this one.
            let all = self.half_difference(solution, |run, sign| {
                for test in &mut run.tests {
                    test.ball_mm[component] += sign * by_mm;
                }
            });
            for ball in &balls {
                let mut shape = DVector::zeros(all.len());
                for block in &self.observations.blocks {
                    if block.test.is_some_and(|test| self.run.tests[test].ball_mm == *ball) {
                        let rows = all.rows(block.first, block.rows);
                        shape.rows_mut(block.first, block.rows).copy_from(&rows);
                    }
                }
                each(shape);
            }
        }
    }

    /// Half the difference of the model's rows between a run that is changed up and one that is changed down.
    fn half_difference(&self, solution: &Solution, change: impl Fn(&mut BallBarRun, f64)) -> DVector<f64> {
        let nominal = self.machine.screws(false);
        let [up, down] = [1.0, -1.0].map(|sign| {
            let mut run = self.run.clone();
            change(&mut run, sign);
            let observations = Observations::new(self.machine, &run);
            let (errors, setup_error_mm) = (&solution.errors, solution.setup_error_mm);
            observations.predict(self.machine, &nominal, &[], errors, setup_error_mm).values_mm
        });
        (up - down) * 0.5
    }
}
