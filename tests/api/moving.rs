//! `trunnion migrate --to`: a data directory on a server has everything that it had before, to the byte, or nothing was
//! moved and the reason is said (`docs/scale-out.md`). Each test does something only with `TRUNNION_TEST_DATABASE`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use reqwest::StatusCode;
use serde_json::{Value, json};
use tempfile::TempDir;
use trunnion::config::{FilesIn, Settings};
use trunnion::jobs::Compensator;

use crate::command_line::{files, posted, said};
use crate::database::{address_of, ask, places, put_on_the_server, schema_of, server, shared_place};
use crate::deep::rewritten;
use crate::process::unset;
use crate::queue::{Held, accepted, cc, document, ended, form, running};
use crate::receiver::Receiver;
use crate::scale_out::is_sound_but_for_fsync;
use crate::support::{App, spawn_real_in};
use crate::webhooks::at_once;

const SHOP: &str = "/v1/machines/demo-ac-table";

/// A command on a data directory with a database file.
fn command(data: &Path, arguments: &[&str]) -> Command {
    let mut command = unset();
    command.args(arguments).env("TRUNNION_DATA_DIR", data);
    command
}

fn run(data: &Path, arguments: &[&str]) -> Output {
    command(data, arguments).output().unwrap()
}

/// The command that moves a data directory to the schema that has its name.
fn moving<'a>(target: &'a str, place: &'a str) -> [&'a str; 5] {
    ["migrate", "--to", target, "--files", place]
}

fn moved(data: &Path, target: &str, place: &str) -> String {
    let done = run(data, &moving(target, place));
    assert!(done.status.success(), "{}", said(&done));
    said(&done)
}

fn refused(data: &Path, target: &str, place: &str) -> String {
    let before = files(data);
    let done = run(data, &moving(target, place));
    assert_eq!(done.status.code(), Some(2), "{}", said(&done));
    assert!(data.join("trunnion.sqlite").is_file());
    assert_eq!(files(&data.join("blobs")).len(), before.iter().filter(|path| is_blob(path)).count());
    said(&done)
}

fn is_blob(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.len() == 64)
}

/// A service on the database file of a directory.
async fn on_the_file(data: &Path, held: &Arc<Held>) -> App {
    let change = |settings: &mut Settings| {
        settings.database = None;
        settings.files = FilesIn::Directory;
        settings.max_computations = 1;
        at_once(settings);
    };
    spawn_real_in(data, change, Arc::clone(held) as Arc<dyn Compensator>).await
}

/// A service on the server, with the same data directory.
async fn on_the_server(data: &Path, held: &Arc<Held>, place: FilesIn) -> App {
    let change = move |settings: &mut Settings| {
        settings.files = place;
        settings.max_computations = 1;
        at_once(settings);
    };
    spawn_real_in(data, change, Arc::clone(held) as Arc<dyn Compensator>).await
}

/// A small directory with one job, and the address to which it is moved.
async fn small(folder: &TempDir) -> (PathBuf, String) {
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    let app = on_the_file(&data, &Arc::default()).await;
    posted(&app).await;
    app.stop().await;
    let target = address_of(&data).unwrap();
    (data, target)
}

fn rows(data: &Path, table: &str) -> String {
    ask(&format!("SELECT count(*) FROM {}.{table}", schema_of(data)))
}

/// Bodies with their tags, by their paths.
async fn read(app: &App, paths: &[String]) -> BTreeMap<String, (u16, Option<String>, Vec<u8>)> {
    let mut all = BTreeMap::new();
    for path in paths {
        let answer = app.get(path).await;
        let tag = answer.headers().get("etag").map(|tag| tag.to_str().unwrap().to_owned());
        let status = answer.status().as_u16();
        all.insert(path.clone(), (status, tag, answer.bytes().await.unwrap().to_vec()));
    }
    all
}

async fn items(app: &App, path: &str) -> Vec<Value> {
    let list: Value = app.get(path).await.json().await.unwrap();
    list["items"].as_array().unwrap().clone()
}

/// Everything that can be read and does not change by itself.
async fn everything(app: &App) -> Vec<String> {
    let mut paths = ["/v1/machines", "/v1/webhooks/secret"].map(str::to_owned).to_vec();
    for machine in items(app, "/v1/machines").await {
        let at = format!("/v1/machines/{}", machine["machine_id"].as_str().unwrap());
        paths.extend([format!("{at}/tools"), format!("{at}/calibrations"), at]);
    }
    for run in items(app, &format!("{SHOP}/calibrations")).await {
        paths.push(format!("{SHOP}/calibrations/{}", run["id"].as_str().unwrap()));
    }
    paths.push(format!("{SHOP}/calibrations/trend?axis=A&error=e_y"));
    paths.push(format!("{SHOP}/tools/T12/wear-entries"));
    paths.push(format!("{SHOP}/tools/T12/wear-trend?limit_um=60&cutter_id=2"));
    for job in items(app, "/v1/jobs").await {
        let at = format!("/v1/jobs/{}", job["id"].as_str().unwrap());
        paths.extend(["program", "report", "plot", "deliveries"].map(|part| format!("{at}/{part}")));
        paths.push(at);
    }
    paths
}

#[tokio::test]
async fn a_directory_on_a_server_answers_as_before_to_the_byte_and_goes_on_with_its_jobs() {
    if server().is_none() {
        return;
    }
    for place in places() {
        let folder = TempDir::new().unwrap();
        let data = folder.path().join("data");
        let demo = run(&data, &["demo"]);
        assert!(demo.status.success(), "{}", said(&demo));
        let held = Arc::<Held>::default();
        let mut app = on_the_file(&data, &held).await;
        let key = app.close().await;
        let paths = everything(&app).await;
        let before = read(&app, &paths).await;
        assert!(before.len() > 40 && before.values().filter(|(status, ..)| *status == 200).count() > 30);
        // Two jobs that have not ended: one is computed, one waits. Both are posted under a key.
        let mut receiver = Receiver::saying(&[]).await;
        let mut order = cc("demo-ac-table");
        order["callback_url"] = receiver.url().into();
        let post = async |app: &App, key: &str, text: &str| -> Value {
            let post = app.client.post(app.url("/v1/jobs")).header("idempotency-key", key);
            post.multipart(form(&order, text)).send().await.unwrap().json().await.unwrap()
        };
        let first = post(&app, "first", "HOLD\n").await;
        let second = post(&app, "second", "g1 x2\n").await;
        let [first, second] = [first, second].map(|job| format!("/v1/jobs/{}", job["id"].as_str().unwrap()));
        running(&app, &first).await;
        let in_use = run(&data, &moving(&address_of(&data).unwrap(), &place.to_string()));
        assert_eq!(in_use.status.code(), Some(2));
        assert!(said(&in_use).contains("another trunnion uses the data directory"), "{}", said(&in_use));
        let audit = items(&app, "/v1/audit?limit=200").await;
        app.stop().await;
        // As a process leaves it that was killed.
        let job = first.trim_start_matches("/v1/jobs/");
        rewritten(&data, &format!("UPDATE jobs SET state = 'running', lease = id WHERE id = '{job}'")).await;

        let target = address_of(&data).unwrap();
        let told = moved(&data, &target, &place.to_string());
        assert!(told.contains("were compared") && told.contains("trunnion.sqlite.migrated"), "{told}");
        assert!(!data.join("trunnion.sqlite").exists() && data.join("trunnion.sqlite.migrated").is_file());
        let shared = place.is_shared();
        assert_eq!(data.join("blobs").is_dir(), !shared, "a service would take them for copies");
        assert_eq!(data.join("blobs.migrated").is_dir(), shared);
        let id = ask(&format!("SELECT database_id FROM {}.service", schema_of(&data)));
        assert_eq!(std::fs::read_to_string(data.join("database.id")).unwrap().trim(), id);
        let looked = {
            let mut command = command(&data, &["doctor", "--deep", "--files", &place.to_string()]);
            command.env("TRUNNION_DATABASE", &target).output().unwrap()
        };
        assert!(is_sound_but_for_fsync(&looked), "{}", said(&looked));

        let other = Arc::<Held>::default();
        other.release();
        let mut app = on_the_server(&data, &other, place.clone()).await;
        app.client = keyed(&key);
        for place in [&first, &second] {
            assert_eq!(ended(&app, place).await["state"], "succeeded");
        }
        let mut told = [receiver.next().await.json(), receiver.next().await.json()]
            .map(|told| told["data"]["id"].as_str().unwrap_or_else(|| panic!("{told}")).to_owned());
        told.sort();
        let mut ids = [&first, &second].map(|place| place.trim_start_matches("/v1/jobs/").to_owned());
        ids.sort();
        assert_eq!(told, ids);
        let after = read(&app, &paths).await;
        for (path, answer) in &before {
            assert!(after[path] == *answer, "{path}: {:?} {:?}", answer.1, after[path].1);
        }
        let again = post(&app, "second", "g1 x2\n").await;
        assert_eq!(format!("/v1/jobs/{}", again["id"].as_str().unwrap()), second);
        let grown = items(&app, "/v1/audit?limit=200").await;
        assert_eq!(&grown[grown.len() - audit.len()..], audit);
        // What is new goes on counting.
        let put = app.client.put(app.url(SHOP)).header("if-match", "*");
        let machine: Value = app.get(SHOP).await.json().await.unwrap();
        let body = json!({"name": "changed", "kinematics": machine["kinematics"]});
        let put = put.json(&body).send().await.unwrap();
        assert_eq!(put.status(), StatusCode::OK, "{}", put.text().await.unwrap());
        let third = accepted(&app, &cc("demo-ac-table"), "g1 x3\n").await;
        assert_eq!(document(&app, &third).await["machine_revision"], 3);
        assert_eq!(ended(&app, &third).await["state"], "succeeded");
        app.stop().await;
        let again = run(&data, &moving(&target, &place.to_string()));
        assert_eq!(again.status.code(), Some(2));
        assert!(said(&again).contains("was moved to a server before"), "{}", said(&again));
    }
}

/// A client with this key.
fn keyed(key: &str) -> reqwest::Client {
    let mut headers = reqwest::header::HeaderMap::new();
    headers.insert("authorization", format!("Bearer {key}").parse().unwrap());
    reqwest::Client::builder().no_proxy().default_headers(headers).build().unwrap()
}

#[tokio::test]
async fn what_cannot_be_moved_is_named_and_nothing_is_moved() {
    if server().is_none() {
        return;
    }
    let folder = TempDir::new().unwrap();
    let (data, target) = small(&folder).await;
    // A target that somebody uses, and one that somebody used.
    let other = TempDir::new().unwrap();
    let used = crate::support::spawn_in(other.path(), |_| {}).await;
    let of_other = address_of(other.path()).unwrap();
    assert!(refused(&data, &of_other, "directory").contains("is in use by trunnion"));
    used.stop().await;
    let told = refused(&data, &of_other, "directory");
    assert!(told.contains("has rows already (table machines)"), "{told}");
    // A file that is damaged, and one that is missing.
    let blob = files(&data.join("blobs")).pop().unwrap();
    let name = blob.file_name().unwrap().to_str().unwrap().to_owned();
    let bytes = std::fs::read(&blob).unwrap();
    for place in ["directory", "postgres"] {
        std::fs::write(&blob, "other bytes").unwrap();
        let told = refused(&data, &target, place);
        assert!(told.contains(&name) && told.contains("has changed"), "{told}");
        std::fs::write(&blob, &bytes).unwrap();
        std::fs::rename(&blob, data.join("away")).unwrap();
        let done = run(&data, &moving(&target, place));
        assert!(said(&done).contains(&name) && said(&done).contains("is missing"), "{}", said(&done));
        std::fs::rename(data.join("away"), &blob).unwrap();
    }
    // A text that the server cannot store.
    let id = "1".repeat(36);
    let wear = format!(
        "INSERT INTO wear_entries (id, machine_id, tool_id, cutter_id, edge, quantity, parts_cut, wear_um, measured_at,
             created_at, note, posted_with)
         VALUES ('{id}', 'example-ac-table', 't', 'c', '', 'radius', 1, 1.0, '2026-01-01T00:00:00.000Z',
             '2026-01-01T00:00:00.000Z', 'a' || char(0) || 'b', '{id}')"
    );
    rewritten(&data, &wear).await;
    let told = refused(&data, &target, "directory");
    assert!(
        told.contains("U+0000") && told.contains(&format!("wear_entries seq 1 id \"{id}\": note")),
        "{told}"
    );
    rewritten(&data, "DELETE FROM wear_entries").await;
    // Rows that are not what was written.
    let report = "UPDATE jobs SET report = json_set(report, '$.blocks_out', 1)";
    rewritten(&data, &format!("CREATE TABLE kept AS SELECT report FROM jobs; {report}")).await;
    let told = refused(&data, &target, "directory");
    assert!(told.contains("the database is damaged"), "{told}");
    rewritten(&data, "UPDATE jobs SET report = (SELECT report FROM kept); DROP TABLE kept").await;
    // A schema of before.
    let version = "SELECT max(version) FROM _sqlx_migrations";
    rewritten(&data, &format!("UPDATE _sqlx_migrations SET version = 1 WHERE version = ({version})")).await;
    let told = refused(&data, &target, "directory");
    assert!(told.contains("run trunnion migrate without --to first"), "{told}");
    let newest = trunnion::store::own_schema();
    rewritten(&data, &format!("UPDATE _sqlx_migrations SET version = {newest} WHERE version = 1")).await;
    assert_eq!((rows(&data, "machines"), rows(&data, "jobs")), ("0".into(), "0".into()));
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    let nothing = run(&empty, &moving(&target, "directory"));
    assert!(said(&nothing).contains("there is no database in"), "{}", said(&nothing));
    // And after all that, it can be moved.
    moved(&data, &target, "directory");
    assert_eq!(rows(&data, "jobs"), "1");
}

/// A session of the server that keeps others from writing to a table, as long as it is not dropped.
struct Locked(Child);

impl Locked {
    fn table(name: &str) -> Self {
        let text = format!("BEGIN; LOCK TABLE {name} IN EXCLUSIVE MODE; SELECT pg_sleep(60)");
        let mut call = Command::new("psql");
        call.args(["-Xq", "-c", &text]).arg(server().unwrap()).stdout(Stdio::null()).stderr(Stdio::null());
        let child = call.spawn().unwrap();
        let locks = format!(
            "SELECT count(*) FROM pg_locks WHERE granted AND mode = 'ExclusiveLock' AND relation = '{name}'::regclass"
        );
        until("a lock", || ask(&locks) == "1");
        Self(child)
    }
}

impl Drop for Locked {
    fn drop(&mut self) {
        // The server looks for its client only when it has something to say.
        let text = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE query LIKE '%pg_sleep(60)' AND pid <> pg_backend_pid()";
        ask(text);
        let _gone = self.0.wait();
    }
}

fn until(what: &str, is_so: impl Fn() -> bool) {
    let end = Instant::now() + Duration::from_secs(20);
    while !is_so() {
        assert!(Instant::now() < end, "{what} did not come");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Begins to move a directory, and kills the process when it waits for this table.
fn killed_at(data: &Path, target: &str, place: &str, table: &str) {
    let name = format!("{}.{table}", schema_of(data));
    let locked = Locked::table(&name);
    let mut command = command(data, &moving(target, place));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let waits = format!("SELECT count(*) FROM pg_locks WHERE NOT granted AND relation = '{name}'::regclass");
    until("the process at its table", || ask(&waits) == "1");
    child.kill().unwrap();
    child.wait().unwrap();
    drop(locked);
}

#[tokio::test]
async fn a_killed_run_leaves_nothing_or_what_the_next_run_goes_on_with() {
    if server().is_none() {
        return;
    }
    let folder = TempDir::new().unwrap();
    let (data, target) = small(&folder).await;
    // The tables are there, so that they can be locked.
    let empty = TempDir::new().unwrap();
    let mut made = command(empty.path(), &["migrate"]);
    assert!(made.env("TRUNNION_DATABASE", &target).output().unwrap().status.success());

    // While its files are kept: it has files and no rows, and no service begins with that.
    killed_at(&data, &target, "postgres", "file_parts");
    until("the end of its session", || rows(&data, "files") == "1");
    assert_eq!(rows(&data, "machines"), "0");
    let on_it = |arguments: &[&str]| {
        let mut command = command(empty.path(), arguments);
        command.env("TRUNNION_DATABASE", &target).output().unwrap()
    };
    let start = on_it(&["serve", "--listen", "127.0.0.1:0", "--files", "postgres"]);
    assert_eq!(start.status.code(), Some(2), "{}", said(&start));
    assert!(said(&start).contains("run trunnion migrate --to once more"), "{}", said(&start));
    let looked = on_it(&["doctor", "--files", "postgres"]);
    assert_eq!(looked.status.code(), Some(1));
    assert!(said(&looked).contains("did not end"), "{}", said(&looked));

    // While its rows are stored: none is there, and a run with files in the directory forgets those that were kept.
    killed_at(&data, &target, "directory", "audit");
    until("the end of its session", || rows(&data, "machines") == "0");
    assert!(data.join("trunnion.sqlite").is_file());
    moved(&data, &target, "directory");
    assert_eq!((rows(&data, "jobs"), rows(&data, "files")), ("1".into(), "0".into()));

    // After its rows were stored: only the file is renamed.
    let back = || {
        std::fs::rename(data.join("trunnion.sqlite.migrated"), data.join("trunnion.sqlite")).unwrap();
    };
    back();
    let told = moved(&data, &target, "directory");
    assert!(told.contains("an earlier run had moved everything"), "{told}");
    // Unless one of both was used since.
    back();
    rewritten(&data, "INSERT INTO job_turns VALUES ('later', 1)").await;
    let told = refused(&data, &target, "directory");
    assert!(told.contains("the table job_turns differs"), "{told}");
}

#[tokio::test]
async fn a_file_of_several_parts_is_moved_and_damage_on_the_way_is_found() {
    if server().is_none() {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    let held = Arc::<Held>::default();
    held.release();
    let app = on_the_file(&data, &held).await;
    let long = format!("g1 x{}\n", "1".repeat(18 << 20));
    let job = accepted(&app, &cc("example-ac-table"), &long).await;
    assert_eq!(ended(&app, &job).await["state"], "succeeded");
    app.stop().await;
    let target = address_of(&data).unwrap();
    moved(&data, &target, &shared_place().to_string());
    assert_eq!(rows(&data, "files"), "2");
    // Another directory: all that a service needs is in the database.
    let other = TempDir::new().unwrap();
    put_on_the_server(other.path());
    let change = |settings: &mut Settings| {
        settings.database = Some(target.parse().unwrap());
        settings.files = shared_place();
    };
    let app = spawn_real_in(other.path(), change, Arc::clone(&held) as Arc<dyn Compensator>).await;
    let program = app.get(&format!("{job}/program")).await.text().await.unwrap();
    assert!(program == long.to_ascii_uppercase());
    app.stop().await;
}
