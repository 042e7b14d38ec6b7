//! Opens a database on a server of PostgreSQL: for the one service that has it, for one of several services, or for a
//! command beside them.

use std::future::Future;
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{Connection, Error, Executor};

use super::error::Doing;
use super::instance::Instance;
use super::postgres::{Holder, PgReaders, PgWriter, with_limits};
use super::postgres_form::{accept_newer, migrate, own_form, schema};
use super::presence::{Presence, TRY_LOCK, TRY_SHARED_LOCK, writes};
use super::private::secret_in;
use super::shared_files::SharedFiles;
use super::sqlite::{is_empty, no_files_beside};
use super::{DATABASE_NAME, StoreError};
use crate::config::{DatabaseAddress, FilesIn, Settings};

/// The oldest server that the statements were tried on.
const OLDEST_SERVER: i32 = 15;
/// Longest time for the first connection.
const REACHED_WITHIN: Duration = Duration::from_secs(10);
/// How long the lock of a service that has just ended is waited for, and how often it is tried.
const LOCKED_WITHIN: Duration = Duration::from_secs(5);
const LOCK_AGAIN: Duration = Duration::from_millis(250);
/// How long the migration of another service is waited for.
const MIGRATED_WITHIN: Duration = Duration::from_mins(10);
/// The file that names the database of a data directory.
pub(super) const DATABASE_ID: &str = "database.id";

/// A database on a server.
#[derive(Debug)]
pub(super) struct Server<'a> {
    pub(super) address: &'a DatabaseAddress,
    pub(super) settings: &'a Settings,
    /// Overrides that of the address.
    pub(super) password: Option<String>,
}

/// The connections to a server.
pub(super) struct Opened {
    pub(super) readers: PgReaders,
    pub(super) writer: PgWriter,
    /// The name under which jobs are taken.
    pub(super) name: Option<String>,
    /// Set for one of several services.
    pub(super) shared: Option<(Instance, SharedFiles)>,
}

/// What a database is opened for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose<'a> {
    /// A service whose files are there.
    Service(&'a FilesIn),
    /// A command that finds no service.
    Command,
}

impl<'a> Purpose<'a> {
    /// The place of the files, if several services have them together.
    fn shared(self) -> Option<&'a FilesIn> {
        match self {
            Self::Service(files) => Some(files).filter(|files| files.is_shared()),
            Self::Command => None,
        }
    }
}

impl<'a> Server<'a> {
    /// The server at this address, with the password that the settings name.
    ///
    /// # Errors
    /// The file with the password cannot be used.
    pub(super) fn as_set(settings: &'a Settings, address: &'a DatabaseAddress) -> Result<Self, StoreError> {
        let password = settings.database_password_file.as_deref().map(secret_in).transpose()?;
        let password = password.map(|text| text.trim_end_matches(['\r', '\n']).to_owned());
        Ok(Self { address, settings, password })
    }
}

impl Server<'_> {
    pub(super) fn options(&self) -> Result<PgConnectOptions, StoreError> {
        if let Some(why) = self.address.fault() {
            return Err(StoreError::Address { why });
        }
        // The fault would quote the address.
        let options = PgConnectOptions::from_str(self.address.with_password());
        let options =
            options.map_err(|_quotes_it| StoreError::Address { why: "it is no address of PostgreSQL" })?;
        let options = with_limits(options);
        Ok(match &self.password {
            Some(password) => options.password(password),
            None => options,
        })
    }

    fn unreachable(&self, source: Error) -> StoreError {
        StoreError::Unreachable { database: self.address.to_string(), source }
    }

    async fn within<T>(&self, doing: impl Future<Output = Result<T, Error>>) -> Result<T, StoreError> {
        let late = |_| Error::Io(std::io::Error::from(std::io::ErrorKind::TimedOut));
        let done = tokio::time::timeout(REACHED_WITHIN, doing).await.map_err(late).flatten();
        done.map_err(|fault| self.unreachable(fault))
    }

    /// A session on a server that can be used.
    pub(super) async fn session(&self, options: &PgConnectOptions) -> Result<PgConnection, StoreError> {
        let mut session = self.within(PgConnection::connect_with(options)).await?;
        let asked: (String, String, bool) = self
            .within(
                sqlx::query_as(
                    "SELECT current_setting('server_version'), current_setting('server_encoding'),
                            current_schema() IS NOT NULL",
                )
                .fetch_one(&mut session),
            )
            .await?;
        let (version, encoding, has_schema) = asked;
        let major =
            version.split(|byte: char| !byte.is_ascii_digit()).next().and_then(|text| text.parse().ok());
        if major.is_none_or(|major: i32| major < OLDEST_SERVER) {
            return Err(StoreError::ServerTooOld { found: version, needed: OLDEST_SERVER });
        }
        if encoding != "UTF8" {
            return Err(StoreError::NotUtf8 { found: encoding });
        }
        if !has_schema {
            return Err(StoreError::NoSchema { database: self.address.to_string() });
        }
        Ok(session)
    }

    /// Opens the database for the service of a data directory, and updates it to the newest form. No other service has
    /// it from now on, unless all keep their files in it. `instance` is a text that was never used before.
    ///
    /// # Errors
    /// The server cannot be used, another service has the database, a newer version has migrated it, the directory
    /// belongs to another database, or the files of the database are in another place.
    pub(super) async fn open(
        &self,
        data_dir: &Path,
        readers: u32,
        instance: String,
        purpose: Purpose<'_>,
    ) -> Result<Opened, StoreError> {
        if !is_empty(&data_dir.join(DATABASE_NAME)) {
            return Err(StoreError::FileHere { directory: data_dir.to_owned() });
        }
        let options = self.options()?;
        let mut session = self.session(&options).await?;
        self.within(writes(&mut session)).await?;
        self.lock(&mut session, purpose).await?;
        one_after_the_other(&mut session).await?;
        migrate(&mut session).await?;
        self.is_no_half_copy(&mut session).await?;
        let id = note_directory(&mut session, data_dir).await?;
        let mut is_new = false;
        if let Purpose::Service(files) = purpose {
            is_new = choose_files(&mut session, files).await?;
        }
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        take(&mut session, &instance, host.trim()).await?;
        let presence = Presence::here();
        let (holder, shared) = if let Some(place) = purpose.shared() {
            let place = (place, self.settings);
            let files = SharedFiles::connect(options.clone(), presence.clone(), place, &id).await?;
            files.enter(is_new, &instance).await?;
            let own =
                Instance::open(options.clone(), presence.clone(), &instance, host.trim(), data_dir).await?;
            (Holder::Several, Some((own, files)))
        } else {
            (Holder::Alone(instance.clone()), None)
        };
        let opened = Opened {
            readers: PgReaders::connect(options.clone(), readers, presence.clone()).await?,
            writer: PgWriter::connect(options.clone(), presence.clone(), holder.clone()).await?,
            name: Some(instance),
            shared,
        };
        let doing = "letting the next service begin";
        session
            .execute("SELECT pg_advisory_unlock(1953656944, hashtext(current_schema()))")
            .await
            .doing(doing)?;
        presence.watch(session, options, holder);
        Ok(opened)
    }

    /// A session on the database in its newest form, and no service has the database as long as the session lasts: to
    /// fill it. `instance` is a text that was never used before.
    ///
    /// # Errors
    /// The server cannot be used, a service has the database, or a newer version has migrated it.
    pub(super) async fn open_to_fill(
        &self,
        instance: &str,
    ) -> Result<(PgConnectOptions, PgConnection), StoreError> {
        let options = self.options()?;
        let mut session = self.session(&options).await?;
        self.within(writes(&mut session)).await?;
        self.lock(&mut session, Purpose::Command).await?;
        one_after_the_other(&mut session).await?;
        migrate(&mut session).await?;
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        take(&mut session, instance, host.trim()).await?;
        Ok((options, session))
    }

    /// Refuses a database to which a data directory was to be moved, and that has its files but no rows.
    async fn is_no_half_copy(&self, session: &mut PgConnection) -> Result<(), StoreError> {
        let text = "SELECT EXISTS (SELECT 1 FROM files) AND NOT EXISTS (SELECT 1 FROM machines)
                        AND EXISTS (SELECT 1 FROM service WHERE files = '')";
        let doing = "asking whether the database is complete";
        if sqlx::query_scalar::<_, bool>(text).fetch_one(session).await.doing(doing)? {
            return Err(StoreError::HalfMoved { database: self.address.to_string() });
        }
        Ok(())
    }

    /// Opens the database beside a service that has it.
    ///
    /// # Errors
    /// The server cannot be used, or the database is not in the form of this version.
    pub(super) async fn open_beside(&self) -> Result<Opened, StoreError> {
        let options = self.options()?;
        let mut session = self.session(&options).await?;
        let (found, needed) = (schema(&mut session).await?.unwrap_or_default(), own_form());
        if found > needed {
            accept_newer(&mut session, found).await?;
        } else if found < needed {
            return Err(StoreError::OtherForm { found, needed });
        }
        let presence = Presence::here();
        Ok(Opened {
            readers: PgReaders::connect(options.clone(), 1, presence.clone()).await?,
            writer: PgWriter::connect(options, presence, Holder::Beside).await?,
            name: None,
            shared: None,
        })
    }

    /// Takes the lock of the service.
    async fn lock(&self, session: &mut PgConnection, purpose: Purpose<'_>) -> Result<(), StoreError> {
        let doing = "asking whether another service has the database";
        let lock = if purpose.shared().is_some() { TRY_SHARED_LOCK } else { TRY_LOCK };
        // A server notices within a moment that a process is gone.
        if locked_within(LOCKED_WITHIN, session, lock).await? {
            return Ok(());
        }
        let database = self.address.to_string();
        let holder = if schema(session).await?.is_some() {
            sqlx::query_as("SELECT host, process, version, since FROM service")
                .fetch_optional(session)
                .await
                .doing(doing)?
        } else {
            None
        };
        let (host, process, version, since): (String, i64, String, String) = holder.unwrap_or_default();
        Err(StoreError::InUse { database, host, process, version, since })
    }
}

/// Whether a lock was free within this time.
async fn locked_within(
    limit: Duration,
    session: &mut PgConnection,
    lock: &'static str,
) -> Result<bool, StoreError> {
    let mut waited = Duration::ZERO;
    loop {
        if sqlx::query_scalar::<_, bool>(lock).fetch_one(&mut *session).await.doing("taking a lock")? {
            return Ok(true);
        }
        if waited >= limit {
            return Ok(false);
        }
        tokio::time::sleep(LOCK_AGAIN).await;
        waited += LOCK_AGAIN;
    }
}

/// Services that start together update the database one after the other.
async fn one_after_the_other(session: &mut PgConnection) -> Result<(), StoreError> {
    let lock = "SELECT pg_try_advisory_lock(1953656944, hashtext(current_schema()))";
    if locked_within(MIGRATED_WITHIN, session, lock).await? {
        return Ok(());
    }
    let late = Error::Io(std::io::Error::from(std::io::ErrorKind::TimedOut));
    Err(late).doing("waiting for another service that updates the database")
}

/// Notes where the files of a database are that no service has used yet, and answers whether it is one. Later they stay
/// there.
async fn choose_files(session: &mut PgConnection, files: &FilesIn) -> Result<bool, StoreError> {
    let (doing, asked) = ("asking where the files of the database are", files.to_string());
    let chosen = sqlx::query("UPDATE service SET files = $1 WHERE NOT EXISTS (SELECT 1 FROM machines)")
        .bind(&asked)
        .execute(&mut *session)
        .await
        .doing(doing)?;
    let found: String =
        sqlx::query_scalar("SELECT files FROM service").fetch_one(session).await.doing(doing)?;
    if found == asked {
        Ok(chosen.rows_affected() > 0)
    } else {
        Err(StoreError::FilesElsewhere { found, asked })
    }
}

/// Notes in the data directory to which database its files belong, or refuses a directory of another one: the sweep at
/// the start would remove all its files. Answers the name of the database.
async fn note_directory(session: &mut PgConnection, data_dir: &Path) -> Result<String, StoreError> {
    let doing = "asking for the name of the database";
    let id: String =
        sqlx::query_scalar("SELECT database_id FROM service").fetch_one(&mut *session).await.doing(doing)?;
    let place = data_dir.join(DATABASE_ID);
    let unusable = |source| StoreError::Note { path: place.clone(), source };
    match std::fs::read_to_string(&place) {
        Ok(noted) if noted.trim() == id => return Ok(id),
        Ok(_other) => return Err(StoreError::OtherDatabase { directory: data_dir.to_owned(), note: place }),
        Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => {}
        Err(fault) => return Err(unusable(fault)),
    }
    no_files_beside(data_dir, &place)?;
    std::fs::write(&place, format!("{id}\n")).map_err(unusable)?;
    Ok(id)
}

/// Makes this the service that has the database: from now on no service before it writes that had it alone.
async fn take(session: &mut PgConnection, instance: &str, host: &str) -> Result<(), StoreError> {
    let doing = "taking the database";
    let begin = "BEGIN; SELECT pg_advisory_xact_lock(1953656942, hashtext(current_schema()))";
    let mut transaction = session.begin_with(begin).await.doing(doing)?;
    // The time of the database: the clocks of two computers may differ.
    sqlx::query(
        "UPDATE service SET instance = $1, host = $2, process = $3, version = $4,
             since = to_char(clock_timestamp() AT TIME ZONE 'UTC', 'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"')",
    )
    .bind(instance)
    .bind(host)
    .bind(i64::from(std::process::id()))
    .bind(env!("CARGO_PKG_VERSION"))
    .execute(&mut *transaction)
    .await
    .doing(doing)?;
    transaction.commit().await.doing(doing)
}
