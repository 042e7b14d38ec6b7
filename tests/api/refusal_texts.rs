//! What a refusal says is true of the program, and its cure is one; what a request states twice or in vain is not
//! passed over.

use std::sync::Arc;

use reqwest::StatusCode;
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::program_tools::{
    ALL, CC, CUT, ENTRIES, HEAD, WEAR, ZERO, ball, cuts, measure, put, with_two_tools,
};
use crate::support::{App, ac_table, kinds, pointers, problem, program_form, spawn_real};

const VERIFY: &str = "verification";
const INTERPRET: &str = "interpretation";
const WORN: &str = "contact=feed-plane&nominal_tool.radius_mm=5&actual_tool.radius_mm=4.9";

async fn refused(app: &App, operation: &str, query: &str, program: &str) -> Value {
    problem(app.operate("m", operation, query, program, "*/*").await, "invalid-request").await
}

fn detail(problem: &Value) -> &str {
    problem["detail"].as_str().unwrap()
}

/// A Sinumerik program of these calls, each before a cut.
fn siemens(calls: &[&str]) -> String {
    let cut = "G0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nG1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000\n";
    let sections: Vec<_> = calls.iter().map(|call| format!("{call}\n{cut}")).collect();
    format!("%_N_P_MPF\n;$PATH=/_N_MPF_DIR\nN10 G71 G90 G94 G54\n{}N90 M30\n", sections.concat())
}

#[tokio::test]
async fn tools_that_a_t_word_alone_does_not_put_in_are_not_said_to_be_missing() {
    let app = with_two_tools().await;
    let query = format!("{ZERO}&contact=feed-plane");
    for (calls, query, why) in [
        (["T1", "T2", "T3 M6"], query.as_str(), "changes tools by M6"),
        (["T1", "T2", "T3 M6"], &format!("{query}&tool_number=1"), "changes tools by M6"),
    ] {
        let body = refused(&app, CC, query, &siemens(&calls)).await;
        assert!(detail(&body).contains(why) && detail(&body).contains("T alone"), "{body}");
        assert!(!detail(&body).contains("no cutter for"), "{body}");
    }
    // The cure: M6 with each of them. A program without any M6 changes tools by T.
    for calls in [["T1 M6", "T2 M6", "T3 M6"], ["T1", "T2", "T1"]] {
        let report = app.report("m", CC, &query, &siemens(&calls)).await;
        assert_eq!(report["resolved"]["tools"][0]["tool_id"], "A", "{report}");
    }
    // Where the table has none of them, that is the truth.
    let body = refused(&app, CC, &query, &siemens(&["T7 M6", "T8 M6"])).await;
    assert!(detail(&body).contains("no cutter for T7, T8"), "{body}");
}

#[tokio::test]
async fn a_tool_that_the_text_does_not_tell_is_not_said_to_be_none() {
    let app = with_two_tools().await;
    let query = format!("{ZERO}&contact=feed-plane");
    let (macros, r) = (format!("{HEAD}T#100 M6\n{CUT}M30\n"), siemens(&["T=R1 M6"]));
    for program in [macros, r, siemens(&["T1 D2 M6"])] {
        let body = refused(&app, CC, &query, &program).await;
        assert_eq!(pointers(&body), ["/tool_radius_mm"]);
        for part in ["does not show which", "tool_number", "tool_radius_mm"] {
            assert!(detail(&body).contains(part), "{part}: {body}");
        }
        // Each cure is one, and both come to the same.
        let stated = app.program("m", CC, &format!("{query}&tool_radius_mm=3"), &program).await;
        assert_ne!(stated, program);
        assert_eq!(app.program("m", CC, &format!("{query}&tool_number=2"), &program).await, stated);
        let report = app.report("m", CC, &format!("{query}&tool_number=2"), &program).await;
        let tool = report["resolved"]["tools"].as_array().unwrap().last().unwrap();
        assert_eq!((&tool["tool_id"], &tool["number"]), (&json!("B"), &json!(2)), "{report}");
    }
    let body = refused(&app, CC, &query, &format!("{HEAD}{CUT}M30\n")).await;
    assert!(detail(&body).contains("calls no tool"), "{body}");
}

#[tokio::test]
async fn axes_that_are_not_known_are_named_with_the_cure() {
    let app = with_two_tools().await;
    let four = CUT.replace(" A0.000", "").replace(" A10.000", "").replace(" A25.000", "");
    let three = four.replace(" C0.000", "").replace(" C10.000", "").replace(" C60.000", "");
    let query = format!("{ZERO}&{WORN}&nominal_tool.length_mm=50&actual_tool.length_mm=49.9");
    for (cut, axes, start) in
        [(&four, "are not known: A. ", "start.A=0"), (&three, "are not known: A, C. ", "start.A=0&start.C=0")]
    {
        let program = format!("{HEAD}{cut}M30\n");
        let body = problem(app.operate("m", WEAR, &query, &program, "*/*").await, "program-fault").await;
        let said = body["errors"][0]["detail"].as_str().unwrap();
        assert!(said.contains(axes) && said.contains("`start`") && said.contains("start.A=0"), "{said}");
        app.report("m", WEAR, &format!("{query}&{start}"), &program).await;
        let step = format!(
            "{ZERO}&wear.contact=feed-plane&wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.9&wear.nominal_tool.length_mm=50&wear.actual_tool.length_mm=49.9"
        );
        let body = problem(app.operate("m", ALL, &step, &program, "*/*").await, "program-fault").await;
        assert!(body["errors"][0]["detail"].as_str().unwrap().contains(axes), "{body}");
        // The contact's path cannot be looked at either.
        let report = app.report("m", CC, &format!("{ZERO}&tool_radius_mm=5"), &program).await;
        let warning =
            report["warnings"].as_array().unwrap().iter().find(|one| one["kind"] == "nothing_checked");
        assert!(warning.unwrap()["detail"].as_str().unwrap().contains("`start`"), "{report}");
    }
}

#[tokio::test]
async fn null_is_no_value_and_never_broken_json() {
    let app = with_two_tools().await;
    let program = cuts(&[1]);
    // "Not stated" is what null says of a member that may be left out; of one with another default it is a wrong value.
    for (member, value, pointer) in [
        ("unit", Value::Null, None),
        ("work_offsets_mm", Value::Null, None),
        ("tool_number", Value::Null, None),
        ("start", Value::Null, None),
        ("stamp", Value::Null, Some("/stamp")),
        ("contact", Value::Null, Some("/contact")),
        ("dialect", Value::Null, Some("/dialect")),
        ("allow_repeated", Value::Null, Some("/allow_repeated")),
        ("tolerance_um", Value::Null, Some("/tolerance_um")),
        ("singular_regions", Value::Null, Some("/singular_regions")),
        ("stamp", json!(5), Some("/stamp")),
        ("stamp", json!([]), Some("/stamp")),
        ("stamp", json!(true), Some("/stamp")),
        ("stamp", json!({"none": 1}), Some("/stamp")),
        ("unit", json!(1.5), Some("/unit")),
    ] {
        let mut parameters = json!({"tool_radius_mm": 5, "work_offset_mm": [0, 0, 0]});
        parameters[member] = value.clone();
        let request = app.client.post(app.url("/v1/machines/m/cc-compensation"));
        let answer = request.multipart(program_form(&parameters, &program, "p.nc")).send().await.unwrap();
        match pointer {
            None => assert_eq!(answer.status(), StatusCode::OK, "{member}"),
            Some(pointer) => {
                let body = problem(answer, "invalid-request").await;
                assert!(pointers(&body)[0].starts_with(pointer), "{member} {value}: {body}");
            }
        }
    }
}

#[tokio::test]
async fn a_member_that_has_to_be_stated_is_named_once() {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let mut head = ac_table();
    head["kinematics"]["rotary_axes"] = json!([
        {"name": "C", "side": "head", "direction": [0, 0, 1], "point_mm": [0, 0, 0]},
        {"name": "A", "side": "head", "direction": [1, 0, 0], "point_mm": [0, 0, 100], "limits_deg": [-120, 120]}
    ]);
    app.put_machine("m", &ac_table()).await;
    app.put_machine("head", &head).await;
    let plane = "tool.radius_mm=5&surface.kind=plane&surface.length_mm=4&surface.width_mm=4&samples=10";
    for (machine, pointer) in [("head", "/tool_length_mm"), ("m", "/work_offset_mm")] {
        for (operation, query) in [(CC, "contact=tip"), (VERIFY, plane)] {
            for program in [cuts(&[1]), format!("{HEAD}{}M30\n", CUT.repeat(12))] {
                let answer = app.operate(machine, operation, query, &program, "*/*").await;
                let body = problem(answer, "invalid-request").await;
                assert_eq!(pointers(&body), [pointer], "{operation}: {body}");
                assert!(body["errors"][0]["detail"].as_str().unwrap().contains("more"), "{body}");
            }
        }
    }
}

#[tokio::test]
async fn what_a_request_states_twice_or_in_vain_is_told() {
    let app = with_two_tools().await;
    // Two statements of one offset.
    let g54 = cuts(&[1]).replace(HEAD, "G90 G21 G94 G54\n");
    let both = |named: &str| format!("work_offset_mm=1,2,3&work_offsets_mm.{named}");
    for (operation, more) in [(CC, "contact=tip"), (ALL, "cc.contact=tip"), (WEAR, WORN), (INTERPRET, "")] {
        for (named, program, fits) in [
            ("G54=1,2,3", &g54, true),
            ("G55=7,7,7", &g54, true),
            ("G54=1,2,4", &g54, false),
            ("G55=1,2,4", &g54.replace("G54", "G55"), false),
            ("G54=1,2,4", &g54.replace("G54", "G55"), true),
        ] {
            let query = format!("{}&{more}", both(named));
            if fits {
                app.report("m", operation, &query, program).await;
                continue;
            }
            let body = refused(&app, operation, &query, program).await;
            assert_eq!(pointers(&body), ["/work_offset_mm"], "{operation}: {body}");
            assert!(detail(&body).contains("1, 2, 3") && detail(&body).contains("1, 2, 4"), "{body}");
        }
    }
    let table = app.operate("m", INTERPRET, &both("G54=1,2,4"), &g54, "text/csv").await;
    problem(table, "invalid-request").await;

    // A cutter that is not used, as both are the table's.
    measure(&app, "A", 3, None, 20.0).await;
    let steps =
        format!("{ZERO}&wear.contact=feed-plane&wear.from=entries&wear.cutter_id=1&cc.contact=feed-plane");
    let program = cuts(&[1]);
    let listed = app.program("m", ALL, &steps, &program).await;
    let unused = "stated_tool_unused".to_owned();
    assert!(!kinds(&app.report("m", ALL, &steps, &program).await).contains(&unused));
    for program in [cuts(&[1]), cuts(&[1, 2])] {
        let stated = format!("{steps}&cc.tool_radius_mm=2");
        let told = kinds(&app.report("m", ALL, &stated, &program).await);
        assert_eq!(told.iter().filter(|kind| **kind == unused).count(), 1, "{told:?}");
    }
    assert_eq!(app.program("m", ALL, &format!("{steps}&cc.tool_radius_mm=2"), &program).await, listed);
}

#[tokio::test]
async fn sections_that_location_errors_move_are_not_said_to_be_left_alone() {
    let app = with_two_tools().await;
    let mut profile = ac_table();
    profile["kinematics"]["rotary_axes"][0]["location_error"] = json!({"e_y_um": 50.0, "e_z_um": 20.0});
    let answer = app
        .client
        .put(app.url("/v1/machines/m"))
        .header("if-match", "*")
        .json(&profile)
        .send()
        .await
        .unwrap();
    assert_eq!(answer.status(), StatusCode::OK, "{}", answer.text().await.unwrap());
    let program = cuts(&[1, 2]);
    for (query, left, moves_second) in [
        ("location_errors=true&tool_number=1", [false, false], true),
        ("location_errors=true&tool_number=1&cc.tolerance_um=5", [false, false], true),
        ("cc.tolerance_um=5&tool_number=1", [false, true], false),
    ] {
        let query = format!("{ZERO}&{query}");
        let report = app.report("m", ALL, &query, &program).await;
        let told: Vec<_> = report["resolved"]["tools"]
            .as_array()
            .unwrap()
            .iter()
            .map(|tool| &tool["is_left_alone"])
            .collect();
        assert_eq!(json!(told), json!(left), "{query}: {report}");
        let text = app.program("m", ALL, &query, &program).await;
        let second = |text: &str| text.split_once("T2 M6").unwrap().1.to_owned();
        assert_eq!(second(&text) != second(&program), moves_second, "{query}");
    }
}

#[tokio::test]
async fn a_program_that_the_length_alone_changes_was_looked_at() {
    let app = with_two_tools().await;
    let program = cuts(&[1]);
    for (lengths, some) in [(["50", "49.8"], true), (["50", "50"], false)] {
        let [nominal, actual] = lengths;
        let query = format!(
            "{ZERO}&nominal_tool.radius_mm=5&actual_tool.radius_mm=5&nominal_tool.length_mm={nominal}&actual_tool.length_mm={actual}"
        );
        let step = format!(
            "{ZERO}&wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=5&wear.nominal_tool.length_mm={nominal}&wear.actual_tool.length_mm={actual}"
        );
        for (operation, query) in [(WEAR, &query), (ALL, &step)] {
            let answer = app.operate("m", operation, query, &program, "*/*").await;
            assert_eq!(answer.status(), StatusCode::OK);
            let checked: u64 =
                answer.headers()["trunnion-motions-checked"].to_str().unwrap().parse().unwrap();
            assert_eq!(checked > 0, some, "{operation} {lengths:?}: {checked}");
            assert_eq!(answer.text().await.unwrap() != program, some);
        }
    }
}

#[tokio::test]
async fn the_axis_is_not_told_where_an_offset_may_turn_the_workpiece() {
    let app = with_two_tools().await;
    let body = "G0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nG1 X1.000 Y0.000 Z0.000 A10.000 C10.000 F1000\n";
    let siemens =
        |shift: &str| format!("%_N_P_MPF\n;$PATH=/_N_MPF_DIR\nN10 G71 G90 G94 G54\n{shift}\n{body}N90 M30\n");
    let iso = |first: &str, then: &str| format!("{HEAD}{first}\n{body}{then}\n{body}M30\n");
    for (query, program, tip, axis) in [
        ("work_offset_mm=0,0,0", siemens(";"), true, true),
        ("work_offset_mm=0,0,0", siemens("TRANS X10"), true, true),
        ("work_offset_mm=0,0,0", siemens("TRANS C10"), false, false),
        // One that is simply not stated does not turn the workpiece.
        ("", siemens(";"), false, true),
        ("", iso("G54", "G54"), false, true),
        ("work_offset_mm=0,0,0", iso("G54", "G55"), false, false),
        ("work_offsets_mm.G54=0,0,0&work_offsets_mm.G55=0,0,1", iso("G54", "G55"), true, true),
        ("work_offset_mm=0,0,0", iso("G54", "G52 X1"), false, false),
    ] {
        let answer = app.report("m", INTERPRET, query, &program).await;
        let last = answer["motions"].as_array().unwrap().last().unwrap();
        assert_eq!(
            (last["tip_mm"].is_array(), last["axis"].is_array()),
            (tip, axis),
            "{query} {program}: {last}"
        );
    }
    // Names that no control knows, and one offset under two names.
    for names in [
        "work_offsets_mm.G53=0,0,0",
        "work_offsets_mm.G54=0,0,0&work_offsets_mm.g54=0,0,1",
        "work_offsets_mm.X=0,0,0",
    ] {
        for operation in [INTERPRET, CC] {
            let query = if operation == CC { format!("{names}&contact=tip") } else { names.to_owned() };
            let body = refused(&app, operation, &query, &cuts(&[1])).await;
            assert!(pointers(&body)[0].starts_with("/work_offsets_mm/"), "{operation} {names}: {body}");
        }
    }
}

#[tokio::test]
async fn the_interpretation_says_how_many_motions_it_leaves_alone() {
    let app = with_two_tools().await;
    for (program, count) in [(cuts(&[1]), 0), (format!("{HEAD}{CUT}M98 P1\nX1.000\nG28 Z0.000\nM30\n"), 3)] {
        for accept in ["text/csv", "application/json"] {
            let answer = app.operate("m", INTERPRET, "work_offset_mm=0,0,0", &program, accept).await;
            let told = answer.headers()["trunnion-motions-left-alone"].to_str().unwrap().to_owned();
            assert_eq!(told, count.to_string(), "{accept}");
            if accept == "application/json" {
                let body: Value = answer.json().await.unwrap();
                assert_eq!(body["left_alone"].as_array().unwrap().len(), count, "{body}");
            }
        }
    }
}

#[tokio::test]
async fn the_worn_cutter_of_a_tool_that_the_text_does_not_tell_is_that_of_the_tool_asked_for() {
    let app = with_two_tools().await;
    put(&app, "m", "C", &ball(3, 4.0)).await;
    measure(&app, "B", 3, None, 20.0).await;
    let program = format!("{HEAD}T#100 M6\n{CUT}M30\n");
    let query = format!("{ZERO}&{ENTRIES}");
    let body = refused(&app, WEAR, &query, &program).await;
    assert!(detail(&body).contains("does not show which"), "{body}");
    let by_entry = app.program("m", WEAR, &format!("{query}&tool_number=2"), &program).await;
    let stated = format!("{ZERO}&contact=feed-plane&nominal_tool.radius_mm=3&actual_tool.radius_mm=2.98");
    assert_eq!(by_entry, app.program("m", WEAR, &stated, &program).await);
    let body = refused(&app, WEAR, &format!("{query}&tool_number=3"), &program).await;
    assert!(detail(&body).contains("no wear entry for T3"), "{body}");
}
