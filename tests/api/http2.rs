//! Clients that speak HTTP/2: what they ask for they get, and what they leave alone ends.

use std::time::Duration;

use reqwest::Client;
use reqwest::multipart::{Form, Part};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::support::{App, spawn_with};

/// Types of frames (RFC 9113 §6), and the flag of an answer to one.
const DATA: u8 = 0;
const HEADERS: u8 = 1;
const SETTINGS: u8 = 4;
const PING: u8 = 6;
const WINDOW_UPDATE: u8 = 8;
const ACK: u8 = 1;
/// `END_STREAM` and `END_HEADERS`.
const WHOLE: u8 = 0b101;
/// `SETTINGS_INITIAL_WINDOW_SIZE`.
const WINDOW: u8 = 4;
/// Far more than the times set below.
const LONG: Duration = Duration::from_mins(1);

fn frame(kind: u8, flags: u8, stream: u8, payload: &[u8]) -> Vec<u8> {
    let length = u32::try_from(payload.len()).unwrap().to_be_bytes();
    [&length[1..], &[kind, flags, 0, 0, 0, stream], payload].concat()
}

/// A client that lets nothing be sent to it on a stream.
async fn closed_window(app: &App) -> TcpStream {
    let mut socket = TcpStream::connect(app.base.trim_start_matches("http://")).await.unwrap();
    let settings = frame(SETTINGS, 0, 0, &[0, WINDOW, 0, 0, 0, 0]);
    socket.write_all(&[b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", &*settings].concat()).await.unwrap();
    socket
}

/// GET /openapi.json on the first stream: entries of the static table (RFC 7541 §A), a path and an authority as they
/// are.
fn asking_for_much() -> Vec<u8> {
    let path = b"/openapi.json";
    let fields =
        [&[0x82, 0x86, 0x04, u8::try_from(path.len()).unwrap()], &path[..], &[0x01, 1, b'x']].concat();
    frame(HEADERS, WHOLE, 1, &fields)
}

/// Answers what a client has to answer to be thought alive, until the service closes the connection.
async fn alive_until_closed(mut socket: TcpStream) {
    let mut head = [0; 9];
    while socket.read_exact(&mut head).await.is_ok() {
        let mut payload = vec![0; u32::from_be_bytes([0, head[0], head[1], head[2]]) as usize];
        if socket.read_exact(&mut payload).await.is_err() {
            return;
        }
        let answer = match (head[3], head[4] & ACK) {
            (PING, 0) => frame(PING, ACK, 0, &payload),
            (SETTINGS, 0) => frame(SETTINGS, ACK, 0, &[]),
            _ => continue,
        };
        if socket.write_all(&answer).await.is_err() {
            return;
        }
    }
}

fn speaks_two() -> Client {
    Client::builder().http2_prior_knowledge().build().unwrap()
}

#[tokio::test]
async fn a_connection_without_a_request_is_closed() {
    let app = spawn_with(|settings| settings.header_timeout_s = 0.2).await;
    let socket = closed_window(&app).await;
    tokio::time::timeout(LONG, alive_until_closed(socket)).await.unwrap();
}

#[tokio::test]
async fn a_client_that_opens_no_window_for_its_answer_is_left() {
    let app = spawn_with(|settings| {
        settings.answer_pause_timeout_s = 0.2;
        settings.max_connections = 1;
    })
    .await;
    let mut socket = closed_window(&app).await;
    // GET /openapi.json: entries of the static table (RFC 7541 §A), and a path and an authority as they are.
    let path = b"/openapi.json";
    let fields =
        [&[0x82, 0x86, 0x04, u8::try_from(path.len()).unwrap()], &path[..], &[0x01, 1, b'x']].concat();
    socket.write_all(&frame(HEADERS, WHOLE, 1, &fields)).await.unwrap();
    tokio::time::timeout(LONG, alive_until_closed(socket)).await.unwrap();
    // The only place for a connection is free.
    assert_eq!(speaks_two().get(app.url("/healthz")).send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn a_client_that_takes_a_little_at_a_time_gets_it_all() {
    let app = spawn_with(|settings| {
        settings.header_timeout_s = 0.5;
        settings.answer_pause_timeout_s = 5.0;
    })
    .await;
    let whole = app.get("/openapi.json").await.bytes().await.unwrap().len();
    let mut socket = closed_window(&app).await;
    // The window of the connection is of no matter here; that of the stream grows for about two seconds.
    let more = |stream: u8, bytes: u32| frame(WINDOW_UPDATE, 0, stream, &bytes.to_be_bytes());
    socket.write_all(&[more(0, 1 << 24), asking_for_much()].concat()).await.unwrap();
    let (mut taken, mut head) = (0, [0; 9]);
    while taken < whole {
        socket.write_all(&more(1, u32::try_from(whole / 20).unwrap() + 1)).await.unwrap();
        tokio::time::sleep(Duration::from_millis(100)).await;
        let mut of_this_window = 0;
        while of_this_window <= whole / 20 && taken < whole {
            tokio::time::timeout(LONG, socket.read_exact(&mut head)).await.unwrap().unwrap();
            let mut payload = vec![0; u32::from_be_bytes([0, head[0], head[1], head[2]]) as usize];
            socket.read_exact(&mut payload).await.unwrap();
            if head[3] == DATA {
                of_this_window += payload.len();
                taken += payload.len();
            }
        }
    }
    assert_eq!(taken, whole);
}

#[tokio::test]
async fn an_answer_of_many_parts_is_the_same_by_either_protocol() {
    let app = spawn_with(|_| {}).await;
    let one = app.get("/openapi.json").await.bytes().await.unwrap();
    let response = speaks_two().get(app.url("/openapi.json")).send().await.unwrap();
    assert_eq!(response.version(), reqwest::Version::HTTP_2);
    assert_eq!(response.headers()["content-length"], one.len().to_string().as_str());
    assert_eq!(response.bytes().await.unwrap(), one);
    assert!(one.len() > 100_000);
}

#[tokio::test]
async fn a_client_that_waits_for_events_is_not_thought_gone() {
    let app = spawn_with(|settings| {
        settings.answer_pause_timeout_s = 0.2;
        settings.header_timeout_s = 2.0;
    })
    .await;
    let job = json!({"machine_id": "example-ac-table", "operation": "cc-compensation",
        "parameters": {"tool_radius_mm": 5, "contact": "tip"}});
    let form = Form::new().text("job", job.to_string());
    let form = form.part("program", Part::text("WAIT\n").file_name("a.nc"));
    let posted = app.client.post(app.url("/v1/jobs")).multipart(form).send().await.unwrap();
    let job = posted.headers()["location"].to_str().unwrap();
    let mut events = speaks_two().get(app.url(&format!("{job}/events"))).send().await.unwrap();
    let mut text = String::new();
    let told = async |events: &mut reqwest::Response, text: &mut String, until: &str| {
        while !text.contains(until) {
            let part = events.chunk().await.unwrap().expect("the stream goes on");
            text.push_str(std::str::from_utf8(&part).unwrap());
        }
    };
    tokio::time::timeout(LONG, told(&mut events, &mut text, "running")).await.unwrap();
    // Nothing happens for several times as long as either pause.
    tokio::time::sleep(Duration::from_secs(5)).await;
    app.client.delete(app.url(job)).send().await.unwrap();
    tokio::time::timeout(LONG, told(&mut events, &mut text, "cancelled")).await.unwrap();
}
