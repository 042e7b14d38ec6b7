//! Wear from the entries is taken where it can be true; where it cannot, or where nothing tells it, the refusal says
//! which entry and why.

use reqwest::StatusCode;
use serde_json::{Value, json};

use crate::program_tools::{ALL, ENTRIES, WEAR, ZERO, ball, cuts, measure, put, spawn, with_two_tools};
use crate::queue::{accepted, ended};
use crate::support::{App, pointers, problem};

/// The refusal of a wear compensation, its pointer checked.
async fn refused(app: &App, query: &str, program: &str, pointer: &str) -> String {
    let query = format!("{ZERO}&{ENTRIES}{query}");
    let body = problem(app.operate("m", WEAR, &query, program, "*/*").await, "invalid-request").await;
    assert_eq!(pointers(&body), [pointer], "{body}");
    assert_eq!(body["errors"][0]["detail"], body["detail"], "{body}");
    body["detail"].as_str().unwrap().to_owned()
}

async fn withdraw(app: &App, tool: &str, id: &str) {
    let place = format!("/v1/machines/m/tools/{tool}/wear-entries/{id}/withdraw");
    app.post_json(&place, &json!({"reason": "wrong"})).await.error_for_status().unwrap();
}

#[tokio::test]
async fn more_wear_than_a_fifth_of_the_radius_is_asked_about() {
    let app = with_two_tools().await;
    measure(&app, "B", 2, None, 10.0).await;
    for (wear_um, fits) in
        [(1000.0, true), (1000.5, false), (4999.0, false), (5000.0, false), (9999.0, false)]
    {
        let id = measure(&app, "A", 3, None, wear_um).await;
        if fits {
            app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[1])).await;
        } else {
            for program in [cuts(&[1]), cuts(&[1, 2]), cuts(&[2, 1])] {
                let detail = refused(&app, "", &program, "/wear").await;
                for part in
                    [id.as_str(), &wear_um.to_string(), "1000.0 µm", "5 mm", "T1", "actual_tool", "withdraw"]
                {
                    assert!(detail.contains(part), "{part}: {detail}");
                }
            }
            refused(&app, "&tool_number=1", &cuts(&[1, 2]), "/wear").await;
            let step = format!("{ZERO}&wear.contact=feed-plane&wear.from=entries&wear.cutter_id=1");
            let body =
                problem(app.operate("m", ALL, &step, &cuts(&[1]), "*/*").await, "invalid-request").await;
            assert_eq!(pointers(&body), ["/wear"], "{body}");
            // Where T1 does not cut, its entries say nothing.
            app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[2])).await;
            app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}&tool_number=2"), &cuts(&[1, 2])).await;
        }
        withdraw(&app, "A", &id).await;
    }
    // A job is refused as the request is, also after the entry was withdrawn.
    let id = measure(&app, "A", 3, None, 4999.0).await;
    let parameters = json!({"work_offset_mm": [0, 0, 0], "contact": "feed-plane", "wear": {"from": "entries", "cutter_id": "1"}});
    let order = json!({"machine_id": "m", "operation": WEAR, "parameters": parameters});
    let place = accepted(&app, &order, &cuts(&[1])).await;
    let job = ended(&app, &place).await;
    assert_eq!((&job["state"], &job["problem"]["errors"][0]["pointer"]), (&json!("failed"), &json!("/wear")));
    assert!(job["problem"]["detail"].as_str().unwrap().contains(&id), "{job}");
}

#[tokio::test]
async fn wear_that_grew_back_is_asked_about() {
    // Readings (edge, µm) in their order, the place of the one that is too small, and of the one that it falls below.
    type Case = (&'static [(Option<&'static str>, f64)], Option<(usize, usize)>);
    let cases: [Case; 9] = [
        (&[(None, 50.0), (None, 5.0)], Some((1, 0))),
        (&[(None, 50.0), (None, 45.0)], None),
        (&[(None, 15.0), (None, 5.0)], None),
        (&[(None, 20.0), (None, 50.0), (None, 30.0), (None, 6.0)], Some((3, 1))),
        (&[(Some("1"), 50.0), (Some("2"), 5.0)], None),
        (&[(Some("1"), 50.0), (Some("2"), 60.0), (Some("1"), 5.0)], Some((2, 0))),
        (&[(None, 50.0), (Some("2"), 5.0)], Some((1, 0))),
        (&[(Some("2"), 50.0), (None, 5.0)], Some((1, 0))),
        (&[(None, 50.0), (Some("1"), 55.0), (Some("2"), 48.0)], None),
    ];
    for (readings, expected) in cases {
        let app = spawn().await;
        put(&app, "m", "A", &ball(1, 5.0)).await;
        let mut ids = Vec::new();
        for (day, (edge, wear_um)) in (1..).zip(readings) {
            ids.push(measure(&app, "A", day, *edge, *wear_um).await);
        }
        let query = format!("{ZERO}&{ENTRIES}");
        let Some((newest, earlier)) = expected else {
            app.report("m", WEAR, &query, &cuts(&[1])).await;
            continue;
        };
        let detail = refused(&app, "", &cuts(&[1]), "/wear").await;
        for index in [newest, earlier] {
            let value = format!("{} µm", readings[index].1);
            assert!(detail.contains(&ids[index]) && detail.contains(&value), "{readings:?}: {detail}");
        }
        assert!(
            ["withdraw", "cutter_id", "actual_tool"].iter().all(|cure| detail.contains(cure)),
            "{detail}"
        );
        // Each cure is one.
        withdraw(&app, "A", &ids[earlier]).await;
        if readings.len() == 2 {
            app.report("m", WEAR, &query, &cuts(&[1])).await;
        }
        let stated = format!("{ZERO}&contact=feed-plane&nominal_tool.radius_mm=5&actual_tool.radius_mm=4.99");
        app.report("m", WEAR, &stated, &cuts(&[1])).await;
    }
}

#[tokio::test]
async fn entries_that_do_not_tell_the_radius_are_not_denied() {
    let app = with_two_tools().await;
    let detail = refused(&app, "", &cuts(&[1]), "/wear/cutter_id").await;
    assert!(detail.contains("no wear entry for T1"), "{detail}");
    let flank = json!({"measured_at": "2026-02-03T09:00:00Z", "parts_cut": 3, "flank_wear_um": 80.0});
    let answer = app.post_json("/v1/machines/m/tools/A/wear-entries", &flank).await;
    assert_eq!(answer.status(), StatusCode::CREATED);
    let id = answer.json::<Value>().await.unwrap()["id"].as_str().unwrap().to_owned();
    for (query, program) in [("", cuts(&[1])), ("", cuts(&[2, 1])), ("&tool_number=1", cuts(&[2, 1]))] {
        let detail = refused(&app, query, &program, "/wear").await;
        for part in [id.as_str(), "T1", "flank_wear_um", "no `radius_wear_um`", "actual_tool"] {
            assert!(detail.contains(part), "{part}: {detail}");
        }
    }
    // Another tool's are not in the way: the section of this one is left alone, as that of every tool without a known
    // wear.
    measure(&app, "B", 4, None, 10.0).await;
    let report = app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[2, 1])).await;
    let left: Vec<_> =
        report["resolved"]["tools"].as_array().unwrap().iter().map(|tool| &tool["is_left_alone"]).collect();
    assert_eq!(json!(left), json!([false, true]), "{report}");
}

#[tokio::test]
async fn an_entry_dated_ahead_of_the_clock_is_of_today() {
    let app = with_two_tools().await;
    // The clock of these tests began on 25 February 2026 at 06:13.
    measure(&app, "A", 25, None, 10.0).await;
    let report = app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[1])).await;
    assert_eq!(report["resolved"]["wear"][0]["age_days"], 0.0, "{report}");
}

#[tokio::test]
async fn wear_of_a_tool_that_the_program_does_not_use_changes_nothing() {
    let app = with_two_tools().await;
    measure(&app, "A", 25, None, 10.0).await;
    let run = || async {
        let program = app.program("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[1])).await;
        let report = app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[1])).await;
        (program, report["resolved"]["wear"].as_array().unwrap().len())
    };
    let alone = run().await;
    measure(&app, "B", 25, None, 20.0).await;
    assert_eq!((run().await, alone.1), (alone.clone(), 1));
    let both = app.report("m", WEAR, &format!("{ZERO}&{ENTRIES}"), &cuts(&[1, 2])).await;
    assert_eq!(both["resolved"]["wear"].as_array().unwrap().len(), 2, "{both}");
}
