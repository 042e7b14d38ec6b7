//! The page: machines, programs, calibrations, servo and wear, shown in a browser. Its files are in the binary, built
//! from `page/`. It asks the interface for everything it shows, as any other client does.

use axum::Router;
use axum::extract::Path;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use http::header::{CACHE_CONTROL, VARY};
use http::{HeaderMap, HeaderValue};
use serde_json::json;

use super::AppState;
use super::embedded::Embedded;
use super::extract::Json;
use super::negotiate::choose;
use super::problem::{Problem, ProblemType};

/// Routes that the description does not contain, with ids of their own.
pub(super) const UNDESCRIBED: [(&str, &str, &str); 2] =
    [("GET", "/", "get_home"), ("GET", "/page/{name}", "get_page_file")];

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The file that names all others.
const FIRST: &str = "index.html";
/// Comes before the digest of the content in the name of a file. A browser may keep such a file.
const DIGEST: char = '-';
const FOR_EVER: HeaderValue = HeaderValue::from_static("public, max-age=31536000, immutable");

// `FILES`: the files of `page/dist`, each with its name.
include!(concat!(env!("OUT_DIR"), "/page_files.rs"));

/// The routes of the page.
pub(super) fn router() -> Router<AppState> {
    Router::new().route("/", get(home)).route("/page/{name}", get(file))
}

fn find(name: &str) -> Result<&'static Embedded, Problem> {
    let file = FILES.iter().find(|(known, _)| *known == name);
    file.map(|(_, file)| file)
        .ok_or_else(|| Problem::new(ProblemType::NotFound, ProblemType::NotFound.title()))
}

async fn file(Path(name): Path<String>, headers: HeaderMap) -> Result<Response, Problem> {
    let mut response = find(&name)?.answer(&headers)?;
    if name.contains(DIGEST) {
        response.headers_mut().insert(CACHE_CONTROL, FOR_EVER);
    }
    Ok(response)
}

/// The page for a browser, and an index for every other client.
async fn home(headers: HeaderMap) -> Result<Response, Problem> {
    let chosen = choose(&headers, &["application/json", "text/html"])?;
    if chosen == "text/html" {
        let mut response = find(FIRST)?.answer(&headers)?;
        response.headers_mut().insert(VARY, HeaderValue::from_static("accept, accept-encoding"));
        return Ok(response);
    }
    let mut response = Json(json!({
        "name": "trunnion",
        "version": VERSION,
        "documentation": "/docs/",
        "description": "/openapi.json",
        "problems": "/problems",
        "metrics": "/metrics",
        "health": "/healthz",
        "readiness": "/readyz",
    }))
    .into_response();
    response.headers_mut().insert(VARY, HeaderValue::from_static("accept"));
    Ok(response)
}
