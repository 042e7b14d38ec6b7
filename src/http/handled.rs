//! The steps of a request on its way to its handler. Each of them may refuse it.

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
use super::guard::{guard, refusal};
use super::host::one_host;
use super::note_refusal::note_refusal;
use super::printed::settled;
use super::problem::{Problem, ProblemType};
use super::rates::Who;
use super::security_log::Reason;
use crate::jobs::asked_by;
use crate::jobs::memory::{Account, paid_by};

// These functions return the future of a block. An async function would keep the request twice, as an argument and as a
// variable, and every step would move that much memory.

/// The answer of the request's handler, if the request may reach it.
#[expect(clippy::manual_async_fn, reason = "its future keeps the request once")]
pub(super) fn handled(app: &AppState, mut request: Request, route: Route) -> impl Future<Output = Response> {
    async move {
        if let Err(problem) = one_host(&request) {
            note_refusal(app, Reason::Host, None, request.method(), request.extensions());
            return problem.into_response();
        }
        if let Err(problem) = chunked_or_plain(&request) {
            return problem.into_response();
        }
        if let Err(refused) = guard(app, &mut request).await {
            // Boxed because it is rare: otherwise its memory would be part of every request's.
            return Box::pin(refusal(app, refused, request)).await;
        }
        let (who, account) = match opened(app, &request) {
            Ok(opened) => opened,
            Err(refusal) => return *refusal,
        };
        let answered = pin!(answered(request, route));
        let Some(account) = account else { return answered.await };
        let response = paid_by(account.clone(), asked_by(who, answered)).await;
        settled(app, account, response).await
    }
}

/// The caller of a request that has passed the guard, and the account that reserves the memory for its work. Requests
/// of monitoring need no account: they are answered whatever memory they need.
///
/// # Errors
/// The answer to a request that must not reach its handler.
fn opened(app: &AppState, request: &Request) -> Result<(Who, Option<Account>), Box<Response>> {
    if let Some(refusal) = admit(app, request) {
        return Err(Box::new(refusal));
    }
    let who = asks(request);
    if is_watching(request.extensions()) {
        return Ok((who, None));
    }
    match app.memory.open(&who) {
        Ok(account) => Ok((who, Some(account))),
        Err(fault) => Err(Box::new(Problem::from(fault).into_response())),
    }
}

/// Passes on a request with its decompressed body.
#[expect(clippy::manual_async_fn, reason = "its future keeps the request once")]
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
