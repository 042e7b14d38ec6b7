//! Delivers webhooks: a few at a time, fewer to one receiver, each at its time.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use tokio::task::{Id, JoinSet};
use tracing::Instrument;

use super::call::{Answer, Letter, Line, Resolve, SystemNames};
use super::pauses::{longest_s, pause_s};
use super::receivers::{NotAllowed, Receivers};
use super::signature::signatures;
use super::trust::Trust;
use crate::config::Settings;
use crate::jobs::clock::after;
use crate::jobs::{Queue, Sources, TrustFault, timestamp};
use crate::meter;
use crate::store::{
    AfterAttempt, DeliveriesWaiting, DueDelivery, JobRow, Store, StoreError, Taken, WebhookSecretRow,
};
use crate::wire::{CallbackUrl, DeliveryAttempt, DeliveryOutcome, DeliveryState, job_event, webhook_id};

/// Longest time between two searches for due webhooks: the clock may have been set meanwhile.
const LONGEST_REST: Duration = Duration::from_secs(30);
/// Shortest time between two searches.
const SHORTEST_REST: Duration = Duration::from_millis(5);
/// For how long a webhook is taken from the other services, beyond the longest attempt \[s\]. If its service dies, it
/// is delivered after this time.
const TAKEN_S: f64 = 30.0;
/// How much the clocks of two services may differ \[s\].
const CLOCKS_DIFFER_S: f64 = 60.0;
/// Pause before a failed store is asked again.
const RETRY: Duration = Duration::from_secs(1);

/// The number of waiting webhooks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeliveriesReading {
    /// Webhooks that wait for delivery.
    pub waiting: i64,
    /// Age of the oldest one \[s\]; 0 if no message waits.
    pub oldest_s: f64,
}

/// Delivers the webhooks about ended jobs; cheap to clone.
#[derive(Debug, Clone)]
pub struct Courier(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    store: Store,
    sources: Sources,
    queue: Queue,
    line: Line,
    pauses_s: Vec<f64>,
    most: usize,
    most_per_receiver: usize,
}

impl Courier {
    /// Begins to deliver the waiting webhooks, until the queue stops.
    ///
    /// # Errors
    /// The file with certificates cannot be used.
    pub fn open(
        store: Store,
        sources: Sources,
        queue: Queue,
        settings: &Settings,
    ) -> Result<Self, TrustFault> {
        Self::calling(store, sources, queue, settings, Arc::new(SystemNames))
    }

    fn calling(
        store: Store,
        sources: Sources,
        queue: Queue,
        settings: &Settings,
        names: Arc<dyn Resolve>,
    ) -> Result<Self, TrustFault> {
        let line = Line {
            receivers: Receivers::new(settings.webhook_allow.clone()),
            names,
            trust: Trust::with(settings.webhook_ca_file.as_deref())?,
            timeout: Duration::from_secs_f64(settings.webhook_timeout_s),
        };
        let shared = Arc::new(Shared {
            store,
            sources,
            queue,
            line,
            pauses_s: settings.webhook_pauses_s.clone(),
            most: settings.max_deliveries,
            most_per_receiver: settings.max_deliveries_per_receiver,
        });
        // Nobody waits for it: an attempt that runs when the service stops is repeated after the next start.
        drop(tokio::spawn(Arc::clone(&shared).deliver()));
        Ok(Self(shared))
    }

    /// Whether webhooks may be sent to this address, as far as that is known now.
    ///
    /// # Errors
    /// They may not.
    pub fn admit(&self, url: &CallbackUrl) -> Result<(), NotAllowed> {
        self.0.line.receivers.admit(url)
    }

    /// There is a new webhook to deliver.
    pub fn wake(&self) {
        self.0.queue.told().notify_one();
    }

    /// The present number of waiting webhooks.
    ///
    /// # Errors
    /// The database failed.
    pub async fn reading(&self) -> Result<DeliveriesReading, StoreError> {
        let DeliveriesWaiting { count, oldest } = self.0.store.deliveries_waiting().await?;
        let since = oldest.and_then(|oldest| oldest.parse::<Timestamp>().ok());
        let ago = since.map(|since| self.0.sources.clock.now().duration_since(since).as_secs_f64());
        Ok(DeliveriesReading { waiting: count, oldest_s: ago.unwrap_or(0.0).max(0.0) })
    }
}

/// Running attempts: the job and the receiver of each.
#[derive(Debug, Default)]
struct UnderWay(HashMap<Id, DueDelivery>);

impl UnderWay {
    fn to(&self, receiver: &str) -> usize {
        self.0.values().filter(|delivery| delivery.receiver == receiver).count()
    }

    /// The jobs and receivers without room.
    fn taken(&self, most_per_receiver: usize) -> Taken {
        let full = self.0.values().map(|delivery| &delivery.receiver);
        let full = full.filter(|receiver| self.to(receiver) >= most_per_receiver);
        Taken {
            jobs: self.0.values().map(|delivery| delivery.job_id.clone()).collect(),
            receivers: full.cloned().collect(),
        }
    }
}

impl Shared {
    async fn deliver(self: Arc<Self>) {
        let mut under_way = UnderWay::default();
        let mut attempts = JoinSet::new();
        loop {
            let rest = self.begin(&mut under_way, &mut attempts).await.unwrap_or_else(|fault| {
                tracing::error!(error = %fault, "the due webhooks cannot be read");
                RETRY
            });
            tokio::select! {
                // Running attempts end with the set.
                () = self.queue.stopping().cancelled() => return,
                Some(ended) = attempts.join_next_with_id() => {
                    let id = ended.map_or_else(|fault| fault.id(), |(id, ())| id);
                    under_way.0.remove(&id);
                }
                () = self.queue.told().notified() => {}
                () = tokio::time::sleep(rest) => {}
            }
        }
    }

    /// Begins the due attempts as far as there is room; returns how long until there is more to do.
    async fn begin(
        self: &Arc<Self>,
        under_way: &mut UnderWay,
        attempts: &mut JoinSet<()>,
    ) -> Result<Duration, StoreError> {
        loop {
            let room = self.most.saturating_sub(under_way.0.len());
            if room == 0 {
                return Ok(LONGEST_REST);
            }
            let now = self.sources.clock.now();
            let taken_s = self.line.timeout.as_secs_f64() + TAKEN_S;
            let longest = longest_s(&self.pauses_s);
            let is_shared = self.store.is_shared();
            let farthest_s = if is_shared { longest.max(taken_s + CLOCKS_DIFFER_S) } else { longest };
            let (farthest, until) = (after(now, farthest_s), after(now, taken_s));
            let taken = under_way.taken(self.most_per_receiver);
            let due = self.store.due_deliveries(&timestamp(now), &farthest, &taken, room).await?;
            if due.is_empty() {
                let next = self.store.next_delivery(&taken).await?;
                return Ok(rest_until(next.as_deref(), now));
            }
            // Every round begins at least one attempt: the first is to a receiver that has room.
            for delivery in due {
                if under_way.to(&delivery.receiver) < self.most_per_receiver {
                    let job_id = delivery.job_id.clone();
                    if !self.store.take_delivery(&job_id, &timestamp(now), &farthest, &until).await? {
                        continue;
                    }
                    let span = tracing::info_span!("webhook", job_id, receiver = delivery.receiver);
                    let task = attempts.spawn(Arc::clone(self).attempt(job_id).instrument(span));
                    under_way.0.insert(task.id(), delivery);
                }
            }
        }
    }

    /// Makes one attempt and records it.
    async fn attempt(self: Arc<Self>, job_id: String) {
        let read = match self.read(&job_id).await {
            Ok(Some(read)) => read,
            // The job was removed meanwhile.
            Ok(None) => return,
            Err(fault) => {
                tracing::error!(error = %fault, "a webhook cannot be read");
                return tokio::time::sleep(RETRY).await;
            }
        };
        let Outgoing { round, attempts, url, letter, now } = read;
        let began = Instant::now();
        let answer = match &url {
            Some(url) => self.line.call(url, &letter).await,
            None => not_called(),
        };
        let elapsed = began.elapsed();
        if let Some(count) = meter::WEBHOOK_ATTEMPTS.get(answer.outcome.without_cause() as usize) {
            count.add(1);
        }
        let attempt = DeliveryAttempt {
            started_at: timestamp(now),
            duration_ms: Some(i64::try_from(elapsed.as_millis()).unwrap_or(i64::MAX)),
            status: answer.status,
            outcome: answer.outcome,
            detail: answer.detail.clone(),
        };
        let pause_s = url.and_then(|_callable| pause_s(&self.pauses_s, attempts + 1, &job_id));
        let after = self.after(&answer, pause_s);
        tell(&attempt, &after, attempts + 1);
        while let Err(fault) = self.store.end_delivery_attempt(&job_id, round, &attempt, &after).await {
            tracing::error!(error = %fault, "an attempt to deliver a webhook cannot be stored");
            tokio::time::sleep(RETRY).await;
        }
    }

    /// What follows an answer; `pause_s` is the pause before another attempt.
    fn after(&self, answer: &Answer, pause_s: Option<f64>) -> AfterAttempt {
        match (answer.outcome, pause_s) {
            (DeliveryOutcome::Delivered, _) => AfterAttempt::Delivered,
            (DeliveryOutcome::Gone, _) | (_, None) => AfterAttempt::GivenUp,
            (_, Some(pause_s)) => {
                // A busy receiver says how long to wait; that is respected up to the longest pause.
                let asked_s = answer.retry_after_s.unwrap_or(0.0).min(longest_s(&self.pauses_s));
                AfterAttempt::Again(self.sources.timestamp_after(pause_s.max(asked_s)))
            }
        }
    }

    /// The message to send now.
    async fn read(&self, job_id: &str) -> Result<Option<Outgoing>, StoreError> {
        let delivery = self.store.delivery(job_id).await?;
        let Some(delivery) = delivery.filter(|delivery| delivery.state == DeliveryState::Waiting) else {
            return Ok(None);
        };
        let Some(JobRow { document, traceparent, .. }) = self.store.job(job_id).await? else {
            return Ok(None);
        };
        let secrets: Vec<WebhookSecretRow> = self.store.webhook_secrets().await?;
        let unprintable = |source| StoreError::Unreadable { what: "job", key: job_id.to_owned(), source };
        let body = job_event(&document).map_err(unprintable)?;
        let (id, now) = (webhook_id(job_id), self.sources.clock.now());
        let timestamp_s = now.as_second();
        let signatures = signatures(&secrets, &timestamp(now), &id, timestamp_s, &body);
        let signatures = signatures.ok_or(StoreError::NoSecret)?;
        let letter = Letter { id, timestamp_s, signatures, body: body.into(), traceparent };
        // It was accepted by a version that checked addresses less strictly.
        let url = document.callback_url.as_deref().and_then(|url| url.parse().ok());
        Ok(Some(Outgoing { round: delivery.round, attempts: delivery.attempts, url, letter, now }))
    }
}

/// An attempt that is about to be made.
#[derive(Debug)]
struct Outgoing {
    round: i64,
    attempts: i64,
    url: Option<CallbackUrl>,
    letter: Letter,
    now: Timestamp,
}

/// The result for an address that is not valid.
fn not_called() -> Answer {
    Answer {
        outcome: DeliveryOutcome::AddressRefused,
        status: None,
        detail: "callback_url is not a valid address".to_owned(),
        retry_after_s: None,
    }
}

/// The time until then, within the limits of a rest.
fn rest_until(next: Option<&str>, now: Timestamp) -> Duration {
    let next = next.and_then(|next| next.parse::<Timestamp>().ok());
    let ahead = next.and_then(|next| Duration::try_from(next.duration_since(now)).ok());
    match next {
        Some(_) => ahead.unwrap_or_default().clamp(SHORTEST_REST, LONGEST_REST),
        None => LONGEST_REST,
    }
}

/// Writes a line to the log.
fn tell(attempt: &DeliveryAttempt, after: &AfterAttempt, attempts: i64) {
    let (outcome, detail) = (attempt.outcome.as_str(), attempt.detail.as_str());
    match after {
        AfterAttempt::Delivered => tracing::info!(attempts, "a job's end was delivered"),
        AfterAttempt::Again(at) => tracing::warn!(attempts, outcome, detail, next = at, "not delivered"),
        AfterAttempt::GivenUp => {
            tracing::error!(attempts, outcome, detail, "a webhook was not delivered and is given up");
        }
    }
}
