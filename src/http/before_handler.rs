//! The checks before a handler, in this order: host, framing, key, length and rate, memory, coding of the body. Each may
//! refuse the request. The caller is known after the check of the key.

use std::pin::pin;

use axum::extract::Request;
use axum::response::{IntoResponse, Response};
use axum::routing::Route;
use http::HeaderValue;
use http::header::{ACCEPT_ENCODING, CONTENT_ENCODING};
use tower::Service;

use super::AppState;
use super::admission::{admit, asks, is_watching};
use super::coding::{TAKEN, coding, unpacked};
use super::framing::chunked_or_plain;
use super::guard::{answer_refused, guard};
use super::host::one_host;
use super::note_refusal::note_refusal;
use super::printed::settled;
use super::problem::{Problem, ProblemType};
use super::security_log::Reason;
use crate::jobs::asked_by;
use crate::jobs::memory::paid_by;

// Some functions here return an `async` block. An async function would store the request twice, as an argument and as a
// variable, and every step would copy both.

/// The answer of the request's handler, or the refusal of the request.
#[expect(clippy::manual_async_fn, reason = "an async function would store the request twice")]
pub(super) fn checked_and_handled(
    app: &AppState,
    mut request: Request,
    route: Route,
) -> impl Future<Output = Response> {
    async move {
        if let Err(problem) = one_host(&request) {
            note_refusal(app, Reason::Host, None, request.method(), request.extensions());
            return problem.into_response();
        }
        if let Err(problem) = chunked_or_plain(&request) {
            return problem.into_response();
        }
        if let Err(refused) = guard(app, &mut request).await {
            // Boxed: a refusal is rare, and otherwise every request would have the memory for it.
            return Box::pin(answer_refused(app, refused, request)).await;
        }
        if let Some(refusal) = admit(app, &request) {
            return refusal;
        }
        let who = asks(&request);
        // Monitoring requests are answered whatever memory they need.
        let account = (!is_watching(request.extensions())).then(|| app.memory.open(&who)).transpose();
        let account = match account {
            Ok(account) => account,
            Err(fault) => return Problem::from(fault).into_response(),
        };
        // Pinned, so that the futures around it hold only a pointer. Code that runs while it is dropped must not need the
        // account or the caller.
        let answered = pin!(answered(request, route));
        let Some(account) = account else { return answered.await };
        let response = paid_by(account.clone(), asked_by(who, answered)).await;
        settled(app, account, response).await
    }
}

/// Decompresses the body, and calls the handler.
#[expect(clippy::manual_async_fn, reason = "an async function would store the request twice")]
fn answered(request: Request, mut route: Route) -> impl Future<Output = Response> {
    async move {
        let called = if request.headers().contains_key(CONTENT_ENCODING) {
            match plain(request) {
                Ok(request) => route.call(request),
                Err(refusal) => return *refusal,
            }
        } else {
            route.call(request)
        };
        called.await.unwrap_or_else(|fault| match fault {})
    }
}

/// The request with its decompressed body.
fn plain(request: Request) -> Result<Request, Box<Response>> {
    if let Some(coding) = coding(request.headers()) {
        return unpacked(request, coding).map_err(|fault| Box::new(Problem::from(fault).into_response()));
    }
    let detail = "use one content coding for a body: gzip or zstd";
    let mut refusal = Problem::new(ProblemType::UnsupportedMediaType, detail).into_response();
    refusal.headers_mut().insert(ACCEPT_ENCODING, HeaderValue::from_static(TAKEN));
    Err(Box::new(refusal))
}
