//! The real service without its sockets: store, queue, courier and router over one folder, with a clock, ids and a
//! compensator of the simulation's own.

use std::fmt;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use http::Request;
use http_body_util::BodyExt;
use jiff::{SignedDuration, Timestamp};
use serde_json::Value;
use tower::ServiceExt;
use trunnion::config::Settings;
use trunnion::http::{AppState, router};
use trunnion::jobs::{
    Besides, Clock, Compensated, Compensator, CompensatorFault, IdSource, JobFault, MachineUsed, OpenFault,
    ProgramJob, ProgramWork, Refusal, RefusalClass, Sizes, Sources, ToolShelf, timestamp,
};
use trunnion::machine::Machine;
use trunnion::process::{self, ProgramReading, ProgramSource, SingularityParameters, StepStore, Stop};
use trunnion::program::{self, Steps};
use trunnion::side_by_side::SideBySide;
use trunnion::store::{Actor, JobRow, Taken};
use trunnion::wire::{
    AuditOrigin, CcFindings, CcParameters, CcReport, Contact, DeviationSeries, DeviationSummary, Dialect,
    Interpolation, JobOperation, MachineDocument,
};

use crate::receiver::Turns;
use crate::recorder;

/// Looks at which nothing has changed before a service is held to rest.
const QUIET_LOOKS: u32 = 6;
/// How long one that waits at the gate sleeps between two looks.
const GATE_PAUSE: Duration = Duration::from_micros(50);
/// Looks at which nothing happens after which a second passes.
const PATIENT_LOOKS: u32 = 80;
/// The test fails if the service has not settled after this number of looks and this time.
const MOST_LOOKS: u32 = 20_000;
const LONGEST_SETTLING: Duration = Duration::from_mins(2);

/// When every run begins.
pub(crate) const BEGINS_S: i64 = 1_772_000_000;
/// How long a job is kept where a start forgets old ones \[s\].
pub(crate) const RETENTION_S: f64 = 86_400.0;
const TEN_YEARS_S: f64 = 10.0 * 365.25 * 86_400.0;

/// The wall clock of a run, which goes and jumps as the scheduler lets it, and never by itself.
#[derive(Debug)]
pub(crate) struct Wall {
    /// Milliseconds since the run began, as shown.
    shown_ms: AtomicI64,
    /// Likewise, as they have really passed.
    passed_ms: AtomicI64,
    began: Timestamp,
}

impl Wall {
    /// A clock that shows so much since the beginning \[ms\], in a process that has watched it for so long \[ms\].
    pub(crate) fn at(shown_ms: i64, watched_ms: i64) -> Arc<Self> {
        let began = Timestamp::from_millisecond(BEGINS_S * 1000 + shown_ms - watched_ms).unwrap();
        Arc::new(Self { shown_ms: AtomicI64::new(shown_ms), passed_ms: AtomicI64::new(watched_ms), began })
    }

    /// So much time passes.
    pub(crate) fn pass_ms(&self, by: i64) {
        self.passed_ms.fetch_add(by, Ordering::SeqCst);
        self.jump_ms(by);
    }

    /// Somebody sets the clock.
    pub(crate) fn jump_ms(&self, by: i64) {
        self.shown_ms.fetch_add(by, Ordering::SeqCst);
    }

    pub(crate) fn shown_ms(&self) -> i64 {
        self.shown_ms.load(Ordering::SeqCst)
    }
}

impl Clock for Wall {
    fn now(&self) -> Timestamp {
        Timestamp::from_millisecond(BEGINS_S * 1000 + self.shown_ms()).unwrap()
    }

    fn certain(&self) -> Timestamp {
        self.passed().min(self.now())
    }

    fn passed(&self) -> Timestamp {
        self.began.checked_add(self.watched()).unwrap()
    }

    fn watched(&self) -> SignedDuration {
        SignedDuration::from_millis(self.passed_ms.load(Ordering::SeqCst))
    }
}

#[derive(Debug)]
pub(crate) struct Ids(AtomicU64);

impl Ids {
    pub(crate) fn from(first: u64) -> Arc<Self> {
        Arc::new(Self(AtomicU64::new(first)))
    }

    pub(crate) fn reached(&self) -> u64 {
        self.0.load(Ordering::SeqCst)
    }
}

impl IdSource for Ids {
    fn next(&self) -> uuid::Uuid {
        let count = self.0.fetch_add(1, Ordering::SeqCst);
        let mut random = [0; 10];
        random[2..].copy_from_slice(&count.to_be_bytes());
        let at = u64::try_from(BEGINS_S * 1000).unwrap();
        uuid::Builder::from_unix_timestamp_millis(at, &random).into_uuid()
    }
}

/// Where programs that say `HOLD` wait until they are let go.
#[derive(Debug, Default)]
pub(crate) struct Gate {
    open: AtomicBool,
    waits: AtomicBool,
    /// How many have gone.
    gone: AtomicU64,
    /// How often those that wait have looked whether they may go, or are to stop.
    looks: AtomicU64,
}

impl Gate {
    /// One through which everything goes.
    pub(crate) fn wide_open() -> Arc<Self> {
        Arc::new(Self { open: AtomicBool::new(true), ..Self::default() })
    }

    pub(crate) fn holds_one(&self) -> bool {
        self.waits.load(Ordering::SeqCst)
    }

    /// Lets the one that waits go, and returns when it has gone.
    pub(crate) fn let_go(&self) {
        if !self.holds_one() {
            return;
        }
        let gone = self.gone.load(Ordering::SeqCst);
        self.open.store(true, Ordering::SeqCst);
        while self.holds_one() && self.gone.load(Ordering::SeqCst) == gone {
            std::thread::sleep(GATE_PAUSE);
        }
    }

    /// Returns when the one that waits, if there is one, has looked again and waits still, or is there no more.
    fn lets_look(&self) {
        let looks = || self.looks.load(Ordering::SeqCst);
        // The look that goes on may have begun before.
        let enough = looks() + 2;
        while self.holds_one() && looks() < enough {
            std::thread::sleep(GATE_PAUSE);
        }
    }

    /// Waits until let go; `false` where it is told to stop.
    fn wait(&self, stop: &Stop<'_>) -> bool {
        if self.open.load(Ordering::SeqCst) && !self.holds_one() {
            // Wide open.
            return true;
        }
        self.waits.store(true, Ordering::SeqCst);
        let goes = loop {
            if self.open.swap(false, Ordering::SeqCst) {
                break true;
            }
            if stop().is_break() {
                break false;
            }
            self.looks.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(GATE_PAUSE);
        };
        self.waits.store(false, Ordering::SeqCst);
        self.gone.fetch_add(1, Ordering::SeqCst);
        goes
    }
}

/// Writes the program in capitals; one that says `REFUSE` is refused.
#[derive(Debug)]
struct Capitals(Arc<Gate>);

impl Compensator for Capitals {
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
        if text.contains("HOLD") && !self.0.wait(stop) {
            return Err(CompensatorFault::Cancelled);
        }
        if text.contains("REFUSE") {
            return Err(CompensatorFault::Refused(Box::new(Refusal {
                class: RefusalClass::Program,
                detail: "told to refuse".to_owned(),
                line: Some(1),
                block: None,
                errors: Vec::new(),
            })));
        }
        output.write_all(text.to_ascii_uppercase().as_bytes())?;
        Ok(Compensated {
            findings: findings(),
            dialect: program::Dialect::Iso,
            steps: Steps::NONE,
            reading: ProgramReading::default(),
        })
    }

    fn figure(&self, _parameters: &CcParameters, _report: &CcReport) -> String {
        "<svg xmlns=\"http://www.w3.org/2000/svg\"/>".to_owned()
    }
}

fn findings() -> CcFindings {
    CcFindings {
        dialect: Dialect::Iso,
        interpolation: Interpolation::Machine,
        contact: Contact::Tip,
        blocks_in: 1,
        blocks_out: 1,
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

/// What the service answered.
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) document: Value,
    pub(crate) location: Option<String>,
}

impl Answer {
    pub(crate) fn is_done(&self) -> bool {
        (200..300).contains(&self.status)
    }

    pub(crate) fn text(&self, member: &str) -> String {
        self.document[member].as_str().unwrap_or_default().to_owned()
    }
}

/// What a client asks.
#[derive(Debug, Clone)]
pub(crate) struct Ask {
    pub(crate) method: &'static str,
    pub(crate) path: String,
    pub(crate) kind: &'static str,
    pub(crate) body: Vec<u8>,
    pub(crate) key: Option<String>,
    pub(crate) if_match: bool,
}

impl Ask {
    pub(crate) fn new(method: &'static str, path: impl Into<String>) -> Self {
        Self { method, path: path.into(), kind: "", body: Vec::new(), key: None, if_match: false }
    }

    pub(crate) fn json(self, body: &Value) -> Self {
        Self { kind: "application/json", body: body.to_string().into_bytes(), ..self }
    }

    pub(crate) fn keyed(self, key: impl Into<String>) -> Self {
        Self { key: Some(key.into()), ..self }
    }

    pub(crate) fn matching(self, if_match: bool) -> Self {
        Self { if_match, ..self }
    }
}

/// A service that runs.
pub(crate) struct World {
    pub(crate) app: AppState,
    /// Made when first asked for: it costs more than all else of a short look.
    router: OnceLock<Router>,
    pub(crate) wall: Arc<Wall>,
    pub(crate) ids: Arc<Ids>,
    pub(crate) gate: Arc<Gate>,
    turns: Arc<Turns>,
}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("World").field("wall", &self.wall).finish_non_exhaustive()
    }
}

/// What a service is opened with.
#[derive(Debug)]
pub(crate) struct Opening {
    pub(crate) data: PathBuf,
    pub(crate) wall: Arc<Wall>,
    pub(crate) ids: Arc<Ids>,
    pub(crate) gate: Arc<Gate>,
    pub(crate) turns: Arc<Turns>,
    pub(crate) retention_s: f64,
}

impl World {
    /// Opens a folder as the service does when it starts.
    pub(crate) async fn open(opening: Opening) -> Result<Self, OpenFault> {
        let Opening { data, wall, ids, gate, turns, retention_s } = opening;
        let settings = Settings {
            listen: ([127, 0, 0, 1], 0).into(),
            data_dir: data,
            max_computations: 1,
            store_readers: 1,
            job_retention_s: retention_s,
            // Long, so that no clock that is set ahead makes a key old, but where old jobs go: there their keys go
            // first.
            idempotency_retention_s: if retention_s > 0.0 { retention_s } else { TEN_YEARS_S },
            webhook_allow: vec!["127.0.0.0/8".parse().unwrap()],
            webhook_pauses_s: vec![1.0, 5.0],
            // One end is told at a time.
            max_deliveries: 1,
            ..Settings::default()
        };
        let sources = Sources {
            clock: Arc::clone(&wall) as Arc<dyn Clock>,
            ids: Arc::clone(&ids) as Arc<dyn IdSource>,
        };
        let compensator = Arc::new(Capitals(Arc::clone(&gate)));
        let app = AppState::open(settings, sources, compensator).await?;
        // What is removed at the start is not beside what is asked later.
        app.queue.begun().await;
        Ok(Self { app, router: OnceLock::new(), wall, ids, gate, turns })
    }

    /// Asks the service as the bearer of this key.
    pub(crate) async fn ask(&self, ask: &Ask, bearer: Option<&str>) -> Answer {
        let mut request = Request::builder().method(ask.method).uri(&ask.path).header("host", "127.0.0.1");
        if let Some(bearer) = bearer {
            request = request.header("authorization", format!("Bearer {bearer}"));
        }
        if !ask.kind.is_empty() {
            request = request.header("content-type", ask.kind);
        }
        if let Some(key) = &ask.key {
            request = request.header("idempotency-key", key);
        }
        if ask.if_match {
            request = request.header("if-match", "*");
        }
        let request = request.body(Body::from(ask.body.clone())).unwrap();
        let router = self.router.get_or_init(|| router(self.app.clone())).clone();
        let response = router.oneshot(request).await.unwrap();
        let status = response.status().as_u16();
        let location = response.headers().get("location");
        let location = location.map(|place| place.to_str().unwrap().to_owned());
        // A body that breaks off is no answer.
        let Ok(body) = response.into_body().collect().await else {
            return Answer { status: 599, document: Value::Null, location: None };
        };
        let document = serde_json::from_slice(&body.to_bytes()).unwrap_or(Value::Null);
        Answer { status, document, location }
    }

    /// A job accepted behind the router, as its handler does it.
    pub(crate) async fn accept(&self, name: &str, program: &str) -> Result<JobRow, JobFault> {
        let (app, id) = (&self.app, "example-ac-table");
        let machine = app.store.machine(id).await?.ok_or(JobFault::MachineLost)?;
        let MachineDocument { revision, profile, .. } = machine.document;
        let tools = ToolShelf::new(app.store.tools(id).await?);
        let on = MachineUsed::new(id.to_owned(), revision, profile, tools).map_err(JobFault::Parameters)?;
        let mut draft = app.spool.blobs().draft()?;
        draft.write_all(program.as_bytes()).map_err(CompensatorFault::Io)?;
        let sizes = Sizes::of_drafts(&draft, None).map_err(CompensatorFault::Io)?;
        let parameters = br#"{"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [1, 2, 3]}"#;
        let work = ProgramWork::read(JobOperation::CcCompensation, parameters, on, sizes, &app.means())?;
        let job = ProgramJob {
            machine_id: id.to_owned(),
            machine_revision: revision,
            work,
            repeats: None,
            steps_done: Steps::NONE,
            program: draft,
            surface: None,
            file_name: "part.nc".to_owned(),
            used: None,
            by: Actor::without_request(AuditOrigin::Service),
        };
        let besides = Besides { external_id: Some(name.to_owned()), ..Besides::default() };
        let accepted = app.queue.accept(vec![app.queue.draw_up(job, besides)?]).await?;
        Ok(accepted.into_iter().next().unwrap())
    }

    /// Whether no job goes on but one that waits at the gate, and whether no end is to be told now.
    async fn rests(&self) -> (bool, bool) {
        let store = &self.app.store;
        let Ok(depth) = store.queue_depth().await else { return (false, false) };
        let now = timestamp(self.wall.now());
        let due = store.due_deliveries(&now, "9999-12-30T22:00:00.000Z", &Taken::default(), 1).await;
        let told = due.is_ok_and(|due| due.is_empty());
        (self.gate.holds_one() || depth.queued + depth.running == 0, told)
    }

    /// Waits until the service rests and does nothing more to its files. Jobs come first; then the receiver answers
    /// those that it has heard, one after the other.
    pub(crate) async fn settle(&self) {
        let (mut quiet, mut patient, mut looks, mut done) = (0, 0, 0, (0, 0));
        let began = Instant::now();
        loop {
            for _ in 0..4 {
                tokio::task::yield_now().await;
            }
            self.gate.lets_look();
            let (rests, told) = self.rests().await;
            // Who looks for a job draws an id for it, also where there is none.
            let now = (recorder::now(), self.ids.reached());
            if now != done {
                (quiet, patient, done) = (0, 0, now);
            } else if others_sleep() {
                patient += 1;
                quiet = if rests { quiet + 1 } else { 0 };
            }
            if quiet >= QUIET_LOOKS {
                if told {
                    return;
                }
                if self.turns.let_answer() {
                    quiet = 0;
                }
            }
            looks += 1;
            if patient >= PATIENT_LOOKS {
                // What failed is tried again after a second.
                recorder::pass_ns(1_000_000_000);
                patient = 0;
            }
            let depth = self.app.store.queue_depth().await;
            // Beside other work of the computer, looks come faster than the service's own threads.
            let is_late = looks >= MOST_LOOKS && began.elapsed() >= LONGEST_SETTLING;
            assert!(!is_late, "the service does not settle: {depth:?}");
        }
    }

    /// Stops as the service does when it is told to.
    pub(crate) async fn stop(self) {
        self.app.begin_draining();
        // What waits at the gate goes nowhere: the time to drain is over at once.
        let drain = if self.gate.holds_one() { Duration::ZERO } else { Duration::from_secs(5) };
        let mut stop = std::pin::pin!(self.app.queue.stop(drain));
        while futures::poll!(stop.as_mut()).is_pending() {
            if others_sleep() {
                recorder::pass_ns(10_000_000);
            }
            std::thread::sleep(Duration::from_micros(200));
            tokio::task::yield_now().await;
        }
        self.app.store.close().await;
    }
}

/// Whether no other thread of this process has anything to do now, while a run is recorded: on a busy computer a
/// thread that has work may wait long for its turn. What is not recorded need not be the same each time.
fn others_sleep() -> bool {
    if !recorder::is_on() {
        return true;
    }
    let me = std::fs::read_link("/proc/thread-self").unwrap();
    std::fs::read_dir("/proc/self/task").unwrap().all(|thread| {
        let thread = thread.unwrap();
        // One that has ended meanwhile has nothing to do.
        let stat = std::fs::read_to_string(thread.path().join("stat")).unwrap_or_default();
        let state = stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next());
        Some(thread.file_name().as_os_str()) == me.file_name()
            || matches!(state, None | Some('S' | 'Z' | 'X'))
    })
}

/// A new folder in memory, which goes with what is returned.
pub(crate) fn folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    let below = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    tempfile::Builder::new().prefix("trunnion-simulation-").tempdir_in(below).unwrap()
}
