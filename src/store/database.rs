//! The database of a service: connections that only read, and one transaction after the other that writes.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use futures::future::BoxFuture;
use sqlx::sqlite::SqlitePool;

use super::audit_chain::chain_old_entries;
use super::error::Doing;
#[cfg(feature = "scale-out")]
use super::postgres::Order;
#[cfg(feature = "scale-out")]
use super::postgres_opening::{self, Purpose, Server};
use super::sql::{Db, Instance, On, PgWriter, SharedFiles, Tx};
use super::sqlite::{self, is_empty, no_files_beside};
use super::{DATABASE_NAME, Depth, Examination, Soundness, StoreError, StoredThing, verify_text};
use crate::config::Settings;
use crate::meter;

/// The database of one data directory.
#[derive(Debug, Clone)]
pub struct Store {
    pub(super) db: Db,
    writer: On<SqlitePool, PgWriter>,
    /// The name under which jobs are taken; only on a server.
    pub(super) name: Option<Arc<str>>,
    /// Set if other services may use the database too.
    pub(super) instance: Option<Instance>,
    files: Option<SharedFiles>,
    writes: Arc<AtomicU64>,
    soundness: Arc<Soundness>,
}

impl Store {
    /// Opens the database file, creates it if it is missing, and updates it to the newest form.
    ///
    /// # Errors
    /// The file cannot be opened or migrated, the linked `SQLite` is too old, or the database does not know the files
    /// that are stored beside it.
    pub async fn open(file: &Path, readers: u32) -> Result<Self, StoreError> {
        if is_empty(file) {
            // Checked before anything is created, and before SQLite removes a write-ahead log without a database.
            no_files_beside(directory_of(file), file)?;
        }
        let store = Self::of_file(sqlite::open(file, readers, true).await?);
        let chained = store
            .write("chaining the audit log", |tx| Box::pin(async move { chain_old_entries(tx).await }))
            .await?;
        if chained > 0 {
            tracing::info!(entries = chained, "the audit log of an earlier version is a chain from now on");
        }
        // Every database that a service has used contains a machine, whatever was deleted since.
        if store.has_no_machine_yet().await?
            && let Err(fault) = no_files_beside(directory_of(file), file)
        {
            store.close().await;
            return Err(fault);
        }
        Ok(store)
    }

    /// Opens the database beside a running service: nothing is created or migrated.
    ///
    /// # Errors
    /// The file is missing, or not in the form of this version.
    pub async fn open_beside(file: &Path) -> Result<Self, StoreError> {
        Ok(Self::of_file(sqlite::open(file, 1, false).await?))
    }

    /// Opens the database that the settings name, for the service of their data directory. `instance` is a text that
    /// was never used before.
    ///
    /// # Errors
    /// The same as [`Self::open`]; or the server cannot be used, or another service has its database.
    #[cfg_attr(not(feature = "scale-out"), expect(unused_variables, reason = "a file has a lock of its own"))]
    pub async fn open_as_set(settings: &Settings, readers: u32, instance: &str) -> Result<Self, StoreError> {
        #[cfg(feature = "scale-out")]
        if let Some(address) = &settings.database {
            let (server, purpose) = (Server::as_set(settings, address)?, Purpose::Service(&settings.files));
            let opened = server.open(&settings.data_dir, readers, instance.to_owned(), purpose);
            return Ok(Self::of_server(Box::pin(opened).await?));
        }
        #[cfg(not(feature = "scale-out"))]
        if settings.database.is_some() {
            return Err(StoreError::NoServers);
        }
        Self::open(&settings.data_dir.join(DATABASE_NAME), readers).await
    }

    /// The same for a command that has the data directory alone. It finds the database in use if a service has it.
    ///
    /// # Errors
    /// The same as [`Self::open_as_set`].
    pub async fn open_for_command_as_set(settings: &Settings, name: &str) -> Result<Self, StoreError> {
        #[cfg(feature = "scale-out")]
        if let Some(address) = &settings.database {
            let server = Server::as_set(settings, address)?;
            let opened = server.open(&settings.data_dir, 1, name.to_owned(), Purpose::Command);
            return Ok(Self::of_server(Box::pin(opened).await?));
        }
        Self::open_as_set(settings, 1, name).await
    }

    /// Opens the database that the settings name beside a running service: nothing is created or migrated.
    ///
    /// # Errors
    /// The same as [`Self::open_beside`]; or the server cannot be used.
    pub async fn open_beside_as_set(settings: &Settings) -> Result<Self, StoreError> {
        #[cfg(feature = "scale-out")]
        if let Some(address) = &settings.database {
            return Ok(Self::of_server(Box::pin(Server::as_set(settings, address)?.open_beside()).await?));
        }
        #[cfg(not(feature = "scale-out"))]
        if settings.database.is_some() {
            return Err(StoreError::NoServers);
        }
        Self::open_beside(&settings.data_dir.join(DATABASE_NAME)).await
    }

    /// Examines the database on a server that the settings name, and its files, to this depth. Nothing is changed, and
    /// services may run. `None` if no service has used the database.
    ///
    /// # Errors
    /// The server cannot be used, or the database failed.
    #[cfg_attr(not(feature = "scale-out"), expect(unused_variables, reason = "this binary knows no server"))]
    #[cfg_attr(
        not(feature = "scale-out"),
        expect(clippy::unused_async, reason = "this binary knows no server")
    )]
    pub async fn examine_server(
        settings: &Settings,
        depth: &Depth,
    ) -> Result<Option<Examination>, StoreError> {
        #[cfg(feature = "scale-out")]
        if let Some(address) = &settings.database {
            let server = Server::as_set(settings, address)?;
            return Box::pin(server.examine(depth)).await;
        }
        Err(StoreError::NoServers)
    }

    /// Completed when another service has taken over the database: this one can store nothing any more, and has to end.
    pub async fn taken_over(&self) {
        match &self.writer {
            // The lock of its directory cannot be lost.
            On::Sqlite(_) => std::future::pending().await,
            #[cfg(feature = "scale-out")]
            On::Postgres(writer) => writer.taken_over().await,
            #[cfg(not(feature = "scale-out"))]
            On::Postgres(never) => match *never {},
        }
    }

    #[cfg(feature = "scale-out")]
    fn of_server(opened: postgres_opening::Opened) -> Self {
        let postgres_opening::Opened { readers, writer, name, shared } = opened;
        let (instance, files) = shared.unzip();
        let store = Self::over(Db(On::Postgres(readers)), On::Postgres(writer));
        Self { name: name.map(Arc::from), instance, files, ..store }
    }

    fn of_file(opened: sqlite::Opened) -> Self {
        let sqlite::Opened { readers, writer } = opened;
        Self::over(Db(On::Sqlite(readers)), On::Sqlite(writer))
    }

    fn over(db: Db, writer: On<SqlitePool, PgWriter>) -> Self {
        let (name, instance, files) = (None, None, None);
        Self { db, writer, name, instance, files, writes: Arc::default(), soundness: Arc::default() }
    }

    /// Where files are kept, if they are kept for several services.
    pub(super) fn files(&self) -> Option<&SharedFiles> {
        self.files.as_ref()
    }

    /// The same store, which records the damage that it finds there.
    #[must_use]
    pub fn noting_damage_in(self, soundness: &Arc<Soundness>) -> Self {
        Self { soundness: Arc::clone(soundness), ..self }
    }

    /// Whether a document is unchanged; damage is recorded.
    ///
    /// # Errors
    /// Its text has another digest.
    pub(super) fn verify(
        &self,
        name: impl FnOnce() -> String,
        text: &str,
        sha256: &str,
    ) -> Result<(), StoreError> {
        verify_text(|| StoredThing::Document(name()), text, sha256).map_err(|damaged| {
            self.soundness.damaged(&damaged);
            StoreError::Damaged(damaged)
        })?;
        self.soundness.sound(sha256);
        Ok(())
    }

    /// The number of write transactions that have ended: while it stays the same, everything read since is current.
    #[must_use]
    pub fn writes(&self) -> u64 {
        self.writes.load(Ordering::SeqCst)
    }

    /// Runs `work` in one write transaction, completely or not at all. The lock is taken at the start, and a failed
    /// transaction is rolled back before its connection is used again. Every error of a statement has to leave `work`:
    /// PostgreSQL stores nothing after one.
    pub(super) async fn write<T, F>(&self, doing: &'static str, work: F) -> Result<T, StoreError>
    where
        T: Send,
        F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, sqlx::Error>> + Send,
    {
        let _timed = meter::STORE_WRITES.begin();
        // It is counted however it ends, even if the caller no longer waits for it.
        let _counted = Counted(&self.writes);
        match &self.writer {
            On::Sqlite(writer) => sqlite::write(writer, doing, work).await,
            #[cfg(feature = "scale-out")]
            // Boxed, so that the futures of all requests keep their size.
            On::Postgres(writer) => Box::pin(writer.write(doing, Order::InTurn, work)).await,
            #[cfg(not(feature = "scale-out"))]
            On::Postgres(never) => match *never {},
        }
    }

    /// The same for work that changes only rows that it locks: it need not wait for the transactions of other services.
    pub(super) async fn write_apart<T, F>(&self, doing: &'static str, work: F) -> Result<T, StoreError>
    where
        T: Send,
        F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, sqlx::Error>> + Send,
    {
        #[cfg(feature = "scale-out")]
        if let On::Postgres(writer) = &self.writer {
            let _timed = meter::STORE_WRITES.begin();
            let _counted = Counted(&self.writes);
            return Box::pin(writer.write(doing, Order::Apart, work)).await;
        }
        self.write(doing, work).await
    }

    /// Whether the database answers, and the bucket if files are in one.
    ///
    /// # Errors
    /// One of the two does not.
    pub async fn check(&self) -> Result<(), StoreError> {
        let _one: i64 =
            sql!(self.db, one(_), "SELECT CAST(1 AS BIGINT) AS \"one!\"").doing("checking the database")?;
        #[cfg(feature = "scale-out")]
        if let Some(files) = &self.files {
            Box::pin(files.check()).await?;
        }
        Ok(())
    }

    /// Closes every connection; the write-ahead log is merged by the last.
    pub async fn close(&self) {
        #[cfg(feature = "scale-out")]
        if let (Some(instance), Some(files)) = (&self.instance, &self.files) {
            instance.leave().await;
            files.close().await;
        }
        match &self.db.0 {
            On::Sqlite(readers) => readers.close().await,
            #[cfg(feature = "scale-out")]
            On::Postgres(readers) => readers.close().await,
            #[cfg(not(feature = "scale-out"))]
            On::Postgres(never) => match *never {},
        }
        match &self.writer {
            On::Sqlite(writer) => writer.close().await,
            #[cfg(feature = "scale-out")]
            On::Postgres(writer) => writer.close().await,
            #[cfg(not(feature = "scale-out"))]
            On::Postgres(never) => match *never {},
        }
    }
}

/// The directory of a database file.
fn directory_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new("."))
}

/// Counts when it is dropped.
struct Counted<'a>(&'a AtomicU64);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.fetch_add(1, Ordering::SeqCst);
    }
}
