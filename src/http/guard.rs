//! Asks every request who sends it.

use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::Response;

use super::AppState;
use super::caller::Caller;

/// Lets in whom it knows.
pub(super) async fn guard(State(_app): State<AppState>, mut request: Request, next: Next) -> Response {
    request.extensions_mut().insert(Caller::anybody());
    next.run(request).await
}
