//! Can the service work?

use axum::extract::State;
use http::HeaderMap;
use serde::Serialize;

use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::extract::Json;
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::store::SoundnessReading;

refusals!(Refusals: NotAcceptable, ShuttingDown);

/// Whether the service can work.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Readiness {
    /// `ready`; or `degraded` if the service works but some stored data is damaged.
    #[schema(example = "ready")]
    status: &'static str,
    /// Known damage in words; empty if none is known.
    reasons: Vec<String>,
}

/// Can the service work
///
/// 200 if the database answers and the disk can be written (checked at most once a second); 503 if not, and while the
/// service is stopping. If stored data is known to be damaged, the answer is 200 with `degraded` and the reasons:
/// everything else works, and a restart or another instance would not help.
#[operation(
    get,
    path = "/readyz",
    tag = "service",
    operation_id = "get_readiness",
    responses((status = 200, description = "The service can work", body = Readiness, example = json!({"status": "ready", "reasons": []})), Refusals)
)]
pub(super) async fn get_readiness(
    State(app): State<AppState>,
    headers: HeaderMap,
) -> Result<Json<Readiness>, Problem> {
    choose(&headers, &["application/json"])?;
    if app.is_draining() {
        return Err(Problem::new(ProblemType::ShuttingDown, "the service is stopping"));
    }
    let unusable = |fault: &dyn std::fmt::Display, detail: &str| {
        tracing::error!(error = %fault, "the store is not usable");
        Problem::new(ProblemType::StorageUnavailable, detail)
    };
    app.store.check().await.map_err(|fault| match fault.of_the_server() {
        Some(reason) => unusable(&fault, &reason),
        None => unusable(&fault, "the database does not answer; see the log"),
    })?;
    let blobs = app.spool.blobs().clone();
    let written = tokio::task::spawn_blocking(move || blobs.check()).await;
    written.map_err(|fault| Problem::internal(&fault))?.map_err(|fault| {
        let detail = fault.storage().map(|storage| storage.to_string());
        unusable(&fault, detail.as_deref().unwrap_or("no file can be written"))
    })?;
    Ok(Json(readiness(app.spool.blobs().soundness().reading())))
}

/// The caller needs no key, so the answer does not say which jobs or files are damaged.
fn readiness(known: SoundnessReading) -> Readiness {
    let SoundnessReading { damaged, findings, .. } = known;
    let cure = "restore from a backup; trunnion doctor --deep lists each";
    let mut reasons = Vec::new();
    if damaged > 0 {
        reasons.push(format!("damaged stored files or reports found so far: {damaged}; {cure}"));
    }
    if findings > 0 {
        reasons.push(format!("findings of the last scrub: {findings}; {cure}"));
    }
    Readiness { status: if reasons.is_empty() { "ready" } else { "degraded" }, reasons }
}
