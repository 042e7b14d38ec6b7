//! What becomes of jobs when the service stops, or its process dies.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool, SqlitePoolOptions};
use tempfile::TempDir;

use crate::queue::{Held, accepted, cc, document, ended, running, spawn_held_in};
use crate::support::spawn_in;

/// Longer than any stop may take.
const FAR_TOO_LONG: Duration = Duration::from_secs(30);

async fn database(data: &Path) -> SqlitePool {
    let options = SqliteConnectOptions::new().filename(data.join("trunnion.sqlite"));
    SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap()
}

/// Changes jobs as a process that dies leaves them.
async fn write(data: &Path, statement: &'static str, place: &str) {
    let pool = database(data).await;
    let id = place.trim_start_matches("/v1/jobs/").to_owned();
    let changed = sqlx::query(statement).bind(id).execute(&pool).await.unwrap();
    assert_eq!(changed.rows_affected(), 1, "{statement}");
    pool.close().await;
}

const RUNNING: &str = "UPDATE jobs SET state = 'running', attempts = 1, lease = id WHERE id = ?";
const RUNNING_AGAIN: &str = "UPDATE jobs SET state = 'running', attempts = 2, lease = id WHERE id = ?";
const CANCELLING: &str =
    "UPDATE jobs SET state = 'running', attempts = 1, lease = id, cancel_requested = 1 WHERE id = ?";

#[tokio::test]
async fn an_orderly_stop_gives_jobs_back_and_they_are_finished_later() {
    let directory = TempDir::new().unwrap();
    let held = Arc::<Held>::default();
    let app = spawn_held_in(directory.path(), &held).await;
    let runs = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let waits = accepted(&app, &cc("example-ac-table"), "g1\n").await;
    running(&app, &runs).await;
    // Whoever follows a job is let go, or the stop would wait for them.
    let follower = app.get(&format!("{waits}/events")).await;
    app.stop().await;
    follower.text().await.unwrap();
    let held = Arc::<Held>::default();
    held.release();
    let app = spawn_held_in(directory.path(), &held).await;
    for (place, bytes) in [(&runs, "HOLD\n"), (&waits, "G1\n")] {
        let job = ended(&app, place).await;
        // The attempt that the stop ended does not count.
        assert_eq!((&job["state"], &job["attempts"]), (&"succeeded".into(), &1.into()), "{job}");
        assert_eq!(app.get(&format!("{place}/program")).await.text().await.unwrap(), bytes);
    }
    assert_eq!(held.order(), ["HOLD", "g1"]);
}

#[tokio::test]
async fn work_that_does_not_stop_is_given_back_over_its_head() {
    let directory = TempDir::new().unwrap();
    let held = Arc::<Held>::default();
    let app = spawn_held_in(directory.path(), &held).await;
    let place = accepted(&app, &cc("example-ac-table"), "RUNAWAY\n").await;
    running(&app, &place).await;
    tokio::time::timeout(FAR_TOO_LONG, app.stop()).await.unwrap();
    let pool = database(directory.path()).await;
    let left: Vec<(String, i64, Option<String>)> =
        sqlx::query_as("SELECT state, attempts, lease FROM jobs").fetch_all(&pool).await.unwrap();
    assert_eq!(left, [("queued".to_owned(), 0, None)]);
    pool.close().await;
    // The test's own runtime waits for threads.
    held.release();
}

#[tokio::test]
async fn what_a_dead_process_was_computing_is_computed_again_once_and_then_parked() {
    let directory = TempDir::new().unwrap();
    let held = Arc::<Held>::default();
    let app = spawn_held_in(directory.path(), &held).await;
    let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &first).await;
    let mut places = Vec::new();
    for program in ["never run\n", "died once\n", "died twice\n", "cancelled\n"] {
        places.push(accepted(&app, &cc("example-ac-table"), program).await);
    }
    app.stop().await;
    write(directory.path(), RUNNING, &places[1]).await;
    write(directory.path(), RUNNING_AGAIN, &places[2]).await;
    write(directory.path(), CANCELLING, &places[3]).await;
    let held = Arc::<Held>::default();
    held.release();
    let app = spawn_held_in(directory.path(), &held).await;
    let parked = document(&app, &places[2]).await;
    assert_eq!(parked["state"], "failed", "{parked}");
    assert_eq!(parked["problem"]["type"], "/problems/process-died");
    assert_eq!(app.get(parked["problem"]["type"].as_str().unwrap()).await.status(), 200);
    assert_eq!(document(&app, &places[3]).await["state"], "cancelled");
    let again = ended(&app, &places[1]).await;
    assert_eq!((&again["state"], &again["attempts"]), (&"succeeded".into(), &2.into()), "{again}");
    for place in [&first, &places[0]] {
        assert_eq!(ended(&app, place).await["state"], "succeeded");
    }
    // What may have killed the process comes first, while nothing else runs beside it.
    assert_eq!(held.order().first().map(String::as_str), Some("died once"));
    assert_eq!(held.order().len(), 3);
}

/// Linux answers every read of this at its beginning with EIO.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn a_job_whose_file_cannot_be_read_on_a_sound_disk_ends_and_lets_the_others_go_on() {
    let directory = TempDir::new().unwrap();
    let held = Arc::<Held>::default();
    let app = spawn_held_in(directory.path(), &held).await;
    let runs = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let [bad, good] = [
        accepted(&app, &cc("example-ac-table"), "g1 x1\n").await,
        accepted(&app, &cc("example-ac-table"), "g1 x2\n").await,
    ];
    running(&app, &runs).await;
    let sha256 = document(&app, &bad).await["input_sha256"].as_str().unwrap().to_owned();
    app.stop().await;
    let file = directory.path().join("blobs").join(&sha256[..2]).join(&sha256);
    std::fs::remove_file(&file).unwrap();
    std::os::unix::fs::symlink("/proc/self/mem", &file).unwrap();
    let held = Arc::<Held>::default();
    held.release();
    let app = spawn_held_in(directory.path(), &held).await;
    let job = ended(&app, &bad).await;
    assert_eq!(job["state"], "failed", "{job}");
    assert_eq!(job["problem"]["type"], "/problems/stored-file-damaged", "{job}");
    assert_eq!(ended(&app, &good).await["state"], "succeeded");
}

#[tokio::test]
async fn old_jobs_go_with_the_files_that_no_other_job_names() {
    let directory = TempDir::new().unwrap();
    let app = spawn_in(directory.path(), |_| {}).await;
    let old = accepted(&app, &cc("example-ac-table"), "shared\n").await;
    ended(&app, &old).await;
    let keyed = app.client.post(app.url("/v1/jobs")).header("idempotency-key", "kept while remembered");
    let keyed = keyed.multipart(crate::queue::form(&cc("example-ac-table"), "keyed\n")).send().await.unwrap();
    let keyed = keyed.headers()["location"].to_str().unwrap().to_owned();
    ended(&app, &keyed).await;
    let waiting = accepted(&app, &cc("example-ac-table"), "shared\n").await;
    ended(&app, &waiting).await;
    app.stop().await;
    for place in [&old, &keyed] {
        write(
            directory.path(),
            "UPDATE jobs SET finished_at = '2025-01-01T00:00:00.000Z' WHERE id = ?",
            place,
        )
        .await;
    }
    let app = spawn_in(directory.path(), |settings| settings.job_retention_s = 86_400.0).await;
    let mut gone = false;
    for _ in 0..10_000 {
        gone = app.get(&old).await.status() == 404;
        if gone {
            break;
        }
    }
    assert!(gone);
    let log: Value = app.get("/v1/audit?action=job-removed").await.json().await.unwrap();
    assert_eq!(log["items"].as_array().unwrap().len(), 1, "{log}");
    let entry = &log["items"][0];
    assert_eq!((&entry["origin"], &entry["machine_id"]), (&"service".into(), &"example-ac-table".into()));
    assert_eq!((&entry["resource"], &entry["request_id"]), (&old.as_str().into(), &Value::Null));
    for place in [&keyed, &waiting] {
        let program = app.get(&format!("{place}/program")).await;
        assert_eq!(program.status(), 200, "{place}");
    }
    let jobs: Value = app.get("/v1/jobs").await.json().await.unwrap();
    assert_eq!(jobs["items"].as_array().unwrap().len(), 2);
    // Two programs, each as it came and as it left.
    assert_eq!(app.files(), (4, 0));
}
