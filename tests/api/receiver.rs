//! A receiver of webhooks: says what it is told to say, and hands over what it was sent.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hmac::{Hmac, KeyInit, Mac};
use serde_json::Value;
use sha2::Sha256;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};
use tokio::task::JoinHandle;
use tokio_rustls::TlsAcceptor;

/// What a receiver says to one request.
#[derive(Debug, Clone)]
pub(crate) enum Reply {
    /// A status with these lines of a header.
    Status(u16, &'static str),
    /// Nothing, for ever.
    Silence,
    /// Closes the connection.
    Hangup,
    /// 200, then a body without an end.
    Flood,
    /// 200, then a body that never comes.
    Stall,
    /// A head without an end.
    LongHead,
}

/// What a receiver was sent.
#[derive(Debug, Clone)]
pub(crate) struct Received {
    pub(crate) line: String,
    pub(crate) headers: HashMap<String, String>,
    pub(crate) body: Vec<u8>,
}

impl Received {
    pub(crate) fn id(&self) -> &str {
        &self.headers["webhook-id"]
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    pub(crate) fn signatures(&self) -> Vec<&str> {
        self.headers["webhook-signature"].split(' ').collect()
    }

    /// The signature that this secret makes, by code that the service does not use.
    pub(crate) fn signed_by(&self, secret: &str) -> String {
        let key = STANDARD.decode(secret.strip_prefix("whsec_").unwrap()).unwrap();
        let mut mac = Hmac::<Sha256>::new_from_slice(&key).unwrap();
        mac.update(format!("{}.{}.", self.id(), self.headers["webhook-timestamp"]).as_bytes());
        mac.update(&self.body);
        format!("v1,{}", STANDARD.encode(mac.finalize().into_bytes()))
    }
}

/// A receiver on this computer.
pub(crate) struct Receiver {
    pub(crate) port: u16,
    received: UnboundedReceiver<Received>,
    task: JoinHandle<()>,
}

impl Drop for Receiver {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Receiver {
    /// Says these things one after the other, and 204 from then on.
    pub(crate) async fn saying(replies: &[Reply]) -> Self {
        Self::listening(TcpListener::bind("127.0.0.1:0").await.unwrap(), replies, None)
    }

    pub(crate) fn listening(listener: TcpListener, replies: &[Reply], tls: Option<TlsAcceptor>) -> Self {
        let port = listener.local_addr().unwrap().port();
        let (sender, received) = unbounded_channel();
        let replies = Arc::new(Mutex::new(VecDeque::from(replies.to_vec())));
        let task = tokio::spawn(async move {
            // They go with this task.
            let mut open = tokio::task::JoinSet::new();
            while let Ok((stream, _)) = listener.accept().await {
                let (sender, replies, tls) = (sender.clone(), Arc::clone(&replies), tls.clone());
                open.spawn(async move {
                    let next = move |received| {
                        let _test_is_over = sender.send(received);
                        replies.lock().unwrap().pop_front().unwrap_or(Reply::Status(204, ""))
                    };
                    match tls {
                        None => serve(stream, next).await,
                        Some(tls) => {
                            if let Ok(stream) = tls.accept(stream).await {
                                serve(stream, next).await;
                            }
                        }
                    }
                });
            }
        });
        Self { port, received, task }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/trunnion?line=4", self.port)
    }

    pub(crate) async fn next(&mut self) -> Received {
        self.received.recv().await.unwrap()
    }

    /// Whether nothing has come that was not looked at.
    pub(crate) fn is_quiet(&mut self) -> bool {
        self.received.try_recv().is_err()
    }
}

/// How a client of TLS begins.
const TLS_HANDSHAKE: [u8; 2] = [22, 3];

/// Takes one request in plain text. A client that begins TLS gets the status 400.
async fn serve(mut stream: impl AsyncRead + AsyncWrite + Unpin, next: impl Fn(Received) -> Reply) {
    let mut text = Vec::new();
    let end = loop {
        if let Some(end) = text.windows(4).position(|part| part == b"\r\n\r\n") {
            break end;
        }
        if stream.read_buf(&mut text).await.unwrap_or(0) == 0 {
            return;
        }
        if text.starts_with(&TLS_HANDSHAKE) {
            let _broken = speak(&mut stream, Reply::Status(400, "")).await;
            return;
        }
    };
    let head = String::from_utf8(text[..end].to_vec()).unwrap();
    let mut lines = head.split("\r\n");
    let line = lines.next().unwrap().to_owned();
    let pair = |line: &str| {
        line.split_once(": ").map(|(name, value)| (name.to_ascii_lowercase(), value.to_owned())).unwrap()
    };
    let headers: HashMap<String, String> = lines.map(pair).collect();
    let length: usize = headers["content-length"].parse().unwrap();
    let mut body = text[end + 4..].to_vec();
    while body.len() < length {
        stream.read_buf(&mut body).await.unwrap();
    }
    let reply = next(Received { line, headers, body });
    // The other side may have had enough.
    let _broken = speak(&mut stream, reply).await;
}

async fn speak(stream: &mut (impl AsyncRead + AsyncWrite + Unpin), reply: Reply) -> std::io::Result<()> {
    match reply {
        Reply::Status(status, lines) => {
            let text = format!("HTTP/1.1 {status} Said\r\ncontent-length: 0\r\n{lines}\r\n");
            stream.write_all(text.as_bytes()).await?;
            stream.shutdown().await
        }
        Reply::Silence => {
            // Until the other side goes.
            stream.read_buf(&mut Vec::new()).await.map(|_end| ())
        }
        Reply::Hangup => Ok(()),
        Reply::Flood => {
            stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 1000000000000\r\n\r\n").await?;
            loop {
                stream.write_all(&[b'x'; 1 << 13]).await?;
            }
        }
        Reply::Stall => {
            stream.write_all(b"HTTP/1.1 200 OK\r\ncontent-length: 10\r\n\r\n").await?;
            stream.read_buf(&mut Vec::new()).await.map(|_end| ())
        }
        Reply::LongHead => {
            stream.write_all(b"HTTP/1.1 200 OK\r\n").await?;
            loop {
                stream.write_all(b"x-more: and more and more and more and more and more\r\n").await?;
            }
        }
    }
}

/// A port of this computer that nobody listens on.
pub(crate) async fn silent_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    listener.local_addr().unwrap().port()
}

/// Whether anything can be connected to there.
pub(crate) async fn connects(port: u16) -> bool {
    TcpStream::connect(("127.0.0.1", port)).await.is_ok()
}

#[test]
fn the_test_signs_as_the_standard_does() {
    let headers = [("webhook-id", "msg_27UH4WbU6Z5A5EzD8u03UvzRbpk"), ("webhook-timestamp", "1649367553")];
    let received = Received {
        line: String::new(),
        headers: headers.map(|(name, value)| (name.to_owned(), value.to_owned())).into(),
        body: br#"{"email":"test@example.com","username":"test_user"}"#.to_vec(),
    };
    let signature = received.signed_by("whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oD");
    assert_eq!(signature, "v1,tZ1I4/hDygAJgO5TYxiSd6Sd0kDW6hPenDe+bTa3Kkw=");
}
