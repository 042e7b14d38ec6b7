//! Axis words to poses over HTTP.

use serde_json::{Value, json};

use crate::support::{pointers, problem, spawn, spawn_with};

const PATH: &str = "/v1/machines/example-ac-table/forward-kinematics";
/// Rounding of a handful of operations on coordinates of some 10 mm \[mm\].
const ROUNDING_MM: f64 = 1e-12;

#[tokio::test]
async fn the_literature_s_axis_direction_comes_back() {
    let app = spawn().await;
    let body = json!({"joints": [{"X": 10, "Y": 0, "Z": 5, "A": 30, "C": 45}, {"X": 1, "Y": 2, "Z": 3, "A": 0, "C": 0}]});
    let answer: Value = app.post_json(PATH, &body).await.json().await.unwrap();
    assert_eq!(answer["machine_revision"], 1);
    let (a, c) = (30_f64.to_radians(), 45_f64.to_radians());
    let pose = &answer["poses"][0];
    // P0 eq. (1).
    for (name, expected) in [("i", a.sin() * c.sin()), ("j", -a.sin() * c.cos()), ("k", a.cos())] {
        assert!((pose[name].as_f64().unwrap() - expected).abs() < 1e-15, "{pose}");
    }
    for (name, expected) in [("x", 1.0), ("y", 2.0), ("z", 3.0)] {
        assert!((answer["poses"][1][name].as_f64().unwrap() - expected).abs() < ROUNDING_MM);
    }
}

#[tokio::test]
async fn csv_gives_the_same_numbers_as_json() {
    let app = spawn().await;
    let json =
        json!({"joints": [{"X": 10, "Y": -2.5, "Z": 5, "A": 30, "C": 45}], "work_offset_mm": [70, -40, 95]});
    let answer: Value = app.post_json(PATH, &json).await.json().await.unwrap();
    let path = format!("{PATH}?work_offset_mm=70,-40,95");
    let response =
        app.post_text(&path, "text/csv", "\u{feff}C,A,Z,Y,X\r\n45, 30,5,-2.5,\"10\"\r\n\r\n").await;
    assert_eq!(response.headers()["trunnion-machine-revision"], "1");
    assert!(response.headers()["content-type"].to_str().unwrap().starts_with("text/csv"));
    let text = response.text().await.unwrap();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!((lines.len(), lines[0]), (2, "x,y,z,i,j,k"));
    for (name, text) in ["x", "y", "z", "i", "j", "k"].iter().zip(lines[1].split(',')) {
        assert_eq!(
            text.parse::<f64>().unwrap().to_bits(),
            answer["poses"][0][name].as_f64().unwrap().to_bits()
        );
    }
    let request = app
        .client
        .post(app.url(PATH))
        .header("content-type", "text/csv")
        .header("accept", "application/json");
    let mixed: Value = request.body("X,Y,Z,A,C\n1,2,3,0,0").send().await.unwrap().json().await.unwrap();
    assert_eq!(mixed["poses"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn every_bad_word_is_named() {
    let app = spawn().await;
    let body = json!({"joints": [
        {"X": 1e308, "Y": 0, "Z": 0, "A": 1e300, "C": 0},
        {"X": 0, "Y": 0, "Z": 0, "A": 0, "B": 1, "C": 0},
        {"X": 0, "Y": 0, "Z": 0, "A": 0}
    ]});
    let found = pointers(&problem(app.post_json(PATH, &body).await, "invalid-request").await);
    assert_eq!(found, ["/joints/0/X", "/joints/0/A", "/joints/1/B", "/joints/2/C"]);
    let array = json!({"joints": [[1, 2, 3, 0, 0, 0, 0]]});
    assert_eq!(pointers(&problem(app.post_json(PATH, &array).await, "invalid-request").await), ["/joints/0"]);
    let many = json!({"joints": vec![json!({"X": 1e308, "Y": 0, "Z": 0, "A": 0, "C": 0}); 1000]});
    assert_eq!(pointers(&problem(app.post_json(PATH, &many).await, "invalid-request").await).len(), 100);
}

#[tokio::test]
async fn bad_tables_are_named_by_line() {
    let app = spawn().await;
    for (text, line, pointer) in [
        ("", 1, "/joints"),
        ("X,Y,Z,A\n", 1, ""),
        ("X,Y,Z,Q\n", 1, "/joints"),
        ("X,X,Y,Z\n", 1, "/joints"),
        ("Y,Z\n", 1, "/joints"),
        ("X,Y,Z,A,C\n1,2,3,4\n", 2, "/joints/0"),
        ("X,Y,Z,A,C\n1,2,3,4,5\n1,2,x,4,5\n", 3, "/joints/1/Z"),
        ("X,Y,Z,A,C\n1,NaN,3,4,5\n", 2, "/joints/0/Y"),
        ("X,Y,Z,A,C\n1,1e999,3,4,5\n", 2, "/joints/0/Y"),
        ("X,Y,Z,A,C\n1,2,3,4,5,6\n", 2, "/joints/0"),
    ] {
        let response = app.post_text(PATH, "text/csv", text).await;
        if pointer.is_empty() {
            assert_eq!(response.status(), 200, "{text:?}");
            continue;
        }
        let body = problem(response, "invalid-request").await;
        assert_eq!(
            (body["line"].as_u64(), pointers(&body)),
            (Some(line), vec![pointer.to_owned()]),
            "{text:?}"
        );
    }
    // Every bad cell, up to a hundred; a sound row in between counts too.
    let bad = "X,Y,Z,A,C\n1,2,x,4,inf\n1,2,3,4,5\n1,2\n,2,3,4,5\n";
    let body = problem(app.post_text(PATH, "text/csv", bad).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/joints/0/Z", "/joints/0/C", "/joints/2", "/joints/3/X"]);
    assert_eq!(body["line"], 2);
    assert!(body["errors"][3]["detail"].as_str().unwrap().starts_with("line 5: "), "{body}");
    let many = format!("X,Y,Z,A,C\n{}", "a,b,c,d,e\n".repeat(1000));
    assert_eq!(
        pointers(&problem(app.post_text(PATH, "text/csv", many).await, "invalid-request").await).len(),
        100
    );
    let long = format!("X,Y,Z,A,C\n{}", "1".repeat(5000));
    assert_eq!(problem(app.post_text(PATH, "text/csv", long).await, "invalid-request").await["line"], 2);
}

#[tokio::test]
async fn options_that_are_unknown_or_of_the_inverse_are_refused() {
    let app = spawn().await;
    for (query, pointer) in [
        ("work_ofset_mm=1,2,3", "/work_ofset_mm"),
        ("tool_length_mm=1e12", "/tool_length_mm"),
        ("location_errors=maybe", "/location_errors"),
        ("selection=path", "/selection"),
    ] {
        let response = app.post_text(&format!("{PATH}?{query}"), "text/csv", "X,Y,Z,A,C\n1,2,3,4,5\n").await;
        assert_eq!(pointers(&problem(response, "invalid-request").await), [pointer]);
    }
    let response = app.post_json(&format!("{PATH}?tool_length_mm=1"), &json!({"joints": []})).await;
    assert_eq!(pointers(&problem(response, "invalid-request").await), ["/tool_length_mm"]);
}

#[tokio::test]
async fn more_than_the_limit_is_refused_in_json_and_csv() {
    let app = spawn_with(|settings| settings.max_poses = 3).await;
    let body = |count| json!({"joints": vec![json!({"X": 0, "Y": 0, "Z": 0, "A": 0, "C": 0}); count]});
    assert_eq!(app.post_json(PATH, &body(3)).await.status(), 200);
    problem(app.post_json(PATH, &body(4)).await, "too-costly").await;
    let rows = |count| format!("X,Y,Z,A,C\n{}", "0,0,0,0,0\n".repeat(count));
    assert_eq!(app.post_text(PATH, "text/csv", rows(3)).await.status(), 200);
    let refused = problem(app.post_text(PATH, "text/csv", rows(4)).await, "too-costly").await;
    assert_eq!(refused["line"], 5);
    let app = spawn_with(|settings| settings.max_cost_s = 1e-5).await;
    problem(app.post_json(PATH, &body(1000)).await, "too-costly").await;
}
