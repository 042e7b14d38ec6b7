//! Virtual cutting over HTTP.

use std::fmt::Write;

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::support::{App, pointers, problem, spawn, spawn_with, unstamped};

const PATH: &str = "/v1/machines/example-ac-table/verification";
/// Passes this far apart [mm], by a ball of this radius [mm].
const STEPOVER_MM: f64 = 1.0;
const RADIUS_MM: f64 = 5.0;
/// r − √(r² − (D/2)²) of these [µm].
const SCALLOP_UM: f64 = 25.062_814_46;
/// A sample lies within a quarter of a hundredth of a step-over from where passes meet: the scallop's slope there is
/// 0.1, and the needles are 0.07 mm apart [µm].
const BESIDE_THE_CUSP_UM: f64 = 4.0;

/// Parallel passes over the top of a plate 40 × 10 mm, back and forth, tip at z = 0.
fn plate() -> String {
    let mut text = "G90 G21 G94\nG0 X-30.000 Y-6.000 Z10.000 A0.000 C0.000\n".to_owned();
    for pass in 0..=12 {
        let (y, side) = (-6.0 + STEPOVER_MM * f64::from(pass), if pass % 2 == 0 { 1.0 } else { -1.0 });
        writeln!(text, "G0 X{:.3} Y{y:.3} Z10.000\nG1 Z0.000 F2000\nX{:.3}", -30.0 * side, 30.0 * side)
            .unwrap();
    }
    text + "G0 Z50.000\nM30\n"
}

fn parameters() -> Value {
    json!({
        "tool": {"radius_mm": RADIUS_MM},
        "surface": {"kind": "plane", "length_mm": 40, "width_mm": 10},
        "samples": 20_000
    })
}

async fn post(app: &App, parameters: &Value, program: &str, accept: &str) -> reqwest::Response {
    let form = Form::new()
        .text("parameters", parameters.to_string())
        .part("program", Part::text(program.to_owned()).file_name("plate.nc"));
    app.client.post(app.url(PATH)).header("accept", accept).multipart(form).send().await.unwrap()
}

#[tokio::test]
async fn parallel_passes_leave_their_scallops_and_every_face_of_the_job_says_so() {
    let app = spawn().await;
    let response = post(&app, &parameters(), &plate(), "application/json").await;
    assert_eq!(response.status(), 200);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let report: Value = response.json().await.unwrap();
    assert_eq!((&report["samples"], &report["uncut"]), (&json!(20_000), &json!(0)));
    let max_um = report["max_excess"]["residual_um"].as_f64().unwrap();
    assert!(max_um < SCALLOP_UM + 0.5 && max_um > SCALLOP_UM - BESIDE_THE_CUSP_UM, "{max_um}");
    assert_eq!((&report["excess_over_limit"], &report["gouge_over_limit"]), (&json!(0), &json!(0)));
    assert!(report["convergence"]["max_change_um"].as_f64().unwrap() < 0.5);
    let counted: u64 =
        report["histogram"]["counts"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(counted, 20_000);

    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["operation"], "verification");
    assert_eq!(document["output_sha256"], report["residuals_sha256"]);
    assert_eq!(document["surface_sha256"], Value::Null);
    let table = app.get(&format!("{job}/residuals")).await;
    assert_eq!(table.headers()["content-type"], "text/csv");
    assert_eq!(table.headers()["content-disposition"], "attachment; filename=\"plate-residuals.csv\"");
    let table = table.text().await.unwrap();
    assert_eq!(table.lines().count(), 20_001);
    let worst =
        table.lines().nth(1 + usize::try_from(report["max_excess"]["sample"].as_u64().unwrap()).unwrap());
    let cells: Vec<&str> = worst.unwrap().split(',').collect();
    assert_eq!(cells[6], report["max_excess"]["residual_um"].to_string());
    assert_eq!(cells[7], report["max_excess"]["line"].to_string());
    assert_eq!(post(&app, &parameters(), &plate(), "text/csv").await.text().await.unwrap(), table);
    let plot = app.get(&format!("{job}/plot")).await.text().await.unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("seen from +Z") && plot.contains("residual"), "{plot}");
    assert_eq!(post(&app, &parameters(), &plate(), "image/svg+xml").await.text().await.unwrap(), plot);
    problem(app.get(&format!("{job}/program")).await, "result-not-found").await;
}

/// The same passes by a ball whose axis leans by 45°, with TCP and contact words; and that axis.
async fn leaning(app: &App) -> (String, [f64; 3]) {
    let joints = json!({"joints": [{"X": 0, "Y": 0, "Z": 0, "A": -45, "C": 0}]});
    let path = "/v1/machines/example-ac-table/forward-kinematics";
    let pose: Value = app.post_json(path, &joints).await.json().await.unwrap();
    let axis = ["i", "j", "k"].map(|name| pose["poses"][0][name].as_f64().unwrap());
    let mut text = "G90 G21 G94\nG43.4 H1\n".to_owned();
    let mut point = |code: &str, x: f64, y: f64| {
        let [u, v, w] = [0, 1, 2].map(|k| [x, y, RADIUS_MM][k] - RADIUS_MM * axis[k]);
        writeln!(text, "{code} X{u:.4} Y{v:.4} Z{w:.4} A-45.0000 C0.0000 U{x:.4} V{y:.4} W0.0000").unwrap();
    };
    for pass in 0..=12 {
        let (y, side) = (-6.0 + STEPOVER_MM * f64::from(pass), if pass % 2 == 0 { 1.0 } else { -1.0 });
        point("G1 F2000", -24.0 * side, y);
        point("G1", 24.0 * side, y);
    }
    (text + "M30\n", axis)
}

const WEAR: &str =
    "/v1/machines/example-ac-table/wear-compensation?nominal_tool.radius_mm=5&actual_tool.radius_mm=4";

#[tokio::test]
async fn a_worn_ball_leaves_more_and_the_compensated_program_what_the_nominal_one_did() {
    let app = spawn().await;
    let (text, axis) = leaning(&app).await;
    let cut = async |radius_mm: f64, text: &str| -> f64 {
        let mut asked = parameters();
        asked["tool"]["radius_mm"] = json!(radius_mm);
        let report: Value = post(&app, &asked, text, "application/json").await.json().await.unwrap();
        assert_eq!(report["uncut"], 0, "{report}");
        report["max_excess"]["residual_um"].as_f64().unwrap()
    };
    let compensated = app.post_text(WEAR, "text/plain", text.clone()).await;
    assert_eq!(compensated.status(), 200);
    let compensated = compensated.text().await.unwrap();
    let [sharp_um, worn_um, mended_um] =
        [cut(5.0, &text).await, cut(4.0, &text).await, cut(4.0, &compensated).await];
    // (r − r′)(1 − n·t), and the scallops of the smaller ball on top: r′ − √(r′² − (D/2)²).
    let (offset_um, scallop_um) = (1000.0 * (1.0 - axis[2]), 31.373);
    assert!((sharp_um - SCALLOP_UM).abs() < BESIDE_THE_CUSP_UM, "{sharp_um}");
    assert!((worn_um - offset_um - scallop_um).abs() < BESIDE_THE_CUSP_UM, "{worn_um} {offset_um}");
    assert!((mended_um - scallop_um).abs() < BESIDE_THE_CUSP_UM, "{mended_um}");
}

#[tokio::test]
async fn a_query_and_a_form_ask_the_same_and_a_key_gives_the_same_job() {
    let app = spawn().await;
    let query = "tool.radius_mm=5&surface.kind=plane&surface.length_mm=40&surface.width_mm=10&samples=20000";
    let url = app.url(&format!("{PATH}?{query}"));
    let keyed = || app.client.post(&url).header("idempotency-key", "one").body(plate());
    let (first, again) = (keyed().send().await.unwrap(), keyed().send().await.unwrap());
    assert_eq!(first.headers()["location"], again.headers()["location"]);
    let (by_query, again): (Value, Value) = (first.json().await.unwrap(), again.json().await.unwrap());
    assert_eq!(by_query, again);
    let by_form: Value = post(&app, &parameters(), &plate(), "application/json").await.json().await.unwrap();
    assert_eq!(by_form, by_query);
    let other = app.client.post(&url).header("idempotency-key", "one").body(plate() + "\n");
    problem(other.send().await.unwrap(), "idempotency-key-reused").await;
}

#[tokio::test]
async fn bad_parameters_of_a_verification_are_all_named() {
    let app = spawn().await;
    let with = |change: Value| {
        let mut asked = parameters();
        for (name, value) in change.as_object().unwrap() {
            asked[name] = value.clone();
        }
        asked
    };
    for (asked, expected) in [
        (json!({}), vec!["/surface", "/tool"]),
        (json!({"tool": {"radius_mm": 5}}), vec!["/surface"]),
        (with(json!({"tool": {"radius_mm": 0}})), vec!["/tool/radius_mm"]),
        (with(json!({"tool": {"radius_mm": 5, "length_mm": 80}})), vec!["/tool/length_mm"]),
        (with(json!({"samples": 0})), vec!["/samples"]),
        (with(json!({"samples": 2_000_001})), vec!["/samples"]),
        (with(json!({"cutting_length_mm": 3})), vec!["/cutting_length_mm"]),
        (
            with(json!({"stock_mm": 0, "limit_um": 1e9, "resolution_um": -1, "chordal_tolerance_um": 5})),
            vec!["/chordal_tolerance_um", "/stock_mm", "/resolution_um", "/limit_um"],
        ),
        (with(json!({"surface": {"kind": "plane", "length_mm": 1}})), vec!["/surface/width_mm"]),
        (with(json!({"surface": {"kind": "torus"}})), vec!["/surface/kind"]),
        (with(json!({"work_offset_mm": [0, 1e9, 0]})), vec!["/work_offset_mm/1"]),
        (with(json!({"tolerance_um": 1})), vec!["/tolerance_um"]),
    ] {
        let body = problem(post(&app, &asked, &plate(), "application/json").await, "invalid-request").await;
        assert_eq!(pointers(&body), expected, "{asked}: {body}");
    }
    let faulty = plate().replace("X30.000\n", "X1.2.3\n");
    problem(post(&app, &parameters(), &faulty, "application/json").await, "program-fault").await;
    problem(post(&app, &parameters(), "G90\nM30\n", "application/json").await, "program-fault").await;
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn work_that_would_cost_too_much_is_refused_before_it_begins() {
    let app = spawn_with(|settings| settings.max_cost_s = 1e-6).await;
    problem(post(&app, &parameters(), &plate(), "application/json").await, "too-costly").await;
    assert_eq!(app.files(), (0, 0));
}

/// The top of the plate as a text of two facets, corners in the order given.
fn stl(corners: [[f64; 3]; 4]) -> String {
    let mut text = "solid plate\n".to_owned();
    for facet in [[0, 1, 2], [0, 2, 3]] {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in facet.map(|k| corners[k]) {
            writeln!(text, "vertex {x} {y} {z}").unwrap();
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid plate\n"
}

const TOP: [[f64; 3]; 4] = [[-20.0, -5.0, 0.0], [20.0, -5.0, 0.0], [20.0, 5.0, 0.0], [-20.0, 5.0, 0.0]];

async fn post_with_surface(app: &App, parameters: &Value, surface: Vec<u8>) -> reqwest::Response {
    let form = Form::new()
        .text("parameters", parameters.to_string())
        .part("surface", Part::bytes(surface).file_name("plate.stl"))
        .part("program", Part::text(plate()).file_name("plate.nc"));
    app.client.post(app.url(PATH)).multipart(form).send().await.unwrap()
}

#[tokio::test]
async fn an_uploaded_surface_is_the_same_as_its_formula_and_is_kept() {
    let app = spawn().await;
    let asked = json!({"tool": {"radius_mm": RADIUS_MM}, "samples": 20_000});
    let response = post_with_surface(&app, &asked, stl(TOP).into_bytes()).await;
    assert_eq!(response.status(), 200);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let report: Value = response.json().await.unwrap();
    let max_um = report["max_excess"]["residual_um"].as_f64().unwrap();
    assert!((max_um - SCALLOP_UM).abs() < BESIDE_THE_CUSP_UM, "{max_um}");
    let mesh = &report["surface_mesh"];
    assert_eq!(
        (&mesh["triangles"], &mesh["vertices"], &mesh["open_edges"]),
        (&json!(2), &json!(4), &json!(4))
    );
    assert_eq!((&mesh["volume_mm3"], &report["area_mm2"]), (&Value::Null, &json!(400.0)));
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["surface_sha256"], report["surface_sha256"]);
    assert_eq!(app.files().0, 3, "program, surface, residuals");
    // In inches, and with another unit said.
    let small = TOP.map(|corner| corner.map(|x| x / 25.4));
    let inches = json!({"tool": {"radius_mm": RADIUS_MM}, "samples": 20_000, "surface_unit_mm": 25.4});
    let again: Value = post_with_surface(&app, &inches, stl(small).into_bytes()).await.json().await.unwrap();
    assert!((again["area_mm2"].as_f64().unwrap() - 400.0).abs() < 1e-9);
}

#[tokio::test]
async fn a_surface_that_is_none_is_refused_and_nothing_is_kept() {
    let app = spawn_with(|settings| settings.max_surface_memory_bytes = 64 << 20).await;
    let asked = json!({"tool": {"radius_mm": RADIUS_MM}});
    let turned = stl(TOP).replacen("vertex -20 -5 0\nvertex 20 -5 0", "vertex 20 -5 0\nvertex -20 -5 0", 1);
    for (surface, words) in [
        (Vec::new(), "neither a binary"),
        (b"ply\nformat ascii".to_vec(), "solid"),
        (b"solid nothing\nendsolid nothing\n".to_vec(), "no facet"),
        (stl(TOP).replace("vertex 20 5 0", "vertex 20 5").into_bytes(), "line"),
        (stl(TOP).replace("vertex 20 5 0", "vertex 20 5 nan").into_bytes(), "finite"),
        (turned.into_bytes(), "opposite orientation"),
        (stl(TOP).as_bytes()[..200].to_vec(), "endsolid"),
        ([vec![0; 80], 1_u32.to_le_bytes().to_vec(), vec![0; 49]].concat(), "the file ends after 0"),
    ] {
        let body = problem(post_with_surface(&app, &asked, surface).await, "invalid-request").await;
        assert_eq!(pointers(&body), ["/surface"], "{body}");
        assert!(body["errors"][0]["detail"].as_str().unwrap().contains(words), "{words}: {body}");
    }
    // Both told and uploaded; told more facets than there is memory for.
    let body =
        problem(post_with_surface(&app, &parameters(), stl(TOP).into_bytes()).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/surface"]);
    let large = [vec![0; 80], 400_000_u32.to_le_bytes().to_vec(), vec![0; 50 * 400_000]].concat();
    let body = problem(post_with_surface(&app, &asked, large).await, "body-too-large").await;
    assert!(body["detail"].as_str().unwrap().contains("400000 facets"), "{body}");
    assert_eq!(app.files(), (0, 0));
    // Other operations have no part.
    let form = Form::new().text("surface", stl(TOP)).text("program", plate());
    let path = "/v1/machines/example-ac-table/servo-simulation";
    let body =
        problem(app.client.post(app.url(path)).multipart(form).send().await.unwrap(), "invalid-request")
            .await;
    assert_eq!(pointers(&body), ["/surface"]);
}

#[tokio::test]
async fn the_part_says_where_a_worn_cutter_touches() {
    let app = spawn().await;
    let (stated, _) = leaning(&app).await;
    // Without contact words, and over a plate that reaches as far as the passes.
    let bare: String =
        stated.lines().map(|line| line.split(" U").next().unwrap().to_owned() + "\n").collect();
    let plate = TOP.map(|[x, y, z]| [2.0 * x, 2.0 * y, z]);
    let asked = json!({
        "nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4}, "contact": "surface",
        "allowed_scallop_um": 40, "stepover_mm": 1
    });
    let post = async |asked: &Value, program: &str, surface: Option<String>| {
        let mut form = Form::new().text("parameters", asked.to_string()).text("program", program.to_owned());
        if let Some(surface) = surface {
            form = form.text("surface", surface);
        }
        let path = "/v1/machines/example-ac-table/wear-compensation";
        app.client.post(app.url(path)).multipart(form).send().await.unwrap()
    };
    let by_part = post(&asked, &bare, Some(stl(plate))).await;
    assert_eq!(by_part.status(), 200);
    let job = by_part.headers()["location"].to_str().unwrap().to_owned();
    let (by_part, _) = unstamped(&by_part.text().await.unwrap());
    let (by_words, _) = unstamped(&app.post_text(WEAR, "text/plain", stated).await.text().await.unwrap());
    for (part, words) in by_part.lines().zip(by_words.lines()) {
        assert_eq!(part, words.split(" U").next().unwrap());
    }
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    assert_eq!((&report["contact"], &report["contacts_kept"]), (&json!("surface"), &json!(26)));
    assert_eq!(report["advice"]["advice"], "compensate", "{report}");
    let flat = ["convex_radius_mm", "convex_line", "concave_radius_mm", "concave_line"];
    assert!(flat.into_iter().all(|name| report["curvature"][name].is_null()), "{report}");
    // A plate that the cutter does not touch: nothing moves, and that is said.
    let below = plate.map(|[x, y, z]| [x, y, z - 1.0]);
    let mut near = asked.clone();
    near["contact_gap_um"] = json!(500);
    let missed = post(&near, &bare, Some(stl(below))).await;
    assert_eq!(missed.text().await.unwrap(), bare);
    for (contact, surface) in [("surface", None), ("program", Some(stl(plate)))] {
        let mut wrong = asked.clone();
        wrong["contact"] = json!(contact);
        let body = problem(post(&wrong, &bare, surface).await, "invalid-request").await;
        assert_eq!(pointers(&body), ["/contact"], "{body}");
    }
}

#[tokio::test]
async fn only_the_named_tool_cuts() {
    let app = spawn().await;
    // The first tool cuts the plate, the second half a millimetre below it.
    let text = plate().replace("G90 G21 G94\n", "G90 G21 G94\nT1 M6\n").replace("M30\n", "T2 M6\n")
        + &plate().replace("Z0.000", "Z-0.500");
    let cut = async |number: Option<u32>| -> Value {
        let mut asked = parameters();
        asked["tool_number"] = json!(number);
        asked["samples"] = json!(500);
        post(&app, &asked, &text, "application/json").await.json().await.unwrap()
    };
    let (first, second) = (cut(Some(1)).await, cut(Some(2)).await);
    assert_eq!((&first["max_gouge"], &first["warnings"]), (&Value::Null, &json!([])));
    assert!(first["left_out"].to_string().contains("other_tool"), "{first}");
    assert!((second["max_gouge"]["residual_um"].as_f64().unwrap() + 500.0).abs() < 1.0, "{second}");
    // One cutter is stated, and two cut: nobody says which of them it is.
    let both = cut(None).await;
    assert_eq!(both["errors"][0]["pointer"], "/tool_number", "{both}");
    assert!(both["detail"].as_str().unwrap().contains("2 tools cut in this program (T1, T2)"), "{both}");
    let none = cut(Some(3)).await;
    assert_eq!(none["errors"][0]["pointer"], "/tool_number", "{none}");
}

#[tokio::test]
async fn a_trench_deeper_than_the_stock_is_a_gouge_however_the_cutter_came() {
    let app = spawn().await;
    // A small ball, and a trench across the finished plate that is entered from beside it.
    let trench = |depth: &str| {
        plate().replace("G0 Z50.000\nM30\n", &format!("G0 X-30. Y0.\nG0 Z{depth}\nG1 X30.\nG0 Z50.\nM30\n"))
    };
    for (length_mm, depth, expected_um) in
        [(4.0, "-2.500", -2500.0), (4.0, "-3.500", -3500.0), (30.0, "-12.000", -12000.0)]
    {
        let mut asked = parameters();
        (asked["tool"]["radius_mm"], asked["samples"]) = (json!(1), json!(4000));
        asked["cutting_length_mm"] = json!(length_mm);
        let report: Value =
            post(&app, &asked, &trench(depth), "application/json").await.json().await.unwrap();
        let gouge_um = report["max_gouge"]["residual_um"].as_f64().unwrap();
        assert!((gouge_um - expected_um).abs() < 10.0, "{depth}: {gouge_um}");
    }
}

#[tokio::test]
async fn a_part_that_no_motion_reaches_is_warned_of() {
    let app = spawn().await;
    let above = plate().replace("Z0.000", "Z5.000");
    let report: Value = post(&app, &parameters(), &above, "application/json").await.json().await.unwrap();
    assert_eq!((&report["uncut"], &report["excess_over_limit"]), (&json!(20_000), &json!(0)));
    assert_eq!(report["warnings"][0]["kind"], "uncut");
    assert_eq!((&report["warnings"][0]["count"], &report["rms_um"]), (&json!(20_000), &Value::Null));
    // Wound the other way round, against its stated normals.
    let [a, b, c, d] = TOP;
    let asked = json!({"tool": {"radius_mm": RADIUS_MM}, "samples": 100});
    let report: Value =
        post_with_surface(&app, &asked, stl([d, c, b, a]).into_bytes()).await.json().await.unwrap();
    assert!(report["warnings"].to_string().contains("contradicting_normals"), "{report}");
}
