//! What is sent to receivers, for the description of the interface: an operation that they serve and this service calls.

use utoipa::openapi::{OpenApi as Document, Paths, RefOr, Schema};
use utoipa::{OpenApi, PartialSchema, ToSchema};

use crate::wire::JobDocument;

/// The end of a job, as it is told.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes what is sent")]
struct JobEvent {
    /// What happened.
    r#type: EventType,
    /// When it happened.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    timestamp: String,
    /// The job as it is read, without its progress.
    #[schema(value_type = EndedJob)]
    data: (),
}

/// What happened to a job.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes what is sent")]
enum EventType {
    /// Its result is there.
    #[schema(rename = "job.succeeded")]
    Succeeded,
    /// It was refused; `problem` says why.
    #[schema(rename = "job.failed")]
    Failed,
    /// Its client cancelled it.
    #[schema(rename = "job.cancelled")]
    Cancelled,
}

/// A job but for its progress.
struct EndedJob;

impl PartialSchema for EndedJob {
    fn schema() -> RefOr<Schema> {
        let mut schema = JobDocument::schema();
        if let RefOr::T(Schema::Object(job)) = &mut schema {
            job.properties.remove("progress");
            job.required.retain(|name| name != "progress");
            job.description = Some("A job that has ended, as its end is told.".to_owned());
        }
        schema
    }
}

impl ToSchema for EndedJob {
    fn name() -> std::borrow::Cow<'static, str> {
        "EndedJob".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        JobDocument::schemas(schemas);
    }
}

/// Take the end of a job
///
/// Served by the receiver at `callback_url`. Verify the signature over the bytes of the body, keep `webhook-id`, do nothing
/// when it comes again, and answer 2xx at once; whatever else is answered, the event comes again later (`docs/webhooks.md`).
#[utoipa::path(
    post,
    path = "job-ended",
    tag = "webhooks",
    operation_id = "take_job_end",
    params(
        ("webhook-id" = String, Header, description = "The same in every attempt", example = "msg_0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("webhook-timestamp" = String, Header, description = "Time of the attempt, seconds since 1970", example = "1773480413"),
        ("webhook-signature" = String, Header, description = "One `v1,…` for each secret that signs, parted by spaces",
            example = "v1,K5oZfzN95Z9UVu1EsfQmfVNQhnkZ2pj9o9NDN/H/pI4="),
    ),
    request_body(content = JobEvent, description = "The event", example = json!({
        "type": "job.succeeded", "timestamp": "2026-03-14T09:26:53.589Z", "data": {
            "id": "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60", "machine_id": "example-ac-table", "machine_revision": 1,
            "operation": "cc-compensation", "parameters": {"tool_radius_mm": 5.0}, "state": "succeeded",
            "input_sha256": "0f343b0931126a20f133d67c2b018a3b0f343b0931126a20f133d67c2b018a3b", "surface_sha256": null,
            "output_sha256": "62af8704764faf8ea82fc61ce9c4c3908b6cb97d463a634e9e587d7c885db0ef", "changes_sha256": null,
            "external_id": "WO-4711/20", "callback_url": "https://mes.example.com/trunnion", "attempts": 1, "problem": null,
            "software_version": "0.1.0", "created_at": "2026-03-14T09:26:50.101Z", "started_at": "2026-03-14T09:26:50.104Z",
            "finished_at": "2026-03-14T09:26:53.589Z"}})),
    responses(
        (status = "2XX", description = "It is taken"),
        (status = 410, description = "This receiver wants no more of it"),
    ),
    security(())
)]
#[expect(dead_code, reason = "describes what is sent")]
fn take_job_end() {}

#[derive(OpenApi)]
#[openapi(paths(take_job_end))]
struct Sent;

/// Adds what is sent to the description.
pub(in crate::http) fn describe(document: &mut Document) {
    let mut sent = Sent::openapi();
    if let Some(components) = sent.components.take() {
        document.components.get_or_insert_default().schemas.extend(components.schemas);
    }
    // An entry is named, not found at a path.
    let named = std::mem::take(&mut sent.paths.paths);
    let mut webhooks = Paths::new();
    webhooks.paths =
        named.into_iter().map(|(path, item)| (path.trim_start_matches('/').to_owned(), item)).collect();
    document.webhooks = Some(webhooks);
}
