//! Accepts a job.

use axum::extract::{Request, State};
use axum::response::{IntoResponse, Response};
use http::header::LOCATION;
use http::{HeaderValue, StatusCode};
use serde::Serialize;

use super::job_tag;
use super::ordered::{Ordered, Sent, invalid, read_order};
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::conditional::tagged;
use crate::http::extract::{Json, Query};
use crate::http::idempotency::{key, remembered, used};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::programs::several::{ProgramFile, calls_no_files};
use crate::http::programs::upload::{Form, FormFields, Part, take_form};
use crate::http::refusals::refusals;
use crate::store::{Draft, JobRow};
use crate::wire::{
    CcParameters, CompensationParameters, JobOperation, NoParameters, PostingParameters,
    ServoProgramParameters, VerificationParameters, WearParameters,
};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, TooCostly, QueueFull
);

/// A job with its program in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct JobForm {
    /// The request for the job.
    job: JobRequestDoc,
    /// The program.
    #[schema(value_type = String, format = Binary)]
    program: Vec<u8>,
    /// Files that the program calls, each under the name that the calls use.
    subprogram: Option<Vec<ProgramFile>>,
    /// Main program, if `program` is a zip archive of several files.
    main: Option<String>,
    /// The part's surface as STL, for operations that use it.
    #[schema(value_type = Option<String>, format = Binary)]
    surface: Option<Vec<u8>>,
}

/// The request for a job.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = JobRequest)]
pub(super) struct JobRequestDoc {
    /// Id of the machine; its current revision is fixed when the job is accepted.
    #[schema(example = "example-ac-table")]
    machine_id: String,
    /// The operation to compute.
    operation: JobOperation,
    /// Parameters, the same as at the operation's own endpoint.
    parameters: AnyParameters,
    /// Your own id of the job.
    #[schema(min_length = 1, max_length = 200, example = "WO-4711/20")]
    external_id: Option<String>,
    /// Address that gets a webhook when the job ends. It must be an `http` or `https` address that is public or that
    /// the operator allows. The webhook is signed as Standard Webhooks describes.
    #[schema(max_length = 2048, example = "https://mes.example.com/trunnion")]
    callback_url: Option<String>,
}

/// The parameters of any operation.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the request")]
enum AnyParameters {
    /// Parameters of `cc-compensation`.
    CcCompensation(CcParameters),
    /// Parameters of `wear-compensation`.
    WearCompensation(WearParameters),
    /// Parameters of `compensation`.
    Compensation(CompensationParameters),
    /// Parameters of `verification`.
    Verification(VerificationParameters),
    /// Parameters of `servo-simulation`.
    ServoSimulation(ServoProgramParameters),
    /// Parameters of `posting`.
    Posting(PostingParameters),
}

/// Post a job
///
/// Queues any operation on a program; it is computed when its turn comes. Everything that can be checked without
/// reading the program is checked now. An accepted job is on the disk: it survives the end of the process and is
/// finished once. Read the job at `Location`, or follow its events.
#[operation(
    post,
    path = "/v1/jobs",
    tag = "jobs",
    operation_id = "create_job",
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request creates only one job"),
    ),
    request_body(
        content(
            (JobForm = "multipart/form-data", example = json!({
                "job": {
                    "machine_id": "example-ac-table", "operation": "cc-compensation",
                    "parameters": {"tool_radius_mm": 5.0, "work_offset_mm": [12.0, -7.0, 35.0]}, "external_id": "WO-4711/20"
                },
                "program": crate::http::programs::EXAMPLE_PROGRAM,
            })),
        ),
    ),
    responses(
        (status = 202, description = "The accepted job", body = crate::wire::JobDocument,
            headers(
                ("Location" = String, description = "The job"),
                ("ETag" = String, description = "Tag of the content"),
            )),
        Refusals,
    )
)]
pub(super) async fn create_job(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    caller: Caller,
    request: Request,
) -> Result<Response, Problem> {
    choose(request.headers(), &["application/json"])?;
    let (parts, body) = request.into_parts();
    let key = key(&parts)?;
    let names = FormFields { document: "job", file: "program", part: Part::Seen, several: true };
    let form = take_form(&app, &parts, body, names, |text| read_order(&app, text)).await?;
    let Form { document, program, file_name, has_files, surface } = form;
    let order = document.ok_or_else(|| invalid("/job", "the field job is missing"))?;
    caller.must_reach(&order.machine_id)?;
    let mut said = vec![program.sha256(), order.canonical.clone()];
    said.extend(surface.as_ref().map(Draft::sha256));
    let used = used(&app, &parts, key, &said.iter().map(String::as_str).collect::<Vec<_>>());
    if let Some(job) = remembered(&app, used.as_ref()).await? {
        return Ok(accepted(job));
    }
    if surface.is_some() && !order.looks_at_part {
        return Err(invalid("/surface", "this operation does not use a surface; remove the field"));
    }
    if has_files && !order.calls_files {
        return Err(calls_no_files());
    }
    let ordered = Ordered::new(&app, &parts, &caller, order).await?;
    app.queue.check_room(1).await?;
    let job = ordered.draw_up(&app, Sent { program, surface, file_name, used }).await?;
    let job = app.queue.accept(vec![job]).await?.pop().ok_or_else(|| Problem::internal(&NoJob))?;
    Ok(accepted(job))
}

/// An accepted job is missing: a fault of the service.
#[derive(Debug, thiserror::Error)]
#[error("the queue accepted no job")]
struct NoJob;

fn accepted(job: JobRow) -> Response {
    let location = format!("/v1/jobs/{}", job.document.id);
    let tag = job_tag(&job.document);
    let mut response = tagged(&tag, (StatusCode::ACCEPTED, Json(job.document)).into_response());
    if let Ok(location) = HeaderValue::try_from(location) {
        response.headers_mut().insert(LOCATION, location);
    }
    response
}
