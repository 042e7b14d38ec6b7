//! Requests that this process sends to its own service, without a connection. They pass everything that the requests
//! of a client pass.

use axum::Router;
use axum::body::{Body, to_bytes};
use bytes::Bytes;
use http::{Request, StatusCode};
use tower::ServiceExt;

use super::{AppState, router};

/// The service, as a function from requests to answers.
#[derive(Debug, Clone)]
pub struct InProcess(Router);

/// Longest answer that is read \[bytes\].
const LONGEST: usize = 1 << 24;

impl InProcess {
    /// The service with this state.
    #[must_use]
    pub fn of(app: AppState) -> Self {
        Self(router(app))
    }

    /// The status and the body of an answer.
    ///
    /// # Errors
    /// The body is longer than 16 MiB, or its sender failed.
    pub async fn answer(&self, request: Request<String>) -> std::io::Result<(StatusCode, Bytes)> {
        let answered = self.0.clone().oneshot(request.map(Body::from)).await;
        let response = match answered {
            Ok(response) => response,
            Err(never) => match never {},
        };
        let status = response.status();
        let body = to_bytes(response.into_body(), LONGEST).await.map_err(std::io::Error::other)?;
        Ok((status, body))
    }
}
