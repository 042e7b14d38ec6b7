//! One request to a receiver: the name is looked up now, the connection goes to a checked address, and only the
//! status of the answer is used. Nothing is kept, followed or taken from the environment.

use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use futures::future::BoxFuture;
use http_body_util::{BodyExt, Full};
use hyper::body::Incoming;
use hyper::client::conn::http1;
use hyper::header::{CONTENT_TYPE, HOST, RETRY_AFTER, USER_AGENT};
use hyper::{Request, StatusCode};
use hyper_util::rt::TokioIo;
use rustls::pki_types::ServerName;
use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_util::task::AbortOnDropHandle;

use super::receivers::{NotAllowed, Receivers};
use super::trust::Trust;
use crate::wire::{CallbackUrl, DeliveryOutcome, Host};

/// Room for the head of an answer \[bytes\]; a longer head is not accepted.
const HEAD_BYTES: usize = 32 << 10;
/// How much of an answer's body is read before the connection is closed \[bytes\].
const HEARD_BYTES: usize = 4 << 10;
/// How long the body is read.
const HEARD_FOR: Duration = Duration::from_secs(1);
/// Most addresses of a name that are tried.
const MOST_ADDRESSES: usize = 4;

/// Looks names up.
pub(super) trait Resolve: Send + Sync + fmt::Debug {
    /// Every address of a name.
    fn resolve<'a>(&'a self, name: &'a str) -> BoxFuture<'a, io::Result<Vec<IpAddr>>>;
}

/// The system's resolver.
#[derive(Debug)]
pub(super) struct SystemNames;

impl Resolve for SystemNames {
    fn resolve<'a>(&'a self, name: &'a str) -> BoxFuture<'a, io::Result<Vec<IpAddr>>> {
        Box::pin(async move {
            Ok(tokio::net::lookup_host((name, 0)).await?.map(|address| address.ip()).collect())
        })
    }
}

/// The message.
#[derive(Debug, Clone)]
pub(super) struct Letter {
    pub(super) id: String,
    pub(super) timestamp_s: i64,
    pub(super) signatures: String,
    pub(super) body: Bytes,
    /// The trace that the job belongs to.
    pub(super) traceparent: Option<String>,
}

/// The result of a call.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answer {
    pub(super) outcome: DeliveryOutcome,
    pub(super) status: Option<u16>,
    pub(super) detail: String,
    /// How long the receiver asks not to be called again \[s\].
    pub(super) retry_after_s: Option<f64>,
}

/// Why there was no answer.
#[derive(Debug, Error)]
pub(super) enum CallFault {
    #[error("the name cannot be looked up")]
    Lookup(#[source] io::Error),
    #[error("the name has no address")]
    NoAddress,
    #[error("{0}")]
    NotAllowed(#[from] NotAllowed),
    #[error("no connection was made: {0}")]
    Connect(#[source] io::Error),
    #[error("TLS: {0}")]
    Tls(#[source] io::Error),
    #[error("the request to the address cannot be built: {0}")]
    Request(#[from] hyper::http::Error),
    #[error("the answer broke off or is not valid: {0}")]
    Http(#[from] hyper::Error),
    #[error("no answer within {timeout_s} s")]
    TimedOut { timeout_s: f64 },
}

impl CallFault {
    fn outcome(&self) -> DeliveryOutcome {
        match self {
            Self::NotAllowed(_) | Self::Request(_) => DeliveryOutcome::AddressRefused,
            Self::Tls(_) => DeliveryOutcome::TlsFailed,
            Self::TimedOut { .. } => DeliveryOutcome::TimedOut,
            Self::Lookup(_) | Self::NoAddress | Self::Connect(_) | Self::Http(_) => {
                DeliveryOutcome::Unreachable
            }
        }
    }
}

/// The way in which receivers are called.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) receivers: Receivers,
    pub(super) names: Arc<dyn Resolve>,
    pub(super) trust: Trust,
    pub(super) timeout: Duration,
}

impl Line {
    /// Sends the message once.
    pub(super) async fn call(&self, url: &CallbackUrl, letter: &Letter) -> Answer {
        let called = tokio::time::timeout(self.timeout, self.exchange(url, letter)).await;
        let timeout_s = self.timeout.as_secs_f64();
        let called = called.unwrap_or_else(|_late| Err(CallFault::TimedOut { timeout_s }));
        match called {
            Ok(heard) => heard.answer().await,
            Err(fault) => Answer {
                outcome: fault.outcome(),
                status: None,
                detail: fault.to_string(),
                retry_after_s: None,
            },
        }
    }

    async fn exchange(&self, url: &CallbackUrl, letter: &Letter) -> Result<Heard, CallFault> {
        let stream = self.connect(url).await?;
        if !url.is_https {
            return send(stream, url, letter).await;
        }
        let client = self.trust.client().await.map_err(|fault| CallFault::Tls(io::Error::other(fault)))?;
        let connector = TlsConnector::from(client);
        let name = match &url.host {
            Host::Name(name) => {
                ServerName::try_from(name.clone()).map_err(|fault| CallFault::Tls(io::Error::other(fault)))?
            }
            Host::Address(address) => ServerName::from(*address),
        };
        let stream = connector.connect(name, stream).await.map_err(CallFault::Tls)?;
        send(stream, url, letter).await
    }

    /// A connection to one of the host's allowed addresses. The name is looked up only here, so that it cannot lead
    /// to another address afterwards.
    async fn connect(&self, url: &CallbackUrl) -> Result<TcpStream, CallFault> {
        let found = match &url.host {
            Host::Address(address) => vec![*address],
            Host::Name(name) => self.names.resolve(name).await.map_err(CallFault::Lookup)?,
        };
        if found.is_empty() {
            return Err(CallFault::NoAddress);
        }
        let mut may = self.receivers.of(&url.host, found);
        may.truncate(MOST_ADDRESSES);
        let mut last = CallFault::NotAllowed(NotAllowed);
        let share = self.timeout.div_f64(may.len().max(1) as f64);
        for address in may {
            let connecting = TcpStream::connect(SocketAddr::new(address, url.port));
            match tokio::time::timeout(share, connecting).await {
                Ok(Ok(stream)) => return Ok(stream),
                Ok(Err(fault)) => last = CallFault::Connect(fault),
                Err(_late) => last = CallFault::TimedOut { timeout_s: share.as_secs_f64() },
            }
        }
        Err(last)
    }
}

/// An answer whose head has arrived.
struct Heard {
    status: StatusCode,
    retry_after_s: Option<f64>,
    body: Incoming,
    _driven: AbortOnDropHandle<Result<(), hyper::Error>>,
}

impl Heard {
    async fn answer(self) -> Answer {
        let Self { status, retry_after_s, mut body, _driven } = self;
        // The rest of the answer is not needed; reading some of it spares the receiver a broken connection.
        let hearing = async {
            let mut heard = 0;
            while let Some(Ok(frame)) = body.frame().await {
                heard += frame.data_ref().map_or(0, Bytes::len);
                if heard >= HEARD_BYTES {
                    break;
                }
            }
        };
        let _ended_or_enough = tokio::time::timeout(HEARD_FOR, hearing).await;
        let outcome = match status {
            StatusCode::GONE => DeliveryOutcome::Gone,
            status if status.is_success() => DeliveryOutcome::Delivered,
            _ => DeliveryOutcome::Refused,
        };
        let also = if status.is_redirection() { ", and redirections are not followed" } else { "" };
        let detail = format!("the receiver answered {}{also}", status.as_u16());
        Answer { outcome, status: Some(status.as_u16()), detail, retry_after_s }
    }
}

async fn send<S>(stream: S, url: &CallbackUrl, letter: &Letter) -> Result<Heard, CallFault>
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let mut request = Request::post(&url.path_and_query)
        .header(HOST, &url.authority)
        .header(USER_AGENT, concat!("trunnion/", env!("CARGO_PKG_VERSION")))
        .header(CONTENT_TYPE, "application/json")
        .header("webhook-id", &letter.id)
        .header("webhook-timestamp", letter.timestamp_s)
        .header("webhook-signature", &letter.signatures);
    if let Some(traceparent) = &letter.traceparent {
        request = request.header("traceparent", traceparent);
    }
    let request = request.body(Full::new(letter.body.clone()))?;
    let (mut sender, connection) =
        http1::Builder::new().max_buf_size(HEAD_BYTES).handshake(TokioIo::new(stream)).await?;
    let driven = AbortOnDropHandle::new(tokio::spawn(connection));
    let response = sender.send_request(request).await?;
    let (head, body) = response.into_parts();
    let asked =
        head.headers.get(RETRY_AFTER).and_then(|value| value.to_str().ok()?.trim().parse::<u32>().ok());
    Ok(Heard { status: head.status, retry_after_s: asked.map(f64::from), body, _driven: driven })
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::TcpListener;

    use super::*;

    /// Names that lead elsewhere each time they are looked up.
    #[derive(Debug)]
    struct Rebinding(Mutex<Vec<Vec<IpAddr>>>);

    impl Resolve for Rebinding {
        fn resolve<'a>(&'a self, _name: &'a str) -> BoxFuture<'a, io::Result<Vec<IpAddr>>> {
            let next = self.0.lock().unwrap().pop();
            Box::pin(async move { next.ok_or_else(|| io::Error::other("looked up too often")) })
        }
    }

    fn line(allowed: &[&str], found: &[&[&str]]) -> Line {
        let parsed = |all: &[&str]| all.iter().map(|text| text.parse().unwrap()).collect();
        Line {
            receivers: Receivers::new(allowed.iter().map(|text| text.parse().unwrap()).collect()),
            names: Arc::new(Rebinding(Mutex::new(found.iter().rev().map(|all| parsed(all)).collect()))),
            trust: Trust::default(),
            timeout: Duration::from_secs(20),
        }
    }

    fn letter() -> Letter {
        Letter {
            id: "msg_1".to_owned(),
            timestamp_s: 1,
            signatures: "v1,x".to_owned(),
            body: Bytes::from_static(b"{}"),
            traceparent: None,
        }
    }

    /// Answers one request with 200, and gives what it was asked.
    async fn answering(listener: TcpListener) -> String {
        let (mut stream, _) = listener.accept().await.unwrap();
        let mut text = Vec::new();
        while !text.ends_with(b"\r\n\r\n{}") {
            assert!(stream.read_buf(&mut text).await.unwrap() > 0);
        }
        stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n").await.unwrap();
        String::from_utf8(text).unwrap()
    }

    #[tokio::test]
    async fn a_name_is_called_only_at_addresses_that_were_looked_at() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url: CallbackUrl =
            format!("http://mes.example.com:{}/x", listener.local_addr().unwrap().port()).parse().unwrap();
        let (heard, ()) = tokio::join!(answering(listener), async {
            // Private, and not allowed: nothing is connected to.
            for found in ["127.0.0.1", "10.0.0.1", "169.254.169.254", "::1", "::ffff:127.0.0.1"] {
                let answer = line(&[], &[&[found]]).call(&url, &letter()).await;
                assert_eq!(answer.outcome, DeliveryOutcome::AddressRefused, "{found}");
                assert!(!answer.detail.contains(found), "{}", answer.detail);
            }
            // Of several only what is allowed, and the name is looked up once for each attempt.
            let mixed = line(&["127.0.0.1"], &[&["169.254.169.254", "127.0.0.1"], &["169.254.169.254"]]);
            let answer = mixed.call(&url, &letter()).await;
            assert_eq!((answer.outcome, answer.status), (DeliveryOutcome::Delivered, Some(200)));
            assert_eq!(mixed.call(&url, &letter()).await.outcome, DeliveryOutcome::AddressRefused);
            assert_eq!(mixed.call(&url, &letter()).await.outcome, DeliveryOutcome::Unreachable);
        });
        assert!(heard.starts_with("POST /x HTTP/1.1\r\nhost: mes.example.com:"), "{heard}");
    }

    #[tokio::test]
    async fn a_name_without_an_address_is_nowhere() {
        let url = "https://mes.example.com/".parse().unwrap();
        let answer = line(&[], &[&[]]).call(&url, &letter()).await;
        assert_eq!(answer.outcome, DeliveryOutcome::Unreachable);
    }
}
