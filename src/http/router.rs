//! Merges the routes of the resources and puts the edge around them.

use std::sync::LazyLock;

use axum::Router;
use axum::response::IntoResponse;
use axum::routing::get;
use bytes::Bytes;
use http::HeaderMap;
use http::header::CONTENT_TYPE;
use utoipa_swagger_ui::{Config, SwaggerUi};

use super::negotiate::choose;
use super::observation::Operations;
use super::problem::Problem;
use super::routes::{described, document};
use super::{AppState, edge};

/// Other pages of the service, with ids of their own.
const PAGES: [(&str, &str, &str); 4] = [
    ("GET", "/openapi.json", "get_openapi"),
    ("GET", "/docs", "get_docs"),
    ("GET", "/docs/", "get_docs"),
    ("GET", "/docs/{*rest}", "get_docs"),
];

/// The description as text, made at the first request: a start spends neither time nor memory on it.
static DESCRIPTION: LazyLock<Bytes> = LazyLock::new(|| document().to_string().into());

/// The whole service.
pub fn router(app: AppState) -> Router {
    let routes = described();
    app.serve_operations(|| Operations::new(routes.operations().chain(PAGES)));
    let served = |headers: HeaderMap| async move {
        choose(&headers, &["application/json"])?;
        Ok::<_, Problem>(([(CONTENT_TYPE, "application/json")], DESCRIPTION.clone()).into_response())
    };
    // Without this setting the page sends its document to a validator on the internet.
    let docs = SwaggerUi::new("/docs").config(Config::new(["/openapi.json"]).validator_url("none"));
    behind_the_edge(routes.into_router().route("/openapi.json", get(served)).merge(docs), app)
}

/// These routes, with all steps that a request passes on its way to a handler.
pub fn behind_the_edge(router: Router<AppState>, app: AppState) -> Router {
    router
        .fallback(edge::not_found)
        .method_not_allowed_fallback(edge::method_not_allowed)
        .layer(edge::EdgeLayer(app.clone()))
        .with_state(app)
}
