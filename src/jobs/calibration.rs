//! Evaluation of calibration runs: from the posted document to the results about the machine.

use jiff::{SignedDuration, Timestamp};

use super::timestamp;
use crate::calibration::rotary_sphere::identify_spheres;
use crate::calibration::{Identified, identify};
use crate::machine::Machine;
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
