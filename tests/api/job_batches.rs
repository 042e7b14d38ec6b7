//! Many programs in one archive: one job for each, all or none.

use std::io::{Cursor, Write};

use reqwest::multipart::{Form, Part};
use reqwest::{Response, StatusCode};
use serde_json::{Value, json};
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

use crate::queue::ended;
use crate::support::{App, pointers, problem, spawn, spawn_with};

const PROGRAM: &str = "G21 G90 G94 G54\nT1 M6\nG1 X10 Y0 Z5 A10 C0 F1000\nX20 Y0 Z5 A10 C20\nM30\n";

pub(crate) fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, text) in files {
        let coded = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        if path.ends_with('/') {
            zip.add_directory(*path, coded).unwrap();
        } else {
            zip.start_file(*path, coded).unwrap();
            zip.write_all(text).unwrap();
        }
    }
    zip.finish().unwrap().into_inner()
}

fn job() -> Value {
    json!({
        "machine_id": "example-ac-table", "operation": "cc-compensation", "external_id": "WO-1",
        "parameters": {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35]},
    })
}

async fn post(app: &App, job: &Value, archive: Vec<u8>, key: Option<&str>) -> Response {
    let form = Form::new()
        .text("job", job.to_string())
        .part("programs", Part::bytes(archive).file_name("programs.zip"));
    let request = app.client.post(app.url("/v1/job-batches")).multipart(form);
    let request = match key {
        Some(key) => request.header("Idempotency-Key", key),
        None => request,
    };
    request.send().await.unwrap()
}

async fn jobs(app: &App) -> Vec<Value> {
    let list: Value = app.get("/v1/jobs?limit=200").await.json().await.unwrap();
    list["items"].as_array().unwrap().clone()
}

#[tokio::test]
async fn each_program_of_an_archive_becomes_a_job_and_ends_as_if_it_had_come_alone() {
    let app = spawn().await;
    let other = PROGRAM.replace("X20", "X30");
    let sent = archive(&[
        ("op20/", b""),
        ("op20/a.nc", PROGRAM.as_bytes()),
        ("__MACOSX/op20/._a.nc", b"\0\x05"),
        ("op20/.DS_Store", b"x"),
        ("op30/a.nc", other.as_bytes()),
        ("./op40/a.nc", other.as_bytes()),
        ("empty.nc", b""),
    ]);
    let answer = post(&app, &job(), sent, None).await;
    assert_eq!(answer.status(), StatusCode::ACCEPTED);
    let batch: Value = answer.json().await.unwrap();
    let items = batch["items"].as_array().unwrap();
    let paths: Vec<_> = items.iter().map(|item| item["path"].as_str().unwrap()).collect();
    assert_eq!(paths, ["op20/a.nc", "op30/a.nc", "./op40/a.nc", "empty.nc"]);
    assert_eq!(batch["left_out"], json!(["__MACOSX/op20/._a.nc", "op20/.DS_Store"]));
    for (item, program) in items.iter().zip([PROGRAM, &other, &other, ""]) {
        assert_eq!(item["job"]["external_id"], "WO-1");
        let id = item["job"]["id"].as_str().unwrap();
        let ended = ended(&app, &format!("/v1/jobs/{id}")).await;
        let alone = app
            .post_text(
                "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&contact=tip&work_offset_mm=12,-7,35",
                "text/plain",
                program.to_owned(),
            )
            .await;
        assert_eq!((alone.status(), &ended["state"]), (StatusCode::OK, &json!("succeeded")));
        let made = app.get(&format!("/v1/jobs/{id}/program")).await;
        let name = made.headers()["content-disposition"].to_str().unwrap().to_owned();
        let file =
            item["path"].as_str().unwrap().rsplit('/').next().unwrap().replace(".nc", "-compensated.nc");
        assert!(name.contains(&format!("\"{file}\"")), "{name}");
        assert_eq!(made.text().await.unwrap(), alone.text().await.unwrap());
    }
}

#[tokio::test]
async fn a_batch_that_is_posted_again_with_its_key_gets_the_same_jobs() {
    let app = spawn().await;
    let sent = archive(&[("a.nc", PROGRAM.as_bytes()), ("b.nc", b"G21\nM30\n")]);
    let first: Value = post(&app, &job(), sent.clone(), Some("K")).await.json().await.unwrap();
    let again: Value = post(&app, &job(), sent.clone(), Some("K")).await.json().await.unwrap();
    let ids = |batch: &Value| -> Vec<Value> {
        batch["items"].as_array().unwrap().iter().map(|item| item["job"]["id"].clone()).collect()
    };
    assert_eq!((ids(&first).len(), ids(&first)), (2, ids(&again)));
    // At the same time too.
    let order = job();
    let (one, two) = tokio::join!(
        post(&app, &order, sent.clone(), Some("L")),
        post(&app, &order, sent.clone(), Some("L"))
    );
    let (one, two): (Value, Value) = (one.json().await.unwrap(), two.json().await.unwrap());
    assert_eq!(ids(&one), ids(&two));
    assert_eq!(jobs(&app).await.len(), 4);
    let mut other = job();
    other["external_id"] = json!("WO-2");
    problem(post(&app, &other, sent.clone(), Some("K")).await, "idempotency-key-reused").await;
    let fewer = archive(&[("a.nc", PROGRAM.as_bytes())]);
    problem(post(&app, &job(), fewer, Some("K")).await, "idempotency-key-reused").await;
    // The longest key is one too.
    let long = "K".repeat(255);
    let first: Value = post(&app, &job(), sent.clone(), Some(&long)).await.json().await.unwrap();
    let again: Value = post(&app, &job(), sent.clone(), Some(&long)).await.json().await.unwrap();
    assert_eq!((ids(&first).len(), ids(&first)), (2, ids(&again)));
    // The key of a single job is no key of a batch, and the other way round.
    let single =
        Form::new().text("job", job().to_string()).part("program", Part::text(PROGRAM).file_name("a.nc"));
    let single = app.client.post(app.url("/v1/jobs")).header("Idempotency-Key", "K").multipart(single);
    problem(single.send().await.unwrap(), "idempotency-key-reused").await;
    assert_eq!(jobs(&app).await.len(), 6);
}

#[tokio::test]
async fn a_batch_is_accepted_whole_or_not_at_all() {
    let app = spawn_with(|settings| settings.max_queued_jobs = 5).await;
    let texts: Vec<_> = (0..6).map(|k| (format!("{k}.nc"), format!("G21\nG1 X{k} F100\nM30\n"))).collect();
    let files: Vec<_> = texts.iter().map(|(path, text)| (path.as_str(), text.as_bytes())).collect();
    let answer = post(&app, &job(), archive(&files), None).await;
    // Five may wait, three quarters of them of one caller: it would never have room.
    let body = problem(answer, "invalid-request").await;
    assert_eq!(pointers(&body), ["/programs"]);
    assert_eq!((jobs(&app).await.len(), app.files()), (0, (0, 0)));
    let damaged = {
        let mut bytes = archive(&files[..3]);
        let at = bytes.windows(4).rposition(|four| four == b"PK\x03\x04").unwrap();
        // A byte of the last program's deflated text.
        bytes[at + 40] ^= 0x10;
        bytes
    };
    let body = problem(post(&app, &job(), damaged, None).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/programs"]);
    assert!(jobs(&app).await.is_empty());
    // What is wrong with one program names it; what is wrong with the parameters is about all of them.
    let app = spawn_with(|settings| settings.max_cost_s = 0.05).await;
    let long = "G1 X1 Y2 Z3 A4 C5 F100\n".repeat(200_000);
    let sent = archive(&[("short.nc", PROGRAM.as_bytes()), ("op20/long.nc", long.as_bytes())]);
    let body = problem(post(&app, &job(), sent, None).await, "too-costly").await;
    assert!(body["detail"].as_str().unwrap().starts_with("op20/long.nc: "), "{body}");
    let mut wrong = job();
    wrong["parameters"]["tolerance_um"] = json!(-1);
    let body = problem(post(&app, &wrong, archive(&files[..3]), None).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/parameters/tolerance_um"]);
    assert!(!body["detail"].as_str().unwrap().contains("0.nc"), "{body}");
    assert_eq!((jobs(&app).await.len(), app.files()), (0, (0, 0)));
}

#[tokio::test]
async fn an_archive_that_is_none_or_holds_too_much_is_refused_with_its_cure() {
    let app = spawn_with(|settings| settings.max_body_bytes = 100_000).await;
    let refused = async |bytes: Vec<u8>, code: &str, word: &str| {
        let body = problem(post(&app, &job(), bytes, None).await, code).await;
        let detail = body["detail"].as_str().unwrap();
        assert!(detail.contains(word), "{detail}");
    };
    refused(b"G21\nM30\n".to_vec(), "invalid-request", "zip").await;
    refused(archive(&[]), "invalid-request", "no program").await;
    refused(archive(&[(".hidden", b"x"), ("folder/", b"")]), "invalid-request", "no program").await;
    let many: Vec<_> = (0..=100).map(|k| format!("{k}.nc")).collect();
    let many: Vec<_> = many.iter().map(|path| (path.as_str(), &b"M30\n"[..])).collect();
    refused(archive(&many), "invalid-request", "100").await;
    let folders: Vec<_> = (0..=1000).map(|k| format!("{k}/")).collect();
    let folders: Vec<_> = folders.iter().map(|path| (path.as_str(), &b""[..])).collect();
    refused(archive(&folders), "invalid-request", "1001").await;
    // A bomb: a hundred kilobytes are the limit, whatever the archive claims.
    refused(
        archive(&[("a.nc", &vec![b' '; 60_000]), ("b.nc", &vec![b' '; 60_000])]),
        "body-too-large",
        "100000",
    )
    .await;
    let mut lying = archive(&[("a.nc", &vec![b' '; 90_000])]);
    let at = lying.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
    lying[at + 24..at + 28].copy_from_slice(&10_u32.to_le_bytes());
    problem(post(&app, &job(), lying, None).await, "invalid-request").await;
    refused(archive(&[("a\u{7}.nc", b"M30\n")]), "invalid-request", "entry 1").await;
    refused(archive(&[(&"a".repeat(501), b"M30\n")]), "invalid-request", "entry 1").await;
    let twice = {
        let mut bytes = archive(&[("a.nc", b"M30\n"), ("b.nc", b"M30\n")]);
        while let Some(at) = bytes.windows(4).position(|four| four == b"b.nc") {
            bytes[at] = b'a';
        }
        bytes
    };
    refused(twice, "invalid-request", "two files").await;
    let encrypted = {
        let mut bytes = archive(&[("a.nc", b"M30\n")]);
        for (mark, flags) in [(b"PK\x03\x04", 6), (b"PK\x01\x02", 8)] {
            let at = bytes.windows(4).position(|four| four == mark).unwrap();
            bytes[at + flags] |= 1;
        }
        bytes
    };
    refused(encrypted, "invalid-request", "encrypted").await;
    // Every cut of an archive is refused.
    let whole = archive(&[("a.nc", PROGRAM.as_bytes()), ("b.nc", b"M30\n")]);
    for length in (0..whole.len()).step_by(7) {
        let answer = post(&app, &job(), whole[..length].to_vec(), None).await;
        assert_eq!(answer.status(), StatusCode::UNPROCESSABLE_ENTITY, "{length}");
    }
    assert!(jobs(&app).await.is_empty());
}

#[tokio::test]
async fn a_batch_reaches_only_the_machines_of_its_key_and_has_no_surface() {
    let mut app = spawn().await;
    let form = Form::new()
        .text("job", job().to_string())
        .part("programs", Part::bytes(archive(&[("a.nc", b"M30\n")])).file_name("p.zip"))
        .part("surface", Part::text("solid\nendsolid\n").file_name("part.stl"));
    let answer = app.client.post(app.url("/v1/job-batches")).multipart(form).send().await.unwrap();
    assert_eq!(pointers(&problem(answer, "invalid-request").await), ["/surface"]);
    app.close().await;
    let key = app.new_key(&["read", "compute"], Some(&["example-bc-table"])).await;
    let form = Form::new()
        .text("job", job().to_string())
        .part("programs", Part::bytes(archive(&[("a.nc", b"M30\n")])).file_name("p.zip"));
    let answer =
        app.client.post(app.url("/v1/job-batches")).bearer_auth(&key).multipart(form).send().await.unwrap();
    problem(answer, "machine-not-found").await;
}
