//! Accepts the programs of an archive as jobs.

use axum::extract::{Request, State};
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use http::request::Parts;

use super::create_job::JobRequestDoc;
use super::ordered::{Ordered, Sent, invalid, read_order};
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query, parsed_bytes};
use crate::http::idempotency::{key, key_of_part, remembered, used};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::programs::several::{archive_refused, refuse_joined};
use crate::http::programs::upload::{Form, FormFields, Part, clean_name, take_form};
use crate::http::refusals::refusals;
use crate::jobs::{JobOrder, Unpacked, memory, unpack};
use crate::store::{Draft, JobRow, KeyUse};
use crate::wire::{BatchedJob, JobBatch, NoParameters};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, TooCostly, QueueFull
);

/// The request for the jobs and their programs in one multipart body.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes the multipart body")]
struct JobBatchForm {
    /// The request for each of the jobs.
    job: JobRequestDoc,
    /// A zip archive with 1 to 100 programs. Hidden files are left out.
    #[schema(value_type = String, format = Binary)]
    programs: Vec<u8>,
}

/// Post many jobs
///
/// Queues one job for each program of a zip archive, all with the same machine, operation and parameters. All of them
/// are accepted or none. The programs together may have as many bytes as one program (`max_body_bytes`). A job
/// that needs an STL file of the part cannot be in an archive: post it to `/v1/jobs`.
#[operation(
    post,
    path = "/v1/job-batches",
    tag = "jobs",
    operation_id = "create_job_batch",
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request creates the jobs only once"),
    ),
    request_body(
        content(
            (JobBatchForm = "multipart/form-data", example = json!({
                "job": {
                    "machine_id": "example-ac-table", "operation": "cc-compensation",
                    "parameters": {"tool_radius_mm": 5.0, "work_offset_mm": [12.0, -7.0, 35.0]}, "external_id": "WO-4711/20"
                },
                "programs": "(the bytes of programs.zip)",
            })),
        ),
    ),
    responses(
        (status = 202, description = "The accepted jobs", body = JobBatch),
        Refusals,
    )
)]
pub(super) async fn create_job_batch(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    caller: Caller,
    request: Request,
) -> Result<Response, Problem> {
    choose(request.headers(), &["application/json"])?;
    let (parts, body) = request.into_parts();
    let key = key(&parts)?;
    let names = FormFields { document: "job", file: "programs", part: Part::Unseen, several: false };
    let form = take_form(&app, &parts, body, names, |text| read_order(&app, text)).await?;
    let Form { document, program: archive, .. } = form;
    let order = document.ok_or_else(|| invalid("/job", "the field job is missing"))?;
    caller.must_reach(&order.machine_id)?;
    let used = used(&app, &parts, key, &[&archive.sha256(), &order.canonical]);
    // The files of an archive stay open until its jobs are accepted, so archives take turns.
    let _turn = app.archives.lock().await;
    let (spool, limit) = (app.spool.of_asker(), app.settings.max_body_bytes);
    let unpacked = app.compute.run(move |stop| unpack(&archive, &spool, limit, stop)).await?;
    let Unpacked { programs, left_out } = unpacked.map_err(|fault| archive_refused(fault, "programs"))?;
    let (paths, drafts): (Vec<_>, Vec<_>) = programs.into_iter().unzip();
    drafts.iter().try_for_each(refuse_joined)?;
    let keys: Vec<_> = (0..paths.len()).map(|part| key_of_part(used.as_ref(), part)).collect();
    let mut jobs = earlier(&app, &keys).await?;
    if jobs.iter().all(Option::is_none) {
        let accepted = accept(&app, &parts, &caller, order, (&paths, drafts, keys)).await?;
        jobs = accepted.into_iter().map(Some).collect();
    }
    let items = paths.into_iter().zip(jobs);
    let items = items.filter_map(|(path, job)| Some(BatchedJob { path, job: job?.document })).collect();
    Ok((StatusCode::ACCEPTED, Json(JobBatch { items, left_out })).into_response())
}

/// The jobs that the same request created before, by the keys of its parts.
async fn earlier(app: &AppState, keys: &[Option<KeyUse>]) -> Result<Vec<Option<JobRow>>, Problem> {
    let mut jobs = Vec::with_capacity(keys.len());
    for key in keys {
        jobs.push(remembered(app, key.as_ref()).await?);
    }
    Ok(jobs)
}

/// Accepts a job for each program.
async fn accept(
    app: &AppState,
    parts: &Parts,
    caller: &Caller,
    order: JobOrder,
    (paths, drafts, keys): (&[String], Vec<Draft>, Vec<Option<KeyUse>>),
) -> Result<Vec<JobRow>, Problem> {
    let most = app.queue.most_of_caller();
    if drafts.len() as u64 > most {
        let detail = format!(
            "the archive has {} programs, but at most {most} jobs of one caller may wait (max_queued_jobs, \
             max_share_per_caller). Divide the archive",
            drafts.len()
        );
        return Err(invalid("/programs", detail));
    }
    app.queue.check_room(drafts.len()).await?;
    let parameter_bytes = parsed_bytes(order.canonical.as_bytes());
    let ordered = Ordered::new(app, parts, caller, order).await?;
    let mut jobs = Vec::with_capacity(drafts.len());
    for ((path, program), used) in paths.iter().zip(drafts).zip(keys) {
        let file_name = clean_name(path).unwrap_or_else(|| "program.nc".to_owned());
        let job = ordered.draw_up(app, Sent { program, surface: None, file_name, used }).await;
        let job = job.map_err(|problem| problem.about(path))?;
        // The store gets a copy.
        memory::keep(2 * (parameter_bytes + job.text_bytes()))?;
        jobs.push(job);
    }
    Ok(app.queue.accept(jobs).await?)
}
