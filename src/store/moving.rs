//! Moves a data directory to a server of PostgreSQL: every row, and every file if files are to be there or in a bucket. The rows are one
//! transaction, which is compared with the file before it ends. Files come before it; a second run goes on with them.
//! The directory is left as it is until the server has everything. Then its database file gets another name, so that no
//! service begins with it again. So does the folder of its files if they are elsewhere now: a service would take them for
//! copies, and remove them.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use sqlx::postgres::{PgConnection, PgDatabaseError};
use sqlx::{AssertSqlSafe, Connection, Error, Executor};
use thiserror::Error;

use super::backup::examined;
use super::error::Doing;
use super::moved_tables::{Content, ORDER, REFERS_BACK, Table};
use super::postgres_opening::{DATABASE_ID, Server};
use super::presence::Presence;
use super::shared_files::SharedFiles;
use super::sqlite::{is_empty, merged};
use super::stored_file::{is_no_plain_file, open_below, verify};
use super::{
    BackupFault, BlobFault, DATABASE_NAME, Damage, DamagedFile, DatabaseFile, Sha256Hex, StoreError,
    StoredThing, Verifying, own_schema,
};
use crate::config::{DatabaseAddress, FilesIn, Settings};

/// What is added to the names of a database file and a folder of files whose content is on a server.
const MOVED: &str = ".migrated";
/// The holder of leases of jobs that were running; no service has this name, so that any of them takes the jobs up.
const NOBODY: &str = "moved";

/// Longest part of what the server says of a row \[characters\].
const MAX_DETAIL: usize = 300;

/// Why a data directory was not moved.
#[derive(Debug, Error)]
pub enum MoveFault {
    /// The server or the file failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The database in the directory is damaged, or cannot be read.
    #[error("nothing was moved: {0}")]
    Source(#[from] BackupFault),
    /// A file is damaged.
    #[error("nothing was moved: {0}")]
    Damaged(DamagedFile),
    /// A file could not be kept.
    #[error("nothing was moved: {0}")]
    Blob(#[from] BlobFault),
    /// A file could not be read or written.
    #[error("while {doing} {}: {source}", path.display())]
    File {
        /// The action that failed.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The directory has no database.
    #[error("there is no database in {}: name the directory with --data-dir", .0.display())]
    NoDatabase(PathBuf),
    /// The directory was moved before.
    #[error(
        "{} is there: this directory was moved to a server before. Nothing was moved. If that database was given up, \
         move this file away first", .0.display()
    )]
    MovedBefore(PathBuf),
    /// The database in the directory has another schema.
    #[error(
        "the database has schema {found}, but only schema {ours} can be moved: run trunnion migrate without --to first, \
         after a backup"
    )]
    OtherSchema {
        /// Schema of the database.
        found: i64,
        /// Newest schema of this version.
        ours: i64,
    },
    /// Texts that the server cannot store.
    #[error(
        "PostgreSQL stores no text with the character U+0000, and these have it: {}. Nothing was moved; this directory \
         has to stay with its database file", .0.join("; ")
    )]
    Nul(Vec<String>),
    /// The target is in use.
    #[error(
        "{database} has rows already (table {table}); nothing was moved. Name an empty database, or an empty schema \
         with ?options[search_path]=NAME"
    )]
    Occupied {
        /// The address without a password.
        database: String,
        /// A table with rows.
        table: &'static str,
    },
    /// The target has an earlier copy, and one of the two has changed since.
    #[error(
        "{database} has an earlier copy of this directory, and the table {table} differs: one of the two was used since. \
         Nothing was moved. If the server has the data that count, move {} away; if the directory has them, drop the \
         schema on the server", file.display()
    )]
    Differs {
        /// The address without a password.
        database: String,
        /// A table with other rows.
        table: &'static str,
        /// The database file.
        file: PathBuf,
    },
    /// The server refuses a row.
    #[error("the server refuses a row of the table {table}: {why}. Nothing was moved")]
    Refused {
        /// The table.
        table: &'static str,
        /// The words of the server.
        why: String,
    },
    /// The server gives back other rows than were sent.
    #[error(
        "the table {table} has {found} rows on the server that are not the {expected} of the file; nothing was moved"
    )]
    Unequal {
        /// The table.
        table: &'static str,
        /// Rows on the server.
        found: u64,
        /// Rows in the file.
        expected: u64,
    },
}

fn at<'a>(doing: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> MoveFault + 'a {
    move |source| MoveFault::File { doing, path: path.to_owned(), source }
}

/// What was moved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Moved {
    /// Rows of all tables.
    pub rows: u64,
    /// Files that jobs name; each was read and compared with its digest.
    pub files: usize,
    /// Length of all these files \[bytes\].
    pub file_bytes: u64,
    /// The database file under its new name.
    pub left: PathBuf,
    /// Whether an earlier run had stored everything, and only names were changed now.
    pub was_complete: bool,
}

/// The tables of a database file with what they contain.
type Contents = Vec<(Table, Content)>;

/// Moves the data directory of the settings to the database at this address. The caller holds the lock of the
/// directory, and `instance` is a text that was never used before.
///
/// # Errors
/// Why nothing was moved. If the process dies, a second run goes on, or begins again.
pub async fn move_to_server(
    settings: &Settings,
    address: &DatabaseAddress,
    instance: &str,
) -> Result<Moved, MoveFault> {
    let (data_dir, place) = (&settings.data_dir, &settings.files);
    let database = data_dir.join(DATABASE_NAME);
    let left = data_dir.join(format!("{DATABASE_NAME}{MOVED}"));
    if left.symlink_metadata().is_ok() {
        return Err(MoveFault::MovedBefore(left));
    }
    if is_empty(&database) {
        return Err(MoveFault::NoDatabase(data_dir.clone()));
    }
    let server = Server::as_set(settings, address)?;
    // The server first: reading everything takes long.
    let (options, mut session) = server.open_to_fill(instance).await?;
    let (named, contents) = source(&database).await?;
    let found = target(&mut session, &contents).await?;
    let mut moved = Moved {
        rows: contents.iter().map(|(_, content)| content.rows).sum(),
        files: named.len(),
        file_bytes: 0,
        left: left.clone(),
        was_complete: false,
    };
    if let Some(table) = found.table {
        let is_ours = noted(data_dir).is_some_and(|id| id == found.id) && found.files == place.to_string();
        if !is_ours {
            return Err(MoveFault::Occupied { database: address.to_string(), table });
        }
        if let Some(table) = differing(&mut session, &contents).await? {
            return Err(MoveFault::Differs { database: address.to_string(), table, file: database });
        }
        moved.was_complete = true;
    }
    let shared = if place.is_shared() {
        let shared = SharedFiles::connect(options, Presence::here(), (place, settings), &found.id).await?;
        // What an earlier run has moved is in the bucket of that run.
        shared.enter(!moved.was_complete, instance).await?;
        Some(shared)
    } else {
        None
    };
    let [blobs, blobs_left] =
        [String::new(), MOVED.to_owned()].map(|end| data_dir.join(format!("blobs{end}")));
    let from = if blobs.is_dir() || !blobs_left.is_dir() { &blobs } else { &blobs_left }.clone();
    let files = tokio::task::spawn_blocking(move || {
        let kept: Result<u64, MoveFault> =
            named.iter().try_fold(0, |sum, sha256| Ok(sum + keep(&from, sha256, shared.as_ref())?));
        (kept, shared)
    });
    let (kept, shared) = files.await.map_err(io::Error::other).map_err(at("reading", data_dir))?;
    if let Some(shared) = shared {
        shared.close().await;
    }
    moved.file_bytes = kept?;
    // Before the rows are there: a run after the death of this one has to find that they are this directory's.
    note(data_dir, &found.id)?;
    if !moved.was_complete {
        fill(&mut session, &database, &contents, place).await?;
    }
    // The database last: as long as it has its name, a second run finds the files under either name.
    if place.is_shared() && blobs.is_dir() {
        fs::rename(&blobs, &blobs_left).map_err(at("renaming", &blobs))?;
    }
    set_aside(&database, &left)?;
    if let Err(fault) = session.close().await {
        tracing::debug!(error = %fault, "the session that moved the rows was not closed properly");
    }
    Ok(moved)
}

/// Reads everything in the database file: it has to be sound, and every text of a kind that the server stores.
async fn source(database: &Path) -> Result<(BTreeSet<Sha256Hex>, Contents), MoveFault> {
    let mut file = DatabaseFile::open(database).await?;
    let found = file.schema().await?.unwrap_or_default();
    file.close().await;
    if found != own_schema() {
        return Err(MoveFault::OtherSchema { found, ours: own_schema() });
    }
    merged(database).await?;
    let named = examined(database).await?.named;
    let mut file = DatabaseFile::open(database).await?;
    let (mut contents, mut nul) = (Vec::new(), Vec::new());
    for name in ORDER {
        let doing = "reading a table that is to be moved";
        let table = Table::of(file.connection(), name).await.doing(doing)?;
        let content = table.in_the_file(file.connection(), &mut nul).await.doing(doing)?;
        contents.push((table, content));
    }
    file.close().await;
    if nul.is_empty() { Ok((named, contents)) } else { Err(MoveFault::Nul(nul)) }
}

/// What is at the target.
struct Target {
    id: String,
    /// Where its files are; empty if nobody has said.
    files: String,
    /// A table with rows.
    table: Option<&'static str>,
}

async fn target(session: &mut PgConnection, contents: &Contents) -> Result<Target, StoreError> {
    let doing = "asking whether the database is empty";
    let (id, files) = sqlx::query_as("SELECT database_id, files FROM service")
        .fetch_one(&mut *session)
        .await
        .doing(doing)?;
    for (table, _) in contents {
        if !table.is_empty(session).await.doing(doing)? {
            return Ok(Target { id, files, table: Some(table.name) });
        }
    }
    Ok(Target { id, files, table: None })
}

/// A table whose rows on the server are not those of the file.
async fn differing(
    session: &mut PgConnection,
    contents: &Contents,
) -> Result<Option<&'static str>, StoreError> {
    for (table, expected) in contents {
        let found = table.on_the_server(session).await.doing("reading the rows on the server")?;
        if found != *expected {
            return Ok(Some(table.name));
        }
    }
    Ok(None)
}

/// Compares a file with its digest. If files do not stay in the directory, it is kept in their place, and read there once
/// more. Answers its length. Blocks.
fn keep(blobs: &Path, sha256: &str, shared: Option<&SharedFiles>) -> Result<u64, MoveFault> {
    let folder = sha256.get(..2).unwrap_or("00");
    let path = blobs.join(folder).join(sha256);
    let damaged = |damage| {
        MoveFault::Damaged(DamagedFile { what: StoredThing::File, sha256: sha256.to_owned(), damage })
    };
    let mut file = open_below(blobs, &[folder], sha256).map_err(|fault| match fault.kind() {
        io::ErrorKind::NotFound => damaged(Damage::Missing),
        _ if is_no_plain_file(&fault) => damaged(Damage::NoPlainFile),
        _ => at("opening", &path)(fault),
    })?;
    verify(&mut file, sha256, |_| Ok(())).map_err(at("reading", &path))?.map_err(MoveFault::Damaged)?;
    let length = file.metadata().map_err(at("asking for", &path))?.len();
    if let Some(shared) = shared {
        shared.keep(sha256, &file, length)?;
        let mut verifying = Verifying::new(sha256);
        shared.read(sha256, |bytes| {
            verifying.take(bytes);
            Ok(())
        })?;
        verifying.finish().map_err(MoveFault::Damaged)?;
    }
    Ok(length)
}

/// Stores every row in one transaction, reads all of them again, and compares them with the file.
async fn fill(
    session: &mut PgConnection,
    database: &Path,
    contents: &Contents,
    place: &FilesIn,
) -> Result<(), MoveFault> {
    let doing = "moving the rows";
    let mut file = DatabaseFile::open(database).await?;
    let mut transaction = session.begin().await.doing(doing)?;
    let refers_back = begin(&mut transaction, place).await.doing(doing)?;
    for (table, _) in contents {
        let copied = table.copy(file.connection(), &mut transaction).await;
        copied.map_err(|fault| of_table(table.name, fault))?;
    }
    end(&mut transaction, &mut file, &refers_back, place).await.doing(doing)?;
    file.close().await;
    for (table, expected) in contents {
        let found = table.on_the_server(&mut transaction).await.doing(doing)?;
        if found != *expected {
            let (table, found, expected) = (table.name, found.rows, expected.rows);
            return Err(MoveFault::Unequal { table, found, expected });
        }
    }
    transaction.commit().await.doing(doing)?;
    Ok(())
}

/// The fault of copying a table, with what the server says of the row if it refuses one.
fn of_table(table: &'static str, fault: Error) -> MoveFault {
    let refused = fault.as_database_error().and_then(|fault| fault.try_downcast_ref::<PgDatabaseError>());
    if let Some(refused) = refused.filter(|fault| matches!(fault.code().get(..2), Some("22" | "23"))) {
        let detail = refused.detail().unwrap_or_default().chars().take(MAX_DETAIL).collect::<String>();
        return MoveFault::Refused { table, why: format!("{}. {detail}", refused.message()) };
    }
    StoreError::Statement { doing: "moving the rows", source: fault }.into()
}

/// Begins to fill the database; answers the name of the reference that is checked at the end only.
async fn begin(transaction: &mut PgConnection, place: &FilesIn) -> Result<String, Error> {
    let limits = "SET LOCAL statement_timeout = 0; SET LOCAL idle_in_transaction_session_timeout = 0;
         SELECT set_config('synchronous_commit', 'on', true) WHERE current_setting('synchronous_commit') = 'off'";
    transaction.execute(limits).await?;
    sqlx::query("UPDATE service SET files = $1").bind(place.to_string()).execute(&mut *transaction).await?;
    if !place.is_shared() {
        // Of an earlier run that was to keep files elsewhere.
        transaction.execute("DELETE FROM files").await?;
    }
    let name: String = sqlx::query_scalar(REFERS_BACK).fetch_one(&mut *transaction).await?;
    let name = format!("\"{}\"", name.replace('"', "\"\""));
    let text = format!("ALTER TABLE machine_revisions ALTER CONSTRAINT {name} DEFERRABLE INITIALLY DEFERRED");
    sqlx::raw_sql(AssertSqlSafe(text)).execute(&mut *transaction).await?;
    Ok(name)
}

/// Checks what was left to the end, lets the numbers of rows go on where they were, and gives running jobs free.
async fn end(
    transaction: &mut PgConnection,
    file: &mut DatabaseFile,
    refers_back: &str,
    place: &FilesIn,
) -> Result<(), Error> {
    let text = format!(
        "SET CONSTRAINTS ALL IMMEDIATE; ALTER TABLE machine_revisions ALTER CONSTRAINT {refers_back} NOT DEFERRABLE"
    );
    sqlx::raw_sql(AssertSqlSafe(text)).execute(&mut *transaction).await?;
    let counted: Vec<(String, i64)> = sqlx::query_as("SELECT name, seq FROM sqlite_sequence WHERE seq > 0")
        .fetch_all(file.connection())
        .await?;
    for (table, last) in counted {
        // The audit log counts its entries itself.
        sqlx::query(
            "SELECT setval(sequence, $2) FROM pg_get_serial_sequence($1, 'seq') AS s (sequence)
             WHERE sequence IS NOT NULL",
        )
        .bind(table)
        .bind(last)
        .execute(&mut *transaction)
        .await?;
    }
    if place.is_shared() {
        // Whichever service is first takes them up, and no death counts.
        sqlx::query(
            "INSERT INTO job_leases (job_id, lease, holder, lease_until)
             SELECT id, lease, $1, clock_timestamp() FROM jobs WHERE state = 'running'",
        )
        .bind(NOBODY)
        .execute(&mut *transaction)
        .await?;
    }
    Ok(())
}

/// The database that a directory names.
fn noted(data_dir: &Path) -> Option<String> {
    fs::read_to_string(data_dir.join(DATABASE_ID)).ok().map(|text| text.trim().to_owned())
}

/// Names the database in the directory.
fn note(data_dir: &Path, id: &str) -> Result<(), MoveFault> {
    let path = data_dir.join(DATABASE_ID);
    let written = fs::write(&path, format!("{id}\n")).and_then(|()| File::open(&path)?.sync_all());
    written.map_err(at("writing", &path))?;
    sync(data_dir)
}

/// Gives the database file another name. Its log was merged into it, and goes with it.
fn set_aside(database: &Path, left: &Path) -> Result<(), MoveFault> {
    fs::rename(database, left).map_err(at("renaming", database))?;
    for end in ["-wal", "-shm"] {
        let [from, to] = [database, left].map(|path| {
            let mut name = path.as_os_str().to_owned();
            name.push(end);
            PathBuf::from(name)
        });
        match fs::rename(&from, to) {
            Err(fault) if fault.kind() != io::ErrorKind::NotFound => {
                return Err(at("renaming", &from)(fault));
            }
            _ => {}
        }
    }
    sync(left.parent().unwrap_or(Path::new(".")))
}

fn sync(folder: &Path) -> Result<(), MoveFault> {
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(at("synchronising", folder))
}
