//! Stored files on their way to a client. No complete answer leaves with bytes that differ from its digest.
//!
//! A short file, and a file that is requested in part, are verified before the first byte is sent; a damaged file
//! gives a problem document. A long file is hashed while it is sent. Its last part is held back until the digest is
//! confirmed. If the digest is wrong, the answer breaks off. Every client notices that, because the length was
//! announced.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use axum::body::Body;
use bytes::Bytes;
use futures::stream::{self, Stream};
use http::HeaderMap;

use super::problem::Problem;
use super::range::{Asked, asked};
use crate::store::{
    BlobFault, Blobs, Damage, DamagedFile, FileState, SoundFile, StorageFault, StoredThing, Verifying,
};

/// Longest file that is verified before its first byte is sent \[bytes\]: it is held in memory completely.
const SHORT_BYTES: u64 = 1 << 20;
/// Bytes read from a longer file at a time.
const PART_BYTES: u64 = 256 << 10;

/// A stored file as the body of an answer.
#[derive(Debug)]
pub(super) struct StoredBody {
    /// The requested bytes.
    pub(super) body: Body,
    /// Which bytes these are.
    pub(super) asked: Asked,
    /// Length of the whole file \[bytes\].
    pub(super) length: u64,
}

/// Opens a stored file and begins to send the part that `headers` ask for.
pub(super) async fn stored_body(
    blobs: &Blobs,
    sha256: &str,
    headers: &HeaderMap,
) -> Result<StoredBody, Problem> {
    let (blobs, sha256, headers) = (blobs.clone(), sha256.to_owned(), headers.clone());
    let opened = tokio::task::spawn_blocking(move || open(blobs, &sha256, &headers));
    opened.await.map_err(|fault| Problem::internal(&fault))?
}

fn open(blobs: Blobs, sha256: &str, headers: &HeaderMap) -> Result<StoredBody, Problem> {
    let mut file = blobs.read(sha256)?;
    let length = file.metadata()?.len();
    let asked = asked(headers, length, sha256);
    let (checked, part) = match &asked {
        Asked::Outside => return Ok(StoredBody { body: Body::empty(), asked, length }),
        Asked::Whole if length <= SHORT_BYTES => {
            let mut bytes = Vec::new();
            // One byte more than expected is enough to see that the file has grown.
            file.take(length + 1).read_to_end(&mut bytes)?;
            let mut verifying = Verifying::new(sha256);
            verifying.take(&bytes);
            verifying.finish().map_err(|damaged| BlobFault::from(blobs.noted(damaged)))?;
            blobs.soundness().sound(sha256);
            return Ok(StoredBody { body: Body::from(bytes), asked, length });
        }
        Asked::Whole => (Checked::AsItGoes(Verifying::new(sha256)), 0..length),
        Asked::Part(part) => {
            let SoundFile { file: sound, state, .. } = blobs.read_sound(sha256)?;
            file = sound;
            file.seek(SeekFrom::Start(part.start))?;
            (Checked::Before { sha256: sha256.to_owned(), state }, part.clone())
        }
    };
    let sending = Sending { file, left: part.end - part.start, checked, blobs };
    Ok(StoredBody { body: Body::from_stream(parts(sending)), asked, length })
}

/// How the bytes are verified against the digest.
#[derive(Debug)]
enum Checked {
    /// While they are sent.
    AsItGoes(Verifying),
    /// They were verified when the file was in this state.
    Before { sha256: String, state: FileState },
}

/// A file that is being sent.
#[derive(Debug)]
struct Sending {
    file: File,
    /// Bytes that are still to be read.
    left: u64,
    checked: Checked,
    blobs: Blobs,
}

impl Sending {
    /// The next part; the last part only if everything is as it was stored. Blocks the thread.
    fn next(mut self) -> io::Result<(Bytes, Option<Self>)> {
        let mut part = Vec::new();
        (&mut self.file).take(self.left.min(PART_BYTES)).read_to_end(&mut part)?;
        self.left -= part.len() as u64;
        if let Checked::AsItGoes(verifying) = &mut self.checked {
            verifying.take(&part);
        }
        // A file that has become shorter ends here too.
        if self.left > 0 && !part.is_empty() {
            return Ok((Bytes::from(part), Some(self)));
        }
        let Self { file, checked, blobs, .. } = self;
        let verified = match checked {
            Checked::AsItGoes(verifying) => {
                let sha256 = verifying.expected().to_owned();
                verifying.finish().inspect(|()| blobs.soundness().sound(&sha256))
            }
            Checked::Before { state, sha256 } if FileState::of(&file)? != state => {
                Err(DamagedFile { what: StoredThing::File, sha256, damage: Damage::WrittenTo })
            }
            Checked::Before { .. } => Ok(()),
        };
        verified.map_err(|damaged| io::Error::other(blobs.noted(damaged)))?;
        Ok((Bytes::from(part), None))
    }
}

/// The parts of a file. One part is always held back, so that the last one leaves only after the digest has agreed.
fn parts(sending: Sending) -> impl Stream<Item = io::Result<Bytes>> {
    stream::try_unfold(Some(sending), |sending| async move {
        let Some(sending) = sending else { return Ok(None) };
        let read = tokio::task::spawn_blocking(move || sending.next()).await.map_err(io::Error::other)?;
        read.map(Some).inspect_err(|fault| {
            let storage = StorageFault::of(fault).map(|storage| storage.to_string());
            tracing::error!(error = %fault, storage, "an answer broke off");
        })
    })
}
