//! What was answered under an `Idempotency-Key` is answered again, whatever became of the machine since.

use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::support::{App, ac_table, problem, spawn};

const PROGRAM: &str = "/v1/machines/m/cc-compensation?tool_radius_mm=5";
const WEAR: &str = "/v1/machines/m/tools/T12/wear-entries";
const CALIBRATION: &str = "/v1/machines/m/calibrations";

async fn send(app: &App, path: &str, key: Option<&str>, body: &Value) -> Response {
    let mut request = app.client.post(app.url(path));
    if let Some(key) = key {
        request = request.header("idempotency-key", key);
    }
    let request = match body {
        Value::String(text) => request.body(text.clone()),
        body => request.json(body),
    };
    request.send().await.unwrap()
}

#[tokio::test]
async fn an_answer_under_a_key_outlives_the_machine() {
    let app = spawn().await;
    let mut profile = ac_table();
    profile["drives"] =
        app.get("/v1/machines/example-ac-table").await.json::<Value>().await.unwrap()["drives"].clone();
    assert_eq!(app.put_machine("m", &profile).await.status(), StatusCode::CREATED);
    let wear = json!({"measured_at": "2025-03-14T09:26:53Z", "parts_cut": 120, "radius_wear_um": 14.0});
    let test = |axis: &str, direction: &str, ball: [f64; 3]| json!({"rotary_axis": axis, "bar_direction": direction, "ball_mm": ball, "eccentricity_um": [1.5, -0.5]});
    let run = json!({
        "kind": "rtcp-ballbar", "measured_at": "2025-03-14T09:26:53Z", "bar_length_mm": 100,
        "tests": [
            test("C", "radial", [150.0, 0.0, 60.0]), test("C", "axial", [150.0, 0.0, 60.0]),
            test("A", "radial", [30.0, 0.0, 160.0]), test("A", "axial", [30.0, 0.0, 160.0])
        ]
    });
    let simulation = json!({
        "machine_id": "m", "path": {"kind": "program", "text": "G21 G1 X1.000 Y0.000 Z0.000 A0.000 C0.000 F1000\nG1 X5.000\n"}
    });
    let requests = [
        (PROGRAM, json!("g1 x1\n")),
        (WEAR, wear),
        (CALIBRATION, run),
        ("/v1/servo-simulations", simulation),
    ];
    let mut answers = Vec::new();
    for (path, body) in &requests {
        let made = send(&app, path, Some(path), body).await;
        let (status, location) = (made.status(), made.headers().get("location").cloned());
        let text = made.text().await.unwrap();
        assert!(status.is_success(), "{path}: {text}");
        answers.push((status, location, text));
    }
    let deleted = app.client.delete(app.url("/v1/machines/m")).header("if-match", "*").send().await.unwrap();
    assert_eq!(deleted.status(), StatusCode::NO_CONTENT);
    for ((path, body), first) in requests.iter().zip(&answers) {
        let again = send(&app, path, Some(path), body).await;
        let (status, location) = (again.status(), again.headers().get("location").cloned());
        assert_eq!(&(status, location, again.text().await.unwrap()), first, "{path}");
        // A key of its own, or none, is a new request, and there is no such machine.
        for key in [Some("another"), None] {
            problem(send(&app, path, key, body).await, "machine-not-found").await;
        }
    }
    let other = json!("g1 x2\n");
    problem(send(&app, PROGRAM, Some(PROGRAM), &other).await, "idempotency-key-reused").await;
}
