//! The representations of a finished job: its program or its table of residuals, its report, its plot.

use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use http::header::{CONTENT_DISPOSITION, CONTENT_TYPE, LOCATION};
use http::{HeaderMap, HeaderValue};

use crate::http::AppState;
use crate::http::conditional::tagged;
use crate::http::contour_figure::program_contour_error;
use crate::http::extract::json_response;
use crate::http::problem::{Problem, ProblemType};
use crate::http::range::{Asked, asked, dressed};
use crate::http::stored::{StoredBody, stored_body};
use crate::jobs::{ResidualFault, one_pass_figure, verification_figure, wear_figure};
use crate::store::{JobRow, StoredThing, verify_text};
use crate::wire::{
    CcParameters, CcReport, CompensationParameters, CompensationReport, JobOperation, JobState, ServoReport,
    VerificationReport, WearReport,
};

/// Media types of a program.
pub(in crate::http) const PROGRAM_TYPES: &[&str] = &["text/plain", "application/octet-stream", "text/csv"];
/// Media types of a report.
pub(in crate::http) const REPORT_TYPES: &[&str] = &["application/json", SVG];
/// Media type of a table.
pub(in crate::http) const CSV: &str = "text/csv";
/// Media type of a plot.
pub(in crate::http) const SVG: &str = "image/svg+xml";

/// The program, streamed from its file.
pub(in crate::http) async fn program(
    app: &AppState,
    job: &JobRow,
    kind: &str,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let sha256 = job.document.output_sha256.as_deref();
    let sha256 = sha256.filter(|_| job.document.operation != JobOperation::Verification);
    let sha256 = sha256.ok_or_else(|| without_result(job, "program"))?;
    // A table stays a table unless the client names another type. Several files are an archive.
    let kind = if is_zip_name(&job.file_name) {
        ZIP
    } else if kind == "text/plain" && job.file_name.to_ascii_lowercase().ends_with(".csv") {
        "text/csv"
    } else {
        kind
    };
    let name = match job.document.operation {
        JobOperation::Posting => format!("{}-posted.nc", stem(&job.file_name)),
        _ => compensated_name(&job.file_name),
    };
    let mut response = streamed(app, sha256, kind, &name, headers).await?;
    if let Some(motions) = job.motions_checked {
        response.headers_mut().insert(MOTIONS_CHECKED, HeaderValue::from(motions));
    }
    Ok(response)
}

/// Number of motions that were checked in a compensated program.
const MOTIONS_CHECKED: &str = "trunnion-motions-checked";

/// A table that an operation makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::http) enum Table {
    /// The residuals of a verification.
    Residuals,
    /// The changes that a compensation in one pass made to every motion.
    Changes,
}

impl Table {
    /// Digest of this table of a job, which is its tag.
    pub(in crate::http) fn sha256(self, job: &JobRow) -> Result<&str, Problem> {
        match self {
            Self::Residuals => residuals_sha256(job),
            Self::Changes => {
                let sha256 = job.document.changes_sha256.as_deref();
                sha256.ok_or_else(|| without_result(job, "table of changes"))
            }
        }
    }

    const fn word(self) -> &'static str {
        match self {
            Self::Residuals => "residuals",
            Self::Changes => "changes",
        }
    }
}

/// A table of a job, streamed from its file.
pub(in crate::http) async fn table(
    app: &AppState,
    job: &JobRow,
    table: Table,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let name = format!("{}-{}.csv", stem(&job.file_name), table.word());
    streamed(app, table.sha256(job)?, CSV, &name, headers).await
}

fn residuals_sha256(job: &JobRow) -> Result<&str, Problem> {
    let sha256 = job.document.output_sha256.as_deref();
    let sha256 = sha256.filter(|_| job.document.operation == JobOperation::Verification);
    sha256.ok_or_else(|| without_result(job, "residuals"))
}

/// A stored file with a file name for saving, or the part of it that `headers` ask for.
async fn streamed(
    app: &AppState,
    sha256: &str,
    kind: &str,
    name: &str,
    headers: &HeaderMap,
) -> Result<Response, Problem> {
    let StoredBody { body, asked, length } = stored_body(app.spool.blobs(), sha256, headers).await?;
    let mut response = body.into_response();
    let given = response.headers_mut();
    given.insert(CONTENT_TYPE, HeaderValue::from_str(kind).unwrap_or(HeaderValue::from_static("text/plain")));
    let disposition = format!("attachment; filename=\"{name}\"");
    if let Ok(value) = HeaderValue::try_from(disposition) {
        given.insert(CONTENT_DISPOSITION, value);
    }
    Ok(dressed(&asked, length, response))
}

/// JSON text, or the part of it that `headers` ask for.
pub(in crate::http) fn part_of_json(headers: &HeaderMap, tag: &str, text: String) -> Response {
    let length = text.len() as u64;
    let text = Bytes::from(text);
    let asked = asked(headers, length, tag);
    let part = match &asked {
        Asked::Part(part) => {
            // Both ends are within the text.
            let at = |place: u64| usize::try_from(place).unwrap_or(text.len());
            text.slice(at(part.start)..at(part.end))
        }
        Asked::Whole | Asked::Outside => text,
    };
    dressed(&asked, length, json_response(part))
}

/// The report of a job, verified against its digest.
pub(in crate::http) fn report<'a>(app: &AppState, job: &'a JobRow) -> Result<&'a str, Problem> {
    let text = job.report.as_deref().ok_or_else(|| without_result(job, "report"))?;
    // No report is stored without its digest.
    let sha256 = job.report_sha256.as_deref().unwrap_or_default();
    verify_text(|| StoredThing::Report, text, sha256).map_err(|damaged| app.spool.blobs().noted(damaged))?;
    app.spool.blobs().soundness().sound(sha256);
    Ok(text)
}

/// The plot, drawn from the stored report.
pub(in crate::http) async fn plot(app: &AppState, job: &JobRow) -> Result<Response, Problem> {
    let report = report(app, job)?;
    let figure = match job.document.operation {
        JobOperation::CcCompensation => {
            let report: CcReport = read(report)?;
            let parameters: CcParameters = serde_json::from_value(job.document.parameters.clone())
                .map_err(|fault| Problem::internal(&fault))?;
            let compensator = std::sync::Arc::clone(&app.compensator);
            app.compute.run(move |_stop| compensator.figure(&parameters, &report)).await?
        }
        JobOperation::ServoSimulation => {
            let report: ServoReport = read(report)?;
            let name = job.file_name.clone();
            app.compute.run(move |_stop| program_contour_error(&name, &report)).await?
        }
        JobOperation::WearCompensation => {
            let report: WearReport = read(report)?;
            app.compute.run(move |_stop| wear_figure(&report)).await?
        }
        JobOperation::Compensation => {
            let report: CompensationReport = read(report)?;
            let parameters: CompensationParameters = serde_json::from_value(job.document.parameters.clone())
                .map_err(|fault| Problem::internal(&fault))?;
            app.compute.run(move |_stop| one_pass_figure(&parameters, &report)).await?
        }
        JobOperation::Verification => {
            let report: VerificationReport = read(report)?;
            let (sha256, blobs) = (residuals_sha256(job)?.to_owned(), app.spool.blobs().clone());
            let drawn = app.compute.run(move |_stop| verification_figure(&report, &blobs, &sha256)).await?;
            drawn.map_err(|fault| match fault {
                ResidualFault::Blob(fault) => fault.into(),
                table @ ResidualFault::Table(_) => Problem::internal(&table),
            })?
        }
        JobOperation::Posting => return Err(without_result(job, "plot")),
    };
    Ok(([(CONTENT_TYPE, SVG)], figure).into_response())
}

fn read<T: serde::de::DeserializeOwned>(report: &str) -> Result<T, Problem> {
    serde_json::from_str(report).map_err(|fault| Problem::internal(&fault))
}

/// A job that has just finished, in the form that the client accepts: its program, its report, or its plot.
pub(in crate::http) async fn job(app: &AppState, job: &JobRow, kind: &str) -> Result<Response, Problem> {
    let (tag, response) = match kind {
        "application/json" => (report_tag(job, kind), json_response(report(app, job)?.to_owned())),
        SVG => (report_tag(job, kind), plot(app, job).await?),
        CSV if job.document.operation == JobOperation::Verification => {
            (program_tag(job), table(app, job, Table::Residuals, &HeaderMap::new()).await?)
        }
        _ => (program_tag(job), program(app, job, kind, &HeaderMap::new()).await?),
    };
    let mut response = tagged(&tag, response);
    if let Ok(location) = HeaderValue::try_from(format!("/v1/jobs/{}", job.document.id)) {
        response.headers_mut().insert(LOCATION, location);
    }
    Ok(response)
}

/// Tag of the program, or of the residuals.
pub(in crate::http) fn program_tag(job: &JobRow) -> String {
    job.document.output_sha256.clone().unwrap_or_default()
}

/// Tag of the report in one of its forms.
pub(in crate::http) fn report_tag(job: &JobRow, kind: &str) -> String {
    let digest = job.report_sha256.as_deref().unwrap_or_default();
    if kind == SVG { format!("{digest}-svg") } else { digest.to_owned() }
}

/// The refusal of a result that a job does not have, or does not have yet.
pub(in crate::http) fn without_result(job: &JobRow, what: &str) -> Problem {
    match job.document.state {
        JobState::Succeeded => {
            let detail = format!("the operation of this job makes no {what}");
            Problem::new(ProblemType::ResultNotFound, detail)
        }
        state => Problem::new(ProblemType::JobNotSucceeded, format!("the job is {}", state.as_str())),
    }
}

/// Media type of an archive.
const ZIP: &str = "application/zip";

/// Whether a name is that of an archive.
pub(super) fn is_zip_name(name: &str) -> bool {
    name.to_ascii_lowercase().ends_with(".zip")
}

/// A file's name without its extension.
pub(super) fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// `blade-compensated.nc` for `blade.nc`.
fn compensated_name(name: &str) -> String {
    match name.rsplit_once('.') {
        Some((stem, extension)) if !stem.is_empty() => format!("{stem}-compensated.{extension}"),
        _ => format!("{name}-compensated"),
    }
}
