//! Limits at which many stand at once, limits on what a request says of itself, and the table that holds that no limit
//! goes without its tests.

use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use futures::future::join_all;
use futures::stream::{self, FuturesUnordered, StreamExt};
use reqwest::multipart::{Form, Part};
use reqwest::{Body, Response};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use trunnion::jobs::Cost;
use trunnion::surface::Mesh;

use crate::queue::{Held, accepted, cc, document, ended, form, running, spawn_held};
use crate::receiver::{Receiver, Reply};
use crate::support::{App, description, problem, spawn_with};
use crate::webhooks::{at_once, calling};

const CC: &str = "/v1/machines/example-ac-table/cc-compensation";
const FORWARD: &str = "/v1/machines/example-ac-table/forward-kinematics";
const SCALLOP: &str = "/v1/scallop-height";
/// What is meant by far past a limit on how many there are at once.
const FAR: usize = 100;

/// The tests of each limit: at it, one past it, far past it. A time is passed by whoever says nothing, and nobody can
/// say less: that test is the first and the last.
const HELD_BY: &[(&str, &[&str])] = &[
    (
        "max_body_bytes",
        &[
            "limits::a_program_at_the_limit_is_taken_and_one_byte_more_is_not",
            "limits::a_gigabyte_of_one_letter_is_refused_and_leaves_nothing",
            "limits::the_limit_counts_after_decompression",
        ],
    ),
    (
        "max_surface_bytes",
        &["limits_beyond::a_surface_at_the_limit_is_taken_one_byte_more_is_not_and_an_absurd_one_neither"],
    ),
    (
        "max_surface_memory_bytes",
        &[
            "limits_beyond::a_surface_takes_all_the_memory_there_is_for_them_and_not_a_byte_more",
            "limits_beyond::surfaces_share_their_memory_and_those_who_find_none_come_again",
        ],
    ),
    (
        "max_memory_bytes",
        &[
            "memory::what_fits_is_answered_and_what_never_will_is_told_how_much_does",
            "memory::many_unfinished_bodies_are_refused_for_now_and_leave_everything_behind",
            "memory::a_body_is_paid_as_it_arrives",
        ],
    ),
    (
        "max_json_bytes",
        &[
            "limits::json_at_the_limit_is_taken_and_one_byte_more_is_not",
            "limits_beyond::json_counts_after_decompression_at_every_operation_that_takes_any",
        ],
    ),
    ("max_parameters_bytes", &["limits::parameters_beside_a_program_have_a_limit_of_their_own"]),
    (
        "max_poses",
        &[
            "forward::more_than_the_limit_is_refused_in_json_and_csv",
            "limits_beyond::absurdly_many_poses_are_refused_at_the_first_too_many",
        ],
    ),
    (
        "max_cost_s",
        &[
            "limits_beyond::work_that_costs_the_limit_is_done_and_what_costs_a_hair_more_or_absurdly_more_is_not",
        ],
    ),
    (
        "max_computations",
        &["limits_beyond::as_many_computations_run_and_wait_as_may_and_all_others_are_refused"],
    ),
    (
        "max_waiting_computations",
        &["limits_beyond::as_many_computations_run_and_wait_as_may_and_all_others_are_refused"],
    ),
    (
        "max_queued_jobs",
        &[
            "queue::a_full_queue_takes_no_more",
            "limits_beyond::of_many_jobs_posted_at_once_as_many_are_taken_as_have_room",
        ],
    ),
    (
        "max_tools_per_machine",
        &[
            "tools::a_table_takes_as_many_tools_as_it_may_and_not_one_more",
            "tools::of_many_tools_put_at_once_as_many_are_stored_as_have_room",
        ],
    ),
    (
        "max_event_streams",
        &[
            "queue::events_tell_every_state_and_end_with_the_job",
            "limits_beyond::of_many_followers_at_once_as_many_are_let_in_as_may_be",
        ],
    ),
    (
        "max_deliveries",
        &[
            "webhooks::a_dead_receiver_does_not_hold_up_the_others",
            "limits_beyond::of_many_webhooks_as_many_are_under_way_as_may_be_and_the_others_wait",
        ],
    ),
    (
        "max_deliveries_per_receiver",
        &[
            "webhooks::a_dead_receiver_does_not_hold_up_the_others",
            "limits_beyond::of_many_webhooks_as_many_are_under_way_as_may_be_and_the_others_wait",
        ],
    ),
    (
        "max_connections",
        &[
            "limits::connections_over_the_cap_are_closed_and_the_service_goes_on",
            "limits_beyond::a_crowd_of_connections_is_closed_and_those_that_were_there_are_served",
        ],
    ),
    (
        "max_result_bytes",
        &[
            "limits::a_result_at_the_limit_is_stored_and_one_byte_more_is_not",
            "limits::an_answer_at_the_limit_is_given_and_one_past_it_is_not",
        ],
    ),
    (
        "max_url_bytes",
        &["limits::an_address_at_the_limit_is_taken_one_byte_more_is_not_and_an_absurd_one_neither"],
    ),
    (
        "max_header_bytes",
        &["limits::a_header_at_the_limit_is_taken_one_byte_more_is_not_and_an_absurd_one_neither"],
    ),
    (
        "max_rate_per_s",
        &[
            "limits::a_caller_over_its_rate_waits_and_a_monitor_does_not",
            "limits_beyond::of_many_requests_at_once_as_many_pass_as_the_burst_allows",
        ],
    ),
    (
        "max_burst_requests",
        &[
            "limits::a_caller_over_its_rate_waits_and_a_monitor_does_not",
            "limits_beyond::of_many_requests_at_once_as_many_pass_as_the_burst_allows",
        ],
    ),
    ("request_timeout_s", &["service::a_handler_that_takes_too_long_is_ended_and_what_it_computes_stops"]),
    (
        "header_timeout_s",
        &[
            "limits::a_header_that_does_not_end_closes_the_connection",
            "http2::a_connection_without_a_request_is_closed",
        ],
    ),
    ("body_pause_timeout_s", &["limits::a_body_that_stops_coming_is_given_up"]),
    (
        "answer_pause_timeout_s",
        &[
            "observation::a_client_that_takes_nothing_of_its_answer_is_left",
            "http2::a_client_that_opens_no_window_for_its_answer_is_left",
        ],
    ),
    ("max_spool_bytes", &["shares::uploads_that_never_end_leave_room_in_the_spool_and_give_theirs_back"]),
    (
        "max_share_per_caller",
        &[
            "shares::one_key_that_fills_the_queue_leaves_room_for_others",
            "shares::one_key_that_follows_all_it_may_leaves_event_streams_for_others",
            "shares::a_key_whose_computations_never_end_does_not_keep_another_from_computing",
            "shares::connections_of_one_address_leave_room_for_another",
            "shares::a_share_of_everything_is_no_share",
        ],
    ),
    ("webhook_timeout_s", &["webhooks::neither_silence_nor_a_flood_holds_the_service"]),
];

const SOURCES: &[(&str, &str)] = &[
    ("forward", include_str!("forward.rs")),
    ("http2", include_str!("http2.rs")),
    ("limits", include_str!("limits.rs")),
    ("limits_beyond", include_str!("limits_beyond.rs")),
    ("memory", include_str!("memory.rs")),
    ("observation", include_str!("observation.rs")),
    ("queue", include_str!("queue.rs")),
    ("service", include_str!("service.rs")),
    ("shares", include_str!("shares.rs")),
    ("tools", include_str!("tools.rs")),
    ("webhooks", include_str!("webhooks.rs")),
];

#[test]
fn every_setting_that_limits_something_has_its_tests() {
    for (setting, _) in trunnion::config::ENVIRONMENT {
        let limits =
            setting.starts_with("max_") || (setting.ends_with("timeout_s") && *setting != "drain_timeout_s");
        let tests: Vec<_> = HELD_BY.iter().filter(|(name, _)| name == setting).collect();
        assert_eq!(tests.len(), usize::from(limits), "{setting}: what holds it at, past and far past it?");
    }
    for (setting, tests) in HELD_BY {
        assert!(trunnion::config::ENVIRONMENT.iter().any(|(name, _)| name == setting), "{setting} is gone");
        for test in *tests {
            let (file, name) = test.split_once("::").unwrap();
            let (_, source) = SOURCES.iter().find(|(known, _)| *known == file).unwrap();
            assert!(source.contains(&format!("fn {name}()")), "{setting}: there is no {test}");
            // Where the document says they stand.
            let told = include_str!("../../docs/limits.md").contains(&format!("`{file}.rs`"));
            assert!(told, "docs/limits.md does not name {file}.rs");
        }
    }
}

/// The top of a plate as a binary file of two facets.
fn plate() -> Vec<u8> {
    let corners: [[f32; 3]; 4] = [[-20.0, -5.0, 0.0], [20.0, -5.0, 0.0], [20.0, 5.0, 0.0], [-20.0, 5.0, 0.0]];
    let mut file = [vec![0; 80], 2_u32.to_le_bytes().to_vec()].concat();
    for facet in [[0, 1, 2], [0, 2, 3]] {
        let corners = facet.into_iter().flat_map(|corner: usize| corners[corner]);
        for number in [0.0, 0.0, 1.0].into_iter().chain(corners) {
            file.extend(number.to_le_bytes());
        }
        file.extend([0; 2]);
    }
    file
}

/// A program over a part, for the operation's own endpoint or for the queue.
async fn cut(app: &App, path: &str, program: &str, surface: impl Into<Body>) -> reqwest::Result<Response> {
    let form = if path == "/v1/jobs" {
        form(&cc("example-ac-table"), program)
    } else {
        let program = Part::text(program.to_owned()).file_name("a.nc");
        Form::new().text("parameters", r#"{"tool_radius_mm":5}"#).part("program", program)
    };
    let surface = Part::stream(surface).file_name("plate.stl");
    app.client.post(app.url(path)).multipart(form.part("surface", surface)).send().await
}

/// A gigabyte of one piece over and over after `head`, made as it is sent.
fn endless(head: &'static str, piece: &'static str) -> Body {
    let chunk = Bytes::from(piece.repeat((64 << 10) / piece.len()));
    let chunks = (0..(1 << 30) / chunk.len()).map(move |_| chunk.clone());
    let whole = std::iter::once(Bytes::from_static(head.as_bytes())).chain(chunks);
    Body::wrap_stream(stream::iter(whole.map(Ok::<_, std::io::Error>)))
}

#[tokio::test]
async fn a_surface_at_the_limit_is_taken_one_byte_more_is_not_and_an_absurd_one_neither() {
    let app = spawn_with(|settings| settings.max_surface_bytes = plate().len() as u64).await;
    for (path, status) in [(CC, 200), ("/v1/jobs", 202)] {
        let taken = cut(&app, path, "g1\n", plate()).await.unwrap();
        let location = taken.headers().get("location").map(|place| place.to_str().unwrap().to_owned());
        assert_eq!(taken.status(), status, "{path}: {}", taken.text().await.unwrap());
        assert_eq!(ended(&app, &location.unwrap()).await["state"], "succeeded");
        let kept = app.files();
        let more = cut(&app, path, "g1\n", [plate(), vec![0]].concat()).await.unwrap();
        problem(more, "body-too-large").await;
        // The service may answer and close while the rest is still being sent; then sending fails instead.
        if let Ok(refused) = cut(&app, path, "g1\n", endless("", "X")).await {
            problem(refused, "body-too-large").await;
        }
        assert_eq!(app.files(), kept, "{path}");
    }
}

#[tokio::test]
async fn a_surface_takes_all_the_memory_there_is_for_them_and_not_a_byte_more() {
    let takes = Mesh::memory_estimate_bytes(2);
    for (limit, fits) in [(takes, true), (takes - 1, false), (1, false)] {
        let app = spawn_with(|settings| settings.max_surface_memory_bytes = limit).await;
        for (path, status) in [(CC, 200), ("/v1/jobs", 202)] {
            let answer = cut(&app, path, "g1\n", plate()).await.unwrap();
            if fits {
                assert_eq!(answer.status(), status, "{path}");
            } else {
                let body = problem(answer, "body-too-large").await;
                let detail = body["detail"].as_str().unwrap();
                assert!(detail.contains(&format!("the limit is {limit};")), "{body}");
                assert_eq!(app.files(), (0, 0), "{path}");
            }
        }
    }
}

/// Asks all at once and waits until so many are refused: those that are left are inside, and stay there.
async fn all_but<F: Future<Output = reqwest::Result<Response>>>(
    asked: impl Iterator<Item = F>,
    refused: usize,
    words: &str,
) -> FuturesUnordered<F> {
    let mut answers: FuturesUnordered<F> = asked.collect();
    for _ in 0..refused {
        // One who is let in too many would be waited for.
        let answer = tokio::time::timeout(Duration::from_mins(1), answers.next()).await.unwrap();
        let body = problem(answer.unwrap().unwrap(), "busy").await;
        assert!(body["detail"].as_str().unwrap().contains(words), "{body}");
    }
    answers
}

/// Those that were inside, once nothing holds them.
async fn succeed<F: Future<Output = reqwest::Result<Response>>>(answers: FuturesUnordered<F>, count: usize) {
    let answers: Vec<_> = answers.collect().await;
    let succeeded = answers.iter().filter(|answer| answer.as_ref().unwrap().status() == 200).count();
    assert_eq!((succeeded, answers.len()), (count, count));
}

#[tokio::test]
async fn surfaces_share_their_memory_and_those_who_find_none_come_again() {
    let held = Arc::<Held>::default();
    // It is given out by whole MiB.
    let each = Mesh::memory_estimate_bytes(2).next_multiple_of(1 << 20);
    let app = spawn_held(&held, |settings| {
        settings.max_computations = 4;
        settings.max_surface_memory_bytes = 2 * each;
    })
    .await;
    let asked = (0..2 + FAR).map(|_| cut(&app, CC, "HOLD\n", plate()));
    let answers = all_but(asked, FAR, "memory").await;
    // What waits anyhow waits for this as well.
    let job = cut(&app, "/v1/jobs", "g1\n", plate()).await.unwrap();
    assert_eq!(job.status(), 202);
    let job = job.headers()["location"].to_str().unwrap().to_owned();
    assert_ne!(document(&app, &job).await["state"], "succeeded");
    held.release();
    succeed(answers, 2).await;
    assert_eq!(ended(&app, &job).await["state"], "succeeded");
    assert_eq!(cut(&app, CC, "g1\n", plate()).await.unwrap().status(), 200);
}

#[tokio::test]
async fn as_many_computations_run_and_wait_as_may_and_all_others_are_refused() {
    for (run, wait) in [(1, 0), (1, 2), (2, 3)] {
        for over in [1, FAR] {
            let held = Arc::<Held>::default();
            let app = spawn_held(&held, |settings| {
                settings.max_computations = run;
                settings.max_waiting_computations = wait;
                settings.max_share_per_caller = 1.0;
            })
            .await;
            let path = app.url(&format!("{CC}?tool_radius_mm=5"));
            let asked = (0..run + wait + over).map(|_| app.client.post(&path).body("HOLD\n").send());
            let answers = all_but(asked, over, "computation").await;
            held.release();
            succeed(answers, run + wait).await;
            assert_eq!(held.order().len(), run + wait, "what was refused has not begun");
            assert_eq!(app.files().1, 0);
        }
    }
}

#[tokio::test]
async fn of_many_jobs_posted_at_once_as_many_are_taken_as_have_room() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_queued_jobs = 2).await;
    let order = cc("example-ac-table");
    let first = accepted(&app, &order, "HOLD\n").await;
    running(&app, &first).await;
    let posts = (0..2 + FAR).map(|k| {
        let form = form(&order, &format!("g{k}\n"));
        app.client.post(app.url("/v1/jobs")).multipart(form).send()
    });
    let mut places = Vec::new();
    for answer in join_all(posts).await {
        let answer = answer.unwrap();
        if answer.status() == 202 {
            places.push(answer.headers()["location"].to_str().unwrap().to_owned());
        } else {
            problem(answer, "queue-full").await;
        }
    }
    // Nothing is left of those that were refused.
    assert_eq!((places.len(), app.files().0), (2, 3));
    held.release();
    for place in [vec![first], places].concat() {
        assert_eq!(ended(&app, &place).await["state"], "succeeded");
    }
    // The first is in capitals already: its result is the same file.
    assert_eq!(app.files(), (5, 0));
}

#[tokio::test]
async fn of_many_followers_at_once_as_many_are_let_in_as_may_be() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_event_streams = 2).await;
    let place = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let path = format!("{place}/events");
    let (in_order, others): (Vec<_>, Vec<_>) = join_all((0..2 + FAR).map(|_| app.get(&path)))
        .await
        .into_iter()
        .partition(|answer| answer.status() == 200);
    assert_eq!((in_order.len(), others.len()), (2, FAR));
    for other in others {
        problem(other, "busy").await;
    }
    held.release();
    for follower in in_order {
        assert!(follower.text().await.unwrap().contains("succeeded"));
    }
}

#[tokio::test]
async fn of_many_webhooks_as_many_are_under_way_as_may_be_and_the_others_wait() {
    let app = spawn_with(|settings| {
        at_once(settings);
        settings.webhook_timeout_s = 3600.0;
        settings.max_deliveries = 3;
        settings.max_deliveries_per_receiver = 2;
    })
    .await;
    let mut receivers = Vec::new();
    // The first gets as many as one may, the second what is left, the third nothing.
    for expected in [2, 1, 0] {
        let mut receiver = Receiver::saying(&[const { Reply::Silence }; 9]).await;
        let mut last = String::new();
        for _job in 0..FAR / 5 {
            last = accepted(&app, &calling(&receiver.url()), "g1\n").await;
        }
        ended(&app, &last).await;
        for _ in 0..expected {
            receiver.next().await;
        }
        receivers.push(receiver);
    }
    let text = app.get("/metrics").await.text().await.unwrap();
    let waiting = format!("trunnion_webhooks_waiting {}", 3 * (FAR / 5));
    assert!(text.lines().any(|line| line == waiting), "{text}");
    assert!(receivers.iter_mut().all(Receiver::is_quiet));
    app.stop().await;
}

#[tokio::test]
async fn a_crowd_of_connections_is_closed_and_those_that_were_there_are_served() {
    let app = spawn_with(|settings| settings.max_connections = 2).await;
    let address = app.base.trim_start_matches("http://");
    let held = [TcpStream::connect(address).await.unwrap(), TcpStream::connect(address).await.unwrap()];
    let closed = async || {
        let mut socket = TcpStream::connect(address).await.unwrap();
        let mut rest = Vec::new();
        // A reset ends the reading as well.
        drop(tokio::time::timeout(Duration::from_mins(1), socket.read_to_end(&mut rest)).await.unwrap());
        rest.is_empty()
    };
    assert!(join_all((0..FAR).map(|_| closed())).await.into_iter().all(|closed| closed));
    for mut socket in held {
        let request = "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
        socket.write_all(request.as_bytes()).await.unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).await.unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
}

#[tokio::test]
async fn of_many_requests_at_once_as_many_pass_as_the_burst_allows() {
    // One place comes back in an hour.
    let app = spawn_with(|settings| {
        settings.max_rate_per_s = 1.0 / 3600.0;
        settings.max_burst_requests = 5;
    })
    .await;
    let answers = join_all((0..5 + FAR).map(|_| app.get("/v1/version"))).await;
    let count = |status: u16| answers.iter().filter(|answer| answer.status() == status).count();
    assert_eq!((count(200), count(429)), (5, FAR));
}

/// `text` and so many spaces, compressed.
fn compressed(text: &str, spaces: usize) -> Vec<u8> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(text.as_bytes()).unwrap();
    let blank = vec![b' '; 1 << 20];
    for begin in (0..spaces).step_by(blank.len()) {
        gzip.write_all(&blank[..blank.len().min(spaces - begin)]).unwrap();
    }
    gzip.finish().unwrap()
}

#[tokio::test]
async fn json_counts_after_decompression_at_every_operation_that_takes_any() {
    const LIMIT: usize = 1 << 20;
    let app = spawn_with(|settings| settings.max_json_bytes = LIMIT as u64).await;
    let send = async |verb: reqwest::Method, path: &str, body: Vec<u8>| {
        let request = app.client.request(verb, app.url(path)).header("content-type", "application/json");
        request.header("content-encoding", "gzip").body(body).send().await.unwrap()
    };
    let empty = r#"{"joints":[]}"#;
    let at = send(reqwest::Method::POST, FORWARD, compressed(empty, LIMIT - empty.len())).await;
    assert_eq!(at.status(), 200, "{}", at.text().await.unwrap());
    let over = send(reqwest::Method::POST, FORWARD, compressed(empty, LIMIT - empty.len() + 1)).await;
    problem(over, "body-too-large").await;
    let bomb = compressed("", 40 * LIMIT);
    assert!(bomb.len() < LIMIT / 2);
    let document = description();
    let mut tried = 0;
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            if operation["requestBody"]["content"].get("application/json").is_some() {
                let path = path.replace("{machine_id}", "example-ac-table").replace("{tool_id}", "T1");
                let answer = send(method.to_uppercase().parse().unwrap(), &path, bomb.clone()).await;
                assert_eq!(answer.status(), 413, "{method} {path}");
                problem(answer, "body-too-large").await;
                tried += 1;
            }
        }
    }
    assert!(tried >= 8, "only {tried} operations");
    // The service may answer and close while the rest is still being sent; then sending fails instead.
    let plain = app.client.post(app.url(FORWARD)).header("content-type", "application/json");
    if let Ok(refused) = plain.body(endless("", " ")).send().await {
        problem(refused, "body-too-large").await;
    }
    assert_eq!(app.get("/readyz").await.status(), 200);
}

#[tokio::test]
async fn absurdly_many_poses_are_refused_at_the_first_too_many() {
    let app = spawn_with(|settings| settings.max_poses = 3).await;
    let inverse = "/v1/machines/example-ac-table/inverse-kinematics";
    for (path, head, row) in
        [(FORWARD, "X,Y,Z,A,C\n", "0,0,0,0,0\n"), (inverse, "x,y,z,i,j,k\n", "1,2,3,0,0,1\n")]
    {
        for (count, status) in [(3, 200), (4, 422)] {
            let answer = app.post_text(path, "text/csv", head.to_owned() + &row.repeat(count)).await;
            assert_eq!(answer.status(), status, "{path} {count}");
        }
        // More than the limit on bodies; the service may close while the rest is still being sent.
        let table =
            app.client.post(app.url(path)).header("content-type", "text/csv").body(endless(head, row));
        if let Ok(answer) = table.send().await {
            assert_eq!(problem(answer, "too-costly").await["line"], 5, "{path}");
        }
    }
    let joints = json!({"joints": vec![json!({"X": 0, "Y": 0, "Z": 0, "A": 0, "C": 0}); 100_000]});
    problem(app.post_json(FORWARD, &joints).await, "too-costly").await;
    let poses = json!({"poses": vec![json!({"x": 1, "y": 2, "z": 3, "i": 0, "j": 0, "k": 1}); 100_000]});
    problem(app.post_json(inverse, &poses).await, "too-costly").await;
    for (count, code) in [(3, None), (4, Some("too-costly")), (100_000, Some("too-costly"))] {
        let body = json!({"stepover_mm": vec![0.1; count], "tool_radius_mm": 5, "surface": "flat"});
        let answer = app.post_json(SCALLOP, &body).await;
        match code {
            Some(code) => drop(problem(answer, code).await),
            None => assert_eq!(answer.status(), 200),
        }
    }
}

/// Work of which the cost is told by its size alone.
#[derive(Debug, Clone, Copy)]
enum Work {
    Joints,
    Table,
    Scallops,
    Program,
    Job,
}

impl Work {
    const PROGRAM: &str = "g1 x1\n";

    fn cost_s(self, size: usize) -> f64 {
        let cost = match self {
            Self::Joints | Self::Table => Cost::of_poses(size, 0),
            Self::Scallops => Cost::of_scallops(size),
            Self::Program | Self::Job => Cost::of_program((size * Self::PROGRAM.len()) as u64, 5.0),
        };
        cost.within(0.0).unwrap_err().estimated_s
    }

    async fn ask(self, app: &App, size: usize) -> Response {
        match self {
            Self::Joints => {
                let joints = vec![json!({"X": 0, "Y": 0, "Z": 0, "A": 0, "C": 0}); size];
                app.post_json(FORWARD, &json!({ "joints": joints })).await
            }
            Self::Table => {
                let rows = "0,0,0,0,0\n".repeat(size);
                app.post_text(FORWARD, "text/csv", format!("X,Y,Z,A,C\n{rows}")).await
            }
            Self::Scallops => {
                let body = json!({"stepover_mm": vec![0.1; size], "tool_radius_mm": 5, "surface": "flat"});
                app.post_json(SCALLOP, &body).await
            }
            Self::Program => {
                let path = format!("{CC}?tool_radius_mm=5&tolerance_um=5");
                app.post_text(&path, "text/plain", Self::PROGRAM.repeat(size)).await
            }
            Self::Job => {
                let mut order = cc("example-ac-table");
                order["parameters"]["tolerance_um"] = json!(5);
                let form = form(&order, &Self::PROGRAM.repeat(size));
                app.client.post(app.url("/v1/jobs")).multipart(form).send().await.unwrap()
            }
        }
    }
}

#[tokio::test]
async fn work_that_costs_the_limit_is_done_and_what_costs_a_hair_more_or_absurdly_more_is_not() {
    for work in [Work::Joints, Work::Table, Work::Scallops, Work::Program, Work::Job] {
        let cost_s = work.cost_s(100);
        let at = spawn_with(|settings| settings.max_cost_s = cost_s).await;
        problem(work.ask(&at, 101).await, "too-costly").await;
        problem(work.ask(&at, 100_000).await, "too-costly").await;
        assert_eq!(at.files(), (0, 0), "{work:?}");
        let done = work.ask(&at, 100).await;
        assert!(done.status().is_success(), "{work:?}: {}", done.text().await.unwrap());
        if let Work::Job = work {
            // What was taken is not found to be too dear when its turn comes.
            let job: Value = done.json().await.unwrap();
            let place = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
            assert_eq!(ended(&at, &place).await["state"], "succeeded");
        }
        // The smallest limit that can be set is far below.
        for limit_s in [cost_s.next_down(), 1e-6] {
            let below = spawn_with(|settings| settings.max_cost_s = limit_s).await;
            problem(work.ask(&below, 100).await, "too-costly").await;
            assert_eq!(below.files(), (0, 0), "{work:?}");
        }
    }
}
