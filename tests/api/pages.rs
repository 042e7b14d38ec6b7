//! Lists: pages, cursors, their limits.

use serde_json::Value;

use crate::support::{ac_table, pointers, problem, spawn};

#[tokio::test]
async fn pages_join_to_the_whole_list_newest_first() {
    let app = spawn().await;
    for index in 0..7 {
        assert_eq!(app.put_machine(&format!("m{index}"), &ac_table()).await.status(), 201);
    }
    let mut ids = Vec::new();
    let mut path = "/v1/machines?limit=3".to_owned();
    loop {
        let page: Value = app.get(&path).await.json().await.unwrap();
        let items = page["items"].as_array().unwrap();
        assert!(items.len() <= 3);
        ids.extend(items.iter().map(|item| item["machine_id"].as_str().unwrap().to_owned()));
        let Some(cursor) = page["next_cursor"].as_str() else { break };
        path = format!("/v1/machines?limit=3&cursor={cursor}");
    }
    assert_eq!(ids, ["m6", "m5", "m4", "m3", "m2", "m1", "m0", "example-ac-table"]);
    let whole: Value = app.get("/v1/machines?limit=8").await.json().await.unwrap();
    assert!(whole["next_cursor"].is_null());
}

#[tokio::test]
async fn bad_limits_cursors_and_parameters_are_named() {
    let app = spawn().await;
    let cases = [
        ("limit=0", "/limit"),
        ("limit=201", "/limit"),
        ("limit=99999999999999999999", "/limit"),
        ("limit=x", "/limit"),
        ("limit=-1", "/limit"),
        ("cursor=x", "/cursor"),
        ("cursor=0123456789abcdef", "/cursor"),
        ("limit=1&limit=2", "/limit"),
        ("limt=1", "/limt"),
        ("limit.x=1", "/limit"),
    ];
    for path in ["/v1/machines", "/v1/jobs", "/v1/machines/example-ac-table/revisions"] {
        for (query, pointer) in cases {
            let body = problem(app.get(&format!("{path}?{query}")).await, "invalid-request").await;
            assert_eq!(pointers(&body), [pointer], "{path}?{query}: {body}");
        }
        for limit in [1, 200] {
            assert_eq!(app.get(&format!("{path}?limit={limit}")).await.status(), 200);
        }
        problem(app.get(&format!("{path}?limit=%zz")).await, "malformed-request").await;
    }
    let body = problem(app.get("/v1/machines/example-ac-table?x=1").await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/x"]);
}
