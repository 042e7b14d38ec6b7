//! The memory that requests share: what has no room in it is refused, everybody gets a part, and all of it comes back.

use std::time::Duration;

use bytes::Bytes;
use futures::{StreamExt, stream};
use reqwest::{Body, StatusCode};
use serde_json::json;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

use crate::support::{App, problem, spawn_with};

const INVERSE: &str = "/v1/machines/example-ac-table/inverse-kinematics";
/// The least that the setting may be: a budget of 32 MiB for requests, of which one caller may have three quarters.
const LEAST_BYTES: u64 = 128 << 20;

async fn spawn_narrow() -> App {
    spawn_with(|settings| settings.max_memory_bytes = LEAST_BYTES).await
}

fn poses(count: usize) -> String {
    let rows = vec![r#"{"x":1,"y":2,"z":3,"i":0,"j":0.1,"k":1}"#; count];
    format!("{{\"poses\":[{}]}}", rows.join(","))
}

#[tokio::test]
async fn what_fits_is_answered_and_what_never_will_is_told_how_much_does() {
    let app = spawn_narrow().await;
    let fits = app.post_text(INVERSE, "application/json", poses(50_000)).await;
    assert_eq!(fits.status(), 200);
    assert_eq!(fits.json::<serde_json::Value>().await.unwrap()["joints"].as_array().unwrap().len(), 50_000);
    let refused = app.post_text(INVERSE, "application/json", poses(500_000)).await;
    let detail = problem(refused, "body-too-large").await["detail"].as_str().unwrap().to_owned();
    assert!(detail.contains("raise max_memory_bytes"), "{detail}");
    // A long table waits on the disk. Its answer as a document, which takes all solutions at once, does not.
    let count = 300_000;
    let rows = Bytes::from(format!("x,y,z,i,j,k\n{}", "1,2,3,0,0.1,1\n".repeat(count)));
    let answer = app.post_text(INVERSE, "text/csv", rows.clone()).await;
    assert_eq!((answer.status(), &answer.headers()["trunnion-warnings"] == "0"), (StatusCode::OK, true));
    let answer = answer.text().await.unwrap();
    let (first, last) = (answer.lines().nth(1), answer.lines().nth(count));
    assert!(first.is_some() && first == last && answer.lines().count() == count + 1);
    let asked = app.client.post(app.url(INVERSE)).header("content-type", "text/csv").body(rows);
    let document = asked.header("accept", "application/json").send().await.unwrap();
    problem(document, "body-too-large").await;
    assert_eq!(app.files(), (0, 0));
    // Nothing is left of them.
    assert_eq!(app.post_text(INVERSE, "application/json", poses(50_000)).await.status(), 200);
}

#[tokio::test]
async fn a_long_table_without_room_in_the_spool_is_refused_and_leaves_nothing() {
    let row = "1,2,3,0,0.1,1\n";
    let rows = |count: usize| format!("x,y,z,i,j,k\n{}", row.repeat(count));
    let app = spawn_with(|settings| settings.max_spool_bytes = 1 << 20).await;
    problem(app.post_text(INVERSE, "text/csv", rows(140_000)).await, "storage-unavailable").await;
    assert_eq!(app.files(), (0, 0));
    // A shorter one stays in memory.
    assert_eq!(app.post_text(INVERSE, "text/csv", rows(20_000)).await.status(), 200);
    let app = spawn_with(|_| {}).await;
    // The last row cannot be reached.
    let far = format!("{}1,2,3,0,0,-1\n", rows(140_000));
    assert_eq!(
        problem(app.post_text(INVERSE, "text/csv", far).await, "unreachable-pose").await["pose"],
        140_000
    );
    std::fs::remove_dir(app.data.join("spool")).unwrap();
    problem(app.post_text(INVERSE, "text/csv", rows(140_000)).await, "internal").await;
}

/// Connections that have sent a part of a body each.
async fn unfinished(app: &App, count: usize, part: &str) -> Vec<TcpStream> {
    let address = app.base.strip_prefix("http://").unwrap();
    let head = format!(
        "POST {INVERSE} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 30000000\r\n\r\n"
    );
    let mut connections = Vec::new();
    for _ in 0..count {
        let mut connection = TcpStream::connect(address).await.unwrap();
        connection.write_all(head.as_bytes()).await.unwrap();
        // The service may have refused it already.
        let _refused = connection.write_all(part.as_bytes()).await;
        connections.push(connection);
    }
    connections
}

#[tokio::test]
async fn many_unfinished_bodies_are_refused_for_now_and_leave_everything_behind() {
    let app = spawn_narrow().await;
    let part = poses(60_000);
    let held = unfinished(&app, 16, part.get(..2_000_000).unwrap()).await;
    // The bodies arrive as fast as the machine lets them.
    let mut asked = app.post_text(INVERSE, "application/json", poses(50_000)).await;
    for _ in 0..200 {
        if asked.status() != StatusCode::OK {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
        asked = app.post_text(INVERSE, "application/json", poses(50_000)).await;
    }
    let refused = asked;
    assert_eq!(refused.headers()["retry-after"], "2");
    let detail = problem(refused, "memory-budget").await["detail"].as_str().unwrap().to_owned();
    assert!(detail.contains("are free"), "{detail}");
    for path in ["/readyz", "/healthz", "/metrics"] {
        assert_eq!(app.get(path).await.status(), 200, "{path}");
    }
    // The unfinished bodies may hold their part, but not all: small answers have room again while they wait.
    let mut listed = StatusCode::SERVICE_UNAVAILABLE;
    for _ in 0..200 {
        listed = app.get("/v1/machines").await.status();
        if listed == StatusCode::OK {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert_eq!(listed, StatusCode::OK);
    drop(held);
    let mut answered = false;
    for _ in 0..100 {
        answered |=
            app.post_text(INVERSE, "application/json", poses(50_000)).await.status() == StatusCode::OK;
        if answered {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    assert!(answered, "the memory does not come back");
}

#[tokio::test]
async fn the_text_fields_of_forms_pay_as_they_arrive() {
    let app = spawn_narrow().await;
    let address = app.base.strip_prefix("http://").unwrap();
    let head = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=b\r\n\
                Content-Length: 20000000\r\n\r\n--b\r\nContent-Disposition: form-data; name=\"job\"\r\n\r\n";
    let text = " ".repeat(1_000_000);
    let mut held = Vec::new();
    for place in 0..32 {
        let mut connection = TcpStream::connect(address).await.unwrap();
        // The service may refuse it meanwhile.
        let _refused = connection.write_all(head.as_bytes()).await;
        let _refused = connection.write_all(text.as_bytes()).await;
        held.push(connection);
        if place == 0 {
            // It has paid before the others come. All that grow at the same time may be refused.
            tokio::time::sleep(Duration::from_secs(1)).await;
        }
    }
    // Some of them are refused: those that are held pay two megabytes each.
    let mut refused = 0;
    for _ in 0..200 {
        for connection in &held {
            let mut answer = [0; 12];
            if connection.try_read(&mut answer).is_ok_and(|read| read == 12) && answer == *b"HTTP/1.1 503" {
                refused += 1;
            }
        }
        if refused >= 16 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    assert!((16..32).contains(&refused), "{refused} of 32 are refused");
    drop(held);
    let mut looks = 0;
    while app.post_text(INVERSE, "application/json", poses(50_000)).await.status() != 200 {
        looks += 1;
        assert!(looks < 100, "the memory does not come back");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test]
async fn a_large_answer_that_nobody_takes_holds_no_memory() {
    let app = spawn_with(|settings| {
        settings.max_memory_bytes = LEAST_BYTES;
        settings.answer_pause_timeout_s = 600.0;
    })
    .await;
    let body = poses(40_000);
    let mut waiting = Vec::new();
    // Together they are several times the budget.
    for _ in 0..24 {
        let mut answer = app.post_text(INVERSE, "application/json", body.clone()).await;
        // The answers before may still be printed, and hold their poses for that long.
        for _ in 0..100 {
            if answer.status() != StatusCode::SERVICE_UNAVAILABLE {
                break;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
            answer = app.post_text(INVERSE, "application/json", body.clone()).await;
        }
        assert_eq!(answer.status(), 200);
        waiting.push(answer);
    }
    let mut texts = Vec::new();
    for answer in waiting {
        texts.push(answer.bytes().await.unwrap());
    }
    assert!(texts.iter().all(|text| *text == texts[0] && text.len() > 3_000_000));
    // The files have no names that could stay.
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn an_answer_has_the_same_bytes_in_memory_and_from_the_disk() {
    let app = spawn_narrow().await;
    let path = "/v1/machines/example-ac-table/forward-kinematics";
    let row = json!({"X": 1.5, "Y": 2, "Z": 3, "A": 10, "C": 20});
    let one = app.post_json(path, &json!({"joints": [row]})).await.text().await.unwrap();
    let pose = one.split_once('[').unwrap().1.trim_end_matches("]}").to_owned();
    for count in [500, 1000, 20_000] {
        let answer = app.post_json(path, &json!({"joints": vec![row.clone(); count]})).await;
        let length = answer.content_length();
        let text = answer.text().await.unwrap();
        // A long answer leaves while it is printed, before its length is known.
        assert_eq!(length, (text.len() <= 256 << 10).then_some(text.len() as u64), "{count}");
        assert_eq!(text.matches(&pose).count(), count);
    }
}

#[tokio::test]
async fn clients_that_leave_in_the_middle_of_an_answer_leave_nothing_behind() {
    let app = spawn_narrow().await;
    let body = poses(40_000);
    for _ in 0..8 {
        let mut answer = app.post_text(INVERSE, "application/json", body.clone()).await;
        if answer.status() == StatusCode::OK {
            assert!(answer.chunk().await.unwrap().is_some_and(|begun| !begun.is_empty()));
        }
    }
    let mut looks = 0;
    let whole = loop {
        let answer = app.post_text(INVERSE, "application/json", body.clone()).await;
        if answer.status() == StatusCode::OK {
            break answer.json::<serde_json::Value>().await.unwrap();
        }
        looks += 1;
        assert!(looks < 100, "the memory does not come back");
        tokio::time::sleep(Duration::from_millis(50)).await;
    };
    assert_eq!(whole["joints"].as_array().unwrap().len(), 40_000);
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_body_is_paid_as_it_arrives() {
    let app = spawn_narrow().await;
    // More than there is room for, announced by nobody, and never ending.
    let blanks = Bytes::from(vec![b' '; 64 << 10]);
    let endless = stream::iter((0..480).map(move |_| Ok::<_, std::io::Error>(blanks.clone()))).boxed();
    let request = app.client.post(app.url(INVERSE)).header("content-type", "application/json");
    if let Ok(refused) = request.body(Body::wrap_stream(endless)).send().await {
        problem(refused, "body-too-large").await;
    }
    assert_eq!(app.get("/v1/machines").await.status(), 200);
}
