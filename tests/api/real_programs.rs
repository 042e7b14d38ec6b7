//! The whole way with the real compensator: a program of our own in, verified program, report and plot out.

use std::sync::Arc;

use serde_json::Value;
use trunnion::jobs::CutterContactCompensator;

use crate::support::{pointers, problem, spawn_real, unstamped};

/// A path over the example machine that turns both rotary axes while the tip moves; its contact is the tip.
const PROGRAM: &str = "%
G90 G21 G94
G0 X0.000 Y0.000 Z50.000 A0.000 C0.000
G1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000
G1 X20.000 Y5.000 Z-2.000 A25.000 C60.000
G1 X40.000 Y0.000 Z0.000 A30.000 C95.000
M30
%
";
const PATH: &str = "/v1/machines/example-ac-table/cc-compensation";

#[tokio::test]
async fn a_program_is_compensated_within_its_tolerance() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let path = format!("{PATH}?tool_radius_mm=5&contact=tip&work_offset_mm=0,0,0");
    let response = app.post_text(&path, "text/plain", PROGRAM).await;
    assert_eq!(response.status(), 200);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let text = response.text().await.unwrap();
    let (bare, stamp) = unstamped(&text);
    assert!(
        bare.starts_with("%\nG90 G21 G94\nG0 X0.000 Y0.000 Z50.000 A0.000 C0.000\n")
            && bare.ends_with("M30\n%\n"),
        "{text}"
    );
    assert!(stamp.unwrap().contains(" cc-compensation steps cc machine example-ac-table revision 1 source "));
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    assert!(report["before"]["max_um"].as_f64().unwrap() > 10.0, "{report}");
    assert!(report["after"]["max_um"].as_f64().unwrap() <= 10.0, "{report}");
    assert_eq!(report["blocks_out"].as_u64().unwrap(), bare.lines().count() as u64);
    assert!(report["blocks_inserted"].as_u64().unwrap() > 0);
    let plot = app.get(&format!("{job}/plot")).await.text().await.unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("</svg>"));
}

#[tokio::test]
async fn where_nothing_exceeds_the_tolerance_the_bytes_stay() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let path = format!("{PATH}?contact=tip&tolerance_um=10000&work_offset_mm=0,0,0");
    assert_eq!(app.post_text(&path, "text/plain", PROGRAM).await.text().await.unwrap(), PROGRAM);
}

#[tokio::test]
async fn faults_of_programs_are_problems_with_their_line() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let path = format!("{PATH}?tool_radius_mm=5&contact=tip&work_offset_mm=0,0,0");
    let post = |body: String| app.post_text(&path, "text/plain", body);
    for empty in ["", "\n\n", "(nothing)\n", "G90 G21\nM30\n"] {
        let body = problem(post(empty.to_owned()).await, "program-fault").await;
        assert!(body["detail"].as_str().unwrap().contains("no motion"), "{body}");
        assert_eq!(pointers(&body), ["/program"], "{body}");
    }
    let travel = PROGRAM.replace("A30.000", "A130.000");
    let body = problem(post(travel).await, "out-of-travel").await;
    assert_eq!(
        (body["line"].as_u64(), body["block"].as_str()),
        (Some(6), Some("G1 X40.000 Y0.000 Z0.000 A130.000 C95.000"))
    );
    let endless = "G1 ".to_owned() + &"X".repeat(1 << 20);
    assert_eq!(problem(post(endless).await, "program-fault").await["line"], 1);
    let control = PROGRAM.replace("M30", "WHILE [#1 LT 3] DO1\nM30");
    assert_eq!(problem(post(control).await, "program-fault").await["line"], 7);
    let jump =
        "BEGIN PGM TEST MM\nL X+0 R0 FMAX\nFN 12: IF +Q3 LT +0 GOTO LBL 2\nEND PGM TEST MM\n".to_owned();
    assert_eq!(problem(post(jump).await, "program-fault").await["line"], 3);
    let no_words =
        app.post_text(&format!("{PATH}?tool_radius_mm=5&contact=program"), "text/plain", PROGRAM).await;
    assert_eq!(pointers(&problem(no_words, "invalid-request").await), ["/contact"]);
    let surface =
        app.post_text(&format!("{PATH}?tool_radius_mm=5&contact=surface"), "text/plain", PROGRAM).await;
    assert_eq!(pointers(&problem(surface, "invalid-request").await), ["/contact"]);
    let fine = app.post_text(&format!("{path}&tolerance_um=0.02"), "text/plain", PROGRAM).await;
    problem(fine, "tolerance-out-of-reach").await;
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn dialects_that_are_not_read_and_doubtful_comments_are_problems_with_their_line() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let path = format!("{PATH}?tool_radius_mm=5&contact=tip&work_offset_mm=0,0,0");
    let post = |body: String| app.post_text(&path, "text/plain", body);
    let body = problem(post(format!("%PM9001\nN9001 (PART)\n{PROGRAM}")).await, "program-fault").await;
    let detail = body["detail"].as_str().unwrap();
    assert!(detail.contains("Heidenhain MillPlus") && detail.contains("not supported"), "{body}");
    assert_eq!((&body["line"], pointers(&body)), (&1.into(), vec!["/program/1".to_owned()]), "{body}");
    let commented = PROGRAM.replace("M30", "(OLD (Z5) G1 X10.)\nM30");
    let body = problem(post(commented).await, "program-fault").await;
    assert_eq!(body["line"], 7, "{body}");
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn contact_words_that_only_a_blocks_end_has_stay_at_its_end() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let iso = "G90 G21 G94\nG1 X20.000 Y5.000 Z-2.000 A25.000 C60.000 F1000\nG1 X40.000 Y0.000 Z0.000 U1 V2 W3A30.000 C95.000\nM30\n";
    let table = "X,Y,Z,A,C,U,V,W,F\n20.000,5.000,-2.000,25.000,60.000,,,,1000\n40.000,0.000,0.000,30.000,95.000,1,2,3,1000\n";
    for (kind, program) in [("text/plain", iso), ("text/csv", table)] {
        let response =
            app.post_text(&format!("{PATH}?contact=tip&work_offset_mm=0,0,0"), kind, program).await;
        let (text, _) = unstamped(&response.text().await.unwrap());
        let parts: Vec<_> = text.lines().skip(2).filter(|line| *line != "M30").collect();
        assert!(parts.len() > 2, "{text}");
        let (last, others) = parts.split_last().unwrap();
        let stated = |line: &str| line.contains('U') || line.contains(",1,2,3,");
        assert!(stated(last) && !others.iter().any(|line| stated(line)), "{text}");
        if kind == "text/plain" {
            assert!(others[0].starts_with("G1 X") && last.contains("U1") && last.contains("W3"), "{text}");
        }
    }
}

#[tokio::test]
async fn what_is_called_with_an_f_of_its_own_finds_the_feed_that_stood() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    for call in ["G65 P9010 F12.5", "G13 X40.000 F12.5"] {
        let program = PROGRAM.replace("M30", &format!("{call}\nM30"));
        let text =
            app.post_text(&format!("{PATH}?contact=tip&work_offset_mm=0,0,0"), "text/plain", program).await;
        assert_eq!(text.status(), 200, "{call}");
        let text = text.text().await.unwrap();
        assert!(text.contains(&format!("\nF1000.\n{call}\nM30")), "{text}");
        // A block's own time stands for nothing behind it.
        let program = PROGRAM.replace("G94", "G93").replace("M30", &format!("{call}\nM30"));
        let program = program.replace("C60.000", "C60.000 F20").replace("C95.000", "C95.000 F20");
        let text = app
            .post_text(&format!("{PATH}?contact=tip&work_offset_mm=0,0,0"), "text/plain", program)
            .await
            .text()
            .await;
        let text = text.unwrap();
        assert!(text.contains("\nX40.000 ") && text.ends_with(&format!("\n{call}\nM30\n%\n")), "{text}");
    }
}
