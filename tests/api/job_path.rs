//! The path of a job's program: its poses are those of the interpretation, its errors those of the report.

use std::collections::HashMap;

use serde_json::Value;

use crate::support::{App, pointers, problem, spawn};

const RUN: &str = "/v1/machines/example-ac-table";
const PARAMETERS: &str = "work_offset_mm=12,-7,35";

async fn blade(app: &App) -> String {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/blade.nc")).unwrap();
    let path = format!("{RUN}/cc-compensation?tool_radius_mm=5&{PARAMETERS}");
    let made = app.post_text(&path, "text/plain", text).await;
    assert_eq!(made.status(), 200);
    made.headers()["location"].to_str().unwrap().to_owned()
}

async fn rows(app: &App, path: &str) -> (Vec<HashMap<String, String>>, u64) {
    let answer = app.get(path).await;
    assert_eq!(answer.status(), 200, "{path}");
    assert_eq!(answer.headers()["content-type"], "text/csv");
    let together = answer.headers()["trunnion-motions-per-pose"].to_str().unwrap().parse().unwrap();
    let text = answer.text().await.unwrap();
    let rows = csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<_, _>>();
    (rows.unwrap(), together)
}

fn number(row: &HashMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap()
}

#[tokio::test]
async fn the_path_of_a_job_has_the_poses_of_the_interpretation_and_the_errors_of_the_report() {
    let app = spawn().await;
    let job = blade(&app).await;
    let (path, together) = rows(&app, &format!("{job}/path")).await;
    assert_eq!(together, 1);
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/blade.nc")).unwrap();
    let read: Value = app
        .post_text(&format!("{RUN}/interpretation?{PARAMETERS}"), "text/plain", text)
        .await
        .json()
        .await
        .unwrap();
    let motions = read["motions"].as_array().unwrap();
    assert_eq!(path.len(), motions.len());
    for (row, motion) in path.iter().zip(motions) {
        assert_eq!(row["line"], motion["line"].to_string());
        assert_eq!(row["kind"], motion["kind"].as_str().unwrap());
        for letter in ["X", "Y", "Z", "A", "C"] {
            assert_eq!(number(row, letter).to_bits(), motion["joints"][letter].as_f64().unwrap().to_bits());
        }
        for (k, name) in ["tip_x_mm", "tip_y_mm", "tip_z_mm"].iter().enumerate() {
            assert_eq!(number(row, name).to_bits(), motion["tip_mm"][k].as_f64().unwrap().to_bits());
        }
    }
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    let series = &report["series"];
    for (k, line) in series["line"].as_array().unwrap().iter().enumerate() {
        let line = line.to_string();
        let row = path.iter().find(|row| row["line"] == line).unwrap();
        for name in ["before_um", "after_um"] {
            assert_eq!(number(row, name).to_bits(), series[name][k].as_f64().unwrap().to_bits(), "{line}");
        }
    }
    let rapids = path.iter().filter(|row| row["kind"] == "rapid");
    assert!(rapids.clone().count() > 0);
    assert!(rapids.into_iter().all(|row| row["before_um"].is_empty() && row["after_um"].is_empty()));
}

#[tokio::test]
async fn a_path_of_few_poses_keeps_its_ends_and_its_largest_error() {
    let app = spawn().await;
    let job = blade(&app).await;
    let (all, _) = rows(&app, &format!("{job}/path")).await;
    let (few, together) = rows(&app, &format!("{job}/path?poses=20")).await;
    assert!(few.len() <= 20 && few.len() > 5, "{}", few.len());
    assert!(together > 1);
    assert_eq!(few.first(), all.first());
    assert_eq!(few.last().unwrap()["line"], all.last().unwrap()["line"]);
    let largest = |rows: &[HashMap<String, String>]| {
        rows.iter().filter_map(|row| row["before_um"].parse().ok()).fold(0.0, f64::max)
    };
    assert_eq!(largest(&few).to_bits(), largest(&all).to_bits());
    for poses in [1, 0, 100_001] {
        let refused = problem(app.get(&format!("{job}/path?poses={poses}")).await, "invalid-request").await;
        assert_eq!(pointers(&refused), ["/poses"]);
    }
    problem(app.get(&format!("{job}/path?pose=7")).await, "invalid-request").await;
    let other = "/v1/jobs/0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60/path";
    problem(app.get(other).await, "job-not-found").await;
    let wrong = app.client.get(app.url(&format!("{job}/path"))).header("accept", "application/json");
    problem(wrong.send().await.unwrap(), "not-acceptable").await;
}
