//! The gallery of figures: `docs/figures.md` shows each figure as the service draws it from the example programs. The
//! files in `docs/figures` are those figures, byte for byte. `BLESS=1 cargo test --test api gallery` writes them again.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use reqwest::RequestBuilder;
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::support::{App, ac_table, program_form, spawn_real};

const BLADE: &str = include_str!("../../docs/examples/blade.nc");
const DOME: &str = include_str!("../../docs/examples/dome.nc");
const BALLBAR: &str = include_str!("../../docs/examples/ballbar.json");
const MACHINE: &str = "/v1/machines/example-ac-table";
const RUNS: &str = "/v1/machines/example-ac-table/calibrations";
const SVG: &str = "image/svg+xml";

/// A figure of the gallery and the file that shows it.
type Figure = (&'static str, String);

/// Files in the folder that other commands make.
const OTHERS: [&str; 1] = ["growth.svg"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/figures")
}

/// The figure that a request answers with.
async fn drawn(request: RequestBuilder) -> String {
    let response = request.header("accept", SVG).send().await.unwrap();
    let status = response.status();
    let text = response.text().await.unwrap();
    assert_eq!(status, 200, "{text}");
    text
}

async fn of_program(app: &App, operation: &str, query: &str, program: &'static str) -> String {
    let url = app.url(&format!("{MACHINE}/{operation}?{query}"));
    drawn(app.client.post(url).header("content-type", "text/plain").body(program)).await
}

async fn of_json(app: &App, path: &str, body: &Value) -> String {
    drawn(app.client.post(app.url(path)).json(body)).await
}

async fn of_programs(app: &App) -> Vec<Figure> {
    const OFFSET: &str = "work_offset_mm=12,-7,35";
    let mut profile = ac_table();
    let errors = json!({"e_x_um": 12.0, "e_y_um": -21.0, "e_z_um": 34.0, "e_a_urad": 41.0, "e_b_urad": -63.0, "e_c_urad": 29.0});
    profile["kinematics"]["rotary_axes"][0]["location_error"] = errors;
    let put = app.put_machine("calibrated", &profile).await;
    assert_eq!(put.status(), 201);
    let one_pass = app.url(&format!("/v1/machines/calibrated/compensation?{OFFSET}&wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.9&location_errors=true&cc.tolerance_um=5"));
    let one_pass = app.client.post(one_pass).header("content-type", "text/plain").body(BLADE);
    let cc = format!("{OFFSET}&tool_radius_mm=5");
    let wear = format!("{OFFSET}&nominal_tool.radius_mm=5&actual_tool.radius_mm=4.75");
    let dome = format!(
        "{OFFSET}&surface.kind=sphere&surface.radius_mm=20&surface.half_angle_deg=20&tool.radius_mm=4.5"
    );
    let servo = app.url(&format!("{MACHINE}/servo-simulation"));
    let form = program_form(&json!({"work_offset_mm": [12, -7, 35]}), BLADE, "blade.nc");
    vec![
        ("cc-compensation.svg", of_program(app, "cc-compensation", &cc, BLADE).await),
        ("wear-compensation.svg", of_program(app, "wear-compensation", &wear, BLADE).await),
        ("one-pass.svg", drawn(one_pass).await),
        ("verification.svg", of_program(app, "verification", &dome, DOME).await),
        ("servo-program.svg", drawn(app.client.post(servo).multipart(form)).await),
    ]
}

async fn of_servo(app: &App) -> Vec<Figure> {
    let circle = json!({"kind": "xc-circle", "radius_mm": 60, "center_x_mm": 100});
    let run = json!({"machine_id": "example-ac-table", "path": circle, "feed_mm_per_min": 1800,
        "position_gain_scale": {"C": 0.8333}});
    let corner = json!({"machine_id": "example-ac-table", "feed_mm_per_min": 1200, "path": {"kind": "polyline", "plane": "xy",
        "points": [{"x": 0, "y": 0, "z": 0}, {"x": 20, "y": 0, "z": 0}, {"x": 20, "y": 20, "z": 0}]}});
    let sweep = json!({"machine_id": "example-ac-table", "path": circle,
        "feed_mm_per_min": [600, 1200, 1800, 2400, 3000],
        "position_gain_scale": {"C": [0.8, 0.9, 1.0, 1.1, 1.2]}});
    let (simulate, sweeps) = ("/v1/servo-simulations", "/v1/servo-sweeps");
    vec![
        ("servo-circle.svg", of_json(app, simulate, &run).await),
        ("servo-following.svg", of_json(app, &format!("{simulate}?plot=following-error"), &run).await),
        ("servo-corner.svg", of_json(app, simulate, &corner).await),
        ("servo-sweep-curves.svg", of_json(app, sweeps, &sweep).await),
        ("servo-sweep-map.svg", of_json(app, &format!("{sweeps}?plot=map"), &sweep).await),
    ]
}

/// The example run, measured later on a machine whose A axis has moved along Y.
fn later(measured_at: &str, moved_um: f64) -> Value {
    let mut run: Value = serde_json::from_str(BALLBAR).unwrap();
    run["measured_at"] = measured_at.into();
    let radial = &mut run["tests"][2];
    assert_eq!((&radial["rotary_axis"], &radial["bar_direction"]), (&json!("A"), &json!("radial")));
    for reading in radial["readings"].as_array_mut().unwrap() {
        let sin = reading["angle_deg"].as_f64().unwrap().to_radians().sin();
        // Readings have a resolution.
        let read = reading["length_change_um"].as_f64().unwrap() - moved_um * sin;
        reading["length_change_um"] = ((read * 10.0).round() / 10.0).into();
    }
    run
}

async fn of_calibration(app: &App) -> Vec<Figure> {
    let mut first = String::new();
    let months = [("03-14T09:26", 0.0), ("04-15T07:50", 3.1), ("05-13T08:10", 4.4), ("06-17T08:02", 7.9)];
    for (place, (month, moved_um)) in months.into_iter().enumerate() {
        let run = later(&format!("2025-{month}:00Z"), moved_um);
        let posted = app.post_json(RUNS, &run).await;
        let document: Value = posted.json().await.unwrap();
        let id = document["id"].as_str().unwrap();
        if place == 0 || place == 2 {
            let apply = app.client.post(app.url(&format!("{RUNS}/{id}/apply"))).header("if-match", "*");
            assert_eq!(apply.send().await.unwrap().status(), 200);
        }
        if place == 0 {
            first = format!("{RUNS}/{id}");
        }
    }
    let get = |path: String| drawn(app.client.get(app.url(&path)));
    vec![
        ("calibration-eccentricities.svg", get(first.clone()).await),
        ("calibration-residuals.svg", get(format!("{first}?plot=residuals&test=0")).await),
        ("calibration-trend.svg", get(format!("{RUNS}/trend?axis=A&error=e_y&tolerance_um=30")).await),
    ]
}

async fn of_wear(app: &App) -> Vec<Figure> {
    let tool = format!("{MACHINE}/tools/T12");
    let measured = [24.5, 27.6, 32.2, 36.0, 39.7].into_iter().zip(0..);
    let entries: Vec<Value> = measured
        .map(|(wear_um, day)| {
            let at = format!("2025-03-1{day}T08:00:00Z");
            json!({"measured_at": at, "parts_cut": 20 * (day + 1), "radius_wear_um": wear_um})
        })
        .collect();
    assert_eq!(app.post_json(&format!("{tool}/wear-entries"), &json!(entries)).await.status(), 201);
    let trend = app.client.get(app.url(&format!("{tool}/wear-trend?limit_um=60")));
    let scallop = json!({"stepover_mm": [0.4, 0.8], "tool_radius_mm": 4.75, "surface": "convex",
        "surface_radius_mm": 40, "allowed_scallop_um": 20});
    vec![
        ("wear-trend.svg", drawn(trend).await),
        ("scallop-height.svg", of_json(app, "/v1/scallop-height", &scallop).await),
    ]
}

#[tokio::test]
async fn the_gallery_shows_the_figures_as_they_are_drawn() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let mut figures = of_programs(&app).await;
    figures.extend(of_servo(&app).await);
    figures.extend(of_calibration(&app).await);
    figures.extend(of_wear(&app).await);
    let bless = std::env::var_os("BLESS").is_some();
    for (name, svg) in &figures {
        assert!(
            svg.contains("<title>") && svg.contains("<desc>") && svg.contains("prefers-color-scheme"),
            "{name}"
        );
        let file = folder().join(name);
        if bless {
            std::fs::write(&file, svg).unwrap();
        }
        let stored = std::fs::read_to_string(&file).unwrap_or_default();
        assert!(
            stored == *svg,
            "docs/figures/{name} is not what is drawn; write it again with BLESS=1, and look at it"
        );
    }
    let page = std::fs::read_to_string(folder().with_file_name("figures.md")).unwrap();
    let names: BTreeSet<String> = figures.iter().map(|(name, _)| (*name).to_owned()).collect();
    for name in &names {
        assert!(page.contains(&format!("](figures/{name})")), "docs/figures.md does not show {name}");
    }
    let files =
        std::fs::read_dir(folder()).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
    let unknown: Vec<String> =
        files.filter(|file| !names.contains(file) && !OTHERS.contains(&file.as_str())).collect();
    assert!(unknown.is_empty(), "no test draws {unknown:?}");
}
