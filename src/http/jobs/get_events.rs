//! Follows a job: its states and its progress as server-sent events.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::State;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::stream;
use http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::Instant;

use super::find;
use crate::description::operation;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::asker;
use crate::shares::{Held, NoShare};
use crate::wire::{JobDocument, JobState, NoParameters};

refusals!(Refusals: MalformedRequest, JobNotFound, NotAcceptable, InvalidRequest, Busy);

const LAST_EVENT_ID: HeaderName = HeaderName::from_static("last-event-id");
/// Proxies that know this header do not hold events back.
const ACCEL_BUFFERING: HeaderName = HeaderName::from_static("x-accel-buffering");
/// Time between two checks of a running job's progress.
const BETWEEN_LOOKS: Duration = Duration::from_millis(250);
/// Time between two looks at a job that another service may compute.
const BETWEEN_JOB_LOOKS: Duration = Duration::from_secs(1);
/// Time between two comments that keep a silent connection open.
const KEEP_ALIVE: Duration = Duration::from_secs(15);
/// Time between two checks of whether the client's key is still valid.
const BETWEEN_KEY_LOOKS: Duration = Duration::from_secs(1);

/// Follow a job
///
/// Server-sent events. `state` has state and progress; it comes once for the present state and again at every change.
/// `progress` comes while the job runs. The stream ends after a final state, and when the API key is revoked or
/// expires. A client that reconnects with `Last-Event-ID` does not get known events again. If it already has the
/// final state, the answer is 204.
#[operation(
    get,
    path = "/v1/jobs/{id}/events",
    tag = "jobs",
    operation_id = "get_job_events",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("Last-Event-ID" = Option<String>, Header, description = "Id of the last event that you received"),
    ),
    responses(
        (status = 200, description = "The events", body = String, content_type = "text/event-stream",
            example = "event: state\nid: running-0\ndata: {\"state\":\"running\",\"progress\":0}\n\nevent: progress\nid: running-412\ndata: {\"progress\":0.412}\n\nevent: state\nid: succeeded-1000\ndata: {\"state\":\"succeeded\",\"progress\":1}\n\n"),
        (status = 204, description = "The job has ended, and you have its final state"),
        Refusals,
    )
)]
pub(super) async fn get_job_events(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    caller: Caller,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["text/event-stream"])?;
    // The stream subscribes to changes before it reads the job, so that it misses none.
    let changes = app.queue.changes();
    let now = Seen::of(&find(&app, &id).await?.document);
    let known = headers.get(LAST_EVENT_ID).and_then(|value| value.to_str().ok());
    let known = known.is_some_and(|known| known == now.id());
    if known && now.state.is_final() {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let place = app.followers.take(&asker(), 1).map_err(|refused| match refused {
        NoShare::Full { total, .. } => Problem::new(
            ProblemType::Busy,
            format!("{total} clients already follow jobs, which is the limit"),
        ),
        over @ NoShare::OverShare { .. } => over.into(),
    })?;
    let first = if known { None } else { Some(now) };
    let (key_look, job_look) = (Instant::now() + BETWEEN_KEY_LOOKS, Instant::now() + BETWEEN_JOB_LOOKS);
    let key_id = caller.key_id;
    let follower = Follower { app, id, key_id, key_look, job_look, changes, told: now, first, _place: place };
    let events = stream::unfold(follower, |mut follower| async move {
        let event = follower.next().await?;
        Some((Ok::<_, Infallible>(event), follower))
    });
    let mut response = Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE)).into_response();
    response.headers_mut().insert(ACCEL_BUFFERING, HeaderValue::from_static("no"));
    Ok(response)
}

/// The state of a job that an event reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Seen {
    state: JobState,
    /// Progress in thousandths.
    progress: u16,
}

impl Seen {
    fn of(job: &JobDocument) -> Self {
        Self { state: job.state, progress: thousandths(job.progress) }
    }

    fn id(self) -> String {
        format!("{}-{}", self.state.as_str(), self.progress)
    }

    /// The event for this state: all of it, or only the progress.
    fn event(self, whole: bool) -> Event {
        let progress = f64::from(self.progress) / 1000.0;
        let event = Event::default().id(self.id());
        if whole {
            let data = format!("{{\"state\":\"{}\",\"progress\":{progress}}}", self.state.as_str());
            event.event("state").data(data)
        } else {
            event.event("progress").data(format!("{{\"progress\":{progress}}}"))
        }
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 1000")]
fn thousandths(share: f64) -> u16 {
    (share.clamp(0.0, 1.0) * 1000.0) as u16
}

struct Follower {
    app: AppState,
    id: String,
    /// The key of the client.
    key_id: Option<Arc<str>>,
    /// Time of the next check of the key.
    key_look: Instant,
    /// Time of the next look at the job, if another service may compute it.
    job_look: Instant,
    changes: Receiver<Arc<str>>,
    told: Seen,
    /// Reported at once.
    first: Option<Seen>,
    _place: Held,
}

impl Follower {
    /// The next event; `None` after a final state, when the service stops, or when the client's key is no longer
    /// valid.
    async fn next(&mut self) -> Option<Event> {
        if let Some(first) = self.first.take() {
            return Some(first.event(true));
        }
        while !self.told.state.is_final() {
            let now = tokio::select! {
                () = self.app.queue.stopping().cancelled() => return None,
                () = tokio::time::sleep_until(self.key_look) => {
                    if !self.is_let_in().await {
                        return None;
                    }
                    self.key_look = Instant::now() + BETWEEN_KEY_LOOKS;
                    continue;
                }
                changed = self.changes.recv() => match changed {
                    Ok(id) if *id != *self.id => continue,
                    Ok(_) | Err(RecvError::Lagged(_)) => {
                        Seen::of(&find(&self.app, &self.id).await.ok()?.document)
                    }
                    Err(RecvError::Closed) => return None,
                },
                () = tokio::time::sleep_until(self.job_look), if self.app.store.is_shared() => {
                    self.job_look = Instant::now() + BETWEEN_JOB_LOOKS;
                    // While the database is away nothing can be said.
                    let Ok(job) = find(&self.app, &self.id).await else { continue };
                    let now = Seen::of(&job.document);
                    // Another service may have begun it again meanwhile.
                    let least = if now.state == self.told.state { self.told.progress } else { 0 };
                    Seen { progress: now.progress.max(least), ..now }
                }
                () = tokio::time::sleep(BETWEEN_LOOKS), if self.told.state == JobState::Running => {
                    let progress = self.app.queue.progress(&self.id).map_or(0, thousandths);
                    Seen { progress: progress.max(self.told.progress), ..self.told }
                }
            };
            if now != self.told {
                let whole = now.state != self.told.state;
                self.told = now;
                return Some(now.event(whole));
            }
        }
        None
    }

    async fn is_let_in(&self) -> bool {
        let now = || self.app.sources.clock.now();
        // While the keys cannot be read, new clients are not admitted either.
        self.app
            .keys
            .current(&self.app.store)
            .await
            .is_ok_and(|ring| ring.still_opens(self.key_id.as_deref(), now))
    }
}
