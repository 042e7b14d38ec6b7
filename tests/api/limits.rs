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
                    if other.status() == 503 {
                        break Ok(other);
                    }
                }
            }
        };
        if let Ok(busy) = busy {
            problem(busy, "busy").await;
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
    socket.write_all(text.as_bytes()).await.unwrap();
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
