//! Content codings (RFC 9110 §8.4): decompresses bodies. All members of a gzip body and all frames of a zstd body are
//! read, and bytes that are not a member are refused: half a program would be a valid program too.

mod gzip;
mod zstd;

use std::error::Error;
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use axum::body::{Body, HttpBody};
use axum::extract::Request;
use bytes::Bytes;
use http::HeaderMap;
use http::header::{CONTENT_ENCODING, CONTENT_LENGTH};
use hyper::body::Frame;
use thiserror::Error;

use super::problem::{Problem, ProblemType};
use crate::jobs::memory::{self, Lease, MemoryFault};
use gzip::Gzip;
use zstd::Zstd;

/// Largest number of bytes that one compressed byte may unpack to. Real programs reach 18 with zstd and 12 with gzip;
/// a raster of even steps reaches 94 and 18. A body of one repeated line reaches 1000 with gzip and 11 000 with zstd.
const MAX_RATIO: u64 = 250;
/// A body may always unpack to this many bytes, whatever its ratio \[bytes\].
const FREE_BYTES: u64 = 1 << 20;
/// Compressed bytes that may unpack to nothing, in addition to an eighth of the unpacked length: headers, empty
/// members, skipped frames \[bytes\].
const MAX_IDLE_BYTES: u64 = 1 << 20;
/// Bytes unpacked at a time.
const ROOM: usize = 32 * 1024;

/// Why a body cannot be decompressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub(super) enum CodingFault {
    /// Bytes at the place of a member that do not begin a member.
    #[error("the compressed body has bytes that do not belong to its coding, at its start or after a member")]
    NoMember,
    /// The deflated or compressed bytes cannot be read.
    #[error("the compressed body is damaged")]
    Damaged,
    /// A checksum or a length is wrong.
    #[error("the compressed body is damaged: a checksum or a length does not match the unpacked bytes")]
    WrongCheck,
    /// The last member is incomplete.
    #[error("the compressed body ends within a member; a part of it is missing")]
    Cut,
    /// A frame needs more memory than the coding allows over HTTP.
    #[error(
        "a zstd frame needs a window of more than 8 MiB, which is the limit; compress without --long and --ultra"
    )]
    WideWindow,
    /// Too much of the compressed body unpacks to nothing.
    #[error(
        "{given} compressed bytes unpack to only {made} bytes; send fewer empty members, skipped frames and header fields"
    )]
    Idle {
        /// Compressed bytes.
        given: u64,
        /// Bytes that they unpacked to.
        made: u64,
    },
    /// The body unpacks to too much.
    #[error(
        "{given} compressed bytes unpack to more than {made} bytes; a body over {FREE_BYTES} bytes may have at most {MAX_RATIO} \
         times its compressed length; send it without compression, or in parts"
    )]
    Ratio {
        /// Compressed bytes.
        given: u64,
        /// Bytes that they have unpacked to so far.
        made: u64,
    },
    /// The decoder could not be created.
    #[error("there is no memory for a decoder; retry later")]
    NoDecoder,
    /// The budget has no memory for the decoder's window.
    #[error(transparent)]
    Memory(#[from] MemoryFault),
}

impl From<CodingFault> for Problem {
    fn from(fault: CodingFault) -> Self {
        let kind = match fault {
            CodingFault::Ratio { .. } => ProblemType::BodyTooLarge,
            CodingFault::NoDecoder => ProblemType::Busy,
            CodingFault::Memory(fault) => return fault.into(),
            _ => ProblemType::MalformedRequest,
        };
        Self::new(kind, fault.to_string())
    }
}

impl CodingFault {
    /// The fault that caused another one, at any depth.
    pub(super) fn within<'a>(fault: &'a (dyn Error + 'static)) -> Option<&'a Self> {
        let mut fault = Some(fault);
        while let Some(this) = fault {
            if let Some(found) = this.downcast_ref() {
                return Some(found);
            }
            fault = this.source();
        }
        None
    }
}

/// A supported coding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    /// No coding.
    Identity,
    /// gzip, also called x-gzip.
    Gzip,
    /// zstd.
    Zstd,
}

/// The coding of a body; `None` if it is not supported.
pub(super) fn coding(headers: &HeaderMap) -> Option<Coding> {
    let mut values = headers.get_all(CONTENT_ENCODING).iter();
    let (first, None) = (values.next()?, values.next()) else { return None };
    let given = first.to_str().ok()?.trim();
    // Names are case-insensitive, and one coding has two names (RFC 9110 §8.4.1).
    let known = [
        ("gzip", Coding::Gzip),
        ("x-gzip", Coding::Gzip),
        ("zstd", Coding::Zstd),
        ("identity", Coding::Identity),
    ];
    known.into_iter().find(|(name, _)| given.eq_ignore_ascii_case(name)).map(|(_, coding)| coding)
}

/// The codings, as the header `Accept-Encoding` of a refusal names them.
pub(super) const TAKEN: &str = "zstd,gzip";

/// The request with its decompressed body, and without the headers about the compressed one.
pub(super) fn unpacked(mut request: Request, coding: Coding) -> Result<Request, CodingFault> {
    let decoder = match coding {
        Coding::Identity => return Ok(request),
        Coding::Gzip => Decoder::Gzip(Box::new(Gzip::new())),
        Coding::Zstd => Decoder::Zstd(Zstd::new()?),
    };
    request.headers_mut().remove(CONTENT_ENCODING);
    request.headers_mut().remove(CONTENT_LENGTH);
    Ok(request.map(|body| Body::new(Unpacked::new(body, decoder))))
}

#[derive(Debug)]
enum Decoder {
    Gzip(Box<Gzip>),
    Zstd(Zstd),
}

/// The result of one step of a decoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Step {
    /// Bytes of the input that were read.
    taken: usize,
    /// Bytes that were written.
    made: usize,
    /// Whether the room was full, so that the bytes read so far may give more.
    full: bool,
}

impl Decoder {
    fn step(&mut self, input: &[u8], room: &mut [u8]) -> Result<Step, CodingFault> {
        match self {
            Self::Gzip(gzip) => gzip.step(input, room),
            Self::Zstd(zstd) => zstd.step(input, room),
        }
    }

    /// Memory that the decoder holds, its window included \[bytes\].
    fn bytes(&self) -> usize {
        match self {
            Self::Gzip(_) => gzip::STATE_BYTES,
            Self::Zstd(zstd) => zstd.bytes(),
        }
    }

    /// Whether every member that was begun is complete.
    fn is_between(&self) -> bool {
        match self {
            Self::Gzip(gzip) => gzip.is_between(),
            Self::Zstd(zstd) => zstd.is_between(),
        }
    }
}

/// A body that is decompressed while it is read. No more is unpacked than is requested.
struct Unpacked {
    packed: Body,
    /// Bytes that have arrived and were not read yet.
    input: Bytes,
    state: State,
    room: Vec<u8>,
    given: u64,
    made: u64,
}

enum State {
    /// The decoder, whether it may have more output, and the memory that it has reserved.
    Reading { decoder: Decoder, full: bool, paid: Option<Lease> },
    /// All bytes were given out.
    Ended,
    /// Bytes that still arrive are discarded.
    Failed,
}

impl Unpacked {
    fn new(packed: Body, decoder: Decoder) -> Self {
        let paid = memory::account().map(|account| account.lease());
        let state = State::Reading { decoder, full: false, paid };
        Self { packed, input: Bytes::new(), state, room: vec![0; ROOM], given: 0, made: 0 }
    }

    /// The next bytes of the content, from the bytes that have arrived.
    fn next(&mut self) -> Result<Option<Bytes>, CodingFault> {
        let State::Reading { decoder, full, paid } = &mut self.state else { return Ok(None) };
        while *full || !self.input.is_empty() {
            let step = decoder.step(&self.input, &mut self.room)?;
            // A window is allocated when the header of its frame is read: at most one window for each thread is not
            // reserved yet.
            if let Some(paid) = paid {
                paid.grow_to((decoder.bytes() + ROOM) as u64)?;
            }
            drop(self.input.split_to(step.taken));
            *full = step.full;
            self.given += step.taken as u64;
            self.made += step.made as u64;
            let (given, made) = (self.given, self.made);
            if made > FREE_BYTES && made > MAX_RATIO.saturating_mul(given) {
                return Err(CodingFault::Ratio { given, made });
            }
            if given > MAX_IDLE_BYTES + made + made / 8 {
                return Err(CodingFault::Idle { given, made });
            }
            if step.made > 0 {
                return Ok(self.room.get(..step.made).map(Bytes::copy_from_slice));
            }
            // A decoder that neither reads nor writes is broken.
            if step.taken == 0 && !self.input.is_empty() {
                return Err(CodingFault::Damaged);
            }
        }
        Ok(None)
    }
}

impl HttpBody for Unpacked {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let this = self.get_mut();
        let failed = |this: &mut Self, fault: CodingFault| {
            // The window and the room are free from here on.
            (this.state, this.room, this.input) = (State::Failed, Vec::new(), Bytes::new());
            Poll::Ready(Some(Err(axum::Error::new(fault))))
        };
        loop {
            match this.next() {
                Ok(Some(bytes)) => return Poll::Ready(Some(Ok(Frame::data(bytes)))),
                Ok(None) => {}
                Err(fault) => return failed(this, fault),
            }
            if matches!(this.state, State::Ended) {
                return Poll::Ready(None);
            }
            match (ready!(Pin::new(&mut this.packed).poll_frame(context)), &this.state) {
                (Some(Err(fault)), _) => return Poll::Ready(Some(Err(fault))),
                (Some(Ok(_)), State::Failed) => return Poll::Ready(Some(Ok(Frame::data(Bytes::new())))),
                (Some(Ok(frame)), _) => match frame.into_data() {
                    Ok(bytes) => this.input = bytes,
                    Err(trailers) => return Poll::Ready(Some(Ok(trailers))),
                },
                (None, State::Reading { decoder, .. }) if !decoder.is_between() => {
                    return failed(this, CodingFault::Cut);
                }
                (None, _) => this.state = State::Ended,
            }
        }
    }
}
