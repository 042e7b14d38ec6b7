//! What an attacker meets at the edge: one host, answers that no browser misuses, and a log of who was not let in.

use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::database;
use crate::support::{App, problem, spawn};

/// What the service answers to these bytes.
async fn said(app: &App, request: &str) -> String {
    let mut stream = TcpStream::connect(app.base.strip_prefix("http://").unwrap()).await.unwrap();
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await.unwrap();
    String::from_utf8(answer).unwrap()
}

/// The lines of the security log, once it has so many.
async fn security_log(app: &App, lines: usize) -> Vec<Value> {
    let end = Instant::now() + Duration::from_secs(20);
    loop {
        let text = std::fs::read_to_string(app.data.join("security.log")).unwrap_or_default();
        if text.lines().count() >= lines {
            return text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        }
        assert!(Instant::now() < end, "{text}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

#[tokio::test]
async fn a_request_with_several_hosts_or_none_is_refused() {
    let app = spawn().await;
    let here = app.base.strip_prefix("http://").unwrap();
    let asked = async |hosts: &str| {
        said(&app, &format!("GET /v1/machines HTTP/1.1\r\n{hosts}Connection: close\r\n\r\n")).await
    };
    assert!(asked(&format!("Host: {here}\r\n")).await.starts_with("HTTP/1.1 200"));
    for hosts in [
        String::new(),
        format!("Host: {here}\r\nHost: {here}\r\n"),
        format!("Host: {here}\r\nHost: evil.example\r\n"),
        format!("Host: someone@{here}\r\n"),
        format!("Host: {here},evil.example\r\n"),
        "Host: 127.0.0.1:99999\r\n".to_owned(),
    ] {
        let answer = asked(&hosts).await;
        assert!(answer.starts_with("HTTP/1.1 400"), "{hosts}: {answer}");
        assert!(answer.contains("/problems/malformed-request"), "{answer}");
    }
    let contradicting =
        format!("GET http://evil.example/v1/machines HTTP/1.1\r\nHost: {here}\r\nConnection: close\r\n\r\n");
    assert!(said(&app, &contradicting).await.starts_with("HTTP/1.1 400"));
    let lines = security_log(&app, 1).await;
    assert_eq!(lines[0]["reason"], "host");
}

#[tokio::test]
async fn no_body_hides_a_second_request() {
    let app = spawn().await;
    let here = app.base.strip_prefix("http://").unwrap();
    let body = "7\r\nG1 X1\r\n\r\n0\r\n\r\n";
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    let asked = async |fields: &str| {
        let head = format!("POST {path} HTTP/1.1\r\nHost: {here}\r\nContent-Type: text/plain\r\n");
        said(&app, &format!("{head}{fields}\r\n{body}")).await
    };
    let answer = asked("Transfer-Encoding: chunked\r\nConnection: close\r\n").await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    // Two lengths: the chunks are the body, and the connection ends behind the answer, whatever else was sent on it.
    let hidden = format!("GET /v1/machines HTTP/1.1\r\nHost: {here}\r\n\r\n");
    for fields in [
        "Content-Length: 22\r\nTransfer-Encoding: chunked\r\n",
        "Transfer-Encoding: chunked\r\nContent-Length: 22\r\n",
    ] {
        let request =
            format!("POST {path} HTTP/1.1\r\nHost: {here}\r\nContent-Type: text/plain\r\n{fields}\r\n");
        let answer = said(&app, &format!("{request}{body}{hidden}")).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{fields}: {answer}");
        assert_eq!(answer.matches("HTTP/1.1").count(), 1, "{fields}: {answer}");
    }
    for fields in [
        "Transfer-Encoding: gzip, chunked\r\n",
        "Transfer-Encoding: chunked, chunked\r\n",
        "Transfer-Encoding: gzip\r\nTransfer-Encoding: chunked\r\n",
    ] {
        let answer = asked(&format!("{fields}Connection: close\r\n")).await;
        assert!(answer.starts_with("HTTP/1.1 400"), "{fields}: {answer}");
        assert!(answer.contains("/problems/malformed-request"), "{answer}");
    }
}

#[tokio::test]
async fn no_answer_can_be_framed_sniffed_or_kept_by_others() {
    let app = spawn().await;
    let blade = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/blade.nc")).unwrap();
    let made = app
        .post_text(
            "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35",
            "text/plain",
            blade,
        )
        .await;
    let job = made.headers()["location"].to_str().unwrap().to_owned();
    let figure = app
        .client
        .get(app.url(&format!("{job}/plot")))
        .header("accept", "image/svg+xml")
        .send()
        .await
        .unwrap();
    let others = [
        "/healthz",
        "/docs/",
        "/docs/swagger-ui-bundle.js",
        "/openapi.json",
        "/problems",
        "/v1/machines/example-ac-table",
        "/nothing",
    ];
    let mut answers = vec![made, figure];
    for path in others {
        answers.push(app.get(path).await);
    }
    for answer in answers {
        let (url, headers) = (answer.url().to_string(), answer.headers());
        assert_eq!(headers["x-content-type-options"], "nosniff", "{url}");
        assert_eq!(headers["referrer-policy"], "no-referrer", "{url}");
        assert_eq!(headers["cross-origin-resource-policy"], "same-origin", "{url}");
        let policy = headers["content-security-policy"].to_str().unwrap();
        assert!(
            policy.contains("default-src 'none'") && policy.contains("frame-ancestors 'none'"),
            "{url}: {policy}"
        );
        assert_eq!(policy.contains("script-src"), url.contains("/docs/"), "{url}: {policy}");
        assert!(!headers.contains_key("strict-transport-security"), "{url}");
        let kept = if headers.contains_key("etag") { "private, no-cache" } else { "no-store" };
        assert_eq!(headers["cache-control"], kept, "{url}");
    }
}

#[tokio::test]
async fn who_is_not_let_in_is_written_down_with_source_key_and_reason() {
    let mut app = spawn().await;
    let admin = app.close().await;
    let reader = app.new_key(&["read"], Some(&["mine"])).await;
    let revoked = app.new_key(&["read"], None).await;
    let id = |key: &str| key.split('_').nth(1).unwrap().to_owned();
    assert_eq!(
        app.client.delete(app.url(&format!("/v1/keys/{}", id(&revoked)))).send().await.unwrap().status(),
        204
    );
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    let machine = "/v1/machines/example-ac-table";
    let ask = async |path: &str, authorization: Option<&str>| {
        let request = client.get(app.url(path)).header("x-request-id", "of-the-client");
        let request = match authorization {
            Some(value) => request.header("authorization", value),
            None => request,
        };
        request.send().await.unwrap()
    };
    problem(ask(machine, None).await, "unauthenticated").await;
    problem(ask(machine, Some("Basic x")).await, "unauthenticated").await;
    let guess = format!("Bearer {}0", &admin[..admin.len() - 1]);
    let guess = if guess.ends_with(&admin) { format!("{guess}1") } else { guess };
    problem(ask(machine, Some(&guess)).await, "unauthenticated").await;
    problem(ask(machine, Some(&format!("Bearer {revoked}"))).await, "unauthenticated").await;
    problem(ask("/v1/audit", Some(&format!("Bearer {reader}"))).await, "scope-missing").await;
    let last = ask(machine, Some(&format!("Bearer {reader}"))).await;
    let request_id = last.headers()["x-request-id"].to_str().unwrap().to_owned();
    problem(last, "machine-not-found").await;
    let lines = security_log(&app, 6).await;
    let said: Vec<_> =
        lines.iter().map(|line| (line["reason"].as_str().unwrap(), line["key_id"].clone())).collect();
    let expected = [
        ("no-key", Value::Null),
        ("unreadable-key", Value::Null),
        // Whoever guesses does not make an entry against the key whose id it names.
        ("unknown-key", Value::Null),
        ("revoked-key", json!(id(&revoked))),
        ("scope", json!(id(&reader))),
        ("machine", json!(id(&reader))),
    ];
    assert_eq!(said, expected);
    for line in &lines {
        assert_eq!(
            (&line["source"], &line["count"], &line["method"]),
            (&json!("127.0.0.1"), &json!(1), &json!("GET"))
        );
    }
    assert_eq!(lines[4]["route"], "/v1/audit");
    assert_eq!(lines[5]["request_id"], request_id);
    let metrics = app.get("/metrics").await.text().await.unwrap();
    assert!(metrics.contains("trunnion_refusals_total{reason=\"machine\"} 1"), "{metrics}");
    let log = std::fs::read_to_string(app.data.join("security.log")).unwrap();
    assert!([&admin, &reader, &revoked].iter().all(|key| !log.contains(key.rsplit('_').next().unwrap())));
    // None of it is in the audit log.
    let audit: Value = app.get("/v1/audit?limit=200").await.json().await.unwrap();
    assert!(audit["items"].as_array().unwrap().iter().all(|entry| entry["key_id"] != json!(id(&reader))));
}

#[tokio::test]
async fn a_service_whose_keys_are_gone_stays_closed() {
    let mut app = spawn().await;
    app.close().await;
    assert_eq!(app.get("/v1/machines").await.status(), 200);
    // A database without keys takes the place of the one with keys, as a careless restore would do it.
    let of_table = if database::server().is_some() { " ON api_keys" } else { "" };
    let drop_trigger = format!("DROP TRIGGER api_keys_never_go{of_table}");
    for text in [drop_trigger.as_str(), "DELETE FROM api_keys"] {
        database::change(&app.data, text).await.unwrap();
    }
    tokio::time::sleep(Duration::from_millis(1200)).await;
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    let refused = problem(client.get(app.url("/v1/machines")).send().await.unwrap(), "unauthenticated").await;
    assert!(refused["detail"].as_str().unwrap().contains("lost its API keys"), "{refused}");
    assert_eq!(client.get(app.url("/healthz")).send().await.unwrap().status(), 200);
}

#[tokio::test]
async fn a_text_that_a_spreadsheet_would_compute_is_text_in_a_table() {
    let app = spawn().await;
    let tool = "/v1/machines/example-ac-table/tools/T12";
    let edge = "=HYPERLINK(\"http://evil.example\")";
    let entry =
        json!({"measured_at": "2026-01-10T08:00:00Z", "parts_cut": 20, "radius_wear_um": 24.5, "edge": edge});
    assert_eq!(app.post_json(&format!("{tool}/wear-entries"), &entry).await.status(), 201);
    let trend = app.client.get(app.url(&format!("{tool}/wear-trend"))).header("accept", "text/csv");
    let table = trend.send().await.unwrap().text().await.unwrap();
    assert!(table.contains("\n\"'=HYPERLINK("), "{table}");
    // As JSON it is what was posted.
    let listed: Value = app.get(&format!("{tool}/wear-entries")).await.json().await.unwrap();
    assert_eq!(listed["items"][0]["edge"], edge);
}
