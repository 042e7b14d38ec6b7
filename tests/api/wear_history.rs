//! Wear histories: posted, read, withdrawn, followed to a limit.

use reqwest::{Response, StatusCode};
use serde_json::{Value, json};

use crate::database;
use crate::support::{App, ac_table, pointers, problem, spawn};

const TOOL: &str = "/v1/machines/example-ac-table/tools/T12";

fn entries() -> String {
    format!("{TOOL}/wear-entries")
}

fn trend(query: &str) -> String {
    format!("{TOOL}/wear-trend{query}")
}

/// The radius worn by 20 µm and 0.2 µm a part, with up to 0.6 µm of scatter; an entry every ten parts.
fn radius(parts_cut: i64) -> Value {
    let scatter = [0.0, 0.6, -0.4, 0.2, -0.5][usize::try_from(parts_cut / 10 % 5).unwrap()];
    let (day, minute) = (1 + parts_cut / 10 % 28, parts_cut / 10 / 28 % 60);
    json!({
        "measured_at": format!("2025-03-{day:02}T10:{minute:02}:00+01:00"), "parts_cut": parts_cut,
        "radius_wear_um": 20.0 + 0.2 * parts_cut as f64 + scatter
    })
}

async fn post(app: &App, body: &Value) -> Value {
    let response = app.post_json(&entries(), body).await;
    let status = response.status();
    let answer: Value = response.json().await.unwrap();
    assert_eq!(status, StatusCode::CREATED, "{answer}");
    answer
}

async fn read(app: &App, path: &str) -> Value {
    let response = app.get(path).await;
    assert_eq!(response.status(), StatusCode::OK, "{path}");
    response.json().await.unwrap()
}

async fn withdraw(app: &App, id: &str, body: &Value) -> Response {
    app.post_json(&format!("{}/{id}/withdraw", entries()), body).await
}

async fn as_kind(app: &App, path: &str, kind: &str) -> String {
    let response = app.client.get(app.url(path)).header("accept", kind).send().await.unwrap();
    assert_eq!(response.status(), StatusCode::OK, "{path}");
    assert_eq!(response.headers()["content-type"], kind);
    response.text().await.unwrap()
}

#[tokio::test]
async fn an_entry_is_kept_and_read_back() {
    let app = spawn().await;
    let mut body = radius(120);
    body["standard_uncertainty_um"] = 1.0.into();
    body["note"] = "tool setter".into();
    let response = app.post_json(&entries(), &body).await;
    assert_eq!(response.status(), StatusCode::CREATED);
    let location = response.headers()["location"].to_str().unwrap().to_owned();
    let entry: Value = response.json().await.unwrap();
    assert_eq!(location, format!("{}/{}", entries(), entry["id"].as_str().unwrap()));
    assert_eq!(entry["measured_at"], "2025-03-13T09:00:00.000Z");
    assert_eq!((&entry["cutter_id"], &entry["edge"]), (&json!("1"), &Value::Null));
    assert_eq!((&entry["tool_id"], &entry["parts_cut"]), (&json!("T12"), &json!(120)));
    assert_eq!(entry.get("flank_wear_um"), None);
    assert_eq!(entry["withdrawn"], Value::Null);
    let first = app.get(&location).await;
    let tag = first.headers()["etag"].to_str().unwrap().to_owned();
    assert_eq!(first.json::<Value>().await.unwrap(), entry);
    let again = || app.client.get(app.url(&location)).header("if-none-match", &tag).send();
    assert_eq!(again().await.unwrap().status(), StatusCode::NOT_MODIFIED);
    assert_eq!(read(&app, &entries()).await, json!({"items": [entry], "next_cursor": null}));
    // Withdrawn it is another.
    let id = entry["id"].as_str().unwrap();
    assert_eq!(withdraw(&app, id, &json!({"reason": "the wrong flute"})).await.status(), 200);
    let other = again().await.unwrap();
    assert_eq!(other.status(), StatusCode::OK);
    assert_ne!(other.headers()["etag"], tag.as_str());
}

#[tokio::test]
async fn an_array_is_kept_whole_and_listed_newest_first() {
    let app = spawn().await;
    let many: Vec<Value> = (0..5).map(|k| radius(10 * k)).collect();
    let response = app.post_json(&entries(), &json!(many)).await;
    assert_eq!(response.status(), StatusCode::CREATED);
    assert_eq!(response.headers()["location"], entries().as_str());
    let kept: Value = response.json().await.unwrap();
    assert_eq!(kept.as_array().unwrap().len(), 5);
    assert_eq!(kept[3]["parts_cut"], 30);
    let mut other = radius(0);
    other["cutter_id"] = "regrind 2".into();
    let other = post(&app, &other).await;
    let page = read(&app, &format!("{}?limit=2", entries())).await;
    assert_eq!(page["items"], json!([other, kept[4]]));
    let next = page["next_cursor"].as_str().unwrap();
    let rest = read(&app, &format!("{}?cursor={next}", entries())).await;
    assert_eq!(rest["items"].as_array().unwrap().len(), 4);
    let of_first = read(&app, &format!("{}?cutter_id=1&limit=1", entries())).await;
    assert_eq!(of_first["items"], json!([kept[4]]));
    // Without a cutter, the trend follows that of the newest entry.
    assert_eq!(read(&app, &trend("")).await["cutter_id"], "regrind 2");
    let first = read(&app, &trend("?cutter_id=1")).await;
    assert_eq!(first["edges"][0]["entries"].as_array().unwrap().len(), 5);
    assert_eq!((&first["outlook"], &first["limit_um"]), (&Value::Null, &Value::Null));
}

#[tokio::test]
async fn a_steady_cutter_is_told_the_parts_it_has_left() {
    let app = spawn().await;
    post(&app, &json!((0..13).map(|k| radius(10 * k)).collect::<Vec<_>>())).await;
    let path = trend("?limit_um=60");
    let found = read(&app, &path).await;
    assert_eq!((&found["quantity"], &found["parts_now"]), (&json!("radius"), &json!(120)));
    let edge = &found["edges"][0];
    assert!((edge["fit"]["rate_um_per_part"].as_f64().unwrap() - 0.2).abs() < 0.01, "{edge}");
    assert_eq!(edge["fit"]["is_rising"], true);
    assert!((edge["entries"][6]["fitted_um"].as_f64().unwrap() - 32.0).abs() < 0.3, "{edge}");
    // 60 µm at 200 parts.
    let outlook = &found["outlook"];
    assert_eq!(outlook["kind"], "predicted", "{outlook}");
    let number = |pointer: &str| outlook.pointer(pointer).and_then(Value::as_u64).unwrap();
    assert!((196..=204).contains(&number("/parts_at_limit/estimate")), "{outlook}");
    assert!((130..200).contains(&number("/parts_at_limit/earliest")), "{outlook}");
    assert!((201..480).contains(&number("/parts_at_limit/latest")), "{outlook}");
    assert!((165..200).contains(&number("/parts_at_limit_in_this_stage/earliest")), "{outlook}");
    assert!((201..400).contains(&number("/parts_at_limit_in_this_stage/latest")), "{outlook}");
    for end in ["earliest", "latest"] {
        let whole = number(&format!("/parts_at_limit/{end}")).abs_diff(200);
        assert!(whole > number(&format!("/parts_at_limit_in_this_stage/{end}")).abs_diff(200), "{outlook}");
    }
    let basis = &outlook["basis"];
    assert_eq!(
        (&basis["model"], &basis["reach_parts"]),
        (&json!("straying-rate-with-stages"), &json!(480)),
        "{basis}"
    );
    let of_edge = &basis["edges"][0];
    assert_eq!(
        (&of_edge["entries"], &of_edge["numbers_of_parts"], &of_edge["first_parts"], &of_edge["last_parts"]),
        (&json!(13), &json!(13), &json!(0), &json!(120)),
        "{basis}"
    );
    assert_eq!(of_edge["scatter_um"], edge["fit"]["scatter_um"]);
    assert!((of_edge["reference_rate_um_per_part"].as_f64().unwrap() - 0.2).abs() < 0.02, "{basis}");
    assert!((0.0..0.7).contains(&of_edge["correlation"].as_f64().unwrap()), "{basis}");
    assert!((0.02..1.0).contains(&of_edge["rate_drift"].as_f64().unwrap()), "{basis}");
    assert_eq!(number("/parts_left/estimate") + 120, number("/parts_at_limit/estimate"));
    assert!(outlook["words"].as_str().unwrap().starts_with("60 µm are most likely reached at"), "{outlook}");
    assert_eq!(found["warnings"], json!([]));

    let table = as_kind(&app, &path, "text/csv").await;
    assert!(
        table.starts_with("edge,parts_cut,radius_wear_um,standard_uncertainty_um,fitted_um,measured_at,id\n")
    );
    assert_eq!(table.lines().count(), 14);
    let svg = as_kind(&app, &path, "image/svg+xml").await;
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    assert!(svg.contains("limit 60 µm") && svg.contains("T12") && svg.contains("<polygon"));
    assert_eq!(svg, as_kind(&app, &path, "image/svg+xml").await);
}

#[tokio::test]
async fn what_cannot_be_told_is_null_and_said() {
    let app = spawn().await;
    let none = read(&app, &trend("?limit_um=60")).await;
    assert_eq!(
        (&none["cutter_id"], &none["edges"], &none["parts_now"]),
        (&Value::Null, &json!([]), &Value::Null)
    );
    assert_eq!(
        (&none["outlook"]["kind"], &none["outlook"]["parts_left"]),
        (&json!("too-few-entries"), &Value::Null)
    );
    post(&app, &json!([radius(0), radius(10)])).await;
    let few = read(&app, &trend("?limit_um=60")).await;
    assert_eq!((&few["outlook"]["kind"], &few["edges"][0]["fit"]), (&json!("too-few-entries"), &Value::Null));
    assert!(few["outlook"]["words"].as_str().unwrap().contains("at 2 different numbers of parts"), "{few}");
    assert_eq!(
        (&few["outlook"]["basis"], &few["outlook"]["parts_at_limit_in_this_stage"]),
        (&Value::Null, &Value::Null)
    );
    assert!(as_kind(&app, &trend("?limit_um=60"), "image/svg+xml").await.contains("<circle"));

    post(&app, &json!((2..10).map(|k| radius(10 * k)).collect::<Vec<_>>())).await;
    let passed = read(&app, &trend("?limit_um=30.5")).await;
    assert_eq!(
        (&passed["outlook"]["kind"], &passed["outlook"]["parts_left"]),
        (&json!("passed"), &Value::Null)
    );
    assert!(passed["outlook"]["words"].as_str().unwrap().contains("between 50 and 60 parts"), "{passed}");
    let before = read(&app, &trend("?limit_um=5")).await;
    assert!(before["outlook"]["words"].as_str().unwrap().contains("at 0 parts or before"), "{before}");
    let far = read(&app, &trend("?limit_um=900")).await;
    assert_eq!(
        (&far["outlook"]["kind"], &far["outlook"]["parts_left"]["estimate"]),
        (&json!("beyond-reach"), &Value::Null)
    );

    // Wear that stands still.
    let still: Vec<Value> = (0..8)
        .map(|k| {
            let mut entry = radius(10 * k);
            entry["radius_wear_um"] =
                (40.0 + f64::from([0, 2, 1, 3, 0, 2, 3, 1][usize::try_from(k).unwrap()])).into();
            entry["cutter_id"] = "still".into();
            entry
        })
        .collect();
    post(&app, &json!(still)).await;
    let still = read(&app, &trend("?limit_um=60&cutter_id=still")).await;
    let outlook = &still["outlook"];
    assert_eq!(
        (&outlook["kind"], &outlook["parts_left"]["estimate"]),
        (&json!("no-rise"), &Value::Null),
        "{outlook}"
    );
    assert_eq!(still["edges"][0]["fit"]["is_rising"], false);
    assert_eq!(outlook["parts_at_limit_in_this_stage"]["latest"], Value::Null, "{outlook}");
    assert!(outlook["parts_at_limit"]["earliest"].as_u64().unwrap() > 70, "{outlook}");
    assert_eq!(outlook["basis"]["edges"][0]["entries"], 8, "{outlook}");
    assert!(outlook["words"].as_str().unwrap().contains("less than 90 %"), "{outlook}");
}

#[tokio::test]
async fn the_worst_edge_governs_and_oddities_are_warned_of() {
    let app = spawn().await;
    let mut many = Vec::new();
    for k in 0..10_i64 {
        for (edge, rate) in [("1", 1.0), ("2", 1.2), ("3", 0.9)] {
            if edge == "3" && k > 7 {
                continue;
            }
            let mut entry = radius(10 * k);
            let wear = entry.as_object_mut().unwrap().remove("radius_wear_um").unwrap().as_f64().unwrap();
            entry["flank_wear_um"] = (rate * wear).into();
            entry["edge"] = edge.into();
            entry["cutter_id"] = "b".into();
            if edge == "1" && k == 5 {
                entry["flank_wear_um"] = 3.0.into();
                entry["standard_uncertainty_um"] = 1.0.into();
            }
            many.push(entry);
        }
    }
    let mut alone = many[0].clone();
    alone["edge"] = "4".into();
    many.push(alone);
    let kept = post(&app, &json!(many)).await;
    let found = read(&app, &trend("?limit_um=60")).await;
    assert_eq!(found["edges"].as_array().unwrap().len(), 4);
    assert_eq!(
        (&found["outlook"]["first_edge"], &found["outlook"]["kind"]),
        (&json!("2"), &json!("predicted"))
    );
    let warned: Vec<_> = found["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| (warning["kind"].as_str().unwrap(), warning["edge"].as_str().unwrap()))
        .collect();
    assert!(warned.contains(&("uncertainties-left-out", "1")), "{warned:?}");
    assert!(warned.contains(&("edge-behind", "3")), "{warned:?}");
    assert!(warned.contains(&("edge-without-fit", "4")), "{warned:?}");
    assert!(as_kind(&app, &trend("?limit_um=60"), "image/svg+xml").await.contains("edge 2"));

    // The misread entry of edge 1 is withdrawn, and trends no longer see it.
    let misread = kept.as_array().unwrap().iter().find(|entry| entry["flank_wear_um"] == 3.0).unwrap();
    let id = misread["id"].as_str().unwrap();
    let gone = withdraw(&app, id, &json!({"reason": "read the wrong flute"})).await;
    assert_eq!(gone.status(), StatusCode::OK);
    let gone: Value = gone.json().await.unwrap();
    assert_eq!(gone["withdrawn"]["reason"], "read the wrong flute");
    assert_eq!(read(&app, &format!("{}/{id}", entries())).await, gone);
    let again = withdraw(&app, id, &json!({"reason": "read the wrong flute"})).await;
    assert_eq!(again.json::<Value>().await.unwrap(), gone, "withdrawn twice is withdrawn once");
    let other = withdraw(&app, id, &json!({"reason": "another"})).await;
    assert_eq!(other.status(), StatusCode::CONFLICT);
    assert!(problem(other, "already-withdrawn").await["detail"].as_str().unwrap().contains("wrong flute"));
    let cleaned = read(&app, &trend("")).await;
    assert_eq!(cleaned["edges"][0]["entries"].as_array().unwrap().len(), 9);
    let (before, after) =
        (&found["edges"][0]["fit"]["scatter_um"], &cleaned["edges"][0]["fit"]["scatter_um"]);
    assert!(after.as_f64().unwrap() < 0.2 * before.as_f64().unwrap(), "{before} {after}");
    // The right number may take its place.
    let mut right = many.iter().find(|entry| entry["flank_wear_um"] == 3.0).unwrap().clone();
    right["flank_wear_um"] = 30.0.into();
    post(&app, &right).await;
    let listed = read(&app, &format!("{}?limit=200", entries())).await;
    assert!(listed["items"].as_array().unwrap().contains(&gone), "what was withdrawn stays in the list");
}

#[tokio::test]
async fn wear_that_falls_is_asked_about() {
    let app = spawn().await;
    let mut many: Vec<Value> = (0..12).map(|k| radius(10 * k)).collect();
    for entry in &mut many[9..] {
        entry["radius_wear_um"] = (entry["radius_wear_um"].as_f64().unwrap() - 36.0).into();
    }
    for entry in &mut many {
        entry["standard_uncertainty_um"] = 0.5.into();
    }
    post(&app, &json!(many)).await;
    let found = read(&app, &trend("?limit_um=60")).await;
    let warning = &found["warnings"][0];
    assert_eq!(warning["kind"], "wear-falls", "{found}");
    assert!(warning["detail"].as_str().unwrap().contains("at 90 parts"), "{warning}");
}

/// A change to an entry.
type Change = fn(&mut Value);

#[tokio::test]
async fn bad_entries_are_refused_with_every_fault_and_nothing_is_kept() {
    let app = spawn().await;
    let cases: [(Change, &[&str]); 13] = [
        (|entry| entry["measured_at"] = "2126-01-01T00:00:00Z".into(), &["/measured_at"]),
        (|entry| entry["measured_at"] = "yesterday".into(), &["/measured_at"]),
        (|entry| entry["parts_cut"] = (-1).into(), &["/parts_cut"]),
        (|entry| entry["parts_cut"] = 1.5.into(), &["/parts_cut"]),
        (|entry| entry["parts_cut"] = 1_000_000_001.into(), &["/parts_cut"]),
        (|entry| entry["radius_wear_um"] = Value::Null, &["/radius_wear_um"]),
        (|entry| entry["flank_wear_um"] = 1.into(), &["/flank_wear_um"]),
        (|entry| entry["radius_wear_um"] = (-0.1).into(), &["/radius_wear_um"]),
        (|entry| entry["standard_uncertainty_um"] = 0.into(), &["/standard_uncertainty_um"]),
        (|entry| entry["cutter_id"] = " 1".into(), &["/cutter_id"]),
        (|entry| entry["edge"] = "".into(), &["/edge"]),
        (|entry| entry["flutes"] = 3.into(), &["/flutes"]),
        (
            |entry| {
                entry["parts_cut"] = (-1).into();
                entry["radius_wear_um"] = 1e5.into();
                entry["note"] = "x".repeat(3000).into();
                entry["cutter_id"] = "a\nb".into();
                entry["measured_at"] = "never".into();
            },
            &["/cutter_id", "/measured_at", "/note", "/parts_cut", "/radius_wear_um"],
        ),
    ];
    for (change, expected) in cases {
        let mut entry = radius(10);
        change(&mut entry);
        let refused = problem(app.post_json(&entries(), &entry).await, "invalid-request").await;
        let mut found = pointers(&refused);
        found.sort();
        assert_eq!(found, expected, "{refused}");
        // The same in an array stands at its index.
        let refused =
            problem(app.post_json(&entries(), &json!([radius(0), entry])).await, "invalid-request").await;
        let mut found = pointers(&refused);
        found.sort();
        let expected: Vec<String> = expected.iter().map(|pointer| format!("/1{pointer}")).collect();
        assert_eq!(found, expected, "{refused}");
    }
    let none = problem(app.post_json(&entries(), &json!([])).await, "invalid-request").await;
    assert_eq!(pointers(&none), [""]);
    for body in [json!(3), json!("x"), json!(null)] {
        problem(app.post_json(&entries(), &body).await, "invalid-request").await;
    }
    problem(app.post_text(&entries(), "application/json", "{").await, "unreadable-json").await;
    problem(app.post_text(&entries(), "text/plain", "{}").await, "unsupported-media-type").await;
    let twice = problem(
        app.post_json(&entries(), &json!([radius(0), radius(10), radius(0)])).await,
        "invalid-request",
    )
    .await;
    assert_eq!(pointers(&twice), ["/2"]);
    let mut flank = radius(20);
    flank["flank_wear_um"] = flank.as_object_mut().unwrap().remove("radius_wear_um").unwrap();
    let mixed = problem(app.post_json(&entries(), &json!([radius(0), flank])).await, "invalid-request").await;
    assert_eq!(pointers(&mixed), ["/1/flank_wear_um"]);
    assert_eq!(read(&app, &entries()).await["items"], json!([]), "nothing was kept");

    // Against what is there.
    post(&app, &radius(0)).await;
    let refused =
        problem(app.post_json(&entries(), &json!([radius(10), flank, radius(0)])).await, "invalid-request")
            .await;
    assert_eq!(pointers(&refused), ["/1/flank_wear_um"], "within the request first");
    let refused = problem(app.post_json(&entries(), &json!([flank])).await, "invalid-request").await;
    assert_eq!(pointers(&refused), ["/0/flank_wear_um"]);
    let refused = problem(app.post_json(&entries(), &radius(0)).await, "invalid-request").await;
    assert_eq!(pointers(&refused), [""]);
    flank["cutter_id"] = "2".into();
    post(&app, &flank).await;
    assert_eq!(read(&app, &entries()).await["items"].as_array().unwrap().len(), 2);
    let edges: Vec<Value> = (0..40)
        .map(|edge| {
            let mut entry = radius(30);
            entry["edge"] = format!("e{edge}").into();
            entry
        })
        .collect();
    // The cutter as a whole counts as one.
    let refused = problem(app.post_json(&entries(), &json!(edges)).await, "invalid-request").await;
    assert_eq!(pointers(&refused), ["/31/edge"]);
}

#[tokio::test]
async fn unknown_and_deleted_machines_and_odd_queries() {
    let app = spawn().await;
    let nobody = "/v1/machines/nobody/tools/T12";
    problem(app.post_json(&format!("{nobody}/wear-entries"), &radius(0)).await, "machine-not-found").await;
    problem(app.get(&format!("{nobody}/wear-entries")).await, "machine-not-found").await;
    problem(app.get(&format!("{nobody}/wear-entries/none")).await, "machine-not-found").await;
    problem(app.get(&format!("{nobody}/wear-trend")).await, "machine-not-found").await;
    let reason = json!({"reason": "x"});
    problem(
        app.post_json(&format!("{nobody}/wear-entries/none/withdraw"), &reason).await,
        "machine-not-found",
    )
    .await;
    problem(app.get(&format!("{}/none", entries())).await, "wear-entry-not-found").await;
    problem(withdraw(&app, "none", &reason).await, "wear-entry-not-found").await;
    let entry = post(&app, &radius(0)).await;
    let id = entry["id"].as_str().unwrap();
    for body in [json!({"reason": ""}), json!({"reason": 1}), json!({}), json!({"reason": "x".repeat(2001)})]
    {
        assert_eq!(pointers(&problem(withdraw(&app, id, &body).await, "invalid-request").await), ["/reason"]);
    }
    // An entry of one tool is none of another.
    let other = format!("/v1/machines/example-ac-table/tools/T13/wear-entries/{id}");
    problem(app.get(&other).await, "wear-entry-not-found").await;
    problem(app.post_json(&format!("{other}/withdraw"), &reason).await, "wear-entry-not-found").await;
    for (query, pointer) in [
        ("?limit_um=0", "/limit_um"),
        ("?limit_um=much", "/limit_um"),
        ("?limit_um=1e9", "/limit_um"),
        ("?limit=3", "/limit"),
    ] {
        assert_eq!(pointers(&problem(app.get(&trend(query)).await, "invalid-request").await), [pointer]);
    }
    let refused = app.client.get(app.url(&trend(""))).header("accept", "text/html").send().await.unwrap();
    problem(refused, "not-acceptable").await;

    // A deleted machine keeps its history and takes no more.
    let delete = app.client.delete(app.url("/v1/machines/example-ac-table")).header("if-match", "*");
    assert!(delete.send().await.unwrap().status().is_success());
    assert_eq!(read(&app, &entries()).await["items"], json!([entry]));
    assert_eq!(read(&app, &trend("")).await["parts_now"], 0);
    problem(app.post_json(&entries(), &radius(10)).await, "machine-not-found").await;
}

#[tokio::test]
async fn a_tool_may_have_any_name() {
    let app = spawn().await;
    for (name, segment) in [
        ("Ø 8/2 50%?", "%C3%98%208%2F2%2050%25%3F"),
        ("T12#a&b=c", "T12%23a%26b%3Dc"),
        ("..", "%2E%2E"),
        ("'; DROP TABLE wear_entries; --", "%27%3B%20DROP%20TABLE%20wear_entries%3B%20--"),
    ] {
        let url = |rest: &str| format!("{}/v1/machines/example-ac-table/tools/{segment}/{rest}", app.base);
        let send = reqwest::Url::parse(&url("wear-entries")).unwrap();
        if !send.path().contains("/tools/") {
            // A client that takes two dots for a step up never gets there.
            continue;
        }
        let response = app.client.post(send).json(&radius(0)).send().await.unwrap();
        assert_eq!(response.status(), StatusCode::CREATED, "{name}");
        let location = response.headers()["location"].to_str().unwrap().to_owned();
        let entry: Value = response.json().await.unwrap();
        assert_eq!(entry["tool_id"], name);
        assert_eq!(read(&app, &location).await, entry, "{location}");
        let followed =
            app.client.get(url("wear-trend")).header("accept", "image/svg+xml").send().await.unwrap();
        assert!(followed.text().await.unwrap().ends_with("</svg>\n"));
    }
    for segment in ["%20", "%00", "a%0Ab", &"x".repeat(101)] {
        let path = format!("/v1/machines/example-ac-table/tools/{segment}/wear-entries");
        assert_eq!(
            pointers(&problem(app.post_json(&path, &radius(0)).await, "invalid-request").await),
            ["/tool_id"]
        );
        problem(app.get(&path).await, "invalid-request").await;
    }
}

#[tokio::test]
async fn keys_make_retries_safe_and_posts_at_once_do_not_mix() {
    let app = spawn().await;
    let send = |key: &'static str, body: Value| {
        app.client.post(app.url(&entries())).header("idempotency-key", key).json(&body).send()
    };
    let many = json!([radius(0), radius(10)]);
    let (first, second) = futures::future::join(send("many", many.clone()), send("many", many.clone())).await;
    let (first, second) = (first.unwrap(), second.unwrap());
    assert_eq!((first.status(), second.status()), (StatusCode::CREATED, StatusCode::CREATED));
    let (first, second): (Value, Value) = (first.json().await.unwrap(), second.json().await.unwrap());
    assert_eq!(first, second);
    assert_eq!(read(&app, &entries()).await["items"].as_array().unwrap().len(), 2);
    let one = send("one", radius(20)).await.unwrap();
    let location = one.headers()["location"].clone();
    let one: Value = one.json().await.unwrap();
    let again = send("one", radius(20)).await.unwrap();
    assert_eq!(again.headers()["location"], location);
    assert_eq!(again.json::<Value>().await.unwrap(), one);
    problem(send("one", radius(30)).await.unwrap(), "idempotency-key-reused").await;
    problem(send("one", json!([radius(20)])).await.unwrap(), "idempotency-key-reused").await;
    // A repeated answer is the first one, also when the entry was withdrawn since.
    withdraw(&app, one["id"].as_str().unwrap(), &json!({"reason": "x"})).await;
    assert_eq!(send("one", radius(20)).await.unwrap().json::<Value>().await.unwrap(), one);

    // Without a key the same entry is kept once, and of two quantities at once one wins.
    let (a, b) =
        futures::future::join(app.post_json(&entries(), &radius(40)), app.post_json(&entries(), &radius(40)))
            .await;
    let mut statuses = [a.status().as_u16(), b.status().as_u16()];
    statuses.sort_unstable();
    assert_eq!(statuses, [201, 422]);
    let mut flank = radius(0);
    flank["flank_wear_um"] = flank.as_object_mut().unwrap().remove("radius_wear_um").unwrap();
    let mut radial = radius(0);
    for entry in [&mut flank, &mut radial] {
        entry["cutter_id"] = "new".into();
    }
    let (a, b) =
        futures::future::join(app.post_json(&entries(), &flank), app.post_json(&entries(), &radial)).await;
    let mut statuses = [a.status().as_u16(), b.status().as_u16()];
    statuses.sort_unstable();
    assert_eq!(statuses, [201, 422]);
}

#[tokio::test]
async fn the_database_keeps_entries_as_they_are() {
    let app = spawn().await;
    let entry = post(&app, &radius(0)).await;
    withdraw(&app, entry["id"].as_str().unwrap(), &json!({"reason": "x"})).await;
    for statement in [
        "UPDATE wear_entries SET wear_um = 0",
        "DELETE FROM wear_entries",
        "UPDATE wear_withdrawals SET reason = 'y'",
        "DELETE FROM wear_withdrawals",
    ] {
        let refused = database::change(&app.data, statement).await.unwrap_err();
        assert!(refused.contains("never"), "{statement}: {refused}");
    }
}

#[tokio::test]
async fn ten_thousand_entries_of_a_cutter_are_followed_and_no_more_are_taken() {
    let app = spawn().await;
    assert_eq!(app.put_machine("other", &ac_table()).await.status(), StatusCode::CREATED);
    let many: Vec<Value> = (0..10_001)
        .map(radius)
        .enumerate()
        .map(|(index, mut entry)| {
            entry["parts_cut"] = index.into();
            entry["radius_wear_um"] = (20.0 + 0.002 * index as f64 + (index * 7 % 5) as f64 * 0.3).into();
            entry["edge"] = (index % 4).to_string().into();
            entry
        })
        .collect();
    let refused = problem(app.post_json(&entries(), &json!(many)).await, "invalid-request").await;
    assert_eq!(pointers(&refused), [""]);
    let kept = post(&app, &json!(many[..10_000])).await;
    assert_eq!(kept.as_array().unwrap().len(), 10_000);
    let one_more = problem(app.post_json(&entries(), &many[10_000]).await, "invalid-request").await;
    assert!(one_more["detail"].as_str().unwrap().contains("at most 10000"), "{one_more}");
    let found = read(&app, &trend("?limit_um=60")).await;
    assert_eq!(found["edges"].as_array().unwrap().len(), 4);
    let estimate = found["outlook"]["parts_at_limit"]["estimate"].as_i64().unwrap();
    assert!((estimate - 19_700).abs() < 1000, "{}", found["outlook"]);
    let svg = as_kind(&app, &trend("?limit_um=60"), "image/svg+xml").await;
    // The entries, the samples of the legend, and the estimate.
    assert!(svg.matches("<circle").count() <= 4 * 1001 + 1, "thinned");
    assert_eq!(as_kind(&app, &trend(""), "text/csv").await.lines().count(), 10_001);
    // The same tool on another machine is another tool.
    let other = "/v1/machines/other/tools/T12/wear-entries";
    assert_eq!(app.post_json(other, &radius(0)).await.status(), StatusCode::CREATED);
    assert_eq!(read(&app, other).await["items"].as_array().unwrap().len(), 1);
}
