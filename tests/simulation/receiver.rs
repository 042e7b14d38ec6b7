//! A receiver of webhooks on this computer: takes what it is sent, and loses or doubles its answers as the seed
//! decides.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio::task::JoinHandle;

use crate::chance::Chance;
use crate::recorder;

/// Who has been heard waits here until the scheduler lets the receiver answer.
#[derive(Debug, Default)]
pub(crate) struct Turns {
    heard: AtomicUsize,
    allowed: Notify,
}

impl Turns {
    /// Lets the receiver answer, if it has heard somebody.
    pub(crate) fn let_answer(&self) -> bool {
        let somebody = self.heard.load(Ordering::SeqCst) > 0;
        if somebody {
            self.heard.store(0, Ordering::SeqCst);
            self.allowed.notify_one();
        }
        somebody
    }
}

/// It listens as long as it is there.
#[derive(Debug)]
pub(crate) struct Receiver {
    task: JoinHandle<()>,
    pub(crate) turns: Arc<Turns>,
}

impl Drop for Receiver {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Receiver {
    pub(crate) async fn listen(seed: u64) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        recorder::receive_at(listener.local_addr().unwrap().port());
        let (mut chance, turns) = (Chance::of(seed, 3), Arc::<Turns>::default());
        let turn = Arc::clone(&turns);
        let task = tokio::spawn(async move {
            while let Ok((mut stream, _)) = listener.accept().await {
                if !hears(&mut stream).await {
                    continue;
                }
                turn.heard.fetch_add(1, Ordering::SeqCst);
                turn.allowed.notified().await;
                let said = match chance.below(6) {
                    // Taken, and the answer lost: it is sent once more.
                    0 => "",
                    1 => "HTTP/1.1 503 Service Unavailable\r\ncontent-length: 0\r\n\r\n",
                    // An answer that comes twice.
                    2 => "HTTP/1.1 204 No Content\r\n\r\nHTTP/1.1 204 No Content\r\n\r\n",
                    _ => "HTTP/1.1 204 No Content\r\n\r\n",
                };
                // Who has left hears nothing.
                let _said = stream.write_all(said.as_bytes()).await;
                let _ended = stream.shutdown().await;
            }
        });
        Self { task, turns }
    }
}

/// Hears a whole request, unless it breaks off.
async fn hears(stream: &mut TcpStream) -> bool {
    let (mut heard, mut part) = (Vec::new(), [0; 4096]);
    while !is_whole(&heard) {
        match stream.read(&mut part).await {
            Ok(count) if count > 0 => heard.extend_from_slice(&part[..count]),
            _ => return false,
        }
    }
    true
}

fn is_whole(heard: &[u8]) -> bool {
    let text = String::from_utf8_lossy(heard);
    let Some((head, body)) = text.split_once("\r\n\r\n") else { return false };
    let length = head.lines().find_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("content-length").then(|| value.trim().parse::<usize>().ok())?
    });
    body.len() >= length.unwrap_or(0)
}
