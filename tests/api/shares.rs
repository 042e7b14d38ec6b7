//! Greedy callers beside ordinary ones: everybody has a share, and nobody more.

use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use futures::stream::{self, FuturesUnordered, StreamExt};
use reqwest::{Body, Response};
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::queue::{Held, accepted, cc, document, ended, form, running, spawn_held};
use crate::support::{App, problem, spawn_with};

const CC: &str = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
const BOTH: [&str; 2] = ["read", "compute"];

/// A request as the bearer of this key makes it.
fn as_bearer(request: reqwest::RequestBuilder, key: &str) -> reqwest::RequestBuilder {
    request.header("authorization", format!("Bearer {key}"))
}

async fn post_job(app: &App, key: &str, program: &str) -> Response {
    let request = app.client.post(app.url("/v1/jobs")).multipart(form(&cc("example-ac-table"), program));
    as_bearer(request, key).send().await.unwrap()
}

fn compensate(app: &App, key: &str, body: impl Into<Body>) -> reqwest::RequestBuilder {
    let request = app.client.post(app.url(CC)).header("content-type", "text/plain").body(body);
    as_bearer(request, key)
}

/// The refusal of what is over a share: its detail.
async fn over_share(response: Response) -> String {
    let after =
        response.headers().get("retry-after").and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    assert!(after.is_some_and(|after_s| after_s > 0), "{:?}", response.headers());
    let body = problem(response, "quota").await;
    assert_eq!(body["status"], 429);
    body["detail"].as_str().unwrap().to_owned()
}

#[tokio::test]
async fn one_key_that_fills_the_queue_leaves_room_for_others() {
    let held = Arc::<Held>::default();
    let mut app = spawn_held(&held, |settings| settings.max_queued_jobs = 8).await;
    app.close().await;
    let (greedy, other) = (app.new_key(&BOTH, None).await, app.new_key(&BOTH, None).await);
    // Jobs of three callers may have begun at one place.
    let mut runs = Vec::new();
    for _ in 0..3 {
        let posted = post_job(&app, &app.new_key(&BOTH, None).await, "HOLD\n").await;
        assert_eq!(posted.status(), 202);
        let place = posted.headers()["location"].to_str().unwrap().to_owned();
        running(&app, &place).await;
        runs.push(place);
    }
    for number in 0..6 {
        assert_eq!(post_job(&app, &greedy, &format!("greedy {number}\n")).await.status(), 202);
    }
    for program in ["greedy, one past it\n", "greedy, far past it\n"] {
        let detail = over_share(post_job(&app, &greedy, program).await).await;
        assert!(detail.contains("6 queued jobs") && detail.contains("max_share_per_caller"), "{detail}");
    }
    for number in 0..2 {
        assert_eq!(post_job(&app, &other, &format!("other {number}\n")).await.status(), 202);
    }
    // Nothing is left for anybody: that is another refusal.
    problem(post_job(&app, &app.new_key(&BOTH, None).await, "third\n").await, "queue-full").await;
    let (kept, _of_the_running_one) = app.files();
    held.release();
    for place in &runs {
        ended(&app, place).await;
    }
    let jobs: Value = app.get("/v1/jobs?limit=200").await.json().await.unwrap();
    for job in jobs["items"].as_array().unwrap() {
        ended(&app, &format!("/v1/jobs/{}", job["id"].as_str().unwrap())).await;
    }
    // Keys are served in turn, and each one's jobs in their order.
    let order = held.order();
    assert_eq!(order[..3], ["HOLD"; 3], "{order:?}");
    let of = |key: &str| order.iter().filter(|text| text.starts_with(key)).cloned().collect::<Vec<_>>();
    assert_eq!(of("other"), ["other 0", "other 1"]);
    assert_eq!(of("greedy"), (0..6).map(|number| format!("greedy {number}")).collect::<Vec<_>>());
    let last_of_other = order.iter().position(|text| text == "other 1").unwrap();
    assert!(last_of_other < 8, "{order:?}");
    assert_eq!(order.len(), 11);
    // What was refused left nothing: three programs of the same text and eight others came in.
    assert_eq!(kept, 9);
}

#[tokio::test]
async fn a_long_job_of_one_key_does_not_keep_the_jobs_of_another_waiting() {
    for places in [1, 2] {
        let held = Arc::<Held>::default();
        let mut app = spawn_held(&held, |settings| settings.max_computations = places).await;
        app.close().await;
        let (greedy, other) = (app.new_key(&BOTH, None).await, app.new_key(&BOTH, None).await);
        let mut long = Vec::new();
        for _ in 0..4 {
            let posted = post_job(&app, &greedy, "HOLD\n").await;
            long.push(posted.headers()["location"].to_str().unwrap().to_owned());
        }
        running(&app, &long[0]).await;
        for number in 0..5 {
            let posted = post_job(&app, &other, &format!("short {number}\n")).await;
            let place = posted.headers()["location"].to_str().unwrap().to_owned();
            assert_eq!(ended(&app, &place).await["state"], "succeeded", "{places} places");
        }
        // One place of two, and the only one, is what the jobs of one key may take.
        let states: Vec<_> = futures::future::join_all(long.iter().map(|place| document(&app, place))).await;
        let states: Vec<_> = states.iter().map(|job| job["state"].as_str().unwrap()).collect();
        assert_eq!(states, ["running", "queued", "queued", "queued"], "{places} places");
        held.release();
        for place in &long {
            ended(&app, place).await;
        }
    }
}

#[tokio::test]
async fn one_key_that_follows_all_it_may_leaves_event_streams_for_others() {
    let held = Arc::<Held>::default();
    let mut app = spawn_held(&held, |settings| settings.max_event_streams = 8).await;
    app.close().await;
    let (greedy, other) = (app.new_key(&["read"], None).await, app.new_key(&["read"], None).await);
    let place = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let follow = |key: &str| as_bearer(app.client.get(app.url(&format!("{place}/events"))), key).send();
    let mut open = Vec::new();
    for _ in 0..6 {
        open.push(follow(&greedy).await.unwrap());
    }
    assert!(open.iter().all(|stream| stream.status() == 200));
    let detail = over_share(follow(&greedy).await.unwrap()).await;
    assert!(detail.contains("6 event streams"), "{detail}");
    assert_eq!(follow(&other).await.unwrap().status(), 200);
    // Who leaves makes room.
    drop(open);
    let mut looks = 0;
    while follow(&greedy).await.unwrap().status() != 200 {
        looks += 1;
        assert!(looks < 10_000, "no room came back");
    }
    held.release();
}

#[tokio::test]
async fn a_key_whose_computations_never_end_does_not_keep_another_from_computing() {
    let mut app = spawn_with(|settings| {
        settings.max_computations = 1;
        settings.max_waiting_computations = 7;
    })
    .await;
    app.close().await;
    let (greedy, other) = (app.new_key(&BOTH, None).await, app.new_key(&BOTH, None).await);
    // Each looks at its stop all the time, and ends with its client.
    let mut endless: FuturesUnordered<_> =
        (0..20).map(|_| tokio::spawn(compensate(&app, &greedy, "WAIT\n").send())).collect();
    // Six of eight places are its share: one past it is refused at once, and one far past it too.
    for _ in 0..14 {
        let answer = tokio::time::timeout(Duration::from_mins(1), endless.next()).await.unwrap();
        let detail = over_share(answer.unwrap().unwrap().unwrap()).await;
        assert!(detail.contains("6 computations"), "{detail}");
    }
    for number in 0..3 {
        let answer = compensate(&app, &other, format!("g1 x{number}\n")).send().await.unwrap();
        assert_eq!(answer.status(), 200);
    }
    // The queue's jobs are computed too.
    let job = accepted(&app, &cc("example-ac-table"), "g1\n").await;
    assert_eq!(ended(&app, &job).await["state"], "succeeded");
    assert!(endless.iter().all(|task| !task.is_finished()));
    endless.iter().for_each(tokio::task::JoinHandle::abort);
}

#[tokio::test]
async fn uploads_that_never_end_leave_room_in_the_spool_and_give_theirs_back() {
    const PIECE: usize = 256 << 10;
    let mut app = spawn_with(|settings| settings.max_spool_bytes = 16 * PIECE as u64).await;
    app.close().await;
    let (greedy, other) = (app.new_key(&BOTH, None).await, app.new_key(&BOTH, None).await);
    let packed = |pieces: usize| {
        let mut packer = GzEncoder::new(Vec::new(), Compression::best());
        // Eight bytes a line, which differ: what packs better than any program is refused for that.
        for line in 0..pieces * PIECE / 8 {
            writeln!(packer, "g1 x{:03}", line * line % 997).unwrap();
        }
        packer.finish().unwrap()
    };
    // Twelve of sixteen pieces are one caller's share, and less on the wire would be more.
    for pieces in [13, 40] {
        let bomb = compensate(&app, &greedy, packed(pieces)).header("content-encoding", "gzip");
        let detail = over_share(bomb.send().await.unwrap()).await;
        assert!(detail.contains(&format!("its share is {} now", 12 * PIECE)), "{detail}");
        assert_eq!(app.files(), (0, 0));
    }
    // Ten pieces that are sent, and no end of them.
    let (sender, receiver) = tokio::sync::mpsc::channel::<Bytes>(1);
    let chunks = stream::unfold(receiver, |mut receiver| async move {
        Some((Ok::<_, std::io::Error>(receiver.recv().await?), receiver))
    });
    let unfinished = tokio::spawn(compensate(&app, &greedy, Body::wrap_stream(chunks)).send());
    for _ in 0..10 {
        sender.send(Bytes::from(vec![b'X'; PIECE])).await.unwrap();
    }
    // All of it has arrived and what is gathered is written: the folder stays as it is.
    let spooled = || {
        let files = std::fs::read_dir(app.data.join("spool")).unwrap();
        files.map(|file| file.unwrap().metadata().unwrap().len()).sum::<u64>()
    };
    let (mut before, mut looks) = (0, 0);
    while before < 9 * PIECE as u64 || spooled() != before {
        before = spooled();
        looks += 1;
        assert!(looks < 300, "{before} bytes have arrived");
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    let five = packed(5);
    let more = || compensate(&app, &greedy, five.clone()).header("content-encoding", "gzip").send();
    assert!(over_share(more().await.unwrap()).await.contains("bytes of uploads"));
    let answer = compensate(&app, &other, packed(1)).header("content-encoding", "gzip").send().await.unwrap();
    assert_eq!(answer.status(), 200);
    unfinished.abort();
    drop(sender);
    let mut looks = 0;
    while more().await.unwrap().status() != 200 {
        looks += 1;
        assert!(looks < 1000, "no room came back");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert_eq!(app.files().1, 0);
}

/// Other systems have one loopback address.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn connections_of_one_address_leave_room_for_another() {
    let app = spawn_with(|settings| settings.max_connections = 8).await;
    let address = app.base.trim_start_matches("http://").parse().unwrap();
    let mut open = Vec::new();
    let mut closed = 0;
    for _ in 0..100 {
        let socket = tokio::net::TcpSocket::new_v4().unwrap();
        socket.bind(([127, 0, 0, 2], 0).into()).unwrap();
        let mut stream = socket.connect(address).await.unwrap();
        // Whoever is let in is answered; whoever is not finds the connection closed.
        let _closed = stream.write_all(b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await;
        let mut answer = [0; 12];
        match stream.read_exact(&mut answer).await {
            Ok(_) => open.push(stream),
            Err(_) => closed += 1,
        }
    }
    assert_eq!((open.len(), closed), (6, 94));
    assert_eq!(app.get("/healthz").await.status(), 200);
}

#[tokio::test]
async fn a_share_of_everything_is_no_share() {
    let held = Arc::<Held>::default();
    let mut app = spawn_held(&held, |settings| {
        settings.max_queued_jobs = 8;
        settings.max_share_per_caller = 1.0;
    })
    .await;
    app.close().await;
    let key = app.new_key(&BOTH, None).await;
    let runs = post_job(&app, &key, "HOLD\n").await;
    running(&app, runs.headers()["location"].to_str().unwrap()).await;
    for number in 0..8 {
        assert_eq!(post_job(&app, &key, &format!("g1 x{number}\n")).await.status(), 202);
    }
    problem(post_job(&app, &key, "one more\n").await, "queue-full").await;
    held.release();
}
