//! Compensates the CC path of a program.

use axum::extract::{Request, State};
use axum::response::Response;

use super::answer::{self, SVG};
use super::upload::{Upload, take};
use crate::http::AppState;
use crate::http::current_machine::{CurrentMachine, current_machine};
use crate::http::extract::Path;
use crate::http::idempotency::{key, remembered, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::{CompensationRequest, ProgramJob, compensate};
use crate::wire::{CcParameters, JobOperation};

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
            (ProgramForm = "multipart/form-data", example = json!({
                "parameters": {"tool_radius_mm": 5.0, "contact": "tip"},
                "program": "G90 G21 G94\nG1 X10.000 Y0.000 Z5.000 A10.000 C20.000 F1000\nG1 X20.000 Y0.000 Z5.000 A25.000 C60.000\nM30\n",
            })),
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
    let CurrentMachine { revision, machine, .. } = current_machine(&app, &machine_id).await?;
    let upload: Upload<CcParameters> = take(&app, &parts, body).await?;
    let said = [upload.program.sha256(), serde_json::to_string(&upload.parameters).unwrap_or_default()];
    let used = used(&app, &parts, key, &[&said[0], &said[1]]);
    if let Some(job) = remembered(&app, used.as_ref()).await? {
        return answer::job(&app, &job, kind).await;
    }
    let faulty = |faults| Problem::invalid(ProblemType::InvalidRequest, faults);
    let tool = upload.parameters.check().map_err(faulty)?;
    let file_name = upload.name();
    let Upload { program, parameters, .. } = upload;
    let job = ProgramJob {
        machine_id,
        machine_revision: revision,
        operation: JobOperation::CcCompensation,
        parameters: serde_json::to_value(&parameters).map_err(|fault| Problem::internal(&fault))?,
        program,
        file_name,
        used,
    };
    let request = CompensationRequest { machine, parameters, tool, max_cost_s: app.settings.max_cost_s };
    let job = compensate(&app.compute, &app.compensator, &app.store, &app.spool, &app.sources, job, request);
    answer::job(&app, &job.await?, kind).await
}
