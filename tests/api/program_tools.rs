//! A program of several tools is that of its sections, each with its own tool from the machine's table, as it was
//! when work was accepted.

use std::sync::Arc;

use reqwest::StatusCode;
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::queue::{Held, accepted, cc, ended, running, spawn_held};
use crate::support::{App, ac_table, kinds, pointers, problem, spawn_real, unstamped};

pub(crate) const CC: &str = "cc-compensation";
pub(crate) const WEAR: &str = "wear-compensation";
pub(crate) const ALL: &str = "compensation";
const VERIFY: &str = "verification";
pub(crate) const ZERO: &str = "work_offset_mm=0,0,0&stamp=none";
const PLANE: &str =
    "work_offset_mm=0,0,0&surface.kind=plane&surface.length_mm=4&surface.width_mm=4&samples=200";
pub(crate) const ENTRIES: &str = "contact=feed-plane&wear.from=entries&wear.cutter_id=1";

/// The cut of one tool, which turns both rotary axes.
pub(crate) const CUT: &str = "G0 X0.000 Y0.000 Z50.000 A0.000 C0.000
G1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000
X20.000 Y5.000 Z-2.000 A25.000 C60.000 F900
G0 Z50.000
";
pub(crate) const HEAD: &str = "G90 G21 G94\n";

/// What changes to a tool, and prepares the next one.
pub(crate) fn call(number: u32) -> String {
    format!("T{number} M6 T{}\n", number + 1)
}

/// The cuts of these tools.
pub(crate) fn cuts(numbers: &[u32]) -> String {
    let sections: Vec<_> = numbers.iter().map(|number| call(*number) + CUT).collect();
    format!("{HEAD}{}M30\n", sections.concat())
}

pub(crate) fn ball(number: u32, radius_mm: f64) -> Value {
    json!({"number": number, "kind": "ball", "radius_mm": radius_mm})
}

pub(crate) async fn put(app: &App, machine: &str, id: &str, tool: &Value) {
    let request = app.client.put(app.url(&format!("/v1/machines/{machine}/tools/{id}"))).json(tool);
    let answer = request.header("if-match", "*").send().await.unwrap();
    if answer.status() == StatusCode::PRECONDITION_FAILED {
        let request = app.client.put(app.url(&format!("/v1/machines/{machine}/tools/{id}"))).json(tool);
        assert_eq!(request.send().await.unwrap().status(), StatusCode::CREATED);
    }
}

/// Stores a reading of the wear: its id.
pub(crate) async fn measure(app: &App, tool: &str, day: u32, edge: Option<&str>, wear_um: f64) -> String {
    let mut entry = json!({"measured_at": format!("2026-02-{day:02}T09:00:00Z"), "parts_cut": day, "cutter_id": "1", "radius_wear_um": wear_um});
    if let Some(edge) = edge {
        entry["edge"] = json!(edge);
    }
    let answer = app.post_json(&format!("/v1/machines/m/tools/{tool}/wear-entries"), &entry).await;
    assert_eq!(answer.status(), StatusCode::CREATED);
    answer.json::<Value>().await.unwrap()["id"].as_str().unwrap().to_owned()
}

/// A machine without tools.
pub(crate) async fn spawn() -> App {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    app.put_machine("m", &ac_table()).await;
    app
}

/// The same with T1 and T2 in its table.
pub(crate) async fn with_two_tools() -> App {
    let app = spawn().await;
    put(&app, "m", "A", &ball(1, 5.0)).await;
    put(&app, "m", "B", &ball(2, 3.0)).await;
    app
}

#[tokio::test]
async fn several_tools_and_one_cutter_are_refused_and_named() {
    let app = spawn().await;
    let program = cuts(&[1, 2, 3]);
    let tools = "nominal_tool.radius_mm=5&actual_tool.radius_mm=4.9&contact=feed-plane";
    let step = "wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.9&wear.contact=feed-plane";
    for (operation, query) in [
        (CC, "tool_radius_mm=5"),
        (CC, "tool_radius_mm=5&contact=tip"),
        (CC, "tool_radius_mm=5&contact=feed-plane"),
        (WEAR, tools),
        (ALL, "cc.tool_radius_mm=5"),
        (ALL, "cc.tool_radius_mm=5&cc.contact=feed-plane"),
        (ALL, step),
        (VERIFY, "tool.radius_mm=5&surface.kind=plane&surface.length_mm=4&surface.width_mm=4&samples=100"),
    ] {
        let query = format!("work_offset_mm=0,0,0&{query}");
        let body =
            problem(app.operate("m", operation, &query, &program, "*/*").await, "invalid-request").await;
        let detail = body["detail"].as_str().unwrap();
        assert!(detail.contains("3 tools") && detail.contains("T1, T2, T3"), "{operation} {query}: {detail}");
        assert_eq!(pointers(&body), ["/tool_number"]);
        // One of them, and a program of one tool or of none, whatever it is called.
        for program in [cuts(&[1]), cuts(&[7, 7]), format!("{HEAD}{CUT}M30\n")] {
            assert_eq!(
                app.operate("m", operation, &query, &program, "*/*").await.status(),
                StatusCode::OK,
                "{operation} {query}"
            );
        }
        let one = format!("{query}&tool_number=2");
        assert_eq!(
            app.operate("m", operation, &one, &program, "*/*").await.status(),
            StatusCode::OK,
            "{operation} {one}"
        );
        let none = format!("{query}&tool_number=9");
        let body =
            problem(app.operate("m", operation, &none, &program, "*/*").await, "invalid-request").await;
        assert!(body["detail"].as_str().unwrap().contains("no cut with tool 9"), "{body}");
    }
    let order = json!({"machine_id": "m", "operation": CC, "parameters": {"tool_radius_mm": 5, "work_offset_mm": [0, 0, 0]}});
    let job = ended(&app, &accepted(&app, &order, &program).await).await;
    assert_eq!(
        (&job["state"], &job["problem"]["errors"][0]["pointer"]),
        (&json!("failed"), &json!("/tool_number")),
        "{job}"
    );
    // No cutter in the request, and none in the table.
    let query = "work_offset_mm=0,0,0&tool_number=2";
    let body = problem(app.operate("m", CC, query, &program, "*/*").await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/tool_radius_mm"], "{body}");
}

/// The program of T1, T2 and T3 as `query` makes it of programs of one tool each, where T3 stays as it is.
async fn by_sections(app: &App, operation: &str, queries: [String; 2]) -> String {
    let mut text = HEAD.to_owned();
    for (number, query) in (1..).zip(queries) {
        let alone = app.program("m", operation, &query, &cuts(&[number])).await;
        text += alone.strip_prefix(HEAD).and_then(|rest| rest.strip_suffix("M30\n")).unwrap();
    }
    text + &call(3) + CUT + "M30\n"
}

#[tokio::test]
async fn each_section_is_worked_on_with_its_own_tool_and_those_without_one_are_left_alone() {
    let app = with_two_tools().await;
    let program = cuts(&[1, 2, 3]);
    for (operation, query, own) in [
        (CC, "contact=feed-plane", "tool_radius_mm"),
        (CC, "contact=tip", "tool_radius_mm"),
        (ALL, "cc.contact=feed-plane", "cc.tool_radius_mm"),
    ] {
        let query = format!("{ZERO}&{query}");
        let alone =
            by_sections(&app, operation, ["5", "3"].map(|radius| format!("{query}&{own}={radius}"))).await;
        assert_eq!(app.program("m", operation, &query, &program).await, alone, "{operation} {query}");
        let report = app.report("m", operation, &query, &program).await;
        let rows = &report["resolved"]["tools"];
        let row = |number: u32, tool: Value, lines: [u32; 2], motions: u32| {
            let revision = if tool.is_null() { Value::Null } else { json!(1) };
            json!({"number": number, "name": null, "tool_id": tool, "tool_revision": revision, "is_left_alone": tool.is_null(),
                "first_line": lines[0], "last_line": lines[1], "motions": motions})
        };
        let expected = json!([
            row(1, json!("A"), [3, 6], 4),
            row(2, json!("B"), [8, 11], 4),
            row(3, Value::Null, [13, 16], 4)
        ]);
        assert_eq!(rows, &expected, "{operation} {query}");
        if operation == CC {
            let warnings = report["warnings"].as_array().unwrap();
            let unknown = warnings.iter().find(|warning| warning["kind"] == "tool_unknown").unwrap();
            assert_eq!((&unknown["count"], &unknown["line"]), (&json!(2), &json!(14)), "{unknown}");
            assert_eq!(report["motions_checked"], 4);
        }
        // The cutter of the request is not used then, and that is told.
        let stated = format!("{query}&{own}=4");
        assert_eq!(app.program("m", operation, &stated, &program).await, alone);
        if operation == CC {
            assert!(
                kinds(&app.report("m", CC, &stated, &program).await)
                    .contains(&"stated_tool_unused".to_owned())
            );
        }
    }
    // One tool of them: the others' sections are left alone.
    for contact in ["tip", "feed-plane"] {
        let query = format!("{ZERO}&contact={contact}");
        let alone = app.program("m", CC, &query, &cuts(&[2])).await;
        let section = alone.strip_prefix(HEAD).and_then(|rest| rest.strip_suffix("M30\n")).unwrap();
        let expected = format!("{HEAD}{}{CUT}{section}{}{CUT}M30\n", call(1), call(3));
        assert_eq!(
            app.program("m", CC, &format!("{query}&tool_number=2"), &program).await,
            expected,
            "{contact}"
        );
    }
}

#[tokio::test]
async fn a_verification_cuts_with_the_tool_of_each_section() {
    let app = with_two_tools().await;
    let plate = "G90 G21 G94\nT2 M6\nG0 X-5.000 Y0.000 Z9.000 A0.000 C0.000\nG1 Z0.000 F500\nX5.000\nT1 M6\nG0 X5.000 Y1.000 Z0.000 A0.000 C0.000\nG1 X-5.000\nT3 M6\nG1 X-5.000 Y-1.000 Z0.000 A0.000 C0.000\nX5.000\nM30\n";
    let one = |number: u32| {
        plate
            .replace("T3", &format!("T{number}"))
            .replace("T1", &format!("T{number}"))
            .replace("T2", &format!("T{number}"))
    };
    for (number, radius) in [(1, 5), (2, 3)] {
        let listed = app.report("m", VERIFY, PLANE, &one(number)).await;
        let stated = app.report("m", VERIFY, &format!("{PLANE}&tool.radius_mm={radius}"), &one(9)).await;
        assert_eq!(listed["max_excess"], stated["max_excess"], "{number}");
        assert_eq!(listed["resolved"]["tools"][0]["tool_id"], if number == 1 { "A" } else { "B" });
    }
    let report = app.report("m", VERIFY, PLANE, plate).await;
    let left: Vec<_> =
        report["left_out"].as_array().unwrap().iter().filter(|left| left["kind"] == "other_tool").collect();
    assert_eq!((left.len(), &left[0]["line"], &left[0]["count"]), (1, &json!(10), &json!(2)), "{report}");
    let without = plate.split_once("T3").unwrap().0.to_owned() + "M30\n";
    let same = app.report("m", VERIFY, PLANE, &without).await;
    assert_eq!((&report["max_excess"], &report["histogram"]), (&same["max_excess"], &same["histogram"]));
}

#[tokio::test]
async fn heads_turn_the_length_of_the_table() {
    let app = spawn().await;
    let presets: Value = app.get("/v1/machine-presets").await.json().await.unwrap();
    let preset = presets["items"].as_array().unwrap_or_else(|| presets.as_array().unwrap());
    let mut head = preset.iter().find(|preset| preset.to_string().contains("ac-head")).unwrap().clone();
    head = head.get("profile").cloned().unwrap_or(head);
    head.as_object_mut().unwrap().retain(|member, _| {
        ["name", "kinematics", "drives", "interpolation_period_s"].contains(&member.as_str())
    });
    let answer = app.put_machine("head", &head).await;
    assert_eq!(answer.status(), StatusCode::CREATED, "{}", answer.text().await.unwrap());
    let program = cuts(&[1]);
    let apt = include_str!("../../docs/examples/flank.apt");
    for (operation, query, program, member) in [
        (CC, "contact=tip&stamp=none", program.as_str(), "output_sha256"),
        (
            VERIFY,
            "tool.radius_mm=5&surface.kind=plane&surface.length_mm=4&surface.width_mm=4&samples=200",
            &program,
            "max_excess",
        ),
        ("posting", "unit=mm&tool_number=1&interpolation=machine", apt, "output_sha256"),
    ] {
        let query = format!("work_offset_mm=0,0,0&{query}");
        if operation != "posting" {
            let body =
                problem(app.operate("head", operation, &query, program, "*/*").await, "invalid-request")
                    .await;
            assert_eq!(pointers(&body)[0], "/tool_length_mm", "{operation}: {body}");
        }
        let stated = app.report("head", operation, &format!("{query}&tool_length_mm=80"), program).await;
        let other = app.report("head", operation, &format!("{query}&tool_length_mm=60"), program).await;
        put(&app, "head", "L", &json!({"number": 1, "kind": "ball", "radius_mm": 5, "length_mm": 80})).await;
        let listed = app.report("head", operation, &query, program).await;
        assert_eq!(listed[member], stated[member], "{operation}");
        if operation != VERIFY {
            assert_ne!(other[member], stated[member], "{operation}");
        }
        assert_eq!(listed["resolved"]["tools"][0]["tool_id"], "L", "{operation}: {listed}");
        let tool = app.client.delete(app.url("/v1/machines/head/tools/L")).header("if-match", "*");
        assert_eq!(tool.send().await.unwrap().status(), StatusCode::NO_CONTENT);
    }
}

#[tokio::test]
async fn wear_is_taken_from_the_entries_where_it_is_asked_for_and_only_there() {
    let app = with_two_tools().await;
    let program = cuts(&[1, 2, 3]);
    let query = format!("{ZERO}&{ENTRIES}");
    let body = problem(app.operate("m", WEAR, &query, &program, "*/*").await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/wear/cutter_id"]);

    let whole = measure(&app, "A", 10, None, 20.0).await;
    let wrong = measure(&app, "A", 20, None, 99.0).await;
    let edges =
        [measure(&app, "B", 12, Some("1"), 30.0).await, measure(&app, "B", 11, Some("2"), 35.0).await];
    measure(&app, "B", 3, Some("2"), 44.0).await;
    // A tool that has entries and is not in the table stays unknown.
    measure(&app, "C", 12, None, 50.0).await;
    let withdrawal = format!("/v1/machines/m/tools/A/wear-entries/{wrong}/withdraw");
    app.post_json(&withdrawal, &json!({"reason": "wrong"})).await.error_for_status().unwrap();

    let report = app.report("m", WEAR, &query, &program).await;
    let worn = &report["resolved"]["wear"];
    let expected = [
        ("A", 20.0, "2026-02-10T09:00:00.000Z", json!([whole])),
        ("B", 35.0, "2026-02-12T09:00:00.000Z", json!(edges)),
    ];
    assert_eq!(worn.as_array().unwrap().len(), 2, "{worn}");
    for (row, (tool, wear_um, at, ids)) in worn.as_array().unwrap().iter().zip(expected) {
        assert_eq!((&row["tool_id"], &row["cutter_id"]), (&json!(tool), &json!("1")));
        assert_eq!((&row["radius_wear_um"], &row["measured_at"]), (&json!(wear_um), &json!(at)));
        let sorted = |ids: &Value| {
            let mut ids: Vec<_> = ids.as_array().unwrap().iter().map(ToString::to_string).collect();
            ids.sort();
            ids
        };
        assert_eq!(sorted(&row["entry_ids"]), sorted(&ids), "{row}");
        // The clock of these tests began on 25 February 2026.
        let age_days = row["age_days"].as_f64().unwrap();
        assert!((12.0..17.0).contains(&age_days), "{row}");
    }
    assert!(kinds(&report).contains(&"tool_unknown".to_owned()), "{report}");
    // It is what the same cutters make where the request states them.
    let stated = [("5", "4.98"), ("3", "2.965")].map(|(nominal, actual)| {
        format!("{ZERO}&contact=feed-plane&nominal_tool.radius_mm={nominal}&actual_tool.radius_mm={actual}")
    });
    let alone = by_sections(&app, WEAR, stated.clone()).await;
    assert_eq!(app.program("m", WEAR, &query, &program).await, alone);
    let step = format!("{ZERO}&wear.contact=feed-plane&wear.from=entries&wear.cutter_id=1");
    assert_eq!(app.program("m", ALL, &step, &program).await, alone);
    let all = app.report("m", ALL, &step, &program).await;
    assert_eq!(all["resolved"]["wear"].as_array().unwrap().len(), 2);

    // Where nobody asks for it, it does not count.
    let nominal = format!("{ZERO}&contact=feed-plane");
    for (operation, query) in
        [(CC, nominal.as_str()), (WEAR, &format!("{}&tool_number=1", stated[0])), (VERIFY, PLANE)]
    {
        let report = app.report("m", operation, query, &program).await;
        assert_eq!(report["resolved"]["wear"], json!([]), "{operation}");
    }
    for (query, pointer) in [
        (nominal.as_str(), "/actual_tool"),
        (&format!("{nominal}&wear.from=entries"), "/wear/cutter_id"),
        (&format!("{nominal}&wear.from=guess&wear.cutter_id=1"), "/wear/from"),
        (&format!("{nominal}&wear.from=entries&wear.cutter_id=2"), "/wear/cutter_id"),
    ] {
        let body = problem(app.operate("m", WEAR, query, &program, "*/*").await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{query}: {body}");
    }
}

#[tokio::test]
async fn a_job_is_computed_with_the_tools_and_the_wear_of_its_acceptance() {
    let held = Arc::<Held>::default();
    let app = spawn_held(&held, |_| {}).await;
    app.put_machine("m", &ac_table()).await;
    put(&app, "m", "A", &ball(1, 5.0)).await;
    put(&app, "m", "B", &ball(2, 3.0)).await;
    for tool in ["A", "B"] {
        measure(&app, tool, 10, None, 20.0).await;
    }
    let level = "G0 X-5.000 Y0.000 Z9.000 A0.000 C0.000\nG1 Z0.000 F500\nX5.000\n";
    let program = [HEAD, &call(1), CUT, level, &call(2), CUT, level, "M30\n"].concat();
    let entries = json!({"from": "entries", "cutter_id": "1"});
    let mut step = entries.clone();
    step["contact"] = json!("feed-plane");
    let orders = [
        (WEAR, json!({"contact": "feed-plane", "wear": entries})),
        (ALL, json!({"wear": step, "cc": {"contact": "feed-plane"}})),
        (VERIFY, json!({"samples": 200, "surface": {"kind": "plane", "length_mm": 4, "width_mm": 4}})),
    ];
    let order = |(operation, parameters): &(&str, Value)| {
        let mut parameters = parameters.clone();
        parameters["work_offset_mm"] = json!([0, 0, 0]);
        json!({"machine_id": "m", "operation": operation, "parameters": parameters})
    };
    // What each makes at once, before anything changes.
    let mut before = Vec::new();
    for one in &orders {
        let job = ended(&app, &accepted(&app, &order(one), &program).await).await;
        assert_eq!(job["state"], "succeeded", "{job}");
        before.push(job);
    }
    let hold = accepted(&app, &cc("example-ac-table"), "HOLD\n").await;
    running(&app, &hold).await;
    let mut waiting = Vec::new();
    for one in &orders {
        waiting.push(accepted(&app, &order(one), &program).await);
    }
    put(&app, "m", "A", &ball(1, 8.0)).await;
    let gone =
        app.client.delete(app.url("/v1/machines/m/tools/B")).header("if-match", "*").send().await.unwrap();
    assert_eq!(gone.status(), StatusCode::NO_CONTENT);
    measure(&app, "A", 20, None, 60.0).await;
    held.release();
    ended(&app, &hold).await;
    for ((place, before), one) in waiting.iter().zip(&before).zip(&orders) {
        let job = ended(&app, place).await;
        assert_eq!(
            (&job["state"], &job["output_sha256"]),
            (&json!("succeeded"), &before["output_sha256"]),
            "{}",
            one.0
        );
        let report: Value = app.get(&format!("{place}/report")).await.json().await.unwrap();
        let tools = report["resolved"]["tools"].as_array().unwrap();
        let named: Vec<_> = tools.iter().map(|tool| (&tool["tool_id"], &tool["tool_revision"])).collect();
        assert_eq!(json!(named), json!([["A", 1], ["B", 1]]), "{}", one.0);
        // Asked for now it is another result: the radius is another, and T2 is gone.
        let now = ended(&app, &accepted(&app, &order(one), &program).await).await;
        assert_ne!(now["output_sha256"], before["output_sha256"], "{}", one.0);
        let place = format!("/v1/jobs/{}/report", now["id"].as_str().unwrap());
        let report: Value = app.get(&place).await.json().await.unwrap();
        assert_eq!(report["resolved"]["tools"][0]["tool_revision"], 2, "{}", one.0);
        assert_eq!(report["resolved"]["tools"][1]["is_left_alone"], true, "{}", one.0);
    }
}

#[tokio::test]
async fn tools_are_found_by_their_names_and_cutters_in_the_text_are_compared() {
    let app = spawn().await;
    put(&app, "m", "A", &json!({"number": 12, "name": "BALL_10", "kind": "ball", "radius_mm": 5})).await;
    let siemens = "%_N_P_MPF\n;$PATH=/_N_MPF_DIR\nN10 G71 G90 G94 G54\nT=\"Ball_10\"\nM6\nN20 G0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nN30 G1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000\nN50 M30\n";
    let report = app.report("m", CC, &format!("{ZERO}&contact=feed-plane"), siemens).await;
    let tool = &report["resolved"]["tools"][0];
    assert_eq!((&tool["tool_id"], &tool["tool_revision"]), (&json!("A"), &json!(1)), "{report}");
    let understood = app.report("m", "interpretation", "", siemens).await;
    assert_eq!(understood["motions"][0]["tool_number"], 12, "{understood}");
    let stamped = app.program("m", CC, "work_offset_mm=0,0,0&contact=feed-plane", siemens).await;
    assert!(unstamped(&stamped).1.is_some());
    // CUTTER/ states the diameter.
    for (diameter, fits) in [("10.0", true), ("8.0", false)] {
        let apt = format!(
            "UNITS/MM\nMULTAX/ON\nLOADTL/12\nCUTTER/{diameter}\nFEDRAT/1200,MMPM\nGOTO/100,0,0,0,0,1,0.1,0,1\nGOTO/101,0,0,0,0,1,0.1,0,1\nFINI\n"
        );
        let query = "contact=normals&work_offset_mm=0,0,0";
        if fits {
            app.report("m", CC, query, &apt).await;
            continue;
        }
        let body = problem(app.operate("m", CC, query, &apt, "*/*").await, "invalid-request").await;
        let detail = body["detail"].as_str().unwrap();
        assert!(detail.contains("8.000 mm") && detail.contains("10.000 mm"), "{detail}");
        assert!(body["line"].is_u64(), "{body}");
    }
}
