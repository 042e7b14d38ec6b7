//! The database on a server of PostgreSQL: connections that only read, and one that writes. Every call has a deadline
//! of its own, because a server that disappears without closing its connections never answers.

use std::fmt;
use std::io;
use std::task::Poll;
use std::time::Duration;

use futures::StreamExt;
use futures::future::{BoxFuture, FutureExt};
use futures::stream::{BoxStream, poll_fn};
use sqlx::pool::PoolConnection;
use sqlx::postgres::{
    PgConnectOptions, PgConnection, PgPool, PgPoolOptions, PgQueryResult, PgRow, PgStatement, PgTypeInfo,
};
use sqlx::{Connection, Either, Error, Execute, Executor, Postgres, SqlStr};

use super::StoreError;
use super::error::Doing;
use super::postgres_fault::is_read_only;
use super::presence::{Presence, writes};
use super::sql::{On, Tx};
use crate::meter;

/// Longest time for a connection, from the pool or from the server, as for a file.
const CONNECTED_WITHIN: Duration = Duration::from_secs(10);
/// Longest time in which a connection that was idle shows that it still works.
pub(super) const ANSWERED_WITHIN: Duration = Duration::from_secs(2);
/// Longest time of one statement that reads, and of one transaction that writes. The server's own limits are shorter,
/// so that it has given up before.
const READ_WITHIN: Duration = Duration::from_secs(40);
const WRITE_WITHIN: Duration = Duration::from_secs(40);

/// Settings of every session at the server. They limit the time of a statement, the wait for a lock and an idle
/// transaction. They also say how long the service may be silent until the server closes the session.
const LIMITS: [(&str, &str); 6] = [
    ("statement_timeout", "30s"),
    ("lock_timeout", "10s"),
    ("idle_in_transaction_session_timeout", "15s"),
    ("tcp_keepalives_idle", "10"),
    ("tcp_keepalives_interval", "5"),
    ("tcp_keepalives_count", "3"),
];

/// The session options of every connection.
pub(super) fn with_limits(options: PgConnectOptions) -> PgConnectOptions {
    options.application_name("trunnion").options(LIMITS)
}

/// A pool of up to `count` connections. No connection is kept open on purpose: after an outage the task of the pool that
/// does so waits up to a minute until it tries again, and holds the place of a connection meanwhile.
pub(super) async fn pool(
    options: PgConnectOptions,
    count: u32,
    presence: &Presence,
) -> Result<PgPool, StoreError> {
    let (presence, known) = (presence.clone(), presence.clone());
    PgPoolOptions::new()
        .max_connections(count)
        .acquire_timeout(CONNECTED_WITHIN)
        .idle_timeout(None)
        .max_lifetime(None)
        .test_before_acquire(false)
        // The pool's own test waits for ever if the server has gone away without a word. A connection from before an
        // outage may lead to a server that was left, or that only reads.
        .before_acquire(move |connection, of| {
            let is_trusted = known.trusts(of.age);
            Box::pin(async move { Ok(is_trusted && answers(connection).await) })
        })
        // The pool asks a connection that comes back too, and waits as long: one to a server that is away goes at once.
        .after_release(move |_, _| {
            let is_here = presence.is_here();
            Box::pin(async move { Ok(is_here) })
        })
        .after_connect(|connection, _| Box::pin(begin(connection)))
        .connect_with(options)
        .await
        .doing("connecting to the database")
}

/// Whether a connection works.
async fn answers(connection: &mut PgConnection) -> bool {
    matches!(tokio::time::timeout(ANSWERED_WITHIN, connection.ping()).await, Ok(Ok(())))
}

/// Begins a session: at a server that writes, and what is acknowledged has to be on the disk, whatever the server does
/// for others.
async fn begin(connection: &mut PgConnection) -> Result<(), Error> {
    writes(connection).await?;
    let text = "SELECT set_config('synchronous_commit', 'on', false) \
                WHERE current_setting('synchronous_commit') = 'off'";
    sqlx::query(text).execute(connection).await.map(drop)
}

/// The connections that only read. Every query through them is timed, from the wait for a connection to its last row.
#[derive(Clone)]
pub(super) struct PgReaders {
    pool: PgPool,
    presence: Presence,
}

impl PgReaders {
    /// Connections of which at most `count` are in use at once.
    ///
    /// # Errors
    /// The server does not answer.
    pub(super) async fn connect(
        options: PgConnectOptions,
        count: u32,
        presence: Presence,
    ) -> Result<Self, StoreError> {
        let options = options.options([("default_transaction_read_only", "on")]);
        Ok(Self { pool: pool(options, count, &presence).await?, presence })
    }

    /// A connection for several statements.
    ///
    /// # Errors
    /// The server does not answer, or every connection is in use for too long.
    pub(super) async fn acquire(&self) -> Result<PoolConnection<Postgres>, Error> {
        self.pool.acquire().await
    }

    /// The server as it is known at present.
    pub(super) fn presence(&self) -> &Presence {
        &self.presence
    }

    /// Closes every connection.
    pub(super) async fn close(&self) {
        let _in_time = tokio::time::timeout(ANSWERED_WITHIN, self.pool.close()).await;
    }
}

/// Options of connections hold a password.
impl fmt::Debug for PgReaders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("PgReaders")
    }
}

impl<'p> Executor<'p> for &'_ PgReaders {
    type Database = Postgres;

    fn fetch_many<'e, 'q: 'e, E>(self, query: E) -> BoxStream<'e, Result<Either<PgQueryResult, PgRow>, Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Postgres>,
    {
        let timed = meter::STORE_READS.begin();
        let mut rows = (&self.pool).fetch_many(query);
        let presence = self.presence.clone();
        let mut refusal = Box::pin(async move { presence.refuses_after(READ_WITHIN).await }).fuse();
        poll_fn(move |context| {
            // The stream measures the time, which ends with it.
            let _held = &timed;
            match refusal.poll_unpin(context) {
                Poll::Ready(fault) => Poll::Ready(Some(Err(fault))),
                Poll::Pending => rows.poll_next_unpin(context),
            }
        })
        .boxed()
    }

    fn fetch_optional<'e, 'q: 'e, E>(self, query: E) -> BoxFuture<'e, Result<Option<PgRow>, Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Postgres>,
    {
        let timed = meter::STORE_READS.begin();
        let row = (&self.pool).fetch_optional(query);
        let presence = self.presence.clone();
        Box::pin(async move {
            let row = presence.within(READ_WITHIN, row).await;
            drop(timed);
            row
        })
    }

    fn prepare_with<'e>(
        self,
        sql: SqlStr,
        parameters: &'e [PgTypeInfo],
    ) -> BoxFuture<'e, Result<PgStatement, Error>>
    where
        'p: 'e,
    {
        (&self.pool).prepare_with(sql, parameters)
    }

    #[cfg(feature = "check-statements")]
    fn describe<'e>(self, sql: SqlStr) -> BoxFuture<'e, Result<sqlx::Describe<Postgres>, Error>>
    where
        'p: 'e,
    {
        (&self.pool).describe(sql)
    }
}

/// The connection that writes. One is enough: the transactions of all processes come one after the other.
#[derive(Clone)]
pub(super) struct PgWriter {
    pool: PgPool,
    presence: Presence,
    holder: Holder,
}

/// Who writes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Holder {
    /// A command beside a service.
    Beside,
    /// The one service that has the database, by its name.
    Alone(String),
    /// One of several services.
    Several,
}

/// Whether a transaction has to come before or after every other one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// It reads something and then writes what depends on it, as the audit log does.
    InTurn,
    /// It changes rows that it has locked, and nothing else depends on it.
    Apart,
}

impl fmt::Debug for PgWriter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PgWriter").field("holder", &self.holder).finish_non_exhaustive()
    }
}

/// Another service has taken over the database.
#[derive(Debug, thiserror::Error)]
#[error("another service has taken over the database")]
pub(super) struct TakenOver;

impl PgWriter {
    /// One connection.
    ///
    /// # Errors
    /// The server does not answer.
    pub(super) async fn connect(
        options: PgConnectOptions,
        presence: Presence,
        holder: Holder,
    ) -> Result<Self, StoreError> {
        Ok(Self { pool: pool(options, 1, &presence).await?, presence, holder })
    }

    /// Runs `work` in one transaction, in turn with those of every other process unless it is `Apart`.
    ///
    /// # Errors
    /// The database failed, or another service has it; nothing is stored. If the server goes away while the transaction
    /// ends, nobody knows whether it is stored.
    pub(super) async fn write<T, F>(
        &self,
        doing: &'static str,
        order: Order,
        work: F,
    ) -> Result<T, StoreError>
    where
        T: Send,
        F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, Error>> + Send,
    {
        self.presence.within(WRITE_WITHIN, self.transact(order, work)).await.doing(doing)
    }

    async fn transact<T, F>(&self, order: Order, work: F) -> Result<T, Error>
    where
        T: Send,
        F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, Error>> + Send,
    {
        let mut connection = self.pool.acquire().await?;
        let done = self.transact_on(&mut connection, order, work).await;
        if done.as_ref().is_err_and(ends_the_connection) {
            connection.close_on_drop();
        }
        done
    }

    async fn transact_on<T, F>(
        &self,
        connection: &mut PgConnection,
        order: Order,
        work: F,
    ) -> Result<T, Error>
    where
        T: Send,
        F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, Error>> + Send,
    {
        // In one journey to the server. The key is that of the schema, as in `presence`.
        let begin = match (order, &self.holder) {
            (Order::Apart, Holder::Several) => "BEGIN",
            // A service that has the database alone compares the holder, and that only in turn with the next one.
            _ => "BEGIN; SELECT pg_advisory_xact_lock(1953656942, hashtext(current_schema()))",
        };
        let mut transaction = connection.begin_with(begin).await?;
        if let Holder::Alone(own) = &self.holder {
            // A statement of its own: it has to see what the holder before has committed.
            let present: String =
                sqlx::query_scalar("SELECT instance FROM service").fetch_one(&mut *transaction).await?;
            if &present != own {
                self.presence.note_taken_over();
                return Err(io::Error::other(TakenOver).into());
            }
        }
        match work(&mut Tx(On::Postgres(&mut transaction))).await {
            Ok(done) => transaction.commit().await.map(|()| done),
            Err(fault) => {
                if let Err(also) = transaction.rollback().await {
                    tracing::debug!(error = %also, "a transaction could not be rolled back");
                }
                Err(fault)
            }
        }
    }

    /// Completed when another service has taken over the database.
    pub(super) async fn taken_over(&self) {
        self.presence.taken_over().await;
    }

    /// Closes the connection, and frees the database.
    pub(super) async fn close(&self) {
        let _in_time = tokio::time::timeout(ANSWERED_WITHIN, self.pool.close()).await;
        self.presence.end().await;
    }
}

/// Whether a connection is not used again after this fault: it is broken, or leads to a server that does not write.
fn ends_the_connection(fault: &Error) -> bool {
    match fault {
        Error::Io(_) | Error::Tls(_) | Error::Protocol(_) => true,
        // After a failover the connection leads to the server that was left.
        Error::Database(state) => {
            is_read_only(fault) || state.code().is_some_and(|code| code.starts_with("57P"))
        }
        _ => false,
    }
}
