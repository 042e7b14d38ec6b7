//! Jobs that are posted: accepted, computed in their turn, followed, cancelled, refused.

use std::io::{Read, Write};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use reqwest::Response;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};
use trunnion::config::Settings;
use trunnion::jobs::{
    Compensated, Compensator, CompensatorFault, CutterContactCompensator, Refusal, RefusalClass,
};
use trunnion::machine::Machine;
use trunnion::process::{self, ProgramSource, SingularityParameters, StepStore, Stop};
use trunnion::side_by_side::SideBySide;
use trunnion::wire::{CcParameters, CcReport};

use crate::support::{
    App, ac_table, compensated, pointers, problem, spawn, spawn_real, spawn_real_in, spawn_real_with,
    spawn_with,
};

/// A compensator that notes in which order programs come, holds those that begin with `HOLD` until it is released or
/// told to stop, and those that begin with `RUNAWAY` until it is released. What begins with `SPIN` computes until it
/// is told to stop.
#[derive(Debug, Default)]
pub(crate) struct Held {
    released: Mutex<bool>,
    changed: Condvar,
    order: Mutex<Vec<String>>,
}

impl Held {
    pub(crate) fn release(&self) {
        *self.released.lock().unwrap() = true;
        self.changed.notify_all();
    }

    pub(crate) fn order(&self) -> Vec<String> {
        self.order.lock().unwrap().clone()
    }

    /// Waits until released, or until `stop` breaks.
    fn wait(&self, stop: impl Fn() -> bool) -> bool {
        // A computation may rest in its look at its stop: nothing is locked meanwhile.
        while !stop() {
            let released = self.released.lock().unwrap();
            if *released || *self.changed.wait_timeout(released, Duration::from_millis(5)).unwrap().0 {
                return true;
            }
        }
        false
    }
}

impl Compensator for Held {
    fn compensate(
        &self,
        _machine: &Machine,
        _asked: &process::CcParameters,
        _singularity: &SingularityParameters,
        source: &dyn ProgramSource,
        output: &mut (dyn Write + Send),
        _spool: &dyn StepStore,
        _parts: &dyn SideBySide,
        stop: &Stop<'_>,
    ) -> Result<Compensated, CompensatorFault> {
        let mut text = String::new();
        source.open()?.read_to_string(&mut text)?;
        self.order.lock().unwrap().push(text.trim().to_owned());
        if text.starts_with("HOLD") && !self.wait(|| stop().is_break()) {
            return Err(CompensatorFault::Cancelled);
        }
        if text.starts_with("SPIN") {
            while stop().is_continue() {
                std::hint::spin_loop();
            }
            return Err(CompensatorFault::Cancelled);
        }
        if text.starts_with("RUNAWAY") {
            self.wait(|| false);
        }
        if text.starts_with("REFUSE") {
            return Err(CompensatorFault::Refused(Box::new(Refusal {
                class: RefusalClass::Program,
                detail: "told to refuse".to_owned(),
                line: Some(1),
                block: Some("REFUSE".to_owned()),
                errors: Vec::new(),
            })));
        }
        assert!(!text.starts_with("PANIC"), "told to break");
        output.write_all(text.to_ascii_uppercase().as_bytes())?;
        Ok(compensated(1))
    }

    fn figure(&self, _parameters: &CcParameters, _report: &CcReport) -> String {
        "<svg xmlns=\"http://www.w3.org/2000/svg\"/>".to_owned()
    }
}

/// One place for computations, so that one held job holds the queue.
fn one_place(settings: &mut Settings) {
    settings.max_computations = 1;
}

pub(crate) async fn spawn_held(held: &Arc<Held>, change: impl FnOnce(&mut Settings)) -> App {
    let change = |settings: &mut Settings| {
        one_place(settings);
        change(settings);
    };
    spawn_real_with(change, Arc::clone(held) as Arc<dyn Compensator>).await
}

pub(crate) async fn spawn_held_in(data: &Path, held: &Arc<Held>) -> App {
    spawn_real_in(data, one_place, Arc::clone(held) as Arc<dyn Compensator>).await
}

pub(crate) fn cc(machine: &str) -> Value {
    json!({"machine_id": machine, "operation": "cc-compensation", "parameters": {"tool_radius_mm": 5}})
}

pub(crate) fn form(job: &Value, program: &str) -> Form {
    let program = Part::text(program.to_owned()).file_name("blade.nc");
    Form::new().text("job", job.to_string()).part("program", program)
}

async fn post(app: &App, job: &Value, program: &str) -> Response {
    app.client.post(app.url("/v1/jobs")).multipart(form(job, program)).send().await.unwrap()
}

/// Posts a job that is accepted: its place.
pub(crate) async fn accepted(app: &App, job: &Value, program: &str) -> String {
    let response = post(app, job, program).await;
    let status = response.status();
    let place = response.headers().get("location").map(|place| place.to_str().unwrap().to_owned());
    let document: Value = response.json().await.unwrap();
    assert_eq!(status, 202, "{document}");
    let place = place.unwrap();
    assert_eq!(place, format!("/v1/jobs/{}", document["id"].as_str().unwrap()));
    assert_eq!((&document["state"], &document["progress"]), (&"queued".into(), &0.0.into()), "{document}");
    place
}

pub(crate) async fn document(app: &App, place: &str) -> Value {
    app.get(place).await.json().await.unwrap()
}

/// The job once it has ended: its events end with it.
pub(crate) async fn ended(app: &App, place: &str) -> Value {
    app.get(&format!("{place}/events")).await.text().await.unwrap();
    let job = document(app, place).await;
    let state = job["state"].as_str().unwrap();
    assert!(["succeeded", "failed", "cancelled"].contains(&state), "{job}");
    job
}

/// Waits until a job is being computed.
pub(crate) async fn running(app: &App, place: &str) {
    let mut looks = 0;
    while document(app, place).await["state"] != "running" {
        looks += 1;
        assert!(looks < 10_000, "{place} never ran");
    }
}

const PROGRAM: &str = "G90 G21 G94
G0 X0.000 Y0.000 Z50.000 A0.000 C0.000
G1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000
G1 X20.000 Y5.000 Z-2.000 A25.000 C60.000
G1 X40.000 Y0.000 Z0.000 A30.000 C95.000
M30
";

#[tokio::test]
async fn a_job_of_every_operation_makes_what_its_own_endpoint_makes() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let tools = json!({"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.95}, "contact": "feed-plane"});
    for (operation, mut parameters) in [
        ("cc-compensation", json!({"tool_radius_mm": 5, "contact": "tip", "tolerance_um": 7.5})),
        ("wear-compensation", tools.clone()),
        ("compensation", json!({"wear": tools, "location_errors": true, "cc": {"tolerance_um": 10}})),
        (
            "verification",
            json!({"tool": {"radius_mm": 5}, "samples": 2000,
                "surface": {"kind": "plane", "length_mm": 40, "width_mm": 10}}),
        ),
        ("servo-simulation", json!({"interpolation": "tcp", "position_gain_scale": {"X": 1.1}})),
    ] {
        parameters["work_offset_mm"] = json!([0, 0, 0]);
        let parts = |name: &'static str, text: &Value| {
            Form::new()
                .text(name, text.to_string())
                .part("program", Part::text(PROGRAM).file_name("blade.nc"))
        };
        let path = app.url(&format!("/v1/machines/example-ac-table/{operation}"));
        let own = app.client.post(path).multipart(parts("parameters", &parameters)).send().await.unwrap();
        let own_place = own.headers().get("location").map(|place| place.to_str().unwrap().to_owned());
        let Some(own_place) = own_place else {
            panic!("{operation}: {}", own.text().await.unwrap());
        };
        let own = document(&app, &own_place).await;
        let order = json!({"machine_id": "example-ac-table", "operation": operation, "parameters": parameters,
            "external_id": "WO-4711/20"});
        let place = accepted(&app, &order, PROGRAM).await;
        let job = ended(&app, &place).await;
        assert_eq!(job["state"], "succeeded", "{job}");
        for member in
            ["operation", "parameters", "machine_revision", "input_sha256", "output_sha256", "changes_sha256"]
        {
            assert_eq!(job[member], own[member], "{operation} {member}");
        }
        let own_report = app.get(&format!("{own_place}/report")).await.text().await.unwrap();
        assert_eq!(
            app.get(&format!("{place}/report")).await.text().await.unwrap(),
            own_report,
            "{operation}"
        );
        assert_eq!((&job["progress"], &job["attempts"]), (&1.0.into(), &1.into()), "{job}");
        assert_eq!(job["external_id"], "WO-4711/20");
        assert!(job["started_at"].is_string() && job["finished_at"].is_string(), "{job}");
        assert_eq!(app.get(&format!("{place}/plot")).await.status(), 200, "{operation}");
    }
    assert_eq!(app.files().1, 0);
}

#[tokio::test]
async fn a_key_makes_a_job_once() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_queued_jobs = 1).await;
    let post = |program: &'static str| {
        app.client
            .post(app.url("/v1/jobs"))
            .header("idempotency-key", "order 7")
            .multipart(form(&cc("example-ac-table"), program))
            .send()
    };
    let first = post("HOLD\n").await.unwrap();
    let place = first.headers()["location"].clone();
    running(&app, place.to_str().unwrap()).await;
    // The queue may be full by now: what was accepted is answered again.
    accepted(&app, &cc("example-ac-table"), "g1\n").await;
    let again = post("HOLD\n").await.unwrap();
    assert_eq!((again.status().as_u16(), &again.headers()["location"]), (202, &place));
    problem(post("g2\n").await.unwrap(), "idempotency-key-reused").await;
    held.release();
    ended(&app, place.to_str().unwrap()).await;
    let again = post("HOLD\n").await.unwrap();
    assert_eq!(again.headers()["location"], place);
    let again: Value = again.json().await.unwrap();
    assert_eq!(again["state"], "succeeded", "{again}");
}

#[tokio::test]
async fn what_cannot_be_a_job_is_refused_and_leaves_nothing() {
    let app = spawn_with(|settings| settings.max_cost_s = 0.01).await;
    let changed = |change: fn(&mut Value)| {
        let mut job = cc("example-ac-table");
        change(&mut job);
        job
    };
    for (job, pointer) in [
        (changed(|job| job["parameters"] = json!({"tool_radius_mm": -5})), "/parameters/tool_radius_mm"),
        (changed(|job| job["parameters"]["tool_radius"] = 5.into()), "/parameters/tool_radius"),
        (changed(|job| job["parameters"]["tolerance_um"] = "5".into()), "/parameters/tolerance_um"),
        (changed(|job| job["parameters"] = json!([5])), "/parameters"),
        (changed(|job| job["operation"] = "milling".into()), "/operation"),
        (changed(|job| job["machine"] = "x".into()), "/machine"),
        (changed(|job| job["external_id"] = "".into()), "/external_id"),
        (changed(|job| job["external_id"] = "x".repeat(201).into()), "/external_id"),
        (changed(|job| job["callback_url"] = "ftp://mes".into()), "/callback_url"),
        (changed(|job| drop(job.as_object_mut().unwrap().remove("parameters"))), "/parameters"),
    ] {
        let body = problem(post(&app, &job, "g1\n").await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{body}");
    }
    problem(post(&app, &cc("nobodys"), "g1\n").await, "machine-not-found").await;
    problem(post(&app, &cc("example-ac-table"), &"g1\n".repeat(100_000)).await, "too-costly").await;
    let send = |form: Form| app.client.post(app.url("/v1/jobs")).multipart(form).send();
    let text = || cc("example-ac-table").to_string();
    for (form, pointer) in [
        (Form::new().part("program", Part::text("g1\n")), "/job"),
        (Form::new().text("job", text()), "/program"),
        (Form::new().text("job", text()).text("job", text()), "/job"),
        (Form::new().text("job", text()).text("parameters", "{}"), "/parameters"),
    ] {
        let body = problem(send(form).await.unwrap(), "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{body}");
    }
    let twice = text().replacen("{\"tool", "{\"tool_radius_mm\":4,\"tool", 1);
    let body = problem(send(Form::new().text("job", twice)).await.unwrap(), "invalid-request").await;
    assert_eq!(pointers(&body), ["/parameters/tool_radius_mm"], "{body}");
    problem(send(Form::new().text("job", "{")).await.unwrap(), "unreadable-json").await;
    let mut servo = cc("example-ac-table");
    (servo["operation"], servo["parameters"]) = ("servo-simulation".into(), json!({}));
    let with_surface = form(&servo, "g1\n").part("surface", Part::text("solid\nendsolid\n"));
    let body = problem(send(with_surface).await.unwrap(), "invalid-request").await;
    assert_eq!(pointers(&body), ["/surface"], "{body}");
    problem(app.post_json("/v1/jobs", &cc("example-ac-table")).await, "unsupported-media-type").await;
    let jobs: Value = app.get("/v1/jobs").await.json().await.unwrap();
    assert_eq!((jobs["items"].as_array().unwrap().len(), app.files()), (0, (0, 0)));
}

#[tokio::test]
async fn a_refused_program_fails_with_the_problem_of_the_request() {
    let app = spawn().await;
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    let refused = problem(app.post_text(path, "text/plain", "g1\nREFUSE\n").await, "program-fault").await;
    let place = accepted(&app, &cc("example-ac-table"), "g1\nREFUSE\n").await;
    let job = ended(&app, &place).await;
    assert_eq!((&job["state"], &job["problem"]), (&"failed".into(), &refused), "{job}");
    assert_eq!(job["problem"]["line"], 2);
    let body = problem(app.get(&format!("{place}/report")).await, "job-not-succeeded").await;
    assert!(body["detail"].as_str().unwrap().contains("failed"), "{body}");
    // A computation that breaks breaks its job alone.
    let broken = accepted(&app, &cc("example-ac-table"), "PANIC\n").await;
    let job = ended(&app, &broken).await;
    assert_eq!((&job["state"], &job["problem"]["type"]), (&"failed".into(), &"/problems/internal".into()));
    let sound = accepted(&app, &cc("example-ac-table"), "g1\n").await;
    assert_eq!(ended(&app, &sound).await["state"], "succeeded");
}

#[tokio::test]
async fn a_full_queue_takes_no_more() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_queued_jobs = 2).await;
    let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &first).await;
    let second = accepted(&app, &cc("example-ac-table"), "a\n").await;
    accepted(&app, &cc("example-ac-table"), "b\n").await;
    problem(post(&app, &cc("example-ac-table"), "c\n").await, "queue-full").await;
    held.release();
    ended(&app, &second).await;
    accepted(&app, &cc("example-ac-table"), "c\n").await;
}

#[tokio::test]
async fn machines_are_served_in_turn() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |_| {}).await;
    for machine in ["two", "three"] {
        app.put_machine(machine, &ac_table()).await;
    }
    let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &first).await;
    let mut places = Vec::new();
    for (machine, program) in [
        ("example-ac-table", "one a\n"),
        ("example-ac-table", "one b\n"),
        ("example-ac-table", "one c\n"),
        ("two", "two a\n"),
        ("two", "two b\n"),
        ("three", "three a\n"),
    ] {
        places.push(accepted(&app, &cc(machine), program).await);
    }
    held.release();
    for place in &places {
        ended(&app, place).await;
    }
    assert_eq!(held.order(), ["HOLD", "two a", "three a", "one a", "two b", "one b", "one c"]);
}

#[tokio::test]
async fn requests_are_served_beside_a_job_that_runs() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_computations = 2).await;
    let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let second = accepted(&app, &cc("example-ac-table"), "HOLD too\n").await;
    running(&app, &first).await;
    // One place of two is left to requests, however long the queue is.
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    assert_eq!(app.post_text(path, "text/plain", "g1\n").await.status(), 200);
    assert_eq!(document(&app, &second).await["state"], "queued");
    held.release();
    assert_eq!(ended(&app, &second).await["state"], "succeeded");
}

#[tokio::test]
async fn jobs_are_cancelled_before_and_while_they_run() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |_| {}).await;
    let cancel = |place: &str| app.client.delete(app.url(place)).send();
    let runs = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    let waits = accepted(&app, &cc("example-ac-table"), "g1\n").await;
    let after = accepted(&app, &cc("example-ac-table"), "g2\n").await;
    running(&app, &runs).await;
    for _twice in 0..2 {
        let cancelled = cancel(&waits).await.unwrap();
        assert_eq!(cancelled.status(), 200);
        let job: Value = cancelled.json().await.unwrap();
        assert_eq!((&job["state"], job["finished_at"].is_string()), (&"cancelled".into(), true), "{job}");
    }
    assert_eq!(cancel(&runs).await.unwrap().status(), 202);
    assert_eq!(ended(&app, &runs).await["state"], "cancelled");
    assert_eq!(ended(&app, &after).await["state"], "succeeded");
    assert_eq!(document(&app, &waits).await["state"], "cancelled");
    problem(cancel(&after).await.unwrap(), "job-ended").await;
    problem(cancel("/v1/jobs/none").await.unwrap(), "job-not-found").await;
    assert_eq!(held.order(), ["HOLD", "g2"]);
    for place in [&runs, &waits] {
        let body = problem(app.get(&format!("{place}/program")).await, "job-not-succeeded").await;
        assert!(body["detail"].as_str().unwrap().contains("cancelled"), "{body}");
    }
    assert_eq!(app.files().1, 0);
}

/// The events of a text: name, id, data.
fn events(text: &str) -> Vec<(String, String, Value)> {
    let field = |event: &str, name: &str| {
        let line = event.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default();
        line.trim_start_matches(':').trim().to_owned()
    };
    let events = text.split("\n\n").filter(|event| event.contains("event:"));
    events
        .map(|event| {
            let data = serde_json::from_str(&field(event, "data")).unwrap();
            (field(event, "event"), field(event, "id"), data)
        })
        .collect()
}

#[tokio::test]
async fn events_tell_every_state_and_end_with_the_job() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_event_streams = 2).await;
    let first = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &first).await;
    let place = accepted(&app, &cc("example-ac-table"), "g1\n").await;
    let path = format!("{place}/events");
    let stream = app.get(&path).await;
    assert_eq!(stream.headers()["content-type"], "text/event-stream");
    let other = app.get(&path).await;
    problem(app.get(&path).await, "busy").await;
    // A client that leaves makes room for another.
    drop(other);
    let mut freed = false;
    for _ in 0..10_000 {
        freed = app.get(&path).await.status() == 200;
        if freed {
            break;
        }
    }
    assert!(freed);
    held.release();
    let told = events(&stream.text().await.unwrap());
    let states: Vec<_> = told.iter().filter(|(event, ..)| event == "state").collect();
    // How fast it ran decides whether its running was seen.
    let said = |data: &Value| (data["state"].clone(), data["progress"].as_f64().unwrap());
    assert_eq!(said(&states[0].2), ("queued".into(), 0.0));
    let (_, last_id, last) = states.last().unwrap();
    assert_eq!(said(last), ("succeeded".into(), 1.0));
    let shares: Vec<f64> = told.iter().map(|(.., data)| data["progress"].as_f64().unwrap()).collect();
    assert!(shares.is_sorted(), "{shares:?}");
    // Who knows the end is not told again, who does not is.
    let with = |id: String| app.client.get(app.url(&path)).header("last-event-id", id).send();
    assert_eq!(with(last_id.clone()).await.unwrap().status(), 204);
    let told = events(&with("queued-0".to_owned()).await.unwrap().text().await.unwrap());
    assert_eq!(told.len(), 1);
    problem(app.get("/v1/jobs/none/events").await, "job-not-found").await;
    let json = app.client.get(app.url(&path)).header("accept", "application/json").send().await.unwrap();
    problem(json, "not-acceptable").await;
}

#[tokio::test]
async fn a_key_posts_jobs_for_its_machines_alone_and_the_audit_log_names_it() {
    let held = Arc::<Held>::default();
    let mut app = spawn_held(&held, |_| {}).await;
    app.close().await;
    for machine in ["mine", "theirs"] {
        assert_eq!(app.put_machine(machine, &ac_table()).await.status(), 201);
    }
    let key = app.new_key(&["read", "compute"], Some(&["mine"])).await;
    let stranger = reqwest::Client::builder().no_proxy().build().unwrap();
    let post = |machine: &str| {
        let form = form(&cc(machine), "HOLD\n");
        stranger.post(app.url("/v1/jobs")).bearer_auth(&key).multipart(form).send()
    };
    let [theirs, nowhere] = [post("theirs").await.unwrap(), post("nowhere").await.unwrap()];
    problem(theirs, "machine-not-found").await;
    problem(nowhere, "machine-not-found").await;
    assert_eq!(app.files(), (0, 0));
    let mine = post("mine").await.unwrap();
    assert_eq!(mine.status(), 202);
    let place = mine.headers()["location"].to_str().unwrap().to_owned();
    running(&app, &place).await;
    for _twice in 0..2 {
        stranger.delete(app.url(&place)).bearer_auth(&key).send().await.unwrap();
    }
    assert_eq!(ended(&app, &place).await["state"], "cancelled");
    let log: Value = app.get("/v1/audit?machine_id=mine").await.json().await.unwrap();
    let entries = log["items"].as_array().unwrap();
    let about = |entry: &&Value| entry["resource"] == place.as_str();
    let done: Vec<_> = entries.iter().filter(about).map(|entry| entry["action"].as_str().unwrap()).collect();
    assert_eq!(done, ["job-cancelled", "job-created"], "{log}");
    assert!(
        entries.iter().filter(about).all(|entry| key.contains(entry["key_id"].as_str().unwrap())),
        "{log}"
    );
    let text = app.get("/metrics").await.text().await.unwrap();
    for line in ["trunnion_jobs_queued 0", "trunnion_jobs_running 0", "trunnion_jobs_oldest_queued_seconds 0"]
    {
        assert!(text.lines().any(|found| found == line), "{text}");
    }
}

#[tokio::test]
async fn whoever_loses_the_key_is_told_no_more_of_a_job() {
    let held = Arc::<Held>::default();
    let mut app = spawn_held(&held, |_| {}).await;
    let place = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &place).await;
    let stranger = reqwest::Client::builder().no_proxy().build().unwrap();
    let follow = async |key: &str| {
        let follow = stranger.get(app.url(&format!("{place}/events"))).bearer_auth(key);
        let following = follow.send().await.unwrap();
        assert_eq!(following.status(), 200);
        following
    };
    // Let in without a key, before there was one.
    let open = follow("").await;
    app.close().await;
    let follow = async |key: &str| {
        let follow = stranger.get(app.url(&format!("{place}/events"))).bearer_auth(key);
        let following = follow.send().await.unwrap();
        assert_eq!(following.status(), 200);
        following
    };
    open.text().await.unwrap();
    // Revoked while it follows.
    let (goes, stays) = (app.new_key(&["read"], None).await, app.new_key(&["read"], None).await);
    let [gone, still] = [follow(&goes).await, follow(&stays).await];
    let id = goes.split('_').nth(1).unwrap();
    let revoked = app.client.delete(app.url(&format!("/v1/keys/{id}"))).send().await.unwrap();
    assert_eq!(revoked.status(), 204);
    assert!(!gone.text().await.unwrap().contains("succeeded"));
    // Ended while it follows: the clock of tests goes on with every look at it.
    let ends = jiff::Timestamp::from_second(1_772_000_000 + 600).unwrap();
    let body = json!({"name": "for a while", "scopes": ["read"], "expires_at": ends.to_string()});
    let made: Value = app.post_json("/v1/keys", &body).await.json().await.unwrap();
    let ended_key = follow(made["key"].as_str().unwrap()).await;
    let clock = async {
        for _look in 0..600 {
            app.get("/v1/webhooks/secret").await;
        }
    };
    clock.await;
    assert!(!ended_key.text().await.unwrap().contains("succeeded"));
    held.release();
    assert!(still.text().await.unwrap().contains("succeeded"));
}
