//! A database on a server: which service has it, which directory belongs to it, and what is never shown of its address
//! (`docs/scale-out.md`). Without `TRUNNION_TEST_DATABASE` only the last of these tests do something.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use reqwest::StatusCode;
use tempfile::TempDir;
use trunnion::cli::start;
use trunnion::config::Settings;
use trunnion::jobs::{CutterContactCompensator, Sources};

use crate::command_line::{said, trunnion};
use crate::database::{address_of, ask, schema_of, server};
use crate::process::unset;
use crate::support::{App, ac_table, problem, spawn, spawn_in};

/// What a service says that starts on this database with this directory.
async fn refusal(database: &Path, data: &Path) -> String {
    let settings = Settings {
        listen: ([127, 0, 0, 1], 0).into(),
        data_dir: data.to_owned(),
        database: address_of(database).map(|address| address.parse().unwrap()),
        ..Settings::default()
    };
    let compensator = Arc::new(CutterContactCompensator::default());
    start(settings, Sources::real(), compensator).await.err().unwrap().to_string()
}

fn blobs(data: &Path) -> usize {
    trunnion::store::stored_files(data)
}

async fn with_a_job(app: &App) {
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&work_offset_mm=0,0,0";
    assert_eq!(app.post_text(path, "text/plain", "G21 G90\nG1 F100 X1\n").await.status(), StatusCode::OK);
}

#[tokio::test]
async fn a_second_service_on_the_same_database_is_refused() {
    if server().is_none() {
        return;
    }
    let app = spawn().await;
    let other = TempDir::new().unwrap();
    let fault = refusal(&app.data, other.path()).await;
    let process = format!("(process {})", std::process::id());
    assert!(fault.contains("is in use by trunnion") && fault.contains(&process), "{fault}");
    assert_eq!(app.get("/readyz").await.status(), StatusCode::OK);
    // The next one starts after the first has ended.
    let first = app.data.clone();
    let _directory = app.stop().await;
    spawn_in(&first, |_| {}).await.stop().await;
}

#[tokio::test]
async fn a_directory_of_another_database_is_refused_and_stays_as_it_is() {
    if server().is_none() {
        return;
    }
    let app = spawn().await;
    with_a_job(&app).await;
    let (one, other) = (app.data.clone(), spawn().await);
    let directory = app.stop().await;
    let (of_other, free) = (other.data.clone(), other.stop().await);
    let kept = blobs(&one);
    assert!(kept > 0);
    let fault = refusal(&of_other, &one).await;
    assert!(fault.contains("belong to another database"), "{fault}");
    assert_eq!(blobs(&one), kept);
    // Without the note, files that the database does not know are not touched either.
    std::fs::remove_file(one.join("database.id")).unwrap();
    let fault = refusal(&of_other, &one).await;
    assert!(fault.contains("No file was touched"), "{fault}");
    assert_eq!(blobs(&one), kept);
    // Nor is a directory with a database of its own.
    let of_a_file = TempDir::new().unwrap();
    std::fs::write(of_a_file.path().join("trunnion.sqlite"), "a database").unwrap();
    let fault = refusal(&of_other, of_a_file.path()).await;
    assert!(fault.contains("has a database file of its own"), "{fault}");
    drop((directory, free));
}

#[tokio::test]
async fn a_service_whose_database_another_one_has_taken_over_stores_nothing() {
    if server().is_none() {
        return;
    }
    let app = spawn().await;
    let schema = schema_of(&app.data);
    ask(&format!("UPDATE {schema}.service SET instance = 'another'"));
    let put = app.put_machine("late", &ac_table()).await;
    problem(put, "storage-unavailable").await;
    tokio::time::timeout(Duration::from_secs(1), app.store().taken_over()).await.unwrap();
    let late = format!("SELECT count(*) FROM {schema}.machines WHERE machine_id = 'late'");
    assert_eq!(ask(&late), "0");
    problem(app.get("/readyz").await, "storage-unavailable").await;
}

#[tokio::test]
async fn a_service_that_loses_its_session_takes_the_lock_again() {
    if server().is_none() {
        return;
    }
    let app = spawn().await;
    let schema = schema_of(&app.data);
    let holders = format!(
        "SELECT count(pid) FROM pg_locks WHERE locktype = 'advisory' AND classid = 1953656943
           AND objid = CAST(CAST(hashtext('{schema}') AS BIGINT) & 4294967295 AS oid)"
    );
    assert_eq!(ask(&holders), "1");
    ask(&holders.replace("count(pid)", "pg_terminate_backend(pid)"));
    let end = Instant::now() + Duration::from_secs(5);
    while ask(&holders) != "1" {
        assert!(Instant::now() < end, "the lock is not taken again");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(app.put_machine("after", &ac_table()).await.status(), StatusCode::CREATED);
    assert_eq!(app.get("/readyz").await.status(), StatusCode::OK);
}

#[tokio::test]
async fn the_rows_are_read_for_damage() {
    if server().is_none() {
        return;
    }
    let app = spawn().await;
    with_a_job(&app).await;
    let pace = trunnion::store::Pace::unbounded();
    assert_eq!(app.store().damage_in_rows(&app.data, &pace).await.unwrap(), Vec::<String>::new());
    let schema = schema_of(&app.data);
    ask(&format!(
        "ALTER TABLE {schema}.jobs DISABLE TRIGGER ALL; UPDATE {schema}.jobs SET report = '{{}}';
         ALTER TABLE {schema}.audit DISABLE TRIGGER ALL; UPDATE {schema}.audit SET resource = '/x' WHERE seq = 2;
         ALTER TABLE {schema}.machines DISABLE TRIGGER ALL; UPDATE {schema}.machines SET last_revision = 7"
    ));
    let found = app.store().damage_in_rows(&app.data, &pace).await.unwrap().join("\n");
    for part in ["report has another SHA-256", "entry 2 of the audit log", "is at revision 7"] {
        assert!(found.contains(part), "{found}");
    }
}

#[tokio::test]
async fn a_text_that_the_server_cannot_store_is_refused() {
    let app = spawn().await;
    let entries = serde_json::json!({"entries": [{
        "cutter_id": "c1", "measured_at": "2026-01-01T00:00:00Z", "parts_cut": 1, "radius_wear_um": 1.0,
        "note": "a\u{0}b"
    }]});
    let posted = app.post_json("/v1/machines/example-ac-table/tools/t1/wear-entries", &entries).await;
    if server().is_some() && posted.status() != StatusCode::UNPROCESSABLE_ENTITY {
        problem(posted, "invalid-request").await;
    }
    assert_eq!(app.get("/readyz").await.status(), StatusCode::OK);
}

#[test]
fn a_password_is_in_no_output() {
    let folder = TempDir::new().unwrap();
    let address = "postgres://trunnion:s3cret@127.0.0.1:1/trunnion";
    let by_environment = |arguments: &[&str]| {
        let mut command = unset();
        command.env("TRUNNION_DATABASE", address).env("TRUNNION_DATA_DIR", folder.path());
        said(&command.args(arguments).output().unwrap())
    };
    for text in [
        by_environment(&["config", "show"]),
        by_environment(&["serve", "--help"]),
        by_environment(&["doctor"]),
        by_environment(&["serve", "--listen", "127.0.0.1:0"]),
        by_environment(&["keys", "list"]),
        by_environment(&["backup", "there"]),
        said(&trunnion(folder.path(), &["config", "show", "--database", address])),
        said(&trunnion(folder.path(), &["config", "show", "--database", "mysql://trunnion:s3cret@h/d"])),
    ] {
        assert!(!text.contains("s3cret") && !text.is_empty(), "{text}");
    }
    let shown = by_environment(&["config", "show"]);
    assert!(shown.contains("database = \"postgres://127.0.0.1:1/trunnion\""), "{shown}");
}

#[test]
fn commands_for_a_file_name_the_tools_of_the_server() {
    let folder = TempDir::new().unwrap();
    for (arguments, tool) in [(["backup", "there"], "pg_dump"), (["restore", "there"], "pg_restore")] {
        let mut all = arguments.to_vec();
        all.extend(["--database", "postgres://127.0.0.1:1/trunnion"]);
        let output = trunnion(folder.path(), &all);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(tool) && text.contains("docs/scale-out.md"), "{text}");
    }
}

#[test]
fn a_server_that_does_not_answer_is_named_at_the_start() {
    let folder = TempDir::new().unwrap();
    let arguments = ["serve", "--listen", "127.0.0.1:0", "--database", "postgres://127.0.0.1:1/trunnion"];
    let output = trunnion(folder.path(), &arguments);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    let expected = if cfg!(feature = "scale-out") {
        "postgres://127.0.0.1:1/trunnion cannot be opened"
    } else {
        "built without the feature scale-out"
    };
    assert!(text.contains(expected), "{text}");
}
