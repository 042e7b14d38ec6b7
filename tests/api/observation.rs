//! What is seen of requests: metrics, traces, log lines, and what is left when a client leaves.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::io::Read;
use std::process::Stdio;
use std::time::Duration;

use reqwest::multipart::Form;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::process::{address, binary};
use crate::receiver::{Receiver, Reply};
use crate::support::{App, spawn, spawn_with};
use crate::webhooks::{at_once, calling};

const INVERSE: &str = "/v1/machines/example-ac-table/inverse-kinematics";
const CC: &str = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";

async fn metrics(app: &App) -> String {
    app.get("/metrics").await.text().await.unwrap()
}

/// The value of the sample with this name and labels.
fn sample(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))?;
    Some(line.parse().unwrap())
}

#[tokio::test]
async fn the_metrics_are_of_the_form_that_prometheus_reads() {
    let app = spawn().await;
    app.post_json(INVERSE, &json!({"poses": [{"x": 1, "y": 2, "z": 3, "i": 0, "j": 0, "k": 1}]})).await;
    app.post_text(CC, "text/plain", "g1 x1\n").await;
    app.put_machine("mine", &crate::support::ac_table()).await;
    let text = metrics(&app).await;
    let (mut families, mut seen) = (BTreeSet::new(), BTreeSet::new());
    let mut cumulative = (String::new(), 0.0);
    for line in text.lines() {
        if let Some(kind) = line.strip_prefix("# TYPE ") {
            assert!(families.insert(kind.split(' ').next().unwrap().to_owned()), "{line}");
        } else if !line.starts_with('#') {
            let (name, value) = line.rsplit_once(' ').unwrap();
            let value: f64 = value.parse().unwrap();
            assert!(seen.insert(name.to_owned()), "{name} is there twice");
            let family = name.split('{').next().unwrap();
            let stem = ["_bucket", "_sum", "_count"].iter().find_map(|end| family.strip_suffix(end));
            assert!(families.contains(family) || families.contains(stem.unwrap()), "{line}");
            if let Some((series, _)) = name.split_once("le=\"") {
                if cumulative.0 == series {
                    assert!(value >= cumulative.1, "{line}");
                }
                cumulative = (series.to_owned(), value);
            }
        }
    }
    for (name, least) in [
        ("trunnion_poses_total", 1.0),
        ("trunnion_program_blocks_total", 1.0),
        ("trunnion_received_bytes_total", 100.0),
        ("trunnion_sent_bytes_total", 100.0),
        ("trunnion_connections", 1.0),
        ("trunnion_http_requests_in_flight", 1.0),
        ("trunnion_store_read_duration_seconds_count", 1.0),
        ("trunnion_store_write_duration_seconds_count", 1.0),
        ("trunnion_jobs_queued", 0.0),
        ("trunnion_jobs_oldest_queued_seconds", 0.0),
        ("process_resident_memory_bytes", 1e6),
        (concat!("trunnion_build_info{version=\"", env!("CARGO_PKG_VERSION"), "\"}"), 1.0),
    ] {
        assert!(sample(&text, name).is_some_and(|value| value >= least), "{name}\n{text}");
    }
    let count = "trunnion_http_request_duration_seconds_count{operation=\"solve_inverse_kinematics\",method=\"POST\"}";
    assert_eq!(sample(&text, count), Some(1.0));
    let bucket = count.replace("_count{", "_bucket{").replace('}', ",le=\"+Inf\"}");
    assert_eq!(sample(&text, &bucket), Some(1.0));
}

#[tokio::test]
async fn no_client_can_multiply_the_series() {
    let app = spawn().await;
    let series = |text: &str| text.lines().filter(|line| line.contains("operation=\"unmatched\"")).count();
    for turn in 0..3 {
        for k in 0..20 {
            app.get(&format!("/v1/nothing/{turn}-{k}?x={k}")).await;
            let method = reqwest::Method::from_bytes(format!("BREW{turn}X{k}").as_bytes()).unwrap();
            app.client.request(method, app.url("/v1/machines")).send().await.unwrap();
        }
        let text = metrics(&app).await;
        // GET with 404, others with 404 or 405, and both with their histograms of 22 lines.
        assert!(series(&text) <= 3 + 2 * 22, "{text}");
        assert!(!text.contains("BREW") && !text.contains("nothing"), "{text}");
    }
    let name = "trunnion_http_requests_total{operation=\"unmatched\",method=\"GET\",status=\"404\"}";
    assert_eq!(sample(&metrics(&app).await, name), Some(60.0));
}

#[tokio::test]
async fn a_trace_comes_back_with_a_span_of_its_own() {
    let app = spawn().await;
    let trace = "4bf92f3577b34da6a3ce929d0e0e4736";
    let ask = async |value: String| {
        let request = app.client.get(app.url("/v1/nothing")).header("traceparent", value);
        let answer = request.send().await.unwrap();
        answer.headers()["traceresponse"].to_str().unwrap().to_owned()
    };
    let first = ask(format!("00-{trace}-00f067aa0ba902b7-01")).await;
    let second = ask(format!("00-{trace}-00f067aa0ba902b7-00")).await;
    assert!(first.starts_with(&format!("00-{trace}-")) && first.ends_with("-01"), "{first}");
    assert!(second.starts_with(&format!("00-{trace}-")) && second.ends_with("-00"), "{second}");
    let span = |text: &str| text.split('-').nth(2).unwrap().to_owned();
    assert_ne!(span(&first), span(&second));
    assert_ne!(span(&first), "00f067aa0ba902b7");
    // What is not of the form counts as none.
    for bad in ["00-zz-11-01".to_owned(), "x".repeat(3000), format!("ff-{trace}-00f067aa0ba902b7-01")] {
        let found = ask(bad).await;
        assert_eq!(found.len(), 55);
        assert!(!found.contains(trace), "{found}");
    }
}

/// A client whose request has the only place; none where another one was faster, so that it was refused.
async fn holding(app: &App) -> Option<TcpStream> {
    let mut socket = TcpStream::connect(app.base.trim_start_matches("http://")).await.unwrap();
    let request = format!("POST {CC} HTTP/1.1\r\nHost: x\r\nContent-Length: 5\r\n\r\nWAIT\n");
    socket.write_all(request.as_bytes()).await.unwrap();
    loop {
        if app.post_text(CC, "text/plain", "g1\n").await.status() == 503 {
            return Some(socket);
        }
        if socket.try_read(&mut [0; 64]).is_ok() {
            return None;
        }
    }
}

#[tokio::test]
async fn a_client_that_leaves_is_counted_and_its_place_is_free() {
    let app = spawn_with(|settings| {
        settings.max_computations = 1;
        settings.max_waiting_computations = 0;
    })
    .await;
    let held = loop {
        if let Some(socket) = holding(&app).await {
            break socket;
        }
    };
    drop(held);
    while app.post_text(CC, "text/plain", "g1\n").await.status() != 200 {}
    let left = sample(&metrics(&app).await, "trunnion_http_requests_abandoned_total");
    assert!(left.is_some_and(|count| count >= 1.0), "{left:?}");
    assert_eq!(app.files().1, 0);
}

#[tokio::test]
async fn a_client_that_takes_nothing_of_its_answer_is_left() {
    let app = spawn_with(|settings| {
        settings.answer_pause_timeout_s = 0.1;
        settings.max_connections = 1;
    })
    .await;
    // An answer of some ten megabytes, more than the sockets of both sides hold.
    let mut body = String::from("x,y,z,i,j,k\n");
    for k in 0..200_000 {
        writeln!(body, "{k}.125,20.25,30.5,0.1,-0.2,0.97").unwrap();
    }
    let address = app.base.trim_start_matches("http://").to_owned();
    let mut socket = TcpStream::connect(&address).await.unwrap();
    let head = format!(
        "POST {INVERSE} HTTP/1.1\r\nHost: x\r\nContent-Type: text/csv\r\nContent-Length: {}\r\n\r\n",
        body.len()
    );
    socket.write_all(head.as_bytes()).await.unwrap();
    socket.write_all(body.as_bytes()).await.unwrap();
    // The only place for a connection is free again although this one is still open.
    let limit = Duration::from_mins(1);
    let again = tokio::time::timeout(limit, async {
        loop {
            if let Ok(answer) = app.client.get(app.url("/healthz")).send().await {
                return answer.status();
            }
        }
    });
    assert_eq!(again.await.unwrap(), 200);
    drop(socket);
}

#[tokio::test]
async fn a_posted_job_hands_its_trace_on_to_whom_it_tells() {
    let app = spawn_with(at_once).await;
    let mut receiver = Receiver::saying(&[Reply::Status(500, "")]).await;
    let program = reqwest::multipart::Part::text("g1\n").file_name("a.nc");
    let form = Form::new().text("job", calling(&receiver.url()).to_string()).part("program", program);
    let trace = "4bf92f3577b34da6a3ce929d0e0e4736";
    let posted = app.client.post(app.url("/v1/jobs")).multipart(form);
    let posted =
        posted.header("traceparent", format!("00-{trace}-00f067aa0ba902b7-00")).send().await.unwrap();
    assert_eq!(posted.status(), 202);
    // Under the span that the answer names, however often it is told.
    let ours = posted.headers()["traceresponse"].to_str().unwrap();
    assert!(ours.starts_with(&format!("00-{trace}-")) && ours.ends_with("-00"), "{ours}");
    for _ in 0..2 {
        assert_eq!(receiver.next().await.headers["traceparent"], ours);
    }
}

/// The log of a service that was asked some things, line by line.
pub(crate) async fn log_of(level: &str, ask: impl AsyncFnOnce(&str)) -> Vec<Value> {
    let data = TempDir::new().unwrap();
    let mut child = binary(&data)
        .args(["--listen", "127.0.0.1:0", "--log-format", "json", "--log", level])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let base = format!("http://{}", address(&mut child));
    ask(&base).await;
    let told = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(told.success());
    assert!(child.wait().unwrap().success());
    let mut text = String::new();
    child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

pub(crate) fn answered<'a>(lines: &'a [Value], request_id: &str) -> &'a Value {
    let of = |line: &&Value| {
        line["span"]["client_request_id"] == request_id && line["fields"]["message"] == "answered"
    };
    let found: Vec<&Value> = lines.iter().filter(of).collect();
    assert_eq!(found.len(), 1, "{lines:#?}");
    found[0]
}

#[tokio::test]
async fn every_request_has_one_log_line_without_secrets() {
    let trace = "4bf92f3577b34da6a3ce929d0e0e4736";
    let lines = log_of("info", async |base| {
        let client = reqwest::Client::builder().no_proxy().build().unwrap();
        let url = |path: &str| format!("{base}{path}");
        let send = async |request: reqwest::RequestBuilder, id: &str| {
            let request = request.header("x-request-id", id).header("authorization", "Bearer sesame-4711");
            request.send().await.unwrap().status()
        };
        let put = client
            .put(url("/v1/machines/mine"))
            .header("traceparent", format!("00-{trace}-00f067aa0ba902b7-01"))
            .json(&crate::support::ac_table());
        assert_eq!(send(put, "one").await, 201);
        assert_eq!(send(client.get(url("/v1/machines/mine?token=sesame-4712")), "two").await, 422);
        let program = client.post(url(CC)).body("G1 G90 X1 Y1 Z1 A0 C0 F100 (sesame-4713)\nX2\n");
        assert_eq!(send(program, "three").await, 200);
    })
    .await;
    let one = answered(&lines, "one");
    assert_eq!(one["level"], "INFO");
    assert_eq!(one["fields"]["status"], 201);
    assert!(one["fields"]["elapsed_ms"].is_number());
    assert_eq!(one["span"]["operation"], "put_machine");
    assert_eq!(one["span"]["machine_id"], "mine");
    assert_eq!(one["span"]["trace_id"], trace);
    let two = answered(&lines, "two");
    assert_eq!((&two["level"], &two["fields"]["status"]), (&json!("WARN"), &json!(422)));
    assert_eq!(two["span"]["operation"], "get_machine");
    let three = answered(&lines, "three");
    assert_eq!(three["span"]["machine_id"], "example-ac-table");
    assert_eq!(three["span"]["job_id"].as_str().unwrap().len(), 36);
    let all = lines.iter().map(Value::to_string).collect::<String>();
    assert!(!all.contains("sesame"), "{all}");
}

#[tokio::test]
async fn a_quiet_log_still_names_the_request_of_a_refusal() {
    let lines = log_of("warn", async |base| {
        let client = reqwest::Client::builder().no_proxy().build().unwrap();
        for (path, id) in [("/healthz", "fine"), ("/v1/nothing", "bad")] {
            client.get(format!("{base}{path}")).header("x-request-id", id).send().await.unwrap();
        }
    })
    .await;
    assert!(lines.iter().all(|line| line["span"]["client_request_id"] != "fine"), "{lines:#?}");
    assert_eq!(answered(&lines, "bad")["level"], "WARN");
}
