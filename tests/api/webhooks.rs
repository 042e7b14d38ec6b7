//! Webhooks: who posted a job is told of its end, signed, until it is taken or given up.

use std::path::Path;
use std::process::Stdio;
use std::sync::Arc;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use reqwest::Response;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;
use trunnion::config::Settings;
use trunnion::store::Taken;

use crate::command_line::{said as printed, trunnion};
use crate::database;
use crate::database::has_no_file;
use crate::process::binary;
use crate::queue::{Held, accepted, cc, document, ended, form, running, spawn_held};
use crate::receiver::{Receiver, Reply, connects, silent_port};
use crate::support::{App, ac_table, pointers, problem, spawn, spawn_in, spawn_with};

/// This computer may be called, and what fails is tried twice more at once.
pub(crate) fn at_once(settings: &mut Settings) {
    settings.webhook_allow = vec!["127.0.0.0/8".parse().unwrap()];
    settings.webhook_pauses_s = vec![0.0, 0.0];
}

/// The same, with these pauses between attempts \[s\].
fn pausing(pauses_s: &[f64]) -> impl Fn(&mut Settings) {
    |settings| {
        at_once(settings);
        settings.webhook_pauses_s = pauses_s.to_vec();
    }
}

pub(crate) fn calling(url: &str) -> Value {
    let mut job = cc("example-ac-table");
    job["callback_url"] = url.into();
    job
}

async fn deliveries(app: &App, place: &str) -> Value {
    app.get(&format!("{place}/deliveries")).await.json().await.unwrap()
}

/// The deliveries of a job once none waits.
async fn settled(app: &App, place: &str) -> Value {
    let mut looks = 0;
    loop {
        let found = deliveries(app, place).await;
        if found["delivery"].is_object() && found["delivery"]["state"] != "waiting" {
            return found;
        }
        looks += 1;
        assert!(looks < 100_000, "{place} is still waiting: {found}");
    }
}

/// Waits until so many attempts are written down.
async fn attempted(app: &App, place: &str, attempts: usize) {
    let mut looks = 0;
    while deliveries(app, place).await["items"].as_array().unwrap().len() != attempts {
        looks += 1;
        assert!(looks < 100_000, "there never were {attempts} attempts");
    }
}

/// Outcomes with their statuses, oldest first.
fn outcomes(deliveries: &Value) -> Vec<(String, Option<u64>)> {
    let items = deliveries["items"].as_array().unwrap().iter().rev();
    items.map(|item| (item["outcome"].as_str().unwrap().to_owned(), item["status"].as_u64())).collect()
}

fn said(outcome: &str, status: u64) -> (String, Option<u64>) {
    (outcome.to_owned(), Some(status))
}

async fn secret(app: &App) -> String {
    let shown: Value = app.get("/v1/webhooks/secret").await.json().await.unwrap();
    shown["secret"].as_str().unwrap().to_owned()
}

async fn again(app: &App, place: &str, key: &str) -> Response {
    let post = app.client.post(app.url(&format!("{place}/deliveries"))).header("idempotency-key", key);
    post.send().await.unwrap()
}

#[tokio::test]
async fn every_end_of_a_job_is_told_once_and_signed() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, at_once).await;
    let mut receiver = Receiver::saying(&[]).await;
    let order = calling(&receiver.url());
    let works = accepted(&app, &order, "HOLD\n").await;
    running(&app, &works).await;
    let waits = accepted(&app, &order, "g1\n").await;
    // Before it has ended there is nothing to tell.
    assert_eq!(deliveries(&app, &waits).await, json!({"delivery": null, "items": [], "next_cursor": null}));
    let early = problem(again(&app, &waits, "early").await, "nothing-to-deliver").await;
    assert!(early["detail"].as_str().unwrap().contains("queued"), "{early}");
    assert_eq!(app.client.delete(app.url(&waits)).send().await.unwrap().status(), 200);
    let told = receiver.next().await;
    assert_eq!(told.json()["type"], "job.cancelled");
    held.release();
    assert_eq!(receiver.next().await.json()["type"], "job.succeeded");
    let fails = accepted(&app, &order, "REFUSE\n").await;
    let told = receiver.next().await;

    // The event is the job as it is read, but for its progress.
    let mut job = document(&app, &fails).await;
    job.as_object_mut().unwrap().remove("progress");
    let event = told.json();
    assert_eq!(event["data"], job);
    assert_eq!((&event["type"], &event["timestamp"]), (&json!("job.failed"), &job["finished_at"]));
    assert_eq!(event["data"]["problem"]["type"], "/problems/program-fault");
    assert_eq!(told.line, "POST /trunnion?line=4 HTTP/1.1");
    assert_eq!(told.headers["host"], format!("127.0.0.1:{}", receiver.port));
    assert_eq!(told.headers["content-type"], "application/json");
    assert_eq!(told.id(), format!("msg_{}", job["id"].as_str().unwrap()));
    assert!(!told.id().contains('.'));
    let secret = secret(&app).await;
    assert_eq!(told.signatures(), [told.signed_by(&secret)]);

    for (place, event) in [(&works, "job.succeeded"), (&waits, "job.cancelled"), (&fails, "job.failed")] {
        let found = settled(&app, place).await;
        assert_eq!(found["delivery"]["state"], "delivered", "{found}");
        assert_eq!((&found["delivery"]["event"], &found["delivery"]["attempts"]), (&json!(event), &json!(1)));
        assert!(found["delivery"]["next_attempt_at"].is_null() && found["next_cursor"].is_null());
        assert_eq!(outcomes(&found), [said("delivered", 204)]);
        assert!(found["items"][0]["duration_ms"].is_i64(), "{found}");
    }
    assert!(receiver.is_quiet());
}

#[tokio::test]
async fn what_is_not_taken_is_sent_again_under_the_same_id() {
    let app = spawn_with(pausing(&[0.0; 6])).await;
    let elsewhere = "location: /elsewhere\r\n";
    let replies = [
        Reply::Status(500, ""),
        Reply::Hangup,
        Reply::Status(302, elsewhere),
        Reply::LongHead,
        Reply::Status(429, "retry-after: 0\r\n"),
    ];
    let mut receiver = Receiver::saying(&replies).await;
    let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
    let secret = secret(&app).await;
    let mut times = Vec::new();
    for _attempt in 0..6 {
        let told = receiver.next().await;
        assert_eq!(told.line, "POST /trunnion?line=4 HTTP/1.1");
        assert_eq!(told.id(), format!("msg_{}", place.rsplit('/').next().unwrap()));
        // Each attempt is signed anew, with its own time.
        assert_eq!(told.signatures(), [told.signed_by(&secret)]);
        times.push(told.headers["webhook-timestamp"].parse::<i64>().unwrap());
    }
    assert!(times.is_sorted() && times[0] < times[5], "{times:?}");
    let found = settled(&app, &place).await;
    let expected = [
        said("refused", 500),
        ("unreachable".to_owned(), None),
        said("refused", 302),
        ("unreachable".to_owned(), None),
        said("refused", 429),
        said("delivered", 204),
    ];
    assert_eq!(outcomes(&found), expected);
    assert!(found["items"][3]["detail"].as_str().unwrap().contains("not followed"), "{found}");
    // The log has pages like every list.
    let page: Value = app.get(&format!("{place}/deliveries?limit=4")).await.json().await.unwrap();
    let cursor = page["next_cursor"].as_str().unwrap();
    let rest: Value = app.get(&format!("{place}/deliveries?cursor={cursor}")).await.json().await.unwrap();
    assert_eq!([outcomes(&rest), outcomes(&page)].concat(), expected);
    assert!(receiver.is_quiet());
}

#[tokio::test]
async fn who_says_gone_is_left_alone_until_somebody_asks() {
    let app = spawn_with(at_once).await;
    let mut receiver = Receiver::saying(&[Reply::Status(410, "")]).await;
    let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
    let found = settled(&app, &place).await;
    assert_eq!(found["delivery"]["state"], "given-up");
    assert_eq!(outcomes(&found), [said("gone", 410)]);
    let first = receiver.next().await;
    assert!(receiver.is_quiet());

    let asked = again(&app, &place, "one").await;
    assert_eq!(asked.status(), 202);
    assert_eq!(asked.headers()["location"].to_str().unwrap(), format!("{place}/deliveries"));
    let asked: Value = asked.json().await.unwrap();
    assert_eq!(asked["webhook_id"], first.id());
    let second = receiver.next().await;
    assert_eq!((second.id(), &second.body), (first.id(), &first.body));
    let found = settled(&app, &place).await;
    assert_eq!(outcomes(&found), [said("gone", 410), said("delivered", 204)]);
    assert_eq!(
        (&found["delivery"]["state"], &found["delivery"]["attempts"]),
        (&json!("delivered"), &json!(1))
    );
    // The same key asks once; another one, once more.
    assert_eq!(again(&app, &place, "one").await.status(), 202);
    assert_eq!(deliveries(&app, &place).await, found);
    assert_eq!(again(&app, &place, "two").await.status(), 202);
    receiver.next().await;
    assert_eq!(outcomes(&settled(&app, &place).await).len(), 3);
    assert!(receiver.is_quiet());
    let log: Value = app.get("/v1/audit?action=delivery-requested").await.json().await.unwrap();
    assert_eq!(log["items"].as_array().unwrap().len(), 2, "{log}");
    assert_eq!(log["items"][0]["resource"], format!("{place}/deliveries"));
    assert_eq!(log["items"][0]["machine_id"], "example-ac-table");
    // A key that has made a job asks for nothing else.
    let post = app.client.post(app.url("/v1/jobs")).header("idempotency-key", "job");
    post.multipart(form(&calling(&receiver.url()), "g2\n")).send().await.unwrap();
    problem(again(&app, &place, "job").await, "idempotency-key-reused").await;
}

#[tokio::test]
async fn a_receiver_that_is_not_there_is_given_up_and_may_come_later() {
    let app = spawn_with(at_once).await;
    let port = silent_port().await;
    let url = format!("http://127.0.0.1:{port}/trunnion?line=4");
    let place = accepted(&app, &calling(&url), "g1\n").await;
    let found = settled(&app, &place).await;
    assert_eq!(found["delivery"]["state"], "given-up");
    assert_eq!(outcomes(&found), vec![("unreachable".to_owned(), None); 3]);
    assert!(!connects(port).await);
    let listener = TcpListener::bind(("127.0.0.1", port)).await.unwrap();
    let mut receiver = Receiver::listening(listener, &[], None);
    assert_eq!(again(&app, &place, "one").await.status(), 202);
    assert_eq!(receiver.next().await.json()["data"]["id"], document(&app, &place).await["id"]);
    assert_eq!(settled(&app, &place).await["delivery"]["state"], "delivered");
}

#[tokio::test]
async fn the_doctor_counts_what_waits_to_be_told_and_what_was_given_up() {
    if has_no_file("the_doctor_counts_what_waits_to_be_told_and_what_was_given_up") {
        return;
    }
    let directory = TempDir::new().unwrap();
    let told = |data: &Path| printed(&trunnion(data, &["doctor"]));
    let app = spawn_in(directory.path(), at_once).await;
    let url = format!("http://127.0.0.1:{}/trunnion?line=4", silent_port().await);
    for program in ["g1\n", "g2\n"] {
        let place = accepted(&app, &calling(&url), program).await;
        assert_eq!(settled(&app, &place).await["delivery"]["state"], "given-up");
    }
    app.stop().await;
    let text = told(directory.path());
    assert!(text.contains("0 are waiting for delivery, 2 were given up"), "{text}");
    let app = spawn_in(directory.path(), pausing(&[5000.0])).await;
    let place = accepted(&app, &calling(&url), "g3\n").await;
    ended(&app, &place).await;
    attempted(&app, &place, 1).await;
    app.stop().await;
    let text = told(directory.path());
    assert!(text.contains("1 are waiting for delivery, 2 were given up"), "{text}");
}

#[tokio::test]
async fn the_courier_knows_when_the_next_end_is_to_be_told() {
    let app = spawn_with(pausing(&[5000.0; 2])).await;
    let store = app.store();
    assert_eq!(store.next_delivery(&Taken::default()).await.unwrap(), None);
    let mut receiver = Receiver::saying(&[Reply::Status(500, "")]).await;
    let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
    receiver.next().await;
    attempted(&app, &place, 1).await;
    let waiting = deliveries(&app, &place).await["delivery"]["next_attempt_at"].as_str().unwrap().to_owned();
    assert_eq!(store.next_delivery(&Taken::default()).await.unwrap(), Some(waiting));
    let id = place.trim_start_matches("/v1/jobs/").to_owned();
    let without = Taken { jobs: [id].into(), ..Taken::default() };
    assert_eq!(store.next_delivery(&without).await.unwrap(), None);
}

#[tokio::test]
async fn neither_silence_nor_a_flood_holds_the_service() {
    // Where something is to be said first, there is time for it on a machine that has much else to do.
    for (reply, timeout_s, expected) in [
        (Reply::Silence, 0.2, ("timed-out".to_owned(), None)),
        // What was said counts, whatever comes after it.
        (Reply::Flood, 2.0, said("delivered", 200)),
        (Reply::Stall, 2.0, said("delivered", 200)),
    ] {
        let app = spawn_with(|settings| {
            at_once(settings);
            settings.webhook_timeout_s = timeout_s;
            settings.webhook_pauses_s = Vec::new();
        })
        .await;
        let receiver = Receiver::saying(&[reply]).await;
        let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
        assert_eq!(outcomes(&settled(&app, &place).await), [expected]);
    }
}

#[tokio::test]
async fn a_dead_receiver_does_not_hold_up_the_others() {
    let app = spawn_with(|settings| {
        at_once(settings);
        settings.webhook_timeout_s = 3600.0;
        settings.max_deliveries = 2;
        settings.max_deliveries_per_receiver = 1;
    })
    .await;
    let mut dead = Receiver::saying(&[const { Reply::Silence }; 9]).await;
    let mut good = Receiver::saying(&[]).await;
    for _job in 0..3 {
        accepted(&app, &calling(&dead.url()), "g1\n").await;
    }
    for _job in 0..3 {
        let place = accepted(&app, &calling(&good.url()), "g1\n").await;
        good.next().await;
        assert_eq!(settled(&app, &place).await["delivery"]["state"], "delivered");
    }
    // One of three is with it, and a stop does not wait for it.
    dead.next().await;
    assert!(dead.is_quiet());
    let text = app.get("/metrics").await.text().await.unwrap();
    assert!(text.lines().any(|line| line == "trunnion_webhooks_waiting 3"), "{text}");
    assert!(text.contains("\ntrunnion_webhook_attempts_total{outcome=\"delivered\"} "), "{text}");
    let oldest = text.lines().find_map(|line| line.strip_prefix("trunnion_webhooks_oldest_waiting_seconds "));
    assert!(oldest.unwrap().parse::<f64>().unwrap() > 0.0);
    app.stop().await;
}

#[tokio::test]
async fn what_waits_when_the_service_stops_is_told_by_the_next() {
    let directory = TempDir::new().unwrap();
    let mut receiver = Receiver::saying(&[Reply::Status(503, ""), Reply::Silence]).await;
    // An hour: nothing more is sent by this service.
    let app = spawn_in(directory.path(), pausing(&[3600.0])).await;
    let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
    let first = receiver.next().await;
    attempted(&app, &place, 1).await;
    app.stop().await;
    // Due further ahead than this one ever waits: the clock was wrong.
    let app = spawn_in(directory.path(), at_once).await;
    let second = receiver.next().await;
    assert_eq!(second.id(), first.id());
    // It goes on waiting for the answer when it stops, and leaves the end to be told.
    app.stop().await;
    let app = spawn_in(directory.path(), at_once).await;
    let third = receiver.next().await;
    assert_eq!((third.id(), third.json()), (first.id(), first.json()));
    let found = settled(&app, &place).await;
    assert_eq!(outcomes(&found), [said("refused", 503), said("delivered", 204)]);
    assert!(receiver.is_quiet());
}

#[tokio::test]
async fn the_end_of_what_kills_the_process_is_told_too() {
    let directory = TempDir::new().unwrap();
    let held = Arc::<Held>::default();
    let mut receiver = Receiver::saying(&[]).await;
    let place = {
        let app = crate::queue::spawn_held_in(directory.path(), &held).await;
        // Accepted by a service that may not call there, and taken as a process leaves it that dies for the fifth
        // time while it computes nothing else.
        let mut order = calling("https://mes.invalid/");
        order["machine_id"] = "example-ac-table".into();
        let place = accepted(&app, &order, "HOLD\n").await;
        running(&app, &place).await;
        app.stop().await;
        place
    };
    let left =
        "UPDATE jobs SET state = 'running', lone_deaths = 4, lease = id, callback_url = ? WHERE id = ?";
    write(directory.path(), left, &receiver.url(), &place).await;
    crate::queue_restart::mark(directory.path(), &place, "alone");
    let app = spawn_in(directory.path(), at_once).await;
    let told = receiver.next().await.json();
    assert_eq!(told["type"], "job.failed");
    assert_eq!(told["data"]["problem"]["type"], "/problems/process-died");
    assert_eq!(settled(&app, &place).await["delivery"]["state"], "delivered");
}

async fn write(data: &Path, statement: &'static str, url: &str, place: &str) {
    let id = place.rsplit('/').next().unwrap();
    let [before, between, after] = statement.split('?').collect::<Vec<_>>().try_into().unwrap();
    let statement = format!("{before}'{url}'{between}'{id}'{after}");
    assert_eq!(database::change(data, &statement).await, Ok(1));
}

#[tokio::test]
async fn nothing_private_is_taken_however_it_is_written() {
    let app = spawn().await;
    for host in [
        "127.0.0.1",
        "127.0.0.1.",
        "127.1",
        "2130706433",
        "0x7f000001",
        "0x7f.0.0.1",
        "017700000001",
        "0177.0.0.1",
        "0",
        "0.0.0.0",
        "10.0.0.7",
        "100.64.0.1",
        "169.254.169.254",
        "172.16.0.1",
        "192.168.0.1",
        "192.0.2.1",
        "198.18.0.1",
        "224.0.0.1",
        "255.255.255.255",
        "[::]",
        "[::1]",
        "[0:0:0:0:0:0:0:1]",
        "[::127.0.0.1]",
        "[::ffff:127.0.0.1]",
        "[::ffff:7f00:1]",
        "[64:ff9b::7f00:1]",
        "[2002:7f00:1::]",
        "[2001:db8::1]",
        "[fc00::1]",
        "[fe80::1]",
        "[fe80::1%25eth0]",
        "[ff02::1]",
        "localhost",
        "LOCALHOST.",
        "mes.localhost",
        "localhost.localdomain",
        "%31%32%37.0.0.1",
        "mes@127.0.0.1",
    ] {
        for url in [format!("http://{host}/x"), format!("https://{host}:8443?x")] {
            let post = app.client.post(app.url("/v1/jobs")).multipart(form(&calling(&url), "g1\n"));
            let body = problem(post.send().await.unwrap(), "invalid-request").await;
            assert_eq!(pointers(&body), ["/callback_url"], "{url}: {body}");
        }
    }
    let jobs: Value = app.get("/v1/jobs").await.json().await.unwrap();
    assert_eq!(jobs["items"], json!([]));
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn why_a_receiver_gives_no_answer_is_told_to_keys_with_admin_alone() {
    let mut app = spawn_with(pausing(&[])).await;
    app.close().await;
    let reader = app.new_key(&["read", "compute"], None).await;
    let plain = Receiver::saying(&[]).await;
    let closed = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap().port();
    let urls = [
        "http://mes.invalid/".to_owned(),
        format!("http://127.0.0.1:{closed}/"),
        format!("https://127.0.0.1:{}/", plain.port),
    ];
    let mut shown = Vec::new();
    let mut details = std::collections::BTreeSet::new();
    for url in urls {
        let place = accepted(&app, &calling(&url), "g1\n").await;
        let whole = settled(&app, &place).await;
        details.insert(whole["items"][0]["detail"].as_str().unwrap().to_owned());
        assert!(whole["items"][0]["duration_ms"].is_i64(), "{whole}");
        let asked = app.client.get(app.url(&format!("{place}/deliveries")));
        let asked = asked.header("authorization", format!("Bearer {reader}")).send().await.unwrap();
        assert_eq!(asked.status(), 200);
        let mut item = asked.json::<Value>().await.unwrap()["items"][0].clone();
        item.as_object_mut().unwrap().remove("started_at").unwrap();
        shown.push(item);
    }
    assert_eq!(details.len(), 3, "{details:?}");
    assert_eq!(shown[0]["outcome"], "unreachable");
    assert!(shown.iter().all(|item| *item == shown[0]), "{shown:?}");
    let text = app.get("/metrics").await.text().await.unwrap();
    assert!(!text.contains("tls-failed") && !text.contains("address-refused"), "{text}");
}

#[tokio::test]
async fn a_name_that_leads_nowhere_public_is_not_called() {
    // This computer may be called, but nobody can be found.
    let app = spawn_with(at_once).await;
    let place = accepted(&app, &calling("http://mes.invalid/"), "g1\n").await;
    assert_eq!(outcomes(&settled(&app, &place).await), vec![("unreachable".to_owned(), None); 3]);
    // Allowed when it was posted, and not any more: it is looked at for every attempt.
    let directory = TempDir::new().unwrap();
    let mut receiver = Receiver::saying(&[Reply::Status(500, "")]).await;
    let app = spawn_in(directory.path(), pausing(&[3600.0])).await;
    let url = format!("http://localhost:{}/", receiver.port);
    let place = accepted(&app, &calling(&url), "g1\n").await;
    receiver.next().await;
    attempted(&app, &place, 1).await;
    app.stop().await;
    let app = spawn_in(directory.path(), |settings| settings.webhook_pauses_s = vec![0.0]).await;
    let found = settled(&app, &place).await;
    assert_eq!(outcomes(&found), [said("refused", 500), ("address-refused".to_owned(), None)]);
    let detail = found["items"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("webhook_allow") && !detail.contains("127.0.0.1"), "{detail}");
    assert!(receiver.is_quiet());
}

#[tokio::test]
async fn certificates_are_looked_at() {
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    let key = PrivateKeyDer::try_from(signing_key.serialize_der()).unwrap();
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(vec![cert.der().clone()], key)
        .unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let tls = TlsAcceptor::from(Arc::new(config));
    let mut receiver = Receiver::listening(listener, &[], Some(tls));
    let url = format!("https://localhost:{}/", receiver.port);

    let stranger = spawn_with(at_once).await;
    let place = accepted(&stranger, &calling(&url), "g1\n").await;
    assert_eq!(outcomes(&settled(&stranger, &place).await), vec![("tls-failed".to_owned(), None); 3]);
    assert!(receiver.is_quiet());

    let folder = TempDir::new().unwrap();
    let file = folder.path().join("plant.pem");
    std::fs::write(&file, cert.pem()).unwrap();
    let app = spawn_with(|settings| {
        at_once(settings);
        settings.webhook_ca_file = Some(file);
    })
    .await;
    let place = accepted(&app, &calling(&url), "g1\n").await;
    let told = receiver.next().await;
    assert_eq!(told.signatures(), [told.signed_by(&secret(&app).await)]);
    assert_eq!(outcomes(&settled(&app, &place).await), [said("delivered", 204)]);
    // The certificate is not one for this name.
    let url = format!("https://127.0.0.1:{}/", receiver.port);
    let place = accepted(&app, &calling(&url), "g1\n").await;
    assert_eq!(outcomes(&settled(&app, &place).await)[0].0, "tls-failed");
}

#[tokio::test]
async fn secrets_rotate_and_sign_side_by_side() {
    let app = spawn_with(at_once).await;
    let mut receiver = Receiver::saying(&[]).await;
    let old = secret(&app).await;
    let rotate = async |key: &str| {
        let post = app.client.post(app.url("/v1/webhooks/secret/rotation")).header("idempotency-key", key);
        let answer = post.send().await.unwrap();
        assert_eq!(answer.status(), 201);
        assert_eq!(answer.headers()["cache-control"], "no-store");
        answer.json::<Value>().await.unwrap()
    };
    let shown = rotate("one").await;
    let new = shown["secret"].as_str().unwrap().to_owned();
    assert_ne!(new, old);
    let previous = &shown["previous"][0];
    assert!(previous["signs_until"].as_str() > shown["created_at"].as_str(), "{shown}");
    // The same key makes it once.
    assert_eq!(rotate("one").await["secret"], new.as_str());
    assert_eq!(secret(&app).await, new);
    // And stands for nothing else.
    let asked = json!({"name": "a key", "scopes": ["admin"]});
    let post = app.client.post(app.url("/v1/keys")).header("idempotency-key", "one").json(&asked);
    assert_eq!(post.send().await.unwrap().status(), 409);
    accepted(&app, &calling(&receiver.url()), "g1\n").await;
    let told = receiver.next().await;
    assert_eq!(told.signatures(), [told.signed_by(&new), told.signed_by(&old)]);
    let newest = rotate("two").await;
    accepted(&app, &calling(&receiver.url()), "g1\n").await;
    let told = receiver.next().await;
    let expected = [newest["secret"].as_str().unwrap(), &new, &old].map(|secret| told.signed_by(secret));
    assert_eq!(told.signatures(), expected);
    // The log says that it happened, and nothing of what it is.
    let text = app.get("/v1/audit").await.text().await.unwrap();
    let log: Value = serde_json::from_str(&text).unwrap();
    let actions: Vec<&str> =
        log["items"].as_array().unwrap().iter().map(|e| e["action"].as_str().unwrap()).collect();
    assert_eq!(actions.iter().filter(|action| **action == "webhook-secret-rotated").count(), 2);
    assert_eq!(actions.last().copied(), Some("machine-created"));
    assert!(actions.contains(&"webhook-secret-created"));
    assert!(!text.contains("whsec_"), "{text}");
    // It outlives the service, and the first is made once.
    let directory = app.stop().await.unwrap();
    let app = spawn_in(directory.path(), at_once).await;
    assert_eq!(secret(&app).await, newest["secret"].as_str().unwrap());
}

#[tokio::test]
async fn the_command_line_shows_and_rotates_the_secret_beside_the_service() {
    let directory = TempDir::new().unwrap();
    let command = |word: &str| {
        let output = binary(&directory).args(["webhooks", word]).stderr(Stdio::piped()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.starts_with("whsec_") && text.lines().count() == 1, "{text}");
        text.trim().to_owned()
    };
    // Before the first start as well, in a directory that is there.
    std::fs::create_dir(directory.path().join("data")).unwrap();
    database::put_on_the_server(&directory.path().join("data"));
    let first = command("secret");
    let app = spawn_in(&directory.path().join("data"), at_once).await;
    assert_eq!(secret(&app).await, first);
    let second = command("rotate");
    assert_ne!(second, first);
    assert_eq!((secret(&app).await, command("secret")), (second.clone(), second.clone()));
    let mut receiver = Receiver::saying(&[]).await;
    accepted(&app, &calling(&receiver.url()), "g1\n").await;
    let told = receiver.next().await;
    assert_eq!(told.signatures(), [told.signed_by(&second), told.signed_by(&first)]);
}

#[tokio::test]
async fn a_key_sees_the_deliveries_of_its_machines_alone() {
    let mut app = spawn_with(at_once).await;
    app.close().await;
    assert_eq!(app.put_machine("mine", &ac_table()).await.status(), 201);
    let mut receiver = Receiver::saying(&[]).await;
    let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
    receiver.next().await;
    settled(&app, &place).await;
    let stranger = app.new_key(&["read", "compute"], Some(&["mine"])).await;
    let path = app.url(&format!("{place}/deliveries"));
    let client = reqwest::Client::builder().no_proxy().build().unwrap();
    problem(client.get(&path).bearer_auth(&stranger).send().await.unwrap(), "job-not-found").await;
    problem(client.post(&path).bearer_auth(&stranger).send().await.unwrap(), "job-not-found").await;
    let reader = app.new_key(&["read"], None).await;
    assert_eq!(client.get(&path).bearer_auth(&reader).send().await.unwrap().status(), 200);
    problem(client.post(&path).bearer_auth(&reader).send().await.unwrap(), "scope-missing").await;
    let secret = app.url("/v1/webhooks/secret");
    problem(client.get(&secret).bearer_auth(&reader).send().await.unwrap(), "scope-missing").await;
    assert!(receiver.is_quiet());
}

#[tokio::test]
async fn a_job_without_a_callback_tells_nobody() {
    let app = spawn_with(at_once).await;
    let short = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    let answer = app.post_text(short, "text/plain", "g1 x1\n").await;
    let short = answer.headers()["location"].to_str().unwrap().to_owned();
    let posted = accepted(&app, &cc("example-ac-table"), "g1\n").await;
    ended(&app, &posted).await;
    for place in [short, posted] {
        assert_eq!(
            deliveries(&app, &place).await,
            json!({"delivery": null, "items": [], "next_cursor": null})
        );
        let refused = problem(again(&app, &place, "one").await, "nothing-to-deliver").await;
        assert!(refused["detail"].as_str().unwrap().contains("callback_url"), "{refused}");
    }
    problem(app.get("/v1/jobs/none/deliveries").await, "job-not-found").await;
    problem(again(&app, "/v1/jobs/none", "two").await, "job-not-found").await;
}

#[tokio::test]
async fn a_job_whose_end_is_still_to_be_told_is_not_forgotten() {
    let directory = TempDir::new().unwrap();
    let mut receiver = Receiver::saying(&[Reply::Status(500, "")]).await;
    let hourly = pausing(&[86_400.0]);
    let app = spawn_in(directory.path(), &hourly).await;
    let place = accepted(&app, &calling(&receiver.url()), "g1\n").await;
    receiver.next().await;
    attempted(&app, &place, 1).await;
    app.stop().await;
    // Ended long ago, and due far ahead.
    let aged = "UPDATE jobs SET finished_at = '2020-01-01T00:00:00.000Z', callback_url = ? WHERE id = ?";
    write(directory.path(), aged, &receiver.url(), &place).await;
    let app = spawn_in(directory.path(), |settings| {
        hourly(settings);
        settings.job_retention_s = 1.0;
    })
    .await;
    assert_eq!(deliveries(&app, &place).await["delivery"]["state"], "waiting");
    app.stop().await;
    let app = spawn_in(directory.path(), at_once).await;
    receiver.next().await;
    settled(&app, &place).await;
    app.stop().await;
    // Now it goes, and all that was said of it.
    let app = spawn_in(directory.path(), |settings| settings.job_retention_s = 1.0).await;
    let mut looks = 0;
    while app.get(&place).await.status() != 404 {
        looks += 1;
        assert!(looks < 100_000, "{place} is still there");
    }
    problem(app.get(&format!("{place}/deliveries")).await, "job-not-found").await;
}

#[tokio::test]
async fn what_may_be_called_is_checked_at_the_start() {
    let directory = TempDir::new().unwrap();
    for (flag, value, word) in [
        ("--webhook-allow", "10.0.0.0/33", "10.0.0.0/33"),
        ("--webhook-pauses-s", "-1", "webhook_pauses_s"),
        ("--webhook-ca-file", "nowhere.pem", "nowhere.pem"),
        ("--max-deliveries", "0", "max_deliveries"),
    ] {
        let flag = format!("{flag}={value}");
        let output = binary(&directory)
            .args(["serve", "--listen", "127.0.0.1:0", &flag])
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert!(!output.status.success(), "{flag}");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains(word), "{text}");
    }
    let shown = binary(&directory)
        .args([
            "config",
            "show",
            "--webhook-allow",
            "10.0.0.0/8,*.plant.local",
            "--webhook-pauses-s",
            "1,2.5",
        ])
        .output()
        .unwrap();
    let text = String::from_utf8(shown.stdout).unwrap();
    assert!(text.contains("webhook_allow = [\"10.0.0.0/8\",\"*.plant.local\"]"), "{text}");
    assert!(text.contains("webhook_pauses_s = [1.0,2.5]"), "{text}");
}
