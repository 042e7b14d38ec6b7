//! A running service, and short ways to ask it something.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use reqwest::header::{AUTHORIZATION, HeaderMap, HeaderValue};
use reqwest::{Client, Response, StatusCode};
use serde_json::{Value, json};
use tempfile::TempDir;
use trunnion::cli::{Running, start};
use trunnion::config::Settings;
use trunnion::jobs::{
    Clock, Compensated, Compensator, CompensatorFault, IdSource, Refusal, RefusalClass, Sources,
};
use trunnion::machine::Machine;
use trunnion::process::{self, ProgramReading, ProgramSource, SingularityParameters, StepStore, Stop};
use trunnion::program::{self, Steps};
use trunnion::side_by_side::SideBySide;
use trunnion::store::Store;
use trunnion::wire::{
    CcFindings, CcParameters, CcReport, Contact, DeviationSeries, DeviationSummary, Dialect, Fault,
    Interpolation,
};

use crate::database;
use crate::description::in_full;

/// A running service.
pub(crate) struct App {
    pub(crate) client: Client,
    pub(crate) base: String,
    pub(crate) data: PathBuf,
    running: Running,
    directory: Option<TempDir>,
}

/// A service in a new directory.
pub(crate) async fn spawn() -> App {
    spawn_with(|_| {}).await
}

/// A service in a new directory with changed settings.
pub(crate) async fn spawn_with(change: impl FnOnce(&mut Settings)) -> App {
    let directory = TempDir::new().unwrap();
    let mut app = spawn_in(directory.path(), change).await;
    app.directory = Some(directory);
    app
}

/// A service in a given directory.
pub(crate) async fn spawn_in(data: &Path, change: impl FnOnce(&mut Settings)) -> App {
    spawn_on(data, change, Arc::new(Upper)).await
}

/// The same with a compensator of the test's own.
pub(crate) async fn spawn_real_in(
    data: &Path,
    change: impl FnOnce(&mut Settings),
    compensator: Arc<dyn Compensator>,
) -> App {
    spawn_on(data, change, compensator).await
}

/// A service in a new directory that compensates with `compensator`.
pub(crate) async fn spawn_real(compensator: Arc<dyn Compensator>) -> App {
    spawn_real_with(|_| {}, compensator).await
}

/// The same with changed settings.
pub(crate) async fn spawn_real_with(
    change: impl FnOnce(&mut Settings),
    compensator: Arc<dyn Compensator>,
) -> App {
    let directory = TempDir::new().unwrap();
    let mut app = spawn_on(directory.path(), change, compensator).await;
    app.directory = Some(directory);
    app
}

async fn spawn_on(data: &Path, change: impl FnOnce(&mut Settings), compensator: Arc<dyn Compensator>) -> App {
    let mut settings = Settings {
        listen: ([127, 0, 0, 1], 0).into(),
        data_dir: data.to_owned(),
        drain_timeout_s: 0.5,
        ..Settings::default()
    };
    database::choose(&mut settings);
    change(&mut settings);
    let running = start(settings, sources(), compensator).await.unwrap();
    let base = format!("http://{}", running.address);
    let client = Client::builder().no_proxy().build().unwrap();
    App { client, base, data: data.to_owned(), running, directory: None }
}

impl App {
    /// What the service keeps.
    pub(crate) fn store(&self) -> &Store {
        &self.running.state.store
    }

    pub(crate) fn url(&self, path: &str) -> String {
        format!("{}{path}", self.base)
    }

    pub(crate) async fn get(&self, path: &str) -> Response {
        self.client.get(self.url(path)).send().await.unwrap()
    }

    pub(crate) async fn post_json(&self, path: &str, body: &Value) -> Response {
        self.client.post(self.url(path)).json(body).send().await.unwrap()
    }

    pub(crate) async fn post_text(&self, path: &str, kind: &str, body: impl Into<reqwest::Body>) -> Response {
        self.client.post(self.url(path)).header("content-type", kind).body(body).send().await.unwrap()
    }

    pub(crate) async fn put_machine(&self, id: &str, profile: &Value) -> Response {
        self.client.put(self.url(&format!("/v1/machines/{id}"))).json(profile).send().await.unwrap()
    }

    /// Makes the first key, which allows everything, and sends it with every request from now on.
    pub(crate) async fn close(&mut self) -> String {
        let all = ["read", "compute", "machines", "calibrations", "admin"];
        let key = self.new_key(&all, None).await;
        let value = HeaderValue::try_from(format!("Bearer {key}")).unwrap();
        let headers = HeaderMap::from_iter([(AUTHORIZATION, value)]);
        self.client = Client::builder().no_proxy().default_headers(headers).build().unwrap();
        key
    }

    /// A new key.
    pub(crate) async fn new_key(&self, scopes: &[&str], machines: Option<&[&str]>) -> String {
        let body = json!({"name": "a test", "scopes": scopes, "machines": machines});
        let made = self.post_json("/v1/keys", &body).await;
        assert_eq!(made.status(), 201);
        made.json::<Value>().await.unwrap()["key"].as_str().unwrap().to_owned()
    }

    pub(crate) async fn stop(self) -> Option<TempDir> {
        self.running.stop().await.unwrap();
        self.directory
    }

    pub(crate) fn begin_draining(&self) {
        self.running.state.begin_draining();
    }

    /// Files kept and half written.
    pub(crate) fn files(&self) -> (usize, usize) {
        let count = |folder: &str| {
            fn files(path: &Path) -> usize {
                std::fs::read_dir(path)
                    .unwrap()
                    .map(|entry| entry.unwrap().path())
                    .fold(0, |sum, path| sum + if path.is_dir() { files(&path) } else { 1 })
            }
            files(&self.data.join(folder))
        };
        (count("blobs"), count("spool"))
    }
}

/// Reads a problem document and checks everything that every problem has.
pub(crate) async fn problem(response: Response, code: &str) -> Value {
    let status = response.status();
    assert_eq!(response.headers()["content-type"], "application/problem+json", "status {status}");
    assert!(response.headers().contains_key("x-request-id"));
    if status == StatusCode::SERVICE_UNAVAILABLE {
        assert!(response.headers().contains_key("retry-after"));
    }
    let body: Value = response.json().await.unwrap();
    assert_eq!(body["type"], format!("/problems/{code}"), "{body}");
    assert_eq!(body["status"], status.as_u16(), "{body}");
    assert!(body["title"].is_string() && body["detail"].is_string(), "{body}");
    body
}

/// A program without the comment that says what was done to it, and what that comment says.
pub(crate) fn unstamped(text: &str) -> (String, Option<String>) {
    let is_stamp = |line: &&str| line.contains("Trunnion ") && line.contains(" parameters ");
    let stamps: Vec<_> = text.split_inclusive('\n').filter(is_stamp).collect();
    assert!(stamps.len() <= 1, "{stamps:?}");
    let bare = text.split_inclusive('\n').filter(|line| !is_stamp(line)).collect();
    let words = |line: &str| {
        let (_, words) = line.split_once("Trunnion ").unwrap();
        words.trim_end().trim_end_matches(')').to_owned()
    };
    (bare, stamps.first().map(|line| words(line)))
}

/// The pointers of a problem's errors.
pub(crate) fn pointers(problem: &Value) -> Vec<String> {
    let errors = problem["errors"].as_array().cloned().unwrap_or_default();
    errors.iter().map(|error| error["pointer"].as_str().unwrap().to_owned()).collect()
}

/// An AC trunnion table.
pub(crate) fn ac_table() -> Value {
    json!({
        "name": "DMU 80 T",
        "kinematics": {
            "rotary_axes": [
                {"name": "A", "side": "table", "direction": [1, 0, 0], "point_mm": [0, 0, -50], "limits_deg": [-120, 120]},
                {"name": "C", "side": "table", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}
            ],
            "linear_limits_mm": {"X": [-400, 400]}
        }
    })
}

#[derive(Debug)]
struct CountedTime(AtomicU64);

impl Clock for CountedTime {
    fn now(&self) -> jiff::Timestamp {
        let seconds = self.0.fetch_add(1, Ordering::SeqCst);
        jiff::Timestamp::from_second(1_772_000_000 + i64::try_from(seconds).unwrap()).unwrap()
    }

    fn watched(&self) -> jiff::SignedDuration {
        jiff::SignedDuration::from_secs(self.0.load(Ordering::SeqCst).try_into().unwrap())
    }
}

#[derive(Debug)]
struct CountedIds(AtomicU64);

impl IdSource for CountedIds {
    fn next(&self) -> uuid::Uuid {
        let count = self.0.fetch_add(1, Ordering::SeqCst);
        let mut random = [0; 10];
        random[2..].copy_from_slice(&count.to_be_bytes());
        uuid::Builder::from_unix_timestamp_millis(1_772_000_000_000, &random).into_uuid()
    }
}

static STARTED: AtomicU64 = AtomicU64::new(0);

fn sources() -> Sources {
    // A service that is started again goes on counting, as real ids do.
    let first = STARTED.fetch_add(1, Ordering::SeqCst) << 24;
    Sources {
        clock: Arc::new(CountedTime(AtomicU64::new(0))),
        ids: Arc::new(CountedIds(AtomicU64::new(first))),
    }
}

/// A compensator of tests: writes the program in capitals, refuses what begins with `REFUSE`, breaks on `PANIC`,
/// waits for its stop on `WAIT`.
#[derive(Debug)]
struct Upper;

impl Compensator for Upper {
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
        let mut text = Vec::new();
        source.open()?.read_to_end(&mut text)?;
        let mut lines = 0;
        for line in text.split_inclusive(|byte| *byte == b'\n') {
            lines += 1;
            if line.starts_with(b"WAIT") {
                while stop().is_continue() {
                    std::thread::yield_now();
                }
                return Err(CompensatorFault::Cancelled);
            }
            assert!(!line.starts_with(b"PANIC"), "told to break");
            let class = match line.get(..4) {
                Some(b"REFU") => Some(RefusalClass::Program),
                Some(b"TOLE") => Some(RefusalClass::ToleranceOutOfReach),
                Some(b"TRAV") => Some(RefusalClass::OutOfTravel),
                Some(b"COST") => Some(RefusalClass::TooCostly),
                _ => None,
            };
            if let Some(class) = class {
                return Err(CompensatorFault::Refused(Box::new(Refusal {
                    class,
                    detail: "told to refuse".to_owned(),
                    line: Some(lines),
                    block: Some(String::from_utf8_lossy(line).trim().to_owned()),
                    errors: vec![Fault::new("/program", "told to refuse")],
                })));
            }
            output.write_all(&line.to_ascii_uppercase())?;
        }
        Ok(compensated(lines))
    }

    fn figure(&self, _parameters: &CcParameters, report: &CcReport) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\"><title>{}</title></svg>",
            report.findings.blocks_in
        )
    }
}

/// What comes of a program of so many lines where nothing is wrong.
pub(crate) fn compensated(lines: u64) -> Compensated {
    Compensated {
        findings: findings(lines),
        dialect: program::Dialect::Iso,
        steps: Steps::NONE,
        reading: ProgramReading::default(),
    }
}

fn findings(lines: u64) -> CcFindings {
    CcFindings {
        dialect: Dialect::Iso,
        interpolation: Interpolation::Machine,
        contact: Contact::Tip,
        blocks_in: lines,
        blocks_out: lines,
        blocks_inserted: 0,
        feeds_restored: 0,
        motions_checked: 0,
        motions_over_tolerance: 0,
        motions_left_over: 0,
        before: DeviationSummary::default(),
        after: DeviationSummary::default(),
        cc_path_length_mm: 0.0,
        singularity: None,
        series: DeviationSeries::default(),
        warnings: Vec::new(),
    }
}

/// A program as a form: its parameters as JSON, and the name of its file.
pub(crate) fn program_form(parameters: &Value, program: &str, name: &str) -> reqwest::multipart::Form {
    let program = reqwest::multipart::Part::text(program.to_owned()).file_name(name.to_owned());
    reqwest::multipart::Form::new().text("parameters", parameters.to_string()).part("program", program)
}

impl App {
    /// An operation on a program with its parameters in the query, in the form asked for.
    pub(crate) async fn operate(
        &self,
        machine: &str,
        operation: &str,
        query: &str,
        program: &str,
        accept: &str,
    ) -> Response {
        let url = self.url(&format!("/v1/machines/{machine}/{operation}?{query}"));
        let request = self.client.post(url).header("accept", accept).header("content-type", "text/plain");
        request.body(program.to_owned()).send().await.unwrap()
    }

    /// The report of an operation that gives one.
    pub(crate) async fn report(&self, machine: &str, operation: &str, query: &str, program: &str) -> Value {
        let response = self.operate(machine, operation, query, program, "application/json").await;
        let status = response.status();
        let report: Value = response.json().await.unwrap();
        assert_eq!(status, 200, "{operation}?{query}: {report}");
        report
    }

    /// The program that an operation gives.
    pub(crate) async fn program(&self, machine: &str, operation: &str, query: &str, program: &str) -> String {
        let response = self.operate(machine, operation, query, program, "text/plain").await;
        let status = response.status();
        let text = response.text().await.unwrap();
        assert_eq!(status, 200, "{operation}?{query}: {text}");
        text
    }
}

/// The warnings of a report by their kinds.
pub(crate) fn kinds(report: &Value) -> Vec<String> {
    let warnings = report["warnings"].as_array().unwrap();
    warnings.iter().map(|warning| warning["kind"].as_str().unwrap().to_owned()).collect()
}

/// The description of the interface that the binary contains, with what operations share written out at each of them.
pub(crate) fn description() -> Value {
    in_full(&serde_json::from_str(&trunnion::http::description_text().unwrap()).unwrap())
}
