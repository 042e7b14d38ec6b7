//! The description of the interface, and the pages that show it. They are in the binary, and need nothing from
//! elsewhere.

use axum::Router;
use axum::extract::Path;
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use http::HeaderMap;

use super::AppState;
use super::embedded::{Embedded, embedded};
use super::negotiate::choose;
use super::problem::{Problem, ProblemType};

/// Routes that the description does not contain, with ids of their own.
pub(super) const UNDESCRIBED: [(&str, &str, &str); 4] = [
    ("GET", "/openapi.json", "get_openapi"),
    ("GET", "/docs", "get_docs"),
    ("GET", "/docs/", "get_docs"),
    ("GET", "/docs/{*rest}", "get_docs"),
];

/// The description, as `openapi/tests.rs` compares it with the routes.
static DESCRIPTION: Embedded = embedded!("application/json", "trunnion.json.gz");

const PAGE: &str = include_str!("index.html");
const INITIALIZER: &str = include_str!("swagger-initializer.js");
const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

static FILES: [(&str, Embedded); 6] = [
    ("swagger-ui-bundle.js", embedded!(SCRIPT, "swagger-ui-bundle.js.gz")),
    ("swagger-ui-standalone-preset.js", embedded!(SCRIPT, "swagger-ui-standalone-preset.js.gz")),
    ("swagger-ui.css", embedded!(STYLE, "swagger-ui.css.gz")),
    ("index.css", embedded!(STYLE, "index.css.gz")),
    ("favicon-16x16.png", embedded!("image/png", "favicon-16x16.png.gz")),
    ("favicon-32x32.png", embedded!("image/png", "favicon-32x32.png.gz")),
];

/// The routes of the description and its pages.
pub(super) fn router() -> Router<AppState> {
    Router::new()
        .route("/openapi.json", get(description))
        .route("/docs", get(|| async { Redirect::to("/docs/") }))
        .route("/docs/", get(|| async { text(HTML, PAGE) }))
        .route("/docs/{*rest}", get(file))
}

/// The description as text.
///
/// # Errors
/// The binary is damaged.
pub fn description_text() -> std::io::Result<String> {
    let text = DESCRIPTION.plain()?;
    String::from_utf8(text.into()).map_err(std::io::Error::other)
}

async fn description(headers: HeaderMap) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    Ok(DESCRIPTION.answer(&headers)?)
}

async fn file(Path(name): Path<String>, headers: HeaderMap) -> Result<Response, Problem> {
    match name.as_str() {
        "index.html" => return Ok(text(HTML, PAGE)),
        "swagger-initializer.js" => return Ok(text(SCRIPT, INITIALIZER)),
        _ => {}
    }
    match FILES.iter().find(|(known, _)| *known == name) {
        Some((_, file)) => Ok(file.answer(&headers)?),
        None => Err(Problem::new(ProblemType::NotFound, ProblemType::NotFound.title())),
    }
}

fn text(kind: &'static str, text: &'static str) -> Response {
    ([(http::header::CONTENT_TYPE, kind)], text).into_response()
}
