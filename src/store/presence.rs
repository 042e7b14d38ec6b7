//! Whether the server of the database is there, and whether this process is still the one service that has it. One
//! session of its own holds the service's lock and is asked every second. Several services share the lock, and none of
//! them takes the database over from another.
//!
//! The lock decides whether a service may start. The row of the table `service` decides whether it may write: the next
//! service changes the row, and every transaction that writes compares it. So a service that lost its session, and with
//! it the lock, never writes beside the next one.

use std::fmt;
use std::future::Future;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{Connection, Error};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::postgres::{ANSWERED_WITHIN, Holder};
use super::postgres_fault::{is_read_only, reason};

/// Time between two questions.
const EVERY: Duration = Duration::from_secs(1);
/// Time between two attempts to reach a server that is away.
const AGAIN: Duration = Duration::from_millis(500);
/// Longest time of one attempt.
const REACHED_WITHIN: Duration = Duration::from_secs(3);

/// What is known of the server.
#[derive(Debug, Clone, PartialEq, Eq)]
enum State {
    Here,
    /// It does not answer, and why.
    Away(Arc<str>),
    /// Another service has the database.
    TakenOver,
}

/// The server as it is known at present.
#[derive(Clone)]
pub(super) struct Presence {
    state: watch::Sender<State>,
    /// Connections that are older may lead to another server than the one that is there now.
    trusted_since: Arc<Mutex<Instant>>,
    stop: CancellationToken,
    tasks: TaskTracker,
}

impl fmt::Debug for Presence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Presence").field("state", &*self.state.borrow()).finish_non_exhaustive()
    }
}

impl Presence {
    /// A server that is there, and that nobody watches yet.
    pub(super) fn here() -> Self {
        Self {
            state: watch::Sender::new(State::Here),
            trusted_since: Arc::new(Mutex::new(Instant::now())),
            stop: CancellationToken::new(),
            tasks: TaskTracker::new(),
        }
    }

    /// Watches the server through the session that holds the service's lock, on behalf of this service.
    pub(super) fn watch(&self, session: PgConnection, options: PgConnectOptions, holder: Holder) {
        let watching = Watching { presence: self.clone(), options, holder };
        self.tasks.spawn(watching.run(session));
        self.tasks.close();
    }

    /// Ends the session, which frees the lock.
    pub(super) async fn end(&self) {
        self.stop.cancel();
        self.tasks.close();
        let _in_time = tokio::time::timeout(REACHED_WITHIN, self.tasks.wait()).await;
    }

    /// Whether the server answers, and the database is this service's, as far as is known.
    pub(super) fn is_here(&self) -> bool {
        *self.state.borrow() == State::Here
    }

    /// Whether a connection of this age leads to the server that is there now, as far as is known.
    pub(super) fn trusts(&self, age: Duration) -> bool {
        let since = *self.trusted_since.lock().unwrap_or_else(PoisonError::into_inner);
        age <= since.elapsed()
    }

    /// No earlier connection is used again: the address may lead to another server now.
    fn distrust_connections(&self) {
        *self.trusted_since.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// Another service has the database.
    pub(super) fn note_taken_over(&self) {
        self.state.send_replace(State::TakenOver);
    }

    /// Completed when another service has taken over the database.
    pub(super) async fn taken_over(&self) {
        let mut state = self.state.subscribe();
        // The sender lives as long as this.
        let _state = state.wait_for(|state| *state == State::TakenOver).await;
    }

    /// The answer of a call, unless the server goes away, or answers nothing for so long.
    pub(super) async fn within<T>(
        &self,
        limit: Duration,
        call: impl Future<Output = Result<T, Error>>,
    ) -> Result<T, Error> {
        tokio::select! {
            // First: nothing begins on a server that is known to be away.
            biased;
            fault = self.refuses_after(limit) => Err(fault),
            done = call => {
                if done.as_ref().is_err_and(is_read_only) {
                    self.distrust_connections();
                }
                done
            }
        }
    }

    /// Completed as soon as the server is away, or after this time.
    pub(super) async fn refuses_after(&self, limit: Duration) -> Error {
        let mut state = self.state.subscribe();
        let gone = async {
            match state.wait_for(|state| *state != State::Here).await.map(|state| state.clone()) {
                Ok(State::Away(reason)) => format!("the database server does not answer: {reason}"),
                _ => "another service has taken over the database".to_owned(),
            }
        };
        let text = tokio::select! {
            text = gone => text,
            () = tokio::time::sleep(limit) => format!("no answer within {} s", limit.as_secs()),
        };
        Error::Io(io::Error::new(io::ErrorKind::TimedOut, text))
    }

    fn note(&self, state: State) {
        self.state.send_if_modified(|known| {
            // Nothing gives a database back.
            let news = *known != state && *known != State::TakenOver;
            if news {
                *known = state;
            }
            news
        });
    }
}

/// The task that watches the server.
struct Watching {
    presence: Presence,
    options: PgConnectOptions,
    holder: Holder,
}

impl Watching {
    async fn run(self, session: PgConnection) {
        let mut session = Some(session);
        loop {
            let pause = if session.is_some() { EVERY } else { AGAIN };
            tokio::select! {
                () = self.presence.stop.cancelled() => break,
                () = tokio::time::sleep(pause) => {}
            }
            let answered = match session.as_mut() {
                Some(session) => writes_in_time(session).await,
                None => false,
            };
            if !answered {
                if session.take().is_some() {
                    tracing::warn!("the session that holds the database for this service is lost");
                }
                session = self.reach().await;
            }
        }
        if let Some(session) = session {
            let _in_time = tokio::time::timeout(REACHED_WITHIN, session.close()).await;
        }
    }

    /// A new session, if the server is there; it notes what it finds.
    async fn reach(&self) -> Option<PgConnection> {
        let found = tokio::time::timeout(REACHED_WITHIN, self.attempt()).await;
        let found = found.unwrap_or_else(|_late| Err(Error::Io(io::ErrorKind::TimedOut.into())));
        match found {
            Ok((session, true)) => {
                if *self.presence.state.borrow() != State::Here {
                    tracing::info!("the database server answers again");
                }
                self.presence.distrust_connections();
                self.presence.note(State::Here);
                Some(session)
            }
            Ok((_session, false)) => {
                tracing::error!("another service has taken over the database");
                self.presence.note(State::TakenOver);
                None
            }
            Err(fault) => {
                let reason: Arc<str> = reason(&fault).into();
                if *self.presence.state.borrow() != State::Away(Arc::clone(&reason)) {
                    tracing::error!(error = %fault, "the database server does not answer");
                }
                self.presence.note(State::Away(reason));
                None
            }
        }
    }

    /// A session, and whether the database is still this service's.
    async fn attempt(&self) -> Result<(PgConnection, bool), Error> {
        let mut session = PgConnection::connect_with(&self.options).await?;
        // A session of before may still have the lock, as long as the server does not know that it is dead.
        let lock = if self.holder == Holder::Several { TRY_SHARED_LOCK } else { TRY_LOCK };
        let _whether: bool = sqlx::query_scalar(lock).fetch_one(&mut session).await?;
        writes(&mut session).await?;
        let Holder::Alone(own) = &self.holder else { return Ok((session, true)) };
        let present: String =
            sqlx::query_scalar("SELECT instance FROM service").fetch_one(&mut session).await?;
        Ok((session, &present == own))
    }
}

/// Whether the server of a session writes.
///
/// # Errors
/// It is a standby, or it does not answer.
pub(super) async fn writes(session: &mut PgConnection) -> Result<(), Error> {
    let is_standby: bool = sqlx::query_scalar("SELECT pg_is_in_recovery()").fetch_one(session).await?;
    if is_standby {
        return Err(Error::Io(io::Error::other("it is a standby that does not write")));
    }
    Ok(())
}

/// Whether the server of a session answers soon that it writes.
async fn writes_in_time(session: &mut PgConnection) -> bool {
    matches!(tokio::time::timeout(ANSWERED_WITHIN, writes(session)).await, Ok(Ok(())))
}

/// Takes the lock of the service for the session, if it is free. The key is that of the schema, so that several plants
/// can share a database.
pub(super) const TRY_LOCK: &str = "SELECT pg_try_advisory_lock(1953656943, hashtext(current_schema()))";
/// The same for one of several services: it keeps those away that have a database alone.
pub(super) const TRY_SHARED_LOCK: &str =
    "SELECT pg_try_advisory_lock_shared(1953656943, hashtext(current_schema()))";
