//! Pages in a browser send every field of a form, also those that a person left empty: an empty part is no part.

use reqwest::Response;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::both_ways::OPERATIONS;
use crate::support::{App, pointers, problem, spawn};

/// One milled line, and the same as cutter location data.
const MILLED: &str = "G21 G90 G54\nG1 X0 Y0 Z20 A0 C0 F500\nX1 A0.5 C1\nM30\n";
const CUTTER_LOCATIONS: &str =
    "UNITS/MM\nMULTAX/ON\nFEDRAT/500,MMPM\nGOTO/0,0,20,0,0,1\nGOTO/1,0,20,0,0,1\nFINI\n";

fn file(text: &str) -> Part {
    Part::text(text.to_owned()).file_name("part.nc")
}

/// As `FormData` of a browser has a file field for which no file was chosen, as a page has it that fills the field with an
/// empty `Blob`, and as an HTML form has it.
fn no_file() -> [Part; 3] {
    let form_data = Part::text("");
    let blob = Part::text("").file_name("blob").mime_str("application/octet-stream").unwrap();
    let html = Part::text("").file_name("").mime_str("application/octet-stream").unwrap();
    [form_data, blob, html]
}

async fn post(app: &App, operation: &str, query: &[(&str, &str)], form: Form) -> Response {
    let url = app.url(&format!("/v1/machines/example-ac-table/{operation}"));
    app.client.post(url).query(query).multipart(form).send().await.unwrap()
}

#[tokio::test]
async fn a_field_without_parameters_leaves_them_to_the_query() {
    let app = spawn().await;
    for (operation, needed) in OPERATIONS {
        let program = if operation == "posting" { CUTTER_LOCATIONS } else { MILLED };
        let alone = post(&app, operation, needed, Form::new().part("program", file(program))).await;
        let alone = (alone.status(), alone.headers().get("etag").cloned());
        assert!(alone.0 == 200 || operation == "verification", "{operation}: {}", alone.0);
        for parameters in ["", " \n", "{}", "{ }\n"] {
            let form = Form::new().text("parameters", parameters).part("program", file(program));
            let answer = post(&app, operation, needed, form).await;
            let answered = (answer.status(), answer.headers().get("etag").cloned());
            let text = answer.text().await.unwrap();
            assert_eq!(answered, alone, "{operation} with {parameters:?}: {text}");
        }
    }
}

#[tokio::test]
async fn parameters_in_two_places_are_refused() {
    let app = spawn().await;
    let form = Form::new().text("parameters", r#"{"tool_radius_mm": 5}"#).part("program", file(MILLED));
    let answer = post(&app, "cc-compensation", &[("contact", "tip")], form).await;
    let body = problem(answer, "invalid-request").await;
    assert_eq!(pointers(&body), ["/parameters"], "{body}");
    assert!(body["detail"].as_str().unwrap().contains("move all of them to one place"), "{body}");
}

#[tokio::test]
async fn a_file_that_was_not_chosen_is_not_there() {
    let app = spawn().await;
    let query = [("tool_radius_mm", "5"), ("contact", "tip"), ("work_offset_mm", "0,0,0")];
    for surface in no_file() {
        let form = Form::new().part("program", file(MILLED)).part("surface", surface);
        let answer = post(&app, "cc-compensation", &query, form).await;
        assert_eq!(answer.status(), 200, "{}", answer.text().await.unwrap());
    }
    for program in no_file() {
        let answer = post(&app, "cc-compensation", &query, Form::new().part("program", program)).await;
        let body = problem(answer, "invalid-request").await;
        assert_eq!(pointers(&body), ["/program"], "{body}");
    }
    // An empty file that was chosen is the caller's.
    let form =
        Form::new().part("program", file(MILLED)).part("surface", Part::text("").file_name("part.stl"));
    let body = problem(post(&app, "cc-compensation", &query, form).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/contact"], "{body}");
}

#[tokio::test]
async fn a_job_without_a_chosen_surface_has_none() {
    let app = spawn().await;
    let job = json!({
        "machine_id": "example-ac-table", "operation": "cc-compensation",
        "parameters": {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [0, 0, 0]}
    });
    for surface in no_file() {
        let form = Form::new().text("job", job.to_string()).part("program", file(MILLED));
        let posted = app.client.post(app.url("/v1/jobs")).multipart(form.part("surface", surface));
        let answer = posted.send().await.unwrap();
        assert_eq!(answer.status(), 202, "{}", answer.text().await.unwrap());
        let document: Value = answer.json().await.unwrap();
        assert_eq!(document["surface_sha256"], Value::Null);
    }
    let form = Form::new().text("job", "").part("program", file(MILLED));
    let answer = app.client.post(app.url("/v1/jobs")).multipart(form).send().await.unwrap();
    let body = problem(answer, "invalid-request").await;
    assert_eq!(pointers(&body), ["/job"], "{body}");
}

#[tokio::test]
async fn options_beside_a_json_body_are_refused_with_their_place() {
    let app = spawn().await;
    let machine = "/v1/machines/example-ac-table";
    let poses = json!({"poses": [{"x": 10, "y": 0, "z": 5, "i": 0, "j": 0, "k": 1}]});
    let joints = json!({"joints": [{"X": 10, "Y": 0, "Z": 5, "A": 0, "C": 0}]});
    for (operation, body) in [("inverse-kinematics", &poses), ("forward-kinematics", &joints)] {
        for (query, pointer, words) in [
            ("work_offset_mm=0,0,0", "/work_offset_mm", "move work_offset_mm from the query"),
            ("start.A=0&start.C=0", "/start", "move start from the query"),
            ("no_such_mm=1", "/no_such_mm", "unknown field"),
        ] {
            let answer = app.post_json(&format!("{machine}/{operation}?{query}"), body).await;
            let problem = problem(answer, "invalid-request").await;
            assert_eq!(pointers(&problem), [pointer], "{operation} {problem}");
            assert!(problem["errors"][0]["detail"].as_str().unwrap().contains(words), "{problem}");
        }
    }
}

#[tokio::test]
async fn an_empty_part_counts_the_same_in_every_order_and_not_too_often() {
    let app = spawn().await;
    let query = [("tool_radius_mm", "5"), ("contact", "tip"), ("work_offset_mm", "0,0,0")];
    for field in ["program", "surface", "parameters"] {
        let form = Form::new().part("program", file(MILLED)).text("parameters", "{}").text(field, "");
        let answer = post(&app, "cc-compensation", &query, form).await;
        let status = answer.status();
        assert_eq!(status, 200, "{field}: {}", answer.text().await.unwrap());
        let many = (0..17).fold(Form::new(), |form, _| form.text(field, ""));
        let answer = post(&app, "cc-compensation", &query, many.part("program", file(MILLED))).await;
        let body = problem(answer, "invalid-request").await;
        assert!(body["detail"].as_str().unwrap().contains("more than 16 parts"), "{body}");
    }
    let twice = Form::new().part("program", file(MILLED)).part("program", file(MILLED));
    let body = problem(post(&app, "cc-compensation", &query, twice).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/program"], "{body}");
}
