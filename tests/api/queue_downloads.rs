//! Lists of jobs, and results in parts.

use serde_json::Value;

use crate::queue::{accepted, cc, ended};
use crate::support::{App, pointers, problem, spawn};

#[tokio::test]
async fn jobs_are_found_by_what_they_are_and_when_they_came() {
    let app = spawn().await;
    let mut order = cc("example-ac-table");
    order["external_id"] = "WO 4711/20".into();
    let mine = accepted(&app, &order, "g1\n").await;
    ended(&app, &mine).await;
    let other = accepted(&app, &cc("example-ac-table"), "g2\n").await;
    let created = ended(&app, &other).await["created_at"].as_str().unwrap().to_owned();
    let found = async |query: &str| {
        let list: Value = app.get(&format!("/v1/jobs?{query}")).await.json().await.unwrap();
        let items = list["items"].as_array().unwrap_or_else(|| panic!("{list}")).clone();
        items.iter().map(|job| format!("/v1/jobs/{}", job["id"].as_str().unwrap())).collect::<Vec<_>>()
    };
    assert_eq!(found("external_id=WO%204711/20").await, std::slice::from_ref(&mine));
    assert_eq!(found("operation=cc-compensation").await, [other.clone(), mine.clone()]);
    assert!(found("operation=verification").await.is_empty());
    assert_eq!(found(&format!("created_after={created}")).await, std::slice::from_ref(&other));
    assert_eq!(found(&format!("created_before={created}")).await, std::slice::from_ref(&mine));
    assert_eq!(found("state=succeeded&limit=1").await, [other]);
    let body =
        problem(app.get("/v1/jobs?created_after=today&created_before=1").await, "invalid-request").await;
    assert_eq!(pointers(&body), ["/created_after", "/created_before"]);
    problem(app.get("/v1/jobs?operation=milling").await, "invalid-request").await;
}

async fn part(app: &App, path: &str, range: &str, condition: Option<&str>) -> reqwest::Response {
    let mut request = app.client.get(app.url(path)).header("range", range);
    if let Some(condition) = condition {
        request = request.header("if-range", condition);
    }
    request.send().await.unwrap()
}

#[tokio::test]
async fn programs_and_reports_come_in_parts() {
    let app = spawn().await;
    let place = accepted(&app, &cc("example-ac-table"), "g1 x1\ng1 x2\n").await;
    assert_eq!(ended(&app, &place).await["state"], "succeeded");
    for face in ["program", "report"] {
        let path = format!("{place}/{face}");
        let whole = app.get(&path).await;
        assert_eq!(whole.headers()["accept-ranges"], "bytes");
        let tag = whole.headers()["etag"].to_str().unwrap().to_owned();
        let whole = whole.bytes().await.unwrap();
        let length = whole.len();
        for (range, expected) in [
            ("bytes=0-3".to_owned(), 0..4),
            ("bytes=4-".to_owned(), 4..length),
            ("bytes=-5".to_owned(), length - 5..length),
            (format!("bytes=2-{}", length + 10), 2..length),
        ] {
            let response = part(&app, &path, &range, Some(&tag)).await;
            assert_eq!(response.status(), 206, "{range}");
            let of = format!("bytes {}-{}/{length}", expected.start, expected.end - 1);
            assert_eq!(response.headers()["content-range"], of.as_str());
            assert_eq!(response.headers()["etag"], tag.as_str());
            assert_eq!(response.bytes().await.unwrap(), whole.slice(expected), "{range}");
        }
        let changed = part(&app, &path, "bytes=0-3", Some("\"other\"")).await;
        assert_eq!((changed.status().as_u16(), changed.bytes().await.unwrap()), (200, whole.clone()));
        let behind = part(&app, &path, &format!("bytes={length}-"), None).await;
        assert_eq!(behind.headers()["content-range"], format!("bytes */{length}").as_str());
        problem(behind, "range-not-satisfiable").await;
    }
}
