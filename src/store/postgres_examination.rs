//! Examines a database on a server of PostgreSQL, and the files that it names, for the doctor. Services may run
//! meanwhile.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use sqlx::{AssertSqlSafe, Connection, Error, Executor, PgConnection};

use super::error::Doing;
use super::examination::{compared, there};
use super::postgres_form::{own_form, schema, usable_from};
use super::postgres_opening::{DATABASE_ID, Server};
use super::postgres_rows::{AT_ONE_MOMENT, READ_WITHIN, WITHOUT_LIMITS, deep};
use super::postgres_schema::differences;
use super::presence::Presence;
use super::shared_files::SharedFiles;
use super::stored_file::is_folder;
use super::{Deep, Depth, Examination, Files, ServerState, Sha256Hex, StoreError};
use crate::config::FilesIn;

/// The tables of the present schema.
const TABLES: &str =
    "SELECT CAST(c.relname AS TEXT) FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace
    WHERE n.nspname = current_schema() AND c.relkind IN ('r', 'p') ORDER BY c.relname";

/// What is switched off or unfinished, in words.
const SWITCHED_OFF: &str = "
    WITH tables AS (SELECT c.oid, c.relname FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace
                    WHERE n.nspname = current_schema())
    SELECT DISTINCT CASE WHEN t.tgisinternal THEN 'references of the table ' || relname || ' are not enforced'
                    ELSE 'the trigger ' || t.tgname || ' of ' || relname || ' is switched off' END
    FROM pg_trigger t JOIN tables ON tables.oid = t.tgrelid WHERE t.tgenabled <> 'O'
    UNION ALL SELECT 'the index ' || i.indexrelid::regclass::text || ' is not complete: REINDEX it'
    FROM pg_index i JOIN tables ON tables.oid = i.indrelid WHERE NOT i.indisvalid
    UNION ALL SELECT 'the constraint ' || c.conname || ' of ' || relname || ' was never checked'
    FROM pg_constraint c JOIN tables ON tables.oid = c.conrelid WHERE NOT c.convalidated";

/// Every reference: the table, the table that it refers to, and the condition that a row and its own agree.
const REFERENCES: &str = "
    SELECT c.conrelid::regclass::text, c.confrelid::regclass::text, string_agg(format('p.%I = c.%I', f.attname, k.attname), ' AND '),
        string_agg(format('c.%I IS NOT NULL', k.attname), ' AND ')
    FROM pg_constraint c JOIN pg_namespace n ON n.oid = c.connamespace,
        unnest(c.conkey, c.confkey) AS pair (own, other), pg_attribute k, pg_attribute f
    WHERE c.contype = 'f' AND n.nspname = current_schema() AND k.attrelid = c.conrelid AND k.attnum = pair.own
        AND f.attrelid = c.confrelid AND f.attnum = pair.other
    GROUP BY c.oid, c.conrelid, c.confrelid";

/// The digests of all files that jobs name.
const NAMED: &str =
    "SELECT input_sha256 FROM jobs UNION SELECT output_sha256 FROM jobs WHERE output_sha256 IS NOT NULL
    UNION SELECT surface_sha256 FROM jobs WHERE surface_sha256 IS NOT NULL
    UNION SELECT changes_sha256 FROM jobs WHERE changes_sha256 IS NOT NULL";

/// What the doctor asks the server about itself.
type Settings = (String, String, String, String, String, bool);
const SETTINGS: &str =
    "SELECT current_setting('server_version'), current_setting('fsync'), current_setting('full_page_writes'),
    current_setting('synchronous_commit'), current_setting('data_checksums'), pg_is_in_recovery()";

impl Server<'_> {
    /// Examines the database and its files to this depth. `None` if no migration has run.
    ///
    /// # Errors
    /// The server cannot be used, or the database failed.
    pub(super) async fn examine(&self, depth: &Depth) -> Result<Option<Examination>, StoreError> {
        let (data_dir, files) = (&self.settings.data_dir, &self.settings.files);
        let options = self.options()?;
        let mut session = self.session(&options).await?;
        let doing = "examining the database";
        let examined = async {
            let Some(schema) = schema(&mut session).await? else { return Ok(None) };
            let rows = rows(&mut session, schema, depth).await.doing(doing)?;
            let named = named(&mut session).await.doing(doing)?;
            let (place, id): (Option<String>, String) =
                sqlx::query_as("SELECT to_jsonb(s) ->> 'files', database_id FROM service s")
                    .fetch_one(&mut session)
                    .await
                    .doing(doing)?;
            let place = place.unwrap_or_default();
            let mut server = settings(&mut session).await.doing(doing)?;
            if let Err(fault) = placed(&place, files) {
                server.1.faults.push(fault.to_string());
            }
            let files = if let Some(place) = shared_place(&mut session, &place, files, schema).await? {
                let place = (&place, self.settings);
                let shared = SharedFiles::connect(options, Presence::here(), place, &id).await?;
                let found = shared_files(&mut session, &shared, &named, depth.files).await;
                shared.close().await;
                found?
            } else {
                if let Err(fault) = noted(data_dir, &id) {
                    server.1.faults.push(fault.to_string());
                }
                compared(data_dir, &named, &there(data_dir), depth.files)
            };
            server.1.notes.extend(rows.notes);
            Ok(Some(Examination {
                engine: ("PostgreSQL", server.0),
                newest_schema: own_form(),
                usable_from: usable_from(&mut session).await.doing(doing)?,
                server: Some(server.1),
                schema: Some(schema),
                structural_faults: rows.switched_off,
                broken_references: rows.broken_references,
                rows: rows.count,
                was_served: rows.was_served,
                files,
                deliveries: Some(rows.deliveries),
                deep: rows.deep,
            }))
        };
        let late = |_| Error::Io(std::io::ErrorKind::TimedOut.into());
        match tokio::time::timeout(READ_WITHIN, examined).await.map_err(late) {
            Ok(examined) => examined,
            Err(late) => Err(late).doing(doing),
        }
    }
}

/// The place of the files, if several services have them together, or if a move of a data directory left some.
async fn shared_place(
    session: &mut PgConnection,
    place: &str,
    asked: &FilesIn,
    schema: i64,
) -> Result<Option<FilesIn>, StoreError> {
    if place.is_empty() && schema == own_form() {
        let text = "SELECT EXISTS (SELECT 1 FROM files)";
        let some: bool = sqlx::query_scalar(text).fetch_one(session).await.doing("examining the database")?;
        let place = if asked.is_shared() { asked.clone() } else { FilesIn::Postgres };
        return Ok(Some(place).filter(|_| some));
    }
    Ok(place.parse::<FilesIn>().ok().filter(FilesIn::is_shared))
}

/// Whether a service with this setting would start.
fn placed(found: &str, asked: &FilesIn) -> Result<(), StoreError> {
    let asked = asked.to_string();
    if found.is_empty() || found == asked {
        return Ok(());
    }
    Err(StoreError::FilesElsewhere { found: found.to_owned(), asked })
}

/// Whether the files of a data directory belong to this database.
fn noted(data_dir: &Path, id: &str) -> Result<(), StoreError> {
    let note = data_dir.join(DATABASE_ID);
    match std::fs::read_to_string(&note) {
        Ok(found) if found.trim() != id => {
            Err(StoreError::OtherDatabase { directory: data_dir.to_owned(), note })
        }
        Err(source) if source.kind() != std::io::ErrorKind::NotFound && is_folder(data_dir) => {
            Err(StoreError::Note { path: note, source })
        }
        _ => Ok(()),
    }
}

/// The version of the server, and what its settings mean for what is stored.
async fn settings(session: &mut PgConnection) -> Result<(String, ServerState), Error> {
    let (version, fsync, pages, commit, checksums, standby): Settings =
        sqlx::query_as(SETTINGS).fetch_one(session).await?;
    let mut state = ServerState::default();
    let off = |value: &str| value == "off";
    if off(&fsync) {
        let fault =
            "fsync = off: the server loses what was acknowledged if its computer fails; set fsync = on";
        state.faults.push(fault.to_owned());
    }
    if standby {
        let fault = "this server is a standby that does not write: name the one that does";
        state.faults.push(fault.to_owned());
    }
    if off(&pages) {
        let note =
            "full_page_writes = off: a page that is half written stays damaged, unless the disk prevents it";
        state.notes.push(note.to_owned());
    }
    if off(&commit) {
        let note = "synchronous_commit = off for others: the service switches it on for itself";
        state.notes.push(note.to_owned());
    }
    if off(&checksums) {
        let note = "the server does not notice damaged pages: pg_checksums --enable, while it is stopped";
        state.notes.push(note.to_owned());
    }
    Ok((version, state))
}

/// The findings about rows.
struct Rows {
    count: u64,
    was_served: bool,
    switched_off: Vec<String>,
    broken_references: u64,
    deliveries: (u64, u64),
    deep: Option<Deep>,
    notes: Vec<String>,
}

async fn rows(session: &mut PgConnection, schema: i64, depth: &Depth) -> Result<Rows, Error> {
    let reads_all = depth.rows || depth.known_head.is_some();
    let mut notes = Vec::new();
    let compared = differences_or_none(session, schema, reads_all).await?;
    if compared.is_none() {
        let note = "the schema was not compared with the migrations: the user may not make a schema in this \
                    database, which GRANT CREATE ON DATABASE lets it";
        notes.push(note.to_owned());
    }
    // Everything is seen as it is at one moment.
    let mut transaction = session.begin_with(AT_ONE_MOMENT).await?;
    transaction.execute(WITHOUT_LIMITS).await?;
    let (mut count, mut was_served) = (0, false);
    for table in sqlx::query_scalar::<_, String>(TABLES).fetch_all(&mut *transaction).await? {
        let text = format!("SELECT count(*) FROM \"{}\"", table.replace('"', "\"\""));
        let rows: i64 = sqlx::query_scalar(AssertSqlSafe(text)).fetch_one(&mut *transaction).await?;
        count += rows.unsigned_abs();
        was_served |= table == "machines" && rows > 0;
    }
    let switched_off = sqlx::query_scalar(SWITCHED_OFF).fetch_all(&mut *transaction).await?;
    let references: Vec<(String, String, String, String)> =
        sqlx::query_as(REFERENCES).fetch_all(&mut *transaction).await?;
    let mut broken_references = 0;
    for (table, other, agree, refers) in references {
        let text = format!(
            "SELECT count(*) FROM {table} c WHERE {refers} AND NOT EXISTS (SELECT 1 FROM {other} p WHERE {agree})"
        );
        let rows: i64 = sqlx::query_scalar(AssertSqlSafe(text)).fetch_one(&mut *transaction).await?;
        broken_references += rows.unsigned_abs();
    }
    let (waiting, given_up): (i64, i64) = sqlx::query_as(
        "SELECT count(*) FILTER (WHERE state = 'waiting'), count(*) FILTER (WHERE state = 'given-up') FROM deliveries",
    )
    .fetch_one(&mut *transaction)
    .await?;
    let deep = if reads_all {
        let mut deep = deep(&mut transaction, depth.known_head.as_ref()).await?;
        for difference in compared.unwrap_or_default() {
            deep.find(difference);
        }
        Some(Deep { rows: count, ..deep })
    } else {
        None
    };
    transaction.rollback().await?;
    let deliveries = (waiting.unsigned_abs(), given_up.unsigned_abs());
    Ok(Rows { count, was_served, switched_off, broken_references, deliveries, deep, notes })
}

/// The differences of the schema, if they are asked for; `None` if the user may not look for them.
async fn differences_or_none(
    session: &mut PgConnection,
    schema: i64,
    asked: bool,
) -> Result<Option<Vec<String>>, Error> {
    if !asked {
        return Ok(Some(Vec::new()));
    }
    match differences(session, schema).await {
        Err(Error::Database(fault))
            if fault.code().is_some_and(|code| code == "42501" || code == "25006") =>
        {
            Ok(None)
        }
        found => found.map(Some),
    }
}

async fn named(session: &mut PgConnection) -> Result<BTreeSet<Sha256Hex>, Error> {
    Ok(sqlx::query_scalar::<_, String>(NAMED).fetch_all(session).await?.into_iter().collect())
}

/// Compares the files that several services have together with what jobs name; with `digests` every byte is read.
async fn shared_files(
    session: &mut PgConnection,
    shared: &SharedFiles,
    named_before: &BTreeSet<Sha256Hex>,
    digests: bool,
) -> Result<Files, StoreError> {
    let doing = "examining files";
    shared.check().await?;
    let rows: Vec<(String, String, i64, i64)> =
        sqlx::query_as("SELECT sha256, object_key, whole, length FROM files ORDER BY sha256")
            .fetch_all(&mut *session)
            .await
            .doing(doing)?;
    let (mut whole, mut incomplete, mut orphans) = (BTreeSet::new(), 0, 0);
    let mut changed = Vec::new();
    // Rows first: an object is there before its row says that it is whole.
    let mut objects = shared.listed().await?.map(|listed| {
        listed.into_iter().map(|object| (object.key, object.length)).collect::<BTreeMap<_, _>>()
    });
    for (sha256, object, is_whole, length) in rows {
        let listed = objects.as_mut().map(|objects| objects.remove(&object));
        if is_whole == 0 {
            incomplete += 1;
            continue;
        }
        if !named_before.contains(&sha256) {
            orphans += 1;
        } else if let Some(found) = listed {
            let Some(found) = found else { continue };
            let is_long = i64::try_from(found).is_ok_and(|found| found == length);
            if !is_long || (digests && !shared.is_sound(&object, &sha256).await?) {
                changed.push((sha256.clone(), PathBuf::from(object)));
            }
        } else if digests && !shared.is_sound(&object, &sha256).await? {
            changed.push((sha256.clone(), PathBuf::from(object)));
        }
        whole.insert(sha256);
    }
    // Jobs may have released files meanwhile.
    let named = named(session).await.doing(doing)?;
    changed.retain(|(sha256, _)| named.contains(sha256));
    Ok(Files {
        named: named_before.len(),
        missing: named_before
            .iter()
            .filter(|sha256| !whole.contains(*sha256) && named.contains(*sha256))
            .cloned()
            .collect(),
        changed: changed.into_iter().map(|(_, object)| object).collect(),
        orphans: orphans + objects.map_or(0, |left| left.len()),
        incomplete,
        shared: true,
    })
}
