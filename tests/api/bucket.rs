//! Files in a bucket of S3: what comes back is what was kept, and what the server of the bucket does wrong is never half a
//! file (`docs/scale-out.md`). Between the service and that server stands one that does wrong on demand. Each test does
//! something only with `tests/s3/with-server`.

use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::response::Response;
use reqwest::StatusCode;
use tempfile::TempDir;
use trunnion::config::Settings;

use crate::command_line::{said, trunnion};
use crate::database::{address_of, ask, bucket_server, schema_of, shared_place};
use crate::queue::{Held, accepted, cc, document, ended, form, running};
use crate::scale_out::is_sound_but_for_fsync;
use crate::several_services::{another, first, within};
use crate::support::{App, problem};

/// What is done wrong.
#[derive(Debug, Clone, Copy)]
enum Wrong {
    /// Nothing.
    Nothing,
    /// An error with this status and code.
    Refused(u16, &'static str),
    /// The connection ends without an answer, when the request has been read.
    Cut,
    /// The server answers, but the client does not hear it.
    Unheard,
    /// No answer comes.
    Silent,
    /// Lists say that everything is old.
    Aged,
}

/// What is asked: the method, and the path with the query.
type Asked = fn(&str, &str) -> bool;

/// The server in between.
#[derive(Clone)]
struct Between {
    address: String,
    wrong: Arc<Mutex<(Wrong, Asked, usize)>>,
    client: reqwest::Client,
    met: Arc<AtomicUsize>,
}

fn anything(_: &str, _: &str) -> bool {
    true
}

fn a_part(method: &str, path: &str) -> bool {
    method == "PUT" && path.contains("partNumber=")
}

fn the_second_part(method: &str, path: &str) -> bool {
    a_part(method, path) && path.contains("partNumber=2")
}

fn an_object(method: &str, _: &str) -> bool {
    method == "PUT"
}

fn the_end_of_an_upload(method: &str, path: &str) -> bool {
    method == "POST" && path.contains("uploadId=")
}

fn a_list(method: &str, path: &str) -> bool {
    method == "GET" && path.contains("list-type=2")
}

impl Between {
    async fn new() -> Option<Self> {
        bucket_server()?;
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let between = Self {
            address: format!("http://{}", listener.local_addr().unwrap()),
            wrong: Arc::new(Mutex::new((Wrong::Nothing, anything, 0))),
            client: reqwest::Client::builder().no_proxy().build().unwrap(),
            met: Arc::default(),
        };
        let router = Router::new().fallback(pass).with_state(between.clone());
        tokio::spawn(async move { axum::serve(listener, router).await });
        Some(between)
    }

    /// From now on the server makes this fault, `times` times.
    fn does(&self, wrong: Wrong, asked: Asked, times: usize) {
        *self.wrong.lock().unwrap() = (wrong, asked, times);
        self.met.store(0, Ordering::SeqCst);
    }

    fn does_nothing_wrong(&self) {
        self.does(Wrong::Nothing, anything, 0);
    }

    fn next(&self, method: &str, path: &str) -> Wrong {
        let mut wrong = self.wrong.lock().unwrap();
        let (kind, asked, left) = &mut *wrong;
        if *left == 0 || !asked(method, path) {
            return Wrong::Nothing;
        }
        *left -= 1;
        self.met.fetch_add(1, Ordering::SeqCst);
        *kind
    }
}

async fn pass(State(between): State<Between>, request: Request) -> Response {
    let (head, body) = request.into_parts();
    let path = head.uri.path_and_query().unwrap().to_string();
    let wrong = between.next(head.method.as_str(), &path);
    let body = axum::body::to_bytes(body, usize::MAX).await.unwrap();
    match wrong {
        Wrong::Refused(status, code) => {
            let text =
                format!("<?xml version=\"1.0\"?><Error><Code>{code}</Code><Message>s3cret</Message></Error>");
            return Response::builder().status(status).body(Body::from(text)).unwrap();
        }
        Wrong::Cut => std::panic::resume_unwind(Box::new("cut")),
        Wrong::Silent => std::future::pending().await,
        Wrong::Nothing | Wrong::Unheard | Wrong::Aged => {}
    }
    let mut headers = head.headers;
    headers.remove("host");
    let url = format!("{}{path}", bucket_server().unwrap());
    let answer = between.client.request(head.method, url).headers(headers).body(body).send().await.unwrap();
    if matches!(wrong, Wrong::Unheard) {
        std::panic::resume_unwind(Box::new("unheard"));
    }
    let mut response = Response::builder().status(answer.status());
    for (name, value) in answer.headers() {
        if name != "transfer-encoding" && name != "connection" {
            response = response.header(name, value);
        }
    }
    let bytes = answer.bytes().await.unwrap();
    if !matches!(wrong, Wrong::Aged) {
        return response.body(Body::from(bytes)).unwrap();
    }
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    let aged = text.split("<LastModified>").map(|part| match part.split_once("</LastModified>") {
        Some((_, rest)) => format!("2020-01-01T00:00:00.000Z</LastModified>{rest}"),
        None => part.to_owned(),
    });
    let aged = aged.collect::<Vec<_>>().join("<LastModified>");
    response.header("content-length", aged.len()).body(Body::from(aged)).unwrap()
}

/// What is in the bucket of a database.
struct Stored {
    root: String,
    client: reqwest::Client,
}

impl Stored {
    fn of(app: &App) -> Self {
        let id = ask(&format!("SELECT database_id FROM {}.service", schema_of(&app.data)));
        let place = shared_place().to_string();
        let root = format!("{}/{id}", place.trim_start_matches("s3://trunnion-test/"));
        // The server of tests wants to be told who asks, and believes it.
        let who = "AWS4-HMAC-SHA256 Credential=trunnion-test/20261126/us-east-1/s3/aws4_request, SignedHeaders=host, Signature=0";
        let headers = [(reqwest::header::AUTHORIZATION, who.parse().unwrap())].into_iter().collect();
        let client = reqwest::Client::builder().no_proxy().default_headers(headers).build().unwrap();
        Self { root, client }
    }

    fn url(&self, key: &str) -> String {
        format!("{}/trunnion-test/{}/{key}", bucket_server().unwrap(), self.root)
    }

    /// The keys of everything with this in it, below the root.
    async fn keys(&self, with: &str) -> Vec<String> {
        let url = format!("{}/trunnion-test?list-type=2&prefix={}/", bucket_server().unwrap(), self.root);
        let text = self.client.get(url).send().await.unwrap().text().await.unwrap();
        let keys = text.split("<Key>").skip(1).map(|part| part.split_once("</Key>").unwrap().0);
        let keys = keys.map(|key| key.trim_start_matches(&format!("{}/", self.root)).to_owned());
        keys.filter(|key| key.contains(with)).collect()
    }

    /// The objects.
    async fn objects(&self) -> Vec<String> {
        self.keys("-").await
    }

    /// The number of uploads that have not ended.
    async fn uploads(&self) -> usize {
        let url = format!("{}/trunnion-test?uploads", bucket_server().unwrap());
        let text = self.client.get(url).send().await.unwrap().text().await.unwrap();
        text.matches(&format!("<Key>{}/", self.root)).count()
    }

    async fn get(&self, key: &str) -> Vec<u8> {
        self.client.get(self.url(key)).send().await.unwrap().bytes().await.unwrap().to_vec()
    }

    async fn put(&self, key: &str, bytes: Vec<u8>) {
        assert!(self.client.put(self.url(key)).body(bytes).send().await.unwrap().status().is_success());
    }

    async fn remove(&self, key: &str) {
        assert!(self.client.delete(self.url(key)).send().await.unwrap().status().is_success());
    }
}

/// A service behind the server in between.
struct Service {
    app: App,
    held: Arc<Held>,
    between: Between,
    stored: Stored,
    schema: String,
    /// It lasts as long as the service.
    _folder: TempDir,
}

async fn service() -> Option<Service> {
    let between = Between::new().await?;
    let (folder, held) = (TempDir::new().unwrap(), Arc::<Held>::default());
    let endpoint = between.address.clone();
    let app = first(folder.path(), &held, |settings| settings.files_endpoint = Some(endpoint)).await;
    let (stored, schema) = (Stored::of(&app), schema_of(folder.path()));
    Some(Service { app, held, between, stored, schema, _folder: folder })
}

/// A program of at least `bytes` bytes. Programs with different names differ.
fn program(name: &str, bytes: usize) -> String {
    format!("g1 x{name} ({})\n", "1234567".repeat(bytes / 7 + 1))
}

async fn refused(app: &App, text: &str) -> String {
    let posted = app.client.post(app.url("/v1/jobs")).multipart(form(&cc("example-ac-table"), text)).send();
    let body = problem(posted.await.unwrap(), "storage-unavailable").await;
    body["detail"].as_str().unwrap().to_owned()
}

/// The bytes of the program of a job, from the bucket and not from a copy.
async fn from_the_bucket(app: &App, place: &str) -> reqwest::Response {
    forget_copies(&app.data);
    app.get(&format!("{place}/program")).await
}

fn forget_copies(data: &Path) {
    for file in crate::command_line::files(&data.join("blobs")) {
        std::fs::remove_file(file).unwrap();
    }
}

impl Service {
    fn rows(&self, which: &str) -> String {
        ask(&format!("SELECT count(*) FROM {}.files {which}", self.schema))
    }

    /// Every row has its object, every object its row, and no upload is left.
    async fn is_tidy(&self) {
        let rows = ask(&format!(
            "SELECT coalesce(string_agg(object_key, ' ' ORDER BY object_key), '') FROM {}.files WHERE whole = 1",
            self.schema
        ));
        let mut objects = self.stored.objects().await;
        for key in &mut objects {
            *key = key.split('/').next_back().unwrap().to_owned();
        }
        objects.sort();
        assert_eq!(objects.join(" "), rows);
        assert_eq!((self.rows("WHERE whole = 0"), self.stored.uploads().await), ("0".into(), 0));
    }
}

#[tokio::test]
async fn small_and_large_files_come_back_and_are_there_once() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, stored, .. } = &service;
    held.release();
    // Some refusals pass while nobody notices.
    between.does(Wrong::Refused(503, "SlowDown"), an_object, 2);
    for bytes in [1, (8 << 20) - 20, 8 << 20, (20 << 20) + 3] {
        let text = program("2", bytes);
        let place = accepted(app, &cc("example-ac-table"), &text).await;
        assert_eq!(ended(app, &place).await["state"], "succeeded");
        let answer = from_the_bucket(app, &place).await;
        assert_eq!(answer.status(), StatusCode::OK);
        assert!(answer.text().await.unwrap() == text.to_ascii_uppercase(), "{bytes}");
        service.is_tidy().await;
    }
    assert_eq!((between.met.load(Ordering::SeqCst), stored.objects().await.len()), (2, 8));
    // The same bytes again make no object.
    let place = accepted(app, &cc("example-ac-table"), &program("2", 1)).await;
    ended(app, &place).await;
    assert_eq!(stored.objects().await.len(), 8);
    assert_eq!(stored.keys("database.id").await, ["database.id"]);
    assert!(stored.keys("trial").await.is_empty());
}

#[tokio::test]
async fn an_answer_that_is_lost_is_asked_for_again() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, .. } = &service;
    held.release();
    let (large, mut names) = (20 << 20, 0);
    for (asked, bytes) in
        [(an_object as Asked, 10), (a_part as Asked, large), (the_end_of_an_upload as Asked, large)]
    {
        between.does(Wrong::Unheard, asked, 1);
        names += 1;
        let text = program(&names.to_string(), bytes);
        let place = accepted(app, &cc("example-ac-table"), &text).await;
        assert_eq!(between.met.load(Ordering::SeqCst), 1);
        assert_eq!(ended(app, &place).await["state"], "succeeded");
        assert!(from_the_bucket(app, &place).await.text().await.unwrap() == text.to_ascii_uppercase());
        service.is_tidy().await;
    }
}

#[tokio::test]
async fn an_upload_that_fails_leaves_nothing() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, .. } = &service;
    held.release();
    for (wrong, asked) in [
        (Wrong::Refused(403, "AccessDenied"), the_second_part as Asked),
        (Wrong::Refused(500, "InternalError"), the_second_part as Asked),
        (Wrong::Refused(403, "AccessDenied"), the_end_of_an_upload as Asked),
        (Wrong::Refused(403, "AccessDenied"), an_object as Asked),
    ] {
        between.does(wrong, asked, usize::MAX);
        let detail = refused(app, &program("4", 20 << 20)).await;
        assert!(detail.contains("the server of the files") && !detail.contains("s3cret"), "{detail}");
        assert!(between.met.load(Ordering::SeqCst) > 0);
        between.does_nothing_wrong();
        // After a server that did not answer, what is left goes later.
        tokio::time::sleep(Duration::from_millis(1100)).await;
        ask(&format!("UPDATE {}.files SET kept_at = kept_at - INTERVAL '25 h'", service.schema));
        app.store().remove_unnamed(None).await.unwrap();
        assert_eq!(service.rows(""), "0", "{wrong:?}");
        service.is_tidy().await;
    }
    let place = accepted(app, &cc("example-ac-table"), &program("4", 20 << 20)).await;
    assert_eq!(ended(app, &place).await["state"], "succeeded");
}

#[tokio::test]
async fn a_server_that_dies_under_an_upload_is_told_and_the_upload_ends_later() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, stored, .. } = &service;
    // The results of what runs are stored when the server is back.
    let place = accepted(app, &cc("example-ac-table"), "HOLD\n").await;
    running(app, &place).await;
    between.does(Wrong::Cut, the_second_part, 1);
    let dead = between.clone();
    let dies = tokio::spawn(async move {
        while dead.met.load(Ordering::SeqCst) == 0 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        dead.does(Wrong::Cut, anything, usize::MAX);
    });
    let began = Instant::now();
    refused(app, &program("5", 20 << 20)).await;
    assert!(began.elapsed() < Duration::from_secs(20), "{:?}", began.elapsed());
    dies.await.unwrap();
    assert_eq!((service.rows("WHERE upload_id IS NOT NULL"), stored.uploads().await), ("1".into(), 1));
    held.release();
    let readiness = problem(app.get("/readyz").await, "storage-unavailable").await;
    assert!(readiness["detail"].as_str().unwrap().contains("the server of the files"), "{readiness}");
    tokio::time::sleep(Duration::from_secs(2)).await;
    assert_ne!(document(app, &place).await["state"], "failed");
    between.does_nothing_wrong();
    let is_ready = || async { app.get("/readyz").await.status() == StatusCode::OK };
    within(Duration::from_secs(5), "readiness", is_ready).await;
    assert_eq!(ended(app, &place).await["state"], "succeeded");
    // As long as it may still be going on, it stays.
    app.store().remove_unnamed(None).await.unwrap();
    assert_eq!(stored.uploads().await, 1);
    ask(&format!("UPDATE {}.files SET kept_at = kept_at - INTERVAL '25 h' WHERE whole = 0", service.schema));
    app.store().remove_unnamed(None).await.unwrap();
    service.is_tidy().await;
}

#[tokio::test]
async fn a_server_that_says_nothing_is_not_waited_for() {
    let Some(service) = service().await else { return };
    let Service { app, between, .. } = &service;
    between.does(Wrong::Silent, anything, usize::MAX);
    tokio::time::sleep(Duration::from_millis(1100)).await;
    let began = Instant::now();
    let told = problem(app.get("/readyz").await, "storage-unavailable").await;
    assert!(told["detail"].as_str().unwrap().contains("no answer within 3 s"), "{told}");
    assert!(began.elapsed() < Duration::from_secs(5), "{:?}", began.elapsed());
    tokio::time::sleep(Duration::from_millis(1100)).await;
    let began = Instant::now();
    refused(app, "g1 x6\n").await;
    assert!(began.elapsed() < Duration::from_secs(45), "{:?}", began.elapsed());
    // Meanwhile the next ones are told at once.
    let began = Instant::now();
    refused(app, "g1 x6\n").await;
    assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
}

#[tokio::test]
async fn what_was_changed_cut_off_or_removed_is_told_and_never_sent() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, stored, .. } = &service;
    held.release();
    let text = program("7", 9 << 20);
    let place = accepted(app, &cc("example-ac-table"), &text).await;
    let job = ended(app, &place).await;
    let [input, output] = ["input_sha256", "output_sha256"].map(|name| job[name].as_str().unwrap());
    let doctor = |arguments: &[&str]| {
        trunnion(&app.data, &[&["doctor", "--files", &shared_place().to_string()], arguments].concat())
    };
    let sound = doctor(&["--deep"]);
    assert!(is_sound_but_for_fsync(&sound) && said(&sound).contains("2 named in the database, all present"));
    let key = stored.keys(output).await.pop().unwrap();
    let whole = stored.get(&key).await;
    let mut other = whole.clone();
    other[5 << 20] ^= 1;
    for (bytes, quick) in [
        (other, false),
        (whole[..whole.len() - 1].to_vec(), true),
        (Vec::new(), true),
        ([&whole[..], b"\n"].concat(), true),
    ] {
        stored.put(&key, bytes).await;
        problem(from_the_bucket(app, &place).await, "stored-file-damaged").await;
        let found = doctor(if quick { &["--quick"] } else { &[] });
        assert_eq!(found.status.code(), Some(1), "{}", said(&found));
        assert!(
            said(&found).contains("has other bytes") && said(&found).contains(output),
            "{}",
            said(&found)
        );
    }
    stored.remove(&key).await;
    problem(from_the_bucket(app, &place).await, "stored-file-damaged").await;
    let found = doctor(&["--quick"]);
    assert!(said(&found).contains(&format!("{output} is missing")), "{}", said(&found));
    // A bucket that is gone is no missing file.
    stored.put(&key, whole).await;
    between.does(Wrong::Refused(404, "NoSuchBucket"), anything, usize::MAX);
    problem(from_the_bucket(app, &place).await, "storage-unavailable").await;
    problem(app.get("/readyz").await, "storage-unavailable").await;
    between.does_nothing_wrong();
    assert!(from_the_bucket(app, &place).await.text().await.unwrap() == text.to_ascii_uppercase());
    // What was lost is kept again when it comes again, under another key.
    let key = stored.keys(input).await.pop().unwrap();
    stored.remove(&key).await;
    let again = accepted(app, &cc("example-ac-table"), &text).await;
    assert_eq!(ended(app, &again).await["state"], "succeeded");
    let now = stored.keys(input).await;
    assert!(now.len() == 1 && now[0] != key, "{now:?}");
    assert_eq!(service.rows(&format!("WHERE sha256 = '{input}' AND whole = 1")), "1");
}

#[tokio::test]
async fn two_services_that_keep_the_same_bytes_at_once_keep_them_once() {
    let Some(service) = service().await else { return };
    let Service { app, held, stored, .. } = &service;
    held.release();
    let folder = TempDir::new().unwrap();
    let other = another(&app.data, folder.path(), held, |_| {}).await;
    for round in 0..12 {
        let text = program(&round.to_string(), if round % 4 == 0 { 9 << 20 } else { 100 });
        let job = cc("example-ac-table");
        let (one, two) = tokio::join!(accepted(app, &job, &text), accepted(&other, &job, &text));
        for (app, place) in [(app, two), (&other, one)] {
            assert_eq!(ended(app, &place).await["state"], "succeeded");
            assert!(from_the_bucket(app, &place).await.text().await.unwrap() == text.to_ascii_uppercase());
        }
    }
    service.is_tidy().await;
    assert_eq!(stored.objects().await.len(), 24);
    other.stop().await;
}

#[tokio::test]
async fn a_removal_beside_uploads_of_the_same_bytes_never_takes_them_away() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, schema, .. } = &service;
    held.release();
    between.does(Wrong::Aged, a_list, usize::MAX);
    let folder = TempDir::new().unwrap();
    let other = another(&app.data, folder.path(), held, |_| {}).await;
    let (mut places, job) = (Vec::new(), cc("example-ac-table"));
    for round in 0..30 {
        // Nothing names the bytes, and they are old: they may go at any moment from now on.
        ask(&format!(
            "BEGIN; DELETE FROM {schema}.jobs; UPDATE {schema}.files SET kept_at = kept_at - INTERVAL '25 h'; COMMIT"
        ));
        let text = program(&(round % 3).to_string(), 100);
        let removal = async {
            tokio::time::sleep(Duration::from_millis(round)).await;
            other.store().remove_unnamed(None).await.unwrap();
            app.store().sweep_bucket().await.unwrap();
        };
        let (place, ()) = tokio::join!(accepted(app, &job, &text), removal);
        assert_eq!(ended(app, &place).await["state"], "succeeded");
        assert!(from_the_bucket(app, &place).await.text().await.unwrap() == text.to_ascii_uppercase());
        places.push(place);
    }
    app.store().sweep_bucket().await.unwrap();
    service.is_tidy().await;
    assert_eq!(places.len(), 30);
    other.stop().await;
}

#[tokio::test]
async fn a_sweep_takes_old_objects_without_a_row_and_nothing_else() {
    let Some(service) = service().await else { return };
    let Service { app, held, between, stored, .. } = &service;
    held.release();
    let place = accepted(app, &cc("example-ac-table"), "g1 x9\n").await;
    ended(app, &place).await;
    let of_ours = stored.objects().await;
    let orphan = format!("ab/{}-0190c3a5-1b2c-4d3e-8f40-5a6b7c8d9e0f", "ab".repeat(32));
    let foreign = "ab/notes-of-somebody.txt";
    stored.put(&orphan, b"G1".to_vec()).await;
    stored.put(foreign, b"mine".to_vec()).await;
    assert_eq!(app.store().sweep_bucket().await.unwrap(), 0, "it is young");
    between.does(Wrong::Aged, a_list, usize::MAX);
    assert_eq!(app.store().sweep_bucket().await.unwrap(), 1);
    let mut left = stored.objects().await;
    left.retain(|key| key != foreign);
    assert_eq!(left, of_ours);
    assert_eq!(stored.get(foreign).await, b"mine");
}

#[tokio::test]
async fn another_bucket_is_refused_at_the_start_and_nothing_is_changed() {
    let Some(service) = service().await else { return };
    let Service { app, held, stored, .. } = service;
    held.release();
    let place = accepted(&app, &cc("example-ac-table"), "g1 x10\n").await;
    ended(&app, &place).await;
    let data = app.data.clone();
    let endpoint = bucket_server();
    app.stop().await;
    let refusal = |change: &dyn Fn(&mut Settings)| {
        let mut settings = Settings {
            listen: ([127, 0, 0, 1], 0).into(),
            data_dir: data.clone(),
            database: address_of(&data).map(|address| address.parse().unwrap()),
            files: shared_place(),
            files_endpoint: endpoint.clone(),
            ..Settings::default()
        };
        change(&mut settings);
        async {
            let compensator = Arc::new(trunnion::jobs::CutterContactCompensator::default());
            let sources = trunnion::jobs::Sources::real();
            trunnion::cli::start(settings, sources, compensator).await.err().unwrap().to_string()
        }
    };
    let elsewhere = refusal(&|settings| settings.files = "s3://trunnion-test/other".parse().unwrap()).await;
    assert!(elsewhere.contains("set files = s3://trunnion-test/shop"), "{elsewhere}");
    let away = refusal(&|settings| settings.files_endpoint = Some("http://127.0.0.1:1".to_owned())).await;
    assert!(
        away.contains("the server of the files cannot be reached") && away.contains("files_endpoint"),
        "{away}"
    );
    stored.remove("database.id").await;
    let emptied = refusal(&|_| {}).await;
    assert!(emptied.contains("does not have the files of this database"), "{emptied}");
    stored.put("database.id", Vec::new()).await;
    // A file that others can read, and files without keys.
    let folder = TempDir::new().unwrap();
    let keys = folder.path().join("keys");
    let with_keys = |text: &str, mode: u32| {
        std::fs::File::create(&keys).unwrap().write_all(text.as_bytes()).unwrap();
        std::fs::set_permissions(&keys, std::fs::Permissions::from_mode(mode)).unwrap();
        let keys = keys.clone();
        refusal(&move |settings| settings.files_credentials_file = Some(keys.clone()))
    };
    let pair = "aws_access_key_id = a\naws_secret_access_key = s3cret\n";
    let open = with_keys(pair, 0o644).await;
    assert!(open.contains("has the mode 644") && !open.contains("s3cret"), "{open}");
    let wrong = with_keys("s3cret\n", 0o600).await;
    assert!(wrong.contains("line 1") && !wrong.contains("s3cret"), "{wrong}");
    // And with what is right it goes on.
    let held = Arc::<Held>::default();
    std::fs::write(&keys, pair).unwrap();
    let app = first(&data, &held, |settings| settings.files_credentials_file = Some(keys.clone())).await;
    assert_eq!(from_the_bucket(&app, &place).await.text().await.unwrap(), "G1 X10\n");
    app.stop().await;
}
