//! A digest that a second thread computes while the caller reads and writes. The digest of a file takes about as long
//! as its copy. The price is a thread and a few pieces of memory. A test compares it with the plain digest.

use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{Builder, JoinHandle};

use sha2::{Digest, Sha256};

/// The length of a piece \[bytes\].
pub(super) const PIECE_BYTES: usize = 1 << 18;
/// Pieces of memory that go round: one is filled, one is in the digest, and one waits between the two.
const PIECES: usize = 3;

/// A digest under way.
pub(super) struct DigestBeside {
    full: Sender<Vec<u8>>,
    spare: Receiver<Vec<u8>>,
    thread: JoinHandle<Sha256>,
}

impl DigestBeside {
    /// Goes on with this digest on a second thread.
    ///
    /// # Errors
    /// No thread can be started.
    pub(super) fn begin(mut digest: Sha256) -> io::Result<Self> {
        let (full, arriving) = channel::<Vec<u8>>();
        let (done, spare) = channel();
        for _ in 1..PIECES {
            done.send(Vec::with_capacity(PIECE_BYTES)).map_err(|_ended| lost())?;
        }
        let thread = Builder::new().name("digest".to_owned()).spawn(move || {
            for mut piece in arriving {
                digest.update(&piece);
                piece.clear();
                // After its last piece, the caller takes none back.
                let _taken = done.send(piece);
            }
            digest
        })?;
        Ok(Self { full, spare, thread })
    }

    /// Takes the next piece, and gives back an empty one.
    ///
    /// # Errors
    /// The thread has ended early.
    pub(super) fn take(&self, piece: Vec<u8>) -> io::Result<Vec<u8>> {
        self.full.send(piece).map_err(|_ended| lost())?;
        self.spare.recv().map_err(|_ended| lost())
    }

    /// The digest of all pieces.
    ///
    /// # Errors
    /// The thread has panicked.
    pub(super) fn end(self) -> io::Result<Sha256> {
        drop(self.full);
        self.thread.join().map_err(|_ended| lost())
    }
}

fn lost() -> io::Error {
    io::Error::other("the digest was lost")
}
