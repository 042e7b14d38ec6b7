//! The audit log: every change with who made it, by which request, from which revision to which; written with the
//! change and never changed itself.

use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::database;
use crate::support::{App, ac_table, pointers, problem, spawn, spawn_with};

/// Action, revision before, revision after of every entry, oldest first.
async fn log(app: &App, query: &str) -> Vec<(String, Value, Value)> {
    let page: Value = app.get(&format!("/v1/audit?limit=200{query}")).await.json().await.unwrap();
    let items = page["items"].as_array().unwrap().iter().rev();
    items
        .map(|entry| {
            let action = entry["action"].as_str().unwrap().to_owned();
            (action, entry["revision_before"].clone(), entry["revision_after"].clone())
        })
        .collect()
}

fn row(action: &str, before: Option<i64>, after: Option<i64>) -> (String, Value, Value) {
    (action.to_owned(), json!(before), json!(after))
}

async fn tag(app: &App, id: &str) -> String {
    app.get(&format!("/v1/machines/{id}")).await.headers()["etag"].to_str().unwrap().to_owned()
}

#[tokio::test]
async fn the_life_of_a_machine_is_in_the_log_and_what_changed_nothing_is_not() {
    let app = spawn().await;
    let mut profile = ac_table();
    assert_eq!(app.put_machine("mine", &profile).await.status(), 201);
    let url = app.url("/v1/machines/mine");
    let put = async |profile: &Value| {
        let put = app.client.put(&url).header("if-match", tag(&app, "mine").await).json(profile);
        put.send().await.unwrap()
    };
    // The same profile is the same revision.
    assert_eq!(put(&profile).await.status(), 200);
    profile["name"] = json!("another");
    assert_eq!(put(&profile).await.status(), 200);
    // Refused: without a condition, with a stale one, with a profile that is none.
    problem(app.put_machine("mine", &ac_table()).await, "precondition-required").await;
    let stale = app.client.delete(&url).header("if-match", "\"r1-0000000000000000\"").send().await.unwrap();
    problem(stale, "precondition-failed").await;
    problem(put(&json!({"name": "x"})).await, "invalid-request").await;
    let gone = app.client.delete(&url).header("if-match", tag(&app, "mine").await).send().await.unwrap();
    assert_eq!(gone.status(), 204);
    assert_eq!(app.put_machine("mine", &profile).await.status(), 201);
    let expected = [
        row("machine-created", None, Some(1)),
        row("machine-replaced", Some(1), Some(2)),
        row("machine-deleted", Some(2), None),
        row("machine-created", None, Some(3)),
    ];
    assert_eq!(log(&app, "&machine_id=mine").await, expected);
    // The example came with the service.
    let page: Value = app.get("/v1/audit?machine_id=example-ac-table").await.json().await.unwrap();
    assert_eq!(page["items"][0]["origin"], "service");
    assert!(page["items"][0]["request_id"].is_null());
}

#[tokio::test]
async fn the_log_is_read_by_time_and_as_a_table() {
    let app = spawn().await;
    for id in ["a", "b", "c", "d"] {
        assert_eq!(app.put_machine(id, &ac_table()).await.status(), 201);
    }
    let page: Value = app.get("/v1/audit?limit=4").await.json().await.unwrap();
    let at = |back: usize| page["items"][back]["at"].as_str().unwrap();
    let machines = async |query: String| {
        let page: Value =
            app.get(&format!("/v1/audit?action=machine-created&{query}")).await.json().await.unwrap();
        let items = page["items"].as_array().unwrap().iter();
        items.map(|entry| entry["machine_id"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(machines(format!("from={}", at(1))).await, ["d", "c"]);
    assert_eq!(machines(format!("from={}&to={}", at(2), at(1))).await, ["c", "b"]);
    assert_eq!(machines(format!("to={}", at(2))).await, ["b", "a", "example-ac-table"]);
    // The same moment in another zone, and pages inside of a time.
    let zoned = at(1).replace('Z', "%2B00:00");
    assert_eq!(machines(format!("from={zoned}&limit=1")).await, ["d"]);
    assert!(machines("from=2100-01-01T00:00:00Z".to_owned()).await.is_empty());
    for (query, pointer) in [("from=yesterday", "/from"), ("to=2026-01-01", "/to")] {
        let refused = problem(app.get(&format!("/v1/audit?{query}")).await, "invalid-request").await;
        assert_eq!(pointers(&refused), [pointer]);
    }
    let day =
        |query: &str| query.replace('A', "2026-03-15T00:00:00Z").replace('B', "2026-03-14T23:59:59.999Z");
    for (query, pointer) in [
        ("/v1/audit?from=A&to=B", "/to"),
        ("/v1/jobs?created_after=A&created_before=B", "/created_before"),
        ("/v1/machines/a/calibrations?measured_from=A&measured_to=B", "/measured_to"),
    ] {
        let refused = problem(app.get(&day(query)).await, "invalid-request").await;
        assert_eq!(pointers(&refused), [pointer]);
        assert_eq!(
            refused["errors"][0]["detail"],
            "2026-03-14T23:59:59.999Z is before 2026-03-15T00:00:00.000Z, where the period begins"
        );
        assert_eq!(app.get(&day(&query.replace('B', "A"))).await.status(), 200, "{query}");
    }

    let table =
        app.client.get(app.url("/v1/audit?limit=2")).header("accept", "text/csv").send().await.unwrap();
    assert_eq!(table.headers()["content-type"], "text/csv");
    let cursor = table.headers()["trunnion-next-cursor"].to_str().unwrap().to_owned();
    assert_eq!(cursor, app.get("/v1/audit?limit=2").await.json::<Value>().await.unwrap()["next_cursor"]);
    let table = table.text().await.unwrap();
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let head = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2);
    let entry = page["items"][0].as_object().unwrap();
    assert_eq!(head.len(), entry.len());
    for (name, cell) in head.iter().zip(&rows[0]) {
        let expected = match &entry[name] {
            Value::Null => String::new(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        assert_eq!(cell, expected, "{name}");
    }
}

#[tokio::test]
async fn the_life_of_a_tool_is_in_the_log_and_what_changed_nothing_is_not() {
    let app = spawn().await;
    let address = "/v1/machines/example-ac-table/tools/T%2012";
    let put = async |tool: &Value, condition: Option<&str>| {
        let request = app.client.put(app.url(address)).json(tool);
        let request = if let Some(tag) = condition { request.header("if-match", tag) } else { request };
        request.send().await.unwrap()
    };
    let ball = |number: u32| json!({"number": number, "kind": "ball", "radius_mm": 5});
    assert_eq!(put(&ball(12), None).await.status(), 201);
    // The same tool is the same revision.
    assert_eq!(put(&ball(12), Some("*")).await.status(), 200);
    assert_eq!(put(&ball(13), Some("*")).await.status(), 200);
    // Refused: without a condition, with a stale one, with a tool that is none, on a machine that is not there.
    problem(put(&ball(14), None).await, "precondition-required").await;
    problem(put(&ball(14), Some("\"r1-0000000000000000\"")).await, "precondition-failed").await;
    problem(put(&json!({"kind": "ball", "radius_mm": 5}), Some("*")).await, "invalid-request").await;
    let nowhere =
        app.client.put(app.url("/v1/machines/nobody/tools/T1")).json(&ball(1)).send().await.unwrap();
    problem(nowhere, "machine-not-found").await;
    let taken = app.client.put(app.url("/v1/machines/example-ac-table/tools/T13")).json(&ball(13));
    problem(taken.send().await.unwrap(), "tool-name-taken").await;
    let gone = app.client.delete(app.url(address)).header("if-match", "*").send().await.unwrap();
    assert_eq!(gone.status(), 204);
    assert_eq!(put(&ball(12), None).await.status(), 201);
    let expected = [
        row("machine-created", None, Some(1)),
        row("tool-created", None, Some(1)),
        row("tool-replaced", Some(1), Some(2)),
        row("tool-deleted", Some(2), None),
        row("tool-created", None, Some(3)),
    ];
    assert_eq!(log(&app, "&machine_id=example-ac-table").await, expected);
    let page: Value = app.get("/v1/audit?action=tool-created").await.json().await.unwrap();
    assert_eq!(page["items"].as_array().unwrap().len(), 2);
    assert_eq!(page["items"][0]["resource"], address);
    assert_eq!(page["items"][0]["route"], "/v1/machines/{machine_id}/tools/{tool_id}");
    assert_eq!(app.get(page["items"][0]["resource"].as_str().unwrap()).await.status(), 200);
}

#[tokio::test]
async fn measurements_are_in_the_log() {
    let app = spawn().await;
    let run = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/examples/ballbar.json"));
    let run: Value = serde_json::from_str(&run.unwrap()).unwrap();
    let machine = "/v1/machines/example-ac-table";
    let stored = app.post_json(&format!("{machine}/calibrations"), &run).await;
    let place = stored.headers()["location"].to_str().unwrap().to_owned();
    for _twice in 0..2 {
        let apply = app.client.post(app.url(&format!("{place}/apply"))).header("if-match", "*");
        let applied = apply.json(&json!({"confirm": true})).send().await.unwrap();
        assert_eq!(applied.status(), 200);
    }
    let wear = json!([
        {"measured_at": "2026-01-10T08:00:00Z", "parts_cut": 20, "radius_wear_um": 24.5},
        {"measured_at": "2026-01-11T08:00:00Z", "parts_cut": 40, "radius_wear_um": 27.6}
    ]);
    let entries = app.post_json(&format!("{machine}/tools/T%2012/wear-entries"), &wear).await;
    assert_eq!(entries.status(), 201);
    let entries: Value = entries.json().await.unwrap();
    let entry = format!("{machine}/tools/T%2012/wear-entries/{}", entries[0]["id"].as_str().unwrap());
    let expected = [
        row("machine-created", None, Some(1)),
        row("calibration-created", None, None),
        row("calibration-applied", Some(1), Some(2)),
        row("wear-entries-created", None, None),
        row("wear-entry-withdrawn", None, None),
    ];
    for time in ["first", "second"] {
        let withdrawn = app.post_json(&format!("{entry}/withdraw"), &json!({"reason": "wrong"})).await;
        assert_eq!(withdrawn.status(), 200);
        assert_eq!(log(&app, "&machine_id=example-ac-table").await, expected, "withdrawn the {time} time");
    }
    let page: Value = app.get("/v1/audit").await.json().await.unwrap();
    assert_eq!(page["items"][0]["resource"], entry);
    assert_eq!(page["items"][1]["resource"], entry);
    assert_eq!(page["items"][2]["resource"], place);
    // What the resource names can be asked for.
    assert_eq!(app.get(page["items"][0]["resource"].as_str().unwrap()).await.status(), 200);
}

#[tokio::test]
async fn jobs_are_in_the_log_once_however_often_they_are_asked_for() {
    let app = spawn_with(|settings| settings.max_computations = 1).await;
    let machine = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    let mut places = Vec::new();
    for _twice in 0..2 {
        let request = app.client.post(app.url(machine)).header("idempotency-key", "one").body("g1 x1\n");
        let answer = request.header("content-type", "text/plain").send().await.unwrap();
        places.push(answer.headers()["location"].to_str().unwrap().to_owned());
    }
    problem(app.post_text(machine, "text/plain", "REFUSE\n").await, "program-fault").await;
    let mut post = async |program: &str| {
        let job = json!({"machine_id": "example-ac-table", "operation": "cc-compensation",
            "parameters": {"tool_radius_mm": 5, "contact": "tip"}});
        let form = Form::new().text("job", job.to_string());
        let form = form.part("program", Part::text(program.to_owned()).file_name("a.nc"));
        let posted = app.client.post(app.url("/v1/jobs")).multipart(form).send().await.unwrap();
        assert_eq!(posted.status(), 202);
        places.push(posted.headers()["location"].to_str().unwrap().to_owned());
        app.url(places.last().unwrap())
    };
    // One that works until it is stopped, and one that waits behind it.
    let [works, waits] = [post("WAIT\n").await, post("g1\n").await];
    let statuses =
        [app.client.delete(&waits).send().await.unwrap(), app.client.delete(&waits).send().await.unwrap()];
    assert_eq!(statuses.map(|answer| answer.status().as_u16()), [200, 200]);
    for _twice in 0..2 {
        assert!(app.client.delete(&works).send().await.unwrap().status().is_success());
    }
    let page: Value = app.get("/v1/audit?machine_id=example-ac-table").await.json().await.unwrap();
    let said: Vec<(&str, &str)> = page["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| (entry["action"].as_str().unwrap(), entry["resource"].as_str().unwrap()))
        .collect();
    let expected = [
        ("job-cancelled", places[2].as_str()),
        ("job-cancelled", &places[3]),
        ("job-created", &places[3]),
        ("job-created", &places[2]),
        ("job-created", &places[0]),
        ("machine-created", "/v1/machines/example-ac-table"),
    ];
    assert_eq!(said, expected);
    assert_eq!(places[0], places[1]);
}

#[tokio::test]
async fn an_entry_names_key_request_and_route() {
    let mut app = spawn().await;
    let first = app.close().await;
    let id = first.split('_').nth(1).unwrap();
    let put =
        app.client.put(app.url("/v1/machines/mine")).header("x-request-id", "shift-7").json(&ac_table());
    let put = put.send().await.unwrap();
    assert_eq!(put.status(), 201);
    let request_id = put.headers()["x-request-id"].to_str().unwrap().to_owned();
    let page: Value = app.get(&format!("/v1/audit?key_id={id}")).await.json().await.unwrap();
    assert_eq!(page["items"].as_array().unwrap().len(), 1);
    let entry = &page["items"][0];
    assert_eq!(entry["origin"], "http");
    assert_eq!(entry["key_id"], id);
    assert_eq!(entry["method"], "PUT");
    assert_eq!(entry["route"], "/v1/machines/{machine_id}");
    // Ours, not the one that the client gives it: that could be anybody's.
    assert_eq!(entry["request_id"], request_id);
    assert_eq!(entry["resource"], "/v1/machines/mine");
    assert_eq!(entry["at"].as_str().unwrap().len(), 24);
    // Keys are changes too; the first was made while the service was open.
    let other = app.new_key(&["read"], None).await;
    let other = other.split('_').nth(1).unwrap();
    for _twice in 0..2 {
        app.client.delete(app.url(&format!("/v1/keys/{other}"))).send().await.unwrap();
    }
    assert_eq!(log(&app, "&action=key-created").await.len(), 2);
    assert_eq!(log(&app, "&action=key-revoked").await.len(), 1);
    let made: Value = app.get("/v1/audit?action=key-created").await.json().await.unwrap();
    assert!(made["items"][1]["key_id"].is_null());
    assert_eq!(made["items"][0]["key_id"], id);
    assert_eq!(made["items"][0]["resource"], format!("/v1/keys/{other}"));
    assert!(!made.to_string().contains(first.rsplit('_').next().unwrap()));
}

#[tokio::test]
async fn pages_of_the_log_follow_each_other() {
    let app = spawn().await;
    for id in ["a", "b", "c"] {
        app.put_machine(id, &ac_table()).await;
    }
    let mut seen = Vec::new();
    let mut path = "/v1/audit?limit=2".to_owned();
    loop {
        let page: Value = app.get(&path).await.json().await.unwrap();
        seen.extend(page["items"].as_array().unwrap().iter().map(|entry| entry["machine_id"].clone()));
        match page["next_cursor"].as_str() {
            Some(next) => path = format!("/v1/audit?limit=2&cursor={next}"),
            None => break,
        }
    }
    // The first secret of webhooks is no machine's.
    assert_eq!(seen, json!(["c", "b", "a", null, "example-ac-table"]).as_array().unwrap().as_slice());
    problem(app.get("/v1/audit?action=anything").await, "invalid-request").await;
}

#[tokio::test]
async fn neither_the_log_nor_a_key_can_be_changed_behind_its_back() {
    let mut app = spawn().await;
    app.close().await;
    let key = app.new_key(&["read"], None).await;
    let place = format!("/v1/keys/{}", key.split('_').nth(1).unwrap());
    app.client.delete(app.url(&place)).send().await.unwrap();
    let data = app.data.clone();
    let directory = app.stop().await;
    assert_eq!(database::value(&data, "SELECT CAST(COUNT(*) AS TEXT) FROM audit").await, "5");
    for statement in [
        "DELETE FROM audit",
        "UPDATE audit SET key_id = 'somebody'",
        "DELETE FROM api_keys",
        "UPDATE api_keys SET revoked_at = NULL WHERE revoked_at IS NOT NULL",
        "UPDATE api_keys SET scopes = '[\"admin\"]'",
        "UPDATE api_keys SET expires_at = '2099-01-01T00:00:00.000Z'",
    ] {
        assert!(database::change(&data, statement).await.is_err(), "{statement}");
    }
    drop(directory);
}
