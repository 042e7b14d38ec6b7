//! The binary: it says where it listens, stops with status 0 when told to, and takes its settings in order.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;
use trunnion::config::{ENVIRONMENT, Flags, Settings};

use crate::database::{address_of, bucket_server};

pub(crate) fn binary(data: &TempDir) -> Command {
    let mut command = unset();
    let data = data.path().join("data");
    // The command uses the database that a service of this test has.
    command.envs(address_of(&data).map(|address| ("TRUNNION_DATABASE", address)));
    command.env("TRUNNION_DATA_DIR", data).stdout(Stdio::piped()).stderr(Stdio::null());
    command
}

/// The binary, with no setting from outside, and nothing that it would take for one.
pub(crate) fn unset() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trunnion"));
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("TRUNNION_") {
            command.env_remove(name);
        }
    }
    // But the server of the bucket, which only matters where files are in it.
    command.envs(bucket_server().map(|address| ("TRUNNION_FILES_ENDPOINT", address)));
    command
}

/// The address that the first line names.
pub(crate) fn address(child: &mut Child) -> String {
    first_lines(child).0
}

/// The address that the first line names, and what is said of keys: in the third line, or in the only one of JSON.
pub(crate) fn first_lines(child: &mut Child) -> (String, String) {
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let first = lines.next().unwrap().unwrap();
    if let Ok(only) = serde_json::from_str::<Value>(&first) {
        let member = |name: &str| only["fields"][name].as_str().unwrap().to_owned();
        return (member("url").rsplit("://").next().unwrap().to_owned(), member("guarded"));
    }
    assert!(lines.next().unwrap().unwrap().contains("/docs"));
    (first.rsplit("://").next().unwrap().to_owned(), lines.next().unwrap().unwrap())
}

#[tokio::test]
async fn it_serves_and_a_signal_ends_it_with_status_0() {
    for signal in ["-TERM", "-INT"] {
        let data = TempDir::new().unwrap();
        let mut child = binary(&data).args(["serve", "--listen", "127.0.0.1:0"]).spawn().unwrap();
        let address = address(&mut child);
        let ready = reqwest::get(format!("http://{address}/readyz")).await.unwrap();
        assert_eq!(ready.status(), 200);
        let check =
            |address: &str| binary(&data).args(["healthcheck", "--listen", address]).status().unwrap();
        assert!(check(&address).success());
        let told = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(told.success());
        assert_eq!(child.wait().unwrap().code(), Some(0), "{signal}");
        assert!(!check(&address).success());
    }
}

#[test]
fn a_wrong_setting_ends_it_with_a_reason() {
    let data = TempDir::new().unwrap();
    for arguments in [
        ["--listen", "nowhere"],
        ["--config", "/none.toml"],
        ["--max-poses", "0"],
        ["--files", "s3://Plant"],
        ["--files-endpoint", "http://key:secret@127.0.0.1"],
    ] {
        let output = binary(&data).args(arguments).stderr(Stdio::piped()).output().unwrap();
        assert!(!output.status.success() && !output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn a_log_that_would_stay_empty_is_refused() {
    let data = TempDir::new().unwrap();
    let show = |log: &str| {
        binary(&data).args(["config", "show", "--log", log]).stderr(Stdio::piped()).output().unwrap()
    };
    for log in [
        "",
        "[",
        "zzz=",
        "=debug",
        "zzz=loud",
        "info,",
        "inof",
        "trunnion",
        "info,,",
        "trunnion[{id}]=info",
        "a=b=info",
        "*=info",
    ] {
        let output = show(log);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{log:?}: {text}");
        assert!(text.contains(&format!("log is {log:?}")), "{log:?}: {text}");
    }
    for log in ["info", "OFF", "warn,trunnion=debug", "trunnion::http=Trace,error"] {
        let output = show(log);
        assert!(output.status.success(), "{log}: {}", String::from_utf8_lossy(&output.stderr));
    }
}

#[cfg(not(feature = "otlp"))]
#[test]
fn spans_that_this_binary_cannot_send_are_not_promised() {
    let data = TempDir::new().unwrap();
    let mut command = binary(&data);
    command.args(["--listen", "127.0.0.1:0", "--otlp-endpoint", "http://127.0.0.1:4318"]);
    let output = command.stderr(Stdio::piped()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("http://127.0.0.1:4318") && text.contains("feature otlp"), "{text}");
    assert!(output.stdout.is_empty() && !data.path().join("data").exists());
}

#[test]
fn flags_win_over_the_file_and_the_file_over_the_defaults() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("trunnion.toml");
    std::fs::write(&file, "max_poses = 7\nmax_json_bytes = 1000\n").unwrap();
    let flags = Flags { max_poses: Some(9), ..Flags::default() };
    let settings = Settings::load(&flags, Some(&file)).unwrap();
    assert_eq!((settings.max_poses, settings.max_json_bytes), (9, 1000));
    assert_eq!(settings.max_body_bytes, Settings::default().max_body_bytes);
    std::fs::write(&file, "max_pose = 7\n").unwrap();
    let fault = Settings::load(&Flags::default(), Some(&file)).unwrap_err().to_string();
    assert!(fault.contains("max_pose"), "{fault}");
}

#[test]
fn the_environment_is_read_and_flags_win_over_it() {
    use clap::Parser;
    let data = TempDir::new().unwrap();
    let output = binary(&data).env("TRUNNION_LISTEN", "nonsense").stderr(Stdio::piped()).output().unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("nonsense"));
    let cli = trunnion::cli::Cli::try_parse_from(["trunnion", "--listen", "127.0.0.1:1", "serve"]).unwrap();
    assert_eq!(cli.flags.listen, Some(([127, 0, 0, 1], 1).into()));
    let names: std::collections::BTreeSet<_> = ENVIRONMENT.iter().map(|(_, name)| name).collect();
    assert_eq!(names.len(), ENVIRONMENT.len());
    assert!(
        ENVIRONMENT.iter().all(|(setting, name)| **name == format!("TRUNNION_{}", setting.to_uppercase()))
    );
}
