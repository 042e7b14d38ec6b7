//! Health, metrics, documentation, start and stop.

use std::io::Read;

use serde_json::Value;

use crate::support::{pointers, problem, spawn, spawn_in, spawn_with};

#[tokio::test]
async fn a_new_service_is_alive_and_ready_and_has_the_example_machine() {
    let app = spawn().await;
    for path in ["/healthz", "/readyz", "/metrics", "/v1/version", "/openapi.json"] {
        assert_eq!(app.get(path).await.status(), 200, "{path}");
    }
    let machine: Value = app.get("/v1/machines/example-ac-table").await.json().await.unwrap();
    assert_eq!(machine["revision"], 1);
    assert_eq!(machine["created_at"].as_str().unwrap().len(), 24);
    let axes = &machine["kinematics"]["rotary_axes"];
    assert_eq!(axes[0]["name"], "A");
    assert_eq!(axes[0]["limits_deg"], serde_json::json!([-120.0, 120.0]));
    assert_eq!(axes[1]["name"], "C");
    assert!(axes[1]["limits_deg"].is_null());
    app.stop().await;
}

#[tokio::test]
async fn requests_are_counted_by_operation_and_status() {
    let app = spawn().await;
    app.get("/v1/machines/none").await;
    let text = app.get("/metrics").await.text().await.unwrap();
    let line = r#"trunnion_http_requests_total{operation="get_machine",method="GET",status="404"} 1"#;
    assert!(text.lines().any(|found| found == line), "{text}");
}

#[tokio::test]
async fn the_documentation_needs_nothing_from_elsewhere() {
    let app = spawn().await;
    let page = app.get("/docs/").await.text().await.unwrap();
    assert!(page.contains("swagger-ui"), "{page}");
    let mut checked = 0;
    for name in ["index.html", "swagger-initializer.js", "swagger-ui.css", "index.css"] {
        let response = app.get(&format!("/docs/{name}")).await;
        assert_eq!(response.status(), 200, "{name}");
        let text = response.text().await.unwrap();
        for loader in
            ["src=\"http", "href=\"http", "url(http", "url(\"http", "@import", "src=\"//", "href=\"//"]
        {
            assert!(!text.contains(loader), "{name} contains {loader}");
        }
        checked += 1;
    }
    let script = app.get("/docs/swagger-initializer.js").await.text().await.unwrap();
    assert!(script.contains("\"validatorUrl\": \"none\""), "{script}");
    assert!(script.contains("/openapi.json"), "{script}");
    assert_eq!(checked, 4);
}

#[tokio::test]
async fn the_description_and_its_pages_are_the_same_compressed_and_not() {
    let app = spawn().await;
    for path in ["/openapi.json", "/docs/swagger-ui.css", "/docs/favicon-32x32.png"] {
        let plain = app.get(path).await;
        assert!(!plain.headers().contains_key("content-encoding"), "{path}");
        let plain = plain.bytes().await.unwrap();
        let compressed =
            app.client.get(app.url(path)).header("accept-encoding", "gzip").send().await.unwrap();
        assert_eq!(compressed.headers()["content-encoding"], "gzip", "{path}");
        assert_eq!(compressed.headers()["vary"], "accept-encoding", "{path}");
        let compressed = compressed.bytes().await.unwrap();
        let mut text = Vec::new();
        flate2::read::GzDecoder::new(&*compressed).read_to_end(&mut text).unwrap();
        assert!(text == plain, "{path}");
    }
    let committed = include_str!("../../openapi/trunnion.json");
    assert!(app.get("/openapi.json").await.text().await.unwrap() == committed);
}

#[tokio::test]
async fn unknown_paths_and_methods_are_problems() {
    let app = spawn().await;
    problem(app.get("/v1/nothing").await, "not-found").await;
    problem(app.get("/docs/nothing.js").await, "not-found").await;
    let response = app.client.patch(app.url("/v1/machines/example-ac-table")).send().await.unwrap();
    assert!(response.headers()["allow"].to_str().unwrap().contains("PUT"));
    problem(response, "method-not-allowed").await;
}

#[tokio::test]
async fn the_id_of_a_request_is_ours_whatever_the_client_calls_it() {
    let app = spawn().await;
    let mut ids = std::collections::BTreeSet::new();
    for given in ["shift-4711", "shift-4711", &"x".repeat(129)] {
        let request = app.client.get(app.url("/healthz")).header("x-request-id", given);
        let answer = request.send().await.unwrap();
        let id = answer.headers()["x-request-id"].to_str().unwrap().to_owned();
        assert_eq!(id.len(), 36, "{id}");
        assert!(ids.insert(id));
    }
}

#[tokio::test]
async fn every_problem_has_a_page() {
    let app = spawn().await;
    let list = app.get("/problems").await.text().await.unwrap();
    for kind in trunnion::http::problem::ProblemType::ALL {
        assert!(list.contains(kind.code()));
        let response = app.get(&format!("/problems/{}", kind.code())).await;
        assert_eq!(response.status(), 200);
        assert!(response.text().await.unwrap().contains(kind.title()));
        let back = trunnion::http::problem::ProblemType::from_code(kind.code());
        assert_eq!(back, Some(*kind));
    }
    problem(app.get("/problems/none").await, "not-found").await;
}

#[tokio::test]
async fn a_second_service_does_not_get_the_same_directory() {
    let app = spawn().await;
    let settings = trunnion::config::Settings {
        listen: ([127, 0, 0, 1], 0).into(),
        data_dir: app.data.clone(),
        database: crate::database::address_of(&app.data).map(|address| address.parse().unwrap()),
        ..trunnion::config::Settings::default()
    };
    let again = trunnion::cli::start(
        settings,
        trunnion::jobs::Sources::real(),
        std::sync::Arc::new(trunnion::jobs::CutterContactCompensator::default()),
    );
    let fault = again.await.err().unwrap().to_string();
    assert!(fault.contains("another trunnion uses"), "{fault}");
}

#[tokio::test]
async fn a_restart_keeps_everything_and_does_not_bring_back_the_example() {
    let app = spawn().await;
    let put = app.put_machine("mine", &crate::support::ac_table()).await;
    let etag = put.headers()["etag"].to_str().unwrap().to_owned();
    let stored: Value = put.json().await.unwrap();
    let example = app.get("/v1/machines/example-ac-table").await.headers()["etag"].clone();
    let gone = app.client.delete(app.url("/v1/machines/example-ac-table")).header("if-match", example);
    assert_eq!(gone.send().await.unwrap().status(), 204);
    let run =
        app.post_text("/v1/machines/mine/cc-compensation?tool_radius_mm=5", "text/plain", "g1 x1\n").await;
    let job = run.headers()["location"].to_str().unwrap().to_owned();
    let data = app.data.clone();
    let directory = app.stop().await;
    let app = spawn_in(&data, |_| {}).await;
    let read = app.get("/v1/machines/mine").await;
    assert_eq!(read.headers()["etag"].to_str().unwrap(), etag);
    assert_eq!(read.json::<Value>().await.unwrap(), stored);
    problem(app.get("/v1/machines/example-ac-table").await, "machine-not-found").await;
    assert_eq!(app.get(&format!("{job}/program")).await.text().await.unwrap(), "G1 X1\n");
    app.stop().await;
    drop(directory);
}

#[tokio::test]
async fn what_an_ended_process_left_half_done_is_swept() {
    let app = spawn().await;
    let data = app.data.clone();
    let directory = app.stop().await;
    std::fs::write(data.join("spool/half"), "half a program").unwrap();
    std::fs::create_dir_all(data.join("blobs/ab")).unwrap();
    std::fs::write(data.join("blobs/ab").join("ab".repeat(32)), "a file that no row names").unwrap();
    let app = spawn_in(&data, |_| {}).await;
    assert_eq!(app.files(), (0, 0));
    app.stop().await;
    drop(directory);
}

#[tokio::test]
async fn a_draining_service_is_not_ready() {
    let app = spawn().await;
    app.begin_draining();
    assert_eq!(app.get("/readyz").await.status(), 503);
    problem(app.get("/readyz").await, "shutting-down").await;
    assert_eq!(app.get("/healthz").await.status(), 200);
}

#[tokio::test]
async fn a_handler_that_takes_too_long_is_ended_and_what_it_computes_stops() {
    let app = spawn_with(|settings| {
        settings.request_timeout_s = 0.2;
        settings.max_computations = 1;
        settings.max_waiting_computations = 0;
    })
    .await;
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    problem(app.post_text(path, "text/plain", "WAIT\n").await, "timed-out").await;
    // The only place is free again: what was computed there has polled its stop. On a machine that has much else to do,
    // this may take too long as well.
    loop {
        let response = app.post_text(path, "text/plain", "g1\n").await;
        if response.status() == 200 {
            break;
        }
        assert_eq!(response.status(), 503);
        let refused: Value = response.json().await.unwrap();
        assert!(
            ["/problems/busy", "/problems/timed-out"].contains(&refused["type"].as_str().unwrap()),
            "{refused}"
        );
    }
    assert_eq!(app.files().1, 0);
}

#[tokio::test]
async fn a_panic_is_an_internal_problem_and_tells_nothing() {
    let app = spawn().await;
    let path = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
    let body = problem(app.post_text(path, "text/plain", "PANIC\n").await, "internal").await;
    assert!(!body.to_string().contains("told to break"));
    assert!(pointers(&body).is_empty());
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn the_service_resources_negotiate_like_all_others() {
    let app = spawn().await;
    for (path, has) in [
        ("/healthz", "application/json"),
        ("/readyz", "application/json"),
        ("/v1/version", "application/json"),
        ("/openapi.json", "application/json"),
        ("/metrics", "text/plain"),
    ] {
        let ask = |accept: &'static str| app.client.get(app.url(path)).header("accept", accept).send();
        problem(ask("image/png").await.unwrap(), "not-acceptable").await;
        let answer = ask("image/png, */*;q=0.1").await.unwrap();
        assert_eq!(answer.status(), 200, "{path}");
        assert!(answer.headers()["content-type"].to_str().unwrap().starts_with(has), "{path}");
    }
}
