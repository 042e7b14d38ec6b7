//! What is understood of a program, motion by motion, as JSON and as a table.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::support::{App, ac_table, pointers, problem, program_form, spawn};

const OPERATION: &str = "interpretation";

/// Inches, two offsets, a reference run, an arc, a call, and what cannot be followed after it.
const PROGRAM: &str = "G90 G20 G94
G54
T5 M6
G0 X0. Y0. Z1. A0. C0.
G1 X1. A25. C60. F10.
G55
X2.
G28 Z0.
G54
G0 X0. Y0. Z1. A0. C0.
G2 X2. Y2. I0. J2.
G65 P1
X1.
M30
";

async fn machines() -> App {
    let app = spawn().await;
    app.put_machine("m", &ac_table()).await;
    let mut bc = ac_table();
    bc["kinematics"]["rotary_axes"][0]["name"] = json!("B");
    bc["kinematics"]["rotary_axes"][0]["direction"] = json!([0, 1, 0]);
    app.put_machine("bc", &bc).await;
    app
}

fn motion(answer: &Value, line: u64) -> &Value {
    let found = answer["motions"].as_array().unwrap().iter().find(|motion| motion["line"] == line);
    assert!(found.is_some(), "line {line}: {answer}");
    found.unwrap()
}

/// A loop, a subprogram behind the end of the program, and a canned cycle.
const RUN: &str = "G90 G21 G94 G17
G54
G0 X0. Y0. Z50. A0. C0.
#1=0
o1 while [#1 LT 2]
#1=[#1+1]
G1 X#1 F100.
o1 endwhile
M98 P2000
G98 G81 X5. Z-5. R3. F100.
G80
M30
O2000
G1 Y7.
M99
";

#[tokio::test]
async fn a_program_is_told_as_it_runs_and_a_program_that_never_ends_is_refused() {
    let app = machines().await;
    let answer = app.report("m", OPERATION, "work_offsets_mm.G54=0,0,0", RUN).await;
    assert_eq!(answer["left_alone"], json!([]), "{answer}");
    let told: Vec<_> = answer["motions"]
        .as_array()
        .unwrap()
        .iter()
        .map(|motion| (motion["line"].as_u64().unwrap(), motion["joints"]["X"].as_f64().unwrap()))
        .collect();
    assert_eq!(told, [(3, 0.0), (7, 1.0), (7, 2.0), (14, 2.0), (10, 5.0), (10, 5.0), (10, 5.0), (10, 5.0)]);
    let levels: Vec<_> =
        answer["motions"].as_array().unwrap().iter().map(|motion| motion["joints"]["Z"].as_f64()).collect();
    assert_eq!(levels[4..], [50.0, 3.0, -5.0, 50.0].map(Some));
    let endless = RUN.replace("[#1 LT 2]", "[1]").replace("G1 X#1 F100.\n", "");
    let refused = app.operate("m", OPERATION, "work_offsets_mm.G54=0,0,0", &endless, "*/*").await;
    let problem = problem(refused, "program-fault").await;
    let text = problem.to_string();
    assert!(text.contains("250000 blocks") && text.contains("line 7"), "{text}");
}

#[tokio::test]
async fn motions_are_told_in_millimetres_and_degrees_whatever_the_programs_unit() {
    let app = machines().await;
    let answer = app.report("m", OPERATION, "work_offsets_mm.G54=1,2,3", PROGRAM).await;
    let rapid = motion(&answer, 4);
    assert_eq!(
        rapid,
        &json!({"line": 4, "file": null, "kind": "rapid", "joints": {"X": 0.0, "Y": 0.0, "Z": 25.4, "A": 0.0, "C": 0.0},
            "tip_mm": rapid["tip_mm"], "axis": [0.0, 0.0, 1.0], "feed_mm_per_min": null, "tool_number": 5, "work_offset": "G54"})
    );
    assert!((rapid["tip_mm"][2].as_f64().unwrap() - 25.4).abs() < 1e-9);
    let cut = motion(&answer, 5);
    assert_eq!((&cut["kind"], &cut["feed_mm_per_min"]), (&json!("linear"), &json!(254.0)));
    assert_eq!(cut["joints"], json!({"X": 25.4, "Y": 0.0, "Z": 25.4, "A": 25.0, "C": 60.0}));
    // The tip and the axis are those of the kinematics.
    let request = json!({"joints": [cut["joints"]], "work_offset_mm": [1, 2, 3]});
    let forward = app.post_json("/v1/machines/m/forward-kinematics", &request).await;
    let pose = &forward.json::<Value>().await.unwrap()["poses"][0];
    for (place, names) in [("tip_mm", ["x", "y", "z"]), ("axis", ["i", "j", "k"])] {
        for (index, name) in names.iter().enumerate() {
            let (told, computed) = (cut[place][index].as_f64().unwrap(), pose[name].as_f64().unwrap());
            assert!((told - computed).abs() < 1e-9, "{place} {name}: {told} and {computed}");
        }
    }
    // A quarter turn about Z, anti-clockwise seen against it: G2 turns the other way.
    let arc = motion(&answer, 11);
    assert_eq!((&arc["kind"], &arc["joints"]["X"]), (&json!("arc"), &json!(50.8)));
    let centre: Vec<f64> = arc["centre_mm"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!((centre[0]).abs() < 1e-9 && (centre[1] - 50.8).abs() < 1e-9, "{arc}");
    let turns = arc["turns"].as_f64().unwrap() * arc["normal"][2].as_f64().unwrap();
    assert!((turns + 0.75).abs() < 1e-9, "{arc}");
    for member in ["centre_mm", "normal", "turns"] {
        assert!(cut.get(member).is_none());
    }
    assert_eq!(
        (&answer["resolved"]["unit"], &answer["resolved"]["unit_stated_by"]),
        (&json!("inch"), &json!("program"))
    );
    assert_eq!(
        (&answer["dialect"], &answer["machine_revision"], &answer["blocks"]),
        (&json!("iso"), &json!(1), &json!(14))
    );
}

#[tokio::test]
async fn a_program_for_osp_is_read_as_that_where_the_caller_says_so() {
    let app = machines().await;
    let program = "OPART\nG21 G90 G94\nT5 M6\nG0 X0. Y0. A0. C0.\nG56 Z50. H1\nG1 X10. F500.\nM02\n%\n";
    let told = |answer: &Value| (answer["dialect"].clone(), motion(answer, 6)["work_offset"].clone());
    let found = app.report("m", OPERATION, "", program).await;
    assert_eq!(told(&found), (json!("iso"), json!("G56")));
    let stated = app.report("m", OPERATION, "dialect=okuma", program).await;
    assert_eq!(told(&stated), (json!("okuma"), Value::Null));
    assert_eq!(motion(&stated, 6)["joints"], json!({"X": 10.0, "Y": 0.0, "Z": 50.0, "A": 0.0, "C": 0.0}));
    let shown = app.report("m", OPERATION, "", &format!("$PART.MIN%\n{program}")).await;
    assert_eq!(shown["dialect"], "okuma");
}

#[tokio::test]
async fn what_is_not_known_is_null_and_what_is_left_alone_says_why() {
    let app = machines().await;
    // Without an offset nothing is refused: where the tip is, is not known.
    let answer = app.report("m", OPERATION, "", PROGRAM).await;
    let cut = motion(&answer, 5);
    assert_eq!((&cut["tip_mm"], cut["axis"].is_array()), (&Value::Null, true), "{cut}");
    let elsewhere = motion(&answer, 7);
    assert_eq!((&elsewhere["work_offset"], &elsewhere["tip_mm"]), (&json!("G55"), &Value::Null));
    let unknown = app.report("m", OPERATION, "", "G21 G90\nG1 X1.000 F100\nA5.000\nM30\n").await;
    assert_eq!(motion(&unknown, 2)["joints"], json!({"X": 1.0, "Y": null, "Z": null, "A": null, "C": null}));
    assert_eq!((&motion(&unknown, 3)["tip_mm"], &motion(&unknown, 3)["axis"]), (&Value::Null, &Value::Null));
    // With a start they are.
    let start = "start.X=0&start.Y=0&start.Z=0&start.A=0&start.C=0&work_offset_mm=0,0,0";
    let known = app.report("m", OPERATION, start, "G21 G90\nG1 X1.000 F100\nA5.000\nM30\n").await;
    assert!(motion(&known, 3)["tip_mm"].is_array() && motion(&known, 3)["axis"].is_array(), "{known}");

    let left: Vec<_> = answer["left_alone"].as_array().unwrap().iter().map(|left| &left["line"]).collect();
    assert_eq!(json!(left), json!([8, 12, 13]), "{answer}");
    for (index, reason) in ["reference position", "subprogram", "not known"].iter().enumerate() {
        let said = answer["left_alone"][index]["reason"].as_str().unwrap();
        assert!(said.contains(reason), "{said}");
    }
    // Every motion is told or left alone, never both.
    let lines: Vec<_> = answer["motions"].as_array().unwrap().iter().map(|motion| &motion["line"]).collect();
    assert_eq!(json!(lines), json!([4, 5, 7, 10, 11]));
}

#[tokio::test]
async fn the_table_has_the_rows_of_the_answer_under_the_letters_of_the_profile() {
    let app = machines().await;
    for (machine, letter) in [("m", "A"), ("bc", "B")] {
        let program = PROGRAM.replace('A', letter);
        for query in ["", "work_offsets_mm.G54=1,2,3&work_offsets_mm.G55=0,0,0"] {
            let answer = app.report(machine, OPERATION, query, &program).await;
            let response = app.operate(machine, OPERATION, query, &program, "text/csv").await;
            assert_eq!(
                (response.status(), response.headers()["content-type"].to_str().unwrap()),
                (StatusCode::OK, "text/csv")
            );
            let table = response.text().await.unwrap();
            let mut lines = table.lines();
            let head = format!(
                "line,file,kind,X,Y,Z,{letter},C,tip_x_mm,tip_y_mm,tip_z_mm,axis_i,axis_j,axis_k,feed_mm_per_min,tool_number,work_offset"
            );
            assert_eq!(lines.next(), Some(head.as_str()));
            let motions = answer["motions"].as_array().unwrap();
            assert_eq!(lines.clone().count(), motions.len());
            for (line, motion) in lines.zip(motions) {
                let mut cells = vec![&motion["line"], &motion["file"], &motion["kind"]];
                cells.extend(["X", "Y", "Z", letter, "C"].map(|name| &motion["joints"][name]));
                cells.extend((0..3).map(|index| &motion["tip_mm"][index]));
                cells.extend((0..3).map(|index| &motion["axis"][index]));
                cells.extend(["feed_mm_per_min", "tool_number", "work_offset"].map(|name| &motion[name]));
                let text = |cell: &&Value| match cell {
                    Value::Null => String::new(),
                    Value::String(text) => text.clone(),
                    other => other.to_string(),
                };
                assert_eq!(line, cells.iter().map(text).collect::<Vec<_>>().join(","), "{machine} {query}");
            }
        }
    }
}

#[tokio::test]
async fn a_tilted_plane_is_followed_where_the_profile_says_how_the_control_turns_to_it() {
    let app = machines().await;
    let mut stated = ac_table();
    stated["plane_solution"] = json!({"rule": "negative-first", "axis": "A"});
    app.put_machine("stated", &stated).await;
    let program = "G90 G21 G94 G17\nG54\nG0 X0. Y0. Z0. A0. C0.\nG68.2 X10. Y20. Z30. I90. J30. K0.\nG53.1\nG0 X1. Y2. Z4.\nG69\nM30\n";
    let answer = app.report("stated", OPERATION, "", program).await;
    let moved = motion(&answer, 6);
    let number = |value: &Value| value.as_f64().unwrap();
    // The normal is (sin 30, 0, cos 30).
    let tip = [10.0 - 2.0 * 0.75_f64.sqrt() + 2.0, 21.0, 30.0 + 1.0 + 4.0 * 0.75_f64.sqrt()];
    for (k, at) in tip.into_iter().enumerate() {
        assert!((number(&moved["tip_mm"][k]) - at).abs() < 1e-9, "{moved}");
    }
    let turned = [number(&moved["joints"]["A"]) + 30.0, number(&moved["joints"]["C"]) + 90.0];
    assert!(turned.iter().all(|off| off.abs() < 1e-9), "{moved}");
    // Where the profile says nothing, the report says what to state.
    let answer = app.report("m", OPERATION, "", program).await;
    let told = answer["left_alone"].as_array().unwrap().last().unwrap();
    assert_eq!(told["line"], 6, "{answer}");
    assert!(told["reason"].as_str().unwrap().contains("profile does not decide"), "{told}");
}

#[tokio::test]
async fn under_tcp_the_words_are_those_of_the_tip() {
    let app = machines().await;
    let program = "G90 G21 G94\nG43.4 H1\nG1 X1.000 Y2.000 Z3.000 A25.000 C60.000 F100\nM30\n";
    let answer = app.report("m", OPERATION, "", program).await;
    let cut = motion(&answer, 3);
    assert_eq!(cut["joints"], json!({"X": 1.0, "Y": 2.0, "Z": 3.0, "A": 25.0, "C": 60.0}));
    assert_eq!(cut["tip_mm"], json!([1.0, 2.0, 3.0]), "{cut}");
    let machine = app.report("m", OPERATION, "interpolation=machine&work_offset_mm=0,0,0", program).await;
    assert_ne!(motion(&machine, 3)["tip_mm"], json!([1.0, 2.0, 3.0]));
}

#[tokio::test]
async fn a_form_asks_the_same_nothing_is_kept_and_what_is_wrong_is_named() {
    let app = machines().await;
    let path = app.url("/v1/machines/m/interpretation");
    let parameters = json!({"work_offsets_mm": {"G54": [1, 2, 3]}});
    let form = app
        .client
        .post(&path)
        .multipart(program_form(&parameters, PROGRAM, "part 7.nc"))
        .send()
        .await
        .unwrap();
    let by_query = app.report("m", OPERATION, "work_offsets_mm.G54=1,2,3", PROGRAM).await;
    assert_eq!(form.json::<Value>().await.unwrap(), by_query);
    let request = app.client.post(&path).header("accept", "text/csv");
    let table = request.multipart(program_form(&parameters, PROGRAM, "part 7.nc")).send().await.unwrap();
    let name = table.headers()["content-disposition"].to_str().unwrap();
    assert!(name.contains("part_7-interpretation.csv"), "{name}");
    for (query, pointer) in [
        ("start.B=1", "/start/B"),
        ("work_offset_mm=1,2,1e9", "/work_offset_mm/2"),
        ("work_offsets_mm.G53=0,0,0", "/work_offsets_mm/G53"),
        ("start.X=1e12", "/start/X"),
        ("feed_mm_per_min=-1", "/feed_mm_per_min"),
        ("tool_length_mm=1e9", "/tool_length_mm"),
        ("tool_radius_mm=5", "/tool_radius_mm"),
        ("unit=cm", "/unit"),
    ] {
        let body = problem(app.operate("m", OPERATION, query, PROGRAM, "*/*").await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{query}");
    }
    problem(app.operate("m", OPERATION, "", PROGRAM, "image/svg+xml").await, "not-acceptable").await;
    problem(app.operate("nobody", OPERATION, "", PROGRAM, "*/*").await, "machine-not-found").await;
    assert_eq!(app.get("/v1/jobs").await.json::<Value>().await.unwrap()["items"], json!([]));
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn it_asks_for_the_scope_compute_on_that_machine() {
    let mut app = machines().await;
    app.close().await;
    let keys = [
        (app.new_key(&["read", "machines", "calibrations"], None).await, 403),
        (app.new_key(&["compute"], Some(&["m"])).await, 200),
        (app.new_key(&["compute"], Some(&["bc"])).await, 404),
    ];
    for (key, status) in keys {
        let client = reqwest::Client::builder().no_proxy().build().unwrap();
        let request = client.post(app.url("/v1/machines/m/interpretation")).bearer_auth(key).body(PROGRAM);
        assert_eq!(request.send().await.unwrap().status(), status);
    }
}
