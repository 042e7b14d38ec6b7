//! Calibration runs of a machine: posted, listed, compared, followed over time, applied, exported.

mod apply_calibration;
mod compare_calibrations;
mod create_calibration;
mod export_calibration;
mod figures;
mod get_calibration;
mod get_run;
mod get_trend;
mod list_calibrations;
mod report_markup;
mod report_page;
mod report_results;
mod report_setup;

use http::HeaderMap;

use super::AppState;
use super::conditional::unless_known;
use super::described::resource;
use super::extract::json_response;
use super::problem::Problem;
use crate::store::{CalibrationRow, Revision};

resource! {
    create_calibration::create_calibration,
    list_calibrations::list_calibrations,
    get_trend::get_calibration_trend,
    get_calibration::get_calibration,
    get_run::get_calibration_run,
    compare_calibrations::compare_calibrations,
    export_calibration::export_calibration,
    apply_calibration::apply_calibration,
}

/// One run of a machine.
async fn find(app: &AppState, machine_id: &str, id: &str) -> Result<CalibrationRow, Problem> {
    if let Some(found) = app.store.calibration(machine_id, id).await? {
        return Ok(found);
    }
    ever_existed(app, machine_id).await?;
    Err(Problem::calibration_not_found(machine_id, id))
}

/// The revision that a run measured.
async fn measured_revision(app: &AppState, run: &CalibrationRow) -> Result<Revision, Problem> {
    let (id, revision) = (&run.document.machine_id, run.document.machine_revision);
    let found = app.store.machine_revision(id, revision).await?;
    found.ok_or_else(|| Problem::internal(&"the revision that a calibration names is not stored"))
}

/// A deleted machine keeps its history.
async fn ever_existed(app: &AppState, machine_id: &str) -> Result<(), Problem> {
    let first = app.store.machine_revision(machine_id, 1).await?;
    first.map(drop).ok_or_else(|| Problem::machine_not_found(machine_id))
}

/// Digits of the digest in a run's tag.
const DIGEST_DIGITS: usize = 16;

fn tag(run: &CalibrationRow) -> &str {
    run.document_sha256.get(..DIGEST_DIGITS).unwrap_or(&run.document_sha256)
}

/// The run's document, or 304 if the client has it.
fn document(headers: &HeaderMap, run: &CalibrationRow) -> Result<axum::response::Response, Problem> {
    unless_known(headers, tag(run), || json_response(run.text.clone()))
}
