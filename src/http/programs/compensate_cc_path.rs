//! Compensates the CC path of a program.

use axum::extract::{Request, State};
use axum::response::Response;
use http::HeaderValue;
use http::header::LOCATION;

use super::answer::{self, SVG};
use super::upload::{Upload, take};
use crate::http::AppState;
use crate::http::conditional::tagged;
use crate::http::extract::{Path, json_response};
use crate::http::idempotency::{key, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::{CompensationRequest, compensate};
use crate::store::{JobRow, Remembered};
use crate::wire::CcParameters;

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, ProgramFault, OutOfTravel, ToleranceOutOfReach, TooCostly, Busy
);

/// What can be answered: the program first.
const OFFERS: &[&str] = &["text/plain", "application/octet-stream", "text/csv", "application/json", SVG];

/// A program with its parameters in one multipart body.
#[derive(Debug, utoipa::ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct ProgramForm {
    /// The parameters; in the query where this field is absent.
    parameters: Option<CcParameters>,
    /// The program.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
}

/// Compensate the CC path of a program
///
/// The answer is the compensated program, same dialect and line ends; with `Accept: application/json` its report,
/// with `image/svg+xml` the plot before and after. It is written out and verified before the first byte is
/// answered, and kept as a job.
#[utoipa::path(
    post,
    path = "/v1/machines/{machine_id}/cc-compensation",
    tag = "programs",
    operation_id = "compensate_cc_path",
    params(
        ("machine_id" = String, Path, description = "The machine", example = "example-ac-table"),
        CcParameters,
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request is answered as before"),
    ),
    request_body(
        content(
            (String = "text/plain", example = "G90 G21 G94\nG1 X10.000 Y0.000 Z5.000 A10.000 C20.000 F1000\nG1 X20.000 Y0.000 Z5.000 A25.000 C60.000\nM30\n"),
            (ProgramForm = "multipart/form-data"),
        ),
        description = "The program as text/*, application/octet-stream or without a type, or a multipart form",
    ),
    responses(
        (status = 200, description = "The compensated program, its report or its plot, by Accept",
            content((String = "text/plain"), (crate::wire::CcReport = "application/json"), (String = "image/svg+xml")),
            headers(
                ("Location" = String, description = "The job"),
                ("ETag" = String, description = "Tag of what is answered"),
                ("Content-Disposition" = String, description = "File name of the program"),
            )),
        Refusals,
    )
)]
pub(super) async fn compensate_cc_path(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let kind = choose(&parts.headers, OFFERS)?;
    let key = key(&parts)?;
    let machine =
        app.store.machine(&machine_id).await?.ok_or_else(|| Problem::machine_not_found(&machine_id))?;
    let upload: Upload<CcParameters> = take(&app, &parts, body).await?;
    let said = [upload.program.sha256(), serde_json::to_string(&upload.parameters).unwrap_or_default()];
    let used = used(&parts, key, &[&said[0], &said[1]]);
    if let Some(used) = &used {
        match app.store.remembered(used).await? {
            Some(Remembered::Same(job)) => return answered(&app, &job, kind).await,
            Some(Remembered::Other) => {
                let detail = "the Idempotency-Key was first used for another request";
                return Err(Problem::new(ProblemType::KeyReused, detail));
            }
            None => {}
        }
    }
    let faulty = |faults| Problem::invalid(ProblemType::InvalidRequest, faults);
    let tool = upload.parameters.check().map_err(faulty)?;
    let machine_revision = machine.document.revision;
    let (_, machine) = machine
        .document
        .profile
        .into_machine()
        .map_err(|_stored_is_sound| Problem::internal(&"a stored profile is no longer accepted"))?;
    let file_name = file_name(&upload);
    let Upload { program, parameters, .. } = upload;
    let max_cost_s = app.settings.max_cost_s;
    let request = CompensationRequest {
        machine_id,
        machine_revision,
        machine,
        parameters,
        tool,
        program,
        file_name,
        used,
        max_cost_s,
    };
    let job =
        compensate(&app.compute, &app.compensator, &app.store, &app.spool, &app.sources, request).await?;
    answered(&app, &job, kind).await
}

async fn answered(app: &AppState, job: &JobRow, kind: &str) -> Result<Response, Problem> {
    let (tag, response) = match kind {
        "application/json" => {
            (answer::report_tag(job, kind), json_response(job.report.clone().unwrap_or_default()))
        }
        SVG => (answer::report_tag(job, kind), answer::plot(app, job).await?),
        _ => (answer::program_tag(job), answer::program(app, job, kind).await?),
    };
    let mut response = tagged(&tag, response);
    if let Ok(location) = HeaderValue::try_from(format!("/v1/jobs/{}", job.document.id)) {
        response.headers_mut().insert(LOCATION, location);
    }
    Ok(response)
}

/// The upload's name, or eight digits of its digest with an extension that fits.
fn file_name(upload: &Upload<CcParameters>) -> String {
    upload.file_name.clone().unwrap_or_else(|| {
        let csv = upload.media_type.as_deref() == Some("text/csv");
        let digest = upload.program.sha256();
        format!("{}.{}", digest.get(..8).unwrap_or(&digest), if csv { "csv" } else { "nc" })
    })
}
