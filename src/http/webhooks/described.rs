//! The messages to receivers, for the description of the interface: an operation that the receiver serves and this
//! service calls.

#[cfg(test)]
use utoipa::openapi::{OpenApi as Document, Paths, RefOr, Schema};
#[cfg(test)]
use utoipa::{OpenApi, PartialSchema};

use crate::description::ToSchema;
use crate::wire::JobDocument;

/// The message about the end of a job.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes what is sent")]
struct JobEvent {
    /// The event.
    r#type: EventType,
    /// Time of the event.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    timestamp: String,
    /// The job as clients read it, without its progress.
    #[schema(value_type = EndedJob)]
    data: (),
}

/// The way in which a job ended.
#[derive(Debug, ToSchema)]
#[expect(dead_code, reason = "describes what is sent")]
enum EventType {
    /// The job has succeeded; its result is ready.
    #[schema(rename = "job.succeeded")]
    Succeeded,
    /// The job failed; `problem` gives the reason.
    #[schema(rename = "job.failed")]
    Failed,
    /// The client cancelled the job.
    #[schema(rename = "job.cancelled")]
    Cancelled,
}

/// A job without its progress.
struct EndedJob;

#[cfg(test)]
impl PartialSchema for EndedJob {
    fn schema() -> RefOr<Schema> {
        let mut schema = JobDocument::schema();
        if let RefOr::T(Schema::Object(job)) = &mut schema {
            job.properties.remove("progress");
            job.required.retain(|name| name != "progress");
            job.description = Some("A job that has ended.".to_owned());
        }
        schema
    }
}

#[cfg(test)]
impl ToSchema for EndedJob {
    fn name() -> std::borrow::Cow<'static, str> {
        "EndedJob".into()
    }

    fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
        JobDocument::schemas(schemas);
    }
}

/// Receive the end of a job
///
/// The receiver at `callback_url` serves this operation. Verify the signature over the bytes of the body, store
/// `webhook-id`, ignore a message whose id came before, and answer 2xx at once. After any other answer the message
/// comes again (`docs/webhooks.md`).
#[utoipa::path(
    post,
    path = "job-ended",
    tag = "webhooks",
    operation_id = "take_job_end",
    params(
        ("webhook-id" = String, Header, description = "Id of the message, the same in every attempt", example = "msg_0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("webhook-timestamp" = String, Header, description = "Time of the attempt, seconds since 1970", example = "1773480413"),
        ("webhook-signature" = String, Header, description = "One `v1,…` for each secret that signs, separated by spaces",
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
        (status = "2XX", description = "The receiver accepts the event"),
        (status = 410, description = "The receiver wants no more attempts"),
    ),
    security(())
)]
#[expect(dead_code, reason = "describes what is sent")]
fn take_job_end() {}

#[derive(OpenApi)]
#[openapi(paths(take_job_end))]
struct Sent;

/// Adds the messages to the description.
pub(in crate::http) fn describe_messages(document: &mut Document) {
    let mut sent = Sent::openapi();
    if let Some(components) = sent.components.take() {
        document.components.get_or_insert_default().schemas.extend(components.schemas);
    }
    // An entry is identified by name, not by a path.
    let named = std::mem::take(&mut sent.paths.paths);
    let mut webhooks = Paths::new();
    webhooks.paths =
        named.into_iter().map(|(path, item)| (path.trim_start_matches('/').to_owned(), item)).collect();
    document.webhooks = Some(webhooks);
}
