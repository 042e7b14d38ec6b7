//! Calibration runs: posted, read, compared, followed, applied.

use std::fmt::Write;

use reqwest::{Response, StatusCode};
use serde_json::{Value, json};
use trunnion::plot::plain;

use crate::database;
use crate::support::{App, ac_table, pointers, problem, spawn};

pub(crate) const RUNS: &str = "/v1/machines/example-ac-table/calibrations";

/// P4's run as eccentricities alone, with a known set-up error.
fn p4_run() -> Value {
    json!({
        "kind": "rtcp-ballbar", "measured_at": "2025-03-14T10:26:53+01:00", "temperature_c": 20.1, "note": "after <the> crash",
        "instrument": "ball bar", "operator": "M. Huber",
        "bar_length_mm": 100, "setup_error_um": {"e_xs": 4.0, "e_ys": -6.0},
        "tests": [
            {"rotary_axis": "C", "bar_direction": "radial", "ball_mm": [150, 20, 60], "eccentricity_um": [6.7, 16.4]},
            {"rotary_axis": "C", "bar_direction": "axial", "ball_mm": [150, 20, 60], "eccentricity_um": [-2.0, 2.6]},
            {"rotary_axis": "A", "bar_direction": "radial", "ball_mm": [30, 10, 160], "eccentricity_um": [9.9, -69.1]},
            {"rotary_axis": "A", "bar_direction": "axial", "ball_mm": [30, 10, 160], "eccentricity_um": [4.5, 14.0]}
        ]
    })
}

/// First-order readings of an AC table with both axes through the origin, for shifts (µm) of A alone: there and back.
pub(crate) fn sweeps(shift_um: [f64; 3], noise_um: f64) -> Value {
    let [dx, dy, dz] = shift_um;
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(state >> 8) / f64::from(1 << 24) - 0.5) * 2.0 * noise_um
    };
    let mut test = |axis: &str, bar: &str, reading: &dyn Fn(f64, f64) -> f64| {
        let (from, to) = if axis == "C" { (0, 36) } else { (-9, 9) };
        let angles: Vec<i32> = (from..=to).chain((from..=to).rev()).collect();
        let readings: Vec<Value> = angles
            .iter()
            .map(|tenth| {
                let angle = f64::from(*tenth) * 10.0;
                let (sin, cos) = angle.to_radians().sin_cos();
                json!({"angle_deg": angle, "length_change_um": reading(sin, cos) + noise()})
            })
            .collect();
        json!({"rotary_axis": axis, "bar_direction": bar, "ball_mm": [150, 0, 100], "readings": readings})
    };
    let tests = [
        test("C", "radial", &|sin, cos| -dx * (cos - 1.0) + dy * sin),
        test("C", "axial", &|_, _| 0.0),
        test("A", "radial", &|sin, cos| -dy * sin - dz * (cos - 1.0)),
        test("A", "axial", &|_, _| 0.0),
    ];
    json!({
        "kind": "rtcp-ballbar", "measured_at": "2025-04-01T00:00:00Z", "bar_length_mm": 100,
        "setup_error_um": {"e_xs": 0, "e_ys": 0}, "tests": tests
    })
}

/// A change to a run.
type Change = fn(&mut Value);

async fn post(app: &App, run: &Value) -> Value {
    let response = app.post_json(RUNS, run).await;
    let status = response.status();
    let document: Value = response.json().await.unwrap();
    assert_eq!(status, StatusCode::CREATED, "{document}");
    document
}

fn etag(response: &Response) -> String {
    response.headers()["etag"].to_str().unwrap().to_owned()
}

async fn apply(app: &App, id: &str, tag: &str, body: &str) -> Response {
    let request = app.client.post(app.url(&format!("{RUNS}/{id}/apply"))).header("if-match", tag);
    let request = if body.is_empty() { request } else { request.header("content-type", "application/json") };
    request.body(body.to_owned()).send().await.unwrap()
}

async fn machine(app: &App) -> (String, Value) {
    let response = app.get("/v1/machines/example-ac-table").await;
    (etag(&response), response.json().await.unwrap())
}

fn value(document: &Value, axis: &str, error: &str) -> f64 {
    document["errors"][axis][error]["value"].as_f64().unwrap()
}

async fn svg(app: &App, path: &str) -> String {
    let response = app.client.get(app.url(path)).header("accept", "image/svg+xml").send().await.unwrap();
    assert_eq!(response.status(), StatusCode::OK, "{path}");
    let text = response.text().await.unwrap();
    assert!(text.starts_with("<svg") && text.ends_with("</svg>\n") && !text.contains("NaN"), "{path}");
    text
}

#[tokio::test]
async fn a_run_is_stored_and_read_back_as_it_was_answered() {
    let app = spawn().await;
    let response = app.post_json(RUNS, &p4_run()).await;
    assert_eq!(response.status(), StatusCode::CREATED);
    let (tag, location) = (etag(&response), response.headers()["location"].to_str().unwrap().to_owned());
    let text = response.text().await.unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(location, format!("{RUNS}/{}", document["id"].as_str().unwrap()));
    assert_eq!(document["machine_revision"], 1);
    assert_eq!(document["measured_at"], "2025-03-14T09:26:53.000Z");
    assert_eq!((document["rank"].as_u64(), document["unknowns"].as_u64()), (Some(8), Some(8)));
    assert_eq!(document["unidentifiable"], json!([]));
    assert_eq!(document["degrees_of_freedom"], 0);
    assert_eq!(document["errors"]["A"]["e_y_um"]["standard_uncertainty"], Value::Null);
    assert_eq!(document["eccentricities_um"]["before"][2], json!([9.9, -69.1]));
    assert_eq!(document["setup_error_um"]["source"], "given");
    // §5: δzAY = −Δz + Px·βAY, with βAY = (PyΔy − PzΔz)/(Py² + Pz²) of the A axial row.
    let beta_urad = (10.0 * 4.5 - 160.0 * 14.0) / (10.0_f64.powi(2) + 160.0_f64.powi(2)) * 1e3;
    assert!((value(&document, "A", "e_b_urad") - beta_urad).abs() < 0.5, "{document}");
    assert!((value(&document, "A", "e_z_um") - (69.1 + 30.0 * beta_urad * 1e-3)).abs() < 0.1);

    let again = app.get(&location).await;
    assert_eq!(etag(&again), tag);
    assert_eq!(again.text().await.unwrap(), text);
    let known = app.client.get(app.url(&location)).header("if-none-match", &tag).send().await.unwrap();
    assert_eq!(known.status(), StatusCode::NOT_MODIFIED);

    let run = app.get(&format!("{location}/run")).await;
    assert_eq!(etag(&run).trim_matches('"'), document["run_sha256"].as_str().unwrap());
    let run: Value = run.json().await.unwrap();
    assert_eq!(run["tests"][1]["eccentricity_um"], json!([-2.0, 2.6]));

    assert!(svg(&app, &location).await.contains("A axial z"));
    let page = app.client.get(app.url(&location)).header("accept", "text/html").send().await.unwrap();
    assert_eq!(page.headers()["content-type"], "text/html; charset=utf-8");
    let page = page.text().await.unwrap();
    assert!(
        page.contains("after &lt;the&gt; crash")
            && page.contains("<i>E</i><sub>Y0A</sub> [µm]")
            && page.contains("<svg")
    );
    let no_readings = app
        .client
        .get(app.url(&format!("{location}?plot=residuals&test=0")))
        .header("accept", "image/svg+xml")
        .send()
        .await
        .unwrap();
    assert_eq!(pointers(&problem(no_readings, "invalid-request").await), ["/test"]);
}

#[tokio::test]
async fn readings_give_uncertainties_residuals_and_questions() {
    let app = spawn().await;
    let document = post(&app, &sweeps([10.0, -20.0, 30.0], 0.5)).await;
    for (error, truth) in [("e_x_um", 10.0), ("e_y_um", -20.0), ("e_z_um", 30.0)] {
        let sigma = document["errors"]["A"][error]["standard_uncertainty"].as_f64().unwrap();
        assert!((0.01..1.0).contains(&sigma), "{error}: {sigma}");
        // Four standard uncertainties, and what the first-order readings leave out.
        assert!((value(&document, "A", error) - truth).abs() < 4.0 * sigma + 0.05, "{document}");
    }
    let matrix = document["covariance"]["matrix_um_urad"].as_array().unwrap();
    assert_eq!(document["covariance"]["names"][0], "A.e_x_um");
    let variance = matrix[0][0].as_f64().unwrap();
    let sigma = document["errors"]["A"]["e_x_um"]["standard_uncertainty"].as_f64().unwrap();
    assert!((variance.sqrt() - sigma).abs() < 1e-12 * sigma);
    assert_eq!(document["warnings"], json!([]));
    let rms = document["residual_rms_um"].as_f64().unwrap();
    assert!((0.2..0.4).contains(&rms), "uniform noise of 0.5 µm has 0.29 µm rms, not {rms}");
    let location = format!("{RUNS}/{}", document["id"].as_str().unwrap());
    let residuals = svg(&app, &format!("{location}?plot=residuals&test=2")).await;
    assert!(residuals.contains("A axis, bar radial") && residuals.contains("magnified"));

    // One sweep only, and millimetres.
    let mut poor = sweeps([10.0, -20.0, 30.0], 0.0);
    for test in poor["tests"].as_array_mut().unwrap() {
        let readings = test["readings"].as_array_mut().unwrap();
        readings.truncate(readings.len() / 2);
        for reading in readings {
            reading["length_change_um"] = (reading["length_change_um"].as_f64().unwrap() * 1e-3).into();
        }
    }
    let document = post(&app, &poor).await;
    let kinds: Vec<&str> = document["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| warning["kind"].as_str().unwrap())
        .collect();
    assert_eq!(kinds.iter().filter(|kind| **kind == "single-sweep").count(), 4);
    assert!(kinds.contains(&"suspiciously-small"), "{kinds:?}");
}

#[tokio::test]
async fn a_document_lists_a_thousand_outliers_and_counts_all() {
    let app = spawn().await;
    let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
    let readings: Vec<Value> = (0..6000_i32)
        .map(|k| {
            let angle_deg = f64::from(k) * 0.06;
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let noise = f64::from(k * 7 % 11 - 5) * 0.1;
            let wrong = if k % 5 == 0 { 60.0 } else { 0.0 };
            json!({"angle_deg": angle_deg, "length_change_um": -10.0 * (cos - 1.0) - 20.0 * sin + noise + wrong})
        })
        .collect();
    run["tests"][0]["readings"] = readings.into();
    let document = post(&app, &run).await;
    assert_eq!(document["outliers"].as_array().unwrap().len(), 1000);
    let warnings = document["warnings"].as_array().unwrap();
    let left_out = warnings.iter().find(|warning| warning["kind"] == "outliers-left-out").unwrap();
    assert!(left_out["detail"].as_str().unwrap().starts_with("1200 readings"), "{left_out}");
}

#[tokio::test]
async fn what_a_run_cannot_tell_apart_is_said_in_words() {
    let app = spawn().await;
    let mut run = sweeps([10.0, -20.0, 30.0], 0.0);
    run["setup_error_um"] = Value::Null;
    let document = post(&app, &run).await;
    assert_eq!((document["rank"].as_u64(), document["unknowns"].as_u64()), (Some(8), Some(10)));
    assert_eq!(document["setup_error_um"]["source"], "held_at_zero");
    let names = ["A.e_x_um", "A.e_y_um", "e_xs_um", "e_ys_um", "E_Y0A_um", "E_X0C_um", "E_Y0C_um"];
    assert_eq!(document["unidentifiable"], json!(names));
    for (axis, error, is_told) in [("A", "e_x", false), ("A", "e_z", true), ("C", "E_X0C", false)] {
        let trend: Value =
            app.get(&format!("{RUNS}/trend?axis={axis}&error={error}")).await.json().await.unwrap();
        assert_eq!(trend["points"][0]["identifiable"], is_told, "{axis} {error}: {trend}");
    }
    let blind = &document["blind"][0];
    assert!(
        blind["words"].as_str().unwrap().contains("cannot be separated from the set-up error"),
        "{blind}"
    );
    assert!(blind["separated_by"].as_str().unwrap().contains("spindle step"), "{blind}");
    // What only the set-up error hides needs no confirmation.
    let (tag, _) = machine(&app).await;
    assert_eq!(apply(&app, document["id"].as_str().unwrap(), &tag, "").await.status(), StatusCode::OK);

    // C tests alone say nothing of where A is.
    run["setup_error_um"] = json!({"e_xs": 0, "e_ys": 0});
    run["tests"].as_array_mut().unwrap().truncate(2);
    let document = post(&app, &run).await;
    assert!(document["rank"].as_u64().unwrap() < 8);
    assert_eq!(document["errors"]["A"]["e_z_um"]["standard_uncertainty"], Value::Null);
    let remedies: Vec<&Value> =
        document["blind"].as_array().unwrap().iter().map(|blind| &blind["separated_by"]).collect();
    assert!(
        remedies.iter().any(|remedy| remedy.as_str().is_some_and(|words| words.contains("a test of A"))),
        "{remedies:?}"
    );
    let (tag, _) = machine(&app).await;
    let id = document["id"].as_str().unwrap();
    let refused = problem(apply(&app, id, &tag, "").await, "confirmation-needed").await;
    assert!(
        refused["errors"][0]["detail"].as_str().unwrap().contains("does not determine this"),
        "{refused}"
    );
    assert_eq!(apply(&app, id, &tag, r#"{"confirm": true}"#).await.status(), StatusCode::OK);
}

#[tokio::test]
async fn a_run_is_applied_once_and_changes_what_is_computed() {
    let app = spawn().await;
    let first = post(&app, &sweeps([10.0, -20.0, 30.0], 0.0)).await;
    let second = post(&app, &sweeps([12.0, -21.0, 31.0], 0.0)).await;
    let (id, other) = (first["id"].as_str().unwrap(), second["id"].as_str().unwrap());
    let (tag, _) = machine(&app).await;
    problem(
        app.client.post(app.url(&format!("{RUNS}/{id}/apply"))).send().await.unwrap(),
        "precondition-required",
    )
    .await;
    let applied = apply(&app, id, &tag, "").await;
    assert_eq!(applied.status(), StatusCode::OK);
    assert_eq!(applied.headers()["trunnion-calibration"], id);
    let applied_tag = etag(&applied);
    let document: Value = applied.json().await.unwrap();
    assert_eq!(document["revision"], 2);
    let error = &document["kinematics"]["rotary_axes"][0]["location_error"];
    assert_eq!(error["e_z_um"], first["errors"]["A"]["e_z_um"]["value"]);
    // The same document as from the machine itself, but for the revision's own members a profile that can be put back.
    assert_eq!(machine(&app).await, (applied_tag.clone(), document.clone()));

    problem(apply(&app, id, &tag, "").await, "precondition-failed").await;
    let again = apply(&app, id, &applied_tag, "").await;
    assert_eq!(etag(&again), applied_tag, "applied twice is applied once");
    let changed = apply(&app, other, &applied_tag, "").await;
    let changed_tag = etag(&changed);
    assert_eq!(changed.json::<Value>().await.unwrap()["revision"], 3);
    let back = apply(&app, id, &changed_tag, "").await;
    let back: Value = back.json().await.unwrap();
    assert_eq!(back["revision"], 4, "going back is a revision of its own");
    assert_eq!(&back["kinematics"]["rotary_axes"][0]["location_error"], error);

    // At A = 90°, C = 0 the table carries its origin from (10, −20, 30) µm about the displaced A axis: Y = dy − dz,
    // Z = dz + dy.
    let poses =
        json!({"poses": [{"x": 0, "y": 0, "z": 0, "i": 0, "j": -1, "k": 0}], "start": {"A": 90, "C": 0}});
    let solved = app.post_json("/v1/machines/example-ac-table/inverse-kinematics", &poses).await;
    let solved: Value = solved.json().await.unwrap();
    assert_eq!(solved["machine_revision"], 4, "{solved}");
    let word = |letter: &str| solved["joints"][0][letter].as_f64().unwrap();
    assert!((word("A") - 90.0).abs() < 0.01, "{solved}");
    assert!((word("Y") + 0.050).abs() < 1e-3 && (word("Z") - 0.010).abs() < 1e-3, "{solved}");
}

#[tokio::test]
async fn probed_spheres_give_an_axis_that_can_be_applied() {
    let app = spawn().await;
    // C through (20, −30, 0) µm, leaning by 100 µrad about X: centres on its circle of 140 mm at 5 angles, 50 mm up.
    let centres: Vec<Value> = (0..5_i32)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 72.0).to_radians().sin_cos();
            let (x, y) = (140.0 * cos, -140.0 * sin);
            // A rotation about X by 1e-4 of (x, y, 50), then the shift; the table turns by −θ.
            let tilt = 1e-4_f64;
            let centre =
                [x + 0.020, y * tilt.cos() - 50.0 * tilt.sin() - 0.030, y * tilt.sin() + 50.0 * tilt.cos()];
            json!({"centre_mm": centre, "angle_deg": f64::from(k) * 72.0})
        })
        .collect();
    let run = json!({
        "kind": "rotary-sphere", "measured_at": "2025-05-01T00:00:00Z",
        "axes": [{"rotary_axis": "C", "centres": centres}]
    });
    let document = post(&app, &run).await;
    let close = |pointer: &str, expected: f64| {
        let value = document.pointer(pointer).and_then(Value::as_f64).unwrap();
        // 1e-6 µm and µrad of rounding, and the difference of tilt and its sine.
        assert!((value - expected).abs() < 1e-5, "{pointer}: {value} is not {expected}");
    };
    close("/errors/C/e_x_um/value", 20.0);
    close("/errors/C/e_y_um/value", -30.0);
    close("/errors/C/e_a_urad/value", 100.0);
    close("/errors/C/e_b_urad/value", 0.0);
    close("/iso_230/E_A0C_urad/value", 100.0);
    close("/axes/0/spheres/0/radius_mm", 140.0);
    assert!(document["errors"]["A"].is_null(), "A was not measured");
    assert!(document["condition_number"].is_null() && document["eccentricities_um"].is_null());
    let location = format!("{RUNS}/{}", document["id"].as_str().unwrap());
    let bars = app.client.get(app.url(&location)).header("accept", "image/svg+xml").send().await.unwrap();
    assert_eq!(pointers(&problem(bars, "invalid-request").await), ["/plot"]);
    let (tag, _) = machine(&app).await;
    let applied: Value = apply(&app, document["id"].as_str().unwrap(), &tag, "").await.json().await.unwrap();
    assert!(
        (applied["kinematics"]["rotary_axes"][1]["location_error"]["e_x_um"].as_f64().unwrap() - 20.0).abs()
            < 1e-5
    );

    let cases: [(Change, &[&str]); 6] = [
        (|run| run["axes"][0]["rotary_axis"] = "B".into(), &["/axes/0/rotary_axis"]),
        (
            |run| {
                run["axes"][0]["centres"].as_array_mut().unwrap().truncate(2);
                run["measured_at"] = "yesterday".into();
                run["instrument_uncertainty_um"] = 1.into();
            },
            &["/axes/0/centres", "/instrument_uncertainty_um", "/measured_at"],
        ),
        (|run| run["axes"][0]["centres"].as_array_mut().unwrap().truncate(2), &["/axes/0/centres"]),
        (
            |run| {
                run["axes"][0]["centres"][1].as_object_mut().unwrap().remove("angle_deg");
            },
            &["/axes/0/centres"],
        ),
        (
            |run| run["axes"][0]["centres"][1]["centre_mm"][2] = 1e300.into(),
            &["/axes/0/centres/1/centre_mm/2"],
        ),
        (
            |run| {
                run.as_object_mut().unwrap().remove("axes");
                run["bar_length_mm"] = 100.into();
            },
            &["/axes", "/bar_length_mm"],
        ),
    ];
    for (change, expected) in cases {
        let mut run = run.clone();
        change(&mut run);
        let refused = problem(app.post_json(RUNS, &run).await, "invalid-request").await;
        let mut found = pointers(&refused);
        found.sort();
        assert_eq!(found, expected, "{refused}");
    }
}

#[tokio::test]
async fn a_run_is_exported_to_controls() {
    let app = spawn().await;
    let run = post(&app, &sweeps([10.0, -20.0, 30.0], 0.0)).await;
    let export = format!("{RUNS}/{}/export", run["id"].as_str().unwrap());
    for (format, part) in [
        ("iso230", "E_Y0A"),
        ("linuxcnc", "xyzac-trt-kins"),
        ("siemens", "TRAFO5_AXIS1_1"),
        ("siemens-tool-carrier&tool_carrier=3", "TC_CARR"),
    ] {
        let response = app.get(&format!("{export}?format={format}")).await;
        assert_eq!(response.status(), StatusCode::OK, "{format}");
        assert_eq!(response.headers()["content-type"], "text/plain; charset=utf-8");
        let text = response.text().await.unwrap();
        assert!(text.contains(part), "{format}: {text}");
    }
    let refused =
        problem(app.get(&format!("{export}?format=linuxcnc&radius_mm=-1")).await, "invalid-request").await;
    assert_eq!(pointers(&refused), ["/radius_mm"]);
    // The text tells what the answer tells.
    let text = app.get(&format!("{export}?format=iso230")).await.text().await.unwrap();
    let text: toml::Table = text.parse().unwrap();
    for (index, axis) in ["A", "C"].into_iter().enumerate() {
        for (symbol, value) in text["rotary_axes"][index]["iso_230"].as_table().unwrap() {
            if let Some(value) = value.as_float() {
                let answered = run["iso_230"][symbol]["value"].as_f64().unwrap();
                assert!((value - answered).abs() < 1e-9, "{symbol} of {axis}: {value} is not {answered}");
            }
        }
    }
    let unknown = problem(app.get(&format!("{export}?format=other")).await, "invalid-request").await;
    assert_eq!(pointers(&unknown), ["/format"]);
}

#[tokio::test]
async fn a_large_change_needs_a_word() {
    let app = spawn().await;
    let run = post(&app, &sweeps([10.0, -250.0, 30.0], 0.0)).await;
    let (tag, _) = machine(&app).await;
    let id = run["id"].as_str().unwrap();
    let refused = apply(&app, id, &tag, "{}").await;
    assert_eq!(refused.status(), StatusCode::CONFLICT);
    let refused = problem(refused, "confirmation-needed").await;
    assert_eq!(pointers(&refused), ["/kinematics/rotary_axes/0/location_error/e_y_um"]);
    assert_eq!(machine(&app).await.1["revision"], 1, "nothing was stored");
    assert_eq!(apply(&app, id, &tag, r#"{"confirm": true}"#).await.status(), StatusCode::OK);
    let wrong = apply(&app, id, "*", r#"{"confirm": 1}"#).await;
    assert_eq!(pointers(&problem(wrong, "invalid-request").await), ["/confirm"]);
}

#[tokio::test]
async fn a_run_of_other_axes_is_not_applied() {
    let app = spawn().await;
    let run = post(&app, &sweeps([10.0, -20.0, 30.0], 0.0)).await;
    let (tag, mut profile) = machine(&app).await;
    for name in ["machine_id", "revision", "created_at"] {
        profile.as_object_mut().unwrap().remove(name);
    }
    profile["kinematics"]["rotary_axes"][0]["point_mm"] = json!([0, 0, -5]);
    let put = app.client.put(app.url("/v1/machines/example-ac-table")).header("if-match", tag);
    assert_eq!(put.json(&profile).send().await.unwrap().status(), StatusCode::OK);
    let refused = apply(&app, run["id"].as_str().unwrap(), "*", "").await;
    assert_eq!(refused.status(), StatusCode::CONFLICT);
    problem(refused, "axes-changed").await;
}

/// Stores the example machine again with a change.
async fn change_machine(app: &App, change: impl FnOnce(&mut Value)) {
    let (tag, mut profile) = machine(app).await;
    for name in ["machine_id", "revision", "created_at"] {
        profile.as_object_mut().unwrap().remove(name);
    }
    change(&mut profile["kinematics"]);
    let put = app.client.put(app.url("/v1/machines/example-ac-table")).header("if-match", tag);
    assert_eq!(put.json(&profile).send().await.unwrap().status(), StatusCode::OK);
}

#[tokio::test]
async fn a_run_evaluated_with_another_squareness_needs_a_word() {
    let app = spawn().await;
    let run = post(&app, &sweeps([10.0, -20.0, 30.0], 0.0)).await;
    let id = run["id"].as_str().unwrap();
    change_machine(&app, |kinematics| kinematics["squareness_urad"]["e_c0y"] = json!(50)).await;
    let refused = problem(apply(&app, id, "*", "").await, "confirmation-needed").await;
    assert_eq!(pointers(&refused), ["/kinematics/squareness_urad"]);
    assert_eq!(apply(&app, id, "*", r#"{"confirm": true}"#).await.status(), StatusCode::OK);
}

#[tokio::test]
async fn what_a_run_leaves_open_is_no_significant_difference() {
    let app = spawn().await;
    let known = post(&app, &sweeps([10.0, -20.0, 30.0], 0.5)).await;
    let mut run = sweeps([10.0, -26.0, 34.0], 0.5);
    run["setup_error_um"] = Value::Null;
    let unknown = post(&app, &run).await;
    let (here, there) = (unknown["id"].as_str().unwrap(), known["id"].as_str().unwrap());
    let difference: Value =
        app.get(&format!("{RUNS}/{here}/difference?from={there}")).await.json().await.unwrap();
    // 6 µm that may as well be the ball's; 4 µm that are the axis'.
    assert_eq!(difference["errors"]["A"]["e_y_um"]["significant"], Value::Null, "{difference}");
    assert_eq!(difference["iso_230"]["E_Y0A_um"]["significant"], Value::Null);
    assert_eq!(difference["errors"]["A"]["e_z_um"]["significant"], true);
}

#[tokio::test]
async fn an_axis_measured_without_its_carrier_is_applied_where_the_carrier_stands_as_then() {
    let app = spawn().await;
    let centres: Vec<Value> = (0..5_i32)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 72.0).to_radians().sin_cos();
            json!({"centre_mm": [140.0 * cos + 0.02, -140.0 * sin, 50], "angle_deg": f64::from(k) * 72.0})
        })
        .collect();
    let spheres = json!({
        "kind": "rotary-sphere", "measured_at": "2025-05-01T00:00:00Z",
        "axes": [{"rotary_axis": "C", "centres": centres}]
    });
    let c_alone = post(&app, &spheres).await;
    let both = post(&app, &sweeps([10.0, -20.0, 30.0], 0.0)).await;
    let (tag, _) = machine(&app).await;
    assert_eq!(apply(&app, both["id"].as_str().unwrap(), &tag, "").await.status(), StatusCode::OK);
    // A has moved in the profile, and with it what the values of C count from.
    let refused = apply(&app, c_alone["id"].as_str().unwrap(), "*", "").await;
    let refused = problem(refused, "axes-changed").await;
    assert!(refused["detail"].as_str().unwrap().contains("carries"), "{refused}");
    // Measured on the machine as it is now, C can be applied.
    let again = post(&app, &spheres).await;
    assert_eq!(apply(&app, again["id"].as_str().unwrap(), "*", "").await.status(), StatusCode::OK);
}

#[tokio::test]
async fn a_head_axis_without_a_tool_length_is_asked_about() {
    let app = spawn().await;
    let presets: Value = app.get("/v1/machine-presets").await.json().await.unwrap();
    let head = presets["items"].as_array().unwrap().iter().find(|preset| preset["id"] == "bc-head").unwrap();
    assert_eq!(app.put_machine("head", &head["profile"]).await.status(), StatusCode::CREATED);
    let test = |axis: &str| json!({"rotary_axis": axis, "bar_direction": "radial", "ball_mm": [0, 0, 0], "eccentricity_um": [1, 2]});
    let mut run = p4_run();
    run["tests"] = json!([test("B"), test("C")]);
    run["tests"][1]["tool_length_mm"] = 200.into();
    let answer = app.post_json("/v1/machines/head/calibrations", &run).await;
    assert_eq!(answer.status(), StatusCode::CREATED);
    let answer: Value = answer.json().await.unwrap();
    let asked = answer["warnings"].as_array().unwrap();
    let asked: Vec<_> = asked.iter().filter(|warning| warning["kind"] == "no-tool-length").collect();
    assert_eq!(asked.len(), 1, "{answer}");
    assert_eq!(asked[0]["test"], 0);
}

#[tokio::test]
async fn the_database_keeps_runs_as_they_are() {
    let app = spawn().await;
    post(&app, &p4_run()).await;
    for statement in [
        "UPDATE calibrations SET run = '{}'",
        "DELETE FROM calibrations",
        "UPDATE calibration_errors SET value = 0",
        "DELETE FROM calibration_errors",
    ] {
        let refused = database::change(&app.data, statement).await.unwrap_err();
        assert!(refused.contains("a calibration never"), "{statement}: {refused}");
    }
}

#[tokio::test]
async fn keys_make_retries_safe() {
    let app = spawn().await;
    let keyed =
        |path: String, key: &'static str| app.client.post(app.url(&path)).header("idempotency-key", key);
    let send = |key| keyed(RUNS.to_owned(), key).json(&p4_run()).send();
    let (first, second) = futures::future::join(send("run"), send("run")).await;
    let (first, second): (Value, Value) =
        (first.unwrap().json().await.unwrap(), second.unwrap().json().await.unwrap());
    assert_eq!(first, second);
    let list: Value = app.get(RUNS).await.json().await.unwrap();
    assert_eq!(list["items"].as_array().unwrap().len(), 1);
    let mut other = p4_run();
    other["note"] = "another".into();
    problem(keyed(RUNS.to_owned(), "run").json(&other).send().await.unwrap(), "idempotency-key-reused").await;

    let (tag, _) = machine(&app).await;
    let path = format!("{RUNS}/{}/apply", first["id"].as_str().unwrap());
    let apply = || keyed(path.clone(), "apply").header("if-match", &tag).send();
    let applied: Value = apply().await.unwrap().json().await.unwrap();
    assert_eq!(applied["revision"], 2);
    let retried = apply().await.unwrap();
    assert_eq!(retried.status(), StatusCode::OK, "the tag is stale, but the answer is known");
    assert_eq!(retried.json::<Value>().await.unwrap(), applied);
    problem(keyed(path, "run").header("if-match", "*").send().await.unwrap(), "idempotency-key-reused").await;
}

#[tokio::test]
async fn runs_are_listed_compared_and_followed() {
    let app = spawn().await;
    let mut ids = Vec::new();
    for month in 1..=3_u32 {
        let mut run = sweeps([10.0, -20.0 + f64::from(month), 30.0], 0.5);
        run["measured_at"] = format!("2025-0{month}-01T08:00:00Z").into();
        ids.push(post(&app, &run).await["id"].as_str().unwrap().to_owned());
    }
    let page: Value = app.get(&format!("{RUNS}?limit=2")).await.json().await.unwrap();
    assert_eq!(page["items"][0]["id"], ids[2]);
    let cursor = page["next_cursor"].as_str().unwrap();
    let rest: Value = app.get(&format!("{RUNS}?limit=2&cursor={cursor}")).await.json().await.unwrap();
    assert_eq!(rest["items"].as_array().unwrap().len(), 1);
    let some: Value = app
        .get(&format!(
            "{RUNS}?measured_from=2025-01-15T00:00:00Z&measured_to=2025-02-15T00:00:00Z&kind=rtcp-ballbar"
        ))
        .await
        .json()
        .await
        .unwrap();
    assert_eq!((some["items"].as_array().unwrap().len(), &some["items"][0]["id"]), (1, &json!(ids[1])));
    let none: Value = app.get(&format!("{RUNS}?kind=rotary-sphere")).await.json().await.unwrap();
    assert_eq!(none, json!({"items": [], "next_cursor": null}));

    let difference: Value =
        app.get(&format!("{RUNS}/{}/difference?from={}", ids[2], ids[0])).await.json().await.unwrap();
    let moved = &difference["errors"]["A"]["e_y_um"];
    assert!((moved["difference"].as_f64().unwrap() - 2.0).abs() < 0.1, "{difference}");
    assert_eq!(moved["significant"], true);
    assert_eq!(difference["iso_230"]["E_Z0A_um"]["significant"], false);

    let trend = format!("{RUNS}/trend?axis=A&error=e_y");
    let followed: Value = app.get(&trend).await.json().await.unwrap();
    assert_eq!(followed["unit"], "um");
    let points = followed["points"].as_array().unwrap();
    assert_eq!(points.iter().map(|point| point["calibration_id"].as_str().unwrap()).collect::<Vec<_>>(), ids);
    assert!(points.iter().all(|point| point["standard_uncertainty"].as_f64().unwrap() > 0.0));
    let newest: Value = app.get(&format!("{trend}&limit=1")).await.json().await.unwrap();
    assert_eq!(newest["points"], json!([points[2]]));
    let absolute: Value = app.get(&format!("{RUNS}/trend?axis=C&error=E_Y0C")).await.json().await.unwrap();
    assert_eq!(absolute["points"].as_array().unwrap().len(), 3);
    let table = app.client.get(app.url(&trend)).header("accept", "text/csv").send().await.unwrap();
    let table = table.text().await.unwrap();
    assert_eq!(table.lines().count(), 4);
    assert!(table.starts_with("calibration_id,measured_at,machine_revision,e_y_um,standard_uncertainty_um,"));
    let figure = svg(&app, &trend).await;
    assert!(figure.contains(">2025-02-") && figure.contains("in the profile, revision 1: 0 µm"), "{figure}");
    assert!(!figure.contains("applied to the profile") && !figure.contains("limits"));
    let applied = apply(&app, &ids[1], "*", r#"{"confirm": true}"#).await;
    assert_eq!(applied.status(), StatusCode::OK);
    let value = points[1]["value"].as_f64().unwrap();
    let figure = svg(&app, &format!("{trend}&tolerance_um=25")).await;
    assert!(figure.contains("applied to the profile") && figure.contains("limits ±25 µm"), "{figure}");
    assert!(
        figure.contains(&format!("in the profile, revision 2: {} µm", plain(value))),
        "{value}: {figure}"
    );
    let absolute = svg(&app, &format!("{RUNS}/trend?axis=C&error=E_Y0C")).await;
    assert!(absolute.contains("in the profile, revision 2"));
    for (query, pointer) in [("tolerance_um=-1", "/tolerance_um"), ("tolerance_urad=5", "/tolerance_urad")] {
        let refused = problem(app.get(&format!("{trend}&{query}")).await, "invalid-request").await;
        assert_eq!(pointers(&refused), [pointer]);
    }
}

#[tokio::test]
async fn bad_runs_are_refused_with_every_fault_and_nothing_is_stored() {
    let app = spawn().await;
    let cases: [(Change, &[&str]); 15] = [
        (
            |run| {
                run["operator"] = "a\0b".into();
                run["note"] = "two\r\n\tlines\u{7}".into();
            },
            &["/note", "/operator"],
        ),
        (|run| run["measured_at"] = "2126-01-01T00:00:00Z".into(), &["/measured_at"]),
        (|run| run["measured_at"] = "yesterday".into(), &["/measured_at"]),
        (|run| run["tests"] = json!([]), &["/tests"]),
        (
            |run| {
                run["tests"][0]["readings"].as_array_mut().unwrap().truncate(2);
                run["bar_length_mm"] = (-100).into();
            },
            &["/bar_length_mm", "/tests/0/readings"],
        ),
        (
            |run| {
                run["tests"][1]["rotary_axis"] = "B".into();
                run["tests"][2]["ball_mm"][1] = 1e9.into();
                run["note"] = "x".repeat(3000).into();
            },
            &["/note", "/tests/1/rotary_axis", "/tests/2/ball_mm/1"],
        ),
        (
            |run| run["tests"][0]["readings"][5]["length_change_um"] = 2e4.into(),
            &["/tests/0/readings/5/length_change_um"],
        ),
        (|run| run["tests"][3]["readings"][0]["angle_deg"] = 1e7.into(), &["/tests/3/readings/0/angle_deg"]),
        (|run| run["tests"][0]["eccentricity_um"] = json!([1, 2]), &["/tests/0"]),
        (|run| run["setup_error_um"] = json!({"e_xs": 1}), &["/setup_error_um/e_ys"]),
        (|run| run["setup_error_um"] = json!({}), &["/setup_error_um"]),
        (
            |run| {
                run["setup_error_um"] =
                    json!({"spindle_deg": [0, 90], "bar_direction": "x", "length_change_um": [0]});
            },
            &["/setup_error_um"],
        ),
        (
            |run| {
                run["setup_error_um"] =
                    json!({"spindle_deg": [0, 90], "bar_direction": "x", "length_change_um": [0, 1]});
            },
            &["/setup_error_um/spindle_deg"],
        ),
        (|run| run["instrument_uncertainty_um"] = (-1).into(), &["/instrument_uncertainty_um"]),
        (|run| run["axes"] = json!([]), &["/axes"]),
    ];
    for (change, expected) in cases {
        let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
        change(&mut run);
        let refused = problem(app.post_json(RUNS, &run).await, "invalid-request").await;
        let mut found = pointers(&refused);
        found.sort();
        assert_eq!(found, expected, "{refused}");
    }
    // Readings that are no machine's.
    let mut wild = sweeps([10.0, -20.0, 30.0], 0.0);
    for (number, reading) in wild["tests"][0]["readings"].as_array_mut().unwrap().iter_mut().enumerate() {
        reading["length_change_um"] = (if number % 2 == 0 { 9000.0 } else { -9000.0 }).into();
    }
    let answer = app.post_json(RUNS, &wild).await.status();
    assert!(answer == StatusCode::CREATED || answer == StatusCode::UNPROCESSABLE_ENTITY, "{answer}");
    let unknown = app.post_json("/v1/machines/nobody/calibrations", &p4_run()).await;
    problem(unknown, "machine-not-found").await;
    problem(app.get("/v1/machines/nobody/calibrations").await, "machine-not-found").await;
    problem(app.get("/v1/machines/nobody/calibrations/trend?axis=A&error=e_y").await, "machine-not-found")
        .await;
    problem(app.get(&format!("{RUNS}/none")).await, "calibration-not-found").await;
    let refused =
        problem(app.get(&format!("{RUNS}/trend?axis=D&error=e_q&limit=0")).await, "invalid-request").await;
    assert_eq!(pointers(&refused), ["/limit", "/axis", "/error"]);
    problem(apply(&app, "none", "*", "").await, "calibration-not-found").await;
}

#[tokio::test]
async fn a_run_of_another_machine_is_not_found_on_this_one() {
    let app = spawn().await;
    assert_eq!(app.put_machine("other", &ac_table()).await.status(), StatusCode::CREATED);
    let run = post(&app, &p4_run()).await;
    let id = run["id"].as_str().unwrap();
    problem(app.get(&format!("/v1/machines/other/calibrations/{id}")).await, "calibration-not-found").await;
    let mut path = String::new();
    write!(path, "/v1/machines/other/calibrations/{id}/apply").unwrap();
    let applied = app.client.post(app.url(&path)).header("if-match", "*").send().await.unwrap();
    problem(applied, "calibration-not-found").await;
}
