//! The errors of a run as a report states them: with their budget, expanded uncertainty, limit and verdict.

use super::calibration_answer::{iso_name, parameter_name};
use super::{CalibrationDocument, CalibrationLimits, Estimate};
use crate::calibration::{UncertaintyBudget, UncertaintyPart, UncertaintySource, Unknown, told_per_unit};
use crate::machine::Machine;

/// The coverage factor: a normal value lies within two standard uncertainties with 95 %.
const COVERAGE_FACTOR: f64 = 2.0;

/// Whether an error keeps its limit, by the rule of ISO 14253-1: the uncertainty counts against the statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The profile states no limit.
    NoLimit,
    /// The run does not determine the error.
    NotDetermined,
    /// The uncertainty is not known.
    NoUncertainty,
    /// Magnitude and U together are not over the limit.
    Within,
    /// The magnitude is over the limit by more than U.
    Outside,
    /// The limit is closer than U.
    NotProven,
}

/// One error against the machine's frame, in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportedError {
    /// The name in `iso_230`: `E_A0C_urad`.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Standard uncertainty from each source, in the order of [`UncertaintySource::ALL`].
    pub parts: [Option<f64>; 5],
    /// Combined standard uncertainty; `None` if the scatter of the readings is not known.
    pub combined: Option<f64>,
    /// Expanded uncertainty U with k = 2.
    pub expanded: Option<f64>,
    /// Effective degrees of freedom of the combined uncertainty (Welch–Satterthwaite).
    pub effective_degrees_of_freedom: Option<f64>,
    /// Whether the run determines the error.
    pub is_determined: bool,
    /// The limit of its magnitude.
    pub limit: Option<f64>,
    /// Whether it keeps its limit.
    pub verdict: Verdict,
}

/// One cascaded error with its expanded uncertainty, in the unit of its name.
#[derive(Debug, Clone, PartialEq)]
pub struct CascadedError {
    /// Axis and name: `A.e_y_um`.
    pub name: String,
    /// The value that applying the run writes into the profile.
    pub value: f64,
    /// Expanded uncertainty U with k = 2.
    pub expanded: Option<f64>,
}

/// The errors of a run against the machine's frame. Without a budget, the document's standard uncertainty is the
/// scatter of the readings.
#[must_use]
pub fn reported_errors(
    document: &CalibrationDocument,
    machine: &Machine,
    budget: Option<&UncertaintyBudget>,
    limits: Option<&CalibrationLimits>,
) -> Vec<ReportedError> {
    let degrees_of_freedom = document.degrees_of_freedom as f64;
    let rows = document.iso_230.iter();
    rows.map(|(name, estimate)| {
        let parts = match budget {
            Some(budget) => {
                budget.parts.each_ref().map(|part| part.as_ref().and_then(|part| of(part, machine, name)))
            }
            None => [estimate.standard_uncertainty, None, None, None, None],
        };
        let is_determined = !document.unidentifiable.contains(name);
        reported(name, estimate.value, parts, degrees_of_freedom, is_determined, limits)
    })
    .collect()
}

/// The standard uncertainty of an error from one source.
fn of(part: &UncertaintyPart, machine: &Machine, name: &str) -> Option<f64> {
    let found = part.absolute.iter().find(|error| iso_name(machine, error) == name)?;
    Some(found.variance?.max(0.0).sqrt() * told_per_unit(found.component))
}

fn reported(
    name: &str,
    value: f64,
    parts: [Option<f64>; 5],
    degrees_of_freedom: f64,
    is_determined: bool,
    limits: Option<&CalibrationLimits>,
) -> ReportedError {
    let [readings, ..] = parts;
    let squares: f64 = parts.iter().flatten().map(|part| part * part).sum();
    let combined = readings.map(|_| squares.sqrt());
    let expanded = combined.map(|combined| COVERAGE_FACTOR * combined);
    let effective_degrees_of_freedom = readings
        .filter(|readings| *readings > 0.0)
        .map(|readings| squares * squares * degrees_of_freedom / readings.powi(4));
    let limit = limits.and_then(|limits| limits.get(name));
    let verdict = match (limit, is_determined, expanded) {
        (None, _, _) => Verdict::NoLimit,
        (Some(_), false, _) => Verdict::NotDetermined,
        (Some(_), true, None) => Verdict::NoUncertainty,
        (Some(limit), true, Some(expanded)) if value.abs() + expanded <= limit => Verdict::Within,
        (Some(limit), true, Some(expanded)) if value.abs() - expanded > limit => Verdict::Outside,
        (Some(_), true, Some(_)) => Verdict::NotProven,
    };
    ReportedError {
        name: name.to_owned(),
        value,
        parts,
        combined,
        expanded,
        effective_degrees_of_freedom,
        is_determined,
        limit,
        verdict,
    }
}

/// The cascaded errors of a run, in the order of the axes.
#[must_use]
pub fn cascaded_errors(
    document: &CalibrationDocument,
    machine: &Machine,
    budget: Option<&UncertaintyBudget>,
) -> Vec<CascadedError> {
    let variance = |name: &str| -> Option<f64> {
        let budget = budget?;
        let index = budget.unknowns.iter().position(|unknown| match unknown {
            Unknown::Error(parameter) => parameter_name(machine, *parameter) == name,
            Unknown::SetupError(_) => false,
        })?;
        let unit = budget.unknowns.get(index)?.told_per_unit();
        let readings_are_known = budget.parts.first().is_some_and(Option::is_some);
        let is_open = budget.undetermined.get(index).copied().unwrap_or(true);
        let parts = budget.parts.iter().flatten();
        (readings_are_known && !is_open)
            .then(|| parts.map(|part| part.covariance[(index, index)] * unit * unit).sum())
    };
    let rows = document.errors.iter().flat_map(|(axis, errors)| {
        errors.iter().map(move |(name, estimate)| (format!("{axis}.{name}"), *estimate))
    });
    rows.map(|(name, Estimate { value, standard_uncertainty })| {
        let standard = match budget {
            Some(_) => variance(&name).map(|variance: f64| variance.max(0.0).sqrt()),
            None => standard_uncertainty,
        };
        CascadedError { name, value, expanded: standard.map(|standard| COVERAGE_FACTOR * standard) }
    })
    .collect()
}

impl ReportedError {
    /// The share of one source.
    #[must_use]
    pub fn part(&self, source: UncertaintySource) -> Option<f64> {
        let index = UncertaintySource::ALL.iter().position(|one| *one == source)?;
        self.parts.get(index).copied().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(value: f64, parts: [Option<f64>; 5], limit: f64) -> ReportedError {
        let limits = serde_json::from_str(&format!("{{\"E_X0C_um\": {limit}}}")).unwrap();
        reported("E_X0C_um", value, parts, 10.0, true, Some(&limits))
    }

    #[test]
    fn the_uncertainty_counts_against_the_statement() {
        // u = √(0.3² + 0.4²) = 0.5, U = 1.
        let parts = [Some(0.3), None, Some(0.4), None, None];
        for (value, verdict) in [
            (3.9, Verdict::Within),
            (-4.0, Verdict::Within),
            (4.1, Verdict::NotProven),
            (-5.9, Verdict::NotProven),
            (6.1, Verdict::Outside),
        ] {
            let error = with(value, parts, 5.0);
            assert_eq!(error.verdict, verdict, "{value}");
            assert!((error.expanded.unwrap() - 1.0).abs() < 1e-15);
            // 0.5⁴ · 10 / 0.3⁴
            assert!((error.effective_degrees_of_freedom.unwrap() - 0.625 / 0.0081).abs() < 1e-9);
        }
        let open = reported("E_X0C_um", 1.0, parts, 10.0, false, None);
        assert_eq!((open.verdict, open.is_determined), (Verdict::NoLimit, false));
        let unknown = with(1.0, [None, Some(0.1), None, None, None], 5.0);
        assert_eq!((unknown.verdict, unknown.expanded), (Verdict::NoUncertainty, None));
    }
}
