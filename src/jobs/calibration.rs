//! Evaluation of calibration runs: from the posted document to the results about the machine.

use jiff::{SignedDuration, Timestamp};

use super::timestamp;
use crate::calibration::rotary_sphere::identify_spheres;
use crate::calibration::{Identified, UncertaintyBudget, identify, uncertainty_budget};
use crate::machine::Machine;
use crate::store::CalibrationAge;
use crate::wire::{
    CalibrationDocument, CalibrationHead, CalibrationKind, CalibrationRequest, Fault, FaultList, fit_fault,
    sphere_fault,
};

/// How far ahead of now a measurement may be: the clocks of machines are sometimes set to local time.
const MAX_AHEAD: SignedDuration = SignedDuration::from_hours(24);

/// The time of a measurement as it is stored (RFC 3339, UTC, milliseconds).
///
/// # Errors
/// The text is not a time, or the time is before 1970 or more than 24 h after `now`.
pub fn measured_at(text: &str, now: Timestamp) -> Result<String, Fault> {
    let refuse = |detail: String| Err(Fault::new("/measured_at", detail));
    let Ok(time) = text.parse::<Timestamp>() else {
        return refuse(format!(
            "{text:?} is not an RFC 3339 time with its offset, such as 2026-03-14T09:26:53Z"
        ));
    };
    if time < Timestamp::UNIX_EPOCH {
        return refuse("the measurement is before 1970; correct measured_at".to_owned());
    }
    if time > now.checked_add(MAX_AHEAD).unwrap_or(Timestamp::MAX) {
        return refuse(format!(
            "{} is more than 24 h ahead of the present time {}; correct measured_at",
            timestamp(time),
            timestamp(now)
        ));
    }
    Ok(timestamp(time))
}

/// The time that bounds a list, in the form in which stored times are compared.
///
/// # Errors
/// The text is not a time.
pub fn time_bound(pointer: &str, text: &str) -> Result<String, Fault> {
    let time = text.parse::<Timestamp>().ok().filter(|time| *time >= Timestamp::UNIX_EPOCH);
    time.map(timestamp).ok_or_else(|| {
        Fault::new(pointer, format!("{text:?} is not an RFC 3339 time with its offset, in 1970 or later"))
    })
}

/// The two ends of a period in the stored form, each if it is stated. Faults are added to `faults`, with these
/// pointers.
pub fn period(
    [from_pointer, to_pointer]: [&'static str; 2],
    from: Option<&str>,
    to: Option<&str>,
    faults: &mut FaultList,
) -> (Option<String>, Option<String>) {
    let mut bound = |pointer, text: Option<&str>| {
        text.and_then(|text| time_bound(pointer, text).map_err(|fault| faults.push(|| fault)).ok())
    };
    let (from, to) = (bound(from_pointer, from), bound(to_pointer, to));
    if let (Some(from), Some(to)) = (&from, &to)
        && from > to
    {
        faults.push(|| Fault::new(to_pointer, format!("{to} is before {from}, where the period begins")));
    }
    (from, to)
}

/// The results of a run.
///
/// # Errors
/// Every fault of the run, `known` first.
pub fn evaluate(
    request: &CalibrationRequest,
    machine: &Machine,
    head: CalibrationHead<'_>,
    known: Vec<Fault>,
) -> Result<CalibrationDocument, Vec<Fault>> {
    let mut faults = FaultList::default();
    for fault in known {
        faults.push(|| fault);
    }
    request.check(&mut faults);
    match request.kind {
        CalibrationKind::RtcpBallbar => {
            let found = ballbar(request, machine, faults)?;
            Ok(CalibrationDocument::of_ballbar(head, request, machine, &found))
        }
        CalibrationKind::RotarySphere => {
            let run = request.to_spheres(machine, &mut faults);
            let found = run.map(|run| identify_spheres(machine, &run));
            if let Some(Err(found)) = &found {
                for fault in found {
                    faults.push(|| sphere_fault(fault));
                }
            }
            faults.into_result()?;
            let found = found.and_then(Result::ok).ok_or_else(Vec::new)?;
            Ok(CalibrationDocument::of_spheres(head, request, machine, &found))
        }
    }
}

/// The fit of a ball-bar run.
///
/// # Errors
/// Every fault of the run.
pub fn evaluate_ballbar(request: &CalibrationRequest, machine: &Machine) -> Result<Identified, Vec<Fault>> {
    ballbar(request, machine, FaultList::default())
}

/// The uncertainty budget of a ball-bar run.
///
/// # Errors
/// Every fault of the run.
pub fn evaluate_budget(
    request: &CalibrationRequest,
    machine: &Machine,
) -> Result<UncertaintyBudget, Vec<Fault>> {
    let mut faults = FaultList::default();
    let run = request.to_ballbar(machine, &mut faults);
    faults.into_result()?;
    let run = run.ok_or_else(Vec::new)?;
    let inputs = request.input_uncertainties();
    uncertainty_budget(machine, &run, &inputs).map_err(|faults| faults.iter().map(fit_fault).collect())
}

/// Hours of a day.
const HOURS_PER_DAY: f64 = 24.0;

/// When the next calibration is due, this number of days after a measurement; `None` if that is no time.
#[must_use]
pub fn due_at(measured_at: &str, due_days: f64) -> Option<Timestamp> {
    let measured = measured_at.parse::<Timestamp>().ok()?;
    let after = SignedDuration::try_from_secs_f64(due_days * HOURS_PER_DAY * 3600.0).ok()?;
    measured.checked_add(after).ok()
}

/// The days from one time to a later one; negative if it is earlier.
fn days_between(from: Timestamp, to: Timestamp) -> f64 {
    to.duration_since(from).as_secs_f64() / (HOURS_PER_DAY * 3600.0)
}

/// How old the calibration of a machine is.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationReading {
    /// The machine.
    pub machine_id: String,
    /// Days since the newest measurement; `None` if the machine has no run.
    pub age_days: Option<f64>,
    /// Days until the next calibration is due, negative if it is overdue; `None` without a measurement or a period.
    pub due_in_days: Option<f64>,
    /// Whether the profile states a period and there is no measurement.
    pub is_missing: bool,
}

impl CalibrationReading {
    /// The reading at this time.
    #[must_use]
    pub fn of(age: CalibrationAge, now: Timestamp) -> Self {
        let CalibrationAge { machine_id, measured_at, due_days } = age;
        let measured = measured_at.as_deref().and_then(|text| text.parse::<Timestamp>().ok());
        let due = measured_at.as_deref().zip(due_days).and_then(|(at, days)| due_at(at, days));
        Self {
            machine_id,
            age_days: measured.map(|measured| days_between(measured, now)),
            due_in_days: due.map(|due| days_between(now, due)),
            is_missing: measured.is_none() && due_days.is_some(),
        }
    }
}

fn ballbar(
    request: &CalibrationRequest,
    machine: &Machine,
    mut faults: FaultList,
) -> Result<Identified, Vec<Fault>> {
    let run = request.to_ballbar(machine, &mut faults);
    faults.into_result()?;
    let run = run.ok_or_else(Vec::new)?;
    identify(machine, &run).map_err(|faults| faults.iter().map(fit_fault).collect())
}
