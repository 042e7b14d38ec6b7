//! What leaves changed says so, and no step is done twice to one program.

use std::sync::Arc;

use reqwest::{Client, Response, StatusCode};
use serde_json::{Value, json};
use trunnion::jobs::CutterContactCompensator;

use crate::queue::{accepted, ended};
use crate::support::{App, ac_table, problem, program_form, spawn_real, unstamped};

const CC: &str = "cc-compensation";
const WEAR: &str = "wear-compensation";
const ALL: &str = "compensation";
const BLADE: &str = include_str!("../../docs/examples/blade.nc");

const CC_QUERY: &str = "tool_radius_mm=5&work_offset_mm=12,-7,35";
const WEAR_QUERY: &str = "nominal_tool.radius_mm=5&actual_tool.radius_mm=4.9&work_offset_mm=12,-7,35";
const CC_STEP: &str = "cc.tool_radius_mm=5&work_offset_mm=12,-7,35";
const WEAR_STEP: &str =
    "wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=4.9&work_offset_mm=12,-7,35";
const ERRORS_STEP: &str = "location_errors=true&work_offset_mm=12,-7,35";
/// Every operation with each step that makes something of its own.
const STEPS: [(&str, &str, &str); 5] = [
    ("cc", CC, CC_QUERY),
    ("wear", WEAR, WEAR_QUERY),
    ("cc", ALL, CC_STEP),
    ("wear", ALL, WEAR_STEP),
    ("location_errors", ALL, ERRORS_STEP),
];

/// Two machines with the same errors of location.
async fn spawn() -> App {
    let app = spawn_real(Arc::new(CutterContactCompensator::default())).await;
    let mut profile = ac_table();
    profile["kinematics"]["rotary_axes"][0]["location_error"] =
        json!({"e_x_um": 12.0, "e_y_um": -21.0, "e_b_urad": -63.0});
    for id in ["one", "two"] {
        assert_eq!(app.put_machine(id, &profile).await.status(), StatusCode::CREATED);
    }
    app
}

/// The same operation by a form of its own, and by a posted job.
fn order(machine: &str, operation: &str, step: &str) -> Value {
    let tools = json!({"nominal_tool": {"radius_mm": 5}, "actual_tool": {"radius_mm": 4.9}});
    let mut parameters = match (operation, step) {
        (CC, _) => json!({"tool_radius_mm": 5}),
        (WEAR, _) => tools,
        (_, "cc") => json!({"cc": {"tool_radius_mm": 5}}),
        (_, "wear") => json!({"wear": tools}),
        _ => json!({"location_errors": true}),
    };
    parameters["work_offset_mm"] = json!([12, -7, 35]);
    json!({"machine_id": machine, "operation": operation, "parameters": parameters})
}

#[tokio::test]
async fn a_stamp_is_one_comment_line_in_the_programs_own_form_after_its_head() {
    let app = spawn().await;
    let iso = "%\r\nO1001(PART)\r\nG90 G21 G94\r\nG0 X0.000 Y0.000 Z50.000 A0.000 C0.000\r\nG1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000\r\nM30\r\n%\r\n";
    let siemens = "%_N_PART_MPF\n;$PATH=/_N_MPF_DIR\nN10 G71 G90 G94 G54\nN20 G0 X0.000 Y0.000 Z50.000 A0.000 C0.000\nN30 G1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000\nN50 M30\n";
    let heidenhain = "0 BEGIN PGM PART MM\n1 L X+0.000 Y+0.000 Z+50.000 A+0.000 C+0.000 R0 FMAX\n2 L X+0.000 Y+0.000 Z+0.000 A+10.000 C+10.000 F1000\n3 M30\n4 END PGM PART MM\n";
    let apt = "PARTNO/ PART\nUNITS/MM\nMULTAX/ON\nFEDRAT/1200,MMPM\nGOTO/100,0,0,0,0,1,0.1,0,1\nGOTO/101,0,0,0,0,1,0.1,0,1\nFINI\n";
    let csv =
        "X,Y,Z,A,C,nx,ny,nz,F\n0.000,0.000,50.000,0,0,0,0.1,1,1000\n0.000,0.000,0.000,10,10,0,0.1,1,1000\n";
    let tools = "nominal_tool.radius_mm=5&actual_tool.radius_mm=4.9&work_offset_mm=0,0,0&contact=";
    for (program, contact, above, before, after) in [
        (iso, "feed-plane", 2, "(Trunnion ", ")\r\n"),
        (siemens, "feed-plane", 2, "; Trunnion ", "\n"),
        (heidenhain, "feed-plane", 1, "; Trunnion ", "\n"),
        (apt, "normals", 1, "$$ Trunnion ", "\n"),
        (csv, "normals", 0, "", ""),
    ] {
        let query = format!("{tools}{contact}");
        let text = app.program("one", WEAR, &query, program).await;
        let bare = app.program("one", WEAR, &format!("{query}&stamp=none"), program).await;
        assert_ne!(bare, program);
        if before.is_empty() {
            assert_eq!(text, bare, "a table has no comments");
            continue;
        }
        let lines: Vec<_> = text.split_inclusive('\n').collect();
        assert!(lines[above].starts_with(before) && lines[above].ends_with(after), "{text}");
        assert_eq!(lines[..above].concat(), program.split_inclusive('\n').take(above).collect::<String>());
        // Nothing else is different, and nothing of it stays with `stamp=none`.
        assert_eq!(unstamped(&text).0, bare);
        assert!(!bare.contains("Trunnion"));
    }
}

/// A long pass with two more sections, cut short or not. Both have the same stamp, apart from the digest of the source.
fn pass(blocks: u32, late: &str, turn: f64) -> String {
    use std::fmt::Write as _;
    let mut text = String::from("%\nO1\nG21 G90 G94 G54\nT1 M6\nG1 F1000\n");
    for block in 0..blocks {
        let phase = f64::from(block);
        writeln!(
            text,
            "X{:.3} Y-7.25 Z{:.3} A10.5 C{:.3}",
            0.05 * phase,
            40.0 + 0.1 * (phase % 7.0),
            turn * phase
        )
        .unwrap();
        if block == blocks * 3 / 4 {
            text.push_str(late);
        }
    }
    text.push_str("M30\n%\n");
    text
}

#[tokio::test]
async fn a_long_program_has_its_stamp_whatever_its_head_lets_expect() {
    let app = spawn().await;
    let query = format!("{CC_QUERY}&work_offsets_mm.G55=1,2,3");
    // Nothing that the head does not show, and another offset that the head does not show.
    for late in ["", "G0 Z90\nG55\nG0 X5 Y5 Z80 A0 C0\nG1 X6 Y5 Z80 A3 C20\n"] {
        for operation in [CC, ALL] {
            let query = if operation == CC { query.clone() } else { format!("cc.{query}") };
            let [(short, _), (long, text)] = {
                let mut found = Vec::new();
                for blocks in [40, 4000] {
                    let program = pass(blocks, late, 2.5);
                    let text = app.program("one", operation, &query, &program).await;
                    let bare = app.program("one", operation, &format!("{query}&stamp=none"), &program).await;
                    let (rest, stamp) = unstamped(&text);
                    assert!(rest == bare, "{late}: something besides the stamp differs");
                    found.push((stamp.unwrap(), text));
                }
                <[_; 2]>::try_from(found).unwrap()
            };
            assert!(text.len() > 2 * 64 * 1024);
            assert!(text.lines().nth(2).unwrap().starts_with("(Trunnion "), "{late}");
            let without_source = |stamp: &str| {
                let (said, parameters) = stamp.split_once(" parameters ").unwrap();
                (said.split_once(" source ").unwrap().0.to_owned(), parameters.to_owned())
            };
            assert_eq!(without_source(&long), without_source(&short), "{late}");
        }
    }
    // A stamp is expected, but nothing changes.
    let still = pass(4000, "", 0.0);
    assert!(app.program("one", CC, &query, &still).await == still);
}

#[tokio::test]
async fn the_stamp_names_what_was_done_and_is_the_same_for_the_same() {
    let app = spawn().await;
    let sha256 =
        app.report("one", CC, &format!("{CC_QUERY}&tolerance_um=9"), BLADE).await["input_sha256"].clone();
    let source = &sha256.as_str().unwrap()[..16];
    let all = format!("{WEAR_STEP}&location_errors=true&cc.tolerance_um=5");
    for (operation, query, steps) in [
        (CC, CC_QUERY, "cc"),
        (WEAR, WEAR_QUERY, "wear"),
        (ALL, ERRORS_STEP, "location_errors"),
        (ALL, all.as_str(), "wear,location_errors,cc"),
        // A step that changed nothing is not named.
        (ALL, &format!("{WEAR_STEP}&cc.tolerance_um=10000"), "wear"),
    ] {
        let text = app.program("one", operation, query, BLADE).await;
        let stamp = unstamped(&text).1.unwrap();
        let (said, parameters) = stamp.split_once(" parameters ").unwrap();
        let version = env!("CARGO_PKG_VERSION");
        assert_eq!(
            said,
            format!("{version} {operation} steps {steps} machine one revision 1 tool 1 source {source}")
        );
        assert!(
            parameters.len() == 16 && parameters.bytes().all(|digit| digit.is_ascii_hexdigit()),
            "{stamp}"
        );
        // Again, under another name, later, as another job: no job and no time is in it.
        let path = app.url(&format!("/v1/machines/one/{operation}?{query}"));
        let part = reqwest::multipart::Part::text(BLADE).file_name("other name.nc");
        let form = reqwest::multipart::Form::new().part("program", part);
        assert_eq!(app.client.post(path).multipart(form).send().await.unwrap().text().await.unwrap(), text);
        let elsewhere = unstamped(&app.program("two", operation, query, BLADE).await).1.unwrap();
        assert_eq!(elsewhere, stamp.replace("machine one", "machine two"), "the same parameters");
    }
    let parameters = |text: &str| unstamped(text).1.unwrap().split_once(" parameters ").unwrap().1.to_owned();
    let mut found = std::collections::BTreeSet::new();
    for query in [CC_QUERY, &format!("{CC_QUERY}&tolerance_um=4"), "tool_radius_mm=5&work_offset_mm=12,-7,36"]
    {
        found.insert(parameters(&app.program("one", CC, query, BLADE).await));
    }
    assert_eq!(found.len(), 3, "other parameters, another digest");
}

#[tokio::test]
async fn what_nothing_changed_leaves_as_it_came() {
    let app = spawn().await;
    let same = "wear.nominal_tool.radius_mm=5&wear.actual_tool.radius_mm=5&work_offset_mm=12,-7,35";
    for (machine, operation, query) in [
        ("one", CC, format!("{CC_QUERY}&tolerance_um=10000")),
        ("one", WEAR, WEAR_QUERY.replace("4.9", "5")),
        ("one", ALL, format!("{same}&cc.tolerance_um=10000")),
        ("example-ac-table", ALL, ERRORS_STEP.to_owned()),
    ] {
        for program in [BLADE.to_owned(), BLADE.replace('\n', "\r\n")] {
            assert_eq!(app.program(machine, operation, &query, &program).await, program, "{operation}");
            let report = app.report(machine, operation, &query, &program).await;
            assert_eq!((&report["steps"], &report["output_sha256"]), (&json!([]), &report["input_sha256"]));
            // It is an output of the step, but not one that differs from its own input: the step may run on it.
            assert_eq!(
                app.operate(machine, operation, &query, &program, "*/*").await.status(),
                StatusCode::OK
            );
        }
    }
}

/// 409, the step, and a cure.
async fn is_done(response: Response, step: &str) {
    let body = problem(response, "already-compensated").await;
    assert_eq!(body["status"], 409);
    let detail = body["detail"].as_str().unwrap();
    assert!(detail.contains(&format!("`{step}`")), "{detail}");
    let cure = if step == "cc" { "allow_repeated=true" } else { "Send the program from before that step" };
    assert!(detail.contains(cure), "{detail}");
}

#[tokio::test]
async fn a_step_that_the_text_bears_is_refused_by_every_operation_on_every_machine() {
    let app = spawn().await;
    for (made, operation, query) in STEPS {
        let text = app.program("one", operation, query, BLADE).await;
        for (asked, operation, query) in STEPS {
            for machine in ["one", "two"] {
                let response = app.operate(machine, operation, query, &text, "*/*").await;
                if asked == made {
                    is_done(response, made).await;
                } else {
                    assert_eq!(response.status(), StatusCode::OK, "{made}, then {asked}");
                }
            }
            let job = ended(&app, &accepted(&app, &order("two", operation, asked), &text).await).await;
            if asked == made {
                assert_eq!(
                    (&job["state"], &job["problem"]["type"]),
                    (&json!("failed"), &json!("/problems/already-compensated")),
                    "{job}"
                );
                assert_eq!(job["problem"]["status"], 409);
            } else {
                assert_eq!(job["state"], "succeeded", "{job}");
            }
        }
    }
}

#[tokio::test]
async fn a_stored_output_is_known_by_its_digest_where_it_bears_no_stamp() {
    let app = spawn().await;
    for (made, operation, query) in STEPS {
        let text = app.program("one", operation, &format!("{query}&stamp=none"), BLADE).await;
        assert!(!text.contains("Trunnion"));
        for (asked, operation, query) in STEPS.into_iter().filter(|(asked, ..)| *asked == made) {
            for machine in ["one", "two"] {
                is_done(app.operate(machine, operation, query, &text, "*/*").await, made).await;
            }
            let job = ended(&app, &accepted(&app, &order("one", operation, asked), &text).await).await;
            assert_eq!(job["problem"]["type"], "/problems/already-compensated", "{job}");
        }
        // One byte is another program: nobody can tell from it.
        let other = text.replacen("(blade)", "(Blade)", 1);
        assert_eq!(app.operate("one", operation, query, &other, "*/*").await.status(), StatusCode::OK);
    }
}

#[tokio::test]
async fn a_step_without_a_stamp_is_known_through_the_jobs_that_came_after_it() {
    let app = spawn().await;
    let worn = app.program("one", WEAR, &format!("{WEAR_QUERY}&stamp=none"), BLADE).await;
    for query in [CC_QUERY.to_owned(), format!("{CC_QUERY}&stamp=none")] {
        let query = format!("{query}&tolerance_um=0.5");
        let corrected = app.program("one", CC, &query, &worn).await;
        assert_ne!(corrected, worn);
        assert!(!corrected.contains("wear"), "the second stamp tells only the second step");
        for (_, operation, query) in STEPS.into_iter().filter(|(step, ..)| *step == "wear") {
            is_done(app.operate("two", operation, query, &corrected, "*/*").await, "wear").await;
        }
        let order = order("one", CC, "cc");
        let job = ended(&app, &accepted(&app, &order, &corrected).await).await;
        assert_eq!(job["problem"]["type"], "/problems/already-compensated", "{job}");
    }
    // A queued job in the middle carries it on as well.
    let posted = ended(&app, &accepted(&app, &order("one", CC, "cc"), &worn).await).await;
    let output = app.get(&format!("/v1/jobs/{}/program", posted["id"].as_str().unwrap())).await;
    let corrected = output.text().await.unwrap();
    is_done(app.operate("one", WEAR, WEAR_QUERY, &corrected, "*/*").await, "wear").await;
}

#[tokio::test]
async fn a_key_is_not_told_what_was_made_on_machines_out_of_its_reach() {
    let mut app = spawn().await;
    app.close().await;
    let bare = app.program("one", WEAR, &format!("{WEAR_QUERY}&stamp=none"), BLADE).await;
    let stamped = app.program("one", WEAR, WEAR_QUERY, BLADE).await;
    let client = Client::builder().no_proxy().build().unwrap();
    for (machines, knows) in [(["two"].as_slice(), false), (&["one", "two"], true)] {
        let key = app.new_key(&["compute", "read"], Some(machines)).await;
        let ask = |program: &str| {
            let url = app.url(&format!("/v1/machines/two/{WEAR}?{WEAR_QUERY}"));
            client.post(url).bearer_auth(&key).body(program.to_owned()).send()
        };
        if knows {
            is_done(ask(&bare).await.unwrap(), "wear").await;
        } else {
            assert_eq!(ask(&bare).await.unwrap().status(), StatusCode::OK);
        }
        // What the text says is no secret.
        is_done(ask(&stamped).await.unwrap(), "wear").await;
        let form = crate::queue::form(&order("two", WEAR, "wear"), &bare);
        let posted = client.post(app.url("/v1/jobs")).bearer_auth(&key).multipart(form).send().await.unwrap();
        let place = posted.headers()["location"].to_str().unwrap().to_owned();
        let job = ended(&app, &place).await;
        assert_eq!(job["state"], if knows { "failed" } else { "succeeded" }, "{job}");
    }
}

#[tokio::test]
async fn cc_and_singularity_may_run_again_and_what_moves_ends_may_not() {
    let app = spawn().await;
    for (operation, query) in [
        (CC, CC_QUERY.to_owned()),
        (ALL, CC_STEP.to_owned()),
        (CC, format!("{CC_QUERY}&singularity=densify")),
        (CC, format!("{CC_QUERY}&contact=feed-plane")),
    ] {
        for stamp in ["", "&stamp=none"] {
            let query = format!("{query}{stamp}");
            let made = app.program("one", operation, &query, BLADE).await;
            is_done(app.operate("one", operation, &query, &made, "*/*").await, "cc").await;
            let again = app.program("one", operation, &format!("{query}&allow_repeated=true"), &made).await;
            assert!(again == made, "{operation} {query}");
        }
    }
    for (step, operation, query) in STEPS.into_iter().filter(|(step, ..)| *step != "cc") {
        for stamp in ["", "&stamp=none"] {
            let made = app.program("one", operation, &format!("{query}{stamp}"), BLADE).await;
            let again = format!("{query}&allow_repeated=true");
            is_done(app.operate("one", operation, &again, &made, "*/*").await, step).await;
        }
    }
}

#[tokio::test]
async fn a_replay_is_answered_before_anything_is_refused() {
    let app = spawn().await;
    let url = app.url(&format!("/v1/machines/one/{WEAR}?{WEAR_QUERY}&stamp=none"));
    let ask = |program: &str, key: &str| {
        app.client.post(&url).header("idempotency-key", key).body(program.to_owned()).send()
    };
    // The output of another order is the program of this one, which came first.
    let made = app.program("two", ALL, &format!("{CC_STEP}&stamp=none"), BLADE).await;
    let first = ask(&made, "k").await.unwrap();
    assert_eq!(first.status(), StatusCode::OK);
    let text = first.text().await.unwrap();
    // Now that very program is made by the step as well.
    let again = ask(&made, "k").await.unwrap();
    assert_eq!((again.status(), again.text().await.unwrap()), (StatusCode::OK, text.clone()));
    is_done(ask(&text, "another").await.unwrap(), "wear").await;
    problem(ask(&text, "k").await.unwrap(), "idempotency-key-reused").await;
}

#[tokio::test]
async fn the_name_of_the_answer_carries_the_name_of_the_source() {
    let app = spawn().await;
    for (name, expected) in [
        ("blade.nc", "blade-compensated.nc"),
        ("OP 20.final.MPF", "OP_20.final-compensated.MPF"),
        ("O1001", "O1001-compensated"),
    ] {
        for (step, operation, _) in STEPS {
            let parameters = &order("one", operation, step)["parameters"];
            let url = app.url(&format!("/v1/machines/one/{operation}"));
            let answer =
                app.client.post(url).multipart(program_form(parameters, BLADE, name)).send().await.unwrap();
            let disposition = answer.headers()["content-disposition"].to_str().unwrap();
            assert_eq!(disposition, format!("attachment; filename=\"{expected}\""), "{operation}");
        }
    }
}
