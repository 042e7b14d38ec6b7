//! What becomes of jobs when the service stops, or its process dies.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::database;
use crate::queue::{Held, accepted, cc, document, ended, running, spawn_held_in};
use crate::support::spawn_in;

/// Longer than any stop may take.
const FAR_TOO_LONG: Duration = Duration::from_secs(30);

/// Changes jobs as a process that dies leaves them.
async fn write(data: &Path, statement: &'static str, place: &str) {
    let id = place.trim_start_matches("/v1/jobs/");
    let changed = database::change(data, &statement.replace('?', &format!("'{id}'"))).await;
    assert_eq!(changed, Ok(1), "{statement}");
}

const RUNNING: &str = "UPDATE jobs SET state = 'running', attempts = 1, lease = id WHERE id = ?";
const SUSPECT: &str = "UPDATE jobs SET state = 'running', attempts = 4, deaths = 3, lease = id WHERE id = ?";
const SUSPECT_AGAIN: &str =
    "UPDATE jobs SET state = 'running', attempts = 8, deaths = 3, lone_deaths = 4, lease = id WHERE id = ?";
const OFTEN_BEGUN: &str =
    "UPDATE jobs SET state = 'running', attempts = 50, deaths = 2, lease = id WHERE id = ?";
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
    let left = "SELECT state || ' ' || attempts || ' ' || coalesce(lease, 'no lease') FROM jobs";
    assert_eq!(database::value(directory.path(), left).await, "queued 0 no lease");
    // The test's own runtime waits for threads.
    held.release();
}

/// Marks a job as being computed, as a process leaves it that dies: beside others, or alone.
pub(crate) fn mark(data: &Path, place: &str, how: &str) {
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let folder = data.join("computing");
    std::fs::create_dir_all(&folder).unwrap();
    let id = place.trim_start_matches("/v1/jobs/");
    std::fs::write(folder.join(id), format!("{} {how}", boot.trim())).unwrap();
}

async fn deaths(data: &Path, place: &str) -> (i64, i64) {
    let id = place.trim_start_matches("/v1/jobs/");
    let query = format!("SELECT deaths || ' ' || lone_deaths FROM jobs WHERE id = '{id}'");
    let found = database::value(data, &query).await;
    let (deaths, lone_deaths) = found.split_once(' ').unwrap();
    (deaths.parse().unwrap(), lone_deaths.parse().unwrap())
}

#[tokio::test]
async fn a_death_counts_for_what_was_computed_and_only_one_alone_is_blamed_on_a_job() {
    let directory = TempDir::new().unwrap();
    let data = directory.path();
    let held = Arc::<Held>::default();
    let app = spawn_held_in(data, &held).await;
    let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &first).await;
    let mut places = Vec::new();
    for program in
        ["never run\n", "beside\n", "alone\n", "alone once too often\n", "not computed\n", "cancelled\n"]
    {
        places.push(accepted(&app, &cc("example-ac-table"), program).await);
    }
    let [never, beside, alone, last, settling, cancelled] = places.try_into().unwrap();
    app.stop().await;
    for (place, statement, how) in [
        (&beside, RUNNING, Some("beside")),
        (&alone, SUSPECT, Some("alone")),
        (&last, SUSPECT_AGAIN, Some("alone")),
        // Taken, but on its way to a thread or from it.
        (&settling, OFTEN_BEGUN, None),
        (&cancelled, CANCELLING, Some("beside")),
    ] {
        write(data, statement, place).await;
        if let Some(how) = how {
            mark(data, place, how);
        }
    }
    let held = Arc::<Held>::default();
    held.release();
    let app = spawn_held_in(data, &held).await;
    let parked = document(&app, &last).await;
    assert_eq!(parked["state"], "failed", "{parked}");
    assert_eq!(parked["problem"]["type"], "/problems/process-died");
    assert_eq!(app.get(parked["problem"]["type"].as_str().unwrap()).await.status(), 200);
    assert_eq!(document(&app, &cancelled).await["state"], "cancelled");
    for (place, attempts) in [(&beside, 2), (&alone, 5), (&settling, 51), (&first, 1), (&never, 1)] {
        let job = ended(&app, place).await;
        assert_eq!((&job["state"], &job["attempts"]), (&"succeeded".into(), &attempts.into()), "{job}");
    }
    // What died is first, and of that what may be blamed least.
    let order = held.order();
    assert_eq!(order[2], "alone", "{order:?}");
    assert!(order[..2].contains(&"beside".to_owned()) && order[..2].contains(&"not computed".to_owned()));
    assert_eq!(order.len(), 5);
    app.stop().await;
    for (place, expected) in
        [(&beside, (1, 0)), (&alone, (3, 1)), (&last, (3, 5)), (&settling, (2, 0)), (&first, (0, 0))]
    {
        assert_eq!(deaths(data, place).await, expected, "{place}");
    }
    assert_eq!(std::fs::read_dir(data.join("computing")).unwrap().count(), 0);
}

#[tokio::test]
async fn a_job_is_marked_for_as_long_as_it_is_computed() {
    let directory = TempDir::new().unwrap();
    let held = Arc::<Held>::default();
    let app = spawn_held_in(directory.path(), &held).await;
    let place = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let folder = directory.path().join("computing");
    let marks = || std::fs::read_dir(&folder).unwrap().count();
    while held.order().is_empty() {
        tokio::task::yield_now().await;
    }
    assert_eq!(marks(), 1);
    let text = std::fs::read_to_string(folder.join(place.trim_start_matches("/v1/jobs/"))).unwrap();
    assert!(text.ends_with(" beside"), "{text}");
    held.release();
    assert_eq!(ended(&app, &place).await["state"], "succeeded");
    assert_eq!(marks(), 0);
    // A computation that breaks has ended too: it fails, and nothing is blamed for a death.
    let place = accepted(&app, &cc("example-ac-table"), "PANIC\n").await;
    assert_eq!(ended(&app, &place).await["problem"]["type"], "/problems/internal");
    assert_eq!(marks(), 0);
}

#[tokio::test]
async fn a_job_that_met_three_deaths_beside_others_is_computed_alone() {
    let directory = TempDir::new().unwrap();
    for (statement, how) in [
        ("UPDATE jobs SET deaths = 2 WHERE id = ?", "beside"),
        ("UPDATE jobs SET deaths = 3 WHERE id = ?", "alone"),
    ] {
        let app = spawn_held_in(directory.path(), &Arc::<Held>::default()).await;
        let place = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
        running(&app, &place).await;
        app.stop().await;
        write(directory.path(), statement, &place).await;
        let held = Arc::<Held>::default();
        let app = spawn_held_in(directory.path(), &held).await;
        while held.order().is_empty() {
            tokio::task::yield_now().await;
        }
        let mark = directory.path().join("computing").join(place.trim_start_matches("/v1/jobs/"));
        let text = std::fs::read_to_string(mark).unwrap();
        assert!(text.ends_with(&format!(" {how}")), "{statement}: {text}");
        held.release();
        assert_eq!(ended(&app, &place).await["state"], "succeeded");
        app.stop().await;
    }
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
