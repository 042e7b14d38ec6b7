//! Programs of several files: in fields of a form, or in one archive.

use std::io::{Cursor, Read};
use std::sync::Arc;

use reqwest::multipart::{Form, Part};
use reqwest::{Response, StatusCode};
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::job_batches::archive;
use crate::queue::ended;
use crate::support::{App, pointers, problem, spawn, spawn_real, spawn_with};

const MAIN: &str = "G21 G90 G94 G17 G54\nT1 M6\nG0 X0 Y0 Z5 A0 C0\nM98 P2\nG1 X20 Y0 Z5 A10 C60 F1000\nM30\n";
const POCKET: &str = "%\nO2\nG1 X10 F500\nM98 P3\nM99\n%\n";
const CORNER: &str = "Y10\nM99\n";
/// The same motions in one text.
const WRITTEN_OUT: &str =
    "G21 G90 G94 G17 G54\nT1 M6\nG0 X0 Y0 Z5 A0 C0\nG1 X10 F500\nY10\nG1 X20 Y0 Z5 A10 C60 F1000\nM30\n";
const FILES: [(&str, &str); 2] = [("O2.nc", POCKET), ("3.NC", CORNER)];

fn part(name: &str, text: &str) -> Part {
    Part::text(text.to_owned()).file_name(name.to_owned())
}

/// A form with a program and the files that it calls.
fn form(parameters: &Value, main: &str, files: &[(&str, &str)]) -> Form {
    let form = Form::new().text("parameters", parameters.to_string()).part("program", part("main.nc", main));
    files.iter().fold(form, |form, (name, text)| form.part("subprogram", part(name, text)))
}

/// A form with an archive.
fn zipped(parameters: &Value, files: &[(&str, &str)], main: Option<&str>) -> Form {
    let files: Vec<_> = files.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
    let form = Form::new()
        .text("parameters", parameters.to_string())
        .part("program", Part::bytes(archive(&files)).file_name("part.zip"));
    match main {
        Some(main) => form.text("main", main.to_owned()),
        None => form,
    }
}

async fn post(app: &App, operation: &str, form: Form, accept: &str) -> Response {
    let url = app.url(&format!("/v1/machines/example-ac-table/{operation}"));
    app.client.post(url).header("Accept", accept).multipart(form).send().await.unwrap()
}

fn placed() -> Value {
    json!({"work_offset_mm": [12, -7, 35]})
}

async fn read(app: &App, form: Form) -> Value {
    let answer = post(app, "interpretation", form, "application/json").await;
    assert_eq!(answer.status(), StatusCode::OK);
    answer.json().await.unwrap()
}

#[tokio::test]
async fn called_files_are_followed_and_each_motion_tells_its_file_and_line() {
    let app = spawn().await;
    let found = read(&app, form(&placed(), MAIN, &FILES)).await;
    assert_eq!(found["left_alone"], json!([]));
    let motions = found["motions"].as_array().unwrap();
    let places: Vec<_> =
        motions.iter().map(|motion| (motion["file"].as_str(), motion["line"].as_u64())).collect();
    let expected =
        [(None, 3), (Some("O2.nc"), 3), (Some("3.NC"), 1), (None, 5)].map(|(file, line)| (file, Some(line)));
    assert_eq!(places, expected);
    let plain = read(&app, form(&placed(), WRITTEN_OUT, &[])).await;
    let ends = |answer: &Value| -> Vec<Value> {
        answer["motions"].as_array().unwrap().iter().map(|motion| motion["tip_mm"].clone()).collect()
    };
    assert_eq!(ends(&found), ends(&plain));
    // As a table.
    let table = post(&app, "interpretation", form(&placed(), MAIN, &FILES), "text/csv").await;
    let table = table.text().await.unwrap();
    let rows: Vec<_> =
        table.lines().skip(1).map(|row| row.split(',').take(2).collect::<Vec<_>>().join(",")).collect();
    assert_eq!(rows, ["3,", "3,O2.nc", "1,3.NC", "5,"]);
    // Without the files nothing is known after the call.
    let alone = read(&app, form(&placed(), MAIN, &[])).await;
    assert_eq!(alone["left_alone"][0]["line"], 4);
}

#[tokio::test]
async fn the_same_files_are_one_program_however_they_are_sent() {
    let app = spawn().await;
    let found = read(&app, form(&placed(), MAIN, &FILES)).await;
    let turned = [FILES[1], FILES[0]];
    let other = read(&app, form(&placed(), MAIN, &turned)).await;
    assert_eq!(found["input_sha256"], other["input_sha256"]);
    let other = read(&app, form(&placed(), MAIN, &FILES[..1])).await;
    assert_ne!(found["input_sha256"], other["input_sha256"]);
    let all = [("sub/O2.nc", POCKET), ("cut/main.nc", MAIN), ("sub/3.NC", CORNER)];
    for main in ["cut/main.nc", "MAIN.NC", "main.nc"] {
        let archived = read(&app, zipped(&placed(), &all, Some(main))).await;
        assert_eq!(archived["motions"][1]["file"], "sub/O2.nc");
        assert_eq!(archived["motions"][3]["tip_mm"], found["motions"][3]["tip_mm"], "{main}");
    }
    let one = read(&app, zipped(&placed(), &[("only.nc", WRITTEN_OUT)], None)).await;
    assert_eq!(one["motions"].as_array().unwrap().len(), 4);
}

#[tokio::test]
async fn a_simulation_and_a_verification_run_through_the_files() {
    let app = spawn().await;
    let report = async |operation: &str, parameters: &Value, main: &str, files: &[(&str, &str)]| {
        let answer = post(&app, operation, form(parameters, main, files), "application/json").await;
        assert_eq!(answer.status(), StatusCode::OK, "{operation}: {:?}", answer.text().await);
        answer.json::<Value>().await.unwrap()
    };
    let [found, plain] = [
        report("servo-simulation", &placed(), MAIN, &FILES).await,
        report("servo-simulation", &placed(), WRITTEN_OUT, &[]).await,
    ];
    assert_eq!((&found["duration_s"], &found["motions"]), (&plain["duration_s"], &plain["motions"]));
    let cut = json!({
        "work_offset_mm": [0, 0, 0], "tool": {"radius_mm": 5}, "samples": 500,
        "surface": {"kind": "plane", "length_mm": 20, "width_mm": 10},
    });
    let [found, plain] = [
        report("verification", &cut, MAIN, &FILES).await,
        report("verification", &cut, WRITTEN_OUT, &[]).await,
    ];
    assert_eq!(found["uncut_samples"], plain["uncut_samples"]);
    // A motion in a file counts at the line of its call.
    let lines = |report: &Value| report.to_string().matches("\"line\":4").count();
    assert!(lines(&found) > 0 || found["max_gouge_um"].is_null(), "{found}");
}

fn unzipped(bytes: Vec<u8>) -> Vec<(String, String)> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut files = Vec::new();
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).unwrap();
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        files.push((file.name().unwrap().into_owned(), text));
    }
    files
}

#[tokio::test]
async fn an_archive_comes_back_as_an_archive_with_the_changed_main_program() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let parameters = json!({"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35]});
    let main = MAIN.replace("M98 P2\n", "G1 X5.000 A5.000 C40.000 F1000\nM98 P2\n");
    let all = [("O2.nc", POCKET), ("main.nc", main.as_str()), ("3.NC", CORNER)];
    let answer = post(&app, "cc-compensation", zipped(&parameters, &all, Some("main.nc")), "*/*").await;
    assert_eq!(answer.status(), StatusCode::OK);
    assert_eq!(answer.headers()["content-type"], "application/zip");
    let name = answer.headers()["content-disposition"].to_str().unwrap().to_owned();
    assert!(name.contains("\"part-compensated.zip\""), "{name}");
    let location = answer.headers()["location"].to_str().unwrap().to_owned();
    let bytes = answer.bytes().await.unwrap();
    let files = unzipped(bytes.to_vec());
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["3.NC", "O2.nc", "main.nc"]);
    assert_eq!((files[0].1.as_str(), files[1].1.as_str()), (CORNER, POCKET));
    // The main program is as if it had come alone, but for the digest in its stamp.
    let alone =
        post(&app, "cc-compensation", form(&parameters, &main, &[]), "*/*").await.text().await.unwrap();
    let unstamped = |text: &str| -> Vec<String> {
        text.lines().filter(|line| !line.contains("Trunnion")).map(str::to_owned).collect()
    };
    assert_ne!(unstamped(&files[2].1), unstamped(&main));
    assert_eq!(unstamped(&files[2].1), unstamped(&alone));
    // The same request gives the same bytes, and the job keeps them.
    let again = post(&app, "cc-compensation", zipped(&parameters, &all, Some("main.nc")), "*/*").await;
    assert_eq!(again.bytes().await.unwrap(), bytes);
    let kept = app.get(&format!("{location}/program")).await;
    assert_eq!(kept.headers()["content-type"], "application/zip");
    assert_eq!(kept.bytes().await.unwrap(), bytes);
    // The result of a step is not compensated again.
    let files: Vec<_> = files.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let twice = post(&app, "cc-compensation", zipped(&parameters, &files, Some("main.nc")), "*/*").await;
    assert_eq!(twice.status(), StatusCode::CONFLICT);
}

#[tokio::test]
async fn a_main_program_in_fields_comes_back_alone() {
    let app = spawn().await;
    let parameters = json!({"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35]});
    let answer = post(&app, "cc-compensation", form(&parameters, MAIN, &FILES), "*/*").await;
    assert_eq!(answer.status(), StatusCode::OK);
    assert!(answer.text().await.unwrap().starts_with("G21"));
}

#[tokio::test]
async fn a_job_takes_files_and_gives_the_result_of_its_operation() {
    let app = spawn().await;
    let order =
        json!({"machine_id": "example-ac-table", "operation": "servo-simulation", "parameters": placed()});
    let form = FILES.iter().fold(
        Form::new().text("job", order.to_string()).part("program", part("main.nc", MAIN)),
        |form, (name, text)| form.part("subprogram", part(name, text)),
    );
    let posted = app.client.post(app.url("/v1/jobs")).multipart(form).send().await.unwrap();
    assert_eq!(posted.status(), StatusCode::ACCEPTED);
    let job: Value = posted.json().await.unwrap();
    let id = job["id"].as_str().unwrap();
    assert_eq!(ended(&app, &format!("/v1/jobs/{id}")).await["state"], "succeeded");
    let report: Value = app.get(&format!("/v1/jobs/{id}/report")).await.json().await.unwrap();
    let plain =
        post(&app, "servo-simulation", self::form(&placed(), WRITTEN_OUT, &[]), "application/json").await;
    let plain: Value = plain.json().await.unwrap();
    assert_eq!(report["duration_s"], plain["duration_s"]);
    let path = app.get(&format!("/v1/jobs/{id}/path")).await.text().await.unwrap();
    let lines: Vec<_> = path.lines().skip(1).filter_map(|row| row.split(',').next()).collect();
    assert_eq!(lines, ["3", "4", "4", "5"]);
}

#[tokio::test]
async fn files_that_do_not_make_one_program_are_refused_with_their_field() {
    let app = spawn().await;
    let refused = async |operation: &str, form: Form| {
        let answer = post(&app, operation, form, "application/json").await;
        let status = answer.status();
        let problem = problem(answer, "invalid-request").await;
        (status, pointers(&problem), problem["errors"][0]["detail"].as_str().unwrap_or_default().to_owned())
    };
    let all = [("a.nc", MAIN), ("b.nc", POCKET)];
    let many: Vec<(String, &str)> = (0..100).map(|number| (format!("{number}.nc"), "M99\n")).collect();
    let many: Vec<_> = many.iter().map(|(name, text)| (name.as_str(), *text)).collect();
    let nameless = form(&placed(), MAIN, &[]).part("subprogram", Part::text("M99\n"));
    for (form, pointer, wanted) in [
        (form(&placed(), MAIN, &[("O2.nc", POCKET), ("o2.NC", CORNER)]), "/subprogram", "o2.NC"),
        (form(&placed(), MAIN, &[("Main.nc", POCKET)]), "/subprogram", "Main.nc"),
        (form(&placed(), MAIN, &many), "/subprogram", "at most 100"),
        (nameless, "/subprogram", "name of a file is missing"),
        (form(&placed(), MAIN, &[]).text("main", "a.nc"), "/main", "no zip archive"),
        (zipped(&placed(), &all, None), "/main", "a.nc, b.nc"),
        (zipped(&placed(), &all, Some("c.nc")), "/main", "no such file"),
        (zipped(&placed(), &[("x/a.nc", ""), ("y/a.nc", "")], Some("a.nc")), "/main", "or several"),
        (
            zipped(&placed(), &all, Some("a.nc")).part("subprogram", part("c.nc", "M99")),
            "/subprogram",
            "into it",
        ),
    ] {
        let (status, pointers, detail) = refused("interpretation", form).await;
        assert_eq!(
            (status, pointers),
            (StatusCode::UNPROCESSABLE_ENTITY, vec![pointer.to_owned()]),
            "{detail}"
        );
        assert!(detail.contains(wanted), "{detail}");
    }
    let (status, found, _) = refused("posting", form(&json!({}), "GOTO/0,0,0\n", &FILES)).await;
    assert_eq!((status, found), (StatusCode::UNPROCESSABLE_ENTITY, vec!["/subprogram".to_owned()]));
    let plain = app.client.post(app.url("/v1/machines/example-ac-table/interpretation"));
    let plain =
        plain.header("Content-Type", "application/octet-stream").body(archive(&[("a.nc", b"G0 X1\n")]));
    let answer = problem(plain.send().await.unwrap(), "invalid-request").await;
    assert_eq!(pointers(&answer), ["/program"]);
    let own = form(&placed(), "%TRUNNION PROGRAM FILES 1\nab 3 x\n\nabc", &[]);
    let (status, found, _) = refused("interpretation", own).await;
    assert_eq!((status, found), (StatusCode::UNPROCESSABLE_ENTITY, vec!["/program".to_owned()]));
    let out = zipped(&placed(), &[("../a.nc", MAIN), ("b.nc", CORNER)], Some("../a.nc"));
    assert!(refused("interpretation", out).await.2.contains("leads out of its folder"));
    // A part that a page sends although no file was chosen.
    let unfilled =
        form(&placed(), MAIN, &[]).part("subprogram", Part::text("").file_name("")).text("main", "");
    assert_eq!(post(&app, "interpretation", unfilled, "*/*").await.status(), StatusCode::OK);
}

#[tokio::test]
async fn files_count_to_the_limit_of_bodies() {
    let app = spawn_with(|settings| settings.max_body_bytes = 20_000).await;
    let comment = format!("({})\nM99\n", "x".repeat(9_000));
    let files = [("2.nc", comment.as_str()), ("3.nc", comment.as_str()), ("4.nc", comment.as_str())];
    let answer = post(&app, "interpretation", form(&placed(), MAIN, &files), "*/*").await;
    assert_eq!(answer.status(), StatusCode::PAYLOAD_TOO_LARGE);
    let unpacked = [("main.nc", MAIN), files[0], files[1], files[2]];
    let answer = post(&app, "interpretation", zipped(&placed(), &unpacked, Some("main.nc")), "*/*").await;
    assert_eq!(answer.status(), StatusCode::PAYLOAD_TOO_LARGE);
    let answer = post(&app, "interpretation", form(&placed(), MAIN, &files[..1]), "*/*").await;
    assert_eq!(answer.status(), StatusCode::OK);
}

/// A loop over a program with a turn of the tool, which deviates each time.
const LOOP: &str = "G21 G90 G94 G17 G54\nT1 M6\nG0 X0.000 Y0.000 Z5.000 A0.000 C0.000\n#1=0\no1 while [#1 LT 2]\n#1=[#1+1]\nM98 P2\no1 endwhile\nM30\n";
const TURN: &str = "O2\nG1 X[#1*5] A[#1*5.000] C[#1*40] F1000\nM99\n";

#[tokio::test]
async fn loops_and_calls_are_written_out_and_compensated_if_the_caller_asks_for_it() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let parameters = json!({
        "tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [12, -7, 35], "flatten": true, "stamp": "none",
    });
    let files = [("2.nc", TURN)];
    let answer = post(&app, "cc-compensation", form(&parameters, LOOP, &files), "*/*").await;
    assert_eq!(answer.status(), StatusCode::OK);
    let location = answer.headers()["location"].to_str().unwrap().to_owned();
    let text = answer.text().await.unwrap();
    assert!(!text.contains("M98") && !text.contains("while") && !text.contains("#1=["), "{text}");
    // As the program that makes the same motions without a loop.
    let plain = "G21 G90 G94 G17 G54\nT1 M6\nG0 X0.000 Y0.000 Z5.000 A0.000 C0.000\n#1=0\nG1 X5.0000 A5.0000 C40.0000 F1000\nG1 X10.0000 A10.0000 C80.0000 F1000\nM30\n";
    let expected =
        post(&app, "cc-compensation", form(&parameters, plain, &[]), "*/*").await.text().await.unwrap();
    assert_eq!(text.replace("#1=0\n", ""), expected.replace("#1=0\n", ""));
    let report: Value = app.get(&format!("{location}/report")).await.json().await.unwrap();
    assert_eq!(report["motions_over_tolerance"], 2);
    let warnings = report["warnings"].as_array().unwrap();
    let told = warnings.iter().find(|warning| warning["kind"] == "written_out").unwrap();
    assert_eq!((&told["count"], &told["line"]), (&json!(2), &json!(6)));
    // The path has the lines and the errors of the written-out program.
    let path = app.get(&format!("{location}/path")).await.text().await.unwrap();
    let rows: Vec<Vec<&str>> = path.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), ["3", "5", "6"]);
    assert!(rows[1..].iter().all(|row| !row[row.len() - 2].is_empty()), "{path}");
    // As an archive, and in one pass.
    let all = [("main.nc", LOOP), files[0]];
    let answer = post(&app, "cc-compensation", zipped(&parameters, &all, Some("main.nc")), "*/*").await;
    assert_eq!(unzipped(answer.bytes().await.unwrap().to_vec()), [("main.nc".to_owned(), text)]);
    let passed = json!({
        "cc": {"tool_radius_mm": 5, "contact": "tip"}, "work_offset_mm": [12, -7, 35], "flatten": true,
    });
    let answer = post(&app, "compensation", form(&passed, LOOP, &files), "application/json").await;
    let report: Value = answer.json().await.unwrap();
    assert!(report["warnings"].to_string().contains("written_out"), "{report}");
    // Without the file, or without asking for it, the program is refused.
    let answer = post(&app, "cc-compensation", form(&parameters, LOOP, &[]), "*/*").await;
    let refused = problem(answer, "program-fault").await;
    assert!(refused.to_string().contains("its file is missing"), "{refused}");
    let mut unasked = parameters.clone();
    unasked["flatten"] = json!(false);
    let answer = post(&app, "cc-compensation", form(&unasked, LOOP, &files), "*/*").await;
    assert_eq!(problem(answer, "program-fault").await["line"], 5);
}

#[tokio::test]
async fn the_names_of_files_show_their_dialect() {
    let app = spawn().await;
    let main = "G71 G90 G94 G54\nG0 X20.5 Y0 Z5 A0 C0\nL54\nG1 X50 F100\nM30\n";
    let found = read(&app, form(&placed(), main, &[("L54.SPF", "G91 G1 X30 F100\nG90\nRET\n")])).await;
    assert_eq!((&found["dialect"], &found["left_alone"]), (&json!("siemens"), &json!([])));
    assert_eq!(found["motions"][1]["joints"]["X"], 50.5);
}
