//! Forms, through the whole service.

use std::sync::{Arc, OnceLock};

use axum::body::{Body, Bytes, to_bytes};
use axum::http::{Request, StatusCode, header};
use axum::{Router, extract::Request as Asked};
use tempfile::TempDir;
use tokio::runtime::{Builder, Runtime};
use tower::ServiceExt;
use trunnion::config::Settings;
use trunnion::http::{AppState, router};
use trunnion::jobs::{CutterContactCompensator, Sources};

struct Running {
    runtime: Runtime,
    router: Router,
    data: TempDir,
}

fn running() -> &'static Running {
    static RUNNING: OnceLock<Running> = OnceLock::new();
    RUNNING.get_or_init(|| {
        let data = TempDir::new().expect("a directory");
        let settings = Settings {
            data_dir: data.path().to_owned(),
            max_rate_per_s: 0.0,
            max_body_bytes: 1 << 20,
            max_cost_s: 0.05,
            body_pause_timeout_s: 5.0,
            ..Settings::default()
        };
        let runtime = Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("a runtime");
        let state = runtime.block_on(AppState::open(settings, Sources::real(), Arc::new(CutterContactCompensator::default())));
        Running { runtime, router: router(state.expect("a service")), data }
    })
}

/// Operations that take a form.
const PATHS: [&str; 7] = [
    "/v1/machines/example-ac-table/cc-compensation",
    "/v1/machines/example-ac-table/wear-compensation",
    "/v1/machines/example-ac-table/compensation",
    "/v1/machines/example-ac-table/verification",
    "/v1/machines/example-ac-table/interpretation",
    "/v1/jobs",
    "/v1/job-batches",
];

/// A form is taken or refused with a reason, whatever it is and however it arrives; nothing of it stays half written.
pub fn form(data: &[u8]) {
    let Some((&choice, body)) = data.split_first() else { return };
    let Running { runtime, router, data } = running();
    let path = PATHS[usize::from(choice & 7) % PATHS.len()];
    let most = 1 + (usize::from(choice >> 3) * 37) % 1000;
    let pieces: Vec<Result<Bytes, std::io::Error>> = body.chunks(most).map(|piece| Ok(Bytes::copy_from_slice(piece))).collect();
    let request: Asked = Request::post(path)
        .header(header::HOST, "localhost")
        .header(header::CONTENT_TYPE, "multipart/form-data; boundary=b")
        .body(Body::from_stream(futures::stream::iter(pieces)))
        .expect("a request");
    runtime.block_on(async {
        let answer = router.clone().oneshot(request).await.unwrap_or_else(|never| match never {});
        let status = answer.status();
        let text = to_bytes(answer.into_body(), 64 << 20).await.expect("an answer");
        let text = String::from_utf8_lossy(&text);
        // The queue fills, because nobody waits for its jobs.
        let full = status == StatusCode::SERVICE_UNAVAILABLE || status == StatusCode::TOO_MANY_REQUESTS;
        assert!(full || !status.is_server_error(), "{status}: {text}");
        assert!(status.is_success() || text.contains("\"type\":\"/problems/"), "{status}: {text}");
    });
    let left = std::fs::read_dir(data.path().join("spool")).expect("the spool").count();
    // Those of jobs that are being computed.
    assert!(left <= 8, "{left} files left half written");
}
