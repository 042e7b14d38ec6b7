//! Merges the routes of the resources and puts the edge around them.

use axum::Router;

use super::observation::Operations;
use super::routes::routes;
use super::{AppState, docs, edge, page};

/// The whole service.
pub fn router(app: AppState) -> Router {
    let routes = routes();
    app.serve_operations(|| {
        Operations::new(routes.operations().chain(docs::UNDESCRIBED).chain(page::UNDESCRIBED))
    });
    behind_the_edge(routes.into_router().merge(docs::router()).merge(page::router()), app)
}

/// These routes, with all steps that a request passes on its way to a handler.
pub fn behind_the_edge(router: Router<AppState>, app: AppState) -> Router {
    router
        .fallback(edge::not_found)
        .method_not_allowed_fallback(edge::method_not_allowed)
        .layer(edge::EdgeLayer(app.clone()))
        .with_state(app)
}
