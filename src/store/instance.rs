//! This process as one of several services: its row, its leases, and what it hears of the others. All of it goes over
//! connections of its own, so that no other work holds it up.

use std::fmt;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use jiff::Timestamp;
use sqlx::Error;
use sqlx::postgres::{PgConnectOptions, PgListener, PgPool};
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

use super::StoreError;
use super::error::Doing;
use super::leases::{HeldLease, Renewed, Signal};
use super::postgres::{TakenOver, pool};
use super::postgres_form::own_form;
use super::presence::Presence;

/// Longest time of one renewal. A later one begins well before the leases end.
const RENEWED_WITHIN: Duration = Duration::from_secs(4);
/// How long the end of the service waits for its last message to the server.
const LEFT_WITHIN: Duration = Duration::from_secs(1);
/// A slower answer does not tell the time of the server well.
const TOLD_WITHIN: Duration = Duration::from_millis(500);
/// Time between two attempts to listen.
const LISTEN_AGAIN: Duration = Duration::from_secs(1);
/// Signals that a slow follower may miss; it looks every second anyway.
const SIGNALS_KEPT: usize = 1024;
/// The file with the name of the process that has the data directory.
const NOTE: &str = "instance.id";

/// One of several services.
#[derive(Clone)]
pub(super) struct Instance {
    name: Arc<str>,
    previous: Option<Arc<str>>,
    host: Arc<str>,
    connections: PgPool,
    presence: Presence,
    signals: broadcast::Sender<Signal>,
    key_changes: Arc<AtomicU64>,
    /// The time of the server, and when it was heard.
    server_time: Arc<Mutex<Option<(Instant, Timestamp)>>>,
    stop: CancellationToken,
}

impl fmt::Debug for Instance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Instance").field("name", &self.name).finish_non_exhaustive()
    }
}

row! {
    /// A lease that was moved on.
    struct Moved {
        job_id: String,
        cancel_requested: i64,
    }
}

row! {
    /// What the server says to a service that lives.
    struct Beaten {
        now_us: i64,
        usable_from: i64,
    }
}

impl Instance {
    /// Enters the service under a name that was never used before, and begins to listen. The data directory tells the
    /// name of the process that had it before.
    ///
    /// # Errors
    /// The server does not answer, or the name cannot be noted.
    pub(super) async fn open(
        options: PgConnectOptions,
        presence: Presence,
        name: &str,
        host: &str,
        data_dir: &Path,
    ) -> Result<Self, StoreError> {
        // One for what has to be said, one for what is heard.
        let connections = pool(options.clone(), 1, &presence).await?;
        let heard = pool(options, 1, &presence).await?;
        let place = data_dir.join(NOTE);
        // Without the note its jobs are taken up when their leases end.
        let previous = std::fs::read_to_string(&place).ok().map(|text| text.trim().to_owned());
        let instance = Self {
            name: name.into(),
            previous: previous.filter(|previous| !previous.is_empty()).map(Arc::from),
            host: host.into(),
            connections,
            presence,
            signals: broadcast::Sender::new(SIGNALS_KEPT),
            key_changes: Arc::default(),
            server_time: Arc::default(),
            stop: CancellationToken::new(),
        };
        instance.beat().await.doing("entering this service")?;
        std::fs::write(&place, format!("{name}\n"))
            .map_err(|source| StoreError::Note { path: place.clone(), source })?;
        drop(tokio::spawn(instance.clone().listen(heard)));
        Ok(instance)
    }

    /// The name of the process that had the data directory before.
    pub(super) fn previous(&self) -> Option<&str> {
        self.previous.as_deref()
    }

    /// What is heard of the other services from now on.
    pub(super) fn signals(&self) -> broadcast::Receiver<Signal> {
        self.signals.subscribe()
    }

    /// The number of changes of API keys that were told.
    pub(super) fn key_changes(&self) -> u64 {
        self.key_changes.load(Ordering::SeqCst)
    }

    /// The time of the server, and when it was heard.
    pub(super) fn server_time(&self) -> Option<(Instant, Timestamp)> {
        *self.server_time.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Says that this service lives, and hears what time it is.
    async fn beat(&self) -> Result<(), Error> {
        let (name, host, version) = (&*self.name, &*self.host, env!("CARGO_PKG_VERSION"));
        let (process, knows) = (i64::from(std::process::id()), own_form());
        let mut connection = self.connections.acquire().await?;
        let asked = Instant::now();
        let beaten: Beaten = postgres!(
            &mut *connection,
            one(Beaten),
            "INSERT INTO instances (id, version, host, process, knows) VALUES ($1, $2, $3, $4, $5)
             ON CONFLICT (id) DO UPDATE SET seen_at = clock_timestamp()
             RETURNING CAST(extract(epoch FROM seen_at) * 1000000 AS BIGINT) AS \"now_us!\",
                 (SELECT usable_from FROM service) AS \"usable_from!\"",
            name,
            version,
            host,
            process,
            knows
        )?;
        self.hear_time(beaten.now_us, asked.elapsed());
        if beaten.usable_from > knows {
            // It was away while that happened: otherwise the newer version would have been refused.
            tracing::error!(
                usable_from = beaten.usable_from,
                knows,
                "a newer version has changed the database so that this service cannot use it"
            );
            self.presence.note_taken_over();
            return Err(io::Error::other(TakenOver).into());
        }
        Ok(())
    }

    /// Notes the time of the server, in microseconds since 1970, after an answer that took so long. It is late by a part
    /// of that.
    fn hear_time(&self, now_us: i64, took: Duration) {
        let Ok(time) = Timestamp::from_microsecond(now_us) else { return };
        let mut known = self.server_time.lock().unwrap_or_else(PoisonError::into_inner);
        if known.is_none() || took < TOLD_WITHIN {
            *known = Some((Instant::now(), time));
        }
    }

    /// Says that this service lives, and moves the ends of these leases.
    ///
    /// # Errors
    /// The server does not answer in time.
    pub(super) async fn renew(&self, held: &[HeldLease]) -> Result<Renewed, Error> {
        // The three members can always be printed.
        let list = serde_json::to_string(held).unwrap_or_default();
        let name = &*self.name;
        let renewal = async {
            self.beat().await?;
            if held.is_empty() {
                return Ok(Renewed::default());
            }
            let mut connection = self.connections.acquire().await?;
            let moved: Vec<Moved> = postgres!(
                &mut *connection,
                all(Moved),
                "UPDATE job_leases l SET lease_until = clock_timestamp() + INTERVAL '30 s'
                 FROM jobs j, json_to_recordset(CAST(CAST($1 AS TEXT) AS json)) AS h (id TEXT, lease TEXT)
                 WHERE l.job_id = h.id AND l.lease = h.lease AND l.holder = $2 AND j.id = h.id AND j.lease = h.lease
                 RETURNING l.job_id, j.cancel_requested",
                list,
                name
            )?;
            let told: Result<u64, Error> = postgres!(
                &mut *connection,
                execute,
                "UPDATE jobs SET progress = h.progress
                 FROM json_to_recordset(CAST(CAST($1 AS TEXT) AS json))
                     AS h (id TEXT, lease TEXT, progress DOUBLE PRECISION)
                 WHERE jobs.id = h.id AND jobs.lease = h.lease AND jobs.state = 'running'
                     AND jobs.progress < h.progress",
                list
            );
            told?;
            let cancelled = moved.iter().filter(|moved| moved.cancel_requested != 0);
            Ok(Renewed {
                cancelled: cancelled.map(|moved| moved.job_id.clone()).collect(),
                held: moved.into_iter().map(|moved| moved.job_id).collect(),
            })
        };
        self.presence.within(RENEWED_WITHIN, renewal).await
    }

    /// Says that this service stops, and closes its connections.
    pub(super) async fn leave(&self) {
        self.stop.cancel();
        let left = async {
            let mut connection = self.connections.acquire().await?;
            let name = &*self.name;
            let done: Result<u64, Error> = postgres!(
                &mut *connection,
                execute,
                "UPDATE instances SET stopped_at = clock_timestamp() WHERE id = $1",
                name
            );
            done.map(drop)
        };
        if let Err(fault) = self.presence.within(LEFT_WITHIN, left).await {
            tracing::warn!(error = %fault, "this service stops, and could not say so to the other services");
        }
        let _in_time = tokio::time::timeout(LEFT_WITHIN, self.connections.close()).await;
    }

    /// Passes on the signals of the other services, until this one stops. A missed signal does no harm, because its
    /// receivers also look.
    async fn listen(self, connections: PgPool) {
        loop {
            let heard = tokio::select! {
                () = self.stop.cancelled() => break,
                heard = self.hear(&connections) => heard,
            };
            if let Err(fault) = heard {
                tracing::debug!(error = %fault, "the signals of the other services cannot be received");
            }
            tokio::select! {
                () = self.stop.cancelled() => break,
                () = tokio::time::sleep(LISTEN_AGAIN) => {}
            }
        }
        let _in_time = tokio::time::timeout(LEFT_WITHIN, connections.close()).await;
    }

    async fn hear(&self, connections: &PgPool) -> Result<(), Error> {
        let channel: String =
            sqlx::query_scalar("SELECT 'trunnion_' || md5(current_schema())").fetch_one(connections).await?;
        let mut listener = PgListener::connect_with(connections).await?;
        listener.listen(&channel).await?;
        loop {
            // `None`: the connection was lost, and is made again.
            let Some(told) = listener.try_recv().await? else { continue };
            let signal = match told.payload().split_once(' ') {
                Some(("queued", id)) => Signal::Queued(id.into()),
                Some(("changed", id)) => Signal::Changed(id.into()),
                Some(("cancelled", id)) => Signal::Cancelled(id.into()),
                _ => {
                    self.key_changes.fetch_add(1, Ordering::SeqCst);
                    continue;
                }
            };
            // There may be no listener.
            let _followers = self.signals.send(signal);
        }
    }
}
