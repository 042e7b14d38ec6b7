//! Calibration runs as people file them and as monitoring sees them: the report, tables of runs, ages in the metrics.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::calibrations::{RUNS, sweeps};
use crate::support::{App, ac_table, pointers, problem, spawn};

/// A run of which everything is stated.
fn stated_run() -> Value {
    let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
    for (name, value) in [
        ("instrument", json!("QC20-W")),
        ("instrument_serial_number", json!("BB-4711")),
        ("instrument_certificate", json!("D-K-15133-2025-03")),
        ("operator", json!("M. Huber")),
        ("temperature_c", json!(20.1)),
        ("instrument_uncertainty_um", json!(0.5)),
        ("setup_uncertainty_um", json!(1.0)),
        ("ball_uncertainty_mm", json!(0.5)),
        ("bar_length_uncertainty_mm", json!(0.1)),
    ] {
        run[name] = value;
    }
    run
}

async fn post(app: &App, runs: &str, run: &Value) -> Value {
    let response = app.post_json(runs, run).await;
    let status = response.status();
    let document: Value = response.json().await.unwrap();
    assert_eq!(status, StatusCode::CREATED, "{document}");
    document
}

async fn accepted(app: &App, path: &str, accept: &str) -> reqwest::Response {
    let response = app.client.get(app.url(path)).header("accept", accept).send().await.unwrap();
    assert_eq!(response.status(), StatusCode::OK, "{path}");
    response
}

async fn report(app: &App, runs: &str, run: &Value) -> String {
    let path = format!("{runs}/{}", run["id"].as_str().unwrap());
    let text = accepted(app, &path, "text/html").await.text().await.unwrap();
    assert!(text.starts_with("<!doctype html>") && !text.contains("NaN") && !text.contains("inf"), "{text}");
    text
}

/// The text of a cell without its markup.
fn plain(html: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for letter in html.chars() {
        match letter {
            '<' => inside = true,
            '>' => inside = false,
            letter if !inside => text.push(letter),
            _ => {}
        }
    }
    text.replace('−', "-").replace("&gt; ", "")
}

/// The rows of the table of this class, without its head.
fn rows(page: &str, class: &str) -> Vec<Vec<String>> {
    let table = page.split(&format!("<table class={class}>")).nth(1).unwrap();
    let body = table.split("<tbody>").nth(1).unwrap().split("</tbody>").next().unwrap();
    let rows = body.split("<tr>").skip(1);
    rows.map(|row| row.split("</td>").map(plain).map(|cell| cell.trim().to_owned()).collect::<Vec<_>>())
        .map(|mut row| {
            row.retain(|cell| !cell.is_empty());
            row
        })
        .collect()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap()
}

/// The current profile of a machine without the members of its revision, and its tag.
async fn profile(app: &App, id: &str) -> (Value, String) {
    let response = app.get(&format!("/v1/machines/{id}")).await;
    let tag = response.headers()["etag"].to_str().unwrap().to_owned();
    let mut document: Value = response.json().await.unwrap();
    for name in ["machine_id", "revision", "created_at"] {
        document.as_object_mut().unwrap().remove(name);
    }
    (document, tag)
}

#[tokio::test]
async fn a_report_has_all_that_was_stated_and_an_uncertainty_that_adds_up() {
    let app = spawn().await;
    let (mut machine, tag) = profile(&app, "example-ac-table").await;
    machine["name"] = json!("DMU 80 <T>");
    machine["serial_number"] = json!("1138-5519");
    machine["asset_id"] = json!("EQ-004711");
    machine["calibration_due_days"] = json!(90);
    // E_Z0A is near 30 µm, E_Y0A near −20 µm, E_B0A near 0.
    machine["calibration_limits"] = json!({"E_Z0A_um": 12, "E_Y0A_um": 20.5, "E_B0A_urad": 60});
    let put = app.client.put(app.url("/v1/machines/example-ac-table")).header("if-match", tag);
    assert_eq!(put.json(&machine).send().await.unwrap().status(), StatusCode::OK);

    let document = post(&app, RUNS, &stated_run()).await;
    assert_eq!(document["instrument_serial_number"], "BB-4711");
    // The same readings alone: their standard uncertainty is Type A.
    let alone = post(&app, RUNS, &sweeps([10.0, -20.0, 30.0], 0.5)).await;
    assert_eq!(alone.get("instrument_serial_number"), None);

    let page = report(&app, RUNS, &document).await;
    for text in [
        "DMU 80 &lt;T&gt;",
        "1138-5519",
        "EQ-004711",
        "BB-4711",
        "D-K-15133-2025-03",
        "M. Huber",
        "20.1 °C",
        "100 mm",
        "150, 0, 100",
        "2025-04-01 00:00 UTC",
        "2025-06-30, 90 days after this measurement",
        "not applied",
        "<i>E</i><sub>C0A</sub> [µrad]",
        "0.5 µm as stated with the run",
        "1 µm in each component of the given values",
        "<svg",
    ] {
        assert!(page.contains(text), "{text:?} is missing in {page}");
    }
    assert!(!page.contains("missing</b>"), "{page}");

    let (results, budget) = (rows(&page, "results"), rows(&page, "budget"));
    let names: Vec<&String> = document["iso_230"].as_object().unwrap().keys().collect();
    assert_eq!((results.len(), budget.len()), (names.len(), names.len()));
    for (name, (result, budget)) in names.iter().zip(results.iter().zip(&budget)) {
        let symbol = name.trim_start_matches("E_").split('_').next().unwrap();
        assert!(result[0].starts_with(&format!("E{symbol} [µ")), "{result:?}");
        let estimate = &document["iso_230"][name.as_str()];
        let (value, expanded) = (number(&result[2]), number(&result[3]));
        // Half of the last digit, which is the second of U.
        let half_a_digit = 0.06 * expanded;
        assert!((value - estimate["value"].as_f64().unwrap()).abs() <= half_a_digit, "{name}: {result:?}");
        let [readings, instrument, setup, ball, bar, combined, degrees, twice] =
            [1, 2, 3, 4, 5, 6, 7, 8].map(|column| number(&budget[column]));
        // Half of the last digit, which is the third of the combined uncertainty; of a sum, a little more.
        let close = |found: f64, expected: f64| (found - expected).abs() <= 0.012 * combined;
        let type_a = alone["iso_230"][name.as_str()]["standard_uncertainty"].as_f64().unwrap();
        assert!(close(readings, type_a), "{name}: {readings} is not {type_a}");
        let with_instrument = estimate["standard_uncertainty"].as_f64().unwrap();
        assert!(close(readings.hypot(instrument), with_instrument), "{name}: {budget:?}");
        let squares: f64 = [readings, instrument, setup, ball, bar].iter().map(|part| part * part).sum();
        assert!(close(squares.sqrt(), combined), "{name}: {budget:?}");
        assert!(close(0.5 * twice, combined), "{name}: {budget:?}");
        assert!((expanded / twice - 1.0).abs() < 0.06, "{name}: {result:?}, {budget:?}");
        let freedom = document["degrees_of_freedom"].as_f64().unwrap();
        assert!(degrees >= freedom - 1.0, "{name}: {budget:?}");
    }
    let verdict = |symbol: &str| {
        let row = results.iter().find(|row| row[0].starts_with(symbol)).unwrap();
        (row[4].clone(), row[5].clone())
    };
    let said = |limit: &str, verdict: &str| (limit.to_owned(), verdict.to_owned());
    assert_eq!(verdict("EZ0A"), said("±12", "outside"));
    assert_eq!(verdict("EY0A"), said("±20.5", "not proven"));
    assert_eq!(verdict("EB0A"), said("±60", "within"));
    assert_eq!(verdict("EC0A"), said("–", "no limit stated"));
    // The same bytes again.
    assert_eq!(report(&app, RUNS, &document).await, page);
}

#[tokio::test]
async fn a_report_says_what_is_missing() {
    let app = spawn().await;
    let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
    run["setup_error_um"] = Value::Null;
    let page = report(&app, RUNS, &post(&app, RUNS, &run).await).await;
    for text in [
        "<b>missing</b>: it was not stated with the run (<code>instrument_uncertainty_um</code>)",
        "<b>missing</b>: it is not known and held at zero",
        "<code>ball_uncertainty_mm</code>",
        "<code>bar_length_uncertainty_mm</code>",
        "no period stated",
        "not stated",
        "cannot be separated from the set-up error",
        "a spindle step",
    ] {
        assert!(page.contains(text), "{text:?} is missing in {page}");
    }
    let open: Vec<String> = rows(&page, "results")
        .into_iter()
        .map(|row| row[0].clone())
        .filter(|symbol| symbol.contains('†'))
        .collect();
    assert_eq!(open, ["EX0C [µm] †", "EY0A [µm] †", "EY0C [µm] †"]);

    // Eccentricities leave no scatter: nothing is stated from the other sources alone.
    let mut short = run.clone();
    short["setup_error_um"] = json!({"e_xs": 0, "e_ys": 0});
    short["instrument_uncertainty_um"] = json!(0.5);
    for test in short["tests"].as_array_mut().unwrap() {
        test.as_object_mut().unwrap().remove("readings");
        test["eccentricity_um"] = json!([1.0, -2.0]);
    }
    let page = report(&app, RUNS, &post(&app, RUNS, &short).await).await;
    assert!(page.contains("there are as many unknowns as readings"), "{page}");
    assert!(rows(&page, "results").iter().all(|row| row[3] == "not known"), "{page}");

    // Probed spheres have a scatter and nothing else.
    let centres: Vec<Value> = (0..6_i32)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 60.0).to_radians().sin_cos();
            let noise = f64::from(k * 7 % 5) * 1e-3;
            json!({"centre_mm": [140.0 * cos + 0.02, -140.0 * sin, 50.0 + noise]})
        })
        .collect();
    let spheres = json!({
        "kind": "rotary-sphere", "measured_at": "2025-05-01T00:00:00Z",
        "axes": [{"rotary_axis": "C", "centres": centres}]
    });
    let page = report(&app, RUNS, &post(&app, RUNS, &spheres).await).await;
    assert!(page.contains("a run of probed spheres states none"), "{page}");
    assert!(page.contains("Few readings"), "{page}");
    assert_eq!(rows(&page, "spheres")[0][1], "6");
}

#[tokio::test]
async fn wrong_uncertainties_and_limits_are_named() {
    let app = spawn().await;
    for (member, value) in [
        ("setup_uncertainty_um", json!(-1)),
        ("ball_uncertainty_mm", json!(101)),
        ("bar_length_uncertainty_mm", json!(51)),
        ("instrument_serial_number", json!("x".repeat(201))),
        ("instrument_certificate", json!("x".repeat(201))),
    ] {
        let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
        run[member] = value;
        let refused = problem(app.post_json(RUNS, &run).await, "invalid-request").await;
        assert_eq!(pointers(&refused), [format!("/{member}")]);
    }
    // A spindle step measures what would be stated.
    let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
    run["setup_error_um"] =
        json!({"spindle_deg": [0, 90, 180, 270], "bar_direction": "x", "length_change_um": [0, 1, 2, 1]});
    run["setup_uncertainty_um"] = json!(1);
    let refused = problem(app.post_json(RUNS, &run).await, "invalid-request").await;
    assert_eq!(pointers(&refused), ["/setup_uncertainty_um"]);
    let mut machine = ac_table();
    machine["calibration_limits"] = json!({"E_X0B_um": 1, "E_X0C_um": 0, "E_Y0C_um": 5});
    let refused = problem(app.put_machine("m", &machine).await, "invalid-machine").await;
    assert_eq!(pointers(&refused), ["/calibration_limits/E_X0B_um", "/calibration_limits/E_X0C_um"]);
}

#[tokio::test]
async fn a_report_names_the_key_that_applied_the_run() {
    let mut app = spawn().await;
    let document = post(&app, RUNS, &sweeps([10.0, -20.0, 30.0], 0.5)).await;
    let id = document["id"].as_str().unwrap();
    let apply = async |app: &App| {
        let (_, tag) = profile(app, "example-ac-table").await;
        let request = app.client.post(app.url(&format!("{RUNS}/{id}/apply"))).header("if-match", tag);
        assert_eq!(request.send().await.unwrap().status(), StatusCode::OK);
    };
    apply(&app).await;
    let page = report(&app, RUNS, &document).await;
    assert!(
        page.contains("without a key: revision 2") && page.contains("revision 2 has the errors of this run")
    );
    let key = app.close().await;
    // Going away from the run and back to it.
    let (mut machine, tag) = profile(&app, "example-ac-table").await;
    machine["kinematics"]["rotary_axes"][0]["location_error"] = json!({});
    let put = app.client.put(app.url("/v1/machines/example-ac-table")).header("if-match", tag);
    assert_eq!(put.json(&machine).send().await.unwrap().status(), StatusCode::OK);
    let page = report(&app, RUNS, &document).await;
    assert!(page.contains("revision 3 was stored without applying a run"), "{page}");
    apply(&app).await;
    let page = report(&app, RUNS, &document).await;
    let key_id = key.split('_').nth(1).unwrap();
    assert!(page.contains(&format!("by key <code>{key_id}</code>: revision 4")), "{page}");
}

#[tokio::test]
async fn runs_are_listed_as_a_table_page_by_page() {
    let app = spawn().await;
    let first = post(&app, RUNS, &stated_run()).await;
    let mut run = sweeps([11.0, -20.0, 30.0], 0.5);
    run["instrument"] = json!("=cmd()");
    let second = post(&app, RUNS, &run).await;
    let page = accepted(&app, &format!("{RUNS}?limit=1"), "text/csv").await;
    assert_eq!(page.headers()["content-type"], "text/csv");
    let cursor = page.headers()["trunnion-next-cursor"].to_str().unwrap().to_owned();
    let table = page.text().await.unwrap();
    let rest = accepted(&app, &format!("{RUNS}?limit=1&cursor={cursor}"), "text/csv").await;
    assert!(!rest.headers().contains_key("trunnion-next-cursor"));
    let rest = rest.text().await.unwrap();
    for (table, run) in [(&table, &second), (&rest, &first)] {
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let head = reader.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let [row] = rows.as_slice() else { panic!("{table}") };
        let cell = |name: &str| &row[head.iter().position(|column| column == name).unwrap()];
        assert_eq!(cell("id"), run["id"].as_str().unwrap());
        assert_eq!(cell("measured_at"), "2025-04-01T00:00:00.000Z");
        let estimate = &run["iso_230"]["E_Z0A_um"];
        // A table has every digit.
        let same = |found: f64, name: &str| found.to_bits() == estimate[name].as_f64().unwrap().to_bits();
        assert!(same(number(cell("E_Z0A_um")), "value"), "{table}");
        assert!(same(number(cell("standard_uncertainty_E_Z0A_um")), "standard_uncertainty"), "{table}");
    }
    assert!(table.contains("'=cmd()") && rest.contains("BB-4711"));
    let empty = accepted(&app, &format!("{RUNS}?kind=rotary-sphere"), "text/csv").await.text().await.unwrap();
    assert_eq!(empty.lines().count(), 1, "{empty}");
}

/// The value of the sample of a machine.
fn sample(text: &str, name: &str, machine: &str) -> Option<f64> {
    let series = format!("trunnion_calibration_{name}{{machine_id=\"{machine}\"}} ");
    text.lines().find_map(|line| line.strip_prefix(&series)).map(number)
}

#[tokio::test]
async fn the_metrics_have_the_age_of_the_newest_measurement_and_the_days_until_the_next() {
    let mut app = spawn().await;
    let mut due = ac_table();
    due["calibration_due_days"] = json!(30);
    for id in ["due", "never", "gone"] {
        app.put_machine(id, &due).await;
    }
    app.put_machine("bare", &ac_table()).await;
    // The clock of the test stands a little after 2026-02-25T06:13:20Z.
    for (machine, measured_at) in [
        ("due", "2026-02-15T06:13:20Z"),
        ("due", "2026-01-01T00:00:00Z"),
        ("example-ac-table", "2026-02-24T06:13:20Z"),
        ("gone", "2026-02-24T06:13:20Z"),
    ] {
        let mut run = sweeps([10.0, -20.0, 30.0], 0.5);
        run["measured_at"] = json!(measured_at);
        post(&app, &format!("/v1/machines/{machine}/calibrations"), &run).await;
    }
    let (_, tag) = profile(&app, "gone").await;
    app.client.delete(app.url("/v1/machines/gone")).header("if-match", tag).send().await.unwrap();

    let text = app.get("/metrics").await.text().await.unwrap();
    let near = |name: &str, machine: &str, days: f64| {
        let found = sample(&text, name, machine).unwrap_or_else(|| panic!("{name} of {machine}: {text}"));
        // Each look at the clock is a second.
        assert!((found - days).abs() < 0.01, "{name} of {machine}: {found}");
    };
    near("age_days", "due", 10.0);
    near("due_in_days", "due", 20.0);
    near("age_days", "example-ac-table", 1.0);
    near("missing", "never", 1.0);
    for (name, machine) in [
        ("due_in_days", "example-ac-table"),
        ("age_days", "never"),
        ("age_days", "bare"),
        ("missing", "bare"),
        ("missing", "due"),
        ("age_days", "gone"),
    ] {
        assert_eq!(sample(&text, name, machine), None, "{name} of {machine}");
    }
    assert!(text.contains("trunnion_calibration_machines_cut 0\n"), "{text}");

    // A key for one machine sees the calibrations of that machine.
    app.close().await;
    let key = app.new_key(&["read"], Some(&["due"])).await;
    let asked = app.client.get(app.url("/metrics")).header("authorization", format!("Bearer {key}"));
    let text = asked.send().await.unwrap().text().await.unwrap();
    assert!(sample(&text, "age_days", "due").is_some(), "{text}");
    assert!(!text.contains("example-ac-table") && !text.contains("\"never\""), "{text}");
}
