//! Keys from the command line, and where a service without keys may listen.

use std::process::{Child, Command, Output, Stdio};

use reqwest::Client;
use serde_json::Value;
use tempfile::TempDir;

use crate::process::{address, binary, first_lines};

/// A service that ends with the test.
struct Serving(Child);

impl Drop for Serving {
    fn drop(&mut self) {
        let _told = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        let _ended = self.0.wait();
    }
}

fn keys(data: &TempDir, arguments: &[&str]) -> Output {
    binary(data).arg("keys").args(arguments).stderr(Stdio::piped()).output().unwrap()
}

fn made(data: &TempDir, arguments: &[&str]) -> String {
    let output = keys(data, &[&["create"], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 1, "{text}");
    text.trim().to_owned()
}

fn id(key: &str) -> &str {
    key.split('_').nth(1).unwrap()
}

async fn status(client: &Client, url: &str, key: &str) -> u16 {
    client.get(url).bearer_auth(key).send().await.unwrap().status().as_u16()
}

#[tokio::test]
async fn keys_are_made_and_revoked_beside_a_running_service_and_take_effect_at_once() {
    let data = TempDir::new().unwrap();
    let mut child = binary(&data).args(["serve", "--listen", "127.0.0.1:0"]).spawn().unwrap();
    let (address, guarding) = first_lines(&mut child);
    let _serving = Serving(child);
    assert!(guarding.contains("no API key"), "{guarding}");
    let client = Client::builder().no_proxy().build().unwrap();
    let url = format!("http://{address}/v1/machines");
    assert_eq!(client.get(&url).send().await.unwrap().status(), 200);
    let office = made(&data, &["--name", "office", "--scopes", "admin,read"]);
    assert_eq!(client.get(&url).send().await.unwrap().status(), 401);
    assert_eq!(status(&client, &url, &office).await, 200);
    let mes = made(&data, &["--name", "MES", "--scopes", "read", "--machines", "example-ac-table"]);
    assert_eq!(status(&client, &url, &mes).await, 200);
    assert!(keys(&data, &["revoke", id(&mes)]).status.success());
    assert_eq!(status(&client, &url, &mes).await, 401);
    let list = String::from_utf8(keys(&data, &["list"]).stdout).unwrap();
    let lines: Vec<Vec<&str>> = list.lines().map(|line| line.split('\t').collect()).collect();
    assert_eq!(lines.len(), 3, "{list}");
    assert_eq!(
        (lines[1][0], lines[1][1], lines[1][2], lines[1][7]),
        (id(&office), "read,admin", "all", "office")
    );
    assert_eq!((lines[2][0], lines[2][2], lines[2][7]), (id(&mes), "example-ac-table", "MES"));
    assert!(lines[1][5] == "-" && lines[2][5].len() == 24, "{list}");
    for key in [&office, &mes] {
        assert!(!list.contains(key.rsplit('_').next().unwrap()));
    }
    let log = client.get(format!("http://{address}/v1/audit")).bearer_auth(&office).send().await.unwrap();
    let log: Value = log.json().await.unwrap();
    let told: Vec<_> = log["items"].as_array().unwrap().iter().take(3).collect();
    assert!(told.iter().all(|entry| entry["origin"] == "command-line"), "{log}");
    assert_eq!(told[0]["action"], "key-revoked");
}

#[test]
fn a_key_can_be_made_before_the_first_start_and_what_cannot_be_is_refused() {
    let data = TempDir::new().unwrap();
    let nowhere = keys(&data, &["list"]);
    assert!(!nowhere.status.success() && !data.path().join("data").exists());
    let key = made(&data, &["--name", "office", "--scopes", "admin"]);
    assert_eq!(String::from_utf8(keys(&data, &["list"]).stdout).unwrap().lines().count(), 2);
    for (wrong, said) in [
        (&["create", "--name", "a", "--scopes", "all"][..], "read, compute, machines"),
        (&["create", "--name", "a", "--scopes", "admin", "--machines", "b"], "/machines"),
        (&["create", "--name", "a", "--scopes", "read", "--expires-at", "soon"], "/expires_at"),
        (&["create", "--name", "a"], "--scopes"),
        (&["revoke", "nobody"], "no key nobody"),
    ] {
        let output = keys(&data, wrong);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(said), "{wrong:?}: {text}");
    }
    assert!(keys(&data, &["revoke", id(&key)]).status.success());
    // Twice is once.
    assert!(keys(&data, &["revoke", id(&key)]).status.success());
}

#[tokio::test]
async fn a_database_in_another_form_is_not_touched_beside_a_running_service() {
    use sqlx::Connection;
    let data = TempDir::new().unwrap();
    let mut child = binary(&data).args(["serve", "--listen", "127.0.0.1:0"]).spawn().unwrap();
    address(&mut child);
    let _serving = Serving(child);
    let file = format!("sqlite://{}", data.path().join("data/trunnion.sqlite").display());
    let mut connection = sqlx::SqliteConnection::connect(&file).await.unwrap();
    let newer = "INSERT INTO _sqlx_migrations (version, description, success, checksum, execution_time)
                 VALUES (29991231000000, 'of a later version', TRUE, x'00', 0)";
    sqlx::query(newer).execute(&mut connection).await.unwrap();
    let output = keys(&data, &["create", "--name", "a", "--scopes", "admin"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && text.contains("29991231000000"), "{text}");
    let made: i64 =
        sqlx::query_scalar("SELECT COUNT(*) FROM api_keys").fetch_one(&mut connection).await.unwrap();
    assert_eq!(made, 0);
}

#[test]
fn without_a_key_it_listens_on_loopback_alone_unless_told_otherwise() {
    let everywhere = ["serve", "--listen", "0.0.0.0:0"];
    let data = TempDir::new().unwrap();
    let output = binary(&data).args(everywhere).stderr(Stdio::piped()).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && output.stdout.is_empty(), "{text}");
    assert!(text.contains("trunnion keys create") && text.contains("--insecure"), "{text}");
    let starts = |command: &mut Command| {
        let mut serving = Serving(command.spawn().unwrap());
        first_lines(&mut serving.0).1
    };
    let told = starts(binary(&data).args(everywhere).arg("--insecure"));
    assert!(told.starts_with("INSECURE"), "{told}");
    let told = starts(binary(&data).args(everywhere).env("TRUNNION_INSECURE", "true"));
    assert!(told.starts_with("INSECURE"), "{told}");
    for loopback in ["127.0.0.2:0", "[::1]:0"] {
        // A system may have no address of the newer kind.
        if std::net::TcpListener::bind(loopback).is_ok() {
            let told = starts(binary(&data).args(["--listen", loopback]));
            assert!(told.starts_with("no API key"), "{told}");
        }
    }
    made(&data, &["--name", "office", "--scopes", "admin"]);
    let told = starts(binary(&data).args(everywhere));
    assert!(told.starts_with("API keys: 1"), "{told}");
}
