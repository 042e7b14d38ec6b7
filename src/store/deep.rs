//! Reads a database row by row: whether its schema is the one that the migrations make, whether every digest matches
//! its data, whether the audit log is complete, and whether an entry of it created every API key. `SQLite`'s own
//! checks find none of this.

use std::collections::BTreeMap;

use futures::TryStreamExt;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{AssertSqlSafe, Column, Connection, Row, TypeInfo, ValueRef};
use tokio::sync::OnceCell;

use super::audit_chain::examine_chain;
use super::calibration_errors::contradictions;
use super::error::Doing;
use super::migrations::of_sqlite;
use super::sql::{On, Tx};
use super::{AuditChain, AuditHead, DatabaseFile, Pace, StoreError, own_schema, sha256_hex};

/// Largest number of findings that are reported one by one.
pub(super) const MAX_FINDINGS: usize = 100;
/// Rows read at a time: no lock is held between two parts.
const AT_ONCE: usize = 200;

/// A column whose digest is in another column.
pub(super) struct Digested {
    pub(super) table: &'static str,
    pub(super) text: &'static str,
    pub(super) sha256: &'static str,
    /// What names a row, on a server.
    #[cfg_attr(not(feature = "scale-out"), expect(dead_code, reason = "a file gives the key of each row"))]
    pub(super) key: &'static str,
}

const OF_MACHINE: &str = "machine_id || '/' || revision";
const OF_TOOL: &str = "machine_id || '/' || tool_id || '/' || revision";

pub(super) const DIGESTED: [Digested; 5] = [
    Digested { table: "machine_revisions", text: "profile", sha256: "sha256", key: OF_MACHINE },
    Digested { table: "tool_revisions", text: "document", sha256: "sha256", key: OF_TOOL },
    Digested { table: "calibrations", text: "run", sha256: "run_sha256", key: "id" },
    Digested { table: "calibrations", text: "document", sha256: "document_sha256", key: "id" },
    Digested { table: "jobs", text: "report", sha256: "report_sha256", key: "id" },
];

/// Rows that contradict each other; its query describes each in words.
pub(super) struct Contradiction {
    /// All tables that the query names.
    tables: &'static [&'static str],
    pub(super) query: &'static str,
}

pub(super) const CONTRADICTIONS: [Contradiction; 5] = [
    Contradiction {
        tables: &["api_keys", "audit"],
        query: "SELECT 'the API key ' || id || ' was made by no entry of the audit log: revoke it' FROM api_keys k
                WHERE NOT EXISTS (SELECT 1 FROM audit a WHERE a.action = 'key-created' AND a.resource = '/v1/keys/' || k.id)",
    },
    Contradiction {
        tables: &["api_keys", "audit"],
        query: "SELECT 'the API key ' || id || ' was revoked and opens again: revoke it' FROM api_keys k
                WHERE revoked_at IS NULL AND EXISTS
                    (SELECT 1 FROM audit a WHERE a.action = 'key-revoked' AND a.resource = '/v1/keys/' || k.id)",
    },
    Contradiction {
        tables: &["machines", "machine_revisions"],
        query: "SELECT 'machine ' || machine_id || ' is at revision ' || last_revision || ', and its last one is ' || last
                FROM (SELECT m.machine_id, m.last_revision, coalesce(
                    (SELECT max(revision) FROM machine_revisions r WHERE r.machine_id = m.machine_id), 0) AS last FROM machines m) AS heads
                WHERE last <> last_revision",
    },
    Contradiction {
        tables: &["tools", "tool_revisions"],
        query: "SELECT 'tool ' || tool_id || ' of machine ' || machine_id || ' is at revision ' || last_revision
                    || ', and its last one is ' || last
                FROM (SELECT t.machine_id, t.tool_id, t.last_revision, coalesce((SELECT max(revision) FROM tool_revisions r
                    WHERE r.machine_id = t.machine_id AND r.tool_id = t.tool_id), 0) AS last FROM tools t) AS heads
                WHERE last <> last_revision",
    },
    Contradiction {
        tables: &["jobs"],
        query: "SELECT 'job ' || id || ' has a report without a digest' FROM jobs
                WHERE report IS NOT NULL AND report_sha256 IS NULL",
    },
];

/// The findings of reading everything.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Deep {
    /// The audit log; `None` in schemas without a chain.
    pub audit: Option<AuditChain>,
    /// Other findings, in words.
    pub findings: Vec<String>,
    /// Rows read.
    pub rows: u64,
}

impl Deep {
    /// All faults, in words.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let chain = self.audit.iter().flat_map(|chain| &chain.faults).map(ToString::to_string);
        self.findings.iter().cloned().chain(chain).collect()
    }

    pub(super) fn find(&mut self, finding: String) {
        if self.findings.len() < MAX_FINDINGS {
            self.findings.push(finding);
        }
    }
}

/// One value of a primary key.
#[derive(Debug, Clone)]
enum Key {
    Number(i64),
    Text(String),
}

impl DatabaseFile {
    /// Reads every row and reports faults of the rows, of the schema, and of the audit log, which is compared with a
    /// recorded entry if there is one. It ends when `pace` ends.
    ///
    /// # Errors
    /// The database failed; a single table that cannot be read is a finding.
    pub async fn deep(&mut self, pace: &Pace, known: Option<&AuditHead>) -> Result<Deep, StoreError> {
        let mut deep = Deep::default();
        let schema = self.schema().await?.unwrap_or_default();
        for difference in self.schema_differences(schema).await? {
            deep.find(difference);
        }
        let connection = self.connection();
        let tables = tables(connection).await?;
        for (table, columns) in &tables {
            if pace.is_over() {
                return Ok(deep);
            }
            if let Err(fault) = read_table(connection, table, columns, pace, &mut deep).await {
                deep.find(format!("table {table} cannot be read: {fault}"));
            }
        }
        for Contradiction { tables: named, query } in CONTRADICTIONS {
            if named.iter().all(|table| tables.contains_key(*table)) {
                match sqlx::query_scalar::<_, String>(query).fetch_all(&mut *connection).await {
                    Ok(found) => found.into_iter().for_each(|found| deep.find(found)),
                    Err(fault) => deep.find(format!("{} cannot be read: {fault}", named.join(", "))),
                }
            }
        }
        if tables.contains_key("calibration_errors") {
            match contradictions(&mut Tx(On::Sqlite(&mut *connection)), pace).await {
                Ok(found) => found.into_iter().for_each(|found| deep.find(found)),
                Err(fault) => deep.find(format!("the errors of calibrations cannot be compared: {fault}")),
            }
        }
        if tables.get("audit").is_some_and(|columns| columns.names.iter().any(|name| name == "sha256")) {
            match examine_chain(&mut Tx(On::Sqlite(connection)), known).await {
                Ok(chain) => deep.audit = Some(chain),
                Err(fault) => deep.find(format!("the audit log cannot be read: {fault}")),
            }
        } else if known.is_some() {
            deep.find(format!("the audit log of schema {schema} has no digests to compare with"));
        }
        Ok(deep)
    }

    /// Differences between the schema and the one that the migrations up to `version` make; a newer schema cannot be
    /// compared.
    async fn schema_differences(&mut self, version: i64) -> Result<Vec<String>, StoreError> {
        if version > own_schema() {
            return Ok(Vec::new());
        }
        let expected = if version == own_schema() {
            OWN.get_or_try_init(|| schema_made(version)).await?.clone()
        } else {
            schema_made(version).await?
        };
        let found = schema_of(self.connection()).await?;
        let mut differences = Vec::new();
        for (name, text) in &expected {
            match found.get(name) {
                None => differences.push(format!("the {} {} is missing from the schema", name.0, name.1)),
                Some(other) if other != text => {
                    differences.push(format!(
                        "the {} {} differs from the one that the migrations make",
                        name.0, name.1
                    ));
                }
                Some(_) => {}
            }
        }
        let more = found.keys().filter(|name| !expected.contains_key(name));
        differences.extend(more.map(|(kind, name)| format!("no migration makes the {kind} {name}")));
        Ok(differences)
    }
}

/// Kind and name of everything in a schema, with its text without blanks and without quotes around names, which a
/// renaming adds.
type Schema = BTreeMap<(String, String), String>;

/// The schema of this version, made once.
static OWN: OnceCell<Schema> = OnceCell::const_new();

/// The schema that the migrations up to `version` make.
async fn schema_made(version: i64) -> Result<Schema, StoreError> {
    let doing = "creating a database for comparison";
    let mut fresh = SqliteConnection::connect("sqlite::memory:").await.doing(doing)?;
    for migration in of_sqlite().iter().filter(|migration| migration.version <= version) {
        sqlx::raw_sql(migration.sql.clone()).execute(&mut fresh).await.doing(doing)?;
    }
    let made = schema_of(&mut fresh).await?;
    fresh.close().await.doing(doing)?;
    Ok(made)
}

async fn schema_of(connection: &mut SqliteConnection) -> Result<Schema, StoreError> {
    let rows: Vec<(String, String, String)> = sqlx::query_as(
        "SELECT type, name, coalesce(sql, '') FROM sqlite_schema
         WHERE name NOT LIKE 'sqlite@_%' ESCAPE '@' AND name <> '_sqlx_migrations'",
    )
    .fetch_all(connection)
    .await
    .doing("reading the schema")?;
    let plain = |text: String| text.replace('"', "").split_whitespace().collect::<Vec<_>>().join(" ");
    Ok(rows.into_iter().map(|(kind, name, text)| ((kind, name), plain(text))).collect())
}

/// Columns of a table, and those of its primary key in their order.
#[derive(Debug, Default)]
struct Columns {
    names: Vec<String>,
    key: Vec<String>,
}

async fn tables(connection: &mut SqliteConnection) -> Result<BTreeMap<String, Columns>, StoreError> {
    let columns: Vec<(String, String, i64)> = sqlx::query_as(
        "SELECT t.name, c.name, c.pk FROM sqlite_schema t, pragma_table_info(t.name) c
         WHERE t.type = 'table' AND t.name NOT LIKE 'sqlite@_%' ESCAPE '@' ORDER BY t.name, c.pk",
    )
    .fetch_all(connection)
    .await
    .doing("listing the tables")?;
    let mut tables = BTreeMap::<String, Columns>::new();
    for (table, column, place) in columns {
        let columns = tables.entry(table).or_default();
        if place > 0 {
            columns.key.push(column.clone());
        }
        columns.names.push(column);
    }
    Ok(tables)
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

/// Reads every row of a table, in parts that end before the next begins.
async fn read_table(
    connection: &mut SqliteConnection,
    table: &str,
    columns: &Columns,
    pace: &Pace,
    deep: &mut Deep,
) -> Result<(), sqlx::Error> {
    let has = |name: &str| columns.names.iter().any(|column| column == name);
    let digested: Vec<_> = DIGESTED
        .iter()
        .filter(|digested| digested.table == table && has(digested.text) && has(digested.sha256))
        .collect();
    // Every table of a migration has a primary key of numbers and texts; any other table is read at once.
    let key = columns.key.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    let marks = vec!["?"; columns.key.len()].join(", ");
    let (all, table_name) = (quoted(table), table);
    let first = if key.is_empty() {
        format!("SELECT * FROM {all}")
    } else {
        format!("SELECT * FROM {all} ORDER BY {key} LIMIT {AT_ONCE}")
    };
    let next = format!("SELECT * FROM {all} WHERE ({key}) > ({marks}) ORDER BY {key} LIMIT {AT_ONCE}");
    let mut last: Option<Vec<Key>> = None;
    loop {
        let sql = if last.is_some() { next.clone() } else { first.clone() };
        let mut query = sqlx::query(AssertSqlSafe(sql));
        for value in last.iter().flatten() {
            query = match value {
                Key::Number(number) => query.bind(*number),
                Key::Text(text) => query.bind(text.clone()),
            };
        }
        let (mut count, mut bytes) = (0_usize, 0_u64);
        let mut rows = query.fetch(&mut *connection);
        while let Some(row) = rows.try_next().await? {
            bytes += length(&row);
            for Digested { text, sha256, .. } in &digested {
                let (text_of, expected) = (row.try_get(*text), row.try_get::<Option<String>, _>(*sha256));
                let text_of: Option<String> = match text_of {
                    Ok(read) => read,
                    Err(fault) => {
                        deep.find(format!(
                            "{table_name} {}: {text} cannot be read: {fault}",
                            named(&row, columns)
                        ));
                        continue;
                    }
                };
                if let (Some(text_of), Some(expected)) = (text_of, expected?) {
                    let found = sha256_hex(text_of.as_bytes());
                    if found != expected {
                        let row = named(&row, columns);
                        deep.find(format!(
                            "{table_name} {row}: {text} has the SHA-256 {found}, expected {expected}"
                        ));
                    }
                }
            }
            count += 1;
            last = Some(key_of(&row, columns)?);
        }
        drop(rows);
        deep.rows += count as u64;
        pace.spend(bytes).await;
        if count < AT_ONCE || key.is_empty() || pace.is_over() {
            return Ok(());
        }
    }
}

/// Bytes of the texts of a row.
fn length(row: &SqliteRow) -> u64 {
    let of = |column: usize| row.try_get::<Option<&str>, _>(column).ok().flatten().map_or(8, str::len);
    row.columns().iter().map(|column| of(column.ordinal()) as u64).sum()
}

fn key_of(row: &SqliteRow, columns: &Columns) -> Result<Vec<Key>, sqlx::Error> {
    let of = |name: &String| {
        let kind = row.try_get_raw(name.as_str())?.type_info().name().to_owned();
        Ok(match kind.as_str() {
            "TEXT" => Key::Text(row.try_get(name.as_str())?),
            _ => Key::Number(row.try_get(name.as_str())?),
        })
    };
    columns.key.iter().map(of).collect()
}

/// The row by its key.
fn named(row: &SqliteRow, columns: &Columns) -> String {
    let id = row.try_get::<String, _>("id").ok();
    id.unwrap_or_else(|| {
        let key = key_of(row, columns).unwrap_or_default();
        let texts = key.into_iter().map(|key| match key {
            Key::Number(number) => number.to_string(),
            Key::Text(text) => text,
        });
        texts.collect::<Vec<_>>().join("/")
    })
}
