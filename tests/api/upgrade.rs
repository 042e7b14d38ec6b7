//! Databases of earlier schemas open in this one with everything they hold. Each is kept as SQL text, as the version
//! that made it left it (`tests/fixtures/schemas`).

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool, SqlitePoolOptions};
use tempfile::TempDir;
use trunnion::store::{own_schema, sha256_hex};

use crate::database::has_no_file;
use crate::deep::rewritten;
use crate::support::spawn_in;

const JOB: &str = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60";
const RUN: &str = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f61";
/// The key that the databases with keys hold; the others leave the service open.
const KEY: &str = "trn_0123456789ab_5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e5e";
/// Schemas from which on a database holds more than machines and jobs.
const CALIBRATIONS: i64 = 20_261_121_020_000;
const WEAR_HISTORY: i64 = 20_261_121_030_000;
const KEYS: i64 = 20_261_121_060_000;
const WEBHOOKS: i64 = 20_261_122_000_000;
const TOOLS: i64 = 20_261_123_120_000;

/// Every schema of which a database is kept, oldest first.
fn schemas() -> Vec<(i64, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/schemas");
    let mut found: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "sql"))
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().parse().unwrap(), path))
        .collect();
    found.sort();
    found
}

/// Rows of a text come in the order of the tables' names, so that references lead nowhere for a while.
async fn open(data: &Path) -> SqlitePool {
    let options = SqliteConnectOptions::new()
        .filename(data.join("trunnion.sqlite"))
        .create_if_missing(true)
        .foreign_keys(false);
    SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap()
}

/// The digests of the texts are those of nothing, and what is stored is answered only under its own.
async fn with_true_digests(data: &Path) {
    let (pool, mut updates) = (open(data).await, String::new());
    let digested = [
        ("machine_revisions", "profile", "sha256"),
        ("tool_revisions", "document", "sha256"),
        ("calibrations", "document", "document_sha256"),
        ("calibrations", "run", "run_sha256"),
        ("jobs", "report", "report_sha256"),
    ];
    for (table, text, sha256) in digested {
        let there = "SELECT count(*) FROM sqlite_schema WHERE name = ?";
        let there: i64 = sqlx::query_scalar(there).bind(table).fetch_one(&pool).await.unwrap();
        if there == 0 {
            continue;
        }
        let rows = sqlx::AssertSqlSafe(format!("SELECT {text} FROM {table}"));
        let rows: Vec<String> = sqlx::query_scalar(rows).fetch_all(&pool).await.unwrap();
        for row in rows {
            let digest = sha256_hex(row.as_bytes());
            writeln!(updates, "UPDATE {table} SET {sha256} = '{digest}' WHERE {text} = '{row}';").unwrap();
        }
    }
    pool.close().await;
    rewritten(data, &updates).await;
}

#[tokio::test]
async fn a_database_of_every_schema_kept_opens_with_what_it_holds() {
    if has_no_file("a_database_of_every_schema_kept_opens_with_what_it_holds") {
        return;
    }
    let schemas = schemas();
    assert!(schemas.len() >= 10 && schemas[0].0 == 20_260_101_000_000, "{schemas:?}");
    for (schema, path) in schemas {
        let directory = TempDir::new().unwrap();
        let data = directory.path();
        let pool = open(data).await;
        let text = std::fs::read_to_string(&path).unwrap();
        sqlx::raw_sql(sqlx::AssertSqlSafe(text)).execute(&pool).await.unwrap();
        pool.close().await;
        with_true_digests(data).await;

        let app = spawn_in(data, |_| {}).await;
        assert_eq!(app.get("/v1/jobs").await.status(), if schema >= KEYS { 401 } else { 200 }, "{schema}");
        let get = async |path: &str| -> Value {
            let request = app.client.get(app.url(path));
            let request = if schema >= KEYS { request.bearer_auth(KEY) } else { request };
            request.send().await.unwrap().json().await.unwrap()
        };
        let machine = get("/v1/machines/old").await;
        assert_eq!(
            (&machine["revision"], &machine["name"]),
            (&json!(1), &json!("Old")),
            "{schema}: {machine}"
        );
        let job = get(&format!("/v1/jobs/{JOB}")).await;
        assert_eq!(
            (&job["external_id"], &job["state"]),
            (&json!("WO-1"), &json!("succeeded")),
            "{schema}: {job}"
        );
        let report = get(&format!("/v1/jobs/{JOB}/report")).await;
        assert_eq!(report["kept"], true, "{schema}");
        if schema >= WEAR_HISTORY {
            let entries = get("/v1/machines/old/tools/T12/wear-entries").await;
            assert_eq!(entries["items"][0]["radius_wear_um"], 24.5, "{schema}: {entries}");
        }
        let tools = get("/v1/machines/old/tools").await;
        let numbers: Vec<_> = tools["items"].as_array().unwrap().iter().map(|tool| &tool["number"]).collect();
        assert_eq!(numbers, [&json!(12)][..usize::from(schema >= TOOLS)], "{schema}: {tools}");
        if schema >= WEBHOOKS {
            let deliveries = get(&format!("/v1/jobs/{JOB}/deliveries")).await;
            assert_eq!(deliveries["delivery"]["state"], "delivered", "{schema}: {deliveries}");
            assert_eq!(deliveries["items"][0]["status"], 204, "{schema}: {deliveries}");
        }
        app.stop().await;

        let pool = open(data).await;
        let keys: Vec<(String, String)> =
            sqlx::query_as("SELECT idempotency_key, job_id FROM idempotency_keys")
                .fetch_all(&pool)
                .await
                .unwrap();
        assert_eq!(keys, [("key".to_owned(), JOB.to_owned())], "{schema}");
        let runs: Vec<(String, String)> =
            sqlx::query_as("SELECT id, document FROM calibrations").fetch_all(&pool).await.unwrap();
        let kept = [(RUN.to_owned(), "{\"id\": \"kept\"}".to_owned())];
        assert_eq!(runs, kept[..usize::from(schema >= CALIBRATIONS)], "{schema}");
        let broken: Vec<(String,)> =
            sqlx::query_as("SELECT \"table\" FROM pragma_foreign_key_check").fetch_all(&pool).await.unwrap();
        assert!(broken.is_empty(), "{schema}: {broken:?}");
        let newest: i64 =
            sqlx::query_scalar("SELECT MAX(version) FROM _sqlx_migrations").fetch_one(&pool).await.unwrap();
        assert_eq!(newest, own_schema(), "{schema}");
        pool.close().await;
    }
}
