//! Posting of cutter location data over HTTP.

use serde_json::{Value, json};

use crate::support::{App, ac_table, kinds, pointers, problem, spawn, spawn_with};

const PATH: &str = "/v1/machines/example-ac-table/posting";

/// A pass along a flank whose tool axis leans and turns: 60 points.
const FLANK: &str = include_str!("../../docs/examples/flank.apt");
/// Tip and axis of every GOTO.
fn points(text: &str) -> Vec<[f64; 6]> {
    let rows = text.lines().filter_map(|line| line.strip_prefix("GOTO/"));
    rows.map(|row| {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    })
    .collect()
}

/// X Y Z A C at every point of a posted program.
fn words(program: &str) -> Vec<Value> {
    let mut joint = serde_json::Map::new();
    let mut joints = Vec::new();
    for line in program.lines().filter(|line| !line.starts_with('(')) {
        let mut moves = false;
        for letter in ["X", "Y", "Z", "A", "C"] {
            let Some((_, rest)) = line.split_once(letter) else { continue };
            let end = rest.find(|c: char| !c.is_ascii_digit() && !"+-.".contains(c)).unwrap_or(rest.len());
            joint.insert(letter.to_owned(), rest[..end].parse::<f64>().unwrap().into());
            moves = true;
        }
        // The first approach takes more than one block.
        if moves && joint.len() == 5 {
            joints.push(Value::Object(joint.clone()));
        }
    }
    joints
}

/// Two tools, a drilled hole, and a cut along points of the cutter's centre.
const WHOLE: &str = "LOADTL/3\nSPINDL/900,CLW\nRAPID\nGOTO/0,0,20\nCYCLE/DRILL,FEDTO,5,MMPM,200,RAPTO,3,RTRCTO,10\n\
                     GOTO/0,0,0\nCYCLE/OFF\nLOADTL/12\nSPINDL/500,CLW\nRAPID\nGOTO/8,0,9\nFEDRAT/70,MMPM\nCUTCOM/LEFT\n\
                     GOTO/8,0,2\nCUTCOM/OFF\n";

#[tokio::test]
async fn a_whole_file_is_posted_if_the_request_says_how() {
    let app = spawn().await;
    for (query, pointer) in [("tool_change=m6", "cutcom"), ("cutcom=centre", "tool_change")] {
        let body =
            problem(posted(&app, &format!("work_offset_mm=0,0,0&{query}"), WHOLE).await, "program-fault")
                .await;
        assert!(body.to_string().contains(pointer), "{body}");
    }
    let response = posted(&app, "work_offset_mm=0,0,0&tool_change=m6&cutcom=centre", WHOLE).await;
    assert_eq!(response.status(), 200);
    let program = response.text().await.unwrap();
    for line in ["T3 M6", "G43.4 H3", "T12 M6", "G43.4 H12", "S500 M3"] {
        assert!(program.lines().any(|written| written == line), "{line}\n{program}");
    }
}

async fn posted(app: &App, query: &str, program: &str) -> reqwest::Response {
    app.post_text(&format!("{PATH}?{query}"), "text/plain", program.to_owned()).await
}

#[tokio::test]
async fn points_become_a_program_whose_words_reach_them() {
    let app = spawn().await;
    let source = FLANK;
    let response = posted(&app, "interpolation=machine&work_offset_mm=12,-7,35", source).await;
    assert_eq!(response.status(), 200);
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let disposition = response.headers()["content-disposition"].to_str().unwrap().to_owned();
    assert!(disposition.ends_with("-posted.nc\""), "{disposition}");
    let program = response.text().await.unwrap();
    assert!(program.contains("G93") && program.contains("\nS8000 M3\n"), "{program}");
    // The words, put through the forward kinematics, give the points back to the rounding of four decimals.
    let joints = words(&program);
    let body = json!({"joints": joints, "work_offset_mm": [12, -7, 35]});
    let forward: Value =
        app.post_json("/v1/machines/example-ac-table/forward-kinematics", &body).await.json().await.unwrap();
    let wanted = points(source);
    let reached = forward["poses"].as_array().unwrap();
    assert_eq!(reached.len(), wanted.len());
    for (pose, point) in reached.iter().zip(&wanted) {
        let off = |names: [&str; 3], from: usize| {
            let parts =
                names.iter().enumerate().map(|(k, name)| pose[name].as_f64().unwrap() - point[from + k]);
            parts.map(|part| part * part).sum::<f64>().sqrt()
        };
        assert!(off(["x", "y", "z"], 0) < 1e-4, "{pose} {point:?}");
        assert!(off(["i", "j", "k"], 3) < 3e-6, "{pose} {point:?}");
    }
    let job: Value = app.get(&location).await.json().await.unwrap();
    assert_eq!((&job["operation"], &job["state"]), (&json!("posting"), &json!("succeeded")), "{job}");
    assert_eq!(job["parameters"]["linear_decimals"], 4);
    let report: Value = app.get(&format!("{location}/report")).await.json().await.unwrap();
    for member in ["machine_revision", "software_version", "input_sha256", "output_sha256"] {
        assert_eq!(report[member], job[member], "{member}");
    }
    assert_eq!((&report["dialect"], &report["output_dialect"]), (&json!("apt"), &json!("iso")));
    assert_eq!((&report["points"], &report["comments"]), (&json!(60), &json!(1)), "{report}");
    assert_eq!(report["post_words"], 1, "{report}");
    assert!(report["read_back"]["max_tip_um"].as_f64().unwrap() < 0.1, "{report}");
    assert!(report["between_points"]["max_tip_um"].as_f64().unwrap() > 1.0, "{report}");
    assert_eq!(report["warnings"][0]["kind"], "post_words_as_comments", "{report}");
    assert_eq!(app.get(&format!("{location}/program")).await.text().await.unwrap(), program);
    problem(app.get(&format!("{location}/plot")).await, "result-not-found").await;
    let drawing = app.client.post(app.url(PATH)).header("accept", "image/svg+xml").body(source);
    problem(drawing.send().await.unwrap(), "not-acceptable").await;
}

#[tokio::test]
async fn under_tcp_the_tips_stay_and_the_program_goes_on_into_compensation() {
    let app = spawn().await;
    let source = FLANK;
    let program =
        posted(&app, "length_offset_number=7&linear_decimals=3", source).await.text().await.unwrap();
    assert!(program.contains("G43.4 H7"), "{program}");
    for (joint, point) in words(&program).iter().zip(points(source)) {
        for (k, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
            assert!(
                (joint[letter].as_f64().unwrap() - point[k]).abs() <= 0.000_5 + 1e-9,
                "{joint} {point:?}"
            );
        }
    }
    let path = "/v1/machines/example-ac-table/compensation?location_errors=true";
    let request = app.client.post(app.url(path)).header("accept", "application/json").body(program);
    let report: Value = request.send().await.unwrap().json().await.unwrap();
    assert_eq!((&report["dialect"], &report["interpolation"]), (&json!("iso"), &json!("tcp")), "{report}");
}

#[tokio::test]
async fn a_form_asks_the_same_and_a_key_gives_the_same_job() {
    let app = spawn().await;
    let by_query = posted(&app, "rotary_decimals=5&start.A=0&start.C=360", FLANK).await;
    let by_query = by_query.text().await.unwrap();
    let mut jobs = Vec::new();
    for _ in 0..2 {
        let parameters = json!({"rotary_decimals": 5, "start": {"A": 0, "C": 360}});
        let form = reqwest::multipart::Form::new()
            .text("parameters", parameters.to_string())
            .part("program", reqwest::multipart::Part::text(FLANK).file_name("flank.apt"));
        let request = app.client.post(app.url(PATH)).header("idempotency-key", "once").multipart(form);
        let response = request.send().await.unwrap();
        let disposition = response.headers()["content-disposition"].to_str().unwrap();
        assert!(disposition.contains("\"flank-posted.nc\""), "{disposition}");
        jobs.push(response.headers()["location"].clone());
        assert_eq!(response.text().await.unwrap(), by_query);
    }
    assert_eq!(jobs[0], jobs[1]);
    let other = app.client.post(app.url(PATH)).header("idempotency-key", "once").body("GOTO/1,2,3\n");
    problem(other.send().await.unwrap(), "idempotency-key-reused").await;
}

#[tokio::test]
async fn what_does_not_fit_is_named_and_nothing_is_stored() {
    let app = spawn().await;
    for (query, expected) in [
        ("linear_decimals=0&rotary_decimals=7", &["/linear_decimals", "/rotary_decimals"][..]),
        ("arc_tolerance_um=0&dialect=iso", &["/arc_tolerance_um", "/dialect"]),
        ("start.A=0&start.B=0", &["/start/B", "/start/C"]),
        ("start.A=130&start.C=0", &["/start/A"]),
        (
            "work_offset_mm=0,1e9,0&length_offset_number=10000",
            &["/length_offset_number", "/work_offset_mm/1"],
        ),
        ("interpolation=joints", &["/interpolation"]),
        ("length_offset_number=0&tool_length_mm=-5", &["/length_offset_number", "/tool_length_mm"]),
        ("surface=1", &["/surface"]),
    ] {
        let found = problem(posted(&app, query, FLANK).await, "invalid-request").await;
        assert_eq!(pointers(&found), expected, "{query}: {found}");
    }
    let no_feed = "MULTAX/ON\nGOTO/1,1,1\nCYCLE/DRILL,5\nGOTO/3,1,1\nCYCLE/OFF\n";
    let found = problem(posted(&app, "", no_feed).await, "program-fault").await;
    assert_eq!(pointers(&found), ["/program/2", "/program/4"], "{found}");
    assert_eq!((&found["line"], &found["block"]), (&json!(2), &json!("GOTO/1,1,1")), "{found}");
    let iso = problem(posted(&app, "", "G1 X1 Y1 Z1 A0 C0 F100\n").await, "program-fault").await;
    assert_eq!(pointers(&iso), ["/program"]);
    assert!(iso["detail"].as_str().unwrap().contains("cutter location data"), "{iso}");
    let upside_down = "FEDRAT/100,MMPM\nGOTO/1,1,1,0,0,1\nGOTO/1,1,1,0,0.1,-1\n";
    let found = problem(posted(&app, "", upside_down).await, "out-of-travel").await;
    assert_eq!((&found["line"], &found["block"]), (&json!(3), &Value::Null), "{found}");
    assert_eq!(app.files(), (0, 0));
    let jobs: Value = app.get("/v1/jobs").await.json().await.unwrap();
    assert_eq!(jobs["items"], json!([]));
}

#[tokio::test]
async fn a_posting_that_would_cost_too_much_is_refused_before_it_begins() {
    let app = spawn_with(|settings| settings.max_cost_s = 1e-4).await;
    let found = problem(posted(&app, "", FLANK).await, "too-costly").await;
    assert!(found["detail"].as_str().unwrap().contains("0.0001"), "{found}");
}

#[tokio::test]
async fn a_cut_that_leaves_its_path_between_two_points_is_refused_with_its_line() {
    let app = spawn().await;
    // One millimetre apart, but the table has to turn by 90°: in machine coordinates the tip swings centimetres off.
    let text =
        "UNITS/MM\nMULTAX/ON\nFEDRAT/1200,MMPM\nGOTO/100,0,0,0.3,0,0.9539392\nGOTO/101,0,0,0,0.3,0.9539392\n";
    let refusal =
        problem(posted(&app, "interpolation=machine&work_offset_mm=0,0,0", text).await, "program-fault")
            .await;
    assert_eq!((&refusal["line"], pointers(&refusal)), (&json!(5), vec!["/program/5".to_owned()]));
    // The control keeps the tip on its line.
    assert_eq!(posted(&app, "interpolation=tcp", text).await.status(), 200);
}

#[tokio::test]
async fn what_the_machine_should_have_done_and_is_a_comment_is_counted_with_its_line() {
    let app = spawn().await;
    let text = "FEDRAT/100,MMPM\nSPINDL/SFM,90,CLW\nGOTO/1,1,1\nCOOLNT/THRU\nSTOP\nGOTO/2,1,1\n";
    let request = app.client.post(app.url(PATH)).header("accept", "application/json").body(text);
    let report: Value = request.send().await.unwrap().json().await.unwrap();
    assert_eq!((&report["comments"], &report["post_words"]), (&json!(2), &json!(1)), "{report}");
    let warnings = report["warnings"].as_array().unwrap();
    let told = warnings.iter().find(|warning| warning["kind"] == "post_words_not_done").unwrap();
    assert_eq!((&told["count"], &told["line"]), (&json!(2), &json!(2)), "{report}");
}

#[tokio::test]
async fn the_unit_and_the_largest_feed_of_the_profile_hold_for_circles_and_cuts() {
    let app = spawn().await;
    let mut profile = ac_table();
    profile["program_unit"] = json!("inch");
    profile["max_feed_mm_per_min"] = json!(15_000);
    assert_eq!(app.put_machine("inches", &profile).await.status(), 201);
    let text = "FEDRAT/10,PERMIN\nGOTO/2,0,0\nCIRCLE/1,0,0,0,0,1\nGOTO/0,0,0\n";
    let by_profile =
        app.operate("inches", "posting", "work_offset_mm=0,0,0", text, "*/*").await.text().await.unwrap();
    let by_request = posted(&app, "unit=inch", text).await.text().await.unwrap();
    let by_text = posted(&app, "", &format!("UNITS/INCHES\n{text}")).await.text().await.unwrap();
    assert!(by_text.matches("\nX").count() > 20 && by_text.contains("X0.0000 Y0.0000"), "{by_text}");
    assert_eq!((&by_request, &by_profile), (&by_text, &by_text));
    let fast = text.replace("FEDRAT/10", "FEDRAT/99999999");
    let found = problem(
        app.operate("inches", "posting", "work_offset_mm=0,0,0", &fast, "*/*").await,
        "program-fault",
    )
    .await;
    assert!(found["detail"].as_str().unwrap().contains("max_feed_mm_per_min"), "{found}");
    assert_eq!(found["line"], 2, "{found}");
}

#[tokio::test]
async fn a_program_without_length_and_without_retract_is_told_of() {
    let app = spawn().await;
    let query = "interpolation=machine&work_offset_mm=0,0,0";
    let told = |query: String| {
        let request = app.client.post(app.url(&format!("{PATH}?{query}")));
        let request = request.header("accept", "application/json").body(FLANK);
        async move {
            let report: Value = request.send().await.unwrap().json().await.unwrap();
            kinds(&report)
        }
    };
    let without = told(query.to_owned()).await;
    assert!(["length_left_out", "end_after_cut"].iter().all(|kind| without.contains(&(*kind).to_owned())));
    let with = told(format!("{query}&length_offset_number=4")).await;
    assert!(!with.contains(&"length_left_out".to_owned()), "{with:?}");
}
