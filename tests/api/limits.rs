//! Limits: at, one past, absurd; and bodies that do not end as they should.

use std::io::Write;
use std::time::Duration;

use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use futures::stream;
use reqwest::Body;
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::support::{problem, spawn, spawn_with};

const PATH: &str = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";

/// `X` over and over, made as it is sent.
fn endless(bytes: usize) -> Body {
    let chunk = Bytes::from(vec![b'X'; 64 * 1024]);
    let chunks = (0..bytes / chunk.len()).map(move |_| Ok::<_, std::io::Error>(chunk.clone()));
    Body::wrap_stream(stream::iter(chunks))
}

#[tokio::test]
async fn a_program_at_the_limit_is_taken_and_one_byte_more_is_not() {
    let app = spawn_with(|settings| settings.max_body_bytes = 1 << 20).await;
    let program = "X".repeat(1 << 20);
    assert_eq!(app.post_text(PATH, "text/plain", program.clone()).await.status(), 200);
    problem(app.post_text(PATH, "text/plain", program.clone() + "X").await, "body-too-large").await;
    let chunked = Body::wrap_stream(stream::iter([Ok::<_, std::io::Error>(program), Ok("X".to_owned())]));
    problem(app.post_text(PATH, "text/plain", chunked).await, "body-too-large").await;
    assert_eq!(app.files().1, 0);
}

#[tokio::test]
async fn a_gigabyte_of_one_letter_is_refused_and_leaves_nothing() {
    let app = spawn_with(|settings| settings.max_body_bytes = 8 << 20).await;
    // The service may answer and close while the rest is still being sent; then sending fails instead.
    let sent = app.client.post(app.url(PATH)).body(endless(1 << 30)).send().await;
    if let Ok(response) = sent {
        problem(response, "body-too-large").await;
    }
    assert_eq!(app.files(), (0, 0));
    assert_eq!(app.get("/readyz").await.status(), 200);
}

#[tokio::test]
async fn the_limit_counts_after_decompression() {
    let app = spawn_with(|settings| settings.max_body_bytes = 1 << 20).await;
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    for _ in 0..64 {
        gzip.write_all(&vec![b'X'; 1 << 20]).unwrap();
    }
    let bomb = gzip.finish().unwrap();
    assert!(bomb.len() < 100_000);
    let request = app.client.post(app.url(PATH)).header("content-encoding", "gzip").body(bomb);
    problem(request.send().await.unwrap(), "body-too-large").await;
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn json_at_the_limit_is_taken_and_one_byte_more_is_not() {
    let text = json!({"poses": []}).to_string();
    let app = spawn_with(|settings| settings.max_json_bytes = text.len() as u64).await;
    let path = "/v1/machines/example-ac-table/inverse-kinematics";
    assert_eq!(app.post_text(path, "application/json", text.clone()).await.status(), 200);
    problem(app.post_text(path, "application/json", text + " ").await, "body-too-large").await;
}

#[tokio::test]
async fn parameters_beside_a_program_have_a_limit_of_their_own() {
    let text = json!({"tool_radius_mm": 5}).to_string();
    let app = spawn_with(|settings| settings.max_parameters_bytes = text.len() as u64).await;
    let send = |path: &'static str, field: &'static str, text: String| {
        let program = reqwest::multipart::Part::text("G1 X1 Y1 Z1 A0 C0 F100\n").file_name("a.nc");
        let form = reqwest::multipart::Form::new().text(field, text).part("program", program);
        app.client.post(app.url(path)).multipart(form).send()
    };
    let path = "/v1/machines/example-ac-table/cc-compensation";
    assert_eq!(send(path, "parameters", text.clone()).await.unwrap().status(), 200);
    for (path, field, bytes) in [
        (path, "parameters", 1),
        (path, "parameters", 100_000),
        ("/v1/jobs", "job", 1),
        ("/v1/jobs", "job", 100_000),
    ] {
        let over = text.clone() + &" ".repeat(bytes);
        problem(send(path, field, over).await.unwrap(), "body-too-large").await;
    }
}

#[tokio::test]
async fn a_computation_over_the_cost_limit_is_refused_before_it_starts() {
    let app = spawn_with(|settings| settings.max_cost_s = 1e-6).await;
    problem(app.post_text(PATH, "text/plain", "WAIT\n".repeat(100)).await, "too-costly").await;
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_full_pool_answers_busy() {
    let app = spawn_with(|settings| {
        settings.max_computations = 1;
        settings.max_waiting_computations = 0;
        settings.request_timeout_s = 1.0;
    })
    .await;
    // Whichever of the two comes first takes the only place: ask again until it was the one that waits.
    for _ in 0..20 {
        let held = app.post_text(PATH, "text/plain", "WAIT\n");
        tokio::pin!(held);
        let busy = loop {
            tokio::select! {
                biased;
                ended = &mut held => break Err(ended),
                other = app.post_text(PATH, "text/plain", "g1\n") => {
                    // On a machine that has much else to do it may have taken too long instead.
                    if other.status() == 503 {
                        let refused: serde_json::Value = other.json().await.unwrap();
                        if refused["type"] == "/problems/busy" {
                            break Ok(());
                        }
                        assert_eq!(refused["type"], "/problems/timed-out");
                    }
                }
            }
        };
        if busy.is_ok() {
            problem(held.await, "timed-out").await;
            return;
        }
    }
    panic!("the pool of one was never full");
}

#[tokio::test]
async fn a_body_that_stops_coming_is_given_up() {
    let app = spawn_with(|settings| settings.body_pause_timeout_s = 0.1).await;
    let pending = stream::iter([Ok::<_, std::io::Error>("G1")]);
    let body = Body::wrap_stream(futures::StreamExt::chain(pending, stream::pending()));
    problem(app.post_text(PATH, "text/plain", body).await, "request-timeout").await;
    assert_eq!(app.files(), (0, 0));
}

async fn raw(app: &crate::support::App, text: &str, close: bool) -> String {
    let mut socket = TcpStream::connect(app.base.trim_start_matches("http://")).await.unwrap();
    // The service may have closed before all of it was sent.
    drop(socket.write_all(text.as_bytes()).await);
    if close {
        socket.shutdown().await.unwrap();
    }
    let mut answer = String::new();
    // A reset ends the reading as well.
    drop(tokio::time::timeout(Duration::from_secs(10), socket.read_to_string(&mut answer)).await.unwrap());
    answer
}

#[tokio::test]
async fn a_truncated_upload_stores_nothing() {
    let app = spawn().await;
    let request = format!("POST {PATH} HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nG1 X1\n");
    let answer = raw(&app, &request, true).await;
    assert!(answer.is_empty() || answer.contains("malformed-request"), "{answer}");
    assert_eq!(app.files(), (0, 0));
    let jobs: serde_json::Value = app.get("/v1/jobs").await.json().await.unwrap();
    assert_eq!(jobs["items"], json!([]));
}

#[tokio::test]
async fn a_header_that_does_not_end_closes_the_connection() {
    let app = spawn_with(|settings| settings.header_timeout_s = 0.1).await;
    let answer = raw(&app, "GET /healthz HTTP/1.1\r\nHost: x\r\nX-Slow: ", false).await;
    assert!(!answer.contains("200 OK"), "{answer}");
    // Nor does silence hold one, nor what may become either version of the protocol.
    for beginning in ["", "P", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r"] {
        let answer = raw(&app, beginning, false).await;
        assert!(answer.is_empty(), "{beginning:?}: {answer}");
    }
}

#[tokio::test]
async fn connections_over_the_cap_are_closed_and_the_service_goes_on() {
    let app = spawn_with(|settings| settings.max_connections = 2).await;
    let address = app.base.trim_start_matches("http://").to_owned();
    let held = [TcpStream::connect(&address).await.unwrap(), TcpStream::connect(&address).await.unwrap()];
    let mut third = TcpStream::connect(&address).await.unwrap();
    let mut rest = Vec::new();
    let ended = tokio::time::timeout(Duration::from_secs(10), third.read_to_end(&mut rest)).await;
    assert!(ended.is_ok() && rest.is_empty());
    drop(held);
    loop {
        if app.client.get(app.url("/healthz")).send().await.is_ok_and(|response| response.status() == 200) {
            break;
        }
    }
}

#[tokio::test]
async fn every_limit_is_listed_with_its_value_and_its_answer() {
    let app = spawn_with(|settings| settings.max_json_bytes = 12_345).await;
    let list: serde_json::Value = app.get("/v1/limits").await.json().await.unwrap();
    let items = list["items"].as_array().unwrap();
    let of = |name: &str| items.iter().find(|item| item["setting"] == name).unwrap();
    assert_eq!(of("max_json_bytes")["value"], 12_345.0);
    assert_eq!(of("max_json_bytes")["status"], 413);
    assert_eq!(of("max_connections")["problem"], serde_json::Value::Null);
    for (setting, environment) in trunnion::config::ENVIRONMENT {
        let limits =
            setting.starts_with("max_") || (setting.ends_with("timeout_s") && *setting != "drain_timeout_s");
        let listed = items.iter().find(|item| item["setting"] == *setting);
        assert_eq!(listed.is_some(), limits, "{setting}");
        if let Some(item) = listed {
            assert_eq!(item["environment"], *environment);
            assert!(item["meaning"].as_str().unwrap().len() > 10, "{item}");
            if let Some(page) = item["problem"].as_str() {
                assert_eq!(app.get(page).await.status(), 200, "{page}");
            }
        }
    }
}

#[tokio::test]
async fn a_caller_over_its_rate_waits_and_a_monitor_does_not() {
    // One place comes back in an hour: no test waits for it.
    let app = spawn_with(|settings| {
        settings.max_rate_per_s = 1.0 / 3600.0;
        settings.max_burst_requests = 5;
    })
    .await;
    for _ in 0..5 {
        assert_eq!(app.get("/v1/version").await.status(), 200);
    }
    for path in ["/v1/version", "/v1/machines", "/v1/nothing"] {
        let refused = app.get(path).await;
        let wait_s: u64 = refused.headers()["retry-after"].to_str().unwrap().parse().unwrap();
        assert!((3000..=3600).contains(&wait_s), "{wait_s}");
        problem(refused, "too-many-requests").await;
    }
    for path in ["/healthz", "/readyz", "/metrics"] {
        for _ in 0..10 {
            assert_eq!(app.get(path).await.status(), 200, "{path}");
        }
    }
}

#[tokio::test]
async fn no_rate_is_no_limit() {
    let app = spawn_with(|settings| {
        settings.max_rate_per_s = 0.0;
        settings.max_burst_requests = 1;
    })
    .await;
    for _ in 0..20 {
        assert_eq!(app.get("/v1/version").await.status(), 200);
    }
}

#[tokio::test]
async fn an_address_at_the_limit_is_taken_one_byte_more_is_not_and_an_absurd_one_neither() {
    let app = spawn_with(|settings| settings.max_url_bytes = 200).await;
    let path = |length: usize| format!("/v1/machines?limit=1{}", "0".repeat(length - 20));
    // Over 200 machines at a time is refused, but read.
    problem(app.get(&path(200)).await, "invalid-request").await;
    problem(app.get(&path(201)).await, "url-too-long").await;
    problem(app.get(&path(20_000)).await, "url-too-long").await;
    let absurd = format!("GET /{} HTTP/1.1\r\nHost: x\r\n\r\n", "a".repeat(10 << 20));
    let answer = raw(&app, &absurd, false).await;
    assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 4"), "{answer}");
    assert_eq!(app.get("/readyz").await.status(), 200);
}

#[tokio::test]
async fn a_header_at_the_limit_is_taken_one_byte_more_is_not_and_an_absurd_one_neither() {
    let app = spawn_with(|settings| settings.max_header_bytes = 1024).await;
    // `Host: x` is 4 + 1 + 4 bytes, `Connection: close` 10 + 5 + 4, `X-Filler` 8 + 4 and its value.
    let request = |filler: usize| {
        let filler = "f".repeat(filler);
        format!("GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\nX-Filler: {filler}\r\n\r\n")
    };
    let rest = 1024 - 9 - 19 - 12;
    assert!(raw(&app, &request(rest), false).await.starts_with("HTTP/1.1 200"));
    let refused = raw(&app, &request(rest + 1), false).await;
    assert!(
        refused.starts_with("HTTP/1.1 431") && refused.contains("/problems/header-too-large"),
        "{refused}"
    );
    let absurd = raw(&app, &request(10 << 20), false).await;
    assert!(absurd.is_empty() || absurd.starts_with("HTTP/1.1 4"), "{absurd}");
    assert_eq!(app.get("/readyz").await.status(), 200);
}

#[tokio::test]
async fn what_the_protocol_refuses_has_a_status_and_no_body() {
    let app = spawn().await;
    let fields = |count: usize| {
        let more = "X: a\r\n".repeat(count - 2);
        format!("GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n{more}\r\n")
    };
    assert!(raw(&app, &fields(100), false).await.starts_with("HTTP/1.1 200"));
    let path = |bytes: usize| format!("GET /{} HTTP/1.1\r\nHost: x\r\n\r\n", "a".repeat(bytes));
    for (request, status) in [
        (fields(101), "431"),
        (path(65_534), "414"),
        ("GET healthz\r\n\r\n".to_owned(), "400"),
        ("GET /healthz HTTP/1.1\r\nHost: x\r\nX Y: a\r\n\r\n".to_owned(), "400"),
        (
            "GET /healthz HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\nContent-Length: 4\r\n\r\n".to_owned(),
            "400",
        ),
    ] {
        let answer = raw(&app, &request, false).await;
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{status}: {answer}");
        assert!(answer.contains("content-length: 0") && answer.ends_with("\r\n\r\n"), "{status}: {answer}");
    }
}

#[tokio::test]
async fn a_result_at_the_limit_is_stored_and_one_byte_more_is_not() {
    let app = spawn_with(|settings| settings.max_result_bytes = 1000).await;
    let program = |bytes: usize| "x".repeat(bytes - 1) + "\n";
    assert_eq!(app.post_text(PATH, "text/plain", program(1000)).await.status(), 200);
    let kept = app.files();
    problem(app.post_text(PATH, "text/plain", program(1001)).await, "result-too-large").await;
    problem(app.post_text(PATH, "text/plain", program(4 << 20)).await, "result-too-large").await;
    assert_eq!(app.files(), kept);
}

#[tokio::test]
async fn an_answer_at_the_limit_is_given_and_one_past_it_is_not() {
    let path = "/v1/machines/example-ac-table/forward-kinematics";
    let rows = |count: usize| "X,Y,Z,A,C\n".to_owned() + &"1,2,3,4,5\n".repeat(count);
    // Six cells of at most 25 bytes in a row, and the header.
    let app = spawn_with(|settings| settings.max_result_bytes = 12 + 10 * 150).await;
    assert_eq!(app.post_text(path, "text/csv", rows(10)).await.status(), 200);
    problem(app.post_text(path, "text/csv", rows(11)).await, "result-too-large").await;
    problem(app.post_text(path, "text/csv", rows(10_000)).await, "result-too-large").await;
    let body = json!({"joints": [{"X": 1, "Y": 2, "Z": 3, "A": 4, "C": 5}]});
    let length = app.post_json(path, &body).await.bytes().await.unwrap().len() as u64;
    let at = spawn_with(|settings| settings.max_result_bytes = length).await;
    assert_eq!(at.post_json(path, &body).await.status(), 200);
    let below = spawn_with(|settings| settings.max_result_bytes = length - 1).await;
    problem(below.post_json(path, &body).await, "result-too-large").await;
}

#[tokio::test]
async fn a_form_of_which_no_field_begins_is_given_up_early() {
    let app = spawn_with(|settings| settings.max_header_bytes = 4096).await;
    let sent = std::sync::Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let count = std::sync::Arc::clone(&sent);
    let chunk = Bytes::from(vec![b'X'; 64 * 1024]);
    let begin = Bytes::from_static(b"--edge\r\nContent-Disposition: form-data; name=\"");
    let endless = futures::StreamExt::chain(
        stream::iter([Ok::<_, std::io::Error>(begin)]),
        stream::iter((0..1 << 14).map(move |_| {
            count.fetch_add(chunk.len(), std::sync::atomic::Ordering::SeqCst);
            Ok(chunk.clone())
        })),
    );
    let request = app
        .client
        .post(app.url(PATH.split('?').next().unwrap()))
        .header("content-type", "multipart/form-data; boundary=edge")
        .body(Body::wrap_stream(endless));
    if let Ok(response) = request.send().await {
        problem(response, "malformed-request").await;
    }
    // A gigabyte was on its way; what both sockets hold was taken, and little more.
    assert!(sent.load(std::sync::atomic::Ordering::SeqCst) < 64 << 20);
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_form_refused_on_its_way_is_answered_to_a_client_that_still_sends() {
    let app = spawn_with(|settings| {
        settings.max_body_bytes = 100;
        settings.max_surface_bytes = 100;
        settings.max_parameters_bytes = 100;
    })
    .await;
    let address = app.base.trim_start_matches("http://");
    let path = PATH.split('?').next().unwrap();
    let length = 8 << 20;
    for (path, fields) in
        [(path, ["program", "surface", "parameters"]), ("/v1/jobs", ["program", "surface", "job"])]
    {
        for field in fields {
            let part = format!("--edge\r\nContent-Disposition: form-data; name=\"{field}\"\r\n\r\n");
            let request = format!(
                "POST {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
                 Content-Type: multipart/form-data; boundary=edge\r\nTransfer-Encoding: chunked\r\n\r\n\
                 {:x}\r\n{part}{}\r\n0\r\n\r\n",
                part.len() + length,
                "X".repeat(length)
            );
            // Many clients look for an answer only when they have sent everything.
            let mut socket = TcpStream::connect(address).await.unwrap();
            socket.write_all(request.as_bytes()).await.unwrap();
            let mut answer = String::new();
            socket.read_to_string(&mut answer).await.unwrap();
            assert!(answer.contains("/problems/body-too-large"), "{path} {field}: {answer}");
        }
    }
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn each_key_has_a_rate_of_its_own_and_guesses_count_by_address() {
    let mut app = spawn_with(|settings| {
        settings.max_rate_per_s = 1.0 / 3600.0;
        settings.max_burst_requests = 8;
    })
    .await;
    let admin = app.close().await;
    let keys = [app.new_key(&["read"], None).await, app.new_key(&["read"], None).await];
    let ask = async |key: &str| {
        let stranger = reqwest::Client::builder().no_proxy().build().unwrap();
        let request = stranger.get(app.url("/v1/machines")).header("authorization", format!("Bearer {key}"));
        request.send().await.unwrap()
    };
    for key in &keys {
        for _ in 0..8 {
            assert_eq!(ask(key).await.status(), 200);
        }
        problem(ask(key).await, "too-many-requests").await;
    }
    // The address has made one request: the one for the first key.
    for _ in 0..7 {
        assert_eq!(ask("guess").await.status(), 401);
    }
    problem(ask("guess").await, "too-many-requests").await;
    assert_eq!(ask(&admin).await.status(), 200);
}
