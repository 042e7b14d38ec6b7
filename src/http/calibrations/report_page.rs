//! A run as a report for people to read, print, sign and file.

use super::figures::{eccentricities, residuals};
use super::measured_revision;
use super::report_markup::{escaped, facts, given, section};
use super::report_results::{Results, for_profile, results};
use super::report_setup::{identity, inseparable, questions, setup, time};
use crate::http::AppState;
use crate::http::problem::Problem;
use crate::jobs::{due_at, evaluate_budget, timestamp};
use crate::store::{CalibrationRow, CalibrationUse, Revision};
use crate::wire::{CalibrationDocument, CalibrationRequest, MachineProfile};

/// The look of the page, on a screen and on A4 paper.
const STYLE: &str = include_str!("report.css");

/// The page. Names, limits and the period of calibrations come from the machine's current profile; if the machine is
/// deleted, from the measured one.
pub(super) async fn page(app: &AppState, run: CalibrationRow) -> Result<String, Problem> {
    let measured = measured_revision(app, &run).await?;
    let current = app.store.machine(&run.document.machine_id).await?;
    let uses = app.store.calibration_uses(&run.document.machine_id, &run.document.id).await?;
    let figures = residuals(app, &run, None).await?;
    let CalibrationRow { document, run, .. } = run;
    let work = app.compute.run(move |_stop| {
        let bars = document.ball_bar.as_ref().map(|_found| eccentricities(&document));
        Ok::<_, Problem>((bars, report(&document, &run, measured, current.as_ref(), &uses)?))
    });
    // Two profiles are in it.
    let (bars, text) = Box::pin(work).await??;
    let figures = bars.iter().chain(&figures);
    let figures: Vec<String> = figures.map(|figure| format!("<figure>{figure}</figure>\n")).collect();
    Ok(format!("{text}\n{}\n</main></html>\n", section("Figures", &figures.concat())))
}

/// Everything before the figures.
fn report(
    document: &CalibrationDocument,
    run: &str,
    measured: Revision,
    current: Option<&Revision>,
    uses: &[CalibrationUse],
) -> Result<String, Problem> {
    let request: CalibrationRequest = serde_json::from_str(run).map_err(|fault| Problem::internal(&fault))?;
    let stated = current.map_or_else(|| measured.document.clone(), |current| current.document.clone());
    let (profile, revision) = (&stated.profile, stated.revision);
    let (_, machine) = measured
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    let budget = document
        .ball_bar
        .as_ref()
        .map(|_found| evaluate_budget(&request, &machine))
        .transpose()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored run is no longer accepted"))?;
    let found = Results {
        document,
        request: &request,
        machine: &machine,
        budget: budget.as_ref(),
        profile,
        revision,
    };
    let title = format!("Calibration report: {}", escaped(&profile.name));
    let parts = [
        format!(
            "<!doctype html>\n<html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\">\
             <meta name=color-scheme content=\"light dark\"><title>{title}</title>\n<style>\n{STYLE}</style>\n\
             <main>\n<h1>{title}</h1>"
        ),
        identity(document, profile, revision),
        results(found),
        section("What cannot be separated", &inseparable(document)),
        section("To check", &questions(document)),
        section("Set-up", &setup(document, &request)),
        section("Values for the profile", &for_profile(found)),
        section("Use", &usage(document, profile, current, uses)),
        signatures(),
    ];
    Ok(parts.join("\n"))
}

/// Whether the run was applied, and when the next one is due.
fn usage(
    document: &CalibrationDocument,
    profile: &MachineProfile,
    current: Option<&Revision>,
    uses: &[CalibrationUse],
) -> String {
    let applied: Vec<String> = uses
        .iter()
        .map(|one| {
            let key = match &one.key_id {
                Some(key_id) => format!("by key <code>{}</code>", escaped(key_id)),
                None => "without a key".to_owned(),
            };
            format!("{} {key}: revision {}", time(&one.at), one.revision)
        })
        .collect();
    let applied = if applied.is_empty() { "not applied".to_owned() } else { applied.join("<br>") };
    let now = match current {
        None => "the machine is deleted".to_owned(),
        Some(Revision { document: machine, calibration_id, .. }) => {
            let revision = machine.revision;
            match calibration_id {
                Some(id) if *id == document.id => format!("revision {revision} has the errors of this run"),
                Some(id) => format!("revision {revision} has the errors of run <code>{}</code>", escaped(id)),
                None => format!("revision {revision} was stored without applying a run"),
            }
        }
    };
    let due = match profile.calibration_due_days {
        None => "no period stated (<code>calibration_due_days</code> of the profile)".to_owned(),
        Some(days) => {
            let date = due_at(&document.measured_at, days).map(timestamp);
            let date = date.as_deref().and_then(|text| text.get(..10)).unwrap_or("after the year 9999");
            format!("{date}, {} days after this measurement", given(days))
        }
    };
    facts(&[("Applied", applied), ("The machine now", now), ("Next calibration due", due)])
}

fn signatures() -> String {
    let line = |role: &str| format!("<div><p>{role}</p><p class=line></p><p>name, date, signature</p></div>");
    format!("<div class=signatures>\n{}\n{}\n</div>", line("Measured"), line("Checked and released"))
}
