//! The commands beside `serve`: what they write, what they say, and how they end.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use rcgen::{CertifiedKey, generate_simple_self_signed};
use serde_json::{Value, json};
use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use tempfile::TempDir;
use trunnion::jobs::CutterContactCompensator;

use crate::database::address_of;
use crate::database::has_no_file;
use crate::process::unset;
use crate::support::{App, ac_table, spawn_in, spawn_real};

pub(crate) const BLADE: &str = include_str!("../../docs/examples/blade.nc");
const FLANK: &str = include_str!("../../docs/examples/flank.apt");

/// The binary, with no setting from outside.
fn command(arguments: &[&str]) -> Command {
    let mut command = unset();
    command.args(arguments);
    command
}

pub(crate) fn trunnion(data: &Path, arguments: &[&str]) -> Output {
    let mut command = command(arguments);
    // The command uses the database that a service of this test has.
    command
        .env("TRUNNION_DATA_DIR", data)
        .envs(address_of(data).map(|address| ("TRUNNION_DATABASE", address)));
    command.output().unwrap()
}

pub(crate) fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

pub(crate) fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A job with a program, posted; its address and its program.
pub(crate) async fn posted(app: &App) -> (String, String) {
    let response = app.post_text("/v1/machines/example-ac-table/posting", "text/plain", FLANK).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    (job, response.text().await.unwrap())
}

/// Every file below a folder.
pub(crate) fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

async fn execute(data: &Path, statement: &'static str) {
    let options = SqliteConnectOptions::new().filename(data.join("trunnion.sqlite"));
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap();
    sqlx::query(statement).execute(&pool).await.unwrap();
    pool.close().await;
}

#[test]
fn a_data_directory_may_be_named_relative_to_the_current_one() {
    for name in ["data", "./a/b/data"] {
        let folder = TempDir::new().unwrap();
        let mut command = command(&["migrate", "--data-dir", name]);
        let output = command.current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{name}: {}", said(&output));
        assert!(folder.path().join(name).join("trunnion.sqlite").is_file());
    }
}

#[tokio::test]
async fn the_doctor_names_what_is_wrong_and_ends_with_1() {
    if has_no_file("the_doctor_names_what_is_wrong_and_ends_with_1") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let none = trunnion(&data, &["doctor"]);
    assert!(none.status.success() && said(&none).contains("does not exist yet"), "{}", said(&none));
    let app = spawn_in(&data, |_| {}).await;
    posted(&app).await;
    let busy = trunnion(&data, &["doctor"]);
    assert!(busy.status.success(), "{}", said(&busy));
    for part in [
        "a service has the directory",
        "writable",
        "2 named in the database, all present",
        "file system",
        "free space",
    ] {
        assert!(said(&busy).contains(part), "{part}: {}", said(&busy));
    }
    app.stop().await;
    // Left over is a note; changed or missing is a fault.
    let folder = data.join("blobs/00");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("00".repeat(32)), "nobody's").unwrap();
    let left = trunnion(&data, &["doctor"]);
    assert!(left.status.success() && said(&left).contains("1 files that no row names"), "{}", said(&left));
    std::fs::remove_dir_all(&folder).unwrap();
    let blob = files(&data.join("blobs")).pop().unwrap();
    std::fs::write(&blob, "other bytes").unwrap();
    let changed = trunnion(&data, &["doctor"]);
    assert_eq!(changed.status.code(), Some(1));
    assert!(said(&changed).contains("has other bytes"), "{}", said(&changed));
    assert!(trunnion(&data, &["doctor", "--quick"]).status.success());
    std::fs::remove_file(&blob).unwrap();
    let missing = trunnion(&data, &["doctor", "--quick"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(said(&missing).contains("is missing"), "{}", said(&missing));
}

#[test]
fn the_doctor_reads_the_certificates_that_the_next_start_would() {
    let folder = TempDir::new().unwrap();
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    let other = generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        std::fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let (certificate, key) = (file("cert.pem", &cert.pem()), file("key.pem", &signing_key.serialize_pem()));
    let (strange, empty) = (file("other.pem", &other.signing_key.serialize_pem()), file("empty.pem", ""));
    let missing = folder.path().join("missing.pem").to_str().unwrap().to_owned();
    let asked = |key: &str, trusted: &str| {
        let settings = ["--tls-certificate", &certificate, "--tls-key", key, "--webhook-ca-file", trusted];
        trunnion(&folder.path().join("data"), &[&settings[..], &["doctor"]].concat())
    };
    let sound = asked(&key, &certificate);
    assert!(sound.status.success() && said(&sound).contains("1 certificates in"), "{}", said(&sound));
    for (key, trusted, fault) in [
        (&strange, &certificate, "cannot be used"),
        (&missing, &certificate, "cannot be read"),
        (&key, &empty, "holds no certificate"),
        (&key, &missing, "cannot be read"),
    ] {
        let output = asked(key, trusted);
        assert_eq!(output.status.code(), Some(1), "{key} {trusted}: {}", said(&output));
        assert!(said(&output).contains(fault), "{fault}: {}", said(&output));
    }
}

#[test]
fn a_mistyped_directory_is_not_made_to_look_into() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("mistyped");
    for command in [&["keys", "list"][..], &["webhooks", "secret"], &["webhooks", "rotate"]] {
        let output = trunnion(&data, command);
        assert_eq!(output.status.code(), Some(2), "{command:?}: {}", said(&output));
        assert!(said(&output).contains("mistyped") && !data.exists(), "{command:?}: {}", said(&output));
    }
}

#[tokio::test]
async fn a_newer_database_is_refused_with_both_schemas_and_stays_as_it_is() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let fresh = trunnion(&data, &["migrate"]);
    assert!(fresh.status.success() && said(&fresh).contains("a new database"), "{}", said(&fresh));
    let again = trunnion(&data, &["migrate"]);
    assert!(again.status.success() && said(&again).contains("already"), "{}", said(&again));
    let newest = trunnion::store::own_schema().to_string();
    assert!(said(&again).contains(&newest), "{}", said(&again));
    execute(
        &data,
        "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
         VALUES (99990101000000, 'later', 1, x'00', 0)",
    )
    .await;
    let before = std::fs::read(data.join("trunnion.sqlite")).unwrap();
    for command in [&["serve", "--listen", "127.0.0.1:0"][..], &["migrate"], &["doctor"]] {
        let output = trunnion(&data, command);
        assert!(!output.status.success(), "{command:?}");
        let text = said(&output);
        assert!(text.contains("99990101000000") && text.contains(&newest), "{command:?}: {text}");
    }
    assert_eq!(std::fs::read(data.join("trunnion.sqlite")).unwrap(), before);
    // It can still be backed up, but a restoration would give a database that this version cannot serve.
    let backup = folder.path().join("backup");
    assert!(trunnion(&data, &["backup", path(&backup)]).status.success());
    let restored = trunnion(&folder.path().join("restored"), &["restore", path(&backup)]);
    assert!(said(&restored).contains("99990101000000"), "{}", said(&restored));
}

#[test]
fn the_settings_are_shown_with_their_origins_and_read_back() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("trunnion.toml");
    std::fs::write(&file, "max_poses = 7\nlog = \"debug\"\n").unwrap();
    let output = trunnion(
        &folder.path().join("d"),
        &["config", "show", "--config", path(&file), "--max-json-bytes=9000"],
    );
    assert!(output.status.success(), "{}", said(&output));
    let shown = String::from_utf8(output.stdout.clone()).unwrap();
    let line = |name: &str| {
        shown
            .lines()
            .find(|line| line.starts_with(&format!("{name} = ")))
            .unwrap_or_else(|| panic!("{name}: {shown}"))
    };
    for (name, value, origin) in [
        ("max_poses", "7", path(&file)),
        ("log", "\"debug\"", path(&file)),
        ("max_json_bytes", "9000", "--max-json-bytes"),
        ("data_dir", &format!("{:?}", folder.path().join("d")), "environment TRUNNION_DATA_DIR"),
        ("max_cost_s", "120.0", "default"),
    ] {
        let (said, from) = line(name).split_once(" # ").unwrap();
        assert_eq!((said.trim(), from), (format!("{name} = {value}").as_str(), origin));
    }
    // What is shown is a settings file.
    std::fs::write(&file, &output.stdout).unwrap();
    let again = trunnion(&folder.path().join("d"), &["config", "show", "--config", path(&file)]);
    assert!(again.status.success(), "{}", said(&again));
    let from_file = String::from_utf8(again.stdout).unwrap();
    assert!(
        from_file.lines().all(|line| line.starts_with('#') || !line.ends_with("# default")),
        "{from_file}"
    );
}

#[test]
fn a_fault_in_the_settings_file_names_its_line_and_shows_none_of_its_text() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("trunnion.toml");
    for (text, expected) in [
        ("max_poses = 7\ndatabse = \"postgres://trunnion:secret@db/plant\"\n", "line 2"),
        ("max_poses = 7\n\nmax_cost_s = \"secret\n", "line 3"),
        ("listen = 8080\n", "line 1"),
    ] {
        std::fs::write(&file, text).unwrap();
        let output = trunnion(folder.path(), &["config", "show", "--config", path(&file)]);
        let said = said(&output);
        assert!(!output.status.success() && said.contains(expected) && said.contains(path(&file)), "{said}");
        assert!(!said.contains("secret"), "{said}");
    }
}

#[test]
fn the_description_printed_is_the_committed_one() {
    let folder = TempDir::new().unwrap();
    let output = trunnion(folder.path(), &["openapi"]);
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    let committed: Value = serde_json::from_str(include_str!("../../openapi/trunnion.json")).unwrap();
    assert!(printed == committed);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Files of one program, its machine and what is made of it.
pub(crate) struct Bench {
    folder: TempDir,
}

impl Bench {
    pub(crate) fn new(program: &str, machine: &Value) -> Self {
        let bench = Self { folder: TempDir::new().unwrap() };
        std::fs::write(bench.at("in.nc"), program).unwrap();
        std::fs::write(bench.at("machine.json"), machine.to_string()).unwrap();
        bench
    }

    pub(crate) fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn compensate(&self, more: &[&str]) -> Output {
        let (input, output, machine) = (self.at("in.nc"), self.at("out.nc"), self.at("machine.json"));
        let mut arguments = vec!["compensate", path(&input), path(&output), "--machine", path(&machine)];
        arguments.extend(more);
        let done = trunnion(&self.at("data"), &arguments);
        assert!(!self.at("data").exists(), "no data directory is made");
        done
    }
}

#[tokio::test]
async fn a_program_on_the_command_line_is_the_one_that_the_service_makes() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let machine: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    let bench = Bench::new(BLADE, &machine);
    let parameters = json!({"cc": {"tool_radius_mm": 5, "tolerance_um": 4}, "work_offset_mm": [12, -7, 35]});
    let form = reqwest::multipart::Form::new()
        .text("parameters", parameters.to_string())
        .part("program", reqwest::multipart::Part::text(BLADE).file_name("blade.nc"));
    let request = app.client.post(app.url("/v1/machines/example-ac-table/compensation")).multipart(form);
    let response = request.send().await.unwrap();
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let served = response.text().await.unwrap();
    let (report, changes) = (bench.at("report.json"), bench.at("changes.csv"));
    let files = ["--report", path(&report), "--changes", path(&changes)];
    let text = parameters.to_string();
    let done = bench.compensate(&[&["--parameters", &text][..], &files].concat());
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert_eq!(done.stderr, b"", "{}", said(&done));
    assert_eq!(std::fs::read_to_string(bench.at("out.nc")).unwrap(), served);
    let served: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    let written: Value = serde_json::from_slice(&std::fs::read(&report).unwrap()).unwrap();
    assert_eq!(written, served);
    let table = app.get(&format!("{job}/changes")).await.text().await.unwrap();
    assert_eq!(std::fs::read_to_string(&changes).unwrap(), table);
    // Parameters in a file, the report on standard output, another operation.
    std::fs::write(
        bench.at("parameters.json"),
        "{\"tool_radius_mm\": 5, \"tolerance_um\": 4, \"work_offset_mm\": [12, -7, 35]}",
    )
    .unwrap();
    let parameters = bench.at("parameters.json");
    let done = bench.compensate(&[
        "--operation",
        "cc-compensation",
        "--parameters",
        path(&parameters),
        "--report",
        "-",
    ]);
    let report: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(report["machine_revision"], 1, "{report}");
    assert!(report["after"]["max_um"].as_f64().unwrap() <= 4.0);
}

/// Parameters that a program in millimetres can do with.
const LOCATION_ERRORS: &str = "{\"location_errors\": true, \"work_offset_mm\": [0, 0, 0]}";
const CC: &str = "{\"cc\": {\"tool_radius_mm\": 5}, \"work_offset_mm\": [0, 0, 0]}";

#[test]
fn only_plain_files_are_replaced_and_each_result_has_its_own_place() {
    let bench = Bench::new("G21 G1 X1 Y1 Z1 A0 C0 F100\n", &ac_table());
    let given = ["--parameters", LOCATION_ERRORS];
    let output = bench.at("out.nc");
    for (places, part) in [
        (["--report", path(&output)], "two results"),
        (["--changes", path(&output)], "two results"),
        (["--report", "/dev/null"], "is not a regular file"),
        (["--report", "no/such/folder/r.json"], "no/such"),
    ] {
        let done = bench.compensate(&[&given[..], &places].concat());
        assert_eq!(done.status.code(), Some(2), "{}", said(&done));
        assert!(said(&done).contains(part), "{}", said(&done));
        assert!(!output.exists());
    }
    std::os::unix::fs::symlink(bench.at("elsewhere.nc"), &output).unwrap();
    let done = bench.compensate(&given);
    assert!(
        said(&done).contains("is not a regular file") && !bench.at("elsewhere.nc").exists(),
        "{}",
        said(&done)
    );
    std::fs::remove_file(&output).unwrap();
    let allow = |mode| std::fs::set_permissions(&output, Permissions::from_mode(mode)).unwrap();
    std::fs::write(&output, "mine").unwrap();
    allow(0o440);
    let done = bench.compensate(&given);
    assert_eq!(done.status.code(), Some(2), "{}", said(&done));
    assert!(said(&done).contains("is write-protected and is not replaced"), "{}", said(&done));
    assert_eq!(std::fs::read_to_string(&output).unwrap(), "mine");
    allow(0o640);
    let done = bench.compensate(&given);
    assert!(done.status.success(), "{}", said(&done));
    assert_ne!(std::fs::read_to_string(&output).unwrap(), "mine");
    assert_eq!(std::fs::metadata(&output).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn every_command_ends_with_2_where_it_could_not_do_its_work_and_with_1_where_it_says_no() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("garbage")).unwrap();
    std::fs::write(at("garbage/trunnion.sqlite"), "no database at all, but long enough to be looked at")
        .unwrap();
    std::fs::write(at("file"), "").unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().to_string();
    let nowhere = format!("127.0.0.1:{}", {
        std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
    });
    for (data, arguments, code) in [
        ("data", &["--listen", &port][..], 2),
        ("garbage", &["serve", "--listen", "127.0.0.1:0"], 2),
        ("file", &["serve", "--listen", "127.0.0.1:0"], 2),
        ("garbage", &["migrate"], 2),
        ("file", &["migrate"], 2),
        ("none", &["keys", "list"], 2),
        ("garbage", &["keys", "list"], 2),
        ("keyless", &["keys", "create", "--name", "a", "--scopes", "admin", "--expires-at", "soon"], 1),
        ("keyless", &["keys", "revoke", "nobody"], 1),
        ("none", &["backup", "elsewhere"], 2),
        ("none", &["restore", "elsewhere"], 2),
        ("garbage", &["doctor"], 1),
        ("none", &["healthcheck", "--listen", &nowhere], 1),
        ("none", &["config", "show", "--config", "nosuch.toml"], 2),
        ("none", &["config", "show", "--max-poses", "0"], 2),
        ("none", &["turn"], 2),
    ] {
        let output = trunnion(&at(data), arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", said(&output));
        assert!(!output.stderr.is_empty(), "{arguments:?}");
    }
    drop(taken);
}

/// The command with an output that nobody reads.
fn unread(data: &Path, arguments: &[&str]) -> Output {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = command(arguments);
    command.env("TRUNNION_DATA_DIR", data);
    command.stdout(writer).stderr(std::process::Stdio::piped());
    command.spawn().unwrap().wait_with_output().unwrap()
}

#[test]
fn what_cannot_be_printed_is_said_in_its_own_words_and_leaves_nothing() {
    let bench = Bench::new("G21 G1 X1 Y1 Z1 A0 C0 F100\n", &ac_table());
    let (data, input, output) = (bench.at("data"), bench.at("in.nc"), bench.at("out.nc"));
    let machine = bench.at("machine.json");
    let create = ["keys", "create", "--name", "office", "--scopes", "admin"];
    let compensate = [
        "compensate",
        path(&input),
        path(&output),
        "--machine",
        path(&machine),
        "--parameters",
        LOCATION_ERRORS,
        "--report",
        "-",
    ];
    for arguments in
        [&["openapi"][..], &["config", "show"], &["doctor"], &create, &["keys", "list"], &compensate]
    {
        let ended = unread(&data, arguments);
        let text = said(&ended);
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {text}");
        assert!(text.starts_with("trunnion: standard output cannot be written"), "{arguments:?}: {text}");
    }
    assert!(!output.exists());
    // The key that nobody saw was not made.
    let list = trunnion(&data, &["keys", "list"]);
    assert_eq!((list.status.code(), said(&list).lines().count()), (Some(0), 1), "{}", said(&list));
}

#[test]
fn the_limits_of_the_settings_hold_on_the_command_line() {
    let program = "G21 G1 X1.000 Y1.000 Z1.000 A0.000 C0.000 F100.\nG1 X8.000 A3.000 C6.000\n";
    let bench = Bench::new(program, &ac_table());
    let parameters = ["--parameters", CC];
    let with = |limit: &[&str]| bench.compensate(&[&parameters[..], limit].concat());
    let length = program.len();
    let (fits, over) = (length.to_string(), (length - 1).to_string());
    assert_eq!(with(&["--max-body-bytes", &fits]).status.code(), Some(0));
    std::fs::remove_file(bench.at("out.nc")).unwrap();
    for (limit, bytes) in
        [("--max-body-bytes", over.as_str()), ("--max-body-bytes", "1"), ("--max-result-bytes", "20")]
    {
        let done = with(&[limit, bytes]);
        assert_eq!(done.status.code(), Some(1), "{limit} {bytes}: {}", said(&done));
        assert!(said(&done).contains(&format!("limit of {bytes} bytes")), "{}", said(&done));
        assert!(!bench.at("out.nc").exists());
    }
}

#[test]
fn what_has_no_end_is_read_up_to_its_limit() {
    let bench = Bench::new("G21 G1 X1 Y1 Z1 A0 C0 F100\n", &ac_table());
    let profile = std::fs::metadata(bench.at("machine.json")).unwrap().len();
    let (fits, over) = (profile.to_string(), (profile - 1).to_string());
    let parameters = bench.at("parameters.json");
    let given = LOCATION_ERRORS;
    let (length, less) = (given.len().to_string(), (given.len() - 1).to_string());
    std::fs::write(&parameters, given).unwrap();
    for typed in [given, path(&parameters)] {
        let with = |limit: &[&str]| bench.compensate(&[&["--parameters", typed], limit].concat());
        let done = with(&["--max-parameters-bytes", &length, "--max-json-bytes", &fits]);
        assert_eq!(done.status.code(), Some(0), "{typed}: {}", said(&done));
        std::fs::remove_file(bench.at("out.nc")).unwrap();
        for (limit, bytes) in [("max-parameters-bytes", less.as_str()), ("max-json-bytes", over.as_str())] {
            let done = with(&[&format!("--{limit}"), bytes]);
            assert_eq!(done.status.code(), Some(1), "{typed}: {}", said(&done));
            let told = format!("limit of {bytes} bytes ({})", limit.replace('-', "_"));
            assert!(said(&done).contains(&told) && !bench.at("out.nc").exists(), "{}", said(&done));
        }
    }
    let endless = bench.compensate(&["--parameters", "/dev/zero"]);
    assert!(said(&endless).contains("/dev/zero is larger than"), "{}", said(&endless));
    let (input, endless) = (bench.at("in.nc"), ["--machine", "/dev/zero"]);
    let endless = trunnion(&bench.at("data"), &[&["compensate", path(&input)][..], &endless].concat());
    assert_eq!(endless.status.code(), Some(1), "{}", said(&endless));
    assert!(said(&endless).contains("(max_json_bytes)"), "{}", said(&endless));
}

#[test]
fn a_result_replaces_nothing_that_it_is_made_of_but_the_program() {
    let bench = Bench::new("G21 G1 X1 Y1 Z1 A0 C0 F100\n", &ac_table());
    let (input, parameters, surface) = (bench.at("in.nc"), bench.at("parameters.json"), bench.at("part.stl"));
    std::fs::write(&parameters, LOCATION_ERRORS).unwrap();
    std::fs::write(&surface, "solid\nendsolid\n").unwrap();
    // Another way to the same place, and a link to it.
    let roundabout = bench.at("folder");
    std::fs::create_dir(&roundabout).unwrap();
    let (machine, linked) = (roundabout.join("../machine.json"), bench.at("linked.json"));
    std::os::unix::fs::symlink(bench.at("machine.json"), &linked).unwrap();
    let contents = || files(bench.folder.path()).iter().map(|file| std::fs::read(file).unwrap()).collect();
    let before: Vec<Vec<u8>> = contents();
    let run = |output: &Path, more: &[&str]| {
        let made =
            [path(&input), path(output), "--machine", path(&linked), "--parameters", path(&parameters)];
        trunnion(&bench.at("data"), &[&["compensate"], &made[..], more].concat())
    };
    let out = bench.at("out.nc");
    for (output, more) in [
        (&machine, &[][..]),
        (&parameters, &[]),
        (&surface, &["--surface", path(&surface)]),
        (&out, &["--report", path(&machine)]),
        (&out, &["--report", path(&input)]),
        (&out, &["--changes", path(&parameters)]),
        (&out, &["--changes", path(&input)]),
        (&out, &["--surface", path(&surface), "--changes", path(&surface)]),
    ] {
        let done = run(output, more);
        assert_eq!(done.status.code(), Some(2), "{more:?}: {}", said(&done));
        assert!(said(&done).contains("is an input of this command"), "{more:?}: {}", said(&done));
        assert_eq!(contents(), before, "{more:?}");
    }
    let done = run(&input, &[]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert!(std::fs::read_to_string(&input).unwrap().contains("G1"));
}

#[test]
fn the_unit_of_a_program_can_be_stated_on_the_command_line() {
    let bench = Bench::new("G1 X1.0000 Y1.0000 Z1.0000 A0. C0. F100.\nX2. A20. C40.\n", &ac_table());
    let with = |more: &[&str]| bench.compensate(&[&["--parameters", CC], more].concat());
    let done = with(&[]);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    assert!(said(&done).contains("X is a length, and its unit is not known: give `unit`"), "{}", said(&done));
    let mut made = Vec::new();
    for unit in ["mm", "inch"] {
        let done = with(&["--unit", unit, "--report", "-"]);
        assert_eq!(done.status.code(), Some(0), "{unit}: {}", said(&done));
        let report: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(
            (&report["resolved"]["unit"], &report["resolved"]["unit_stated_by"]),
            (&json!(unit), &json!("request"))
        );
        made.push(report["cc"]["before"]["max_um"].as_f64().unwrap());
    }
    assert!(made[1] > made[0] + 500.0, "{made:?}");
    // An object without a member, one that has the member already, and another unit.
    let done = bench.compensate(&["--unit", "mm", "--parameters", " { } "]);
    assert!(said(&done).contains("no step is given"), "{}", said(&done));
    let twice = ["--unit", "mm", "--parameters", "{\"unit\": \"mm\"}"];
    assert!(said(&bench.compensate(&twice)).contains("no step is given"));
    let done = bench.compensate(&["--unit", "inch", "--parameters", "{\"unit\": \"mm\"}"]);
    let told = said(&done);
    assert!(told.contains("inch") && told.contains("mm") && done.status.code() == Some(2), "{told}");
    assert_eq!(with(&["--unit", "cm"]).status.code(), Some(2));
}

#[test]
fn what_is_refused_on_the_command_line_is_named_and_nothing_is_written() {
    let bench = Bench::new("G21 G1 X1 Y1 Z1 A0 C0 F100\nG1 X[#<_x>] A1\n", &ac_table());
    std::fs::write(bench.at("out.nc"), "as it was").unwrap();
    for (more, code, part) in [
        (&["--parameters", "{\"cc\": {\"tolerance_um\": 0}}"][..], 1, "/cc/tolerance_um"),
        (&["--parameters", "{\"location_errors\": 1}"], 1, "/location_errors"),
        (&["--operation", "posting"], 1, "cutter location data"),
        (&["--operation", "turning"], 2, "turning"),
        (&["--parameters", "none.json"], 2, "none.json"),
        (&["--operation", "servo-simulation"], 2, "makes no program"),
        (&["--operation", "posting", "--changes", "c.csv"], 2, "makes no table of changes"),
        (&["--max-cost-s", "0.000001", "--parameters", LOCATION_ERRORS], 1, "over the limit"),
    ] {
        let done = bench.compensate(more);
        assert_eq!(done.status.code(), Some(code), "{more:?}: {}", said(&done));
        assert!(said(&done).contains(part), "{more:?}: {}", said(&done));
        assert_eq!(std::fs::read_to_string(bench.at("out.nc")).unwrap(), "as it was", "{more:?}");
    }
    std::fs::write(bench.at("in.nc"), "G21 G1 X1 Y1 Z1 A0 C0 F100\nG1 X5 A130\n").unwrap();
    let done = bench.compensate(&["--parameters", CC]);
    assert_eq!(done.status.code(), Some(1), "{}", said(&done));
    assert!(said(&done).contains("first at line 2: G1 X5 A130"), "{}", said(&done));
    assert_eq!(std::fs::read_to_string(bench.at("out.nc")).unwrap(), "as it was");
    std::fs::write(bench.at("machine.json"), "{\"name\": \"x\"}").unwrap();
    assert_eq!(bench.compensate(&[]).status.code(), Some(1));
    std::fs::remove_file(bench.at("machine.json")).unwrap();
    assert_eq!(bench.compensate(&[]).status.code(), Some(2));
    // Nothing lies beside the files but the files.
    let mut names: Vec<_> = files(bench.folder.path());
    names.sort();
    assert_eq!(names, [bench.at("in.nc"), bench.at("out.nc")]);
}
