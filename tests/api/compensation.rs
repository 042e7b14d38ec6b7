//! The compensation's plumbing: uploads, parameters, answers, keys. What is computed is tested elsewhere.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::database;
use crate::support::{App, pointers, problem, spawn, spawn_with};

const PATH: &str = "/v1/machines/example-ac-table/cc-compensation";
const GOOD: &str = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";

async fn jobs(app: &App) -> Vec<Value> {
    let list: Value = app.get("/v1/jobs").await.json().await.unwrap();
    list["items"].as_array().unwrap().clone()
}

#[tokio::test]
async fn a_program_comes_back_and_is_kept_as_a_job() {
    let app = spawn().await;
    let response = app.post_text(GOOD, "text/plain", "g1 x1\r\ng1 y2").await;
    assert_eq!(response.status(), 200);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let tag = response.headers()["etag"].to_str().unwrap().to_owned();
    let name = response.headers()["content-disposition"].to_str().unwrap().to_owned();
    assert!(name.starts_with("attachment; filename=\"") && name.ends_with("-compensated.nc\""), "{name}");
    assert_eq!(response.text().await.unwrap(), "G1 X1\r\nG1 Y2");
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["state"], "succeeded");
    assert_eq!(document["machine_revision"], 1);
    assert_eq!(document["operation"], "cc-compensation");
    assert_eq!(document["parameters"]["tolerance_um"], 10.0);
    assert_eq!(tag, format!("\"{}\"", document["output_sha256"].as_str().unwrap()));
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    for name in ["machine_revision", "software_version", "input_sha256", "output_sha256"] {
        assert_eq!(report[name], document[name], "{name}");
    }
    assert_eq!(report["blocks_in"], 2);
    assert_eq!(app.files(), (2, 0));
}

#[tokio::test]
async fn accept_chooses_program_report_or_plot() {
    let app = spawn().await;
    for (accept, kind) in [
        ("*/*", "text/plain"),
        ("application/json", "application/json"),
        ("image/svg+xml", "image/svg+xml"),
        ("image/*;q=0.9, text/*;q=0.8", "image/svg+xml"),
        ("application/octet-stream", "application/octet-stream"),
    ] {
        let request = app.client.post(app.url(GOOD)).header("accept", accept).body("g1\n");
        let response = request.send().await.unwrap();
        assert_eq!(response.headers()["content-type"], kind, "{accept}");
        assert!(response.headers().contains_key("location") && response.headers().contains_key("etag"));
    }
    let request = app.client.post(app.url(GOOD)).header("accept", "text/html").body("g1\n");
    problem(request.send().await.unwrap(), "not-acceptable").await;
    assert_eq!(jobs(&app).await.len(), 5);
}

#[tokio::test]
async fn bodies_of_every_kind_are_taken() {
    let app = spawn().await;
    for kind in ["text/plain", "text/x-gcode", "application/octet-stream", "TEXT/plain; charset=latin1"] {
        assert_eq!(app.post_text(GOOD, kind, "g1\n").await.text().await.unwrap(), "G1\n", "{kind}");
    }
    let untyped = app.client.post(app.url(GOOD)).body("g1\n").send().await.unwrap();
    assert_eq!(untyped.text().await.unwrap(), "G1\n");
    for kind in ["application/json", "image/png", "application/x-www-form-urlencoded", "nonsense"] {
        problem(app.post_text(GOOD, kind, "g1\n").await, "unsupported-media-type").await;
    }
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(b"g1 x3\n").unwrap();
    let gzip = gzip.finish().unwrap();
    let coded = |coding: &'static str, body: Vec<u8>| {
        app.client.post(app.url(GOOD)).header("content-encoding", coding).body(body).send()
    };
    for coding in ["gzip", "GZIP", "x-gzip", "X-GZip"] {
        let text = coded(coding, gzip.clone()).await.unwrap().text().await.unwrap();
        assert_eq!(text, "G1 X3\n", "{coding}");
    }
    problem(coded("gzip", gzip[..gzip.len() - 9].to_vec()).await.unwrap(), "malformed-request").await;
    problem(coded("gzip", b"g1 x3\n".to_vec()).await.unwrap(), "malformed-request").await;
    // A zstd frame of one raw block: magic, one-byte content size, block header, text.
    let zstd = [b"\x28\xB5\x2F\xFD\x20\x06\x31\x00\x00".as_slice(), b"g1 x3\n"].concat();
    assert_eq!(coded("Zstd", zstd.clone()).await.unwrap().text().await.unwrap(), "G1 X3\n");
    problem(coded("zstd", zstd[..10].to_vec()).await.unwrap(), "malformed-request").await;
    let other = coded("br", gzip).await.unwrap();
    assert!(other.headers().contains_key("accept-encoding"));
    problem(other, "unsupported-media-type").await;
}

#[tokio::test]
async fn a_form_brings_parameters_and_program() {
    let app = spawn().await;
    let send = |form: Form| app.client.post(app.url(PATH)).multipart(form).send();
    let program = || Part::bytes(b"g1\n".as_slice()).file_name("C:\\jobs\\blade 7.mpf");
    let parameters = json!({"tool_radius_mm": 5, "work_offset_mm": [70, -40, 95]}).to_string();
    let response =
        send(Form::new().text("parameters", parameters.clone()).part("program", program())).await.unwrap();
    assert_eq!(response.status(), 200);
    assert_eq!(response.headers()["content-disposition"], "attachment; filename=\"blade_7-compensated.mpf\"");
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["parameters"]["work_offset_mm"], json!([70.0, -40.0, 95.0]));

    let missing = send(Form::new().text("parameters", parameters.clone())).await.unwrap();
    assert_eq!(pointers(&problem(missing, "invalid-request").await), ["/program"]);
    let unknown = Form::new().text("parameter", parameters.clone()).part("program", program());
    assert_eq!(pointers(&problem(send(unknown).await.unwrap(), "invalid-request").await), ["/parameter"]);
    let broken = Form::new().text("parameters", "{").part("program", program());
    problem(send(broken).await.unwrap(), "unreadable-json").await;
    let misspelt = Form::new().text("parameters", "{\"tool_radius\": 5}").part("program", program());
    assert_eq!(pointers(&problem(send(misspelt).await.unwrap(), "invalid-request").await), ["/tool_radius"]);
    let both = app
        .client
        .post(app.url(GOOD))
        .multipart(Form::new().text("parameters", parameters).part("program", program()));
    assert_eq!(pointers(&problem(both.send().await.unwrap(), "invalid-request").await), ["/parameters"]);
    let cut =
        app.post_text(PATH, "multipart/form-data; boundary=x", "--x\r\nContent-Disposition: form-da").await;
    problem(cut, "malformed-request").await;
    assert_eq!(jobs(&app).await.len(), 1);
    assert_eq!(app.files().1, 0);
}

#[tokio::test]
async fn bad_parameters_are_named() {
    let app = spawn().await;
    for (query, expected) in [
        ("", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=0", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=-5", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=NaN", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=inf", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=1e308", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=five", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=5&tool_radius_mm=5", vec!["/tool_radius_mm"]),
        ("tool_radius_mm=5&corner_radius_mm=6", vec!["/corner_radius_mm"]),
        ("tool_radius_mm=5&corner_radius_mm=-1", vec!["/corner_radius_mm"]),
        ("tool_radius_mm=5&tolerance_um=0", vec!["/tolerance_um"]),
        ("tool_radius_mm=5&tolerance_um=-0&feed_mm_per_min=0", vec!["/tolerance_um", "/feed_mm_per_min"]),
        ("tool_radius_mm=5&tolerance=10", vec!["/tolerance"]),
        ("tool_radius_mm=5&contact=surfaces", vec!["/contact"]),
        ("tool_radius_mm=5&output=Minimal", vec!["/output"]),
        ("tool_radius_mm=5&work_offset_mm=1,2", vec!["/work_offset_mm"]),
        ("tool_radius_mm=5&work_offset_mm=1,2,3,4", vec!["/work_offset_mm"]),
        ("tool_radius_mm=5&work_offset_mm=1,x,3", vec!["/work_offset_mm/1"]),
        ("tool_radius_mm=5&work_offset_mm=1,2,1e9", vec!["/work_offset_mm/2"]),
        ("tool_radius_mm.x=5", vec!["/tool_radius_mm"]),
        ("nominal_tool.radius_mm=5", vec!["/nominal_tool"]),
    ] {
        let response = app.post_text(&format!("{PATH}?{query}"), "text/plain", "g1\n").await;
        let body = problem(response, "invalid-request").await;
        assert_eq!(pointers(&body), expected, "{query}: {body}");
    }
    assert!(jobs(&app).await.is_empty());
    assert_eq!(app.files(), (0, 0));
    let tip = app.post_text(&format!("{PATH}?contact=tip"), "text/plain", "g1\n").await;
    assert_eq!(tip.status(), 200);
}

#[tokio::test]
async fn a_refused_program_names_its_line_and_stores_nothing() {
    let app = spawn().await;
    for (word, code) in [
        ("REFUSE me", "program-fault"),
        ("TOLERANCE", "tolerance-out-of-reach"),
        ("TRAVEL", "out-of-travel"),
        ("COST", "too-costly"),
    ] {
        let response = app.post_text(GOOD, "text/plain", format!("g1\n{word}\n")).await;
        let body = problem(response, code).await;
        assert_eq!((&body["line"], &body["block"]), (&json!(2), &json!(word)));
        assert_eq!(pointers(&body), ["/program"]);
    }
    assert!(jobs(&app).await.is_empty());
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_machine_that_is_not_there_is_not_found() {
    let app = spawn().await;
    let path = "/v1/machines/none/cc-compensation?tool_radius_mm=5";
    problem(app.post_text(path, "text/plain", "g1\n").await, "machine-not-found").await;
}

#[tokio::test]
async fn a_key_gives_the_same_answer_again() {
    let app = spawn().await;
    let send = |path: &str, key: &str, body: &str| {
        let request = app.client.post(app.url(path)).header("idempotency-key", key).body(body.to_owned());
        async move { request.send().await.unwrap() }
    };
    let first = send(GOOD, "k1", "g1\n").await;
    let again = send(GOOD, "k1", "g1\n").await;
    assert_eq!(first.headers()["location"], again.headers()["location"]);
    assert_eq!(first.headers()["etag"], again.headers()["etag"]);
    assert_eq!(first.text().await.unwrap(), again.text().await.unwrap());
    problem(send(GOOD, "k1", "g2\n").await, "idempotency-key-reused").await;
    problem(send(&format!("{GOOD}&tolerance_um=5"), "k1", "g1\n").await, "idempotency-key-reused").await;
    assert_ne!(send(GOOD, "k2", "g1\n").await.headers()["location"], again_location(&app).await);
    for key in ["", "x y\u{e9}", &"k".repeat(256)] {
        problem(send(GOOD, key, "g1\n").await, "malformed-request").await;
    }
    assert_eq!(jobs(&app).await.len(), 2);
    // Four at once under one key: one job.
    let together = futures::future::join_all((0..4).map(|_| send(GOOD, "k3", "g4\n"))).await;
    let mut places: Vec<_> = together.iter().map(|response| response.headers()["location"].clone()).collect();
    places.dedup();
    assert_eq!(places.len(), 1);
    assert_eq!(jobs(&app).await.len(), 3);
}

#[tokio::test]
async fn a_key_is_forgotten_after_its_time() {
    // The clock of tests goes on by a second whenever it is looked at.
    let app = spawn_with(|settings| settings.idempotency_retention_s = 10.0).await;
    let send = |key: &str, body: &str| {
        let request = app.client.post(app.url(GOOD)).header("idempotency-key", key).body(body.to_owned());
        async move { request.send().await.unwrap().headers()["location"].clone() }
    };
    let first = send("k", "g1\n").await;
    assert_eq!(send("k", "g1\n").await, first);
    let mut asked = 0;
    while send("k", "g1\n").await == first {
        asked += 1;
        assert!(asked < 20, "the key is never forgotten");
    }
    assert_eq!(jobs(&app).await.len(), 2);
    // A forgotten key may name another request; old keys go with the next one that is stored.
    for count in 0..30 {
        send(&format!("k{count}"), "g2\n").await;
    }
    send("k", "g3\n").await;
    let kept = database::value(&app.data, "SELECT CAST(COUNT(*) AS TEXT) FROM idempotency_keys").await;
    assert!((1..10).contains(&kept.parse::<i64>().unwrap()), "{kept} keys are kept");
}

#[tokio::test]
async fn a_key_of_a_clock_that_was_far_ahead_is_forgotten_as_well() {
    let app = spawn_with(|settings| settings.idempotency_retention_s = 10.0).await;
    let send = async |key: &str| {
        let request = app.client.post(app.url(GOOD)).header("idempotency-key", key).body("g1\n");
        request.send().await.unwrap().headers()["location"].clone()
    };
    let first = send("ahead").await;
    let ahead = "UPDATE idempotency_keys SET created_at = '2090-01-01T00:00:00.000Z'";
    assert_eq!(database::change(&app.data, ahead).await, Ok(1));
    // It may also be now that the clock is behind: until a retention has passed, nothing is done to it.
    assert_eq!(send("ahead").await, first);
    // The clock of tests goes on by a second whenever it is looked at.
    for count in 0..30 {
        send(&format!("k{count}")).await;
    }
    let far = "SELECT CAST(COUNT(*) AS TEXT) FROM idempotency_keys WHERE created_at > '2030'";
    assert_eq!(database::value(&app.data, far).await, "0");
    assert_ne!(send("ahead").await, first);
}

async fn again_location(app: &App) -> String {
    format!("/v1/jobs/{}", jobs(app).await.last().unwrap()["id"].as_str().unwrap())
}
