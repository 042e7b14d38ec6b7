//! The tool table of a machine: tools put, read, listed, replaced and deleted, what programs call them by, and what a
//! job takes of them.

use reqwest::{Method, Response, StatusCode};
use serde_json::{Value, json};
use trunnion::wire::WearEntry;

use crate::database;
use crate::support::{App, ac_table, pointers, problem, spawn, spawn_with};

const TABLE: &str = "/v1/machines/example-ac-table/tools";
const BALL: &str = "/v1/machines/example-ac-table/tools/T12";

fn ball(number: u64) -> Value {
    json!({"number": number, "kind": "ball", "radius_mm": 5})
}

async fn put(app: &App, path: &str, tool: &Value) -> Response {
    app.client.put(app.url(path)).json(tool).send().await.unwrap()
}

async fn put_if(app: &App, path: &str, tool: &Value, tag: &str) -> Response {
    app.client.put(app.url(path)).header("if-match", tag).json(tool).send().await.unwrap()
}

async fn made(app: &App, path: &str, tool: &Value) -> Value {
    let answer = put(app, path, tool).await;
    assert_eq!(answer.status(), StatusCode::CREATED, "{path} {tool}");
    answer.json().await.unwrap()
}

async fn delete(app: &App, path: &str, tag: Option<&str>) -> Response {
    let request = app.client.delete(app.url(path));
    match tag {
        Some(tag) => request.header("if-match", tag).send().await.unwrap(),
        None => request.send().await.unwrap(),
    }
}

async fn read(app: &App, path: &str) -> Value {
    let answer = app.get(path).await;
    assert_eq!(answer.status(), StatusCode::OK, "{path}");
    answer.json().await.unwrap()
}

fn etag(answer: &Response) -> String {
    answer.headers()["etag"].to_str().unwrap().to_owned()
}

fn ids(list: &Value) -> Vec<&str> {
    list["items"].as_array().unwrap().iter().map(|tool| tool["tool_id"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn a_tool_is_made_replaced_and_deleted() {
    let app = spawn().await;
    let tool = json!({"number": 12, "name": "BALL_10", "kind": "ball", "radius_mm": 5, "length_mm": 92.4});
    let answer = put(&app, BALL, &tool).await;
    assert_eq!(
        (answer.status(), &answer.headers()["location"]),
        (StatusCode::CREATED, &BALL.parse().unwrap())
    );
    let first = etag(&answer);
    let document: Value = answer.json().await.unwrap();
    let created_at = document["created_at"].as_str().unwrap();
    let expected = json!({
        "machine_id": "example-ac-table", "tool_id": "T12", "revision": 1, "created_at": created_at, "number": 12,
        "name": "BALL_10", "kind": "ball", "radius_mm": 5.0, "corner_radius_mm": 5.0, "length_mm": 92.4
    });
    assert_eq!(document, expected);
    assert_eq!(read(&app, BALL).await, document);

    // What was read can be put back, and so can what was posted: the same revision.
    let mut same = document.clone();
    for name in ["machine_id", "tool_id", "revision", "created_at"] {
        same.as_object_mut().unwrap().remove(name);
    }
    for same in [same, tool] {
        let again = put_if(&app, BALL, &same, &first).await;
        assert_eq!((again.status(), etag(&again)), (StatusCode::OK, first.clone()));
        assert_eq!(again.json::<Value>().await.unwrap(), document);
    }
    let reground = json!({"number": 12, "kind": "bull-nose", "radius_mm": 5, "corner_radius_mm": 0.5});
    let second = put_if(&app, BALL, &reground, &first).await;
    assert_eq!(second.status(), StatusCode::OK);
    let second_tag = etag(&second);
    let second: Value = second.json().await.unwrap();
    assert_eq!((&second["revision"], second.get("name"), second.get("length_mm")), (&json!(2), None, None));

    let revisions = read(&app, &format!("{BALL}/revisions")).await;
    assert_eq!(revisions["items"], json!([second, document]));
    assert_eq!(read(&app, &format!("{BALL}/revisions/1")).await, document);
    let entry = json!({"measured_at": "2025-03-14T09:26:53Z", "parts_cut": 120, "radius_wear_um": 14.0});
    assert_eq!(app.post_json(&format!("{BALL}/wear-entries"), &entry).await.status(), StatusCode::CREATED);

    problem(delete(&app, BALL, None).await, "precondition-required").await;
    problem(delete(&app, BALL, Some(&first)).await, "precondition-failed").await;
    assert_eq!(delete(&app, BALL, Some(&second_tag)).await.status(), StatusCode::NO_CONTENT);
    problem(app.get(BALL).await, "tool-not-found").await;
    problem(delete(&app, BALL, Some("*")).await, "tool-not-found").await;
    problem(put_if(&app, BALL, &reground, "*").await, "precondition-failed").await;
    assert_eq!(read(&app, TABLE).await["items"], json!([]));
    // What was computed with it stays readable, and what was measured of it too.
    assert_eq!(read(&app, &format!("{BALL}/revisions/2")).await, second);
    assert_eq!(read(&app, &format!("{BALL}/revisions")).await["items"].as_array().unwrap().len(), 2);
    assert_eq!(read(&app, &format!("{BALL}/wear-entries")).await["items"][0]["radius_wear_um"], 14.0);
    assert_eq!(made(&app, BALL, &reground).await["revision"], 3);
    assert_eq!(read(&app, &format!("{BALL}/wear-entries")).await["items"][0]["radius_wear_um"], 14.0);
}

#[tokio::test]
async fn conditions_are_kept() {
    let app = spawn().await;
    let send = |tool: Value, name: &'static str, value: String| {
        let request = app.client.put(app.url(BALL)).header(name, value).json(&tool);
        async move { request.send().await.unwrap() }
    };
    problem(send(ball(12), "if-match", "*".to_owned()).await, "precondition-failed").await;
    problem(app.get(BALL).await, "tool-not-found").await;
    assert_eq!(send(ball(12), "if-none-match", "*".to_owned()).await.status(), 201);
    problem(send(ball(12), "if-none-match", "*".to_owned()).await, "precondition-failed").await;
    problem(put(&app, BALL, &ball(12)).await, "precondition-required").await;
    problem(send(ball(12), "if-match", "unquoted".to_owned()).await, "malformed-request").await;
    let tag = etag(&app.get(BALL).await);
    problem(send(ball(13), "if-match", format!("W/{tag}")).await, "precondition-failed").await;
    // The tag of a machine is none of a tool.
    let machines = etag(&app.get("/v1/machines/example-ac-table").await);
    problem(send(ball(13), "if-match", machines).await, "precondition-failed").await;
    for (value, status) in [(tag.clone(), 304), (format!("\"x\", W/{tag}"), 304), ("\"x\"".to_owned(), 200)] {
        for path in [BALL.to_owned(), format!("{BALL}/revisions/1")] {
            let known = app.client.get(app.url(&path)).header("if-none-match", &value).send().await.unwrap();
            assert_eq!((known.status().as_u16(), etag(&known)), (status, tag.clone()));
        }
    }
    assert_eq!(send(ball(13), "if-match", tag.clone()).await.status(), 200);
    problem(send(ball(14), "if-match", tag).await, "precondition-failed").await;
    assert_eq!(read(&app, BALL).await["number"], 13);
}

#[tokio::test]
async fn every_fault_of_a_tool_is_named() {
    let app = spawn().await;
    let wrong = json!({"name": "a\"b", "kind": "ball", "radius_mm": 0, "length_mm": -1e6});
    let long = format!("{TABLE}/{}", "T".repeat(101));
    let body = problem(put(&app, &long, &wrong).await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/tool_id", "/name", "/length_mm", "/radius_mm"]);
    for (wrong, pointer) in [
        (json!({"kind": "ball", "radius_mm": 5}), "/number"),
        (json!({"number": -1, "kind": "ball", "radius_mm": 5}), "/number"),
        (json!({"number": 4_294_967_296_u64, "kind": "ball", "radius_mm": 5}), "/number"),
        (json!({"number": 1.5, "kind": "ball", "radius_mm": 5}), "/number"),
        (json!({"number": 1, "kind": "ball", "radius_mm": 5, "corner_radius_mm": 4}), "/corner_radius_mm"),
        (json!({"number": 1, "kind": "bull-nose", "radius_mm": 5}), "/corner_radius_mm"),
        (json!({"number": 1, "kind": "flat"}), "/radius_mm"),
        (json!({"number": 1, "kind": "drill", "radius_mm": 5}), "/kind"),
        (json!({"number": 1, "radius_mm": 5}), "/kind"),
        (json!({"number": 1, "kind": "ball", "radius_mm": 5, "flutes": 2}), "/flutes"),
        (json!({"number": 1, "kind": "ball", "radius_mm": "5"}), "/radius_mm"),
    ] {
        let body = problem(put(&app, BALL, &wrong).await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer], "{wrong}");
    }
    assert_eq!(read(&app, TABLE).await["items"], json!([]));
    for (index, good) in [
        json!({"number": 0, "kind": "other"}),
        json!({"number": 4_294_967_295_u32, "kind": "other", "radius_mm": 4.25}),
        json!({"name": "a".repeat(64), "kind": "flat", "radius_mm": 1000, "length_mm": -100_000}),
        json!({"name": "Kugel Ø 10", "kind": "ball", "radius_mm": 0.001, "length_mm": 100_000}),
    ]
    .iter()
    .enumerate()
    {
        made(&app, &format!("{TABLE}/{index}"), good).await;
    }
}

#[tokio::test]
async fn no_two_tools_of_a_machine_are_called_alike() {
    let app = spawn().await;
    let named = |number: u64, name: &str| json!({"number": number, "name": name, "kind": "other"});
    let [one, two, three] =
        ["one", "two", "3/8\""].map(|id| format!("{TABLE}/{}", id.replace('/', "%2F").replace('"', "%22")));
    made(&app, &one, &named(1, "BALL_10")).await;
    made(&app, &three, &named(3, "FLAT_3")).await;
    let refused = async |tool: Value, expected: &[(&str, &str)]| {
        let body = problem(put(&app, &two, &tool).await, "tool-name-taken").await;
        let found: Vec<_> = body["errors"].as_array().unwrap().iter().collect();
        assert_eq!(found.len(), expected.len(), "{body}");
        for (found, (pointer, other)) in found.iter().zip(expected) {
            assert_eq!(found["pointer"], *pointer, "{body}");
            assert!(found["detail"].as_str().unwrap().contains(&format!("{other:?}")), "{body}");
        }
    };
    refused(named(1, "NEW"), &[("/number", "one")]).await;
    refused(json!({"name": "Ball_10", "kind": "other"}), &[("/name", "one")]).await;
    refused(named(1, "flat_3"), &[("/number", "one"), ("/name", "3/8\"")]).await;
    problem(app.get(&two).await, "tool-not-found").await;
    made(&app, &two, &named(2, "ball_11")).await;
    // Neither by a new revision, which may keep its own name in other capitals.
    let tag = etag(&app.get(&two).await);
    problem(put_if(&app, &two, &named(3, "ball_11"), &tag).await, "tool-name-taken").await;
    assert_eq!(put_if(&app, &two, &named(2, "Ball_11"), &tag).await.status(), StatusCode::OK);
    // The condition is looked at first: who does not know the tool does not learn what else there is.
    problem(put_if(&app, &two, &named(3, "ball_11"), &tag).await, "precondition-failed").await;
    // What a tool gave up, and what was deleted, is free.
    assert_eq!(
        put_if(&app, &one, &json!({"number": 1, "kind": "other"}), "*").await.status(),
        StatusCode::OK
    );
    assert_eq!(delete(&app, &three, Some("*")).await.status(), StatusCode::NO_CONTENT);
    assert_eq!(put_if(&app, &two, &named(3, "ball_10"), "*").await.status(), StatusCode::OK);
    problem(put(&app, &three, &named(3, "FLAT_3")).await, "tool-name-taken").await;
    // Another machine has a table of its own.
    assert_eq!(app.put_machine("other", &ac_table()).await.status(), StatusCode::CREATED);
    made(&app, "/v1/machines/other/tools/one", &named(3, "BALL_10")).await;
}

#[tokio::test]
async fn of_tools_put_at_once_under_one_name_exactly_one_is_stored() {
    let app = spawn().await;
    let puts = (0..16).map(|index| {
        let app = &app;
        let tool =
            json!({"number": index, "name": if index % 2 == 0 { "BALL" } else { "ball" }, "kind": "other"});
        async move { put(app, &format!("{TABLE}/T{index}"), &tool).await.status().as_u16() }
    });
    let mut statuses = futures::future::join_all(puts).await;
    statuses.sort_unstable();
    assert_eq!(statuses[0], 201);
    assert!(statuses[1..].iter().all(|status| *status == 409), "{statuses:?}");
    assert_eq!(read(&app, TABLE).await["items"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn a_table_takes_as_many_tools_as_it_may_and_not_one_more() {
    let app = spawn_with(|settings| settings.max_tools_per_machine = 3).await;
    for number in 0..3 {
        made(&app, &format!("{TABLE}/T{number}"), &ball(number)).await;
    }
    let body = problem(put(&app, &format!("{TABLE}/T3"), &ball(3)).await, "tool-table-full").await;
    assert!(body["detail"].as_str().unwrap().contains("has 3 tools"), "{body}");
    // One that is there may still be replaced, and one that goes makes room.
    assert_eq!(put_if(&app, &format!("{TABLE}/T2"), &ball(4), "*").await.status(), StatusCode::OK);
    assert_eq!(delete(&app, &format!("{TABLE}/T0"), Some("*")).await.status(), StatusCode::NO_CONTENT);
    made(&app, &format!("{TABLE}/T3"), &ball(3)).await;
    problem(put(&app, &format!("{TABLE}/T0"), &ball(0)).await, "tool-table-full").await;
    // Another machine has room of its own.
    app.put_machine("other", &ac_table()).await;
    made(&app, "/v1/machines/other/tools/T0", &ball(0)).await;
}

#[tokio::test]
async fn of_many_tools_put_at_once_as_many_are_stored_as_have_room() {
    let app = spawn_with(|settings| settings.max_tools_per_machine = 5).await;
    let puts = (0..200).map(|number| {
        let app = &app;
        async move { put(app, &format!("{TABLE}/T{number}"), &ball(number)).await.status().as_u16() }
    });
    let statuses = futures::future::join_all(puts).await;
    let count = |wanted: u16| statuses.iter().filter(|status| **status == wanted).count();
    assert_eq!((count(201), count(409)), (5, 195), "{statuses:?}");
    assert_eq!(read(&app, TABLE).await["items"].as_array().unwrap().len(), 5);
}

#[tokio::test]
async fn the_tools_of_a_machine_go_with_it() {
    let app = spawn().await;
    app.put_machine("mill", &ac_table()).await;
    for (id, number) in [("b", 2), ("a", 1)] {
        made(&app, &format!("/v1/machines/mill/tools/{id}"), &ball(number)).await;
    }
    let tool = "/v1/machines/mill/tools/a";
    let entry = json!({"measured_at": "2025-03-14T09:26:53Z", "parts_cut": 120, "radius_wear_um": 14.0});
    assert_eq!(app.post_json(&format!("{tool}/wear-entries"), &entry).await.status(), StatusCode::CREATED);
    assert_eq!(delete(&app, "/v1/machines/mill", Some("*")).await.status(), StatusCode::NO_CONTENT);
    for path in [tool, "/v1/machines/mill/tools"] {
        problem(app.get(path).await, "machine-not-found").await;
    }
    problem(put(&app, tool, &ball(1)).await, "machine-not-found").await;
    problem(delete(&app, tool, Some("*")).await, "machine-not-found").await;
    assert_eq!(read(&app, &format!("{tool}/revisions")).await["items"][0]["number"], 1);
    assert_eq!(read(&app, &format!("{tool}/wear-entries")).await["items"].as_array().unwrap().len(), 1);
    // Every one of them is in the log, before the machine.
    let log = read(&app, "/v1/audit?machine_id=mill&limit=3").await;
    let said: Vec<_> = log["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| {
            (
                entry["action"].as_str().unwrap(),
                entry["resource"].as_str().unwrap(),
                &entry["revision_before"],
            )
        })
        .collect();
    let first = &json!(1);
    let expected = [
        ("machine-deleted", "/v1/machines/mill", first),
        ("tool-deleted", "/v1/machines/mill/tools/b", first),
        ("tool-deleted", "/v1/machines/mill/tools/a", first),
    ];
    assert_eq!(said, expected);
    // A machine put again under the same id begins with an empty table, whose tools go on counting.
    app.put_machine("mill", &ac_table()).await;
    assert_eq!(read(&app, "/v1/machines/mill/tools").await["items"], json!([]));
    problem(app.get(tool).await, "tool-not-found").await;
    assert_eq!(made(&app, tool, &ball(2)).await["revision"], 2);
}

#[tokio::test]
async fn tools_are_listed_newest_first_and_pages_join() {
    let app = spawn().await;
    for number in 0..5 {
        made(&app, &format!("{TABLE}/T{number}"), &ball(number)).await;
    }
    // A new revision does not make a tool newer.
    assert_eq!(put_if(&app, &format!("{TABLE}/T1"), &ball(11), "*").await.status(), StatusCode::OK);
    let mut seen = Vec::new();
    let mut path = format!("{TABLE}?limit=2");
    loop {
        let page = read(&app, &path).await;
        assert!(page["items"].as_array().unwrap().len() <= 2);
        seen.extend(ids(&page).into_iter().map(str::to_owned));
        let Some(cursor) = page["next_cursor"].as_str() else { break };
        path = format!("{TABLE}?limit=2&cursor={cursor}");
    }
    assert_eq!(seen, ["T4", "T3", "T2", "T1", "T0"]);
    let page = read(&app, &format!("{TABLE}/T1/revisions?limit=1")).await;
    assert_eq!(page["items"][0]["number"], 11);
    let next = format!("{TABLE}/T1/revisions?limit=1&cursor={}", page["next_cursor"].as_str().unwrap());
    assert_eq!(read(&app, &next).await["items"][0]["number"], 1);
    for (query, pointer) in [("limit=0", "/limit"), ("cursor=x", "/cursor"), ("number=1", "/number")] {
        let body = problem(app.get(&format!("{TABLE}?{query}")).await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer]);
    }
}

#[tokio::test]
async fn what_is_not_there_is_not_found() {
    let app = spawn().await;
    made(&app, BALL, &ball(12)).await;
    for revision in ["0", "2", "-1", "x", "99999999999999999999"] {
        problem(app.get(&format!("{BALL}/revisions/{revision}")).await, "revision-not-found").await;
    }
    for path in ["T13", "T13/revisions"] {
        problem(app.get(&format!("{TABLE}/{path}")).await, "tool-not-found").await;
    }
    for path in [
        "/v1/machines/nobody/tools",
        "/v1/machines/nobody/tools/T12",
        "/v1/machines/nobody/tools/T12/revisions",
    ] {
        problem(app.get(path).await, "machine-not-found").await;
    }
    // A machine that is not there is told before the tool's condition or name.
    let nowhere = "/v1/machines/nobody/tools/T12";
    problem(put_if(&app, nowhere, &ball(12), "*").await, "machine-not-found").await;
    for (method, path) in
        [(Method::GET, BALL), (Method::GET, TABLE), (Method::PUT, "/v1/machines/example-ac-table/tools/T2")]
    {
        let request = app.client.request(method, app.url(path)).header("accept", "text/html").json(&ball(2));
        problem(request.send().await.unwrap(), "not-acceptable").await;
    }
    problem(app.get(&format!("{TABLE}/T2")).await, "tool-not-found").await;
}

#[tokio::test]
async fn a_tool_may_be_called_anything_that_wear_entries_may_name() {
    let app = spawn().await;
    for (number, (id, address)) in [
        ("Ø 8/2 50%?", "%C3%98%208%2F2%2050%25%3F"),
        ("T12#a&b=c", "T12%23a%26b%3Dc"),
        ("wear-entries", "wear-entries"),
    ]
    .into_iter()
    .enumerate()
    {
        let path = format!("{TABLE}/{address}");
        let answer = put(&app, &path, &ball(number as u64)).await;
        assert_eq!(answer.status(), StatusCode::CREATED, "{id}");
        let place = answer.headers()["location"].to_str().unwrap().to_owned();
        assert_eq!(answer.json::<Value>().await.unwrap()["tool_id"], id);
        assert_eq!(read(&app, &place).await["tool_id"], id);
    }
}

#[tokio::test]
async fn what_a_job_takes_of_the_table_is_in_the_store() {
    let app = spawn().await;
    for (id, number) in [("b", 2), ("a", 1), ("B", 3), ("gone", 4)] {
        made(&app, &format!("{TABLE}/{id}"), &ball(number)).await;
    }
    put_if(&app, &format!("{TABLE}/a"), &json!({"name": "FLAT", "kind": "flat", "radius_mm": 4}), "*").await;
    delete(&app, &format!("{TABLE}/gone"), Some("*")).await;
    let entry = |day: u32, edge: &str, cutter: &str, wear_um: f64| {
        json!({"measured_at": format!("2025-03-{day:02}T09:00:00Z"), "parts_cut": day, "edge": edge, "cutter_id": cutter,
            "radius_wear_um": wear_um})
    };
    // The last measured is neither the last stored nor, for want of the other edge, the largest.
    let entries = json!([
        entry(20, "2", "1", 31.0),
        entry(19, "1", "1", 35.0),
        entry(10, "1", "1", 12.0),
        entry(9, "2", "1", 11.0),
        entry(21, "1", "2", 3.0),
        entry(28, "1", "1", 99.0)
    ]);
    let wear = format!("{TABLE}/a/wear-entries");
    let posted: Value = app.post_json(&wear, &entries).await.json().await.unwrap();
    let wrong = posted[5]["id"].as_str().unwrap();
    let withdrawn = app.post_json(&format!("{wear}/{wrong}/withdraw"), &json!({"reason": "wrong"})).await;
    assert_eq!(withdrawn.status(), StatusCode::OK);

    let store = app.store();
    let table = store.tools("example-ac-table").await.unwrap();
    let rows: Vec<_> =
        table.iter().map(|tool| (tool.tool_id.as_str(), tool.revision, tool.document.number)).collect();
    assert_eq!(rows, [("B", 1, Some(3)), ("a", 2, None), ("b", 1, Some(2))]);
    let flat = table[1].document.cutter().unwrap();
    assert_eq!((flat.radius().mm(), flat.corner_radius().mm()), (4.0, 0.0));
    assert!(store.tools("nobody").await.unwrap().is_empty());

    let newest = async |cutter: &str| {
        let found = store.newest_and_most_wear("example-ac-table", cutter).await.unwrap();
        let row = |entry: WearEntry| (entry.id, entry.edge.unwrap(), entry.measured_at, entry.radius_wear_um);
        found.into_iter().map(row).collect::<Vec<_>>()
    };
    let expected = |index: usize, edge: &str, day: u32, wear_um: f64| {
        let id = posted[index]["id"].as_str().unwrap().to_owned();
        (id, edge.to_owned(), format!("2025-03-{day}T09:00:00.000Z"), Some(wear_um))
    };
    assert_eq!(newest("1").await, [expected(1, "1", 19, 35.0), expected(0, "2", 20, 31.0)]);
    assert_eq!(newest("2").await, [expected(4, "1", 21, 3.0)]);
    assert_eq!(newest("3").await, []);
}

#[tokio::test]
async fn a_revision_of_a_tool_does_not_change_behind_its_back() {
    let app = spawn().await;
    made(&app, BALL, &json!({"number": 12, "name": "BALL_10", "kind": "ball", "radius_mm": 5})).await;
    made(
        &app,
        &format!("{TABLE}/T13"),
        &json!({"number": 13, "name": "BALL_11", "kind": "ball", "radius_mm": 5}),
    )
    .await;
    let data = app.data.clone();
    let directory = app.stop().await;
    for statement in [
        "DELETE FROM tool_revisions",
        "UPDATE tool_revisions SET document = '{}'",
        "UPDATE tools SET number = 13 WHERE tool_id = 'T12'",
        "UPDATE tools SET name_key = 'BALL_11' WHERE tool_id = 'T12'",
        "UPDATE tools SET number = NULL, name_key = NULL",
        "INSERT INTO tools (machine_id, tool_id, last_revision, number) VALUES ('nobody', 'T1', 1, 1)",
    ] {
        assert!(database::change(&data, statement).await.is_err(), "{statement}");
    }
    drop(directory);
}
