//! What the lines of the log say: refusals, failed jobs, keys, health checks, and the start itself.

use std::process::Stdio;

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::observation::{answered, log_of};
use crate::process::binary;

const ALL: [&str; 5] = ["read", "compute", "machines", "calibrations", "admin"];

#[tokio::test]
async fn a_refusal_names_its_problem_and_its_key() {
    let mut narrow = String::new();
    let lines = log_of("info", async |base| {
        let client = reqwest::Client::builder().no_proxy().build().unwrap();
        let new_key = async |scopes: &[&str], with: Option<&str>| {
            let request =
                client.post(format!("{base}/v1/keys")).json(&json!({"name": "a test", "scopes": scopes}));
            let request = with.map_or(request.try_clone().unwrap(), |key| request.bearer_auth(key));
            request.send().await.unwrap().json::<Value>().await.unwrap()["key"].as_str().unwrap().to_owned()
        };
        let admin = new_key(&ALL, None).await;
        narrow = new_key(&["read"], Some(&admin)).await;
        let ask = async |path: &str, key: &str, id: &str| {
            let request = client.get(format!("{base}{path}")).bearer_auth(key).header("x-request-id", id);
            request.send().await.unwrap().status().as_u16()
        };
        assert_eq!(ask("/v1/keys", &narrow, "scope").await, 403);
        assert_eq!(ask("/v1/machines/nobody", &narrow, "machine").await, 404);
        assert_eq!(ask("/v1/machines", "trn_no_key", "unknown").await, 401);
        assert_eq!(ask("/v1/machines", &narrow, "fine").await, 200);
    })
    .await;
    let id = narrow.split('_').nth(1).unwrap();
    for (name, status, problem, key) in [
        ("scope", 403, json!("scope-missing"), json!(id)),
        ("machine", 404, json!("machine-not-found"), json!(id)),
        ("unknown", 401, json!("unauthenticated"), Value::Null),
        ("fine", 200, Value::Null, json!(id)),
    ] {
        let line = answered(&lines, name);
        assert_eq!(line["fields"]["status"], status, "{line}");
        assert_eq!((&line["fields"]["problem"], &line["span"]["key_id"]), (&problem, &key), "{line}");
    }
    let all = lines.iter().map(Value::to_string).collect::<String>();
    assert!(!all.contains(narrow.rsplit('_').next().unwrap()), "a secret is in the log");
}

#[tokio::test]
async fn health_checks_are_lines_of_a_log_of_everything_alone() {
    let asked = async |level| {
        log_of(level, async |base| {
            let client = reqwest::Client::builder().no_proxy().build().unwrap();
            for path in ["/healthz", "/readyz", "/metrics"] {
                let request = client.get(format!("{base}{path}")).header("x-request-id", path);
                assert_eq!(request.send().await.unwrap().status(), 200, "{path}");
            }
            let wrong = client.post(format!("{base}/healthz")).header("x-request-id", "wrong");
            assert_eq!(wrong.send().await.unwrap().status(), 405);
        })
        .await
    };
    let lines = asked("info").await;
    let has = |lines: &[Value], id: &str| lines.iter().any(|line| line["span"]["client_request_id"] == id);
    for (id, logged) in [("/healthz", false), ("/readyz", false), ("/metrics", true), ("wrong", true)] {
        assert_eq!(has(&lines, id), logged, "{id}: {lines:#?}");
    }
    assert_eq!(answered(&lines, "wrong")["fields"]["problem"], "method-not-allowed");
    let lines = asked("info,trunnion::http=debug").await;
    assert_eq!(answered(&lines, "/readyz")["level"], "DEBUG");
}

#[tokio::test]
async fn a_failed_job_says_why() {
    let mut id = String::new();
    let lines = log_of("info", async |base| {
        let client = reqwest::Client::builder().no_proxy().build().unwrap();
        let job = json!({
            "machine_id": "example-ac-table", "operation": "cc-compensation",
            "parameters": {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [0, 0, 0]}
        });
        let program = "G21 G90\nG1 X1 Y1 Z1 A0 C0 F100\nX5 A130\n";
        let form =
            Form::new().text("job", job.to_string()).part("program", Part::text(program).file_name("a.nc"));
        let posted = client.post(format!("{base}/v1/jobs")).multipart(form).send().await.unwrap();
        id = posted.json::<Value>().await.unwrap()["id"].as_str().unwrap().to_owned();
        let events = client.get(format!("{base}/v1/jobs/{id}/events")).send().await.unwrap();
        assert!(events.text().await.unwrap().contains("failed"));
    })
    .await;
    let failed: Vec<&Value> =
        lines.iter().filter(|line| line["fields"]["message"] == "the job failed").collect();
    assert_eq!(failed.len(), 1, "{lines:#?}");
    let line = failed[0];
    assert_eq!((&line["level"], &line["span"]["job_id"]), (&json!("WARN"), &json!(id)), "{line}");
    assert_eq!(
        (&line["fields"]["problem"], &line["fields"]["line"]),
        (&json!("out-of-travel"), &json!(3)),
        "{line}"
    );
    assert!(line["fields"]["detail"].as_str().unwrap().contains("130"), "{line}");
}

#[test]
fn a_start_that_fails_says_so_in_json_if_the_log_is_json() {
    let data = TempDir::new().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().to_string();
    let file = data.path().join("trunnion.toml");
    std::fs::write(&file, "log_format = \"json\"\n").unwrap();
    let file = file.to_str().unwrap();
    let json = ("TRUNNION_LOG_FORMAT", "json");
    for (arguments, variables, part) in [
        (&["--listen", &port, "--log-format", "json"][..], &[][..], "cannot listen"),
        (&["serve", "--listen", &port], &[json], "cannot listen"),
        (&["--listen", &port, "--config", file], &[], "cannot listen"),
        (&["--listen", "nonsense"], &[json], "nonsense"),
        (&["--max-poses", "0", "--log-format=json"], &[], "max_poses is 0"),
        (&["serve"], &[json, ("TRUNNION_LISTNE", "x")], "did you mean TRUNNION_LISTEN?"),
    ] {
        let mut command = binary(&data);
        command.args(arguments).envs(variables.iter().copied()).stderr(Stdio::piped());
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let last = lines.last().unwrap();
        assert_eq!((&last["level"], lines.len()), (&"ERROR".into(), 1), "{text}");
        assert!(last["fields"]["error"].as_str().unwrap().contains(part), "{text}");
        assert!(last["timestamp"].as_str().unwrap().ends_with('Z'), "{text}");
    }
    // Without JSON, and for people who ask for another command, it is a sentence.
    for arguments in [&["--listen", &port][..], &["backup", "nowhere", "--log-format", "json"]] {
        let output = binary(&data).args(arguments).stderr(Stdio::piped()).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.starts_with("trunnion: "), "{arguments:?}: {text}");
    }
}

#[tokio::test]
async fn warnings_of_the_start_are_lines_of_the_log() {
    let data = TempDir::new().unwrap();
    let mut command = binary(&data);
    command.args(["--listen", "127.0.0.1:0", "--log-format", "json"]).stderr(Stdio::piped());
    command.envs([("TRUNNION_PORT", "tcp://10.0.0.7:80"), ("TRUNNION_SERVICE_HOST", "10.0.0.7")]);
    let mut child = command.spawn().unwrap();
    let address = crate::process::address(&mut child);
    assert_eq!(reqwest::get(format!("http://{address}/readyz")).await.unwrap().status(), 200);
    let told = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(told.success());
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let first = lines[0]["fields"]["message"].as_str().unwrap();
    assert!(first.contains("TRUNNION_PORT, TRUNNION_SERVICE_HOST"), "{text}");
    assert_eq!(text.matches("enableServiceLinks").count(), 1, "{text}");
}
