//! A database on a server: which service has it, which directory belongs to it, and what is never shown of its address
//! (`docs/scale-out.md`). Without `TRUNNION_TEST_DATABASE` only the last of these tests do something.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;
use std::time::{Duration, Instant};

use reqwest::StatusCode;
use serde_json::Value;
use tempfile::TempDir;
use trunnion::cli::start;
use trunnion::config::{FilesIn, Settings};
use trunnion::jobs::{CutterContactCompensator, Sources};

use crate::command_line::{said, trunnion};
use crate::database::{address_of, ask, places, schema_of, server, shared_place};
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
    if app.store().is_shared() {
        // None of several services takes a database over.
        return;
    }
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

/// Whether the doctor finds nothing. A server of tests need not survive its computer.
pub(crate) fn is_sound_but_for_fsync(output: &Output) -> bool {
    let text = said(output);
    let mut faults = text.lines().filter(|line| line.starts_with("FAULT"));
    match output.status.code() {
        Some(0) => faults.next().is_none(),
        Some(1) => faults.all(|line| line.contains("  fsync = off: ") && line.ends_with("set fsync = on")),
        _ => false,
    }
}

#[tokio::test]
async fn the_doctor_reads_rows_and_files_of_a_server_and_names_what_is_wrong() {
    if server().is_none() {
        return;
    }
    for place in places() {
        let folder = TempDir::new().unwrap();
        let data = folder.path();
        let asked = |arguments: &[&str]| {
            trunnion(data, &[&["doctor", "--files", &place.to_string()], arguments].concat())
        };
        crate::database::put_on_the_server(data);
        let empty = asked(&[]);
        assert!(empty.status.success() && said(&empty).contains("is empty"), "{}", said(&empty));
        let app = spawn_in(data, |settings| settings.files = place.clone()).await;
        with_a_job(&app).await;
        let run: Value = serde_json::from_str(include_str!("../../docs/examples/ballbar.json")).unwrap();
        let run = app.post_json("/v1/machines/example-ac-table/calibrations", &run).await;
        assert_eq!(run.status(), StatusCode::CREATED);
        let sound = asked(&["--deep"]);
        assert!(is_sound_but_for_fsync(&sound), "{}", said(&sound));
        for part in [
            "PostgreSQL",
            "1 named in the database, all present",
            "schema unchanged",
            "a chain of",
            "in use by",
        ] {
            assert!(said(&sound).contains(part), "{part}: {}", said(&sound));
        }
        let fsync = ask("SHOW fsync") == "off";
        assert_eq!(said(&sound).contains("fsync = off: the server loses"), fsync, "{}", said(&sound));
        let elsewhere = if place == FilesIn::Postgres { "directory" } else { "postgres" };
        let wrong = trunnion(data, &["doctor", "--files", elsewhere]);
        assert!(said(&wrong).contains(&format!("set files = {place}")), "{}", said(&wrong));
        app.stop().await;

        let schema = schema_of(data);
        let at = |text: &str| ask(&text.replace('@', &format!("{schema}.")));
        let sha256 = at("SELECT output_sha256 FROM @jobs");
        let blob = data.join("blobs").join(&sha256[..2]).join(&sha256);
        if let FilesIn::Objects(_) = place {
            // What the doctor finds of objects is tried in `bucket.rs`.
            continue;
        }
        if place == FilesIn::Postgres {
            at(&format!("UPDATE @file_parts SET bytes = 'G1 X9' WHERE object_key LIKE '{sha256}%'"));
        } else {
            std::fs::write(&blob, "G1 X9").unwrap();
        }
        let found = asked(&[]);
        assert_eq!(found.status.code(), Some(1));
        assert!(
            said(&found).contains("has other bytes") && said(&found).contains(&sha256),
            "{}",
            said(&found)
        );
        assert!(is_sound_but_for_fsync(&asked(&["--quick"])));
        if place == FilesIn::Postgres {
            at(&format!("DELETE FROM @files WHERE sha256 = '{sha256}'"));
        } else {
            std::fs::remove_file(&blob).unwrap();
        }
        let found = asked(&["--quick"]);
        assert!(said(&found).contains(&format!("{sha256} is missing")), "{}", said(&found));
        let head = at("SELECT seq || ':' || sha256 FROM @audit ORDER BY seq DESC LIMIT 1");
        for (what, statement, told) in [
            ("a report", "UPDATE @jobs SET report = '{}'", "report has another SHA-256"),
            (
                "the log",
                "UPDATE @audit SET resource = '/x' WHERE seq = 2",
                "entry 2 of the audit log was changed",
            ),
            ("a trend", "UPDATE @calibration_errors SET value = value + 1", "contradict its document"),
            ("a machine", "UPDATE @machines SET last_revision = 7", "is at revision 7"),
            ("a reference", "DELETE FROM @machines", "rows refer to missing rows"),
            (
                "an index",
                "DROP INDEX @jobs_of_machine",
                "the index jobs_of_machine is missing from the schema",
            ),
            ("a rule", "ALTER TABLE @jobs DROP CONSTRAINT jobs_check", "the constraint jobs_check"),
            (
                "a function",
                "CREATE OR REPLACE FUNCTION @forget_caller() RETURNS trigger LANGUAGE plpgsql AS 'BEGIN RETURN NULL; END'",
                "the function forget_caller() differs",
            ),
        ] {
            at(&format!(
                "BEGIN; SET LOCAL session_replication_role = replica; {statement}; COMMIT; SELECT count(*) FROM @jobs"
            ));
            let found = asked(&["--deep"]);
            assert_eq!(found.status.code(), Some(1), "{what}");
            assert!(said(&found).contains(told), "{what}: {told}: {}", said(&found));
        }
        at("ALTER TABLE @audit DISABLE TRIGGER audit_never_goes; DELETE FROM @audit WHERE seq = 1; SELECT 1");
        let found = asked(&["--audit-head", &head.replace('a', "b")]);
        assert!(
            said(&found).contains("the trigger audit_never_goes of audit is switched off"),
            "{}",
            said(&found)
        );
        assert!(said(&found).contains("was recorded elsewhere") || !head.contains('a'), "{}", said(&found));
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
        by_environment(&["migrate", "--to", address]),
        by_environment(&["migrate", "--to", "mysql://trunnion:s3cret@h/d"]),
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

/// A database that comes back from a dump is the same to the doctor, deep look included.
#[tokio::test]
async fn a_restored_dump_is_sound() {
    let Some(server) = server() else { return };
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    let app = spawn_in(&data, |_| ()).await;
    with_a_job(&app).await;
    let files = if app.store().is_shared() { shared_place().to_string() } else { "directory".to_owned() };
    app.stop().await;
    let (schema, dump) = (schema_of(&data), folder.path().join("trunnion.dump"));
    let run = |command: &mut Command| {
        let done = command.output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    };
    run(Command::new("pg_dump")
        .args(["--format=custom", "--schema", &schema, "--file"])
        .arg(&dump)
        .arg(&server));
    ask(&format!("DROP SCHEMA {schema} CASCADE"));
    run(Command::new("pg_restore").args(["--single-transaction", "--dbname", &server]).arg(&dump));
    let looked = trunnion(&data, &["doctor", "--deep", "--files", &files]);
    assert!(is_sound_but_for_fsync(&looked), "{}", said(&looked));
    assert!(said(&looked).contains("schema unchanged"), "{}", said(&looked));
    // Its rules still hold.
    let changed = crate::database::change(&data, "UPDATE audit SET resource = '/x' WHERE seq = 1").await;
    assert!(changed.is_err_and(|fault| fault.contains("the audit log never changes")));
    ask(&format!("DROP SCHEMA {schema} CASCADE"));
    let gone = trunnion(&data, &["doctor", "--files", &files]);
    assert!(said(&gone).contains("CREATE SCHEMA"), "{}", said(&gone));
    ask(&format!("CREATE SCHEMA {schema}"));
}

#[tokio::test]
async fn a_backup_of_a_server_reads_everything_and_prints_the_commands() {
    if server().is_none() {
        return;
    }
    let app = spawn().await;
    with_a_job(&app).await;
    let files = if app.store().is_shared() { shared_place().to_string() } else { "directory".to_owned() };
    let asked = || trunnion(&app.data, &["backup", "/srv/there", "--files", &files]);
    let sound = asked();
    let text = said(&sound);
    assert_eq!(sound.status.code(), Some(2), "{text}");
    for part in
        ["all present, with the bytes", "a chain of", "copied nothing", "--file /srv/there/trunnion.dump"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert_eq!(text.contains("cp --recursive"), files == "directory", "{text}");
    let schema = schema_of(&app.data);
    ask(&format!("ALTER TABLE {schema}.jobs DISABLE TRIGGER ALL; UPDATE {schema}.jobs SET report = '{{}}'"));
    let text = said(&asked());
    assert!(
        text.contains("report has another SHA-256") && text.contains("a copy would have the same faults"),
        "{text}"
    );
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
