//! The tables of a data directory on their way to a server: read from the file row by row, written in parts, read back
//! and compared. Every value has to come out with the same bits.

use std::fmt::Write;

use futures::TryStreamExt;
use sha2::{Digest, Sha256};
use sqlx::postgres::PgConnection;
use sqlx::sqlite::SqliteConnection;
use sqlx::{AssertSqlSafe, Error, Row};

use super::blobs::{Sha256Hex, hex};

/// Every table of the schema, in an order in which the rows that are referred to come first. Revisions and calibrations
/// refer to each other: [`REFERS_BACK`].
pub(super) const ORDER: [&str; 17] = [
    "machines",
    "machine_revisions",
    "calibrations",
    "calibration_errors",
    "jobs",
    "job_turns",
    "caller_turns",
    "wear_entries",
    "wear_withdrawals",
    "idempotency_keys",
    "api_keys",
    "audit",
    "deliveries",
    "delivery_attempts",
    "webhook_secrets",
    "tools",
    "tool_revisions",
];

/// Names the reference of revisions to the calibrations that they carry.
pub(super) const REFERS_BACK: &str = "SELECT CAST(conname AS TEXT) FROM pg_constraint
    WHERE contype = 'f' AND conrelid = CAST('machine_revisions' AS regclass)
        AND confrelid = CAST('calibrations' AS regclass)";

/// Rows, and bytes of their texts, that are sent at once.
const ROWS_AT_ONCE: usize = 500;
const BYTES_AT_ONCE: usize = 4 << 20;
/// Texts that the server cannot store and that are named one by one.
const MAX_TOLD: usize = 20;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Text,
    Whole,
    Fraction,
}

#[derive(Debug, Clone, PartialEq)]
enum Value {
    Text(Option<String>),
    Whole(Option<i64>),
    Fraction(Option<f64>),
}

#[derive(Debug, Clone)]
struct Column {
    name: String,
    kind: Kind,
    /// Its place in the primary key, from 1 on.
    in_key: i64,
}

/// A table and its columns.
#[derive(Debug, Clone)]
pub(super) struct Table {
    pub(super) name: &'static str,
    columns: Vec<Column>,
}

/// The number of rows of a table, and the digest of all their values in the order of the key.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Content {
    pub(super) rows: u64,
    pub(super) sha256: Sha256Hex,
}

/// The values of a row of either database.
macro_rules! values {
    ($row:expr, $columns:expr) => {
        $columns
            .iter()
            .enumerate()
            .map(|(place, column)| {
                Ok(match column.kind {
                    Kind::Text => Value::Text($row.try_get(place)?),
                    Kind::Whole => Value::Whole($row.try_get(place)?),
                    Kind::Fraction => Value::Fraction($row.try_get(place)?),
                })
            })
            .collect::<Result<Vec<Value>, Error>>()
    };
}

impl Table {
    /// The table as the file has it.
    ///
    /// # Errors
    /// The file failed.
    pub(super) async fn of(file: &mut SqliteConnection, name: &'static str) -> Result<Self, Error> {
        let columns: Vec<(String, String, i64)> =
            sqlx::query_as("SELECT name, type, pk FROM pragma_table_info(?) ORDER BY cid")
                .bind(name)
                .fetch_all(file)
                .await?;
        let column = |(name, kind, in_key): (String, String, i64)| Column {
            name,
            kind: match kind.as_str() {
                "INTEGER" => Kind::Whole,
                "REAL" => Kind::Fraction,
                _ => Kind::Text,
            },
            in_key,
        };
        Ok(Self { name, columns: columns.into_iter().map(column).collect() })
    }

    fn names(&self) -> String {
        self.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// Every row in the order of the key, on either database: both compare texts byte by byte.
    fn select(&self) -> String {
        let mut key: Vec<&Column> = self.columns.iter().filter(|column| column.in_key > 0).collect();
        key.sort_by_key(|column| column.in_key);
        let key = key.iter().map(|column| column.name.as_str()).collect::<Vec<_>>().join(", ");
        format!("SELECT {} FROM {} ORDER BY {key}", self.names(), self.name)
    }

    /// The row by its key, and by its id if it has one.
    fn named(&self, row: &[Value]) -> String {
        let mut text = self.name.to_owned();
        for (column, value) in self.columns.iter().zip(row) {
            if column.in_key > 0 || column.name == "id" {
                let _always = match value {
                    Value::Text(Some(value)) => write!(text, " {} {value:?}", column.name),
                    Value::Whole(Some(value)) => write!(text, " {} {value}", column.name),
                    _ => Ok(()),
                };
            }
        }
        text
    }

    /// Reads the table in the file, and names the texts that the server cannot store in `nul`.
    ///
    /// # Errors
    /// The file failed.
    pub(super) async fn in_the_file(
        &self,
        file: &mut SqliteConnection,
        nul: &mut Vec<String>,
    ) -> Result<Content, Error> {
        let mut rows = sqlx::query(AssertSqlSafe(self.select())).fetch(file);
        let mut digest = ContentDigest::default();
        while let Some(row) = rows.try_next().await? {
            let row = values!(row, self.columns)?;
            digest.take(&row);
            for (column, value) in self.columns.iter().zip(&row) {
                if matches!(value, Value::Text(Some(text)) if text.contains('\0')) && nul.len() < MAX_TOLD {
                    nul.push(format!("{}: {}", self.named(&row), column.name));
                }
            }
        }
        Ok(digest.end())
    }

    /// Reads the table on the server.
    ///
    /// # Errors
    /// The server failed, or its table has other columns.
    pub(super) async fn on_the_server(&self, server: &mut PgConnection) -> Result<Content, Error> {
        let mut rows = sqlx::query(AssertSqlSafe(self.select())).fetch(server);
        let mut digest = ContentDigest::default();
        while let Some(row) = rows.try_next().await? {
            digest.take(&values!(row, self.columns)?);
        }
        Ok(digest.end())
    }

    /// Whether the table on the server has a row.
    ///
    /// # Errors
    /// The server failed.
    pub(super) async fn is_empty(&self, server: &mut PgConnection) -> Result<bool, Error> {
        let text = format!("SELECT NOT EXISTS (SELECT 1 FROM {})", self.name);
        sqlx::query_scalar(AssertSqlSafe(text)).fetch_one(server).await
    }

    /// Copies every row.
    ///
    /// # Errors
    /// The file or the server failed, or the server refuses a row.
    pub(super) async fn copy(
        &self,
        file: &mut SqliteConnection,
        server: &mut PgConnection,
    ) -> Result<(), Error> {
        let mut rows = sqlx::query(AssertSqlSafe(self.select())).fetch(file);
        let (mut part, mut bytes) = (Vec::new(), 0);
        while let Some(row) = rows.try_next().await? {
            let row = values!(row, self.columns)?;
            bytes += row.iter().map(length).sum::<usize>();
            part.push(row);
            if part.len() >= ROWS_AT_ONCE || bytes >= BYTES_AT_ONCE {
                self.insert(server, std::mem::take(&mut part)).await?;
                bytes = 0;
            }
        }
        self.insert(server, part).await
    }

    /// Inserts rows, a column at a time.
    async fn insert(&self, server: &mut PgConnection, rows: Vec<Vec<Value>>) -> Result<(), Error> {
        if rows.is_empty() {
            return Ok(());
        }
        let arrays: Vec<String> = (1..)
            .zip(&self.columns)
            .map(|(place, column)| {
                let kind = match column.kind {
                    Kind::Text => "TEXT",
                    Kind::Whole => "BIGINT",
                    Kind::Fraction => "DOUBLE PRECISION",
                };
                format!("CAST(${place} AS {kind}[])")
            })
            .collect();
        let (name, names, arrays) = (self.name, self.names(), arrays.join(", "));
        let text = format!("INSERT INTO {name} ({names}) SELECT * FROM unnest({arrays})");
        let mut query = sqlx::query(AssertSqlSafe(text));
        let mut rows: Vec<_> = rows.into_iter().map(Vec::into_iter).collect();
        for column in &self.columns {
            let values = rows.iter_mut().filter_map(Iterator::next);
            query = match column.kind {
                Kind::Text => query.bind(
                    values
                        .filter_map(|value| if let Value::Text(text) = value { Some(text) } else { None })
                        .collect::<Vec<Option<String>>>(),
                ),
                Kind::Whole => query.bind(
                    values
                        .filter_map(|value| if let Value::Whole(whole) = value { Some(whole) } else { None })
                        .collect::<Vec<Option<i64>>>(),
                ),
                Kind::Fraction => query.bind(
                    values
                        .filter_map(|value| if let Value::Fraction(part) = value { Some(part) } else { None })
                        .collect::<Vec<Option<f64>>>(),
                ),
            };
        }
        query.execute(server).await.map(drop)
    }
}

fn length(value: &Value) -> usize {
    match value {
        Value::Text(text) => text.as_ref().map_or(1, String::len),
        Value::Whole(_) | Value::Fraction(_) => 8,
    }
}

/// The digest of rows under way: each value with its kind and length.
#[derive(Default)]
struct ContentDigest {
    rows: u64,
    hasher: Sha256,
}

impl ContentDigest {
    fn take(&mut self, row: &[Value]) {
        self.rows += 1;
        for value in row {
            match value {
                Value::Text(None) | Value::Whole(None) | Value::Fraction(None) => self.hasher.update(b"-"),
                Value::Text(Some(text)) => {
                    self.hasher.update(b"t");
                    self.hasher.update((text.len() as u64).to_le_bytes());
                    self.hasher.update(text.as_bytes());
                }
                Value::Whole(Some(whole)) => {
                    self.hasher.update(b"w");
                    self.hasher.update(whole.to_le_bytes());
                }
                Value::Fraction(Some(part)) => {
                    self.hasher.update(b"f");
                    self.hasher.update(part.to_bits().to_le_bytes());
                }
            }
        }
    }

    fn end(self) -> Content {
        Content { rows: self.rows, sha256: hex(&self.hasher.finalize()) }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use sqlx::Connection;

    use super::*;

    async fn made() -> SqliteConnection {
        let mut file = SqliteConnection::connect("sqlite::memory:").await.unwrap();
        for migration in crate::store::migrations::of_sqlite().iter() {
            sqlx::raw_sql(migration.sql.clone()).execute(&mut file).await.unwrap();
        }
        file
    }

    #[tokio::test]
    async fn every_table_of_the_schema_is_moved_and_each_has_a_key() {
        let mut file = made().await;
        let tables: Vec<String> = sqlx::query_scalar(
            "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite@_%' ESCAPE '@'",
        )
        .fetch_all(&mut file)
        .await
        .unwrap();
        let tables: BTreeSet<&str> = tables.iter().map(String::as_str).collect();
        assert_eq!(tables, BTreeSet::from(ORDER));
        for name in ORDER {
            let table = Table::of(&mut file, name).await.unwrap();
            assert!(table.columns.iter().any(|column| column.in_key > 0), "{name}");
        }
    }

    #[tokio::test]
    async fn a_text_with_nul_is_named_and_one_bit_changes_the_digest() {
        let mut file = made().await;
        let table = Table::of(&mut file, "job_turns").await.unwrap();
        let mut nul = Vec::new();
        let mut seen = BTreeSet::new();
        for change in [
            "SELECT 1",
            "INSERT INTO job_turns VALUES ('a', 1)",
            "UPDATE job_turns SET turn = 2",
            "UPDATE job_turns SET machine_id = 'b'",
            "INSERT INTO job_turns VALUES ('c', 3)",
        ] {
            sqlx::query(change).execute(&mut file).await.unwrap();
            let content = table.in_the_file(&mut file, &mut nul).await.unwrap();
            assert!(seen.insert(content.sha256), "{change}");
        }
        assert!(nul.is_empty());
        sqlx::query("INSERT INTO job_turns VALUES ('d' || char(0), 4)").execute(&mut file).await.unwrap();
        table.in_the_file(&mut file, &mut nul).await.unwrap();
        assert_eq!(nul, ["job_turns machine_id \"d\\0\": machine_id"]);
    }
}
