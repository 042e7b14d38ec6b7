//! Surfaces that were made to be searched for ever, over HTTP.

use std::fmt::Write as _;
use std::io::Write;
use std::sync::Arc;

use flate2::Compression;
use flate2::write::GzEncoder;
use reqwest::Response;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::queue::{Held, spawn_held};
use crate::support::{App, problem, spawn_real_with};

const MACHINE: &str = "/v1/machines/example-ac-table";

/// Copies of one facet, as a binary file.
fn copies(count: u32, raised_by: impl Fn(u32) -> f32) -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file.extend(count.to_le_bytes());
    for k in 0..count {
        let z = raised_by(k);
        for vector in [[0.0; 3], [-40.0, -40.0, z - 1.0], [40.0, -40.0, z + 0.5], [0.0, 40.0, z + 0.5]] {
            file.extend(vector.into_iter().flat_map(f32::to_le_bytes));
        }
        file.extend([0; 2]);
    }
    file
}

fn program(blocks: u32) -> String {
    let mut text = String::from("G21 G90 G94\nG0 X0 Y0 Z20 A0 C0\nG1 X0 Y0 Z0 A5 C5 F1000\n");
    for k in 0..blocks {
        writeln!(text, "G1 X{} Y0.2 Z0 A{} C{}", f64::from(k % 40) * 0.05, 5 + k % 7, 5 + k % 11).unwrap();
    }
    text
}

async fn post(app: &App, operation: &str, parameters: &Value, program: &str, surface: &[u8]) -> Response {
    let form = Form::new()
        .text("parameters", parameters.to_string())
        .part("program", Part::text(program.to_owned()).file_name("a.nc"))
        .part("surface", Part::bytes(surface.to_vec()).file_name("part.stl"));
    app.client.post(app.url(&format!("{MACHINE}/{operation}"))).multipart(form).send().await.unwrap()
}

/// Every operation that looks for contacts on a part, and one that samples it.
fn operations() -> [(&'static str, Value); 4] {
    let tools = json!({"nominal_tool": {"radius_mm": 5, "corner_radius_mm": 1},
        "actual_tool": {"radius_mm": 4.9, "corner_radius_mm": 0.9}, "contact": "surface", "contact_gap_um": 2000});
    let mut step = tools.clone();
    step.as_object_mut().unwrap().remove("contact_gap_um");
    let set_up = json!({"work_offset_mm": [0, 0, 0], "interpolation": "tcp"});
    let with = |more: Value| {
        let mut all = set_up.clone();
        all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        all
    };
    [
        (
            "cc-compensation",
            with(
                json!({"tool_radius_mm": 5, "corner_radius_mm": 1, "contact": "surface", "contact_gap_um": 2000}),
            ),
        ),
        ("wear-compensation", with(tools)),
        ("compensation", with(json!({"wear": step, "contact_gap_um": 2000}))),
        ("verification", with(json!({"tool": {"radius_mm": 5}, "samples": 2000}))),
    ]
}

#[tokio::test]
async fn twenty_thousand_copies_of_a_facet_cost_what_they_are_allowed() {
    let surface = copies(20_000, |_| 0.0);
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&surface).unwrap();
    assert!(packed.finish().unwrap().len() < 8000, "a small request in the wire");
    // A thirtieth of the default.
    let real = Arc::new(CutterContactCompensator::default());
    let app = spawn_real_with(|settings| settings.max_cost_s = 4.0, real).await;
    for (operation, parameters) in operations() {
        let response = post(&app, operation, &parameters, &program(300), &surface).await;
        let status = response.status();
        let body = response.text().await.unwrap();
        let is_costly = status == 422 && body.contains("\"/problems/too-costly\"");
        assert!(status.is_success() || is_costly, "{operation}: {status} {body}");
    }
}

#[tokio::test]
async fn a_search_over_its_limit_is_refused_with_the_count_and_keeps_nothing() {
    // Each facet a little nearer than the one before: none can be passed over.
    let surface = copies(20_000, |k| -1e-5 * k as f32);
    let real = Arc::new(CutterContactCompensator { budget: trunnion::jobs::Cost::budget_within(0.1) });
    let app = spawn_real_with(|settings| settings.max_cost_s = 0.1, real).await;
    for (operation, parameters) in operations().into_iter().take(3) {
        let mut details = Vec::new();
        for _ in 0..2 {
            let response = post(&app, operation, &parameters, &program(200), &surface).await;
            details.push(problem(response, "too-costly").await["detail"].clone());
        }
        let detail = details[0].as_str().unwrap();
        assert!(detail.contains("steps of the search for contacts on the surface"), "{operation}: {detail}");
        assert!(detail.contains("max_cost_s"), "{operation}: {detail}");
        assert_eq!(details[0], details[1], "{operation}");
    }
    assert_eq!(app.files().0, 0);
}

#[tokio::test]
async fn what_nothing_counts_is_stopped_by_its_processor_time() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |settings| settings.max_cost_s = 0.02).await;
    let path = format!("{MACHINE}/cc-compensation?tool_radius_mm=5");
    let body = problem(app.post_text(&path, "text/plain", "SPIN\n").await, "too-costly").await;
    let detail = body["detail"].as_str().unwrap();
    assert!(detail.contains("s of processor time") && detail.contains("1.000 s"), "{detail}");
    // Its place is free again.
    assert!(app.post_text(&path, "text/plain", "g1\n").await.status().is_success());
}
