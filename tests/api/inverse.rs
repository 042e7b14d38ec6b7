//! Poses to axis words over HTTP.

use serde_json::{Value, json};

use crate::support::{ac_table, pointers, problem, spawn};

const PATH: &str = "/v1/machines/example-ac-table/inverse-kinematics";
const FORWARD: &str = "/v1/machines/example-ac-table/forward-kinematics";
/// What the project asks of a round trip \[mm\].
const ROUND_TRIP_MM: f64 = 1e-9;
/// And of the tool axis.
const ROUND_TRIP_AXIS: f64 = 1e-12;

fn pose(x: f64, a_deg: f64, c_deg: f64) -> Value {
    let (a, c) = (a_deg.to_radians(), c_deg.to_radians());
    json!({"x": x, "y": 2.0, "z": 3.0, "i": a.sin() * c.sin(), "j": -a.sin() * c.cos(), "k": a.cos()})
}

#[tokio::test]
async fn what_comes_back_can_be_turned_round() {
    let app = spawn().await;
    let poses: Vec<_> =
        (0..50).map(|n| pose(f64::from(n), 10.0 + f64::from(n), f64::from(n) * 7.0)).collect();
    let body = json!({"poses": poses, "work_offset_mm": [70, -40, 95]});
    let answer: Value = app.post_json(PATH, &body).await.json().await.unwrap();
    assert_eq!(answer["machine_revision"], 1);
    assert!(answer.get("candidates").is_none());
    assert_eq!(answer["warnings"], json!([]));
    let joints = answer["joints"].clone();
    assert_eq!(joints.as_array().unwrap().len(), 50);
    let keys: Vec<_> = joints[0].as_object().unwrap().keys().cloned().collect();
    assert_eq!(keys, ["A", "C", "X", "Y", "Z", "conditioning"]);
    let back = json!({"joints": joints, "work_offset_mm": [70, -40, 95]});
    let back: Value = app.post_json(FORWARD, &back).await.json().await.unwrap();
    for (pose, back) in poses.iter().zip(back["poses"].as_array().unwrap()) {
        for (names, tolerance) in [(["x", "y", "z"], ROUND_TRIP_MM), (["i", "j", "k"], ROUND_TRIP_AXIS)] {
            for name in names {
                let off = pose[name].as_f64().unwrap() - back[name].as_f64().unwrap();
                assert!(off.abs() < tolerance, "{pose} {back}");
            }
        }
    }
}

#[tokio::test]
async fn all_gives_every_candidate_and_csv_names_the_pose() {
    let app = spawn().await;
    let body = json!({"poses": [pose(1.0, 30.0, 40.0), pose(2.0, 90.0, 40.0)], "selection": "all"});
    let answer: Value = app.post_json(PATH, &body).await.json().await.unwrap();
    assert!(answer.get("joints").is_none());
    let candidates = answer["candidates"].as_array().unwrap();
    assert_eq!(candidates.len(), 2);
    assert!(candidates.iter().all(|of_pose| of_pose.as_array().unwrap().len() == 2), "{answer}");
    let mut table = "x,y,z,i,j,k\n".to_owned();
    for pose in body["poses"].as_array().unwrap() {
        let cells: Vec<_> =
            ["x", "y", "z", "i", "j", "k"].iter().map(|name| pose[name].to_string()).collect();
        table += &(cells.join(",") + "\n");
    }
    let text = app.post_text(&format!("{PATH}?selection=all"), "text/csv", table).await.text().await.unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[0], "pose,X,Y,Z,A,C,conditioning");
    let first: Vec<_> = lines[1..].iter().map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(first, ["0", "0", "1", "1"]);
    let x: f64 = lines[3].split(',').nth(1).unwrap().parse().unwrap();
    assert_eq!(x.to_bits(), candidates[1][0]["X"].as_f64().unwrap().to_bits());
}

/// More poses than are made at a time, in several rounds.
const MANY: usize = 9_000;

#[tokio::test]
async fn a_table_of_many_poses_has_the_words_and_the_warnings_of_the_document() {
    let app = spawn().await;
    let mut profile = ac_table();
    // Without the other solution, a turn the other way round is a rewind.
    profile["kinematics"]["rotary_axes"][0]["limits_deg"] = json!([-120, 1]);
    profile["kinematics"]["rotary_axes"][1]["limits_deg"] = json!([-400, 400]);
    assert_eq!(app.put_machine("limited", &profile).await.status(), 201);
    // Tilted, on the pole now and then, and turned the other way round every thousand poses.
    let poses: Vec<_> = (0..MANY)
        .map(|n| {
            let s = n as f64 * 1e-3;
            let tilt_deg = if n % 700 < 3 { 0.0 } else { 20.0 + 15.0 * (3.0 * s).sin() };
            pose(10.0 * s.cos(), tilt_deg, 60.0 * s.sin() + if n / 1000 % 2 == 1 { 170.0 } else { 0.0 })
        })
        .collect();
    let mut table = "x,y,z,i,j,k\n".to_owned();
    for pose in &poses {
        let cells = ["x", "y", "z", "i", "j", "k"].map(|name| pose[name].to_string());
        table += &(cells.join(",") + "\n");
    }
    for (path, rewinds) in [(PATH, false), ("/v1/machines/limited/inverse-kinematics", true)] {
        let document: Value = app.post_json(path, &json!({"poses": poses})).await.json().await.unwrap();
        let answer = app.post_text(path, "text/csv", table.clone()).await;
        assert_eq!(answer.status(), 200);
        let warnings = document["warnings"].as_array().unwrap();
        let kinds = |kind: &str| warnings.iter().filter(|warning| warning["kind"] == kind).count();
        assert!(kinds("pole_hold") >= 39 && (kinds("rewind") > 0) == rewinds, "{path}: {warnings:?}");
        assert_eq!(answer.headers()["trunnion-warnings"], warnings.len().to_string());
        let text = answer.text().await.unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        let joints = document["joints"].as_array().unwrap();
        assert_eq!((header, rows.lines().count()), ("X,Y,Z,A,C,conditioning", joints.len()));
        for (row, words) in rows.lines().zip(joints) {
            for (cell, name) in row.split(',').zip(header.split(',')) {
                let value: f64 = cell.parse().unwrap();
                assert_eq!(value.to_bits(), words[name].as_f64().unwrap().to_bits(), "{row}");
            }
        }
    }
}

#[tokio::test]
async fn the_start_is_read_by_the_machine_s_letters() {
    let app = spawn().await;
    let solve = |start: Value| {
        let body = json!({"poses": [pose(1.0, 30.0, 40.0)], "start": start});
        let app = &app;
        async move { app.post_json(PATH, &body).await }
    };
    let near: Value = solve(json!({"A": -30, "C": 220})).await.json().await.unwrap();
    assert!((near["joints"][0]["A"].as_f64().unwrap() + 30.0).abs() < 1e-9, "{near}");
    assert_eq!(solve(Value::Null).await.status(), 200);
    let wrong = pointers(&problem(solve(json!({"A": 0, "B": 0})).await, "invalid-request").await);
    assert_eq!(wrong, ["/start/B", "/start/C"]);
    let outside = pointers(&problem(solve(json!({"A": 121, "C": 0})).await, "invalid-request").await);
    assert_eq!(outside, ["/start/A"]);
    let table = "x,y,z,i,j,k\n1,2,3,0.1,0.2,0.9\n";
    let query = format!("{PATH}?start.A=-20&start.C=10");
    assert_eq!(app.post_text(&query, "text/csv", table).await.status(), 200);
    let query = format!("{PATH}?start.A=-20&start.D=10");
    assert_eq!(
        pointers(&problem(app.post_text(&query, "text/csv", table).await, "invalid-request").await),
        ["/start/D"]
    );
}

#[tokio::test]
async fn the_pole_is_held_and_said_so() {
    let app = spawn().await;
    let body = json!({"poses": [pose(1.0, 5.0, 40.0), pose(1.0, 0.0, 0.0), pose(1.0, 5.0, 40.0)]});
    let answer: Value = app.post_json(PATH, &body).await.json().await.unwrap();
    let warning = &answer["warnings"][0];
    assert_eq!((&warning["pose"], &warning["kind"]), (&json!(1), &json!("pole_hold")), "{answer}");
    assert!(warning["axis_residual_urad"].is_number());
    assert_eq!(answer["joints"][0]["C"], answer["joints"][1]["C"]);
}

#[tokio::test]
async fn poses_out_of_reach_or_travel_are_refused_by_index() {
    let app = spawn().await;
    let both = json!({"poses": [pose(1.0, 30.0, 0.0), pose(1.0, 130.0, 0.0)]});
    let body = problem(app.post_json(PATH, &both).await, "unreachable-pose").await;
    assert_eq!(body["pose"], 1);
    assert_eq!(app.put_machine("small", &ac_table()).await.status(), 201);
    let path = "/v1/machines/small/inverse-kinematics";
    let far = json!({"poses": [pose(1.0, 30.0, 0.0), pose(900.0, 30.0, 0.0)], "selection": "all"});
    let body = problem(app.post_json(path, &far).await, "unreachable-pose").await;
    assert_eq!(body["pose"], 1);
    assert!(body["detail"].as_str().unwrap().contains("400"), "{body}");
}

#[tokio::test]
async fn every_bad_pose_is_named() {
    let app = spawn().await;
    let zero = json!({"x": 0, "y": 0, "z": 0, "i": 0, "j": 0, "k": 0});
    let huge = json!({"x": 1e308, "y": 0, "z": 0, "i": 0, "j": -1e308, "k": 1});
    let body = json!({"poses": [pose(1.0, 3.0, 0.0), zero, huge]});
    let found = pointers(&problem(app.post_json(PATH, &body).await, "invalid-request").await);
    assert_eq!(found, ["/poses/1", "/poses/2/x", "/poses/2/j"]);
    let missing = json!({"poses": [{"x": 0, "y": 0, "z": 0, "i": 0, "j": 0}]});
    assert_eq!(
        pointers(&problem(app.post_json(PATH, &missing).await, "invalid-request").await),
        ["/poses/0/k"]
    );
    let misspelt = json!({"poses": [], "selektion": "all"});
    assert_eq!(
        pointers(&problem(app.post_json(PATH, &misspelt).await, "invalid-request").await),
        ["/selektion"]
    );
    let empty: Value = app.post_json(PATH, &json!({"poses": []})).await.json().await.unwrap();
    assert_eq!(empty["joints"], json!([]));
    let table = app.post_text(PATH, "text/csv", "x,y,z,i,j,k\n0,0,0,0,0,0\n").await;
    assert_eq!(pointers(&problem(table, "invalid-request").await), ["/poses/0"]);
}

#[tokio::test]
async fn a_small_body_cannot_ask_for_endless_turns() {
    let app = spawn().await;
    let mut profile = ac_table();
    for axis in [0, 1] {
        profile["kinematics"]["rotary_axes"][axis]["limits_deg"] = json!([-360_000, 360_000]);
    }
    assert_eq!(app.put_machine("wound", &profile).await.status(), 201);
    let path = "/v1/machines/wound/inverse-kinematics";
    let body = json!({"poses": vec![pose(1.0, 30.0, 0.0); 100], "selection": "all"});
    problem(app.post_json(path, &body).await, "too-costly").await;
}

#[tokio::test]
async fn other_media_types_are_refused() {
    let app = spawn().await;
    for kind in ["text/plain", "application/xml", "application/x-www-form-urlencoded"] {
        problem(app.post_text(PATH, kind, "x").await, "unsupported-media-type").await;
    }
    let untyped = app.client.post(app.url(PATH)).body("{}").send().await.unwrap();
    problem(untyped, "unsupported-media-type").await;
    let request =
        app.client.post(app.url(PATH)).header("accept", "image/svg+xml").json(&json!({"poses": []}));
    problem(request.send().await.unwrap(), "not-acceptable").await;
    problem(
        app.post_json("/v1/machines/none/inverse-kinematics", &json!({"poses": []})).await,
        "machine-not-found",
    )
    .await;
}
