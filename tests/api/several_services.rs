//! Several services on one database: what one of them accepts, another one computes, follows, cancels and sends
//! (`docs/scale-out.md`). Each test does something only with `TRUNNION_TEST_DATABASE`.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use reqwest::StatusCode;
use serde_json::Value;
use tempfile::TempDir;
use trunnion::config::Settings;

use crate::database::{address_of, ask, bucket_server, schema_of, server, shared_place};
use crate::queue::{Held, accepted, cc, document, ended, form, running};
use crate::support::{App, ac_table, problem, spawn_real_in};

/// A service with files in the database or in a bucket.
pub(crate) async fn first(data: &Path, held: &Arc<Held>, change: impl FnOnce(&mut Settings)) -> App {
    let shared = |settings: &mut Settings| {
        settings.files = shared_place();
        settings.max_computations = 1;
        change(settings);
    };
    spawn_real_in(data, shared, Arc::clone(held) as _).await
}

/// Another service on the database of the first one.
pub(crate) async fn another(
    of: &Path,
    data: &Path,
    held: &Arc<Held>,
    change: impl FnOnce(&mut Settings),
) -> App {
    let address = address_of(of);
    let same = |settings: &mut Settings| {
        settings.database = address.map(|address| address.parse().unwrap());
        change(settings);
    };
    first(data, held, same).await
}

/// Two services, each with a compensator and a directory of its own.
struct Two {
    a: App,
    b: App,
    of_a: Arc<Held>,
    of_b: Arc<Held>,
    schema: String,
    /// They last as long as the services.
    kept: [TempDir; 2],
}

async fn two() -> Option<Two> {
    server()?;
    let directories = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let (of_a, of_b) = (Arc::<Held>::default(), Arc::<Held>::default());
    let a = first(directories[0].path(), &of_a, |_| {}).await;
    let b = another(directories[0].path(), directories[1].path(), &of_b, |_| {}).await;
    let schema = schema_of(directories[0].path());
    Some(Two { a, b, of_a, of_b, schema, kept: directories })
}

/// Waits until something is so, and for how long that took.
pub(crate) async fn within<F: Future<Output = bool>>(
    limit: Duration,
    what: &str,
    is_so: impl Fn() -> F,
) -> Duration {
    let began = Instant::now();
    while !is_so().await {
        assert!(began.elapsed() < limit, "{what}: not within {limit:?}");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    began.elapsed()
}

fn id(place: &str) -> &str {
    place.trim_start_matches("/v1/jobs/")
}

#[tokio::test]
async fn what_is_made_once_is_made_once_and_files_are_where_the_first_service_chose() {
    let Some(Two { a, b, schema, kept: _kept, .. }) = two().await else { return };
    let once = |table: &str| ask(&format!("SELECT count(*) FROM {schema}.{table}"));
    assert_eq!((once("machine_revisions"), once("webhook_secrets")), ("1".into(), "1".into()));
    assert_eq!(once("instances WHERE stopped_at IS NULL"), "2");
    // A service with files in its directory would not see those of the others.
    let (data, third) = (a.data.clone(), TempDir::new().unwrap());
    let address = address_of(&data).unwrap();
    let alone = || Settings {
        listen: ([127, 0, 0, 1], 0).into(),
        data_dir: third.path().to_owned(),
        database: Some(address.parse().unwrap()),
        ..Settings::default()
    };
    let refusal = |settings: Settings| async {
        let compensator = Arc::new(trunnion::jobs::CutterContactCompensator::default());
        let sources = trunnion::jobs::Sources::real();
        trunnion::cli::start(settings, sources, compensator).await.err().unwrap().to_string()
    };
    let fault = refusal(alone()).await;
    assert!(fault.contains("is in use by trunnion") && fault.contains("files = postgres"), "{fault}");
    let (_a, _b) = (a.stop().await, b.stop().await);
    assert_eq!(once("instances WHERE stopped_at IS NULL"), "0");
    let fault = refusal(alone()).await;
    assert!(fault.contains(&format!("set files = {}", shared_place())), "{fault}");
}

#[tokio::test]
async fn a_job_of_one_is_computed_by_another_and_its_files_are_everywhere() {
    let Some(Two { a, b, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    let held = accepted(&a, &cc("example-ac-table"), "HOLD\n").await;
    running(&b, &held).await;
    // One of them is busy, so the other one takes it.
    let long = format!("g1 x{}\n", "1".repeat(3 << 20));
    let place = accepted(&b, &cc("example-ac-table"), &long).await;
    let job = ended(&a, &place).await;
    assert_eq!(job["state"], "succeeded", "{job}");
    assert_eq!(of_a.order().len() + of_b.order().len(), 2);
    for app in [&a, &b] {
        let program = app.get(&format!("{place}/program")).await.text().await.unwrap();
        assert!(program == long.to_ascii_uppercase());
    }
    of_a.release();
    of_b.release();
    assert_eq!(ended(&b, &held).await["state"], "succeeded");
    let unkept = "SELECT count(*) FROM {}.jobs j WHERE NOT EXISTS
        (SELECT 1 FROM {}.files f WHERE f.whole = 1 AND f.sha256 = j.output_sha256)";
    assert_eq!(ask(&unkept.replace("{}", &schema)), "0");
    assert_eq!(ask(&format!("SELECT count(*) FROM {schema}.job_leases")), "0");
}

#[tokio::test]
async fn a_damaged_copy_is_made_again_and_a_damaged_file_is_not_sent() {
    let Some(Two { a, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    of_a.release();
    of_b.release();
    let place = accepted(&a, &cc("example-ac-table"), "g1 x1\n").await;
    let job = ended(&a, &place).await;
    let sha256 = job["output_sha256"].as_str().unwrap();
    let program = || async { a.get(&format!("{place}/program")).await };
    assert_eq!(program().await.text().await.unwrap(), "G1 X1\n");
    let copy = a.data.join("blobs").join(&sha256[..2]).join(sha256);
    std::fs::write(&copy, "G1 X9\n").unwrap();
    problem(program().await, "stored-file-damaged").await;
    assert_eq!(program().await.text().await.unwrap(), "G1 X1\n");
    if bucket_server().is_some() {
        // What becomes of objects is tried in `bucket.rs`.
        return;
    }
    std::fs::remove_file(&copy).unwrap();
    let part = format!(
        "UPDATE {schema}.file_parts SET bytes = 'G1 X8' WHERE object_key LIKE '{sha256}%'; SELECT count(*) FROM {schema}.files"
    );
    ask(&part);
    problem(program().await, "stored-file-damaged").await;
}

#[tokio::test]
async fn a_machine_changed_at_one_is_the_machine_of_a_job_accepted_at_another() {
    let Some(Two { a, b, of_a, of_b, kept: _kept, .. }) = two().await else { return };
    of_a.release();
    of_b.release();
    let mut profile = ac_table();
    for revision in 1..=5 {
        profile["name"] = Value::from(format!("revision {revision}"));
        let put = a.client.put(a.url("/v1/machines/mill")).header("if-match", "*").json(&profile);
        let put =
            if revision == 1 { a.put_machine("mill", &profile).await } else { put.send().await.unwrap() };
        assert!(put.status().is_success(), "{}", put.text().await.unwrap());
        let place = accepted(&b, &cc("mill"), "g1\n").await;
        assert_eq!(document(&b, &place).await["machine_revision"], revision);
        ended(&a, &place).await;
    }
}

#[tokio::test]
async fn a_key_revoked_at_one_is_refused_at_another_within_a_second() {
    let Some(Two { mut a, b, kept: _kept, .. }) = two().await else { return };
    let key = a.close().await;
    let other = a.new_key(&["read"], None).await;
    let status =
        || async { b.client.get(b.url("/v1/machines")).bearer_auth(&other).send().await.unwrap().status() };
    within(Duration::from_secs(1), "a new key", || async { status().await == StatusCode::OK }).await;
    let key_id = other.trim_start_matches("trn_").split('_').next().unwrap();
    let revoked =
        a.client.delete(a.url(&format!("/v1/keys/{key_id}"))).bearer_auth(&key).send().await.unwrap();
    assert!(revoked.status().is_success());
    within(Duration::from_secs(1), "a revoked key", || async { status().await == StatusCode::UNAUTHORIZED })
        .await;
}

#[tokio::test]
async fn a_job_of_one_is_followed_and_cancelled_at_another() {
    let Some(Two { a, b, of_a, of_b, kept: _kept, .. }) = two().await else { return };
    let place = accepted(&a, &cc("example-ac-table"), "HOLD\n").await;
    running(&a, &place).await;
    // Whichever computes it, the other one does not.
    let follow = |app: &App| tokio::spawn(app.client.get(app.url(&format!("{place}/events"))).send());
    let (at_a, at_b) = (follow(&a), follow(&b));
    let runs_at_a = of_a.order().len() == 1;
    let stopper = if runs_at_a { &b } else { &a };
    let cancelled = stopper.client.delete(stopper.url(&place)).send().await.unwrap();
    assert_eq!(cancelled.status(), StatusCode::ACCEPTED);
    let is_cancelled = || async { document(&a, &place).await["state"] == "cancelled" };
    within(Duration::from_secs(6), "a cancel", is_cancelled).await;
    let ended_at = Instant::now();
    for follower in [at_a, at_b] {
        let events = follower.await.unwrap().unwrap().text().await.unwrap();
        assert!(events.trim_end().ends_with(r#"{"state":"cancelled","progress":0}"#), "{events}");
    }
    assert!(ended_at.elapsed() < Duration::from_millis(1500), "{:?}", ended_at.elapsed());
    drop((of_a, of_b));
}

#[tokio::test]
async fn one_idempotency_key_at_two_services_makes_one_job() {
    let Some(Two { a, b, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    of_a.release();
    of_b.release();
    for pair in 0..25 {
        let program = format!("g1 x{pair}\n");
        let post = |app: &App| {
            app.client
                .post(app.url("/v1/jobs"))
                .header("idempotency-key", format!("pair-{pair}"))
                .multipart(form(&cc("example-ac-table"), &program))
                .send()
        };
        let (one, other) = tokio::join!(post(&a), post(&b));
        let (one, other): (Value, Value) =
            (one.unwrap().json().await.unwrap(), other.unwrap().json().await.unwrap());
        assert_eq!(one["id"], other["id"], "{one} {other}");
    }
    assert_eq!(ask(&format!("SELECT count(*) FROM {schema}.jobs")), "25");
}

#[tokio::test]
async fn a_service_that_stops_gives_its_jobs_to_another_at_once() {
    let Some(Two { a, b, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    let place = accepted(&a, &cc("example-ac-table"), "HOLD\n").await;
    running(&a, &place).await;
    let runs_at_a = of_a.order().len() == 1;
    let (stops, stays, released) = if runs_at_a { (a, b, &of_b) } else { (b, a, &of_a) };
    released.release();
    let job = id(&place).to_owned();
    let stopped = tokio::spawn(async move { stops.stop().await });
    let is_done = || async { document(&stays, &place).await["state"] == "succeeded" };
    within(Duration::from_secs(3), "a job of a service that stops", is_done).await;
    let _directory = stopped.await.unwrap();
    let deaths =
        ask(&format!("SELECT deaths + lone_deaths || ' ' || attempts FROM {schema}.jobs WHERE id = '{job}'"));
    assert_eq!(deaths, "0 1", "an orderly stop is no death, and its attempt does not count");
}

/// Makes a lease look as if its holder had not been heard of for so long.
fn age(schema: &str, job: &str, holder_too: bool) {
    ask(&format!(
        "UPDATE {schema}.job_leases SET lease_until = clock_timestamp() - INTERVAL '1 s', holder = 'gone' WHERE job_id = '{job}';
         INSERT INTO {schema}.instances (id, version, host, process, seen_at) VALUES ('gone', '', '', 0,
             clock_timestamp() - INTERVAL '{}')",
        if holder_too { "31 s" } else { "29 s" }
    ));
}

#[tokio::test]
async fn an_expired_lease_is_taken_up_and_its_late_holder_ends_nothing() {
    let Some(Two { a, b, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    let place = accepted(&a, &cc("example-ac-table"), "RUNAWAY\n").await;
    running(&a, &place).await;
    let order = || of_a.order().len() + of_b.order().len();
    within(Duration::from_secs(5), "the first computation", || async { order() == 1 }).await;
    let first = ask(&format!("SELECT lease FROM {schema}.jobs WHERE id = '{}'", id(&place)));
    age(&schema, id(&place), false);
    let lease = format!("SELECT coalesce(lease, '{first}') FROM {schema}.jobs WHERE id = '{}'", id(&place));
    within(Duration::from_secs(5), "another lease", || async { ask(&lease) != first }).await;
    let late = trunnion::store::Ending::Failed { problem: serde_json::json!({"type": "/problems/late"}) };
    let done = a.store().end_job(id(&place), &first, &late, "2026-01-01T00:00:00.000Z").await.unwrap();
    assert!(!done, "a lease that was given to another one ends nothing");
    of_a.release();
    of_b.release();
    let job = ended(&b, &place).await;
    assert_eq!((&job["state"], &job["attempts"]), (&"succeeded".into(), &2.into()), "{job}");
    assert_eq!(order(), 2, "the work of the first lease came to nothing");
    let deaths = ask(&format!("SELECT deaths + lone_deaths FROM {schema}.jobs WHERE id = '{}'", id(&place)));
    assert_eq!(deaths, "0", "its holder lives");
}

#[tokio::test]
async fn a_dead_holder_counts_only_for_who_has_reached_the_database_all_the_time() {
    let Some(Two { a, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    let now = "2026-01-01T00:00:00.000Z";
    let problem = serde_json::json!({"type": "/problems/process-died"});
    let place = accepted(&a, &cc("example-ac-table"), "RUNAWAY\n").await;
    within(Duration::from_secs(5), "a computation", || async {
        ask(&format!("SELECT count(*) FROM {schema}.job_leases WHERE computed = 'beside'")) == "1"
    })
    .await;
    age(&schema, id(&place), true);
    let unsteady = a.store().take_up_expired(false, &problem, now).await.unwrap();
    assert!(unsteady.is_empty(), "{unsteady:?}");
    let steady = a.store().take_up_expired(true, &problem, now).await.unwrap();
    assert_eq!(steady.queued, 1);
    assert_eq!(ask(&format!("SELECT deaths FROM {schema}.jobs WHERE id = '{}'", id(&place))), "1");
    of_a.release();
    of_b.release();
    ended(&a, &place).await;
}

#[tokio::test]
async fn files_that_no_job_names_go_after_a_day_and_not_before() {
    let Some(Two { a, b, of_a, of_b, schema, kept: _kept, .. }) = two().await else { return };
    of_a.release();
    of_b.release();
    let place = accepted(&a, &cc("example-ac-table"), "g1\n").await;
    ended(&b, &place).await;
    let digest = "0".repeat(64);
    ask(&format!(
        "INSERT INTO {schema}.files (object_key, sha256, length, whole) VALUES ('{digest}-1', '{digest}', 0, 1),
             ('{digest}-2', '{digest}', 5, 0)"
    ));
    let files = || ask(&format!("SELECT count(*) FROM {schema}.files"));
    assert_eq!((a.store().remove_unnamed(None).await.unwrap(), files()), (0, "4".into()));
    ask(&format!("UPDATE {schema}.files SET kept_at = kept_at - INTERVAL '25 h'"));
    assert_eq!((b.store().remove_unnamed(None).await.unwrap(), files()), (2, "2".into()));
    // And a job cannot name what is not there.
    let forged = format!(
        "INSERT INTO {schema}.jobs (id, machine_id, machine_revision, operation, parameters, state, progress, file_name,
             input_sha256, software_version, created_at)
         SELECT '{}', machine_id, machine_revision, operation, parameters, 'queued', 0, file_name, '{digest}',
             software_version, created_at FROM {schema}.jobs RETURNING id",
        "1".repeat(36)
    );
    let refused = std::panic::catch_unwind(|| ask(&forged));
    assert!(refused.is_err(), "a job names a file that is not kept");
}
