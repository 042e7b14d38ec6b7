//! Machines: revisions, conditions, faults.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::support::{App, ac_table, pointers, problem, spawn};

/// A change to a profile, and the pointer of the fault it makes.
type Case = (fn(&mut Value), String);

async fn put_if(app: &App, id: &str, profile: &Value, header: &str, value: &str) -> reqwest::Response {
    let request = app.client.put(app.url(&format!("/v1/machines/{id}"))).header(header, value);
    request.json(profile).send().await.unwrap()
}

fn etag(response: &reqwest::Response) -> String {
    response.headers()["etag"].to_str().unwrap().to_owned()
}

#[tokio::test]
async fn a_machine_is_made_replaced_and_deleted() {
    let app = spawn().await;
    let made = app.put_machine("dmu-80-t", &ac_table()).await;
    assert_eq!(made.status(), StatusCode::CREATED);
    assert_eq!(made.headers()["location"], "/v1/machines/dmu-80-t");
    let first = etag(&made);
    let document: Value = made.json().await.unwrap();
    assert_eq!(document["machine_id"], "dmu-80-t");
    assert_eq!(document["revision"], 1);
    assert_eq!(document["interpolation_period_s"], 0.002);
    assert_eq!(document["kinematics"]["squareness_urad"]["e_c0y"], 0.0);
    assert_eq!(document["kinematics"]["rotary_axes"][0]["reversed"], false);
    assert_eq!(
        document["kinematics"]["linear_limits_mm"],
        json!({"X": [-400.0, 400.0], "Y": null, "Z": null})
    );

    // What was read can be put back: the same revision.
    let mut same = document.clone();
    for name in ["machine_id", "revision", "created_at"] {
        same.as_object_mut().unwrap().remove(name);
    }
    let again = put_if(&app, "dmu-80-t", &same, "if-match", &first).await;
    assert_eq!((again.status(), etag(&again)), (StatusCode::OK, first.clone()));

    let mut changed = ac_table();
    changed["kinematics"]["rotary_axes"][0]["direction"] = json!([2, 0, 0.5]);
    let second = put_if(&app, "dmu-80-t", &changed, "if-match", &format!("\"other\", {first}")).await;
    assert_eq!(second.status(), StatusCode::OK);
    let second_tag = etag(&second);
    let second: Value = second.json().await.unwrap();
    assert_eq!(second["revision"], 2);
    let direction = &second["kinematics"]["rotary_axes"][0]["direction"];
    assert!((direction[0].as_f64().unwrap() - 2.0 / 4.25_f64.sqrt()).abs() < 1e-15);
    let mut same = second.clone();
    for name in ["machine_id", "revision", "created_at"] {
        same.as_object_mut().unwrap().remove(name);
    }
    assert_eq!(etag(&put_if(&app, "dmu-80-t", &same, "if-match", "*").await), second_tag);

    let revisions: Value = app.get("/v1/machines/dmu-80-t/revisions").await.json().await.unwrap();
    let numbers: Vec<_> =
        revisions["items"].as_array().unwrap().iter().map(|item| item["revision"].as_i64()).collect();
    assert_eq!(numbers, [Some(2), Some(1)]);
    let old: Value = app.get("/v1/machines/dmu-80-t/revisions/1").await.json().await.unwrap();
    assert_eq!(old, document);

    let delete = |tag: Option<String>| {
        let request = app.client.delete(app.url("/v1/machines/dmu-80-t"));
        async move {
            match tag {
                Some(tag) => request.header("if-match", tag).send().await.unwrap(),
                None => request.send().await.unwrap(),
            }
        }
    };
    problem(delete(None).await, "precondition-required").await;
    problem(delete(Some(first)).await, "precondition-failed").await;
    assert_eq!(delete(Some(second_tag)).await.status(), StatusCode::NO_CONTENT);
    problem(app.get("/v1/machines/dmu-80-t").await, "machine-not-found").await;
    problem(delete(Some("*".to_owned())).await, "machine-not-found").await;
    assert_eq!(app.get("/v1/machines/dmu-80-t/revisions/2").await.status(), 200);
    let recreated = app.put_machine("dmu-80-t", &ac_table()).await;
    assert_eq!(recreated.status(), StatusCode::CREATED);
    assert_eq!(recreated.json::<Value>().await.unwrap()["revision"], 3);
}

#[tokio::test]
async fn conditions_are_kept() {
    let app = spawn().await;
    problem(put_if(&app, "m", &ac_table(), "if-match", "*").await, "precondition-failed").await;
    problem(app.get("/v1/machines/m").await, "machine-not-found").await;
    assert_eq!(put_if(&app, "m", &ac_table(), "if-none-match", "*").await.status(), 201);
    problem(put_if(&app, "m", &ac_table(), "if-none-match", "*").await, "precondition-failed").await;
    problem(app.put_machine("m", &ac_table()).await, "precondition-required").await;
    problem(put_if(&app, "m", &ac_table(), "if-match", "unquoted").await, "malformed-request").await;
    problem(put_if(&app, "m", &ac_table(), "if-match", "\"a\" \"b\"").await, "malformed-request").await;
    let both = app.client.put(app.url("/v1/machines/m")).json(&ac_table());
    let both = both.header("if-match", "*").header("if-none-match", "unquoted").send().await.unwrap();
    problem(both, "malformed-request").await;
    let tag = etag(&app.get("/v1/machines/m").await);
    problem(put_if(&app, "m", &ac_table(), "if-match", &format!("W/{tag}")).await, "precondition-failed")
        .await;
    let known =
        |value: String| app.client.get(app.url("/v1/machines/m")).header("if-none-match", value).send();
    for value in [tag.clone(), format!("W/{tag}"), format!("\"x\" , {tag}"), "*".to_owned()] {
        let response = known(value).await.unwrap();
        assert_eq!((response.status().as_u16(), etag(&response)), (304, tag.clone()));
    }
    assert_eq!(known("\"x\"".to_owned()).await.unwrap().status(), 200);
}

#[tokio::test]
async fn of_two_conditions_both_count() {
    let app = spawn().await;
    let tag = etag(&app.put_machine("m", &ac_table()).await);
    let mut changed = ac_table();
    changed["name"] = json!("another");
    let send = |method: &'static str, matching: &str, absent: &str| {
        let request = app.client.request(method.parse().unwrap(), app.url("/v1/machines/m")).json(&changed);
        let request = request.header("if-match", matching).header("if-none-match", absent);
        async move { request.send().await.unwrap() }
    };
    let listed = format!("\"x\", W/{tag}");
    for matching in ["*", &tag] {
        for absent in ["*", &tag, &listed] {
            for method in ["PUT", "DELETE"] {
                problem(send(method, matching, absent).await, "precondition-failed").await;
            }
        }
    }
    // A revision that it is not is in nobody's way.
    for (method, status) in [("PUT", 200), ("DELETE", 204)] {
        let now = etag(&app.get("/v1/machines/m").await);
        let other = if method == "PUT" { "\"r9-0123456789abcdef\"" } else { tag.as_str() };
        problem(send(method, "\"x\"", other).await, "precondition-failed").await;
        let matching = if method == "PUT" { "*" } else { now.as_str() };
        assert_eq!(send(method, matching, other).await.status().as_u16(), status, "{method}");
    }
    // What is not there is no revision either.
    problem(send("PUT", "*", "\"x\"").await, "precondition-failed").await;
    problem(send("PUT", "*", "*").await, "precondition-failed").await;
}

#[tokio::test]
async fn of_puts_at_once_exactly_one_wins() {
    let app = spawn().await;
    let tag = etag(&app.put_machine("m", &ac_table()).await);
    let puts = (0..16).map(|index| {
        let mut profile = ac_table();
        profile["name"] = json!(format!("writer {index}"));
        let (app, tag) = (&app, &tag);
        async move { put_if(app, "m", &profile, "if-match", tag).await.status().as_u16() }
    });
    let mut statuses = futures::future::join_all(puts).await;
    statuses.sort_unstable();
    assert_eq!(statuses[0], 200);
    assert!(statuses[1..].iter().all(|status| *status == 412), "{statuses:?}");
}

#[tokio::test]
async fn every_fault_of_a_profile_is_named() {
    let app = spawn().await;
    let profile = json!({
        "name": "",
        "kinematics": {
            "rotary_axes": [
                {"name": "D", "side": "table", "direction": [0, 0, 0], "point_mm": [1e308, 0, 0], "limits_deg": [20, -20]},
                {"name": "C", "side": "table", "direction": [0, 0, 1], "point_mm": [0, 0, 0],
                 "location_error": {"e_a_urad": 60000}}
            ],
            "linear_limits_mm": {"Y": [5, 5]},
            "squareness_urad": {"e_b0z": 1e6}
        },
        "interpolation_period_s": 0,
        "drives": {"X": {"position_gain_per_s": -1, "velocity_gain_a_s_per_rad": 1, "velocity_integral_time_s": 0.01,
            "current_gain_v_per_a": 1, "inductance_h": 0.01, "resistance_ohm": 1, "torque_constant_nm_per_a": 1,
            "back_emf_v_s_per_rad": 1, "inertia_kg_m2": 0.01, "damping_nm_s_per_rad": 0,
            "transmission": {"gear_ratio": 90}}}
    });
    let body = problem(app.put_machine("m", &profile).await, "invalid-machine").await;
    let mut found = pointers(&body);
    found.sort();
    let axis = "/kinematics/rotary_axes/0";
    let mut expected = vec![
        "/name".to_owned(),
        format!("{axis}/name"),
        format!("{axis}/direction"),
        format!("{axis}/point_mm/0"),
        format!("{axis}/limits_deg"),
        "/kinematics/rotary_axes/1/location_error/e_a_urad".to_owned(),
        "/kinematics/linear_limits_mm/Y".to_owned(),
        "/kinematics/squareness_urad/e_b0z".to_owned(),
        "/interpolation_period_s".to_owned(),
        "/drives/X/position_gain_per_s".to_owned(),
        "/drives/X/transmission/lead_mm".to_owned(),
        "/drives/X/transmission/gear_ratio".to_owned(),
    ];
    expected.sort();
    assert_eq!(found, expected);
    problem(app.get("/v1/machines/m").await, "machine-not-found").await;
}

#[tokio::test]
async fn machines_that_cannot_point_the_tool_are_refused() {
    let app = spawn().await;
    let refused = |change: fn(&mut Value)| {
        let mut profile = ac_table();
        change(&mut profile["kinematics"]["rotary_axes"]);
        let app = &app;
        async move { pointers(&problem(app.put_machine("m", &profile).await, "invalid-machine").await) }
    };
    assert_eq!(refused(|axes| axes[1]["direction"] = json!([-1, 0, 0])).await, ["/kinematics/rotary_axes"]);
    let third = |axes: &mut Value| {
        let axis = axes[0].clone();
        axes.as_array_mut().unwrap().push(axis);
    };
    let found = refused(third).await;
    assert_eq!(found, ["/kinematics/rotary_axes", "/kinematics/rotary_axes/2/name"]);
    assert_eq!(refused(|axes| axes[1]["name"] = json!("A")).await, ["/kinematics/rotary_axes/1/name"]);
    let along = refused(|axes| {
        axes.as_array_mut().unwrap().swap(0, 1);
    });
    assert_eq!(along.await, ["/kinematics/rotary_axes/0/direction"]);
}

#[tokio::test]
async fn unknown_missing_and_mistyped_fields_are_named() {
    let app = spawn().await;
    let axis = "/kinematics/rotary_axes/0";
    let cases: [Case; 8] = [
        (|p| p["nmae"] = json!("x"), "/nmae".to_owned()),
        (|p| p["kinematics"]["rotary_axes"][0]["limit_deg"] = json!(null), format!("{axis}/limit_deg")),
        (|p| drop(p.as_object_mut().unwrap().remove("name")), "/name".to_owned()),
        (|p| p["kinematics"]["rotary_axes"][0]["direction"] = json!([1, 0]), format!("{axis}/direction")),
        (
            |p| p["kinematics"]["rotary_axes"][0]["direction"] = json!([1, 0, 0, 0]),
            format!("{axis}/direction"),
        ),
        (|p| p["kinematics"]["rotary_axes"][0]["direction"][1] = json!("0"), format!("{axis}/direction/1")),
        (|p| p["kinematics"]["rotary_axes"][0]["side"] = json!("bed"), format!("{axis}/side")),
        (|p| p["kinematics"]["squareness_urad"] = json!([1, 2, 3]), "/kinematics/squareness_urad".to_owned()),
    ];
    for (change, pointer) in cases {
        let mut profile = ac_table();
        change(&mut profile);
        let body = problem(app.put_machine("m", &profile).await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{body}");
    }
}

#[tokio::test]
async fn bad_bodies_are_refused_by_what_is_wrong_with_them() {
    let app = spawn().await;
    let put = |kind: &str, body: String| {
        let request =
            app.client.put(app.url("/v1/machines/m")).header("content-type", kind.to_owned()).body(body);
        async move { request.send().await.unwrap() }
    };
    let text = ac_table().to_string();
    problem(put("text/plain", text.clone()).await, "unsupported-media-type").await;
    problem(put("application/json", text.replace("-50", "NaN")).await, "unreadable-json").await;
    problem(put("application/json", text[..text.len() - 3].to_owned()).await, "unreadable-json").await;
    problem(put("application/json", text.clone() + "{}").await, "unreadable-json").await;
    problem(put("application/json", String::new()).await, "unreadable-json").await;
    let huge = put("application/json", text.replace("-50", "1e999")).await;
    assert_eq!(pointers(&problem(huge, "invalid-request").await), ["/kinematics/rotary_axes/0/point_mm/2"]);
    let absurd = put("application/json", text.replace("-50", "1e308")).await;
    assert_eq!(pointers(&problem(absurd, "invalid-machine").await), ["/kinematics/rotary_axes/0/point_mm/2"]);
    let twice = put("application/json", text.replacen('{', "{\"name\": \"a\", ", 1)).await;
    assert_eq!(pointers(&problem(twice, "invalid-request").await), ["/name"]);
    let deep = put("application/json", "[".repeat(100_000)).await;
    problem(deep, "unreadable-json").await;
    problem(put("application/json", "{\"name\": \"a\"} x".to_owned()).await, "unreadable-json").await;
}

#[tokio::test]
async fn ids_that_are_no_slugs_are_refused() {
    let app = spawn().await;
    for id in ["UPPER", "-a", "a_b", "a.b", "%20", &"a".repeat(65)] {
        let body = problem(app.put_machine(id, &ac_table()).await, "invalid-request").await;
        assert_eq!(pointers(&body), ["/machine_id"], "{id}");
    }
    assert_eq!(app.put_machine(&"a".repeat(64), &ac_table()).await.status(), 201);
    problem(app.get("/v1/machines/%ff").await, "malformed-request").await;
}

#[tokio::test]
async fn revisions_that_never_were_are_not_found() {
    let app = spawn().await;
    for revision in ["0", "2", "-1", "x", "99999999999999999999"] {
        let path = format!("/v1/machines/example-ac-table/revisions/{revision}");
        problem(app.get(&path).await, "revision-not-found").await;
    }
    problem(app.get("/v1/machines/none/revisions").await, "machine-not-found").await;
}

#[tokio::test]
async fn presets_can_be_put_as_they_are() {
    let app = spawn().await;
    let presets: Value = app.get("/v1/machine-presets").await.json().await.unwrap();
    let items = presets["items"].as_array().unwrap();
    for id in ["ac-table", "bc-table", "ab-table", "ac-head", "bc-head", "b-head-c-table"] {
        assert!(items.iter().any(|item| item["id"] == id), "{id}");
    }
    for item in items {
        let id = item["id"].as_str().unwrap();
        assert_eq!(app.put_machine(id, &item["profile"]).await.status(), 201, "{item}");
    }
}

/// A profile that says everything about programs that a profile can say.
fn with_programs() -> Value {
    let mut profile = ac_table();
    for (name, value) in [
        ("program_unit", json!("inch")),
        ("start_codes", json!("G1 G17 G90 G94")),
        (
            "work_offsets_mm",
            json!({"G55": [0, 0, 1.5], "G54": [-70, 40, 95], "G54.1 P3": [1, 2, 3], "G505": [0, 0, 0]}),
        ),
        ("max_feed_mm_per_min", json!(15_000)),
        ("block_time_ms", json!(0.4)),
        ("plane_solution", json!({"rule": "positive-first", "axis": "C"})),
        (
            "machine_coordinates",
            json!({"zero_mm": [0, 0, 640], "tool_length_counts": false, "reference_positions": [{"A": -90, "X": 12.5}]}),
        ),
        ("rs274_control", json!(true)),
        ("serial_number", json!("1138-5519")),
        ("asset_id", json!("EQ 4711 Ä")),
        ("calibration_due_days", json!(0.5)),
        ("calibration_limits", json!({"E_A0C_urad": 30, "E_X0C_um": 2.5})),
    ] {
        profile[name] = value;
    }
    profile
}

const OF_PROGRAMS: [&str; 12] = [
    "program_unit",
    "start_codes",
    "work_offsets_mm",
    "max_feed_mm_per_min",
    "block_time_ms",
    "plane_solution",
    "machine_coordinates",
    "rs274_control",
    "serial_number",
    "asset_id",
    "calibration_due_days",
    "calibration_limits",
];

#[tokio::test]
async fn what_a_profile_says_of_programs_is_kept_and_what_it_does_not_say_is_not_there() {
    let app = spawn().await;
    let first = etag(&app.put_machine("m", &ac_table()).await);
    let bare: Value = app.get("/v1/machines/m").await.json().await.unwrap();
    // Null says nothing either: the same revision.
    let mut nulls = ac_table();
    for name in OF_PROGRAMS {
        assert_eq!(bare.get(name), None, "{name}");
        nulls[name] = Value::Null;
    }
    assert_eq!(etag(&put_if(&app, "m", &nulls, "if-match", "*").await), first);

    let put = put_if(&app, "m", &with_programs(), "if-match", "*").await;
    assert_eq!(put.status(), StatusCode::OK);
    let second = etag(&put);
    let document: Value = put.json().await.unwrap();
    assert_eq!(document["revision"], 2);
    // The list of machines has the numbers by which a shop knows its machines.
    let list: Value = app.get("/v1/machines?limit=1").await.json().await.unwrap();
    assert_eq!(
        (&list["items"][0]["serial_number"], &list["items"][0]["asset_id"]),
        (&document["serial_number"], &document["asset_id"])
    );
    for name in OF_PROGRAMS {
        // Whole numbers come back as numbers with a point.
        let said = with_programs()[name].to_string().replace(".0", "");
        assert_eq!(document[name].to_string().replace(".0", ""), said, "{name}");
    }
    // In whatever order offsets are named, and zero whatever its sign.
    let mut turned = with_programs();
    turned["work_offsets_mm"] = serde_json::from_str(
        r#"{"G505": [-0.0, 0, 0], "G54.1 P3": [1, 2, 3], "G54": [-70, 40, 95], "G55": [0, -0.0, 1.5]}"#,
    )
    .unwrap();
    assert_eq!(etag(&put_if(&app, "m", &turned, "if-match", "*").await), second);
    // Without an axis the rule has none.
    turned["plane_solution"] = json!({"rule": "shortest"});
    let document: Value = put_if(&app, "m", &turned, "if-match", "*").await.json().await.unwrap();
    assert_eq!(document["plane_solution"], json!({"rule": "shortest", "axis": null}));
}

#[tokio::test]
async fn only_the_example_says_in_which_unit_its_programs_are() {
    let app = spawn().await;
    let example: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    assert_eq!(example["program_unit"], "mm");
    let presets: Value = app.get("/v1/machine-presets").await.json().await.unwrap();
    for preset in presets["items"].as_array().unwrap() {
        for name in OF_PROGRAMS {
            assert_eq!(preset["profile"].get(name), None, "{preset}");
        }
    }
}

#[tokio::test]
async fn every_fault_of_what_a_profile_says_of_programs_is_named() {
    let app = spawn().await;
    let cases: [(&str, Value, &[&str]); 26] = [
        ("max_feed_mm_per_min", json!(0), &["/max_feed_mm_per_min"]),
        ("max_feed_mm_per_min", json!(1_000_001), &["/max_feed_mm_per_min"]),
        ("block_time_ms", json!(0), &["/block_time_ms"]),
        ("block_time_ms", json!(1001), &["/block_time_ms"]),
        ("calibration_due_days", json!(0), &["/calibration_due_days"]),
        ("calibration_due_days", json!(-1), &["/calibration_due_days"]),
        ("calibration_due_days", json!(36_501), &["/calibration_due_days"]),
        ("serial_number", json!(""), &["/serial_number"]),
        ("serial_number", json!("a".repeat(201)), &["/serial_number"]),
        ("asset_id", json!("a\nb"), &["/asset_id"]),
        ("plane_solution", json!({"rule": "shortest", "axis": "B"}), &["/plane_solution/axis"]),
        ("plane_solution", json!({"rule": "shortest", "axis": "X"}), &["/plane_solution/axis"]),
        (
            "work_offsets_mm",
            json!({"G54": [0, 1e5, 1e6], "": [0, 0, 0]}),
            &["/work_offsets_mm/", "/work_offsets_mm/G54/2"],
        ),
        ("work_offsets_mm", json!({"G54": [0, 0, 0], "g54": [1, 0, 0]}), &["/work_offsets_mm/g54"]),
        (
            "work_offsets_mm",
            json!({"G54.1P03": [0, 0, 0], "G54.1 P3": [1, 0, 0]}),
            &["/work_offsets_mm/G54.1P03"],
        ),
        ("work_offsets_mm", json!({"a/b~c ": [0, 0, 0]}), &["/work_offsets_mm/a~1b~0c "]),
        (
            "work_offsets_mm",
            json!({"a".repeat(33): [0, 0, 0]}),
            &[&format!("/work_offsets_mm/{}", "a".repeat(33))],
        ),
        ("name", json!("a\tb"), &["/name"]),
        ("block_time_ms", json!(1e300), &["/block_time_ms"]),
        ("work_offsets_mm", json!({"G54": [-1e308, 0, 0]}), &["/work_offsets_mm/G54/0"]),
        ("machine_coordinates", json!({"zero_mm": [0, 0, 1e6]}), &["/machine_coordinates/zero_mm/2"]),
        (
            "machine_coordinates",
            json!({"zero_mm": [0, 0, 0], "reference_positions": [{"X": 0}, {"B": 0, "Z": 1e9}]}),
            &["/machine_coordinates/reference_positions/1/B", "/machine_coordinates/reference_positions/1/Z"],
        ),
        (
            "machine_coordinates",
            json!({"zero_mm": [0, 0, 0], "reference_positions": [{}, {}, {}, {}, {}]}),
            &["/machine_coordinates/reference_positions"],
        ),
        (
            "machine_coordinates",
            json!({"zero_mm": [0, 0, 0], "reference_positions": [{"x/": 0}]}),
            &["/machine_coordinates/reference_positions/0/x~1"],
        ),
        ("start_codes", json!("G1 G2"), &["/start_codes"]),
        ("start_codes", json!("G0 G1"), &["/start_codes"]),
    ];
    for (name, value, expected) in cases {
        let mut profile = with_programs();
        profile[name] = value;
        let body = problem(app.put_machine("m", &profile).await, "invalid-machine").await;
        assert_eq!(pointers(&body), expected, "{name}: {body}");
    }
    let many: serde_json::Map<_, _> = (0..401).map(|k| (format!("G{k}"), json!([0, 0, 0]))).collect();
    let cases: [(&str, Value, &str); 12] = [
        ("machine_coordinates", json!({}), "/machine_coordinates/zero_mm"),
        ("machine_coordinates", json!({"zero_mm": [0, 0]}), "/machine_coordinates/zero_mm"),
        ("machine_coordinates", json!({"zero_mm": [0, 0, 0], "length": true}), "/machine_coordinates/length"),
        ("program_unit", json!("cm"), "/program_unit"),
        ("work_offsets_mm", json!([0, 0, 0]), "/work_offsets_mm"),
        ("work_offsets_mm", json!({"G54": [0, 0]}), "/work_offsets_mm/G54"),
        ("work_offsets_mm", json!({"G54": null}), "/work_offsets_mm/G54"),
        ("work_offsets_mm", json!({"G54": {"x": 0}}), "/work_offsets_mm/G54"),
        ("work_offsets_mm", Value::Object(many), "/work_offsets_mm"),
        ("plane_solution", json!({"rule": "first"}), "/plane_solution/rule"),
        ("plane_solution", json!({"axis": "A"}), "/plane_solution/rule"),
        ("plane_solution", json!({"rule": "shortest", "axes": "A"}), "/plane_solution/axes"),
    ];
    for (name, value, pointer) in cases {
        let mut profile = with_programs();
        profile[name] = value;
        let body = problem(app.put_machine("m", &profile).await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{name}: {body}");
    }
    let twice = with_programs().to_string().replace("\"G54.1 P3\"", "\"G55\"");
    let request = app.client.put(app.url("/v1/machines/m")).header("content-type", "application/json");
    let body = problem(request.body(twice).send().await.unwrap(), "invalid-request").await;
    assert_eq!(pointers(&body), ["/work_offsets_mm/G55"]);
}

#[tokio::test]
async fn only_json_is_offered() {
    let app = spawn().await;
    for path in ["/v1/machines", "/v1/machines/example-ac-table", "/v1/machine-presets"] {
        let response = app.client.get(app.url(path)).header("accept", "text/html").send().await.unwrap();
        problem(response, "not-acceptable").await;
    }
}
