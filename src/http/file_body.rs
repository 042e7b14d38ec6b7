//! A file as the body of an answer.
//!
//! An answer in a file was written a moment ago, so the system still has it in memory. Such bytes are copied at once,
//! on the thread that sends them: handing every piece to a thread that may wait costs more than the copy. The system is
//! asked not to wait for the disk. If it would have to, a thread that may wait reads the piece.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use axum::body::HttpBody;
use bytes::{Bytes, BytesMut};
use hyper::body::Frame;
use tokio::task::JoinHandle;

/// Bytes read from a file at a time.
pub(super) const CHUNK: usize = 32 << 10;

/// The content of a file, from its beginning.
#[derive(Debug)]
pub(super) struct FileBody {
    file: Arc<File>,
    /// Bytes that were read.
    at: u64,
    /// The piece that a waiting thread reads.
    waiting: Option<JoinHandle<io::Result<Bytes>>>,
}

impl FileBody {
    pub(super) fn new(file: File) -> Self {
        Self { file: Arc::new(file), at: 0, waiting: None }
    }

    /// The next piece, empty at the end of the file.
    fn next(&mut self, context: &mut Context<'_>) -> Poll<io::Result<Bytes>> {
        if self.waiting.is_none() {
            if let Some(piece) = without_waiting(&self.file, self.at) {
                return Poll::Ready(Ok(piece));
            }
            let (file, at) = (Arc::clone(&self.file), self.at);
            self.waiting = Some(tokio::task::spawn_blocking(move || read(&file, at)));
        }
        let Some(waiting) = &mut self.waiting else { return Poll::Ready(Ok(Bytes::new())) };
        let piece = ready!(Pin::new(waiting).poll(context));
        self.waiting = None;
        Poll::Ready(piece.unwrap_or_else(|panicked| Err(io::Error::other(panicked))))
    }
}

/// A piece that the system has in memory; `None` if it has to be waited for.
#[cfg(target_os = "linux")]
fn without_waiting(file: &File, at: u64) -> Option<Bytes> {
    use rustix::io::{ReadWriteFlags, preadv2};
    let mut piece = BytesMut::zeroed(CHUNK);
    let length = preadv2(file, &mut [io::IoSliceMut::new(&mut piece)], at, ReadWriteFlags::NOWAIT).ok()?;
    piece.truncate(length);
    Some(piece.freeze())
}

/// Other systems cannot be asked not to wait.
#[cfg(not(target_os = "linux"))]
fn without_waiting(_file: &File, _at: u64) -> Option<Bytes> {
    None
}

fn read(file: &File, at: u64) -> io::Result<Bytes> {
    let mut piece = BytesMut::zeroed(CHUNK);
    let length = file.read_at(&mut piece, at)?;
    piece.truncate(length);
    Ok(piece.freeze())
}

impl HttpBody for FileBody {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, io::Error>>> {
        let piece = ready!(self.next(context));
        Poll::Ready(match piece {
            Ok(piece) if piece.is_empty() => None,
            Ok(piece) => {
                self.at += piece.len() as u64;
                Some(Ok(Frame::data(piece)))
            }
            Err(fault) => Some(Err(fault)),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use http_body_util::BodyExt;

    use super::*;

    #[tokio::test]
    async fn all_bytes_come_in_order_with_and_without_waiting() {
        let content: Vec<u8> = (0..=250).cycle().take(3 * CHUNK + 17).collect();
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&content).unwrap();
        let waited = read(&file, CHUNK as u64).unwrap();
        assert_eq!(waited, content[CHUNK..2 * CHUNK]);
        assert_eq!(read(&file, content.len() as u64).unwrap().len(), 0);
        let body = FileBody::new(file).collect().await.unwrap().to_bytes();
        assert!(body == content);
    }
}
