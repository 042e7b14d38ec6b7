//! Servo simulations, sweeps and matchings over HTTP.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::support::{App, ac_table, pointers, problem, spawn, spawn_with};

const SIMULATE: &str = "/v1/servo-simulations";
const SWEEP: &str = "/v1/servo-sweeps";
const MATCH: &str = "/v1/servo-matching";
/// Values given to nine significant digits are met to half a unit of the last.
const NINE_DIGITS: f64 = 5.5e-9;

fn circle() -> Value {
    json!({"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100})
}

fn simulation() -> Value {
    json!({"machine_id": "example-ac-table", "path": circle(), "feed_mm_per_min": 1800})
}

/// `base` with the members of `more`.
fn with(mut base: Value, more: &Value) -> Value {
    for (name, value) in more.as_object().unwrap() {
        base[name] = value.clone();
    }
    base
}

fn close(value: &Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!(((value - expected) / expected).abs() < NINE_DIGITS, "{value} is not {expected}");
}

async fn answer(app: &App, path: &str, body: &Value) -> Value {
    let response = app.post_json(path, body).await;
    assert_eq!(response.status(), StatusCode::OK, "{:?}", response.text().await);
    response.json().await.unwrap()
}

async fn svg(app: &App, path: &str, body: &Value) -> String {
    let request = app.client.post(app.url(path)).header("accept", "image/svg+xml").json(body);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), StatusCode::OK);
    assert_eq!(response.headers()["content-type"], "image/svg+xml");
    response.text().await.unwrap()
}

#[tokio::test]
async fn the_circle_of_p2_has_the_values_of_the_reference_drive() {
    let app = spawn().await;
    let matched = answer(&app, SIMULATE, &simulation()).await;
    assert_eq!(matched["machine_revision"], 1);
    close(&matched["contour_error"]["min_um"], -11.106_107_3);
    close(&matched["contour_error"]["max_um"], -2.271_959_35);
    let poles = matched["axes"]["X"]["stability"]["poles"].as_array().unwrap();
    for (pole, expected) in poles.iter().zip([-8.365_008_27, -40.284_128_6, -114.239_662, -4_750.011_63]) {
        close(&pole["re_per_s"], expected);
    }
    // A ramp lags by v/Kpp: 1 mm at 30 mm/s and 30 1/s.
    let steady_um = matched["axes"]["X"]["steady_state_following_error_um"].as_f64().unwrap();
    assert!((steady_um - 1000.0).abs() < 0.01, "{steady_um}");
    assert!(matched["axes"]["C"].get("max_following_error_um").is_none());
    let slow_c = with(simulation(), &json!({"position_gain_scale": {"C": 25.0 / 30.0}}));
    let unequal = answer(&app, SIMULATE, &slow_c).await;
    close(&unequal["contour_error"]["min_um"], -114.421_536);
    close(&unequal["contour_error"]["max_um"], 97.148_611_9);
    let axis_deg = unequal["contour_error"]["oval"]["major_axis_deg"].as_f64().unwrap();
    assert!((axis_deg - 134.9).abs() < 0.05, "{axis_deg}");
    let samples = &unequal["samples"];
    let rows = samples["t_s"].as_array().unwrap().len();
    assert!((500..=2000).contains(&rows), "{rows}");
    for column in ["phi_deg", "contour_error_um"] {
        assert_eq!(samples[column].as_array().unwrap().len(), rows);
    }
    assert_eq!(samples["following_error_urad"]["C"].as_array().unwrap().len(), rows);
}

#[tokio::test]
async fn drives_without_a_machine_and_the_same_question_twice() {
    let app = spawn().await;
    let machine: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    let mut body = simulation();
    body.as_object_mut().unwrap().remove("machine_id");
    body["drives"] = machine["drives"].clone();
    let answers = [
        app.post_json(SIMULATE, &body).await.text().await.unwrap(),
        app.post_json(SIMULATE, &body).await.text().await.unwrap(),
    ];
    assert_eq!(answers[0], answers[1]);
    let answer: Value = serde_json::from_str(&answers[0]).unwrap();
    assert_eq!(answer["machine_revision"], Value::Null);
    close(&answer["contour_error"]["min_um"], -11.106_107_3);
}

#[tokio::test]
async fn every_path_through_the_kinematics_of_the_machine_is_run() {
    let app = spawn().await;
    for (path, axes) in [
        (json!({"kind": "circle", "axes": ["X", "Y"], "radius_mm": 20}), "XY"),
        (
            json!({"kind": "cone-frustum", "center_mm": [20, 10, 5], "radius_mm": 40, "half_apex_deg": 15, "tilt_deg": 30}),
            "ACXYZ",
        ),
        (
            json!({"kind": "tip-hold", "tip_mm": [40, 0, 30], "sweep_deg": {"A": [-30, 30], "C": [0, 180]}}),
            "ACXYZ",
        ),
        (
            json!({"kind": "polyline", "plane": "xy", "points": [{"x": 0, "y": 0, "z": 0}, {"x": 20, "y": 0, "z": 0}, {"x": 20, "y": 20, "z": 0}]}),
            "XY",
        ),
    ] {
        let body = json!({"machine_id": "example-ac-table", "path": path, "feed_mm_per_min": 1200});
        let found = answer(&app, SIMULATE, &body).await;
        let letters: String = found["axes"].as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(letters, axes, "{path}");
        let error_um = found["contour_error"]["max_abs_um"].as_f64().unwrap();
        assert!((0.0..5000.0).contains(&error_um), "{path}: {error_um}");
        let figure = svg(&app, &format!("{SIMULATE}?plot=contour-error"), &body).await;
        assert!(figure.contains("contour error of the tool tip"), "{path}");
        let unit = if path["kind"] == "tip-hold" { "deg/min" } else { "mm/min" };
        assert!(figure.contains(&format!("at 1200 {unit}")), "{path}");
    }
    // A corner cut on the inside, to the left of travel: negative.
    let corner = json!({"machine_id": "example-ac-table", "feed_mm_per_min": 1200,
        "path": {"kind": "polyline", "plane": "xy", "points": [{"x": 0, "y": 0, "z": 0}, {"x": 20, "y": 0, "z": 0}, {"x": 20, "y": 20, "z": 0}]}});
    let cut = answer(&app, SIMULATE, &corner).await;
    assert!(cut["contour_error"]["min_um"].as_f64().unwrap() < -100.0, "{}", cut["contour_error"]);
    let stops =
        with(corner, &json!({"feed_profile": {"acceleration_mm_per_s2": 1000, "jerk_mm_per_s3": 20000}}));
    let stopped = answer(&app, SIMULATE, &stops).await;
    assert!(stopped["contour_error"]["max_abs_um"].as_f64().unwrap() < 40.0, "{}", stopped["contour_error"]);
}

#[tokio::test]
async fn a_sweep_is_made_of_its_simulations() {
    let app = spawn().await;
    let sweep = json!({"machine_id": "example-ac-table", "path": circle(), "feed_mm_per_min": [900, 1800, 1200],
        "position_gain_scale": {"C": [0.8, 1.0, 900.0], "X": [1.0, 1.1, 1.0]}});
    let swept = answer(&app, SWEEP, &sweep).await;
    assert_eq!(swept["gains"], json!(["C × 0.8, X × 1", "C × 1, X × 1.1", "C × 900, X × 1"]));
    for (row, scale) in [json!({"C": 0.8}), json!({"X": 1.1})].into_iter().enumerate() {
        for (column, feed) in [900, 1800, 1200].into_iter().enumerate() {
            let one = with(simulation(), &json!({"feed_mm_per_min": feed, "position_gain_scale": scale}));
            let one = answer(&app, SIMULATE, &one).await;
            assert_eq!(swept["contour_error"][row][column], one["contour_error"]);
        }
    }
    assert_eq!(swept["contour_error"][2], json!([null, null, null]));
    assert_eq!(swept["faults"].as_array().unwrap().len(), 3);
    assert!(swept["faults"][1]["detail"].as_str().unwrap().contains("axis C"), "{}", swept["faults"]);
    for plot in ["curves", "map"] {
        let figure = svg(&app, &format!("{SWEEP}?plot={plot}"), &sweep).await;
        assert!(figure.contains("feed [mm/min]"), "{plot}");
    }
}

#[tokio::test]
async fn matching_answers_which_gains_and_how_fast() {
    let app = spawn().await;
    let body = with(simulation(), &json!({"target_um": [10, 25]}));
    let found = answer(&app, MATCH, &body).await;
    assert_eq!(found["reached"], true);
    let gain = found["gains"]["X"]["position_gain_per_s"].as_f64().unwrap();
    assert!((30.0..35.0).contains(&gain), "{gain}");
    assert!(found["matched"]["max_abs_um"].as_f64().unwrap() <= 10.0);
    // What is proposed does what is said of it.
    let scale = found["gains"]["X"]["scale"].clone();
    let feed = found["feed_limits"][1]["matched_mm_per_min"].clone();
    let set = with(
        simulation(),
        &json!({"feed_mm_per_min": feed, "position_gain_scale": {"X": scale, "C": scale}}),
    );
    let error_um = answer(&app, SIMULATE, &set).await["contour_error"]["max_abs_um"].as_f64().unwrap();
    assert!((24.5..=25.0).contains(&error_um), "{error_um}");
}

#[tokio::test]
async fn every_wrong_value_is_named() {
    let app = spawn().await;
    let body = with(
        simulation(),
        &json!({"path": {"kind": "xc-circle", "radius_mm": -1, "center_x_mm": 1e9}, "feed_mm_per_min": 0,
            "sample_period_s": 0, "laps": 0, "position_gain_scale": {"C": 0, "Q": 1},
            "feed_profile": {"acceleration_mm_per_s2": 0, "jerk_mm_per_s3": -1}}),
    );
    let found = problem(app.post_json(SIMULATE, &body).await, "invalid-request").await;
    let mut pointers = pointers(&found);
    pointers.sort();
    assert_eq!(
        pointers,
        [
            "/feed_mm_per_min",
            "/feed_profile/acceleration_mm_per_s2",
            "/feed_profile/jerk_mm_per_s3",
            "/laps",
            "/path/center_x_mm",
            "/path/radius_mm",
            "/position_gain_scale/C",
            "/position_gain_scale/Q",
            "/sample_period_s",
        ]
    );
    let machine: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    let mut drives = machine["drives"].clone();
    drives["X"]["inertia_kg_m2"] = json!(-0.003);
    drives["C"]["transmission"]["gear_ratio"] = json!(0);
    drives["Y"]["load_inertia_kg_m2"] = json!(0.001);
    drives["Z"]["transmission"]["resonance"] = json!({"frequency_hz": 0, "damping_ratio": -1});
    let body = json!({"drives": drives, "path": circle(), "feed_mm_per_min": 1800});
    let found = problem(app.post_json(SIMULATE, &body).await, "invalid-request").await;
    let pointers = crate::support::pointers(&found);
    for pointer in [
        "/drives/X/inertia_kg_m2",
        "/drives/C/transmission/gear_ratio",
        "/drives/Y/load_inertia_kg_m2",
        "/drives/Z/transmission/resonance/frequency_hz",
        "/drives/Z/transmission/resonance/damping_ratio",
    ] {
        assert!(pointers.iter().any(|found| found == pointer), "{pointer} is not among {pointers:?}");
    }
}

#[tokio::test]
async fn what_cannot_be_run_is_refused_with_its_reason() {
    let app = spawn().await;
    app.put_machine("bare", &ac_table()).await;
    let pointer = |pointer: &str| vec![pointer.to_owned()];
    for (change, code, expected) in [
        (
            json!({"path": {"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 60}}),
            "invalid-request",
            pointer("/path/center_x_mm"),
        ),
        (
            json!({"path": {"kind": "xc-circle", "radius_mm": 60, "center_x_mm": -60.001}}),
            "invalid-request",
            pointer("/path/center_x_mm"),
        ),
        (json!({"feed_mm_per_min": 0.01, "sample_period_s": 1e-5}), "too-costly", vec![]),
        (
            json!({"path": {"kind": "circle", "axes": ["X", "Y"], "radius_mm": 0.001}, "feed_mm_per_min": 1e6}),
            "invalid-request",
            pointer("/sample_period_s"),
        ),
        (
            json!({"path": {"kind": "polyline", "points": [{"x": 0, "y": 0, "z": 0}, {"x": 30, "y": 0, "z": 0}]},
                "sample_period_s": 1e-5, "position_gain_scale": {"X": 0.1}}),
            "invalid-request",
            pointer("/sample_period_s"),
        ),
        (json!({"feed_mm_per_min": 1, "laps": 1}), "too-costly", vec![]),
        (json!({"position_gain_scale": {"C": 900}}), "unstable-loop", pointer("/drives/C")),
        (json!({"machine_id": "bare"}), "invalid-request", pointer("/machine_id")),
        (json!({"machine_id": "nobody"}), "machine-not-found", vec![]),
        (json!({"drives": {}}), "invalid-request", pointer("/drives")),
        (
            json!({"path": {"kind": "cone-frustum", "radius_mm": 40, "half_apex_deg": 60, "tilt_deg": 90}}),
            "unreachable-pose",
            vec![],
        ),
        (
            json!({"path": {"kind": "tip-hold", "tip_mm": [0, 0, 0], "sweep_deg": {"A": [0, 150]}}}),
            "unreachable-pose",
            vec![],
        ),
        (
            json!({"path": {"kind": "tip-hold", "tip_mm": [0, 0, 0], "sweep_deg": {"B": [0, 10]}}}),
            "invalid-request",
            pointer("/path/sweep_deg/B"),
        ),
        (
            json!({"path": {"kind": "polyline", "points": [{"x": 0, "y": 0, "z": 0}]}}),
            "invalid-request",
            pointer("/path/points"),
        ),
        (
            json!({"laps": 3, "path": {"kind": "polyline", "points": [{"x": 0, "y": 0, "z": 0}, {"x": 9, "y": 0, "z": 0}]}}),
            "invalid-request",
            pointer("/laps"),
        ),
        // What may be left out is not null.
        (
            json!({"path": {"kind": "cone-frustum", "radius_mm": 60, "half_apex_deg": 0, "tilt_deg": null}}),
            "invalid-request",
            pointer("/path/tilt_deg"),
        ),
        // An axis too many is a wrong value; it is still JSON.
        (
            json!({"path": {"kind": "circle", "axes": ["X", "Y", "Z"], "radius_mm": 5}}),
            "invalid-request",
            pointer("/path/axes"),
        ),
        (
            json!({"path": {"kind": "circle", "axes": ["X", "X"], "radius_mm": 5}}),
            "invalid-request",
            pointer("/path/axes"),
        ),
    ] {
        let found = problem(app.post_json(SIMULATE, &with(simulation(), &change)).await, code).await;
        assert_eq!(pointers(&found), expected, "{change}: {found}");
    }
    let unstable = with(simulation(), &json!({"position_gain_scale": {"C": 900}}));
    let found = problem(app.post_json(SIMULATE, &unstable).await, "unstable-loop").await;
    assert!(found["errors"][0]["detail"].as_str().unwrap().contains("poles [1/s]: "), "{found}");
    for body in [json!({"path": circle(), "feed_mm_per_min": 1800}), with(simulation(), &json!({"spin": 1}))]
    {
        problem(app.post_json(SIMULATE, &body).await, "invalid-request").await;
    }
}

async fn faults_of(app: &App, path: &str, body: &Value) -> Vec<String> {
    let mut found = pointers(&problem(app.post_json(path, body).await, "invalid-request").await);
    found.sort();
    found
}

#[tokio::test]
async fn faults_of_the_operation_are_named_though_path_or_drives_are_missing() {
    let app = spawn().await;
    app.put_machine("bare", &ac_table()).await;
    let held = json!({"kind": "tip-hold", "tip_mm": [0, 0, 0], "sweep_deg": {"A": [0, 1e9]}});
    // No drives at all: of the scales only the numbers and letters that are wrong in any case.
    let nothing = json!({"path": held, "feed_mm_per_min": 0, "tool_length_mm": 1e12, "laps": 0,
        "position_gain_scale": {"C": 1.0, "X": 0.0, "Q": 1.0}});
    assert_eq!(
        faults_of(&app, SIMULATE, &nothing).await,
        [
            "/drives",
            "/feed_mm_per_min",
            "/laps",
            "/machine_id",
            "/path/sweep_deg/A/1",
            "/position_gain_scale/Q",
            "/position_gain_scale/X",
            "/tool_length_mm",
        ]
    );
    let bare = with(simulation(), &json!({"machine_id": "bare", "position_gain_scale": {"C": 1.0}}));
    assert_eq!(faults_of(&app, SIMULATE, &bare).await, ["/machine_id"]);
    // A drive that is faulty is there all the same.
    let machine: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    let mut drives = machine["drives"].clone();
    drives["C"]["inertia_kg_m2"] = json!(0);
    drives.as_object_mut().unwrap().remove("Z");
    let faulty = json!({"drives": drives, "path": circle(), "feed_mm_per_min": [900, -1],
        "position_gain_scale": {"C": [1.0], "Z": [1.0]}});
    assert_eq!(
        faults_of(&app, SWEEP, &faulty).await,
        ["/drives/C/inertia_kg_m2", "/feed_mm_per_min/1", "/position_gain_scale/Z"]
    );
    // Both sources of drives, and a path that is no path of a matching.
    let both = json!({"machine_id": "example-ac-table", "drives": drives, "feed_mm_per_min": -1, "target_um": [],
        "path": {"kind": "program", "text": "G1 X1"}, "least_gain_margin": 0.5});
    assert_eq!(
        faults_of(&app, MATCH, &both).await,
        [
            "/drives",
            "/drives/C/inertia_kg_m2",
            "/feed_mm_per_min",
            "/least_gain_margin",
            "/path/kind",
            "/target_um",
        ]
    );
    let program = json!({"drives": drives, "path": {"kind": "program", "text": "G1 X1"}, "laps": 2,
        "sample_period_s": 0, "feed_mm_per_min": -1});
    assert_eq!(
        faults_of(&app, SIMULATE, &program).await,
        ["/drives", "/feed_mm_per_min", "/laps", "/machine_id", "/sample_period_s"]
    );
    // Too large a sweep is looked at to its end.
    let large = json!({"machine_id": "example-ac-table", "path": circle(), "feed_mm_per_min": [900],
        "position_gain_scale": {"C": vec![1.0; 10_001], "Q": [0.0]}});
    assert_eq!(
        faults_of(&app, SWEEP, &large).await,
        ["/feed_mm_per_min", "/position_gain_scale/Q", "/position_gain_scale/Q", "/position_gain_scale/Q/0"]
    );
}

#[tokio::test]
async fn faults_within_a_path_keep_their_place() {
    let app = spawn().await;
    let points = |second: Value| json!({"kind": "polyline", "points": [{"x": 0, "y": 0, "z": 0}, second]});
    for (path, pointer) in [
        (points(json!({"x": "a", "y": 0, "z": 0})), "/path/points/1/x"),
        (points(json!({"x": 1, "y": 0})), "/path/points/1/z"),
        (points(json!([1, 2, 3, 0, 0, 1])), "/path/points/1"),
        (points(json!({"x": 1, "y": 0, "z": 0, "i": 1})), "/path/points/1"),
        (json!({"kind": "xc-circle", "radius_mm": "a", "center_x_mm": 1}), "/path/radius_mm"),
        (json!({"kind": "xc-circle", "radius_mm": 5}), "/path/center_x_mm"),
        (json!({"kind": "xc-circle", "radius_mm": 5, "center_x_mm": 1, "tilt_deg": 1}), "/path/tilt_deg"),
        (json!({"kind": "xc-circle", "radius_mm": 5, "center_x_mm": 1, "q": 1}), "/path/q"),
        (json!({"kind": "nope"}), "/path/kind"),
        (json!([]), "/path"),
    ] {
        let found = problem(
            app.post_json(SIMULATE, &with(simulation(), &json!({"path": path}))).await,
            "invalid-request",
        )
        .await;
        assert_eq!(pointers(&found), [pointer], "{path}: {found}");
    }
}

#[tokio::test]
async fn a_profile_may_hold_a_drive_that_cannot_be_simulated_yet() {
    let app = spawn().await;
    let example: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    let mut profile = ac_table();
    profile["drives"] = example["drives"].clone();
    profile["drives"]["X"]["load_inertia_kg_m2"] = json!(0.001);
    profile["drives"]["C"]["load_inertia_kg_m2"] = json!(0);
    assert_eq!(app.put_machine("two-masses", &profile).await.status(), StatusCode::CREATED);
    let body = with(simulation(), &json!({"machine_id": "two-masses"}));
    let found = problem(app.post_json(SIMULATE, &body).await, "invalid-request").await;
    assert_eq!(pointers(&found), ["/drives/X/load_inertia_kg_m2"]);
}

#[tokio::test]
async fn sweeps_and_matchings_are_bounded_before_they_start() {
    let app = spawn_with(|settings| settings.max_cost_s = 0.5).await;
    let many: Vec<f64> = (0..200).map(|k| 900.0 + f64::from(k)).collect();
    let base = json!({"machine_id": "example-ac-table", "path": circle()});
    let too_many =
        with(base.clone(), &json!({"feed_mm_per_min": many, "position_gain_scale": {"C": vec![1.0; 51]}}));
    let found = problem(app.post_json(SWEEP, &too_many).await, "invalid-request").await;
    assert_eq!(pointers(&found), ["/feed_mm_per_min"]);
    let costly =
        with(base.clone(), &json!({"feed_mm_per_min": many, "position_gain_scale": {"C": vec![1.0; 50]}}));
    problem(app.post_json(SWEEP, &costly).await, "too-costly").await;
    let uneven = with(
        base.clone(),
        &json!({"feed_mm_per_min": [900], "position_gain_scale": {"C": [1.0], "X": [1.0, 2.0]}}),
    );
    let found = problem(app.post_json(SWEEP, &uneven).await, "invalid-request").await;
    assert_eq!(pointers(&found), ["/position_gain_scale/C"]);
    let empty = with(base.clone(), &json!({"feed_mm_per_min": []}));
    problem(app.post_json(SWEEP, &empty).await, "invalid-request").await;
    let slow = with(base.clone(), &json!({"feed_mm_per_min": 50, "target_um": [10]}));
    problem(app.post_json(MATCH, &slow).await, "too-costly").await;
    // Hundreds of exact stops, each of thousands of samples: the profile is counted too.
    let points: Vec<Value> =
        (0..300).map(|k| json!({"x": 0.01 * f64::from(k % 2), "y": 0.01 * f64::from(k), "z": 0})).collect();
    let stops = with(
        base.clone(),
        &json!({"path": {"kind": "polyline", "points": points}, "feed_mm_per_min": [6000],
            "feed_profile": {"acceleration_mm_per_s2": 100, "jerk_mm_per_s3": 100}}),
    );
    problem(app.post_json(SWEEP, &stops).await, "too-costly").await;
    let no_target =
        with(base, &json!({"feed_mm_per_min": 1800, "target_um": [], "feed_range_mm_per_min": [900, 800]}));
    let found = problem(app.post_json(MATCH, &no_target).await, "invalid-request").await;
    assert_eq!(pointers(&found), ["/target_um", "/feed_range_mm_per_min"]);
}

#[tokio::test]
async fn figures_of_a_circle_state_their_scale() {
    let app = spawn().await;
    let body = with(simulation(), &json!({"position_gain_scale": {"C": 25.0 / 30.0}}));
    let polar = svg(&app, SIMULATE, &body).await;
    for part in [
        "magnified 200 times",
        "rings every 50 µm",
        "ideal circle, r = 60 mm",
        "major axis at 135°",
        "C × 0.833",
    ] {
        assert!(polar.contains(part), "{part}");
    }
    let following = svg(&app, &format!("{SIMULATE}?plot=following-error"), &body).await;
    for part in ["X [µm]", "C [µrad]", "judged from"] {
        assert!(following.contains(part), "{part}");
    }
    let refused = app.client.post(app.url(SIMULATE)).header("accept", "text/html").json(&body);
    problem(refused.send().await.unwrap(), "not-acceptable").await;
    problem(app.post_json(&format!("{SIMULATE}?plot=pie"), &body).await, "invalid-request").await;
}

#[tokio::test]
async fn drive_presets_say_what_is_assumed_and_fit_into_a_profile() {
    let app = spawn().await;
    let presets: Value = app.get("/v1/drive-presets").await.json().await.unwrap();
    let items = presets["items"].as_array().unwrap();
    assert_eq!(items.len(), 5);
    let assumed = |id: &str| items.iter().find(|preset| preset["id"] == id).unwrap()["assumed"].clone();
    assert_eq!(
        assumed("reference-rotary"),
        json!(["position_gain_per_s", "current_gain_v_per_a", "transmission.gear_ratio"])
    );
    for mill in ["mill-x", "mill-y", "mill-z"] {
        assert_eq!(
            assumed(mill),
            json!(["current_gain_v_per_a", "inductance_h", "resistance_ohm", "back_emf_v_s_per_rad"])
        );
        let preset = items.iter().find(|preset| preset["id"] == mill).unwrap();
        // Kf of the published identification
        assert_eq!(preset["drive"]["velocity_feedforward"], 1.0);
        assert!(preset["title"].as_str().unwrap().contains("dry friction left out"), "{preset}");
    }
    let mut profile = ac_table();
    profile["drives"] = json!({});
    for preset in items {
        assert!(preset["assumed"].as_array().unwrap().iter().all(Value::is_string), "{preset}");
        for axis in preset["axes"].as_array().unwrap().iter().filter(|axis| *axis != "B") {
            profile["drives"][axis.as_str().unwrap()] = preset["drive"].clone();
        }
    }
    let response = app.put_machine("with-drives", &profile).await;
    assert_eq!(response.status(), StatusCode::CREATED, "{:?}", response.text().await);
    let body = json!({"machine_id": "with-drives", "path": circle(), "feed_mm_per_min": 900});
    let found = answer(&app, SIMULATE, &body).await;
    // X with feed-forward leaves no error on a ramp, C lags by 1/30 s: they do not match.
    assert!(found["contour_error"]["max_abs_um"].as_f64().unwrap() > 100.0, "{}", found["contour_error"]);
}

/// A square with one arc, in millimetres.
const SQUARE: &str =
    "G90 G21 G94 G17\nG43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F1200\nY20\nG2 X0 Y0 R20\nG1 X5\nG0 Z50\nM30\n";
const PROGRAM: &str = "/v1/machines/example-ac-table/servo-simulation";

#[tokio::test]
async fn a_program_is_simulated_and_kept_as_a_job() {
    let app = spawn().await;
    let response = app.post_text(&format!("{PROGRAM}?plane=xy"), "text/plain", SQUARE).await;
    assert_eq!(response.status(), StatusCode::OK);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let report: Value = response.json().await.unwrap();
    assert_eq!((&report["motions_simulated"], &report["passes"]), (&json!(3), &json!(2)));
    assert_eq!(report["left_out"][0]["kind"], "arc");
    assert_eq!(report["left_out"][0]["line"], 6);
    // The corner between lines 4 and 5 is cut on the inside, to the left.
    assert!(report["contour_error"]["min_um"].as_f64().unwrap() < -100.0, "{}", report["contour_error"]);
    assert_eq!(report["contour_error"]["worst_line"], 5);
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["operation"], "servo-simulation");
    assert_eq!(document["parameters"]["plane"], "xy");
    assert_eq!(document["output_sha256"], Value::Null);
    let kept: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    assert_eq!(kept, report);
    let plot = app.get(&format!("{job}/plot")).await.text().await.unwrap();
    let mark = plot.split(">line 5, ").nth(1).and_then(|rest| rest.split_once("</text>"));
    assert!(mark.is_some_and(|(mark, _)| mark.contains(": −")), "the worst line is not marked");
    problem(app.get(&format!("{job}/program")).await, "result-not-found").await;
    let list: Value = app.get("/v1/jobs?machine_id=example-ac-table").await.json().await.unwrap();
    assert_eq!(list["items"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn a_program_in_the_path_is_the_same_program() {
    let app = spawn().await;
    let uploaded: Value =
        app.post_text(&format!("{PROGRAM}?plane=xy"), "text/plain", SQUARE).await.json().await.unwrap();
    let body = json!({"machine_id": "example-ac-table", "path": {"kind": "program", "text": SQUARE, "plane": "xy", "file_name": "square.nc"}});
    let key = |key: &str, body: &Value| {
        app.client.post(app.url(SIMULATE)).header("idempotency-key", key).json(body).send()
    };
    let first = key("a", &body).await.unwrap();
    let job = first.headers()["location"].clone();
    assert_eq!(first.json::<Value>().await.unwrap(), uploaded);
    assert_eq!(key("a", &body).await.unwrap().headers()["location"], job);
    let other = with(body.clone(), &json!({"sample_period_s": 0.002}));
    problem(key("a", &other).await.unwrap(), "idempotency-key-reused").await;
    // One that is none is refused, also where nothing would be kept under it.
    let circle = json!({"machine_id": "example-ac-table", "path": {"kind": "xc-circle", "radius_mm": 60.0}, "feed_mm_per_min": 1800.0});
    for path in [&body, &circle] {
        problem(key(&"a".repeat(256), path).await.unwrap(), "malformed-request").await;
    }
    for (change, pointer) in [
        (json!({"laps": 2}), "/laps"),
        (json!({"machine_id": null}), "/machine_id"),
        (json!({"position_gain_scale": {"B": 1.0}}), "/position_gain_scale/B"),
    ] {
        let found =
            problem(app.post_json(SIMULATE, &with(body.clone(), &change)).await, "invalid-request").await;
        assert_eq!(pointers(&found), [pointer], "{found}");
    }
    let swept = with(body, &json!({"feed_mm_per_min": [900]}));
    let found = problem(app.post_json(SWEEP, &swept).await, "invalid-request").await;
    assert_eq!(pointers(&found), ["/path/kind"]);
}

/// An acceleration that takes millions of samples.
const LAZY: &str = "/v1/machines/example-ac-table/servo-simulation?feed_profile.acceleration_mm_per_s2=1&feed_profile.jerk_mm_per_s3=1&sample_period_s=0.00001";

#[tokio::test]
async fn programs_that_cannot_be_simulated_store_nothing() {
    let app = spawn().await;
    app.put_machine("bare", &ac_table()).await;
    for (path, text, code) in [
        (PROGRAM, "G1 X1\nM30\n", "program-fault"),
        (PROGRAM, "", "program-fault"),
        (PROGRAM, "G0 X0 Y0 Z0 A0 C0\nG93 G1 X10 F0.000001\n", "too-costly"),
        (LAZY, SQUARE, "too-costly"),
        ("/v1/machines/bare/servo-simulation", SQUARE, "invalid-request"),
        ("/v1/machines/nobody/servo-simulation", SQUARE, "machine-not-found"),
    ] {
        problem(app.post_text(path, "text/plain", text).await, code).await;
    }
    let unstable = format!("{PROGRAM}?position_gain_scale.X=900");
    problem(app.post_text(&unstable, "text/plain", SQUARE).await, "unstable-loop").await;
    let negative = format!(
        "{PROGRAM}?sample_period_s=-1&feed_profile.acceleration_mm_per_s2=0&feed_profile.jerk_mm_per_s3=1"
    );
    let found = problem(app.post_text(&negative, "text/plain", SQUARE).await, "invalid-request").await;
    assert_eq!(pointers(&found), ["/sample_period_s", "/feed_profile/acceleration_mm_per_s2"]);
    let jobs: Value = app.get("/v1/jobs").await.json().await.unwrap();
    assert_eq!(jobs["items"], json!([]));
    assert_eq!(app.files(), (0, 0));
}
