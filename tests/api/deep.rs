//! Databases that `SQLite` calls sound and that are not: the deep doctor, backups, restorations and the scrub name
//! what was changed.

use std::path::{Path, PathBuf};
use std::time::Duration;

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use sqlx::AssertSqlSafe;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool, SqlitePoolOptions};
use tempfile::TempDir;
use trunnion::store::sha256_hex;

use crate::command_line::{files, path, posted, said, trunnion};
use crate::database::has_no_file;
use crate::support::{App, ac_table, problem, spawn_in};

const BALLBAR: &str = include_str!("../../docs/examples/ballbar.json");

async fn open(data: &Path) -> SqlitePool {
    let options = SqliteConnectOptions::new().filename(data.join("trunnion.sqlite")).foreign_keys(false);
    SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap()
}

async fn execute(pool: &SqlitePool, statement: &str) {
    sqlx::raw_sql(AssertSqlSafe(statement.to_owned())).execute(pool).await.unwrap();
}

/// Changes a database as somebody does who can write to its file: no trigger is in the way, and all are there again
/// afterwards.
pub(crate) async fn rewritten(data: &Path, statements: &str) {
    let pool = open(data).await;
    let triggers: Vec<(String, String)> =
        sqlx::query_as("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger'")
            .fetch_all(&pool)
            .await
            .unwrap();
    for (name, _) in &triggers {
        execute(&pool, &format!("DROP TRIGGER {name}")).await;
    }
    execute(&pool, statements).await;
    for (_, text) in &triggers {
        execute(&pool, text).await;
    }
    pool.close().await;
}

/// A directory with machines, a job and keys.
async fn used(data: &Path) {
    let app = spawn_in(data, |_| {}).await;
    assert_eq!(app.put_machine("dmu-80", &ac_table()).await.status(), 201);
    posted(&app).await;
    let run: Value = serde_json::from_str(BALLBAR).unwrap();
    let run = app.post_json("/v1/machines/example-ac-table/calibrations", &run).await;
    assert_eq!(run.status(), 201);
    app.stop().await;
    for name in ["office", "hall"] {
        let made = trunnion(data, &["keys", "create", "--name", name, "--scopes", "read"]);
        assert!(made.status.success(), "{}", said(&made));
    }
}

fn copied(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for file in files(from) {
        let target = to.join(file.strip_prefix(from).unwrap());
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(&file, target).unwrap();
    }
}

fn assert_unsound(data: &Path, told: &[&str]) {
    let looked = trunnion(data, &["doctor", "--deep"]);
    assert_eq!(looked.status.code(), Some(1), "{told:?}: {}", said(&looked));
    for part in told {
        assert!(said(&looked).contains(part), "{part}: {}", said(&looked));
    }
    let target = data.with_extension("backup");
    let refused = trunnion(data, &["backup", path(&target)]);
    assert_eq!(refused.status.code(), Some(2), "{told:?}: {}", said(&refused));
    assert!(said(&refused).contains("the database is damaged"), "{told:?}: {}", said(&refused));
    assert!(!target.exists());
}

#[tokio::test]
async fn every_kind_of_edit_is_found_by_the_deep_doctor_and_by_a_backup() {
    if has_no_file("every_kind_of_edit_is_found_by_the_deep_doctor_and_by_a_backup") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let sound = folder.path().join("sound");
    used(&sound).await;
    let looked = trunnion(&sound, &["doctor", "--deep"]);
    assert!(looked.status.success(), "{}", said(&looked));
    assert!(said(&looked).contains("digests and schema unchanged"), "{}", said(&looked));
    let edits: [(&str, &str, &[&str]); 12] = [
        (
            "limits of a machine",
            "UPDATE machine_revisions SET profile = replace(profile, '400', '900') WHERE machine_id = 'dmu-80'",
            &["machine_revisions dmu-80/1: profile has the SHA-256"],
        ),
        (
            "a report",
            "UPDATE jobs SET report = json_set(report, '$.blocks_out', 1)",
            &["report has the SHA-256"],
        ),
        ("an index", "DROP INDEX jobs_of_machine", &["the index jobs_of_machine is missing from the schema"]),
        ("a table", "CREATE TABLE more (a)", &["no migration makes the table more"]),
        (
            "half of the audit log and a key",
            "DELETE FROM audit WHERE seq > (SELECT max(seq) / 2 FROM audit);
             INSERT INTO api_keys (id, secret_sha256, name, scopes, created_at) VALUES ('intruder00',
                 '5e884898da28047151d0e56f8dc6292773603d0d6aabbdd62a11ef721d1542d8', 'x', '[\"admin\"]',
                 '2026-01-01T00:00:00.000Z')",
            &["the audit log ends at entry", "the API key intruder00 was made by no entry"],
        ),
        (
            "the first entry",
            "DELETE FROM audit WHERE seq = 1",
            &["entry 2 of the audit log was changed after it was written"],
        ),
        (
            "who did it",
            "UPDATE audit SET key_id = 'somebody' WHERE seq = 2",
            &["entry 2 of the audit log was changed after it was written"],
        ),
        (
            "an entry without a digest",
            "INSERT INTO audit (at, origin, action, resource) VALUES ('2026-01-01T00:00:00.000Z', 'service', 'x', '/x')",
            &["has no digest"],
        ),
        (
            "a value of a trend",
            "UPDATE calibration_errors SET value = value + 1 WHERE axis = 'A' AND error = 'e_z'",
            &["the error rows of calibration", "contradict its document"],
        ),
        (
            "a value more in a trend",
            "INSERT INTO calibration_errors SELECT machine_id, axis, error, '2030-01-01T00:00:00.000Z', calibration_seq,
                 calibration_id, machine_revision, value, standard_uncertainty, identifiable
             FROM calibration_errors WHERE axis = 'A' AND error = 'e_z'",
            &["but the calibrations have"],
        ),
        (
            "all values of a trend",
            "DELETE FROM calibration_errors",
            &["the error rows of calibration", "contradict its document"],
        ),
        (
            "a machine's revision",
            "UPDATE machines SET last_revision = 7 WHERE machine_id = 'dmu-80'",
            &["its last one is 1"],
        ),
    ];
    for (number, (what, statements, told)) in edits.into_iter().enumerate() {
        let data = folder.path().join(format!("edited-{number}"));
        copied(&sound, &data);
        rewritten(&data, statements).await;
        eprintln!("{what}");
        assert_unsound(&data, told);
        // SQLite itself has nothing to say.
        assert!(trunnion(&data, &["doctor", "--quick"]).status.success(), "{what}");
    }
    let data = folder.path().join("no-trigger");
    copied(&sound, &data);
    let pool = open(&data).await;
    execute(&pool, "DROP TRIGGER audit_never_goes").await;
    pool.close().await;
    assert_unsound(&data, &["the trigger audit_never_goes is missing from the schema"]);
}

#[tokio::test]
async fn an_edited_machine_tool_or_calibration_is_neither_shown_nor_computed_with() {
    const DMU: &str = "/v1/machines/dmu-80";
    if has_no_file("an_edited_machine_tool_or_calibration_is_neither_shown_nor_computed_with") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path();
    let app = spawn_in(data, |_| {}).await;
    assert_eq!(app.put_machine("dmu-80", &ac_table()).await.status(), 201);
    let tool = json!({"number": 12, "name": "BALL_10", "kind": "ball", "radius_mm": 5});
    assert_eq!(
        app.client.put(app.url(&format!("{DMU}/tools/T12"))).json(&tool).send().await.unwrap().status(),
        201
    );
    let run: Value = serde_json::from_str(include_str!("../../docs/examples/ballbar.json")).unwrap();
    let run = app.post_json(&format!("{DMU}/calibrations"), &run).await;
    assert_eq!(run.status(), 201);
    let run: Value = run.json().await.unwrap();
    let run = format!("{DMU}/calibrations/{}", run["id"].as_str().unwrap());
    app.stop().await;
    rewritten(
        data,
        "UPDATE machine_revisions SET profile = replace(profile, '400', '900') WHERE machine_id = 'dmu-80';
         UPDATE tool_revisions SET document = replace(document, '5.0', '6.0');
         UPDATE calibrations SET run = replace(run, '1', '2')",
    )
    .await;
    let app = spawn_in(data, |_| {}).await;
    let poses = json!({"poses": [{"x": 0, "y": 0, "z": 0, "i": 0, "j": 0, "k": 1}]});
    let answers = [
        ("machine dmu-80 revision 1", app.get(DMU).await),
        ("machine dmu-80 revision 1", app.get("/v1/machines").await),
        ("machine dmu-80 revision 1", app.post_json(&format!("{DMU}/inverse-kinematics"), &poses).await),
        ("\"T12\" of machine dmu-80 revision 1", app.get(&format!("{DMU}/tools/T12")).await),
        ("run of calibration", app.get(&run).await),
    ];
    for (what, answer) in answers {
        let detail = problem(answer, "stored-file-damaged").await["detail"].as_str().unwrap().to_owned();
        assert!(detail.contains(what) && detail.contains("restore it from a backup"), "{detail}");
    }
    // Another machine is served on, and the readiness tells.
    assert_eq!(app.get("/v1/machines/example-ac-table").await.status(), 200);
    let ready: Value = app.get("/readyz").await.json().await.unwrap();
    assert_eq!(ready["status"], "degraded", "{ready}");
    // What was there before is put in its place: a revision of its own, which is served.
    let put = async |path: &str, document: &Value| {
        app.client.put(app.url(path)).header("if-match", "*").json(document).send().await.unwrap()
    };
    for (path, document) in [(DMU.to_owned(), ac_table()), (format!("{DMU}/tools/T12"), tool)] {
        let answer = put(&path, &document).await;
        assert_eq!(answer.status(), 200, "{path}");
        assert_eq!(answer.json::<Value>().await.unwrap()["revision"], 2, "{path}");
        assert_eq!(app.get(&path).await.status(), 200, "{path}");
        // And no further one, once it is.
        let again: Value = put(&path, &document).await.json().await.unwrap();
        assert_eq!(again["revision"], 2, "{path}");
    }
}

#[tokio::test]
async fn a_zeroed_overflow_page_is_found() {
    if has_no_file("a_zeroed_overflow_page_is_found") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    used(&data).await;
    let report = json!({"text": "overflowing ".repeat(2000)}).to_string();
    rewritten(
        &data,
        &format!(
            "UPDATE jobs SET report = '{report}', report_sha256 = '{}'; PRAGMA wal_checkpoint(TRUNCATE)",
            sha256_hex(report.as_bytes())
        ),
    )
    .await;
    let looked = trunnion(&data, &["doctor", "--deep"]);
    assert!(looked.status.success(), "{}", said(&looked));
    let database = data.join("trunnion.sqlite");
    let mut bytes = std::fs::read(&database).unwrap();
    let page = usize::from(u16::from_be_bytes([bytes[16], bytes[17]]));
    let marker = b"overflowing overflowing overflowing";
    let holds = |page: &[u8]| page.windows(marker.len()).any(|window| window == marker);
    let last = bytes.chunks(page).rposition(holds).unwrap();
    bytes[last * page + 4..(last + 1) * page].fill(0);
    std::fs::write(&database, bytes).unwrap();
    assert_eq!(trunnion(&data, &["doctor", "--deep"]).status.code(), Some(1));
    assert_eq!(trunnion(&data, &["backup", path(&folder.path().join("backup"))]).status.code(), Some(2));
}

#[tokio::test]
async fn an_index_that_has_lost_its_entries_is_found() {
    if has_no_file("an_index_that_has_lost_its_entries_is_found") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    used(&data).await;
    let pool = open(&data).await;
    execute(&pool, "PRAGMA wal_checkpoint(TRUNCATE)").await;
    let root: i64 = sqlx::query_scalar(
        "SELECT rootpage FROM sqlite_schema WHERE type = 'index' AND name = 'audit_of_machine'",
    )
    .fetch_one(&pool)
    .await
    .unwrap();
    pool.close().await;
    let database = data.join("trunnion.sqlite");
    let mut bytes = std::fs::read(&database).unwrap();
    let page = usize::from(u16::from_be_bytes([bytes[16], bytes[17]]));
    let begin = (usize::try_from(root).unwrap() - 1) * page;
    assert_eq!(bytes[begin], 10, "a leaf of an index");
    // No free block, no cells, and the cells' space begins at the page's end: the page itself is sound.
    let [high, low] = u16::try_from(page).unwrap().to_be_bytes();
    bytes[begin + 1..begin + 8].copy_from_slice(&[0, 0, 0, 0, high, low, 0]);
    std::fs::write(&database, bytes).unwrap();
    let looked = trunnion(&data, &["doctor"]);
    assert_eq!(looked.status.code(), Some(1), "{}", said(&looked));
    assert!(said(&looked).contains("audit_of_machine"), "{}", said(&looked));
}

/// The head that the doctor tells.
fn head(data: &Path) -> String {
    let looked = trunnion(data, &["doctor", "--deep"]);
    let text = said(&looked);
    assert!(looked.status.success(), "{text}");
    let (_, head) = text.split_once("head ").unwrap();
    head.split_whitespace().next().unwrap().to_owned()
}

#[tokio::test]
async fn a_head_kept_elsewhere_finds_a_log_that_was_rewritten_without_a_trace() {
    if has_no_file("a_head_kept_elsewhere_finds_a_log_that_was_rewritten_without_a_trace") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    used(&data).await;
    let kept = head(&data);
    // What came later stands after it.
    assert!(trunnion(&data, &["keys", "create", "--name", "third", "--scopes", "read"]).status.success());
    let grown = trunnion(&data, &["doctor", "--audit-head", &kept]);
    assert!(grown.status.success() && said(&grown).contains("as recorded"), "{}", said(&grown));
    // The last two entries go with their keys, and the count with them: nothing in the directory tells.
    rewritten(
        &data,
        "DELETE FROM api_keys WHERE name IN ('hall', 'third');
         DELETE FROM audit WHERE seq > (SELECT max(seq) - 2 FROM audit);
         UPDATE sqlite_sequence SET seq = (SELECT max(seq) FROM audit) WHERE name = 'audit'",
    )
    .await;
    assert_ne!(head(&data), kept);
    let found = trunnion(&data, &["doctor", "--audit-head", &kept]);
    assert_eq!(found.status.code(), Some(1), "{}", said(&found));
    assert!(said(&found).contains("was recorded elsewhere"), "{}", said(&found));
    // So is another digest under the same number.
    let (seq, _) = kept.split_once(':').unwrap();
    let other = format!("{}:{}", seq.parse::<i64>().unwrap() - 1, "ab".repeat(32));
    let found = trunnion(&data, &["doctor", "--audit-head", &other]);
    assert_eq!(found.status.code(), Some(1), "{}", said(&found));
    assert!(said(&found).contains("was rewritten"), "{}", said(&found));
    let unreadable = trunnion(&data, &["doctor", "--audit-head", "42"]);
    assert_eq!(unreadable.status.code(), Some(2), "{}", said(&unreadable));
}

#[tokio::test]
async fn the_audit_log_as_it_is_answered_is_the_documented_chain() {
    if has_no_file("the_audit_log_as_it_is_answered_is_the_documented_chain") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |_| {}).await;
    assert_eq!(app.put_machine("dmu-80", &ac_table()).await.status(), 201);
    posted(&app).await;
    let list: Value = app.get("/v1/audit").await.json().await.unwrap();
    let mut previous = "0".repeat(64);
    let entries: Vec<&Value> = list["items"].as_array().unwrap().iter().rev().collect();
    assert!(entries.len() >= 4, "{list}");
    for entry in entries {
        let mut content = vec![json!("trunnion-audit-1"), json!(previous)];
        content.extend(
            [
                "seq",
                "at",
                "origin",
                "key_id",
                "action",
                "method",
                "route",
                "request_id",
                "machine_id",
                "resource",
                "revision_before",
                "revision_after",
            ]
            .map(|member| entry[member].clone()),
        );
        let digest = Sha256::digest(serde_json::to_vec(&content).unwrap());
        let digits = digest.iter().flat_map(|byte| [byte >> 4, byte & 15]);
        previous = digits.map(|digit| char::from_digit(u32::from(digit), 16).unwrap()).collect();
        assert_eq!(entry["sha256"], previous.as_str(), "{entry}");
    }
    app.stop().await;
    assert!(head(&data).ends_with(&previous));
}

#[tokio::test]
async fn entries_of_an_earlier_version_are_chained_at_the_first_start() {
    if has_no_file("entries_of_an_earlier_version_are_chained_at_the_first_start") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    used(&data).await;
    let before = head(&data);
    rewritten(&data, "UPDATE audit SET sha256 = NULL").await;
    assert_eq!(trunnion(&data, &["doctor", "--deep"]).status.code(), Some(1));
    assert!(trunnion(&data, &["migrate"]).status.success());
    assert_eq!(head(&data), before);
}

#[tokio::test]
async fn a_backup_has_the_head_in_its_manifest_and_is_restored_with_no_other() {
    if has_no_file("a_backup_has_the_head_in_its_manifest_and_is_restored_with_no_other") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    used(&data).await;
    let backup = folder.path().join("backup");
    assert!(trunnion(&data, &["backup", path(&backup)]).status.success());
    let place = backup.join("manifest.json");
    let mut manifest: Value = serde_json::from_slice(&std::fs::read(&place).unwrap()).unwrap();
    let told = &manifest["audit_head"];
    assert_eq!(format!("{}:{}", told["seq"], told["sha256"].as_str().unwrap()), head(&data));
    let restored = folder.path().join("restored");
    manifest["audit_head"]["sha256"] = json!("ab".repeat(32));
    std::fs::write(&place, manifest.to_string()).unwrap();
    let refused = trunnion(&restored, &["restore", path(&backup)]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("audit log ends at"), "{}", said(&refused));
    // An edit of the database that the manifest was made to agree with is found in the rows.
    let database = backup.join("trunnion.sqlite");
    rewritten(
        &backup,
        "UPDATE jobs SET report = json_set(report, '$.blocks_out', 1); PRAGMA wal_checkpoint(TRUNCATE)",
    )
    .await;
    let bytes = std::fs::read(&database).unwrap();
    manifest["audit_head"] = Value::Null;
    manifest["files"]["trunnion.sqlite"] = json!({"bytes": bytes.len(), "sha256": sha256_hex(&bytes)});
    std::fs::write(&place, manifest.to_string()).unwrap();
    let refused = trunnion(&restored, &["restore", path(&backup)]);
    assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
    assert!(said(&refused).contains("report has the SHA-256"), "{}", said(&refused));
    assert!(!restored.exists());
}

/// Waits until readiness says this.
async fn until(app: &App, status: &str) -> Value {
    let mut looks = 0;
    loop {
        let body: Value = app.get("/readyz").await.json().await.unwrap();
        if body["status"] == status {
            return body;
        }
        looks += 1;
        assert!(looks < 600, "readiness was never {status}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test]
async fn a_scrub_finds_what_nobody_asks_for_and_forgets_what_is_well_again() {
    if has_no_file("a_scrub_finds_what_nobody_asks_for_and_forgets_what_is_well_again") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |settings| settings.scrub_interval_s = 0.05).await;
    posted(&app).await;
    let blob: PathBuf = files(&data.join("blobs")).pop().unwrap();
    let sound = std::fs::read(&blob).unwrap();
    std::fs::write(&blob, "rotten").unwrap();
    let told = until(&app, "degraded").await;
    assert!(told["reasons"][0].as_str().unwrap().contains("damaged stored files"), "{told}");
    std::fs::write(&blob, &sound).unwrap();
    until(&app, "ready").await;
    let metrics = app.get("/metrics").await.text().await.unwrap();
    assert!(metrics.contains("\ntrunnion_scrub_last_timestamp_seconds "), "{metrics}");
    assert!(metrics.contains("\ntrunnion_scrub_findings 0\n"), "{metrics}");
    let edit = "UPDATE jobs SET report = json_set(report, '$.blocks_out', 1)";
    let pool = open(&data).await;
    execute(&pool, edit).await;
    pool.close().await;
    let told = until(&app, "degraded").await;
    assert!(told["reasons"][0].as_str().unwrap().contains("findings of the last scrub: 1"), "{told}");
    app.stop().await;
}
