//! Scallop heights and advice for worn cutters over HTTP.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::support::{App, pointers, problem, spawn, spawn_with};

const SCALLOP: &str = "/v1/scallop-height";
/// Values given to nine significant digits are met to half a unit of the last.
const NINE_DIGITS: f64 = 5.5e-9;

fn close(value: &Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!(((value - expected) / expected).abs() < NINE_DIGITS, "{value} is not {expected}");
}

async fn answer(app: &App, path: &str, body: &Value) -> Value {
    let response = app.post_json(path, body).await;
    assert_eq!(response.status(), StatusCode::OK, "{:?}", response.text().await);
    response.json().await.unwrap()
}

async fn refused(app: &App, path: &str, body: &Value) -> Value {
    let response = app.post_json(path, body).await;
    assert_eq!(response.status(), StatusCode::UNPROCESSABLE_ENTITY, "{body}");
    problem(response, "invalid-request").await
}

#[tokio::test]
async fn scallop_heights_are_those_of_the_table() {
    let app = spawn().await;
    for (surface, height_um, stepover_mm) in [
        ("flat", 0.250_006_250, 0.893_532_316),
        ("convex", 0.375_030_472, 0.728_716_609),
        ("concave", 0.125_000_781, 1.264_278_45),
    ] {
        let mut body =
            json!({"stepover_mm": 0.1, "tool_radius_mm": 5, "surface": surface, "allowed_scallop_um": 20});
        if surface != "flat" {
            body["surface_radius_mm"] = json!(10);
        }
        let found = answer(&app, SCALLOP, &body).await;
        close(&found["scallop_height_um"], height_um);
        close(&found["max_stepover_mm"], stepover_mm);
        assert!(found["min_tool_radius_mm"].as_f64().unwrap() < 0.1, "{found}");
        assert!(found.get("effective_radius_mm").is_none());
        body.as_object_mut().unwrap().remove("allowed_scallop_um");
        let found = answer(&app, SCALLOP, &body).await;
        assert_eq!(found.as_object().unwrap().len(), 1, "{found}");
    }
}

#[tokio::test]
async fn arrays_are_answered_as_arrays_and_single_numbers_count_for_all() {
    let app = spawn().await;
    let body = json!({"stepover_mm": [0.1, 0.2, 3.0], "tool_radius_mm": 5, "surface": "convex",
        "surface_radius_mm": [10, 20, 3.0], "allowed_scallop_um": 1});
    let many = answer(&app, SCALLOP, &body).await;
    for index in 0..3 {
        let one = json!({"stepover_mm": body["stepover_mm"][index], "tool_radius_mm": 5, "surface": "convex",
            "surface_radius_mm": body["surface_radius_mm"][index], "allowed_scallop_um": 1});
        let one = answer(&app, SCALLOP, &one).await;
        for name in ["scallop_height_um", "max_stepover_mm", "min_tool_radius_mm"] {
            assert_eq!(many[name][index], one[name], "{name} {index}");
        }
    }
    // No tool leaves a micrometre on a chord of 3 mm over a radius of 3 mm.
    assert_eq!(many["min_tool_radius_mm"][2], Value::Null);
    assert!(many["min_tool_radius_mm"][0].is_f64());
    let single =
        answer(&app, SCALLOP, &json!({"stepover_mm": [0.1], "tool_radius_mm": 5, "surface": "flat"})).await;
    assert_eq!(single["scallop_height_um"].as_array().map(Vec::len), Some(1));
}

#[tokio::test]
async fn answers_may_be_asked_again() {
    let app = spawn().await;
    for surface in ["convex", "concave", "flat"] {
        for (radius, allowed) in [(7.3, 1e7), (7.3, 13.0), (9.999, 1e7), (11.0, 1.5)] {
            let mut body = json!({"stepover_mm": 0.3, "tool_radius_mm": radius, "surface": surface, "allowed_scallop_um": allowed});
            if surface != "flat" {
                body["surface_radius_mm"] = json!(11.0);
            }
            let found = answer(&app, SCALLOP, &body).await;
            let mut widest = body.clone();
            widest["stepover_mm"] = found["max_stepover_mm"].clone();
            let height = answer(&app, SCALLOP, &widest).await["scallop_height_um"].as_f64().unwrap();
            assert!(height <= allowed * (1.0 + 1e-9), "{widest}");
            let mut least = body.clone();
            least["tool_radius_mm"] = found["min_tool_radius_mm"].clone();
            let height = answer(&app, SCALLOP, &least).await["scallop_height_um"].as_f64().unwrap();
            assert!(height <= allowed * (1.0 + 1e-9), "{least}");
        }
    }
}

#[tokio::test]
async fn an_inclined_cutter_is_taken_with_its_effective_radius() {
    let app = spawn().await;
    let body = json!({"stepover_mm": 1.0, "tool_radius_mm": 5, "corner_radius_mm": 1, "lead_deg": 30,
        "surface": "flat", "allowed_scallop_um": 10});
    let found = answer(&app, SCALLOP, &body).await;
    close(&found["effective_radius_mm"], 9.0);
    let ball = json!({"stepover_mm": 1.0, "tool_radius_mm": 9, "surface": "flat"});
    close(
        &found["scallop_height_um"],
        answer(&app, SCALLOP, &ball).await["scallop_height_um"].as_f64().unwrap(),
    );
    let mut smallest = body.clone();
    smallest["tool_radius_mm"] = found["min_tool_radius_mm"].clone();
    close(&answer(&app, SCALLOP, &smallest).await["scallop_height_um"], 10.0);
    let mut wide = body.clone();
    wide["stepover_mm"] = json!(10.5);
    assert_eq!(pointers(&refused(&app, SCALLOP, &wide).await), ["/stepover_mm"]);
    let mut flat = body.clone();
    flat["lead_deg"] = json!(0);
    assert_eq!(pointers(&refused(&app, SCALLOP, &flat).await), ["/lead_deg"]);
    flat.as_object_mut().unwrap().remove("lead_deg");
    assert_eq!(pointers(&refused(&app, SCALLOP, &flat).await), ["/lead_deg"]);
    // A ball needs none.
    flat["corner_radius_mm"] = json!(5);
    close(&answer(&app, SCALLOP, &flat).await["effective_radius_mm"], 5.0);
}

#[tokio::test]
async fn every_bad_element_is_named() {
    let app = spawn().await;
    let base =
        json!({"stepover_mm": 0.1, "tool_radius_mm": 5, "surface": "concave", "surface_radius_mm": 10});
    let with = |more: Value| with(base.clone(), &more);
    for (more, expected) in [
        (json!({"stepover_mm": [0.1, 0.2, 0.3, -1, 0.5]}), vec!["/stepover_mm/3"]),
        (json!({"stepover_mm": [0.1, 10.0, 0.3, 20.5]}), vec!["/stepover_mm/3"]),
        (json!({"stepover_mm": [-1, 0.1, -1]}), vec!["/stepover_mm/0", "/stepover_mm/2"]),
        (
            json!({"stepover_mm": 3, "tool_radius_mm": [5, 1, 12]}),
            vec!["/tool_radius_mm/1", "/tool_radius_mm/2"],
        ),
        (json!({"tool_radius_mm": 0}), vec!["/tool_radius_mm"]),
        (json!({"surface_radius_mm": 0}), vec!["/surface_radius_mm"]),
        (json!({"surface_radius_mm": 4}), vec!["/tool_radius_mm"]),
        (json!({"surface_radius_mm": [10, 4, -2]}), vec!["/surface_radius_mm/2", "/surface_radius_mm/1"]),
        (json!({"tool_radius_mm": 12, "stepover_mm": [0.1, 0.2]}), vec!["/tool_radius_mm"]),
        (json!({"stepover_mm": 30, "allowed_scallop_um": [1, 2, 3]}), vec!["/stepover_mm"]),
        (json!({"stepover_mm": [0.1, 0.2], "tool_radius_mm": [1, 2, 3]}), vec!["/stepover_mm"]),
        (json!({"surface": "flat"}), vec!["/surface_radius_mm"]),
        (json!({"surface_radius_mm": null}), vec!["/surface_radius_mm"]),
        (json!({"corner_radius_mm": [1, 6], "lead_deg": 60}), vec!["/corner_radius_mm/1"]),
        (json!({"allowed_scallop_um": -1}), vec!["/allowed_scallop_um"]),
        (json!({"stepover_mm": [0.1, "x"]}), vec!["/stepover_mm/1"]),
        (json!({"stepover_mm": [0.1, null]}), vec!["/stepover_mm/1"]),
        (json!({"stepover_mm": []}), vec!["/stepover_mm"]),
        (json!({"stepover_mm": {"x": 1}}), vec!["/stepover_mm"]),
        (json!({"surface": "wavy"}), vec!["/surface"]),
        (json!({"colour": 1}), vec!["/colour"]),
    ] {
        let body = with(more);
        let found = refused(&app, SCALLOP, &body).await;
        assert_eq!(pointers(&found), expected, "{body}");
    }
    let gouge = refused(&app, SCALLOP, &with(json!({"surface_radius_mm": 4}))).await;
    assert!(gouge["detail"].as_str().unwrap().contains("at most 4 mm"), "{gouge}");
    let apart = refused(&app, SCALLOP, &with(json!({"stepover_mm": 25}))).await;
    assert!(apart["detail"].as_str().unwrap().contains("the limit is 20 mm"), "{apart}");
    let missing = refused(&app, SCALLOP, &json!({"tool_radius_mm": 5, "surface": "flat"})).await;
    assert_eq!(pointers(&missing), ["/stepover_mm"]);
    let huge = app
        .post_text(
            SCALLOP,
            "application/json",
            r#"{"stepover_mm": [0.1, 1e999], "tool_radius_mm": 5, "surface": "flat"}"#,
        )
        .await;
    assert_eq!(pointers(&problem(huge, "invalid-request").await), ["/stepover_mm/1"]);
}

#[tokio::test]
async fn the_figure_runs_over_the_step_over_or_the_radius() {
    let app = spawn().await;
    let body = json!({"stepover_mm": 0.1, "tool_radius_mm": [4, 4.2, 4.4, 4.6, 4.8, 5], "surface": "convex", "surface_radius_mm": 10, "allowed_scallop_um": 0.4});
    let figure = |query: &'static str| {
        app.client
            .post(app.url(&format!("{SCALLOP}{query}")))
            .header("accept", "image/svg+xml")
            .json(&body)
            .send()
    };
    for (query, part) in [("", "step-over [mm]"), ("?plot=radius", "tool radius [mm]")] {
        let response = figure(query).await.unwrap();
        assert_eq!(response.headers()["content-type"], "image/svg+xml");
        let svg = response.text().await.unwrap();
        for part in [part, "scallop height [µm]", "surface radius 10 mm", "allowed 0.4 µm"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg, figure(query).await.unwrap().text().await.unwrap());
    }
    assert_eq!(
        pointers(&problem(figure("?plot=nothing").await.unwrap(), "invalid-request").await),
        ["/plot"]
    );
    let neither = app.client.post(app.url(SCALLOP)).header("accept", "text/html").json(&body).send();
    problem(neither.await.unwrap(), "not-acceptable").await;
}

#[tokio::test]
async fn too_many_elements_are_refused_before_they_are_computed() {
    let app = spawn_with(|settings| settings.max_poses = 100).await;
    let body = json!({"stepover_mm": vec![0.1; 101], "tool_radius_mm": 5, "surface": "flat"});
    let found = problem(app.post_json(SCALLOP, &body).await, "too-costly").await;
    assert!(
        found["detail"].as_str().unwrap().contains("101 elements are more than the limit of 100"),
        "{found}"
    );
    let app = spawn_with(|settings| settings.max_cost_s = 1e-3).await;
    let body = json!({"stepover_mm": vec![0.1; 1000], "tool_radius_mm": 5, "surface": "flat"});
    problem(app.post_json(SCALLOP, &body).await, "too-costly").await;
    let body = json!({"stepover_mm": vec![0.1; 100], "tool_radius_mm": 5, "surface": "flat"});
    answer(&app, SCALLOP, &body).await;
}

const ADVICE: &str = "/v1/wear-advice";

fn question() -> Value {
    json!({"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.75}, "stepover_mm": 0.893_532_316,
        "surface": "flat", "allowed_scallop_um": 20})
}

/// `base` with the members of `more`.
fn with(mut base: Value, more: &Value) -> Value {
    for (name, value) in more.as_object().unwrap() {
        base[name] = value.clone();
    }
    base
}

#[tokio::test]
async fn advice_goes_from_keeping_to_changing_as_the_tool_wears() {
    let app = spawn().await;
    for (radius, advice) in [
        (4.999_999, "reduce-stepover"),
        (4.75, "reduce-stepover"),
        (4.5, "reduce-stepover"),
        (4.0, "change-tool"),
    ] {
        let found =
            answer(&app, ADVICE, &with(question(), &json!({"actual_tool": {"radius_mm": radius}}))).await;
        assert_eq!(found["advice"], advice, "{found}");
        close(&found["nominal"]["scallop_height_um"], 20.0);
        close(&found["min_tool_radius_mm"], 5.0);
        // contact angles up to 90° unless said
        let most_um = found["offset"]["max_um"].as_f64().unwrap();
        assert!((most_um - (5.0 - radius) * 1e3).abs() < 1e-9, "{found}");
        if advice == "change-tool" {
            assert_eq!(found["stepover_mm"], Value::Null);
            close(&found["residual_after_um"], 20.0);
            continue;
        }
        close(&found["residual_after_um"], 20.0);
        // What is left by the step-over advised, asked from the other operation.
        let again = json!({"stepover_mm": found["stepover_mm"], "tool_radius_mm": radius, "surface": "flat"});
        close(&answer(&app, SCALLOP, &again).await["scallop_height_um"], 20.0);
    }
    let allowed = with(question(), &json!({"allowed_scallop_um": 30}));
    let found = answer(&app, ADVICE, &allowed).await;
    assert_eq!(found["advice"], "compensate");
    assert!(found["residual_before_um"].as_f64().unwrap() > 250.0, "{found}");
    assert!(found["residual_after_um"].as_f64().unwrap() < 22.0, "{found}");
    assert!(found["detail"].as_str().unwrap().contains("instead of"), "{found}");
    // On a part that leans by at most two degrees the same wear is not seen.
    let gentle = with(allowed.clone(), &json!({"contact_angle_deg": [0, 2]}));
    assert_eq!(answer(&app, ADVICE, &gentle).await["advice"], "keep");
    // A control that has the nominal length lets a tool 0.1 mm shorter leave that much.
    let short = with(
        gentle,
        &json!({"nominal_tool": {"radius_mm": 5, "length_mm": 80}, "actual_tool": {"radius_mm": 4.75, "length_mm": 79.9}}),
    );
    let found = answer(&app, ADVICE, &short).await;
    assert_eq!(found["advice"], "compensate");
    close(&found["offset"]["max_um"], 100.0 + 150.0 * (1.0 - 2.0_f64.to_radians().cos()));
    // A step-over that is worth running all the same.
    let patient = with(question(), &json!({"actual_tool": {"radius_mm": 4}, "min_stepover_mm": 0.5}));
    assert_eq!(answer(&app, ADVICE, &patient).await["advice"], "reduce-stepover");
}

#[tokio::test]
async fn a_larger_tool_gouges_until_it_is_compensated() {
    let app = spawn().await;
    let reground = with(question(), &json!({"actual_tool": {"radius_mm": 5.001}, "allowed_scallop_um": 30}));
    let found = answer(&app, ADVICE, &reground).await;
    assert_eq!(found["advice"], "compensate", "{found}");
    close(&found["offset"]["min_um"], -1.0);
    // Inclined, a new corner makes the cutter flatter than the hollow.
    let hollow = json!({"nominal_tool": {"radius_mm": 5, "corner_radius_mm": 4.5}, "actual_tool": {"radius_mm": 5, "corner_radius_mm": 1},
        "stepover_mm": 0.5, "surface": "concave", "surface_radius_mm": 12, "lead_deg": 5, "allowed_scallop_um": 20});
    let found = answer(&app, ADVICE, &hollow).await;
    assert_eq!((&found["advice"], &found["actual"]), (&json!("change-tool"), &Value::Null));
    assert!(found["detail"].as_str().unwrap().contains("gouges"), "{found}");
}

#[tokio::test]
async fn every_bad_value_of_a_question_for_advice_is_named() {
    let app = spawn().await;
    for (more, expected) in [
        (
            json!({"nominal_tool": {"radius_mm": 0}, "actual_tool": {"radius_mm": 4, "corner_radius_mm": 4.1}}),
            vec!["/nominal_tool/radius_mm", "/actual_tool/corner_radius_mm"],
        ),
        (
            json!({"actual_tool": {"radius_mm": 5, "corner_radius_mm": 1}}),
            vec!["/nominal_tool/corner_radius_mm", "/lead_deg"],
        ),
        (
            json!({"nominal_tool": {"radius_mm": 5, "corner_radius_mm": 5}, "actual_tool": {"radius_mm": 5, "corner_radius_mm": 1}, "lead_deg": 0}),
            vec!["/lead_deg"],
        ),
        (json!({"stepover_mm": 11}), vec!["/stepover_mm"]),
        (json!({"stepover_mm": -1, "allowed_scallop_um": 0}), vec!["/stepover_mm", "/allowed_scallop_um"]),
        (json!({"surface": "concave"}), vec!["/surface_radius_mm"]),
        (json!({"surface_radius_mm": 10}), vec!["/surface_radius_mm"]),
        (json!({"surface": "concave", "surface_radius_mm": 4.9}), vec!["/nominal_tool/radius_mm"]),
        (json!({"contact_angle_deg": [20, 10]}), vec!["/contact_angle_deg"]),
        (json!({"contact_angle_deg": [0, 91]}), vec!["/contact_angle_deg/1"]),
        (json!({"contact_angle_deg": [0]}), vec!["/contact_angle_deg"]),
        (json!({"nominal_tool": {"radius_mm": 5, "length_mm": -1}}), vec!["/nominal_tool/length_mm"]),
        (json!({"nominal_tool": {"radius_mm": 5, "teeth": 2}}), vec!["/nominal_tool/teeth"]),
        (json!({"actual_tool": {}}), vec!["/actual_tool/radius_mm"]),
        (json!({"min_stepover_mm": -1}), vec!["/min_stepover_mm"]),
    ] {
        let body = with(question(), &more);
        assert_eq!(pointers(&refused(&app, ADVICE, &body).await), expected, "{body}");
    }
}
