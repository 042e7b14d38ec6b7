//! Compensation in one pass over HTTP: the whole way with the real computation.

use std::sync::Arc;

use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::queue::{accepted, ended};
use crate::support::{App, ac_table, pointers, problem, spawn, spawn_real, unstamped};

const BLADE: &str = include_str!("../../docs/examples/blade.nc");
const PATH: &str = "/v1/machines/example-ac-table/compensation";
const OFFSET: &str = "work_offset_mm=12,-7,35";

async fn post(app: &App, path: &str, query: &str, program: &str) -> reqwest::Response {
    app.post_text(&format!("{path}?{query}"), "text/plain", program.to_owned()).await
}

/// The example table with errors as a calibration finds them.
async fn calibrated(app: &App) {
    let mut profile = ac_table();
    let errors = json!({"e_x_um": 12.0, "e_y_um": -21.0, "e_z_um": 34.0, "e_a_urad": 41.0, "e_b_urad": -63.0, "e_c_urad": 29.0});
    profile["kinematics"]["rotary_axes"][0]["location_error"] = errors;
    profile["kinematics"]["rotary_axes"][1]["location_error"] = json!({"e_y_um": 15.0, "e_b_urad": 27.0});
    let request = app.client.put(app.url("/v1/machines/calibrated")).json(&profile);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 201, "{}", response.text().await.unwrap());
}

#[tokio::test]
async fn where_nothing_is_wrong_the_program_comes_back_byte_for_byte() {
    let app = spawn().await;
    let query = format!(
        "{OFFSET}&wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=5&location_errors=true&cc.tolerance_um=1000"
    );
    let response = post(&app, PATH, &query, BLADE).await;
    assert_eq!(response.status(), 200);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    assert_eq!(response.text().await.unwrap(), BLADE);
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    assert_eq!(report["input_sha256"], report["output_sha256"]);
    assert_eq!(report["changes"]["motions_changed"], 0);
    assert_eq!(report["location_errors"]["machine_has_errors"], false);
    // The table of changes is there, with its header alone.
    let changes = app.get(&format!("{job}/changes")).await.text().await.unwrap();
    assert_eq!(
        changes.trim_end(),
        "line,kind,location_errors_um,tool_axis_urad,wear_um,cc_um,blocks_out,error_before_um,error_after_um"
    );
}

#[tokio::test]
async fn all_three_steps_are_one_job_with_shares_budget_table_and_figure() {
    let app = spawn().await;
    calibrated(&app).await;
    let path = "/v1/machines/calibrated/compensation";
    let query = format!(
        "{OFFSET}&wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.9&location_errors=true&cc.tolerance_um=5"
    );
    let response = post(&app, path, &query, BLADE).await;
    let status = response.status();
    let job = response.headers().get("location").map(|job| job.to_str().unwrap().to_owned());
    let text = response.text().await.unwrap();
    assert_eq!(status, 200, "{text}");
    let job = job.unwrap();
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["operation"], "compensation");
    assert_eq!(document["parameters"]["cc"]["tolerance_um"], 5.0);
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    for member in ["machine_revision", "software_version", "input_sha256", "output_sha256"] {
        assert_eq!(report[member], document[member], "{member}");
    }
    assert_eq!(report["changes"]["changes_sha256"], document["changes_sha256"]);
    // Each step has done something, and what is left is small.
    assert!(report["location_errors"]["motions_posted"].as_u64().unwrap() > 90, "{report}");
    assert!(report["wear"]["max_shift_um"].as_f64().unwrap() > 90.0);
    assert!(report["cc"]["motions_over_tolerance"].as_u64().unwrap() > 0);
    assert!(report["cc"]["after"]["max_um"].as_f64().unwrap() <= 5.0);
    let budget = &report["error_budget"];
    for source in ["interpolation", "location_errors", "wear"] {
        let before = budget[source]["before_um"].as_f64().unwrap();
        let after = budget[source]["after_um"].as_f64().unwrap();
        assert!(before > 10.0 && after <= 5.0, "{source}: {before} and {after}");
    }
    let kinds: Vec<_> = budget["not_modelled"].as_array().unwrap().iter().map(|one| &one["kind"]).collect();
    assert!(kinds.contains(&&json!("thermal")) && kinds.contains(&&json!("drives")), "{kinds:?}");
    // Every changed motion has its row; lines are those of the upload.
    let table = app.get(&format!("{job}/changes")).await;
    assert_eq!(table.headers()["content-type"], "text/csv");
    let tag = table.headers()["etag"].to_str().unwrap().to_owned();
    let table = table.text().await.unwrap();
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len() as u64, report["changes"]["motions_changed"].as_u64().unwrap());
    let lines: Vec<usize> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    assert!(
        lines.windows(2).all(|pair| pair[0] <= pair[1]) && *lines.last().unwrap() <= BLADE.lines().count()
    );
    let blocks_out: u64 = rows.iter().map(|row| row[6].parse::<u64>().unwrap() - 1).sum();
    assert!(blocks_out <= report["blocks_inserted"].as_u64().unwrap() && blocks_out > 0);
    let known = app.client.get(app.url(&format!("{job}/changes"))).header("if-none-match", tag);
    assert_eq!(known.send().await.unwrap().status(), 304);
    let plot = app.get(&format!("{job}/plot")).await.text().await.unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("One pass"));
    // The same request again: the same bytes.
    let again = post(&app, path, &query, BLADE).await.text().await.unwrap();
    assert_eq!(again, text);
    // And as a form.
    let parameters = json!({
        "wear": {"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.9}},
        "location_errors": true, "cc": {"tolerance_um": 5}, "work_offset_mm": [12, -7, 35]
    });
    let form = reqwest::multipart::Form::new()
        .text("parameters", parameters.to_string())
        .part("program", reqwest::multipart::Part::text(BLADE).file_name("blade.nc"));
    let request = app.client.post(app.url(path)).header("accept", "application/json").multipart(form);
    let by_form: Value = request.send().await.unwrap().json().await.unwrap();
    assert_eq!(by_form["output_sha256"], report["output_sha256"]);
}

#[tokio::test]
async fn one_step_alone_is_what_its_own_operation_makes() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    for (own, query, step) in [
        ("cc-compensation", "tool_radius_mm=5&tolerance_um=4", "cc.tool_radius_mm=5&cc.tolerance_um=4"),
        (
            "wear-compensation",
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4.75",
            "wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.75",
        ),
    ] {
        let path = format!("/v1/machines/example-ac-table/{own}");
        let alone = post(&app, &path, &format!("{OFFSET}&{query}"), BLADE).await.text().await.unwrap();
        let as_step = post(&app, PATH, &format!("{OFFSET}&{step}"), BLADE).await.text().await.unwrap();
        let [(alone, alone_says), (as_step, step_says)] = [&alone, &as_step].map(|text| unstamped(text));
        assert!(alone == as_step && alone != BLADE, "{own}");
        // The stamps name the operations, and the same step.
        let steps = format!(" steps {} machine ", own.split('-').next().unwrap());
        for (says, operation) in [(alone_says, own), (step_says, "compensation")] {
            let says = says.unwrap();
            assert!(says.contains(&format!(" {operation}{steps}")), "{says}");
        }
    }
}

#[tokio::test]
async fn what_does_not_fit_is_named_by_its_step() {
    let app = spawn().await;
    for (query, expected) in [
        ("", &[""][..]),
        ("location_errors=false", &[""]),
        ("cc.tolerance_um=0", &["/cc/tolerance_um", "/cc/tool_radius_mm"]),
        ("cc.tool_radius_mm=5&cc.corner_radius_mm=6", &["/cc/corner_radius_mm"]),
        (
            "wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.9&cc.tool_radius_mm=6",
            &["/cc/tool_radius_mm"],
        ),
        ("wear.nominal_tool.radius_mm=5", &["/wear/actual_tool"]),
        (
            "wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4&wear.contact=tip&work_offset_mm=0,1e9,0",
            &["/work_offset_mm/1", "/wear/contact"],
        ),
        ("location_errors=true&feed_mm_per_min=0", &["/feed_mm_per_min"]),
    ] {
        let response = post(&app, PATH, query, BLADE).await;
        let found = problem(response, "invalid-request").await;
        assert_eq!(pointers(&found), expected, "{query}: {found}");
    }
    let unknown = post(&app, PATH, "wear.radius_mm=5", BLADE).await;
    assert_eq!(unknown.status(), 422);
    let job = post(&app, "/v1/machines/example-ac-table/cc-compensation", "contact=tip", BLADE).await;
    let job = job.headers()["location"].to_str().unwrap().to_owned();
    problem(app.get(&format!("{job}/changes")).await, "result-not-found").await;
}

/// A pass that leans over the pole of the example table: A through 0 while C has to turn.
const OVER_THE_POLE: &str = "G21 G90 G94\nG1 X-10.0000 Y0.0000 Z5.0000 A0.6000 C10.0000 F1000\nX-5.0000 A0.3000 C20.0000\nX0.0000 A0.1500 C60.0000\nX5.0000 A0.3000 C110.0000\nX10.0000 A0.6000 C120.0000\nX15.0000 A0.9000 C124.0000\nM30\n";

#[tokio::test]
async fn singular_regions_are_listed_divided_or_passed_more_slowly() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    for (path, query) in [
        ("/v1/machines/example-ac-table/cc-compensation", "tool_radius_mm=5&contact=tip&tolerance_um=500"),
        (PATH, "cc.tool_radius_mm=5&cc.contact=tip&cc.tolerance_um=500"),
    ] {
        let mut found = Vec::new();
        for action in [
            "",
            "&singularity=densify&singular_regions.axis_tolerance_deg=0.2",
            "&singularity=smooth&singular_regions.axis_tolerance_deg=0.2",
        ] {
            let response =
                post(&app, path, &format!("work_offset_mm=0,0,0&{query}{action}"), OVER_THE_POLE).await;
            assert_eq!(response.status(), 200, "{path} {action}");
            let job = response.headers()["location"].to_str().unwrap().to_owned();
            let text = response.text().await.unwrap();
            let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
            assert_eq!(report["blocks_in"], 8, "{report}");
            found.push((text, report["singularity"].clone()));
        }
        let [(listed, listing), (_, dense), (smooth, smoothed)] = &found[..] else { unreachable!() };
        assert_eq!(
            (&listing["action"], &listing["regions_found"]),
            (&json!("report"), &json!(1)),
            "{listing}"
        );
        let region = &listing["regions"][0];
        assert_eq!((&region["kind"], &region["treatment"]), (&json!("pole"), &json!("reported")));
        assert!(region["least_angle_deg"].as_f64().unwrap() < 0.2, "{region}");
        assert_ne!(listed, smooth);
        assert_eq!(dense["regions"][0]["treatment"], "densified", "{dense}");
        assert!(dense["blocks_inserted"].as_u64().unwrap() > 0);
        assert_eq!(smoothed["regions"][0]["treatment"], "smoothed", "{smoothed}");
        let spent = smoothed["axis_spent_deg"].as_f64().unwrap();
        assert!(spent > 0.0 && spent <= 0.2, "{spent}");
        let speed = |figures: &Value| figures["rotary_deg_per_s"].as_f64().unwrap();
        assert!(speed(&smoothed["after"]) < 0.9 * speed(&smoothed["before"]), "{smoothed}");
    }
    let response = post(&app, PATH, "location_errors=true&singular_regions.zone_deg=0", OVER_THE_POLE).await;
    assert_eq!(pointers(&problem(response, "invalid-request").await), ["/singular_regions/zone_deg"]);
}

#[tokio::test]
async fn a_second_smoothing_spends_nothing_though_the_first_left_no_stamp() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let query = "work_offset_mm=0,0,0&cc.tool_radius_mm=5&cc.contact=tip&cc.tolerance_um=500&stamp=none\
        &singularity=smooth&singular_regions.axis_tolerance_deg=0.2";
    let first = post(&app, PATH, query, OVER_THE_POLE).await.text().await.unwrap();
    assert!(first != OVER_THE_POLE && !first.contains("Trunnion"), "{first}");
    let refused = post(&app, PATH, query, &first).await;
    assert_eq!(refused.status(), 409);
    let again = post(&app, PATH, &format!("{query}&allow_repeated=true"), &first).await;
    let job = again.headers()["location"].to_str().unwrap().to_owned();
    assert_eq!(again.text().await.unwrap(), first);
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    assert_eq!(report["singularity"]["regions"][0]["left_reason"], "smoothed_before", "{report}");
    let order = json!({"machine_id": "example-ac-table", "operation": "compensation", "parameters": {
        "work_offset_mm": [0, 0, 0], "allow_repeated": true, "stamp": "none", "singularity": "smooth",
        "cc": {"tool_radius_mm": 5, "contact": "tip", "tolerance_um": 500},
        "singular_regions": {"axis_tolerance_deg": 0.2}}});
    let job = ended(&app, &accepted(&app, &order, &first).await).await;
    assert_eq!(job["state"], "succeeded", "{job}");
    assert_eq!(job["output_sha256"], job["input_sha256"], "{job}");
}
