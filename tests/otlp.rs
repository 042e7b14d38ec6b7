//! Spans reach a collector over OTLP: `cargo test --features otlp --test otlp`.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise, helpers included")]

use std::sync::Arc;

use axum::Router;
use axum::body::Bytes;
use axum::http::HeaderMap;
use axum::routing::post;
use tokio::sync::mpsc;
use trunnion::cli::start;
use trunnion::config::Settings;
use trunnion::jobs::{CutterContactCompensator, Sources};

const TRACE: &str = "4bf92f3577b34da6a3ce929d0e0e4736";
const PARENT: &str = "00f067aa0ba902b7";

fn contains(body: &[u8], part: &[u8]) -> bool {
    body.windows(part.len()).any(|window| window == part)
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len()).step_by(2).map(|k| u8::from_str_radix(&hex[k..k + 2], 16).unwrap()).collect()
}

fn settings(data: &std::path::Path, endpoint: String) -> Settings {
    Settings {
        listen: ([127, 0, 0, 1], 0).into(),
        data_dir: data.to_owned(),
        drain_timeout_s: 0.5,
        otlp_endpoint: endpoint,
        ..Settings::default()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_is_a_span_of_its_callers_trace() {
    let (sender, mut received) = mpsc::unbounded_channel();
    let collector = Router::new().route(
        "/v1/traces",
        post(move |headers: HeaderMap, body: Bytes| {
            let sender = sender.clone();
            async move { sender.send((headers, body)).unwrap() }
        }),
    );
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move { axum::serve(listener, collector).await });

    let data = tempfile::TempDir::new().unwrap();
    let running = start(
        settings(data.path(), format!("http://{address}")),
        Sources::real(),
        Arc::new(CutterContactCompensator::default()),
    )
    .await
    .unwrap();
    let url = format!("http://{}/v1/machines/example-ac-table", running.address);
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    let ask = |flags: &str| {
        client
            .get(&url)
            .header("traceparent", format!("00-{TRACE}-{PARENT}-{flags}"))
            .header("x-request-id", flags)
            .send()
    };
    let answer = ask("01").await.unwrap();
    let given = answer.headers()["traceresponse"].to_str().unwrap().to_owned();
    // A trace that its caller does not record is not sent on either.
    assert_eq!(ask("00").await.unwrap().status(), 200);
    running.stop().await.unwrap();

    let (headers, body) = received.recv().await.unwrap();
    assert_eq!(headers["content-type"], "application/x-protobuf");
    for id in [TRACE, PARENT, given.split('-').nth(2).unwrap()] {
        assert!(contains(&body, &bytes(id)), "{id}");
    }
    for text in ["get_machine", "/v1/machines/{machine_id}", "example-ac-table", "service.name", "trunnion"] {
        assert!(contains(&body, text.as_bytes()), "{text}");
    }
    let count = body.windows(11).filter(|window| window == b"get_machine").count();
    assert_eq!(count, 1);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_collector_that_is_not_there_hinders_nobody() {
    let data = tempfile::TempDir::new().unwrap();
    // Nothing listens on the port of an address that was given back.
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let compensator = || Arc::new(CutterContactCompensator::default());
    let endpoint = format!("http://{address}");
    let running = start(settings(data.path(), endpoint), Sources::real(), compensator()).await.unwrap();
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    let answer = client.get(format!("http://{}/readyz", running.address)).send().await.unwrap();
    assert_eq!(answer.status(), 200);
    running.stop().await.unwrap();
    let fault = start(settings(data.path(), "https://x".to_owned()), Sources::real(), compensator()).await;
    assert!(fault.err().unwrap().to_string().contains("http://"));
}
