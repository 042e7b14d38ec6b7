//! Programs for a worn cutter over HTTP: the whole way with the real computation.

use std::sync::Arc;

use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::support::{App, ac_table, pointers, problem, spawn, spawn_real, unstamped};

const BLADE: &str = include_str!("../../docs/examples/blade.nc");
const PATH: &str = "/v1/machines/example-ac-table/wear-compensation";
/// P3 Table 4's nominal ball, and the set-up of the example program.
const NOMINAL: &str = "nominal_tool.radius_mm=5&work_offset_mm=12,-7,35";

async fn post(app: &App, query: &str, program: &str) -> reqwest::Response {
    app.post_text(&format!("{PATH}?{query}"), "text/plain", program.to_owned()).await
}

/// X Y Z of every block that moves, and everything else of it.
fn words(text: &str) -> Vec<([f64; 3], String)> {
    text.lines()
        .filter(|line| line.contains(" X"))
        .map(|line| {
            let mut place = [0.0; 3];
            let mut rest = String::new();
            for word in line.split(' ') {
                match ["X", "Y", "Z"].iter().position(|letter| word.starts_with(letter)) {
                    Some(k) => place[k] = word[1..].parse().unwrap(),
                    None => rest += word,
                }
            }
            (place, rest)
        })
        .collect()
}

#[tokio::test]
async fn the_tools_of_p3_table_4_move_the_blade_in_proportion_and_keep_its_rotary_words() {
    let app = spawn().await;
    let source = words(BLADE);
    let mut moved = Vec::new();
    for radius in ["4", "4.5", "4.75"] {
        let response = post(&app, &format!("{NOMINAL}&actual_tool.radius_mm={radius}"), BLADE).await;
        assert_eq!(response.status(), 200);
        let job = response.headers()["location"].to_str().unwrap().to_owned();
        let (text, stamp) = unstamped(&response.text().await.unwrap());
        assert!(
            stamp
                .unwrap()
                .contains(" wear-compensation steps wear machine example-ac-table revision 1 tool 1 ")
        );
        let written = words(&text);
        assert_eq!((written.len(), text.lines().count()), (source.len(), BLADE.lines().count()));
        for ((_, before), (_, after)) in source.iter().zip(&written) {
            assert_eq!(before, after, "only X Y Z may change");
        }
        let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
        let lost_um = (5.0 - radius.parse::<f64>().unwrap()) * 1000.0;
        // 60° between normal and axis: half of it stands off, and the tip moves by all of it.
        assert!(
            (report["before"]["max_excess_um"].as_f64().unwrap() - 0.5 * lost_um).abs() < 0.1,
            "{report}"
        );
        assert!((report["max_shift_um"].as_f64().unwrap() - lost_um).abs() < 0.1);
        assert!(report["after"]["max_um"].as_f64().unwrap() < 0.1, "{}", report["after"]);
        assert_eq!(report["contacts_kept"], source.len());
        assert_eq!((&report["blocks_in"], &report["warnings"]), (&report["blocks_out"], &json!([])));
        moved.push(written);
    }
    // Twice the wear, twice the shift, to two roundings of four decimals.
    for (k, (place, _)) in source.iter().enumerate() {
        for (axis, from) in place.iter().enumerate() {
            let shift = |tool: usize| moved[tool][k].0[axis] - from;
            assert!((shift(0) - 2.0 * shift(1)).abs() < 2.01e-4, "{k}");
            assert!((shift(1) - 2.0 * shift(2)).abs() < 2.01e-4, "{k}");
        }
    }
}

#[tokio::test]
async fn a_worn_program_is_a_job_with_report_and_figure() {
    let app = spawn().await;
    let query = format!("{NOMINAL}&actual_tool.radius_mm=4.75&allowed_scallop_um=20&stepover_mm=0.85");
    let response = post(&app, &query, BLADE).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let name = response.headers()["content-disposition"].to_str().unwrap().to_owned();
    assert!(name.ends_with("-compensated.nc\""), "{name}");
    let program = response.text().await.unwrap();
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(
        (&document["operation"], &document["state"]),
        (&json!("wear-compensation"), &json!("succeeded"))
    );
    assert_eq!(document["parameters"]["nominal_tool"]["radius_mm"], 5.0);
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    for member in ["machine_revision", "software_version", "input_sha256", "output_sha256"] {
        assert_eq!(report[member], document[member], "{member}");
    }
    // On a plane 20 µm want passes 0.871 mm apart.
    assert_eq!(report["advice"]["advice"], "compensate");
    let angles = report["contact_angle_deg"].as_array().unwrap();
    assert!(angles.iter().all(|angle| (angle.as_f64().unwrap() - 60.0).abs() < 0.01), "{angles:?}");
    let plot = app.get(&format!("{job}/plot")).await.text().await.unwrap();
    assert!(
        plot.starts_with("<svg") && plot.contains("offset of the worn cutter") && !plot.contains("tolerance")
    );
    assert_eq!(app.get(&format!("{job}/program")).await.text().await.unwrap(), program);
    // The same by a form, and as the report.
    let parameters = json!({
        "nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.75}, "work_offset_mm": [12, -7, 35],
        "allowed_scallop_um": 20, "stepover_mm": 0.85
    });
    let form = reqwest::multipart::Form::new()
        .text("parameters", parameters.to_string())
        .part("program", reqwest::multipart::Part::text(BLADE).file_name("blade.nc"));
    let request = app.client.post(app.url(PATH)).header("accept", "application/json").multipart(form);
    let by_form: Value = request.send().await.unwrap().json().await.unwrap();
    assert_eq!(by_form["output_sha256"], report["output_sha256"]);
    assert_eq!(by_form["advice"], report["advice"]);
    // Without the figures for the advice there is none.
    let request = app.client.post(app.url(&format!("{PATH}?{NOMINAL}&actual_tool.radius_mm=4.75")));
    let plain = request.header("accept", "application/json").body(BLADE).send().await.unwrap();
    assert_eq!(plain.json::<Value>().await.unwrap()["advice"], Value::Null);
    // A key gives the same answer again.
    let keyed =
        || app.client.post(app.url(&format!("{PATH}?{query}"))).header("idempotency-key", "k").body(BLADE);
    let (first, again) = (keyed().send().await.unwrap(), keyed().send().await.unwrap());
    assert_eq!(first.headers()["location"], again.headers()["location"]);
}

#[tokio::test]
async fn no_wear_gives_the_bytes_back() {
    let app = spawn().await;
    let text = BLADE.replace('\n', "\r\n");
    for query in [
        "actual_tool.radius_mm=5",
        "wear_table.contact_angle_deg=0,90&wear_table.deviation_um=0,0",
        "actual_tool.radius_mm=5&nominal_tool.length_mm=80&actual_tool.length_mm=80&contact=feed-plane",
    ] {
        let response = post(&app, &format!("{NOMINAL}&{query}"), &text).await;
        assert_eq!(response.text().await.unwrap(), text, "{query}");
    }
}

#[tokio::test]
async fn tables_and_lengths_are_taken() {
    let app = spawn().await;
    let answer = |query: &str| {
        let query = format!("{NOMINAL}&stamp=none&{query}");
        let app = &app;
        async move { post(app, &query, BLADE).await.text().await.unwrap() }
    };
    let ball = answer("actual_tool.radius_mm=4.75").await;
    let table = answer("wear_table.contact_angle_deg=0,90&wear_table.deviation_um=-250,-250").await;
    assert_eq!(ball, table);
    let lengths = "actual_tool.radius_mm=4.75&nominal_tool.length_mm=80&actual_tool.length_mm=79.5";
    let nominal = answer(lengths).await;
    assert_ne!(nominal, ball);
    assert_eq!(answer(&format!("{lengths}&length_in_control=nominal")).await, nominal);
    // The tables turn the part: along the spindle the tip goes half a millimetre deeper.
    for ((deeper, _), (as_deep, _)) in words(&nominal).iter().zip(&words(&ball)) {
        let off = [deeper[0] - as_deep[0], deeper[1] - as_deep[1], deeper[2] - as_deep[2] + 0.5];
        assert!(off.iter().all(|off| off.abs() < 1.01e-4), "{off:?}");
    }
    assert_eq!(answer(&format!("{lengths}&length_in_control=measured")).await, ball);
}

#[tokio::test]
async fn bad_parameters_of_a_worn_program_are_named() {
    let app = spawn().await;
    for (query, expected) in [
        ("", vec!["/actual_tool", "/nominal_tool"]),
        ("nominal_tool.radius_mm=5", vec!["/actual_tool"]),
        (
            "nominal_tool.radius_mm=0&actual_tool.radius_mm=-1",
            vec!["/nominal_tool/radius_mm", "/actual_tool/radius_mm"],
        ),
        (
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4&actual_tool.corner_radius_mm=4.5",
            vec!["/actual_tool/corner_radius_mm"],
        ),
        (
            "nominal_tool.radius_mm=5&nominal_tool.corner_radius_mm=1&actual_tool.radius_mm=4.9",
            vec!["/actual_tool/corner_radius_mm"],
        ),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&contact=tip", vec!["/contact"]),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&contact=surface", vec!["/contact"]),
        (
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4&contact=feed-plane&milling=side",
            vec!["/contact"],
        ),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&contact=normals", vec!["/contact"]),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&milling=top", vec!["/milling"]),
        (
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4&length_in_control=measured",
            vec!["/length_in_control"],
        ),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&tolerance_um=10", vec!["/tolerance_um"]),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&stepover_mm=1", vec!["/allowed_scallop_um"]),
        (
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4&stepover_mm=11&allowed_scallop_um=20",
            vec!["/stepover_mm"],
        ),
        ("nominal_tool.radius_mm=5&actual_tool.radius_mm=4&lead_deg=3", vec!["/lead_deg"]),
        (
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4&wear_table.contact_angle_deg=0&wear_table.deviation_um=0",
            vec!["/wear_table"],
        ),
        (
            "nominal_tool.radius_mm=5&wear_table.contact_angle_deg=0,90&wear_table.deviation_um=0",
            vec!["/wear_table"],
        ),
        (
            "nominal_tool.radius_mm=5&wear_table.contact_angle_deg=0,90,80&wear_table.deviation_um=0,1,2",
            vec!["/wear_table/contact_angle_deg/2"],
        ),
        (
            "nominal_tool.radius_mm=5&wear_table.contact_angle_deg=1,90&wear_table.deviation_um=0,1",
            vec!["/wear_table/contact_angle_deg/0"],
        ),
        (
            "nominal_tool.radius_mm=5&wear_table.contact_angle_deg=0,90&wear_table.deviation_um=0,1e9",
            vec!["/wear_table/deviation_um/1"],
        ),
        (
            "nominal_tool.radius_mm=5&wear_table.contact_angle_deg=0,90&wear_table.deviation_um=0,1&milling=side",
            vec!["/wear_table"],
        ),
        (
            "nominal_tool.radius_mm=5&actual_tool.radius_mm=4&work_offset_mm=1,2,1e9&feed_mm_per_min=0",
            vec!["/work_offset_mm/2", "/feed_mm_per_min"],
        ),
    ] {
        let body = problem(post(&app, query, BLADE).await, "invalid-request").await;
        assert_eq!(pointers(&body), expected, "{query}: {body}");
    }
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_program_that_cannot_be_moved_names_its_lines_and_stores_nothing() {
    let app = spawn().await;
    let query = format!("{NOMINAL}&actual_tool.radius_mm=4.75");
    let middle = "N170 X0.0000";
    for (change, code) in [
        ("G41 D1 X0.0000", "program-fault"),
        ("/N170 X0.0000", "program-fault"),
        ("G55\nN170 X0.0000", "program-fault"),
        ("G65 P1\nN170 X0.0000", "program-fault"),
    ] {
        let body = problem(post(&app, &query, &BLADE.replace(middle, change)).await, code).await;
        assert!((18..=19).contains(&body["line"].as_u64().unwrap()), "{body}");
        assert!(body["block"].is_string() && pointers(&body)[0].starts_with("/program/1"), "{body}");
    }
    // A normal that points away from the tool.
    let under = BLADE.replace("U0.0000 V-8.7679 W-3.6891", "U0.0000 V-4.4378 W3.8109");
    let body = problem(post(&app, &query, &under).await, "program-fault").await;
    assert_eq!((body["line"].as_u64(), &body["block"]), (Some(18), &json!(under.lines().nth(17).unwrap())));
    // The narrow machine is left by the shift alone.
    let mut narrow = ac_table();
    narrow["kinematics"]["rotary_axes"][0]["point_mm"] = json!([0, 0, 0]);
    let highest = words(BLADE).iter().map(|(place, _)| place[2]).fold(f64::NEG_INFINITY, f64::max);
    narrow["kinematics"]["linear_limits_mm"]["Z"] = json!([-100, highest]);
    assert_eq!(app.put_machine("tight", &narrow).await.status(), 201);
    let path = format!("/v1/machines/tight/wear-compensation?{query}");
    let longer = format!("{path}&nominal_tool.length_mm=80&actual_tool.length_mm=81");
    problem(app.post_text(&longer, "text/plain", BLADE).await, "out-of-travel").await;
    assert_eq!(app.files(), (0, 0));
    problem(
        app.post_text("/v1/machines/none/wear-compensation?nominal_tool.radius_mm=5", "text/plain", BLADE)
            .await,
        "machine-not-found",
    )
    .await;
}

#[tokio::test]
async fn a_stamp_that_a_control_cut_off_or_wrote_anew_still_refuses_a_second_time() {
    const WEAR: &str = "actual_tool.radius_mm=4.5";
    const CC: &str = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&work_offset_mm=12,-7,35&contact=feed-plane";
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let with = |comment: &str| BLADE.replacen("(blade)", &format!("(blade)\n({comment})"), 1);
    for comment in [
        "Trunnion 0.2.0 wear-compensatio",
        "TRUNNION 0.2.0 COMPENSATION STEPS CC",
        "Trunnion 0.2.0 compensation steps  machine a",
        "Trunnion 0.2.0 compensation steps cc,polish machine a",
        "made by Trunnion 0.2.0",
    ] {
        let said =
            problem(post(&app, &format!("{NOMINAL}&{WEAR}"), &with(comment)).await, "already-compensated");
        let detail = said.await["detail"].as_str().unwrap().to_owned();
        assert!(detail.contains("cannot all be read"), "{comment}: {detail}");
        assert!(detail.contains("Send the source program"), "{comment}: {detail}");
        for query in ["", "&allow_repeated=true"] {
            let answer = app.post_text(&format!("{CC}{query}"), "text/plain", with(comment)).await;
            assert_eq!(answer.status(), 409, "{comment} {query}");
        }
    }
    let both = with("Trunnion 0.2.0 compensation steps cc, wear machine a");
    let said = problem(post(&app, &format!("{NOMINAL}&{WEAR}"), &both).await, "already-compensated").await;
    assert!(said["detail"].as_str().unwrap().contains("the step `wear`"), "{said}");
    assert_eq!(app.post_text(CC, "text/plain", both.clone()).await.status(), 409);
    let again = app.post_text(&format!("{CC}&allow_repeated=true"), "text/plain", both).await;
    assert_eq!(again.status(), 200, "{}", again.text().await.unwrap());
    // A machine with a trunnion is no stamp.
    let named = with("TRUNNION TABLE 160, 5.2 MM LOWER");
    assert_eq!(post(&app, &format!("{NOMINAL}&{WEAR}"), &named).await.status(), 200);
}
