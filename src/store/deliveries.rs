//! The webhooks about ended jobs. A trigger (`jobs_are_told`) writes their rows together with the ends: a job cannot
//! end without its webhook.

use std::collections::BTreeSet;

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::keys::{Answer, keep_key, unless_key_taken};
use super::machines::as_array;
use super::{Cursor, KeyUse, Page, Store, StoreError};
use crate::wire::{AuditAction, DeliveryAttempt, DeliveryOutcome, DeliveryState};

row! {
    /// A webhook that is due.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct DueDelivery {
        /// The job.
        pub job_id: String,
        /// Host and port of the receiver.
        pub receiver: String,
    }
}

/// State of a delivery.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeliveryRow {
    /// Host and port of the receiver.
    pub receiver: String,
    /// The state.
    pub state: DeliveryState,
    /// How often the delivery was requested.
    pub round: i64,
    /// Attempts in the present round.
    pub attempts: i64,
    /// Time of the next attempt.
    pub due_at: Option<String>,
}

/// The step after an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AfterAttempt {
    /// Nothing: the receiver has accepted it.
    Delivered,
    /// Nothing: no receiver will accept it.
    GivenUp,
    /// Another attempt at this time.
    Again(String),
}

/// The result of a request to deliver a webhook again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Redelivery {
    /// It will be delivered again.
    Asked,
    /// There is nothing to deliver.
    Nothing,
    /// The request's key was used in the meantime.
    KeyTaken,
}

row! {
    /// The waiting webhooks.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct DeliveriesWaiting {
        /// How many are waiting.
        pub count: i64,
        /// End of the job with the oldest one.
        pub oldest: Option<String>,
    }
}

/// Jobs and receivers to leave out: those that are being delivered, and receivers that have reached their limit.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Taken {
    /// Jobs that are being delivered.
    pub jobs: BTreeSet<String>,
    /// Receivers at their limit.
    pub receivers: BTreeSet<String>,
}

row! {
    struct StoredDelivery {
        receiver: String,
        state: String,
        round: i64,
        attempts: i64,
        due_at: Option<String>,
    }
}

row! {
    struct StoredAttempt {
        seq: i64,
        started_at: String,
        duration_ms: i64,
        status: Option<i64>,
        outcome: String,
        detail: String,
    }
}

impl Store {
    /// The due webhooks, those that have waited longest first. A webhook is due at `now` or before, or if its time is
    /// so far ahead that the clock must have been wrong when it was written.
    ///
    /// # Errors
    /// The database failed.
    pub async fn due_deliveries(
        &self,
        now: &str,
        farthest: &str,
        taken: &Taken,
        limit: usize,
    ) -> Result<Vec<DueDelivery>, StoreError> {
        let (jobs, receivers) = (as_array(Some(&taken.jobs)), as_array(Some(&taken.receivers)));
        let limit = i64::try_from(limit).unwrap_or(i64::MAX);
        sql!(
            self.db,
            all(DueDelivery),
            "SELECT job_id, receiver FROM deliveries
             WHERE state = 'waiting' AND (due_at <= $1 OR due_at > $2)
               AND job_id NOT IN (SELECT value FROM json_each($3))
               AND receiver NOT IN (SELECT value FROM json_each($4))
             ORDER BY due_at LIMIT $5",
            now,
            farthest,
            jobs,
            receivers,
            limit
        )
        .doing("looking for webhooks to deliver")
    }

    /// Takes a due webhook until this time. Then a service that looks for due webhooks finds it again, unless its
    /// attempt was recorded before. `false` if another service has taken it. That cannot happen with a database that
    /// one service has.
    ///
    /// # Errors
    /// The database failed.
    pub async fn take_delivery(
        &self,
        job_id: &str,
        now: &str,
        farthest: &str,
        until: &str,
    ) -> Result<bool, StoreError> {
        if !self.is_shared() {
            return Ok(true);
        }
        let [job_id, now, farthest, until] = [job_id, now, farthest, until].map(str::to_owned);
        let taken: u64 = self
            .write_apart("taking a webhook", |tx| {
                Box::pin(async move {
                    sql!(
                        tx,
                        execute,
                        postgres "UPDATE deliveries SET due_at = $1
                                  WHERE job_id = $2 AND state = 'waiting' AND (due_at <= $3 OR due_at > $4)",
                        until,
                        job_id,
                        now,
                        farthest
                    )
                })
            })
            .await?;
        Ok(taken == 1)
    }

    /// Time of the next webhook.
    ///
    /// # Errors
    /// The database failed.
    pub async fn next_delivery(&self, taken: &Taken) -> Result<Option<String>, StoreError> {
        let (jobs, receivers) = (as_array(Some(&taken.jobs)), as_array(Some(&taken.receivers)));
        let found = sql!(
            self.db,
            optional(_),
            "SELECT due_at FROM deliveries
             WHERE state = 'waiting' AND job_id NOT IN (SELECT value FROM json_each($1))
               AND receiver NOT IN (SELECT value FROM json_each($2))
             ORDER BY due_at LIMIT 1",
            jobs,
            receivers
        )
        .doing("looking for the next webhook")?;
        Ok(found.flatten())
    }

    /// State of the delivery of a job's end; `None` if there is no webhook.
    ///
    /// # Errors
    /// The database failed.
    pub async fn delivery(&self, job_id: &str) -> Result<Option<DeliveryRow>, StoreError> {
        let row = sql!(
            self.db,
            optional(StoredDelivery),
            "SELECT receiver, state, round, attempts, due_at FROM deliveries WHERE job_id = $1",
            job_id
        )
        .doing("reading a delivery")?;
        let read = |row: StoredDelivery| {
            let StoredDelivery { receiver, state, round, attempts, due_at } = row;
            let unreadable =
                |source| StoreError::Unreadable { what: "delivery", key: job_id.to_owned(), source };
            let state = serde_json::from_value(state.into()).map_err(unreadable)?;
            Ok(DeliveryRow { receiver, state, round, attempts, due_at })
        };
        row.map(read).transpose()
    }

    /// A page of the attempts to deliver a job's end, newest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn delivery_attempts(
        &self,
        job_id: &str,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<DeliveryAttempt>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(StoredAttempt),
            "SELECT seq, started_at, duration_ms, status, outcome, detail FROM delivery_attempts
             WHERE job_id = $1 AND seq < $2 ORDER BY seq DESC LIMIT $3",
            job_id,
            before,
            count
        )
        .doing("listing attempts")?;
        let read = rows.into_iter().map(|row| {
            let unreadable =
                |source| StoreError::Unreadable { what: "attempt", key: row.seq.to_string(), source };
            let outcome: DeliveryOutcome = serde_json::from_value(row.outcome.into()).map_err(unreadable)?;
            let attempt = DeliveryAttempt {
                started_at: row.started_at,
                duration_ms: Some(row.duration_ms),
                status: row.status.and_then(|status| u16::try_from(status).ok()),
                outcome,
                detail: row.detail,
            };
            Ok((row.seq, attempt))
        });
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }

    /// Records an attempt, and the step after it unless a new round was requested meanwhile.
    ///
    /// # Errors
    /// The database failed.
    pub async fn end_delivery_attempt(
        &self,
        job_id: &str,
        round: i64,
        attempt: &DeliveryAttempt,
        after: &AfterAttempt,
    ) -> Result<(), StoreError> {
        let (job_id, attempt) = (job_id.to_owned(), attempt.clone());
        let (state, due_at) = match after {
            AfterAttempt::Delivered => ("delivered", None),
            AfterAttempt::GivenUp => ("given-up", None),
            AfterAttempt::Again(at) => ("waiting", Some(at.clone())),
        };
        self.write("recording an attempt", |tx| {
            Box::pin(async move {
                let (status, outcome) = (attempt.status.map(i64::from), attempt.outcome.as_str());
                let duration_ms = attempt.duration_ms.unwrap_or(0);
                // The job and its deliveries may have been removed meanwhile.
                sql!(
                    tx,
                    execute,
                    "INSERT INTO delivery_attempts (job_id, started_at, duration_ms, status, outcome, detail)
                     SELECT job_id, $1, $2, $3, $4, $5 FROM deliveries WHERE job_id = $6",
                    attempt.started_at,
                    duration_ms,
                    status,
                    outcome,
                    attempt.detail,
                    job_id
                )?;
                sql!(
                    tx,
                    execute,
                    "UPDATE deliveries SET state = $1, due_at = $2, attempts = attempts + 1
                     WHERE job_id = $3 AND round = $4 AND state = 'waiting'",
                    state,
                    due_at,
                    job_id,
                    round
                )?;
                Ok(())
            })
        })
        .await
    }

    /// Requests that a job's end is delivered now, from the first attempt on, whatever the result of earlier rounds.
    ///
    /// # Errors
    /// The database failed.
    pub async fn deliver_again(
        &self,
        job_id: &str,
        now: &str,
        used: Option<&KeyUse>,
        by: &Actor,
    ) -> Result<Redelivery, StoreError> {
        let (id, now, used, by) = (job_id.to_owned(), now.to_owned(), used.cloned(), by.clone());
        let asked = self
            .write("asking for a delivery", |tx| {
                Box::pin(async move {
                    let done = sql!(
                        tx,
                        execute,
                        "UPDATE deliveries SET state = 'waiting', round = round + 1, attempts = 0, due_at = $1
                         WHERE job_id = $2",
                        now,
                        id
                    )?;
                    if done == 0 {
                        return Ok(false);
                    }
                    keep_key(tx, used.as_ref(), Answer::Job(&id), &now).await?;
                    let machine_id: Option<String> =
                        sql!(tx, optional(_), "SELECT machine_id FROM jobs WHERE id = $1", id)?;
                    let change = Change {
                        at: &now,
                        action: AuditAction::DeliveryRequested,
                        machine_id: machine_id.as_deref(),
                        resource: format!("/v1/jobs/{id}/deliveries"),
                        revisions: (None, None),
                    };
                    audit(tx, &by, change).await?;
                    Ok(true)
                })
            })
            .await;
        match asked {
            Ok(false) => Ok(Redelivery::Nothing),
            asked => unless_key_taken(asked.map(|_asked| ()))
                .map(|asked| if asked { Redelivery::Asked } else { Redelivery::KeyTaken }),
        }
    }

    /// The waiting webhooks.
    ///
    /// # Errors
    /// The database failed.
    pub async fn deliveries_waiting(&self) -> Result<DeliveriesWaiting, StoreError> {
        let row = sql!(
            self.db,
            one(DeliveriesWaiting),
            "SELECT (SELECT count(*) FROM deliveries WHERE state = 'waiting') AS \"count!\",
                 (SELECT min(created_at) FROM deliveries WHERE state = 'waiting') AS \"oldest\""
        )
        .doing("counting the waiting webhooks")?;
        Ok(DeliveriesWaiting { count: row.count, oldest: row.oldest })
    }
}
