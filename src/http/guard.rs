//! Checks who sends each request, and admits it if its key allows the operation. A machine that a key does not reach
//! does not exist for the caller, and neither does anything that belongs to it.

use std::sync::Arc;

use axum::RequestExt;
use axum::extract::{MatchedPath, RawPathParams, Request};
use axum::response::{IntoResponse, Response};
use http::header::{AUTHORIZATION, WWW_AUTHENTICATE};
use http::{HeaderMap, HeaderValue, Method};

use super::AppState;
use super::access::{Need, needed};
use super::admission::turned_away;
use super::body::Incoming;
use super::caller::Caller;
use super::note_refusal::note_refusal;
use super::pages::from_here;
use super::problem::{Problem, ProblemType};
use super::request_facts::RequestFacts;
use super::security_log::Reason;
use crate::jobs::{KeyRefusal, key_id_of};

/// A refusal, with its challenge (RFC 6750 §3).
pub(super) struct Refused {
    problem: Problem,
    challenge: Option<String>,
    /// The reason, if it is not a fault of the service.
    reason: Option<Reason>,
    key_id: Option<Arc<str>>,
}

impl Refused {
    fn because(reason: Reason, problem: Problem) -> Self {
        Self { reason: Some(reason), ..Self::from(problem) }
    }

    fn challenging(self, challenge: &str) -> Self {
        Self { challenge: Some(challenge.to_owned()), ..self }
    }
}

impl Reason {
    fn of(refusal: &KeyRefusal) -> Self {
        match refusal {
            KeyRefusal::Unknown => Self::UnknownKey,
            KeyRefusal::Revoked { .. } => Self::RevokedKey,
            KeyRefusal::Expired { .. } => Self::EndedKey,
        }
    }
}

/// Whether the service listens only to programs on its own computer.
fn is_local(app: &AppState) -> bool {
    app.settings.listen.ip().to_canonical().is_loopback()
}

impl From<Problem> for Refused {
    fn from(problem: Problem) -> Self {
        Self { problem, challenge: None, reason: None, key_id: None }
    }
}

const REALM: &str = "Bearer realm=\"trunnion\"";

/// Checks the key of a request, and adds the caller to its [`RequestFacts`]. A request that needs no key passes.
///
/// # Errors
/// The reason of the refusal; [`answer_refused`] makes the answer of it.
pub(super) async fn guard(app: &AppState, request: &mut Request) -> Result<(), Box<Refused>> {
    let caller = admitted(app, request).await.map_err(Box::new)?;
    if let Some(id) = &caller.key_id {
        tracing::Span::current().record("key_id", &**id);
        app.keys.note_use(&app.store, &app.sources, id);
    }
    let Some(facts) = request.extensions_mut().get_mut::<RequestFacts>() else {
        // A fault of the service: a request without a caller must not reach a handler.
        return Err(Box::new(Problem::internal(&"a request did not pass the watch").into()));
    };
    facts.caller = Some(caller);
    Ok(())
}

/// The answer to a request that is not admitted.
pub(super) async fn answer_refused(app: &AppState, refused: Box<Refused>, request: Request) -> Response {
    if let Some(id) = &refused.key_id {
        tracing::Span::current().record("key_id", &**id);
    }
    if let Some(reason) = refused.reason {
        note_refusal(app, reason, refused.key_id.as_deref(), request.method(), request.extensions());
    }
    // A caller that guesses keys is counted by address.
    if let Some(response) = turned_away(app, request.method(), request.extensions(), None) {
        return response;
    }
    Incoming::new(request.into_body(), app.settings.body_pause_timeout_s).swallow().await;
    let mut response = refused.problem.into_response();
    if let Some(value) = refused.challenge.and_then(|text| HeaderValue::try_from(text).ok()) {
        response.headers_mut().insert(WWW_AUTHENTICATE, value);
    }
    response
}

async fn admitted(app: &AppState, request: &mut Request) -> Result<Caller, Refused> {
    let ring = app.keys.current(&app.store).await.map_err(Problem::from)?;
    let is_open = ring.is_empty() && !app.keys.were_seen() && (app.settings.insecure || is_local(app));
    if is_open {
        if is_local(app) {
            from_here(request).map_err(|problem| Refused::because(Reason::ForeignPage, problem))?;
        }
        return Ok(Caller::anybody());
    }
    // An address that does not exist needs no guard.
    let Some(route) = request.extensions().get::<MatchedPath>().cloned() else { return Ok(Caller::nobody()) };
    let route = route.as_str();
    let Need::Scope(scope) = needed(request.method().as_str(), route) else { return Ok(Caller::nobody()) };
    if ring.is_empty() {
        // Keys existed before: the database was restored without them, or is another one.
        let detail = "the service has lost its API keys: keys existed before, but none exists now; create one with trunnion keys create, or restore the database";
        let problem = Problem::new(ProblemType::Unauthenticated, detail);
        return Err(Refused::because(Reason::NoKeysMade, problem).challenging(REALM));
    }
    let text = bearer(request.headers())?;
    let key = ring.find(text, || app.sources.clock.now()).map_err(|refusal| {
        let problem = Problem::new(ProblemType::Unauthenticated, refusal.to_string());
        let refused = Refused::because(Reason::of(&refusal), problem);
        // The refusal of a revoked or expired key confirms that its secret was right.
        let known = !matches!(refusal, KeyRefusal::Unknown);
        let key_id = known.then(|| key_id_of(text)).flatten().map(Into::into);
        Refused { key_id, ..refused }.challenging(&format!("{REALM}, error=\"invalid_token\""))
    })?;
    let caller = Caller::with(key);
    if !caller.may(scope) {
        let detail = format!("the operation needs a key with the scope {scope}");
        let refused = Refused::because(Reason::Scope, Problem::new(ProblemType::ScopeMissing, detail));
        let refused = Refused { key_id: caller.key_id, ..refused };
        return Err(refused.challenging(&format!("{REALM}, error=\"insufficient_scope\", scope=\"{scope}\"")));
    }
    if caller.machines.is_some() {
        Box::pin(reaches(app, &caller, route, request)).await.map_err(|problem| {
            let of_client = problem.kind().status().is_client_error();
            Refused {
                reason: of_client.then_some(Reason::Machine),
                key_id: caller.key_id.clone(),
                ..Refused::from(problem)
            }
        })?;
    }
    Ok(caller)
}

/// The key of a request.
fn bearer(headers: &HeaderMap) -> Result<&str, Refused> {
    let refuse = |reason, detail: &str| {
        Refused::because(reason, Problem::new(ProblemType::Unauthenticated, detail)).challenging(REALM)
    };
    let mut values = headers.get_all(AUTHORIZATION).iter();
    let value = values.next().ok_or_else(|| {
        refuse(
            Reason::NoKey,
            "the request has no Authorization header; send Authorization: Bearer with an API key",
        )
    })?;
    let not_one =
        || refuse(Reason::UnreadableKey, "the Authorization header must be Bearer followed by one key");
    if values.next().is_some() {
        return Err(not_one());
    }
    let (scheme, key) = value.to_str().ok().and_then(|text| text.split_once(' ')).ok_or_else(not_one)?;
    if scheme.eq_ignore_ascii_case("bearer") { Ok(key.trim()) } else { Err(not_one()) }
}

/// Whether the key reaches the machine that the path names. A machine that the body names is checked where the body
/// is read.
async fn reaches(app: &AppState, caller: &Caller, route: &str, request: &mut Request) -> Result<(), Problem> {
    let of_machine = route.contains("{machine_id}");
    let of_job = route.starts_with("/v1/jobs/{id}");
    if !of_machine && !of_job {
        return Ok(());
    }
    let path = request.extract_parts::<RawPathParams>().await;
    let path = path.map_err(|fault| Problem::new(ProblemType::MalformedRequest, fault.body_text()))?;
    let wanted = if of_machine { "machine_id" } else { "id" };
    let named = path.iter().find(|(name, _)| *name == wanted).map_or("", |(_, value)| value);
    if of_job {
        let machine_id = app.store.machine_of_job(named).await?;
        let within = machine_id.is_some_and(|machine_id| caller.reaches(&machine_id));
        return if within { Ok(()) } else { Err(Problem::job_not_found(named)) };
    }
    if request.method() == Method::PUT && route == "/v1/machines/{machine_id}" && !caller.reaches(named) {
        let detail = format!("the key is limited to a list of machines, and {named:?} is not in it");
        return Err(Problem::new(ProblemType::MachineNotAllowed, detail));
    }
    caller.must_reach(named)
}
