//! Databases of earlier schemas open in this one with everything they hold.

use serde_json::Value;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use tempfile::TempDir;

use crate::support::spawn_in;

const JOB: &str = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60";
const AT: &str = "2026-01-01T00:00:00.000Z";

/// A database as the first schema left it: a machine, a job, the key it was asked under.
async fn first_light(data: &std::path::Path) {
    let migrations = TempDir::new().unwrap();
    let first = "20260101000000_first_light.sql";
    let committed = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("migrations").join(first);
    std::fs::copy(committed, migrations.path().join(first)).unwrap();
    let options = SqliteConnectOptions::new().filename(data.join("trunnion.sqlite")).create_if_missing(true);
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap();
    Migrator::new(migrations.path()).await.unwrap().run(&pool).await.unwrap();
    let digest = "ab".repeat(32);
    for statement in [
        "INSERT INTO machines VALUES (1, 'old', 1, 0)".to_owned(),
        format!("INSERT INTO machine_revisions VALUES ('old', 1, '{{}}', '{digest}', '{AT}')"),
        format!(
            "INSERT INTO jobs VALUES (9, '{JOB}', 'old', 1, 'cc-compensation', '{{}}', 'succeeded', 1.0, 'a.nc',
             '{digest}', '{digest}', '{{\"kept\": true}}', '{digest}', NULL, 'WO-1', '0.1.0', '{AT}', NULL, NULL)"
        ),
        format!("INSERT INTO idempotency_keys VALUES ('key', '{digest}', '{JOB}', '{AT}')"),
    ] {
        sqlx::query(sqlx::AssertSqlSafe(statement)).execute(&pool).await.unwrap();
    }
    pool.close().await;
}

#[tokio::test]
async fn a_database_of_the_first_schema_keeps_its_jobs_and_keys() {
    let directory = TempDir::new().unwrap();
    first_light(directory.path()).await;
    let app = spawn_in(directory.path(), |_| {}).await;
    let job: Value = app.get(&format!("/v1/jobs/{JOB}")).await.json().await.unwrap();
    assert_eq!((&job["external_id"], &job["state"]), (&"WO-1".into(), &"succeeded".into()), "{job}");
    let report: Value = app.get(&format!("/v1/jobs/{JOB}/report")).await.json().await.unwrap();
    assert_eq!(report["kept"], true);
    app.stop().await;
    let options = SqliteConnectOptions::new().filename(directory.path().join("trunnion.sqlite"));
    let pool = SqlitePoolOptions::new().connect_with(options).await.unwrap();
    let keys: Vec<(String, String)> = sqlx::query_as("SELECT idempotency_key, job_id FROM idempotency_keys")
        .fetch_all(&pool)
        .await
        .unwrap();
    assert_eq!(keys, [("key".to_owned(), JOB.to_owned())]);
    let broken: Vec<(String,)> =
        sqlx::query_as("SELECT \"table\" FROM pragma_foreign_key_check").fetch_all(&pool).await.unwrap();
    assert!(broken.is_empty(), "{broken:?}");
    pool.close().await;
}
