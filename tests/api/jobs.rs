//! Jobs as a record of what was computed.

use serde_json::Value;

use crate::support::{ac_table, pointers, problem, spawn};

#[tokio::test]
async fn jobs_are_listed_newest_first_and_filtered() {
    let app = spawn().await;
    app.put_machine("mine", &ac_table()).await;
    let mut places = Vec::new();
    for machine in ["mine", "example-ac-table", "mine"] {
        let path = format!("/v1/machines/{machine}/cc-compensation?tool_radius_mm=5");
        let run = app.post_text(&path, "text/plain", "g1\n").await;
        places.push(run.headers()["location"].to_str().unwrap().to_owned());
    }
    let ids = |query: &str| {
        let path = format!("/v1/jobs?{query}");
        let app = &app;
        async move {
            let list: Value = app.get(&path).await.json().await.unwrap();
            let items = list["items"].as_array().unwrap().clone();
            items.iter().map(|job| format!("/v1/jobs/{}", job["id"].as_str().unwrap())).collect::<Vec<_>>()
        }
    };
    places.reverse();
    assert_eq!(ids("").await, places);
    assert_eq!(ids("machine_id=mine").await, [places[0].clone(), places[2].clone()]);
    assert_eq!(ids("machine_id=mine&state=succeeded&limit=1").await, [places[0].clone()]);
    assert!(ids("state=failed").await.is_empty());
    assert!(ids("external_id=WO-1").await.is_empty());
    // A query has no null: what is to be left out is left out.
    assert!(ids("external_id=null").await.is_empty());
    for (query, pointer) in [("state=done", "/state"), ("limit=null", "/limit"), ("state=null", "/state")] {
        let body = problem(app.get(&format!("/v1/jobs?{query}")).await, "invalid-request").await;
        assert_eq!(pointers(&body), [pointer]);
    }
}

#[tokio::test]
async fn jobs_are_found_by_the_digests_of_their_programs() {
    let app = spawn().await;
    let mut jobs = Vec::new();
    for program in ["g1 x1\n", "g1 x2\n", "g1 x1\n"] {
        let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
        let run = app.post_text(path, "text/plain", program).await;
        let place = run.headers()["location"].to_str().unwrap().to_owned();
        jobs.push(app.get(&place).await.json::<Value>().await.unwrap());
    }
    let digest = |job: usize, name: &str| jobs[job][name].as_str().unwrap().to_owned();
    let found = async |query: String| {
        let list: Value = app.get(&format!("/v1/jobs?{query}")).await.json().await.unwrap();
        list["items"].as_array().unwrap().iter().map(|job| job["id"].clone()).collect::<Vec<_>>()
    };
    let ids = |which: &[usize]| which.iter().map(|job| jobs[*job]["id"].clone()).collect::<Vec<_>>();
    for name in ["input_sha256", "output_sha256"] {
        assert_eq!(found(format!("{name}={}", digest(0, name))).await, ids(&[2, 0]));
        assert_eq!(found(format!("{name}={}", digest(1, name).to_uppercase())).await, ids(&[1]));
        assert_eq!(found(format!("{name}={}&limit=1", digest(0, name))).await, ids(&[2]));
        assert!(found(format!("{name}={}", "0".repeat(64))).await.is_empty());
        assert!(found(format!("{name}={}&state=failed", digest(0, name))).await.is_empty());
        for wrong in ["abc", &"g".repeat(64)] {
            let refused =
                problem(app.get(&format!("/v1/jobs?{name}={wrong}")).await, "invalid-request").await;
            assert_eq!(pointers(&refused), [format!("/{name}")]);
        }
    }
    let both =
        format!("input_sha256={}&output_sha256={}", digest(0, "input_sha256"), digest(1, "output_sha256"));
    assert!(found(both).await.is_empty());
}

#[tokio::test]
async fn every_face_of_a_job_has_a_tag_and_answers_304() {
    let app = spawn().await;
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    let run = app.post_text(path, "text/plain", "g1\n").await;
    let job = run.headers()["location"].to_str().unwrap().to_owned();
    for (face, kind) in [
        ("", "application/json"),
        ("/program", "text/plain"),
        ("/report", "application/json"),
        ("/plot", "image/svg+xml"),
    ] {
        let path = format!("{job}{face}");
        let first = app.get(&path).await;
        assert_eq!(first.status(), 200, "{path}");
        assert_eq!(first.headers()["content-type"], kind);
        let tag = first.headers()["etag"].clone();
        let known = app.client.get(app.url(&path)).header("if-none-match", tag).send().await.unwrap();
        assert_eq!(known.status(), 304, "{path}");
        let html = app.client.get(app.url(&path)).header("accept", "text/html").send().await.unwrap();
        problem(html, "not-acceptable").await;
    }
    let report = format!("{job}/report");
    let plot = app.client.get(app.url(&report)).header("accept", "image/svg+xml").send().await.unwrap();
    assert!(plot.text().await.unwrap().contains("<svg"));
}

#[tokio::test]
async fn a_job_keeps_the_revision_it_was_computed_on() {
    let app = spawn().await;
    let tag = app.put_machine("mine", &ac_table()).await.headers()["etag"].clone();
    let path = "/v1/machines/mine/cc-compensation?tool_radius_mm=5";
    let run = app.post_text(path, "text/plain", "g1\n").await;
    let job = run.headers()["location"].to_str().unwrap().to_owned();
    let gone = app.client.delete(app.url("/v1/machines/mine")).header("if-match", tag).send().await.unwrap();
    assert_eq!(gone.status(), 204);
    let document: Value = app.get(&job).await.json().await.unwrap();
    assert_eq!(document["machine_id"], "mine");
    let revision = document["machine_revision"].as_i64().unwrap();
    assert_eq!(app.get(&format!("/v1/machines/mine/revisions/{revision}")).await.status(), 200);
    problem(app.post_text(path, "text/plain", "g1\n").await, "machine-not-found").await;
}

#[tokio::test]
async fn jobs_that_are_not_there_are_not_found() {
    let app = spawn().await;
    for face in ["", "/program", "/report", "/plot"] {
        problem(app.get(&format!("/v1/jobs/none{face}")).await, "job-not-found").await;
    }
}
