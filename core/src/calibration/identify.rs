//! Location errors from ball-bar readings: weighted, robust least squares on the full rigid-body model.

use nalgebra::{DMatrix, DVector};

use super::absolute::{AbsoluteError, absolute_estimates};
use super::blind::{Blind, blind_combinations};
use super::decomposition::{Decomposition, product};
use super::eccentricity::{Harmonic, HarmonicFit};
use super::observations::{Observations, Predicted};
use super::robust::{Outliers, keep};
use super::uncertainty::Response;
use super::warnings::{RunWarning, warnings};
use super::{BallBarRun, ErrorParameter, RunFault, SetupError, placing_parameters, told_per_unit};
use crate::machine::{LocationError, Machine};
use crate::units::UM_PER_MM;

/// A quantity that is unknown before the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unknown {
    /// A component of a location error \[mm or rad\].
    Error(ErrorParameter),
    /// A component of the set-up error \[mm\]: 0 `e_xs`, 1 `e_ys`.
    SetupError(usize),
}

impl Unknown {
    /// The factor from the computed unit to the reported one: µm per mm, µrad per rad.
    #[must_use]
    pub fn told_per_unit(&self) -> f64 {
        match self {
            Self::Error(parameter) => told_per_unit(parameter.component),
            Self::SetupError(_) => UM_PER_MM,
        }
    }
}

/// Eccentricities of one test \[mm\]; `None` if the angles do not determine them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eccentricities {
    /// As measured, with nominal kinematics in the control.
    pub before_mm: Option<[f64; 2]>,
    /// Prediction for a control that knows only the four translations.
    pub after_linear_mm: Option<[f64; 2]>,
    /// Prediction for a control that knows all errors.
    pub after_all_mm: Option<[f64; 2]>,
}

/// A reading that the fit leaves out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    /// The test.
    pub test: usize,
    /// The reading.
    pub reading: usize,
    /// Measured minus fitted \[mm\].
    pub residual_mm: f64,
}

/// The result of a run for a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Identified {
    /// The location errors, cascaded as in the profile. Components that are not fitted are zero.
    pub errors: [LocationError; 2],
    /// The set-up error, given or found \[mm\].
    pub setup_error_mm: [f64; 2],
    /// The fitted unknowns, in the order of `covariance`.
    pub unknowns: Vec<Unknown>,
    /// Covariance of the unknowns \[mm², mm·rad, rad²\]; `None` without degrees of freedom to estimate it.
    pub covariance: Option<DMatrix<f64>>,
    /// Whether the readings do not determine the unknown. Its value is then only the smallest that fits.
    pub undetermined: Vec<bool>,
    /// The errors against the machine's frame, with ISO 230-7 symbols.
    pub absolute: Vec<AbsoluteError>,
    /// The combinations that the readings cannot distinguish.
    pub blind: Vec<Blind>,
    /// Number of `counted` unknowns that the readings determine, without offsets.
    pub rank: usize,
    /// Number of location errors, plus the two set-up errors if these were not given.
    pub counted: usize,
    /// Largest singular value over the smallest, of the fitted unknowns with columns at unit length.
    pub condition_number: f64,
    /// Number of observations minus unknowns and offsets.
    pub degrees_of_freedom: usize,
    /// Root mean square of the residuals of the readings kept \[mm\].
    pub residual_rms_mm: f64,
    /// Measured minus fitted, by test \[mm\]; two values for a test with eccentricities only.
    pub residuals_mm: Vec<Vec<f64>>,
    /// The offset of each test \[mm\]; `None` if none was fitted.
    pub offsets_mm: Vec<Option<f64>>,
    /// The readings left out, by test and reading.
    pub outliers: Vec<Outlier>,
    /// Eccentricities by test.
    pub eccentricities: Vec<Eccentricities>,
    /// Warnings that a metrologist should check.
    pub warnings: Vec<RunWarning>,
}

/// Most steps of the fit. It needs three or four.
const MAX_STEPS: usize = 30;
/// The fit ends at a step that moves the model by less than this in the mean of the rows \[mm\]. It is a thousandth
/// of the accuracy of comparisons (1e-6 µm), and ten times the rounding of coordinates of a few hundred mm.
const STEP_END_MM: f64 = 1e-12;
/// Steps below this that no longer become smaller are rounding \[mm\], for coordinates of metres summed over many
/// rows.
const ROUNDING_MM: f64 = 1e-9;

/// Identifies the location errors of both rotary axes of `machine`. Its own location errors are not used: the
/// control turned the axes by the nominal lines.
///
/// The model is the rigid-body model of shared notation §1 and §5, without linearisation. The unknowns are
/// [`placing_parameters`], the set-up error if it is measured, and one offset per test if asked for. Readings far
/// from all others are left out and listed. Combinations that the tests cannot see are kept at zero and listed.
/// Covariance: Type A from the residuals. A given instrument uncertainty adds an unknown first harmonic of that
/// size in every test; more readings do not average it away.
///
/// # Errors
/// Everything wrong with the run's numbers; or no plausible errors of a machine explain them.
pub fn identify(machine: &Machine, run: &BallBarRun) -> Result<Identified, Vec<RunFault>> {
    run.check(machine)?;
    Fit::new(machine, run).and_then(|fit| fit.run()).map_err(|fault| vec![fault])
}

/// The predicted bar readings \[mm\] at the angles of each test of `run` (its measured values are not used). The
/// machine has these errors and this set-up error, under nominal kinematics. A test without readings gives two
/// eccentricities.
///
/// # Errors
/// Everything wrong with the run's numbers.
pub fn expected_readings(
    machine: &Machine,
    run: &BallBarRun,
    errors: &[LocationError; 2],
    setup_error_mm: [f64; 2],
) -> Result<Vec<Vec<f64>>, Vec<RunFault>> {
    run.check(machine)?;
    let observations = Observations::new(machine, run);
    let control = machine.screws(false);
    let values_mm = observations.predict(machine, &control, &[], errors, setup_error_mm).values_mm;
    let mut readings = vec![Vec::new(); run.tests.len()];
    for block in &observations.blocks {
        if let Some(test) = block.test {
            readings[test] = values_mm.rows(block.first, block.rows).iter().copied().collect();
        }
    }
    Ok(readings)
}

/// The parts of the problem that stay the same from step to step.
pub(super) struct Fit<'a> {
    pub(super) machine: &'a Machine,
    pub(super) run: &'a BallBarRun,
    pub(super) parameters: Vec<ErrorParameter>,
    pub(super) unknowns: Vec<Unknown>,
    pub(super) observations: Observations,
    solved: Decomposition,
    /// Matrix from the determined combinations to the unknowns in their units.
    pub(super) directions: DMatrix<f64>,
    /// Number of unknowns that the readings determine, and number of unknowns. They include the set-up error if it
    /// was not given.
    rank: usize,
    counted: usize,
    pub(super) blind: Vec<Blind>,
}

/// The state of a fit.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub(super) errors: [LocationError; 2],
    pub(super) setup_error_mm: [f64; 2],
    /// Measured minus model, with offsets still included \[mm\].
    pub(super) residuals_mm: DVector<f64>,
    pub(super) predicted: Predicted,
}

impl<'a> Fit<'a> {
    pub(super) fn new(machine: &'a Machine, run: &'a BallBarRun) -> Result<Self, RunFault> {
        let parameters = placing_parameters(machine);
        let observations = Observations::new(machine, run);
        // At zero of everything: an effect that only the product of two small numbers shows does not count as seen.
        let nominal = machine.screws(false);
        let at_zero =
            observations.predict(machine, &nominal, &parameters, &[LocationError::default(); 2], [0.0; 2]);
        let every: Vec<Unknown> =
            parameters.iter().copied().map(Unknown::Error).chain([0, 1].map(Unknown::SetupError)).collect();
        let decomposed = |columns: usize| {
            let mut slopes = at_zero.slopes.columns(0, columns).into_owned();
            observations.project(&observations.weights, slopes.as_mut_slice());
            Decomposition::new(slopes).filter(|found| found.rank() > 0).ok_or(RunFault::NothingDetermined)
        };
        let with_setup = matches!(run.setup_error, SetupError::Spindle(_));
        let counts_setup = !matches!(run.setup_error, SetupError::Known(_));
        let columns = |setup: bool| parameters.len() + if setup { 2 } else { 0 };
        let solved = decomposed(columns(with_setup))?;
        let counted = decomposed(columns(counts_setup))?;
        let directions = solved.unscaled_seen();
        let unknowns = every.iter().copied().take(columns(with_setup)).collect();
        let counted_unknowns: Vec<Unknown> = every.into_iter().take(columns(counts_setup)).collect();
        let blind = blind_combinations(machine, run, &counted_unknowns, &counted, &observations, &at_zero);
        Ok(Self {
            machine,
            run,
            parameters,
            unknowns,
            observations,
            solved,
            directions,
            rank: counted.rank(),
            counted: counted_unknowns.len(),
            blind,
        })
    }

    fn run(&self) -> Result<Identified, RunFault> {
        let Outliers { solution, weights, left_out } = self.solve()?;
        Ok(self.answer(&solution, &weights, &left_out))
    }

    /// The errors that explain the readings kept.
    pub(super) fn solve(&self) -> Result<Outliers, RunFault> {
        let known = match self.run.setup_error {
            SetupError::Known(known) => known,
            SetupError::Spindle(_) | SetupError::Unknown => [0.0; 2],
        };
        let start = self.at([LocationError::default(); 2], known);
        keep(self, start)
    }

    /// Which unknowns are part of a combination that the readings do not determine.
    pub(super) fn undetermined(&self) -> Vec<bool> {
        self.solved.touched()
    }

    fn at(&self, errors: [LocationError; 2], setup_error_mm: [f64; 2]) -> Solution {
        let predicted = self.observations.nothing_predicted(self.parameters.len());
        let residuals_mm = self.observations.values_mm.clone();
        let mut solution = Solution { errors, setup_error_mm, residuals_mm, predicted };
        self.predict(&mut solution);
        solution
    }

    /// Predicts the readings with the solution's errors, in the memory of its last prediction.
    fn predict(&self, solution: &mut Solution) {
        let nominal = self.machine.screws(false);
        let Solution { errors, setup_error_mm, residuals_mm, predicted } = solution;
        let observations = &self.observations;
        observations.predict_into(
            predicted,
            self.machine,
            &nominal,
            &self.parameters,
            errors,
            *setup_error_mm,
        );
        observations.values_mm.sub_to(&predicted.values_mm, residuals_mm);
    }

    /// Gauss–Newton from `solution` with these weights of the rows, among the determined combinations.
    pub(super) fn descend(&self, mut solution: Solution, weights: &[f64]) -> Result<Solution, RunFault> {
        let mut before_mm = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let moved_mm = self.step(&mut solution, weights)?;
            let only_rounding = moved_mm < ROUNDING_MM && moved_mm > 0.5 * before_mm;
            if moved_mm <= STEP_END_MM || only_rounding {
                return Ok(solution);
            }
            before_mm = moved_mm;
        }
        Err(Self::OUT_OF_BOUNDS)
    }

    const OUT_OF_BOUNDS: RunFault =
        RunFault::NoFit { max_mm: Machine::MAX_ERROR_MM, max_rad: Machine::MAX_ERROR_RAD };

    /// Takes one step. Returns its mean change of the model over the rows \[mm\].
    pub(super) fn step(&self, solution: &mut Solution, weights: &[f64]) -> Result<f64, RunFault> {
        let factors = self.design(solution, weights).qr();
        let mut residuals = solution.residuals_mm.clone();
        self.observations.project(weights, residuals.as_mut_slice());
        factors.q_tr_mul(&mut residuals);
        let top = residuals.rows(0, self.directions.ncols()).into_owned();
        let moved_mm = top.norm() / (self.observations.values_mm.len() as f64).sqrt();
        let step = factors.r().solve_upper_triangular(&top).ok_or(Self::OUT_OF_BOUNDS)?;
        let Solution { errors, setup_error_mm, .. } = &mut *solution;
        for (unknown, row) in self.unknowns.iter().zip(self.directions.row_iter()) {
            let change: f64 = row.iter().zip(step.iter()).map(|(part, step)| part * step).sum();
            match unknown {
                Unknown::Error(parameter) => {
                    let value = parameter.value(errors) + change;
                    parameter.set(errors, value);
                }
                Unknown::SetupError(component) => setup_error_mm[*component] += change,
            }
        }
        let within = |values: &[f64], max: f64| values.iter().all(|value| value.abs() <= max);
        let sound = within(setup_error_mm.as_slice(), Machine::MAX_ERROR_MM)
            && errors.iter().all(|error| {
                within(error.translation_mm.as_slice(), Machine::MAX_ERROR_MM)
                    && within(error.rotation_rad.as_slice(), Machine::MAX_ERROR_RAD)
            });
        if !sound {
            return Err(Self::OUT_OF_BOUNDS);
        }
        self.predict(solution);
        Ok(moved_mm)
    }

    /// The slopes along the determined combinations, projected and weighted.
    pub(super) fn design(&self, solution: &Solution, weights: &[f64]) -> DMatrix<f64> {
        let slopes = solution.predicted.slopes.columns(0, self.unknowns.len());
        let mut design = product(slopes, &self.directions);
        self.observations.project(weights, design.as_mut_slice());
        design
    }

    /// Observations kept, minus the number of fitted values.
    pub(super) fn degrees_of_freedom(&self, weights: &[f64]) -> usize {
        let kept = weights.iter().filter(|weight| **weight > 0.0).count();
        let offsets = self.observations.blocks.iter().filter(|block| block.offset).count();
        kept.saturating_sub(self.solved.rank() + offsets)
    }

    fn answer(&self, solution: &Solution, weights: &[f64], left_out: &[usize]) -> Identified {
        let observations = &self.observations;
        let mut weighted = solution.residuals_mm.clone();
        observations.project(weights, weighted.as_mut_slice());
        let degrees_of_freedom = self.degrees_of_freedom(weights);
        let offsets = observations.offsets(weights, solution.residuals_mm.as_slice());
        let tests = self.run.tests.len();
        let (mut residuals_mm, mut offsets_mm) = (vec![Vec::new(); tests], vec![None; tests]);
        let (mut outliers, mut squares, mut kept) = (Vec::new(), 0.0, 0.0);
        for (block, offset) in observations.blocks.iter().zip(offsets) {
            for reading in 0..block.rows {
                let row = block.first + reading;
                let residual_mm = solution.residuals_mm[row] - offset;
                let is_out = left_out.binary_search(&row).is_ok();
                if !is_out {
                    squares += residual_mm * residual_mm;
                    kept += 1.0;
                }
                if let Some(test) = block.test {
                    residuals_mm[test].push(residual_mm);
                    if is_out {
                        outliers.push(Outlier { test, reading, residual_mm });
                    }
                }
            }
            if let Some(test) = block.test.filter(|_| block.offset) {
                offsets_mm[test] = Some(offset);
            }
        }
        let covariance = self.covariance(solution, weights, weighted.norm_squared(), degrees_of_freedom);
        let undetermined = self.undetermined();
        let absolute = absolute_estimates(
            self.machine,
            &solution.errors,
            &self.unknowns,
            covariance.as_ref(),
            &undetermined,
            &self.blind,
        );
        Identified {
            errors: solution.errors,
            setup_error_mm: solution.setup_error_mm,
            unknowns: self.unknowns.clone(),
            covariance,
            undetermined,
            absolute,
            blind: self.blind.clone(),
            rank: self.rank,
            counted: self.counted,
            condition_number: self.solved.condition,
            degrees_of_freedom,
            residual_rms_mm: if kept > 0.0 { f64::sqrt(squares / kept) } else { 0.0 },
            residuals_mm,
            offsets_mm,
            warnings: warnings(self.machine, self.run, &outliers, self.solved.condition),
            outliers,
            eccentricities: self.eccentricities(solution, weights),
        }
    }

    fn covariance(
        &self,
        solution: &Solution,
        weights: &[f64],
        squares: f64,
        degrees_of_freedom: usize,
    ) -> Option<DMatrix<f64>> {
        let instrument_mm = self.run.instrument_uncertainty_mm.filter(|value| *value > 0.0);
        if degrees_of_freedom == 0 && instrument_mm.is_none() {
            return None;
        }
        let response = Response::new(self, solution, weights)?;
        let mut covariance = if degrees_of_freedom > 0 {
            response.scatter(squares / degrees_of_freedom as f64)
        } else {
            DMatrix::zeros(self.unknowns.len(), self.unknowns.len())
        };
        if let Some(instrument_mm) = instrument_mm {
            response.add_instrument(self, weights, instrument_mm, &mut covariance);
        }
        Some(covariance)
    }

    /// Measured eccentricities, and the same after the compensation that the model predicts. The part that no
    /// location error explains remains.
    fn eccentricities(&self, solution: &Solution, weights: &[f64]) -> Vec<Eccentricities> {
        let linear = solution
            .errors
            .map(|error| LocationError { translation_mm: error.translation_mm, ..LocationError::default() });
        let controls = [
            self.machine.screws(false),
            self.machine.screws_with(&linear),
            self.machine.screws_with(&solution.errors),
        ];
        let models = controls.map(|control| {
            let (errors, setup_error_mm) = (&solution.errors, solution.setup_error_mm);
            self.observations.predict(self.machine, &control, &[], errors, setup_error_mm).values_mm
        });
        let none = Eccentricities { before_mm: None, after_linear_mm: None, after_all_mm: None };
        let mut eccentricities = vec![none; self.run.tests.len()];
        for block in &self.observations.blocks {
            let Some(test) = block.test else { continue };
            let described = &self.run.tests[test];
            let rows = block.first..block.first + block.rows;
            // For readings the fit of those kept; for two eccentricities alone, these themselves.
            let fitted = if described.readings().is_empty() {
                None
            } else {
                let harmonic = Harmonic::new(&self.machine.rotary_axes()[described.axis], described.bar);
                let kept: Vec<usize> = rows.filter(|row| weights[*row] > 0.0).collect();
                let turns: Vec<_> = kept.iter().map(|row| block.turns[row - block.first]).collect();
                let Some(fit) = HarmonicFit::new(&harmonic, &turns) else { continue };
                Some((kept, fit))
            };
            let of = |values: &DVector<f64>| match &fitted {
                Some((kept, fit)) => fit.of(&kept.iter().map(|row| values[*row]).collect::<Vec<_>>()),
                None => [values[block.first], values[block.first + 1]],
            };
            let measured = of(&self.observations.values_mm);
            let [before, linear, all] = models.each_ref().map(of);
            let after = |model: [f64; 2]| Some([0, 1].map(|k| measured[k] - before[k] + model[k]));
            eccentricities[test] = Eccentricities {
                before_mm: Some(measured),
                after_linear_mm: after(linear),
                after_all_mm: after(all),
            };
        }
        eccentricities
    }
}
