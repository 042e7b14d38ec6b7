//! `trunnion demo`: what it loads, that it is the same every time, and what it does not touch.

use std::path::Path;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::command_line::{path, posted, said, trunnion};
use crate::database::has_no_file;
use crate::support::{App, spawn_in};

const MACHINE: &str = "/v1/machines/demo-ac-table";

fn loaded(data: &Path) -> String {
    let done = trunnion(data, &["demo"]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert_eq!(done.stderr, b"", "{}", said(&done));
    String::from_utf8(done.stdout).unwrap()
}

async fn items(app: &App, path: &str) -> Vec<Value> {
    let list: Value = app.get(path).await.json().await.unwrap();
    list["items"].as_array().unwrap().clone()
}

/// Everything that was loaded, without ids and times of the load.
async fn content(app: &App) -> Value {
    let mut jobs = Vec::new();
    for job in items(app, "/v1/jobs").await {
        let at = |name: &str| format!("/v1/jobs/{}/{name}", job["id"].as_str().unwrap());
        let report = app.get(&at("report")).await.text().await.unwrap();
        let report = if job["state"] == "succeeded" { report } else { job["problem"]["detail"].to_string() };
        jobs.push(json!([
            job["external_id"],
            job["state"],
            job["input_sha256"],
            job["output_sha256"],
            report
        ]));
    }
    let trend = app.client.get(app.url(&format!("{MACHINE}/calibrations/trend?axis=A&error=e_y")));
    let trend: Value = trend.send().await.unwrap().json().await.unwrap();
    let points = trend["points"].as_array().unwrap().iter();
    let points: Vec<Value> = points.map(|point| json!([point["measured_at"], point["value"]])).collect();
    let wear: Value = app
        .get(&format!("{MACHINE}/tools/T12/wear-trend?limit_um=60&cutter_id=2"))
        .await
        .json()
        .await
        .unwrap();
    let mut machine: Value = app.get(MACHINE).await.json().await.unwrap();
    machine["created_at"] = Value::Null;
    json!({"jobs": jobs, "trend": points, "wear": wear["outlook"], "machine": machine})
}

#[tokio::test]
async fn an_empty_directory_gets_jobs_calibrations_and_wear_and_the_same_every_time() {
    if has_no_file("an_empty_directory_gets_jobs_calibrations_and_wear_and_the_same_every_time") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let mut all = Vec::new();
    for name in ["one", "two"] {
        let data = folder.path().join(name);
        let told = loaded(&data);
        let app = spawn_in(&data, |_| {}).await;
        // Every page that is named opens.
        let pages =
            told.lines().filter_map(|line| line.strip_prefix("  ")?.split_once("http://127.0.0.1:8080"));
        let pages: Vec<_> = pages.filter(|(what, _)| !what.contains("curl")).map(|(_, page)| page).collect();
        assert_eq!(pages.len(), 9, "{told}");
        for page in pages {
            let answer =
                app.client.get(app.url(page)).header("accept", "text/html,*/*;q=0.8").send().await.unwrap();
            assert_eq!(answer.status(), 200, "{page}");
        }
        all.push(content(&app).await);
        app.stop().await;
        // It is a data directory like any other.
        let sound = trunnion(&data, &["doctor", "--deep"]);
        assert_eq!(sound.status.code(), Some(0), "{}", said(&sound));
    }
    assert_eq!(all[0], all[1]);
    let content = &all[0];
    let states: Vec<&str> =
        content["jobs"].as_array().unwrap().iter().map(|job| job[1].as_str().unwrap()).collect();
    assert_eq!(states.iter().filter(|state| **state == "succeeded").count(), 6, "{states:?}");
    assert_eq!(states.iter().filter(|state| **state == "failed").count(), 1, "{states:?}");
    let refused = content["jobs"].as_array().unwrap().iter().find(|job| job[1] == "failed").unwrap();
    assert!(refused[4].as_str().unwrap().contains("125"), "{refused}");
    // The errors grow, and the fit finds them.
    let trend: Vec<f64> =
        content["trend"].as_array().unwrap().iter().map(|point| point[1].as_f64().unwrap()).collect();
    assert_eq!(trend.len(), 6);
    for (run, value) in trend.iter().enumerate() {
        assert!((value - (-8.0 - 1.5 * run as f64)).abs() < 1.0, "{trend:?}");
    }
    assert_eq!(content["machine"]["revision"], 2);
    let applied = &content["machine"]["kinematics"]["rotary_axes"][0]["location_error"]["e_y_um"];
    assert!((applied.as_f64().unwrap() - trend[4]).abs() < 1e-9, "{applied}");
    assert!(content["wear"].is_object(), "{content}");
}

#[tokio::test]
async fn a_directory_that_is_in_use_is_refused_and_stays_as_it_is() {
    if has_no_file("a_directory_that_is_in_use_is_refused_and_stays_as_it_is") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let app = spawn_in(&data, |_| {}).await;
    let busy = trunnion(&data, &["demo"]);
    assert_eq!(busy.status.code(), Some(2), "{}", said(&busy));
    posted(&app).await;
    app.stop().await;
    let before = std::fs::read(data.join("trunnion.sqlite")).unwrap();
    let used = trunnion(&data, &["demo"]);
    assert_eq!(used.status.code(), Some(2), "{}", said(&used));
    assert!(said(&used).contains("holds 1 rows in jobs; nothing was changed"), "{}", said(&used));
    assert!(said(&used).contains("--data-dir"), "{}", said(&used));
    assert_eq!(std::fs::read(data.join("trunnion.sqlite")).unwrap(), before);
    let photos = folder.path().join("photos");
    std::fs::create_dir(&photos).unwrap();
    std::fs::write(photos.join("cat.jpg"), "").unwrap();
    let foreign = trunnion(&photos, &["demo"]);
    assert_eq!(foreign.status.code(), Some(2), "{}", said(&foreign));
    assert!(said(&foreign).contains("holds \"cat.jpg\" and no database"), "{}", said(&foreign));
    assert_eq!(std::fs::read_dir(&photos).unwrap().count(), 1);
    let fresh = folder.path().join("fresh");
    std::fs::create_dir_all(fresh.join("lost+found")).unwrap();
    loaded(&fresh);
    let twice = trunnion(&fresh, &["demo"]);
    assert!(
        twice.status.code() == Some(2) && said(&twice).contains("holds 7 rows in jobs"),
        "{}",
        said(&twice)
    );
}

#[tokio::test]
async fn a_directory_with_keys_keeps_them_and_no_other_key_stays_valid() {
    if has_no_file("a_directory_with_keys_keeps_them_and_no_other_key_stays_valid") {
        return;
    }
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    let made = trunnion(&data, &["keys", "create", "--name", "office", "--scopes", "admin,read"]);
    let key = String::from_utf8(made.stdout).unwrap();
    let told = loaded(&data);
    assert!(told.contains("Authorization: Bearer KEY"), "{told}");
    let list = trunnion(&data, &["keys", "list"]);
    let list = String::from_utf8(list.stdout).unwrap();
    let lines: Vec<Vec<&str>> = list.lines().map(|line| line.split('\t').collect()).collect();
    let of =
        |name: &str| lines.iter().find(|line| line[7] == name).unwrap_or_else(|| panic!("{name}: {list}"));
    assert_eq!(of("office")[5], "-", "{list}");
    assert_ne!(of("trunnion demo")[5], "-", "{list}");
    let app = spawn_in(&data, |_| {}).await;
    assert_eq!(app.get("/v1/jobs").await.status(), 401);
    let jobs = app.client.get(app.url("/v1/jobs")).bearer_auth(key.trim()).send().await.unwrap();
    assert_eq!(jobs.json::<Value>().await.unwrap()["items"].as_array().unwrap().len(), 7);
    app.stop().await;
    assert_eq!(trunnion(&data, &["doctor", "--deep", "--data-dir", path(&data)]).status.code(), Some(0));
}
