//! Stored bytes that are not what was stored: neither sent whole nor computed with, and told.

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use reqwest::Response;
use serde_json::Value;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use tempfile::TempDir;

use crate::database::has_no_file;
use crate::queue::{Held, accepted, cc, document, ended, running, spawn_held};
use crate::support::{App, problem, spawn, spawn_in};

/// Where a stored file stands.
fn stored(app: &App, sha256: &str) -> PathBuf {
    app.data.join("blobs").join(&sha256[..2]).join(sha256)
}

/// What a detail says of an injury, and the injury.
type Injury = (&'static str, fn(&Path));

/// A changed digit, a cut, a file that is gone, a link to the very bytes: each done to a file.
fn injuries() -> [Injury; 4] {
    [
        ("has changed", |path| {
            let mut bytes = std::fs::read(path).unwrap();
            let last = bytes.len() - 2;
            bytes[last] ^= 1;
            std::fs::write(path, bytes).unwrap();
        }),
        ("has changed", |path| {
            let bytes = std::fs::read(path).unwrap();
            std::fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        }),
        ("is missing", |path| std::fs::remove_file(path).unwrap()),
        ("is not a regular file", |path| {
            let elsewhere = path.with_extension("elsewhere");
            std::fs::rename(path, &elsewhere).unwrap();
            symlink(&elsewhere, path).unwrap();
        }),
    ]
}

async fn metric(app: &App, name: &str) -> f64 {
    let text = app.get("/metrics").await.text().await.unwrap();
    let line = text.lines().find(|line| line.starts_with(&format!("{name} ")));
    let line = line.unwrap_or_default();
    line.rsplit(' ').next().unwrap().parse().unwrap()
}

async fn readiness(app: &App) -> (u16, Value) {
    let response = app.get("/readyz").await;
    (response.status().as_u16(), response.json().await.unwrap())
}

#[tokio::test]
async fn a_damaged_program_is_a_problem_with_digests_and_cure_until_it_is_restored() {
    let app = spawn().await;
    let place = accepted(&app, &cc("example-ac-table"), "g1 x1.5\ng1 x2.5\n").await;
    let job = ended(&app, &place).await;
    let sha256 = job["output_sha256"].as_str().unwrap();
    let path = stored(&app, sha256);
    let sound = std::fs::read(&path).unwrap();
    let ask = async |range: Option<&str>| -> Response {
        let request = app.client.get(app.url(&format!("{place}/program")));
        let request = if let Some(range) = range { request.header("range", range) } else { request };
        request.send().await.unwrap()
    };
    for (told, injure) in injuries() {
        let before = metric(&app, "trunnion_damaged_reads_total").await;
        injure(&path);
        for range in [None, Some("bytes=0-3")] {
            let refused = problem(ask(range).await, "stored-file-damaged").await;
            assert_eq!(refused["status"], 500);
            let detail = refused["detail"].as_str().unwrap();
            for part in [sha256, told, "restore it from a backup", "trunnion doctor"] {
                assert!(detail.contains(part), "{part}: {detail}");
            }
        }
        let (status, body) = readiness(&app).await;
        assert_eq!((status, &body["status"]), (200, &"degraded".into()), "{told}: {body}");
        assert!(body["reasons"][0].as_str().unwrap().contains("doctor"), "{body}");
        assert!(metric(&app, "trunnion_damaged_reads_total").await >= before + 2.0);
        assert!(metric(&app, "trunnion_stored_files_damaged").await >= 1.0);
        // Put back, it is sent again and nothing is said any more.
        let _link = std::fs::remove_file(&path);
        std::fs::write(&path, &sound).unwrap();
        let again = ask(None).await;
        assert_eq!((again.status().as_u16(), again.bytes().await.unwrap().to_vec()), (200, sound.clone()));
        assert_eq!(readiness(&app).await.1["status"], "ready", "{told}");
    }
}

#[tokio::test]
async fn a_folder_of_stored_files_that_is_a_link_is_not_followed() {
    let app = spawn().await;
    let place = accepted(&app, &cc("example-ac-table"), "g1 x1.5\n").await;
    let job = ended(&app, &place).await;
    let folder = stored(&app, job["output_sha256"].as_str().unwrap()).parent().unwrap().to_owned();
    let elsewhere = app.data.join("elsewhere");
    std::fs::rename(&folder, &elsewhere).unwrap();
    symlink(&elsewhere, &folder).unwrap();
    problem(app.get(&format!("{place}/program")).await, "stored-file-damaged").await;
}

/// A program of several megabytes.
fn long_program() -> String {
    "g1 x12.125 y1.5\n".repeat(200_000)
}

#[tokio::test]
async fn a_long_damaged_program_never_arrives_whole() {
    let app = spawn().await;
    let place = accepted(&app, &cc("example-ac-table"), &long_program()).await;
    let job = ended(&app, &place).await;
    let path = stored(&app, job["output_sha256"].as_str().unwrap());
    let sound = std::fs::read(&path).unwrap();
    assert!(sound.len() > 2 << 20);
    let ask = async || app.get(&format!("{place}/program")).await;
    assert_eq!(ask().await.bytes().await.unwrap(), sound);
    let changed = |at: usize| {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        bytes
    };
    let mut longer = sound.clone();
    longer.extend_from_slice(b"G1 X9\n");
    for bytes in [changed(7), changed(sound.len() - 2), sound[..sound.len() - 1].to_vec(), longer] {
        std::fs::write(&path, bytes).unwrap();
        let mut broken = ask().await;
        assert_eq!(broken.status(), 200);
        let length = broken.content_length().unwrap();
        let mut arrived = 0;
        let fault = loop {
            match broken.chunk().await {
                Ok(Some(part)) => arrived += part.len() as u64,
                Ok(None) => break false,
                Err(_broken_off) => break true,
            }
        };
        assert!(fault && arrived < length, "{arrived} of {length} bytes arrived, broken off: {fault}");
        assert_eq!(readiness(&app).await.1["status"], "degraded");
        let part = app.client.get(app.url(&format!("{place}/program"))).header("range", "bytes=0-3");
        problem(part.send().await.unwrap(), "stored-file-damaged").await;
    }
    std::fs::write(&path, &sound).unwrap();
    assert_eq!(ask().await.bytes().await.unwrap(), sound);
    assert_eq!(readiness(&app).await.1["status"], "ready");
}

#[tokio::test]
async fn a_job_whose_input_was_altered_before_it_ran_fails_with_that_problem() {
    for (told, injure) in injuries() {
        let held = Arc::<Held>::default();
        let app = spawn_held(&held, |_| {}).await;
        let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
        running(&app, &first).await;
        let second = accepted(&app, &cc("example-ac-table"), "g1 x1.5\ng1 x2.5\n").await;
        let waiting = document(&app, &second).await;
        injure(&stored(&app, waiting["input_sha256"].as_str().unwrap()));
        held.release();
        assert_eq!(ended(&app, &first).await["state"], "succeeded");
        let failed = ended(&app, &second).await;
        assert_eq!(failed["state"], "failed", "{failed}");
        assert_eq!(failed["problem"]["type"], "/problems/stored-file-damaged", "{failed}");
        assert!(failed["problem"]["detail"].as_str().unwrap().contains(told), "{failed}");
        assert_eq!(held.order(), ["HOLD"], "it was computed");
    }
}

#[tokio::test]
async fn an_input_that_is_written_to_while_it_is_computed_fails_its_job() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |_| {}).await;
    let place = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &place).await;
    while held.order().is_empty() {
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    let input = document(&app, &place).await["input_sha256"].as_str().unwrap().to_owned();
    std::fs::write(stored(&app, &input), "HOLE\n").unwrap();
    held.release();
    let failed = ended(&app, &place).await;
    assert_eq!(failed["problem"]["type"], "/problems/stored-file-damaged", "{failed}");
}

async fn execute(data: &Path, statement: &'static str) {
    let options = SqliteConnectOptions::new().filename(data.join("trunnion.sqlite"));
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap();
    sqlx::query(statement).execute(&pool).await.unwrap();
    pool.close().await;
}

#[tokio::test]
async fn an_edited_report_is_neither_answered_nor_drawn() {
    if has_no_file("an_edited_report_is_neither_answered_nor_drawn") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let app = spawn_in(folder.path(), |_| {}).await;
    let place = accepted(&app, &cc("example-ac-table"), "g1 x1.5\n").await;
    ended(&app, &place).await;
    execute(folder.path(), "UPDATE jobs SET report = replace(report, '\"blocks_in\":1', '\"blocks_in\":2')")
        .await;
    for face in ["report", "plot"] {
        let refused = problem(app.get(&format!("{place}/{face}")).await, "stored-file-damaged").await;
        assert!(refused["detail"].as_str().unwrap().contains("the stored report"), "{refused}");
    }
    assert_eq!(readiness(&app).await.1["status"], "degraded");
    app.stop().await;
}
