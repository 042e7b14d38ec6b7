//! The requests of the example, answered by the service in this process. They pass everything that the requests of a
//! client pass.

use http::header::{AUTHORIZATION, CONTENT_TYPE, HOST, IF_MATCH};
use http::{Method, Request};
use serde_json::{Value, json};

use super::DemoFault;
use super::content::{Job, MACHINE};
use crate::cli::serve::Running;
use crate::http::{AppState, InProcess};
use crate::jobs::{IssuedKey, Sources, issue_key};
use crate::store::Actor;
use crate::wire::{ApiKeyRequest, AuditOrigin, Scope};

/// Time after which the key of the example expires even if the process dies \[s\].
const KEY_LIFE_S: f64 = 3600.0;
/// Separates the parts of a form; no program has this line.
const BOUNDARY: &str = "trunnion-demo-a3d1f0";

/// Sends requests, with a key if the service has keys.
pub(super) struct Caller {
    service: InProcess,
    app: AppState,
    /// Id of the key and the key.
    key: Option<(String, String)>,
}

impl Caller {
    /// A caller that the service admits. If the service has keys, it gets its own for as long as it needs one.
    pub(super) async fn admitted(running: &Running) -> Result<Self, DemoFault> {
        let app = running.state.clone();
        let mut caller = Self { service: InProcess::of(app.clone()), app, key: None };
        if caller.app.store.every_api_key().await?.is_empty() {
            return Ok(caller);
        }
        let sources = Sources::real();
        let request = ApiKeyRequest {
            name: "trunnion demo".to_owned(),
            scopes: [Scope::Read, Scope::Compute, Scope::Machines, Scope::Calibrations].into(),
            machines: None,
            expires_at: Some(sources.timestamp_after(KEY_LIFE_S)),
        };
        let IssuedKey { row, key } = issue_key(&request, &sources)?;
        let id = row.document.id.clone();
        if caller.app.store.add_api_key(&row, None, &actor()).await? {
            caller.key = Some((id, key));
        }
        Ok(caller)
    }

    /// Gives the key up.
    pub(super) async fn leave(&mut self) -> Result<(), DemoFault> {
        if let Some((id, _)) = self.key.take() {
            self.app.store.revoke_api_key(&id, &self.app.sources.timestamp(), &actor()).await?;
        }
        Ok(())
    }

    /// Stores a document.
    pub(super) async fn put(&self, path: &str, document: &Value) -> Result<Value, DemoFault> {
        self.send(Method::PUT, path, json_body(document)).await
    }

    /// Posts a document.
    pub(super) async fn post(&self, path: &str, document: &Value) -> Result<Value, DemoFault> {
        self.send(Method::POST, path, json_body(document)).await
    }

    /// Applies a calibration to the newest revision of its machine.
    pub(super) async fn apply(&self, path: &str) -> Result<Value, DemoFault> {
        self.send(Method::POST, path, (None, String::new())).await
    }

    /// Posts a job with its program.
    pub(super) async fn post_job(&self, job: &Job) -> Result<Value, DemoFault> {
        let order = json!({
            "machine_id": MACHINE, "operation": job.operation, "parameters": job.parameters,
            "external_id": format!("demo: {}", job.name),
        });
        let form = format!(
            "--{BOUNDARY}\r\nContent-Disposition: form-data; name=\"job\"\r\n\r\n{order}\r\n--{BOUNDARY}\r\n\
             Content-Disposition: form-data; name=\"program\"; filename=\"{}\"\r\nContent-Type: text/plain\r\n\r\n\
             {}\r\n--{BOUNDARY}--\r\n",
            job.file_name, job.program
        );
        let kind = format!("multipart/form-data; boundary={BOUNDARY}");
        self.send(Method::POST, "/v1/jobs", (Some(kind), form)).await
    }

    /// The job after its end.
    pub(super) async fn ended(&self, id: &str) -> Result<Value, DemoFault> {
        let mut changes = self.app.queue.changes();
        loop {
            let job = self.send(Method::GET, &format!("/v1/jobs/{id}"), (None, String::new())).await?;
            let state = job.get("state").and_then(Value::as_str).unwrap_or_default();
            if !["queued", "running"].contains(&state) {
                return Ok(job);
            }
            let _change = changes.recv().await;
        }
    }

    async fn send(
        &self,
        method: Method,
        path: &str,
        (kind, body): (Option<String>, String),
    ) -> Result<Value, DemoFault> {
        let unsound = |fault: &dyn std::fmt::Display| DemoFault::Content(format!("{method} {path}: {fault}"));
        let mut request = Request::builder().method(&method).uri(path).header(HOST, "localhost");
        if let Some(kind) = kind {
            request = request.header(CONTENT_TYPE, kind);
        }
        if let Some((_, key)) = &self.key {
            request = request.header(AUTHORIZATION, format!("Bearer {key}"));
        }
        if path.ends_with("/apply") {
            request = request.header(IF_MATCH, "*");
        }
        let request = request.body(body).map_err(|fault| unsound(&fault))?;
        let (status, bytes) = self.service.answer(request).await.map_err(|fault| unsound(&fault))?;
        let answer: Value = serde_json::from_slice(&bytes).unwrap_or_default();
        if status.is_success() {
            return Ok(answer);
        }
        let detail = answer.get("detail").and_then(Value::as_str).unwrap_or_default().to_owned();
        Err(DemoFault::Refused {
            method: method.to_string(),
            path: path.to_owned(),
            status: status.as_u16(),
            detail,
        })
    }
}

fn actor() -> Actor {
    Actor::without_request(AuditOrigin::CommandLine)
}

fn json_body(document: &Value) -> (Option<String>, String) {
    (Some("application/json".to_owned()), document.to_string())
}
