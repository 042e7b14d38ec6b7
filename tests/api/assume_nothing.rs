//! What nobody states is refused or left alone, and never assumed: contact, unit, work offset, tool length, feed.

use std::sync::Arc;

use reqwest::StatusCode;
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::support::{App, ac_table, kinds, pointers, problem, program_form, spawn_real, unstamped};

const CC: &str = "cc-compensation";
const WEAR: &str = "wear-compensation";

/// A pocket at A0 C0: a plunge, corners, a retract.
const FLAT: &str = "G90 G21 G94\nG0 X0.000 Y0.000 Z10.000 A0.000 C0.000\nG1 Z-1.000 F1577\nY-6.000\nX12.000 Y-9.000\nY4.000\nX0.000\nZ10.000\nM30\n";
/// Turns both rotary axes while the tip moves.
const TURNING: &str = "G90 G21 G94\nG0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nG1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000\nX20.000 Y5.000 Z-2.000 A25.000 C60.000\nM30\n";
/// An inch program whose header has no G20.
const INCH: &str = "%\n(inch)\nG90 G94\nG0 X0. Y0. Z2. A0. C0.\nG1 Z1.7224 F20.\nX1.\nX2. A5. C5.\nM30\n%\n";
/// Moves under G54 and under G55.
const TWO_OFFSETS: &str = "G90 G21 G94\nG54\nG0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nG1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000\nX20.000 Y5.000 Z-2.000 A25.000 C60.000\nG55\nG1 X40.000 Y0.000 Z0.000 A30.000 C95.000\nX20.000 Y5.000 Z-2.000 A25.000 C60.000\nX40.000 Y0.000 Z0.000 A30.000 C95.000\nM30\n";
const TIP: &str = "tool_radius_mm=5&contact=tip";

/// A machine that states nothing of its programs, and one with both rotary axes in the head.
async fn spawn() -> App {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    assert_eq!(app.put_machine("m", &ac_table()).await.status(), StatusCode::CREATED);
    let mut head = ac_table();
    head["kinematics"]["rotary_axes"] = json!([
        {"name": "C", "side": "head", "direction": [0, 0, 1], "point_mm": [0, 0, 0]},
        {"name": "A", "side": "head", "direction": [1, 0, 0], "point_mm": [0, 0, 100], "limits_deg": [-120, 120]}
    ]);
    assert_eq!(app.put_machine("head", &head).await.status(), StatusCode::CREATED);
    app
}

async fn refused(app: &App, machine: &str, operation: &str, query: &str, program: &str, code: &str) -> Value {
    problem(app.operate(machine, operation, query, program, "*/*").await, code).await
}

#[tokio::test]
async fn where_no_rotary_axis_turns_a_program_comes_back_byte_for_byte_whatever_the_contact() {
    let app = spawn().await;
    for contact in ["", "&contact=auto", "&contact=tip", "&contact=feed-plane"] {
        for offset in ["", "&work_offset_mm=5,-8,40"] {
            let query = format!("tool_radius_mm=5{contact}{offset}");
            assert_eq!(app.program("m", CC, &query, FLAT).await, FLAT, "{query}");
            let report = app.report("m", CC, &query, FLAT).await;
            assert_eq!((&report["motions_over_tolerance"], &report["steps"]), (&json!(0), &json!([])));
        }
    }
    // Nothing states a contact: the tip, and how to state one.
    let report = app.report("m", CC, "tool_radius_mm=5", FLAT).await;
    assert_eq!((&report["contact"], kinds(&report)), (&json!("tip"), vec!["contact_unknown".to_owned()]));
    let detail = report["warnings"][0]["detail"].as_str().unwrap();
    for way in ["U V W", "normals", "surface", "not corrected"] {
        assert!(detail.contains(way), "{way}: {detail}");
    }
}

#[tokio::test]
async fn what_cc_made_is_not_changed_again() {
    let app = spawn().await;
    for contact in ["auto", "tip", "feed-plane"] {
        let query = format!("tool_radius_mm=5&contact={contact}&work_offset_mm=5,-8,40");
        let made = app.program("m", CC, &query, TURNING).await;
        assert_ne!(made, TURNING);
        refused(&app, "m", CC, &query, &made, "already-compensated").await;
        let again = format!("{query}&allow_repeated=true");
        assert_eq!(app.program("m", CC, &again, &made).await, made, "{contact}");
        let report = app.report("m", CC, &again, &made).await;
        assert_eq!((&report["steps"], &report["motions_left_over"]), (&json!([]), &json!(0)), "{contact}");
    }
}

#[tokio::test]
async fn the_unit_of_the_text_wins_then_that_of_the_request_then_that_of_the_profile() {
    let app = spawn().await;
    let mut profile = ac_table();
    profile["program_unit"] = json!("inch");
    app.put_machine("inches", &profile).await;
    // A tool 0.2 mm shorter goes deeper by so much in the program's own unit.
    let shorter = "nominal_tool.radius_mm=5&actual_tool.radius_mm=5&nominal_tool.length_mm=80&actual_tool.length_mm=79.8&contact=feed-plane&work_offset_mm=0,0,0&stamp=none";
    for (machine, unit, header, z, by) in [
        ("m", "&unit=inch", "", "Z1.7145", "request"),
        ("m", "&unit=mm", "", "Z1.5224", "request"),
        ("m", "", "G20 ", "Z1.7145", "program"),
        ("m", "", "G21 ", "Z1.5224", "program"),
        ("inches", "", "", "Z1.7145", "profile"),
        ("inches", "&unit=mm", "", "Z1.5224", "request"),
        ("inches", "&unit=mm", "G20 ", "Z1.7145", "program"),
        ("example-ac-table", "", "", "Z1.5224", "profile"),
        ("example-ac-table", "", "G20 ", "Z1.7145", "program"),
    ] {
        let program = INCH.replace("G90 G94", &format!("{header}G90 G94"));
        let query = format!("{shorter}{unit}");
        let text = app.program(machine, WEAR, &query, &program).await;
        assert!(text.contains(&format!("\nG1 {z} F20.\n")), "{machine} {query} {header}: {text}");
        let report = app.report(machine, WEAR, &query, &program).await;
        let expected = if z == "Z1.7145" { "inch" } else { "mm" };
        assert_eq!(report["resolved"]["unit"], expected, "{machine} {query} {header}");
        assert_eq!(report["resolved"]["unit_stated_by"], by, "{machine} {query} {header}");
        // A disagreement is told.
        let differs = header == "G20 " && machine != "m";
        assert_eq!(kinds(&report).contains(&"unit_disagrees".to_owned()), differs, "{report}");
    }
}

#[tokio::test]
async fn a_unit_that_nobody_states_is_refused_with_its_line_and_the_cure() {
    let app = spawn().await;
    let shorter =
        "nominal_tool.radius_mm=5&actual_tool.radius_mm=4.9&contact=feed-plane&work_offset_mm=0,0,0";
    let at_zero = "tool_radius_mm=5&contact=tip&work_offset_mm=0,0,0";
    let cube = "surface.kind=plane&surface.length_mm=4&surface.width_mm=4&samples=10";
    let apt = "MULTAX/ON\nFEDRAT/1200,MMPM\nGOTO/100,0,0,0,0,1\nGOTO/101,0,0,0,0,1\n";
    let siemens = "%_N_P_MPF\n;$PATH=/_N_MPF_DIR\nN10 G90 G94 G54\nN20 G0 X=1 Y=0 Z=5 A=0 C=0\nN30 M30\n";
    for (operation, query, program, line) in [
        (CC, at_zero, INCH, 4),
        (WEAR, shorter, INCH, 4),
        ("compensation", "cc.tool_radius_mm=5&work_offset_mm=0,0,0", INCH, 4),
        ("compensation", "location_errors=true&work_offset_mm=0,0,0", INCH, 4),
        ("verification", &format!("tool.radius_mm=5&work_offset_mm=0,0,0&{cube}"), INCH, 4),
        ("interpretation", "", INCH, 4),
        ("posting", "work_offset_mm=0,0,0", apt, 3),
        (CC, at_zero, siemens, 4),
    ] {
        let body = refused(&app, "m", operation, query, program, "unit-unknown").await;
        assert_eq!((&body["status"], &body["line"]), (&json!(422), &json!(line)), "{operation}: {body}");
        assert_eq!(pointers(&body), [format!("/program/{line}")], "{operation}");
        let detail = body["detail"].as_str().unwrap();
        for cure in ["`unit`", "G20 or G21", "`program_unit`", "UNITS/"] {
            assert!(detail.contains(cure), "{operation} {cure}: {detail}");
        }
        let answer = app.operate("m", operation, &format!("{query}&unit=mm"), program, "*/*").await;
        assert_eq!(answer.status(), StatusCode::OK, "{operation}: {}", answer.text().await.unwrap());
    }
    // Dialects that say it themselves.
    let table = "X,Y,Z,A,C\n0.000,0.000,50.000,0.000,0.000\n0.000,0.000,0.000,0.000,0.000\n";
    let heidenhain = "0 BEGIN PGM P INCH\n1 L X+1.000 Y+0.000 Z+2.000 A+0 C+0 R0 FMAX\n2 L Z+1.000 F20\n3 END PGM P INCH\n";
    for (program, unit) in [(table, "mm"), (heidenhain, "inch")] {
        let report = app.report("m", "interpretation", "feed_mm_per_min=100", program).await;
        assert_eq!(
            (&report["resolved"]["unit"], &report["resolved"]["unit_stated_by"]),
            (&json!(unit), &json!("program"))
        );
    }
    // Nothing of it was kept.
    assert_eq!(
        app.get("/v1/jobs").await.json::<Value>().await.unwrap()["items"].as_array().unwrap().len(),
        7
    );
}

#[tokio::test]
async fn what_turns_in_machine_coordinates_needs_its_work_offset_stated_and_zero_is_an_answer() {
    let app = spawn().await;
    let plane = "tool.radius_mm=5&surface.kind=plane&surface.length_mm=4&surface.width_mm=4&samples=10";
    let level = "G90 G21 G94\nG0 X0.000 Y0.000 Z10.000 A0.000 C0.000\nG1 Z1.000 F1000\nX5.000\nM30\n";
    let tcp = TURNING.replace("G90 G21", "G43.4 G90 G21");
    let errors = "location_errors=true";
    let single = "singularity=densify&tool_radius_mm=5&contact=tip";
    let mut off = ac_table();
    off["kinematics"]["rotary_axes"][0]["location_error"] = json!({"e_y_um": 20});
    app.put_machine("off", &off).await;
    for (machine, operation, query, program, line) in [
        ("m", CC, TIP, TURNING, Some(3)),
        ("m", CC, single, TURNING, Some(3)),
        ("m", CC, TIP, level, None),
        ("m", CC, TIP, tcp.as_str(), None),
        ("m", CC, "tool_radius_mm=5&contact=tip&interpolation=tcp", TURNING, None),
        ("m", "compensation", "cc.tool_radius_mm=5", TURNING, Some(3)),
        ("m", "verification", plane, TURNING, Some(3)),
        ("m", "verification", plane, level, None),
        // Location errors move any motion.
        ("off", "compensation", errors, TURNING, Some(2)),
        ("off", "compensation", errors, level, Some(2)),
    ] {
        if let Some(line) = line {
            let body = refused(&app, machine, operation, query, program, "invalid-request").await;
            assert_eq!(body["line"], line, "{operation} {query}: {body}");
            assert!(pointers(&body).iter().all(|pointer| pointer == "/work_offset_mm"), "{body}");
            let detail = body["detail"].as_str().unwrap();
            assert!(
                detail.contains("0,0,0 is an answer") && detail.contains("`work_offsets_mm`"),
                "{detail}"
            );
            assert_eq!(body["block"], program.lines().nth(line - 1).unwrap());
        } else {
            app.operate(machine, operation, query, program, "*/*").await.error_for_status().unwrap();
        }
        let zero = format!("{query}&work_offset_mm=0,0,0");
        let answer = app.operate(machine, operation, &zero, program, "*/*").await;
        assert_eq!(answer.status(), StatusCode::OK, "{operation} {zero}: {}", answer.text().await.unwrap());
    }
    // Kinematics keep zero as their default.
    let pose = json!({"poses": [{"x": 1, "y": 0, "z": 0, "i": 0.3, "j": 0, "k": 1}]});
    let answer = app.post_json("/v1/machines/m/inverse-kinematics", &pose).await;
    assert_eq!(answer.status(), StatusCode::OK);
}

#[tokio::test]
async fn a_head_needs_the_length_of_its_tool_stated() {
    let app = spawn().await;
    let body = refused(&app, "head", CC, TIP, TURNING, "invalid-request").await;
    assert_eq!(body["line"], 3);
    assert!(pointers(&body).iter().all(|pointer| pointer == "/tool_length_mm"), "{body}");
    assert!(body["detail"].as_str().unwrap().contains("0 is an answer"));
    let lengths = ["0", "80"].map(|length| format!("{TIP}&tool_length_mm={length}"));
    let mut before = Vec::new();
    for query in &lengths {
        before.push(app.report("head", CC, query, TURNING).await["before"]["max_um"].as_f64().unwrap());
    }
    assert!((before[0] - before[1]).abs() > 100.0, "{before:?}");
    assert_eq!(app.operate("head", CC, TIP, FLAT, "*/*").await.status(), StatusCode::OK);
}

#[tokio::test]
async fn a_fault_repeated_on_many_lines_is_one_with_a_count() {
    use std::fmt::Write;
    let app = spawn().await;
    let mut program = "G90 G21 G94\nG0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nG1 F1000\n".to_owned();
    for motion in 1..=3000 {
        writeln!(
            program,
            "X{:.3} A{:.3} C{:.3}",
            f64::from(motion % 300),
            f64::from(motion % 50),
            f64::from(motion % 70)
        )
        .unwrap();
    }
    let body = refused(&app, "m", CC, TIP, &program, "invalid-request").await;
    assert_eq!(body["errors"].as_array().unwrap().len(), 1, "{body}");
    let detail = body["errors"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("2999 more") && detail.contains("`work_offset_mm`"), "{detail}");
}

#[tokio::test]
async fn work_offsets_by_name_are_taken_from_query_form_and_profile() {
    let app = spawn().await;
    let both = json!({"G54": [5, -8, 40], "G55": [0, 0, 0]});
    let mut profile = ac_table();
    profile["work_offsets_mm"] = both.clone();
    app.put_machine("known", &profile).await;
    let query = format!("{TIP}&stamp=none");
    let by_query = app
        .program(
            "m",
            CC,
            &format!("{query}&work_offsets_mm.G54=5,-8,40&work_offsets_mm.G55=0,0,0"),
            TWO_OFFSETS,
        )
        .await;
    let by_profile = app.program("known", CC, &query, TWO_OFFSETS).await;
    let parameters = json!({"tool_radius_mm": 5, "contact": "tip", "stamp": "none", "work_offsets_mm": both});
    let request = app.client.post(app.url("/v1/machines/m/cc-compensation"));
    let form = request.multipart(program_form(&parameters, TWO_OFFSETS, "two.nc")).send().await.unwrap();
    assert_eq!((form.status(), form.text().await.unwrap()), (StatusCode::OK, by_query.clone()));
    assert_eq!(by_profile, by_query);
    assert_ne!(by_query, TWO_OFFSETS);
    // The request wins over the profile, offset by offset.
    let report = app.report("known", CC, &format!("{TIP}&work_offsets_mm.G55=1,2,3"), TWO_OFFSETS).await;
    let said: Vec<_> = report["resolved"]["work_offsets"]
        .as_array()
        .unwrap()
        .iter()
        .map(|offset| (&offset["name"], &offset["origin_mm"], &offset["stated_by"], &offset["is_left_alone"]))
        .collect();
    assert_eq!(
        json!(said),
        json!([["G54", [5.0, -8.0, 40.0], "profile", false], ["G55", [1.0, 2.0, 3.0], "request", false]])
    );
    // Other controls' names, one with a dot.
    for (name, text, origin) in [("G54.1 P3", "G54.1 P3", [0, 0, 7]), ("G59.1", "G59.1", [0, 0, 8])] {
        let program = TWO_OFFSETS.replace("G55", text);
        let query = format!(
            "{TIP}&work_offsets_mm.G54=5,-8,40&work_offsets_mm.{}={}",
            name.replace(' ', "%20"),
            "0,0,".to_owned() + &origin[2].to_string()
        );
        let report = app.report("m", CC, &query, &program).await;
        assert_eq!(
            report["resolved"]["work_offsets"][1]["origin_mm"],
            json!(origin.map(f64::from)),
            "{name}: {report}"
        );
        assert_eq!(report["resolved"]["work_offsets"][1]["is_left_alone"], false);
    }
    for (name, pointer) in [("G53", "/work_offsets_mm/G53"), ("table", "/work_offsets_mm/table")] {
        let query = format!("{TIP}&work_offsets_mm.{name}=0,0,0");
        assert_eq!(
            pointers(&refused(&app, "m", CC, &query, TWO_OFFSETS, "invalid-request").await),
            [pointer]
        );
    }
}

#[tokio::test]
async fn a_switch_to_an_offset_that_is_not_given_leaves_the_program_alone_from_line_to_line() {
    let app = spawn().await;
    for query in ["work_offset_mm=5,-8,40", "work_offsets_mm.G54=5,-8,40"] {
        let query = format!("{TIP}&stamp=none&{query}");
        let report = app.report("m", CC, &query, TWO_OFFSETS).await;
        let rows = &report["resolved"]["work_offsets"];
        assert_eq!(rows.as_array().unwrap().len(), 2, "{rows}");
        assert_eq!(
            rows[1],
            json!({"name": "G55", "origin_mm": null, "stated_by": null, "is_left_alone": true, "first_line": 7, "last_line": 9, "motions": 3})
        );
        assert_eq!((&rows[0]["first_line"], &rows[0]["last_line"]), (&json!(3), &json!(5)));
        let warnings = report["warnings"].as_array().unwrap();
        let warning = warnings.iter().find(|warning| warning["kind"] == "work_offset_changed").unwrap();
        assert_eq!((&warning["count"], &warning["line"]), (&json!(3), &json!(7)), "{warning}");
        assert!(warning["detail"].as_str().unwrap().contains("work_offsets_mm"), "{warning}");
        assert_eq!(report["motions_checked"], 2);
        let text = app.program("m", CC, &query, TWO_OFFSETS).await;
        let after = TWO_OFFSETS.split_once("G55\n").unwrap().1;
        assert!(text.replace(" F1000.\nX20", "\nX20").ends_with(after) && text != TWO_OFFSETS, "{text}");
    }
}

#[tokio::test]
async fn a_start_lets_programs_of_fewer_axes_be_followed_from_their_first_block() {
    let app = spawn().await;
    let program = "G21 G90 G94\nG1 X10.000 F1000\nY5.000\nA10.000 C30.000\nX20.000 A0.000 C0.000\nM30\n";
    let query = format!("{TIP}&work_offset_mm=0,0,0");
    for (start, checked) in [
        ("", 0),
        ("&start.A=0&start.C=0", 0),
        ("&start.X=0&start.Y=0&start.Z=0&start.A=0&start.C=0", 4),
        ("&start.Z=0&start.A=0&start.C=0", 2),
    ] {
        let report = app.report("m", CC, &format!("{query}{start}"), program).await;
        assert_eq!(report["motions_checked"], checked, "{start}: {report}");
        assert_eq!(kinds(&report).contains(&"nothing_checked".to_owned()), checked == 0, "{report}");
    }
    let body = refused(&app, "m", CC, &format!("{query}&start.B=0"), program, "invalid-request").await;
    assert_eq!(pointers(&body), ["/start/B"]);
}

#[tokio::test]
async fn every_compensated_program_says_how_many_motions_were_looked_at() {
    let app = spawn().await;
    let nothing = "G90 G21 G94\nG0 X0.000 Y0.000 Z5.000\nG1 X1.000 F1000\nM30\n";
    let rapids = "G90 G21 G94\nG0 X1.000 Y0.000 Z5.000 A0.000 C0.000\nM30\n";
    let tools = "nominal_tool.radius_mm=5&actual_tool.radius_mm=4.9&contact=feed-plane&work_offset_mm=0,0,0";
    for (operation, query, program, expected) in [
        (CC, TIP, FLAT, "6"),
        (CC, TIP, nothing, "0"),
        (WEAR, tools, rapids, "0"),
        (WEAR, tools, TURNING, "3"),
        ("compensation", "cc.tool_radius_mm=5&cc.contact=tip", nothing, "0"),
        ("compensation", "cc.tool_radius_mm=5&cc.contact=tip", FLAT, "6"),
    ] {
        let response = app.operate("m", operation, query, program, "text/plain").await;
        assert_eq!(response.status(), StatusCode::OK, "{operation} {query}");
        assert_eq!(response.headers()["trunnion-motions-checked"], expected, "{operation} {program}");
        let job = response.headers()["location"].to_str().unwrap().to_owned();
        let kept = app.get(&format!("{job}/program")).await;
        assert_eq!(kept.headers()["trunnion-motions-checked"], expected, "{operation}, kept");
    }
    let report = app.report("m", CC, TIP, nothing).await;
    assert!(kinds(&report).contains(&"nothing_checked".to_owned()), "{report}");
}

#[tokio::test]
async fn no_feed_is_written_over_its_bound() {
    let app = spawn().await;
    let feeds = |text: &str| -> Vec<f64> {
        let words = text.split_whitespace().filter_map(|word| word.strip_prefix('F'));
        words.map(|feed| feed.parse().unwrap()).collect()
    };
    // The tip runs a hundred times as far as the table's words, whose pole is near: 10 times the programmed F at most.
    let program = "G90 G21 G94\nG0 X0.000 Y0.000 Z300.000 A0.000 C0.000\nG1 X0.100 A40.000 C60.000 F1000\nX0.200 A80.000 C120.000\nM30\n";
    let mut profile = ac_table();
    profile["max_feed_mm_per_min"] = json!(1500);
    app.put_machine("bounded", &profile).await;
    for (machine, bound, max, by) in [
        ("m", "", 10_000.0, "rule"),
        ("m", "&max_feed_mm_per_min=1200", 1200.0, "request"),
        ("bounded", "", 1500.0, "profile"),
        ("bounded", "&max_feed_mm_per_min=1200", 1200.0, "request"),
    ] {
        let query = format!("{TIP}&work_offset_mm=0,0,0{bound}");
        let text = unstamped(&app.program(machine, CC, &query, program).await).0;
        assert!(feeds(&text).iter().all(|feed| *feed <= max), "{machine} {bound}: {text}");
        let report = app.report(machine, CC, &query, program).await;
        assert_eq!(report["resolved"]["max_feed_stated_by"], by);
        let left = report["motions_left_over"].as_u64().unwrap();
        assert_eq!(kinds(&report).contains(&"feed_too_high".to_owned()), left > 0, "{report}");
        // A block that would need more stays as it was, and counts as over the tolerance.
        assert_eq!(text.contains("G1 X0.100 A40.000 C60.000 F1000\n"), left > 0, "{machine} {bound}: {text}");
        assert_eq!(report["after"]["max_um"].as_f64().unwrap() > 10.0, left > 0);
    }
}

#[tokio::test]
async fn presets_and_stored_profiles_are_given_no_unit() {
    let app = spawn().await;
    let presets: Value = app.get("/v1/machine-presets").await.json().await.unwrap();
    let text = presets.to_string();
    for member in ["program_unit", "work_offsets_mm", "max_feed_mm_per_min"] {
        assert!(!text.contains(member), "{member}");
    }
    let stored: Value = app.get("/v1/machines/m").await.json().await.unwrap();
    assert!(stored.get("program_unit").is_none(), "{stored}");
    let example: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    assert_eq!(example["program_unit"], "mm");
}

#[tokio::test]
async fn the_codes_at_the_start_are_those_of_the_profile() {
    let app = spawn().await;
    let mut profile = ac_table();
    profile["start_codes"] = json!("G1 G17 G90 G94");
    app.put_machine("begins", &profile).await;
    let program = "F500.0\nX0.0000 Y0.0000 Z20.0000 A10.0000 C20.0000\nX30.0000 A25.0000 C60.0000\nM30\n";
    let query = "tool_radius_mm=5&unit=mm&work_offset_mm=5,-8,40&stamp=none";
    // Where nobody states how the tool moves, nothing is changed.
    assert_eq!(app.program("m", CC, query, program).await, program);
    let compensated = app.program("begins", CC, query, program).await;
    assert!(compensated.lines().count() > program.lines().count(), "{compensated}");
    let stated = app.program("m", CC, query, &program.replace("F500.0", "G1 F500.0")).await;
    assert_eq!(compensated, stated.replace("G1 F500.0", "F500.0"));
}
